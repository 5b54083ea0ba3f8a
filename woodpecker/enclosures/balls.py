"""Conversions between balls of Arb [Johansson2017] and rational numbers."""

from __future__ import annotations

from fractions import Fraction
from functools import reduce
from operator import add
from typing import Any

from flint import arb, fmpq

ZERO = arb(0)
DIGITS = 30  # decimals of the coefficients of a tube's curve


def ball(x: Any) -> Any:
    """The ball of a rational number of flint or an integer; anything else is returned unchanged."""
    return arb(x) if isinstance(x, fmpq | int) else x


def number(x: Fraction) -> Any:
    """The ball of a rational number."""
    return arb(fmpq(x.numerator, x.denominator))


def fraction(exact: Any) -> Fraction:
    """The value of an exact ball (of radius zero) as a rational number."""
    mantissa, exponent = exact.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def rounded(x: Fraction, digits: int) -> Fraction:
    """A rational number rounded to so many decimals."""
    return Fraction(round(x * 10**digits), 10**digits)


def decimal(x: Any, digits: int = DIGITS) -> Fraction:
    """The midpoint of a ball rounded to so many decimals."""
    return rounded(fraction(x.mid()), digits)


def sum_of(terms: Any) -> Any:
    """The sum of one or more terms; unlike ``sum`` it needs no zero."""
    return reduce(add, terms)
