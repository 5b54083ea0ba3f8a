"""A rectangle of two parameters cut into strips, in each of which edges of cells do not meet."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy
from sympy import QQ

from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import Real, RealRoot, integers, real_to_sympy, simplest_between
from pwmap.maps.budget import BUDGET, Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.axis import Axis, ResampleError
from pwmap.parameters.cells import Cell, from_all_orders, merged, shown_cells, with_stages
from pwmap.parameters.recorded import RecordedAxis
from pwmap.parameters.results import ParameterCells
from pwmap.plane.marks import Mark, marks


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strip:
    """An open interval of one parameter, with cells of the other; of :func:`pwmap.parameter_plane`.

    ``column`` is the interval, with the sample at which ``cells`` were found; the edges of cells
    are expressions in the first parameter. ``borders`` are the edges and both ends of the span as
    roots of polynomials, from the lowest on; ``marks`` are bifurcations. ``upright`` has the
    coefficients of polynomials in the first parameter alone whose signs were used.
    """

    column: Column
    cells: ParameterCells
    borders: tuple[Root, ...]
    marks: tuple[Mark, ...]
    upright: tuple[tuple[int, ...], ...]

    @property
    def lower(self) -> sympy.Expr:
        """The exact lower end."""
        return real_to_sympy(self.column.low)

    @property
    def upper(self) -> sympy.Expr:
        """The exact upper end."""
        return real_to_sympy(self.column.high)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rectangle:
    """A map of two parameters, with an interval of each, and the orders to look at."""

    map: PiecewiseLinearMap
    across: str
    along: str
    across_span: tuple[Any, Any]
    along_span: tuple[Any, Any]
    orders: tuple[int, ...]
    meter: Meter

    @property
    def index(self) -> int:
        """The index of the parameter across among those of the map."""
        return [str(symbol) for symbol in self.map.parameters].index(self.across)

    @property
    def studied(self) -> tuple[int, ...]:
        """The orders and their divisors: a jump may end at a cycle of smaller period."""
        return tuple(sorted({d for n in self.orders for d in range(1, n + 1) if n % d == 0}))

    def strips(self) -> list[Strip]:
        """All strips from left to right, up to the first gap that the budget leaves."""
        found: list[Strip] = []
        waiting: list[tuple[Real, Real]] = [self.across_span]
        with self.meter.keeping(waiting):
            while waiting:
                self.meter.advance("strips", len(found))
                left, right = waiting[-1]
                sample = simplest_between(left, right)
                broken = self.map.definition.region.contains({self.across: sample})
                if broken is not None:
                    value = f"{self.across} = {real_to_sympy(sample)}"
                    raise ValueError(f"{value} in the span contradicts the assumption {broken}")
                try:
                    strip = self._strip(sample)
                except ResampleError:  # edges meet at the sample: it lies between two strips
                    waiting[-1:] = [(sample, right), (left, sample)]
                    continue
                start, stop = max(left, strip.column.low), min(right, strip.column.high)
                column = replace(strip.column, low=start, high=stop)
                found.append(replace(strip, column=column))
                beside = ((stop, right), (left, start))
                waiting[-1:] = [(a, b) for a, b in beside if a is not b]
        if waiting:
            end = waiting[-1][0]
            found = [strip for strip in found if not end < strip.column.high]
        found.sort(key=lambda strip: strip.column.sample)
        if found and isinstance(found[-1].column.high, RealRoot):  # a rectangle has rational ends
            column = found[-1].column
            end = simplest_between(column.sample, column.high)
            found[-1] = replace(found[-1], column=replace(column, high=end))
        return found

    def _strip(self, sample: Any) -> Strip:
        sampled, built = {self.across: sample}, from_all_orders(self._built)
        return with_stages(built, self.map, self.along, self.studied, self.along_span, sampled,
                           with_ends=True, meter=self.meter)  # fmt: skip

    def _built(self, axis: Axis, cells: list[Cell]) -> Strip:
        assert isinstance(axis, RecordedAxis)
        inner = cells[1 if cells[0].is_edge else 0 : -1 if cells[-1].is_edge else None]
        kept = merged(inner)
        return Strip(
            cells=shown_cells(self.map, self.studied, axis, kept),
            column=axis.column,
            borders=(kept[0].lower, *(cell.upper for cell in kept if not cell.is_edge)),
            marks=tuple(marks(self.map, axis, cells)),
            upright=tuple(map(integers, axis.upright)),
        )

    def upright_marks(self, along: Any, span: tuple[Any, Any]) -> list[Mark]:
        """The bifurcations over the parameter across, at a rational value of the one along."""
        map_ = self.map.at({self.along: QQ.to_sympy(along)})
        found = from_all_orders(partial(marks, map_))
        return with_stages(found, map_, self.across, self.studied, span, None,
                           with_ends=True, meter=Meter(BUDGET))  # fmt: skip
