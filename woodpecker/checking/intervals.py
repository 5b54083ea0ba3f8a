"""Intervals and Taylor models in fixed point: integers times 2^-bits, rounded outwards.

Sums are exact, and products need one shift. Cosines and sines are mpmath's intervals; so are
exponentials, with their last digits widened. A Taylor model is a polynomial in tau / half,
|tau| <= half, with multiples of 2^-bits as coefficients, and a radius of the remainder, which
includes all rounding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from math import factorial, isqrt
from threading import RLock
from typing import Any

from mpmath import libmp

LARGEST = 64  # |x| up to which a series is summed: quotients of terms are below 1/2 by the 20th
LARGEST_EXPONENT = 1000  # largest exponent: e^1000 has more digits than the 200 of any certificate
# Bits beyond the unit to which exponentials are trusted: half of the 20 asked for.
TRUSTED_BITS = 10


class NotSeparated(Exception):  # noqa: N818  (no error: an answer)
    """Intervals could not decide a question; the text says which."""


class Context:
    """The unit 2^-bits, global in the process; :func:`unit` sets it for one computation."""

    bits = 160
    taken = RLock()


@contextmanager
def unit(bits: int) -> Iterator[None]:
    """Set the unit to 2^-bits inside a ``with`` statement; other threads wait."""
    with Context.taken:
        before, Context.bits = Context.bits, bits
        try:
            yield
        finally:
            Context.bits = before


class I:  # noqa: E742  (the name of intervals in the field)
    """A closed interval from a to b units."""

    __slots__ = ("a", "b")

    def __init__(self, a: int, b: int) -> None:
        self.a, self.b = a, b

    @classmethod
    def of(cls, x: Fraction | int, y: Fraction | int | None = None) -> I:
        """The narrowest interval that holds one or two rational numbers."""
        top, bits = x if y is None else y, Context.bits
        return cls(
            (x.numerator << bits) // x.denominator, -((-top.numerator << bits) // top.denominator)
        )

    @classmethod
    def pi(cls) -> I:
        """The number pi."""
        bits = Context.bits + 20
        return _own((libmp.mpf_pi(bits, "f"), libmp.mpf_pi(bits, "c")))  # floor and ceiling

    def __add__(self, other: I) -> I:
        if type(other) is not I:  # a function over a box adds itself
            return NotImplemented
        return I(self.a + other.a, self.b + other.b)

    def __sub__(self, other: I) -> I:
        return I(self.a - other.b, self.b - other.a)

    def __neg__(self) -> I:
        return I(-self.b, -self.a)

    def __mul__(self, other: I) -> I:
        if type(other) is not I:
            return NotImplemented
        a, b, c, d, bits = self.a, self.b, other.a, other.b, Context.bits
        if a >= 0 and c >= 0:
            return I(a * c >> bits, -(-b * d >> bits))
        p, q, r, s = a * c, a * d, b * c, b * d
        return I(min(p, q, r, s) >> bits, -(-max(p, q, r, s) >> bits))

    def __truediv__(self, other: I) -> I:
        if other.a <= 0 <= other.b:
            raise NotSeparated("a divisor may vanish")
        bits = Context.bits
        ends = [((x << bits), y) for x in (self.a, self.b) for y in (other.a, other.b)]
        return I(min(x // y for x, y in ends), max(-(-x // y) for x, y in ends))

    def power(self, n: int) -> I:
        """An integer power >= 0, sharp for even ones."""
        if n == 0:
            return I.of(1)
        found = self
        for _ in range(n - 1):
            found = found * self
        if n % 2 == 0 and self.a < 0 < self.b:
            return I(0, max(-found.a, found.b))
        return found

    def sqrt(self) -> I:
        """Square root of a positive interval."""
        bits = Context.bits
        return I(isqrt(self.a << bits), isqrt(self.b << bits) + 1)

    def cube_root(self) -> I:
        """Cube root; negative numbers count as zero."""
        if self.b <= 0:
            return I.of(0)
        bits, three = Context.bits + 20, (libmp.from_int(3), libmp.from_int(3))
        logarithm = libmp.mpi_log(I(max(self.a, 0), self.b)._foreign(), bits)
        return _exponential(libmp.mpi_div(logarithm, three, bits))

    def cos_sin(self) -> tuple[I, I]:
        """Cosine and sine."""
        c, s = libmp.mpi_cos_sin(self._foreign(), Context.bits + 20)
        return _own(c), _own(s)

    def exp(self) -> I:
        """Exponential; NotSeparated if its argument is large."""
        if not self.size.less(I.of(LARGEST_EXPONENT)):
            raise NotSeparated("a flight is too long")
        return _exponential(self._foreign())

    def _foreign(self) -> Any:
        bits = Context.bits
        return libmp.from_man_exp(self.a, -bits), libmp.from_man_exp(self.b, -bits)

    def sign(self) -> int | None:
        """The sign, 1 or -1; 0 for the number zero, None if it holds zero and other numbers."""
        if self.a > 0:
            return 1
        if self.b < 0:
            return -1
        return 0 if self.a == self.b else None

    def inside(self, other: I) -> bool:
        """Whether it lies in another interval."""
        return other.a <= self.a and self.b <= other.b

    def within(self, other: I) -> bool:
        """Whether it lies in the interior of another interval."""
        return other.a < self.a and self.b < other.b

    def meet(self, other: I) -> I:
        """The intersection of two intervals that hold the same number."""
        return I(max(self.a, other.a), min(self.b, other.b))

    def hull(self, other: I) -> I:
        """The smallest interval that holds both."""
        return I(min(self.a, other.a), max(self.b, other.b))

    @property
    def ends(self) -> tuple[Fraction, Fraction]:
        """Both ends, exactly."""
        return Fraction(self.a, 1 << Context.bits), Fraction(self.b, 1 << Context.bits)

    @property
    def low(self) -> I:
        """The lower end."""
        return I(self.a, self.a)

    @property
    def high(self) -> I:
        """The upper end."""
        return I(self.b, self.b)

    @property
    def mid(self) -> I:
        """The midpoint, rounded to a number inside."""
        middle = (self.a + self.b) >> 1
        return I(middle, middle)

    @property
    def size(self) -> I:
        """The largest modulus, as a number."""
        largest = max(-self.a, self.b)
        return I(largest, largest)

    @property
    def ball(self) -> I:
        """The interval from -size to size."""
        largest = max(-self.a, self.b)
        return I(-largest, largest)

    def less(self, other: I) -> bool:
        """Whether all of it lies below another interval."""
        return self.b < other.a

    def __float__(self) -> float:
        return float(Fraction(self.a + self.b, 2 ** (Context.bits + 1)))


def _own(pair: Any, part: Fraction = Fraction(0)) -> I:
    """An interval of mpmath, with both ends widened by a relative ``part``, rounded outwards."""
    ends = [libmp.to_rational(x) for x in pair]
    low, high = (Fraction(int(p), int(q)) for p, q in ends)
    return I.of(low - abs(low) * part, high + abs(high) * part)


def _exponential(pair: Any) -> I:
    # mpmath truncates the series 14 bits beyond the precision and rounds that, so e^(2^-bits) gets
    # the upper end 1 + 2^-bits, too low. It widens its cosines for this, but not its exponentials.
    bits = Context.bits
    return _own(libmp.mpi_exp(pair, bits + 20), Fraction(1, 1 << bits + TRUSTED_BITS))


class Box:
    """The box |s| <= radius, |tau| <= half; functions have ``terms`` in tau and ``depth`` parts."""

    def __init__(
        self, half: Fraction, terms: int, radius: Fraction = Fraction(0), depth: int = 1
    ) -> None:
        self.half, self.terms, self.s, self.depth = half, terms, I.of(radius).ball, depth


class T:
    """A Taylor model: coefficients of powers of tau / half and radius of the rest, in units."""

    __slots__ = ("_powers", "box", "c", "reach", "rest")

    def __init__(self, box: Box, c: Sequence[int], rest: int = 0) -> None:
        self.box, self.rest = box, rest
        if len(c) > box.terms:
            self.rest += sum(map(abs, c[box.terms :]))
        self.c = list(c[: box.terms])
        self.reach = sum(map(abs, self.c[1:]))
        self._powers: list[T] | None = None

    @classmethod
    def of(cls, box: Box, c: Sequence[Fraction]) -> T:
        """The Taylor model of a polynomial, from coefficients of powers of tau."""
        exact = [I.of(x * box.half**k) for k, x in enumerate(c)]  # of powers of tau / half
        return cls(box, [x.a for x in exact], sum(x.b - x.a for x in exact))

    @property
    def poly(self) -> I:
        """Range of the polynomial."""
        return I(self.c[0] - self.reach, self.c[0] + self.reach)

    @property
    def range(self) -> I:
        """Range of the function."""
        more = self.reach + self.rest
        return I(self.c[0] - more, self.c[0] + more)

    @property
    def first(self) -> I:
        """The constant coefficient, as an exact interval."""
        return I(self.c[0], self.c[0])

    def wider(self, more: I) -> T:
        """The function plus an unknown that is no larger than the size of an interval."""
        return T(self.box, self.c, self.rest + max(-more.a, more.b))

    def plus(self, x: I) -> T:
        """The function plus a number."""
        middle = (x.a + x.b) >> 1
        c = [self.c[0] + middle, *self.c[1:]]
        return T(self.box, c, self.rest + max(x.b - middle, middle - x.a))

    def __add__(self, other: T) -> T:
        longer, shorter = (self.c, other.c) if len(self.c) >= len(other.c) else (other.c, self.c)
        c = [x + y for x, y in zip(longer, shorter, strict=False)] + longer[len(shorter) :]
        return T(self.box, c, self.rest + other.rest)

    def __neg__(self) -> T:
        return T(self.box, [-x for x in self.c], self.rest)

    def __sub__(self, other: T) -> T:
        return self + (-other)

    def scaled(self, x: I) -> T:
        """The function times a number."""
        bits, middle = Context.bits, (x.a + x.b) >> 1
        wide = max(x.b - middle, middle - x.a)
        most = abs(self.c[0]) + self.reach
        rest = self.rest * (abs(middle) + wide) + most * wide
        return T(self.box, [middle * c >> bits for c in self.c], (rest >> bits) + 1 + len(self.c))

    def __mul__(self, other: T) -> T:
        a, b, n, bits = self.c, other.c, self.box.terms, Context.bits
        size = len(a) + len(b) - 1
        c = [0] * size
        for i, x in enumerate(a):
            if x:
                for j, y in enumerate(b):
                    c[i + j] += x * y
        rest = self.rest * (abs(b[0]) + other.reach + other.rest)
        rest += (abs(a[0]) + self.reach) * other.rest + sum(map(abs, c[n:]))
        return T(self.box, [x >> bits for x in c[:n]], (rest >> bits) + 1 + min(n, size))

    @property
    def powers(self) -> list[T]:
        """Powers 1, 2, .. of the polynomial without its constant term."""
        if self._powers is None:
            move = T(self.box, [0, *self.c[1:]])
            self._powers = [move]
            for _ in range(self.box.terms - 2):
                self._powers.append(self._powers[-1] * move)
        return self._powers


def through(f: T, taylor: Sequence[I], slope: I, last: I) -> T:
    """g(f), from the Taylor coefficients of g at f.first, and ranges of g' and g^(n)/n! over f."""
    n = f.box.terms
    found = T(f.box, [0]).plus(taylor[0])
    for k in range(1, n):
        found = found + f.powers[k - 1].scaled(taylor[k])
    reach = I(-f.reach, f.reach).power(n)
    return found.wider(last * reach).wider(slope * I(-f.rest, f.rest))


