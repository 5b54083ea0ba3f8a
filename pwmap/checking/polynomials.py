"""Polynomials with integer coefficients, and the signs that they have at roots of others.

All signs come from sequences of signed remainders: Sturm's theorem, and that of Tarski on the signs
of one polynomial at the roots of another [BasuPollackRoy2006, Section 2.2].
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise, zip_longest
from math import gcd

from pwmap.checking.refusing import BITS, DEGREE, digits, refuse

Poly = tuple[int, ...]  # lowest degree first, the last coefficient is not zero
Quotient = tuple[Poly, Poly]


def trimmed(coefficients: Sequence[int]) -> Poly:
    """Drop leading zeros; refuse what is too large to work with."""
    size = len(coefficients)
    while size and not coefficients[size - 1]:
        size -= 1
    if size > DEGREE or any(c.bit_length() > BITS for c in coefficients):
        refuse("the polynomials that decide become too large to be checked")
    return tuple(coefficients[:size])


def plus(f: Poly, g: Poly, sign: int = 1) -> Poly:
    """The sum, or the difference, of two polynomials."""
    return trimmed([a + sign * b for a, b in zip_longest(f, g, fillvalue=0)])


def times(f: Poly, g: Poly) -> Poly:
    """The product of two polynomials."""
    found = [0] * (len(f) + len(g))
    for i, a in enumerate(f):
        for k, b in enumerate(g):
            found[i + k] += a * b
    return trimmed(found)


@lru_cache(maxsize=4096)
def power(f: Poly, n: int) -> Poly:
    """The n-th power."""
    return times(power(f, n - 1), f) if n else (1,)


def derivative(f: Poly) -> Poly:
    """The derivative."""
    return tuple(n * c for n, c in enumerate(f))[1:]


def primitive(f: Sequence[int]) -> Poly:
    """A polynomial divided by the greatest common divisor of its coefficients."""
    common = gcd(*f) or 1
    return trimmed([c // common for c in f])


def divided(f: Poly, g: Poly) -> tuple[Poly, Poly]:
    """Positive multiples of the quotient and of the remainder of f by g."""
    rest, quotient = list(f), [0] * len(f)
    lead, scale = (1 if g[-1] > 0 else -1), abs(g[-1])
    while len(rest) >= len(g):
        factor, shift = lead * rest[-1], len(rest) - len(g)
        rest, quotient = [scale * c for c in rest], [scale * c for c in quotient]
        quotient[shift] += factor
        for i, c in enumerate(g):
            rest[shift + i] -= factor * c
        rest = list(trimmed(rest))
    return primitive(quotient), primitive(rest)


def sign_of(number: Fraction | int) -> int:
    """-1, 0 or 1."""
    return (number > 0) - (number < 0)


def sign_near(f: Poly, x: Fraction) -> int:
    """The sign of a polynomial at a rational number."""
    value, scale = 0, 1
    for c in reversed(f):
        value = value * x.numerator + c * scale
        scale *= x.denominator
    return sign_of(value)


@lru_cache(maxsize=4096)
def chain(f: Poly, g: Poly) -> tuple[Poly, ...]:
    """The sequence of signed remainders of two polynomials, up to positive factors."""
    found = [f, g]
    while found[-1]:
        rest = divided(found[-2], found[-1])[1]
        found.append(tuple(-c for c in rest))
    return tuple(found[:-1])


@lru_cache(maxsize=4096)
def sturm(f: Poly) -> tuple[Poly, ...]:
    """Sturm's sequence of the polynomial that has each root of another one once."""
    simple = divided(f, chain(f, derivative(f))[-1])[0]
    return chain(simple, derivative(simple))


def changes(signs: Iterable[int]) -> int:
    """How often the sign changes along a sequence, zeros left out."""
    return sum(one != other for one, other in pairwise(filter(None, signs)))


def query(f: Poly, g: Poly, low: Fraction, high: Fraction) -> int:
    """The sum of the signs of g at the roots of f between two numbers that are no roots of f."""
    sequence = chain(f, times(derivative(f), g))
    ends = [changes(sign_near(h, x) for h in sequence) for x in (low, high)]
    return ends[0] - ends[1]


def text(poly: Sequence[Fraction | int], symbol: str) -> str:
    """A polynomial as text."""
    terms = []
    for n, c in enumerate(poly):
        factors = [digits(max(c, -c))] * (abs(c) != 1 or n == 0)
        factors += [symbol if n == 1 else f"{symbol}^{n}"] * (n > 0)
        terms += [("- " if c < 0 else "+ ") + " ".join(factors)] * (c != 0)
    found = " ".join(terms)
    return found[2:] if found.startswith("+") else found.replace("- ", "-", 1) or "0"
