"""Immediate basins: the intervals around an attractor from which nothing leaves it.

The immediate basin of an attractor is made of the largest intervals around its points, or bands,
in which all orbits come to it, but for those that end in a repelling cycle inside. They are found
from inside: an interval is extended as far as what lies beside it is mapped into the intervals that
are known. Where a piece rises and is steep that leads to its repelling fixed point in infinitely
many ever smaller steps; so the fixed point is taken at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import QQ

from pwmap.longrun.line import Germ, Interval, Line
from pwmap.longrun.numbers import Exact

ROUNDS = 40  # of extending all intervals on both sides
MOST = 16  # intervals of which iterates are looked at until all have come back
End = Exact | None


@dataclass(frozen=True, slots=True, eq=False)
class Basin:
    """The immediate basin of an attractor.

    Attributes
    ----------
    intervals
        Open, from left to right; an end that is None is infinite.
    complete
        Whether it is complete; if not, these are parts of it.
    """

    intervals: tuple[tuple[End, End], ...]
    complete: bool

    def holds(self, x: Exact) -> bool:
        """Whether a point lies in it."""
        return any(
            (low is None or low < x) and (high is None or x < high) for low, high in self.intervals
        )

    def within(self, window: Interval) -> list[Interval]:
        """The parts inside a window."""
        low, high = window
        parts = [
            (low if a is None else max(a, low), high if b is None else min(b, high))
            for a, b in self.intervals
        ]
        return [(a, b) for a, b in parts if a < b]


def basin_of(line: Line, start: Sequence[Interval]) -> Basin:
    """The immediate basin of an attractor.

    Parameters
    ----------
    line
        The map.
    start
        Intervals that hold the attractor, and that are mapped into themselves: its bands, or what
        its points are known to draw in.
    """
    known: list[tuple[End, End]] = [*sorted(start, key=lambda each: each[0])]
    for _ in range(ROUNDS):
        before = list(known)
        for k in range(len(known)):
            for side in (-1, 1):
                known[k] = _extended(line, known, k, side)
        known = _joined(known)
        if known == before:
            return Basin(tuple(known), True)
    return Basin(tuple(known), False)


def _extended(line: Line, known: Sequence[tuple[End, End]], k: int, side: int) -> tuple[End, End]:
    """An interval with what lies beside it, on one piece of the map, and is mapped into the known.

    Iterates are looked at until all ends may have come back, twice: what is mapped to the other
    side of a repelling point comes back the second time.
    """
    end = known[k][side > 0]
    if end is None:
        return known[k]
    best = end
    for rounds in range(1, 4 * min(len(known), MOST) + 1):
        found = _reach(line, known, end, side, rounds)
        if found is None or (side > 0 and found > best) or (side < 0 and found < best):
            best = found
            if best is None:
                break
    return (known[k][0], best) if side > 0 else (best, known[k][1])


def _reach(line: Line, known: Sequence[tuple[End, End]], end: Exact, side: int, rounds: int) -> End:
    """How far beside an end points are mapped into known intervals, or ever farther from its image.

    The end itself if none is.
    """
    slope, intercept, limit = _pieces(line, end, side, rounds)
    image = slope * end + intercept
    if slope == 0:
        return limit if _holder(known, image, 0) is not None else end
    way = side if slope > 0 else -side
    number = _holder(known, image, way)
    if number is None:
        return end
    target = known[number][way > 0]
    if target is None:
        return limit
    if slope > 0 and target == end:  # points beside the end come closer to it, and are inside then
        if image == end:
            return limit if slope < 1 else end
        fixed = intercept / (1 - slope) if slope > 1 else None
        return limit if fixed is None else _nearer(fixed, limit, side)
    found = (target - intercept) / slope
    return _nearer(found, limit, side) if (found - end) * side > 0 else end


def _nearer(x: Exact, limit: End, side: int) -> Exact:
    if limit is None:
        return x
    return min(x, limit) if side > 0 else max(x, limit)


def _pieces(line: Line, end: Exact, side: int, rounds: int) -> tuple[Exact, Exact, End]:
    """Slope, intercept and farthest end of the affine piece of an iterate beside a point."""
    slope, intercept, limit = QQ.one, QQ.zero, None
    germ = Germ(end, side)
    for _ in range(rounds):
        if not slope:
            break
        branch = line.beside(germ)
        stop = branch.upper if germ.side > 0 else branch.lower
        if stop is not None:
            limit = _nearer((stop - intercept) / slope, limit, side)
        slope, intercept = branch.slope * slope, branch.slope * intercept + branch.intercept
        germ = line.image(germ)
    return slope, intercept, limit


def _holder(known: Sequence[tuple[End, End]], x: Exact, way: int) -> int | None:
    """The known interval that holds what lies beside a point on a side of it."""
    for k, (low, high) in enumerate(known):
        over = low is None or low < x or (low == x and way > 0)
        under = high is None or x < high or (high == x and way < 0)
        if over and under:
            return k
    return None


def _joined(intervals: Sequence[tuple[End, End]]) -> list[tuple[End, End]]:
    """The same set as intervals apart, but for points at which they touch."""
    found = list[tuple[End, End]]()
    for low, high in intervals:
        if found and (low is None or found[-1][1] is None or low <= found[-1][1]):
            last = found[-1][1]
            found[-1] = found[-1][0], None if high is None or last is None else max(last, high)
        else:
            found.append((low, high))
    return found
