"""One parameter of a map as an axis with exact places on it.

A place is a number or, beside symbolic parameters, a function of these: a real root of a polynomial
in all parameters, linear in that of the axis if there are several others. Signs are then decided,
and places compared, at a sample of the others; each comparison records the polynomial in them (a
leading coefficient, discriminant or resultant) at whose zeros it can change.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial, total_ordering
from itertools import pairwise
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.assumptions import AssumedRegion
from pwmap.algebra.exact import (
    HIGHEST,
    LOWEST,
    Fraction_,
    Infinite,
    Number,
    constant,
    degree_in,
    dense,
    evaluate,
    fraction_to_sympy,
    is_constant,
    names_of,
    normalised,
    reduced_to_sympy,
    sign,
    to_float,
    to_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint, along
from pwmap.algebra.numbers import value_of
from pwmap.algebra.rootfunctions import (
    Column,
    Root,
    at_root_of,
    coefficients_in,
    critical,
    divides,
    irreducible_factors,
    leading_in,
    minimal_polynomial,
    resultant,
)
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    equally_spaced,
    gap_around,
    gaps_and_roots,
    inside,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
    value_at,
)
from pwmap.algebra.signs import possible_signs, without_implied
from pwmap.maps.decided import ColumnCell, NumberCell, Scope, SymbolicCell
from pwmap.maps.reading import Definition
from pwmap.maps.words import Decision, Orbits, SignOracle, in_integers

INFINITE = "infinite"


class ResampleError(ValueError):
    """The sample of the symbolic parameters is not generic: edges meet there."""


@total_ordering
@dataclass(frozen=True, slots=True, eq=False)
class ValueAt:
    """A quotient of polynomials at a place, where other parameters stay symbolic."""

    value: Any  # at the sample of the other parameters, in canonical form
    top: PolyElement  # not in lowest terms
    bottom: PolyElement
    factor: PolyElement  # zero at the place

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ValueAt) or self.value != other.value:
            return False
        rest = self.top * other.bottom - other.top * self.bottom
        return divides(self.factor, rest)

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: object) -> bool:
        """Whether it is smaller at the sample; this is not recorded."""
        return bool(self.value < other.value) if isinstance(other, ValueAt) else NotImplemented


def identical(first: Any, second: Any) -> bool:
    """Whether two equal places stay equal for other values of the symbolic parameters."""
    if not isinstance(first, Root):
        return True
    return bool(first.factor == second.factor and first.number == second.number)


def _sign_at_root(root: RealRoot, number: Number) -> int:
    return sign_at(dense(number), root)


class Axis:
    """One parameter of a map, along which signs are decided; others stay symbolic, with a sample.

    If there are no others, places and values are numbers, and nothing is recorded.
    """

    def __init__(self, definition: Definition, name: str, sample: dict[str, Number]) -> None:
        self.definition, self.name, self.sample = definition, name, sample
        self.orbits = Orbits(definition.table)
        symbols = definition.ring.symbols
        self.index = names_of(definition.ring).index(name)
        self._is_alone = not sample
        self._others = [symbol for symbol in symbols if str(symbol) != name]
        self._point = tuple(sample.get(str(symbol), QQ.zero) for symbol in symbols)
        self._roots: dict[Decision | PolyElement, tuple[Any, ...] | None] = {}
        self._factors: dict[PolyElement, tuple[Root, ...]] = {}
        self._conditions: dict[PolyElement, None] = {}
        self.upright: dict[Dense, None] = {}  # decisive polynomials in the other parameter alone

    def copy(self) -> Axis:
        """A copy of the axis; what either records later is not recorded in the other."""
        twin = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, dict):
                setattr(twin, name, dict(value))
        return twin

    @property
    def identity(self) -> Fraction_:
        """The parameter itself, as a quotient."""
        ring = self.definition.ring
        return ring.gens[self.index], ring.one

    def degree(self, number: Number) -> int:
        """Degree of a polynomial in the parameter of the axis; 0 for zero."""
        return degree_in(number, self.index)

    # --- Places ---------------------------------------------------------------------------------

    def place(self, value: Number) -> Any:
        """A rational value as a place on the axis."""
        return value if self._is_alone else Root(value, normalised(self.identity[0] - value), 0)

    def real(self, place: Any) -> Real:
        """The real number at which a place lies for the sample."""
        return place.value if isinstance(place, Root) else place

    def between(self, low: Any, high: Any) -> Any:
        """A place strictly between two others."""
        return self.place(simplest_between(self.real(low), self.real(high)))

    def equally_spaced(self, low: Any, high: Any, n: int) -> list[Any]:
        """Places inside an interval, in equal steps."""
        return [self.place(value) for value in equally_spaced(self.real(low), self.real(high), n)]

    def roots(self, decision: Decision) -> tuple[Any, ...] | None:
        """Places where the sign of a decision is zero; None if it is zero everywhere."""
        if decision not in self._roots:
            self._roots[decision] = self.zeros(self.orbits.polynomial(decision))
        return self._roots[decision]

    def limits(self, constraint: Constraint) -> tuple[Any, ...]:
        """Places where an assumption begins or ceases to hold; ValueError for too high a degree."""
        polynomial = constraint.polynomial
        if polynomial not in self._roots:
            factors = irreducible_factors(polynomial) if len(self.sample) > 1 else ()
            if any(self.degree(factor) > 1 for factor in factors):
                raise ValueError(
                    f"the assumption {constraint} is not of degree one in {self.name}: "
                    "give the other parameters values (.at)"
                )
            self._roots[polynomial] = self.zeros(polynomial)
        return self._roots[polynomial] or ()

    def zeros(self, polynomial: Number) -> tuple[Any, ...] | None:
        """Places where a polynomial in the parameters is zero; None if it is zero everywhere."""
        if not polynomial:
            return None
        if self._is_alone:
            return real_roots(dense(polynomial))
        found = [root for part in irreducible_factors(polynomial) for root in self._zeros(part)]
        if len(set(found)) < len(found):
            raise ResampleError
        return tuple(found)

    def _zeros(self, factor: PolyElement) -> tuple[Root, ...]:
        if factor not in self._factors:
            degree, single = self.degree(factor), len(self.sample) == 1
            if degree > 1 and not single:
                raise ValueError(
                    f"a decision has degree {degree} in {self.name}: "
                    f"{sympy.factor(to_sympy(factor))}; give the other parameters values (.at)"
                )
            if not degree and single:
                self.upright[self._across(factor)] = None
            for polynomial in critical(factor, self.index):
                self._keep_sign(polynomial)
            roots = real_roots(self.coefficients(factor)) if degree else ()
            self._factors[factor] = tuple(
                Root(value, factor, number) for number, value in enumerate(roots)
            )
        return self._factors[factor]

    # --- Decided at the sample ------------------------------------------------------------------

    def coefficients(self, polynomial: Number) -> Dense:
        """A polynomial in the parameter of the axis alone, others at their sample."""
        return dense(polynomial) if self._is_alone else along(polynomial, self._point, self.index)

    @cached_property
    def _orbits_here(self) -> Orbits:
        if self._is_alone:
            return self.orbits
        return Orbits(self.definition.table.mapped(lambda n: evaluate(n, self.sample)))

    def oracle(self, place: Any) -> SignOracle:
        """The signs of all decisions at a place."""
        value = self.real(place)
        if isinstance(value, RealRoot):
            return SignOracle(self._orbits_here, partial(_sign_at_root, value))
        table = self._orbits_here.table.mapped(lambda number: value_at(dense(number), value))
        return SignOracle(Orbits(in_integers(table)), sign)

    def sign(self, polynomial: Number, place: Any) -> int:
        """Sign of a polynomial in the parameters at a place."""
        return sign_at(self.coefficients(polynomial), self.real(place))

    def number(self, fraction: Fraction_, place: Any) -> float:
        """A finite quotient at a place as a float, infinite if it is too large; for drawing."""
        top, bottom = (self.coefficients(number) for number in fraction)
        value = self.real(place)
        if isinstance(value, RealRoot):
            return value.to_float(top, bottom)
        return to_float(value_at(top, value) / value_at(bottom, value))

    # --- Decided, and recorded ------------------------------------------------------------------

    def value(self, fraction: Fraction_, place: Any) -> Any:
        """A quotient at a place, in a canonical form, or INFINITE."""
        above, below = (value_of(self.coefficients(n), self.real(place)) for n in fraction)
        if self._is_alone:
            return above / below if below else INFINITE
        if divides(place.factor, fraction[1]):
            return INFINITE
        if not below:
            raise ResampleError
        return ValueAt(above / below, *fraction, place.factor)

    def compare(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        """Sign of the difference of two finite quotients at a place."""
        (a, b), (c, d) = first, second
        found = self.recorded_sign(a * d - c * b, place)
        return found and found * self.recorded_sign(b, place) * self.recorded_sign(d, place)

    def recorded_sign(self, polynomial: Number, place: Any) -> int:
        """Sign of a polynomial at a place; records what keeps it when other parameters vary."""
        if self._is_alone:
            return self.sign(polynomial, place)
        if divides(place.factor, polynomial):
            return 0
        found = self.sign(polynomial, place)
        if not found:
            raise ResampleError
        if self.degree(polynomial):
            polynomial = resultant(place.factor, polynomial, self.index)
        self._keep_sign(polynomial)
        return found

    def _keep_sign(self, polynomial: PolyElement) -> None:
        """Record that a polynomial in the other parameters must keep the sign of the sample."""
        if is_constant(polynomial):
            return
        if not self.coefficients(polynomial):
            raise ResampleError
        self._conditions[polynomial] = None

    # --- What persists --------------------------------------------------------------------------

    def closing(self, places: Sequence[Any], decided: Iterable[Decision]) -> None:
        """Record the conditions on other parameters under which all roots keep their order.

        Roots of ``decided`` are among them. Those outside the places stay outside.
        """
        if self._is_alone or not places:
            return
        for decision in decided:
            self.roots(decision)
        low, high = places[0], places[-1]
        # equal roots that are not identical are both kept, so that their meeting is noticed
        found = [root for roots in self._roots.values() for root in roots or ()]
        known = {(root, root.factor, root.number): root for root in found}.values()
        inside: dict[Any, Any] = {}
        for place in (*places, *known):
            if low <= place <= high and not identical(inside.setdefault(place, place), place):
                raise ResampleError
        pairs = list(pairwise(sorted(inside)))
        pairs += [(place, low) for place in known if place < low]
        pairs += [(high, place) for place in known if high < place]
        for left, right in pairs:
            if left.factor != right.factor:
                self._keep_sign(resultant(left.factor, right.factor, self.index))

    @cached_property
    def _own(self) -> tuple[Constraint, ...]:
        constraints = self.definition.region.constraints
        return tuple(c for c in constraints if not self.degree(c.polynomial))

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """Inequalities for the others: the interval of a single one, or all recorded signs."""
        if self._is_alone:
            return ()
        if len(self.sample) > 1:
            return tuple(constraint.relation() for constraint in self._kept())
        (symbol,), column = self._others, self.column
        lower = [symbol > real_to_sympy(column.low)] if column.low > LOWEST else []
        return (*lower, *([symbol < real_to_sympy(column.high)] if column.high < HIGHEST else []))

    @property
    def is_everywhere(self) -> bool:
        """Whether the results hold for all values of the others that the assumptions admit."""
        if len(self.sample) > 1:
            own = {(self._rest(c.polynomial), c.strict) for c in self._own}
            return all(each in own for each in self._kept())
        column = self.column
        conditions = [(self._across(c.polynomial), c) for c in self._own]
        ends = {end for end in (column.low, column.high) if not isinstance(end, Infinite)}
        limits = sorted(ends.union(*(real_roots(polynomial) for polynomial, _ in conditions)))
        return all(
            column.low < x < column.high
            for x in map(inside, gaps_and_roots(limits))
            if all(c.holds(sign_at(polynomial, x)) for polynomial, c in conditions)
        )

    @cached_property
    def _assumed(self) -> tuple[Constraint, ...]:
        if len(self.sample) == 1:
            return (*self._own, *self._ends())
        ring = self.definition.ring
        return tuple(Constraint(to_ring(c.polynomial, ring), c.strict) for c in self._kept())

    def _kept(self) -> list[Constraint]:
        """The recorded signs as constraints, without those that follow from others."""
        own = [Constraint(self._rest(c.polynomial), c.strict) for c in self._own]
        kept = [*own]
        point = [self.sample[str(symbol)] for symbol in self._others]
        for polynomial in sorted(self._conditions, key=len):
            for factor, _ in self._rest(polynomial).factor_list()[1]:
                side = sign(evaluate(factor, self.sample))
                if possible_signs(factor, tuple(kept), lambda: [point]) != frozenset((side,)):
                    kept.append(Constraint(side * factor, True))
        return without_implied(kept, len(own))

    def _rest(self, polynomial: PolyElement) -> PolyElement:
        return evaluate(polynomial, {self.name: QQ.zero})

    # --- Beside one other parameter -------------------------------------------------------------

    def _across(self, polynomial: PolyElement) -> Dense:
        return dense(polynomial, 1 - self.index)

    @property
    def column(self) -> Column:
        """The only other parameter at its sample, and the interval in which results persist."""
        (value,) = self.sample.values()
        limits = [*(constraint.polynomial for constraint in self._own), *self._conditions]
        low, high = gap_around(value, map(self._across, limits))
        return Column(tuple(self.definition.ring.symbols), self.index, low, high, value)

    def _ends(self) -> Iterator[Constraint]:
        """The interval as inequalities; an algebraic end has a rational bound, too."""
        ring, other, column = self.definition.ring, 1 - self.index, self.column
        for side, end, outer in ((1, column.low, 0), (-1, column.high, 1)):
            if not isinstance(end, Infinite):
                yield Constraint(side * (ring.gens[other] - bounds(end)[outer]), True)
            if isinstance(end, RealRoot):
                polynomial = minimal_polynomial(ring, other, end)
                side = sign_at(column.across(polynomial), column.sample)
                yield Constraint(side * polynomial, True)

    # --- What a user sees -----------------------------------------------------------------------

    def to_sympy(self, place: Any) -> sympy.Expr:
        """A place as an expression."""
        if not isinstance(place, Root):
            return real_to_sympy(place)
        if self.degree(place.factor) > 1:
            return place.to_sympy(self.column)
        return reduced_to_sympy(*self._quotient(place), self.name)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        """What :meth:`value` returned for a place, as an expression."""
        if self._is_alone:
            return real_to_sympy(value)
        if self.degree(place.factor) > 1:
            symbol = self.definition.ring.symbols[self.index]
            return fraction_to_sympy((value.top, value.bottom)).subs(symbol, self.to_sympy(place))
        slope = leading_in(place.factor, self.index)
        (top, n), (bottom, m) = (
            (at_root_of(number, place.factor, self.index), self.degree(number))
            for number in (value.top, value.bottom)
        )
        both = top * slope ** max(0, m - n), bottom * slope ** max(0, n - m)
        return reduced_to_sympy(*both, self.name)

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        """The scope of a cell with these ends, after :meth:`closing`."""
        if self._is_alone:
            return NumberCell(self.definition.ring.symbols[0], low, high, orders)
        ends = [end for end in (low, high) if isinstance(end, Root)]
        if any(self.degree(end.factor) > 1 for end in ends):
            return ColumnCell(self.column, low, high, orders)
        ring, symbol = self.definition.ring, self.definition.ring.symbols[self.index]
        shown, limits = (self.to_sympy(low), self.to_sympy(high)), [*self._assumed]
        if low is high:
            region = AssumedRegion(ring, self._assumed)
            return SymbolicCell(symbol, region, *shown, orders, self._quotient(low))
        for side, end in ((1, low), (-1, high)):
            if not isinstance(end, Infinite):
                top, bottom = self._quotient(end)
                sense = side * sign(constant(evaluate(bottom, self.sample)))
                limits.append(Constraint(sense * (self.identity[0] * bottom - top), True))
        return SymbolicCell(symbol, AssumedRegion(ring, tuple(limits)), *shown, orders)

    def _quotient(self, place: Root) -> Fraction_:
        """Numerator and denominator of a place of degree one, in the ring of all parameters."""
        rest, slope = coefficients_in(place.factor, self.index)
        return -rest, slope
