"""Places where attractors may change, by short words: images of breaks meet breaks or cycles.

The words of images are followed letter by letter, and the interval is cut where an image meets a
break. In a part in which all words up to some length are constant no cycle up to that period begins
or ends, except where a multiplier is 1 or -1.

An image that meets a repelling cycle inside of bands ends no band. A short interval beside a point
of the cycle is followed along it to a break, and on. If an image surrounds a point of the cycle,
the cycle lies inside of every band to which the break may belong, there and nearby: no band ends,
begins or merges. Doubles decide, with intervals that are shortened at each step by far more than
their error; in doubt nothing is claimed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property, partial
from itertools import accumulate, pairwise

from pwmap.algebra.exact import dense
from pwmap.algebra.roots import Dense, Real, bounds, simplest_between
from pwmap.longrun.crises.samples import BreakImage, Samples
from pwmap.longrun.line import MapLine, joined
from pwmap.maps.words import CriticalOrbit, MultiplierSign, Word

AxisPart = tuple[Real, Real]  # an interval of the parameter


class Cuts:
    """Finds the places at which attractors may change, by words up to the order."""

    def __init__(self, samples: Samples, order: int) -> None:
        self.samples, self.order = samples, order
        self.orbits = samples.orbits
        self._returns = set[Real]()  # places at which a break comes back to itself

    def between(self, low: Real, high: Real) -> dict[Real, bool]:
        """All such places strictly between two others, and whether a cycle meets a break there."""
        parts = _cut([(low, high)], self._slopes_vanish)
        for length in range(1, self.order + 1):
            parts = _cut(parts, partial(self._images_meet_breaks, length))
        parts = _cut(parts, self._multipliers_are_units)
        found = dict[Real, bool]()
        for part in parts:
            found |= {end: end in self._returns for end in part}
            found |= dict.fromkeys(self._images_meet_cycles(part), False)
        return {place: found[place] for place in sorted(found) if low < place < high}

    def _slopes_vanish(self, part: AxisPart) -> Iterator[Real]:
        for letter in set(self.samples.letters):
            slope = self.orbits.polynomial(MultiplierSign((letter,), 0))
            yield from self.samples.roots(slope, *part)

    def _images_meet_breaks(self, length: int, part: AxisPart) -> Iterator[Real]:
        """Where images after so many steps meet breaks; words are constant up to there."""
        for image, _ in self._images(part):
            for other in self.samples.layout.breaks if len(image.word) == length else ():
                polynomial = self.orbits.polynomial(CriticalOrbit(*image, other))
                found = self.samples.roots(polynomial, *part)
                self._returns.update(found if image.k == other else ())
                yield from found

    def _images(self, part: AxisPart) -> Iterator[tuple[BreakImage, int]]:
        """Images of both sides of breaks up to the order, and the sides on which they come."""
        line = self.samples.line(simplest_between(*part))
        for k, germ in zip(self.samples.breaks, line.germs, strict=True):
            word: Word = ()
            # on a break after a flat piece orbits are those of this break
            while len(word) < self.order and (germ.side or germ.x not in line.breaks):
                word = (*word, self.samples.letters[line.number(germ)])
                germ = line.image(germ)
                yield BreakImage(k, word), germ.side

    def _multipliers_are_units(self, part: AxisPart) -> Iterator[Real]:
        """Where the multiplier of a cycle is 1 or -1."""
        if self._changes_slopes:
            cycles = self.samples.cycles(simplest_between(*part), self.order)
            own = self.samples.letters
            for letters in {tuple(sorted(own[k] for k in word)) for word, _ in cycles}:
                for unit in (1, -1):
                    polynomial = self.orbits.polynomial(MultiplierSign(letters, unit))
                    yield from self.samples.roots(polynomial, *part)

    @cached_property
    def _changes_slopes(self) -> bool:
        table = self.orbits.table
        return any(len(dense(s)) > 1 for s in (*table.slopes, table.denominator))

    def _images_meet_cycles(self, part: AxisPart) -> Iterator[Real]:
        """Where an image first meets a repelling cycle that is not covered."""
        images = dict[Dense, tuple[BreakImage, int]]()  # one for both sides of a continuous break
        for image, side in self._images(part):
            if side:
                value = dense(self.orbits.value(*image)[0])
                images.setdefault((*value, side), (image, side))
        for word in self.samples.repelling(simplest_between(*part), self.order):
            for i in range(len(word)):
                turned = word[i:] + word[:i]
                cycle = tuple(self.samples.letters[k] for k in turned)
                for image, side in images.values():
                    if image.word[-1] == cycle[-1]:
                        continue
                    meeting = self.orbits.meeting(*image, cycle)
                    for root in self.samples.roots(meeting, *part):
                        line = self.samples.line(bounds(root)[0])
                        if not is_covered(line.doubles, turned, side):
                            yield root


def _cut(parts: Iterable[AxisPart], places: Callable[[AxisPart], Iterable[Real]]) -> list[AxisPart]:
    """Intervals, each cut at places inside."""
    return [new for part in parts for new in pairwise(sorted({*part, *places(part)}))]


STEPS = 24  # in which the interval grows, at most
PARTS = 24  # of its images, at most
SLACK = 1e-9  # relative length by which an interval is shortened at each step

Part = tuple[float, float]


def is_covered(line: MapLine, word: Sequence[int], side: int) -> bool:
    """Whether late images of one side of a repelling cycle surround one of its points."""
    points = points_of(line, word)
    rises = line.along(word).slope > 0.0
    first = _first_part(line, word if rises else (*word, *word), points[0], side)
    if first is None:
        return False
    known, new = [first], [first]
    for _ in range(STEPS):
        longer = joined([*known, *(image for part in new for image in _images(line, part))])
        known, new = longer, [part for part in longer if part not in known]
        if any(_surrounds(part, x) for part in new for x in points):
            return True
        if not new or len(known) > PARTS:
            return False
    return False


def points_of(line: MapLine, word: Sequence[int]) -> list[float]:
    """The points of a cycle, given by the numbers of its branches."""
    start = line.along(word).fixed_point
    return [*accumulate(word[:-1], lambda x, k: line.branches[k](x), initial=start)]


def _images(line: MapLine, part: Part) -> Iterator[Part]:
    """The images of an interval that is cut at breaks, each a bit shorter than it is."""
    for branch, ends in line.parts(part):
        low, high = branch.over(ends)
        slack = SLACK * (abs(low) + abs(high) + abs(branch.intercept))
        if low + slack < high - slack:
            yield low + slack, high - slack


def _first_part(line: MapLine, word: Sequence[int], x: float, side: int) -> Part | None:
    """The first interval from a point of a cycle to a break; None if that is not certain."""
    nearest, found, scale = math.inf, None, 1.0
    for k in word:
        branch = line.branches[k]
        y = branch.upper if side > 0 else branch.lower
        if math.isfinite(y):
            slack = SLACK * (abs(x) + abs(y))
            if not (y - x) * side > 2.0 * slack:
                return None
            if abs(y - x) / scale < nearest:
                nearest = abs(y - x) / scale
                found = min(x, y) + slack, max(x, y) - slack
        scale *= abs(branch.slope)
        side = side if branch.slope > 0.0 else -side
        x = branch(x)
    return found


def _surrounds(part: Part, x: float) -> bool:
    slack = SLACK * (abs(x) + max(map(abs, part)))
    return part[0] + slack < x < part[1] - slack
