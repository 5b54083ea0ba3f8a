"""Attractors at rational values of one parameter, described by words, and glimpses of others.

Orbits in doubles at many places help to find attractors that exist in a short interval only. Where
they differ from those near an exact sample, another exact sample is taken, which decides.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import chain, islice, pairwise, product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import sympy
from sympy import QQ

from pwmap.algebra.exact import Number, dense, quotient_to_sympy
from pwmap.algebra.numbers import Exact, key, quotient_of
from pwmap.algebra.roots import Real, bounds, roots_between, simplest_between
from pwmap.diagrams.data import runs_of
from pwmap.longrun.attractors import Attractors, attractors_of
from pwmap.longrun.cycles import closed_words, levels_of
from pwmap.longrun.fates import Fate, GermOrbit
from pwmap.longrun.line import MapLine, line_at
from pwmap.maps.budget import BUDGET, Budget, Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import CriticalOrbit, Decision, Word, first_rotation, units_of

THIRDS = ((0, 3), (0, 1), (2, 3), (1, 2))  # parts of an interval in which samples are tried in turn
WORK = BUDGET.work // 10  # operations at one place, at most
LETTERS = 48  # of a cycle whose ends are computed, at most
OPENED = 2  # open samples that are not special, after which an interval counts as open
CLOSE = (3, 1)  # halvings of the distance to a place, for samples tried beside it in turn
CLOSER = (6,)  # the same where a cycle ends
PLACES = 256  # of orbits in doubles, in the whole interval
LOOKS = 3  # exact samples taken for glimpses between two cuts, at most
SETTLED, SEEN = 400, 512  # steps of an orbit that are dropped as transient, and steps that are kept
FAR = 1e9  # times the breaks and their images: farther away orbits count as lost
SAME = 1e-9  # of the size of an orbit: closer points are counted as one
GAP = 10.0  # times the mean distance of its points: a larger distance is a gap between bands


class BreakImage(NamedTuple):
    """An image of a break: the index of the break, and the word from it to the image."""

    k: int
    word: Word


Ends = tuple[BreakImage, BreakImage]  # lower and upper end of a band


@dataclass(frozen=True, slots=True, eq=False)
class Attracted:
    """The attractors at one value of the parameter."""

    place: Number
    found: Attractors
    ends: tuple[tuple[Ends, ...], ...]  # of the bands of each chaotic attractor
    cycles: tuple[str, ...]  # words, each from its first letter in the alphabet on
    neutral: tuple[str, ...]  # the same for neutral intervals
    is_special: bool  # images of breaks meet there but not nearby, where attractors may differ

    @property
    def counts(self) -> tuple[int, ...]:
        """The numbers of bands of the chaotic attractors, in ascending order."""
        return tuple(sorted(map(len, self.found.bands)))

    @property
    def words(self) -> tuple[tuple[str, bool], ...]:
        """The words of cycles (with True) and of neutral intervals (with False), each in order."""
        # no set: the hashes of texts, and with them its order, differ from one process to the next
        return (*((w, True) for w in self.cycles), *((w, False) for w in self.neutral))

    @property
    def is_open(self) -> bool:
        """Whether the sample leaves open what attracts at nearby places."""
        too_long = any(len(word) > LETTERS for word, _ in self.words)
        return self.is_special or too_long or bool(self.found.open)


class Samples:
    """The attractors at rational values, once each, with images and cycles up to an ``order``."""

    def __init__(
        self, map_: PiecewiseLinearMap, order: int, meter: Meter, span: tuple[Number, Number]
    ) -> None:
        self.map, self.orbits, self.order, self.meter = map_, map_.orbits, order, meter
        self.span = span
        self.layout = map_.layout
        self.breaks = [k for k in self.layout.breaks for _ in (-1, 1)]  # one for each germ
        # caches of the instance: those of the class would keep all samples alive
        self.line, self.at = cache(partial(line_at, map_)), cache(self._at)
        self.cycles, self.ends_of = cache(self._cycles), cache(self._ends_of)

    def _at(self, place: Number) -> Attracted:
        """The attractors at a rational value; open if they need more work than one place may."""
        line = self.line(place)
        left = self.meter.budget.work - self.meter.work
        meter = Meter(Budget(work=max(1, min(WORK, left))))
        found = attractors_of(line, meter)
        self.meter.spend(meter.work)
        words = (self.map.numbered(orbit.letters) for orbit in found.orbits)
        rows = [*zip(found.orbits, self.breaks, words, strict=True)]
        names = dict[Hashable, BreakImage]()
        needed = {key(x) for bands in found.bands for pair in bands.intervals for x in pair}
        for orbit, k, word in rows:
            for n, germ in enumerate(orbit.germs):
                if (name := key(germ.x)) in needed:
                    names.setdefault(name, BreakImage(k, word[:n]))
        ends = tuple(
            tuple((names[key(a)], names[key(b)]) for a, b in bands.intervals)
            for bands in found.bands
        )
        cycles, neutral = (
            tuple(sorted(first_rotation(each.word) for each in group))
            for group in (found.cycles, found.neutral)
        )
        special = any(self._is_special(line, *row) for row in rows)
        return Attracted(place, found, ends, cycles, neutral, special)

    @cached_property
    def glimpses(self) -> tuple[list[Number], list[tuple[int, ...]]]:
        """Equally spaced places of the interval, with the kinds of the orbits in doubles there."""
        (low, high), breaks = self.span, len(self.layout.breaks)
        places = [low + (high - low) * QQ(2 * k + 1, 2 * PLACES) for k in range(PLACES)]
        self.meter.spend(breaks * (SETTLED + SEEN))
        lines = [self.line(place).doubles for place in places if breaks]
        return places, _kinds(lines) if breaks else [(0,)] * PLACES

    def _cycles(self, place: Number, order: int) -> list[tuple[Word, Exact]]:
        """The words and multipliers of all cycles up to a period."""
        levels = levels_of(self.line(place), self.meter)
        found = closed_words(chain.from_iterable(islice(levels, order)))
        return [(self.layout.word(numbers), whole.slope) for numbers, whole, _ in found]

    def repelling(self, place: Number, order: int) -> list[Word]:
        """The words of all repelling cycles up to a period."""
        return [word for word, multiplier in self.cycles(place, order) if abs(multiplier) > 1]

    def roots(self, polynomial: Number, low: Real, high: Real) -> tuple[Real, ...]:
        """The roots of a polynomial strictly between two places; none of the zero polynomial."""
        coefficients = dense(polynomial)
        self.meter.spend(len(coefficients) ** 2)
        return roots_between(coefficients, low, high) if coefficients else ()

    def _ends_of(self, word: tuple[str, bool], low: Real, high: Real) -> tuple[Real, ...]:
        """The places between two others at which a cycle, or neutral intervals, may end."""
        letters, attracts = word
        numbers = self.map.numbered(letters)
        decisions: list[Decision] = [*units_of(numbers)]
        breaks = self.layout.breaks
        for k in range(len(letters)):
            turned = numbers[k:] + numbers[:k]
            # a cycle ends where a point of it meets a break (or its multiplier is 1 or -1, above);
            # a neutral interval ends in images of breaks, so also where one meets another break
            decisions += [CriticalOrbit(b, turned, b) for b in breaks]
            if not attracts:
                decisions += [
                    CriticalOrbit(b, turned[:n], other)
                    for n in range(len(turned))
                    for b, other in product(breaks, repeat=2)
                ]
        found = set[Real]()
        for decision in decisions:
            found.update(self.roots(self.orbits.polynomial(decision), low, high))
        return tuple(sorted(found))

    def formulas(self, bands: Iterable[Ends]) -> tuple[tuple[sympy.Expr, sympy.Expr], ...]:
        """The formulas of both ends of each band."""
        ends = ([quotient_to_sympy(self.orbits.value(*end)) for end in band] for band in bands)
        return tuple((low, high) for low, high in ends)

    def value(self, image: BreakImage, place: Real) -> Exact:
        """The value of an image of a break at a place."""
        return quotient_of(self.orbits.value(*image), place)

    def _is_special(self, line: MapLine, orbit: GermOrbit, k: int, word: Word) -> bool:
        """Whether an orbit meets a break, or is periodic, at this place but not at all places."""
        polynomial = self.orbits.polynomial
        start = word[: orbit.start]
        if orbit.fate is Fate.FINITE and polynomial(CriticalOrbit(k, word, k, start)):
            return True
        met = (
            CriticalOrbit(k, word[:n], self.layout.breaks[line.breaks.index(germ.x)])
            for n, germ in enumerate(orbit.germs)
            if n and germ.x in line.breaks
        )
        return any(polynomial(decision) for decision in met)

    def between(self, low: Real, high: Real) -> Attracted:
        """The attractors at a simple place of an interval; at others if that is special or open."""
        first, last = bounds(low)[1], bounds(high)[0]
        third = (last - first) / 3
        opened = 0
        # not the simplest of all: there cycles often flip or collide
        for start, end in THIRDS:
            left, right = first + third * start if start else low, first + third * end
            found = self.at(simplest_between(left, right if end < 3 else high))
            opened += not found.is_special
            if not found.is_open or opened == OPENED:
                break
        return found

    def beside(self, place: Real, other: Number, closeness: tuple[int, ...] = CLOSE) -> Attracted:
        """The attractors close to a place, on the side of another one; farther away if open."""
        end = bounds(place)[0 if other < place else 1]
        for halvings in closeness:
            near = end + (other - end) / (1 << halvings)
            found = self.between(*sorted((place, near)))
            if not found.is_open:
                break
        return found


Floats = npt.NDArray[np.float64]


def glimpsed(samples: Samples, low: Real, high: Real, place: Number) -> list[Number]:
    """Simple rationals between two places where orbits in doubles differ from those at a sample.

    Only bands and cycles up to the order count, and only if two neighbouring places both differ.
    """
    places, kinds = samples.glimpses
    kind = kinds[bisect_right(places, place + (places[1] - places[0]) / 2) - 1]
    first, last = bisect_right(places, low), bisect_left(places, bounds(high)[0])
    # a single place does not count: near a merging, or by chance, the number of bands is wrong
    differ = [
        kind not in both and max(map(max, both)) <= 1 + samples.order
        for both in pairwise(kinds[first:last])
    ]
    starts = [first + k for k, _ in runs_of(np.array(differ, dtype=bool))]
    return [simplest_between(*places[k : k + 2]) for k in starts[:LOOKS]]


@np.errstate(over="ignore", invalid="ignore")  # orbits that overflow are lost
def _kinds(lines: Sequence[MapLine]) -> list[tuple[int, ...]]:
    """For each map and side of a break 1 + the period, minus the number of bands, or 0 if lost."""
    slopes, intercepts = (
        np.array([[branch[i] for branch in line.branches] for line in lines]).T for i in (0, 1)
    )
    breaks = np.array([line.breaks for line in lines]).T
    sides = [(b, k) for b in range(len(breaks)) for k in (b, b + 1)]
    x = np.array([slopes[k] * breaks[b] + intercepts[k] for b, k in sides])
    far = FAR * (1.0 + np.abs(breaks).max() + np.abs(x).max())
    orbit = np.empty((SEEN, *x.shape))
    for step in range(-SETTLED, SEEN):
        if step >= 0:
            orbit[step] = x
        piece = (x[None] > breaks[:, None]).sum(axis=0)
        x = np.take_along_axis(slopes, piece, 0) * x + np.take_along_axis(intercepts, piece, 0)
        np.clip(x, -far, far, out=x)
    return [tuple(row) for row in _counted(np.sort(orbit, axis=0), far).T.tolist()]


def _counted(points: Floats, far: float) -> npt.NDArray[np.int64]:
    """The same codes from the sorted points of orbits, along the first axis."""
    span = points[-1] - points[0]
    steps = np.diff(points, axis=0)
    cycle = 1 + (steps > SAME * (np.abs(points).max(axis=0) + span)).sum(axis=0)
    bands = 1 + (steps > GAP * span / SEEN).sum(axis=0)
    lost = ~(np.abs(points[-1]) + np.abs(points[0]) < far)
    return np.where(lost, 0, np.where(cycle < SEEN // 4, 1 + cycle, -bands))
