"""Maps and their iterates: properties of random rational maps, and what is refused."""

from fractions import Fraction
from typing import Any

import brute
import pytest
import sympy
from brute import map_of, spelled, texts
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from independent import EXACT, LEFT, RIGHT, Parts, nested
from thoroughness import thorough as at_least

from pwmap import PiecewiseLinearMap, UndecidedError

X = sympy.Symbol("x")

LONGEST = {1: 5, 2: 5, 3: 4, 4: 3}  # orders of iterates by number of intervals; 2 for more


def thorough(examples: int) -> settings:
    return at_least(examples, HealthCheck.too_slow)


# --- Random maps ----------------------------------------------------------------------------------

rationals = st.builds(Fraction, st.integers(-12, 12), st.integers(1, 6))
slopes = st.one_of(st.sampled_from([Fraction(n) for n in (-2, -1, 0, 1, 2)]), rationals)


@st.composite
def maps(draw: st.DrawFn, intervals: int = 5) -> Parts:
    """One to five intervals, and points that are pieces of their own between some of them."""
    n = draw(st.integers(0, intervals - 1))
    breaks = sorted(draw(st.lists(rationals, min_size=n, max_size=n, unique=True)))
    owners = [draw(st.sampled_from(["left", "right", "point"])) for _ in breaks]
    formulas = [
        (draw(slopes), draw(rationals)) for _ in range(len(breaks) + 1 + owners.count("point"))
    ]
    return map_of(breaks, owners, formulas)


@st.composite
def iterates(draw: st.DrawFn) -> tuple[Parts, int]:
    """A map and the order of an iterate."""
    f = draw(maps())
    intervals = sum(part.lo is None or part.lo != part.hi for part in f)
    return f, draw(st.integers(1, LONGEST.get(intervals, 2)))


def to_rational(number: Fraction) -> sympy.Rational:
    return sympy.Rational(number.numerator, number.denominator)


def to_fraction(number: sympy.Expr) -> Fraction:
    assert isinstance(number, sympy.Rational)
    return Fraction(int(number.p), int(number.q))


def exact_map(f: Parts) -> PiecewiseLinearMap:
    """The map of the package."""
    return PiecewiseLinearMap(texts(f))


def interesting(f: Parts, j: int) -> list[Fraction]:
    """The breaks of P_j, points between them, and the breaks of P with their images."""
    cuts = brute.breaks(f, j)
    own = [part.lo for part in f if part.lo is not None]
    middles = [x for ends in brute.gaps(cuts) for x in brute.inner(*ends)]
    return sorted({*cuts, *middles, *own, *(nested(f, x, 1)[0] for x in own)})


# --- Values ---------------------------------------------------------------------------------------


@pytest.mark.nightly
@thorough(120)
@given(iterates(), st.lists(rationals, max_size=4))
def test_values_limits_and_words_are_nested_evaluations(
    f_and_j: tuple[Parts, int], points: list[Fraction]
) -> None:
    f, j = f_and_j
    map_ = exact_map(f)
    iterate = map_.iterate(j)
    for x in [*points, *interesting(f, j)[:40]]:
        value, word = nested(f, x, j)
        again: sympy.Expr = to_rational(x)
        for _ in range(j):
            again = map_(again)
        assert to_fraction(iterate(to_rational(x))) == to_fraction(again) == value
        assert iterate.word_of(to_rational(x)) == spelled(map_.letters, word)
        for side, name in ((LEFT, "-"), (RIGHT, "+")):
            limit = to_fraction(iterate.limit(to_rational(x), name))
            assert limit == nested(f, x, j, side)[0]


# --- Jumps and the diagonal -----------------------------------------------------------------------


@pytest.mark.slow
@thorough(80)
@given(iterates())
def test_jumps_are_those_of_brute_force(f_and_j: tuple[Parts, int]) -> None:
    f, j = f_and_j
    iterate = exact_map(f).iterate(j)
    sides = [
        (x, *(nested(f, x, j, side)[0] for side in (LEFT, EXACT, RIGHT)))
        for x in brute.breaks(f, j)
    ]
    found = [
        tuple(to_fraction(v) for v in (jump.x, jump.left, jump.value, jump.right))
        for jump in iterate.jumps()
    ]
    assert found == [row for row in sides if len(set(row[1:])) > 1]


