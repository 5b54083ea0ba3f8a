"""Intervals with outward rounding, and Taylor models over them.

Arithmetic is that of mpmath's library of intervals. A Taylor model is a polynomial in tau on
|tau| <= half, with narrow intervals as coefficients, and an interval for the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import factorial
from typing import Any

from mpmath import libmp

LARGEST = 64  # of |x| for a series whose 20th quotient is below a half


class Undecided(Exception):  # noqa: N818  (no error: an answer)
    """What intervals could not decide."""


class Context:
    """The working precision [bits]; one for the whole process."""

    bits = 100


@lru_cache(maxsize=20_000)
def _rounded(numerator: int, denominator: int, bits: int, direction: str) -> Any:
    return libmp.from_rational(numerator, denominator, bits, direction)


class I:  # noqa: E742  (the name of intervals in the field)
    """A closed interval."""

    __slots__ = ("v",)

    def __init__(self, v: Any) -> None:
        self.v = v

    @classmethod
    def of(cls, x: Fraction | int, y: Fraction | int | None = None) -> I:
        """The narrowest interval known that holds one or two rational numbers."""
        top = x if y is None else y
        low = _rounded(x.numerator, x.denominator, Context.bits, "f")
        return cls((low, _rounded(top.numerator, top.denominator, Context.bits, "c")))

    def __add__(self, other: I) -> I:
        return I(libmp.mpi_add(self.v, other.v, Context.bits))

    def __sub__(self, other: I) -> I:
        return I(libmp.mpi_sub(self.v, other.v, Context.bits))

    def __mul__(self, other: I) -> I:
        return I(libmp.mpi_mul(self.v, other.v, Context.bits))

    def __neg__(self) -> I:
        return I(libmp.mpi_neg(self.v))

    def __truediv__(self, other: I) -> I:
        if other.sign() is None or other.sign() == 0:
            raise Undecided("a divisor may vanish")
        return I(libmp.mpi_div(self.v, other.v, Context.bits))

    def power(self, n: int) -> I:
        """An integer power >= 0."""
        return I(libmp.mpi_pow_int(self.v, n, Context.bits))

    def sqrt(self) -> I:
        """Square root of a positive interval."""
        return I(libmp.mpi_sqrt(self.v, Context.bits))

    def cos_sin(self) -> tuple[I, I]:
        """Cosine and sine."""
        c, s = libmp.mpi_cos_sin(self.v, Context.bits)
        return I(c), I(s)

    def exp(self) -> I:
        """Exponential."""
        return I(libmp.mpi_exp(self.v, Context.bits))

    def sign(self) -> int | None:
        """1, -1, 0 if it is exactly zero, None if it holds zero and more."""
        low, high = libmp.mpf_sign(self.v[0]), libmp.mpf_sign(self.v[1])
        if low == high:
            return int(low)
        return None

    def inside(self, other: I) -> bool:
        """Whether it lies in another one."""
        above = libmp.mpf_ge(self.v[0], other.v[0])
        return bool(above and libmp.mpf_le(self.v[1], other.v[1]))

    def within(self, other: I) -> bool:
        """Whether it lies in the interior of another one."""
        above = libmp.mpf_gt(self.v[0], other.v[0])
        return bool(above and libmp.mpf_lt(self.v[1], other.v[1]))

    def meet(self, other: I) -> I:
        """What both share; both hold the same number, so there is something."""
        low = self.v[0] if libmp.mpf_ge(self.v[0], other.v[0]) else other.v[0]
        high = self.v[1] if libmp.mpf_le(self.v[1], other.v[1]) else other.v[1]
        return I((low, high)) if libmp.mpf_le(low, high) else self

    def hull(self, other: I) -> I:
        """The smallest interval that holds both."""
        low = self.v[0] if libmp.mpf_le(self.v[0], other.v[0]) else other.v[0]
        high = self.v[1] if libmp.mpf_ge(self.v[1], other.v[1]) else other.v[1]
        return I((low, high))

    @property
    def low(self) -> I:
        """The lower end."""
        return I((self.v[0], self.v[0]))

    @property
    def high(self) -> I:
        """The upper end."""
        return I((self.v[1], self.v[1]))

    @property
    def mid(self) -> I:
        """A number inside, near the middle."""
        m = libmp.mpi_mid(self.v, Context.bits)
        return I((m, m))

    @property
    def size(self) -> I:
        """The largest modulus, as a number."""
        return I(libmp.mpi_abs(self.v, Context.bits)).high

    @property
    def ball(self) -> I:
        """The symmetric interval of this size."""
        return (-self.size).hull(self.size)

    def less(self, other: I) -> bool:
        """Whether all of it lies below all of another one."""
        return (other - self).sign() == 1

    def __float__(self) -> float:
        return float(libmp.to_float(libmp.mpi_mid(self.v, Context.bits)))


ZERO, ONE = I((libmp.fzero, libmp.fzero)), I((libmp.fone, libmp.fone))


def number(x: float) -> I:
    """The interval of a double."""
    v = libmp.from_float(x)
    return I((v, v))


class Span:
    """The domain of Taylor models: |tau| <= half, and how many coefficients they have."""

    def __init__(self, half: I, terms: int) -> None:
        self.half, self.terms = half, terms
        self.tau = half.ball
        self.powers = [self.tau.power(k) for k in range(2 * terms + 1)]


class T:
    """A Taylor model."""

    __slots__ = ("_range", "c", "rest", "span")

    def __init__(self, span: Span, c: Sequence[I], rest: I = ZERO) -> None:
        self.span, self.rest = span, rest
        for k in range(span.terms, len(c)):
            self.rest = self.rest + c[k] * span.powers[k]
        self.c = list(c[: span.terms])
        self._range: I | None = None

    @property
    def poly(self) -> I:
        """Range of the polynomial."""
        if self._range is None:
            total = self.c[0]
            for k in range(1, len(self.c)):
                total = total + self.c[k] * self.span.powers[k]
            self._range = total
        return self._range

    @property
    def range(self) -> I:
        """Range of the function."""
        return self.poly + self.rest

    def wider(self, more: I) -> T:
        """The function plus something in an interval."""
        return T(self.span, self.c, self.rest + more)

    def __add__(self, other: T) -> T:
        longer, shorter = (self.c, other.c) if len(self.c) >= len(other.c) else (other.c, self.c)
        c = [x + y for x, y in zip(longer, shorter, strict=False)] + longer[len(shorter) :]
        return T(self.span, c, self.rest + other.rest)

    def __neg__(self) -> T:
        return T(self.span, [-x for x in self.c], -self.rest)

    def __sub__(self, other: T) -> T:
        return self + (-other)

    def scaled(self, x: I) -> T:
        """The function times a number."""
        return T(self.span, [x * c for c in self.c], x * self.rest)

    def __mul__(self, other: T) -> T:
        c = convolved(self.c, other.c)
        return T(self.span, c, self.rest * other.range + self.poly * other.rest)


def convolved(a: Sequence[I], b: Sequence[I]) -> list[I]:
    """Coefficients of a product of polynomials."""
    c = [ZERO] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            c[i + j] = c[i + j] + x * y
    return c


def through(f: T, taylor: Sequence[I], slope: I, last: I) -> T:
    """g(f), from Taylor coefficients at f's first one, and ranges of g' and g^(n)/n! over f."""
    move = T(f.span, [ZERO, *f.c[1:]])
    found, power = T(f.span, [taylor[0]]), T(f.span, [ONE])
    for k in range(1, f.span.terms):
        power = power * move
        found = found + power.scaled(taylor[k])
    tail = last * move.poly.power(f.span.terms)
    return found.wider(tail + slope * f.rest)


def inverse(f: T) -> T:
    """1 / f."""
    over, whole = ONE / f.c[0], ONE / f.range
    taylor, n = [over], f.span.terms
    for _ in range(n):
        taylor.append(-(taylor[-1] * over))
    last = (ONE / f.poly).power(n + 1)
    return through(f, taylor, -(whole * whole), last if n % 2 == 0 else -last)


def wave(kappa: I, t: I) -> list[I]:
    """s_0 .. s_5, s_k = t^k (1/k! + x/(k+2)! + x^2/(k+4)! + ...) with x = kappa t^2.

    By the series where it converges fast, else by s_(k+2) = (s_k - t^k/k!) / kappa from the cosine.
    """
    x = kappa * t * t
    if x.size.less(ONE):
        return [t.power(k) * c for k, c in enumerate(shapes(x, 5))]
    found = _direct(kappa, t)
    middle, move = _direct(kappa, t.mid), t - t.mid
    for k in range(1, 6):
        found[k] = found[k].meet(middle[k] + found[k - 1] * move)
    return found


def _direct(kappa: I, t: I) -> list[I]:
    if kappa.sign() == -1:
        omega = (-kappa).sqrt()
        c, s = (omega * t).cos_sin()
    else:
        omega = kappa.sqrt()
        up, down = (omega * t).exp(), (-(omega * t)).exp()
        half = I.of(Fraction(1, 2))
        c, s = (up + down) * half, (up - down) * half
    found = [c, s / omega]
    for k in range(4):
        found.append((found[k] - t.power(k) / I.of(factorial(k))) / kappa)
    return found


def shapes(x: I, last: int) -> list[I]:
    """c_0 .. c_last, c_k(x) = 1/k! + x/(k+2)! + ...: the last two by their series, then downwards."""
    if not x.size.less(I.of(LARGEST)):
        raise Undecided("a flight is too long")
    found = [ZERO] * (last + 1)
    for k in range(max(last - 1, 0), last + 1):
        terms = _terms(x, k)
        after = _reciprocal(k + 2 * terms, Context.bits)  # what follows is less than half each time
        total = (after + after).ball
        for n in range(terms - 1, -1, -1):
            total = _reciprocal(k + 2 * n, Context.bits) + x * total
        found[k] = total
    for k in range(last - 2, -1, -1):
        found[k] = _reciprocal(k, Context.bits) + x * found[k + 2]
    return found


def _terms(x: I, k: int) -> int:
    """How many terms of the series of c_k are needed, at least so many that the rest soon falls."""
    size, n, term = float(x.size), 0, 1.0
    while term > 2.0**-Context.bits or (k + 2 * n + 1) * (k + 2 * n + 2) < 2.0 * size + 1.0:
        n += 1
        term *= (size + 1e-300) / ((k + 2 * n - 1) * (k + 2 * n))
    return n + 1


@lru_cache(maxsize=1000)
def _reciprocal(n: int, bits: int) -> I:
    """1 / n!."""
    return I.of(Fraction(1, factorial(n)))
