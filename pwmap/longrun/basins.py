"""Basins of attractors: the immediate basin, and all of its preimages.

The immediate basin consists of the largest intervals around an attractor in which all orbits, but
for those that end in a repelling cycle, converge to it. Each interval is extended as long as points
beside it are mapped into known intervals; on a steep increasing piece such extensions converge to a
repelling fixed point, which is taken at once. The whole basin is the exact set of all preimages, as
intervals and single points. It is complete if it contains its own preimage. Points that converge to
an end of bands or neutral intervals without entering these are included from the start.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from math import prod

import sympy
from sympy import QQ

from pwmap.algebra.exact import Infinite
from pwmap.algebra.numbers import Exact
from pwmap.longrun.fates import followers
from pwmap.longrun.line import (
    AffinePiece,
    Germ,
    Interval,
    MapLine,
    Part,
    PointSet,
    closed_intervals,
    drawn_back,
    iterates,
    open_intervals,
    point_set,
    preimage,
    union,
)
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

ROUNDS = 40  # of extending all intervals on both sides, and of taking preimages, at most
PARTS = 64  # of a whole basin, at most
SHOWN = 4  # parts that its text lists
STEPS = 100  # of the orbit of a break, at most
MAX_ORDER_INTERVALS = 16  # intervals up to which the order of the iterates grows with their number
PREIMAGE_ORDER = 4  # order of the iterates tried beside an end of a preimage, at most
LONGEST = 60  # work of one operation with an end: ends of longer numbers are not extended
STEP = 20  # operations of one step of an iterate, tests included


@dataclass(frozen=True, slots=True, eq=False)
class WholeBasin:
    """The points known to converge to an attractor, up to a set of measure zero.

    The exceptions end in a repelling cycle, or at a break whose value leads elsewhere. If the basin
    is ``complete``, the ``region`` contains its preimage and no other point is attracted.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> text = "Piecewise((x/2, x < 1), (x + 1, x < 10), (-1, True))"
    >>> (cycle,) = dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
    >>> cycle.basin, cycle.basin_is_complete
    ((Interval.open(-oo, 1),), False)
    >>> cycle.whole_basin, cycle.whole_basin.complete
    (WholeBasin(Interval(-oo, oo)), True)
    """

    region: PointSet
    complete: bool

    def __repr__(self) -> str:
        """The first few parts, the number of others, and whether the basin is complete."""
        shown = ", ".join(map(str, PointSet(self.region.parts[:SHOWN]).to_sympy()))
        more = len(self.region.parts) - SHOWN
        rest = f" and {more} more" if more > 0 else ""
        return f"WholeBasin({shown}{rest}{'' if self.complete else ', not complete'})"

    @property
    def parts(self) -> tuple[sympy.Set, ...]:
        """The region as intervals and points of sympy, from left to right."""
        return self.region.to_sympy()


def whole_basin(
    line: MapLine, core: PointSet, immediate: Sequence[Interval], meter: Meter
) -> WholeBasin:
    """The basin of an attractor: all preimages of its core and of its open immediate basin."""
    found = [core | open_intervals(immediate)]
    complete = False
    with meter.keeping(found):
        comes = {x: _converges(line, core, x, meter) for x in line.breaks}
        settled = [x for x in line.breaks if comes[x] is not False]
        for _ in meter.each(range(ROUNDS), "rounds"):
            known = found[-1]
            meter.spend(len(line.branches) * sum(map(_work, known.parts)))
            longer = known | preimage(line, known, settled)
            if known.has(longer):
                isolated = (x for x in line.breaks if x in known and not known.surrounds(x))
                complete = all(comes[x] for x in isolated)
                break
            found.append(_with_more(line, known, longer, meter))
            if len(found[-1].parts) > PARTS:
                break
    return WholeBasin(found[-1], complete)


def _with_more(line: MapLine, known: PointSet, longer: PointSet, meter: Meter) -> PointSet:
    """The longer set, extended beyond each new end by points that an iterate maps into it."""
    before = {end for pair in known.interior for end in pair}
    intervals = longer.interior
    return longer | open_intervals(
        _extended(line, intervals, k, side, PREIMAGE_ORDER, meter)
        for k, pair in enumerate(intervals)
        for side, end in zip((-1, 1), pair, strict=True)
        if end not in before
    )


def _work(part: Part) -> int:
    return STEP + 3 * sum(work_of(x) for x, _ in part)


def invariant_closure(line: MapLine, intervals: Sequence[Interval]) -> PointSet:
    """Closed intervals that are mapped into themselves, without endpoints whose orbits leave."""
    whole = closed_intervals(intervals)
    ends = [x for interval in intervals for x in interval]
    kept = dict.fromkeys(ends, True)
    for _ in ends:
        for x in ends:
            value = line(x)
            kept[x] = kept[x] and kept.get(value, value in whole)
    return point_set(
        ((low, -1 if kept[low] else 1), (high, 1 if kept[high] else -1)) for low, high in intervals
    )


def attracted_from_outside(line: MapLine, core: PointSet) -> PointSet:
    """Points outside of permuted intervals that converge to their ends without entering them.

    There the outer germ at an end returns to itself, through outer germs of other ends, with a
    product of slopes below 1 in size. So all points converge that follow it for one round.
    """
    images = {
        germ: line.image(germ)
        for ends in core.closure.interior
        for germ in map(Germ, ends, (-1, 1))
        if not isinstance(germ.x, Infinite)
    }
    found = list[Interval]()
    while images:
        germ, way = next(iter(images)), list[Germ]()
        while germ in images:
            way.append(germ)
            germ = images.pop(germ)
        turn = way[way.index(germ) :] if germ in way else []
        if prod((abs(line.piece(each).slope) for each in turn), start=QQ.one) < 1:
            found += followers(line, turn)
    return open_intervals(found)


def _converges(line: MapLine, core: PointSet, x: Exact, meter: Meter) -> bool | None:
    """Whether the orbit of a point converges to an attractor; None if that is not known."""
    leaving = any(y in core and line(y) not in core for y in line.breaks)
    seen = list[Exact]()
    for y, _ in islice(line.orbit(Germ(x, 0)), STEPS):
        meter.spend(STEP + 3 * work_of(y))
        if y in seen:
            return all(each in core for each in seen[seen.index(y) :])
        if y in core and not leaving:
            return True
        seen.append(y)
    return None


def basin_of(line: MapLine, start: Sequence[Interval], meter: Meter) -> tuple[Interval, ...]:
    """The immediate basin, grown from intervals that are mapped into themselves."""
    known = list(start)
    with meter.keeping(known):
        for _ in meter.each(range(ROUNDS), "rounds"):
            before = list(known)
            # so that each of the 2 n ends may return twice: a map that exchanges the sides of a
            # repelling point returns to the first side only the second time
            orders = 4 * min(len(known), MAX_ORDER_INTERVALS)
            for k in range(len(known)):
                for side in (-1, 1):
                    known[k] = _extended(line, known, k, side, orders, meter)
            known[:] = union(known)
            if known == before:
                break
    return tuple(union(known))


def _extended(
    line: MapLine, known: Sequence[Interval], k: int, side: int, orders: int, meter: Meter
) -> Interval:
    """A known interval, extended by the points beside it that an iterate maps into known ones."""
    end = best = known[k][side > 0]
    if isinstance(end, Infinite) or work_of(end) > LONGEST:
        return known[k]
    target = open_intervals(known)
    for piece in iterates(_visited(line, Germ(end, side), orders, meter)):
        piece = piece._replace(**{"lower" if side > 0 else "upper": end})
        best = (max if side > 0 else min)(best, _extended_end(piece, target, side))
        if isinstance(best, Infinite):
            break
    return (known[k][0], best) if side > 0 else (best, known[k][1])


def _extended_end(piece: AffinePiece, known: PointSet, side: int) -> Exact:
    """The place up to which a piece maps all points from its end on into known intervals."""
    end, limit = (piece.lower, piece.upper)[::side]
    drawn = (part[::side] for part in drawn_back(piece, known))
    far = next((last[0] for first, last in drawn if first == (end, side)), end)
    if far != end and piece.slope > 0 and piece(far) == end:
        # points beyond come closer to the end, and so into this part at last, up to a fixed point
        rest = 1 - piece.slope
        return limit if rest >= 0 else (min if side > 0 else max)(piece.intercept / rest, limit)
    return far


def _visited(line: MapLine, start: Germ, orders: int, meter: Meter) -> Iterator[AffinePiece]:
    """Yield the pieces that the orbit of a germ visits, up to a flat one."""
    for germ in islice(line.orbit(start), orders):
        meter.spend(STEP + 3 * work_of(germ.x))
        yield line.piece(germ)
        if not line.piece(germ).slope:
            return
