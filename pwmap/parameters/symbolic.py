"""One parameter as an axis where several others stay symbolic.

A place is a quotient of polynomials in these, with its value at a sample of them.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    Fraction_,
    Infinite,
    Number,
    evaluate,
    factored_to_sympy,
    is_constant,
    polynomial_ring,
    sign,
    to_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.roots import Dense, trimmed
from pwmap.algebra.signs import possible_signs, without_implied
from pwmap.maps.reading import Definition
from pwmap.parameters.axis import (
    INFINITE,
    DegreeError,
    RecordedAxis,
    ResampleError,
    Threshold,
    ValueAt,
)


def _quotient(top: PolyElement, bottom: PolyElement) -> Any:
    """A quotient in lowest terms, as an element of the field."""
    return top.ring.to_field().new(top, bottom)


class SymbolicAxis(RecordedAxis):
    """One parameter of a map that has several others, which stay symbolic.

    Parameters
    ----------
    definition
        The map.
    name
        The parameter of the axis.
    sample
        Values of the other parameters at which the picture is drawn.
    """

    def __init__(self, definition: Definition, name: str, sample: dict[str, Number]) -> None:
        super().__init__(definition, name, sample)
        self._others = polynomial_ring([s for s in definition.ring.symbols if str(s) != name])
        self._conditions: dict[PolyElement, None] = {}

    def place(self, value: Number) -> Threshold:
        return Threshold(value, self._others.ground_new(value), self._others.one)

    def zeros(self, polynomial: Number) -> tuple[Any, ...] | None:
        if not polynomial:
            return None
        if self.degree(polynomial) <= 1:
            return self._linear_zeros(polynomial)
        factors = [factor for factor, _ in polynomial.factor_list()[1]]
        worst = max(factors, key=self.degree)
        if self.degree(worst) > 1:
            raise DegreeError(
                f"a decision has degree {self.degree(worst)} in {self.name}: "
                f"{sympy.factor(to_sympy(worst))}; give the other parameters values (.at)"
            )
        return tuple({zero for factor in factors for zero in self._linear_zeros(factor)})

    def _linear_zeros(self, polynomial: PolyElement) -> tuple[Threshold, ...]:
        slope, rest = self._coefficients(polynomial)
        if not slope:
            self._keep_sign(rest)
            return ()
        self._keep_sign(slope)
        return (Threshold(self._at_sample(-rest, slope), -rest, slope),)

    def _coefficients(self, polynomial: PolyElement) -> tuple[PolyElement, PolyElement]:
        """Slope and rest of a polynomial of degree at most one in the axis' parameter."""
        rest, slope = (*self._powers(polynomial), self._others.zero)[:2]
        return slope, rest

    def _powers(self, polynomial: PolyElement) -> list[PolyElement]:
        """Coefficients of the powers of the axis' parameter, from the zeroth on."""
        powers = [self._others.zero] * (self.degree(polynomial) + 1)
        for exponents, coefficient in polynomial.terms():
            others = exponents[: self.index] + exponents[self.index + 1 :]
            powers[exponents[self.index]] += self._others.from_dict({others: coefficient})
        return powers

    def _keep_sign(self, polynomial: PolyElement) -> None:
        """Record that a polynomial in the other parameters must keep the sign of the sample."""
        if is_constant(polynomial):
            return
        if not evaluate(polynomial, self.sample, None):
            raise ResampleError
        self._conditions[polynomial.primitive()[1]] = None

    def _at_sample(self, top: PolyElement, bottom: PolyElement) -> Number:
        """A quotient of polynomials in the other parameters at their sample."""
        divisor = evaluate(bottom, self.sample, None)
        if not divisor:
            raise ResampleError
        return evaluate(top, self.sample, None) / divisor

    def _substituted(self, polynomial: PolyElement, place: Threshold) -> tuple[PolyElement, int]:
        """A polynomial of degree n at a place p/q, times q^n, and n."""
        top, bottom = place.expr.numer, place.expr.denom
        powers = self._powers(polynomial)
        value, scale = self._others.zero, self._others.one
        for power in reversed(powers):  # Horner's rule
            value = value * top + power * scale
            scale = scale * bottom
        return value, len(powers) - 1

    def value(self, fraction: Fraction_, place: Threshold) -> Any:
        (top, n), (bottom, m) = (self._substituted(number, place) for number in fraction)
        if not bottom:
            return INFINITE
        scale = place.expr.denom
        top, bottom = top * scale ** max(0, m - n), bottom * scale ** max(0, n - m)
        return ValueAt(self._at_sample(top, bottom), top, bottom)

    def compare(self, first: Fraction_, second: Fraction_, place: Threshold) -> int:
        one, other = self.value(first, place), self.value(second, place)
        difference = one.top * other.bottom - other.top * one.bottom
        if not difference:
            return 0
        self._keep_sign_of(_quotient(difference, one.bottom * other.bottom))
        return sign(one.value - other.value)

    def to_sympy(self, place: Threshold) -> sympy.Expr:
        if isinstance(place, Infinite):
            return place.to_sympy()
        return factored_to_sympy((place.expr.numer, place.expr.denom))

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        quotient = _quotient(value.top, value.bottom)
        return factored_to_sympy((quotient.numer, quotient.denom))

    def coefficients(self, polynomial: Number) -> Dense:
        return trimmed(evaluate(c, self.sample, None) for c in reversed(self._powers(polynomial)))

    def _keep_order(self, left: Threshold, right: Threshold) -> None:
        self._keep_sign_of(right.expr - left.expr)

    def _keep_sign_of(self, quotient: Any) -> None:
        """Record that a quotient of polynomials in the others must keep its sign."""
        self._keep_sign(quotient.numer)
        self._keep_sign(quotient.denom)

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """All recorded signs as inequalities."""
        return tuple(constraint.relation() for constraint in self._kept())

    def _kept(self) -> list[Constraint]:
        """All recorded signs, but for those that follow from others."""
        kept = self._own()
        point = [self.sample[str(symbol)] for symbol in self._others.symbols]
        for polynomial in sorted(self._conditions, key=len):
            for factor, _ in polynomial.factor_list()[1]:
                side = sign(evaluate(factor, self.sample, None))
                if possible_signs(factor, tuple(kept), lambda: [point]) != frozenset((side,)):
                    kept.append(Constraint(side * factor, True))
        return without_implied(kept, len(self._own()))

    @cached_property
    def _assumed(self) -> tuple[Constraint, ...]:
        ring = self.definition.ring
        return tuple(Constraint(to_ring(c.polynomial, ring), c.strict) for c in self._kept())

    def _quotient(self, place: Threshold) -> Fraction_:
        ring = self.definition.ring
        return to_ring(place.expr.numer, ring), to_ring(place.expr.denom, ring)

    def _own(self) -> list[Constraint]:
        """What the map itself assumes of the other parameters."""
        return [
            Constraint(evaluate(c.polynomial, {self.name: QQ.zero}, self._others), c.strict)
            for c in self.definition.region.constraints
            if not self.degree(c.polynomial)
        ]
