"""Rotational words, tongues and rotation numbers, against closed formulas and brute force."""

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import islice, pairwise, product
from math import gcd

import pytest
import sympy
from brute import coded, cycle_of, map_of
from independent import nested
from readings import rational as fraction
from sympy import Interval, Rational

from pwmap import PiecewiseLinearMap, tongues
from pwmap.rotations import (
    Tongue,
    farey,
    rotation_interval,
    rotation_number,
    rotation_number_at,
    rotational_word,
)

ROTATION = PiecewiseLinearMap(
    [("a*x + d", "x < (1 - d)/a"), ("a*x + d - 1", "x >= (1 - d)/a")], given=["a > 0", "a < 1"]
)
GAP = PiecewiseLinearMap([("s*x + d", "x < 0"), ("t*x + d - 1", "x >= 0")])
CONTRACTIONS = [Rational(1, 3), Rational(1, 2), Rational(4, 5)]
Q_MAX = 12


def rational(number: Fraction) -> sympy.Rational:
    """A fraction as sympy has it."""
    return Rational(number.numerator, number.denominator)


# --- Words ----------------------------------------------------------------------------------------


def test_farey_fractions() -> None:
    assert " ".join(map(str, farey(5))) == "0 1/5 1/4 1/3 2/5 1/2 3/5 2/3 3/4 4/5 1"
    for q in (1, 2, 12, 40):
        found = farey(q)
        assert len(found) == 1 + sum(sympy.totient(k) for k in range(1, q + 1))
        for low, high in pairwise(found):  # neighbours have determinant 1
            assert high.numerator * low.denominator - low.numerator * high.denominator == 1


def test_rotational_words_are_those_of_rotations() -> None:
    for rotation in farey(Q_MAX):
        x, word = Fraction(0), ""
        for _ in range(rotation.denominator):
            word += "R" if x + rotation >= 1 else "L"
            x = (x + rotation) % 1
        assert rotational_word(rotation) == word
        assert rotation_number(word) == rotation
    assert rotational_word(Rational(2, 5), "ab") == "aabab"


# --- Contracted rotations -------------------------------------------------------------------------


