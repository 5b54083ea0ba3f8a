"""Exact numbers and polynomials, and how they are written.

A coefficient is an element of ``QQ`` or of a polynomial ring over it. Sympy expressions are read
and returned by public functions only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache, lru_cache, total_ordering
from typing import Any, NamedTuple, Self

import sympy
from sympy import QQ
from sympy.polys.orderings import lex
from sympy.polys.rings import PolyElement, PolyRing

Number = Any  # an element of QQ or of a PolyRing over QQ: both have + - * and ==
Ring = Any  # a sympy PolyRing over QQ, or None where there is no parameter
Fraction_ = tuple[Number, Number]  # numerator and denominator
FACTORED = 64  # degree up to which quotients are factored when written


def polynomial_ring(symbols: Sequence[sympy.Symbol]) -> Ring:
    """The ring ``QQ[symbols]``; None without symbols, as numbers are then elements of ``QQ``."""
    return PolyRing(tuple(symbols), QQ, lex) if symbols else None


class Packed:
    """A stand-in for a value in a pickle: the call that makes it from types of Python."""

    def __init__(self, make: Callable[..., Any], *parts: Any) -> None:
        self._call = make, parts

    def __reduce__(self) -> tuple[Any, ...]:
        return self._call


def portable(value: Any) -> Any:
    """A value with its numbers packed for a pickle, as sympy's number types vary by machine."""
    match value:
        case PolyElement():
            terms = [(exponents, pair(c)) for exponents, c in value.terms()]
            return Packed(_polynomial, value.ring.symbols, terms)
        case PolyRing():
            return Packed(polynomial_ring, value.symbols)
        case QQ.dtype():
            return Packed(_rational, *pair(value))
        case tuple():
            parts = map(portable, value)
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def _polynomial(symbols: Sequence[sympy.Symbol], terms: Iterable[tuple[Any, Any]]) -> PolyElement:
    return polynomial_ring(symbols).from_dict({key: QQ(*number) for key, number in terms})


def _rational(top: int, bottom: int) -> Number:
    return QQ(top, bottom)


class Portable:
    """Base of values that never change; a dataclass is pickled field by field, numbers packed."""

    __slots__ = ()

    def __reduce__(self) -> tuple[Any, ...]:
        own: Any = self
        kept = {each.name: portable(getattr(self, each.name)) for each in fields(own)}
        return _made, (type(self), kept)

    def __copy__(self) -> Self:
        return self  # a copy by __reduce__ would keep the packed numbers


def _made(kind: type, kept: Mapping[str, Any]) -> Any:
    return kind(**kept)


class Affine(NamedTuple):
    """The affine map x -> slope x + intercept, in numbers of any kind."""

    slope: Number
    intercept: Number

    def __call__(self, x: Number) -> Number:
        """The value at a point."""
        return self.slope * x + self.intercept

    def after(self, first: Affine) -> Affine:
        """The composition: this map applied after ``first``."""
        return Affine(self.slope * first.slope, self.slope * first.intercept + self.intercept)

    @property
    def fixed_point(self) -> Number:
        """The point that is mapped to itself; the slope must not be 1."""
        return self.intercept / (1 - self.slope)


def sign(number: Number) -> int:
    """The sign of an element of ``QQ``: -1, 0 or 1."""
    return int(number > 0) - int(number < 0)


@total_ordering
class Infinite:
    """Minus or plus infinity, by its side (-1, +1); an affine map takes it to its limit there."""

    __slots__ = ("side",)

    def __init__(self, side: int) -> None:
        self.side = side

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Infinite) and self.side == other.side

    def __hash__(self) -> int:
        return hash((Infinite, self.side))

    def __lt__(self, other: Any) -> bool:
        return self.side < (other.side if isinstance(other, Infinite) else 0)

    def __neg__(self) -> Infinite:
        return Infinite(-self.side)

    def __abs__(self) -> Infinite:
        return HIGHEST

    def __add__(self, other: Any) -> Infinite:
        return self

    __radd__ = __sub__ = __add__

    def __rsub__(self, other: Any) -> Infinite:
        return -self

    def __mul__(self, other: Any) -> Any:
        """Zero times infinity is zero: a flat piece has its one value at infinity, too."""
        return Infinite(self.side * sign(other)) if other else QQ.zero

    __rmul__ = __truediv__ = __mul__

    def __float__(self) -> float:
        return self.side * math.inf

    @property
    def value(self) -> Infinite:
        """Infinity itself, at any sample of other parameters."""
        return self

    def to_sympy(self, *_: Any) -> sympy.Expr:
        """The infinity as a sympy expression."""
        return self.side * sympy.oo

    def __repr__(self) -> str:
        return "oo" if self.side > 0 else "-oo"


LOWEST, HIGHEST = Infinite(-1), Infinite(1)


def pair(number: Number) -> tuple[int, int]:
    """Numerator and denominator of an element of ``QQ`` as Python integers."""
    return int(QQ.numer(number)), int(QQ.denom(number))


def bits(number: Number) -> int:
    """The bits of the numerator and the denominator of an element of ``QQ``, added."""
    return int(QQ.numer(number).bit_length() + QQ.denom(number).bit_length())


def floor(number: Number) -> int:
    """The largest integer not above an element of ``QQ``."""
    top, bottom = pair(number)
    return top // bottom


def to_float(number: Number) -> float:
    """The float nearest to an element of ``QQ``; infinite if it is too large."""
    top, bottom = pair(number)
    try:
        return top / bottom
    except OverflowError:
        return math.inf if top > 0 else -math.inf


@lru_cache(maxsize=256)
def names_of(ring: Ring) -> tuple[str, ...]:
    """The names of the generators of a ring; empty if there is no parameter."""
    return tuple(map(str, ring.symbols)) if ring is not None else ()


