"""The long run of maps at one place: closed forms, and brute force with exact numbers."""

import math
from fractions import Fraction
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import sympy
from effort import at_most
from sympy import QQ, Interval, Rational, log, sqrt

from pwmap import Budget, PiecewiseLinearMap, RealRoot, dynamics
from pwmap.algebra.exact import pair
from pwmap.algebra.numbers import Element, Exact
from pwmap.algebra.roots import algebraic, real_to_sympy
from pwmap.longrun import Extremum
from pwmap.longrun.attractors import expanded
from pwmap.longrun.line import AffinePiece, line_of
from pwmap.maps import Meter

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
BETA = PiecewiseLinearMap.from_sympy("Piecewise((b*x, x < 1/b), (b*x - 1, True))", given=["b > 1"])
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((r - 2 + b*x, x <= 0), (r - a*x, True))")
GOLDEN = (1 + sqrt(5)) / 2


# --- Attractors ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "bands"),
    [(Rational(3, 2), 1), (Rational(7, 5), 2), (Rational(6, 5), 2), (Rational(11, 10), 4),
     (Rational(21, 20), 8)],
)  # fmt: skip
def test_bands_of_the_tent_map_double(a: Rational, bands: int) -> None:
    """They merge at 2^(1/2), 2^(1/4), 2^(1/8); the outer ends are the first images of the break."""
    (found,) = dynamics(TENT, {"a": a}).attractors
    assert len(found.bands) == bands
    assert found.bands[-1].end == a / 2
    assert found.bands[0].start == a * (1 - a / 2)
    assert found.period == bands
    assert found.basin == (Interval.open(0, 1),)


def test_bands_touch_where_they_merge() -> None:
    """At a^2 = 2 both bands end in the fixed point a/(1 + a), and still do not mix."""
    (found,) = dynamics(TENT, {"a": sqrt(2)}).attractors
    assert len(found.bands) == 1
    assert found.period == 2
    assert not found.is_mixing


def test_cycles_of_the_paper_s_map_attract_and_bands_do_where_it_expands() -> None:
    """With a flat left piece a superstable cycle draws in everything; r - 2 for r < 2."""
    found = dynamics(PAPER, {"r": 1, "a": "5/4", "b": 0})
    assert [(each.word, each.points, each.multiplier) for each in found.attractors] == [
        ("L", (-1,), 0)
    ]
    assert found.entropy.value == 0
    (bands,) = dynamics(PAPER, {"r": 3, "a": "5/4", "b": "3/2"}).attractors
    assert bands.bands == (Interval(Rational(-3, 4), 1), Interval(Rational(7, 4), 3))
    assert bands.is_mixing  # a jump inside a band leads to both


def test_two_attractors_share_the_line() -> None:
    found = dynamics(PAPER, {"r": 1, "a": "1/2", "b": "1/2"})
    assert [each.word for each in found.attractors] == ["L", "R"]
    assert found.attractors[0].basin == (Interval.open(-sympy.oo, 0),)
    assert found.attractors[1].basin == (Interval.open(0, 2),)
    assert found.attractors[1].share((-1, 3)) == Rational(1, 2)


def test_what_escapes_has_no_attractor() -> None:
    found = dynamics(TENT, {"a": "9/4"})
    assert found.attractors == ()
    assert found.absorbing is None
    assert found.entropy.value == log(2)  # of what stays, a Cantor set


def test_a_word_of_slope_minus_one_makes_a_neutral_interval() -> None:
    """3 - x turns (1, 2) about 3/2; all beyond comes there, or to the points 0, 3 of slope 3."""
    found = dynamics(PiecewiseLinearMap.from_sympy("Piecewise((3 - x, x < 2), (9 - 3*x, True))"))
    (each,) = found.attractors
    assert str(each) == "1 neutral interval of L: (1, 2)"
    assert each.neutral == (Interval.open(1, 2),)
    assert (each.period, each.multiplier, each.exponent) == (2, -1, 0)
    assert each.is_neutral
    assert not each.is_chaotic
    assert each.basin == (Interval.open(1, 2),)
    assert not each.basin_is_complete  # 9 - 3 x takes (7/3, 8/3) there
    assert Interval.open(Rational(7, 3), Rational(8, 3)) in each.whole_basin.parts
    closed = dynamics(PiecewiseLinearMap.from_sympy("Piecewise((3 - x, x <= 2), (9 - 3*x, True))"))
    assert closed.attractors[0].neutral == (Interval(1, 2),)


