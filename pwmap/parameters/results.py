"""The cells of a parameter as a user sees them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from pwmap.algebra.arguments import shortened
from pwmap.maps.piecewise_linear import PiecewiseLinearMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterCell:
    """An open interval of the parameter, or an edge, of :func:`pwmap.parameter_cells`.

    The exact ends ``lower`` and ``upper`` are equal for an edge. For the orders of the cells,
    ``map`` gives ``iterate(j).pieces``, ``fixed_points()`` and ``jump_crossings()`` as formulas in
    the parameters; other answers it gives if they hold throughout the cell, and
    :class:`UndecidedError` otherwise.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    map: PiecewiseLinearMap

    @property
    def is_edge(self) -> bool:
        """Whether it is a single value of the parameter."""
        return bool(self.lower == self.upper)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParameterCells:
    """Admitted cells of :func:`pwmap.parameter_cells` from left to right, open ones and edges.

    ``given`` are conditions on the other parameters.
    """

    parameter: sympy.Symbol
    orders: tuple[int, ...]
    cells: tuple[ParameterCell, ...]
    given: tuple[sympy.Basic, ...]

    @property
    def edges(self) -> tuple[sympy.Expr, ...]:
        """The exact values of the parameter at which something changes."""
        return tuple(cell.lower for cell in self.cells if cell.is_edge)

    def __iter__(self) -> Iterator[ParameterCell]:
        return iter(self.cells)

    def __len__(self) -> int:
        return len(self.cells)

    def __repr__(self) -> str:
        edges = shortened(", ".join(map(str, self.edges)) or "none", 160)
        orders = ", ".join(map(str, self.orders))
        return (
            f"ParameterCells({self.parameter}, orders {orders}: {len(self)} cells, edges {edges})"
        )
