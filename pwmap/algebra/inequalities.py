"""Polynomial inequalities between parameters, the generators of a ring, given by number."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import sympy
from sympy import QQ
from sympy.core.relational import Relational
from sympy.polys.rings import PolyElement

from pwmap.algebra.arguments import shortened
from pwmap.algebra.exact import Number, partly, sign, to_sympy
from pwmap.algebra.linear import combination
from pwmap.algebra.roots import Dense, integers, trimmed

Signs = frozenset[int]
ANY: Signs = frozenset((-1, 0, 1))


class Constraint(NamedTuple):
    """A polynomial that is positive (strict) or not negative."""

    polynomial: PolyElement
    strict: bool

    def holds(self, number_sign: int) -> bool:
        """Whether a sign of the polynomial is admitted."""
        return number_sign > 0 or (number_sign == 0 and not self.strict)

    def __str__(self) -> str:
        return shortened(str(self.relation()))

    def relation(self) -> Relational:
        """As a sympy relation; of one parameter in degree one, such as a > 1/2."""
        constant_, rest = sympy.factor(to_sympy(self.polynomial)).as_coeff_Add()
        scale, symbol = rest.as_coeff_Mul()
        if symbol.is_Symbol:
            constant_, rest = constant_ / abs(scale), sympy.sign(scale) * symbol
        if rest.could_extract_minus_sign():
            return (sympy.Lt if self.strict else sympy.Le)(-rest, constant_, evaluate=False)
        return (sympy.Gt if self.strict else sympy.Ge)(rest, -constant_, evaluate=False)


def shown(constraints: Iterable[Constraint]) -> str:
    """Inequalities as text, or "no assumption"."""
    return ", ".join(str(c.relation()) for c in constraints) or "no assumption"


@cache
def connected(constraints: tuple[Constraint, ...], start: frozenset[int]) -> tuple[Constraint, ...]:
    """The inequalities that share parameters with some, directly or through one another."""
    occurring, reached = [variables(c.polynomial) for c in constraints], start
    while tied := [own for own in occurring if own & reached and not own <= reached]:
        reached = reached.union(*tied)
    return tuple(c for c, own in zip(constraints, occurring, strict=True) if own & reached)


def combined(
    constraints: Iterable[Constraint], monomials: Sequence[tuple[int, ...]]
) -> tuple[bool, tuple[Fraction, ...]]:
    """Whether nonnegative multiples of inequalities, and of 1 > 0, add up to a false one.

    With their weights, or a vector that separates them: values of the monomials, of which the last
    is 1, and a scale. For linear inequalities these are a point at which they hold [Motzkin1936].
    """
    columns = []
    for constraint in constraints:
        polynomial, strict = constraint
        terms = dict(zip(polynomial.monoms(), integers(polynomial.coeffs()), strict=True))
        columns.append([*(terms.get(monomial, 0) for monomial in monomials), int(strict)])
    columns.append([0] * (len(monomials) - 1) + [1, 1])
    return combination(columns, [0] * len(monomials) + [1])


# --- Polynomials ----------------------------------------------------------------------------------


@cache
def variables(polynomial: PolyElement) -> frozenset[int]:
    """Which generators occur."""
    degrees = [max(exponents) for exponents in zip(*polynomial.monoms(), strict=True)]
    return frozenset(i for i, degree in enumerate(degrees) if degree)


def along(polynomial: PolyElement, values: Sequence[Number], variable: int) -> Dense:
    """Coefficients in one generator, highest power first, where the others have values."""
    powers = partly(polynomial, [*values[:variable], None, *values[variable + 1 :]])
    top = max(powers, default=(-1,))[0]
    return trimmed(powers.get((i,), QQ.zero) for i in range(top, -1, -1))


def value_at(polynomial: PolyElement, values: Sequence[Number]) -> Number:
    """Value of a polynomial at rational values of all generators."""
    return partly(polynomial, values).get((), QQ.zero)


def proportion(polynomial: PolyElement, factor: PolyElement) -> int:
    """Sign of the constant c with polynomial = c factor, or 0 if there is none."""
    if len(polynomial) != len(factor):
        return 0
    scale = polynomial.LC / factor.LC
    return sign(scale) if polynomial == scale * factor else 0
