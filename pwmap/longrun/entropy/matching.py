"""Orbits of both sides of a break that match, and the growth of laps where almost all of them do.

Both orbits *match* if after as many steps they are at one point, with slopes of one sign. From
there on they cancel in the kneading determinant D. Intervals of a parameter on which orbits match
may accumulate at values at which they never do; yet growth can be the same there [Bruin2019]. Here
is a proof for all values in an interval G of the parameter.

Let slopes not depend on the parameter, and intercepts and breaks be affine in it. Each step moves
one of both orbits: that of the smaller slope, or else the one that is behind. If the left orbit is
at x, the right one is at ratio x + offset. A *pair* is such a relation, with the lag between both.
If G admits finitely many pairs, D follows a path of a finite graph: if R_v is the rest of D from
the pair v on, each step from v to u says R_v = w +- t^n R_u with a known w, and R is 0 where orbits
have matched.

A shortest path to there gives each pair v a polynomial h_v. Let p be the polynomial of the least
root in (0, 1) of D along such a path. If w +- t^n h_u - h_v is a multiple of p for *every* step, so
is R_v - h_v for every path, and so is D = p Q, where Q follows the same graph with other terms. The
graph gives bounds of Q. If Q is not 0 up to the root of p, that is the least root of D on every
path, and growth is one over it for all of G.
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
PAIRS = 200  # of a graph, at most
CHANGES = 30  # of the region of a pair, until the graph is given up
ROUNDS = 40  # in which the bounds of Q are improved
PARTS = 16  # into which the interval up to the root is cut for them, at most

MapFamily = tuple[MapLine, MapLine]  # at both ends of its interval; slopes are equal, none zero
Ends = tuple[Number, Number]  # an affine function of the parameter, at both ends of its interval
Region = tuple[Ends, Ends]  # of the left orbit of a pair, between two bounds


def matched(
    line: MapLine, number: int, steps: int, meter: Meter
) -> tuple[GermOrbit, GermOrbit] | None:
    """The itineraries of both sides of a break up to where they match; None if they do not."""
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
    """A map at both ends of an interval of its one parameter; None unless it is such a family."""
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
    """The image of an affine function of the parameter, by the formula of a piece."""
    low, high = (line.branches[piece](end) for line, end in zip(family, x, strict=True))
    return low, high


class Pair(NamedTuple):
    """The orbits of both sides of a break: the left one at x, the right one at ratio x + offset."""

    ratio: Number  # of the slopes, too
    offset: Ends
    lag: int  # how many steps the left orbit is ahead

    @property
    def left_is_next(self) -> bool:
        """Whether the left orbit moves next."""
        return abs(self.ratio) > 1 or (abs(self.ratio) == 1 and self.lag <= 0)


TOGETHER = Pair(QQ.one, (QQ.zero, QQ.zero), 0)  # at the break, and where orbits match


class PairStep(NamedTuple):
    """A step of the graph: the rest R of the determinant is term + factor times the next R."""

    term: PolyElement
    factor: PolyElement
    onward: Pair


def _step(
    family: MapFamily, weights: Sequence[PolyElement], pair: Pair, piece: int, *, left: bool
) -> PairStep:
    """The step of the left or right orbit by a piece, for the right minus the left series."""
    slope = family[0].branches[piece].slope
    ratio, offset, lag = pair
    # both series begin at the earlier time, with the sign of the left slope
    ahead, behind = max(lag, 0), max(-lag, 0)
    if left:
        ratio = ratio / slope
        a, b = _moved(family, piece, (QQ.zero, QQ.zero))
        onward = Pair(ratio, (offset[0] - ratio * a, offset[1] - ratio * b), lag + 1)
        factor = sign(slope) * T ** min(ahead + 1, behind)
        return PairStep(-weights[piece] * T**ahead, factor, onward)
    onward = Pair(ratio * slope, _moved(family, piece, offset), lag - 1)
    term = sign(ratio) * weights[piece] * T**behind
    return PairStep(term, T ** min(ahead, behind + 1), onward)


def _joined(one: Region, other: Region) -> Region:
    """The smallest region that contains both."""
    low, high = zip(one[0], other[0], strict=True), zip(one[1], other[1], strict=True)
    (a, b), (c, d) = map(min, low), map(max, high)
    return (a, b), (c, d)


def _between(region: Region, low: Ends | None, high: Ends | None) -> Region | None:
    """A region that contains the part of one between two bounds; None if that is empty."""
    lows = [region[0]] if low is None else [low, region[0]]
    highs = [region[1]] if high is None else [high, region[1]]
    if any(a[0] > b[0] and a[1] > b[1] for a in lows for b in highs):
        return None
    # if two bounds cross, the new one is taken, so that there are few different ones
    least = next(a for a in lows if a is region[0] or not _at_most(a, region[0]))
    most = next(a for a in highs if a is region[1] or not _at_most(region[1], a))
    return least, most


def _at_most(one: Ends, other: Ends) -> bool:
    """Whether one bound is not above another over all of the interval."""
    return bool(one[0] <= other[0] and one[1] <= other[1])


def _graph(
    family: MapFamily, weights: Sequence[PolyElement], number: int, first: Pair, meter: Meter
) -> Mapping[Pair, Sequence[PairStep]] | None:
    """The steps from a pair and from all pairs after it; None if these are too many."""
    low, high = (line.breaks[number] for line in family)
    start = _moved(family, number, (low, high))
    # regions contain all that orbits reach, so that no step is missed
    regions: dict[Pair, Region] = {first: (start, start)}
    found, changes, waiting = dict[Pair, list[PairStep]](), Counter[Pair](), deque([first])
    while waiting:
        pair = waiting.popleft()
        found[pair] = []
        if pair[:2] == TOGETHER[:2]:
            if pair.lag:  # the rest is a series of the point times 1 - t^lag
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
    """The pieces by which a pair may move, with the next region of its left orbit."""
    ratio, offset, _ = TOGETHER if pair.left_is_next else pair  # of the orbit that moves
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
    """The growth of laps, above 1, if it is proved constant on the closed interval; else None."""
    one = _step(family, weights, TOGETHER, number, left=True)
    other = _step(family, weights, one.onward, number + 1, left=False)
    start = PairStep(one.term + one.factor * other.term, one.factor * other.factor, other.onward)
    steps = _graph(family, weights, number, start.onward, meter)
    return None if steps is None else _growth(start, steps, meter)


def _growth(start: PairStep, steps: Mapping[Pair, Sequence[PairStep]], meter: Meter) -> Real | None:
    """One over the least root of the determinant, if it is the same on every path; else None."""
    rests = _matching(steps)
    if not steps.keys() <= rests.keys():
        return None
    found = start.term + start.factor * rests[start.onward]
    growth = growth_from(found)
    if growth is None or growth == 1:
        return None
    of_growth = growth.polynomial if isinstance(growth, RealRoot) else (QQ.one, -growth)
    divisor = sum((c * T**k for k, c in enumerate(of_growth)), start=RING.zero)
    quotients = dict[Pair, list[PairStep]]()
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


def _matching(steps: Mapping[Pair, Sequence[PairStep]]) -> dict[Pair, PolyElement]:
    """The rest of the determinant from each pair on, along a shortest path to matching orbits."""
    found = {TOGETHER: RING.zero}
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
    start: PairStep, steps: Mapping[Pair, Sequence[PairStep]], end: Number, meter: Meter
) -> bool:
    """Whether no path has a determinant that is zero between 0 and some place below 1."""
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
    part: Ends, start: PairStep, steps: Mapping[Pair, Sequence[PairStep]], meter: Meter
) -> Any:
    """An interval with the determinants of all paths, for all t in a part of [0, 1)."""
    t = IV.mpf([enclosure(part[0]).a, enclosure(part[1]).b])
    ranges = {
        pair: [(_range(s.term, t), _range(s.factor, t), s.onward) for s in each]
        for pair, each in steps.items()
    }
    largest = max((abs(term).b for each in ranges.values() for term, _, _ in each), default=0)
    # a path with as many steps as there are pairs visits one twice, which gives a factor t
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
    """The values of a polynomial in an interval."""
    return sum((enclosure(c) * t**power for (power,), c in polynomial.terms()), start=IV.mpf(0))
