"""Intervals on which the entropy is constant: closed forms, and other proofs at random places."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest
import sympy
from sympy import Rational, log, sqrt

from pwmap import (
    ConstantEntropy,
    EntropyIntervals,
    GapCause,
    PiecewiseLinearMap,
    constant_entropy,
    dynamics,
)

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((x/2 + 1, x <= 0), (b*x + 1, True))")
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((b*x + r - 2, x <= 0), (r - a*x, True))")
HALF = PAPER.at({"a": "5/4", "b": "1/2"})
FALLING = PAPER.at({"a": "5/4", "b": "-3/4"})
LORENZ = PiecewiseLinearMap.from_sympy("Piecewise((3*x/4 + 1, x <= 0), (3*x/2 - c, True))")
THREE = PiecewiseLinearMap.from_sympy(
    "Piecewise((-2*x - 3, x <= -1), (3*x/4 + c, x <= 1), (2 - 2*x, True))"
)
GOLDEN = (1 + sqrt(5)) / 2


# --- Closed forms --------------------------------------------------------------------------------


def test_windows_of_the_skew_tent_map() -> None:
    """R L^n attracts for a^n |b| < 1, and lies in its pieces if 1 + ... + a^n < |b| a^(n-1) ...

    With a = 1/2 the word R L lives down to b = -2, and R L L from -3, where its point meets the
    break (1/2 (b + 1) + 1 = 0 -> b = -3), to -4. Its map has the two laps of the golden mean.
    """
    found = constant_entropy(SKEW, "b", (-6, -1))
    shown = [(e.lower, e.upper, e.closed, e.cycles) for e in found.intervals]
    assert shown == [(-4, -3, (True, True), ("LLR",)), (-2, -1, (True, True), ("LR",))]
    values = [e.entropy.value for e in found.intervals]
    assert values[1] == 0
    assert sympy.simplify(sympy.exp(values[0]) - GOLDEN) == 0
    assert [(g.lower, g.upper) for g in found.gaps] == [(-6, -4), (-3, -2)]


def test_a_tent_map_has_its_slope_for_growth() -> None:
    """Zero up to 1, where it does not expand; then log a, which increases: no interval at all."""
    found = constant_entropy(TENT, "a", ("1/4", 2), samples=80)
    (only,) = found.intervals
    assert (only.lower, only.upper, only.closed) == (Rational(1, 4), 1, (True, True))
    assert only.entropy.value == 0
    assert (only.entropy.low, only.entropy.high) == (0.0, 0.0)
    (gap,) = found.gaps
    assert (gap.lower, gap.upper) == (1, 2)
    assert GapCause.EXPANDS in gap.causes
    assert GapCause.OPEN not in gap.causes


def test_what_escapes_leaves_the_whole_of_two_laps() -> None:
    (only,) = constant_entropy(TENT, "a", ("9/4", 5)).intervals
    assert (only.lower, only.upper, only.closed) == (Rational(9, 4), 5, (True, True))
    assert only.entropy.value == log(2)
    assert only.cycles == ()


def test_it_is_known_at_the_edge_too() -> None:
    """From 2 on orbits of the break escape, or come to 0: both have two laps."""
    (only,) = constant_entropy(TENT, "a", (2, 3)).intervals
    assert (only.lower, only.upper, only.closed) == (2, 3, (True, True))
    assert only.entropy.value == log(2)


def test_contracted_rotations_have_no_entropy() -> None:
    """Over all translations, though the rotation number changes with every one."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((3*x/4 + c, x <= 0), (3*x/4 + c - 1, True))")
    found = constant_entropy(map_, "c", (-1, 2))
    (only,) = found.intervals
    assert (only.lower, only.upper, only.closed) == (-1, 2, (True, True))
    assert only.entropy.value == 0
    assert found.gaps == ()
    assert found.share == 1.0


def test_a_flat_piece_ends_laps() -> None:
    """One lap goes to itself and to the flat piece: no growth, whatever the cycles are."""
    map_ = PAPER.at({"a": "5/4", "b": 0})
    (only,) = constant_entropy(map_, "r", (2, 12)).intervals
    assert (only.lower, only.upper, only.entropy.value) == (2, 12, 0)


def test_windows_of_the_paper_s_map_begin_where_its_cycles_do() -> None:
    """L R R with a = 5/4, b = 1/2: from 16/7, where it meets the break, to 50/21."""
    found = constant_entropy(HALF, "r", (2, 3))
    (window,) = (e for e in found.intervals if e.cycles == ("LRR",))
    assert (window.lower, window.upper) == (Rational(16, 7), Rational(50, 21))
    assert window.entropy.value == 0


# --- By another way ------------------------------------------------------------------------------

CASES = [(SKEW, "b", (-6, -1), 40), (HALF, "r", (2, 12), 60), (FALLING, "r", (2, 12), 60),
         (LORENZ, "c", (-1, 4), 40), (THREE, "c", (-3, 3), 40)]  # fmt: skip


def at_random(found: EntropyIntervals, n: int) -> Iterator[tuple[ConstantEntropy, sympy.Rational]]:
    """Rationals inside each interval."""
    rng = random.Random(3)
    for each in found.intervals:
        low, width = Rational(str(sympy.N(each.lower, 40))), each.upper - each.lower
        width = Rational(str(sympy.N(width, 40)))
        for _ in range(n):
            yield each, low + width * Rational(rng.randint(1, 10**6 - 1), 10**6)


def disagreements(map_: PiecewiseLinearMap, found: EntropyIntervals, n: int) -> tuple[int, int]:
    """How many places have an entropy that contradicts, and how many of all are not exact.

    There it comes from laps outside what cycles draw in, whose ends are compared as numbers.
    """
    wrong = open_ = 0
    for each, place in at_random(found, n):
        seen = dynamics(map_, {str(found.parameter): place}).entropy
        if seen.value is None:
            open_ += 1
            wrong += not (seen.low <= each.entropy.high and each.entropy.low <= seen.high)
        else:
            wrong += seen.value != each.entropy.value
    return wrong, open_


@pytest.mark.slow
@pytest.mark.parametrize(("map_", "name", "span", "samples"), CASES)
def test_at_fifty_places_inside_it_is_the_same(
    map_: PiecewiseLinearMap, name: str, span: tuple[int, int], samples: int
) -> None:
    found = constant_entropy(map_, name, span, samples=samples)
    assert found.intervals
    wrong, open_ = disagreements(map_, found, 50)
    assert wrong == 0
    assert open_ <= 0.05 * 50 * len(found.intervals)
