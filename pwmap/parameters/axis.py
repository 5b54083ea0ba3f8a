"""One parameter of a map as an axis with exact places on it.

A place is a rational, an algebraic number, or, where other parameters stay symbolic, a quotient of
polynomials in these with its value at a sample of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    Fraction_,
    Number,
    dense,
    names_of,
    sign,
    to_float,
)
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.roots import (
    Dense,
    RealRoot,
    difference,
    integers,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
    spread,
)
from pwmap.maps.reading import Definition
from pwmap.maps.scopes import Edge, Interval, Scope
from pwmap.maps.words import Decision, IntegerOrbits, Orbits, SignOracle

INFINITE = "infinite"


class ResampleError(ValueError):
    """The sample of the symbolic parameters is not generic: there edges meet."""


class DegreeError(ValueError):
    """A polynomial is of a higher degree in the parameter of the axis than one."""


class Axis(ABC):
    """One parameter of a map, along which the signs of polynomials are followed."""

    definition: Definition
    name: str
    sample: dict[str, Number]  # values of the other, symbolic parameters
    orbits: Orbits  # of the map, in all its parameters

    @abstractmethod
    def place(self, value: Number) -> Any:
        """A rational value as a place on the axis."""

    @abstractmethod
    def between(self, low: Any, high: Any) -> Any:
        """A place strictly between two others; None is an infinite end."""

    @abstractmethod
    def oracle(self, place: Any) -> SignOracle:
        """Who decides all signs at a place."""

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.orbits = Orbits(definition.table)
        self.sample = {}
        self._roots: dict[Decision | PolyElement, tuple[Any, ...] | None] = {}

    def copy(self) -> Axis:
        """The same axis, which records for itself what is decided from now on."""
        twin = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, dict):
                setattr(twin, name, dict(value))
        return twin

    def roots(self, decision: Decision) -> tuple[Any, ...] | None:
        """Places where the sign of a decision is zero; None if it is zero everywhere."""
        if decision not in self._roots:
            self._roots[decision] = self.zeros(self.orbits.polynomial(decision))
        return self._roots[decision]

    def limits(self, constraint: Constraint) -> tuple[Any, ...]:
        """Places where an assumption begins or ceases to hold.

        Raises
        ------
        ValueError
            If its degree is too high for that.
        """
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

    @abstractmethod
    def sign(self, polynomial: Number, place: Any) -> int:
        """Sign of a polynomial in the parameters at a place."""

    @abstractmethod
    def value(self, fraction: Fraction_, place: Any) -> Any:
        """A quotient at a place, in a canonical form, or INFINITE."""

    @abstractmethod
    def compare(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        """Sign of the difference of two finite quotients at a place."""

    @abstractmethod
    def compare_values(self, first: Any, second: Any, place: Any) -> int:
        """Sign of the difference of two values, as :meth:`value` returned them for a place.

        With symbolic parameters it is the sign at their sample, which is not recorded.
        """

    @abstractmethod
    def to_sympy(self, place: Any) -> sympy.Expr:
        """A place as an expression."""

    @abstractmethod
    def number(self, fraction: Fraction_, place: Any) -> float:
        """A finite quotient at a place as a float, infinite if it is too large; for drawing."""

    @abstractmethod
    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        """What :meth:`value` returned for a place, as an expression."""

    @abstractmethod
    def coefficients(self, polynomial: Number) -> Dense:
        """A polynomial in the parameter of the axis alone, others at their sample."""

    @abstractmethod
    def spread(self, low: Any, high: Any, n: int) -> list[Any]:
        """Places inside an interval, in equal steps."""

    @abstractmethod
    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        """Where the decisions of a cell hold that was cut for some orders of iterates.

        With other parameters symbolic, after :meth:`closing`.
        """

    @property
    def identity(self) -> Fraction_:
        """The parameter itself, as a quotient."""
        ring = self.definition.ring
        return ring.gens[names_of(ring).index(self.name)], ring.one

    def degree(self, number: Number) -> int:
        """Degree of a polynomial in the parameter of the axis; 0 for zero."""
        index = names_of(self.definition.ring).index(self.name)
        return max(0, int(number.degree(index))) if number else 0

    def closing(self, places: Sequence[Any], decided: Iterable[Decision]) -> None:  # noqa: B027
        """Record what the order of some places, from left to right, asks of other parameters.

        So does what was decided at some of these places, but maybe not beside them.
        """

    @property
    def given(self) -> tuple[sympy.Basic, ...]:
        """Conditions on other, symbolic parameters under which all that was decided holds."""
        return ()


@dataclass(frozen=True, slots=True)
class SignAt:
    """Signs at an algebraic number."""

    root: RealRoot

    def __call__(self, number: Number) -> int:
        return self.root.sign_of(_integers(number))


@lru_cache(maxsize=65536)  # the same polynomial is asked at many places
def _integers(number: Number) -> tuple[int, ...]:
    return integers(dense(number))


class RationalAxis(Axis):
    """The only parameter of a map."""

    def __init__(self, definition: Definition) -> None:
        super().__init__(definition)
        self.name = str(definition.ring.symbols[0])

    def place(self, value: Number) -> Number:
        return value

    def between(self, low: Any, high: Any) -> Number:
        return simplest_between(low, high)

    def oracle(self, place: Any) -> SignOracle:
        if isinstance(place, RealRoot):
            return SignOracle(self.orbits, SignAt(place))
        table = self.definition.table.mapped(lambda number: _at(number, place))
        return SignOracle(IntegerOrbits(table), sign)

    def scope(self, low: Any, high: Any, orders: tuple[int, ...]) -> Scope:
        symbol = self.definition.ring.symbols[0]
        if low is not None and low is high:
            return Edge(symbol, low)
        return Interval(symbol, low, high, orders)

    def zeros(self, polynomial: Number) -> tuple[Any, ...] | None:
        return real_roots(dense(polynomial)) if polynomial else None

    def sign(self, polynomial: Number, place: Any) -> int:
        return sign_at(dense(polynomial), place)

    def value(self, fraction: Fraction_, place: Any) -> Any:
        top, bottom = (dense(number) for number in fraction)
        if sign_at(bottom, place) == 0:
            return INFINITE
        if isinstance(place, RealRoot):
            return place.quotient(top, bottom)
        return _at(fraction[0], place) / _at(fraction[1], place)

    def compare(self, first: Fraction_, second: Fraction_, place: Any) -> int:
        (a, b), (c, d) = first, second
        bottom = sign_at(dense(b), place) * sign_at(dense(d), place)
        return sign_at(dense(a * d - c * b), place) * bottom

    def compare_values(self, first: Any, second: Any, place: Any) -> int:
        if isinstance(place, RealRoot):
            return sign_at(difference(first, second), place)
        return sign(first - second)

    def to_sympy(self, place: Any) -> sympy.Expr:
        return real_to_sympy(place)

    def number(self, fraction: Fraction_, place: Any) -> float:
        if isinstance(place, RealRoot):
            top, bottom = (dense(number) for number in fraction)
            return place.to_float(top, bottom)
        return to_float(_at(fraction[0], place) / _at(fraction[1], place))

    def value_to_sympy(self, value: Any, place: Any) -> sympy.Expr:
        if not isinstance(place, RealRoot):
            return QQ.to_sympy(value)
        return place.element_to_sympy(value)

    def coefficients(self, polynomial: Number) -> Dense:
        return dense(polynomial)

    def spread(self, low: Any, high: Any, n: int) -> list[Number]:
        return spread(low, high, n)


def _at(number: PolyElement, value: Number) -> Number:
    """A polynomial in one parameter at a rational value."""
    total = QQ.zero
    for (exponent,), coefficient in number.items():
        total += coefficient * value**exponent
    return total
