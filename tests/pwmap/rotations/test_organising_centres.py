"""Organising centres: where they are, and what brute force finds on small curves around them."""

import re
from fractions import Fraction
from itertools import pairwise

import pytest
import sympy
from brute import coded, cycle_of, map_of, spelled
from independent import Parts, nested
from sympy import Rational, sqrt

from pwmap import PiecewiseLinearMap, UndecidedError, word_family
from pwmap.rotations import (
    CentreKind,
    farey,
    organising_centre,
    organising_centres,
    rotation_number,
    rotational_word,
)

U, V = sympy.symbols("u v")


def normal_form(left: object, right: object) -> PiecewiseLinearMap:
    """Left: s x + u, right: m x - v."""
    return PiecewiseLinearMap([(f"{left}*x + u", "x < 0"), (f"{right}*x - v", "x >= 0")])


# --- Brute force ----------------------------------------------------------------------------------


def lines(
    left: tuple[Fraction, Fraction], right: tuple[Fraction, Fraction], at: Fraction = Fraction(0)
) -> Parts:
    """s x + c left of a break, m x + d from there on."""
    return map_of([at], ["right"], [left, right])


def attractors(f: Parts, starts: int = 9, settle: int = 60, seen: int = 120) -> set[str]:
    """Cycles that orbits come to from both sides of the break; each begins with its last R."""
    found = set()
    top, low = (part(f[0].hi) for part in f)
    for k in range(-1, starts + 1):
        x = nested(f, low + (top - low) * Fraction(k, starts - 1), settle)[0]
        letters = spelled("LR", nested(f, x, seen)[1])
        period = next(q for q in range(1, seen) if letters[q:] == letters[:-q])
        turned = {letters[i : i + period] for i in range(period)}
        assert any(cycle_of(f, coded("LR", word)) is not None for word in turned)
        found.add(max(turned))
    return found


def around(s: Fraction, m: Fraction, ratio: Fraction, size: Fraction) -> Parts:
    """The normal form near (0, 0) with v/u = ratio > 0 on the square |u| + |v| = size."""
    u = size / (1 + ratio)
    return lines((s, u), (m, -ratio * u))


SIZE = Fraction(1, 1000)


# --- Period adding --------------------------------------------------------------------------------


@pytest.mark.nightly
def test_period_adding_between_two_positive_slopes() -> None:
    """One rotational cycle at each place; rotation numbers fall from 1 to 0, mediants in between.

    The quarter is gone through from v = 0 to u = 0.
    """
    s, m = Fraction(1, 2), Fraction(1, 3)
    assert organising_centre(normal_form("1/2", "1/3"), U, V).kind is CentreKind.ADDING

    def rotation(ratio: Fraction) -> Fraction:
        (word,) = attractors(around(s, m, ratio, SIZE))
        number = rotation_number(word)
        plain = rotational_word(number)
        assert word in {plain[k:] + plain[:k] for k in range(len(plain))}
        return number

    ratios = [Fraction(k * k, 400) for k in range(1, 60)]
    seen = [rotation(ratio) for ratio in ratios]
    assert all(first >= second for first, second in pairwise(seen))
    assert {Fraction(1, 2), Fraction(1, 3), Fraction(2, 3), Fraction(1, 4)} <= set(seen)
    for wanted in farey(7)[1:-1]:
        low, high = Fraction(1, 1000), Fraction(1000)
        for _ in range(40):
            middle = (low + high) / 2
            number = rotation(middle)
            if number == wanted:
                break
            low, high = (middle, high) if number > wanted else (low, middle)
        assert number == wanted


# --- Period incrementing --------------------------------------------------------------------------


def height(s: Fraction, n: int) -> Fraction:
    """h_n = (s^-n - 1)/(1 - s)."""
    return (1 / s**n - 1) / (1 - s)


@pytest.mark.nightly
@pytest.mark.parametrize(("s", "t"), [("1/2", "1/3"), ("2/3", "4/5"), ("1/3", "0")])
def test_period_incrementing_between_slopes_of_two_signs(s: str, t: str) -> None:
    """R L^n for h_(n - 1) - t <= v/u < h_n, or with the ends owned otherwise, and nothing else."""
    slope, fall = Fraction(s), Fraction(t)
    map_ = normal_form(s, f"(-{t})")
    centre = organising_centre(map_, U, V)
    assert centre.kind is (CentreKind.INCREMENTING if fall else CentreKind.SEPARATED)
    assert centre.patterns == ("R L^n",)
    step, together = Fraction(1, 10**6), 0
    for n in range(1, 7):
        low, high = height(slope, n - 1) - fall, height(slope, n)
        for ratio in (low - step, low + step, (low + high) / 2, high - fall - step,
                      high - fall + step, high - step, high + step):  # fmt: skip
            if ratio <= 0:
                continue
            expected = {
                "R" + k * "L"
                for k in range(1, 9)
                if height(slope, k - 1) - fall < ratio < height(slope, k)
            }
            found = attractors(around(slope, -fall, ratio, SIZE), starts=25)
            assert found == expected, ratio
            assert 1 <= len(found) <= 2
            if len(found) == 2:
                first, second = sorted(found, key=len)
                assert second == first + "L"
                together += 1
    assert (together > 5) is (fall > 0)


