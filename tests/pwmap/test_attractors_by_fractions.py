"""Attractors of P1^L with a left slope, r > 2, at random parameters, by orbits of fractions."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from pwmap import Attractor, PiecewiseLinearMap, dynamics

PAPER = PiecewiseLinearMap.from_sympy("Piecewise((r - 2 + b*x, x <= 0), (r - a*x, True))")
STEPS = 240  # of an orbit: its fractions grow to some thousand bits
STARTS = 6
FAR = 10**6


def parameters(count: int) -> list[tuple[Fraction, Fraction, Fraction]]:
    """Slopes -a and b, and r: a from 1/2 to 3, b from -1 to 1 without 0, r from 2 to 12."""
    draw = random.Random(16)
    found = []
    while len(found) < count:
        a = Fraction(draw.randint(8, 48), 16)
        b = Fraction(draw.choice([k for k in range(-15, 16) if k]), 16)
        found.append((a, b, 2 + Fraction(draw.randint(1, 80), 8)))
    return found


def image(x: Fraction, a: Fraction, b: Fraction, r: Fraction) -> Fraction:
    return r - 2 + b * x if x <= 0 else r - a * x


def image_of(
    intervals: list[tuple[Fraction, Fraction]], a: Fraction, b: Fraction, r: Fraction
) -> list[tuple[Fraction, Fraction]]:
    """The closure of the image of intervals, joined."""
    pieces = []
    for low, high in intervals:
        if low < 0:
            pieces.append((low, min(high, Fraction(0)), b, r - 2))
        if high > 0:
            pieces.append((max(low, Fraction(0)), high, -a, r))
    ends = sorted(tuple(sorted((s * p + t, s * q + t))) for p, q, s, t in pieces)
    joined: list[tuple[Fraction, Fraction]] = []
    for low, high in ends:
        if joined and low <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(high, joined[-1][1])
        else:
            joined.append((low, high))
    return joined


def exact(attractor: Attractor) -> tuple[list[Fraction], list[tuple[Fraction, Fraction]]]:
    """Points of a cycle, and bands."""
    points = [Fraction(str(x)) for x in attractor.points]
    return points, [(Fraction(str(i.start)), Fraction(str(i.end))) for i in attractor.bands]


@pytest.mark.slow
def test_attractors_at_a_hundred_random_parameters() -> None:
    """Cycles return exactly, bands are mapped onto themselves exactly, and every orbit of
    fractions that stays bounded comes to one of them."""
    draw = random.Random(4)
    chaotic = cycles = settled = 0
    left: list[tuple[Fraction, Fraction, Fraction]] = []
    for a, b, r in parameters(100):
        found = dynamics(PAPER, {"a": str(a), "b": str(b), "r": str(r)})
        if found.open:  # slopes 1/2 and -17/16: what expands so slowly is not followed to its end
            left.append((a, b, r))
            continue
        every = [exact(each) for each in found.attractors]
        for (points, bands), attractor in zip(every, found.attractors, strict=True):
            if points:
                cycles += 1
                turned = [image(x, a, b, r) for x in points]
                assert turned == points[1:] + points[:1]
                multiplier = Fraction(1)
                for x in points:
                    multiplier *= b if x < 0 else -a
                assert Fraction(str(attractor.multiplier)) == multiplier
                assert abs(multiplier) < 1
            else:
                chaotic += 1
                assert image_of(bands, a, b, r) == bands
        for _ in range(STARTS):
            settled += _settles(Fraction(draw.randint(-64, 64), 16), (a, b, r), every)
    assert left == [(Fraction(17, 16), Fraction(1, 2), Fraction(23, 4))]
    assert (chaotic, cycles) == (25, 62)
    assert settled >= 450


def _settles(
    x: Fraction,
    place: tuple[Fraction, Fraction, Fraction],
    every: list[tuple[list[Fraction], list[tuple[Fraction, Fraction]]]],
) -> bool:
    """Whether an orbit is seen to come to an attractor, and to stay there if that is a band."""
    for step in range(STEPS):
        if abs(x) > FAR:
            return False
        if any(low <= x <= high for _, bands in every for low, high in bands):
            for _ in range(8):  # and it stays
                x = image(x, *place)
                assert any(low <= x <= high for _, bands in every for low, high in bands)
            return True
        if any(abs(x - point) < Fraction(1, 10**4) for points, _ in every for point in points):
            return True
        x = image(x, *place)
        if step > 100:  # enough for a contraction: from here on doubles would do
            x = Fraction(round(x * 2**400), 2**400)
    return False
