"""Curves over two parameters, started at special points of a family over its first parameter."""

from dataclasses import replace

import sympy
from maps import everything

from pwmap import PointKind
from pwmap.diagrams.diagram import SpecialPoint
from woodpecker import Curve, Settings, curve_in_two
from woodpecker.plane import Family, SymbolicFamily, family_from_sympy

X, P, Q = sympy.symbols("x p q")
Spans = tuple[tuple[float, float], tuple[float, float]]
SPANS: Spans = ((-2.0, 2.0), (-2.0, 2.0))
SETTINGS = Settings(window=(-2.0, 2.0))


def smooth(formula: sympy.Expr) -> SymbolicFamily:
    """A map of one formula in x over p and q."""
    return family_from_sympy(formula, X, (P, Q))


def broken(left: sympy.Expr, right: sympy.Expr, at: sympy.Expr = X) -> SymbolicFamily:
    """A map of two formulas: ``left`` where ``at`` is negative, ``right`` elsewhere."""
    return smooth(sympy.Piecewise((left, at < 0), (right, True)))


def special(
    family: Family, second: float, spans: Spans = SPANS, settings: Settings = SETTINGS,
    orders: tuple[int, ...] = (1,), *, kind: PointKind | None = None, order: int | None = None,
    near: float | None = None,
) -> list[SpecialPoint]:  # fmt: skip
    """Special points over the first parameter, all or those of a kind, an order, a place."""
    over = family.over(0, (0.0, second))
    return [
        point
        for point in everything(over, replace(settings, span=spans[0]), orders).diagram.points
        if kind in (None, point.kind) and order in (None, point.order)
        if near is None or abs(point.parameter - near) < 1e-9
    ]


def along(
    family: Family, point: SpecialPoint, second: float, spans: Spans = SPANS,
    settings: Settings = SETTINGS,
) -> Curve:  # fmt: skip
    """The curve of a point that was found at a value of the second parameter."""
    return curve_in_two(family, point, family.names, spans, value=second, settings=settings)


def through(
    family: Family, second: float, spans: Spans = SPANS, settings: Settings = SETTINGS,
    orders: tuple[int, ...] = (1,), *, kind: PointKind | None = None, order: int | None = None,
    near: float | None = None,
) -> Curve:  # fmt: skip
    """The curve of the first of :func:`special`."""
    point = special(family, second, spans, settings, orders, kind=kind, order=order, near=near)[0]
    return along(family, point, second, spans, settings)
