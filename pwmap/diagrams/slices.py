"""An exact diagram at one value of its parameter, by substitution in its formulas.

At an algebraic value numbers are elements of its field and are compared by exact signs.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import sympy
from sympy import QQ

from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import HIGHEST, LOWEST, to_float
from pwmap.algebra.numbers import Element, Exact, exact_to_sympy
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    algebraic,
    dense_of,
    real_to_sympy,
)


class ExactValue(NamedTuple):
    """A formula at one value of the parameter."""

    formula: sympy.Expr  # exact, or in parameters that stay symbolic
    exact: Exact  # at their sample; nan if it is none
    number: float  # the same as a float


_ENDS = {sympy.oo: HIGHEST, -sympy.oo: LOWEST}


@dataclass(frozen=True, slots=True)
class ExactSlice:
    """One value of the parameter."""

    name: str
    at: Real
    sample: Mapping[str, sympy.Expr]  # of parameters that stay symbolic

    def overlaps(self, interval: sympy.Set, most: Real) -> bool:
        """Whether an interval of the parameter holds a value from this one up to another."""
        if isinstance(interval, sympy.FiniteSet):
            ends = [self._end(end) for end in interval]
            return any(not (end < self.at or most < end) for end in ends)
        low, high = self._end(interval.start), self._end(interval.end)
        begins = low < most or (low == most and not interval.left_open)
        goes_on = self.at < high or (high == self.at and not interval.right_open)
        return bool(begins and goes_on)

    def _end(self, end: sympy.Expr) -> Real:
        return _ENDS[end] if end.is_infinite else algebraic(self._sampled(end))

    def _sampled(self, expr: sympy.Expr) -> sympy.Expr:
        values = {s: self.sample[s.name] for s in expr.free_symbols if s.name in self.sample}
        return expr.xreplace(values) if values else expr

    def value(self, expr: sympy.Expr) -> ExactValue:
        """A formula in the parameter at this value."""
        if expr.is_infinite or expr is sympy.nan:
            return ExactValue(expr, _ENDS.get(expr, expr), float(expr))
        own = next((s for s in expr.free_symbols if s.name == self.name), None)
        drawn = self._sampled(expr)
        if not isinstance(self.at, RealRoot) or own is None:
            point = {own: real_to_sympy(self.at)} if own is not None else {}
            exact = algebraic(drawn.xreplace(point))
            return ExactValue(expr.xreplace(point), exact, to_float(exact))
        top, bottom = quotient_in(drawn, own)
        exact = Element(self.at, self.at.quotient(top, bottom))
        formula = (
            exact_to_sympy(exact) if drawn == expr else expr.xreplace({own: self.at.to_sympy()})
        )
        return ExactValue(formula, exact, self.at.to_float(top, bottom))


def end_of(value: Any) -> Real:
    """The exact number of an end of an interval, which may be infinite."""
    if isinstance(value, numbers.Real | sympy.Expr) and value in (math.inf, -math.inf):
        return LOWEST if value == -math.inf else HIGHEST
    return exact_number(value)


def exact_number(value: object) -> Real:
    """The exact number of a parameter's value; a float is the binary number it holds.

    ValueError if it is no finite real number; TypeError if it is neither a number nor text.
    """
    if isinstance(value, numbers.Real) and not isinstance(value, numbers.Rational | sympy.Basic):
        if not math.isfinite(value):
            raise ValueError(f"a slice needs a finite value of the parameter, got {value}")
        return QQ(*float(value).as_integer_ratio())
    if isinstance(value, sympy.Float):
        value = sympy.Rational(value)
    if isinstance(value, str | numbers.Rational) and not isinstance(value, sympy.Basic):
        return rational(value)
    if not isinstance(value, sympy.Basic):
        raise TypeError(f"a slice needs a number, got {value!r}")
    if not (isinstance(value, sympy.Expr) and value.is_number and value.is_real):
        raise ValueError(f"a slice needs a real number, got {value}")
    try:
        return algebraic(value)
    except ValueError:
        raise ValueError(f"a slice needs a rational or algebraic number, got {value}") from None


@lru_cache(maxsize=4096)
def quotient_in(expr: sympy.Expr, symbol: sympy.Symbol) -> tuple[Dense, Dense]:
    """Coefficients of numerator and denominator of a formula in one symbol."""
    top, bottom = sympy.fraction(sympy.together(expr))
    return dense_of(sympy.Poly(top, symbol)), dense_of(sympy.Poly(bottom, symbol))
