"""What the package says, read anew: formulas as polynomials, branches from their exact values."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import sympy
from independent import Number, Poly, Root, trimmed, value

from pwmap import Branch, BranchKind
from pwmap.diagrams import Stretch

P = sympy.Symbol("p")
DIGITS = 60  # of algebraic numbers that are only compared
Place = Fraction | Root  # a value of the parameter

_ROOTS: dict[tuple[Poly, int], Root] = {}  # so that equal roots are one object


@cache
def place(expr: sympy.Expr) -> Place:
    """A real number as a rational or as the one root of its kind."""
    if expr.is_Rational:
        return Fraction(int(expr.p), int(expr.q))
    t = sympy.Symbol("t")
    poly = sympy.Poly(sympy.minimal_polynomial(expr, t), t)
    near, width = rational(sympy.N(expr, DIGITS)), Fraction(1, 10 ** (DIGITS - 20))
    low, high = near - width, near + width
    ends = [sympy.Rational(end.numerator, end.denominator) for end in (low, high)]
    assert poly.count_roots(*ends) == 1
    coefficients = coefficients_of(poly)
    key = (coefficients, poly.count_roots(None, ends[0]))
    return _ROOTS.setdefault(key, Root(coefficients, low, high))


def rational(number: sympy.Number) -> Fraction:
    """A rational or a decimal number as the fraction it is."""
    exact = sympy.Rational(number)
    return Fraction(int(exact.p), int(exact.q))


def coefficients_of(poly: sympy.Poly) -> Poly:
    """From the constant term up."""
    return trimmed([Fraction(int(c.p), int(c.q)) for c in reversed(poly.all_coeffs())])


def compared(a: Place, b: Place) -> int:
    """-1, 0 or 1 as for numbers."""
    if isinstance(a, Root):
        return a.compared(b)
    return -b.compared(a) if isinstance(b, Root) else (a > b) - (a < b)


def number_of(p: Place) -> Number:
    """A place as a number to calculate with."""
    return p.number if isinstance(p, Root) else p


@cache
def quotient(expr: sympy.Expr) -> tuple[Poly, Poly] | None:
    """Numerator and denominator in lowest terms; None for nan and infinity."""
    if expr in (sympy.nan, sympy.oo, -sympy.oo):
        return None
    top, bottom = sympy.fraction(sympy.cancel(expr))
    return coefficients_of(sympy.Poly(top, P)), coefficients_of(sympy.Poly(bottom, P))


def evaluated(expr: Any, p: Number) -> Number:
    """A formula at a parameter that is no pole of it; None for nan and infinity."""
    parts = quotient(expr)
    if parts is None:
        return None
    top, bottom = parts
    return value(top, p) / value(bottom, p)


def closed_set(interval: sympy.Set) -> tuple[Place, bool, Place, bool]:
    """Ends of an interval, and which of them belong to it."""
    if isinstance(interval, sympy.FiniteSet):
        (only,) = interval.args
        return place(only), True, place(only), True
    return (
        place(interval.start),
        not interval.left_open,
        place(interval.end),
        not interval.right_open,
    )


@dataclass(frozen=True, eq=False)
class Curve:
    """A branch as far as its formulas hold, from its exact values only."""

    branch: Branch
    stretch: Stretch
    lo: Place
    lo_in: bool
    hi: Place
    hi_in: bool

    @classmethod
    def of(cls, branch: Branch) -> list[Curve]:
        """Those of all its stretches, one after the other."""
        return [
            cls(branch, stretch, *closed_set(stretch.exact["interval"]))  # type: ignore[arg-type]
            for stretch in branch.words
        ]

    def __str__(self) -> str:
        exact = self.stretch.exact
        order = f"order {self.branch.order}, {self.word}"
        return f"{self.branch.id} ({order}, x = {exact.get('x')}, {exact['interval']})"

    @property
    def word(self) -> str:
        """Of the stretch."""
        return self.stretch.word

    @property
    def is_upright(self) -> bool:
        """Whether it is a band along one value of the parameter."""
        return "x" not in self.stretch.exact

    @property
    def is_fixed(self) -> bool:
        """Whether it is made of fixed points."""
        return self.branch.kind is BranchKind.FIXED_POINT

    @property
    def key(self) -> tuple[int, str]:
        """Order and word."""
        return self.branch.order, self.word

    def holds(self, p: Place) -> bool:
        """Whether the branch exists there."""
        low, high = compared(self.lo, p), compared(p, self.hi)
        return (low < 0 or (low == 0 and self.lo_in)) and (high < 0 or (high == 0 and self.hi_in))

    def passes(self, p: Place) -> bool:
        """Whether it lies on both sides of a parameter."""
        return compared(self.lo, p) < 0 < compared(self.hi, p)

    def x(self, p: Number) -> Number:
        """Its position."""
        return evaluated(self.stretch.exact["x"], p)

    def multiplier(self, p: Number) -> Number:
        """Its multiplier; None if it is nan."""
        return evaluated(self.stretch.exact["multiplier"], p)

    def stable(self, p: Number) -> bool:
        """Whether it attracts."""
        if self.branch.attracts is not None:
            return self.branch.attracts
        m = self.multiplier(p)
        return m is not None and -1 < m < 1

    def limit(self, end: int) -> Number:
        """x at an end; a float if it is infinite."""
        p = number_of((self.lo, self.hi)[end])
        top, bottom = quotient(self.stretch.exact["x"])  # type: ignore[misc]
        if value(bottom, p) != 0:
            return value(top, p) / value(bottom, p)
        beside = between(self.lo, self.hi)
        for _ in range(200):  # until the sign is that of the limit
            beside = between(self.lo, beside) if end == 0 else between(beside, self.hi)
        return float("inf") if value(top, beside) / value(bottom, beside) > 0 else -float("inf")


def between(a: Place, b: Place) -> Fraction:
    """A rational between two places."""
    assert compared(a, b) < 0
    while True:
        low = a.high if isinstance(a, Root) else a
        high = b.low if isinstance(b, Root) else b
        if low < high:
            return (low + high) / 2
        for end in (a, b):
            if isinstance(end, Root):
                end.refine()


def near(x: Number, expr: Any) -> bool:
    """Whether a number and a real expression are the same, as far as many digits can tell."""
    if x is None or isinstance(x, float) or not expr.is_finite:
        return isinstance(x, float) and x == float(expr)
    if isinstance(x, Fraction) and expr.is_Rational:
        return bool(x == Fraction(int(expr.p), int(expr.q)))
    other, small = rational(sympy.N(expr, DIGITS)), Fraction(1, 10 ** (DIGITS // 2))
    return bool(-small < x - other < small)


def rational_near(root: Root) -> Fraction:
    """A rational that is no farther from a root than 10^-50."""
    while root.high - root.low > Fraction(1, 10**50):
        root.refine()
    return root.low
