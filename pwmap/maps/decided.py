"""Maps whose signs are decided: a table of pieces, a chain of maps, an oracle and its scope.

The scope is the set of parameter values for which the answers of a map hold: its assumptions, or a
cell. A cell is cut for some orders of iterates; any other question about its map is answered if the
answer is the same throughout the cell, and refused otherwise.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Self, TypeVar

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.arguments import check_mapping, shortened, shown
from pwmap.algebra.arithmetic import rational
from pwmap.algebra.assumptions import AssumedRegion, UndecidedError
from pwmap.algebra.exact import (
    Fraction_,
    Infinite,
    Number,
    Portable,
    constant,
    degree_in,
    dense,
    evaluate,
    fraction_to_sympy,
    is_constant,
    names_of,
    polynomial_ring,
    quotient_to_sympy,
    sign,
    to_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.rootfunctions import (
    Column,
    Root,
    at_root_of,
    critical,
    divides,
    irreducible_factors,
)
from pwmap.algebra.roots import Real, real_roots, real_to_sympy, sign_at, simplest_between
from pwmap.algebra.terms import checked_parameter
from pwmap.maps import cylinders as cyl
from pwmap.maps.budget import BUDGET, Meter
from pwmap.maps.cylinders import Cut, Cylinder, StudiedIterate
from pwmap.maps.reading import Definition
from pwmap.maps.words import Layout, Orbits, SignOracle, Table, Word, over_one_denominator

Orders = tuple[int, ...]


class CellScope(Portable, ABC):
    """The scope of a cell or an edge, in which a sign is known if it is the same throughout."""

    __slots__ = ()
    symbol: sympy.Symbol  # the parameter of the axis
    orders: Orders

    @property
    def is_edge(self) -> bool:
        """Whether it is one value of the parameter, a number or a quotient."""
        return False

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The scope as inequalities; none where its ends are algebraic numbers or functions."""
        return ()

    def sign(self, polynomial: Number) -> int:
        """The sign of a polynomial; UndecidedError unless it is known to be the same throughout."""
        if is_constant(polynomial):
            return sign(constant(polynomial))
        found = self._sign(polynomial)
        if found is None:
            raise UndecidedError(refusal(polynomial, self, self.orders))
        return found

    def contains(self, values: Mapping[str, Number]) -> CellScope | None:
        """None if the given values lie inside, otherwise the scope itself."""
        return None if self._holds(values) else self

    @abstractmethod
    def _sign(self, polynomial: Number) -> int | None:
        """The sign of a polynomial, or None if it may change within the scope."""

    @abstractmethod
    def _holds(self, values: Mapping[str, Number]) -> bool:
        """Whether the given values lie inside; parameters without a value do not matter."""


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
    region: AssumedRegion  # the assumptions on the others, and the bounds of an open cell
    low: sympy.Expr  # its ends, which are equal for one value
    high: sympy.Expr
    orders: Orders = field(compare=False)
    value: Fraction_ | None = None  # the one value, with a denominator of one sign

    @property
    def is_edge(self) -> bool:
        """Whether it is one value, whatever those of the others."""
        return self.value is not None

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints of the region; one value adds two opposite inequalities."""
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
            return self.region.known_sign(polynomial)
        found = self.region.known_sign(at_root_of(polynomial, self._line(), self._index))
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
    """The part of a column between two roots that do not meet (or infinity), or one root."""

    column: Column
    low: Root | Infinite
    high: Root | Infinite
    orders: Orders = field(compare=False)

    @property
    def symbol(self) -> sympy.Symbol:
        """The parameter in which the roots are taken."""
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
        """Whether an irreducible polynomial is known to have no zero in the cell."""
        column = self.column
        if not degree_in(factor, column.along):
            return column.keeps(factor)
        for root in real_roots(column.at_sample(factor)):
            if self.low.value < root < self.high.value:
                return False
        if not all(map(column.keeps, critical(factor, column.along))):
            return False
        ends = (end for end in (self.low, self.high) if isinstance(end, Root))
        return all(end.factor == factor or column.is_apart(end, factor) for end in ends)

    def _holds(self, values: Mapping[str, Number]) -> bool:
        column, index = self.column, self.column.along
        other, own = (values.get(str(column.symbols[i])) for i in (1 - index, index))
        if other is None or not column.holds(other):
            return other is None
        low, high = (column.number(end, other) for end in (self.low, self.high))
        if own is None or self._root is not None:
            return own is None or own == low
        return bool(low < own < high)

    def __str__(self) -> str:
        low, high = (end.to_sympy(self.column) for end in (self.low, self.high))
        return between(low, self.symbol, high) if self._root is None else f"{self.symbol} = {low}"


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


Chain = tuple[int, ...]  # the maps (layouts) that are applied one after the other


class Decided:
    """A map whose signs are decided by the assumptions on its parameters, or in a cell.

    It has the ``definition`` (coefficients and assumptions), the ``chain`` (the maps applied one
    after the other), the ``scope`` (the parameter values for which all answers hold), the
    ``oracle`` (the signs there), and the ``iterates`` that its cell was cut for. Its iterates share
    the cylinders that are ``known`` by chain.
    """

    def __init__(
        self,
        definition: Definition,
        chain: Chain = (0,),
        scope: Scope | None = None,
        oracle: SignOracle | None = None,
        iterates: Mapping[Chain, StudiedIterate] | None = None,
    ) -> None:
        self.definition, self.chain = definition, chain
        self.scope = definition.region if scope is None else scope
        decide = sign if definition.ring is None else self.scope.sign
        self.oracle = oracle or SignOracle(Orbits(definition.table), decide)
        self.iterates = iterates or {}
        self.known = {(): cyl.WHOLE_LINE, **{c: i.cylinders for c, i in self.iterates.items()}}

    @classmethod
    def of(cls, *parts: Any) -> Self:
        """A map from the arguments of :class:`Decided`, whatever ``__init__`` a subclass has."""
        self = cls.__new__(cls)
        Decided.__init__(self, *parts)
        return self

    def __reduce__(self) -> tuple[Callable[..., Self], tuple[object, ...]]:
        kept = self.definition, self.chain, self.scope, self.oracle, self.iterates
        return type(self).of, kept  # cylinders are computed anew

    @property
    def orbits(self) -> Orbits:
        """The affine maps of words, with coefficients in the ring of the parameters."""
        return self.oracle.orbits

    @property
    def studied(self) -> StudiedIterate | None:
        """Fixed points and crossings, if the cell was cut for this iterate."""
        return self.iterates.get(self.chain)

    @cached_property
    def cylinders(self) -> tuple[Cylinder, ...]:
        """The pieces as cylinders, from left to right."""
        chain, known = self.chain, self.known
        start = next(n for n in range(len(chain), -1, -1) if chain[:n] in known)
        meter, oracle = Meter(BUDGET), self.oracle
        for n in range(start, len(chain)):
            known[chain[: n + 1]] = cyl.refined(
                known[chain[:n]], chain[n], oracle, meter, oracle.ask
            )
        return known[chain]

    def layouts(self, n: int) -> list[Layout]:
        """The layouts of n maps in a row, the chain repeated."""
        chain = self.chain
        return [self.definition.table.layouts[chain[i % len(chain)]] for i in range(n)]

    @property
    def layout(self) -> Layout:
        """The layout of the map that is applied first."""
        return self.definition.table.layouts[self.chain[0]]

    def spelled(self, word: Word) -> str:
        """A word in letters."""
        return "".join(self.definition.letters[letter] for letter in word)

    def numbered(self, letters: Iterable[str]) -> Word:
        """The word that :meth:`spelled` writes in these letters of one map."""
        return tuple(map(self.definition.letters.index, letters))

    def cut_to_sympy(self, word: Word, cut: Cut) -> sympy.Expr:
        """The exact x of a cut of a word, as an expression."""
        return fraction_to_sympy(self.orbits.preimage(cut.k, word[: cut.steps]))

    def slope(self, word: Word) -> sympy.Expr:
        """The slope of a word."""
        return quotient_to_sympy(self.orbits.slope(word))

    def period(self, word: Word) -> int:
        """Minimal period of a point with a word, counted in single maps."""
        unit = cyl.minimal_period(self.chain)  # an iterate of p @ q repeats every two maps
        return cyl.minimal_period(word, unit) * unit

    def is_zero(self, number: Number) -> bool:
        """Whether a polynomial vanishes identically, or at the edge that is the map's scope."""
        at_edge = isinstance(self.scope, CellScope) and self.scope.is_edge
        return not number or (at_edge and self.scope.sign(number) == 0)

    def with_chain(self, chain: Chain) -> Self:
        """The same maps applied along another chain; known cylinders are shared."""
        twin = self.of(self.definition, chain, self.scope, self.oracle, self.iterates)
        twin.known = self.known
        return twin


