"""The values of the parameters for which the answers of a map hold: its assumptions, or a cell.

A cell is cut for some orders of iterates; other questions about its map are answered if the answer
is the same throughout the cell, and refused otherwise.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.assumptions import AssumedRegion, UndecidedError
from pwmap.algebra.exact import (
    Fraction_,
    Infinite,
    Number,
    Portable,
    constant,
    degree_in,
    dense,
    fraction_to_sympy,
    is_constant,
    names_of,
    sign,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.rootfunctions import (
    Column,
    Root,
    at_root_of,
    discriminant,
    divides,
    irreducible_factors,
    leading_in,
)
from pwmap.algebra.roots import Real, real_roots, real_to_sympy, sign_at, simplest_between

Orders = tuple[int, ...]


class CellScope(Portable, ABC):
    """A cell, or an edge of cells: a sign is known at one place of it, maybe everywhere."""

    __slots__ = ()
    symbol: sympy.Symbol  # the parameter of the axis
    orders: Orders

    @property
    def is_edge(self) -> bool:
        """Whether it is one value of the parameter, a number or a quotient."""
        return False

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """None, where a border is an algebraic number or function, and no inequality."""
        return ()

    def sign(self, polynomial: Number) -> int:
        """The sign of a polynomial, if it is the same throughout."""
        if is_constant(polynomial):
            return sign(constant(polynomial))
        found = self._sign(polynomial)
        if found is None:
            raise UndecidedError(refusal(polynomial, self, self.orders))
        return found

    def contains(self, values: Mapping[str, Number]) -> CellScope | None:
        """The cell itself, if values lie outside, as far as they are given."""
        return None if self._holds(values) else self

    @abstractmethod
    def _sign(self, polynomial: Number) -> int | None:
        """The sign of a polynomial, or None if it may have several."""

    @abstractmethod
    def _holds(self, values: Mapping[str, Number]) -> bool:
        """Whether values lie inside."""


Scope = AssumedRegion | CellScope  # values of the parameters


@dataclass(frozen=True, slots=True)
class NumberCell(CellScope):
    """An open cell of the only parameter, or one value of it."""

    symbol: sympy.Symbol
    low: Real
    high: Real
    orders: Orders = field(compare=False)

    @property
    def is_edge(self) -> bool:
        """Whether it is one value."""
        return bool(self.low == self.high)

    def _sign(self, polynomial: Number) -> int | None:
        coefficients = dense(polynomial)
        if self.is_edge:
            return sign_at(coefficients, self.low)
        if any(self._contains(root) for root in real_roots(coefficients)):
            return None
        return sign_at(coefficients, simplest_between(self.low, self.high))

    def _holds(self, values: Mapping[str, Number]) -> bool:
        value = values.get(str(self.symbol))
        return value is None or self._contains(value)

    def _contains(self, value: Real) -> bool:
        if self.is_edge:
            return bool(value == self.low)
        return bool(self.low < value < self.high)

    def __str__(self) -> str:
        low, high = map(real_to_sympy, (self.low, self.high))
        return f"{self.symbol} = {low}" if self.is_edge else between(low, self.symbol, high)


@dataclass(frozen=True, slots=True)
class SymbolicCell(CellScope):
    """An open cell of one parameter where others stay symbolic, or one value of it."""

    symbol: sympy.Symbol
    region: AssumedRegion  # what is assumed of the others and, of an open cell, its bounds
    low: sympy.Expr  # its ends; of one value both are that
    high: sympy.Expr
    orders: Orders = field(compare=False)
    value: Fraction_ | None = None  # the one value, with a denominator of one sign

    @property
    def is_edge(self) -> bool:
        """Whether it is one value, whatever those of the others."""
        return self.value is not None

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """Those of the region; one value is two inequalities more."""
        sides = () if self.value is None else (1, -1)
        return (*self.region.constraints, *(Constraint(s * self._line(), False) for s in sides))

    def _line(self) -> Number:
        """The polynomial of degree one that is zero at the one value."""
        assert self.value is not None
        top, bottom = self.value
        return self.region.ring.gens[self._index] * bottom - top

    @property
    def _index(self) -> int:
        return names_of(self.region.ring).index(str(self.symbol))

    def _sign(self, polynomial: Number) -> int | None:
        if self.value is None:
            return _sign_in(self.region, polynomial)
        found = _sign_in(self.region, at_root_of(polynomial, self._line(), self._index))
        if found is None:
            return None
        return found * int(self.region.sign(self.value[1]) ** degree_in(polynomial, self._index))

    def _holds(self, values: Mapping[str, Number]) -> bool:
        whole = self.region
        if self.value is not None:
            whole = AssumedRegion(whole.ring, self.constraints)
        return whole.contains(values) is None

    def __str__(self) -> str:
        if self.value is not None:
            return f"{self.symbol} = {fraction_to_sympy(self.value)}"
        return between(self.low, self.symbol, self.high)


@dataclass(frozen=True, slots=True)
class ColumnCell(CellScope):
    """The part of a column between two roots that do not meet, or ends of the line; or one root."""

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


def _sign_in(region: AssumedRegion, polynomial: Number) -> int | None:
    """The sign that inequalities prove, or None."""
    try:
        return region.sign(polynomial)
    except UndecidedError:
        return None


def refusal(polynomial: Number, cell: object, orders: Orders) -> str:
    """Why a sign is not known in a cell, and what to ask for."""
    names = ", ".join(map(str, orders))
    more = (*orders, orders[-1] + 1)
    return (
        f"{sympy.factor(to_sympy(polynomial))} is not known to keep its sign in the cell {cell}, "
        f"which was cut for the orders {names} only: ask for all you need, such as "
        f"parameter_cells(..., orders={more})"
    )


def between(low: sympy.Expr, symbol: sympy.Symbol, high: sympy.Expr) -> str:
    """An open interval as text."""
    left = "" if low == -sympy.oo else f"{low} < "
    right = "" if high == sympy.oo else f" < {high}"
    return f"{left}{symbol}{right}" if left or right else f"of all {symbol}"
