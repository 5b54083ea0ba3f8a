"""Arithmetic of formulas in the variable and the parameters of a map, within a limit of work.

A value is a polynomial in the variable, divided by an element of the ring of the parameters. The
work of an operation is counted before it is done: ``((a + b + c + d)**64)**64`` is not expanded.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.arguments import shown
from pwmap.algebra.exact import Fraction_, Number, Ring, cancelled, constant, is_constant
from pwmap.algebra.exact import bits as bits_of
from pwmap.algebra.parsing import term_of
from pwmap.algebra.terms import CONDITIONS, MAX_BITS, Operation, Term, plain_name
from pwmap.algebra.texts import exact

MAX_DEGREE = 64  # of a polynomial in the parameters, and in the variable
MAX_PARAMETERS = 64  # far more than any map has; the work on polynomials grows fast with it
MAX_WORK = 100_000  # products of two short terms, at a few microseconds each


class Quotient(NamedTuple):
    """``(top[0] + top[1] x + top[2] x**2 + ...) / bottom``; the last entry of top is not zero."""

    top: tuple[Number, ...]
    bottom: Number

    @property
    def is_constant(self) -> bool:
        """Whether the variable does not occur."""
        return len(self.top) <= 1


class Arithmetic:
    """Sums, products and powers of quotients over the parameters' ring (None if there are none)."""

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self._left = MAX_WORK
        self.one: Number = ring.one if ring is not None else QQ.one
        self.zero: Number = self.one - self.one
        generators = zip(ring.symbols, ring.gens, strict=True) if ring is not None else ()
        self._generators = {plain_name(symbol): generator for symbol, generator in generators}

    def spend(self, work: int) -> None:
        """Count work before it is done; ValueError if the total is too large."""
        self._left -= work
        if self._left < 0:
            raise ValueError(
                "the formulas are too large to be multiplied out, or have too many pieces"
            )

    # --- Numbers of the ring --------------------------------------------------------------------

    def times(self, a: Number, b: Number) -> Number:
        """The product of two coefficients."""
        if a == self.one or b == self.one:
            return b if a == self.one else a
        (n, bits, degree), (m, more_bits, more) = _size(a), _size(b)
        self._check(bits + more_bits, degree + more)
        self.spend(n * m * _words(bits, more_bits))
        return a * b

    def plus(self, a: Number, b: Number) -> Number:
        """The sum of two coefficients."""
        (n, bits, _), (m, more_bits, _) = _size(a), _size(b)
        self._check(max(bits, more_bits), 0)
        self.spend((n + m) * _words(bits, more_bits))
        return a + b

    def _check(self, bits: int, degree: int) -> None:
        if bits > MAX_BITS:
            raise ValueError(f"an integer may have {MAX_BITS} bits, here it would have {bits}")
        if degree > MAX_DEGREE:
            raise ValueError(f"a degree may be at most {MAX_DEGREE}, here it would be {degree}")

    # --- Quotients ------------------------------------------------------------------------------

    def constant(self, number: Number) -> Quotient:
        """An element of ``QQ`` or of the ring as a quotient."""
        value = self.one * number
        return Quotient((value,) if value else (), self.one)

    @property
    def variable(self) -> Quotient:
        """The variable of the map as a quotient."""
        return Quotient((self.zero, self.one), self.one)

    def sum(self, values: Sequence[Quotient]) -> Quotient:
        """The sum of quotients; those with the same denominator are added first."""
        groups: dict[Number, list[Number]] = {}
        for value in values:
            self._add(groups.setdefault(value.bottom, []), value.top)
        (bottom, total), *others = groups.items() or [(self.one, [])]
        for other, top in others:
            total = [self.times(coefficient, other) for coefficient in total]
            self._add(total, [self.times(coefficient, bottom) for coefficient in top])
            bottom = self.times(bottom, other)
        return _trimmed(total, bottom)

    def _add(self, total: list[Number], top: Sequence[Number]) -> None:
        """Add the coefficients of a polynomial to ``total``, in place."""
        total += [self.zero] * (len(top) - len(total))
        for i, coefficient in enumerate(top):
            total[i] = self.plus(total[i], coefficient) if total[i] else coefficient

    def negative(self, value: Quotient) -> Quotient:
        """Minus a quotient."""
        return Quotient(tuple(-coefficient for coefficient in value.top), value.bottom)

    def product(self, a: Quotient, b: Quotient) -> Quotient:
        """The product of two quotients."""
        self._check(0, len(a.top) + len(b.top) - 2)
        top = [self.zero] * max(0, len(a.top) + len(b.top) - 1)
        for i, x in enumerate(a.top):
            for j, y in enumerate(b.top):
                top[i + j] = self.plus(top[i + j], self.times(x, y))
        return _trimmed(top, self.times(a.bottom, b.bottom))

    def inverse(self, value: Quotient) -> Quotient:
        """One over a quotient; NotPolynomialError if the variable occurs, ValueError for 0."""
        if not value.is_constant:
            raise NotPolynomialError
        if not value.top:
            raise ValueError("it divides by zero")
        top, bottom = value.top[0], value.bottom
        if is_constant(top):
            return Quotient((self.times(bottom, self.one / constant(top)),), self.one)
        return Quotient((bottom,), top)

    def power(self, base: Quotient, exponent: int) -> Quotient:
        """A power with an integer exponent."""
        if exponent < 0:
            return self.power(self.inverse(base), -exponent)
        number = self.rational(base)
        if number is not None:
            if number in (0, 1, -1):
                exponent = min(exponent, 2 - exponent % 2)
            self._check(bits_of(number) * exponent, 0)
            return self.constant(number**exponent)
        self._check(0, exponent)
        result = self.constant(QQ.one)
        for _ in range(exponent):
            result = self.product(result, base)
        return result

    def rational(self, value: Quotient) -> Number | None:
        """A quotient as an element of ``QQ``, or None if it is not a rational number."""
        if not value.top:
            return QQ.zero
        if not (value.is_constant and is_constant(value.top[0]) and is_constant(value.bottom)):
            return None
        return constant(value.top[0]) / constant(value.bottom)

    def applied(self, term: Term, arguments: Sequence[Quotient]) -> Quotient:
        """The value of a tree from those of its arguments; ValueError, also NotPolynomialError."""
        try:
            match term.operation:
                case Operation.NUMBER:
                    return self.constant(term.value)
                case Operation.NAME:
                    return Quotient((self._generators[plain_name(term.value)],), self.one)
                case Operation.SUM:
                    return self.sum(arguments)
                case Operation.NEGATIVE:
                    return self.negative(arguments[0])
                case Operation.PRODUCT:
                    return reduce(self.product, arguments)
                case Operation.INVERSE:
                    return self.inverse(arguments[0])
                case Operation.POWER:
                    exponent = self.rational(arguments[1])
                    if exponent is None or QQ.denom(exponent) != 1:
                        raise ValueError("an exponent must be a whole number")
                    return self.power(arguments[0], int(exponent))
            what = "a condition" if term.operation in CONDITIONS else f"{term.operation.value}"
            raise ValueError(f"a formula was expected here, not {what}")
        except NotPolynomialError:
            raise
        except ValueError as error:
            raise ValueError(f"cannot work out {term}: {error}") from None


