"""Exact finite unions of intervals and points of the line, with or without their ends.

An end is a *cut*: just below (-1) or just above (+1) a number. An interval [a, b) lies between the
cuts just below a and just below b, a point between the two cuts beside it. So all parts are of one
kind, and cuts are compared as pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import sympy

from pwmap.algebra.exact import sign
from pwmap.algebra.numbers import Exact, exact_to_sympy
from pwmap.longrun.line import AffinePiece, Interval, MapLine, joined

Cut = tuple[Exact, int]  # a number, and -1 just below it or +1 just above it
Part = tuple[Cut, Cut]  # from a cut to a higher one


@dataclass(frozen=True, eq=False)
class PointSet:
    """A set of numbers."""

    parts: tuple[Part, ...] = ()  # apart, from left to right; two never have a cut in common

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __contains__(self, x: Exact) -> bool:
        return self.covers(((x, -1), (x, 1)))

    def covers(self, part: Part) -> bool:
        """Whether it contains an interval or a point."""
        return any(low <= part[0] and part[1] <= high for low, high in self.parts)

    def surrounds(self, x: Exact) -> bool:
        """Whether it contains all points close enough to a number, on both sides."""
        cuts = ((x, -1), (x, 1))
        return all(any(low < cut < high for low, high in self.parts) for cut in cuts)

    def has(self, other: PointSet) -> bool:
        """Whether it contains another set."""
        return all(map(self.covers, other.parts))

    def __or__(self, other: PointSet) -> PointSet:
        return point_set((*self.parts, *other.parts))

    @property
    def closure(self) -> PointSet:
        """The set with all ends."""
        return closed_intervals((low[0], high[0]) for low, high in self.parts)

    @property
    def interior(self) -> tuple[Interval, ...]:
        """The ends of its intervals, without its single points."""
        return tuple((low[0], high[0]) for low, high in self.parts if low[0] != high[0])

    def to_sympy(self) -> tuple[sympy.Set, ...]:
        """Its parts as intervals and points of sympy."""
        return tuple(map(part_to_sympy, self.parts))


def point_set(parts: Iterable[Part]) -> PointSet:
    """The union of intervals and points in any order."""
    return PointSet(tuple(joined(parts)))


def open_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of open intervals."""
    return point_set(((low, 1), (high, -1)) for low, high in intervals)


def closed_intervals(intervals: Iterable[Interval]) -> PointSet:
    """The union of closed intervals; both ends may be the same."""
    return point_set(((low, -1), (high, 1)) for low, high in intervals)


def preimage(line: MapLine, target: PointSet, breaks: Iterable[Exact]) -> PointSet:
    """All numbers that a map takes into a set; of the breaks, only the given ones are tried."""
    found = [part for branch in line.branches for part in _drawn_back(branch, target)]
    found += [((x, -1), (x, 1)) for x in breaks if line(x) in target]
    return point_set(found)


def _drawn_back(branch: AffinePiece, target: PointSet) -> Iterator[Part]:
    """The parts of a piece's open interval that it takes into a set."""
    whole: Part = ((branch.lower, 1), (branch.upper, -1))
    if not branch.slope:
        if branch.intercept in target:
            yield whole
        return
    way = sign(branch.slope)
    for part in target.parts:
        low, high = (((x - branch.intercept) / branch.slope, way * side) for x, side in part[::way])
        low, high = max(low, whole[0]), min(high, whole[1])
        if low < high:
            yield low, high


def part_to_sympy(part: Part) -> sympy.Set:
    """An interval or a point of sympy."""
    (low, after), (high, before) = part
    ends = exact_to_sympy(low), exact_to_sympy(high)
    return sympy.Interval(*ends, left_open=after > 0, right_open=before < 0)
