"""Borders in a window, and the one nearest to a point: exact maps, and the toy."""

from __future__ import annotations

import math

import pytest
from maps import moving, paper
from sympy import Piecewise, Rational, symbols

from woodpecker import Toy, ToyPieces, equilibrium, from_sympy
from woodpecker.base.settings import Settings
from woodpecker.maps import Iterate
from woodpecker.slices import BorderKind, borders_in, crosses, nearest_border

SETTINGS = Settings(window=(-2.5, -0.24))
X, P = symbols("x p", real=True)
# Jumps of P_1 whatever the restitution of the beak: between which doubles its words change, found
# by bisection, which knows no margin. Rounding mixes the words over some ten spacings.
JUMPS = (-0.8847733440138271, -0.7577872573415623)
DIGITS = 2e-15


def test_a_border_whose_margin_vanishes_exactly_at_a_double() -> None:
    """Newton's method meets 0.0 on the way from this start: the end of the jammed sleeve."""
    rest = equilibrium(Toy()).phi_s
    found = nearest_border(ToyPieces(Toy()), rest + 1e-3, 0.5, 0.1)
    assert found is not None
    assert found.cause == "the lower sleeve only just sticks"
    band = nearest_border(ToyPieces(Toy()), rest - 1e-3, 0.5, 0.1)
    assert band is not None
    assert found.x - rest == pytest.approx(rest - band.x, abs=1e-15)  # mirror images


def test_a_border_farther_than_asked_is_none() -> None:
    assert nearest_border(moving(2.0), 0.3, 0.25, 0.19) is None
    assert nearest_border(moving(2.0), 0.3, 0.25, 0.21) is not None


def test_borders_of_the_toy_are_exact() -> None:
    map_ = ToyPieces(Toy())
    found = borders_in(map_, 0.5, (-0.9, -0.75), SETTINGS)
    jumps = [border for border in found if border.kind(SETTINGS) is BorderKind.JUMP]
    assert [border.x for border in jumps] == pytest.approx(JUMPS, abs=DIGITS)
    assert {border.cause for border in jumps} == {"the beak and the upper sleeve strike at once"}
    for border in found:  # from the other side, by another margin of another piece
        other = nearest_border(map_, border.x + 1e-5, 0.5, 2e-5, SETTINGS)
        assert other is not None
        assert other.x == pytest.approx(border.x, abs=1e-12)


def test_the_limits_of_the_toy_at_a_jump_are_those_of_its_neighbours() -> None:
    """Both pieces, at the border itself, against the map 1e-9 beside it."""
    map_ = ToyPieces(Toy())
    border = nearest_border(map_, -0.8, 0.5, 0.2, SETTINGS)
    assert border is not None
    for image, side in ((border.inner, -border.side), (border.outer, border.side)):
        beside = map_.at(border.x + 1e-9 * side, 0.5)
        assert image.piece.key == beside.piece.key
        assert image.value == pytest.approx(beside.value - 1e-9 * side * beside.slope, abs=1e-14)


def test_borders_of_an_iterate_are_preimages() -> None:
    map_ = ToyPieces(Toy())
    (jump,) = filter(crosses, borders_in(Iterate(map_, 2), 0.125, (-1.15, -0.68), SETTINGS))
    assert map_.at(jump.x, 0.125).value == pytest.approx(JUMPS[0], abs=1e-14)


def test_wrong_input_is_named() -> None:
    with pytest.raises(ValueError, match=r"window must ascend, got \(1.0, 0.0\)"):
        borders_in(paper(), 1.0, (1.0, 0.0))
    with pytest.raises(ValueError, match="window must be finite"):
        borders_in(paper(), 1.0, (0.0, float("inf")))
    with pytest.raises(ValueError, match="p must be one real number, got '1'"):
        borders_in(paper(), "1", (0.0, 1.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"within must be positive and finite, got 0\.0"):
        nearest_border(paper(), 1.0, 1.0, 0.0)
    with pytest.raises(ValueError, match=r"no value at x = 0.2, p = 0.5: the beak touches"):
        nearest_border(ToyPieces(Toy()), 0.2, 0.5, 0.1)


@pytest.mark.parametrize("size", [Rational(1), Rational(-1, 50), Rational(1, 1000)])
@pytest.mark.parametrize("power", [Rational(1, 4), Rational(1, 2), Rational(3, 4)])
@pytest.mark.parametrize("x", [-0.05, 0.05])
def test_a_root_at_a_border_is_a_grazing_however_small(
    size: Rational, power: Rational, x: float
) -> None:
    """p + x/2 + c (-x)^s below 0 and p + x/3 above: both limits are p, one slope is infinite."""
    below = P + X / 2 + size * (-X) ** power
    map_ = from_sympy(Piecewise((below, X < 0), (P + X / 3, True)), X, P)
    border = nearest_border(map_, x, 0.1, 0.2)
    assert border is not None
    assert border.kind(Settings(window=(-3.0, 3.0))) is BorderKind.GRAZING
    one, other = (border.inner, border.outer) if x < 0.0 else (border.outer, border.inner)
    assert [one.slope, other.slope] == [-math.copysign(math.inf, size), pytest.approx(1 / 3)]
    assert [one.value, other.value] == pytest.approx([0.1, 0.1], abs=1e-13)


@pytest.mark.parametrize("kink", [Rational(0), Rational(1, 100)])
@pytest.mark.parametrize("root", [Rational(1, 30), Rational(1, 11), Rational(1, 50)])
def test_slopes_that_merge_like_a_cube_root_make_no_kink(root: Rational, kink: Rational) -> None:
    """-x/2 + p, and beyond q = x^2 - r > 0 besides q^(4/3) + k q: the slopes differ by 2 k sqrt(r).

    The double next to the border lies up to 1e-14 off: without k, slopes there differ by 2e-4.
    """
    q = X**2 - root
    beyond = q * (q**2) ** Rational(1, 6) + kink * q
    map_ = from_sympy(Piecewise((P - X / 2, q < 0), (P - X / 2 + beyond, True)), X, P)
    (border,) = borders_in(map_, 0.0, (0.01, 1.0))
    assert border.kind(Settings()) is (BorderKind.KINK if kink else BorderKind.SMOOTH)
    off = border.outer.slope - border.inner.slope
    assert off == pytest.approx(2.0 * float(kink) * math.sqrt(root), abs=2e-4)
