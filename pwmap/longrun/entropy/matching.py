"""Matching orbits of the two sides of a break, and the growth of laps where almost all match.

Both orbits *match* if after equally many steps they are at the same point, with slopes of the same
sign. From there on they cancel in the kneading determinant D. Parameter intervals on which orbits
match may accumulate at values where they never do, and yet the growth can be the same [Bruin2019].
This module proves it for all values in an interval G of the parameter.

Let the slopes be constant, and intercepts and breaks affine in the parameter. Each step moves one
of the two orbits: the one with the smaller slope or, if these are equal, the one that is behind. If
the left orbit is at x, the right one is at ratio x + offset; a *pair* is this relation with the lag
between the orbits. If G admits finitely many pairs, D follows a path in a finite graph: let R_v be
the rest of D from the pair v on; then each step from v to u says R_v = w +- t^n R_u with a known w,
and R is 0 once the orbits have matched.

Along a shortest path to a match R_v is a polynomial h_v. Let p be the minimal polynomial of the
least root in (0, 1) of D on such a path. If w +- t^n h_u - h_v is a multiple of p for *every* step,
then so is R_v - h_v on every path, and so is D = p Q, where Q follows the same graph with other
terms. The graph also bounds Q. If Q has no zero up to the root of p, then that is the least root of
D on every path, and the growth is one over it on all of G.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import Number, dense, is_constant, sign
from pwmap.algebra.numbers import IV, enclosure
from pwmap.algebra.roots import Real, RealRoot, bounds
from pwmap.longrun.entropy.kneading import RING, T, growth_from
from pwmap.longrun.fates import Fate, GermOrbit
from pwmap.longrun.line import Germ, MapLine, line_at
from pwmap.maps.budget import Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import work_of

STEP = 10  # operations of one step
PAIRS = 200  # nodes of a graph, at most
CHANGES = 30  # enlargements of the region of a pair, at most: it may grow for ever
ROUNDS = 40  # of improving the bounds of Q along all edges
PARTS = 16  # subintervals up to the root that are tried for these bounds, at most

MapFamily = tuple[MapLine, MapLine]  # the map at both ends of G; slopes are equal and not zero
Ends = tuple[Number, Number]  # an affine function of the parameter, by its values at both ends of G
Region = tuple[Ends, Ends]  # lower and upper bound of the left orbit of a pair


def matched(
    line: MapLine, number: int, steps: int, meter: Meter
) -> tuple[GermOrbit, GermOrbit] | None:
    """The itineraries of the two sides of a break until they match; None if they do not."""
    left, right = line.germs[2 * number : 2 * number + 2]
    pairs = list[tuple[Germ, Germ]]()
    for _ in range(steps):
        meter.spend(sum(STEP + 3 * work_of(germ.x) for germ in (left, right)))
        pairs.append((left, right))
        left, right = line.image(left), line.image(right)
        if not left.side or not right.side:
            return None
        if left == Germ(right.x, -right.side):
            one, other = (
                GermOrbit(line, germs, Fate.MATCHED, len(germs))
                for germs in zip(*pairs, strict=True)
            )
            return one, other
    return None


def family_of(map_: PiecewiseLinearMap, low: Number, high: Number) -> MapFamily | None:
    """The map at both ends of G; None unless slopes are constant, not 0, and the rest is affine."""
    table, layout = map_.definition.table, map_.layout
    slopes = [table.slopes[k] for k in layout.between]
    affine = [table.intercepts[k] for k in layout.between]
    affine += [table.breaks[k] for k in layout.breaks]
    if not all(map(is_constant, (*slopes, table.denominator))) or not all(slopes):
        return None
    if any(len(dense(each)) > 2 for each in affine):
        return None
    return line_at(map_, low, admitted=False), line_at(map_, high, admitted=False)


def _moved(family: MapFamily, piece: int, x: Ends) -> Ends:
    """The image of an affine function of the parameter by the formula of a piece."""
    low, high = (line.branches[piece](end) for line, end in zip(family, x, strict=True))
    return low, high


class Pair(NamedTuple):
    """A relation of the two orbits: the left one is at x, the right one at ratio x + offset."""

    ratio: Number  # of the right slope to the left one, too
    offset: Ends
    lag: int  # how many steps the left orbit is ahead

    @property
    def left_is_next(self) -> bool:
        """Whether the left orbit moves next."""
        return abs(self.ratio) > 1 or (abs(self.ratio) == 1 and self.lag <= 0)


MATCHED_PAIR = Pair(QQ.one, (QQ.zero, QQ.zero), 0)  # at the break itself, and where orbits match


class PairEdge(NamedTuple):
    """An edge of the graph: the rest R of the determinant is term + factor * (R of ``onward``)."""

    term: PolyElement
    factor: PolyElement
    onward: Pair


def _step(
    family: MapFamily, weights: Sequence[PolyElement], pair: Pair, piece: int, *, left: bool
) -> PairEdge:
    """The edge on which a piece moves the left or right orbit; R is right minus left series."""
    slope = family[0].branches[piece].slope
    ratio, offset, lag = pair
    # R counts powers of t from the orbit that is behind, and signs from the left slope
    ahead, behind = max(lag, 0), max(-lag, 0)
    if left:
        ratio = ratio / slope
        a, b = _moved(family, piece, (QQ.zero, QQ.zero))
        onward = Pair(ratio, (offset[0] - ratio * a, offset[1] - ratio * b), lag + 1)
        factor = sign(slope) * T ** min(ahead + 1, behind)
        return PairEdge(-weights[piece] * T**ahead, factor, onward)
    onward = Pair(ratio * slope, _moved(family, piece, offset), lag - 1)
    term = sign(ratio) * weights[piece] * T**behind
    return PairEdge(term, T ** min(ahead, behind + 1), onward)


def _joined(one: Region, other: Region) -> Region:
    """The smallest region that contains both."""
    low, high = zip(one[0], other[0], strict=True), zip(one[1], other[1], strict=True)
    (a, b), (c, d) = map(min, low), map(max, high)
    return (a, b), (c, d)


def _between(region: Region, low: Ends | None, high: Ends | None) -> Region | None:
    """A region that covers the part of a region between two bounds; None if that is empty."""
    lows = [region[0]] if low is None else [low, region[0]]
    highs = [region[1]] if high is None else [high, region[1]]
    if any(a[0] > b[0] and a[1] > b[1] for a in lows for b in highs):
        return None
    # of two bounds that cross within G the new one is taken, so that few different ones arise
    least = next(a for a in lows if a is region[0] or not _at_most(a, region[0]))
    most = next(a for a in highs if a is region[1] or not _at_most(region[1], a))
    return least, most


def _at_most(one: Ends, other: Ends) -> bool:
    """Whether one bound is not above another on all of G."""
    return bool(one[0] <= other[0] and one[1] <= other[1])


def _graph(
    family: MapFamily, weights: Sequence[PolyElement], number: int, first: Pair, meter: Meter
) -> Mapping[Pair, Sequence[PairEdge]] | None:
    """The edges from all pairs that are reached from the first one; None if these are too many."""
    low, high = (line.breaks[number] for line in family)
    start = _moved(family, number, (low, high))
    # each region covers all points that orbits may reach, so that no edge is missed
    regions: dict[Pair, Region] = {first: (start, start)}
    found, changes, waiting = dict[Pair, list[PairEdge]](), Counter[Pair](), deque([first])
    while waiting:
        pair = waiting.popleft()
        found[pair] = []
        if pair[:2] == MATCHED_PAIR[:2]:
            if pair.lag:  # then R is not 0, but 1 - t^|lag| times the series of the point
                return None
            continue
        for piece, region in _regions(family, pair, regions[pair], meter):
            step = _step(family, weights, pair, piece, left=pair.left_is_next)
            found[pair].append(step)
            known = regions.get(step.onward)
            joined = region if known is None else _joined(region, known)
            if joined != known:
                regions[step.onward] = joined
                changes[step.onward] += 1
                if step.onward not in waiting:
                    waiting.append(step.onward)
        if len(regions) > PAIRS or changes[pair] > CHANGES:
            return None
    return found


def _regions(
    family: MapFamily, pair: Pair, region: Region, meter: Meter
) -> Iterator[tuple[int, Region]]:
    """Yield the pieces that may move a pair, with the region of the left orbit afterwards."""
    ratio, offset, _ = MATCHED_PAIR if pair.left_is_next else pair  # that of the orbit that moves
    breaks = zip(*(line.breaks for line in family), strict=True)
    cuts = [((a - offset[0]) / ratio, (b - offset[1]) / ratio) for a, b in breaks]
    for piece, branch in enumerate(family[0].branches):
        meter.spend(STEP + 3 * sum(work_of(x) for ends in region for x in ends))
        sides = cuts[piece - 1] if piece else None, cuts[piece] if piece < len(cuts) else None
        inside = _between(region, *(sides if ratio > 0 else sides[::-1]))
        if inside is not None and pair.left_is_next:
            low, high = (_moved(family, piece, end) for end in inside[:: sign(branch.slope)])
            inside = low, high
        if inside is not None:
            yield piece, inside


def growth_of_pairs(
    family: MapFamily, number: int, weights: Sequence[PolyElement], meter: Meter
) -> Real | None:
    """The growth of laps, above 1, if it is proved to be constant on all of G; otherwise None."""
    one = _step(family, weights, MATCHED_PAIR, number, left=True)
    other = _step(family, weights, one.onward, number + 1, left=False)
    start = PairEdge(one.term + one.factor * other.term, one.factor * other.factor, other.onward)
    steps = _graph(family, weights, number, start.onward, meter)
    return None if steps is None else _growth(start, steps, meter)


def _growth(start: PairEdge, steps: Mapping[Pair, Sequence[PairEdge]], meter: Meter) -> Real | None:
    """One over the determinant's least root if all paths have the same one; otherwise None."""
    rests = _matching(steps)
    if not steps.keys() <= rests.keys():
        return None
    found = start.term + start.factor * rests[start.onward]
    growth = growth_from(found)
    if growth is None or growth == 1:
        return None
    of_growth = growth.polynomial if isinstance(growth, RealRoot) else (QQ.one, -growth)
    divisor = sum((c * T**k for k, c in enumerate(of_growth)), start=RING.zero)
    quotients = dict[Pair, list[PairEdge]]()
    for pair, each in steps.items():
        quotients[pair] = []
        for step in each:
            difference = step.term + step.factor * rests[step.onward] - rests[pair]
            term, left_over = difference.div(divisor)
            if left_over:
                return None
            quotients[pair].append(step._replace(term=term))
    start = start._replace(term=found.quo(divisor))
    return growth if _has_no_root(start, quotients, 1 / bounds(growth)[0], meter) else None


