"""The local model at a border collision, on maps that are their own local model, and on the toy."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from maps import A, Line, lines, moving, paper, skew_tent, two_lines
from sympy import Expr, Piecewise, Rational, sqrt, symbols

from pwmap import BranchKind
from woodpecker import Toy, ToyPieces, first_return, from_sympy, local_model
from woodpecker.base.settings import Settings
from woodpecker.maps import Iterate
from woodpecker.slices import Start, borders_in, crosses

X, P = symbols("x p")
SCALES = Settings(window=(-2.5, -0.24), finest=1e-9)  # borders are looked for in 1e-6 rad
LOWER = -0.8847733440  # phi_S of A
# By the law of expansion: eps_N1 of A, the slope of P_1 there, and dx/d eps_N1 of the fixed point
# and of the jumps of P_2, P_3, P_4.
POINT_A = {
    "summed": (0.1119709144566, -1.30491, (2.4435, 4.3160, 1.0085, 3.5432)),
    "separate": (0.0421643309129, -1.26515, (6.3673, 11.4001, 2.3892, 9.5116)),
}
laws = pytest.mark.parametrize("law", POINT_A)


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


def test_a_power_at_the_jump_counts_by_its_slope() -> None:
    """p - (-x)^(3/2) meets the jump at p = 0 with the slope 0: the fixed point is p to first order.

    It lies on the left for p < 0, and the limits p and 1 + p are on both sides of 0 there.
    """
    power = Piecewise((P - (-X) ** Rational(3, 2), X < 0), (1 + P, True))
    found = local_model(from_sympy(power, X, P), 0.0, 0.0)
    assert (found.point.kind, found.point.note) == ("BC", "fold")
    assert (found.left.slope, found.right.slope) == (0.0, 0.0)
    assert [(str(each.kind), each.order, each.side, each.slope) for each in found.starts] == [
        ("fixed-point", 1, -1, 1.0), ("jump", 1, -1, 0.0),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("left", "border"),
    [(X / 2, X), (P**2 - X / 2, X), (-P - 2 * (X + P), X + P), (X, X)],
    ids=str,
)
def test_a_fixed_point_that_stays_at_the_jump_is_no_collision(left: Expr, border: Expr) -> None:
    """The limit from the left moves with the jump: 0, p^2, and -p where the jump is at x = -p."""
    map_ = from_sympy(Piecewise((left, border < 0), (1 + P, True)), X, P)
    with pytest.raises(ValueError, match=r"a limit of the jump at x = 0\.0, p = 0\.0 stays on the"):
        local_model(map_, 0.0, 0.0)


def test_an_infinite_slope_has_no_local_model() -> None:
    root = from_sympy(Piecewise((P - sqrt(-X), X < 0), (1 + P, True)), X, P)
    with pytest.raises(ValueError, match=r"x = 0\.0, p = 0\.0 lies on the diagonal with a finite"):
        local_model(root, 0.0, 0.0)


def test_a_jump_that_moves() -> None:
    """In y = x - 2 p the map is the paper's; every slope is larger by the speed of the jump."""
    found = local_model(moving(2.0), 0.0, 0.0)
    assert found.speed == 2.0
    jumps = by_order(found.starts, BranchKind.JUMP)
    for order, slope in predicted(-A, 1.0, range(1, 5)).items():
        assert jumps[order] == pytest.approx(2.0 + slope, rel=1e-15)


def test_a_collision_is_located_anew() -> None:
    """From digits that are off by parts of Settings.beside the model is the same."""
    found = local_model(moving(2.0), 3e-7, 2e-7)
    assert (found.x, found.p) == pytest.approx((0.0, 0.0), abs=1e-16)
    assert (found.left.value, found.right.value) == pytest.approx((-2.0, 0.0), abs=1e-15)
    assert found.inner == "R"


def test_a_collision_of_a_cycle() -> None:
    """x/2 + 1 and x/2 - 1 + p: the cycle (4/3 (p - 1/2), 1 + 2/3 (p - 1/2)) meets 0 at p = 1/2."""
    found = local_model(
        Iterate(lines(Line(0.5, 0.0, 1.0), Line(0.5, 1.0, -1.0)), 2), 0.0, 0.5, (1,)
    )
    assert (found.x, found.p, found.inner) == (0.0, 0.5, "L")
    assert by_order(found.starts, BranchKind.FIXED_POINT) == {1: pytest.approx(4.0 / 3.0)}
    assert found.left.slope == 0.25