Map = TypeVar("Map", bound=Decided)


def with_values(map_: Map, values: Mapping[Any, object]) -> Map:
    """The map with rational values for some of its parameters, by symbol or by name."""
    check_mapping("values", values)
    definition, own = map_.definition, map_.definition.parameters
    numbers = {checked_parameter(name, own): rational(value) for name, value in values.items()}
    if not numbers:
        return map_
    broken, cell = definition.region.contains(numbers), map_.scope.contains(numbers)
    if broken is not None or cell is not None:
        given = shortened(shown_values(numbers))
        if broken is not None:
            raise ValueError(f"{given} contradicts the assumption {broken}")
        raise ValueError(f"{given} lies outside of the cell {cell}, for which this map holds")
    ring = polynomial_ring([s for s in own if str(s) not in numbers])
    valued = partial(evaluate, values=numbers)
    whole = AssumedRegion(None, (*definition.region.constraints, *map_.scope.constraints))
    region, table = whole.moved(ring, valued), definition.table.mapped(valued)
    return map_.of(Definition(definition.x, region, table, definition.letters), map_.chain)


def shown_values(values: Mapping[str, Number]) -> str:
    """Values of parameters for a message, such as ``a = 5/4, r = 1``."""
    return ", ".join(f"{name} = {shown(QQ.to_sympy(value))}" for name, value in values.items())


