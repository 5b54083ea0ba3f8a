"""A map as a table of pieces, a chain of maps, and an oracle of signs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

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


@dataclass(frozen=True, eq=False)
class Decided:
    """A map whose signs are decided."""

    definition: Definition  # coefficients and assumptions
    chain: Chain  # which maps are applied one after the other
    scope: Scope  # where decisions hold
    orbits: Orbits  # affine forms in the ring of the parameters
    oracle: SignOracle  # and their signs there
    iterates: Mapping[Chain, StudiedIterate]  # those that the cell of the map was cut for
    known: dict[Chain, tuple[Cylinder, ...]]  # pieces that were asked for, for all iterates

    def __reduce__(self) -> tuple[Callable[..., Decided], tuple[object, ...]]:
        kept = self.definition, self.chain, self.scope, self.orbits, self.oracle, self.iterates
        return in_cell, kept  # pieces are made anew

    @property
    def x(self) -> sympy.Symbol:
        """The variable."""
        return self.definition.x

    @property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """The parameters that have no value yet."""
        ring = self.definition.ring
        return tuple(ring.symbols) if ring is not None else ()

    @property
    def order(self) -> int:
        """How many maps are composed."""
        return len(self.chain)

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
        return [self.definition.table.layouts[self.chain[i % self.order]] for i in range(n)]

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

    def with_chain(self, chain: Chain) -> Decided:
        """The same maps, applied in another order."""
        return replace(self, chain=chain)


def as_written(definition: Definition, chain: Chain = (0,)) -> Decided:
    """A map whose signs follow from what is assumed of its parameters."""
    orbits = Orbits(definition.table)
    decide = sign if definition.ring is None else definition.region.sign
    return in_cell(definition, chain, definition.region, orbits, SignOracle(orbits, decide), {})


def in_cell(
    definition: Definition,
    chain: Chain,
    scope: Scope,
    orbits: Orbits,
    oracle: SignOracle,
    iterates: Mapping[Chain, StudiedIterate],
) -> Decided:
    """A map whose signs are known in a cell."""
    known = {(): cyl.WHOLE_LINE, **{c: iterate.cylinders for c, iterate in iterates.items()}}
    return Decided(definition, chain, scope, orbits, oracle, iterates, known)


def with_values(map_: Decided, values: Mapping[Any, object]) -> Decided:
    """The map with rational values for some of its parameters, by symbol or by name."""
    check_mapping("values", values)
    definition = map_.definition
    numbers = {
        checked_parameter(name, map_.parameters): rational(value) for name, value in values.items()
    }
    if not numbers:
        return map_
    given = shortened(", ".join(f"{n} = {QQ.to_sympy(v)}" for n, v in numbers.items()))
    broken = definition.region.contains(numbers)
    if broken is not None:
        raise ValueError(f"{given} contradicts the assumption {broken}")
    cell = map_.scope.contains(numbers)
    if cell is not None:
        raise ValueError(f"{given} lies outside of the cell {cell}, for which this map holds")
    ring = polynomial_ring([s for s in map_.parameters if str(s) not in numbers])
    constraints = [
        Constraint(evaluate(c.polynomial, numbers, ring), c.strict)
        for c in dict.fromkeys((*definition.region.constraints, *map_.scope.constraints))
    ]
    region = AssumedRegion(ring, tuple(c for c in constraints if not is_constant(c.polynomial)))
    _ = region.sample  # complains if the values leave nothing
    table = definition.table.mapped(lambda number: evaluate(number, numbers, ring))
    return as_written(Definition(map_.x, region, table, definition.letters), map_.chain)


def composed(outer: Decided, inner: Decided) -> Decided:
    """The map x -> outer(inner(x)), for the cell of the one that has a cell."""
    if inner.definition == outer.definition:
        wide = outer.scope == outer.definition.region  # a cell is the narrower one
        if not wide and inner.scope not in (outer.scope, inner.definition.region):
            raise ValueError(f"the maps hold in different cells, {outer.scope} and {inner.scope}")
        return (inner if wide else outer).with_chain(inner.chain + outer.chain)
    definition, shift = _joined(inner.definition, outer.definition)
    chain = inner.chain + tuple(i + shift for i in outer.chain)
    cell = next((m.scope for m in (outer, inner) if m.scope != m.definition.region), None)
    if cell is None or (outer.parameters and inner.parameters):
        return as_written(definition, chain)
    orbits = Orbits(definition.table)
    return in_cell(definition, chain, cell, orbits, SignOracle(orbits, cell.sign), {})


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