def test_no_collision_is_said() -> None:
    with pytest.raises(ValueError, match=r"does not jump at x = 1\.0, p = 0\.0"):
        local_model(paper(A), 1.0, 0.0)
    with pytest.raises(ValueError, match=r"no limit of the jump at x = 0\.0, p = 1\.0"):
        local_model(paper(A), 0.0, 1.0)
    with pytest.raises(ValueError, match=r"does not jump at x = 0\.0, p = 0\.0"):
        local_model(skew_tent(0.5, -1.5), 0.0, 0.0)
    with pytest.raises(TypeError, match=r"a map must be one of pieces, such as .*, got 3"):
        local_model(3, 0.0, 0.0)  # type: ignore[arg-type]


@laws
def test_point_a_of_the_toy_is_the_papers_figure_12(law: str) -> None:
    """A fold-flip, and the jump branches of P_2, P_3, P_4 start there."""
    at, slope, speeds = POINT_A[law]
    found = local_model(ToyPieces(Toy(expansion_friction=law)), LOWER, at)  # type: ignore[arg-type]
    assert (found.point.kind, found.point.note, found.inner) == ("FF", "fold", "R")
    assert found.right.slope == pytest.approx(slope, abs=5e-6)  # printed digits
    assert found.speed == 0.0
    assert {start.side for start in found.starts} == {1}
    fixed = by_order(found.starts, BranchKind.FIXED_POINT)[1]
    jumps = by_order(found.starts, BranchKind.JUMP)
    assert (fixed, *(jumps[order] for order in (2, 3, 4))) == pytest.approx(speeds, abs=5.1e-5)
    m = found.right.slope
    assert jumps == pytest.approx(predicted(m, fixed * (1.0 - m), range(1, 5)), rel=1e-9, abs=1e-9)


def test_a_slope_of_rounding_at_the_border_is_that_right_beside_it() -> None:
    """Along A over mu_2 the slope at the border is -6e12 in doubles; it is -1.41864 + c d^(1/3).

    The limit follows to 1e-5 from slopes at 1e-9 and 1e-12, of which c d^(1/3) differs tenfold.
    """
    toy = Toy(mu_2=0.3253588304081592)
    found = local_model(ToyPieces(toy), -0.8866010875, 0.1449647407)
    assert (found.point.kind, found.point.note, found.inner) == ("FF", "fold", "R")
    there = toy.replace(eps_n1=found.border.p)
    far, near = (first_return(there, found.border.x + d).slope for d in (1e-9, 1e-12))
    assert found.right.slope == pytest.approx(near + (near - far) / 9.0, abs=2e-5)


@pytest.mark.parametrize(
    ("law", "order", "nearest", "rate"),
    [
        *(("separate", order, 1e-5, 2.0) for order in (2, 3, 4)),
        *(("summed", order, 4e-5, 2.0) for order in (2, 3)),
        ("summed", 4, 4e-5, 3.2),  # its curvature almost vanishes: 5e-3 per unit, of the others 40
    ],
)
def test_the_toy_has_the_jump_branches_the_model_predicts(
    law: str, order: int, nearest: float, rate: float
) -> None:
    """At three distances q from A the jump of P_j is q**2 close to the predicted line."""
    at = POINT_A[law][0]
    map_ = ToyPieces(Toy(expansion_friction=law))  # type: ignore[arg-type]
    found = local_model(map_, LOWER, at)
    slope = by_order(found.starts, BranchKind.JUMP)[order]
    errors = []
    for q in (4.0 * nearest, 2.0 * nearest, nearest):
        p = found.p + q
        middle = found.x + slope * q
        reach = 0.2 * abs(slope) * q
        borders = borders_in(Iterate(map_, order), p, (middle - reach, middle + reach), SCALES)
        (jump,) = filter(crosses, borders)
        errors.append(abs(jump.x - middle))
    rates = [math.log2(a / b) for a, b in pairwise(errors)]
    assert rates == pytest.approx([rate, rate], abs=0.35)