def composed(outer: Map, inner: Map) -> Map:
    """The map x -> outer(inner(x)), in the cell of whichever map has one."""
    if inner.definition == outer.definition:
        wide = outer.scope == outer.definition.region  # otherwise a cell, which is narrower
        if not wide and inner.scope not in (outer.scope, inner.definition.region):
            raise ValueError(f"the maps hold in different cells, {outer.scope} and {inner.scope}")
        return (inner if wide else outer).with_chain(inner.chain + outer.chain)
    definition, shift = _joined(inner.definition, outer.definition)
    chain = inner.chain + tuple(i + shift for i in outer.chain)
    cell = next((m.scope for m in (outer, inner) if m.scope != m.definition.region), None)
    both_vary = outer.definition.parameters and inner.definition.parameters
    return outer.of(definition, chain, None if both_vary else cell)


def _joined(first: Definition, second: Definition) -> tuple[Definition, int]:
    """Two maps in one table, and by how much the layouts of the second were shifted."""
    if first.x != second.x:
        raise ValueError(f"the maps have different variables, {first.x} and {second.x}")
    symbols = {str(symbol): symbol for symbol in (*first.parameters, *second.parameters)}
    ring = polynomial_ring([symbols[name] for name in sorted(symbols)])

    def moved(number: Number) -> Number:
        return to_ring(number, ring)

    tables = over_one_denominator([m.table.mapped(moved) for m in (first, second)])
    pieces, breaks = len(first.letters), len(first.table.breaks)
    shifted = [
        Layout(tuple(k + breaks for k in lay.breaks), tuple(s + pieces for s in lay.slots))
        for lay in second.table.layouts
    ]
    both = AssumedRegion(None, (*first.region.constraints, *second.region.constraints))
    table = Table(
        tables[0].slopes + tables[1].slopes,
        tables[0].intercepts + tables[1].intercepts,
        tables[0].breaks + tables[1].breaks,
        (*first.table.layouts, *shifted),
        tables[0].one,
        tables[0].denominator,
    )
    region, letters = both.moved(ring, moved), first.letters + second.letters
    return Definition(first.x, region, table, letters), len(first.table.layouts)
