"""Cells of two parameters whose borders are roots of polynomials of any degree.

Over an open interval of one parameter real roots in the other one are functions that do not meet. A
cell is what lies between two of them, an edge is one of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.assumptions import UndecidedError
from pwmap.algebra.bivariate import (
    degree_in,
    discriminant,
    divides,
    irreducible_factors,
    leading_in,
)
from pwmap.algebra.exact import Number, constant, is_constant, sign
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import real_roots, sign_at, simplest_between
from pwmap.maps.scopes import Orders, between, refusal


@dataclass(frozen=True, slots=True)
class ColumnInterval:
    """A cell: the part of a column between two roots; one that is None is infinite."""

    column: Column
    low: Root | None
    high: Root | None
    orders: Orders = field(compare=False)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """None: a root of a polynomial is no inequality."""
        return ()

    def sign(self, polynomial: Number) -> int:
        """The sign, if no root of the polynomial enters the cell."""
        if is_constant(polynomial):
            return sign(constant(polynomial))
        column = self.column
        for factor in irreducible_factors(polynomial):
            if not self._is_clear(factor):
                raise UndecidedError(refusal(polynomial, self, self.orders))
        ends = (None if end is None else end.value for end in (self.low, self.high))
        return sign_at(column.at_sample(polynomial), simplest_between(*ends))

    def _is_clear(self, factor: PolyElement) -> bool:
        """Whether an irreducible polynomial is surely not zero in the cell."""
        column = self.column
        if not degree_in(factor, column.along):
            return column.keeps(factor)
        for root in real_roots(column.at_sample(factor)):
            above = self.low is None or self.low.value < root
            if above and (self.high is None or root < self.high.value):
                return False
        if not column.keeps(leading_in(factor, column.along)):
            return False
        if degree_in(factor, column.along) > 1 and not column.keeps(
            discriminant(factor, column.along)
        ):
            return False
        ends = (end for end in (self.low, self.high) if end is not None)
        return all(end.factor == factor or column.is_apart(end, factor) for end in ends)

    def contains(self, values: Mapping[str, Number]) -> ColumnInterval | None:
        """The cell itself, if the values lie outside."""
        other, own = self.column.values(values)
        if other is None:
            return None
        if not self.column.holds(other):
            return self
        low, high = (
            None if end is None else self.column.number(end, other) for end in (self.low, self.high)
        )
        inside = own is None or ((low is None or low < own) and (high is None or own < high))
        return None if inside else self

    def __str__(self) -> str:
        symbol = self.column.symbols[self.column.along]
        return between(_shown(self.low, self.column), symbol, _shown(self.high, self.column))


@dataclass(frozen=True, slots=True)
class ColumnEdge:
    """A root over a column."""

    column: Column
    root: Root
    orders: Orders = field(compare=False)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """None: a root of a polynomial is no inequality."""
        return ()

    def sign(self, polynomial: Number) -> int:
        """The sign at the root, if it is the same all over the column."""
        if is_constant(polynomial):
            return sign(constant(polynomial))
        if divides(self.root.factor, polynomial):
            return 0
        if not self.column.is_apart(self.root, polynomial):
            raise UndecidedError(refusal(polynomial, self, self.orders))
        return sign_at(self.column.at_sample(polynomial), self.root.value)

    def contains(self, values: Mapping[str, Number]) -> ColumnEdge | None:
        """The edge itself, if the values are not on it."""
        other, own = self.column.values(values)
        if other is None:
            return None
        here = self.column.number(self.root, other)
        return None if here is not None and (own is None or here == own) else self

    def __str__(self) -> str:
        return f"{self.column.symbols[self.column.along]} = {_shown(self.root, self.column)}"


def _shown(root: Root | None, column: Column) -> sympy.Expr | None:
    return None if root is None else root.to_sympy(column)
