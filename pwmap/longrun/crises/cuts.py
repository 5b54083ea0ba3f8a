"""Places where attractors may change, by short words: images of breaks meet breaks or cycles.

The words of images are followed letter by letter, and the interval is cut where an image meets a
break. In a part in which all words up to some length are constant no cycle up to that period begins
or ends, except where a multiplier is 1 or -1.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise

from pwmap.algebra.exact import dense
from pwmap.algebra.roots import Dense, Real, bounds
from pwmap.longrun.crises.covering import is_covered
from pwmap.longrun.crises.samples import BreakImage, Samples
from pwmap.maps.words import CriticalOrbit, MultiplierSign, SignOracle, Slope, Word

AxisPart = tuple[Real, Real, tuple[Word, ...]]  # an interval, and the words of all germs there


class Cuts:
    """Finds the places at which attractors may change, by words up to the order."""

    def __init__(self, samples: Samples, order: int) -> None:
        self.samples, self.order = samples, order
        self.axis, self.orbits = samples.axis, samples.axis.orbits
        self.layout, self.germs = samples.layout, samples.germs
        self._returns = set[Real]()  # places at which a break comes back to itself

    def between(self, low: Real, high: Real) -> dict[Real, bool]:
        """All such places strictly between two others, and whether a cycle meets a break there."""
        found = dict[Real, bool]()
        for part in self._parts(low, high):
            found |= {end: end in self._returns for end in part[:2]}
            found |= dict.fromkeys(self._meetings(part), False)
        return {place: found[place] for place in sorted(found) if low < place < high}

    # --- Words --------------------------------------------------------------------------------

    def _parts(self, low: Real, high: Real) -> list[AxisPart]:
        """Parts in which the words of germs are constant, and no multiplier is 1 or -1."""
        cuts = {low, high}
        for letter in set(self.samples.letters):
            cuts.update(self.samples.roots(self.orbits.polynomial(Slope(letter)), low, high))
        parts: list[AxisPart] = [
            (a, b, tuple(() for _ in self.germs)) for a, b in pairwise(sorted(cuts))
        ]
        for length in range(self.order + 1):
            parts = [new for part in parts for new in self._longer(part, length)]
        return [new for part in parts for new in self._by_multipliers(part)]

    def _longer(self, part: AxisPart, length: int) -> Iterator[AxisPart]:
        """A part, cut where an image meets a break, with words one letter longer."""
        start, end, words = part
        cuts = {start, end}
        for (k, _), word in zip(self.germs, words, strict=True):
            if len(word) == length and word:
                for other in self.layout.breaks:
                    polynomial = self.orbits.polynomial(CriticalOrbit(k, word, other))
                    found = self.samples.roots(polynomial, start, end)
                    cuts.update(found)
                    self._returns.update(found if k == other else ())
        for low, high in pairwise(sorted(cuts)):
            oracle = self.axis.oracle(self.axis.between(low, high))
            longer = tuple(
                self._with_letter(k, side, word, oracle) if len(word) == length else word
                for (k, side), word in zip(self.germs, words, strict=True)
            )
            yield low, high, longer

    def _with_letter(self, k: int, side: int, word: Word, oracle: SignOracle) -> Word:
        """A word with the next letter; the same word if the image is a break after a flat piece."""
        slot = oracle.slot(self.samples.map.chain[0], k, word)
        if slot % 2:
            side *= oracle.slope(word)
            if not side:
                return word
            slot += side
        return (*word, self.layout.slots[slot])

    def _by_multipliers(self, part: AxisPart) -> Iterator[AxisPart]:
        """A part, cut where the multiplier of a cycle is 1 or -1."""
        start, end, words = part
        cuts = {start, end}
        if self._changes_slopes:
            cycles = self.samples.cycles(self.axis.between(start, end), self.order)
            own = self.samples.letters
            for letters in {tuple(sorted(own[k] for k in word)) for word, _ in cycles}:
                for unit in (1, -1):
                    polynomial = self.orbits.polynomial(MultiplierSign(letters, unit))
                    cuts.update(self.samples.roots(polynomial, start, end))
        yield from ((low, high, words) for low, high in pairwise(sorted(cuts)))

    @cached_property
    def _changes_slopes(self) -> bool:
        table = self.orbits.table
        return any(len(dense(s)) > 1 for s in (*table.slopes, table.denominator))

    # --- Meetings -----------------------------------------------------------------------------

    def _meetings(self, part: AxisPart) -> set[Real]:
        """Places of a part at which an image first meets a repelling cycle that is not covered."""
        low, high, words = part
        place = self.axis.between(low, high)
        oracle, own = self.axis.oracle(place), self.samples.letters
        images = dict[Dense, tuple[BreakImage, int]]()  # one for both sides of a continuous break
        for (k, side), word in zip(self.germs, words, strict=True):
            for n in range(1, min(len(word), self.order) + 1):
                here = side * oracle.slope(word[:n])
                if here:
                    value = dense(self.orbits.value(k, word[:n])[0])
                    images.setdefault((*value, here), (BreakImage(k, word[:n]), here))
        found = set[Real]()
        for word in self.samples.repelling(place, self.order):
            for i in range(len(word)):
                turned = word[i:] + word[:i]
                cycle = tuple(own[k] for k in turned)
                for image, side in images.values():
                    if image.word[-1] == cycle[-1]:
                        continue
                    meeting = self.orbits.meeting(image.k, image.word, cycle)
                    for root in self.samples.roots(meeting, low, high):
                        doubles = self.samples.doubles(bounds(root)[0])
                        if not is_covered(doubles, turned, side):
                            found.add(root)
        return found
