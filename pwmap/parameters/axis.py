"""One parameter of a map as an axis with exact places on it.

A place is a number or, beside symbolic parameters, a function of these. Signs are then decided at a
sample of these, and the axis records which polynomials in them must keep their signs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.bivariate import divides
from pwmap.algebra.exact import (
    Fraction_,
    Number,
    degree_in,
    dense,
    evaluate,
    names_of,
    polynomial_ring,
    sign,
    to_float,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.numbers import exact_to_sympy, value_of
from pwmap.algebra.rootfunctions import Root
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    integers,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
    spread,
    value_at,
)
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import NumberCell, Scope
from pwmap.maps.words import Decision, Orbits, SignOracle, in_integers

INFINITE = "infinite"


class ResampleError(ValueError):
    """The sample of the symbolic parameters is not generic: there edges meet."""


class DegreeError(ValueError):
    """A polynomial is of a higher degree in the parameter of the axis than one."""


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


def identical(first: Any, second: Any) -> bool:
    """Whether two equal places stay equal for other values of the symbolic parameters."""
    if not isinstance(first, Root):
        return True
    return bool(first.factor == second.factor and first.number == second.number)


class Axis(ABC):
    """One parameter of a map, along which signs are followed; others stay symbolic at a sample."""

    def __init__(self, definition: Definition, name: str, sample: dict[str, Number]) -> None:
        self.definition, self.name, self.sample = definition, name, sample
        self.orbits = Orbits(definition.table)
        self.index = names_of(definition.ring).index(name)
        self._roots: dict[Decision | PolyElement, tuple[Any, ...] | None] = {}

    def copy(self) -> Axis:
        """The same axis; what it records from now on is not recorded here."""
        twin = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, dict):
                setattr(twin, name, dict(value))
        return twin

    # --- Places ---------------------------------------------------------------------------------

    @abstractmethod
    def place(self, value: Number) -> Any:
        """A rational value as a place on the axis."""

    @abstractmethod
    def real(self, place: Any) -> Real:
        """The number that a place is at the sample."""

    def between(self, low: Any, high: Any) -> Any:
        """A place strictly between two others."""
        return self.place(simplest_between(self.real(low), self.real(high)))

    def spread(self, low: Any, high: Any, n: int) -> list[Any]:
        """Places inside an interval, in equal steps."""
        return [self.place(value) for value in spread(self.real(low), self.real(high), n)]

    def roots(self, decision: Decision) -> tuple[Any, ...] | None:
        """Places where the sign of a decision is zero; None if it is zero everywhere."""
        if decision not in self._roots:
            self._roots[decision] = self.zeros(self.orbits.polynomial(decision))
        return self._roots[decision]

    def limits(self, constraint: Constraint) -> tuple[Any, ...]:
        """Places where an assumption begins or ceases to hold; ValueError for too high a degree."""
        polynomial = constraint.polynomial
        if polynomial not in self._roots:
            try:
                self._roots[polynomial] = self.zeros(polynomial)
            except DegreeError:
                raise DegreeError(
                    f"the assumption {constraint} is not of degree one in {self.name}: "
                    "give the other parameters values (.at)"
                ) from None
        return self._roots[polynomial] or ()

    @abstractmethod
    def zeros(self, polynomial: Number) -> tuple[Any, ...] | None:
        """Places where a polynomial in the parameters is zero; None if it is zero everywhere."""

    # --- Decided at the sample ------------------------------------------------------------------

    @abstractmethod
    def coefficients(self, polynomial: Number) -> Dense:
        """A polynomial in the parameter of the axis alone, others at their sample."""

    @cached_property
    def _orbits_here(self) -> Orbits:
        if not self.sample:
            return self.orbits
        ring = polynomial_ring([self.definition.ring.symbols[self.index]])
        table = self.definition.table.mapped(lambda n: evaluate(n, self.sample, ring))
        return Orbits(table)

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

    @staticmethod
    def compare_values(first: Any, second: Any) -> int:
        """Sign of the difference of two values of :meth:`value`; it is not recorded."""
        one, other = (v.value if isinstance(v, ValueAt) else v for v in (first, second))
        return sign(one - other)

    # --- Decided, and recorded ------------------------------------------------------------------

    @abstractmethod
    def value(self, fraction: Fraction_, place: Any) -> Any:
        """A quotient at a place, in a canonical form, or INFINITE."""

    def compare(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        """Sign of the difference of two finite quotients at a place."""
        (a, b), (c, d) = first, second
        found = self.recorded_sign(a * d - c * b, place)
        return found and found * self.recorded_sign(b, place) * self.recorded_sign(d, place)

    def recorded_sign(self, polynomial: Number, place: Any) -> int:
        """Sign of a polynomial at a place, with what it asks of other parameters recorded."""
        return self.sign(polynomial, place)

    def closing(self, places: Sequence[Any], decided: Iterable[Decision]) -> None:  # noqa: B027
        """Record what the order of places, and decisions at them, ask of other parameters."""

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """Conditions on symbolic parameters under which all decisions hold."""
        return ()

    # --- What a user sees -----------------------------------------------------------------------

    @abstractmethod
    def to_sympy(self, place: Any) -> sympy.Expr:
        """A place as an expression."""

    @abstractmethod
    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        """What :meth:`value` returned for a place, as an expression."""

    @abstractmethod
    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        """Where the signs of a cell hold; after :meth:`closing`."""

    @property
    def identity(self) -> Fraction_:
        """The parameter itself, as a quotient."""
        ring = self.definition.ring
        return ring.gens[self.index], ring.one

    def degree(self, number: Number) -> int:
        """Degree of a polynomial in the parameter of the axis; 0 for zero."""
        return degree_in(number, self.index)


def _sign_at_root(root: RealRoot, number: Number) -> int:
    return root.sign_of(_integers(number))


@lru_cache(maxsize=65536)  # the same polynomial is asked at many places
def _integers(number: Number) -> tuple[int, ...]:
    return integers(dense(number))


class RationalAxis(Axis):
    """The only parameter of a map; places are numbers."""

    def place(self, value: Number) -> Number:
        return value

    def real(self, place: Real) -> Real:
        return place

    def zeros(self, polynomial: Number) -> tuple[Any, ...] | None:
        return real_roots(dense(polynomial)) if polynomial else None

    def coefficients(self, polynomial: Number) -> Dense:
        return dense(polynomial)

    def value(self, fraction: Fraction_, place: Any) -> Any:
        top, bottom = (value_of(dense(number), place) for number in fraction)
        return top / bottom if bottom else INFINITE

    def to_sympy(self, place: Any) -> sympy.Expr:
        return real_to_sympy(place)

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        return exact_to_sympy(value)

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        return NumberCell(self.definition.ring.symbols[0], low, high, orders)