def _matching(steps: Mapping[Pair, Sequence[PairEdge]]) -> dict[Pair, PolyElement]:
    """The polynomial h of each pair: the rest R along a shortest path to a match."""
    found = {MATCHED_PAIR: RING.zero}
    while True:
        more = {
            pair: step.term + step.factor * found[step.onward]
            for pair, each in steps.items() if pair not in found
            for step in each if step.onward in found
        }  # fmt: skip
        if not more:
            return found
        found |= more


def _has_no_root(
    start: PairEdge, steps: Mapping[Pair, Sequence[PairEdge]], end: Number, meter: Meter
) -> bool:
    """Whether the quotient Q has no zero from 0 to ``end``, below 1, on any path."""
    parts = [(QQ.zero, end)]
    for _ in range(PARTS if end < 1 else 0):
        low, high = parts.pop()
        if 0 in _bounds((low, high), start, steps, meter):
            middle = (low + high) / 2
            parts += [(low, middle), (middle, high)]
        if not parts:
            return True
    return False


def _bounds(
    part: Ends, start: PairEdge, steps: Mapping[Pair, Sequence[PairEdge]], meter: Meter
) -> Any:
    """An interval that encloses Q on all paths, for all t in a part of [0, 1)."""
    t = IV.mpf([enclosure(part[0]).a, enclosure(part[1]).b])
    ranges = {
        pair: [(_range(s.term, t), _range(s.factor, t), s.onward) for s in each]
        for pair, each in steps.items()
    }
    largest = max((abs(term).b for each in ranges.values() for term, _, _ in each), default=0)
    # a path of as many edges as there are pairs visits one twice, which gives a factor t
    most = len(steps) * largest / (1 - t)
    found = {
        pair: IV.mpf([-most.b, most.b]) if each else IV.mpf(0) for pair, each in ranges.items()
    }
    for _ in range(ROUNDS):
        meter.spend(STEP * sum(map(len, ranges.values())))
        for pair, each in ranges.items():
            ends = [term + factor * found[onward] for term, factor, onward in each]
            if ends:
                found[pair] = IV.mpf([min(x.a for x in ends), max(x.b for x in ends)])
    return _range(start.term, t) + _range(start.factor, t) * found[start.onward]


def _range(polynomial: PolyElement, t: Any) -> Any:
    """An interval that encloses the values of a polynomial on an interval."""
    return sum((enclosure(c) * t**power for (power,), c in polynomial.terms()), start=IV.mpf(0))
