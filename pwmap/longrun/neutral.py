"""Neutral intervals: all points of an interval follow a word of slope 1 or -1 for ever.

A word of slope 1 that takes one point back takes back all points that follow it: they are periodic,
and neither attract nor repel. A word of slope -1 turns an interval about its middle, so that two
rounds take all points back. The largest such interval, or an image of it, reaches to a break; it is
found from a germ at a break that comes back with slope 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sympy import QQ

from pwmap.algebra.exact import HIGHEST, LOWEST, Infinite
from pwmap.algebra.numbers import Exact
from pwmap.longrun.fates import Fate, GermOrbit
from pwmap.longrun.line import Germ, Interval, MapLine
from pwmap.longrun.pointsets import Part, PointSet, point_set


@dataclass(frozen=True, slots=True, eq=False)
class NeutralIntervals:
    """Intervals that a map permutes, all of whose points are periodic; of :func:`pwmap.dynamics`.

    ``intervals`` has the ends of each in the order of visits, from the leftmost on, ``parts`` the
    same with the ends that belong to them, ``word`` the letters of their pieces. The ``multiplier``
    is 1 if one round takes every point back; -1 if it turns the intervals about their middles, so
    that two rounds do.
    """

    intervals: tuple[Interval, ...]
    parts: tuple[Part, ...]
    word: str
    multiplier: int

    def __len__(self) -> int:
        return len(self.intervals)

    @property
    def region(self) -> PointSet:
        """The union of the intervals."""
        return point_set(self.parts)

    @property
    def period(self) -> int:
        """The period of all points but the middles of turned intervals, which have half of it."""
        return len(self.intervals) * (1 if self.multiplier > 0 else 2)


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
    intervals = tuple(visited[first:] + visited[:first])
    return NeutralIntervals(
        intervals=intervals,
        parts=_with_ends(line, intervals, len(germs)),
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
        around = [Germ(end, side)]  # comes by the ends of all intervals
        while len(around) < period:
            around.append(line.image(around[-1]))
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
        return (NeutralIntervals(((LOWEST, HIGHEST),), parts, branch.letter, multiplier),)
    return ()
