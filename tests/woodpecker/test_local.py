"""The local model at a border collision, on maps that are their own local model, and on the toy."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from maps import A, paper, two_lines

from pwmap import BranchKind
from woodpecker import Resolution, Start, Toy, local_model, sampled, slice_of, toy_map
from woodpecker.labelled import Evaluation, iterate

POINT_A = -0.8847733440, 0.0421643309  # phi_S, eps_N1
SLOPE = -1.2652  # of P_1 at A


def by_order(starts: tuple[Start, ...], kind: BranchKind) -> dict[int, float]:
    return {start.order: start.slope for start in starts if start.kind is kind}


def predicted(m: float, rate: float, orders: range) -> dict[int, float]:
    """dx/dp of the jump branches of P_j: preimages of the jump, x* (1 - m**(1 - j))."""
    fixed = rate / (1.0 - m)
    return {j: fixed * (1.0 - m ** (1 - j)) for j in orders}


def test_the_papers_map_is_its_own_local_model() -> None:
    found = local_model(paper(A), 0.0, 0.0)
    assert (found.point.kind, found.point.note) == ("FF", "fold")
    assert (found.speed, found.inner) == (0.0, "R")
    assert all(start.side == 1 for start in found.starts)
    fixed = by_order(found.starts, BranchKind.FIXED_POINT)
    assert fixed == {1: pytest.approx(1.0 / (1.0 + A), rel=1e-12)}
    jumps = by_order(found.starts, BranchKind.JUMP)
    assert jumps == pytest.approx(predicted(-A, 1.0, range(1, 5)), rel=1e-9, abs=1e-12)


def test_a_fold_without_flip() -> None:
    """x/2 + p meets the jump at p = 0 from the left: slope 1/2 starts no P_2 jump of its own."""
    found = local_model(two_lines(), 0.0, 0.0)
    assert (found.point.kind, found.point.note) == ("BC", "fold")
    assert by_order(found.starts, BranchKind.FIXED_POINT) == {1: pytest.approx(2.0)}
    assert by_order(found.starts, BranchKind.JUMP) == {1: 0.0}


def test_a_jump_that_moves() -> None:
    """In y = x - 2 p the map is the paper's; every slope is larger by the speed of the jump."""

    def moving(x: float, p: float) -> Evaluation:
        here = paper(A)(x - 2.0 * p, p)
        return here._replace(value=here.value + 2.0 * p, rate=here.rate + 2.0 - 2.0 * here.slope)

    found = local_model(moving, 0.0, 0.0)
    assert found.speed == pytest.approx(2.0, rel=1e-6)  # a difference over 2e-7
    jumps = by_order(found.starts, BranchKind.JUMP)
    for order, slope in predicted(-A, 1.0, range(1, 5)).items():
        assert jumps[order] == pytest.approx(2.0 + slope, rel=1e-5)


def test_no_collision_is_said() -> None:
    with pytest.raises(ValueError, match=r"does not jump at x = 1\.0, p = 0\.0"):
        local_model(paper(A), 1.0, 0.0)
    with pytest.raises(ValueError, match=r"no limit of the jump at x = 0\.0, p = 1\.0"):
        local_model(paper(A), 0.0, 1.0)


def test_point_a_of_the_toy_is_the_papers_figure_12() -> None:
    """A fold-flip of slope -1.2652, and the jump branches of P_2, P_3, P_4 start there."""
    found = local_model(toy_map(Toy()), *POINT_A)
    assert (found.point.kind, found.point.note, found.inner) == ("FF", "fold", "R")
    assert found.edge.right.slope == pytest.approx(SLOPE, abs=5e-5)
    assert found.speed == 0.0
    assert {start.side for start in found.starts} == {1}
    fixed = by_order(found.starts, BranchKind.FIXED_POINT)[1]
    jumps = by_order(found.starts, BranchKind.JUMP)
    m = found.edge.right.slope
    assert jumps == pytest.approx(predicted(m, fixed * (1.0 - m), range(1, 5)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_the_toy_has_the_jump_branches_the_model_predicts(order: int) -> None:
    """At three distances q from A the jump of P_j is q**2 close to the predicted line."""
    labelled = toy_map(Toy())
    found = local_model(labelled, *POINT_A)
    slope = by_order(found.starts, BranchKind.JUMP)[order]
    whole = iterate(labelled, order)
    errors = []
    for q in (4e-5, 2e-5, 1e-5):
        p = POINT_A[1] + q
        middle = found.edge.x + slope * q
        reach = 0.2 * abs(slope) * q
        look = Resolution(spacing=0.1 * reach, smallest=1e-13, bend=1e-9)
        (edge,) = slice_of(sampled(whole), p, (middle - reach, middle + reach), look).crossings
        errors.append(abs(edge.x - middle))
    rates = [math.log2(a / b) for a, b in pairwise(errors)]
    # A itself is known to 1e-10, which is a part of the error of the smallest distance
    assert rates == pytest.approx([2.0, 2.0], abs=0.35)