def closed_tongue(a: sympy.Rational, rotation: Fraction) -> tuple[sympy.Expr, sympy.Expr]:
    """Where x -> a x + d mod 1 has rotation number p/q: d from ... up to, but for, ...

    At the lower end the leftmost point of the cycle is 0. With the letters w_k = 0, 1 of the
    rotational word, that point is (d - (1 - a) S/(1 - a^q))/(1 - a), S the sum of
    a^(j - 1) w_(q - j), j = 1 ... q. The width is (1 - a)^2 a^(q - 1)/(1 - a^q)
    [Bugeaud1993; Laurent2018]. (For 0/1 and 1/1 d is not reduced modulo 1.)
    """
    p, q = rotation.as_integer_ratio()
    letters = [(k + 1) * p // q - k * p // q for k in range(q)]
    total = sum(a ** (j - 1) * letters[q - j] for j in range(1, q + 1))
    lower = (1 - a) * total / (1 - a**q)
    return lower, lower + width(a, q)


def width(a: sympy.Rational, q: int) -> sympy.Expr:
    """Of a tongue of denominator q."""
    return (1 - a) ** 2 * a ** (q - 1) / (1 - a**q)


@cache
def contracted(a: sympy.Rational) -> tuple[Tongue, ...]:
    return tongues(ROTATION.at({"a": a}), Q_MAX)


@pytest.mark.slow
@pytest.mark.parametrize("a", CONTRACTIONS)
def test_all_tongues_of_contracted_rotations(a: sympy.Rational) -> None:
    found = contracted(a)
    assert tuple(tongue.rotation for tongue in found) == farey(Q_MAX)
    for tongue in found:
        lower, upper = closed_tongue(a, tongue.rotation)
        assert tongue.multiplier == a**tongue.rotation.denominator
        if 0 < tongue.rotation < 1:
            assert (tongue.lower, tongue.upper) == (lower, upper)
            assert tongue.values == Interval.Ropen(lower, upper)
        else:  # fixed points: one border each
            ends = Interval.open(-sympy.oo, upper), Interval(lower, sympy.oo)
            assert tongue.values == ends[int(tongue.rotation)]


@pytest.mark.slow
def test_borders_with_two_symbols_are_conditions_of_the_cycle() -> None:
    a, d = sympy.symbols("a d")
    for tongue in tongues(ROTATION, 5):
        assert set(tongue.borders) <= set(tongue.cycle.conditions)
        assert len(tongue.borders) == (2 if 0 < tongue.rotation < 1 else 1)
        lower, upper = closed_tongue(a, tongue.rotation)
        for border, end in zip(tongue.borders, (upper, lower)[-len(tongue.borders) :], strict=True):
            if 0 < tongue.rotation < 1:
                assert sympy.cancel((border.lhs - border.rhs).subs(d, end)) == 0
        with pytest.raises(ValueError, match="exactly one parameter, it has a, d"):
            _ = tongue.values


def test_ends_in_the_slope_are_algebraic() -> None:
    """At d = 3/5: 1/2 is locked from 1/(1 + a) = d to (1 + a - a^2)/(1 + a) = d, 1/3 alike."""
    a, d = sympy.Symbol("a"), Rational(3, 5)
    none, third, half, two_thirds, one = tongues(ROTATION.at({"d": d}), 3)
    assert none.values == Interval.open(0, Rational(2, 5))
    assert half.values == Interval.Ropen(Rational(2, 3), (1 + sympy.sqrt(11)) / 5)
    assert third.lower == -Rational(1, 2) + sympy.sqrt(33) / 6
    assert sympy.minimal_polynomial(third.upper, a) == 5 * a**3 - 2 * a**2 + 3 * a - 2
    assert two_thirds.values is one.values is sympy.EmptySet
    for tongue in (third, half):
        for formula, end in zip(
            closed_tongue(a, tongue.rotation), (tongue.lower, tongue.upper), strict=True
        ):
            top = sympy.fraction(sympy.cancel(formula - d))[0]
            assert sympy.rem(top, sympy.minimal_polynomial(end, a), a) == 0


@pytest.mark.nightly
@pytest.mark.parametrize("slopes", [("1/2", "3/4"), ("2", "1/3"), ("5/4", "9/8"), ("1", "1/2")])
def test_tongues_of_two_slopes_hold_where_brute_force_finds_the_cycle(
    slopes: tuple[str, str],
) -> None:
    """Two conditions against all q, also where pieces overlap and cycles repel."""
    s, t = map(Fraction, slopes)
    map_ = GAP.at({"s": rational(s), "t": rational(t)})
    found = [tongue for tongue in tongues(map_, 9) if len(tongue.word) > 1]
    assert len(found) == len(farey(9)) - 2
    for tongue in found:
        low, high = fraction(tongue.lower), fraction(tongue.upper)
        step = (high - low) / 100
        for d in (low - step, low, low + step, (low + high) / 2, high - step, high, high + step):
            f = map_of([Fraction(0)], ["right"], [(s, d), (t, d - 1)])
            fits = cycle_of(f, coded("LR", tongue.word)) is not None
            assert (rational(d) in tongue.values) == fits, (tongue.rotation, d)


def test_words_of_slope_1_have_no_tongue() -> None:
    assert [t.word for t in tongues(GAP.at({"s": 1, "t": Rational(1, 2)}), 2)] == ["LR", "R"]
    assert tongues(GAP.at({"s": 1, "t": 1}), 3) == ()


def test_a_tongue_may_be_empty() -> None:
    up = PiecewiseLinearMap([("x/2 + p", "x < 0"), ("x/2 + p + 1", "x >= 0")])
    middle = tongues(up, 2)[1]
    assert middle.values is sympy.EmptySet
    with pytest.raises(ValueError, match="the cycle LR exists for no admitted value"):
        _ = middle.lower


# --- Rotation numbers -----------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("a", CONTRACTIONS)
def test_rotation_numbers_inside_at_and_outside_of_tongues(a: sympy.Rational) -> None:
    inner = contracted(a)[1:-1]
    for tongue in inner:
        middle = (tongue.lower + tongue.upper) / 2
        for d in (tongue.lower, middle, tongue.upper):  # at the upper end as a limit
            found = rotation_number_at(ROTATION.at({"a": a, "d": d}))
            assert found.exact
            assert found.lower == tongue.rotation
    for low, high in pairwise(inner):
        found = rotation_number_at(ROTATION.at({"a": a, "d": (low.upper + high.lower) / 2}))
        assert found.exact
        assert low.rotation < found.lower < high.rotation


@pytest.mark.slow
def test_bounds_when_iterates_run_out_are_neighbours() -> None:
    map_ = GAP.at({"s": Rational(99, 100), "t": Rational(99, 100), "d": Rational(382, 1000)})
    full = rotation_number_at(map_)
    assert full.exact
    for iterates in range(2, full.iterates):
        bounds = rotation_number_at(map_, iterates)
        assert bounds.lower <= full.lower <= bounds.upper
        (a, b), (c, d) = bounds.lower.as_integer_ratio(), bounds.upper.as_integer_ratio()
        assert bounds.exact or b * c - a * d == 1


# --- Overlapping pieces ---------------------------------------------------------------------------


def rotational_cycles(s: Fraction, t: Fraction, d: Fraction, q_max: int) -> Iterator[Fraction]:
    """By brute force: rotation numbers of *all* cycles of s x + d | t x + d - 1 up to a period.

    Fixed points outside of [d - 1, d] belong to no circle map: they repel what leaves it.
    """
    f = map_of([Fraction(0)], ["right"], [(s, d), (t, d - 1)])
    for q in range(1, q_max + 1):
        for letters in product("LR", repeat=q):
            rights = letters.count("R")
            if s ** (q - rights) * t**rights == 1:
                continue
            x = cycle_of(f, coded("LR", "".join(letters)))
            if x is not None and all(d - 1 <= nested(f, x, k)[0] <= d for k in range(q)):
                yield Fraction(rights, q)


OVERLAPPING = [("3/2", "5/4", "2/5"), ("6/5", "6/5", "1/2"), ("8/7", "9/7", "3/7"),
               ("1/2", "2", "2/5"), ("11/10", "11/10", "13/25"), ("21/20", "19/20", "5/8"),
               ("101/100", "103/100", "7/11"), ("1/3", "3/2", "1/2")]  # fmt: skip


@pytest.mark.nightly
@pytest.mark.parametrize("values", OVERLAPPING)
def test_rotation_intervals_hold_just_the_cycles_there_are(values: tuple[str, str, str]) -> None:
    s, t, d = map(Fraction, values)
    map_ = GAP.at(dict(zip("std", values, strict=True)))
    found = rotation_interval(map_)
    low, high = found.least, found.greatest
    assert low.exact
    assert high.exact
    seen = set(rotational_cycles(s, t, d, 9))
    strict = {f for f in farey(9) if low.lower < f < high.lower}
    assert strict <= seen <= strict | {low.lower, high.lower}
    words = {f for f in farey(9) if f in seen and map_.cycle(rotational_word(f)).admissible}
    assert words == seen  # one of them is rotational, for each number


def test_pieces_that_overlap_have_several_rotation_numbers() -> None:
    map_ = GAP.at({"s": Rational(3, 2), "t": Rational(5, 4), "d": Rational(2, 5)})
    with pytest.raises(ValueError, match=r"fill an interval from 1/4 to 3/8: ask for rotation_int"):
        rotation_number_at(map_)


def test_orbits_that_leave_have_no_rotation_number() -> None:
    with pytest.raises(ValueError, match="no bounded interval around the break"):
        rotation_interval(GAP.at({"s": 2, "t": 2, "d": Rational(1, 5)}))
    up = PiecewiseLinearMap([("x/2 - 1", "x < 0"), ("x/2 + 1", "x >= 0")])
    with pytest.raises(ValueError, match="both pieces map into themselves"):
        rotation_interval(up)
    fixed = rotation_interval(GAP.at({"s": Rational(1, 2), "t": 2, "d": -1}))
    assert (fixed.least.lower, fixed.greatest.upper) == (0, 0)


def test_a_plain_rotation() -> None:
    """Slopes 1: the rotation by d itself, which every orbit shares."""
    for d in islice((f for f in farey(30) if gcd(f.numerator, 30) == 1), 1, 40):
        found = rotation_number_at(GAP.at({"s": 1, "t": 1, "d": rational(d)}))
        assert (found.lower, found.upper) == (d, d)
