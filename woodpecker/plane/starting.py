"""Starts of curves over two parameters: at special points over one, and on other curves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import PointKind, SpecialPoint
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Sample
from woodpecker.engine.germs import SAME, least_period, paths
from woodpecker.engine.maps import Accumulating
from woodpecker.engine.newton import solve
from woodpecker.engine.orbits import Condition, Held, Multiplier, OnBorder, SpaceOrbit
from woodpecker.plane.maps import FamilyPiece, Plane, pair
from woodpecker.plane.nodes import border_in, border_of, curve_of, multiplier_inside
from woodpecker.slices.borders import BorderKind

T = TypeVar("T")
MULTIPLIERS = (PointKind.LP, PointKind.PD)
COLLISIONS = (PointKind.BC, PointKind.FF)
AT_EDGE = "end of the window"
PREFERRED = (BorderKind.JUMP, BorderKind.KINK, BorderKind.GRAZING, BorderKind.LOST,
             BorderKind.SMOOTH)  # fmt: skip
RETURNS = 1e-3  # scaled: an orbit started at a cycle closes to this, even where slopes are steep
Found = tuple[SpaceOrbit, Condition]
Seed = tuple[Condition, Sample, bool]
"""The condition of the cycles of a curve, its first sample, and whether it leads on both ways."""


def cycle_at(plane: Plane, point: SpecialPoint, other: float, axis: int = 0) -> Found:
    """The cycle at a special point over one of the parameters, solved anew, and its condition.

    The diagram of the point is over the parameter of ``axis``, 0 or 1; ``other`` is the value of
    the other one. ValueError if its kind has no curve, or there is no such point.
    """
    if not has_curve(point):
        raise ValueError(
            f"a curve starts at LP, PD, BC or FF, or at an end of the window, got {point.id}, "
            f"{point.kind.label}"
        )
    guesses = list(_guesses(plane, point, np.array(_both(point.parameter, other, axis))))
    lasting = [guess for guess in guesses if not _has_limit(guess[0])]
    if guesses and not lasting:
        raise ValueError(
            f"at {point.id} infinitely many pieces accumulate, none of which holds along a curve: "
            f"expected a point with finitely many pieces beside it"
        )
    solved = ((_solved(plane, orbit, on, axis), on) for orbit, on in lasting)
    found = [(orbit, on) for orbit, on in solved if orbit is not None]
    if not found:
        over, held = _both(*plane.family.names, axis)
        raise ValueError(
            f"there is no {point.kind} near {over} = {point.parameter:.12g}, x = {point.x:.12g} at "
            f"{held} = {other:.12g}: expected a special point of cycles, not of jump "
            f"crossings, of a diagram over {over} with all other parameters as they are now"
        )
    return min(found, key=lambda each: _rank(plane, point, *each))


def _has_limit(orbit: SpaceOrbit) -> bool:
    """Whether a cycle has a limit of pieces, whose margin for the border is zero everywhere."""
    return any(isinstance(image.piece, Accumulating) for image in orbit.images)


def has_curve(point: SpecialPoint) -> bool:
    """Whether a special point can be followed over two parameters."""
    at_edge = point.kind is PointKind.EP and point.note == AT_EDGE
    return at_edge or point.kind in (*MULTIPLIERS, *COLLISIONS)


def _both(over: T, held: T, axis: int) -> tuple[T, T]:
    """Values for the parameter of an axis and for the other one, in the order of the family."""
    return (over, held) if axis == 0 else (held, over)


def _guesses(plane: Plane, point: SpecialPoint, p: Floats) -> Iterator[Found]:
    """Orbits that start at a special point and close, on all pieces there, with conditions."""
    # The cycle of a special point of P_n may have a smaller period than n.
    x, problem = np.array([point.x]), plane.cycles()
    for order in range(1, point.order + 1):
        for path in paths(plane, x, p, order, problem):
            if problem.same(path.end, x, RETURNS):
                yield from ((path, each) for each in _conditions(plane, point, path))


def _conditions(plane: Plane, point: SpecialPoint, orbit: SpaceOrbit) -> list[Condition]:
    """The conditions that the cycle of a special point may satisfy: of a BC one for each margin."""
    if point.kind in MULTIPLIERS:
        return [Multiplier(point.kind.value, plane.scale)]
    if point.kind is PointKind.EP:
        window = plane.first.window
        nearest = int(np.abs(orbit.x - np.array(window)).argmin())
        return [Held(nearest // 2, window[nearest % 2])]
    return [
        OnBorder(i, code)
        for i, image in enumerate(orbit.images)
        for code in image.codes[image.tied(orbit.x[i], orbit.p)].tolist()
    ]


def _rank(
    plane: Plane, point: SpecialPoint, orbit: SpaceOrbit, on: Condition
) -> tuple[bool, bool, int, float]:
    """A key by which the cycle comes first that fits best how the diagram names the collision."""
    # Where both sides of a border hold the cycle, it is followed on that with finite slopes.
    if not isinstance(on, OnBorder):
        return False, False, 0, 0.0
    border, _ = border_of(plane, orbit, on)
    kind, slope = border.kind(plane.first), abs(border.inner.slope)
    grazes = kind is BorderKind.GRAZING and math.isinf(slope)
    return grazes, border.cause != point.cause, PREFERRED.index(kind), slope


def _solved(plane: Plane, guess: SpaceOrbit, condition: Condition, axis: int) -> SpaceOrbit | None:
    """The cycle near a guess that satisfies a condition; None if none, or of a smaller period."""
    size, other = guess.x.size, 1 - axis
    kept = Held(size + other, float(guess.p[other]))
    problem = plane.cycles(0, 1).with_(condition, kept)
    # right at a root its limit follows from points inside: the same ones as in Newton's method
    placed = problem.moved(guess, np.zeros(size + 2))
    solution = solve(problem, placed)
    way = np.abs(problem.step_between(guess, solution.orbit))
    near = float(way[[0, -2, -1]].max()) <= plane.first.beside
    if not (solution.converged and near):
        return None
    period = len(least_period(solution.orbit, problem).x)
    return solution.orbit if period == len(guess.x) else None


def seeds_at(plane: Plane, arc: Arc) -> tuple[Seed, ...]:
    """The starts of curves of another kind at the end of an arc.

    Where a cycle on a border has the multiplier +1 or -1 a curve of folds or flips starts, into the
    piece inside. Where a fold, a flip or a cycle on another border meets a border, a curve of
    collisions with that border starts.
    """
    orbit, own = arc.samples[-1].orbit, border_in(arc.curve)
    name = arc.test.name if arc.test is not None else ""
    if name in (PlaneKind.FOLD_BORDER, PlaneKind.FLIP_BORDER) and own is not None:
        kind, value = ("LP", 1.0) if name == PlaneKind.FOLD_BORDER else ("PD", -1.0)
        if abs(multiplier_inside(orbit) - value) <= plane.first.kink:
            return _seeds(plane, orbit, Multiplier(kind, plane.scale), own)
    if arc.border is not None and (own is None or own.image != arc.border[0]):
        return _seeds(plane, orbit, OnBorder(*arc.border), own)
    return ()


def is_of(plane: Plane, orbit: SpaceOrbit) -> bool:
    """Whether the pieces of a cycle are those of the plane's maps, as far as its images tell."""
    for x, image in zip(orbit.x, orbit.images, strict=True):
        old, family = image.piece, plane.family
        assert isinstance(old, FamilyPiece)
        if type(old.family) is not type(family):
            return False
        try:
            own = family.carried(old.own, family.over(0, pair(orbit.p)))
        except KeyError:  # it has no piece of that name
            return False
        one, other = (each.at(x, orbit.p) for each in (old, FamilyPiece(own, family, plane.scale)))
        for name in ("value", "jacobian", "margins"):
            both = getattr(one, name), getattr(other, name)
            if both[0].shape != both[1].shape or not np.allclose(*both, SAME, SAME, equal_nan=True):
                return False
    return True


def _seeds(
    plane: Plane, orbit: SpaceOrbit, condition: Condition, into: OnBorder | None
) -> tuple[Seed, ...]:
    """The start of a curve through a cycle: to where a margin is positive, or both ways."""
    curve = curve_of(plane, condition, orbit)
    start = curve.start(orbit)
    if not np.isfinite(start.tangent).all():
        return ()
    if into is None:
        return ((condition, start, True),)
    rate = curve.rate(start, into.image, into.code)
    return ((condition, start if rate > 0.0 else start.turned, False),) if rate else ()
