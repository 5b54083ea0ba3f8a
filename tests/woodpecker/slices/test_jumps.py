"""Branches of jumps that cross the diagonal, on maps whose jumps are known by hand."""

from __future__ import annotations

import numpy as np
import pytest
from diagrams import LOCATED
from maps import Line, moving_border, two_lines, two_pieces
from sympy import Piecewise, Rational, sin, sqrt, symbols

from pwmap.diagrams.diagram import BranchKind, PointKind
from woodpecker import FormulaMap, FormulaPiece, PiecewiseMap, Smooth, from_sympy, slices_at
from woodpecker.base.settings import Settings
from woodpecker.search.curves import BranchCurve, End
from woodpecker.search.tasks import Tasks

BC, EP, FALL = PointKind.BC, PointKind.EP, PointKind.FALL
SPAN = (-2.0, 3.0)


def jump_at(
    map_: PiecewiseMap, x: float, p: float, settings: Settings | None = None, order: int = 1
) -> BranchCurve:
    """The branch, without folds, of the jump of P_order near a place whose orbit is the longest."""
    settings = settings or Settings(span=SPAN, window=(-20.0, 20.0))
    (found,) = [each for each in slices_at(map_, p, [order], settings) if each.order == order]
    jump = max((j for j in found.jumps if abs(j.x - x) < 0.05), key=lambda j: len(j.head))
    followed = Tasks.of_line(map_, settings).jump(jump)
    assert followed is not None
    curve = followed.curve
    assert curve.kind is BranchKind.JUMP
    turns = np.sign(np.diff(curve.parameter))
    assert abs(turns.sum()) == len(turns)
    return curve


def ends(curve: BranchCurve) -> list[End]:
    """By their parameter."""
    return sorted(curve.ends, key=lambda end: end.p)


def places(curve: BranchCurve) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """(parameter, x) of its ends, by the parameter."""
    return np.array([(end.p, end.x[0, 0]) for end in ends(curve)])


