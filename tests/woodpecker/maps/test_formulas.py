"""Maps written by hand, from sympy and from pwmap: values, derivatives, margins and refusals."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy

from pwmap import PiecewiseLinearMap
from woodpecker.maps.derivatives import check_derivatives
from woodpecker.maps.formulas import NOWHERE, FormulaMap, FormulaPiece, Smooth, difference
from woodpecker.maps.symbolic import SymbolicPiece, from_pwmap, from_sympy

X, P, K = sympy.symbols("x p k")
ROUNDING = 4e-16  # some spacings of doubles at 1
CENTRAL = 1e-9  # a central difference of step 2^-17: third derivatives of about ten, and rounding


def below(x: float, p: float) -> float:
    return p - x


def line(x: float, p: float) -> float:
    return 0.5 * x + p


MET = "x meets p"


def by_hand() -> FormulaMap:
    """sqrt(p - x) for x <= p, x/2 + p beyond; differences for all but the root."""
    root = Smooth(
        lambda x, p: math.sqrt(p - x),
        lambda x, p: -0.5 / math.sqrt(p - x),
        lambda x, p: 0.5 / math.sqrt(p - x),
    )
    return FormulaMap(
        (
            FormulaPiece("L", root, {MET: Smooth(below)}),
            FormulaPiece("R", Smooth(line), {MET: Smooth(lambda x, p: x - p)}),
        )
    )


def symbolic() -> FormulaMap:
    """The same from sympy."""
    formula = sympy.Piecewise((sympy.sqrt(P - X), X <= P), (X / 2 + P, True))
    return from_sympy(formula, X, P, words=("L", "R"))


BOTH = pytest.mark.parametrize("make", [by_hand, symbolic])

# --- Values ---------------------------------------------------------------------------------------


@BOTH
def test_values_derivatives_and_margins(make: Callable[[], FormulaMap]) -> None:
    image = make().at(0.19, 1.0)
    assert image.piece.word == "L"
    assert image.value == pytest.approx(0.9, abs=ROUNDING)
    assert image.slope == pytest.approx(-0.5 / 0.9, abs=ROUNDING)
    assert image.d_parameter == pytest.approx(0.5 / 0.9, abs=ROUNDING)
    assert image.margins == pytest.approx([0.81], abs=ROUNDING)
    assert image.gradients == pytest.approx(np.array([[-1.0, 1.0]]), abs=CENTRAL)
    beyond = make().at(2.0, 1.0)
    assert beyond.piece.word == "R"
    assert (beyond.value, beyond.margin(0)) == (2.0, 1.0)
    assert (beyond.slope, beyond.d_parameter) == pytest.approx((0.5, 1.0), abs=CENTRAL)


@BOTH
def test_a_piece_says_why_it_has_no_value(make: Callable[[], FormulaMap]) -> None:
    outside = make().piece("L").at(2.0, 1.0)
    assert math.isnan(outside.value)
    assert outside.reason == "L has no value at x = 2.0, p = 1.0"
    assert outside.margin(0) == -1.0


@BOTH
def test_a_square_root_has_a_value_but_no_slope_at_its_end(make: Callable[[], FormulaMap]) -> None:
    end = make().piece("L").at(1.0, 1.0)
    assert (end.value, end.margin(0), end.reason) == (0.0, 0.0, "")
    assert math.isnan(end.slope)


def test_a_power_has_a_slope_where_its_base_is_zero() -> None:
    """That of (-x)^n is -n (-x)^(n - 1): 0 at x = 0 for n > 1. sympy writes n (-x)^n/x, 0/0 there.

    The margin is one, too: (p - 2 x)^(5/2) has the derivatives -5 (p - 2 x)^(3/2) and half of it.
    """
    margin = (P - 2 * X) ** sympy.Rational(5, 2)
    formula = sympy.Piecewise((P + (-X) ** sympy.Rational(3, 2), margin > 0), (-1, True))
    image = from_sympy(formula, X, P).pieces[0].at(0.0, 0.0)
    assert (image.value, image.slope, image.d_parameter) == (0.0, 0.0, 1.0)
    assert image.margins.tolist() == [0.0]
    assert image.gradients.tolist() == [[0.0, 0.0]]
    inside = from_sympy(formula, X, P).at(-4.0, 1.0)
    assert (inside.value, inside.slope, inside.d_parameter) == (9.0, -3.0, 1.0)
    assert inside.gradients.tolist() == [[-135.0, 67.5]]


@BOTH
def test_many_points_at_once(make: Callable[[], FormulaMap]) -> None:
    x = np.linspace(-1.0, 3.0, 400).reshape(20, 20)  # 1 is not among them
    map_ = make()
    one_by_one = [map_.at(each, 1.0).value for each in x.ravel().tolist()]
    assert map_.values(x, 1.0).ravel() == pytest.approx(one_by_one, abs=ROUNDING)
    assert map_.values(2, 1).shape == ()


def test_no_piece_holds_a_point() -> None:
    map_ = FormulaMap((by_hand().piece("R"),))
    assert map_.at(0.0, 1.0).reason == NOWHERE
    assert np.isnan(map_.values([0.0, 2.0], 1.0)).tolist() == [True, False]


def test_the_first_piece_that_holds_a_point_counts() -> None:
    everywhere = FormulaPiece("all", Smooth(line))
    assert FormulaMap((everywhere, *by_hand().pieces)).at(0.0, 1.0).piece.word == "all"
    last = FormulaMap((*by_hand().pieces, everywhere))
    assert last.at(0.0, 1.0).piece.word == "L"
    assert last.values([0.0], 1.0).tolist() == [1.0]  # the root, not x/2 + p
    assert last.values([0.19], 1.0) == pytest.approx([0.9], abs=ROUNDING)


def test_strict_relations_of_sympy_are_strict() -> None:
    map_ = from_sympy(sympy.Piecewise((1, X < P), (2, X <= P), (3, True)), X, P)
    images = [map_.at(x, 1.0).value for x in (0.5, 1.0, 1.5)]
    assert images == map_.values([0.5, 1.0, 1.5], 1.0).tolist() == [1.0, 2.0, 3.0]


def test_a_number_that_no_double_holds_is_no_value() -> None:
    large = Smooth(lambda x, p: 10**400)
    assert math.isnan(large.at(1.0, 2.0)[0])
    assert "has no value" in from_sympy(10**400 * X, X, P).at(1.0, 2.0).reason


def test_symbols_are_real_numbers() -> None:
    """The root is abs(x - p), which has a corner; it was one smooth piece."""
    tent = from_sympy(1 - P * sympy.sqrt((X - P) ** 2), X, P)
    assert len(tent.pieces) == 2
    for x in (1.0, 3.0):
        image = tent.at(x, 2.0)
        assert (image.value, image.slope) == (-1.0, 2.0 * np.sign(2.0 - x))
        assert image.margins.tolist() == [1.0]  # the distance from the corner


def test_differences_are_good_to_nine_digits() -> None:
    value, dx, dp = Smooth(lambda x, p: math.sin(3.0 * x) * math.exp(p)).at(0.4, -0.3)
    size = math.exp(-0.3)
    assert value == pytest.approx(math.sin(1.2) * size, abs=ROUNDING)
    assert dx == pytest.approx(3.0 * math.cos(1.2) * size, abs=CENTRAL)
    assert dp == pytest.approx(value, abs=CENTRAL)


def test_differences_look_inside_at_the_end_of_a_domain() -> None:
    """sqrt(x)^3 has slope 0 at its end; the difference to one side errs by its step's root."""
    assert Smooth(lambda x, p: math.sqrt(x) ** 3).at(0.0, 0.0)[1] == pytest.approx(0.0, abs=0.01)
    assert Smooth(lambda x, p: x * math.sqrt(1.0 - x) ** 4).at(1.0, 0.0)[1] == pytest.approx(
        0.0, abs=1e-8
    )


