"""Polynomials with integer coefficients, and their signs at roots of other ones.

Signs come from signed remainder sequences, by the theorems of Sturm and Tarski [BasuPollackRoy2006,
Section 2.2]. The work of each multiplication is charged before it is done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise, zip_longest
from math import gcd
from typing import NamedTuple, TypeVar

from pwmap.checking.refusing import BITS, MAX_COEFFICIENTS, STEP, Effort, brief, digits, refuse

Poly = tuple[int, ...]  # lowest degree first, the last coefficient is not zero
Quotient = tuple[Poly, Poly]
Kept = TypeVar("Kept")


def length(f: Sequence[int]) -> int:
    """The number of bits of the longest coefficient."""
    return max((c.bit_length() for c in f), default=0)


def multiplying(bits: int, more: int) -> int:
    """The approximate work of multiplying, or dividing, two integers of so many bits."""
    return 60 + (bits + more) // 16 + bits * more // 1000


def trimmed(coefficients: Sequence[int]) -> Poly:
    """The polynomial without leading zeros; refused if it is too large."""
    size = len(coefficients)
    while size and not coefficients[size - 1]:
        size -= 1
    if size > MAX_COEFFICIENTS or length(coefficients) > BITS:
        refuse("the polynomials that decide become too large to be checked")
    return tuple(coefficients[:size])


def plus(work: Effort, f: Poly, g: Poly, sign: int = 1) -> Poly:
    """The sum, or with ``sign`` -1 the difference, of two polynomials."""
    work.spend(STEP + (len(f) + len(g)) * multiplying(max(length(f), length(g)), 1))
    return trimmed([a + sign * b for a, b in zip_longest(f, g, fillvalue=0)])


def times(work: Effort, f: Poly, g: Poly) -> Poly:
    """The product of two polynomials."""
    work.spend(STEP + len(f) * len(g) * 2 * multiplying(length(f), length(g)))
    found = [0] * (len(f) + len(g))
    for i, a in enumerate(f):
        for k, b in enumerate(g):
            found[i + k] += a * b
    return trimmed(found)


def power(work: Effort, f: Poly, n: int) -> Poly:
    """The n-th power of a polynomial; lower powers are kept."""
    powers: list[Poly] = known(work, ("powers", f), lambda: [(1,)])
    while len(powers) <= n:
        powers.append(times(work, powers[-1], f))
        work.keep(powers[-1])
    return powers[n]


def known(work: Effort, key: tuple[str, *tuple[Poly, ...]], compute: Callable[[], Kept]) -> Kept:
    """A value for a key, computed once and then kept."""
    work.spend(STEP + sum(len(f) * (60 + length(f) // 16) for f in key[1:]))  # for the lookup
    if key not in work.known:
        found = compute()
        work.keep(*key[1:])
        work.known[key] = found
    return work.known[key]  # type: ignore[no-any-return]


def derivative(f: Poly) -> Poly:
    """The derivative of a polynomial."""
    return tuple(n * c for n, c in enumerate(f))[1:]


def primitive(work: Effort, f: Sequence[int]) -> Poly:
    """A polynomial divided by the greatest common divisor of its coefficients."""
    bits = length(f)
    work.spend(STEP + len(f) * (multiplying(bits, bits) + bits * bits // 500))
    common = gcd(*f) or 1
    return trimmed([c // common for c in f])


def divided(work: Effort, f: Poly, g: Poly) -> tuple[Poly, Poly]:
    """Positive multiples of the quotient and of the remainder of f by g."""
    rest, quotient = list(f), [0] * len(f)
    lead, scale = (1 if g[-1] > 0 else -1), abs(g[-1])
    while len(rest) >= len(g):
        bits = max(length(rest), length(quotient))
        work.spend(STEP + 3 * len(f) * multiplying(bits, length(g)))
        factor, shift = lead * rest[-1], len(rest) - len(g)
        rest, quotient = [scale * c for c in rest], [scale * c for c in quotient]
        quotient[shift] += factor
        for i, c in enumerate(g):
            rest[shift + i] -= factor * c
        rest = list(trimmed(rest))
        trimmed(quotient)
    return primitive(work, quotient), primitive(work, rest)


def sign_of(number: Fraction | int) -> int:
    """The sign of a number: -1, 0 or 1."""
    return (number > 0) - (number < 0)


def sign_near(work: Effort, f: Poly, x: Fraction) -> int:
    """The sign of a polynomial at a rational number."""
    bits = max(length((x.numerator,)), length((x.denominator,)))
    most = length(f) + len(f) * bits  # bits of the value after the last step
    steps = 2 * multiplying(most, bits) + multiplying(length(f), len(f) * bits)
    work.spend(STEP + len(f) * steps)
    value, scale = 0, 1
    for c in reversed(f):
        value = value * x.numerator + c * scale
        scale *= x.denominator
    return sign_of(value)


def chain(work: Effort, f: Poly, g: Poly) -> tuple[Poly, ...]:
    """The signed remainder sequence of two polynomials, up to positive factors."""

    def compute() -> tuple[Poly, ...]:
        found = [f, g]
        while found[-1]:
            rest = divided(work, found[-2], found[-1])[1]
            found.append(tuple(-c for c in rest))
            work.keep(rest)
        return tuple(found[:-1])

    return known(work, ("chain", f, g), compute)


def sturm(work: Effort, f: Poly) -> tuple[Poly, ...]:
    """Sturm's sequence of a polynomial, reduced to simple roots."""

    def compute() -> tuple[Poly, ...]:
        simple = divided(work, f, chain(work, f, derivative(f))[-1])[0]
        return chain(work, simple, derivative(simple))

    return known(work, ("sturm", f), compute)


