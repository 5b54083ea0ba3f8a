"""From a special point over one parameter to a place on its curve over two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from pwmap.diagrams.diagram import PointKind, SpecialPoint
from woodpecker.piecewise.borders import BorderKind
from woodpecker.piecewise.branch_points import Multiplier
from woodpecker.piecewise.crossings import border_at
from woodpecker.piecewise.margins import nearest_code
from woodpecker.piecewise.orbits import (
    Closed,
    Condition,
    Coordinate,
    Margin,
    Orbit,
    minimal_period,
    scales,
    solve,
)
from woodpecker.piecewise.pieces import Image, PiecewiseMap
from woodpecker.piecewise.settings import Settings
from woodpecker.plane.places import Locus, Place, Plane, Unknown

T = TypeVar("T")
MULTIPLIERS = {PointKind.LP: 1.0, PointKind.PD: -1.0}
COLLISIONS = (PointKind.BC, PointKind.FF)
AT_EDGE = "end of the window"
PREFERRED = (BorderKind.JUMP, BorderKind.KINK, BorderKind.GRAZING, BorderKind.LOST,
             BorderKind.SMOOTH)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """An orbit that might be the cycle that collides, and where it might lie on a border."""

    orbit: Orbit
    margin: Margin


def located(plane: Plane, point: SpecialPoint, other: float, axis: int = 0) -> tuple[Place, Locus]:
    """The place of a special point, found anew, and what its curve obeys.

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
    p, settings = point.parameter, plane.settings[axis]
    map_ = plane.map(_both(p, other, axis), axis)
    if point.kind is PointKind.EP:
        found = _leaving(map_, point, settings)
    elif point.kind in MULTIPLIERS:
        found = _turning(map_, point, settings)
    else:
        found = _colliding(map_, point, settings)
    if found is None:
        over, held = _both(*plane.family.names, axis)
        raise ValueError(
            f"there is no {point.kind} near {over} = {p:.12g}, x = {point.x:.12g} at "
            f"{held} = {other:.12g}: expected a special point of a diagram over {over} "
            "with all other parameters as they are now"
        )
    orbit, locus = found
    return plane.place(orbit.pieces, orbit.x, _both(orbit.p, other, axis)), locus


def has_curve(point: SpecialPoint) -> bool:
    """Whether a special point can be followed over two parameters."""
    at_edge = point.kind is PointKind.EP and point.note == AT_EDGE
    return at_edge or point.kind in (*MULTIPLIERS, *COLLISIONS)


def _both(over: T, held: T, axis: int) -> tuple[T, T]:
    """What belongs to the parameter of an axis and to the other one, in the order of the family."""
    return (over, held) if axis == 0 else (held, over)


def _from_start(map_: PiecewiseMap, point: SpecialPoint) -> Orbit | None:
    """The orbit from a point, as long as its cycle; None if it ends before."""
    x, images = [point.x], [map_.at(point.x, point.parameter)]
    while len(images) < point.order and not images[-1].reason:
        x.append(images[-1].value)
        images.append(map_.at(x[-1], point.parameter))
    return None if images[-1].reason else Orbit(np.array(x), point.parameter, tuple(images))


def _leaving(
    map_: PiecewiseMap, point: SpecialPoint, settings: Settings
) -> tuple[Orbit, Locus] | None:
    """The cycle of which a point lies on an end of the window."""
    guess = _from_start(map_, point)
    if guess is None:
        return None
    away = np.abs(guess.x[:, None] - np.array(settings.window))
    index, end = (int(k) for k in np.unravel_index(away.argmin(), away.shape))
    edge = settings.window[end]
    found = _solved(guess, (Closed(), Coordinate(index, edge)), settings)
    return None if found is None else (found, Locus(Unknown(index, edge)))


def _turning(
    map_: PiecewiseMap, point: SpecialPoint, settings: Settings
) -> tuple[Orbit, Locus] | None:
    """The cycle of a fold or a flip."""
    guess, value = _from_start(map_, point), MULTIPLIERS[point.kind]
    if guess is None:
        return None
    found = _solved(guess, (Closed(), Multiplier(value, settings, settings.nearest)), settings)
    return None if found is None else (found, Locus(value))


def _colliding(
    map_: PiecewiseMap, point: SpecialPoint, settings: Settings
) -> tuple[Orbit, Locus] | None:
    """The cycle of a border collision, and the margin that vanishes; as the diagram names it."""
    best, rank = None, (2, len(PREFERRED), 0.0)
    away = settings.beside
    while best is None and away >= settings.nearest:
        for each in _candidates(map_, point, away * settings.x_scale, settings):
            found = _solved(each.orbit, (Closed(), each.margin), settings)
            if found is None:
                continue
            border = border_at(map_, found, each.margin, settings)
            named = border.cause == point.cause
            own = (
                0 if named else 1,
                PREFERRED.index(border.kind(settings)),
                abs(found.images[each.margin.index].slope),
            )
            if own < rank:
                best, rank = (found, Locus(each.margin)), own
        away *= settings.numerics.restart
    return best


def _solved(
    guess: Orbit, conditions: tuple[Condition, Condition], settings: Settings
) -> Orbit | None:
    """The orbit near a guess that obeys two conditions, with its minimal period; None if none."""
    solution = solve(guess, conditions, settings)
    way = (solution.orbit.point - guess.point) / scales(len(guess), settings)
    near = float(np.abs(way[[0, -1]]).max()) <= settings.beside
    if not (solution.converged and near):
        return None
    return solution.orbit if minimal_period(solution.orbit, settings) == len(guess) else None


def _candidates(
    map_: PiecewiseMap, point: SpecialPoint, away: float, settings: Settings
) -> Iterator[_Candidate]:
    """Orbits from a point that come back to it, by all pieces that meet next to theirs."""
    p = point.parameter

    def extended(x: list[float], images: list[Image], sides: list[int]) -> Iterator[_Candidate]:
        left, right = (map_.at(x[-1] + side * away, p) for side in (-1, 1))
        on_border = left.piece.key != right.piece.key
        for piece_of, side in ((left, 1), (right, -1))[: 2 if on_border else 1]:
            image = piece_of.piece.at(x[-1], p) if not piece_of.reason else piece_of
            if image.reason:
                continue
            own, met = [*images, image], [*sides, side if on_border else 0]
            if abs(image.value - x[0]) <= _slack(own, settings):
                orbit = Orbit(np.array(x), p, tuple(own))
                for i, towards in enumerate(met):
                    code = nearest_code(orbit.images[i], towards) if towards else -1
                    if code >= 0:
                        yield _Candidate(orbit, Margin(i, code))
            elif len(own) < point.order:
                yield from extended([*x, image.value], own, met)

    yield from extended([point.x], [], [])


def _slack(images: list[Image], settings: Settings) -> float:
    """How far from its start an orbit may come back: its start is known to rounding only."""
    steepest = 1.0
    for image in images:
        steepest *= max(1.0, min(abs(image.slope), settings.numerics.steep))
    return min(settings.beside * steepest, settings.near) * settings.x_scale
