"""Intervals on which the entropy is constant: closed forms, and other proofs at random places."""

import random
from collections.abc import Iterator
from itertools import pairwise

import pytest
import sympy
from sympy import QQ, Rational, log, sqrt
from sympy.polys.rings import PolyElement

from pwmap import Budget, PiecewiseLinearMap, constant_entropy, dynamics
from pwmap.algebra.roots import Real, real_to_sympy, simplest_between
from pwmap.longrun import ConstantEntropy, EntropyIntervals, GapCause
from pwmap.longrun.entropy.kneading import RING, T, growth_by_kneading, itinerary_of
from pwmap.longrun.entropy.matching import (
    MATCHED_PAIR,
    PairEdge,
    _growth,
    family_of,
    growth_of_pairs,
    matched,
)
from pwmap.longrun.line import MapLine, line_of
from pwmap.maps.budget import Meter

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((x/2 + 1, x <= 0), (b*x + 1, True))")
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((b*x + r - 2, x <= 0), (r - a*x, True))")
HALF = PAPER.at({"a": "5/4", "b": "1/2"})
FALLING = PAPER.at({"a": "5/4", "b": "-3/4"})
LORENZ = PiecewiseLinearMap.from_sympy("Piecewise((3*x/4 + 1, x <= 0), (3*x/2 - c, True))")
THREE = PiecewiseLinearMap.from_sympy(
    "Piecewise((-2*x - 3, x <= -1), (3*x/4 + c, x <= 1), (2 - 2*x, True))"
)
CIRCLE = PiecewiseLinearMap.from_sympy("Piecewise((3*x/4 + c, x <= 0), (3*x/4 + c - 1, True))")
GOLDEN = (1 + sqrt(5)) / 2


# --- Closed forms --------------------------------------------------------------------------------


NIGHT = (pytest.mark.nightly, pytest.mark.slow)
T_ = sympy.Symbol("t")


@pytest.mark.parametrize(
    ("map_", "name", "span", "samples", "windows"),
    [
        # L R attracts down to b/2 = -1; L L R from where its point meets the break, (b + 1)/2 + 1
        # = 0, to b/4 = -1: laps grow by the golden mean, as intervals do round a 3-cycle
        pytest.param(SKEW, "b", (-6, -1), 200, [(-4, -3, GOLDEN, ("LLR",)), (-2, -1, 1, ("LR",))],
                     marks=NIGHT),
        # beyond 1 it is log a, which increases: no interval at all
        pytest.param(TENT, "a", ("1/4", 2), 80, [("1/4", 1, 1, None)], marks=NIGHT),
        # what escapes leaves the whole of two laps; at 2 orbits of the break come to 0
        (TENT, "a", ("9/4", 5), 200, [("9/4", 5, 2, ())]),
        (TENT, "a", (2, 3), 200, [(2, 3, 2, ())]),
        # contracted rotations, though the rotation number changes with every translation
        (CIRCLE, "c", (-1, 2), 200, [(-1, 2, 1, None)]),
        # over the slope -a the cycle R repels from a = 1 on, and there is chaos around it
        pytest.param(PAPER.at({"r": 3, "b": "1/2"}), "a", ("1/2", 4), 40, [("1/2", 1, 1, None)],
                     marks=NIGHT),
    ],
    ids=["skew", "tent", "escape", "edge", "rotations", "slope"],
)  # fmt: skip
def test_windows_of_known_entropy(
    map_: PiecewiseLinearMap, name: str, span: tuple[object, object], samples: int, windows: list
) -> None:
    """All intervals, with both ends, the growth, and the attracting cycles; the rest are gaps."""
    found = constant_entropy(map_, name, span, samples=samples)
    assert [(e.lower, e.upper) for e in found.intervals] == [
        (Rational(low), Rational(high)) for low, high, *_ in windows
    ]
    for each, (*_, growth, cycles) in zip(found.intervals, windows, strict=True):
        assert each.closed == (True, True)
        assert sympy.simplify(sympy.exp(each.entropy.value) - growth) == 0
        assert growth != 1 or (each.entropy.low, each.entropy.high) == (0.0, 0.0)
        assert cycles in (None, each.cycles)
    ends = [Rational(end) for low, high, *_ in windows for end in (low, high)]
    around = [Rational(span[0]), *ends, Rational(span[1])]
    gaps = [(a, b) for a, b in zip(around[::2], around[1::2], strict=True) if a != b]
    assert [(gap.lower, gap.upper) for gap in found.gaps] == gaps
    assert found.share == (1.0 if not gaps else pytest.approx(
        float(sum(b - a for a, b in zip(ends[::2], ends[1::2], strict=True)))
        / float(around[-1] - around[0])))  # fmt: skip