def test_a_complex_value_is_no_value() -> None:
    assert math.isnan(Smooth(lambda x, p: x**0.5).at(-1.0, 0.0)[0])
    cubic = from_sympy(X ** sympy.Rational(1, 3), X, P)
    assert math.isnan(cubic.at(-1.0, 0.0).value)
    assert cubic.at(8.0, 0.0).value == 2.0


# --- Conditions of sympy --------------------------------------------------------------------------


OUTSIDE = (X < -1) | (X > 1)
BANDS = [
    # Later pieces hold where earlier ones do not.
    ([(0, X < 0), (1, X < 1), (2, True)],
     {"A": {"-x > 0"}, "B": {"x >= 0", "1 - x > 0"}, "C": {"x - 1 >= 0"}}),
    # What is written out needs no complement.
    ([(0, X < 0), (1, (X >= 0) & (X < P)), (2, (X >= 0) & (X >= P))],
     {"A": {"-x > 0"}, "B": {"x >= 0", "p - x > 0"}, "C": {"x >= 0", "-p + x >= 0"}}),
    # The last piece: not x < 0, and not (0 <= x < 2), of which only x < 2 is open.
    ([(0, (X >= 0) & (X < 2)), (1, X < 0), (2, True)],
     {"A": {"x >= 0", "2 - x > 0"}, "B": {"-x > 0"}, "C": {"x - 2 >= 0"}}),
    ([(0, X**2 + P**2 < 1), (1, True)],
     {"A": {"-p**2 - x**2 + 1 > 0"}, "B": {"p**2 + x**2 - 1 >= 0"}}),
    # What is left of a band is two pieces.
    ([(0, (X > P) & (X < P + 1)), (1, True)],
     {"A": {"-p + x > 0", "p - x + 1 > 0"}, "B1": {"p - x >= 0"}, "B2": {"-p + x - 1 >= 0"}}),
    *(([(0, OUTSIDE), (1, inside)],
       {"A1": {"x - 1 > 0"}, "A2": {"-x - 1 > 0"}, "B": {"x + 1 >= 0", "1 - x >= 0"}})
      for inside in (True, sympy.Not(OUTSIDE))),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "expected"), BANDS)
