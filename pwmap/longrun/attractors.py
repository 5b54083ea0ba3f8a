"""Attractors: attracting cycles, neutral intervals, and bands of chaotic attractors.

Each chaotic attractor holds a break in its interior, since an expanding interval grows until it
lies across one. The late images of one side of a break are a candidate if they are mapped onto
themselves. They are an attractor if the map expands by more than 2 along each of finitely many
words, and if the image of each such word grows to all of them: any interval grows until it contains
all points that follow one of these words [LasotaYorke1973], so that no part attracts by itself.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import gcd

import networkx as nx
from sympy import QQ

from pwmap.algebra.exact import pair
from pwmap.algebra.numbers import Element, Exact, enclosed, key
from pwmap.longrun.fates import (
    AttractingCycle,
    Fate,
    Fates,
    GermOrbit,
    NeutralIntervals,
    followers,
    neutral_intervals,
)
from pwmap.longrun.line import Germ, Interval, MapLine, difference, join, length, union
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

STEPS = 600  # of an orbit, at most
EXPANDING = 96  # the same if every piece expands: then no cycle attracts the orbit
PARTS = 2000  # intervals in the images of one side of a break, at most
MAX_GROWTH_STEPS = 20_000  # steps for which an interval beside a break is followed, at most
WORDS = 20_000  # followed to decide whether bands expand, at most
ROUNDED = 64  # bits by which rounding errors lie below the square of the initial interval
STEP = 20  # operations of mapping an interval once
# All images of an interval are collected once it is longer than this fraction of the least gap,
# or once it has not grown for so many steps.
LONG_ENOUGH, STALLED_STEPS = QQ(1, 2**16), 256
# Bits by which the initial interval is shorter than the least gap, besides a multiple of the bits
# of the coefficients: rationals of so many bits lie no closer to a value at which attractors
# change, up to the bits of that value [Roth1955].
START_BITS, BITS_PER_BIT = 20, 3
Intervals = tuple[Interval, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Bands:
    """The bands of a chaotic attractor of :func:`pwmap.dynamics`, with dense orbits."""

    intervals: Intervals  # closed and disjoint, from left to right

    def __len__(self) -> int:
        return len(self.intervals)


@dataclass(frozen=True, eq=False)
class Attractors:
    """The bounded attractors of a map, each kind from left to right."""

    cycles: tuple[AttractingCycle, ...]
    neutral: tuple[NeutralIntervals, ...]
    bands: tuple[Bands, ...]
    orbits: tuple[GermOrbit, ...]  # of all germs at breaks, with their fates
    open: tuple[Exact, ...]  # breaks beside which further attractors may lie
    left_out: str = ""  # a sentence if a budget or an interrupt ended the search


def attractors_of(line: MapLine, meter: Meter) -> Attractors:
    """The attractors of a map; breaks that the budget does not reach stay open."""
    expands = all(abs(branch.slope) > 1 for branch in line.branches)
    fates = Fates(line, EXPANDING if expands else STEPS, meter)
    orbits = _orbits(fates)
    neutral = neutral_intervals(line, orbits)
    bands, open_ = _bands(fates, orbits, neutral)
    return Attractors(
        cycles=tuple(sorted(fates.cycles, key=lambda each: each.points[0])),
        neutral=neutral,
        bands=tuple(sorted(bands, key=lambda each: each.intervals[0][0])),
        orbits=tuple(orbits),
        open=tuple(sorted(open_)),
        left_out=meter.stopped,
    )


def _orbits(fates: Fates) -> list[GermOrbit]:
    """The orbits of all germs at breaks; following them finds the attracting cycles."""
    line, meter, orbits = fates.line, fates.meter, list[GermOrbit]()
    with meter.keeping(line.branches):
        for germ in meter.each(line.germs, "orbits of breaks"):
            orbits.append(_like_the_last(line, germ, orbits) or fates.orbit(germ))
        for k, orbit in enumerate(orbits):  # now that all cycles are known, one may attract it
            if orbit.fate is Fate.OPEN and fates.cycles:
                orbits[k] = fates.orbit(orbit.germs[0])
        if not line.breaks:  # then any orbit finds the fixed point, if it attracts
            fates.orbit(Germ(QQ.zero, 1))
    rest = line.germs[len(orbits) :]
    return orbits + [GermOrbit(line, (germ,), Fate.OPEN) for germ in rest]


def _bands(
    fates: Fates, orbits: Sequence[GermOrbit], neutral: Sequence[NeutralIntervals]
) -> tuple[list[Bands], set[Exact]]:
    """The bands of all chaotic attractors, and the breaks beside which there may be more."""
    line, meter, bands = fates.line, fates.meter, list[Bands]()
    grown = dict[Exact, set[Intervals]]()  # late images of both sides of each break
    waiting, unproved = set[Intervals](), set[Intervals]()  # candidates, and those not proved
    with meter.keeping(line.branches):
        growth = _LateImages(fates, orbits, neutral)
        sides = zip(orbits[::2], orbits[1::2], strict=True)
        beside = [
            (x, _beside(fates, growth, pair))
            for x, pair in meter.each([*zip(line.breaks, sides, strict=True)], "breaks")
        ]
        grown = {x: found for x, found in beside if found is not None}
        waiting = {each for found in grown.values() for each in found if each}
        while waiting:
            each = min(waiting, key=length)
            is_smallest = growth.is_smallest(each)
            waiting.remove(each)
            if is_smallest:
                bands.append(Bands(each))
                waiting = {other for other in waiting if difference(each, other)}
            else:
                unproved.add(each)
    doubtful = [interval for each in waiting | unproved for interval in each]
    left = {x for x in line.breaks if x not in grown or any(a < x < b for a, b in doubtful)}
    return bands, left


def _like_the_last(line: MapLine, germ: Germ, orbits: Sequence[GermOrbit]) -> GermOrbit | None:
    """The orbit of a right germ, copied from the left one if both have one image; else None."""
    last = orbits[-1] if orbits else None
    if last is None or last.fate is Fate.FINITE or line.image(germ) not in last.germs[1:2]:
        return None
    return replace(last, germs=(germ, *last.germs[1:]))


def _beside(
    fates: Fates, growth: _LateImages, sides: tuple[GermOrbit, GermOrbit]
) -> set[Intervals] | None:
    """The late images of both sides of a break, () for a side that settles; None if unknown."""
    found = set[Intervals]()
    image = sides[0].germs[1:2]
    same = image and image == sides[1].germs[1:2]
    for orbit in sides[:1] if same else sides:
        each = _grown(fates, growth, orbit)
        if each is None:
            return None
        found.add(each)
    return found


def _grown(fates: Fates, growth: _LateImages, orbit: GermOrbit) -> Intervals | None:
    """The late images of one side of a break, () if it settles; None if that is unknown."""
    if orbit.fate is Fate.FINITE:
        if any(germ.x in cycle.points for germ in orbit.again for cycle in fates.cycles):
            return ()
        if orbit.size < 1 or not all(germ.side for germ in orbit.again):
            return None  # it ends in a cycle through a break, which may attract from one side
        if orbit.size == 1:
            return ()
    if orbit.fate in (Fate.DRAWN, Fate.LOST) or not fates.line.piece(orbit.germs[0]).slope:
        return ()  # on a flat piece all points have the same image
    return growth.grown(orbit.germs[0])


def absorbing_of(line: MapLine) -> Interval | None:
    """The smallest closed interval, mapped into itself, with all breaks and images; or None."""
    if not line.breaks:
        return None
    places = [*line.breaks, *map(line, line.breaks), *(line.image(germ).x for germ in line.germs)]
    least, most = min(places), max(places)
    left, right = line.branches[0], line.branches[-1]
    # its ends lie on the outer pieces; each is the extreme image of a break, the fixed point of its
    # own piece, or the image of the other end. The shortest invariant interval whose ends solve two
    # of these equations lies in all others
    found = [
        ends
        for low in ((QQ.zero, QQ.zero, least), (left.slope, QQ.zero, left.intercept),
                    (QQ.zero, right.slope, right.intercept))
        for high in ((QQ.zero, QQ.zero, most), (QQ.zero, right.slope, right.intercept),
                     (left.slope, QQ.zero, left.intercept))
        if (ends := _fixed(low, high)) is not None
        and ends[0] <= min(least, left(ends[0]), right(ends[1]))
        and ends[1] >= max(most, left(ends[0]), right(ends[1]))
    ]  # fmt: skip
    return max(found, key=lambda ends: ends[0] - ends[1], default=None)


def _fixed(low: tuple[Exact, ...], high: tuple[Exact, ...]) -> Interval | None:
    """The solution (l, u) of l = a l + b u + c and u = d l + e u + f; None unless it is unique."""
    (a, b, c), (d, e, f) = low, high
    size = (1 - a) * (1 - e) - b * d
    return None if not size else (((1 - e) * c + b * f) / size, (d * c + (1 - a) * f) / size)


def denominator_bits(x: Exact) -> int:
    """The number of bits of the largest denominator in a number."""
    if isinstance(x, Element):
        return max(map(denominator_bits, x.value), default=1)
    return pair(x)[1].bit_length()


class _LateImages:
    """Late images of one-sided neighbourhoods of breaks.

    A short interval at a break is mapped, keeping the longest part between breaks each time, until
    it is long or grows no more; then all images are collected. Long fractions are rounded, by much
    less than the length of the first interval. Finally each end is replaced by the nearby image of
    a break, and the result is accepted only if it is mapped onto itself exactly.
    """

    def __init__(
        self, fates: Fates, orbits: Sequence[GermOrbit], neutral: Sequence[NeutralIntervals]
    ) -> None:
        self.fates, self.line, self.meter = fates, fates.line, fates.meter
        numbers = (*self.line.breaks, *(x for branch in self.line.branches for x in branch[:2]))
        self.stretches = any(abs(branch.slope) > 1 for branch in self.line.branches)
        self.scale = _scale(self.line)
        bits = START_BITS + BITS_PER_BIT * max(map(denominator_bits, numbers))
        self.close = self.scale * QQ(1, 1 << bits)
        self.grid = 2 * denominator_bits(self.close) + ROUNDED
        self.near = self.close * (1 << self.grid)  # the same, in units of the grid
        self.step = STEP * max(map(work_of, numbers), default=1)  # with numbers of the map's field
        # in order by their places on the grid: it takes long to compare exact ones
        images = {key(germ.x): germ.x for orbit in orbits for germ in orbit.germs}
        self.images = sorted((self.on_grid(x), x) for x in images.values())
        self.places = [place for place, _ in self.images]
        self.known = dict[Interval, Intervals]()
        self.settling = [pair for each in neutral for pair in each.intervals]
        for orbit in orbits:  # the side of a break may attract, without a cycle that does
            if orbit.fate is Fate.FINITE and orbit.size < 1 and all(g.side for g in orbit.again):
                self.settling += followers(self.line, orbit.again)

    def is_smallest(self, intervals: Intervals) -> bool:
        """Whether no smaller late images lie within given ones; False if that is not known."""
        # a word expands by more than 2, so that the longer half of an interval cut by a break still
        # grows, until an image contains all points that follow one of these words
        images = expanded(self.line, intervals, self.meter)
        if images is None:
            return False
        enough: Interval | None = None
        for part in sorted(images, key=_length, reverse=True):
            if self.whole(part, enough) != intervals:
                return False
            enough = enough or part
        return True

    def grown(self, germ: Germ) -> Intervals | None:
        """The late images of the side of a germ, () if it settles; None if they are not known."""
        ends = germ.x, germ.x + germ.side * self.close
        part: Interval = (min(ends), max(ends))
        longest, since = part, 0
        for _ in range(MAX_GROWTH_STEPS):
            if since > STALLED_STEPS and not self.stretches:
                return None  # where nothing expands there are no bands
            if since > STALLED_STEPS or not _length(longest) < self.scale * LONG_ENOUGH:
                return self.whole(part)
            found = self.images_of([part])
            if found is None:
                return ()
            part = max(found, key=_length)
            since += 1
            if _length(longest) < _length(part):
                longest, since = part, 0
        return None

    def whole(self, part: Interval, enough: Interval | None = None) -> Intervals | None:
        """The late images of an interval; those of ``enough`` as soon as they contain that.

        () if an image settles; None if they are not known.
        """
        known, new = [part], [part]
        while new:
            if enough is not None and not difference([enough], known):
                return self.known[enough]
            images = self.images_of(new)
            if images is None:
                return ()
            self.meter.spend(len(known))  # for sorting them
            new = difference(union(images), known)
            join(known, new)
            if len(known) > PARTS:
                return None
        for _ in range(MAX_GROWTH_STEPS):
            self.note(known)
            exact = self.exact(known)
            if exact and self.line.images(exact) == exact:
                self.known[part] = tuple(exact)
                return tuple(exact)
            images = self.line.images(known)
            if len(images) > PARTS:
                break
            before = known
            known = union((self.rounded(low), self.rounded(high)) for low, high in images)
            if known == before:
                break
        return None

    def exact(self, known: Sequence[Interval]) -> list[Interval]:
        """The intervals with ends moved to images of breaks; empty if one is not close to any."""
        ends = list[Exact]()
        for end in chain.from_iterable(known):
            near = self.nearest(end)
            if near is None:
                return []
            ends.append(near)
        return union(zip(ends[::2], ends[1::2], strict=True))

    def nearest(self, x: Exact) -> Exact | None:
        """The image of a break closest to a number; None if it is farther than ``close``."""
        place = self.on_grid(x)
        first = max(0, bisect_left(self.places, place) - 1)
        beside = self.images[first : bisect_right(self.places, place, first) + 1]
        least = min(abs(at - place) for at, _ in beside)
        if not least < self.near:
            return None
        # images that converge to an end are at one place of the grid with it
        found = [each for at, each in beside if abs(at - place) == least]
        return found[0] if len(found) == 1 else min(found, key=lambda each: abs(each - x))

    def images_of(self, parts: Sequence[Interval]) -> list[Interval] | None:
        """The images of the parts between breaks, not joined; None if one of them settles."""
        found = list[Interval]()
        for branch, part in (each for whole in parts for each in self.line.parts(whole)):
            self.note([part])
            low, high = branch.over(part)
            if low == high or self.is_settled((low, high)):
                return None
            found.append((self.rounded(low), self.rounded(high)))
        return found

    def note(self, parts: Sequence[Interval]) -> None:
        self.meter.spend(sum(self.step + 3 * (work_of(low) + work_of(high)) for low, high in parts))

    def is_settled(self, part: Interval) -> bool:
        """Whether an end escapes or converges to a cycle, or a part is neutral or converges."""
        return (
            any(self.fates.is_lost(end) for end in part)
            or any(cycle.draws(end) for cycle in self.fates.cycles for end in part)
            or any(low < part[1] and part[0] < high for low, high in self.settling)
        )

    def rounded(self, x: Exact) -> Exact:
        """The number itself, or the nearest one of the grid if its denominator is longer."""
        return x if denominator_bits(x) <= self.grid else QQ(self.on_grid(x), 1 << self.grid)

    def on_grid(self, x: Exact) -> int:
        """The nearest multiple of 2**-grid, over that, up to an error in the last bit."""
        top, bottom = (
            enclosed(x, self.grid)[0].as_integer_ratio() if isinstance(x, Element) else pair(x)
        )
        return ((top << self.grid + 1) // bottom + 1) // 2


def _length(part: Interval) -> Exact:
    return part[1] - part[0]


def expanded(line: MapLine, intervals: Intervals, meter: Meter) -> set[Interval] | None:
    """The images of intervals along words of slope above 2 in size; None if some are open."""
    found, looked = set[Interval](), 0
    level = dict.fromkeys(intervals, QQ.one)
    while level and looked < WORDS:
        images, level = stretched(line, level.items(), meter), {}
        looked += len(images)
        for image, size in images:
            if not size:
                return None
            if size > 2:
                found.add(image)
            else:
                level[image] = min(size, level.get(image, size))
    return None if level else found


def stretched(
    line: MapLine, parts: Iterable[tuple[Interval, Exact]], meter: Meter
) -> list[tuple[Interval, Exact]]:
    """The images of the intervals one letter on, each with the size of the slope of its word."""
    found = list[tuple[Interval, Exact]]()
    for interval, size in parts:
        meter.spend(STEP + 3 * (work_of(interval[0]) + work_of(size)))
        for branch, part in line.parts(interval):
            found.append((branch.over(part), size * abs(branch.slope)))
    return found


def _scale(line: MapLine) -> Exact:
    """The least distance of two breaks, or of two limits at breaks; 1 if there is none."""
    limits = sorted({line.image(germ).x for germ in line.germs})
    gaps = (b - a for row in (line.breaks, limits) for a, b in pairwise(row))
    return min((gap for gap in gaps if gap > 0), default=QQ.one)


def common_period(line: MapLine, parts: Sequence[Interval]) -> int:
    """The greatest common divisor of the return times to the parts, which the map covers."""
    graph = nx.DiGraph(
        (k, other)
        for k, part in enumerate(parts)
        for low, high in line.images([part])
        for other, (a, b) in enumerate(parts)
        if a < high and low < b
    )
    depth = nx.single_source_shortest_path_length(graph, 0)
    return gcd(*(depth[here] + 1 - depth[there] for here, there in graph.edges))
