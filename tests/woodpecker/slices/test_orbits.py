"""Orbits, folds, flips and branch points of smooth maps, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from maps import two_lines

from woodpecker.base.settings import Settings
from woodpecker.engine.newton import tangent
from woodpecker.engine.orbits import Closed, Held
from woodpecker.maps.formulas import FormulaMap, FormulaPiece, Smooth
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