def test_relations_of_each_piece(
    parts: list[tuple[Any, Any]], expected: dict[str, set[str]]
) -> None:
    found = {}
    map_ = from_sympy(sympy.Piecewise(*((value + P, where) for value, where in parts)), X, P)
    for piece in map_.pieces:
        assert isinstance(piece, SymbolicPiece)
        found[piece.word] = {str(bound) for bound in piece.bounds}
    assert found == expected


def test_a_border_that_no_piece_has_is_refused() -> None:
    """Jump crossings were lost there; where a third piece has it, or a map ends, it is no gap."""
    both, either = sympy.And, sympy.Or
    for left, right in ((X < 0, X > 0), (X < P, 2 * P < 2 * X), (X < 0, both(X > 0, P > 1))):
        with pytest.raises(ValueError, match=r"there is a gap: no piece covers .*, write <="):
            of(sympy.Piecewise((X, left), (P, right)))()
    for conditions in (
        (X < 0, X > 1), (X < 0, X > 0, True), (X < 0, X > 0, both(X <= 0, P < 9), P >= 9),
        (both(X < 0, P < 0), both(X > 0, P > 0)), (X < 0, X >= 0), (either(X < 0, X > 1),),
    ):  # fmt: skip
        assert of(sympy.Piecewise(*((X + k, each) for k, each in enumerate(conditions))))()


@pytest.mark.parametrize("nowhere", [X < K, K > 0])
def test_a_piece_that_holds_nowhere_is_left_out(nowhere: sympy.Basic) -> None:
    map_ = from_sympy(sympy.Piecewise((X, X < 0), (K, nowhere), (P, True)), X, P, {K: -1})
    assert [piece.word for piece in map_.pieces] == ["A", "C"]
    assert map_.at(-0.5, 3.0).value == -0.5
    assert map_.at(0.0, 3.0).value == 3.0


CORNERS = (
    1 - 2 * sympy.Abs(X) + P,
    sympy.Piecewise((P * X + sympy.Abs(X), X < P), (1 - 2 * sympy.Abs(X - 1), True)),
    sympy.Max(X, P, 1 - X) - X / 2,
    sympy.Min(sympy.Max(3 * X + P, -1), 1),
    sympy.Abs(sympy.Abs(X) - 1) * X + P,
    P + sympy.Piecewise((sympy.Piecewise((X, X < 0), (P, True)), X < 1), (X**2, True)),
    sympy.Piecewise((X, sympy.Abs(X) < 1), (P, True)),
    sympy.Piecewise((X / 2, sympy.Not((X > -1) & (X < P))), (1 - X, True)),
)


