"""Balls of Arb [Johansson2017] from rational numbers, and back."""

from __future__ import annotations

from fractions import Fraction
from functools import reduce
from operator import add
from typing import Any

from flint import arb, fmpq

ZERO = arb(0)
DIGITS = 30  # decimals of the numbers that describe a tube


def ball(x: Any) -> Any:
    """The ball of a rational of flint or a whole number; anything else unchanged."""
    return arb(x) if isinstance(x, fmpq | int) else x


def number(x: Fraction) -> Any:
    """The ball of a rational number."""
    return arb(fmpq(x.numerator, x.denominator))


def fraction(exact: Any) -> Fraction:
    """The rational number that a ball without radius is."""
    mantissa, exponent = exact.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def rounded(x: Fraction, digits: int) -> Fraction:
    """A rational number, rounded to decimals."""
    return Fraction(round(x * 10**digits), 10**digits)


def decimal(x: Any, digits: int = DIGITS) -> Fraction:
    """The middle of a ball, rounded to decimals."""
    return rounded(fraction(x.mid()), digits)


def sum_of(terms: Any) -> Any:
    """The sum of at least one term."""
    return reduce(add, terms)
