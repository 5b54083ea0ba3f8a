"""Curves of folds and flips of smooth maps, with their points of codimension two."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from maps import everything

from pwmap.diagrams.diagram import PointKind
from woodpecker import Curve, Settings, curve_in_two
from woodpecker.plane import PlaneKind, family_from_sympy

X, P, Q = sympy.symbols("x p q")
SETTINGS = Settings(window=(-2.0, 2.0))
SPAN = ((-2.0, 2.0), (-2.0, 2.0))


def curve(formula: sympy.Expr, second: float, kind: PointKind) -> Curve:
    """The curve through the first special point of a kind over p."""
    family = family_from_sympy(formula, X, (P, Q))
    found = everything(family.over(0, (0.0, second)), replace(SETTINGS, span=SPAN[0])).diagram
    (point, *_) = [each for each in found.points if each.kind is kind]
    return curve_in_two(family, point, family.names, SPAN, value=second, settings=SETTINGS)


def test_cusp() -> None:
    """x + p + q x - x^3 folds where q = 3 x^2 and p = -2 x^3, so 27 p^2 = 4 q^3: a cusp at zero."""
    found = curve(X + P + Q * X - X**3, 1.0, PointKind.LP)
    p, q = found.values.T
    x = found.x[:, 0]
    assert np.abs(q - 3.0 * x**2).max() < 1e-10  # the multiplier is 1 to some 1e-15 times 1/(6 x)
    assert np.abs(p + 2.0 * x**3).max() < 1e-10
    assert np.ptp(x) > 1.5
    (cusp,) = [point for point in found.points if point.kind is PlaneKind.CUSP]
    assert cusp.values == pytest.approx((0.0, 0.0), abs=1e-12)
    assert cusp.x[0] == pytest.approx(0.0, abs=1e-9)  # slopes are compared over 1e-5, exactly here


def test_generalised_flip() -> None:
    """-(1 + p) x + x^2 + q x^3 flips at p = 0; f''^2/2 + f'''/3 = 2 + 2 q vanishes at q = -1."""
    found = curve(-(1 + P) * X + X**2 + Q * X**3, 0.0, PointKind.PD)
    assert np.abs(found.values[:, 0]).max() < 1e-12
    (flip,) = [point for point in found.points if point.kind is PlaneKind.GENERALISED_FLIP]
    assert flip.values == pytest.approx((0.0, -1.0), abs=1e-8)  # a second difference over 2e-3
    assert np.abs(found.multipliers[:, 0] + 1.0).max() < 1e-12


def test_a_closed_curve_says_so() -> None:
    """x + x^2 + p^2 + q^2 - 1 folds at x = 0 on the unit circle."""
    found = curve(X + X**2 + P**2 + Q**2 - 1, 0.5, PointKind.LP)
    assert found.closed
    assert found.ends[1].cause == "the curve closes"
    assert np.abs(np.hypot(*found.values.T) - 1.0).max() < 1e-12
    angles = np.unwrap(np.arctan2(found.values[:, 1], found.values[:, 0]))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi, abs=1e-9)


def test_it_ends_at_the_window() -> None:
    """x^2 + p - q x: its folds lie at x = (1 + q)/2, which leaves a window."""
    family = family_from_sympy(X**2 + P - Q * X, X, (P, Q))
    narrow = Settings(window=(-0.25, 0.75))
    found = everything(family.over(0, (0.0, 0.0)), replace(narrow, span=SPAN[0])).diagram
    (fold,) = [each for each in found.points if each.kind is PointKind.LP]
    met = curve_in_two(family, fold, family.names, SPAN, value=0.0, settings=narrow)
    assert sorted(float(each.x[0]) for each in met.ends) == pytest.approx([-0.25, 0.75], abs=1e-12)
    assert {each.cause for each in met.ends} == {"end of the window"}


def test_what_has_no_curve() -> None:
    family = family_from_sympy(X**2 + P - Q * X, X, (P, Q))
    found = everything(family.over(0, (0.0, 0.0)), replace(SETTINGS, span=SPAN[0])).diagram
    end = next(each for each in found.points if each.kind is PointKind.EP)
    fold = next(each for each in found.points if each.kind is PointKind.LP)
    with pytest.raises(ValueError, match="or at an end of the window, got EP"):
        curve_in_two(family, end, family.names, SPAN, value=0.0, settings=SETTINGS)
    with pytest.raises(ValueError, match=r"there is no LP near p = 0\.25, x = 0\.5 at q = 1"):
        curve_in_two(family, fold, family.names, SPAN, value=1.0, settings=SETTINGS)
    with pytest.raises(ValueError, match=r"span must hold q = 0\.0, got \(1.0, 2.0\)"):
        curve_in_two(
            family, fold, family.names, (SPAN[0], (1.0, 2.0)), value=0.0, settings=SETTINGS
        )
    with pytest.raises(ValueError, match="needs a value of q"):
        curve_in_two(family, fold, family.names, SPAN, settings=SETTINGS)
