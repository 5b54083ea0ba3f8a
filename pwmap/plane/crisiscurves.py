"""Curves of crises over two parameters.

At some values of one parameter the crises along the other are found. In each an image of a break
meets a repelling cycle; their words give a polynomial in both parameters that is zero there. At
many of its zeros it is decided whether the crisis happens; an end of the curve between two of them
is located by bisection. Between neighbouring zeros nothing is proved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.arguments import check_functions, check_kind, checked_count, explained, shown
from pwmap.algebra.exact import Number, degree_in
from pwmap.algebra.inequalities import along
from pwmap.algebra.rootfunctions import Column, Root, irreducible_factors
from pwmap.algebra.roots import Real, algebraic, real_roots
from pwmap.diagrams.data import PointKind, runs_of
from pwmap.longrun.crises.changes import kind_at
from pwmap.longrun.crises.diagram import attractor_diagram
from pwmap.longrun.crises.meetings import meeting_polynomial
from pwmap.maps.budget import BUDGET, Budget, Meter, check_work, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.plane.curves import PlaneArc, PlaneCurve, curve_of
from pwmap.plane.plane import ParameterPlane
from pwmap.plane.strips import PlaneEvent

CRISIS_BUDGET = Budget(work=20 * BUDGET.work)  # some minutes
CRISES = (PointKind.MC, PointKind.XC, PointKind.FC)
COLUMN = 1000  # least work of one column in which crises are looked for
CHECKS_PER_COLUMN = 4  # values at which a curve is checked, for each of these columns
HALVINGS = 12  # bisections of an interval in which a curve ends
# Attractors beside a curve are compared within the span along over this number.
COMPARED_BESIDE = 2**12

_Family = tuple[PlaneEvent, PolyElement, int]  # a possible curve: a root of a polynomial by number


@explained()
def with_crises(
    plane: ParameterPlane,
    order: int = 2,
    columns: int = 12,
    *,
    budget: Budget | Meter = CRISIS_BUDGET,
    progress: Callable[[int], None] | None = None,
) -> ParameterPlane:
    """The same plane with the curves of merging, expansion and final crises.

    Parameters
    ----------
    plane, order
        The plane, and the order as of :func:`pwmap.attractor_diagram`.
    columns
        The number of values of the parameter across at which crises are looked for, at least 1.
    budget
        At its end, or at an interrupt, the curves that are finished are returned, and ``left_out``
        says so.
    progress
        Called after each column with the number of finished ones.

    Returns
    -------
    ParameterPlane
        A new one.

    Raises
    ------
    ValueError
        If ``columns`` is no integer of at least 1. A ``BudgetError`` if no column is finished.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> from pwmap.plane import with_crises
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> plane = parameter_plane(skew, "a", "b", ("19/20", 1), ("-17/10", "-8/5"), orders=(1,))
    >>> curve, = with_crises(plane, order=1, columns=1).curves
    >>> curve.kind.label, curve.polynomial
    ('merging crisis', a*b**2 - a + b)
    """
    check_kind("plane", plane, ParameterPlane)
    check_functions(progress=progress)
    columns = checked_count(columns, "columns")
    meter, curves = metered(budget), list[PlaneCurve]()
    done, traced = list[int](), list[_Family]()
    check_work(f"{shown(columns)} columns", COLUMN * columns, meter)
    low, high = plane.across_span
    found = dict[_Family, None]()
    with meter.keeping(done):
        for n in meter.each(range(columns), "columns"):
            value = low + (high - low) * QQ(2 * n + 1, 2 * columns)
            found.update(dict.fromkeys(_families(plane, value, order, meter)))
            done.append(n)
            if progress is not None:
                progress(len(done))
    many = columns * CHECKS_PER_COLUMN
    values = [low + (high - low) * QQ(n, many) for n in range(many + 1)]
    with meter.keeping(traced, besides=done):
        for family in meter.each(found, "curves of crises"):
            meter.spend(1)
            happens = partial(_has_crisis, plane, order, meter, family)
            for arc in _arcs(plane, family, values, happens):
                kind = arc.event.kind
                count = sum(curve.kind is kind for curve in curves) + 1
                curves.append(curve_of(f"{kind}{count}", [arc]))
            traced.append(family)
    left_out = "; ".join(filter(None, (plane.left_out, meter.left_out)))
    return replace(plane, curves=(*plane.curves, *curves), left_out=left_out)


def _families(plane: ParameterPlane, value: Number, order: int, meter: Meter) -> Iterator[_Family]:
    """The possible curves through the crises at a value of the parameter across."""
    span, index = tuple(map(QQ.to_sympy, plane.along_span)), _along(plane)
    found = attractor_diagram(_map_at(plane, value), plane.along, span, order, budget=meter)
    for crisis in found.crises:
        if crisis.kind in CRISES and not crisis.width:
            place = algebraic(crisis.parameter)
            factors = (
                factor
                for meeting in crisis.meetings
                for factor in irreducible_factors(meeting_polynomial(plane.map, meeting))
                if degree_in(factor, index)
            )
            for polynomial in factors:
                roots = _roots(plane, polynomial, value)
                if place in roots:
                    event = PlaneEvent(crisis.kind, f"image {crisis.images[0]}", crisis.cycles)
                    yield event, polynomial, roots.index(place)
                    break


def _along(plane: ParameterPlane) -> int:
    """The index of the parameter along among those of the map."""
    return plane.map.parameters.index(plane.along)


def _map_at(plane: ParameterPlane, value: Number) -> PiecewiseLinearMap:
    return plane.map.at({plane.across: QQ.to_sympy(value)})


def _roots(plane: ParameterPlane, polynomial: PolyElement, value: Number) -> tuple[Real, ...]:
    return real_roots(along(polynomial, (value, value), _along(plane)))


def _has_crisis(
    plane: ParameterPlane, order: int, meter: Meter, family: _Family, value: Number
) -> bool:
    """Whether a possible curve has its crisis at a value of the parameter across."""
    event, polynomial, number = family
    roots = _roots(plane, polynomial, value)
    low, high = plane.along_span
    if len(roots) <= number or not low < roots[number] < high:
        return False
    width = (high - low) * QQ(1, COMPARED_BESIDE)
    return kind_at(_map_at(plane, value), order, roots[number], width, meter) is event.kind


def _arcs(
    plane: ParameterPlane, family: _Family, values: list[Number], happens: Callable[[Number], bool]
) -> Iterator[PlaneArc]:
    """The arcs of a possible curve on which its crisis happens."""
    seen = [happens(value) for value in values]
    for first, last in runs_of(np.array(seen)):
        low = _end(happens, values[first], values[first - 1]) if first else values[0]
        high = _end(happens, *values[last : last + 2]) if last + 1 < len(values) else values[-1]
        yield _arc(plane, family, low, high)


def _end(happens: Callable[[Number], bool], inside: Number, outside: Number) -> Number:
    """The last value with a crisis, by bisection between a value with it and one without."""
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        if happens(middle):
            inside = middle
        else:
            outside = middle
    return inside


def _arc(plane: ParameterPlane, family: _Family, low: Number, high: Number) -> PlaneArc:
    event, polynomial, number = family
    symbols = tuple(plane.map.parameters)
    column = Column(symbols, _along(plane), low, high, (low + high) / 2)
    ends = low, column.sample, high
    start, value, end = (_roots(plane, polynomial, x)[number] for x in ends)
    root = Root(value, polynomial, number)
    return PlaneArc(event, polynomial, ((low, start), (high, end)), column, root)
