"""A map as a table of pieces, a chain of maps, and an oracle of signs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Self, TypeVar

import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_mapping, shortened
from pwmap.algebra.arithmetic import rational
from pwmap.algebra.assumptions import AssumedRegion
from pwmap.algebra.exact import (
    Number,
    evaluate,
    fraction_to_sympy,
    is_constant,
    polynomial_ring,
    quotient_to_sympy,
    sign,
    to_ring,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.terms import checked_parameter
from pwmap.maps import cylinders as cyl
from pwmap.maps.budget import BUDGET, Meter
from pwmap.maps.cylinders import Cut, Cylinder, StudiedIterate
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import CellScope, Scope
from pwmap.maps.words import Layout, Orbits, SignOracle, Table, Word, over_one_denominator

Chain = tuple[int, ...]  # the maps (layouts) that are applied one after the other


class Decided:
    """A map whose signs are decided, by what is assumed of its parameters or in a cell.

    It has the ``definition`` (coefficients and assumptions), the ``chain`` (which maps are applied
    one after the other), the ``scope`` (for which values of the parameters all answers hold), the
    ``oracle`` (the signs there), and the ``iterates`` that its cell was cut for. Pieces that were
    asked for are ``known``, for all of its iterates.
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
        """A map of these parts; by default its signs follow from what is assumed."""
        self = cls.__new__(cls)
        Decided.__init__(self, *parts)
        return self

    def __reduce__(self) -> tuple[Callable[..., Self], tuple[object, ...]]:
        kept = self.definition, self.chain, self.scope, self.oracle, self.iterates
        return type(self).of, kept  # pieces are made anew

    @property
    def orbits(self) -> Orbits:
        """Affine forms of words in the ring of the parameters."""
        return self.oracle.orbits

    @property
    def studied(self) -> StudiedIterate | None:
        """Fixed points and crossings, if the cell was cut for this iterate."""
        return self.iterates.get(self.chain)

    @cached_property
    def cylinders(self) -> tuple[Cylinder, ...]:
        """The pieces in combinatorial form, from left to right."""
        chain, known = self.chain, self.known
        start = next(n for n in range(len(chain), -1, -1) if chain[:n] in known)
        meter = Meter(BUDGET)
        for n in range(start, len(chain)):
            known[chain[: n + 1]] = cyl.refined(known[chain[:n]], chain[n], self.oracle, meter)
        return known[chain]

    def layouts(self, n: int) -> list[Layout]:
        """The layouts of n maps in a row, the chain repeated."""
        chain = self.chain
        return [self.definition.table.layouts[chain[i % len(chain)]] for i in range(n)]

    def spelled(self, word: Word) -> str:
        """A word in letters."""
        return "".join(self.definition.letters[letter] for letter in word)

    def cut_to_sympy(self, word: Word, cut: Cut) -> sympy.Expr:
        """The exact value of an end of a piece that has a word."""
        return fraction_to_sympy(self.orbits.preimage(cut.k, word[: cut.steps]))

    def slope(self, word: Word) -> sympy.Expr:
        """The slope of a word."""
        return quotient_to_sympy(self.orbits.slope(word))

    def period(self, word: Word) -> int:
        """Minimal period of a point with a word, counted in single maps."""
        unit = cyl.minimal_period(self.chain)  # an iterate of p @ q repeats every two maps
        return cyl.minimal_period(word, unit) * unit

    def is_zero(self, number: Number) -> bool:
        """Whether a number is zero for all parameters, or at the edge of the map."""
        at_edge = isinstance(self.scope, CellScope) and self.scope.is_edge
        return not number or (at_edge and self.scope.sign(number) == 0)

    def with_chain(self, chain: Chain) -> Self:
        """The same maps, applied in another order."""
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
    given = shortened(", ".join(f"{n} = {QQ.to_sympy(v)}" for n, v in numbers.items()))
    broken = definition.region.contains(numbers)
    if broken is not None:
        raise ValueError(f"{given} contradicts the assumption {broken}")
    cell = map_.scope.contains(numbers)
    if cell is not None:
        raise ValueError(f"{given} lies outside of the cell {cell}, for which this map holds")
    ring = polynomial_ring([s for s in own if str(s) not in numbers])
    constraints = [
        Constraint(evaluate(c.polynomial, numbers, ring), c.strict)
        for c in dict.fromkeys((*definition.region.constraints, *map_.scope.constraints))
    ]
    region = AssumedRegion(ring, tuple(c for c in constraints if not is_constant(c.polynomial)))
    _ = region.sample  # complains if the values leave nothing
    table = definition.table.mapped(lambda number: evaluate(number, numbers, ring))
    return map_.of(Definition(definition.x, region, table, definition.letters), map_.chain)


def composed(outer: Map, inner: Map) -> Map:
    """The map x -> outer(inner(x)), for the cell of the one that has a cell."""
    if inner.definition == outer.definition:
        wide = outer.scope == outer.definition.region  # a cell is the narrower one
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
    symbols = {
        str(s): s for ring in (first.ring, second.ring) if ring is not None for s in ring.symbols
    }
    ring = polynomial_ring([symbols[name] for name in sorted(symbols)])
    tables = over_one_denominator(
        [m.table.mapped(lambda number: to_ring(number, ring)) for m in (first, second)]
    )
    letters, breaks = len(first.letters), len(first.table.breaks)
    shifted = [
        Layout(tuple(k + breaks for k in lay.breaks), tuple(s + letters for s in lay.slots))
        for lay in second.table.layouts
    ]
    constraints = [
        Constraint(to_ring(c.polynomial, ring), c.strict)
        for m in (first, second)
        for c in m.region.constraints
    ]
    region = AssumedRegion(ring, tuple(dict.fromkeys(constraints)))
    _ = region.sample
    table = Table(
        tables[0].slopes + tables[1].slopes,
        tables[0].intercepts + tables[1].intercepts,
        tables[0].breaks + tables[1].breaks,
        (*first.table.layouts, *shifted),
        tables[0].one,
        tables[0].denominator,
    )
    definition = Definition(first.x, region, table, first.letters + second.letters)
    return definition, len(first.table.layouts)