def changes(signs: Iterable[int]) -> int:
    """The number of sign changes in a sequence, zeros left out."""
    return sum(one != other for one, other in pairwise(filter(None, signs)))


def query(work: Effort, f: Poly, g: Poly, low: Fraction, high: Fraction) -> int:
    """Tarski's query: the sum of the signs of g at the roots of f between two non-roots of f."""
    sequence = chain(work, f, times(work, derivative(f), g))
    ends = [changes(sign_near(work, h, x) for h in sequence) for x in (low, high)]
    return ends[0] - ends[1]


def text(poly: Sequence[Fraction | int], symbol: str) -> str:
    """A polynomial in a symbol as text, lowest power first."""
    terms = []
    for n, c in enumerate(poly):
        factors = [digits(max(c, -c))] * (abs(c) != 1 or n == 0)
        factors += [symbol if n == 1 else f"{symbol}^{n}"] * (n > 0)
        terms += [("- " if c < 0 else "+ ") + " ".join(factors)] * (c != 0)
    found = " ".join(terms)
    return found[2:] if found.startswith("+") else found.replace("- ", "-", 1) or "0"


# --- Where signs are taken: at a number, or on an open interval -----------------------------------


class Number(NamedTuple):
    """A rational number, or the only root of a polynomial in an open interval."""

    poly: Poly
    low: Fraction
    high: Fraction

    @property
    def is_root(self) -> bool:
        """Whether it is given as a root, inside of an interval."""
        return self.low < self.high

    def sign(self, work: Effort, f: Poly) -> int:
        """The sign of a polynomial at the number."""
        if not self.is_root or len(f) < 2:
            return sign_near(work, f, self.low)
        return query(work, self.poly, f, self.low, self.high)

    def __str__(self) -> str:
        return self._said(str)

    @property
    def brief(self) -> str:
        """The number as text, cut where it is long, for refusals."""
        return self._said(brief)

    def _said(self, shown: Callable[[str], str]) -> str:
        low, high = shown(str(self.low)), shown(str(self.high))
        if not self.is_root:
            return low
        return f"the root of {shown(text(self.poly, 't'))} between {low} and {high}"


def between(low: Number, high: Number) -> Fraction:
    """A rational strictly between two numbers; refused if their intervals do not separate them."""
    middle = (low.high + high.low) / 2
    after = low.high < middle or (low.is_root and low.high == middle)  # a root lies below its high
    before = middle < high.low or (high.is_root and high.low == middle)
    if not (after and before):
        both = f"{low.brief} and {high.brief}"
        refuse(f"edges must ascend, with intervals that part them, got {both}")
    return middle


class Place:
    """One value of the parameter, or an open interval; no polynomial asked for has a root in it."""

    def __init__(self, low: Number, high: Number, work: Effort) -> None:
        self.low, self.high = low, high
        self.is_edge = low is high
        self.sample = low.low if self.is_edge else between(low, high)
        self.work = work
        self.signs: dict[Poly, int] = {}  # of all polynomials queried so far

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial at the edge, or on the whole open interval."""
        self.work.spend(STEP + len(f) * (60 + length(f) // 16))  # for the lookup
        if f not in self.signs:
            found = self._sign(primitive(self.work, f))
            self.work.keep(f)
            self.signs[f] = found
        return self.signs[f]

    def _sign(self, f: Poly) -> int:
        if len(f) < 2:
            return sign_near(self.work, f, self.sample)
        if self.is_edge:
            return self.low.sign(self.work, f)
        if self._roots(f):
            where = f"between the edges {self.low.brief} and {self.high.brief}"
            refuse(f"{brief(text(f, 'p'))} has a root {where}")
        return sign_near(self.work, f, self.sample)

    def _roots(self, f: Poly) -> int:
        """The number of distinct roots of a polynomial in the open interval."""
        work, (low, high) = self.work, (self.low, self.high)
        sequence = sturm(work, f)
        outer = [changes(sign_near(work, h, x) for h in sequence) for x in (low.low, high.high)]
        if outer[0] == outer[1]:
            return 0
        ends = [changes(end.sign(work, h) for h in sequence) for end in (low, high)]
        return ends[0] - ends[1] - (high.sign(work, f) == 0)
