"""Branch switching: the branches of cycles that start at a branch point or a flip of another."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from pwmap.diagrams.diagram import PointKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.births import born
from woodpecker.piecewise.branch_points import directions, ways
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.curves import turned
from woodpecker.piecewise.ends import End
from woodpecker.piecewise.orbits import Closed, Orbit, minimal_period, scales, tangent
from woodpecker.piecewise.pieces import PiecewiseMap
from woodpecker.piecewise.samples import Sample, Stop
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import Stepper
from woodpecker.piecewise.stops import FLIP

Begin = tuple[Sample, Sample]


def switched(
    map_: PiecewiseMap, end: End, orders: Collection[int], settings: Settings
) -> list[Begin]:
    """The branches that start where another one flips or is crossed.

    At a flip of P_n the branch of P_2n, or the other way round, if both are wanted; at a branch
    point both branches both ways, for it is not known which one led there; at a kink longer cycles.

    Parameters
    ----------
    map_
        The map.
    end
        A special point, PD, BP, or BC at a kink.
    orders
        Iterates whose branches are wanted.
    settings
        Steps and tolerances.

    Returns
    -------
    For each the sample at the special point, and the next one.
    """
    if end.kind is PointKind.BC:
        return born(map_, end, orders, settings)
    x = np.asarray(end.x)
    whole = Orbit(x, end.p, tuple(map_.at(each, end.p) for each in x.tolist()))
    n = minimal_period(whole, settings, settings.same)
    cycle = Orbit(x[:n], end.p, whole.images[:n])
    if not cycle.defined or (end.kind is PointKind.PD and cycle.multiplier > 0.0):
        return []
    if end.kind is PointKind.BP:
        if n not in orders:
            return []
        found = [
            _begin(map_, Sample(cycle, sign * way), Stop.BRANCHING, settings)
            for way in directions(cycle, settings)
            for sign in (1.0, -1.0)
        ]
    elif not {n, 2 * n} <= set(orders):
        return []
    elif len(x) == n:
        twice = Orbit(np.tile(cycle.x, 2), cycle.p, cycle.images * 2)
        start = Sample(twice, doubling(twice, settings))
        found = [_begin(map_, start, Stop.BRANCHING, settings)]
    else:
        start = Sample(cycle, tangent(cycle, Closed(), settings))
        found = [_begin(map_, each, Stop.FLIP, settings) for each in (start, turned(start))]
    return [begin for begin in found if begin is not None]


def doubling(twice: Orbit, settings: Settings) -> Floats:
    """The way (2 n + 1,) in which the doubled branch leaves a flip, in scaled unknowns.

    The points of both turns move apart; the parameter changes with the square of that only.
    """
    way = ways(twice)[:, 0] / scales(len(twice), settings)
    half = len(twice) // 2
    way[half:-1] = -way[:half]  # where the multiplier is -1, but for rounding
    found: Floats = way / np.linalg.norm(way)
    return found


def _begin(map_: PiecewiseMap, start: Sample, ignored: Stop, settings: Settings) -> Begin | None:
    """The first samples of a branch; None if a border or an end lies closer than can be told."""
    step = settings.step
    short = replace(settings, max_samples=2)
    stepper = Stepper(Corrector(map_, Closed(), short), [FLIP])
    while step >= settings.beside:  # four times shorter each time
        arc = stepper.follow(start, ignored, first=step)
        if len(arc.samples) == 2 and arc.stop is Stop.MANY:
            return start, arc.samples[1]
        step *= settings.numerics.retry
    return None
