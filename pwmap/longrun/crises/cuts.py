"""Places where attractors may change: images of breaks, with short words, meet breaks or cycles.

The interval is cut wherever an image meets a break, letter by letter. Where all words up to some
length are constant, no cycle up to that period begins or ends, unless a multiplier is 1 or -1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain, pairwise

from pwmap.algebra.exact import dense
from pwmap.algebra.roots import Dense, Real, simplest_between
from pwmap.longrun.crises.samples import BreakImage, Samples
from pwmap.longrun.line import Germ
from pwmap.maps.words import CriticalOrbit, MultiplierSign, Word, units_of

AxisPart = tuple[Real, Real]  # an interval of the parameter


def cuts_between(samples: Samples, low: Real, high: Real) -> dict[Real, bool]:
    """The places strictly between two others, each with whether a cycle meets a break there."""
    returns = set[Real]()  # places at which a break returns to itself
    parts = _cut([(low, high)], partial(_slopes_vanish, samples))
    for length in range(1, samples.order + 1):
        parts = _cut(parts, partial(_images_meet_breaks, samples, length, returns))
    parts = _cut(parts, partial(_multipliers_are_units, samples))
    places = {end for part in parts for end in part}
    places.update(*(_images_meet_cycles(samples, part) for part in parts))
    return {place: place in returns for place in sorted(places) if low < place < high}


def _cut(parts: Iterable[AxisPart], places: Callable[[AxisPart], Iterable[Real]]) -> list[AxisPart]:
    """Cut each interval at the places inside that a function gives for it."""
    return [new for part in parts for new in pairwise(sorted({*part, *places(part)}))]


def _slopes_vanish(samples: Samples, part: AxisPart) -> Iterator[Real]:
    for letter in set(samples.layout.between):
        slope = samples.orbits.polynomial(MultiplierSign((letter,), 0))
        yield from samples.roots(slope, *part)


def _images_meet_breaks(
    samples: Samples, length: int, returns: set[Real], part: AxisPart
) -> Iterator[Real]:
    """Yield where images after ``length`` steps meet breaks; shorter words are constant."""
    for image, _ in _images(samples, part):
        for other in samples.layout.breaks if len(image.word) == length else ():
            found = samples.roots(samples.orbits.polynomial(CriticalOrbit(*image, other)), *part)
            returns.update(found if image.k == other else ())
            yield from found


def _images(samples: Samples, part: AxisPart) -> Iterator[tuple[BreakImage, Germ]]:
    """Yield the images of both sides of all breaks up to the order, with their germs."""
    line = samples.line(simplest_between(*part))
    for k, germ in zip(samples.breaks, line.germs, strict=True):
        word: Word = ()
        # an orbit that a flat piece takes to a break goes on like that of this break
        while len(word) < samples.order and (germ.side or germ.x not in line.breaks):
            word += samples.layout.word([line.number(germ)])
            germ = line.image(germ)
            yield BreakImage(k, word), germ


def _multipliers_are_units(samples: Samples, part: AxisPart) -> Iterator[Real]:
    """Yield where a cycle up to the order has multiplier 1 or -1."""
    table = samples.orbits.table
    if all(len(dense(each)) <= 1 for each in (*table.slopes, table.denominator)):
        return  # slopes do not depend on the parameter
    cycles = samples.cycles(simplest_between(*part), samples.order)
    for unit in chain.from_iterable({units_of(word) for word, _ in cycles}):
        yield from samples.roots(samples.orbits.polynomial(unit), *part)


def _images_meet_cycles(samples: Samples, part: AxisPart) -> Iterator[Real]:
    """Yield where an image of a break is its first one on a repelling cycle."""
    images = dict[Dense, BreakImage]()  # both sides of a continuous break have the same ones
    for image, germ in _images(samples, part):
        if germ.side:  # otherwise the orbit has passed a flat piece
            images.setdefault(dense(samples.orbits.value(*image)[0]), image)
    for word in samples.repelling(simplest_between(*part), samples.order):
        for i in range(len(word)):
            cycle = word[i:] + word[:i]
            for image in images.values():
                if image.word[-1] != cycle[-1]:
                    yield from samples.roots(samples.orbits.meeting(*image, cycle), *part)