def test_where_every_piece_expands_the_gap_says_so() -> None:
    (gap,) = constant_entropy(TENT, "a", ("5/4", 2), samples=8).gaps
    assert GapCause.EXPANDS in gap.causes
    assert GapCause.OPEN not in gap.causes


@pytest.mark.slow
def test_an_end_that_is_not_admitted_does_not_belong() -> None:
    text = "Piecewise((x/2 + c, x <= 0), (x/2 + c - 1, True))"
    map_ = PiecewiseLinearMap.from_sympy(text, given=["c > 0"])
    (only,) = constant_entropy(map_, "c", (0, 1)).intervals
    assert (only.lower, only.upper, only.closed) == (0, 1, (False, True))
    beta = PiecewiseLinearMap.from_sympy(
        "Piecewise((b*x, x < 1/b), (b*x - 1, True))", given=["b > 1"]
    )
    found = constant_entropy(beta, "b", (1, 2), samples=20)
    assert found.intervals == ()  # it is log b


def test_a_flat_piece_ends_laps() -> None:
    """One lap goes to itself and to the flat piece: no growth, whatever the cycles are."""
    map_ = PAPER.at({"a": "5/4", "b": 0})
    (only,) = constant_entropy(map_, "r", (2, 12)).intervals
    assert (only.lower, only.upper, only.entropy.value) == (2, 12, 0)


@pytest.mark.nightly
def test_windows_of_the_paper_s_map_begin_where_its_cycles_do() -> None:
    """L R R with a = 5/4, b = 1/2: from 16/7, where it meets the break, to 50/21."""
    found = constant_entropy(HALF, "r", (2, 3), samples=20)
    (window,) = (e for e in found.intervals if e.cycles == ("LRR",))
    assert (window.lower, window.upper) == (Rational(16, 7), Rational(50, 21))
    assert window.entropy.value == 0


PLATEAU = "Piecewise((x + 1, x <= g), (3 - 2*x, True))"
MATCHING = PiecewiseLinearMap.from_sympy(PLATEAU)
MATCHES = ("1/6", "2/3", T_**2 - T_ - 1)  # from where to where, and a multiple of the growth's


