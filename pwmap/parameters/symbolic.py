"""One parameter as an axis where several others stay symbolic.

A place is a quotient of polynomials in these, with its value at a sample of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, total_ordering
from itertools import pairwise
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.assumptions import Region
from pwmap.algebra.exact import (
    Fraction_,
    Number,
    evaluate,
    factored_to_sympy,
    is_constant,
    polynomial_ring,
    sign,
    to_float,
    to_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.roots import Dense, simplest_between, trimmed
from pwmap.algebra.signs import possible_signs, without_implied
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import Scope, SymbolicEdge, SymbolicInterval
from pwmap.maps.words import Decision, IntegerOrbits, SignOracle
from pwmap.parameters.axis import INFINITE, Axis, DegreeError, ResampleError


@total_ordering
@dataclass(frozen=True, eq=False)
class Threshold:
    """A value of the parameter that depends on other, symbolic parameters.

    Attributes
    ----------
    value
        Its value at the sample of the other parameters.
    top, bottom
        Polynomials in the others of which it is the quotient, not in lowest terms.
    """

    value: Number
    top: PolyElement
    bottom: PolyElement

    @cached_property
    def expr(self) -> Any:
        """The quotient in lowest terms."""
        return _quotient(self.top, self.bottom)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Threshold) and self.value == other.value

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: Threshold) -> bool:
        return bool(self.value < other.value)


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicValue:
    """A quotient of polynomials in other, symbolic parameters, not in lowest terms.

    Attributes
    ----------
    value
        Its value at the sample of the other parameters.
    """

    value: Number
    top: PolyElement
    bottom: PolyElement

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, SymbolicValue)
            and self.value == other.value
            and self.top * other.bottom == other.top * self.bottom
        )

    def __hash__(self) -> int:
        return hash(self.value)


def _quotient(top: PolyElement, bottom: PolyElement) -> Any:
    """A quotient in lowest terms, as an element of the field."""
    return top.ring.to_field().new(top, bottom)


class SymbolicAxis(Axis):
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
        super().__init__(definition)
        self.name, self.sample = name, sample
        names = [str(s) for s in definition.ring.symbols]
        self._index = names.index(name)
        self._others = polynomial_ring([s for s in definition.ring.symbols if str(s) != name])
        self._conditions: dict[PolyElement, None] = {}
        self._assumed: list[Constraint] | None = None  # of the others, when all was decided

    def place(self, value: Number) -> Threshold:
        return Threshold(value, self._others.ground_new(value), self._others.one)

    def between(self, low: Any, high: Any) -> Threshold:
        ends = (end.value if end is not None else None for end in (low, high))
        return self.place(simplest_between(*ends))

    def oracle(self, place: Threshold) -> SignOracle:
        values = {**self.sample, self.name: place.value}
        table = self.definition.table.mapped(lambda n: evaluate(n, values, None))
        return SignOracle(IntegerOrbits(table), sign)

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

    def sign(self, polynomial: Number, place: Threshold) -> int:
        return sign(evaluate(polynomial, {**self.sample, self.name: place.value}, None))

    def _coefficients(self, polynomial: PolyElement) -> tuple[PolyElement, PolyElement]:
        """Slope and rest of a polynomial of degree at most one in the axis' parameter."""
        rest, slope = (*self._powers(polynomial), self._others.zero)[:2]
        return slope, rest

    def _powers(self, polynomial: PolyElement) -> list[PolyElement]:
        """Coefficients of the powers of the axis' parameter, from the zeroth on."""
        powers = [self._others.zero] * (self.degree(polynomial) + 1)
        for exponents, coefficient in polynomial.terms():
            others = exponents[: self._index] + exponents[self._index + 1 :]
            powers[exponents[self._index]] += self._others.from_dict({others: coefficient})
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
        return SymbolicValue(self._at_sample(top, bottom), top, bottom)

    def compare(self, first: Fraction_, second: Fraction_, place: Threshold) -> int:
        one, other = self.value(first, place), self.value(second, place)
        difference = one.top * other.bottom - other.top * one.bottom
        if not difference:
            return 0
        self._keep_sign_of(_quotient(difference, one.bottom * other.bottom))
        return sign(one.value - other.value)

    def compare_values(self, first: Any, second: Any, place: Threshold) -> int:
        return sign(first.value - second.value)

    def to_sympy(self, place: Threshold) -> sympy.Expr:
        return factored_to_sympy((place.expr.numer, place.expr.denom))

    def number(self, fraction: Fraction_, place: Threshold) -> float:
        values = {**self.sample, self.name: place.value}
        top, bottom = (evaluate(number, values, None) for number in fraction)
        return to_float(top / bottom)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        quotient = _quotient(value.top, value.bottom)
        return factored_to_sympy((quotient.numer, quotient.denom))

    def coefficients(self, polynomial: Number) -> Dense:
        return trimmed(evaluate(c, self.sample, None) for c in reversed(self._powers(polynomial)))

    def spread(self, low: Any, high: Any, n: int) -> list[Threshold]:
        step = (high.value - low.value) / (n + 1)
        return [self.place(low.value + step * i) for i in range(1, n + 1)]

    def closing(self, places: Sequence[Threshold], decided: Iterable[Decision]) -> None:
        """Record that all thresholds keep their order inside the places, and stay outside them."""
        if not places:
            return
        for decision in decided:
            self.roots(decision)
        low, high = places[0], places[-1]
        thresholds = self._thresholds()
        inside: dict[Threshold, Threshold] = {}
        for threshold in (*places, *thresholds):
            if low <= threshold <= high and not is_same(
                inside.setdefault(threshold, threshold), threshold
            ):
                raise ResampleError
        pairs = list(pairwise(sorted(inside)))
        pairs += [(p, low) for p in thresholds if p < low]
        pairs += [(high, p) for p in thresholds if high < p]
        for left, right in pairs:
            self._keep_sign_of(right.expr - left.expr)

    def _thresholds(self) -> list[Threshold]:
        """All that were found, each once."""
        found: list[Threshold] = []
        known: dict[Number, list[Threshold]] = defaultdict(list)
        for roots in self._roots.values():
            for threshold in roots or ():
                alike = known[threshold.value]
                if not any(is_same(threshold, other) for other in alike):
                    alike.append(threshold)
                    found.append(threshold)
        return found

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

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        ring, symbol = self.definition.ring, self.definition.ring.symbols[self._index]
        if self._assumed is None:
            kept = self._kept()
            self._assumed = [Constraint(to_ring(c.polynomial, ring), c.strict) for c in kept]
        if low is not None and low is high:
            return SymbolicEdge(
                symbol, self._quotient(low), Region(ring, (*self._assumed,)), orders
            )
        limits = [*self._assumed]
        for side, end in ((1, low), (-1, high)):
            if end is not None:
                top, bottom = self._quotient(end)
                sense = side * sign(evaluate(bottom, self.sample, None))
                limits.append(Constraint(sense * (self.identity[0] * bottom - top), True))
        left, right = (None if end is None else self.to_sympy(end) for end in (low, high))
        return SymbolicInterval(symbol, Region(ring, tuple(limits)), left, right, orders)

    def _quotient(self, place: Threshold) -> Fraction_:
        """Numerator and denominator of a place in the ring of all parameters."""
        ring = self.definition.ring
        return to_ring(place.expr.numer, ring), to_ring(place.expr.denom, ring)

    def _own(self) -> list[Constraint]:
        """What the map itself assumes of the other parameters."""
        return [
            Constraint(evaluate(c.polynomial, {self.name: QQ.zero}, self._others), c.strict)
            for c in self.definition.region.constraints
            if not self.degree(c.polynomial)
        ]


def is_same(first: Threshold, second: Threshold) -> bool:
    """Whether two thresholds are one and the same function."""
    return bool(first.top * second.bottom == second.top * first.bottom)
