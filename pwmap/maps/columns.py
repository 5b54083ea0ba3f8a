"""Cells of two parameters whose borders are roots of polynomials of any degree.

Over an open interval of one parameter real roots in the other one are functions that do not meet. A
cell is what lies between two of them, an edge is one of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.bivariate import discriminant, divides, irreducible_factors, leading_in
from pwmap.algebra.exact import Infinite, Number, degree_in
from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import real_roots, sign_at, simplest_between
from pwmap.maps.scopes import CellScope, Orders, between


@dataclass(frozen=True, slots=True)
class ColumnCell(CellScope):
    """The part of a column between two roots, or the ends of the line; or one root."""

    column: Column
    low: Root | Infinite
    high: Root | Infinite
    orders: Orders = field(compare=False)

    @property
    def symbol(self) -> sympy.Symbol:
        """The parameter of roots."""
        return self.column.symbols[self.column.along]

    @property
    def _root(self) -> Root | None:
        """That over which it lies, if it is an edge."""
        return self.low if isinstance(self.low, Root) and self.low == self.high else None

    def _sign(self, polynomial: Number) -> int | None:
        root, column = self._root, self.column
        if root is not None:
            if divides(root.factor, polynomial):
                return 0
            value = root.value if column.is_apart(root, polynomial) else None
        else:
            clear = all(map(self._is_clear, irreducible_factors(polynomial)))
            value = simplest_between(self.low.value, self.high.value) if clear else None
        return None if value is None else sign_at(column.at_sample(polynomial), value)

    def _is_clear(self, factor: PolyElement) -> bool:
        """Whether an irreducible polynomial is surely not zero in the cell."""
        column = self.column
        if not degree_in(factor, column.along):
            return column.keeps(factor)
        for root in real_roots(column.at_sample(factor)):
            if self.low.value < root < self.high.value:
                return False
        if not column.keeps(leading_in(factor, column.along)):
            return False
        if degree_in(factor, column.along) > 1 and not column.keeps(
            discriminant(factor, column.along)
        ):
            return False
        ends = (end for end in (self.low, self.high) if isinstance(end, Root))
        return all(end.factor == factor or column.is_apart(end, factor) for end in ends)

    def _holds(self, values: Mapping[str, Number]) -> bool:
        other, own = self.column.values(values)
        if other is None or not self.column.holds(other):
            return other is None
        low, high = (self.column.number(end, other) for end in (self.low, self.high))
        if own is None or self._root is not None:
            return own is None or own == low
        return bool(low < own < high)

    def __str__(self) -> str:
        low, high = (end.to_sympy(self.column) for end in (self.low, self.high))
        return between(low, self.symbol, high) if self._root is None else f"{self.symbol} = {low}"