@pytest.mark.nightly
@thorough(80)
@given(iterates())
def test_virtual_fixed_points_solve_their_formula_outside_its_piece(
    f_and_j: tuple[Parts, int],
) -> None:
    f, j = f_and_j
    iterate = exact_map(f).iterate(j)
    pieces = {piece.word: piece for piece in iterate.pieces}
    points = iterate.fixed_points(virtual=True)
    for point in points:
        piece = pieces[point.word]
        assert piece.expression.subs(X, point.x) == point.x
        assert (piece.interval.contains(point.x) == sympy.true) == point.admissible
    assert tuple(p for p in points if p.admissible) == iterate.fixed_points()
    steep = {p.word for p in iterate.pieces if p.slope != 1}
    assert steep <= {p.word for p in points}


def test_cycles_that_visit_a_point_piece_of_slope_one() -> None:
    """Of a piece that is one point only the value counts: 0 is fixed, and isolated."""
    map_ = PiecewiseLinearMap([("x + 1", "x < 0"), ("x", "Eq(x, 0)"), ("x + 1", "x > 0")])
    assert [p.x for p in map_.fixed_points()] == [0]
    assert [(cycle.word, cycle.points) for cycle in map_.cycles(1)] == [("M", (0,))]


ONE_POINT = {  # maps, the word of a cycle of slope 1, its points: no other point has this word
    "turns": ([("-x", "x <= 0"), ("-2*x", "x > 0")], "LL", (0, 0)),
    "between": ([("2*x", "x <= 1"), ("0", "(x > 1) & (x < 2)"), ("x/2", "x >= 2")], "LR", (1, 2)),
    "moved": ([("2*p - x", "x <= p"), ("3*p - 2*x", "x > p")], "LL", ("p", "p")),
}


