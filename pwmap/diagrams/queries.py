"""Queries of a diagram: branches at a parameter, beside a point, on a path, stable intervals.

An exact diagram is evaluated at one value of its parameter by substitution into its formulas. At an
algebraic value the results are elements of its number field and are compared by exact signs.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from sympy import QQ

from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import HIGHEST, LOWEST
from pwmap.algebra.numbers import Element, Exact, to_double
from pwmap.algebra.roots import Dense, Real, RealRoot, algebraic, dense_of, real_to_sympy
from pwmap.diagrams.data import (
    Branch,
    BranchKind,
    Hit,
    PointKind,
    SpecialPoint,
    StableInterval,
    Stretch,
    runs_of,
    stable_inside,
)

_ENDS = {sympy.oo: HIGHEST, -sympy.oo: LOWEST}


@dataclass(frozen=True, slots=True)
class ExactSlice:
    """One value of the parameter, at which formulas are evaluated."""

    name: str
    at: Real
    sample: Mapping[str, sympy.Expr]  # of parameters that stay symbolic

    def overlaps(self, interval: sympy.Set, most: Real) -> bool:
        """Whether an interval of the parameter has a value from this one up to ``most``."""
        if isinstance(interval, sympy.FiniteSet):
            ends = [self._end(end) for end in interval]
            return any(not (end < self.at or most < end) for end in ends)
        low, high = self._end(interval.start), self._end(interval.end)
        begins = low < most or (low == most and not interval.left_open)
        goes_on = self.at < high or (high == self.at and not interval.right_open)
        return bool(begins and goes_on)

    def _end(self, end: sympy.Expr) -> Real:
        return _ENDS[end] if end in _ENDS else algebraic(self._sampled(end))

    def _sampled(self, expr: sympy.Expr) -> sympy.Expr:
        values = {s: self.sample[s.name] for s in expr.free_symbols if s.name in self.sample}
        return expr.xreplace(values) if values else expr

    def value(self, expr: sympy.Expr) -> tuple[sympy.Expr, Exact]:
        """A formula at this value of the parameter: an expression, and its number at the sample."""
        if expr.is_infinite or expr is sympy.nan:
            return expr, _ENDS.get(expr, math.nan)
        own = next((s for s in expr.free_symbols if s.name == self.name), None)
        drawn = self._sampled(expr)
        if not isinstance(self.at, RealRoot) or own is None:
            point = {own: real_to_sympy(self.at)} if own is not None else {}
            return expr.xreplace(point), algebraic(drawn.xreplace(point))
        exact = Element(self.at, self.at.quotient(*quotient_in(drawn, own)))
        if drawn == expr:
            return real_to_sympy(exact), exact
        return expr.xreplace({own: self.at.to_sympy()}), exact


def end_of(value: Any) -> Real:
    """An end of an interval as an exact number, which may be infinite."""
    if isinstance(value, numbers.Real | sympy.Expr) and value in (math.inf, -math.inf):
        return LOWEST if value == -math.inf else HIGHEST
    if isinstance(value, str) and value.strip() in ("oo", "-oo"):
        return LOWEST if value.strip() == "-oo" else HIGHEST
    return exact_number(value)


def exact_number(value: object) -> Real:
    """A value of the parameter as an exact number; a float is the binary number it holds.

    ValueError unless it is a finite, real, algebraic number; TypeError if neither number nor text.
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


def hits(
    branches: Sequence[Branch], name: str, parameter: object, sample: Mapping[str, Any]
) -> tuple[Hit, ...]:
    """The points of branches at a value of the parameter, in order of x."""
    exact = exact_number(parameter)
    if any("interval" in branch.exact for branch in branches):
        return _exact_hits(branches, ExactSlice(name, exact, sample))
    found = [hit for branch in branches for hit in _between_samples(branch, to_double(exact))]
    return tuple(sorted(found, key=lambda hit: hit.x))


def exists_within(
    branch: Branch, low: Real, high: Real, name: str, sample: Mapping[str, Any]
) -> bool:
    """Whether a branch exists somewhere between two values of the parameter, or at one."""
    if "interval" not in branch.exact:
        ends = branch.parameter.min(), branch.parameter.max()
        return bool(ends[0] <= to_double(high) and to_double(low) <= ends[1])
    here = ExactSlice(name, low, sample)
    intervals = (s.exact["interval"] for s in branch.words if "interval" in s.exact)
    return any(here.overlaps(interval, high) for interval in intervals)