@pytest.mark.parametrize("formula", CORNERS, ids=str)
def test_corners_are_borders_of_pieces(formula: sympy.Expr) -> None:
    """Each point of a grid, which has corners in it, has one piece, with the formula's value."""
    map_, expected = from_sympy(formula, X, P), sympy.lambdify([X, P], formula, "math")
    for x, p in itertools.product(np.arange(-2.0, 2.25, 0.25).tolist(), repeat=2):
        holding = [piece for piece in map_.pieces if piece.holds(x, p)]
        assert [piece.word for piece in holding] == [map_.at(x, p).piece.word]
        assert map_.at(x, p).value == expected(x, p)  # quarters are exact


@pytest.mark.slow
def test_each_condition_is_taken_apart_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three conditions, of which none is a corner's."""
    asked, own = list[sympy.Basic](), sympy.to_dnf

    def counted(condition: sympy.Basic) -> sympy.Basic:
        asked.append(condition)
        return own(condition)

    monkeypatch.setattr(sympy, "to_dnf", counted)
    conditions = (sympy.Or(X < -2, X > 2), X < P, sympy.true)
    from_sympy(sympy.Piecewise((X, conditions[0]), (P, conditions[1]), (1, True)), X, P)
    assert [asked[0], asked[2:]] == [conditions[0], [sympy.true]]
    assert asked[1] in (X < P, P > X)  # by its own order of symbols


def test_corners_that_make_too_many_cases_are_refused() -> None:
    steps = sympy.Piecewise(*((k * X, k > X) for k in range(80)), (X, True))
    assert len(from_sympy(steps, X, P).pieces) == 81
    with pytest.raises(ValueError, match="corners must make at most 64 cases, got more in"):
        from_sympy(steps + sympy.Abs(X - P), X, P)


def test_floats_are_the_binary_numbers_they_hold() -> None:
    third = 1.0 / 3.0
    map_ = from_sympy(K * X + 0.1, X, P, {K: third})
    assert map_.at(1.0, 0.0).slope == third
    assert map_.at(0.0, 0.0).value == 0.1


def test_a_symbol_of_a_strange_name_is_only_a_name() -> None:
    strange = sympy.Symbol("__import__('os').getcwd()")
    assert from_sympy(2 * strange + P, strange, P).at(3.0, 1.0).value == 7.0


# --- Maps of pwmap --------------------------------------------------------------------------------


def test_a_map_of_pwmap() -> None:
    """P1^L with a = 5/4 [Leine2001, Eq. 14], and its second iterate with its moving break r/a."""
    pieces = [("r - 2", "x <= 0"), ("r - a*x", "x > 0")]
    exact = PiecewiseLinearMap(pieces, given=["a > 1", "r > 0", "r < 2"]).at({"a": "5/4"})
    map_ = from_pwmap(exact, "r")
    assert [piece.word for piece in map_.pieces] == ["L", "R"]
    image = map_.at(0.4, 0.7)
    assert (image.value, image.slope, image.d_parameter) == pytest.approx((0.2, -1.25, 1.0))
    assert map_.at(0.0, 0.7).value == pytest.approx(-1.3)  # the left piece owns the break
    twice = from_pwmap(exact.iterate(2), sympy.Symbol("r"))
    for x in (-1.0, 0.3, 0.7):
        assert twice.at(x, 0.7).value == pytest.approx(map_.at(map_.at(x, 0.7).value, 0.7).value)
    inner = next(piece for piece in twice.pieces if piece.holds(0.3, 0.7))
    assert inner.cause(1) == "x = 4*r/5"
    assert inner.at(0.3, 0.7).gradients.tolist() == [[1.0, 0.0], [-1.0, 0.8]]


def test_single_points_are_left_out() -> None:
    exact = PiecewiseLinearMap([("x + p", "x < 0"), ("7", "Eq(x, 0)"), ("-x + p", "x > 0")])
    assert [piece.word for piece in from_pwmap(exact, "p").pieces] == ["L", "R"]


# --- Derivatives ----------------------------------------------------------------------------------

INSIDE = [(-0.7, 1.0), (0.3, 0.9), (1.7, 1.1), (40.0, 3.0)]


@BOTH
def test_right_derivatives_pass(make: Callable[[], FormulaMap]) -> None:
    """Also next to the end of a square root, if they are given."""
    check_derivatives(make(), INSIDE + [(1.0 - 1e-3, 1.0)] * (make is symbolic))


