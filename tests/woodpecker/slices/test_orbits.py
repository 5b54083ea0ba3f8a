"""Orbits, folds, flips and branch points of smooth maps, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagrams import chained

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.settings import Settings
from woodpecker.maps.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.search.curves import Curve
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import (
    Closed,
    Coordinate,
    Orbit,
    jacobian,
    minimal_period,
    orbit_of,
    residuals,
    scales,
    solve,
    tangent,
)

SETTINGS = Settings(span=(-1.0, 2.0), window=(-3.0, 3.0))
# Folds and flips are zeros of functions of slope 1 or so, found to a few spacings of doubles at 1.
EXACT = 1e-14
# A branch point is bracketed to 1e-6 of a step, and its parameter depends on that linearly.
NEAR = 1e-8


def square(x: float, p: float) -> float:
    return p - x * x


QUADRATIC = FormulaMap(
    [FormulaPiece("Q", Smooth(square, lambda x, _: -2.0 * x, lambda _x, _p: 1.0))]
)
"""x -> p - x^2: fold at p = -1/4, flips at 3/4 and 5/4 [Strogatz, ch. 10]."""


def cycle(x: list[float], p: float) -> Orbit:
    start = orbit_of([QUADRATIC.pieces[0]] * len(x), np.array(x), p)
    solution = solve(start, (Closed(), Coordinate(-1, p)), SETTINGS)
    assert solution.converged
    return solution.orbit


def ends(curves: list[Curve]) -> list[tuple[PointKind, float]]:
    return [(end.kind, end.p) for curve in curves for end in curve.ends]


def test_newton_finds_fixed_points_and_cycles() -> None:
    one = cycle([0.5], 0.5)
    assert one.x[0] == pytest.approx(0.5 * (math.sqrt(3.0) - 1.0), abs=EXACT)
    two = cycle([1.1, -0.1], 1.0)
    assert two.x == pytest.approx([1.0, 0.0], abs=EXACT)
    assert two.multiplier == pytest.approx(0.0, abs=EXACT)
    assert (minimal_period(one, SETTINGS), minimal_period(two, SETTINGS)) == (1, 2)


def test_the_tangent_is_normal_to_the_equations() -> None:
    for orbit in (cycle([0.5], 0.5), cycle([1.1, -0.1], 1.0)):
        direction = tangent(orbit, Closed(), SETTINGS)
        rows = jacobian(orbit, (Closed(),), scales(len(orbit), SETTINGS))
        assert rows @ direction == pytest.approx(np.zeros(len(orbit)), abs=EXACT)
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        assert np.linalg.det(np.vstack([rows, direction])) > 0.0


def test_the_jacobian_is_that_of_the_residuals() -> None:
    orbit, conditions = cycle([1.1, -0.1], 1.0), (Closed(), Coordinate(0, 0.3))
    matrix, h = jacobian(orbit, conditions, np.ones(3)), 1e-6
    for k in range(3):
        point = [orbit.point + sign * h * np.eye(3)[k] for sign in (1.0, -1.0)]
        one, other = (residuals(orbit_of(orbit.pieces, p[:-1], p[-1]), conditions) for p in point)
        # the map is quadratic: central differences are exact but for rounding, 1e-16 / h
        assert matrix[:, k] == pytest.approx((one - other) / (2.0 * h), abs=1e-9)


def test_fold_and_flip_of_the_fixed_point() -> None:
    curves = chained(Tasks(QUADRATIC, SETTINGS), cycle([0.5], 0.5))
    special = [(kind, p) for kind, p in ends(curves) if kind is not PointKind.EP]
    assert {kind for kind, _ in special} == {PointKind.LP, PointKind.PD}
    for kind, p in special:
        assert p == pytest.approx(-0.25 if kind is PointKind.LP else 0.75, abs=EXACT)
    for curve in curves:
        x = np.array([points[0] for points in curve.points])
        assert x * x + x == pytest.approx(curve.parameter, abs=EXACT)
        assert curve.multiplier == pytest.approx(-2.0 * x, abs=EXACT)


def test_the_doubled_cycle_ends_in_the_flip_of_the_fixed_point() -> None:
    curves = chained(Tasks(QUADRATIC, SETTINGS), cycle([1.1, -0.1], 1.0))
    special = sorted(p for kind, p in ends(curves) if kind is PointKind.PD)
    assert special == pytest.approx([0.75, 1.25, 1.25], abs=EXACT)


def test_a_fixed_point_passed_twice_shows_its_flip_as_a_branch_point() -> None:
    fixed = cycle([0.5], 0.5).x[0]
    curves = chained(Tasks(QUADRATIC, SETTINGS), cycle([fixed, fixed], 0.5))
    special = {kind: p for kind, p in ends(curves) if kind is not PointKind.EP}
    assert special[PointKind.BP] == pytest.approx(0.75, abs=EXACT)
    assert special[PointKind.LP] == pytest.approx(-0.25, abs=EXACT)


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_units_do_not_matter(unit: float) -> None:
    """The same map in other units of x and p: the same samples, in these units."""

    def scaled(x: float, p: float) -> float:
        return unit * square(x / unit, p / unit)

    map_ = FormulaMap(
        [FormulaPiece("Q", Smooth(scaled, lambda x, _: -2.0 * x / unit, lambda _x, _p: 1.0))]
    )
    settings = Settings(span=(-unit, 2.0 * unit), window=(-3.0 * unit, 3.0 * unit))
    start = orbit_of(map_.pieces, np.array([0.5 * unit]), 0.5 * unit)
    found = solve(start, (Closed(), Coordinate(-1, 0.5 * unit)), settings)
    curves = chained(Tasks(map_, settings), found.orbit)
    expected = chained(Tasks(QUADRATIC, SETTINGS), cycle([0.5], 0.5))
    assert [len(c.parameter) for c in curves] == [len(c.parameter) for c in expected]
    for one, other in zip(curves, expected, strict=True):
        assert one.parameter / unit == pytest.approx(other.parameter, abs=1e-9)
