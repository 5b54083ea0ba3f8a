"""The paper's map, and random ones with flat, neutral and isolated pieces, against exact orbits.

Orbits are followed by :mod:`exact_orbits`, which knows nothing of the package. What is said of
attractors, basins and bands must be what they do; nothing is compared by doubles.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from brute import map_of, spelled, texts
from exact_orbits import Course, End, breaks_of, course, multiplier, random_map
from independent import Parts, nested, part_at
from sympy import QQ

from pwmap import PiecewiseLinearMap, dynamics
from pwmap.algebra.exact import Infinite, pair
from pwmap.algebra.numbers import Exact
from pwmap.longrun import AttractingCycle, Attractor, Bands, Dynamics

Part = tuple[Fraction, Fraction]
MAPS, PAPERS, STARTS, STEPS = 1000, 200, 6, 200
SHORT = 200  # bits of a start


@dataclass(frozen=True)
class Case:
    """A map, what is found, and orbits from random starts, breaks and ends of basins."""

    map: Parts
    found: Dynamics
    courses: tuple[Course, ...]

    @property
    def breaks(self) -> set[Fraction]:
        """Where the pieces of the map meet."""
        return set(breaks_of(self.map))


@cache
def papers() -> tuple[Case, ...]:
    """P1^L with a slope b on the left, 0 < |b| < 1; 1/2 < a < 3 and 2 < r < 12."""
    rng, found = random.Random(17), list[Case]()
    while len(found) < PAPERS:
        r, a, b = (
            Fraction(rng.randrange(*ends), 64) for ends in ((129, 768), (33, 192), (-63, 64))
        )
        if b:
            found.append(_case(map_of([Fraction(0)], ["left"], [(b, r - 2), (-a, r)]), rng))
    return tuple(found)


@cache
def randoms() -> tuple[Case, ...]:
    rng = random.Random(41)
    return tuple(_case(random_map(rng), rng) for _ in range(MAPS))


def cases() -> tuple[Case, ...]:
    return papers() + randoms()


def _case(map_: Parts, rng: random.Random) -> Case:
    found = dynamics(PiecewiseLinearMap(texts(map_)))
    starts = {Fraction(rng.randint(-960, 960), rng.choice((60, 64, 77)))
              for _ in range(STARTS)} | set(breaks_of(map_))  # fmt: skip
    for each in found.attractors:
        cuts = [cut for part in each.whole_basin.region.parts[:4] for cut in part]
        starts |= {fraction(x) for x, _ in cuts if not isinstance(x, Infinite)}
    short = sorted(x for x in starts if x.denominator.bit_length() < SHORT)
    return Case(map_, found, tuple(course(map_, x, STEPS) for x in short))


EACH = pytest.mark.parametrize(
    "some", [papers, pytest.param(randoms, marks=pytest.mark.nightly)], ids=["P1L", "random"]
)


def number(x: Fraction) -> Exact:
    return QQ(x.numerator, x.denominator)


def fraction(x: Exact) -> Fraction:
    return Fraction(*map(int, pair(x)))


def comes(each: Attractor, orbit: Course) -> bool | None:
    """Whether an orbit comes to an attractor; None if that is not known."""
    core = each.core
    if isinstance(core, AttractingCycle):
        known = orbit.end is not End.OPEN
        return set(orbit.cycle) == set(map(fraction, core.points)) if known else None
    if isinstance(core, Bands):
        inside = any(low <= number(x) <= high for x in orbit.cycle or orbit.points[-1:]
                     for low, high in core.intervals)  # fmt: skip
        return inside if orbit.end is not End.OPEN or inside else None
    if orbit.end is End.OPEN:
        return None
    return orbit.end is End.CYCLE and all(number(x) in core.region for x in orbit.cycle)


def is_excepted(case: Case, each: Attractor, orbit: Course) -> bool:
    """Whether a point in a basin may do something else.

    Its orbit ends in a cycle that repels or meets a break; or it meets a break, and all points
    close to it are in the basin.
    """
    at_break = any(x in case.breaks for x in orbit.points)
    repelling = abs(orbit.multiplier) > 1 or any(x in case.breaks for x in orbit.cycle)
    inside = each.whole_basin.region.surrounds(number(orbit.points[0]))
    return (orbit.end is End.CYCLE and repelling) or (at_break and inside)


@pytest.mark.nightly
def test_there_are_all_kinds() -> None:
    found = [each for case in randoms() for each in case.found.attractors]
    kinds = Counter(type(each.core).__name__ for each in found)
    assert min(kinds.values()) > 40, kinds
    assert len(kinds) == 3
    complete = [each.whole_basin.complete for each in found]
    assert sum(complete) > len(complete) * 2 // 3
    assert sum(bool(case.found.open) for case in randoms()) < MAPS // 8


@pytest.mark.nightly
def test_what_is_open_of_the_paper_s_map_is_nearly_neutral() -> None:
    """At a = 1 cycles R R neither attract nor repel; a little beyond bands are many and thin."""
    falls = [-case.map[1].slope for case in papers() if case.found.open]
    assert all(1 <= a < Fraction(9, 8) for a in falls)
    assert len(falls) <= PAPERS // 20
    kinds = Counter(each.is_chaotic for case in papers() for each in case.found.attractors)
    assert kinds[False] > PAPERS // 2
    assert kinds[True] > PAPERS // 6


@pytest.mark.slow
@EACH
def test_points_of_cycles_come_back_along_their_words(some: Callable[[], Iterable[Case]]) -> None:
    """The multiplier is the product of the slopes on the way, less than 1 in size."""
    looked = 0
    for case in some():
        for each in case.found.attractors:
            if not isinstance(each.core, AttractingCycle):
                continue
            points = tuple(map(fraction, each.core.points))
            after = tuple(part_at(case.map, x)(x) for x in points)
            assert after == points[1:] + points[:1], case.map
            assert len(set(points)) == len(points) == len(each.word)
            if not set(points) & case.breaks:
                assert fraction(each.core.multiplier) == multiplier(case.map, points)
                assert abs(multiplier(case.map, points)) < 1
                if len(case.map) == 2:
                    word = nested(case.map, points[0], len(points))[1]
                    assert each.word == spelled("LR", word)
                    looked += 1
    assert looked > 50


@pytest.mark.nightly
def test_an_orbit_that_settles_does_so_in_an_attractor() -> None:
    """A cycle that draws in, or of slope 1 or -1 away from breaks, is found, unless one is open."""
    looked = 0
    for case in cases():
        if case.found.open:
            continue
        for orbit in case.courses:
            neutral = abs(orbit.multiplier) <= 1 and not set(orbit.cycle) & case.breaks
            if orbit.end is End.DRAWN or (orbit.end is End.CYCLE and neutral):
                assert sum(bool(comes(each, orbit)) for each in case.found.attractors) == 1, (
                    case.map, orbit.points[0],
                )  # fmt: skip
                looked += 1
    assert looked > 3 * MAPS


@pytest.mark.nightly
def test_nearly_all_orbits_settle_within_two_hundred_steps() -> None:
    """Where nothing is open; what does not may be a long way from a small basin."""
    neither = settled = 0
    for case in cases():
        if case.found.open:
            continue
        for orbit in case.courses:
            ends = orbit.end is not End.OPEN or any(
                comes(each, orbit) for each in case.found.attractors
            )
            settled += ends
            neither += not ends
    assert neither < settled // 100


@pytest.mark.nightly
def test_from_basins_orbits_come_to_their_attractors_and_from_nowhere_else() -> None:
    """Where a basin is complete; not from an isolated point or an end outside of it either."""
    inside = coming = 0
    for case in cases():
        for each in case.found.attractors:
            for orbit in case.courses:
                x, arrives = number(orbit.points[0]), comes(each, orbit)
                about = case.map, str(each), x
                if x in each.whole_basin.region:
                    assert arrives is not False or is_excepted(case, each, orbit), about
                    inside += 1
                if arrives and each.whole_basin.complete:
                    assert x in each.whole_basin.region, about
                    coming += 1
                if arrives and each.basin_is_complete:
                    parts = [part.closure for part in each.basin]
                    assert any(part.contains(QQ.to_sympy(x)) for part in parts), about
    assert min(inside, coming) > 2 * MAPS


@pytest.mark.slow
@EACH
def test_bands_are_mapped_onto_themselves_and_hold_no_cycle_that_draws_in(
    some: Callable[[], Iterable[Case]],
) -> None:
    """By the pieces of the map alone; no exact orbit from inside leaves, or is drawn in."""
    looked = 0
    for case in some():
        for each in case.found.attractors:
            if not isinstance(each.core, Bands):
                continue
            bands = [(fraction(low), fraction(high)) for low, high in each.core.intervals]
            assert image(case.map, bands) == bands, case.map
            for low, high in bands:
                for k in (1, 2, 3, 5):
                    orbit = course(case.map, low + (high - low) * Fraction(k, 7), STEPS)
                    assert orbit.end in (End.OPEN, End.CYCLE), case.map
                    repelling = abs(orbit.multiplier) > 1 or set(orbit.cycle) & case.breaks
                    assert orbit.end is End.OPEN or repelling, case.map
                    looked += 1
    assert looked > 200


@pytest.mark.nightly
def test_an_orbit_comes_close_to_both_ends_of_all_bands() -> None:
    """100 000 points of one orbit, to 1/1000 of what all bands span.

    Noise of a rounding keeps doubles from short cycles.
    """
    rng = np.random.default_rng(19)
    for case in papers():
        for each in case.found.attractors:
            if not isinstance(each.core, Bands):
                continue
            bands = [(float(low), float(high)) for low, high in each.core.intervals]
            (b, down), (a, r) = ((float(p.slope), float(p.intercept)) for p in case.map)
            x, points = bands[0][0] + (bands[0][1] - bands[0][0]) / 3, np.empty(100_000)
            noise = rng.normal(0.0, 1e-15, len(points)).tolist()
            for k in range(len(points)):
                x = (b * x + down if x <= 0.0 else a * x + r) + noise[k]
                points[k] = x
            close = 1e-3 * (bands[-1][1] - bands[0][0])
            for end in (end for band in bands for end in band):
                assert np.min(np.abs(points - end)) < close, case.map


def image(map_: Parts, parts: list[tuple[Fraction, Fraction]]) -> list[tuple[Fraction, Fraction]]:
    """The closures of images of intervals, joined."""
    found = list[Part]()
    for low, high in parts:
        cuts = [low, *(cut for cut in breaks_of(map_) if low < cut < high), high]
        for a, b in pairwise(cuts):
            part = part_at(map_, (a + b) / 2)
            ends = part(a), part(b)
            found.append((min(ends), max(ends)))
    whole = list[Part]()
    for a, b in sorted(found):
        if whole and a <= whole[-1][1]:
            whole[-1] = whole[-1][0], max(whole[-1][1], b)
        else:
            whole.append((a, b))
    return whole
