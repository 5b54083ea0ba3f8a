"""Orbits, folds, flips and branch points of smooth maps, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagrams import chained
from maps import two_lines

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.settings import Settings
from woodpecker.engine.newton import tangent
from woodpecker.engine.orbits import Closed, Held
from woodpecker.maps.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.search.curves import BranchCurve
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import (
    CYCLE,
    Orbit,
    at_parameter,
    is_inside,
    leads,
    minimal_period,
    of_engine,
    orbit_of,
    problem_of,
    stepped,
    to_engine,
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
    found = at_parameter(start, SETTINGS)
    assert found is not None
    return found


def ends(curves: list[BranchCurve]) -> list[tuple[PointKind, float]]:
    return [(end.kind, end.p) for curve in curves for end in curve.ends]


def test_newton_finds_fixed_points_and_cycles() -> None:
    one = cycle([0.5], 0.5)
    assert one.x[0] == pytest.approx(0.5 * (math.sqrt(3.0) - 1.0), abs=EXACT)
    two = cycle([1.1, -0.1], 1.0)
    assert two.x == pytest.approx([1.0, 0.0], abs=EXACT)
    assert two.multiplier == pytest.approx(0.0, abs=EXACT)
    assert (minimal_period(one, SETTINGS), minimal_period(two, SETTINGS)) == (1, 2)


def test_an_orbit_goes_to_the_engine_and_back_unchanged() -> None:
    orbit = cycle([1.1, -0.1], 1.0)
    back = of_engine(to_engine(orbit))
    assert (back.x.tolist(), back.p, back.words) == (orbit.x.tolist(), orbit.p, orbit.words)
    for one, other in zip(orbit.images, back.images, strict=True):
        assert one[:3] == other[:3]
        assert one.piece is other.piece


def test_one_step_of_newtons_method_tells_a_cycle_from_its_neighbours() -> None:
    """Of p - x^2 at p = 1/2, a step leaves (x - x_0)^2 / (1 + 2 x) of the way to x_0."""
    orbit = cycle([0.5], 0.5)
    for away in (1e-3, 0.1):
        to = stepped(orbit_of(orbit.pieces, orbit.x + away, 0.5), SETTINGS)
        left = away**2 / (1.0 + 2.0 * (orbit.x[0] + away))
        assert to - orbit.x == pytest.approx(left, abs=EXACT)
        assert leads(orbit.x + away, orbit, SETTINGS)
    other = -0.5 * (math.sqrt(3.0) + 1.0)  # the second fixed point keeps to itself
    assert not leads(np.array([other]), orbit, SETTINGS)


def test_an_orbit_that_ends_on_a_border_is_inside_but_for_that_margin() -> None:
    lines = two_lines()
    beside = orbit_of([lines.pieces[0]], np.array([-1e-3]), 0.5)  # its margin is x
    assert not is_inside(beside)
    assert is_inside(beside, int(beside.images[0].causes[0]))


def test_the_tangent_is_normal_to_the_equations() -> None:
    for orbit in (cycle([0.5], 0.5), cycle([1.1, -0.1], 1.0)):
        problem = problem_of(SETTINGS, *CYCLE)
        rows, direction = problem.matrix(to_engine(orbit)), tangent(problem, to_engine(orbit))[0]
        assert rows @ direction == pytest.approx(np.zeros(len(orbit)), abs=EXACT)
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        assert np.linalg.det(np.vstack([rows, direction])) > 0.0


def test_the_jacobian_is_that_of_the_residuals() -> None:
    orbit, h = to_engine(cycle([1.1, -0.1], 1.0)), 1e-6
    problem = problem_of(SETTINGS, Closed(), Held(0, 0.3))
    for k in range(3):
        way = h * np.eye(3)[k]
        one, other = (problem.residual(problem.moved(orbit, step)) for step in (way, -way))
        # the map is quadratic: central differences are exact but for rounding, 1e-16 / h
        assert problem.matrix(orbit)[:, k] == pytest.approx((one - other) / (2.0 * h), abs=1e-9)


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


@pytest.mark.slow
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
    found = at_parameter(start, settings)
    assert found is not None
    curves = chained(Tasks(map_, settings), found)
    expected = chained(Tasks(QUADRATIC, SETTINGS), cycle([0.5], 0.5))
    assert [len(c.parameter) for c in curves] == [len(c.parameter) for c in expected]
    for one, other in zip(curves, expected, strict=True):
        assert one.parameter / unit == pytest.approx(other.parameter, abs=1e-9)
