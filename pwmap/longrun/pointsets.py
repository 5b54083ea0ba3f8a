"""Sets made of finitely many intervals and points of the line, exactly, with or without their ends.

An end is a *cut*: a place between a number and what lies beside it, just below it (-1) or just
above it (+1). An interval lies between two cuts, [a, b) between those just below a and just below
b, and a point between the two cuts beside it. So there is one kind of part, and cuts are compared
as pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import sympy

from pwmap.longrun.line import AffinePiece, MapLine
from pwmap.longrun.numbers import Exact, exact_to_sympy, sign

Cut = tuple[Exact, int]  # a number, and -1 just below it or +1 just above it
Part = tuple[Cut | None, Cut | None]  # from a cut to a higher one; None is infinite


@dataclass(frozen=True, eq=False)
class PointSet:
    """A set of numbers.

    Attributes
    ----------
    parts
        Apart, from left to right; two parts never have a cut in common.
    """

    parts: tuple[Part, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __contains__(self, x: Exact) -> bool:
        return self.covers(((x, -1), (x, 1)))

    def covers(self, part: Part) -> bool:
        """Whether an interval or a point lies in it."""
        return any(
            _first_is_lower(low, part[0]) and _last_is_higher(high, part[1])
            for low, high in self.parts
        )

    def surrounds(self, x: Exact) -> bool:
        """Whether all that lies close to a number lies in it, on both sides."""
        return all(
            any(
                (low is None or low < cut) and (high is None or cut < high)
                for low, high in self.parts
            )
            for cut in ((x, -1), (x, 1))
        )

    def has(self, other: PointSet) -> bool:
        """Whether another set lies in it."""
        return all(map(self.covers, other.parts))

    def __or__(self, other: PointSet) -> PointSet:
        return point_set((*self.parts, *other.parts))

    def __and__(self, other: PointSet) -> PointSet:
        return PointSet(tuple(
            met for one in self.parts for two in other.parts
            if (met := _met(one, two)) is not None
        ))  # fmt: skip

    @property
    def closure(self) -> PointSet:
        """The same with all ends."""
        return point_set(
            (None if low is None else (low[0], -1), None if high is None else (high[0], 1))
            for low, high in self.parts
        )

    @property
    def interior(self) -> tuple[tuple[Exact | None, Exact | None], ...]:
        """The ends of its intervals, without its points; None is infinite."""
        return tuple(
            (None if low is None else low[0], None if high is None else high[0])
            for low, high in self.parts
            if low is None or high is None or low[0] != high[0]
        )

    def to_sympy(self) -> tuple[sympy.Set, ...]:
        """Its parts as intervals and points of sympy."""
        return tuple(map(part_to_sympy, self.parts))


def point_set(parts: Iterable[Part]) -> PointSet:
    """The union of intervals and points in any order."""
    found = list[Part]()
    for low, high in sorted(parts, key=lambda part: (part[0] is not None, part[0])):
        if found and (found[-1][1] is None or (low is not None and low > found[-1][1])):
            if found[-1][1] is None:
                break
            found.append((low, high))
        elif found:
            start, last = found[-1]
            found[-1] = start, high if _last_is_higher(high, last) else last
        else:
            found.append((low, high))
    return PointSet(tuple(found))


def open_intervals(intervals: Iterable[tuple[Exact | None, Exact | None]]) -> PointSet:
    """The union of open intervals; an end that is None is infinite."""
    return point_set(
        (None if low is None else (low, 1), None if high is None else (high, -1))
        for low, high in intervals
    )


def closed_intervals(intervals: Iterable[tuple[Exact, Exact]]) -> PointSet:
    """The union of closed intervals; both ends may be the same."""
    return point_set(((low, -1), (high, 1)) for low, high in intervals)


def preimage(line: MapLine, target: PointSet, breaks: Iterable[Exact]) -> PointSet:
    """All numbers that a map takes into a set; of breaks only such as are given."""
    found = [part for branch in line.branches for part in _drawn_back(branch, target)]
    found += [((x, -1), (x, 1)) for x in breaks if line(x) in target]
    return point_set(found)


def _drawn_back(branch: AffinePiece, target: PointSet) -> Iterator[Part]:
    """What a piece on its open interval takes into a set."""
    whole: Part = (
        None if branch.lower is None else (branch.lower, 1),
        None if branch.upper is None else (branch.upper, -1),
    )
    if not branch.slope:
        if branch.intercept in target:
            yield whole
        return
    way = sign(branch.slope)
    for part in target.parts:
        ends = [
            None if cut is None else ((cut[0] - branch.intercept) / branch.slope, way * cut[1])
            for cut in part
        ]
        met = _met((ends[0], ends[1]) if way > 0 else (ends[1], ends[0]), whole)
        if met is not None:
            yield met


def _met(one: Part, other: Part) -> Part | None:
    """What two parts have in common; None if nothing."""
    low = other[0] if _first_is_lower(one[0], other[0]) else one[0]
    high = other[1] if _last_is_higher(one[1], other[1]) else one[1]
    return (low, high) if low is None or high is None or low < high else None


def _first_is_lower(low: Cut | None, other: Cut | None) -> bool:
    """Whether one lower end is not above another."""
    return low is None or (other is not None and low <= other)


def _last_is_higher(high: Cut | None, other: Cut | None) -> bool:
    """Whether one upper end is not below another."""
    return high is None or (other is not None and other <= high)


def part_to_sympy(part: Part) -> sympy.Set:
    """An interval or a point of sympy."""
    low, high = part
    start = -sympy.oo if low is None else exact_to_sympy(low[0])
    end = sympy.oo if high is None else exact_to_sympy(high[0])
    if start == end:
        return sympy.FiniteSet(start)
    return sympy.Interval(
        start, end, left_open=low is None or low[1] > 0, right_open=high is None or high[1] < 0
    )
