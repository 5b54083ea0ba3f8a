"""Where a map settles: attracting cycles and bands, and what surrounds them.

A *band* is an interval of a chaotic attractor. Bands are found by what grows from both sides of a
break: where the map expands every interval comes to lie across a break sooner or later, so that
each chaotic attractor has one inside; what grows from it is the attractor itself if nothing smaller
grows from another break in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import gcd

from sympy import QQ

from pwmap.algebra.exact import pair
from pwmap.longrun.fates import AttractingCycle, Fate, Fates, Orbit, abs_, hull
from pwmap.longrun.line import Germ, Interval, Line, add, length, outside
from pwmap.longrun.numbers import Element, Exact

STEPS = 600  # of an orbit, and of what grows from a break
PARTS = 2000  # of what grows from a break at most, at any time
EXPANDING = 96  # the same where every piece expands: nothing draws it in, so it is finite or open
GROWTH = 20_000  # steps of what grows from a break where every piece expands
MIXED = 1_000  # and where some contract: there it may never end
CLOSE = 20  # bits by which the sides from which something grows are smaller than what is kept apart
HEIGHT = 3  # and times the bits of the coefficients: numbers of so many bits do not lie closer to
# places at which attractors change, but for the bits of these [Roth1955]
CLOSER = 2**7  # the same must grow from this part of the sides


@dataclass(frozen=True, slots=True, eq=False)
class Bands:
    """A chaotic attractor: intervals between which orbits go, dense in all of them.

    Attributes
    ----------
    intervals
        Closed, apart, from left to right.
    breaks
        Those inside.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> bands = dynamics(tent, {"a": "7/5"}).attractors[0].core
    >>> len(bands), [(str(low), str(high)) for low, high in bands.intervals]
    (2, [('21/50', '721/1250'), ('147/250', '7/10')])
    """

    intervals: tuple[Interval, ...]
    breaks: tuple[Exact, ...]

    def __len__(self) -> int:
        """How many bands."""
        return len(self.intervals)

    def holds(self, x: Exact) -> bool:
        """Whether a point lies inside one of them.

        Parameters
        ----------
        x
            An exact number.

        Returns
        -------
        bool
            False at the ends of a band.
        """
        return any(low < x < high for low, high in self.intervals)


@dataclass(frozen=True, eq=False)
class Attractors:
    """Everything bounded that orbits settle to.

    Attributes
    ----------
    cycles, bands
        Attracting cycles, and chaotic attractors, from left to right.
    orbits
        Of all germs at breaks, with their fates.
    open
        Breaks of which it is not known what grows from them.
    """

    line: Line
    cycles: tuple[AttractingCycle, ...]
    bands: tuple[Bands, ...]
    orbits: tuple[Orbit, ...]
    open: tuple[Exact, ...]

    def __len__(self) -> int:
        """How many."""
        return len(self.cycles) + len(self.bands)

    @cached_property
    def absorbing(self) -> Interval | None:
        """The smallest interval around all breaks and their images that is mapped into itself.

        None if there is none, since some of these images are lost.
        """
        line = self.line
        if not line.breaks:
            return None
        found = hull([(line.image(germ).x, line.image(germ).x) for germ in line.germs]
                     + [(value, value) for value in line.values])  # fmt: skip
        fates = Fates(line, STEPS)
        for _ in range(STEPS):
            if fates.is_lost(found[0]) or fates.is_lost(found[1]):
                return None
            more = hull([found, *line.images([found])])
            if more == found:
                return found
            found = more
        return None


class _Grown(Exception):  # noqa: N818  it is not an error
    """What grows from a break is no part of a chaotic attractor."""


def attractors_of(line: Line, steps: int = STEPS) -> Attractors:
    """The attractors of a map.

    Parameters
    ----------
    line
        The map.
    steps
        How far orbits are followed.
    """
    expands = all(abs_(branch.slope) > 1 for branch in line.branches)
    fates = Fates(line, min(steps, EXPANDING) if expands else steps)
    orbits = [fates.orbit(germ) for germ in line.germs]
    for k, orbit in enumerate(orbits):  # the cycles are all known only now
        if orbit.fate is Fate.OPEN:
            orbits[k] = fates.orbit(orbit.germs[0])
    scale = _scale(line)
    grown, left = dict[Exact, list[Interval]](), list[Exact]()
    for x, (one, other) in zip(
        line.breaks, zip(orbits[::2], orbits[1::2], strict=True), strict=True
    ):
        if any(_ends_at_a_break(line, orbit, fates) for orbit in (one, other)):
            left.append(x)
            continue
        settled = {one.fate, other.fate} & {Fate.DRAWN, Fate.LOST}
        if (
            settled
            or _is_flat(line, x)
            or _ends_in_a_cycle(one, fates)
            or _ends_in_a_cycle(other, fates)
        ):
            continue
        found = _grown_twice(fates, x, scale)
        if found is None:
            left.append(x)
        elif found:
            grown[x] = found
    bands = list[Bands]()
    for intervals in grown.values():
        inner = [y for y in line.breaks if any(low < y < high for low, high in intervals)]
        known = any(intervals == list(each.intervals) for each in bands)
        if not known and all(grown.get(y) == intervals for y in inner):
            bands.append(Bands(tuple(intervals), tuple(inner)))
    bands.sort(key=lambda each: each.intervals[0][0])
    cycles = sorted(fates.cycles, key=lambda each: each.points[0])
    return Attractors(line, tuple(cycles), tuple(bands), tuple(orbits), tuple(left))


def _is_flat(line: Line, x: Exact) -> bool:
    """Whether a piece beside a break is flat: its points all have one orbit."""
    return any(not line.beside(Germ(x, side)).slope for side in (-1, 1))


def height(line: Line) -> int:
    """Bits of the largest denominator of a map's coefficients."""
    numbers = [*line.breaks, *(x for branch in line.branches for x in branch[:2])]
    parts = [c for x in numbers for c in (x.value if isinstance(x, Element) else (x,))]
    return max(pair(part)[1].bit_length() for part in parts)