@pytest.mark.slow
def test_patterns_and_thresholds_of_a_centre_agree_with_its_family() -> None:
    """Both borders of R L^n in v, in symbols: h_n u and (h_(n - 1) - t) u."""
    s, t = sympy.symbols("s t")
    map_ = PiecewiseLinearMap(
        [("s*x + u", "x < 0"), ("-t*x - v", "x >= 0")], given=["s > 0", "s < 1", "t > 0", "t < 1"]
    )
    centre = organising_centre(map_, U, V)
    assert (centre.kind, centre.slopes) == (CentreKind.INCREMENTING, (s, -t))
    family = word_family(map_, centre.patterns[0])
    power = s**-family.n
    closed = (power - 1) / (1 - s) * U, ((s * power - 1) / (1 - s) - t) * U
    for threshold, end in zip(family.thresholds(V), closed, strict=True):
        assert sympy.simplify(threshold - end) == 0


# --- Two negative slopes, and others --------------------------------------------------------------


@pytest.mark.nightly
def test_two_negative_slopes_have_a_cycle_of_two_points_and_fixed_points() -> None:
    """L R for v > -t u or u > -s v; R for v < 0, L for u < 0 (here with the break on the right)."""
    s, t = Fraction(1, 2), Fraction(2, 3)
    assert organising_centre(normal_form("(-1/2)", "(-2/3)"), U, V).kind is CentreKind.ALTERNATING
    shown = set()
    edges = [Fraction(k, 6) for k in range(-6, 7)]
    square = [(a, b) for a in edges for b in edges if max(abs(a), abs(b)) == 1]
    for a, b in square:
        u, v = SIZE * (a + Fraction(1, 100)), SIZE * (b + Fraction(1, 70))  # on no border
        expected = {"R"} if v < 0 else set()
        expected |= {"L"} if u < 0 else set()
        if v > -t * u and u > -s * v:
            expected |= {"RL"}
        assert attractors(lines((-s, u), (-t, -v)), starts=17) == expected, (u, v)
        shown.add(frozenset(expected))
    assert {frozenset(x) for x in (["RL"], ["R", "RL"], ["L", "RL"], ["L", "R"])} <= shown


@pytest.mark.parametrize(
    ("left", "right", "kind"),
    [
        ("0", "0", CentreKind.ALTERNATING),
        ("0", "(-1/2)", CentreKind.ALTERNATING),
        ("0", "1/2", CentreKind.SEPARATED),
        ("(-1/2)", "1/2", CentreKind.INCREMENTING),
        ("1/2", "1", CentreKind.EXPANDING),
        ("3/2", "(-1/2)", CentreKind.EXPANDING),
    ],
)
def test_kinds(left: str, right: str, kind: CentreKind) -> None:
    assert organising_centre(normal_form(left, right), "u", "v").kind is kind


def test_the_letter_that_is_repeated_has_the_positive_slope() -> None:
    assert organising_centre(normal_form("(-1/2)", "1/2"), U, V).patterns == ("L R^n",)
    assert organising_centre(normal_form("1/3", "1/2"), U, V).patterns == ("R L^n", "L R^n")


# --- Where ----------------------------------------------------------------------------------------


def test_centres_with_other_parameters_and_a_moving_break() -> None:
    s, t, p = sympy.symbols("s t p")
    map_ = PiecewiseLinearMap(
        [("s*x + u + p", "x < p"), ("t*x - v", "x >= p")], given=["0 < s < 1", "0 < t < 1"]
    )
    centre = organising_centre(map_, "u", "v")
    assert centre.x == p
    assert sympy.expand(centre.values[0] + s * p) == 0
    assert sympy.expand(centre.values[1] - (t - 1) * p) == 0
    assert centre.kind is CentreKind.ADDING
    with pytest.raises(UndecidedError, match="the sign of"):
        organising_centre(PiecewiseLinearMap([("s*x + u", "x < 0"), ("x/2 - v", "x >= 0")]), U, V)


