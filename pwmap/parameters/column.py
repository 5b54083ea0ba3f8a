"""One of two parameters as an axis, at a sample of the other, which stays symbolic.

Places are real roots of polynomials in both parameters, and so functions of the other one. They are
compared at the sample, where they are numbers; each comparison records the polynomial in the other
parameter that is zero wherever it could change: a leading coefficient, discriminant or resultant.
Between the nearest roots of these everything persists.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.assumptions import Region
from pwmap.algebra.bivariate import (
    at_root_of,
    coefficients_in,
    degree_in,
    discriminant,
    divides,
    irreducible_factors,
    leading_in,
    normalised,
    resultant,
)
from pwmap.algebra.exact import (
    Fraction_,
    Number,
    evaluate,
    fraction_to_sympy,
    is_constant,
    polynomial_ring,
    sign,
    to_float,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.rootfunctions import Column, Root, minimal_polynomial
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    difference,
    may_vanish,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
    spread,
)
from pwmap.maps.columns import ColumnEdge, ColumnInterval
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import Scope, SymbolicEdge, SymbolicInterval
from pwmap.maps.words import Decision, IntegerOrbits, Orbits, SignOracle
from pwmap.parameters.axis import INFINITE, Axis, ResampleError, SignAt


@dataclass(frozen=True, slots=True, eq=False)
class ColumnValue:
    """A quotient of polynomials in both parameters at a root.

    Attributes
    ----------
    value
        At the sample of the other parameter, in canonical form.
    top, bottom
        The polynomials.
    factor
        Of the root.
    """

    value: Any
    top: PolyElement
    bottom: PolyElement
    factor: PolyElement

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ColumnValue)
            and self.value == other.value
            and divides(self.factor, self.top * other.bottom - other.top * self.bottom)
        )

    def __hash__(self) -> int:
        return hash(self.value)


class ColumnAxis(Axis):
    """One of the two parameters of a map; the other one stays symbolic.

    Parameters
    ----------
    definition
        The map.
    name
        The parameter of the axis.
    sample
        A value of the other parameter.
    """

    def __init__(self, definition: Definition, name: str, sample: dict[str, Number]) -> None:
        super().__init__(definition)
        self.name, self.sample = name, sample
        ring = definition.ring
        self._along = [str(s) for s in ring.symbols].index(name)
        (value,) = sample.values()
        self._column = Column(tuple(ring.symbols), self._along, None, None, value)
        column = polynomial_ring([ring.symbols[self._along]])
        table = definition.table.mapped(lambda number: evaluate(number, sample, column))
        self._orbits_here = Orbits(table)
        self._factors: dict[PolyElement, tuple[Root, ...]] = {}
        self._conditions: dict[Dense, None] = {}
        self.upright: dict[Dense, None] = {}  # polynomials in the other parameter that decide

    # --- Places ---------------------------------------------------------------------------------

    def place(self, value: Number) -> Root:
        generator = self.identity[0]
        return Root(value, normalised(generator - value), 0)

    def between(self, low: Any, high: Any) -> Root:
        ends = (end.value if end is not None else None for end in (low, high))
        return self.place(simplest_between(*ends))

    def spread(self, low: Any, high: Any, n: int) -> list[Root]:
        return [self.place(value) for value in spread(low.value, high.value, n)]

    def zeros(self, polynomial: Number) -> tuple[Root, ...] | None:
        if not polynomial:
            return None
        found = [root for part in irreducible_factors(polynomial) for root in self._zeros(part)]
        if len(set(found)) < len(found):
            raise ResampleError
        return tuple(found)

    def _zeros(self, factor: PolyElement) -> tuple[Root, ...]:
        """The roots of an irreducible polynomial."""
        if factor not in self._factors:
            degree = degree_in(factor, self._along)
            if not degree:
                self.upright[self._column.across(factor)] = None
            self._keep_sign(leading_in(factor, self._along))
            if degree > 1:
                self._keep_sign(discriminant(factor, self._along))
            roots = real_roots(self._column.at_sample(factor)) if degree else ()
            self._factors[factor] = tuple(
                Root(value, factor, number) for number, value in enumerate(roots)
            )
        return self._factors[factor]

    # --- Signs and values -----------------------------------------------------------------------

    def oracle(self, place: Root) -> SignOracle:
        if isinstance(place.value, RealRoot):
            return SignOracle(self._orbits_here, SignAt(place.value))
        values = {**self.sample, self.name: place.value}
        table = self.definition.table.mapped(lambda number: evaluate(number, values, None))
        return SignOracle(IntegerOrbits(table), sign)

    def sign(self, polynomial: Number, place: Root) -> int:
        return sign_at(self._column.at_sample(polynomial), place.value)

    def _kept_sign(self, polynomial: PolyElement, place: Root) -> int:
        """The sign at a place, with what it depends on recorded."""
        if divides(place.factor, polynomial):
            return 0
        found = self.sign(polynomial, place)
        if not found:
            raise ResampleError
        if degree_in(polynomial, self._along):
            polynomial = resultant(place.factor, polynomial, self._along)
        self._keep_sign(polynomial)
        return found

    def _keep_sign(self, polynomial: PolyElement) -> None:
        """Record that a polynomial in the other parameter must have no zero near the sample."""
        if is_constant(polynomial):
            return
        dense = self._column.across(polynomial)
        if not sign_at(dense, self._column.sample):
            raise ResampleError
        self._conditions[dense] = None

    def value(self, fraction: Fraction_, place: Root) -> Any:
        top, bottom = fraction
        if divides(place.factor, bottom):
            return INFINITE
        above, below = (self._column.at_sample(number) for number in fraction)
        if not sign_at(below, place.value):
            raise ResampleError
        if isinstance(place.value, RealRoot):
            return ColumnValue(place.value.quotient(above, below), top, bottom, place.factor)
        value = _at(above, place.value) / _at(below, place.value)
        return ColumnValue(value, top, bottom, place.factor)

    def compare(self, first: Fraction_, second: Fraction_, place: Root) -> int:
        (a, b), (c, d) = first, second
        found = self._kept_sign(a * d - c * b, place)
        return found and found * self._kept_sign(b, place) * self._kept_sign(d, place)

    def compare_values(self, first: Any, second: Any, place: Root) -> int:
        if isinstance(place.value, RealRoot):
            return sign_at(difference(first.value, second.value), place.value)
        return sign(first.value - second.value)

    def coefficients(self, polynomial: Number) -> Dense:
        return self._column.at_sample(polynomial)

    def number(self, fraction: Fraction_, place: Root) -> float:
        top, bottom = (self._column.at_sample(number) for number in fraction)
        if isinstance(place.value, RealRoot):
            return place.value.to_float(top, bottom)
        return to_float(_at(top, place.value) / _at(bottom, place.value))

    # --- What persists --------------------------------------------------------------------------

    def closing(self, places: Sequence[Root], decided: Iterable[Decision]) -> None:
        """Record that all roots keep their order inside the places, and stay outside them."""
        if not places:
            return
        for decision in decided:
            self.roots(decision)
        low, high = places[0], places[-1]
        known = self._known()
        inside: dict[Root, Root] = {}
        for root in (*places, *known):
            if low <= root <= high and not is_same(inside.setdefault(root, root), root):
                raise ResampleError
        pairs = list(pairwise(sorted(inside)))
        pairs += [(root, low) for root in known if root < low]
        pairs += [(high, root) for root in known if high < root]
        for left, right in pairs:
            if left.factor != right.factor:
                self._keep_sign(resultant(left.factor, right.factor, self._along))

    def _known(self) -> list[Root]:
        """All roots that were found, each once; equal ones only if they are not the same."""
        found: dict[Root, list[Root]] = defaultdict(list)
        for roots in self._roots.values():
            for root in roots or ():
                alike = found[root]
                if not any(is_same(root, other) for other in alike):
                    alike.append(root)
        return [root for alike in found.values() for root in alike]

    @cached_property
    def _own(self) -> tuple[Constraint, ...]:
        """What the map itself assumes of the other parameter."""
        constraints = self.definition.region.constraints
        return tuple(c for c in constraints if not self.degree(c.polynomial))

    def bounds(self) -> tuple[Real | None, Real | None]:
        """The interval of the other parameter in which all that was recorded persists."""
        value = self._column.sample
        below: Real | None = None
        above: Real | None = None
        limits = [self._column.across(constraint.polynomial) for constraint in self._own]
        for dense in sorted((*limits, *self._conditions), key=len):
            if below is not None and above is not None:
                ends = to_float(bounds(below)[0]), to_float(bounds(above)[1])
                if not may_vanish(dense, *ends):
                    continue
            for root in real_roots(dense):
                if root < value and (below is None or below < root):
                    below = root
                if value < root and (above is None or root < above):
                    above = root
        return below, above

    @property
    def column(self) -> Column:
        """The sample, with that interval."""
        low, high = self.bounds()
        return replace(self._column, low=low, high=high)

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """The interval of the other parameter as inequalities."""
        symbol, (below, above) = self._column.symbols[1 - self._along], self.bounds()
        lower = [] if below is None else [symbol > real_to_sympy(below)]
        return (*lower, *([] if above is None else [symbol < real_to_sympy(above)]))

    # --- What a user sees -----------------------------------------------------------------------

    def to_sympy(self, place: Root) -> sympy.Expr:
        return place.to_sympy(self._column)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        if degree_in(place.factor, self._along) > 1:
            symbol = self._column.symbols[self._along]
            return fraction_to_sympy((value.top, value.bottom)).subs(symbol, self.to_sympy(place))
        slope = leading_in(place.factor, self._along)
        (top, n), (bottom, m) = (
            (at_root_of(number, place.factor, self._along), degree_in(number, self._along))
            for number in (value.top, value.bottom)
        )
        return self._column.shown(top * slope ** max(0, m - n), bottom * slope ** max(0, n - m))

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        ends = [end for end in (low, high) if end is not None]
        is_edge = low is not None and low is high
        if any(degree_in(end.factor, self._along) > 1 for end in ends):
            return (
                ColumnEdge(self.column, low, orders)
                if is_edge
                else ColumnInterval(self.column, low, high, orders)
            )
        ring, symbol = self.definition.ring, self._column.symbols[self._along]
        if is_edge:
            return SymbolicEdge(symbol, self._quotient(low), Region(ring, self._assumed), orders)
        limits = [*self._assumed]
        for side, end in ((1, low), (-1, high)):
            if end is not None:
                sense = side * sign_at(
                    self._column.across(leading_in(end.factor, self._along)), self._column.sample
                )
                limits.append(Constraint(sense * end.factor, True))
        left, right = (None if end is None else self.to_sympy(end) for end in (low, high))
        return SymbolicInterval(symbol, Region(ring, tuple(limits)), left, right, orders)

    def _quotient(self, place: Root) -> Fraction_:
        """Numerator and denominator of a place that is a quotient."""
        rest, slope = coefficients_in(place.factor, self._along)
        return -rest, slope

    @cached_property
    def _assumed(self) -> tuple[Constraint, ...]:
        """What holds of the other parameter in the strip, when all was decided."""
        return (*self._own, *self._ends())

    def _ends(self) -> Iterator[Constraint]:
        """The strip as inequalities: an algebraic end with a rational one beyond."""
        ring, other = self.definition.ring, 1 - self._along
        for side, end, outer in zip((1, -1), self.bounds(), (0, 1), strict=True):
            if end is not None:
                yield Constraint(side * (ring.gens[other] - bounds(end)[outer]), True)
            if isinstance(end, RealRoot):
                polynomial = minimal_polynomial(ring, other, end)
                sense = sign_at(self._column.across(polynomial), self._column.sample)
                yield Constraint(sense * polynomial, True)


def is_same(first: Root, second: Root) -> bool:
    """Whether two roots are one and the same function."""
    return first.factor == second.factor and first.number == second.number


def _at(polynomial: Dense, value: Number) -> Number:
    """The value of a polynomial at a rational number."""
    total = QQ.zero
    for coefficient in polynomial:
        total = total * value + coefficient
    return total
