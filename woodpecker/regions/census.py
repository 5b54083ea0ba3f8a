"""Cycles at one place of two parameters, counted by stability, and the attractors there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.data import Coded
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.regions.survey import Survey
from woodpecker.slices.attracting import SettledOrbit, orbit_diagram
from woodpecker.slices.slices import slices_at

NEUTRAL = 1e-6  # of 1 - |multiplier|: closer, rounding decides on stability; the ends of
# intervals of fixed points, such as states of rest, have the multiplier one exactly
LONGER = 16  # times as many points of an orbit without a period: it may be settling still, even if
# chaos comes first, and exponents over a hundred points vary by some 0.03
STEADY = 1e-9  # largest |exponent| of orbits at rest, where all slopes are one


class Count(NamedTuple):
    """Numbers of stable and unstable cycles of one minimal period.

    Examples
    --------
    >>> from woodpecker.regions import Count
    >>> Count(2, stable=1, unstable=3)
    Count(period=2, stable=1, unstable=3)
    """

    period: int
    stable: int
    unstable: int


Census = tuple[Count, ...]
"""Cycles of some periods, in ascending order of these."""


class Settles(Coded):
    """The kind of an attractor.

    Examples
    --------
    >>> from woodpecker.regions import Settles
    >>> [(settles.name, settles.value) for settles in Settles][:3]
    [('CYCLE', 'cycle'), ('REST', 'rest'), ('CHAOS', 'chaos')]
    """

    CYCLE = "cycle", "a cycle"
    REST = "rest", "an interval of fixed points: the system rests"
    CHAOS = "chaos", "no cycle that is looked for, and a positive exponent"
    LONG = "long", "no cycle that is looked for, and no positive exponent"
    LOST = "lost", "the orbit leaves the window or has no image"


class SampledAttractor(NamedTuple):
    """An attractor of sampled orbits; the period is that of a cycle, else 0.

    Examples
    --------
    >>> from woodpecker.regions import SampledAttractor, Settles
    >>> print(SampledAttractor(Settles.CYCLE, 2), "and", SampledAttractor(Settles.CHAOS, 0))
    period 2 and chaos
    """

    kind: Settles
    period: int = 0

    def __str__(self) -> str:
        return f"period {self.period}" if self.kind is Settles.CYCLE else self.kind.value


def census_at(map_: PiecewiseMap, p: float, orders: Sequence[int], settings: Settings) -> Census:
    """The census of the window: counts for ascending periods, without neutral cycles."""
    found = []
    for each in slices_at(map_, p, orders, settings):
        sizes = [abs(cycle.multiplier) for cycle in each.cycles]
        told = [size for size in sizes if abs(size - 1.0) > NEUTRAL]
        stable = sum(size < 1.0 for size in told)
        found.append(Count(each.order, stable, len(told) - stable))
    return tuple(found)


def attractors_at(
    map_: PiecewiseMap, p: float, settings: Settings, within: tuple[float, float], survey: Survey
) -> tuple[SampledAttractor, ...]:
    """The distinct attractors of orbits from evenly spaced starts in the window.

    An orbit is lost where it leaves the interval ``within``.
    """
    low, high = settings.window
    starts = low + (np.arange(survey.starts) + 0.5) / survey.starts * (high - low)
    kinds = set[SampledAttractor]()
    for keep in (survey.keep, LONGER * survey.keep):  # on from where orbits have not settled
        found = orbit_diagram(
            map_, p, starts, within, transient=survey.transient, keep=keep, settings=settings
        )
        kinds |= {_attractor(orbit) for orbit in found.orbits if orbit.period}
        if found.lost:
            kinds.add(SampledAttractor(Settles.LOST))
        left = [orbit for orbit in found.orbits if not orbit.period]
        starts = np.array([orbit.x[-1] for orbit in left])
        if not left:
            break
    kinds.update(map(_attractor, left))
    return tuple(sorted(kinds, key=lambda each: (list(Settles).index(each.kind), each.period)))


def _attractor(orbit: SettledOrbit) -> SampledAttractor:
    if orbit.period == 1 and abs(orbit.exponent) <= STEADY:
        return SampledAttractor(Settles.REST)
    if orbit.period:
        return SampledAttractor(Settles.CYCLE, orbit.period)
    chaotic = orbit.exponent > 0.0 and math.isfinite(orbit.exponent)
    return SampledAttractor(Settles.CHAOS if chaotic else Settles.LONG)
