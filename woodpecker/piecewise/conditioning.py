"""What of a branch can be checked in double precision.

Rounding of one point of a cycle grows by the slopes of the laps that follow. Where that is more
than a residual that is asked for, no double is a fixed point in a sense that could be checked: the
branch ends there. Next to a square root a branch is steep for a moment only, and goes on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointKind
from woodpecker.piecewise.maps import Cycle, LabelledMap, correct, iterate, tangent
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import PathPoint

TOO_STEEP = "too steep"
TRANSIT = 1e-3  # in arclength: a steep stretch longer than this ends a branch
FINE = 1e-10  # in arclength: how well its end is located
CERTAIN = 100.0  # up to this steepness rounding does no harm
NEIGHBOURS = 20  # doubles on either side


def gentle(
    points: Iterable[PathPoint], labelled_map: LabelledMap, settings: Settings
) -> Iterator[PathPoint]:
    """The points of a branch that are no steeper than ``settings.steepest``.

    Special points on a short steep stretch are kept; a long stretch, or one with two changes of
    word, ends the branch (EP): the same from either end of it. Nothing comes out if the branch
    begins with such a stretch.
    """
    limit = partial(_limit, labelled_map=labelled_map, settings=settings)
    last: PathPoint | None = None  # gentle
    held: list[PathPoint] = []  # a change of word that may lead to steep points, and these
    entry: PathPoint | None = None  # where they begin
    for point in points:
        steep = not point.cycle.steepness <= settings.steepest
        if steep:
            held.append(point)
            entry = entry or limit(last or held[0], held[0])
        if entry is not None and _too_long(entry, point if steep else limit(point, held[-1]), held):
            if last is not None:
                yield replace(entry, kind=PointKind.EP, note=TOO_STEEP)
            return
        if not steep:
            yield from _special(held)
            last, entry = point, None
            held = [point] if point.kind is PointKind.WC else []
            if not held:
                yield point
    if last is not None:
        yield from _special(held)


def _special(points: Iterable[PathPoint]) -> Iterator[PathPoint]:
    return (point for point in points if point.kind is not None)


def _too_long(entry: PathPoint, last: PathPoint, held: Iterable[PathPoint]) -> bool:
    """Whether a steep stretch from one point to another is one too many to pass."""
    apart = math.hypot(entry.p - last.p, float(np.abs(entry.cycle.x - last.cycle.x).max()))
    return apart > TRANSIT or sum(point.kind is PointKind.WC for point in held) > 1


def checked(labelled_map: LabelledMap, cycle: Cycle, first: int, closing: float) -> float | None:
    """A point of a cycle as a double that P_j takes to itself within ``closing``.

    Rounding errors of P_j differ from double to double: of a steep cycle the nearest that returns
    as closely as that is taken. None if there is none.
    """
    x = float(cycle.x[first])
    order, steepness = len(cycle.x), cycle.steepness
    if steepness <= CERTAIN and order * cycle.residual * steepness <= 0.1 * closing:
        return x
    whole = iterate(labelled_map, order)
    for _ in range(3):  # Newton's method on P_j itself
        image = whole(x, cycle.p)
        gap = image.value - x
        if abs(gap) <= closing:
            return x
        if not math.isfinite(gap) or image.slope == 1.0:
            return None
        x -= gap / (image.slope - 1.0)
    for k in range(NEIGHBOURS):
        for near in (x - k * math.ulp(x), x + k * math.ulp(x)):
            if abs(whole(near, cycle.p).value - near) <= closing:
                return near
    return None


def _limit(a: PathPoint, b: PathPoint, labelled_map: LabelledMap, settings: Settings) -> PathPoint:
    """Where a branch is as steep as it may be, between a gentle point and its steep neighbour.

    The gentle point itself if a change of word lies between them.
    """
    if a is b or a.cycle.words != b.cycle.words:
        return a
    step = float(np.append(b.cycle.x - a.cycle.x, b.p - a.p) @ a.tangent)
    gentlest = a

    def excess(s: float) -> float:
        nonlocal gentlest
        if s in (0.0, step):
            return -1.0 if s == 0.0 else 1.0
        cycle, good, _ = correct(
            labelled_map, a.cycle.x + s * a.tangent[:-1], a.p + s * a.tangent[-1], a.tangent,
            settings.tolerances, a.cycle.words,
        )  # fmt: skip
        value = math.log(cycle.steepness / settings.steepest) if good else 1.0
        if value <= 0.0:
            gentlest = PathPoint(cycle=cycle, tangent=tangent(cycle, a.tangent))
        return value

    if abs(step) > FINE:
        brentq(excess, 0.0, step, xtol=FINE)
    return gentlest