def test_a_line_that_is_turned_takes_an_algebraic_value() -> None:
    (each,) = dynamics(PiecewiseLinearMap.from_sympy("a - x"), {"a": sqrt(2)}).attractors
    assert (each.multiplier, each.period) == (-1, 2)


def test_rotations_by_rationals_are_neutral_everywhere() -> None:
    """x + 3/7 mod 1 has period 7: each seventh is a cylinder, with its left end."""
    rotation = "Piecewise((x + 3/7, x < 4/7), (x - 4/7, x < 1), (x/2, True))"
    (each,) = dynamics(PiecewiseLinearMap.from_sympy(rotation)).attractors
    assert each.period == 7
    assert each.neutral == tuple(Interval.Ropen(Rational(k, 7), Rational(k + 1, 7))
                                 for k in range(7))  # fmt: skip


@pytest.mark.slow
def test_neutral_intervals_take_time_in_proportion_to_their_number() -> None:
    """x + 2/481 mod 1 has 481 of them, each with its left end, of which one orbit tells."""
    text = "Piecewise((x + 2/481, x < 479/481), (x - 479/481, x < 1), (x/2, True))"
    with at_most(1_200_000):
        (each,) = dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
    assert each.neutral == tuple(
        Interval.Ropen(Rational(k, 481), Rational(k + 1, 481)) for k in range(481)
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [("x/2 + 1", "cycle A through 2"), ("7", "cycle A through 7"), ("-x/3", "cycle A through 0"),
     ("3 - x", "1 neutral interval of A: (-oo, oo)"), ("x", "1 neutral interval of A: (-oo, oo)"),
     ("x + 1", ""), ("2*x", ""), ("-2*x", "")],
)  # fmt: skip
def test_maps_of_one_piece_have_attractors(text: str, expected: str) -> None:
    found = dynamics(PiecewiseLinearMap.from_sympy(f"Piecewise(({text}, True))"))
    assert [str(each) for each in found.attractors] == [expected] * bool(expected)
    assert all(each.whole_basin.parts == (Interval(-sympy.oo, sympy.oo),)
               for each in found.attractors)  # fmt: skip
    assert found.attractors.left_out == ""


def test_basins_are_complete_only_where_nothing_comes_from_elsewhere() -> None:
    text = "Piecewise((x/2, x < 1), (x + 1, x < 10), (-1, True))"
    (each,) = dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
    assert each.basin == (Interval.open(-sympy.oo, 1),)
    assert not each.basin_is_complete
    assert each.whole_basin.parts == (Interval(-sympy.oo, sympy.oo),)
    assert each.whole_basin.complete
    text = "Piecewise((x/5 + 17/30, x < 1/3), (5/3 - 5*x/2, True))"
    (each,) = dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
    assert not each.basin_is_complete  # from the right the second piece comes to it, as from 2
    isolated = "Piecewise((x/2, x < 1), (2*x, x < 5), (0, x <= 5), (2*x, True))"
    (each,) = dynamics(PiecewiseLinearMap.from_sympy(isolated)).attractors
    assert each.basin == (Interval.open(-sympy.oo, 1),)
    assert not each.basin_is_complete
    assert set(each.whole_basin.parts[1:]) >= {sympy.FiniteSet(Rational(5, 2)), sympy.FiniteSet(5)}


