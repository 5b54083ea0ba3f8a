"""Where what attracts changes between two samples.

A cycle ends where one of its points meets a break or its multiplier is 1 or -1; bands end or change
where an end of one meets a break or a point of a repelling cycle. Between two samples that differ,
samples are taken between neighbouring places of this kind and close to each. A change is at such a
place if both samples beside it say so; what no place explains is halved, and what is not settled
then is open.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, product

from pwmap.algebra.exact import Number, dense
from pwmap.algebra.roots import Real, bounds, sign_at
from pwmap.diagrams.data import PointKind
from pwmap.longrun.crises.meetings import earliest
from pwmap.longrun.crises.samples import CLOSER, Attracted, BreakImage, Samples
from pwmap.longrun.line import joined, outside
from pwmap.longrun.numbers import to_double
from pwmap.maps.budget import Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import CriticalOrbit, MultiplierSign, Word
from pwmap.parameters.recorded import axis_of

EFFORT = 24  # halvings of an interval in which samples differ, at most
PLACE = 3  # halvings that a place counts for which does not explain what happens at it
LONG = 24  # and where a cycle is longer than the order: between two there may be any number
MANY = 12  # places that are looked at together: of more an interval is halved first
PERIOD = 8  # of repelling cycles that ends of bands may meet, at least
SAME = 1e-4  # of their length: so little may bands differ that are the same, in a short interval
NEAR = 1e-9  # of the numbers at hand: closer ones are compared exactly


@dataclass(frozen=True, slots=True, eq=False)
class Onset:
    """A place at which what attracts changes, or an interval in which it does."""

    low: Real  # equal to high if the place is known
    high: Real
    before: Attracted  # samples beside it: what attracts there does so up to the place
    after: Attracted
    met: tuple[tuple[BreakImage, Word], ...] = ()  # ends of bands, and the cycles that they meet
    is_open: bool = False  # something is not known in the interval: there may be several changes

    @property
    def is_exact(self) -> bool:
        """Whether the place is known."""
        return bool(self.low == self.high)

    @property
    def place(self) -> Real:
        """The place, or the middle."""
        if self.is_exact:
            return self.low
        return (bounds(self.low)[0] + bounds(self.high)[1]) / 2


class Changes:
    """Finds what happens between samples; cycles up to the order are told apart in any case."""

    def __init__(self, samples: Samples, order: int) -> None:
        self.samples, self.order = samples, order
        self.axis, self.orbits = samples.axis, samples.axis.orbits

    def between(self, left: Attracted, right: Attracted, effort: int = EFFORT) -> Iterator[Onset]:
        """What happens between two samples that are not open, from left to right."""
        if self.same(left, right):
            return
        if self._are_long(left, right) and self._is_gap(left, right):
            yield self._open(left, right)
            return
        met = sorted(self.places(left, right))
        row = list[Attracted]()  # samples between neighbouring places
        if 0 < len(met) <= MANY:
            row = [left, *(self.samples.between(a, b) for a, b in pairwise(met)), right]
        if row and not any(each.is_open for each in row):
            for place, (x, y) in zip(met, pairwise(row), strict=True):
                yield from self._at(place, x, y, effort)
        elif effort > 0:
            third = (right.place - left.place) / 3
            middle = self.samples.between(left.place + third, right.place - third)
            if middle.is_open:
                yield self._open(left, right)
                return
            yield from self.between(left, middle, effort - 1)
            yield from self.between(middle, right, effort - 1)
        elif met or self._are_long(left, right):
            yield self._open(left, right)
        else:
            yield Onset(left.place, right.place, left, right)

    def _at(self, place: Real, x: Attracted, y: Attracted, effort: int) -> Iterator[Onset]:
        """What happens between samples on both sides of a place at which something may."""
        if self.same(x, y):
            return
        near = self._beside(place, x), self._beside(place, y)
        if any(each.is_open for each in near):
            yield self._open(x, y)
            return
        less = effort - (LONG if self._are_long(x, y) else PLACE)
        yield from self._further(x, near[0], less)
        if self._explains(place, *near):
            yield from self._exactly(place, *near, less)
        else:
            yield from self._further(*near, less)
        yield from self._further(near[1], y, less)

    def _exactly(self, place: Real, x: Attracted, y: Attracted, effort: int) -> Iterator[Onset]:
        """A change at a place, with what happens between it and samples beside it."""
        if x.words == y.words:
            if not self.same(x, y):
                yield Onset(place, place, x, y, met=self.places(x, y).get(place, ()))
            return
        close = [
            self.samples.beside(place, each.place, CLOSER) if each.counts else each
            for each in (x, y)
        ]
        if not close[0].is_open:
            yield from self._further(x, close[0], effort)
        # bands may merge infinitely often where a cycle begins or ends
        is_open = any(
            each.is_open or not self.same(each, near)
            for each, near in zip(close, (x, y), strict=True)
        )
        if not is_open:
            met = self.places(*close).get(place, ())
            yield Onset(place, place, close[0], close[1], met=met)
        else:
            yield self._open(
                *(one if other.is_open else other for one, other in zip((x, y), close, strict=True))
            )
        if not close[1].is_open:
            yield from self._further(close[1], y, effort)

    def _further(self, left: Attracted, right: Attracted, effort: int) -> Iterator[Onset]:
        """What happens between two samples, if there is still effort for that."""
        if effort > 0 or self.same(left, right):
            yield from self.between(left, right, effort)
        else:
            yield self._open(left, right)

    def _beside(self, place: Real, sample: Attracted) -> Attracted:
        """What attracts right beside a place; cycles alone are known to attract up to it."""
        known = sample.words and not sample.counts
        return sample if known else self.samples.beside(place, sample.place)

    def _explains(self, place: Real, left: Attracted, right: Attracted) -> bool:
        """Whether all that differs between two samples beside a place changes exactly there."""
        ends = [self.ends_of(word, left.place, right.place) for word in left.words ^ right.words]
        return all(place in each for each in ends) and (
            bool(ends) or place in self.places(left, right)
        )

    def _is_gap(self, left: Attracted, right: Attracted) -> bool:
        """Whether cycles at one place end before those at another one begin."""
        if left.counts or right.counts:
            return False
        end = self.reach(left, left.place, right.place, 0)
        start = self.reach(right, left.place, right.place, -1)
        return end is not None and start is not None and bool(end < start)

    def _are_long(self, *samples: Attracted) -> bool:
        return any(len(word) > self.order for each in samples for word, _ in each.words)

    def _open(self, left: Attracted, right: Attracted) -> Onset:
        """An interval of which it is not known what attracts: as far as cycles are not known to."""
        low, high = left.place, right.place
        first: Real = low if left.counts else self.reach(left, low, high, 0) or low
        last: Real = high if right.counts else self.reach(right, low, high, -1) or high
        if not first < last:
            first, last = low, high
        return Onset(first, last, left, right, is_open=True)

    def reach(self, sample: Attracted, low: Real, high: Real, which: int) -> Real | None:
        """The first place, or the last, at which a cycle of a sample ends; None if none does."""
        ends = [found[which] for word in sample.words if (found := self.ends_of(word, low, high))]
        if not ends:
            return None
        return max(ends) if which else min(ends)

    # --- Whether something differs ------------------------------------------------------------

    def same(self, left: Attracted, right: Attracted) -> bool:
        """Whether the same attracts at two places and, as far as words say, between them."""
        if left is right:
            return True
        if (left.counts, left.words) != (right.counts, right.words):
            return False
        if any(self.ends_of(word, left.place, right.place) for word in left.words):
            return False
        return left.ends == right.ends or self._exchanged(left, right)

    def _exchanged(self, left: Attracted, right: Attracted) -> bool:
        """Whether other images are the ends of bands because they pass each other in between."""
        rows = [[ends for bands in each.ends for ends in bands] for each in (left, right)]
        if len(rows[0]) != len(rows[1]):
            return False
        for ours, theirs in zip(*rows, strict=True):
            for one, other in zip(ours, theirs, strict=True):
                a, b = (self.orbits.value(each.k, each.word) for each in (one, other))
                order = dense(a[0] * b[1] - b[0] * a[1]) if one != other else ()
                # they must be in different orders at both places, or always equal
                if order and sign_at(order, left.place) * sign_at(order, right.place) > 0:
                    return False
        return True

    # --- Where something may end --------------------------------------------------------------

    def places(
        self, left: Attracted, right: Attracted
    ) -> dict[Real, tuple[tuple[BreakImage, Word], ...]]:
        """Places between two samples at which what attracts at one of them may end."""
        low, high = left.place, right.place
        found = dict[Real, tuple[tuple[BreakImage, Word], ...]]()
        for word in left.words | right.words:
            found |= dict.fromkeys(self.ends_of(word, low, high), ())
        for sample in (left, right):
            for place, met in self._ends_of_bands(sample, low, high):
                found[place] = tuple(dict.fromkeys((*found.get(place, ()), *met)))
        return found

    @cache  # noqa: B019  as long as the changes live
    def ends_of(self, word: tuple[str, bool], low: Real, high: Real) -> tuple[Real, ...]:
        """Where a cycle, or a neutral interval, may end between two places."""
        letters, attracts = word
        numbers = tuple(map(self.samples.map.letters.index, letters))
        decisions: list[CriticalOrbit | MultiplierSign] = [
            MultiplierSign(tuple(sorted(numbers)), unit) for unit in (1, -1)
        ]
        breaks = self.samples.layout.breaks
        for k in range(len(letters)):
            turned = numbers[k:] + numbers[:k]
            # a point meets a break, or has the multiplier 1 or -1; ends of intervals that are not
            # turned are images of breaks, which meet others
            decisions += [CriticalOrbit(b, turned, b) for b in breaks]
            if not attracts:
                decisions += [
                    CriticalOrbit(b, turned[:n], other)
                    for n in range(len(turned))
                    for b, other in product(breaks, repeat=2)
                ]
        found = set[Real]()
        for decision in decisions:
            found.update(self.samples.roots(self.orbits.polynomial(decision), low, high))
        return tuple(sorted(found))

    def _ends_of_bands(
        self, sample: Attracted, low: Number, high: Number
    ) -> Iterator[tuple[Real, tuple[tuple[BreakImage, Word], ...]]]:
        """Where an end of a band passes a break or a point of a repelling cycle."""
        ends = list(dict.fromkeys(end for bands in sample.ends for pair in bands for end in pair))
        if not ends:
            return
        for end in ends:
            for other in self.samples.layout.breaks:
                polynomial = self.orbits.polynomial(CriticalOrbit(end.k, end.word, other))
                yield from ((root, ()) for root in self._crossings(polynomial, low, high))
        lines = [self.samples.doubles(place) for place in (low, high)]
        at = [[to_double(self.samples.value(end, place)) for end in ends] for place in (low, high)]
        for numbers in self.samples.repelling(sample.place, max(PERIOD, self.order)):
            word = tuple(self.samples.letters[k] for k in numbers)
            points = [line.cycle(numbers)[0] for line in lines]
            for i in range(len(word)):
                for end, *values in zip(ends, *at, strict=True):
                    one, other = (y - x[i] for y, x in zip(values, points, strict=True))
                    size = NEAR * (abs(values[0]) + abs(values[1]))
                    if one * other > 0.0 and abs(one) > size and abs(other) > size:
                        continue
                    image, cycle = earliest(end.word, word[i:] + word[:i])
                    polynomial = self.orbits.meeting(end.k, image, cycle)
                    for root in self._crossings(polynomial, low, high):
                        yield root, ((BreakImage(end.k, image), cycle),)

    def _crossings(self, polynomial: Number, low: Number, high: Number) -> tuple[Real, ...]:
        """Roots between two places at which a polynomial has different signs."""
        ends = sign_at(dense(polynomial), low), sign_at(dense(polynomial), high)
        if ends[0] * ends[1] < 0:
            return self.samples.roots(polynomial, low, high)
        self.samples.meter.spend(1 + len(polynomial))  # for the signs
        return ()


# --- What happens to bands: they merge, grow, are lost, or a cycle begins -------------------------


def kind_at(
    map_: PiecewiseLinearMap, name: str, order: int, place: Real, width: Number,
    meter: Meter,
) -> PointKind | None:  # fmt: skip
    """What happens to bands at a place, from what attracts a half and one width beside it."""
    samples = Samples(map_, axis_of(map_.definition, name, {}), meter)
    low, high = bounds(place)
    left = samples.between(low - width, low - width / 2)
    right = samples.between(high + width / 2, high + width)
    if left.is_open or right.is_open or Changes(samples, order).same(left, right):
        return None
    return kind_of(samples, Onset(place, place, left, right))


def kind_of(samples: Samples, change: Onset) -> PointKind | None:
    """What happens to bands at a change; None if nothing does."""
    left, right = change.before, change.after
    if not left.counts and not right.counts:
        return None
    if not (left.counts and right.counts):
        chaotic, other = (left, right) if left.counts else (right, left)
        new = [word for word in other.cycles if word not in chaotic.cycles]
        for word in new if change.is_exact else ():
            letters = tuple(sorted(map(samples.map.letters.index, word)))
            flip = samples.axis.orbits.polynomial(MultiplierSign(letters, -1))
            if samples.axis.sign(flip, change.low) == 0:
                return PointKind.PD
        return PointKind.BC if new else PointKind.FC
    if change.is_exact:
        ours, theirs = (
            joined((samples.value(a, change.low), samples.value(b, change.low))
                   for bands in sample.ends for a, b in bands)
            for sample in (left, right)
        )  # fmt: skip
        same = ours == theirs
    else:
        same = _close(left, right)
    if not same:
        return PointKind.XC
    return None if left.counts == right.counts else PointKind.MC


def _close(left: Attracted, right: Attracted) -> bool:
    """Whether bands at two places may cover the same, however they are divided, by lengths."""
    one, other = (
        joined(
            (to_double(a), to_double(b)) for bands in each.found.bands for a, b in bands.intervals
        )
        for each in (left, right)
    )
    little = SAME * (one[-1][1] - one[0][0])
    return all(b - a <= little for a, b in (*outside(one, other), *outside(other, one)))