def evaluate(polynomial: PolyElement, values: Mapping[str, Number]) -> Number:
    """A polynomial with rational values for some generators: one in the others, or a rational."""
    gens = zip(names_of(polynomial.ring), polynomial.ring.gens, strict=True)
    known = [(gen, values[name]) for name, gen in gens if name in values]
    return polynomial.evaluate(known) if known else polynomial


def partly(
    polynomial: PolyElement, values: Sequence[Number | None]
) -> dict[tuple[int, ...], Number]:
    """The coefficients by the exponents of the generators that have no value (None).

    The others have the given rational values.
    """
    terms: dict[tuple[int, ...], Number] = {}
    for exponents, coefficient in polynomial.items():
        for value, exponent in zip(values, exponents, strict=True):
            if value is not None and exponent:
                coefficient = coefficient * value**exponent
        key = tuple(e for e, value in zip(exponents, values, strict=True) if value is None)
        terms[key] = terms.get(key, QQ.zero) + coefficient
    return terms


def to_ring(number: Number, ring: Ring) -> Number:
    """Move a number to a ring that has all its generators."""
    if ring is None:
        return number
    return number.set_ring(ring) if isinstance(number, PolyElement) else ring.ground_new(number)


def dense(polynomial: Number, index: int = 0) -> tuple[Number, ...]:
    """The coefficients of a polynomial in one generator, highest power first; () for zero."""
    if not isinstance(polynomial, PolyElement):
        return (polynomial,) if polynomial else ()
    terms = {exponents[index]: coefficient for exponents, coefficient in polynomial.terms()}
    return tuple(terms.get(i, QQ.zero) for i in range(max(terms, default=-1), -1, -1))


def degree_in(polynomial: Number, index: int) -> int:
    """The degree of a polynomial in one generator; 0 for zero."""
    return max(0, int(polynomial.degree(index))) if polynomial else 0


def is_constant(number: Number) -> bool:
    """Whether no parameter occurs in a number."""
    return not isinstance(number, PolyElement) or number.is_ground


def constant(number: Number) -> Number:
    """The value in ``QQ`` of a number in which no parameter occurs."""
    return number.coeff(1) if isinstance(number, PolyElement) else number


def cancelled(fraction: Fraction_) -> Fraction_:
    """Numerator and denominator without common factor; the denominator of a constant is 1."""
    numerator, denominator = fraction
    if isinstance(numerator, PolyElement):
        return tuple(numerator.cancel(denominator))
    return numerator / denominator, QQ.one


@lru_cache(maxsize=4096)  # iterates share most of their coefficients
def to_sympy(number: Number) -> sympy.Expr:
    """A coefficient as a sympy expression."""
    return number.as_expr() if isinstance(number, PolyElement) else QQ.to_sympy(QQ.convert(number))


def quotient_to_sympy(fraction: Fraction_) -> sympy.Expr:
    """A quotient as a sympy expression: a polynomial as it is, others in lowest terms."""
    top, bottom = fraction
    return to_sympy(top) if bottom == 1 else fraction_to_sympy(fraction)


@lru_cache(maxsize=4096)
def fraction_to_sympy(fraction: Fraction_) -> sympy.Expr:
    """A quotient as a sympy expression in lowest terms, factored unless its degree is high."""
    top, bottom = cancelled(fraction)
    if is_constant(top) and is_constant(bottom):
        return to_sympy(constant(top) / constant(bottom))
    plain = len(top.ring.gens) == 1 and top.degree() <= 1 and bottom.degree() <= 1
    plain = plain or max(total_degree(top), total_degree(bottom)) > FACTORED
    return to_sympy(top) / to_sympy(bottom) if plain else factored_to_sympy((top, bottom))


@cache
def total_degree(polynomial: PolyElement) -> int:
    """The largest sum of exponents; 0 for constants."""
    return max(map(sum, polynomial), default=0)


def reduced_to_sympy(top: PolyElement, bottom: PolyElement, name: str) -> sympy.Expr:
    """A quotient in lowest terms as an expression; the generator ``name`` does not occur in it."""
    above, below = (evaluate(number, {name: QQ.zero}) for number in (top, bottom))
    return factored_to_sympy(cancelled((above, below)))


@lru_cache(maxsize=4096)
def factored_to_sympy(fraction: Fraction_) -> sympy.Expr:
    """A quotient in lowest terms as ``sympy.factor`` writes it."""
    top, bottom = fraction
    if len(top.ring.gens) > 1:
        return sympy.factor(to_sympy(top) / to_sympy(bottom))
    (unit, above), (scale, below) = factored(top), factored(bottom)
    powers = [*above, *((factor, -exponent) for factor, exponent in below)]
    product = sympy.Mul(*(to_sympy(factor) ** exponent for factor, exponent in powers))
    coefficient = to_sympy(unit / scale)
    if coefficient in (1, -1) or not product.is_Add:
        return coefficient * product
    return sympy.Mul(coefficient, product, evaluate=False)  # keeps the factor in front of the sum


@lru_cache(maxsize=65536)  # the same polynomials recur at many places
def factored(polynomial: PolyElement) -> tuple[Number, tuple[tuple[PolyElement, int], ...]]:
    """A constant, and the irreducible factors of coprime integers with their exponents."""
    if polynomial.is_ground:
        return constant(polynomial), ()
    unit, powers = polynomial.factor_list()
    return unit, tuple(powers)


def normalised(polynomial: PolyElement) -> PolyElement:
    """The multiple with coprime integer coefficients, the leading one positive."""
    primitive = polynomial.primitive()[1]
    return -primitive if primitive.LC < 0 else primitive