@pytest.mark.parametrize(
    ("text", "basin"),
    [("Piecewise((x/2, x < 0), (2*x, x < 1/2), (2 - 2*x, True))", Interval(-sympy.oo, sympy.oo)),
     ("Piecewise((-3, x < -1), (x/2, x < 0), (2*x, x < 1/2), (2 - 2*x, True))",
      Interval(-1, Rational(3, 2))),
     ("Piecewise((2 - 2*x/3, x < -1/2), (11/6 - x, True))", Interval(-sympy.oo, sympy.oo)),
     ("Piecewise((x/2, x <= 0), (x, x < 1), (1/2, True))", Interval(-sympy.oo, sympy.oo)),
     ("Piecewise((-20, x < -6), (x/2 + 5, x < 0), (2*x, x < 1/2), (2 - 2*x, x < 2), (x - 5, x < 5),"
      " (-20, True))", Interval(0, 1))],
)  # fmt: skip
def test_a_basin_holds_what_comes_to_an_end_of_its_attractor_from_outside(
    text: str, basin: Interval
) -> None:
    """Beside 0 the slope is 1/2; round (-1/2, 7/3) 2/3. In the last 0 and 5 draw in together.

    In the second x < -1 comes to -3, and x > 1 goes to 2 - 2 x, which is less than -1 from 3/2 on.
    """
    (each,) = (each for each in dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
               if not each.points)  # fmt: skip
    assert each.whole_basin.parts == (basin,)
    assert each.whole_basin.complete
    assert each.basin_is_complete
    assert [part.closure for part in each.basin] == [basin]


@pytest.mark.nightly
def test_bands_are_found_where_they_expand_slowly() -> None:
    """The 8 bands of the skew tent map merge to 4 at b = -8.239167880405 for a = 1/2."""
    for b, bands in ((Rational(-33, 4), 4), (Rational(-82392, 10000), 4),
                     (Rational(-82391, 10000), 8), (Rational(-823682, 100000), 8)):  # fmt: skip
        (each,) = dynamics(SKEW, {"a": "1/2", "b": b}).attractors
        assert len(each.bands) == bands
    assert len(dynamics(TENT, {"a": "26/25"}).attractors[0].bands) == 16


@pytest.mark.slow
def test_bands_are_not_told_where_smaller_ones_may_lie_inside() -> None:
    """At 1001/1000 there are 512, whose gaps are shorter than the sides from which they grow."""
    found = dynamics(TENT, {"a": "1001/1000"}).attractors
    assert found == ()
    assert repr(found) == "(incomplete: open beside the break 1/2)"


@pytest.mark.parametrize(("mu", "period"), [("-9/7", 9), ("-5/4", 17), ("-17/14", 65)])
def test_a_side_of_a_break_may_attract_all_others(mu: str, period: int) -> None:
    """The left side of -1 returns to itself with slope 1/2; random points come ever closer to it.

    The break itself is mapped elsewhere, so that no cycle attracts. Fifty thousand units of work
    are a thousandth of what is allowed; without the sides that attract it would not be enough.
    """
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x/2 + mu + 1, x < -1), (mu - 2*x, x < 1), (x/2 + mu - 1, True))"
    )
    seen = dynamics(map_, {"mu": mu}, budget=Budget(work=50_000))
    assert (seen.open, seen.attractors.cause, len(seen.attractors)) == ((-1,), "", 0)
    value = Fraction(mu)

    def image(x: Fraction) -> Fraction:
        return -2 * x + value if -1 <= x < 1 else x / 2 + value + (1 if x < -1 else -1)

    for start in np.random.default_rng(1).integers(-1000, 1000, 4).tolist():
        x, gaps = Fraction(start, 997), list[Fraction]()
        for _ in range(60 * period):
            x = image(x)
            if -1 - Fraction(1, 2**20) < x < -1:
                gaps.append(-1 - x)
        assert len(gaps) > 5
        assert all(after == before / 2 for before, after in pairwise(gaps))


