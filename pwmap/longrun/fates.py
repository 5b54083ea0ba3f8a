"""What orbits of germs end in: attracting cycles and neutral intervals, infinity, or it is open.

In *neutral* intervals all points follow a word of slope 1 or -1 for ever. A word of slope 1 that
takes one point back takes back all points that follow it: they are periodic, and neither attract
nor repel. A word of slope -1 turns an interval about its middle, so that two rounds take all points
back. The largest such interval, or an image of it, reaches to a break; it is found from a germ at a
break that comes back with slope 1.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
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
    open_intervals,
    point_set,
)
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

REPEATS = 3  # of a word, before its cycle is tried: does it attract the orbit?
STEP = 8  # operations of one step
LONGEST = 10_000  # work of one operation: numbers of an orbit may be some ten thousand bits long
FIRST = 16  # step at which cycles are tried for the first time; then at every power of two


class Fate(Enum):
    """The fate of an orbit; the value says it in words."""

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
    pieces. ``multiplier`` is the product of the slopes, less than one in size. Orbits closer to a
    point than its ``reach``, which may be infinite, are known to converge to the cycle.
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
        """The set within reach."""
        reach = zip(self.points, self.reach, strict=True)
        return open_intervals((x - near, x + near) for x, near in reach)


@dataclass(frozen=True, slots=True, eq=False)
class GermOrbit:
    """A germ's orbit, as far as it was followed."""

    line: MapLine
    germs: tuple[Germ, ...]  # itself and its images, each once
    fate: Fate
    start: int = -1  # of a finite orbit, the number of the first germ that repeats; of an
    # itinerary, that of the first piece that does

    @property
    def numbers(self) -> tuple[int, ...]:
        """The numbers of the branches that it visits."""
        return tuple(map(self.line.number, self.germs))

    @property
    def word(self) -> tuple[int, ...]:
        """Those that repeat."""
        return tuple(map(self.line.number, self.again))

    @property
    def letters(self) -> tuple[str, ...]:
        """The letters of its pieces."""
        return tuple(self.line.piece(germ).letter for germ in self.germs)

    @property
    def period(self) -> int:
        """The period of the germs in which a finite orbit ends."""
        return len(self.germs) - self.start

    @property
    def again(self) -> tuple[Germ, ...]:
        """The germs in which a finite orbit ends."""
        return self.germs[self.start :]

    @property
    def size(self) -> Exact:
        """The size of the multiplier of these."""
        return prod((abs(self.line.piece(germ).slope) for germ in self.again), start=QQ.one)

    def kneading(self) -> str:
        """The letters, those that repeat in brackets; dots where it was not followed on."""
        word = "".join(self.letters)
        if self.fate is Fate.FINITE:
            return f"{word[: self.start]}({word[self.start :]})"
        return f"{word}..."