@pytest.mark.parametrize(
    ("text", "given", "span", "plateau"),
    [
        # after LRLR and RRLL both orbits are at 4 g - 1 with slope 4, for 1/3 < g < 2/3; below,
        # intervals in which orbits match accumulate [Bruin2019]
        (PLATEAU, [], ("1/3", "2/3"), ("1/3", *MATCHES[1:])),
        pytest.param(PLATEAU, [], ("1/6", "2/3"), MATCHES, marks=pytest.mark.slow),
        pytest.param(PLATEAU, [], ("1/8", "7/10"), MATCHES,
                     marks=pytest.mark.slow),
        pytest.param(PLATEAU, [], ("1/5", "1/4"), ("1/5", "1/4", MATCHES[2]),
                     marks=pytest.mark.slow),
        # the same map with its break at 0, and one with a break at 5 that orbits do not reach
        pytest.param("Piecewise((x + 1, x <= 0), (3 - 3*g - 2*x, True))", [], ("1/7", "3/4"),
                     MATCHES, marks=NIGHT),
        pytest.param("Piecewise((x + 1, x <= g), (3 - 2*x, x <= 5), (8 - 3*x, True))",
                     ["0 < g", "g < 1"], ("1/7", "3/4"), MATCHES, marks=NIGHT),
        # 1 + s (1 - x), from s/(s + 1) - 1/s to s/(s + 1): at the lower end s - 1 - s g, to which
        # the left orbit comes, is the fixed point of s - s x; in the upper part orbits go along
        # L R L^(s-1) R and R R L^s, and D = 1 - 2 t + t^(s+1) = (1 - t) (1 - t - ... - t^s)
        *(
            pytest.param(
                f"Piecewise((x + 1, x <= g), ({1 + s} - {s}*x, True))", [], ("1/4", "9/10"),
                (Rational(s, s + 1) - Rational(1, s), Rational(s, s + 1),
                 T_**s - sum(T_**k for k in range(s))), marks=NIGHT)
            for s in (3, 4, 5)
        ),
        # a piece that contracts
        pytest.param("Piecewise((x/2 + 1, x <= 0), (g - 2*x, True))", [], ("19/10", "29/10"),
                     (2, "14/5", T_**3 - T_**2 - 1), marks=NIGHT),
    ],
)  # fmt: skip
def test_a_plateau_is_one_interval_where_orbits_of_a_break_match(
    text: str, given: list[str], span: tuple[str, str], plateau: tuple
) -> None:
    map_ = PiecewiseLinearMap.from_sympy(text, given=given)
    found = constant_entropy(map_, "g", span, samples=20)
    lower, upper, polynomial = plateau
    (only,) = (each for each in found.intervals if each.upper == Rational(upper))
    assert (only.lower, only.closed) == (Rational(lower), (True, True))
    growth = sympy.exp(only.entropy.value)
    assert sympy.expand(sympy.minimal_polynomial(growth, T_) - polynomial) == 0
    assert growth > 1
    assert disagreements(map_, found, 3)[0] == 0


def never_matching(map_: PiecewiseLinearMap, places: list[sympy.Rational]) -> Iterator[MapLine]:
    """The map where both orbits of its break come back, and do not match before."""
    for place in places:
        line = line_of(map_, {"g": place})
        if matched(line, 0, 400, Meter(Budget())) is None:
            yield line