def test_bands_are_judged_by_words_that_expand_by_more_than_two() -> None:
    """At 3/2 these have two letters; the image [3/8, 21/32] is that of LR."""
    line, ends = line_of(TENT, {"a": Rational(3, 2)}), (QQ(3, 8), QQ(3, 4))
    images = {ends, (QQ(9, 16), QQ(3, 4)), (QQ(3, 8), QQ(21, 32))}
    assert expanded(line, (ends,), Meter(Budget())) == images


def test_long_numbers_take_little_work() -> None:
    """A slope of 80 digits: 10 million units at most, about a fifth of what is allowed."""
    a = Rational("1.4" + 8 * "1234567891")
    (each,) = dynamics(TENT, {"a": a}, budget=Budget(work=10_000_000)).attractors
    assert len(each.bands) == 2
    assert each.bands[-1].end == a / 2
    found = dynamics(TENT, {"a": a}, budget=Budget(work=100_000)).attractors
    assert not len(found)
    assert found.open == (Rational(1, 2),)
    assert found.left_out.endswith("more than 100000 units of work are needed")


@pytest.mark.parametrize("mu", ["-295/243", "-167/139"])
def test_late_images_take_time_in_proportion_to_their_work(mu: str) -> None:
    """Of hundreds of intervals, a step adds a few or changes the ends of a few."""
    text = "Piecewise((x/2 + mu + 1, x < -1), (mu - 2*x, x < 1), (x/2 + mu - 1, True))"
    budget = Budget(work=300_000)
    with at_most(400_000):  # 190 000 and 330 000; where all were sorted and compared, 750 000
        found = dynamics(PiecewiseLinearMap.from_sympy(text), {"mu": mu}, budget=budget).attractors
    assert found.cause == "more than 300000 units of work are needed"


def test_a_budget_that_is_used_up_leaves_bounds() -> None:
    few = dynamics(SKEW, {"a": "1/2", "b": "-7/3"}, budget=Budget(work=200)).entropy
    assert few.value is None
    assert few.low == 0.0
    assert math.log(2) <= few.high < math.nextafter(math.log(2), math.inf) + 1e-15
    assert few.left_out == "stopped after order 0: more than 200 units of work are needed"


@pytest.mark.parametrize(
    ("text", "ends"),
    [("Piecewise((1/2, x < 1), (1/4, True))", (Rational(1, 4), 1)),
     ("Piecewise((x/2, x < 1), (5, True))", (0, 5)),
     ("Piecewise((x/2 - 1, x < 0), (3 - x/2, True))", (-2, 3)),
     ("Piecewise((-x/2 - 1, x < 0), (3 - x/3, True))", (-1, 3))],
)  # fmt: skip
def test_the_absorbing_interval_holds_breaks_and_is_mapped_into_itself(
    text: str, ends: tuple[object, object]
) -> None:
    """Where an outer piece comes ever closer to its fixed point, that is its end."""
    assert dynamics(PiecewiseLinearMap.from_sympy(text)).absorbing == Interval(*ends)


def test_an_enclosed_measure_is_a_double_too() -> None:
    """At 7/4 the density is not exact; both halves of the band have the measure 1 together."""
    (each,) = dynamics(TENT, {"a": "7/4"}).attractors
    density = each.density
    assert density is not None
    low, high = density.places[0], density.places[-1]
    middle = (low + high) / 2
    halves = [density.measure(*pair) for pair in ((low, middle), (middle, high))]
    assert abs(sum(map(float, halves)) - 1.0) < 1e-15  # their width, and a rounding of each
    assert all(abs(half.mid - float(half)) < 2.0**-53 for half in halves)


def test_numbers_of_a_field_in_order() -> None:
    """Also where their doubles are the same, and however well their root is known."""
    close = [QQ(1, 3) + QQ(k, 2**80) for k in (2, -1, 0, 1, -2)]
    assert len({*map(float, close)}) == 1
    root = algebraic(sqrt(2))
    assert isinstance(root, RealRoot)
    elements = [Element(root, root.reduced((c, QQ(1)))) for c in close]
    for _ in range(5):
        assert sorted(elements) == [elements[k] for k in (4, 1, 2, 3, 0)]
        root.refine()