class Fates:
    """Follows orbits of a map, and keeps the attracting cycles that they meet."""

    def __init__(self, line: MapLine, steps: int, meter: Meter) -> None:
        self.line, self.steps, self.meter = line, steps, meter
        self.lost_below, self.lost_above = escapes(line)
        self.cycles = list[AttractingCycle]()

    def is_lost(self, x: Exact) -> bool:
        """Whether the orbit of a point is known to tend to infinity."""
        return bool(x < self.lost_below or x > self.lost_above)

    def orbit(self, germ: Germ) -> GermOrbit:
        """The orbit of a germ until its fate is known."""
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
        """Add an attracting cycle to the known ones, if it is new."""
        if cycle is not None and all(cycle.points != each.points for each in self.cycles):
            self.cycles.append(cycle)

    def _drawn(self, germ: Germ, pieces: list[AffinePiece]) -> AttractingCycle | None:
        """The cycle whose word an orbit repeats, if it attracts the orbit."""
        letters = [piece.letter for piece in pieces]
        for period in range(1, len(letters) // REPEATS + 1):
            if letters[-REPEATS * period :] == letters[-period:] * REPEATS:
                cycle = self.cycle_along(pieces[-period:])
                if cycle is not None and cycle.draws(germ.x):
                    self.keep(cycle)
                    return cycle
        return None

    def cycle_along(self, word: Sequence[AffinePiece]) -> AttractingCycle | None:
        """The attracting cycle with a point inside of each piece of a word; None if there is none.

        The word may go round it several times.
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
        """How close to each point of a cycle orbits follow it for one round."""
        away = [min((abs(x - at) for at in self.line.breaks), default=HIGHEST) for x in points]
        found, after = list[Exact](away), HIGHEST
        # twice: the second round needs less than the first, by the multiplier
        for k in [*reversed(range(len(points)))] * 2:
            slope = abs(pieces[k].slope)
            after = found[k] = min(away[k], after / slope if slope else HIGHEST)
        return tuple(found)


def escapes(line: MapLine) -> Interval:
    """The ends beyond which orbits tend to infinity; infinite where they do not."""
    left, right = line.branches[0], line.branches[-1]
    below, above = _own(left, -1), _own(right, 1)
    turns = sign(left.slope), sign(right.slope)
    if len(line.branches) == 1:
        return below, above
    # a falling piece maps its far end to the other side
    if turns[0] < 0:
        below = min(left.upper, (above - left.intercept) / left.slope)
    if turns[1] < 0:
        above = max(right.lower, (below - right.intercept) / right.slope)
    if turns == (-1, -1) and left.slope * right.slope > 1:
        return _swapped(left, right)
    return below, above


def _own(branch: AffinePiece, side: int) -> Exact:
    """The point of a rising outer piece beyond which orbits tend to infinity on its own side."""
    end = branch.upper if side < 0 else branch.lower
    if branch.slope > 1:
        return (min if side < 0 else max)(branch.intercept / (1 - branch.slope), end)
    if branch.slope == 1 and side * sign(branch.intercept) > 0:
        return end
    return side * HIGHEST


def _swapped(left: AffinePiece, right: AffinePiece) -> Interval:
    """The ends if both outer pieces fall and map what lies beyond to each other's side."""
    slope = left.slope * right.slope
    low = (right.slope * left.intercept + right.intercept) / (1 - slope)
    # a 2-cycle of both pieces or, if it does not lie in them, where their images meet them
    low = min(low, left.upper, (right.lower - left.intercept) / left.slope)
    high = left(low)
    return low, max(high, right.lower)


@dataclass(frozen=True, slots=True, eq=False)
class NeutralIntervals:
    """Intervals that a map permutes, all of whose points are periodic; of :func:`pwmap.dynamics`.

    ``parts`` are in the order of visits, from the leftmost on, with the ends that belong to them,
    ``word`` has the letters of their pieces. The ``multiplier`` is 1 if one round takes every point
    back; -1 if it turns the intervals about their middles, so that two rounds do.
    """

    parts: tuple[Part, ...]
    word: str
    multiplier: int

    def __len__(self) -> int:
        return len(self.parts)

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """The ends of each."""
        return tuple((low[0], high[0]) for low, high in self.parts)

    @property
    def region(self) -> PointSet:
        """The union of the intervals."""
        return point_set(self.parts)

    @property
    def period(self) -> int:
        """The period of all points but the middles of turned intervals, which have half of it."""
        return len(self.parts) * (1 if self.multiplier > 0 else 2)


def neutral_intervals(line: MapLine, orbits: Iterable[GermOrbit]) -> tuple[NeutralIntervals, ...]:
    """All neutral intervals in which orbits of germs end, from left to right."""
    if not line.breaks:
        return _of_one_piece(line)
    found = dict[Interval, NeutralIntervals]()
    for orbit in orbits:
        is_finite = orbit.fate is Fate.FINITE
        if is_finite and orbit.size == 1 and all(germ.side for germ in orbit.again):
            each = _around(line, orbit.again)
            found.setdefault(each.intervals[0], each)
    return tuple(sorted(found.values(), key=lambda each: each.intervals[0]))


def _around(line: MapLine, germs: tuple[Germ, ...]) -> NeutralIntervals:
    """The intervals whose points follow a cycle of germs of slope 1."""
    ahead, behind = (room(line, germs, way) for way in (1, -1))
    visited, letters, scale = list[Interval](), list[str](), QQ.one
    for germ in germs:
        far, back = germ.x + germ.side * scale * ahead, germ.x - germ.side * scale * behind
        part = (back, far) if germ.side > 0 else (far, back)
        if part in visited[:1]:
            break
        visited.append(part)
        letters.append(line.piece(germ).letter)
        scale = scale * abs(line.piece(germ).slope)
    first = min(range(len(visited)), key=visited.__getitem__)
    return NeutralIntervals(
        parts=_with_ends(line, visited[first:] + visited[:first], len(germs)),
        word="".join(letters[first:] + letters[:first]),
        multiplier=1 if len(germs) == len(visited) else -1,
    )


def room(line: MapLine, germs: Sequence[Germ], way: int) -> Exact:
    """How far from the first germ, on its side (1) or the other (-1), points follow all germs."""
    found, scale = HIGHEST, QQ.one
    for germ in germs:
        branch = line.piece(germ)
        end = branch.upper if way * germ.side > 0 else branch.lower
        found = min(found, abs(end - germ.x) / scale)
        scale = scale * abs(branch.slope)
    return found


def _with_ends(line: MapLine, intervals: Sequence[Interval], period: int) -> tuple[Part, ...]:
    """Intervals with those ends that follow the same pieces as the points beside them."""
    owned = set[tuple[int, int]]()  # numbers of intervals, and the side on which points beside lie
    for end, side in zip(intervals[0], (1, -1), strict=True):
        if isinstance(end, Infinite):
            continue
        around = [*islice(line.orbit(Germ(end, side)), period)]  # by the ends of all intervals
        if all(line.piece(Germ(each.x, 0)).letter == line.piece(each).letter for each in around):
            owned.update((k % len(intervals), each.side) for k, each in enumerate(around))
    return tuple(
        ((low, -1 if (k, 1) in owned else 1), (high, 1 if (k, -1) in owned else -1))
        for k, (low, high) in enumerate(intervals)
    )


def _of_one_piece(line: MapLine) -> tuple[NeutralIntervals, ...]:
    """The whole line, if the map is the identity or turns it."""
    (branch,) = line.branches
    if branch.slope == -1 or (branch.slope == 1 and not branch.intercept):
        parts, multiplier = (((LOWEST, 1), (HIGHEST, -1)),), -1 if branch.slope < 0 else 1
        return (NeutralIntervals(parts, branch.letter, multiplier),)
    return ()