def _exact_hits(branches: Sequence[Branch], here: ExactSlice) -> tuple[Hit, ...]:
    found: list[tuple[Exact, Hit]] = []
    for branch in branches:
        for formulas in (stretch.exact for stretch in branch.words):
            if "interval" in formulas and here.overlaps(formulas["interval"], here.at):
                found += _hits_of(branch, formulas, here)
    return tuple(hit for _, hit in sorted(found, key=lambda each: each[0]))


def _hits_of(
    branch: Branch, formulas: Mapping[str, object], here: ExactSlice
) -> Iterator[tuple[Exact, Hit]]:
    """The points of a branch with some formulas at a parameter; of a band, both of its ends."""
    names = [n for n in formulas if n not in ("interval", "lower", "upper", "x")]
    values = {name: here.value(formulas[name]) for name in names}
    exact = {name: formula for name, (formula, _) in values.items()}
    multiplier = to_double(values["multiplier"][1]) if "multiplier" in values else math.nan
    for name in ("lower", "upper") if "x" not in formulas else ("x",):
        x, number = here.value(formulas[name])
        yield number, Hit(branch, to_double(number), multiplier, {"x": x, **exact})


def _between_samples(branch: Branch, at: float) -> Iterator[Hit]:
    """The points at which straight lines between the samples of a branch meet a parameter."""
    p = branch.parameter
    for run in runs_of(p == at):
        # a run of samples at this value counts with its first and its last
        for i in sorted(set(run)):
            yield Hit(branch, float(branch.x[i]), float(branch.multiplier[i]))
    sides = np.sign(p - at)
    for i in np.flatnonzero(sides[:-1] * sides[1:] < 0.0).tolist():
        s = (at - p[i]) / (p[i + 1] - p[i])
        x, m = (
            float((1.0 - s) * values[i] + s * values[i + 1])
            for values in (branch.x, branch.multiplier)
        )
        yield Hit(branch, x, m)


def sides_of(
    point: SpecialPoint, incident: Iterable[Branch]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Ids of the branches that end at a point, those at smaller and those at larger parameters."""
    found: dict[int, list[str]] = {-1: [], 0: [], 1: []}
    for branch in incident:
        for end, side in zip(branch.ends, _sides_of_ends(branch, point), strict=True):
            if end == point.id:
                found[side].append(branch.id)
    return tuple(found[-1]), tuple(found[1])


def _sides_of_ends(branch: Branch, point: SpecialPoint) -> tuple[int, int]:
    """For each end at a point, whether the branch lies at smaller (-1) or larger (1) parameters."""
    if "interval" in branch.exact:
        return _side(branch.words[0], point), _side(branch.words[-1], point)
    away = branch.parameter - point.parameter
    known = point.precision if math.isfinite(point.precision) else 0.0
    away = away[np.abs(away) > known]  # at one parameter a branch lies on neither side
    return (int(np.sign(away[0])), int(np.sign(away[-1]))) if len(away) else (0, 0)


def _side(stretch: Stretch, point: SpecialPoint) -> int:
    """Whether an exact stretch lies at smaller (-1) or larger (1) parameters than an end of it."""
    interval: Any = stretch.exact["interval"]
    if not hasattr(interval, "left_open"):  # a set of one value
        return 0
    return 1 if interval.start == point.exact["parameter"] else -1


def collision_near(
    place: tuple[float, float],
    within: float,
    branches: Sequence[Branch],
    points: Sequence[SpecialPoint],
) -> SpecialPoint | None:
    """The nearest border collision of the lowest order; distances are relative to the extent."""
    ends = ([branch.parameter for branch in branches], [branch.x for branch in branches])
    sizes = [float(np.ptp(np.concatenate(values))) or 1.0 for values in ends if values]

    def away(point: SpecialPoint) -> float:
        gaps = (point.parameter - place[0], point.x - place[1])
        return max(abs(gap) / size for gap, size in zip(gaps, sizes, strict=True))

    kinds = (PointKind.BC, PointKind.FF)
    near = [point for point in points if point.kind in kinds and away(point) <= within]
    return min(near, key=lambda point: (point.order, away(point)), default=None)


def stable_intervals(branches: Iterable[Branch], order: int | None) -> Iterator[StableInterval]:
    """Intervals of the parameter in which fixed points attract, of one iterate or of all."""
    for branch in branches:
        if branch.kind is BranchKind.FIXED_POINT and order in (None, branch.order):
            for first, last in runs_of(stable_inside(branch)):
                p = branch.parameter[first : last + 1]
                yield StableInterval(branch, float(p.min()), float(p.max()))