# --- Entropy -------------------------------------------------------------------------------------


@pytest.mark.parametrize("a", [Rational(3, 2), Rational(7, 5), Rational(19, 10)])
def test_the_entropy_of_a_tent_map_is_the_logarithm_of_its_slope(a: Rational) -> None:
    found = dynamics(TENT, {"a": a}).entropy
    assert found.low <= math.log(a) <= found.high
    assert found.high - found.low < 1e-10


@pytest.mark.parametrize(
    ("map_", "values", "growth"),
    [(TENT, {"a": 2}, 2), (TENT, {"a": sqrt(2)}, sqrt(2)), (TENT, {"a": GOLDEN}, GOLDEN),
     (BETA, {"b": 2}, 2), (BETA, {"b": GOLDEN}, GOLDEN)],
)  # fmt: skip
def test_it_is_exact_where_critical_orbits_are_finite(
    map_: PiecewiseLinearMap, values: dict[str, object], growth: sympy.Expr
) -> None:
    found = dynamics(map_, values)
    assert found.is_finite
    assert found.entropy.value is not None
    assert sympy.simplify(sympy.exp(found.entropy.value) - growth) == 0
    assert found.entropy.low <= math.log(growth) <= found.entropy.high


def test_laps_are_counted_as_iterates_have_pieces() -> None:
    map_ = PAPER.at({"r": 3, "a": "5/4", "b": "3/2"})
    pieces = [sum(not c.is_point for c in map_.iterate(n).cylinders) for n in range(1, 10)]
    assert dynamics(map_).laps(9) == pieces


@pytest.mark.nightly
def test_bounds_of_the_entropy_hold_for_a_thousand_maps() -> None:
    """It is the infimum of (log l_n)/n: no lower bound is above any, to order 14.

    Bounds of higher orders lie within those of lower ones. Nothing is allowed for rounding:
    logarithms are enclosed.
    """
    rng = np.random.default_rng(5)
    mpmath.iv.prec = 120
    for _ in range(1000):
        r, a, b = (Fraction(int(rng.integers(*ends)), 16)
                   for ends in ((-20, 80), (-30, 40), (-30, 40)))  # fmt: skip
        found = dynamics(PAPER, {"r": r, "a": a, "b": b}, orders=(8,))
        more = dynamics(PAPER, {"r": r, "a": a, "b": b}, orders=(8, 20)).entropy
        low, high = found.entropy.low, found.entropy.high
        for n, laps in enumerate(found.laps(14), start=1):
            bound = mpmath.iv.log(laps) / n
            assert more.low <= bound.b, (r, a, b, n)
            assert found.entropy.low <= bound.b, (r, a, b, n)
        assert low <= more.low <= more.high <= high, (r, a, b)


# --- Densities -----------------------------------------------------------------------------------


def test_parry_s_density_of_the_golden_mean() -> None:
    """Of x -> b x mod 1 [Parry1960]: two steps, of heights b^3/(1 + b^2) and b^2/(1 + b^2)."""
    (found,) = dynamics(BETA, {"b": GOLDEN}).attractors
    density = found.density
    assert density is not None
    assert density.exact
    heights = [sympy.simplify(real_to_sympy(value)) for value in density.values]
    one = GOLDEN**2 / (1 + GOLDEN**2)
    assert [sympy.simplify(h - e) for h, e in zip(heights, [GOLDEN * one, one], strict=True)] == [
        0,
        0,
    ]
    assert found.exponent is not None
    assert sympy.simplify(found.exponent - log(GOLDEN)) == 0


