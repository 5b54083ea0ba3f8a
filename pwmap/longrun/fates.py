"""What becomes of germs: periodic after a while, drawn into a cycle, lost to infinity, or open."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from sympy import QQ

from pwmap.algebra.exact import HIGHEST, sign
from pwmap.longrun.line import IDENTITY, AffinePiece, Germ, Interval, MapLine
from pwmap.longrun.numbers import Exact, key, work_of
from pwmap.longrun.pointsets import PointSet, open_intervals
from pwmap.maps.budget import Meter

REPEATS = 3  # of a word, before its cycle is asked whether it draws the orbit in
STEP = 8  # operations of one step
LONGEST = 10_000  # work of one operation: numbers of an orbit may be some ten thousand bits long
FIRST = 16  # step at which that is asked for the first time; then at every power of two


class Fate(Enum):
    """What becomes of an orbit; the value says it in words."""

    FINITE = "periodic after a while"
    DRAWN = "drawn into a cycle"
    LOST = "lost to infinity"
    FLAT = "one with all points beside it, after a flat piece"
    OPEN = "not known"


@dataclass(frozen=True, eq=False)
class AttractingCycle:
    """A cycle to which all orbits close to it come, the core of an attractor.

    ``points`` are in the order of visits, from the smallest on, ``word`` has the letters of their
    pieces. ``multiplier`` is the product of the slopes, less than one in size; ``reach`` is how
    close to each point an orbit must come to be drawn in, and may be infinite. See
    :func:`pwmap.dynamics`.
    """

    points: tuple[Exact, ...]
    word: str
    multiplier: Exact
    reach: tuple[Exact, ...]

    @property
    def period(self) -> int:
        """How many points it has."""
        return len(self.points)

    def draws(self, x: Exact) -> bool:
        """Whether an orbit that comes to an exact number is known to be drawn in."""
        k = bisect_left(self.drawn_in, x, key=lambda each: each[1])
        return k < len(self.drawn_in) and bool(self.drawn_in[k][0] < x < self.drawn_in[k][1])

    @cached_property
    def drawn_in(self) -> tuple[Interval, ...]:
        """Open intervals within its reach, joined, from left to right."""
        return self.region.interior

    @property
    def region(self) -> PointSet:
        """All that is known to be drawn in at once."""
        reach = zip(self.points, self.reach, strict=True)
        return open_intervals((x - near, x + near) for x, near in reach)


@dataclass(frozen=True, slots=True, eq=False)
class GermOrbit:
    """A germ's orbit, as far as it was followed."""

    germs: tuple[Germ, ...]  # itself and its images, each once
    letters: tuple[str, ...]  # of the pieces by which they are mapped
    fate: Fate
    start: int = -1  # if it is finite, the number of the first germ that comes again
    cycle: AttractingCycle | None = None  # what draws it in

    @property
    def period(self) -> int:
        """If it is finite, of what it ends in."""
        return len(self.germs) - self.start

    def kneading(self) -> str:
        """The letters, with those that come again and again in brackets; open ends with dots."""
        word = "".join(self.letters)
        if self.fate is Fate.FINITE:
            return f"{word[: self.start]}({word[self.start :]})"
        return f"{word}..."


