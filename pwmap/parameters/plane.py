"""Cells of two parameters: strips of one, in each of which the cells of the other persist."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy

from pwmap.algebra.roots import real_to_sympy, simplest_between
from pwmap.algebra.terms import own_name
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.axis import Axis, ResampleError
from pwmap.parameters.cells import (
    Cell,
    ParameterCells,
    checked_orders,
    checked_span,
    shown_cells,
    with_cells,
)
from pwmap.parameters.column import ColumnAxis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strip:
    """An open interval of one parameter, with the cells of the other.

    Attributes
    ----------
    lower, upper
        Exact ends of the interval.
    cells
        The cells of the other parameter; their edges are formulas in the first.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    cells: ParameterCells


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterPlane:
    """Cells of two parameters, strip by strip.

    Attributes
    ----------
    across, along
        The parameter of the strips, and the one along each strip.
    strips
        From left to right. The single values between two strips, where edges meet, belong to
        neither and were not analysed.
    """

    across: sympy.Symbol
    along: sympy.Symbol
    strips: tuple[Strip, ...]


def parameter_plane(
    map_: PiecewiseLinearMap,
    across: object,
    along: object,
    across_span: tuple[object, object],
    along_span: tuple[object, object],
    orders: Iterable[int] = (1, 2),
) -> ParameterPlane:
    """Cut a rectangle of two parameters into cells, exactly.

    Parameters
    ----------
    map_
        A map with just these two parameters.
    across, along
        Symbols or names. All decisions must be of degree one in ``along``.
    across_span, along_span
        Rationals.
    orders
        The iterates to look at.

    Raises
    ------
    ValueError
        If the map has other parameters, or a decision has a higher degree in ``along``.
    """
    across, along = (own_name(name, map_.parameters) for name in (across, along))
    names = {str(symbol): symbol for symbol in map_.parameters}
    if set(names) != {str(across), str(along)} or len(names) != 2:
        raise ValueError(f"expected a map of {across} and {along}, this one has {list(names)}")
    orders = checked_orders(orders)
    low, high = checked_span(across_span)
    ends = checked_span(along_span)
    strips: list[tuple[Any, Strip]] = []
    waiting: list[tuple[Any, Any]] = [(low, high)]
    while waiting:
        left, right = waiting.pop()
        sample = {str(across): simplest_between(left, right)}
        broken = map_.definition.region.contains(sample)
        if broken is not None:
            value = real_to_sympy(sample[str(across)])
            raise ValueError(f"{across} = {value} in the span contradicts the assumption {broken}")
        try:
            bounds, shown = with_cells(
                partial(_strip, map_, orders), map_, along, orders, ends, sample
            )
        except ResampleError:  # edges meet here: it is no strip, but lies between two
            waiting += [(left, sample[str(across)]), (sample[str(across)], right)]
            continue
        start, stop = _within(bounds, left, right)
        strip = Strip(lower=real_to_sympy(start), upper=real_to_sympy(stop), cells=shown)
        strips.append((sample[str(across)], strip))
        waiting += [(left, start)] if start is not left else []
        waiting += [(stop, right)] if stop is not right else []
    strips.sort(key=lambda item: item[0])
    return ParameterPlane(
        across=names[str(across)], along=names[str(along)], strips=tuple(s for _, s in strips)
    )


def _strip(
    map_: PiecewiseLinearMap, orders: tuple[int, ...], axis: Axis, cells: list[Cell]
) -> tuple[tuple[Any, Any], ParameterCells]:
    """Where the cells of one sample hold, and the cells."""
    assert isinstance(axis, ColumnAxis)
    return axis.bounds(), shown_cells(map_, orders, axis, cells)


def _within(bounds: tuple[Any, Any], left: Any, right: Any) -> tuple[Any, Any]:
    """An interval cut at two ends."""
    low, high = bounds
    return (
        left if low is None or not left < low else low,
        right if high is None or not high < right else high,
    )