def x_of(curve: BranchCurve) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Where the jump is, at each sample."""
    return np.array([points[0, 0] for points in curve.points])


# --- Ends of jumps of P_1 -------------------------------------------------------------------------


def test_the_limit_may_be_curved() -> None:
    """The right limit p^3 - 0.2 meets 0 at the cube root of 0.2, at the rate 3 p^2 = 1.03."""
    right = Smooth(lambda x, p: p**3 - 0.2, lambda x, p: 0.0, lambda x, p: 3.0 * p * p)
    curve = jump_at(two_pieces(Line(0.0, 0.0, -1.0).smooth(), right), 0.0, 0.9)
    assert ends(curve)[0].kind is BC
    assert ends(curve)[0].p == pytest.approx(0.2 ** (1 / 3), abs=1e-15)


def pieces_of(map_: FormulaMap) -> tuple[FormulaPiece, FormulaPiece]:
    """The left and the right one."""
    right, left = map_.pieces
    assert isinstance(left, FormulaPiece)
    assert isinstance(right, FormulaPiece)
    return left, right


def divided_lines(pieces: dict[str, dict[str, Smooth]], beyond: Smooth | None = None) -> FormulaMap:
    """Two lines, the right one in pieces with more margins, beyond the first with a formula."""
    left, right = pieces_of(two_lines())
    formulas = [right.map, *[beyond or right.map] * (len(pieces) - 1)]
    return FormulaMap(
        [left]
        + [
            FormulaPiece(name, formula, dict(right.margins) | margins)
            for formula, (name, margins) in zip(formulas, pieces.items(), strict=True)
        ]
    )


def stripes(width: float, sign: float) -> FormulaMap:
    """-1 for x >= 0; 0.1 - sign p for x < 0, with a name of its own about sign p = 0.1 - x."""
    limit, right = Line(0.0, -sign, 0.1).smooth(), Line(0.0, 0.0, -1.0).smooth()
    base = {"x reaches 0": Line(-1.0, 0.0).smooth()}

    def margin(way: float, at: float) -> Smooth:
        return Line(way, way * sign, -way * at).smooth()

    low, high = 0.1 - width, 0.1 + width
    inside = {"low": margin(1.0, low), "high": margin(-1.0, high)}
    return FormulaMap(
        [
            FormulaPiece("R", right, {"x reaches 0": Line(1.0, 0.0).smooth()}),
            FormulaPiece("strip", limit, base | inside),
            FormulaPiece("before", limit, base | {"low": margin(-1.0, low)}),
            FormulaPiece("after", limit, base | {"high": margin(1.0, high)}),
        ]
    )


@pytest.mark.parametrize("width", [3e-3, 2e-4, 2e-5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_collision_in_a_narrow_piece(width: float, sign: float) -> None:
    """The left limit 0.1 - sign p meets the jump at 0 in a strip in which its word is another.

    A step can pass over the strip, and finds the limits on one side of the diagonal beyond.
    """
    settings = Settings(span=(-2.0, 2.0), window=(-1.5, 1.5))
    curve = jump_at(stripes(width, sign), 0.0, 0.0, settings)
    end = ends(curve)[1 if sign > 0.0 else 0]
    assert end.kind is BC
    assert (end.p, end.x[0, 0]) == pytest.approx((sign * 0.1, 0.0), abs=LOCATED)


# --- Borders that move ----------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1e-4, 1e-6, 1e-8, 1e-11])
def test_a_border_of_a_thin_piece(width: float) -> None:
    """The right piece is narrower than the way the border moves in one step.

    Where it is too narrow to be seen the limit is that of the piece beyond, but on the border.
    """
    left, right = pieces_of(moving_border())
    end, beyond = Line(-1.0, 0.5, width).smooth(), Line(1.0, -0.5, -width).smooth()
    inside = FormulaPiece("R", right.map, dict(right.margins) | {"the end": end})
    outside = FormulaPiece("beyond", right.map, {"the end": beyond})
    curve = jump_at(FormulaMap([left, inside, outside]), 0.15, 0.3)
    assert [end.kind for end in ends(curve)] == [BC, BC]
    assert places(curve) == pytest.approx(np.array([[-1.0, -0.5], [1.0, 0.5]]), abs=LOCATED)
    assert x_of(curve) == pytest.approx(0.5 * curve.parameter, abs=LOCATED)


def test_a_curved_border() -> None:
    """At sin(3 p), with limits one above and one below."""
    x, p = symbols("x p")
    at = sin(3 * p)
    curve = jump_at(from_sympy(Piecewise((at - 1, x < at), (at + 1, True)), x, p), 0.0, 0.0)
    assert [(end.kind, end.p) for end in ends(curve)] == [(EP, -2.0), (EP, 3.0)]
    assert x_of(curve) == pytest.approx(np.sin(3.0 * curve.parameter), abs=LOCATED)


# --- Ends and changes of word ---------------------------------------------------------------------


def divided(tilt: float, beyond: Smooth | None = None) -> FormulaMap:
    """Two lines, whose right piece is called R1 where p + tilt x < -0.6, with a formula of its own.

    tilt
        If it is zero no step in x leads from R to R1.
    """
    on, off = Line(tilt, 1.0, 0.6).smooth(), Line(-tilt, -1.0, -0.6).smooth()
    return divided_lines({"R": {"p reaches -0.6": on}, "R1": {"p reaches -0.6": off}}, beyond)


@pytest.mark.parametrize("tilt", [0.5, -0.5, 1e-3, 0.0])
def test_words_change_along_a_jump(tilt: float) -> None:
    """The branch goes on with its new words; what changes is no point of it."""
    curve = jump_at(divided(tilt), 0.0, -0.3)
    assert [end.kind for end in ends(curve)] == [BC, BC]
    assert places(curve) == pytest.approx(np.array([[-1.0, 0.0], [0.0, 0.0]]), abs=LOCATED)
    assert np.abs(x_of(curve)).max() <= LOCATED
    (mark,) = curve.marks
    assert mark.cause == "p reaches -0.6"
    beside = curve.parameter[mark.sample : mark.sample + 2]
    assert np.abs(beside + 0.6).min() <= LOCATED
    assert sorted(word.text for word in curve.words) == ["L / R", "L / R1"]
    for word in curve.words:
        assert (curve.parameter[word.first + 1] > -0.6) == (word.text == "L / R")


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6, 5e-8])
def test_words_that_change_close_together(apart: float) -> None:
    """R, R1 and R2 beside the jump at 0, with borders at p = -0.6 - x/2 and as much further on.

    R1 is a wedge, twice as wide in x: pieces are told apart down to 1e-9 of the window of 40.
    """
    edges = (-0.6, -0.6 - apart)
    on = [Line(0.5, 1.0, -at).smooth() for at in edges]
    off = [Line(-0.5, -1.0, at).smooth() for at in edges]
    pieces = {"R": {"1": on[0]}, "R1": {"1": off[0], "2": on[1]}, "R2": {"2": off[1]}}
    curve = jump_at(divided_lines(pieces), 0.0, -0.3)
    assert places(curve) == pytest.approx(np.array([[-1.0, 0.0], [0.0, 0.0]]), abs=LOCATED)
    assert sorted(mark.cause for mark in curve.marks) == ["1", "2"]
    for mark in curve.marks:
        beside = curve.parameter[mark.sample : mark.sample + 2]
        assert np.abs(beside - edges[int(mark.cause) - 1]).min() <= LOCATED


def test_a_jump_goes_round_a_corner() -> None:
    """R1 takes x/2 + p, as L does: below p = -0.6 the jump is no more at 0, but between R1 and R.

    There, on p + x/2 = -0.6, it crosses the diagonal until the fixed point 2 (p + 1)/3 of R meets
    it, at x = 0.2 and p = -0.7.
    """
    curve = jump_at(divided(0.5, Line(0.5, 1.0).smooth()), 0.0, -0.3)
    low, high = ends(curve)
    assert (high.kind, high.p) == (BC, pytest.approx(0.0, abs=LOCATED))
    assert (low.kind, low.note, low.cause) == (BC, "fold", "p reaches -0.6")
    assert (low.p, low.x[0]) == pytest.approx((-0.7, 0.2), abs=LOCATED)


def test_a_jump_beside_which_the_map_is_lost() -> None:
    on = Line(0.5, 1.0, 0.6).smooth()
    curve = jump_at(divided_lines({"R": {"p reaches -0.6": on}}), 0.0, -0.3)
    low, _ = ends(curve)
    assert (low.kind, low.cause) == (FALL, "a limit of the jump is lost")
    assert low.p == pytest.approx(-0.6, abs=LOCATED)


@pytest.mark.parametrize("off", [0.1, 1e-3, 1e-6, 3e-8])
def test_a_jump_whose_orbit_hugs_a_square_root(off: float) -> None:
    """P_1 jumps at p/10; p/10 - off + sqrt(x - root) takes x = root + off**2 there.

    The root 1/2 + p**2 moves on a curve: a straight guess leaves the piece, however small the step.
    """

    x, p = symbols("x p")
    root, at = Rational(1, 2) + p**2, p / 10
    formula = Piecewise((at - off + sqrt(x - root), x >= root), (-1, x <= at), (2, True))
    map_ = from_sympy(formula, x, p)
    settings = Settings(span=(0.0, 1.0), window=(-3.0, 3.0))
    curve = jump_at(map_, 0.51, 0.1, settings, order=2)
    assert [(end.kind, end.p) for end in ends(curve)] == [(EP, 0.0), (EP, 1.0)]
    # Newton's method stops after a step of 2**-48 of the window
    assert x_of(curve) == pytest.approx(0.5 + curve.parameter**2 + off**2, abs=1e-12)
    assert len(curve.parameter) < 300  # steps as long as the curve allows
