"""Where short words of what attracts may change: images of breaks meet breaks or repelling cycles.

Words of images are followed letter by letter; where an image meets a break they continue with both
letters. In a part on which all words up to some length are constant no cycle up to that period
begins or ends, except where a multiplier passes through one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise

from pwmap.algebra.exact import Number, dense, to_float
from pwmap.algebra.roots import (
    Dense,
    Real,
    bounds,
    may_vanish,
    most_roots,
    real_roots,
    roots_between,
)
from pwmap.longrun.crises.covering import DoubleMap, family_of, is_covered, single_root, value_at
from pwmap.longrun.crises.samples import BreakImage, Samples
from pwmap.longrun.cycles import closed_words
from pwmap.longrun.line import line_at
from pwmap.longrun.numbers import Exact, to_double
from pwmap.maps.words import CriticalOrbit, MultiplierSign, SignOracle, Slope, Word


@dataclass(frozen=True, slots=True, eq=False)
class AxisPart:
    """A part of the axis in which the words of images are constant."""

    low: Real
    high: Real
    words: tuple[Word, ...]  # of each germ, as far as it was followed


class Cuts:
    """Places at which words of images and cycles, up to the order, say that attractors change."""

    def __init__(self, samples: Samples, order: int) -> None:
        self.axis, self.orbits, self.order = samples.axis, samples.axis.orbits, order
        self.map, self.meter = samples.map, samples.meter
        self.layout, self.letters, self.germs = samples.layout, samples.letters, samples.germs
        self._family = family_of(self.orbits.table, self.layout)
        self._returns = set[Real]()  # places at which a break comes back to itself

    def between(self, low: Real, high: Real) -> dict[Real, bool]:
        """All such places strictly between two others, with whether a cycle meets a break there."""
        found = dict[Real, bool]()
        for part in self._parts(low, high):
            found |= {end: end in self._returns for end in (part.low, part.high)}
            found |= dict.fromkeys(self._meetings(part), False)
        return {place: found[place] for place in sorted(found) if low < place < high}

    # --- Words --------------------------------------------------------------------------------

    def _parts(self, low: Real, high: Real) -> list[AxisPart]:
        """Parts in which germs keep their words, and no multiplier passes 1 or -1."""
        cuts = {low, high}
        for letter in set(self.letters):
            cuts |= self._roots(self.orbits.polynomial(Slope(letter)), low, high)
        parts = [AxisPart(a, b, tuple(() for _ in self.germs)) for a, b in pairwise(sorted(cuts))]
        for length in range(self.order + 1):
            parts = [new for part in parts for new in self._longer(part, length)]
        return [new for part in parts for new in self._by_multipliers(part)]

    def _longer(self, part: AxisPart, length: int) -> Iterator[AxisPart]:
        """A part cut where an image meets a break, with words one letter longer."""
        cuts = {part.low, part.high}
        for (k, _), word in zip(self.germs, part.words, strict=True):
            if len(word) == length and word:
                for other in self.layout.breaks:
                    polynomial = self.orbits.polynomial(CriticalOrbit(k, word, other))
                    found = self._roots(polynomial, part.low, part.high)
                    cuts |= found
                    self._returns |= found if k == other else set()
        for low, high in pairwise(sorted(cuts)):
            oracle = self.axis.oracle(self.axis.between(low, high))
            words = tuple(
                self._with_letter(k, side, word, oracle) if len(word) == length else word
                for (k, side), word in zip(self.germs, part.words, strict=True)
            )
            yield AxisPart(low, high, words)

    def _with_letter(self, k: int, side: int, word: Word, oracle: SignOracle) -> Word:
        """The word of a germ with the letter of its piece; as it is on a break after a flat one."""
        slot = oracle.slot(self.map.chain[0], k, word)
        if slot % 2:
            side *= oracle.slope(word)
            if not side:
                return word
            slot += side
        return (*word, self.layout.slots[slot])

    def _by_multipliers(self, part: AxisPart) -> Iterator[AxisPart]:
        """A part cut where the multiplier of a cycle is 1 or -1."""
        cuts = {part.low, part.high}
        if self._changes_slopes:
            place = self.axis.between(part.low, part.high)
            letters = {tuple(sorted(self._lettered(word))) for word, _ in self._cycles(place)}
            for word in letters:
                for unit in (1, -1):
                    polynomial = self.orbits.polynomial(MultiplierSign(word, unit))
                    cuts |= self._roots(polynomial, part.low, part.high)
        yield from (AxisPart(low, high, part.words) for low, high in pairwise(sorted(cuts)))

    @cached_property
    def _changes_slopes(self) -> bool:
        table = self.orbits.table
        return any(len(dense(s)) > 1 for s in (*table.slopes, table.denominator))

    @cache  # noqa: B019  as long as the cuts live
    def _cycles(self, place: Number) -> list[tuple[tuple[int, ...], Exact]]:
        """Words of cycles as numbers of pieces, with their multipliers."""
        return list(closed_words(line_at(self.map, place), self.order, self.meter))

    def _lettered(self, numbers: Iterable[int]) -> Word:
        return tuple(self.letters[k] for k in numbers)

    def _roots(self, polynomial: Number, low: Real, high: Real) -> set[Real]:
        """The places between two others at which a polynomial is zero; none if it is everywhere."""
        self.meter.spend(1 + len(polynomial))
        return set(roots_between(dense(polynomial), low, high)) if polynomial else set()

    # --- Meetings -----------------------------------------------------------------------------

    def _meetings(self, part: AxisPart) -> set[Real]:
        """Places of a part at which an image first meets a repelling cycle and may end bands."""
        place = self.axis.between(part.low, part.high)
        oracle = self.axis.oracle(place)
        images = dict[
            Dense, tuple[BreakImage, int]
        ]()  # both sides of a continuous break have the same
        for (k, side), word in zip(self.germs, part.words, strict=True):
            for n in range(1, min(len(word), self.order) + 1):
                here = side * oracle.slope(word[:n])
                if here:
                    value = dense(self.orbits.value(k, word[:n])[0])
                    images.setdefault((*value, here), (BreakImage(k, word[:n]), here))
        found = set[Real]()
        for word, multiplier in self._cycles(place):
            if -1 <= multiplier <= 1:
                continue
            for i in range(len(word)):
                turned = word[i:] + word[:i]
                for image, side in images.values():
                    if image.word[-1] != self.letters[turned[-1]]:
                        found |= self._met(part, image, side, turned)
        return found

    def _met(
        self, part: AxisPart, image: BreakImage, side: int, cycle: tuple[int, ...]
    ) -> set[Real]:
        """Where an image meets a cycle in a part, unless the cycle is covered there."""
        polynomial, doubles = self._difference(image, self._lettered(cycle))
        self.meter.spend(len(polynomial))
        first, last = bounds(part.low)[0], bounds(part.high)[1]
        low, high = to_float(first), to_float(last)
        if not may_vanish(polynomial, low, high):
            return set()
        count = most_roots(polynomial, first, last)
        if not count:
            return set()
        if count == 1 and value_at(doubles, low) * value_at(doubles, high) < 0.0:
            place = single_root(doubles, low, high)
            if is_covered(self._doubles(place), cycle, side):
                return set()
        return {
            root
            for root in real_roots(polynomial)
            if part.low < root < part.high
            and not is_covered(self._doubles(to_double(bounds(root)[0])), cycle, side)
        }

    @cache  # noqa: B019  as long as the cuts live
    def _difference(self, image: BreakImage, cycle: Word) -> tuple[Dense, tuple[float, ...]]:
        """An image minus the point of a cycle, but for what does not vanish; exactly and not."""
        exact = dense(self.orbits.meeting(image.k, image.word, cycle))
        return exact, tuple(map(to_float, exact))

    @cache  # noqa: B019  as long as the cuts live
    def _doubles(self, place: float) -> DoubleMap:
        return self._family(place)