@pytest.mark.parametrize("b", [Rational(3, 2), Rational(7, 4), Rational(5, 4)])
def test_parry_s_density_where_orbits_do_not_end(b: Rational) -> None:
    """h(x) is proportional to the sum of b^-n over all n with x < T^n(1) [Parry1960]."""
    (found,) = dynamics(BETA, {"b": b}).attractors
    density = found.density
    assert density is not None
    assert not density.exact
    mpmath.mp.prec = 200
    slope = mpmath.mpf(b.p) / b.q
    orbit = [Fraction(1)]
    for _ in range(150):
        x = Fraction(b.p, b.q) * orbit[-1]
        orbit.append(x - 1 if x >= 1 else x)
    total = sum(
        mpmath.mpf(x.numerator) / x.denominator * slope ** (-n) for n, x in enumerate(orbit)
    )
    for low, high, value in list(density.steps())[::7]:
        middle = Fraction(*pair((low + high) / 2))
        exact = sum(slope ** (-n) for n, x in enumerate(orbit) if middle < x) / total
        assert abs(exact - value.mid) < 1e-13  # 150 terms of a series of ratio 4/5 at most


def test_the_exponent_of_a_lorenz_map_of_two_slopes() -> None:
    """x/p below p and (x - p)/(1 - p) above keep Lebesgue's measure: -p log p - (1-p) log(1-p)."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((x/p, x < p), ((x - p)/(1 - p), True))",
                                         given=["p > 0", "p < 1"])  # fmt: skip
    (found,) = dynamics(map_, {"p": "1/3"}).attractors
    assert found.exponent is not None
    exact = -log(Rational(1, 3)) / 3 - 2 * log(Rational(2, 3)) / 3
    assert abs(float(found.exponent - exact)) < 1e-15
    low, high = found.exponent_bounds or (0.0, 0.0)
    assert low <= float(exact) <= high
    assert high - low < 1e-14


@pytest.mark.slow
def test_a_measure_is_asked_for_between_exact_numbers_of_any_kind() -> None:
    """The skew tent map has the heights 1/2 and 3/4; x -> b x mod 1 the left one b^3/(1 + b^2)."""
    (band,) = dynamics(SKEW, {"a": 2, "b": "-3/2"}).attractors
    assert band.density is not None
    for ends in ((0, "1/2"), (Fraction(0), Fraction(1, 2)), ("0", Rational(1, 2))):
        assert Fraction(*pair(band.density.measure(*ends))) == Fraction(3, 8)
    found = real_to_sympy(band.density.measure(0, sympy.sqrt(2) / 2))
    assert sympy.simplify(found - 3 * sympy.sqrt(2) / 8) == 0
    (band,) = dynamics(BETA, {"b": GOLDEN}).attractors
    assert band.density is not None
    for end in (Rational(1, 2), 1 / GOLDEN, 2 - GOLDEN):
        found = real_to_sympy(band.density.measure(0, end))
        assert sympy.simplify(found - end * GOLDEN**3 / (1 + GOLDEN**2)) == 0
    with pytest.raises(ValueError, match="is no number of the field of"):
        band.density.measure(0, sympy.sqrt(2) / 2)


@pytest.mark.nightly
def test_bins_hold_all_of_a_density() -> None:
    """Measures of 16 bins add up to one, exactly or within their enclosures.

    The transfer operator leaves them: a bin has the measure of what is mapped into it. On an
    attractor no other density does that: it is the one of the orbits.
    """
    rng, looked = np.random.default_rng(8), 0
    while looked < 15:
        r, a, b = (Fraction(int(rng.integers(*ends)), 16)
                   for ends in ((33, 80), (18, 30), (18, 30)))  # fmt: skip
        for each in dynamics(PAPER, {"r": r, "a": a, "b": b}).attractors:
            if each.density is None:
                continue
            looked += 1
            density = each.density
            low, high = density.places[0], density.places[-1]
            edges = [low + (high - low) * k / 16 for k in range(17)]
            whole = [density.measure(x, y) for x, y in pairwise(edges)]
            assert sum(whole) == 1 if density.exact else 1 in sum(whole)
            for (x, y), measure in zip(pairwise(edges), whole, strict=True):
                before = [_preimage(branch, x, y) for branch in density.line.branches]
                total = sum(density.measure(*part) for part in before if part is not None)
                assert total == measure if density.exact else 0 in total - measure, (r, a, b)


def _preimage(branch: AffinePiece, x: Exact, y: Exact) -> tuple[Exact, Exact] | None:
    """What a piece maps into an interval."""
    low, high = sorted(
        ((x - branch.intercept) / branch.slope, (y - branch.intercept) / branch.slope)
    )
    low, high = max(low, branch.lower), min(high, branch.upper)
    return (low, high) if low < high else None


# --- Kneading, wrong input -----------------------------------------------------------------------


def test_kneading_sequences_of_the_tent_map() -> None:
    found = dynamics(TENT, {"a": 2})
    assert [each.word for each in found.kneading] == ["LR(L)", "RR(L)"]
    assert {each.fate for each in found.kneading} == {"periodic after a while"}
    assert [(each.letters, each.repeating) for each in found.kneading] == [
        (("L", "R", "L"), 1), (("R", "R", "L"), 1),
    ]  # fmt: skip
    turned = dynamics(PiecewiseLinearMap.from_sympy("Piecewise((1 - x, x <= 0), (0, True))"))
    assert [each.word for each in turned.kneading] == ["LR(LR)", "R(LR)"]  # 0 itself is in L
    drawn = dynamics(PAPER, {"r": 3, "a": "5/4", "b": 0}).kneading[1]
    assert (drawn.letters, drawn.repeating) == (("R",), 0)


def test_min_max_sequences_of_the_tent_map() -> None:
    """At a = 2 the break goes to 1, a maximum, and to 0, a minimum for ever.

    At the golden mean it comes back, 1/2 -> a/2 -> a (1 - a/2) -> 1/2: from both sides the third
    iterate has a minimum there, with points close by on the right, in R.
    """
    assert [str(each.minmax) for each in dynamics(TENT, {"a": 2}).kneading] == ["M^R (m^L)"] * 2
    found = dynamics(TENT, {"a": GOLDEN}).kneading
    assert [str(each.minmax) for each in found] == ["(M^R m^L m^R)"] * 2
    found = dynamics(TENT, {"a": "3/2"}).kneading
    for each in found:  # after the first maximum every R turns, every L keeps
        side = -1
        for extremum, letter in each.minmax.symbols:
            assert extremum is (Extremum.MAXIMUM if side < 0 else Extremum.MINIMUM)
            side = -side if letter == "R" else side
    assert found[0].minmax.start is None
    assert str(found[0].minmax).endswith(" ...")


@pytest.mark.slow
def test_min_max_sequences_are_what_iterates_do_close_to_a_break() -> None:
    """Maps with a jump: the iterate of a point 2^-400 beside it, in fractions, and its limit."""
    rng, looked = np.random.default_rng(11), 0
    for _ in range(60):
        r, a, b = (Fraction(int(rng.integers(*ends)), 16)
                   for ends in ((-40, 80), (-40, 40), (-30, 30)))  # fmt: skip
        for each in dynamics(PAPER, {"r": r, "a": a, "b": b}).kneading:
            symbols, start = each.minmax.symbols, each.minmax.start
            if start is not None:  # the rounds that come again, too
                symbols += symbols[start:] * 40
            x, limit = Fraction(each.side, 2**400), Fraction(0)
            for extremum, letter in symbols[:40]:
                slope, shift = (b, r - 2) if x <= 0 else (-a, r)
                x, limit = slope * x + shift, slope * limit + shift
                side = (x > limit) - (x < limit)
                expected = (Extremum.CONSTANT, Extremum.MINIMUM, Extremum.MAXIMUM)[side]
                assert (extremum, letter) == (expected, "L" if x <= 0 else "R"), (r, a, b)
                looked += 1
    assert looked > 3500


def test_where_a_piece_is_flat_iterates_are_constant() -> None:
    """From 0 on the left: 1 -> 7/4 -> ... in R, by -5/4 x + 3, until L after eight; then again."""
    left, right = dynamics(PAPER, {"r": 3, "a": "5/4", "b": 0}).kneading
    assert str(left.minmax) == f"({'c^R ' * 8}c^L)"
    assert str(right.minmax) == f"M^R m^L ({'c^R ' * 8}c^L)"  # 3, and -3/4


@pytest.mark.slow
def test_a_repelling_point_is_no_attractor_where_a_neighbour_would_attract_it() -> None:
    """At -40/3 both formulas have a fixed point, but the piece there is the one of slope 6/5."""
    two = "Piecewise((6*x/5 + 8/3, x <= -3), (2*x/5 - 8, True))"
    three = "Piecewise((3*x + 2/3, x <= -6), (-10*x/7, x <= 1), (3*x/4, True))"
    for text in (two, three):
        found = dynamics(PiecewiseLinearMap.from_sympy(text))
        assert all(each.is_chaotic for each in found.attractors)


def test_an_orbit_of_long_numbers_is_drawn_into_a_cycle_that_another_one_tells() -> None:
    """From -20 on up by 1 + x/10^4 at most; after 27 steps its numbers are too long to go on, and a
    repeated word would be looked for after 32. It is close to the fixed point beyond 2 by then."""
    slope = f"(10**284 + {28 * '1234567891'})/10**284"
    text = f"Piecewise((x - 1, x < -20), ({slope}*x + 1, x < 0), ({slope}/2*x + 1, True))"
    found = dynamics(PiecewiseLinearMap.from_sympy(text))
    fates = [each.fate for each in found.kneading]
    assert fates == ["lost to infinity", *3 * ["drawn into a cycle"]]
    assert found.is_finite


def test_what_grows_into_orbits_that_are_lost_is_no_attractor() -> None:
    """From -3/2 the left piece leads to -1/2, which 3 x + 1 leaves on both sides; all else is lost
    or stays on a Cantor set. Intervals would grow without end."""
    text = "Piecewise((2*x + 5/2, x <= -3/2), (3*x + 1, True))"
    found = dynamics(PiecewiseLinearMap.from_sympy(text), budget=Budget(work=100_000))
    assert (found.attractors, found.attractors.left_out) == ((), "")


def test_preimages_come_to_a_repelling_point_at_once() -> None:
    """Between 1/2 and 2 the piece 2 x - 2 leads down to (-1, 1/2), in ever more steps closer to 2;
    from there -x/3 - 2 is less than -5/4. The piece up to -1 leads beyond 2, where all is lost."""
    text = "Piecewise((-7/4, x <= -5/4), (x/3 + 3, x <= -1), (-x/3 - 2, x < 1/2), (2*x - 2, True))"
    (each,) = dynamics(PiecewiseLinearMap.from_sympy(text)).attractors
    assert each.whole_basin.parts == (
        Interval(-sympy.oo, Rational(-5, 4)),
        Interval.open(-1, 2),
    )
    assert each.whole_basin.complete


def test_a_cycle_through_a_break_is_open() -> None:
    """16/3 -> -1 -> 16/3: a flat piece draws in, but beside the break another piece leads away."""
    flat = "Piecewise((3*x/4 - 1/3, x <= -3), (16/3, x <= -1), (-x/8 - 1/3, True))"
    found = dynamics(PiecewiseLinearMap.from_sympy(flat))
    assert found.open


def test_nothing_is_a_band_where_no_piece_stretches() -> None:
    """Both slopes are -1: for m in (0, 1) orbits go down by 1 in two steps, to the left of a gap.

    Beside the break an interval stays as long as it is, so that its images would fill no band.
    """
    turned = PiecewiseLinearMap.from_sympy("Piecewise((m - x, x <= 0), (m - 1 - x, True))")
    for m in ("3/5", "1/1000003"):
        found = dynamics(turned, {"m": m}, budget=Budget(work=100_000))  # 20 000 are needed
        assert found.attractors.left_out == "incomplete: open beside the break 0"
    (kept,) = dynamics(turned, {"m": "-2/7"}).attractors
    assert repr(kept) == "Attractor(1 neutral interval of L: [-2/7, 0])"
