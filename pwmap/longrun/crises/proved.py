"""How far the attractors at a sample are proved to persist: while sides of breaks keep their fates.

Every attracting cycle attracts a side of a break. Its orbit converges once it follows the word of
the cycle, twice if the multiplier is negative, as do all points in between. It escapes once outer
pieces take it away from where it was. While none of these words changes, the same cycles attract.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from itertools import islice

from pwmap.algebra.roots import Real
from pwmap.longrun.crises.samples import CLOSER, Attracted, Samples
from pwmap.longrun.fates import Fate, GermOrbit
from pwmap.longrun.line import Germ, MapLine
from pwmap.maps.words import CriticalOrbit, Decision, MultiplierSign, units_of

TRIES = 8  # samples, each closer to the end than all places of doubt before
OUTSIDE = 4  # steps after which lost orbits repeat one outer piece, or both in turn
# the numbers of the pieces that an orbit visits until its fate is decided, and the length of the
# last part, whose multiplier decides on convergence or escape; 0 if none has to
Route = tuple[tuple[int, ...], int]


def settled(samples: Samples, sample: Attracted, end: Real) -> tuple[Attracted, Real]:
    """A sample between another one and an end, and up to where its attractors are right."""
    # Cycles of the first sample must attract up to the end. With bands nothing is proved, and one
    # more sample is taken close to the end; if that is open, only the place of the sample is right.
    if sample.place == end:
        return sample, end
    known: Container[tuple[str, bool]] = sample.words
    if sample.counts:
        closer = samples.beside(end, sample.place, CLOSER)
        if closer.is_open:
            return sample, sample.place
        if closer.counts:
            return closer, end
        sample, known = closer, ()
    for _ in range(TRIES):
        doubts = _doubts(samples, sample, end, known)
        if not doubts:
            return sample, end
        nearest = (min if end < sample.place else max)(doubts)
        closer = samples.between(*sorted((nearest, end)))
        if closer.is_open:
            break
        sample = closer
        if sample.counts:
            break
    return sample, sample.place


def _doubts(
    samples: Samples, sample: Attracted, end: Real, known: Container[tuple[str, bool]]
) -> set[Real]:
    """The places between a sample and an end where cycles may end or sides of breaks change."""
    low, high = sorted((sample.place, end))
    new = (word for word in sample.words if word not in known)
    found = {x for word in new for x in samples.ends_of(word, low, high)}
    for k, orbit in zip(samples.breaks, sample.found.orbits, strict=True):
        route = _route(samples, sample, orbit)
        if route is None:
            return {sample.place}
        for decision in _decisions(samples, k, route, is_lost=orbit.fate is Fate.LOST):
            found.update(samples.roots(samples.orbits.polynomial(decision), low, high))
    return found


def _decisions(samples: Samples, k: int, route: Route, *, is_lost: bool) -> Iterator[Decision]:
    """Yield the quantities whose signs decide the fate of a side of the break k."""
    numbers, turn = route
    word = samples.layout.word(numbers)
    yield from (MultiplierSign((letter,), 0) for letter in set(word))
    yield from samples.layout.visits(k, numbers)
    start = len(word) - turn
    if turn:
        yield from units_of(word[start:])
    if is_lost:  # it goes on to the same side
        yield CriticalOrbit(k, word, k, word[:start])


def _route(samples: Samples, sample: Attracted, orbit: GermOrbit) -> Route | None:
    """The route of a side of a break until its fate is decided; None if it is not."""
    line, germs, cycles = orbit.line, orbit.germs, sample.found.cycles
    if any(not germ.side and germ.x in line.breaks for germ in germs):
        return None  # it comes to a break after a flat piece
    if orbit.fate is Fate.FINITE:
        if any(germ.x in cycle.points for germ in orbit.again for cycle in cycles):
            return orbit.numbers, 0
        units = units_of(samples.layout.word(orbit.word))
        is_neutral = not all(map(samples.orbits.polynomial, units))
        # else it tells nothing about the points beside it, unless all of them have one image
        is_sure = is_neutral or not line.piece(germs[0]).slope
        return (orbit.numbers, orbit.period) if is_sure else None
    if orbit.fate is Fate.LOST:
        numbers = _numbers(line, germs[0], len(germs) + OUTSIDE)
        return numbers, 1 if numbers[-1] == numbers[-2] else 2
    if orbit.fate is Fate.DRAWN:  # maybe before it was found to be: cycles are tried at few steps
        step, cycle = next(
            (step, cycle)
            for step, germ in enumerate(line.orbit(germs[0]))
            for cycle in cycles
            if cycle.draws(germ.x)
        )
        turns = 1 if cycle.multiplier > 0 else 2
        return _numbers(line, germs[0], step + turns * cycle.period), 0
    return None


def _numbers(line: MapLine, germ: Germ, count: int) -> tuple[int, ...]:
    """The numbers of the first pieces that an orbit visits."""
    return tuple(map(line.number, islice(line.orbit(germ), count)))
