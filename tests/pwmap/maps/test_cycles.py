"""Cycles by words, against composition, brute force with fractions and numbers of necklaces."""

import random
from fractions import Fraction
from itertools import product

import pytest
import sympy
from sympy import Rational, divisors, mobius, sqrt

from pwmap import Budget, BudgetError, PiecewiseLinearMap, cycles, word_family
from pwmap.maps import Progress
from pwmap.rotations import farey

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
P1L = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))")
CIRCLE = PiecewiseLinearMap([("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")])


def necklaces(points: list[int]) -> list[int]:
    """Numbers of cycles of periods 1, 2, ... from those of fixed points of iterates [Moebius]."""
    return [
        sum(int(mobius(n // d)) * points[d - 1] for d in divisors(n)) // n
        for n in range(1, len(points) + 1)
    ]


def test_the_full_tent_map_has_all_words() -> None:
    """2^n fixed points of the n-th iterate."""
    found = cycles(TENT, {"a": 2}, 12)
    assert [len(found.of_period(n)) for n in range(1, 13)] == necklaces(
        [2**n for n in range(1, 13)]
    )
    assert (found.order, found.left_out) == (12, "")


@pytest.mark.slow
def test_the_tent_map_of_the_golden_mean_counts_with_lucas_numbers() -> None:
    """The break has the period 3. Of its words LL never occurs in the bands: the trace of the n-th
    power of (0 1; 1 1), L_n; the fixed point 0 outside of them, and words through the break twice,
    from both sides, are told apart: that cycle has a point on the break, and no word beside it."""
    lucas = [1, 3]
    while len(lucas) < 12:
        lucas.append(lucas[-1] + lucas[-2])
    points = [n + 1 for n in lucas]  # 0 is fixed, too
    expected = necklaces(points)
    found = cycles(TENT, {"a": (1 + sqrt(5)) / 2}, 12)
    counts = [len(found.of_period(n)) for n in range(1, 13)]
    assert counts == expected
    (through,) = (cycle for cycle in found if cycle.at_break)
    assert through.period == 3
    assert Rational(1, 2) in through.points
    assert through.stable is None


def brute(map_: PiecewiseLinearMap, order: int) -> set[tuple[Fraction, ...]]:
    """Cycles by all words, followed with fractions; intervals of periodic points are left out."""
    pieces = [(p.word, Fraction(str(p.slope)), Fraction(str(p.intercept))) for p in map_.pieces]
    found = set()
    for n in range(1, order + 1):
        for word in product(pieces, repeat=n):
            slope, intercept = Fraction(1), Fraction(0)
            for _, s, t in word:
                slope, intercept = s * slope, s * intercept + t
            if slope == 1:
                continue
            x = intercept / (1 - slope)
            points = [x]
            for letter, *_ in word:
                if map_.word_of(sympy.Rational(str(points[-1]))) != letter:
                    break
                points.append(Fraction(str(map_(sympy.Rational(str(points[-1]))))))
            else:
                if points[-1] == x and len(set(points)) == n:
                    first = points.index(min(points))
                    found.add(tuple(points[first:-1] + points[:first]))
    return found


def random_map(draw: random.Random) -> PiecewiseLinearMap:
    """Two or three pieces with jumps, flat pieces, slopes of one and points of their own."""
    count = draw.choice((2, 3))
    slopes = [Rational(draw.choice((-7, -5, -4, -3, 0, 3, 4, 5, 6)), 4) for _ in range(count)]
    shifts = [Rational(draw.randint(-6, 6), 4) for _ in range(count)]
    breaks = sorted(draw.sample(range(-3, 4), count - 1))
    x = sympy.Symbol("x")
    pieces, above = [], sympy.true
    for slope, shift, end in zip(slopes, shifts, [*breaks, None], strict=True):
        if end is None:
            pieces.append((slope * x + shift, above))
            break
        kind = draw.choice(("left", "right", "own"))
        below = x <= end if kind == "left" else x < end
        pieces.append((slope * x + shift, sympy.And(above, below)))
        above = x > end if kind != "right" else x >= end
        if kind == "own":
            pieces.append((sympy.Integer(draw.randint(-3, 3)), sympy.Eq(x, end)))
    return PiecewiseLinearMap(pieces)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_random_maps_by_brute_force(seed: int) -> None:
    map_ = random_map(random.Random(seed))
    found = cycles(map_, order=5)
    points = {tuple(Fraction(str(x)) for x in cycle.points) for cycle in found}
    alone = {tuple(Fraction(str(x)) for x in c.points) for c in found if c.multiplier is None}
    assert points - alone <= brute(map_, 5) <= points
    assert len(points) == len(found)
    for cycle in found:
        letters = [map_.word_of(x) for x in cycle.points]
        assert "".join(letters) == cycle.word


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40, 80))
def test_random_maps_by_composition(seed: int) -> None:
    """The same words and multipliers as the fixed points of iterates have."""
    map_ = random_map(random.Random(seed))
    found = cycles(map_, order=6)
    for period in range(1, 7):
        fixed = [p for p in map_.iterate(period).fixed_points() if p.period == period]
        assert len(fixed) == period * len(found.of_period(period))
        multipliers = {p.word: (p.multiplier, p.stable) for p in fixed}
        for cycle in found.of_period(period):
            if not cycle.at_break:
                assert multipliers[cycle.word] == (cycle.multiplier, cycle.stable)


def test_cycles_of_an_iterate_have_its_periods() -> None:
    """The tent map of slope 2 has 1, 1, 2, 3, 6, 9 ... cycles; its second iterate has 4^n fixed
    points of the n-th iterate, so 4, 6, 20, each period that of the points."""
    found = cycles(TENT.at({"a": 2}).iterate(2), order=3)
    assert [len(found.of_period(n)) for n in range(1, 4)] == necklaces([4, 16, 64]) == [4, 6, 20]
    assert all(cycle.period == len(cycle.points) for cycle in found)
    assert {len(cycle.word) for cycle in found.of_period(3)} == {6}


def test_symbolic_cycles_are_the_same() -> None:
    for values in ({"a": "5/4", "r": "11/5"}, {"a": "5/4", "r": 3}, {"a": "3/2", "r": 8}):
        map_ = P1L.at(values)
        found = cycles(map_, order=9)
        for period in range(1, 10):
            known = map_.cycles(period)
            assert [len(c.points) for c in known] == [period] * len(found.of_period(period))
            assert {min(c.points) for c in known} == {c.points[0] for c in found.of_period(period)}


def test_a_family_of_words_is_found_at_its_parameters() -> None:
    """L R^n of the paper's map beyond r = 2, at r = 3 with n = 8."""
    family = word_family(P1L.at({"a": "5/4"}), "L R^n")
    (one, other) = cycles(P1L, {"a": "5/4", "r": 3}, 20)
    assert (one.word, other.word) == ("R", "L" + 8 * "R")
    conditions = family.at(8).conditions
    assert all(condition.subs("r", 3) == sympy.true for condition in conditions)
    assert other.points[0] == Rational(-42827, 65536)
    assert other.multiplier == 0


def test_a_rotation_has_one_cycle_and_few_words() -> None:
    found = cycles(CIRCLE, {"d": "5/7"}, 20)
    assert [cycle.word for cycle in found] == ["LR"]
    assert found.words < 20 * 20


def test_the_budget_ends_a_search_that_grows_without_bound() -> None:
    found = cycles(TENT, {"a": 2}, 20, budget=Budget(pieces=100))
    assert found.order == 9
    assert found.left_out == (
        "stopped after period 9: 112 words of that length, at most 100 are allowed"
    )
    whole = cycles(TENT, {"a": 2}, found.order)
    assert [c.word for c in found] == [c.word for c in whole]


def test_orders_and_denominators_of_any_size_are_answered() -> None:
    found = cycles(TENT, {"a": 2}, 2**70, budget=Budget(pieces=100))
    assert (found.order, len(found)) == (9, len(cycles(TENT, {"a": 2}, 9)))
    found = cycles(TENT, {"a": "1/2"}, 10**400, budget=Budget(letters=50))
    assert (found.order, len(found)) == (50, 1)
    assert found.left_out == "stopped after period 50: words of at most 50 letters are allowed"
    with pytest.raises(BudgetError, match="the fractions up to the denominator 1000"):
        farey(10**400)


def test_what_is_completed_is_kept_if_it_is_interrupted() -> None:
    told: list[Progress] = []
    ended: list[bool] = []

    def stop(done: Progress) -> None:
        told.append(done)
        if done.order == 6:
            raise KeyboardInterrupt

    found = cycles(
        TENT, {"a": 2}, 20, progress=stop, on_interrupt=lambda: ended.append(True)
    )  # fmt: skip
    assert ended == [True]
    assert found.left_out == f"stopped after period {found.order}: interrupted"
    assert [c.word for c in found] == [c.word for c in cycles(TENT, {"a": 2}, found.order)]
    assert [done.order for done in told] == [1, 2, 3, 4, 5, 6]
    with pytest.raises(KeyboardInterrupt):
        cycles(TENT, {"a": 2}, 20, progress=stop)
