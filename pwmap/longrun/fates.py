"""Fates of the orbits of germs: an attracting cycle, a neutral interval, infinity, or unknown.

All points of a *neutral* interval follow a word of slope 1 or -1 for ever. If a word of slope 1
returns one point to itself, it returns all points that follow it: these are periodic, and neither
attract nor repel. A word of slope -1 reflects an interval about its midpoint, so that two rounds
return all points. The largest such interval, or an image of it, ends at a break; it is found from a
germ at a break that returns to itself with slope 1 in size.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import accumulate, islice
from math import prod

from sympy import QQ

from pwmap.algebra.exact import HIGHEST, LOWEST, Infinite, sign
from pwmap.algebra.numbers import Exact, key
from pwmap.longrun.line import (
    IDENTITY,
    AffinePiece,
    Germ,
    Interval,
    MapLine,
    Part,
    PointSet,
    iterates,
    open_intervals,
    point_set,
)
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

REPEATS = 3  # of a word at the end of an orbit, before its cycle is tested for attracting the orbit
STEP = 8  # operations of one step, besides those of long numbers
LONGEST = 10_000  # work of one operation, with some ten thousand bits: then an orbit is given up
FIRST = 16  # step at which an attracting cycle is first sought; again at every power of two


class Fate(Enum):
    """What becomes of an orbit; the value says it in words."""

    FINITE = "periodic after a while"
    DRAWN = "drawn into a cycle"
    LOST = "lost to infinity"
    FLAT = "one with all points beside it, after a flat piece"
    MATCHED = "one with that of the other side of a break"
    OPEN = "not known"


@dataclass(frozen=True, eq=False)
class AttractingCycle:
    """An attracting cycle: the core of an attractor of :func:`pwmap.dynamics`.

    ``points`` are in the order of visits, from the smallest on; ``word`` has the letters of their
    pieces. ``multiplier`` is the product of the slopes, less than 1 in size. All orbits that start
    closer to a point than its ``reach``, which may be infinite, converge to the cycle.
    """

    points: tuple[Exact, ...]
    word: str
    multiplier: Exact
    reach: tuple[Exact, ...]

    @property
    def period(self) -> int:
        """The number of points."""
        return len(self.points)

    def draws(self, x: Exact) -> bool:
        """Whether the orbit of an exact number is known to converge to the cycle."""
        return x in self.region

    @cached_property
    def region(self) -> PointSet:
        """The union of the open intervals within reach of the points."""
        reach = zip(self.points, self.reach, strict=True)
        return open_intervals((x - near, x + near) for x, near in reach)


@dataclass(frozen=True, slots=True, eq=False)
class GermOrbit:
    """The orbit of a germ, as far as it was followed."""

    line: MapLine
    germs: tuple[Germ, ...]  # itself and its images, each once
    fate: Fate
    start: int = -1  # index of the first germ of the period, if the orbit is finite; of the
    # first piece of the period, if only the itinerary is eventually periodic

    @property
    def numbers(self) -> tuple[int, ...]:
        """The indices of the branches visited."""
        return tuple(map(self.line.number, self.germs))

    @property
    def word(self) -> tuple[int, ...]:
        """The branch indices of the periodic part."""
        return tuple(map(self.line.number, self.again))

    @property
    def letters(self) -> tuple[str, ...]:
        """The letters of the pieces visited."""
        return tuple(self.line.piece(germ).letter for germ in self.germs)

    @property
    def period(self) -> int:
        """The period of the cycle of germs in which a finite orbit ends."""
        return len(self.germs) - self.start

    @property
    def again(self) -> tuple[Germ, ...]:
        """The cycle of germs in which a finite orbit ends."""
        return self.germs[self.start :]

    @property
    def size(self) -> Exact:
        """The absolute value of that cycle's multiplier."""
        return prod((abs(self.line.piece(germ).slope) for germ in self.again), start=QQ.one)

    def kneading(self) -> str:
        """The letters, with the period in brackets; dots if the orbit is not known to be finite."""
        word = "".join(self.letters)
        if self.fate is Fate.FINITE:
            return f"{word[: self.start]}({word[self.start :]})"
        return f"{word}..."


