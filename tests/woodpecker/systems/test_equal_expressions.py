"""Expressions that are the same function, and some that are nearly so."""

import pytest
import sympy

from woodpecker.systems.mechanics.expressions import are_equal

X, Y, V = sympy.symbols("x y v")
LENGTH = sympy.Symbol("length", positive=True)
SMALL = sympy.Rational(1, 10**30)

SAME = [
    (V * sympy.tan(X / 2), V * sympy.sin(X) / (1 + sympy.cos(X))),
    (V * sympy.sqrt(3 + 2 * sympy.sqrt(2)), V * (1 + sympy.sqrt(2))),
    (V * sympy.cbrt(7 + 5 * sympy.sqrt(2)), V * (1 + sympy.sqrt(2))),
    (V * (X**2 - Y**2) / (X - Y), V * X + V * Y),
    (V * sympy.cos(5 * sympy.acos(X)), V * (16 * X**5 - 20 * X**3 + 5 * X)),
    (3 * sympy.Float(0.1) * V, sympy.Float(0.3) * V),  # they differ by a rounding
    (V * sympy.log(LENGTH**2 + LENGTH), V * sympy.log(LENGTH) + V * sympy.log(LENGTH + 1)),
    (sympy.Integer(0), (X + 1) ** 2 - X**2 - 2 * X - 1),
]
OTHER = [
    (V * sympy.sin(X), V * sympy.cos(X)),
    (V, V * (1 + SMALL)),
    (V + SMALL * X, V),
    (sympy.Float(0.1) * V, sympy.Float(0.1000000001) * V),
    (V * sympy.sqrt(X**2), V * X),  # not where x is negative
    (sympy.Float(1e-30) * V, sympy.Integer(0)),
    (sympy.Function("f")(X), V),  # nobody knows the values of f
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_the_same_function(one: sympy.Expr, other: sympy.Expr) -> None:
    assert one != other
    assert are_equal(one, other)
    assert are_equal(other, one)


@pytest.mark.parametrize(("one", "other"), OTHER)
def test_another_function(one: sympy.Expr, other: sympy.Expr) -> None:
    assert not are_equal(one, other)
    assert not are_equal(other, one)


def test_functions_that_are_the_same_where_gaps_are_zero() -> None:
    """Corners of a block have one slip where both are closed, not where one is."""
    sides = [sympy.cos(X) + side * LENGTH * sympy.sin(X) for side in (1, -1)]
    both = [Y - arm for arm in sides]
    one, other = (V * arm for arm in sides)
    assert not are_equal(one, other)
    assert are_equal(one, other, both, (X, Y))
    assert not are_equal(one, other + V * Y, both, (X, Y))
    assert not are_equal(one, other, both[:1], (X, Y))
    assert not are_equal(V, 2 * V, (X**2 + 1,), (X,))  # a gap that is never zero