class Fates:
    """Follows orbits, and keeps the attracting cycles that it meets."""

    def __init__(self, line: MapLine, steps: int, meter: Meter) -> None:
        self.line, self.steps, self.meter = line, steps, meter
        self.lost_below, self.lost_above = escapes(line)
        self.cycles = list[AttractingCycle]()

    def is_lost(self, x: Exact) -> bool:
        """Whether the orbit of a point is known to tend to infinity."""
        return bool(x < self.lost_below or x > self.lost_above)

    def orbit(self, germ: Germ) -> GermOrbit:
        """The orbit of a germ until its fate is known."""
        seen, germs, letters = dict[Hashable, int](), list[Germ](), list[str]()
        for step in range(self.steps):
            work = work_of(germ.x)
            self.meter.spend(STEP + 3 * work)
            if work > LONGEST:
                break
            place = key(germ.x), germ.side
            if place in seen:
                self._kept(self._cycle_at(germ, step - seen[place]))
                return GermOrbit(tuple(germs), tuple(letters), Fate.FINITE, seen[place])
            if self.is_lost(germ.x):
                return GermOrbit(tuple(germs), tuple(letters), Fate.LOST)
            drawn = next((each for each in self.cycles if each.draws(germ.x)), None)
            if drawn is None and step >= FIRST and not step & (step - 1):
                drawn = self._drawn(germ, letters)
            if drawn is not None and germ.x not in drawn.points:
                return GermOrbit(tuple(germs), tuple(letters), Fate.DRAWN, cycle=drawn)
            seen[place] = step
            germs.append(germ)
            piece = self.line.piece(germ)
            germ = piece.image(germ)
            letters.append(piece.letter)
        return GermOrbit(tuple(germs), tuple(letters), Fate.OPEN)

    def _kept(self, cycle: AttractingCycle | None) -> AttractingCycle | None:
        if cycle is not None and all(cycle.points != each.points for each in self.cycles):
            self.cycles.append(cycle)
        return cycle

    def _drawn(self, germ: Germ, letters: list[str]) -> AttractingCycle | None:
        """The cycle that an orbit has begun to follow, if it draws it in."""
        tried = list[list[str]]()
        for period in range(1, len(letters) // REPEATS + 1):
            word = letters[-period:]
            if letters[-REPEATS * period :] != word * REPEATS:
                continue
            if any(each * (period // len(each)) == word for each in tried):
                continue  # several rounds of a cycle that was asked
            tried.append(word)
            cycle = self._cycle_at(germ, period)
            if cycle is not None and cycle.draws(germ.x):
                return self._kept(cycle)
        return None

    def _cycle_at(self, germ: Germ, period: int) -> AttractingCycle | None:
        """The attracting cycle whose pieces a germ visits."""
        whole, here = IDENTITY, germ
        for _ in range(period):
            if not here.side and here.x in self.line.breaks:
                return None
            branch = self.line.piece(here)
            whole = branch.after(whole)
            here = self.line.image(here)
        if not abs(whole.slope) < 1:
            return None
        return self.attracting(whole.fixed_point, period)

    def attracting(self, x: Exact, period: int) -> AttractingCycle | None:
        """The attracting cycle of a point; None if it has none, or a jump of it is in the way."""
        points, slopes, word = list[Exact](), list[Exact](), list[str]()
        for _ in range(period):
            if x in self.line.breaks:
                return None
            branch = self.line.piece(Germ(x, 0))
            points.append(x)
            slopes.append(branch.slope)
            word.append(branch.letter)
            x = branch(x)
            if x == points[0]:
                break
        if x != points[0]:
            return None
        first = points.index(min(points))
        points, slopes, word = (each[first:] + each[:first] for each in (points, slopes, word))
        multiplier = QQ.one
        for each in slopes:
            multiplier = multiplier * each
        if not abs(multiplier) < 1:  # the word was that of pieces in which the point does not lie
            return None
        reach = self._reach(points, slopes)
        return AttractingCycle(tuple(points), "".join(word), multiplier, reach)

    def _reach(self, points: Sequence[Exact], slopes: Sequence[Exact]) -> tuple[Exact, ...]:
        """How close to each point of a cycle orbits follow it once round."""
        away = [min((abs(x - at) for at in self.line.breaks), default=HIGHEST) for x in points]
        found, after = list[Exact](away), HIGHEST
        # twice: the second turn needs less than the first, by the multiplier
        for k in [*reversed(range(len(points)))] * 2:
            near = after / abs(slopes[k]) if slopes[k] else HIGHEST
            after = found[k] = min(away[k], near)
        return tuple(found)


def escapes(line: MapLine) -> Interval:
    """Ends beyond which orbits tend to infinity, below and above; infinite where they do not."""
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
    """Beyond which point of an outer piece that rises orbits run away on its own side."""
    end = branch.upper if side < 0 else branch.lower
    if branch.slope > 1:
        return (min if side < 0 else max)(branch.intercept / (1 - branch.slope), end)
    if branch.slope == 1 and side * sign(branch.intercept) > 0:
        return end
    return side * HIGHEST


def _swapped(left: AffinePiece, right: AffinePiece) -> Interval:
    """The ends where two falling pieces map what lies beyond to each other's side."""
    slope = left.slope * right.slope
    low = (right.slope * left.intercept + right.intercept) / (1 - slope)
    # from a 2-cycle of both pieces or, if it is not in them, where both images are
    low = min(low, left.upper, (right.lower - left.intercept) / left.slope)
    high = left(low)
    return low, max(high, right.lower)