@pytest.mark.nightly
def test_where_orbits_never_match_the_growth_is_the_golden_mean_too() -> None:
    """Of 1184 rationals in [1/6, 2/3] 18 are such; there the graph of laps is finite.

    At 5/24 the left orbit comes to the cycle of 1/3, 7/3, -5/3 and -2/3.
    """
    places = sorted({Rational(p, q) for q in range(1, 89) for p in range(q // 6, q)})
    places = [each for each in places if Rational(1, 6) <= each <= Rational(2, 3)]
    lines = list(never_matching(MATCHING, places))
    assert {Rational(1, 6), Rational(5, 24), Rational(2, 3)} <= {
        QQ.to_sympy(line.breaks[0]) for line in lines
    }
    assert len(lines) == 18
    for line in lines:
        growth = growth_by_kneading(
            line, [itinerary_of(line, germ, 400, Meter(Budget())) for germ in line.germs]
        )
        assert growth is not None
        assert real_to_sympy(growth) == Rational(1, 2) + sqrt(5) / 2


def test_below_the_plateau_the_entropy_is_another_one() -> None:
    """At 4/25 it is less than log of the golden mean: nothing is proved from there on."""
    assert dynamics(MATCHING, {"g": "4/25"}).entropy.high < 0.48 < float(log(GOLDEN))
    family = family_of(MATCHING, QQ(4, 25), QQ(1, 3))
    assert family is not None
    assert growth_of_pairs(family, 0, [RING.zero, RING.one], Meter(Budget())) is None
    family = family_of(MATCHING, QQ(1, 6), QQ(1, 3))
    assert family is not None
    growth = growth_of_pairs(family, 0, [RING.zero, RING.one], Meter(Budget()))
    assert growth is not None
    assert real_to_sympy(growth) == Rational(1, 2) + sqrt(5) / 2


@pytest.mark.nightly
def test_plateaus_of_random_maps() -> None:
    """At the ends and at random places inside laps grow as one proof for all of them says."""
    rng, looked = random.Random(1), 0
    while looked < 60:
        slopes = rng.choice([(-2, 1), (1, -3), (-4, 1), (-3, "1/2"), ("-1/2", -2)])
        one, other = (f"{m}*x + {rng.randint(-3, 3)} + {rng.randint(-1, 1)}*g" for m in slopes)
        text = f"Piecewise(({one}, x <= g), ({other}, True))"
        map_ = PiecewiseLinearMap.from_sympy(text)
        low = QQ(rng.randint(1, 150), 100)
        high = low + QQ(rng.randint(1, 20), 100)
        family = family_of(map_, low, high)
        assert family is not None
        growth = growth_of_pairs(family, 0, [RING.zero, RING.one], Meter(Budget()))
        if growth is None:
            continue
        rate = sympy.log(real_to_sympy(growth)).evalf(30)
        for part in (QQ.zero, QQ(rng.randint(1, 99), 100), QQ.one):
            place = QQ.to_sympy(low + part * (high - low))
            seen = dynamics(map_, {"g": place}, orders=(48,)).entropy
            assert seen.low <= rate <= seen.high, (text, place)
            looked += 1


def test_growth_of_a_graph_of_pairs_needs_no_root_before() -> None:
    """One pair leads to where orbits match, and to itself with the term -a t p and the factor t.

    With p = 1 - t - t^2, D of n rounds is p Q, Q = 1 - a t (1 + t + ... + t^(n-1)). For ever it is
    zero at 1/(1 + a): beyond the root of p, 0.618, for a = 1/2, and before it for a = 1.
    """
    p, pair = 1 - T - T**2, MATCHED_PAIR._replace(lag=1)
    start, together = PairEdge(p, RING.one, pair), PairEdge(RING.zero, RING.one, MATCHED_PAIR)

    def growth(term: PolyElement) -> Real | None:
        steps = {pair: [together, PairEdge(term, T, pair)], MATCHED_PAIR: []}
        return _growth(start, steps, Meter(Budget()))

    found = growth(-T * p / 2)
    assert found is not None
    assert real_to_sympy(found) == Rational(1, 2) + sqrt(5) / 2
    assert growth(-T * p) is None
    assert growth(-T) is None  # no multiple of p


# --- By another way ------------------------------------------------------------------------------

CASES = [(SKEW, "b", (-6, -1), 40), (HALF, "r", (2, 12), 60), (FALLING, "r", (2, 12), 60),
         (LORENZ, "c", (-1, 4), 40), (THREE, "c", (-3, 3), 40)]  # fmt: skip


def at_random(found: EntropyIntervals, n: int) -> Iterator[tuple[ConstantEntropy, sympy.Rational]]:
    """Rationals inside each interval, of small denominators."""
    rng = random.Random(3)
    for each in found.intervals:
        low, high = (QQ.from_sympy(Rational(str(sympy.N(x, 40)))) for x in (each.lower, each.upper))
        for _ in range(n):
            part = low + (high - low) * QQ(rng.randint(1, 999), 1000)
            near = simplest_between(part - (high - low) / 2000, part + (high - low) / 2000)
            yield each, QQ.to_sympy(near)


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


@pytest.mark.nightly
@pytest.mark.parametrize(("map_", "name", "span", "samples"), CASES)
def test_at_fifty_places_inside_it_is_the_same(
    map_: PiecewiseLinearMap, name: str, span: tuple[int, int], samples: int
) -> None:
    found = constant_entropy(map_, name, span, samples=samples)
    assert found.intervals
    wrong, open_ = disagreements(map_, found, 50)
    assert wrong == 0
    assert open_ <= 25 * len(found.intervals)  # others are exact in half of the places at least


# --- Parts, and wrong input ----------------------------------------------------------------------


def test_gaps_say_why() -> None:
    found = constant_entropy(HALF, "r", (2, "5/2"), samples=3)
    assert {cause for gap in found.gaps for cause in gap.causes} == {GapCause.BUDGET}
    found = constant_entropy(HALF, "r", (2, "5/2"), tolerance="1/10")
    assert {cause for gap in found.gaps for cause in gap.causes} == {GapCause.NARROW}
    ends = sorted((each.lower, each.upper) for each in (*found.intervals, *found.gaps))
    assert ends[0][0] == 2
    assert ends[-1][1] == Rational(5, 2)
    assert all(one[1] == other[0] for one, other in pairwise(ends))
