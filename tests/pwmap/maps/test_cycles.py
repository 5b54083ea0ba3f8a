"""Cycles by words, against composition, brute force with fractions and numbers of necklaces."""

from fractions import Fraction

import brute
import pytest
import sympy
from brute import spelled
from certified import LETTERS, random_map, read
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


def test_exact_points_and_numbers_of_sympy_are_computed_with_together() -> None:
    """x = sqrt(2) x + 1 is -1 - sqrt(2) (before: a TypeError, or a number that is none)."""
    (cycle,) = cycles(PiecewiseLinearMap.from_sympy("a*x + 1"), {"a": sqrt(2)}, 1)
    (x,) = cycle.exact_points
    assert (x + sqrt(2), sqrt(2) + x, x * 1) == (-1, -1, x)
    assert sympy.expand(2 * x / sqrt(2)) == -2 - sqrt(2)
    assert x < -sqrt(2) < x + 2


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


def test_random_maps_by_brute_force() -> None:
    """Of fractions: all cycles that lie in no interval of such, from each of their points on."""
    through_breaks = 0
    for seed in range(150):
        f = random_map(seed)
        found = cycles(read(f), order=5)
        for period in range(1, 6):
            fixed = {p.x: p for p in brute.fixed_points(f, period) if p.period == period}
            own = found.of_period(period)
            points = {Fraction(str(x)): (c, k) for c in own for k, x in enumerate(c.points)}
            assert points.keys() == fixed.keys(), (seed, period)
            assert len(points) == period * len(own)
            for x, (cycle, k) in points.items():
                word = spelled(LETTERS, fixed[x].word)
                assert cycle.word[k:] + cycle.word[:k] == word, (seed, x)
                if cycle.at_break:
                    through_breaks += 1
                else:
                    assert cycle.multiplier == sympy.Rational(str(fixed[x].multiplier)), (seed, x)
                    assert cycle.stable is fixed[x].stable, (seed, x)
            at_breaks = [any(fixed[Fraction(str(x))].at_border for x in c.points) for c in own]
            assert [c.at_break for c in own] == at_breaks, (seed, period)
    assert through_breaks > 50


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
    with pytest.raises(BudgetError, match="denominators up to about 1e"):
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
