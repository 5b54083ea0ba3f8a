"""A thousand random maps with flat, neutral and isolated pieces and jumps, against exact orbits.

Orbits are followed by :mod:`exact_orbits`, which knows nothing of the package. What is said of
attractors, basins and bands must be what they do; nothing is compared by doubles.
"""

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise

import pytest
from exact_orbits import Course, End, RandomMap, course, random_map
from sympy import QQ

from pwmap import PiecewiseLinearMap, dynamics
from pwmap.algebra.exact import Infinite, pair
from pwmap.algebra.numbers import Exact
from pwmap.longrun import AttractingCycle, Attractor, Bands, Dynamics

Part = tuple[Fraction, Fraction]
MAPS, STARTS, STEPS = 1000, 6, 200
SHORT = 200  # bits of a start


@dataclass(frozen=True)
class Case:
    """A map, what is found, and orbits from random starts, breaks and ends of basins."""

    map: RandomMap
    found: Dynamics
    courses: tuple[Course, ...]


@cache
def cases() -> tuple[Case, ...]:
    return tuple(_cases(random.Random(41)))


def _cases(rng: random.Random) -> Iterator[Case]:
    for _ in range(MAPS):
        map_ = random_map(rng)
        found = dynamics(PiecewiseLinearMap.from_sympy(map_.text))
        starts = {Fraction(rng.randint(-960, 960), rng.choice((60, 64, 77)))
                  for _ in range(STARTS)} | set(map_.breaks)  # fmt: skip
        for each in found.attractors:
            cuts = [cut for part in each.whole_basin.region.parts[:4] for cut in part]
            starts |= {fraction(x) for x, _ in cuts if not isinstance(x, Infinite)}
        short = sorted(x for x in starts if x.denominator.bit_length() < SHORT)
        yield Case(map_, found, tuple(course(map_, x, STEPS) for x in short))


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
    at_break = any(x in case.map.breaks for x in orbit.points)
    repelling = abs(orbit.multiplier) > 1 or any(x in case.map.breaks for x in orbit.cycle)
    inside = each.whole_basin.region.surrounds(number(orbit.points[0]))
    return (orbit.end is End.CYCLE and repelling) or (at_break and inside)


@pytest.mark.nightly
@pytest.mark.slow
def test_there_are_all_kinds() -> None:
    kinds = Counter(type(each.core).__name__ for case in cases() for each in case.found.attractors)
    assert min(kinds.values()) > 40, kinds
    assert len(kinds) == 3
    complete = [each.whole_basin.complete for case in cases() for each in case.found.attractors]
    assert sum(complete) > len(complete) * 2 // 3
    assert sum(bool(case.found.open) for case in cases()) < MAPS // 8


@pytest.mark.nightly
@pytest.mark.slow
def test_an_orbit_that_settles_does_so_in_an_attractor() -> None:
    """A cycle that draws in, or of slope 1 or -1 away from breaks, is found, unless one is open."""
    looked = 0
    for case in cases():
        if case.found.open:
            continue
        for orbit in case.courses:
            neutral = abs(orbit.multiplier) <= 1 and not set(orbit.cycle) & set(case.map.breaks)
            if orbit.end is End.DRAWN or (orbit.end is End.CYCLE and neutral):
                assert sum(bool(comes(each, orbit)) for each in case.found.attractors) == 1, (
                    case.map.text, orbit.points[0],
                )  # fmt: skip
                looked += 1
    assert looked > 3 * MAPS


@pytest.mark.nightly
@pytest.mark.slow
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
@pytest.mark.slow
def test_from_basins_orbits_come_to_their_attractors() -> None:
    looked = 0
    for case in cases():
        for each in case.found.attractors:
            for orbit in case.courses:
                if number(orbit.points[0]) in each.whole_basin.region:
                    good = comes(each, orbit) is not False or is_excepted(case, each, orbit)
                    assert good, (case.map.text, str(each), orbit.points[0])
                    looked += 1
    assert looked > 2 * MAPS


@pytest.mark.nightly
@pytest.mark.slow
def test_what_is_said_to_be_complete_is() -> None:
    """No orbit comes from outside, not from an isolated point or an end either."""
    looked = 0
    for case in cases():
        for each in case.found.attractors:
            for orbit in case.courses:
                if not comes(each, orbit):
                    continue
                x = number(orbit.points[0])
                if each.whole_basin.complete:
                    assert x in each.whole_basin.region, (case.map.text, str(each), x)
                    looked += 1
                if each.basin_is_complete:
                    assert any(part.closure.contains(QQ.to_sympy(x)) for part in each.basin), (
                        case.map.text, str(each), x,
                    )  # fmt: skip
    assert looked > 2 * MAPS


@pytest.mark.nightly
@pytest.mark.slow
def test_bands_are_mapped_onto_themselves_and_hold_no_cycle_that_draws_in() -> None:
    """By the pieces of the random map alone; no exact orbit from inside leaves, or is drawn in."""
    looked = 0
    for case in cases():
        for each in case.found.attractors:
            if not isinstance(each.core, Bands):
                continue
            bands = [(fraction(low), fraction(high)) for low, high in each.core.intervals]
            assert image(case.map, bands) == bands, case.map.text
            for low, high in bands:
                for k in (1, 2, 3, 5):
                    orbit = course(case.map, low + (high - low) * Fraction(k, 7), STEPS)
                    assert orbit.end in (End.OPEN, End.CYCLE), case.map.text
                    repelling = abs(orbit.multiplier) > 1 or set(orbit.cycle) & set(case.map.breaks)
                    assert orbit.end is End.OPEN or repelling, case.map.text
                    looked += 1
    assert looked > 200


def image(
    map_: RandomMap, parts: list[tuple[Fraction, Fraction]]
) -> list[tuple[Fraction, Fraction]]:
    """The closures of images of intervals, joined."""
    found = list[Part]()
    for low, high in parts:
        cuts = [low, *(cut for cut in map_.breaks if low < cut < high), high]
        for a, b in pairwise(cuts):
            k = map_.number((a + b) / 2)
            ends = map_.piece(k, a), map_.piece(k, b)
            found.append((min(ends), max(ends)))
    whole = list[Part]()
    for a, b in sorted(found):
        if whole and a <= whole[-1][1]:
            whole[-1] = whole[-1][0], max(whole[-1][1], b)
        else:
            whole.append((a, b))
    return whole