def test_a_difference_at_the_end_of_a_domain_is_one_sided() -> None:
    """Exact for x^2 + 2 x up to rounding over the step, from either side of x = 1."""

    def above(x: float) -> float:
        return x * x + 2.0 * x if x >= 1.0 else math.nan

    def below(x: float) -> float:
        return x * x + 2.0 * x if x <= 1.0 else math.nan

    for function in (above, below):
        assert difference(function, 1.0, 3.0) == pytest.approx(4.0, abs=1e-8)


def test_derivatives_right_beside_a_kink_and_a_leap_are_compared() -> None:
    """A margin leaps 1e-5 away, the value has a kink there: slopes are those of this side."""
    margin = Smooth(lambda x, p: x if x < 0.50001 else x - 3.0, lambda x, p: 1.0)
    value = Smooth(lambda x, p: max(2.0 * x, x + 0.50001) + p, lambda x, p: 1.0)
    check_derivatives(FormulaMap([FormulaPiece("K", value, {MET: margin})]), [(0.5, 2.0)])
    with pytest.raises(ValueError, match=r"the value of piece 'K' .* given as 1, .* say 2"):
        check_derivatives(FormulaMap([FormulaPiece("K", value, {})]), [(0.6, 2.0)])


# --- Wrong input ----------------------------------------------------------------------------------

HALF = FormulaPiece("S", Smooth(line))
EXACT = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
WRONG_DX = FormulaPiece("S", Smooth(line, lambda x, p: -0.5))
WRONG_DP = FormulaPiece("S", Smooth(line, None, lambda x, p: 1.00001))
WRONG_MARGIN = FormulaPiece("S", Smooth(line), {MET: Smooth(below, lambda x, p: 1.0)})


def of(formula: Any, *arguments: Any) -> Callable[[], object]:
    """A call of :func:`from_sympy` in x and p, or in what else is given."""
    return lambda: from_sympy(formula, *(arguments or (X, P)))


