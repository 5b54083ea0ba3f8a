"""Continuation of fixed points and orbits, on maps whose branches are known by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import (
    A,
    fold,
    grazing,
    island,
    line,
    logistic,
    logistic_pair,
    lost_beyond,
    moving_edge,
    paper,
    pieces,
    relabelled_logistic,
    skew_tent,
    staircase,
    start,
    two_cycle,
    two_lines,
)
from thoroughness import thorough

from pwmap.diagrams.diagram import PointKind
from woodpecker.piecewise.borders import Edge
from woodpecker.piecewise.maps import Evaluation, LabelledMap, evaluate
from woodpecker.piecewise.stepping import PathPoint, Settings, classify, follow, follow_from

BC, EP, FALL, FF = PointKind.BC, PointKind.EP, PointKind.FALL, PointKind.FF
LP, PD, WC = PointKind.LP, PointKind.PD, PointKind.WC

# A border collision is bisected to the last bit along the branch, the points on it have residuals
# below 1e-12: an error of 1e-12/|1 - m|, in fact of a few roundings.
COLLISION = 1e-12
# LP and PD: a root of the multiplier found to 1e-14 along the branch.
LOCATED = 1e-10
# Beside a square root residuals up to 2^-47 * slope pass and the last steps are as small as
# Tolerances.edge = 1e-9: a grazing met from its steep side is located that well only.
GRAZED = 1e-8


def run(
    labelled_map: LabelledMap,
    x: float | list[float],
    p: float,
    direction: int = 1,
    span: tuple[float, float] = (-2.0, 2.0),
    **options: float | tuple[float, float],
) -> list[PathPoint]:
    """The whole path through the cycle near x at p."""
    chosen = Settings(span=span, **options)  # type: ignore[arg-type]
    return list(follow(labelled_map, start(labelled_map, x, p), chosen, direction))


def specials(path: list[PathPoint]) -> list[PathPoint]:
    return [point for point in path if point.kind is not None]


def kinds(path: list[PathPoint]) -> list[PointKind | None]:
    return [point.kind for point in specials(path)]


def at(point: PathPoint) -> tuple[float, float]:
    return float(point.p), float(point.cycle.x[0])


def assert_on_branch(path: list[PathPoint], word: str, x: Callable[[float], float]) -> None:
    """All points with this word lie on the curve x(p); the residual allows 1e-12/|1 - m|."""
    chosen = [point for point in path if point.cycle.word == word]
    assert len(chosen) > 10
    for point in chosen:
        assert point.cycle.x[0] == pytest.approx(x(point.p), abs=1e-11)


# --- border collisions ---------------------------------------------------------------------------


def test_branch_ends_in_a_border_collision() -> None:
    path = run(two_lines(), -2.0, -1.0)
    assert kinds(path) == [BC]
    assert path[-1].ends
    assert path[-1].note == "fold"
    assert at(path[-1]) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert path[-1].cycle.multiplier == 0.5
    assert (path[-1].side, path[-1].lap) == (1, 0)
    edge = path[-1].edge
    assert edge is not None
    assert (edge.left.word, edge.right.word) == ("L", "R")
    assert (edge.left_limit, edge.right_limit) == pytest.approx((0.0, 1.0), abs=COLLISION)
    assert_on_branch(path, "L", lambda p: 2.0 * p)


@pytest.mark.parametrize("jump", [1e-5, 1e-3, 1.0, -1e-5, -1e-3, -1.0])
@pytest.mark.parametrize("step", [0.02, 0.5])
def test_branch_never_hops_over_a_jump(jump: float, step: float) -> None:
    """Fixed points 2 p and, on the other side of a small jump, 2 (p + jump) await the hop."""
    two = pieces(line(0.5, 1.0), line(0.5, 1.0, jump))
    path = run(two, -2.0, -1.0, step=0.005, max_step=step)
    assert kinds(path) == [BC]
    assert at(path[-1]) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert {point.cycle.word for point in path} == {"L"}
    assert all(point.p <= COLLISION for point in path)


@pytest.mark.parametrize("width", [0.002, 0.01])
@pytest.mark.parametrize("max_step", [0.02, 0.5])
def test_thin_piece_between_two_of_one_name_is_seen(width: float, max_step: float) -> None:
    """Beyond a strip of another word the same word rules again: the ends of a step do not tell."""

    def striped(x: float, p: float) -> Evaluation:
        inside = 0.0 <= x < width
        return Evaluation(0.5 * x + p + inside, 0.5, 1.0, "strip" if inside else "S")

    path = run(striped, -1.0, -0.5, max_step=max_step)
    assert kinds(path) == [BC]
    assert at(path[-1]) == pytest.approx((0.0, 0.0), abs=COLLISION)


@pytest.mark.parametrize(("a", "kind"), [(A, FF), (1.01, FF), (3.0, FF), (0.5, BC), (0.99, BC)])
def test_point_a_of_the_paper(a: float, kind: PointKind) -> None:
    """The fixed point r/(1 + a) folds into the jump at r = 0; a flip comes with it if a > 1."""
    path = run(paper(a), 1.0 / (1.0 + a), 1.0, -1)
    assert kinds(path) == [kind]
    assert path[-1].note == "fold"
    assert at(path[-1]) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert path[-1].cycle.multiplier == -a
    assert path[-1].side == -1
    assert_on_branch(path, "R", lambda r: r / (1.0 + a))


def test_point_b_of_the_paper() -> None:
    """The fixed point r - 2 folds into the same jump at r = 2; its slope 0 starts no flip."""
    path = run(paper(), -1.0, 1.0, span=(-1.0, 3.0))
    assert kinds(path) == [BC]
    assert path[-1].note == "fold"
    assert at(path[-1]) == pytest.approx((2.0, 0.0), abs=COLLISION)
    assert path[-1].side == 1
    assert_on_branch(path, "L", lambda r: r - 2.0)


@pytest.mark.parametrize(
    ("x", "p", "direction", "end"), [(-2.0, -1.0, 1, 0.0), (1.0, 1.5, -1, 1.0)]
)
def test_persistence(x: float, p: float, direction: int, end: float) -> None:
    """The fixed point of the staircase goes over into the jump as the parameter goes on."""
    path = run(staircase(), x, p, direction)
    assert kinds(path) == [BC]
    assert path[-1].note == "persistence"
    assert at(path[-1]) == pytest.approx((end, 0.0), abs=COLLISION)


@pytest.mark.parametrize(("x", "direction", "end"), [(-2.0, 1, 1.0), (2 / 3, -1, -1.0)])
def test_collision_with_a_moving_edge(x: float, direction: int, end: float) -> None:
    path = run(moving_edge, x, 0.0, direction)
    assert kinds(path) == [BC]
    assert at(path[-1]) == pytest.approx((end, end / 2.0), abs=COLLISION)


# --- folds, flips, closed loops ------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_fold_is_located_and_passed(sign: float) -> None:
    """x = +-sqrt(p), multiplier 1 - 2 x: round the fold to the other root."""
    path = run(fold, 0.5 * sign, 0.25, -1, span=(-1.0, 0.5))
    assert kinds(path) == [LP, EP]
    point = specials(path)[0]
    assert not point.ends
    assert at(point) == pytest.approx((0.0, 0.0), abs=LOCATED)
    assert point.cycle.multiplier == pytest.approx(1.0, abs=LOCATED)
    assert at(path[-1]) == pytest.approx((0.5, -sign * math.sqrt(0.5)), abs=1e-11)
    assert all(q.cycle.x[0] ** 2 == pytest.approx(q.p, abs=2e-12) for q in path)
    turns = [q.cycle.x[0] for q in path]
    assert all((after - before) * sign <= 0.0 for before, after in pairwise(turns))


def test_following_from_the_fold_itself() -> None:
    """Any direction may be given, also the vertical one."""
    tip = evaluate(fold, np.array([0.0]), 0.0)
    for sign in (1.0, -1.0):
        path = list(follow_from(fold, tip, np.array([sign, 0.0]), Settings(span=(-1.0, 0.25))))
        assert path[-1].kind is EP
        assert at(path[-1]) == pytest.approx((0.25, 0.5 * sign), abs=1e-11)


def test_flip_of_the_logistic_map() -> None:
    path = run(logistic, 0.6, 2.5, span=(2.0, 3.2))
    assert kinds(path) == [PD, EP]
    assert at(specials(path)[0]) == pytest.approx((3.0, 2.0 / 3.0), abs=LOCATED)
    assert specials(path)[0].cycle.multiplier == pytest.approx(-1.0, abs=LOCATED)
    assert not specials(path)[0].ends
    assert_on_branch(path, "S", lambda p: 1.0 - 1.0 / p)


def test_flip_of_the_orbit_of_period_two() -> None:
    """Multiple shooting: 4 + 2 p - p^2 = -1 at p = 1 + sqrt(6)."""
    path = run(logistic, list(logistic_pair(3.2)), 3.2, span=(2.0, 3.6))
    assert kinds(path) == [PD, EP]
    assert specials(path)[0].p == pytest.approx(1.0 + math.sqrt(6.0), abs=LOCATED)
    for point in path:
        assert tuple(point.cycle.x) == pytest.approx(logistic_pair(point.p), abs=1e-11)
        # d multiplier/d x = 2 p^2 < 30, times the error in x
        assert point.cycle.multiplier == pytest.approx(4 + 2 * point.p - point.p**2, abs=1e-9)


def assert_turns_are_folds(path: list[PathPoint]) -> None:
    """Where the parameter turns along a path, a special point says so."""
    parameters = [point.p for point in path]
    marked = {k for k, point in enumerate(path) if point.kind is not None}
    for k in range(1, len(path) - 1):
        if (parameters[k] - parameters[k - 1]) * (parameters[k + 1] - parameters[k]) < 0.0:
            assert marked & {k - 1, k, k + 1}, f"the branch turns unmarked near {path[k].p}"


def test_every_turn_of_a_branch_is_marked() -> None:
    assert_turns_are_folds(run(fold, 0.5, 0.25, -1, span=(-1.0, 0.5)))
    assert_turns_are_folds(run(grazing(1.0), -0.5, -0.25, span=(-1.0, 1.0)))
    assert_turns_are_folds(run(island(-0.5, 0.5, 0.3), -0.2, 0.5))


def test_turn_of_the_orbit_of_period_two_is_marked() -> None:
    """Down to p = 3 its two points meet, multiplier +1: a fold of the second iterate."""
    path = run(logistic, list(logistic_pair(3.2)), 3.2, -1, span=(2.5, 3.4))
    assert min(point.p for point in path) == pytest.approx(3.0, abs=1e-3)
    assert_turns_are_folds(path)


@pytest.mark.parametrize("radius", [0.05, 0.3])
@pytest.mark.parametrize("direction", [1, -1])
def test_island_closes(radius: float, direction: int) -> None:
    """A circle of fixed points, multiplier 1 - 2 (x - x_0): folds at its two sides."""
    x_0, p_0 = -0.5, 0.5
    path = run(island(x_0, p_0, radius), x_0 + radius, p_0, direction)
    assert kinds(path) == [LP, LP, EP]
    first, second, end = specials(path)
    assert at(first) == pytest.approx((p_0 + direction * radius, x_0), abs=LOCATED)
    assert at(second) == pytest.approx((p_0 - direction * radius, x_0), abs=LOCATED)
    assert end.note == "the branch closes"
    assert math.dist(at(end), at(path[0])) < Settings().max_step
    for point in path:
        distance = math.hypot(point.cycle.x[0] - x_0, point.p - p_0)
        # residual 1e-12 = error in the square of the distance
        assert distance == pytest.approx(radius, abs=1e-12 / radius)
    angles = np.unwrap([math.atan2(q.cycle.x[0] - x_0, q.p - p_0) for q in path])
    assert abs(angles[-1] - angles[0]) == pytest.approx(2 * math.pi, abs=0.02 / radius)


def test_flips_of_an_island() -> None:
    """With radius 1.2 the multiplier is -1 at x - x_0 = 1, p - p_0 = +-sqrt(0.44)."""
    path = run(island(0.0, 0.0, 1.2), 1.2, 0.0)
    assert kinds(path) == [PD, LP, LP, PD, EP]
    assert [point.p for point in specials(path)[:-1]] == pytest.approx(
        [math.sqrt(0.44), 1.2, -1.2, -math.sqrt(0.44)], abs=LOCATED
    )


def test_corner_without_a_word_change_is_no_flip() -> None:
    """The multiplier jumps from 0.5 to -1.5 and is never -1, or to 1.5 and is never 1."""
    for slope in (-1.5, 1.5):
        tent = skew_tent(0.5, slope)
        path = run(lambda x, p, f=tent: f(x, p)._replace(word="S"), -0.2, -0.1, span=(-1.0, 1.0))  # type: ignore[misc]
        for point in path:
            if point.kind in (LP, PD):
                expected = 1.0 if point.kind is LP else -1.0
                assert point.cycle.multiplier == pytest.approx(expected, abs=1e-6)


# --- changes of word -----------------------------------------------------------------------------


def test_word_change_of_the_skew_tent() -> None:
    """0.5 x + p | -1.5 x + p: from 2 p to 2 p/5, with the new word and multiplier."""
    path = run(skew_tent(0.5, -1.5), -0.2, -0.1, span=(-1.0, 1.0))
    assert kinds(path) == [WC, EP]
    crossing = specials(path)[0]
    assert not crossing.ends
    assert at(crossing) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert crossing.cycle.word == "L"
    words = [point.cycle.word for point in path]
    assert words == sorted(words)  # L ... L R ... R
    assert_on_branch(path, "L", lambda p: 2.0 * p)
    assert_on_branch(path, "R", lambda p: 0.4 * p)
    assert [q.cycle.multiplier for q in path] == [{"L": 0.5, "R": -1.5}[word] for word in words]
    assert at(path[-1]) == pytest.approx((1.0, 0.4), abs=1e-11)


def test_word_change_met_downwards() -> None:
    path = run(skew_tent(0.5, -1.5), 0.04, 0.1, -1, span=(-1.0, 1.0))
    assert kinds(path) == [WC, EP]
    assert at(specials(path)[0]) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert specials(path)[0].side == -1
    assert at(path[-1]) == pytest.approx((-1.0, -2.0), abs=1e-11)


def test_word_change_that_folds() -> None:
    """0.5 x + p | 1.5 x + p: both fixed points live at p < 0; the branch turns at the kink."""
    path = run(skew_tent(0.5, 1.5), -0.2, -0.1, span=(-1.0, 1.0))
    assert kinds(path) == [WC, EP]
    assert at(specials(path)[0]) == pytest.approx((0.0, 0.0), abs=COLLISION)
    assert_on_branch(path, "R", lambda p: -2.0 * p)
    assert at(path[-1]) == pytest.approx((-1.0, 2.0), abs=1e-11)


def test_grazing_is_crossed_towards_its_root() -> None:
    """x/2 + p - sqrt(x): s = -1 + sqrt(1 + 2 p), x = s^2; it flips at s = 1/3."""
    path = run(grazing(-1.0), -0.5, -0.25, span=(-1.0, 1.0))
    assert kinds(path) == [WC, PD, EP]
    assert at(specials(path)[0]) == pytest.approx((0.0, 0.0), abs=GRAZED)
    assert at(specials(path)[1]) == pytest.approx((7 / 18, 1 / 9), abs=LOCATED)
    assert_on_branch(path, "L", lambda p: 2.0 * p)
    assert_on_branch(path, "R", lambda p: (math.sqrt(1.0 + 2.0 * p) - 1.0) ** 2)
    assert at(path[-1])[1] == pytest.approx((math.sqrt(3.0) - 1.0) ** 2, abs=1e-11)


def test_grazing_is_crossed_from_its_root() -> None:
    path = run(grazing(-1.0), (math.sqrt(2.0) - 1.0) ** 2, 0.5, -1, span=(-1.0, 1.0))
    assert kinds(path) == [PD, WC, EP]
    assert at(specials(path)[0]) == pytest.approx((7 / 18, 1 / 9), abs=LOCATED)
    assert at(specials(path)[1]) == pytest.approx((0.0, 0.0), abs=GRAZED)
    assert at(path[-1]) == pytest.approx((-1.0, -2.0), abs=1e-11)


def test_grazing_that_folds() -> None:
    """x/2 + p + sqrt(x): back to p < 0 with slope +inf, round the fold at (-1/2, 1), and on."""
    path = run(grazing(1.0), -0.5, -0.25, span=(-1.0, 1.0))
    assert kinds(path) == [WC, LP, EP]
    assert at(specials(path)[0]) == pytest.approx((0.0, 0.0), abs=GRAZED)
    assert at(specials(path)[1]) == pytest.approx((-0.5, 1.0), abs=LOCATED)
    assert at(path[-1]) == pytest.approx((1.0, (1.0 + math.sqrt(3.0)) ** 2), abs=1e-11)


def test_grazing_that_folds_met_from_its_root() -> None:
    path = run(grazing(1.0), (1.0 + math.sqrt(0.5)) ** 2, -0.25, -1, span=(-1.0, 1.0))
    assert kinds(path) == [LP, WC, EP]
    assert at(specials(path)[0]) == pytest.approx((-0.5, 1.0), abs=LOCATED)
    assert at(specials(path)[1]) == pytest.approx((0.0, 0.0), abs=GRAZED)
    assert at(path[-1]) == pytest.approx((-1.0, -2.0), abs=1e-11)


# --- orbits of period two ------------------------------------------------------------------------


@pytest.mark.parametrize("first", [0, 1])
def test_word_change_of_one_lap(first: int) -> None:
    """The lower point passes the label at 1/2 at p = 1 + sqrt(5); the phase is kept."""
    x = np.roll(logistic_pair(3.1), -first).tolist()
    path = run(relabelled_logistic(0.5), x, 3.1, span=(2.0, 3.6))
    assert kinds(path) == [WC, PD, EP]
    crossing = specials(path)[0]
    assert crossing.lap == first  # the lap that starts at the lower point
    assert crossing.p == pytest.approx(1.0 + math.sqrt(5.0), abs=COLLISION)
    assert specials(path)[1].p == pytest.approx(1.0 + math.sqrt(6.0), abs=LOCATED)
    assert {point.cycle.word for point in path if point.p < crossing.p} == {"R | R"}
    beyond = "L | R" if first == 0 else "R | L"
    assert {point.cycle.word for point in path if point.p > crossing.p} == {beyond}
    for point in path:
        expected = np.roll(logistic_pair(point.p), -first)
        np.testing.assert_allclose(point.cycle.x, expected, atol=1e-11)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize(("direction", "end", "lap"), [(1, 0.5, 0), (-1, -1.0, 1)])
def test_collision_of_one_lap(first: int, direction: int, end: float, lap: int) -> None:
    path = run(two_cycle, np.roll([-2 / 3, 2 / 3], -first).tolist(), 0.0, direction)
    assert kinds(path) == [BC]
    assert path[-1].p == pytest.approx(end, abs=COLLISION)
    assert path[-1].lap == (lap - first) % 2
    assert path[-1].cycle.x[path[-1].lap] == pytest.approx(0.0, abs=COLLISION)
    assert path[-1].cycle.multiplier == 0.25
    for point in path:
        shift = point.p - 0.5
        expected = np.roll([4 / 3 * shift, 1.0 + 2 / 3 * shift], -first)
        np.testing.assert_allclose(point.cycle.x, expected, atol=1e-11)


# --- ends ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("direction", "end"), [(1, 2.7), (-1, 1.3)])
def test_end_of_the_span_is_met_exactly(direction: int, end: float) -> None:
    path = run(logistic, 0.5, 2.0, direction, span=(1.3, 2.7))
    assert kinds(path) == [EP]
    assert path[-1].note == "end of the parameter span"
    assert path[-1].p == end
    assert path[-1].cycle.x[0] == pytest.approx(1.0 - 1.0 / end, abs=1e-12)
    parameters = [point.p for point in path]
    assert parameters == sorted(parameters, reverse=direction < 0)


def test_start_at_the_end_of_the_span() -> None:
    path = run(logistic, 0.5, 2.0, 1, span=(1.0, 2.0))
    assert kinds(path) == [EP]
    assert at(path[-1]) == (2.0, 0.5)


@pytest.mark.parametrize(("direction", "end"), [(1, 0.6), (-1, 0.4)])
def test_end_of_the_window(direction: int, end: float) -> None:
    """The crossing of the bound is located like a flip; nothing lies beyond it."""
    path = run(logistic, 0.5, 2.0, direction, span=(1.0, 4.0), window=(0.4, 0.6))
    assert kinds(path) == [EP]
    assert path[-1].note == "end of the window"
    assert at(path[-1]) == pytest.approx((1.0 / (1.0 - end), end), abs=LOCATED)
    assert all(0.4 <= point.cycle.x[0] <= 0.6 for point in path[:-1])


def test_branch_falls_where_the_map_is_lost() -> None:
    path = run(lost_beyond(1.0), 0.0, 0.0)
    assert kinds(path) == [FALL]
    assert path[-1].ends
    assert path[-1].note == "lost"  # the map's own reason
    assert at(path[-1]) == pytest.approx((0.5, 1.0), abs=COLLISION)


def test_number_of_points_is_limited() -> None:
    path = run(logistic, 0.5, 2.0, span=(1.0, 4.0), max_points=7)
    assert kinds(path) == [EP]
    assert path[-1].note == "limit on the number of points"
    assert len(path) == 9  # the start, seven steps, the end


def test_stop_ends_the_iteration_after_its_point() -> None:
    seen: list[PathPoint] = []

    def stop(point: PathPoint) -> bool:
        seen.append(point)
        return point.p > 2.3

    path = list(follow(logistic, start(logistic, 0.5, 2.0), Settings(span=(1.0, 4.0)), 1, stop))
    assert path[-1].kind is None
    assert path[-1].p > 2.3
    assert all(point.p <= 2.3 for point in path[:-1])
    assert seen[-1] is path[-1]


def test_follow_is_lazy() -> None:
    """Nothing is computed beyond the points that are asked for."""
    calls = 0

    def counted(x: float, p: float) -> Evaluation:
        nonlocal calls
        calls += 1
        return logistic(x, p)

    path: Iterator[PathPoint] = follow(counted, start(logistic, 0.5, 2.0), Settings(span=(1, 4)))
    assert next(path).p == 2.0
    assert calls == 0
    next(path)
    assert 0 < calls < 10


@pytest.mark.parametrize("max_step", [0.005, 0.1])
def test_steps_keep_to_the_settings(max_step: float) -> None:
    path = run(logistic, 0.3, 1.0 / 0.7, span=(1.0, 4.0), step=0.001, max_step=max_step)
    lengths = [math.dist(at(a), at(b)) for a, b in pairwise(path)]
    # the corrector leaves the chord by max_turn^2/2 = 0.5 % at most
    assert lengths[0] == pytest.approx(0.001, rel=0.005)
    assert max(lengths) <= max_step * 1.005
    assert max(lengths) >= max_step * 0.99
    for a, b in pairwise(path):
        assert np.linalg.norm(a.tangent - b.tangent) <= Settings().max_turn


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"span": (1.0, 0.0)}, r"span must ascend, got \(1.0, 0.0\)"),
        ({"span": (0.5, 0.5)}, "span must ascend"),
        ({"span": (math.nan, 1.0)}, "span must ascend"),
        ({"span": (0.01, math.inf)}, r"span must be finite, got \(0.01, inf\)"),
        ({"span": (-math.inf, 0.0)}, r"span must be finite, got \(-inf, 0.0\)"),
        ({"window": (-0.24, -2.5)}, r"window must ascend, got \(-0.24, -2.5\)"),
        ({"step": 0.0}, r"step must lie in \(0, 0.02\], got 0.0"),
        ({"step": -0.01}, "step must lie in"),
        ({"step": 0.03}, "step must lie in"),
        ({"step": math.nan}, "step must lie in"),
        ({"span": (0.0, 0.5, 1.0)}, r"span must be two real numbers, got \(0.0, 0.5, 1.0\)"),
        ({"span": (0.0, math.inf)}, r"span must be finite, got \(0.0, inf\)"),
        ({"window": (0.0, 1.0j)}, r"window must be two real numbers, got \(0.0, 1j\)"),
        ({"max_turn": 0}, "max_turn must be positive and finite, got 0"),
        ({"max_turn": math.nan}, "max_turn must be positive and finite, got nan"),
        ({"probe": 0}, "probe must be positive and finite, got 0"),
        ({"probe": -0.1}, "probe must be positive and finite, got -0.1"),
        ({"steepest": math.nan}, "steepest must be larger than 1, got nan"),
        ({"max_points": 0}, "max_points must be a whole number of at least 1, got 0"),
    ],
)
def test_settings_refuse(options: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Settings(**options)  # type: ignore[arg-type]


# --- the kind of a border collision, against counting --------------------------------------------

Values = npt.NDArray[np.float64]
REACH, CELLS = 0.05, 20_000  # the neighbourhood of the edge in which crossings are counted
NEXT_TO = 1e-3  # distance of the parameter from the collision


def crossings(f: Callable[[Values], Values]) -> tuple[int, list[float]]:
    """Number of fixed points and places of jump crossings within REACH, seen on a grid.

    Between neighbouring grid points, 5e-6 apart, a branch of slope below 10 changes by 5e-5 and
    the jumps that occur by more than 0.01.
    """
    x = np.linspace(-REACH, REACH, CELLS)  # an even number of points: none at 0
    excess = f(x) - x
    change = np.flatnonzero(excess[:-1] * excess[1:] < 0.0)
    jumps = np.abs(np.diff(excess))[change] > 1e-3
    return int((~jumps).sum()), x[change[jumps]].tolist()


@thorough(150)
@given(
    m=st.sampled_from([-1.0, 1.0]).flatmap(
        lambda sign: st.one_of(st.floats(0.1, 0.9), st.floats(1.1, 3.0)).map(lambda a: sign * a)
    ),
    limit=st.floats(0.5, 2.0),
    sign=st.sampled_from([-1.0, 1.0]),
    outer_slope=st.floats(-0.5, 0.5),
    inner=st.sampled_from([-1, 1]),
)
def test_classification_against_counting(
    m: float, limit: float, sign: float, outer_slope: float, inner: int
) -> None:
    """m x + p on the inner side of 0, +-limit + c x on the outer: count what P and P o P do.

    At p = 0 the fixed point meets the jump. Persistence: fixed point on one side of p = 0, jump
    crossing on the other. Fold: both on one side. Fold-flip: on that side P o P has a jump crossing
    that is not P's own.
    """

    def first(p: float) -> Callable[[Values], Values]:
        return lambda x: np.where(inner * x > 0.0, m * x + p, sign * limit + outer_slope * x)

    counts = {}
    for p in (-NEXT_TO, NEXT_TO):
        once = first(p)
        fixed, jumps = crossings(once)
        _, jumps_twice = crossings(lambda x, f=once: f(f(x)))  # type: ignore[misc]
        # P's jump is in the cell around 0, a preimage of it is NEXT_TO/|m| > 3e-4 away
        counts[p] = (fixed, len(jumps), sum(abs(x) > 1e-4 for x in jumps_twice))
    by_counting = sorted(count[:2] for count in counts.values())
    started = max(counts.values())[2] > 0

    here, there = Evaluation(0.0, m, 1.0, "in"), Evaluation(0.0, outer_slope, 0.0, "out")
    sides = (here, there) if inner < 0 else (there, here)
    limits = (0.0, sign * limit) if inner < 0 else (sign * limit, 0.0)
    edge = Edge(
        x=0.0, p=0.0, left=sides[0], right=sides[1], left_limit=limits[0], right_limit=limits[1]
    )
    kind, note = classify(edge, inner, m)
    if note == "persistence":
        assert by_counting == [(0, 1), (1, 0)]
        assert kind is BC
    else:
        assert note == "fold"
        assert by_counting == [(0, 0), (1, 1)]
        assert kind is (FF if started else BC)