def inverse(f: T) -> T:
    """The Taylor model of 1 / f."""
    one = I.of(1)
    over, whole = one / f.first, one / f.range
    taylor, n = [over], f.box.terms
    for _ in range(n):
        taylor.append(-(taylor[-1] * over))
    last = (one / f.poly).power(n + 1)
    return through(f, taylor, -(whole * whole), last if n % 2 == 0 else -last)


def wave(kappa: I, t: I) -> list[I]:
    """Stumpff's functions s_0 .. s_5, s_k = t^k c_k(kappa t^2)."""
    # By series where these converge fast, else by s_(k+2) = (s_k - t^k/k!) / kappa, in the mean
    # value form about the middle of t.
    x = kappa * t.power(2)
    if x.size.less(I.of(1)):
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
        found.append((found[k] - t.power(k) * inverse_factorial(k)) / kappa)
    return found


def shapes(x: I, last: int) -> list[I]:
    """c_0 .. c_last, c_k(x) = 1/k! + x/(k+2)! + ...: the last two by series, the rest from them."""
    if not x.size.less(I.of(LARGEST)):
        raise NotSeparated("a flight is too long")
    found = [I.of(0)] * (last + 1)
    for k in range(max(last - 1, 0), last + 1):
        terms = _terms(x, k)
        after = inverse_factorial(k + 2 * terms)  # each further term is less than half the last,
        total = (after + after).ball  # so that twice the first bounds the sum of all
        for n in range(terms - 1, -1, -1):
            total = inverse_factorial(k + 2 * n) + x * total
        found[k] = total
    for k in range(last - 2, -1, -1):
        found[k] = inverse_factorial(k) + x * found[k + 2]
    return found


def _terms(x: I, k: int) -> int:
    """Number of terms of c_k's series: the next is below the unit, and quotients below 1/2."""
    size, n, term = float(x.size), 0, 1.0
    while term > 2.0**-Context.bits or (k + 2 * n + 1) * (k + 2 * n + 2) < 2.0 * size + 1.0:
        n += 1
        term *= (size + 1e-300) / ((k + 2 * n - 1) * (k + 2 * n))
    return n + 1


def inverse_factorial(n: int) -> I:
    """1 / n!."""
    return _inverse_factorial(n, Context.bits)


@lru_cache(maxsize=1000)
def _inverse_factorial(n: int, _bits: int) -> I:
    return I.of(Fraction(1, factorial(n)))
