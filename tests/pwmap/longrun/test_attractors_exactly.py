"""Attractors of P1^L with a slope on the left, checked by orbits and images of fractions alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
import sympy

from pwmap import PiecewiseLinearMap, dynamics
from pwmap.algebra.exact import pair
from pwmap.longrun import Attractor, Dynamics

MAP = PiecewiseLinearMap.from_sympy("Piecewise((b*x + r - 2, x <= 0), (r - a*x, True))")
PLACES = 200
Part = tuple[Fraction, Fraction]


@dataclass(frozen=True, slots=True)
class Paper:
    """The map with numbers for its parameters."""

    r: Fraction
    a: Fraction
    b: Fraction

    def __call__(self, x: Fraction) -> Fraction:
        return self.b * x + self.r - 2 if x <= 0 else self.r - self.a * x


@cache
def places() -> tuple[tuple[Paper, Dynamics], ...]:
    """Random ones: 0 < |b| < 1, 1/2 < a < 3, 2 < r < 12, and what is found there."""
    rng, found = np.random.default_rng(17), list[tuple[Paper, Dynamics]]()
    while len(found) < PLACES:
        r, a, b = (Fraction(int(rng.integers(*ends)), 64)
                   for ends in ((129, 768), (33, 192), (-63, 64)))  # fmt: skip
        if b:
            found.append((Paper(r, a, b), dynamics(MAP, {"r": r, "a": a, "b": b})))
    return tuple(found)


def fraction(x: object) -> Fraction:
    return Fraction(*pair(x))


def bands_of(each: Attractor) -> list[Part]:
    return [(fraction(low), fraction(high)) for low, high in each.core.intervals]


def chaotic() -> Iterator[tuple[Paper, Attractor]]:
    for map_, found in places():
        yield from ((map_, each) for each in found.attractors if each.is_chaotic)


@pytest.mark.nightly
@pytest.mark.slow
def test_what_is_open_is_nearly_neutral() -> None:
    """At a = 1 cycles R R neither attract nor repel; a little beyond bands are many and thin."""
    open_ = [map_ for map_, found in places() if found.open]
    assert all(1 <= map_.a < Fraction(9, 8) for map_ in open_)
    assert len(open_) <= PLACES // 20
    cycles = sum(not each.is_chaotic for _, found in places() for each in found.attractors)
    assert cycles > PLACES // 2
    assert len(list(chaotic())) > PLACES // 6


@pytest.mark.slow
def test_points_of_cycles_solve_their_words_and_come_back() -> None:
    """x = m x + c along the word, in fractions; then the map itself goes round once."""
    for map_, found in places():
        for each in found.attractors:
            if not each.points:
                continue
            m, c = Fraction(1), Fraction(0)
            for letter in each.word:
                slope, shift = (map_.b, map_.r - 2) if letter == "L" else (-map_.a, map_.r)
                m, c = slope * m, slope * c + shift
            assert abs(m) < 1
            assert m == fraction(each.core.multiplier)
            x = start = c / (1 - m)
            points = list[Fraction]()
            for letter in each.word:
                assert (letter == "L") == (x <= 0)
                assert x != 0
                points.append(x)
                x = map_(x)
            assert x == start
            assert points == [fraction(point) for point in each.core.points]
            assert len(set(points)) == len(points)


@pytest.mark.slow
def test_an_orbit_of_fractions_stays_in_bands() -> None:
    """400 steps, from one third of the first band: denominators have some thousand bits then."""
    for map_, each in chaotic():
        bands = bands_of(each)
        x = bands[0][0] + (bands[0][1] - bands[0][0]) / 3
        for _ in range(400):
            x = map_(x)
            assert any(low <= x <= high for low, high in bands), map_


@pytest.mark.nightly
@pytest.mark.slow
def test_an_orbit_comes_close_to_both_ends_of_all_bands() -> None:
    """100 000 points of one orbit, to 1/1000 of what all bands span.

    Noise of a rounding keeps doubles from short cycles.
    """
    rng = np.random.default_rng(19)
    for map_, each in chaotic():
        bands = [(float(low), float(high)) for low, high in bands_of(each)]
        r, a, b = float(map_.r), float(map_.a), float(map_.b)
        x, points = bands[0][0] + (bands[0][1] - bands[0][0]) / 3, np.empty(100_000)
        noise = rng.normal(0.0, 1e-15, len(points)).tolist()
        for k in range(len(points)):
            x = (b * x + r - 2.0 if x <= 0.0 else r - a * x) + noise[k]
            points[k] = x
        close = 1e-3 * (bands[-1][1] - bands[0][0])
        for end in (end for band in bands for end in band):
            assert np.min(np.abs(points - end)) < close, map_


@pytest.mark.nightly
@pytest.mark.slow
def test_exact_orbits_settle_in_what_is_found() -> None:
    """From ten starts each, up to 1000 steps of fractions: in a band, by a cycle, or outward."""
    rng = np.random.default_rng(23)
    ends = {"settled": 0, "lost": 0, "neither": 0}
    for map_, found in places():
        if found.open:
            continue
        for start in rng.integers(-640, 768, 10):
            ends[settled(map_, found, Fraction(int(start), 64))] += 1
    assert ends["neither"] == 0, ends
    assert ends["settled"] > 5 * PLACES


def settled(map_: Paper, found: Dynamics, x: Fraction) -> str:
    for _ in range(20):
        if any(holds(map_, each, x) for each in found.attractors):
            return "settled"
        if is_lost(map_, x):
            return "lost"
        for _ in range(50):
            x = map_(x)
    return "neither"


def is_lost(map_: Paper, x: Fraction) -> bool:
    """Whether an orbit turns round the break and is farther out every second step.

    Both pieces fall then, and two steps expand. One piece alone, of a slope below one or falling,
    lets nothing run away.
    """
    once, twice = map_(x), map_(map_(x))
    if map_.b > 0 or map_.a * -map_.b <= 1:
        return False
    return (x > 0 >= once and twice > x) or (x <= 0 < once and twice < x)


def holds(map_: Paper, each: Attractor, x: Fraction) -> bool:
    """Whether a point lies in bands, or follows a word of what attracts twice from some letter on.

    What does so is drawn into a cycle, see :mod:`pwmap.longrun.entropy.kneading`, or is neutral.
    """
    if each.is_chaotic:
        return any(low <= x <= high for low, high in bands_of(each))
    letters = ""
    for _ in range(2 * len(each.word)):
        letters += "L" if x <= 0 else "R"
        x = map_(x)
    return any(letters == 2 * (each.word[k:] + each.word[:k]) for k in range(len(each.word)))


def test_a_line_that_is_turned_takes_an_algebraic_value() -> None:
    turned = PiecewiseLinearMap.from_sympy("a - x")
    (each,) = dynamics(turned, {"a": sympy.sqrt(2)}).attractors
    assert (each.multiplier, each.period) == (-1, 2)
