"""Checks that the exact values of a loaded diagram are such as its queries can evaluate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

import sympy

from pwmap.algebra.arguments import shown
from pwmap.algebra.rootfunctions import RealRootOf
from pwmap.diagrams.data import Branch, SpecialPoint

INTERVAL = "interval"  # the entry with the parameters at which a stretch exists
PLACES = {"x"}, {"lower", "upper"}  # entries one of which a stretch with an interval must have


def check_exact(
    name: str,
    sample: Mapping[str, object],
    branches: tuple[Branch, ...],
    points: tuple[SpecialPoint, ...],
) -> None:
    """ValueError that names entry and value if an exact value of a diagram is not valid.

    Values of branches are expressions in the parameter and in symbols that have a sample, those of
    points and intervals in the latter only.
    """
    others = set(sample)
    for point in points:
        for key, value in point.exact.items():
            _check(f"{key!r} of point {point.id!r}", value, others)
    for entry, exact in _stretches(branches):
        for key, value in exact.items():
            if key == INTERVAL:
                _check_interval(f"{key!r} of {entry}", value, others)
            else:
                _check(f"{key!r} of {entry}", value, {name, *others})
        if INTERVAL in exact and not any(each <= exact.keys() for each in PLACES):
            listed = ", ".join(exact)
            raise ValueError(
                f"exact values of {entry} must have x, or lower and upper, got {listed}"
            )


def _stretches(branches: tuple[Branch, ...]) -> Iterator[tuple[str, Mapping[str, object]]]:
    for branch in branches:
        for k, stretch in enumerate(branch.words):
            yield f"branch {branch.id!r}{f', stretch {k}' if k else ''}", stretch.exact


def _check_interval(entry: str, value: Any, known: Set[str]) -> None:
    if not isinstance(value, sympy.Interval | sympy.FiniteSet):
        raise ValueError(f"the exact {entry} must be an interval or a value, got {shown(value)}")
    for end in value.args[:2] if isinstance(value, sympy.Interval) else value.args:
        _check(entry, end, known)


def _check(entry: str, value: Any, known: Set[str]) -> None:
    """ValueError unless a value is an algebraic expression in known symbols."""
    if not _is_algebraic(value):
        raise ValueError(f"the exact {entry} must be an algebraic expression, got {shown(value)}")
    unknown = sorted({symbol.name for symbol in value.free_symbols} - known)
    if unknown:
        given = ", ".join(sorted(known)) or "without symbols"
        raise ValueError(
            f"the exact {entry} must be an expression {'in ' * bool(known)}{given}, got "
            f"{shown(value)} with the unknown {', '.join(unknown)}"
        )


def _is_algebraic(value: object) -> bool:
    """Whether a formula is made of numbers, symbols and roots by arithmetic and rational powers."""
    if not isinstance(value, sympy.Expr) or value is sympy.zoo:
        return False
    if not value.args or isinstance(value, sympy.CRootOf):
        return True
    if isinstance(value, sympy.Pow) and not value.exp.is_Rational:
        return False
    known = isinstance(value, sympy.Add | sympy.Mul | sympy.Pow | RealRootOf)
    return known and all(map(_is_algebraic, value.args))