CURVED = PiecewiseLinearMap([("u*x/2 + u**3 - v - 1", "x < v"), ("u*x/3 - v + u*v", "x >= v")])


@pytest.mark.slow
def test_rational_centres_of_curved_equations_and_what_lives_there() -> None:
    """L(v) = v and R(v) = v: v (4 u/3 - 2) = 0, so v = 0 with u^3 = 1, or u = 3/2 with v = 19/10.

    Around (1, 0) the slopes are near 1/2 and 1/3: every orbit comes to one rotational cycle.
    """
    first, second = organising_centres(CURVED, U, V)
    assert (first.values, first.x, first.slopes) == ((1, 0), 0, (Rational(1, 2), Rational(1, 3)))
    assert second.values == (Rational(3, 2), Rational(19, 10))
    assert second.slopes == (Rational(3, 4), Rational(1, 2))
    assert first.kind is second.kind is CentreKind.ADDING
    numbers = []
    for k in range(1, 40):
        tau = Fraction(k, 40)
        u = 1 + SIZE * (1 - tau**2) / (1 + tau**2)
        v = SIZE * 2 * tau / (1 + tau**2)
        f = lines((u / 2, u**3 - v - 1), (u / 3, u * v - v), v)
        if f[0](v) > v > f[1](v):
            (word,) = attractors(f, starts=5)
            numbers.append(rotation_number(word))
    assert all(first >= second for first, second in pairwise(numbers))
    assert len(set(numbers)) >= 5


def test_algebraic_centres() -> None:
    pieces = [("x/2 + u**2 - 2", "x < 0"), ("x/3 - v + u", "x >= 0")]
    low, high = (-sqrt(2), -sqrt(2)), (sqrt(2), sqrt(2))
    for over in ((U, V), (V, U)):
        found = organising_centres(PiecewiseLinearMap(pieces), *over)
        assert [centre.values for centre in found] == [low, high]
    half = PiecewiseLinearMap(pieces, given=["u > 0"])
    assert organising_centre(half, U, V).values == high
    circle = PiecewiseLinearMap(
        [("x/2 + u**2 + v**2 - 1", "x < 0"), ("v*x + v**2 - 1/4", "x >= 0")]
    )
    u, v = sqrt(3) / 2, Rational(1, 2)
    assert {centre.values: centre.kind for centre in organising_centres(circle, U, V)} == {
        **dict.fromkeys([(-u, v), (u, v)], CentreKind.ADDING),
        **dict.fromkeys([(-u, -v), (u, -v)], CentreKind.INCREMENTING),
    }


def test_a_fold_of_both_limits_is_degenerate() -> None:
    map_ = PiecewiseLinearMap([("x/2 + (u - v)**2", "x < 0"), ("x/3 - v + 1", "x >= 0")])
    centre = organising_centre(map_, U, V)
    assert (centre.values, centre.kind) == ((1, 1), CentreKind.DEGENERATE)
    flat = PiecewiseLinearMap([("x/2 + u*v", "x < 0"), ("x/3 + u**2 - v**2", "x >= 0")])
    centre = organising_centre(flat, U, V)
    assert (centre.values, centre.kind) == ((0, 0), CentreKind.DEGENERATE)


def test_centres_above_one_another_are_told_apart() -> None:
    """A grid of nine: neither parameter is an abscissa for them all."""
    grid = PiecewiseLinearMap([("x/2 + u**3 - u", "x < 0"), ("x/3 + v**3 - 4*v", "x >= 0")])
    found = {centre.values for centre in organising_centres(grid, U, V)}
    assert found == {(u, v) for u in (-1, 0, 1) for v in (-2, 0, 2)}


EQUATIONS = [
    ([("v*x + u", "x < 0"), ("x/3 + u + 1", "x >= 0")],
     "expected one organising centre in (u, v), got 0: none"),
    ([("u*x/2 + u**3 - v - 1", "x < v"), ("u*x/3 - v + u*v", "x >= v")],
     "got 2: (1, 0), (3/2, 19/10)"),
    ([("x/2 + (u - v)*u", "x < 0"), ("x/3 + (u - v)*v", "x >= 0")],
     "along a curve in (u, v), no point"),
    ([("x/2 + u**2 - p", "x < 0"), ("x/3 - v", "x >= 0")],
     "the other parameters, p, must have values"),
    ([("u*x + v", "x > 0 or x <= 0")], "expected a map of two pieces"),
]  # fmt: skip


@pytest.mark.parametrize(("pieces", "message"), EQUATIONS)
def test_maps_without_one_centre_are_refused(pieces: list[tuple[str, str]], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        organising_centre(PiecewiseLinearMap(pieces), U, V)