@pytest.mark.parametrize(("pieces", "word", "points"), ONE_POINT.values(), ids=ONE_POINT)
def test_a_word_of_slope_one_with_a_single_point_is_an_isolated_cycle(
    pieces: list[tuple[object, object]], word: str, points: tuple[object, ...]
) -> None:
    map_ = PiecewiseLinearMap(pieces)
    expected = tuple(map(sympy.sympify, points))
    cycle = map_.cycle(word)
    assert cycle.points == expected
    assert (cycle.multiplier, cycle.conditions, cycle.admissible) == (1, (), True)
    for again in (map_, map_.iterate(2)):
        found = again.cycles(len(set(points)) // again.order or 1)
        assert set(expected) & {x for c in found for x in c.points}


def test_a_word_of_slope_one_with_a_band_is_no_isolated_cycle() -> None:
    """0 < x < 1 goes to 1 < x < 2 and back."""
    pieces = [("5", "x <= 0"), ("x + 1", "(x > 0) & (x < 1)"), ("x - 1", "x >= 1")]
    map_ = PiecewiseLinearMap(pieces)
    assert [band.word for band in map_.iterate(2).fixed_intervals()] == ["MR", "RM"]
    assert map_.cycles(2) == ()
    with pytest.raises(ValueError, match="the slope of MR is 1: it has no isolated cycle"):
        map_.cycle("MR")


def test_whether_a_word_of_slope_one_has_a_cycle_can_hang_on_parameters() -> None:
    """-x + p on the left of 0, closed: its second iterate is the identity on [p, 0], for p <= 0."""
    map_ = PiecewiseLinearMap([("p - x", "x <= 0"), ("x + 1", "x > 0")])
    with pytest.raises(UndecidedError, match="sign of p"):
        map_.cycle("LL")
    assert map_.at({"p": 0}).cycle("LL").points == (0, 0)
    with pytest.raises(ValueError, match="the slope of LL is 1: it has no isolated cycle"):
        map_.at({"p": -1}).cycle("LL")


units = st.sampled_from(
    [Fraction(n, d) for n, d in ((-2, 1), (-1, 1), (0, 1), (1, 1), (2, 1), (1, 2))]
)
whole = st.integers(-3, 3).map(Fraction)


@st.composite
def unit_maps(draw: st.DrawFn) -> Parts:
    """Maps whose orbits return to breaks, and whose words often have slope 1."""
    breaks = sorted(draw(st.lists(whole, min_size=1, max_size=3, unique=True)))
    owners = [draw(st.sampled_from(["left", "right", "point"])) for _ in breaks]
    n = len(breaks) + 1 + owners.count("point")
    return map_of(breaks, owners, [(draw(units), draw(whole)) for _ in range(n)])


def starts(map_: PiecewiseLinearMap, j: int) -> list[Fraction]:
    """The points of all cycles of a period, each time the whole map was applied."""
    points = [x for cycle in map_.cycles(j) for x in cycle.points[:: map_.order]]
    return sorted(map(to_fraction, points))


def isolated(f: Parts, j: int) -> list[Fraction]:
    """Points of minimal period j that lie in no band, by fractions."""
    return [p.x for p in brute.fixed_points(f, j) if p.period == j]


@pytest.mark.nightly
@thorough(150)
@given(st.one_of(unit_maps(), maps(4)), unit_maps())
def test_cycles_of_maps_iterates_and_compositions(f: Parts, g: Parts) -> None:
    """Of just those fixed points that end no band, by fractions.

    Both maps use the same letters, and are brute force's own map p(q(x)) by itself.
    """
    p, q = exact_map(f), exact_map(g)
    for map_, alone in (
        (p, f),
        (p.iterate(2), brute.composition(f, f)),
        (p @ q, brute.composition(f, g)),
    ):
        for j in (1, 2, 3)[: 4 - map_.order]:
            assert starts(map_, j) == isolated(alone, j)
            for cycle in map_.cycles(j):
                assert cycle.admissible
                assert map_.cycle(cycle.word) == cycle
                x, after = cycle.points[0], (*cycle.points, cycle.points[0])[map_.order]
                assert map_(x) == after
                if map_ is p:
                    passed = [p.pieces[p.letters.index(letter)] for letter in cycle.word]
                    slopes = [sympy.nan if s.lower == s.upper else s.slope for s in passed]
                    assert cycle.multiplier == sympy.prod(slopes)  # of a point: none


def test_letters_of_a_composition_belong_to_the_map_at_their_position() -> None:
    """(-1/2)(x/3 + 1) + 1 on LR: 1/2 - x/6 has the fixed point 3/7, which q sends to 8/7."""
    p = PiecewiseLinearMap([("2*x - 1", "x <= 0"), ("1 - x/2", "x > 0")])
    q = PiecewiseLinearMap([("x/3 + 1", "x <= 1"), ("1 - x", "x > 1")])
    third = sympy.Rational(1, 7)
    for cycle in ((p @ q).cycle("LR"), *(p @ q).cycles(1)):
        assert (cycle.word, cycle.points) == ("LR", (3 * third, 8 * third))
        assert (cycle.multiplier, cycle.admissible) == (-sympy.Rational(1, 6), True)
    assert (p @ q).cycles(2) == ()
    assert not (p @ q).cycle("RL").admissible
    three = PiecewiseLinearMap([("0", "x < 0"), ("1", "Eq(x, 0)"), ("2", "x > 0")])
    with pytest.raises(ValueError, match=r"'M' is no piece of this map, it has \('L', 'R'\)"):
        (p @ three).cycle("MM")


@pytest.mark.nightly
def test_cycles_of_long_words() -> None:
    """A letter 3000 times, and L R^1199, whose orbit leaves L at once and comes back."""
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    repeated = map_.cycle("R" * 3000)
    a, r = map_.parameters
    assert set(repeated.points) == {r / (a + 1)}
    assert repeated.multiplier == a**3000
    at = map_.at({"a": "5/4", "r": 1})
    long = at.cycle("L" + "R" * 1199)
    x = sympy.Rational(-1)
    assert long.points[1] == x
    for point in long.points[1:5]:
        assert point == x
        x = 1 - sympy.Rational(5, 4) * x
    assert (len(long.points), long.multiplier, long.admissible) == (1200, 0, False)
    turns = PiecewiseLinearMap([("-x", "x <= 0"), ("-2*x", "x > 0")])
    assert set(turns.cycle("L" * 600).points) == {0}


# --- As sympy and back ----------------------------------------------------------------------------


@pytest.mark.slow
@thorough(60)
@given(iterates(), st.lists(rationals, max_size=3))
def test_from_sympy_undoes_to_sympy(f_and_j: tuple[Parts, int], points: list[Fraction]) -> None:
    f, j = f_and_j
    j = min(j, 2)
    iterate = exact_map(f).iterate(j)
    formula = iterate.to_sympy()
    again = PiecewiseLinearMap.from_sympy(formula)
    for x in [*points, *interesting(f, j)[:10]]:
        assert to_fraction(again(x)) == nested(f, x, j)[0]
        assert to_fraction(sympy.sympify(formula.subs(X, to_rational(x)))) == nested(f, x, j)[0]


@pytest.mark.parametrize("always", [sympy.true, True, "True"], ids=["sympy", "bool", "text"])
def test_a_condition_that_always_holds(always: object) -> None:
    map_ = PiecewiseLinearMap([("2*x + 1", always)])
    assert [str(p.expression) for p in map_.pieces] == ["2*x + 1"]
    assert map_(3) == 7


# --- What is refused ------------------------------------------------------------------------------

PAPER = [("r - 2", "x <= 0"), ("r - a*x", "x > 0")]


def paper(**changes: Any) -> PiecewiseLinearMap:
    return PiecewiseLinearMap(PAPER, **({"given": ["a > 1"]} | changes))


@pytest.mark.parametrize(
    ("pieces", "error", "message"),
    [
        ([], ValueError, "at least one piece"),
        ([("x", "x < 0"), ("1", "x > 0")], ValueError, "gap: no piece covers x = 0"),
        ([("x", "x < 0"), ("1", "x > 1/2")], ValueError, "gap: no piece covers x = 0"),
        ([("x", "x <= 0"), ("1", "x >= 1/2")], ValueError, "no piece covers 0 < x < 1/2"),
        ([("x", "x <= 0")], ValueError, "no piece covers 0 < x"),
        ([("x", "x <= 0"), ("1", "x >= 0")], ValueError, "1 and 2 overlap: both cover x = 0"),
        ([("x", "x < 3"), ("1", "x > 2"), ("2", "x >= 3")], ValueError, "both cover 2 < x < 3"),
        ([("x**2", sympy.true)], ValueError, r"x\*\*2 is not affine in x"),
        ([("1/x", sympy.true)], ValueError, "1/x is not affine in x"),
        ([("sqrt(2)*x", sympy.true)], ValueError, r"polynomial .* rationals, got sqrt\(2\)"),
        ([("x/r", sympy.true)], UndecidedError, "denominator must have a sign, but the sign of r "),
        ([("1.25*x", sympy.true)], TypeError, "1.25.* is a float.*write the rational 5/4"),
        ([("x", "x < 0.1"), ("1", "x >= 0.1")], TypeError, "write the rational 1/10"),
        ([(0.75, sympy.true)], TypeError, "0.75 is a float.* 3/4 instead, as text or by"),
        ([("x", "r < 0"), ("1", "r >= 0")], ValueError, "r < 0 does not contain the variable x"),
        ([("x", "x**2 < 1"), ("1", "x**2 >= 1")], ValueError, r"x\*\*2 < 1 must compare x"),
        ([("x +* 2", sympy.true)], ValueError, r"cannot read 'x \+\* 2'"),
    ],
)  # fmt: skip
def test_faulty_pieces(pieces: list[tuple[object, object]], error: type, message: str) -> None:
    with pytest.raises(error, match=message):
        PiecewiseLinearMap(pieces)


def test_breaks_without_a_certain_order() -> None:
    pieces = [("x", "x < 0"), ("1", "(x >= 0) & (x < r)"), ("2", "x >= r")]
    with pytest.raises(UndecidedError, match=r"breaks of x have no certain order.* sign of -?r "):
        PiecewiseLinearMap(pieces)
    with pytest.raises(UndecidedError, match=r"no certain order.*r >= 0"):
        PiecewiseLinearMap(pieces, given=["r >= 0"])
    assert len(PiecewiseLinearMap(pieces, given=["r > 0"]).pieces) == 3


def test_pieces_of_an_iterate_that_the_assumptions_leave_open() -> None:
    second = paper().iterate(2)
    with pytest.raises(UndecidedError, match=r"sign of -?\(?r - 2\)? .*a > 1.*given"):
        _ = second.pieces
    assert [p.word for p in paper(given=["a > 1", "r > 2"]).iterate(2).pieces] == ["LR", "RR", "RL"]
    with pytest.raises(UndecidedError, match="sign of"):
        paper().iterate(1).fixed_points()
    with pytest.raises(UndecidedError, match="sign of r"):
        paper()("r")


def test_a_stability_that_is_open_refuses_no_list() -> None:
    """R is fixed for all slopes b < 1, and attracts for b > -1 only."""
    skew = [("a*x + r", "x <= 0"), ("b*x + r", "x > 0")]
    given = ["0 < a", "a < 1", "r > 0", "b < 0"]
    (point,) = PiecewiseLinearMap(skew, given=given).fixed_points()
    assert (point.word, point.stable, point.multiplier) == ("R", None, sympy.Symbol("b"))
    for further, stable in (("b > -1", True), ("b < -1", False)):
        (point,) = PiecewiseLinearMap(skew, given=[*given, further]).fixed_points()
        assert point.stable is stable
    corner = [("m*x", "x < 0"), ("n*x", "x >= 0")]  # 0 attracts if m < 1, n < 1 and m*n < 1
    for given, stable in (
        (["m < 1", "m > 0", "n < 1", "n > 0"], True),
        (["m < 0", "n < 0"], None),
        (["m < -2", "n < -1"], False),
        (["m < 0", "n > 1"], False),
    ):
        found = PiecewiseLinearMap(corner, given=given).fixed_points()
        assert [(p.x, p.at_border, p.stable) for p in found] == [(0, True, stable)], given
