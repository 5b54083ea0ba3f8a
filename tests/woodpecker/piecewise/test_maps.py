"""Cycles of labelled maps: derivatives, Newton's method, iterates."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from maps import fold, grazing, logistic, lost_beyond, paper, two_lines

from woodpecker.piecewise.maps import (
    Cycle,
    Evaluation,
    correct,
    evaluate,
    gaps,
    iterate,
    jacobian,
    tangent,
)
from woodpecker.piecewise.tolerances import DEFAULT

# Central differences with step h: h^2/6 times third derivatives, which vanish or stay below 1e2 for
# the maps used, and 1e-16/h of rounding.
STEP, DIFFERENCE = 1e-5, 1e-8


def test_jacobian_against_differences() -> None:
    x, p = np.array([0.2, 0.6, 0.8]), 3.4
    matrix = jacobian(evaluate(logistic, x, p), np.array([0.1, 0.2, 0.3, 0.4]))
    for k in range(4):
        step = STEP * np.eye(4)[k]
        ahead = gaps(evaluate(logistic, x + step[:3], p + step[3]))
        behind = gaps(evaluate(logistic, x - step[:3], p - step[3]))
        np.testing.assert_allclose(matrix[:3, k], (ahead - behind) / (2 * STEP), atol=DIFFERENCE)
    np.testing.assert_array_equal(matrix[3], [0.1, 0.2, 0.3, 0.4])


def test_jacobian_of_one_lap() -> None:
    """Both entries of the lap share one place: slope - 1."""
    matrix = jacobian(evaluate(logistic, np.array([0.2]), 3.0), np.array([0.0, 1.0]))
    np.testing.assert_allclose(matrix, [[3.0 * 0.6 - 1.0, 0.16], [0.0, 1.0]], atol=1e-15)


def test_cycle_knows_its_laps() -> None:
    cycle = evaluate(paper(), np.array([-0.5, 0.25]), 1.0)
    assert cycle.words == ("L", "R")
    assert cycle.word == "L | R"
    assert cycle.multiplier == 0.0
    # f(-1/2) = -1, 1.25 from the second point; f(1/4) = 11/16, 1.1875 from the first: all exact
    assert cycle.residual == 1.25
    np.testing.assert_array_equal(gaps(cycle), [-1.25, 1.1875])


def test_tangent_is_that_of_the_branch() -> None:
    """On x = 1 - 1/p at p = 2: dx/dp = 1/p^2 = 1/4."""
    cycle = evaluate(logistic, np.array([0.5]), 2.0)
    for sign in (1.0, -1.0):
        expected = sign * np.array([0.25, 1.0]) / math.hypot(0.25, 1.0)
        np.testing.assert_allclose(tangent(cycle, np.array([0.0, sign])), expected, atol=1e-15)


def test_tangent_at_a_fold_is_vertical_and_otherwise_nan() -> None:
    cycle = evaluate(fold, np.array([0.0]), 0.0)
    np.testing.assert_array_equal(tangent(cycle, np.array([-1.0, 0.0])), [-1.0, 0.0])
    assert np.isnan(tangent(cycle, np.array([0.0, 1.0]))).all()


def test_newton_converges_quadratically() -> None:
    """Errors of f(x) - x: e_{k+1}/e_k^2 -> f''/(2 (f' - 1)) = p/(p - 1) = 5/3 at p = 5/2."""
    visited: list[float] = []

    def watched(x: float, p: float) -> Evaluation:
        visited.append(x)
        return logistic(x, p)

    cycle, good, steps = correct(watched, np.array([0.65]), 2.5)
    assert good
    assert steps <= 5  # 5e-2 -> 4e-3 -> 2e-5 -> 8e-10 -> 1e-16
    assert cycle.x[0] == pytest.approx(0.6, abs=1e-15)
    errors = np.abs(np.array(visited) - 0.6)
    ratios = [
        after / before**2 for before, after in pairwise(errors.tolist()) if 1e-6 < before < 1e-2
    ]
    # next order of the error: relative 2 * 5/3 * e <= 2 % for e < 5e-3
    assert len(ratios) >= 2
    assert ratios == pytest.approx([5 / 3] * len(ratios), rel=0.02)


def test_newton_without_direction_holds_the_parameter() -> None:
    cycle, good, _ = correct(fold, np.array([0.4]), 0.25)
    assert good
    assert cycle.p == 0.25
    assert cycle.x[0] == pytest.approx(0.5, abs=1e-15)


def test_newton_with_direction_stays_in_the_plane() -> None:
    """Next to the fold, in the plane x = 0.01: p = 1e-4, where the parameter alone is stiff."""
    cycle, good, _ = correct(fold, np.array([0.01]), 0.0, np.array([1.0, 0.0]))
    assert good
    assert cycle.x[0] == 0.01
    assert cycle.p == pytest.approx(1e-4, abs=1e-15)


def test_newton_finds_an_orbit_of_two_laps() -> None:
    """At p = 3.2: x^2 - (p + 1)/p x + (p + 1)/p^2 = 0, multiplier 4 + 2 p - p^2 = 0.16."""
    cycle, good, _ = correct(logistic, np.array([0.5, 0.8]), 3.2)
    assert good
    assert cycle.x.sum() == pytest.approx(4.2 / 3.2, abs=1e-14)
    assert cycle.x.prod() == pytest.approx(4.2 / 3.2**2, abs=1e-14)
    assert cycle.multiplier == pytest.approx(0.16, abs=1e-13)


def constant(value: float, slope: float) -> tuple[Cycle, bool, int]:
    return correct(lambda _x, _p: Evaluation(value, slope, 1.0, "S"), np.array([0.0]), 0.0)


@pytest.mark.parametrize(
    ("value", "slope"),
    [
        (1.0, 1.0),  # singular: parallel to the diagonal
        (math.nan, 0.5),
        (math.nan, math.nan),
        (1.0, math.nan),
        (math.inf, 0.5),
        (1.0, math.inf),  # the edge of a grazing
        (1.0, -math.inf),
    ],
)
def test_newton_reports_failure(value: float, slope: float) -> None:
    cycle, good, _ = constant(value, slope)
    assert not good
    assert not cycle.residual <= 1e-6


def test_newton_from_the_edge_of_a_grazing_is_no_solution() -> None:
    """f(0) = -1/2 at p = -1/2, where the slope is infinite: not a fixed point."""
    cycle, good, _ = correct(grazing(-1.0), np.array([0.0]), -0.5)
    assert not (good and cycle.residual > 1e-6)


def test_newton_stops_where_the_map_has_no_value() -> None:
    cycle, good, steps = correct(lost_beyond(1.0), np.array([2.0]), 0.0)
    assert (good, steps) == (False, 0)
    assert cycle.word == "lost"
    cycle, good, steps = correct(lost_beyond(1.0), np.array([0.5]), 0.6)  # its point is at 1.2
    assert (good, steps) == (False, 1)
    assert cycle.x[0] == pytest.approx(1.2, abs=1e-15)


def test_newton_does_not_trust_a_value_the_map_disowns() -> None:
    """x = 0 would be fixed, but the map says that it has no value there."""
    _, good, steps = correct(lambda x, _p: Evaluation(x / 2, 0.5, 1.0, "lost", False), [0.0], 0.0)
    assert (good, steps) == (False, 0)


def test_newton_gives_up_where_there_is_no_fixed_point() -> None:
    cycle, good, steps = correct(fold, np.array([0.5]), -0.1)
    assert not good
    assert steps == 25
    assert cycle.residual >= 0.1  # |p - x^2| >= |p|


def test_newton_may_land_on_another_piece_and_says_so() -> None:
    """x/2 + 1/2 reaches the diagonal at x = 1, where the other piece rules: the word tells."""
    cycle, good, _ = correct(two_lines(), np.array([-1.0]), 0.5)
    assert good
    assert cycle.word == "R"


def test_allowed_residual_grows_with_steep_slopes_only() -> None:
    assert DEFAULT.allowed(100.0) == 1e-12
    assert DEFAULT.allowed(-1e6) == pytest.approx(1e6 * 2.0**-47, rel=1e-15)


def test_iterate_obeys_the_chain_rule() -> None:
    third = iterate(logistic, 3)
    x, p = 0.3, 3.7
    here = third(x, p)
    value = x
    for _ in range(3):
        value = p * value * (1.0 - value)
    assert here.value == pytest.approx(value, abs=1e-15)
    slope = (third(x + STEP, p).value - third(x - STEP, p).value) / (2 * STEP)
    rate = (third(x, p + STEP).value - third(x, p - STEP).value) / (2 * STEP)
    # third derivatives of the third iterate reach 1e3: STEP^2/6 * 1e3 = 2e-8
    assert here.slope == pytest.approx(slope, abs=1e-7)
    assert here.rate == pytest.approx(rate, abs=1e-7)
    assert here.word == "S | S | S"


def test_iterate_is_the_papers_second_map() -> None:
    """P2^L of Eq. 15 at r = 1, a = 5/4: its three pieces, values exact in binary."""
    second = iterate(paper(), 2)
    assert second(-1.0, 1.0)[:2] == (-1.0, 0.0)
    assert second(0.5, 1.0)[:2] == (1.5625 * 0.5 - 0.25, 1.5625)
    assert second(1.0, 1.0)[:2] == (-1.0, 0.0)
    assert [second(x, 1.0).word for x in (-1.0, 0.5, 1.0)] == ["L | L", "R | R", "R | L"]


def test_iterate_of_one_lap_is_the_map_and_loss_is_passed_on() -> None:
    assert iterate(logistic, 1) is logistic
    lost = iterate(lost_beyond(1.0), 3)(0.9, 0.6)  # 0.9 -> 1.05 -> lost
    assert not lost.defined
    assert math.isnan(lost.value)
    assert lost.word == "L | lost"
