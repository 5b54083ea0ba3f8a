"""Exact real numbers: the rationals, and fields Q(t) of one real algebraic number t."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from fractions import Fraction
from functools import total_ordering
from typing import Any

import mpmath
import sympy
from sympy import QQ
from sympy.polys.densearith import dup_add, dup_mul, dup_neg, dup_pow, dup_sub
from sympy.polys.polyerrors import IsomorphismFailed

from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import Fraction_, Infinite, Number, dense, pair, to_float
from pwmap.algebra.roots import Dense, Real, RealRoot, algebraic, integers, value_at

IV = mpmath.MPIntervalContext()  # a separate context, whose precision no other library changes
IV.prec = 120
Exact = Any  # an element of QQ, or an Element; an end of an interval may be Infinite


@total_ordering
class Element:
    """A number in the field of a real root, by its reduced coefficients, highest power first."""

    __slots__ = ("root", "value")

    def __init__(self, root: RealRoot, value: Dense) -> None:
        self.root = root
        self.value = tuple(value)

    def _dense(self, other: object) -> Dense | None:
        if isinstance(other, Element):
            return other.value
        if isinstance(other, (int, Fraction)):
            other = QQ(other.numerator, other.denominator)
        if isinstance(other, (float, Infinite, sympy.Basic)):  # sympy takes it by _sympy_
            return None
        return (other,) if other else ()

    def _with(self, other: object, operation: Callable[..., list[Number]]) -> Element:
        right = self._dense(other)
        if right is None:
            return NotImplemented  # type: ignore[no-any-return]
        return Element(self.root, tuple(operation(list(self.value), list(right), QQ)))

    def _product(self, one: list[Number], other: list[Number], domain: Any) -> list[Number]:
        return [*self.root.reduced(tuple(dup_mul(one, other, domain)))]

    def __add__(self, other: object) -> Element:
        return self._with(other, dup_add)

    def __neg__(self) -> Element:
        return Element(self.root, tuple(dup_neg(list(self.value), QQ)))

    def __sub__(self, other: object) -> Element:
        return self._with(other, dup_sub)

    def __rsub__(self, other: object) -> Element:
        return -self + other

    def __mul__(self, other: object) -> Element:
        return self._with(other, self._product)

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, exponent: int) -> Element:
        return Element(self.root, self.root.reduced(tuple(dup_pow([*self.value], exponent, QQ))))

    def __truediv__(self, other: object) -> Element:
        right = self._dense(other)
        if right is None:
            return NotImplemented
        if not right:
            raise ZeroDivisionError(f"{self} is divided by zero")
        return Element(self.root, self.root.quotient(self.value, right))

    def __rtruediv__(self, other: object) -> Element:
        return Element(self.root, self._dense(other) or ()) / self

    def __abs__(self) -> Element:
        return -self if self < 0 else self

    def __bool__(self) -> bool:
        return bool(self.value)

    def __eq__(self, other: object) -> bool:
        right = self._dense(other)
        return right is not None and self.value == right

    def __hash__(self) -> int:
        return hash((self.root, self.value))

    def __lt__(self, other: object) -> bool:
        if self._dense(other) is None:
            return NotImplemented
        return self.root.sign_of(integers((self - other).value)) < 0

    def __float__(self) -> float:
        return self.root.to_float(self.value, (QQ.one,))

    def to_sympy(self) -> sympy.Expr:
        """The number as a sympy expression."""
        return self.root.element_to_sympy(self.value)

    _sympy_ = to_sympy

    def __repr__(self) -> str:
        return str(self.to_sympy())


def value_of(coefficients: Dense, place: Real) -> Exact:
    """The value of a polynomial, highest power first, at a rational or algebraic place."""
    if isinstance(place, RealRoot):
        return Element(place, place.reduced(coefficients))
    return value_at(coefficients, place)


def quotient_of(fraction: Fraction_, place: Real) -> Exact:
    """The value of a quotient of univariate polynomials at a rational or algebraic place."""
    top, bottom = (value_of(dense(number), place) for number in fraction)
    return top / bottom


def key(x: Exact) -> Hashable:
    """A dictionary key for a number; hashing a fraction itself needs a slow modular inverse."""
    return x if isinstance(x, Element) else pair(x)


def to_double(x: Exact) -> float:
    """The double nearest to a number, up to an error in the last bit."""
    return to_float(x) if isinstance(x, QQ.dtype) else float(x)


def number_of(value: object, root: RealRoot | None) -> Exact:
    """A value as a rational or an element of the field of a root; of any field if that is None.

    TypeError if it is a float, ValueError if it is neither rational nor in the field.
    """
    if isinstance(value, Element):
        if root in (None, value.root):
            return value
        value = value.to_sympy()
    if not isinstance(value, sympy.Expr) or value.is_Rational or value.is_Float:
        return rational(value)
    found = algebraic(value)
    if root is None or not isinstance(found, RealRoot):
        return Element(found, (QQ.one, QQ.zero)) if isinstance(found, RealRoot) else found
    try:
        inside = sympy.to_number_field(value, root.to_sympy())
    except IsomorphismFailed:
        raise ValueError(f"{value} is no number of the field of {root.to_sympy()}") from None
    return Element(root, root.reduced(tuple(map(QQ.from_sympy, inside.coeffs()))))


def enclosed(x: Exact, bits: int = 64) -> tuple[Fraction, Fraction]:
    """Fractions below and above a number, equal if it is rational.

    Otherwise they differ by at most 2**-bits times the larger of 1 and the size of the number.
    """
    if not isinstance(x, Element):
        exact = Fraction(*pair(x))
        return exact, exact
    if not x.value:
        return Fraction(0), Fraction(0)
    coefficients, known = integers(x.value), bits
    scale = Fraction(*pair(x.value[0])) / coefficients[0]
    while True:
        value, error = x.root.value_near(coefficients, known)
        unit = scale / (1 << (known + 1) * (len(coefficients) - 1))
        if 2 * error * unit <= max(Fraction(1), abs(value) * unit) / (1 << bits):
            return (value - error) * unit, (value + error) * unit
        known *= 2


def enclosure(x: Exact) -> Any:
    """An mpmath interval that encloses a number, of about the working precision."""
    low, high = (IV.mpf(end.numerator) / end.denominator for end in enclosed(x, IV.prec))
    return IV.mpf([low.a, high.b])


def log_bounds(x: Exact) -> tuple[float, float]:
    """Doubles below and above the natural logarithm of a positive number."""
    found = IV.log(enclosure(x))
    return math.nextafter(float(found.a), -math.inf), math.nextafter(float(found.b), math.inf)
