"""One of two parameters as an axis, at a sample of the other, which stays symbolic.

Places are real roots of polynomials in both parameters, and so functions of the other one. They are
compared at the sample, where they are numbers; each comparison records the polynomial in the other
parameter that is zero wherever it could change: a leading coefficient, discriminant or resultant.
Between the nearest roots of these everything persists.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.bivariate import (
    at_root_of,
    coefficients_in,
    discriminant,
    divides,
    irreducible_factors,
    leading_in,
    normalised,
    resultant,
)
from pwmap.algebra.exact import (
    HIGHEST,
    LOWEST,
    Fraction_,
    Infinite,
    Number,
    degree_in,
    fraction_to_sympy,
    is_constant,
    to_float,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.rootfunctions import Column, Root, minimal_polynomial
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    may_vanish,
    real_roots,
    real_to_sympy,
    sign_at,
)
from pwmap.maps.columns import ColumnCell
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import Scope
from pwmap.parameters.axis import INFINITE, RecordedAxis, ResampleError, ValueAt, quotient_at


class ColumnAxis(RecordedAxis):
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
        super().__init__(definition, name, sample)
        (value,) = sample.values()
        self._column = Column(tuple(definition.ring.symbols), self.index, LOWEST, HIGHEST, value)
        self._factors: dict[PolyElement, tuple[Root, ...]] = {}
        self._conditions: dict[Dense, None] = {}
        self.upright: dict[Dense, None] = {}  # polynomials in the other parameter that decide

    # --- Places ---------------------------------------------------------------------------------

    def place(self, value: Number) -> Root:
        return Root(value, normalised(self.identity[0] - value), 0)

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
            degree = degree_in(factor, self.index)
            if not degree:
                self.upright[self._column.across(factor)] = None
            self._keep_sign(leading_in(factor, self.index))
            if degree > 1:
                self._keep_sign(discriminant(factor, self.index))
            roots = real_roots(self._column.at_sample(factor)) if degree else ()
            self._factors[factor] = tuple(
                Root(value, factor, number) for number, value in enumerate(roots)
            )
        return self._factors[factor]

    # --- Signs and values -----------------------------------------------------------------------

    def _kept_sign(self, polynomial: PolyElement, place: Root) -> int:
        """The sign at a place, with what it depends on recorded."""
        if divides(place.factor, polynomial):
            return 0
        found = self.sign(polynomial, place)
        if not found:
            raise ResampleError
        if degree_in(polynomial, self.index):
            polynomial = resultant(place.factor, polynomial, self.index)
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
        return ValueAt(quotient_at(above, below, place.value), top, bottom, place.factor)

    def compare(self, first: Fraction_, second: Fraction_, place: Root) -> int:
        (a, b), (c, d) = first, second
        found = self._kept_sign(a * d - c * b, place)
        return found and found * self._kept_sign(b, place) * self._kept_sign(d, place)

    def coefficients(self, polynomial: Number) -> Dense:
        return self._column.at_sample(polynomial)

    # --- What persists --------------------------------------------------------------------------

    def _keep_order(self, left: Root, right: Root) -> None:
        if left.factor != right.factor:
            self._keep_sign(resultant(left.factor, right.factor, self.index))

    @cached_property
    def _own(self) -> tuple[Constraint, ...]:
        """What the map itself assumes of the other parameter."""
        constraints = self.definition.region.constraints
        return tuple(c for c in constraints if not self.degree(c.polynomial))

    def bounds(self) -> tuple[Real, Real]:
        """The interval of the other parameter in which all that was recorded persists."""
        value = self._column.sample
        below: Real = LOWEST
        above: Real = HIGHEST
        limits = [self._column.across(constraint.polynomial) for constraint in self._own]
        for dense in sorted((*limits, *self._conditions), key=len):
            if below > LOWEST and above < HIGHEST:
                ends = to_float(bounds(below)[0]), to_float(bounds(above)[1])
                if not may_vanish(dense, *ends):
                    continue
            for root in real_roots(dense):
                if below < root < value:
                    below = root
                if value < root < above:
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
        symbol, (below, above) = self._column.symbols[1 - self.index], self.bounds()
        lower = [symbol > real_to_sympy(below)] if below > LOWEST else []
        return (*lower, *([symbol < real_to_sympy(above)] if above < HIGHEST else []))

    # --- What a user sees -----------------------------------------------------------------------

    def to_sympy(self, place: Root) -> sympy.Expr:
        return place.to_sympy(self._column)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        if degree_in(place.factor, self.index) > 1:
            symbol = self._column.symbols[self.index]
            return fraction_to_sympy((value.top, value.bottom)).subs(symbol, self.to_sympy(place))
        slope = leading_in(place.factor, self.index)
        (top, n), (bottom, m) = (
            (at_root_of(number, place.factor, self.index), degree_in(number, self.index))
            for number in (value.top, value.bottom)
        )
        return self._column.shown(top * slope ** max(0, m - n), bottom * slope ** max(0, n - m))

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        ends = [end for end in (low, high) if isinstance(end, Root)]
        if any(degree_in(end.factor, self.index) > 1 for end in ends):
            return ColumnCell(self.column, low, high, orders)
        return super().scope(low, high, orders)

    def _quotient(self, place: Root) -> Fraction_:
        rest, slope = coefficients_in(place.factor, self.index)
        return -rest, slope

    @cached_property
    def _assumed(self) -> tuple[Constraint, ...]:
        """What holds of the other parameter in the strip, when all was decided."""
        return (*self._own, *self._ends())

    def _ends(self) -> Iterator[Constraint]:
        """The strip as inequalities: an algebraic end with a rational one beyond."""
        ring, other = self.definition.ring, 1 - self.index
        for side, end, outer in zip((1, -1), self.bounds(), (0, 1), strict=True):
            if not isinstance(end, Infinite):
                yield Constraint(side * (ring.gens[other] - bounds(end)[outer]), True)
            if isinstance(end, RealRoot):
                polynomial = minimal_polynomial(ring, other, end)
                sense = sign_at(self._column.across(polynomial), self._column.sample)
                yield Constraint(sense * polynomial, True)