class Fates:
    """Follows orbits of a map and collects the attracting cycles in which they end."""

    def __init__(self, line: MapLine, steps: int, meter: Meter) -> None:
        self.line, self.steps, self.meter = line, steps, meter
        self.lost_below, self.lost_above = escapes(line)
        self.cycles = list[AttractingCycle]()

    def is_lost(self, x: Exact) -> bool:
        """Whether the orbit of a point is known to tend to infinity."""
        return bool(x < self.lost_below or x > self.lost_above)

    def orbit(self, germ: Germ) -> GermOrbit:
        """The orbit of a germ up to the step at which its fate is known, or OPEN."""
        seen, germs, pieces = dict[Hashable, int](), list[Germ](), list[AffinePiece]()
        for step in range(self.steps):
            work = work_of(germ.x)
            self.meter.spend(STEP + 3 * work)
            if work > LONGEST:
                break
            place = key(germ.x), germ.side
            if place in seen:
                self.keep(self.cycle_along(pieces[seen[place] :]))
                return GermOrbit(self.line, tuple(germs), Fate.FINITE, seen[place])
            if self.is_lost(germ.x):
                return GermOrbit(self.line, tuple(germs), Fate.LOST)
            drawn = next((each for each in self.cycles if each.draws(germ.x)), None)
            if drawn is None and step >= FIRST and not step & (step - 1):
                drawn = self._drawn(germ, pieces)
            if drawn is not None and germ.x not in drawn.points:
                return GermOrbit(self.line, tuple(germs), Fate.DRAWN)
            seen[place] = step
            germs.append(germ)
            pieces.append(self.line.piece(germ))
            germ = pieces[-1].image(germ)
        return GermOrbit(self.line, tuple(germs), Fate.OPEN)

    def keep(self, cycle: AttractingCycle | None) -> None:
        """Add an attracting cycle to the known ones, unless it is None or known."""
        if cycle is not None and all(cycle.points != each.points for each in self.cycles):
            self.cycles.append(cycle)

    def _drawn(self, germ: Germ, pieces: list[AffinePiece]) -> AttractingCycle | None:
        """The cycle of the word that an orbit has begun to repeat, if it attracts the orbit."""
        letters = [piece.letter for piece in pieces]
        for period in range(1, len(letters) // REPEATS + 1):
            if letters[-REPEATS * period :] == letters[-period:] * REPEATS:
                cycle = self.cycle_along(pieces[-period:])
                if cycle is not None and cycle.draws(germ.x):
                    self.keep(cycle)
                    return cycle
        return None

    def cycle_along(self, word: Sequence[AffinePiece]) -> AttractingCycle | None:
        """The attracting cycle that follows a word in the interiors of its pieces; None if none.

        The word may be a power of the word of the cycle.
        """
        whole = IDENTITY
        for piece in word:
            whole = piece.after(whole)
        if not abs(whole.slope) < 1:
            return None
        visited = [*accumulate(word, lambda x, piece: piece(x), initial=whole.fixed_point)]
        if not all(piece.lower < x < piece.upper for x, piece in zip(visited, word, strict=False)):
            return None
        period = visited.index(visited[0], 1)
        points, pieces = visited[:period], [*word[:period]]
        first = points.index(min(points))
        points, pieces = points[first:] + points[:first], pieces[first:] + pieces[:first]
        return AttractingCycle(
            points=tuple(points),
            word="".join(piece.letter for piece in pieces),
            multiplier=prod((piece.slope for piece in pieces), start=QQ.one),
            reach=self._reach(points, pieces),
        )

    def _reach(self, points: Sequence[Exact], pieces: Sequence[AffinePiece]) -> tuple[Exact, ...]:
        """Distances from the points of a cycle within which orbits follow its pieces for ever."""
        away = [min((abs(x - at) for at in self.line.breaks), default=HIGHEST) for x in points]
        found, after = list[Exact](away), HIGHEST
        # backwards and twice, to close the cycle: as the multiplier is below 1 in size, bounds
        # from a third round would be weaker
        for k in [*reversed(range(len(points)))] * 2:
            slope = abs(pieces[k].slope)
            after = found[k] = min(away[k], after / slope if slope else HIGHEST)
        return tuple(found)


def escapes(line: MapLine) -> Interval:
    """The points below and above which orbits tend to infinity; infinite where none do."""
    left, right = line.branches[0], line.branches[-1]
    below, above = _own(left, -1), _own(right, 1)
    if len(line.branches) == 1:
        return below, above
    # a decreasing outer piece maps far points to the other side
    if left.slope < 0 and right.slope < 0 and left.slope * right.slope > 1:
        _, twice = iterates((left, right))
        below = _own(twice, -1)
        return below, max(left(below), right.lower)
    if left.slope < 0:
        below = min(left.upper, (above - left.intercept) / left.slope)
    if right.slope < 0:
        above = max(right.lower, (below - right.intercept) / right.slope)
    return below, above


def _own(branch: AffinePiece, side: int) -> Exact:
    """The point beyond which a rising outer piece takes orbits to infinity on its own side."""
    end = branch.upper if side < 0 else branch.lower
    if branch.slope > 1:
        return (min if side < 0 else max)(branch.intercept / (1 - branch.slope), end)
    if branch.slope == 1 and side * sign(branch.intercept) > 0:
        return end
    return side * HIGHEST


@dataclass(frozen=True, slots=True, eq=False)
class NeutralIntervals:
    """Intervals that a map permutes, all of whose points are periodic; of :func:`pwmap.dynamics`.

    ``parts`` are in the order of visits, from the leftmost on, with the ends that belong to them;
    ``word`` has the letters of their pieces. The ``multiplier`` is 1 if one round returns every
    point, and -1 if it reflects the intervals about their midpoints, so that two rounds do.
    """

    parts: tuple[Part, ...]
    word: str
    multiplier: int

    def __len__(self) -> int:
        return len(self.parts)

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """The endpoints of each interval."""
        return tuple((low[0], high[0]) for low, high in self.parts)

    @property
    def region(self) -> PointSet:
        """The union of the intervals."""
        return point_set(self.parts)

    @property
    def period(self) -> int:
        """The period of all points, but half of it for midpoints of reflected intervals."""
        return len(self.parts) * (1 if self.multiplier > 0 else 2)


def neutral_intervals(line: MapLine, orbits: Iterable[GermOrbit]) -> tuple[NeutralIntervals, ...]:
    """The neutral intervals in which the given orbits of germs end, from left to right."""
    if not line.breaks:
        return _of_one_piece(line)
    found = dict[Interval, NeutralIntervals]()
    for orbit in orbits:
        is_finite = orbit.fate is Fate.FINITE
        if is_finite and orbit.size == 1 and all(germ.side for germ in orbit.again):
            each = _around(line, orbit.again)
            found.setdefault(each.intervals[0], each)
    return tuple(sorted(found.values(), key=lambda each: each.intervals[0]))


def followers(line: MapLine, germs: Sequence[Germ]) -> Iterator[Interval]:
    """Yield the intervals, one beside each germ of a cycle, whose points follow it for a round."""
    part, start = domain(line, germs), germs[0]
    part = (start.x, part[1]) if start.side > 0 else (part[0], start.x)
    for germ in germs:
        yield part
        part = line.piece(germ).over(part)


def _around(line: MapLine, germs: tuple[Germ, ...]) -> NeutralIntervals:
    """The neutral intervals whose points follow a cycle of germs with slopes of product 1."""
    visited, part, pieces = list[Interval](), domain(line, germs), [*map(line.piece, germs)]
    while part not in visited[:1]:
        visited.append(part)
        part = pieces[len(visited) - 1].over(part)
    first = min(range(len(visited)), key=visited.__getitem__)
    letters = [piece.letter for piece in pieces[: len(visited)]]
    return NeutralIntervals(
        parts=_with_ends(line, visited[first:] + visited[:first], len(germs)),
        word="".join(letters[first:] + letters[:first]),
        multiplier=1 if len(germs) == len(visited) else -1,
    )


def domain(line: MapLine, germs: Sequence[Germ]) -> Interval:
    """The interval of the points that follow the pieces on the sides of all germs of an orbit."""
    *_, whole = iterates(map(line.piece, germs))
    return whole.lower, whole.upper


def _with_ends(line: MapLine, intervals: Sequence[Interval], period: int) -> tuple[Part, ...]:
    """The intervals as parts, closed at ends whose own orbits follow the same pieces."""
    owned = set[tuple[int, int]]()  # interval, and side of its interior at an owned end
    for end, side in zip(intervals[0], (1, -1), strict=True):
        if isinstance(end, Infinite):
            continue
        around = [*islice(line.orbit(Germ(end, side)), period)]  # visits an end of every interval
        if line.owns(around):
            owned.update((k % len(intervals), each.side) for k, each in enumerate(around))
    return tuple(
        ((low, -1 if (k, 1) in owned else 1), (high, 1 if (k, -1) in owned else -1))
        for k, (low, high) in enumerate(intervals)
    )


def _of_one_piece(line: MapLine) -> tuple[NeutralIntervals, ...]:
    """The whole line, if a map of one piece is the identity or a reflection; otherwise empty."""
    (branch,) = line.branches
    if branch.slope == -1 or (branch.slope == 1 and not branch.intercept):
        parts, multiplier = (((LOWEST, 1), (HIGHEST, -1)),), -1 if branch.slope < 0 else 1
        return (NeutralIntervals(parts, branch.letter, multiplier),)
    return ()