class NotPolynomialError(ValueError):
    """A formula divides by the variable."""


def _trimmed(top: list[Number], bottom: Number) -> Quotient:
    while top and not top[-1]:
        del top[-1]
    return Quotient(tuple(top), bottom)


def _words(bits: int, more_bits: int) -> int:
    """The work of a product or sum of two rationals: 1 for short ones, by words of 64 bits."""
    return 1 + (bits + more_bits) // 64 + bits * more_bits // 2048


def _size(number: Number) -> tuple[int, int, int]:
    """The number of terms, the bits of the longest one, and the total degree of a coefficient."""
    if not isinstance(number, PolyElement):
        return 1, bits_of(number), 0
    return (
        1 + len(number),
        max(map(bits_of, number.values()), default=0),
        max(map(sum, number), default=0),
    )


# --- Trees without a variable ---------------------------------------------------------------------


def worked_out(term: Term, arithmetic: Arithmetic) -> Fraction_:
    """The numerator and denominator of a tree in the parameters; ValueError if it has no value."""
    known: dict[int, Quotient] = {}

    def value(inner: Term) -> Quotient:
        if id(inner) not in known:
            known[id(inner)] = arithmetic.applied(inner, [value(a) for a in inner.arguments])
        return known[id(inner)]

    top, bottom = value(term)
    return top[0] if top else arithmetic.zero, bottom


def fraction_of(value: object, ring: Ring, what: str) -> Fraction_:
    """A formula in the parameters, given as text, number or sympy expression, in lowest terms.

    TypeError if a float occurs; ValueError, about ``what``, for other symbols or no formula.
    """
    symbols = ring.symbols if ring is not None else ()
    term = term_of(value, symbols)
    unknown = sorted(term.names().keys() - {plain_name(symbol) for symbol in symbols})
    if unknown:
        raise ValueError(f"{what} {term} holds the unknown symbol {unknown[0]}")
    return cancelled(worked_out(term, Arithmetic(ring)))


def rational(value: object) -> Number:
    """A value, also text as ``"5/4"`` or ``"1.25"``, in ``QQ``; TypeError for a float."""
    try:
        term = term_of(exact(value) if isinstance(value, str) else value)
    except ValueError as error:
        raise ValueError(f"expected a rational number, such as 5/4: {error}") from None
    if term.names() or term.operation in CONDITIONS:
        raise ValueError(f"expected a rational number, got {shown(value)}")
    top, bottom = worked_out(term, Arithmetic(None))
    return top / bottom
