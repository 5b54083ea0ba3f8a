"""Coefficients that are quotients: values put in first or afterwards give the same."""

import pickle

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational, symbols
from thoroughness import thorough

from pwmap import PiecewiseLinearMap, UndecidedError, bifurcation_diagram, parameter_cells

A, R = symbols("a r")
read = PiecewiseLinearMap.from_sympy

FAMILIES = [
    "Piecewise((x/a, x < 1/a), (1 - 2*x/(a + 1), True))",
    "Piecewise((-x/a + 1, x <= 1/(a + 2)), (3*x - 1/a**2, x < 2), (1/a, True))",
    "Piecewise((a*x/(a + 1) + 1, x < -1/a), (-2*x/a, Eq(x, -1/a)), (x/2 - 1, True))",
    "Abs(x - 1/a)*(a + 2)/a - 1/(1 + a)",
    "Max(x/a, 1 - a*x/2, -1/a)",
]
VALUES = [Rational(n, 4) for n in (1, 2, 3, 4, 5, 7, 8, 11, 12, 20)]


def facts(map_: PiecewiseLinearMap, value: Rational | None = None) -> list[object]:
    """All that a map shows, with a value put for its parameter."""

    def at(expr: sympy.Basic) -> sympy.Basic:
        return expr if value is None else sympy.sympify(expr).subs(A, value)

    found: list[object] = []
    for p in map_.pieces:
        found += [p.word, at(p.slope), at(p.intercept), at(p.lower), at(p.upper), p.lower_closed]
    for f in map_.fixed_points():
        found += [at(f.x), at(f.multiplier), f.word, f.stable, f.at_border]
    for j in map_.jumps():
        limits = [at(j.left), at(j.value), at(j.right)]
        found += [at(j.x), *limits] if len(set(limits)) > 1 else []
    for c in map_.jump_crossings():
        found += [at(c.x), at(c.left), at(c.right), c.left_word, c.right_word]
    return found


@pytest.mark.nightly
@pytest.mark.parametrize("text", FAMILIES)
def test_cells_of_a_family_hold_what_its_maps_show(text: str) -> None:
    """In each cell of the parameter, and on each rational edge, against plain maps in rationals."""
    formula = sympy.sympify(text)
    family = read(text, given=["a > 0"])
    for order in (1, 2, 3):
        cells = parameter_cells(family, "a", (order,))
        checked = 0
        for value in [*VALUES, *(e for e in cells.edges if e.is_Rational)]:
            cell = next(
                c
                for c in cells
                if (
                    c.lower == value
                    if c.is_edge
                    else bool(c.lower < value) and bool(value < c.upper)
                )
            )
            alone = read(formula.subs(A, value))
            expected = facts(alone.iterate(order))
            assert facts(family.at({"a": value}).iterate(order)) == expected, (value, order)
            if alone.letters == family.letters:  # at some values two of its pieces are one
                assert facts(cell.map.iterate(order), value) == expected, (value, order)
                checked += 1
        assert checked >= len(VALUES) - 1


@pytest.mark.nightly
@thorough(60)
@given(st.fractions(-5, 5), st.fractions(Rational(1, 9), 5), st.fractions(-5, 5))
def test_points_are_followed_as_in_fractions(x, a, r) -> None:  # type: ignore[no-untyped-def]
    map_ = read("Piecewise((x/a + r, x < r/(a + 1)), (1/a - x*r/(a + 1), True))", given=["a > 0"])
    y, word = x, ""
    for _ in range(4):
        left = y < r / (a + 1)
        word += "L" if left else "R"
        y = y / a + r if left else 1 / a - y * r / (a + 1)
    fourth = map_.at({"a": a, "r": r}).iterate(4)
    assert fourth(x) == Rational(y.numerator, y.denominator)
    assert fourth.word_of(x) == word
    assert map_.at({"a": a}).at({"r": r}).iterate(4)(x) == fourth(x)


def test_a_symbolic_family() -> None:
    map_ = read("Piecewise((x/a, x < 1/a), (r - x/(a + 1), True))", given=["a > 1", "r > 3"])
    assert [sympy.simplify(p.x - R * (A + 1) / (A + 2)) for p in map_.fixed_points()[1:]] == [0]
    assert map_.fixed_points()[0].x == 0
    (jump,) = map_.jumps()
    assert jump.x == 1 / A
    assert jump.left == A**-2
    assert sympy.simplify(jump.right - (R - 1 / (A * (A + 1)))) == 0
    assert str(pickle.loads(pickle.dumps(map_))) == str(map_)
    cycle = map_.cycle("R")
    assert cycle.admissible
    assert sympy.simplify(cycle.multiplier + 1 / (A + 1)) == 0
    inner = read("x/b + 1/b", given=["b > 0"])
    both = map_ @ inner
    point = both.at({"a": 2, "r": 4, "b": 3})(5)
    assert point == map_.at({"a": 2, "r": 4})(inner.at({"b": 3})(5)) == Rational(4) - Rational(2, 3)


def test_denominators_have_a_sign_or_are_refused() -> None:
    with pytest.raises(UndecidedError, match="a denominator must have a sign, but the sign of a "):
        read("x/a", given=["a > -1"])
    with pytest.raises(UndecidedError, match="sign of a"):
        read("Piecewise((1, x < 1/a), (2, True))")
    assert read("x/a", given=["a < 0"]).at({"a": -2})(3) == Rational(-3, 2)
    assert read("x*a/a")(3) == 3
    with pytest.raises(ValueError, match="zero"):
        read("x/(a - a)")
    with pytest.raises(ValueError, match="a = 0 contradicts"):
        read("x/a", given=["a > 0"]).at({"a": 0})


def test_signs_are_those_of_quotients_also_where_a_denominator_is_negative() -> None:
    second = read("Abs(x - 1/a)", given=["a < -1"]).iterate(2)
    assert [str(p) for p in second.pieces] == ["LR: -x for x < 1/a", "RR: x - 2/a for 1/a <= x"]


def test_a_diagram_up_to_a_zero_of_a_denominator() -> None:
    map_ = read("Piecewise((x/a + 1, x < 0), (1 - 2*x/(a + 1), True))", given=["a > 0"])
    for span in ((0, 4), (Rational(1, 10), 4), None):
        diagram = bifurcation_diagram(map_, "a", span, (1,))
        exact = {"R": (A + 1) / (A + 3), "L": A / (A - 1)}
        for branch in diagram.branches:
            if branch.word in exact:
                assert sympy.simplify(branch.exact["x"] - exact[branch.word]) == 0
        assert {branch.word for branch in diagram.branches} >= {"L", "R"}
        ends = [b.exact["interval"].sup for b in diagram.branches if b.word == "L"]
        assert max(ends) == 1
    with pytest.raises(ValueError, match="in the span contradicts the assumption a > 0"):
        bifurcation_diagram(map_, "a", (-1, 4), (1,))


def test_positive_denominators_are_no_part_of_what_is_undecided() -> None:
    """The decision is b (a + 1)**2 in numerators over a + 1; only b has no sign."""
    text = "Piecewise((x/(a + 1) + b, x <= 0), (b - a*x/(a + 1), True))"
    map_ = PiecewiseLinearMap.from_sympy(text, given=["a > 0"])
    with pytest.raises(UndecidedError, match=r"^the sign of b does not follow from a > 0: assume"):
        map_.iterate(2).fixed_points()
