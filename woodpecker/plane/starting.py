"""From a special point over one parameter to a cycle on its curve over two."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import PointKind, SpecialPoint
from woodpecker.base.arrays import Floats
from woodpecker.engine.germs import once, paths
from woodpecker.engine.newton import solve
from woodpecker.engine.orbits import Condition, Held, Multiplier, OnBorder, Orbit
from woodpecker.plane.maps import Plane
from woodpecker.plane.nodes import border_of
from woodpecker.slices.borders import BorderKind

T = TypeVar("T")
MULTIPLIERS = (PointKind.LP, PointKind.PD)
COLLISIONS = (PointKind.BC, PointKind.FF)
AT_EDGE = "end of the window"
PREFERRED = (BorderKind.JUMP, BorderKind.KINK, BorderKind.GRAZING, BorderKind.LOST,
             BorderKind.SMOOTH)  # fmt: skip
RETURNS = 1e-3  # scaled: an orbit through a cycle comes back that close, where slopes are steep
Found = tuple[Orbit, Condition]


def located(plane: Plane, point: SpecialPoint, other: float, axis: int = 0) -> Found:
    """The cycle at a special point, found anew, and what its curve obeys.

    Parameters
    ----------
    point
        Of a diagram over one of the parameters.
    other
        The value of the other one.
    axis
        Which one the diagram is over, 0 or 1.

    Raises
    ------
    ValueError
        If it is of a kind that has no curve, or there is no such point.
    """
    if not has_curve(point):
        raise ValueError(
            f"a curve starts at LP, PD, BC or FF, or at an end of the window, got {point.id}, "
            f"{point.kind.label}"
        )
    p = point.parameter
    values = np.array(_both(p, other, axis))
    if point.kind is PointKind.EP:
        found = _leaving(plane, point, values, axis)
    elif point.kind in MULTIPLIERS:
        found = _turning(plane, point, values, axis)
    else:
        found = _colliding(plane, point, values, axis)
    if found is None:
        over, held = _both(*plane.family.names, axis)
        raise ValueError(
            f"there is no {point.kind} near {over} = {p:.12g}, x = {point.x:.12g} at "
            f"{held} = {other:.12g}: expected a special point of a diagram over {over} "
            "with all other parameters as they are now"
        )
    return found


def has_curve(point: SpecialPoint) -> bool:
    """Whether a special point can be followed over two parameters."""
    at_edge = point.kind is PointKind.EP and point.note == AT_EDGE
    return at_edge or point.kind in (*MULTIPLIERS, *COLLISIONS)


def _both(over: T, held: T, axis: int) -> tuple[T, T]:
    """What belongs to the parameter of an axis and to the other one, in the order of the family."""
    return (over, held) if axis == 0 else (held, over)


def _from_start(plane: Plane, point: SpecialPoint, p: Floats) -> Orbit | None:
    """The orbit from a point, as long as its cycle; None if it ends before."""
    x, map_ = [np.array([point.x])], plane.map
    images = [map_.at(x[0], p)]
    while len(images) < point.order and not images[-1].reason:
        x.append(images[-1].value)
        images.append(map_.at(x[-1], p))
    return None if images[-1].reason else Orbit(np.array(x), p, 0.0, tuple(images))


def _leaving(plane: Plane, point: SpecialPoint, p: Floats, axis: int) -> Found | None:
    """The cycle of which a point lies on an end of the window."""
    guess, window = _from_start(plane, point, p), plane.first.window
    if guess is None:
        return None
    away = np.abs(guess.x - np.array(window))
    index, end = (int(k) for k in np.unravel_index(away.argmin(), away.shape))
    held = Held(index, window[end])
    found = _solved(plane, guess, held, axis)
    return None if found is None else (found, held)


def _turning(plane: Plane, point: SpecialPoint, p: Floats, axis: int) -> Found | None:
    """The cycle of a fold or a flip."""
    guess = _from_start(plane, point, p)
    if guess is None:
        return None
    condition = Multiplier(point.kind.value, plane.scale)
    found = _solved(plane, guess, condition, axis)
    return None if found is None else (found, condition)


def _colliding(plane: Plane, point: SpecialPoint, p: Floats, axis: int) -> Found | None:
    """The cycle of a border collision, and the margin that vanishes; as the diagram names it."""
    best, rank = None, (2, len(PREFERRED), 0.0)
    for guess, on in _candidates(plane, point, p):
        found = _solved(plane, guess, on, axis)
        if found is None:
            continue
        met = border_of(plane, found, on)
        named = met.border.cause == point.cause
        own = 0 if named else 1, PREFERRED.index(met.kind), abs(met.border.inner.slope)
        if own < rank:
            best, rank = (found, on), own
    return best


def _solved(plane: Plane, guess: Orbit, condition: Condition, axis: int) -> Orbit | None:
    """The cycle near a guess that obeys a condition, with its minimal period; None if none."""
    problem = plane.cycles(axis).with_(condition)
    solution = solve(problem, guess)
    way = np.abs(problem.step_between(guess, solution.orbit))
    near = float(way[[0, -1]].max()) <= plane.first.beside
    if not (solution.converged and near):
        return None
    period = len(once(solution.orbit, problem).x)
    return solution.orbit if period == len(guess.x) else None


def _candidates(plane: Plane, point: SpecialPoint, p: Floats) -> Iterator[tuple[Orbit, OnBorder]]:
    """Orbits from a point that come back to it, by all pieces that meet where it goes."""
    x, problem = np.array([point.x]), plane.cycles()
    for order in range(1, point.order + 1):
        for path in paths(plane.map, x, p, order, problem):
            if not problem.same(path.end, x, RETURNS):
                continue
            orbit = Orbit(path.x, p, 0.0, path.images)
            for i, image in enumerate(orbit.images):
                for code in image.codes[image.tied(orbit.x[i], p)].tolist():
                    yield orbit, OnBorder(i, code)