def _ends_in_a_cycle(orbit: Orbit, fates: Fates) -> bool:
    """Whether a finite orbit ends in an attracting cycle."""
    if orbit.fate is not Fate.FINITE:
        return False
    end = {germ.x for germ in orbit.germs[orbit.start :]}
    return any(end & set(cycle.points) for cycle in fates.cycles)


def _ends_at_a_break(line: Line, orbit: Orbit, fates: Fates) -> bool:
    """Whether a finite orbit ends in a cycle that attracts on one side, since it meets a break."""
    if orbit.fate is not Fate.FINITE or _ends_in_a_cycle(orbit, fates):
        return False
    size = QQ.one
    for germ in orbit.germs[orbit.start :]:
        size = size * abs_(line.beside(germ).slope) if germ.side else size
    held = any(not germ.side for germ in orbit.germs[orbit.start :])
    return held or size < 1


def _scale(line: Line) -> Exact:
    """A length that is small beside what breaks keep apart."""
    breaks = line.breaks
    gaps = [b - a for a, b in pairwise(breaks)]
    images = sorted({line.image(germ).x for germ in line.germs})
    gaps += [b - a for a, b in pairwise(images)]
    return min((gap for gap in gaps if gap > 0), default=QQ.one)


def _grown_twice(fates: Fates, x: Exact, scale: Exact) -> list[Interval] | None:
    """What grows from the sides of a break, [] if it does not stay; None if that is not known.

    The same must grow from much less: then its ends are images of breaks.
    """
    try:
        close = scale * QQ(1, 1 << (CLOSE + HEIGHT * height(fates.line)))
        found = _grown(fates, x, close)
        again = _grown(fates, x, close * QQ(1, CLOSER)) if found else found
    except _Grown:
        return []
    return found if found == again else None


def _grown(fates: Fates, x: Exact, away: Exact) -> list[Interval] | None:
    """All images of the two sides of a break, as intervals."""
    line = fates.line
    new: Sequence[Interval] = [(x - away, x + away)]
    known = list(new)
    expands = all(abs_(branch.slope) > 1 for branch in line.branches)
    for _ in range(GROWTH if expands else MIXED):
        images = line.images(new)
        new = outside(images, known)
        if not new:
            return known
        for low, high in new:
            if fates.is_lost(low) or fates.is_lost(high):
                raise _Grown
            if any(cycle.draws(end) for cycle in fates.cycles for end in (low, high)):
                raise _Grown
        add(known, new)
        if len(known) > PARTS:
            return None
    return None


def common_period(ways: Sequence[Sequence[int]]) -> int:
    """The greatest common divisor of the lengths of all closed walks in a connected graph."""
    depth, waiting, found = {0: 0}, [0], 0
    while waiting:
        here = waiting.pop()
        for there in ways[here]:
            if there in depth:
                found = gcd(found, depth[here] + 1 - depth[there])
            else:
                depth[there] = depth[here] + 1
                waiting.append(there)
    return found


def share(intervals: Sequence[Interval], window: Interval) -> Exact:
    """The part of a window that intervals cover."""
    low, high = window
    inside = [(max(a, low), min(b, high)) for a, b in intervals if a < high and low < b]
    return length(inside) / (high - low)
