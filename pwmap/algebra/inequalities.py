"""Polynomial inequalities of parameters, which are ring generators, known by their index."""

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
    """The assumption that a polynomial is positive (strict) or not negative."""

    polynomial: PolyElement
    strict: bool

    def holds(self, number_sign: int) -> bool:
        """Whether the constraint admits this sign of the polynomial."""
        return number_sign > 0 or (number_sign == 0 and not self.strict)

    def __str__(self) -> str:
        return shortened(str(self.relation()))

    def relation(self) -> Relational:
        """The constraint as a sympy relation, solved for a single linear parameter: a > 1/2."""
        constant_, rest = sympy.factor(to_sympy(self.polynomial)).as_coeff_Add()
        scale, symbol = rest.as_coeff_Mul()
        if symbol.is_Symbol:
            constant_, rest = constant_ / abs(scale), sympy.sign(scale) * symbol
        if rest.could_extract_minus_sign():
            return (sympy.Lt if self.strict else sympy.Le)(-rest, constant_, evaluate=False)
        return (sympy.Gt if self.strict else sympy.Ge)(rest, -constant_, evaluate=False)


def shown(constraints: Iterable[Constraint]) -> str:
    """The inequalities as text, or "no assumption"."""
    return ", ".join(str(c.relation()) for c in constraints) or "no assumption"


@cache
def connected(constraints: tuple[Constraint, ...], start: frozenset[int]) -> tuple[Constraint, ...]:
    """The inequalities tied to given parameters, directly or through one another."""
    occurring, reached = [variables(c.polynomial) for c in constraints], start
    while tied := [own for own in occurring if own & reached and not own <= reached]:
        reached = reached.union(*tied)
    return tuple(c for c, own in zip(constraints, occurring, strict=True) if own & reached)


def combined(
    constraints: Iterable[Constraint], monomials: Sequence[tuple[int, ...]]
) -> tuple[bool, tuple[Fraction, ...]]:
    """Whether nonnegative multiples of inequalities, and of 1 > 0, add up to a false one.

    With their weights or, if not, a separating vector: an entry for each monomial, of which 1 is
    the last, and one more. Over the entry of 1 it is a point where linear ones hold [Motzkin1936].
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
    """The indices of the generators that occur in a polynomial."""
    degrees = [max(exponents) for exponents in zip(*polynomial.monoms(), strict=True)]
    return frozenset(i for i, degree in enumerate(degrees) if degree)


def along(polynomial: PolyElement, values: Sequence[Number], variable: int) -> Dense:
    """The coefficients in one generator, highest power first, at values of the others."""
    powers = partly(polynomial, [*values[:variable], None, *values[variable + 1 :]])
    top = max(powers, default=(-1,))[0]
    return trimmed(powers.get((i,), QQ.zero) for i in range(top, -1, -1))


def value_at(polynomial: PolyElement, values: Sequence[Number]) -> Number:
    """The value of a polynomial at values of all generators, in one field."""
    return partly(polynomial, values).get((), QQ.zero)


def proportion(polynomial: PolyElement, factor: PolyElement) -> int:
    """The sign of the constant c with polynomial = c factor, or 0 if there is no such c."""
    if len(polynomial) != len(factor):
        return 0
    scale = polynomial.LC / factor.LC
    return sign(scale) if polynomial == scale * factor else 0