def compared(*pieces: FormulaPiece, at: Any = ((0.25, 2.0),)) -> Callable[[], object]:
    return lambda: check_derivatives(FormulaMap(pieces), at)


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (of(sympy.sign(P) * X), ValueError, "not among the smooth functions"),
        (of(sympy.floor(X)), ValueError, r"floor\(x\) in floor\(x\) is not among the smooth"),
        (of(sympy.Function("f")(X)), ValueError, "not among the smooth functions"),
        (of(sympy.I * X), ValueError, "I in I\\*x is not among"),
        (of(X + sympy.oo * P), ValueError, "not among"),
        (of(K * X + P), ValueError, r"no value is given for k in k\*x \+ p"),
        (of(sympy.Symbol("x", real=True) + P), ValueError, "two symbols, of different assumptions"),
        (of(sympy.Piecewise((1, sympy.Ne(X, 0)), (P, True))), ValueError, "must be a relation"),
        (of(sympy.Piecewise((1, sympy.Eq(X, P)), (P, True))), ValueError, "must be a relation"),
        (of("x + p"), TypeError, "must be an expression of sympy, got"),  # no text is evaluated
        (of("__import__('os').getcwd()"), TypeError, "must be an expression of sympy, got"),
        (of(1.0), TypeError, "must be an expression of sympy, got"),
        (of(X + K, X, P, {K: "p"}), TypeError, "the value of k must be a number, got 'p'"),
        (of(X + P, "x", P), TypeError, "x must be a symbol of sympy, got 'x'"),
        (of(X + P, X, X), ValueError, "must differ, got x twice"),
        (of(X + P, X, P, {P: 1}), ValueError, "for symbols other than"),
        (of(X + P, X, P, {K: sympy.I}), ValueError, "must be a finite real number, got I"),
        (of(X + P, X, P, {K: math.inf}), ValueError, "must be a finite real number, got inf"),
        (of(X + P, X, P, {}, ("L", "R")), ValueError, r"words must be 1 names, .* got \('L', 'R'"),
        (of(X + P, X, P, {}, [""]), ValueError, r"words must be 1 names, .* got \[''\]"),
        (of(sympy.Abs(X), X, P, {}, ["L", "L"]), ValueError, r"2 names, .* got \['L', 'L'\]"),
        (of(X + K, X, P, {K: None}), TypeError, "the value of k must be a number, got None"),
        (of(X + K, X, P, "k"), TypeError, "values must be a dict of symbols and numbers, got 'k'"),
        (lambda: from_pwmap(3, "p"), TypeError, "must be a pwmap.PiecewiseLinearMap, got 3"),
        (lambda: from_pwmap(EXACT, "r"), ValueError, "must be r alone, got a, r"),
        (lambda: FormulaMap(()), ValueError, "at least one piece, got none"),
        (lambda: FormulaMap(by_hand().pieces * 2), ValueError, "got 'L' twice"),
        (lambda: FormulaMap(5), TypeError, "needs a list of pieces, got 5"),
        (lambda: FormulaMap([line]), TypeError, "must be a FormulaPiece or alike, got <function"),
        (lambda: FormulaMap([HALF], "mu"), TypeError, "must be those of the coordinate and the pa"),
        (lambda: FormulaPiece("", Smooth(line)), ValueError, "must not be empty"),
        (lambda: FormulaPiece(1, Smooth(line)), TypeError, "must be text, got 1"),
        (lambda: FormulaPiece("L", line), TypeError, r"the map of L must be Smooth\(f\)"),
        (lambda: FormulaPiece("L", Smooth(line), {MET: below}), TypeError, "margin 'x meets p'"),
        (lambda: FormulaPiece("L", Smooth(line), [below]), TypeError, "of L must be a dict"),
        (lambda: Smooth(1.0), TypeError, "value must be a function of x and p, got 1.0"),
        (lambda: Smooth(lambda x: x), TypeError, "value must be a function of x and p, got <func"),
        (lambda: Smooth(line, 1.0), TypeError, "dx must be a function of x and p, got 1.0"),
        (lambda: Smooth(lambda x, p: None).at(1.0, 2.0), TypeError, "got None at x=1.0, p=2.0"),
        (lambda: by_hand().values(["a"], 1.0), ValueError, "x must be real numbers"),
        (lambda: by_hand().values([0.0], "a"), ValueError, "p must be one real number, got 'a'"),
        (lambda: check_derivatives(line, [(0.0, 1.0)]), TypeError, "one of pieces, such as .*, g"),
        (compared(HALF, at=[0.5]), ValueError, r"pairs .*, got \[0.5\]"),
        (compared(HALF, at=[("a", 1)]), ValueError, r"pairs .*, got \[\('a', 1"),
        (compared(HALF, at=[]), ValueError, "at least one pair"),
        (compared(by_hand().piece("R"), at=[(0.0, 1.0)]), ValueError,
         f"no value at x = 0.0, p = 1.0: {NOWHERE}"),
        (compared(*symbolic().pieces, at=[(1.0 - 1e-6, 1.0)]), ValueError, "no value beside it"),
        (compared(WRONG_DX), ValueError, "the derivative in x of the value of piece 'S' at "
         "x = 0.25, p = 2.0 is given as -0.5, but differences of values say 0.5"),
        (compared(WRONG_DP), ValueError, "the derivative in p of the value of piece 'S' at "
         "x = 0.25, p = 2.0 is given as 1.00001, but differences of values say 1"),
        (compared(WRONG_MARGIN), ValueError, "the derivative in x of the margin 'x meets p' of "
         "piece 'S' at x = 0.25, p = 2.0 is given as 1, but differences of values say -1"),
    ],
)  # fmt: skip
def test_wrong_input_gets_a_sentence(
    make: Callable[[], object], error: type[Exception], sentence: str
) -> None:
    with pytest.raises(error, match=sentence):
        make()


def test_names_of_a_map_are_two() -> None:
    assert FormulaMap([HALF], ("x", "mu")).names == ("x", "mu")


def test_values_as_text_are_exact_as_in_pwmap() -> None:
    """0.1 as text is 1/10; as a float it is the binary number, which 1/10 is not."""
    lines = PiecewiseLinearMap.from_sympy("Piecewise((k*x + p, x <= 0), (p, True))")
    assert {str(lines.at({"k": text})) for text in ("0.1", "1/10", " 1e-1")} == {
        "L  p + x/10  for x <= 0\nR  p         for 0 < x"
    }
    for text in ("0.1", "1/10"):
        (piece,) = from_sympy(K * X + P, X, P, {K: text}).pieces
        assert piece.value == X / 10 + P
    (piece,) = from_sympy(K * X + P, X, P, {K: 0.1}).pieces
    assert piece.value != X / 10 + P
