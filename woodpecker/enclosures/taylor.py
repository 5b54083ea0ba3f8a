"""Taylor models: functions of the parameter as a polynomial plus a ball that holds the remainder.

On |p| <= half width, f(p) = c_0 + c_1 p + ... + c_(n-1) p^(n-1) + rest. Since coefficients are
thin, equal dependences on p cancel; only the remainder, of order p^n, accumulates [Makino2003].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import arb, arb_poly

from woodpecker.enclosures.balls import ZERO


@dataclass(frozen=True)
class Frame:
    """A box of starts and parameters, and how functions over it are expanded."""

    s: Any  # ball about zero: distance of the start from a curve
    p: Any  # ball about zero: distance of the parameter from its centre
    terms: int = 1  # coefficients of Taylor polynomials in p, at least one
    depth: int = 2  # parts of a form: 2 (value and f_s), 3 (f_p too) or 6 (second derivatives too)

    @cached_property
    def power(self) -> Any:
        """Range of p^terms."""
        return _power(self.p, self.terms)


def _power(p: Any, n: int) -> Any:
    """Range of p^n over a ball that holds zero."""
    return arb(0, (abs(p).upper() ** n).upper())


class Taylor:
    """A function over the interval of a frame: f(p) is in poly(p) + rest."""

    __slots__ = ("box", "frame", "head", "poly", "rest")

    def __init__(self, frame: Frame, poly: Any, rest: Any) -> None:
        self.frame, self.poly, self.rest = frame, poly, rest
        self.head = poly(frame.p) if frame.terms > 1 else poly[0]  # range of the polynomial
        self.box = self.head + rest  # range of the function

    def widened(self, ball: Any) -> Taylor:
        """The function plus an unknown quantity in a ball."""
        return Taylor(self.frame, self.poly, self.rest + ball)

    def __neg__(self) -> Taylor:
        return Taylor(self.frame, -self.poly, -self.rest)

    def __add__(self, other: Taylor) -> Taylor:
        return Taylor(self.frame, self.poly + other.poly, self.rest + other.rest)

    def __sub__(self, other: Taylor) -> Taylor:
        return Taylor(self.frame, self.poly - other.poly, self.rest - other.rest)

    def __mul__(self, other: Any) -> Taylor:
        frame = self.frame
        if not isinstance(other, Taylor):
            return Taylor(frame, self.poly * other, self.rest * other)
        rest = self.rest * other.box + self.head * other.rest
        return cut(frame, self.poly * other.poly, rest)

    __rmul__ = __mul__


def cut(frame: Frame, poly: Any, rest: Any) -> Taylor:
    """The Taylor model of polynomial + rest; terms beyond the frame's move into the rest."""
    n = frame.terms
    if poly.degree() >= n:
        rest = rest + poly.right_shift(n)(frame.p) * frame.power
        poly = poly.truncate(n)
    return Taylor(frame, poly, rest)


def constant(frame: Frame, value: Any) -> Taylor:
    """The Taylor model of a constant."""
    return Taylor(frame, arb_poly([value]), ZERO)


def composed(f: Taylor, thin: Sequence[Any], slope: Any, last: Any) -> Taylor:
    """The Taylor model of g(f).

    ``thin`` are the first n Taylor coefficients of g at the constant term of f; ``slope`` is the
    range of g' over that of f, and ``last`` that of g^(n) / n! over that of f's polynomial.
    """
    frame, n = f.frame, f.frame.terms
    if n == 1:
        return Taylor(frame, arb_poly([thin[0]]), f.rest * slope)
    move = f.poly - f.poly[0]
    reach = move(frame.p)  # it holds zero, as p does, which _power needs
    return cut(frame, arb_poly(list(thin[:n]))(move), last * _power(reach, n) + f.rest * slope)


def inverse(f: Taylor) -> Taylor:
    """The Taylor model of 1 / f, where f has no zero."""
    n = f.frame.terms
    over, wide, head = 1 / f.poly[0], 1 / f.box, 1 / f.head
    thin = [over]
    for _ in range(n - 1):
        thin.append(-thin[-1] * over)
    return composed(f, thin, -wide * wide, (-1) ** n * head ** (n + 1))


def thin(poly: Any, terms: int) -> Any:
    """The first terms of a polynomial, with midpoints as coefficients."""
    return arb_poly([c.mid() for c in poly.truncate(terms).coeffs()])
