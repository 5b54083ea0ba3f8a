"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""

from pwmap.assumptions import UndecidedError
from pwmap.bifurcations import bifurcation_diagram
from pwmap.budget import Budget, BudgetError, Progress
from pwmap.cells import ParameterCell, ParameterCells, parameter_cells
from pwmap.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.graph import read_graph, write_graph
from pwmap.maps import (
    Cycle,
    FixedInterval,
    FixedPoint,
    Jump,
    JumpCrossing,
    Piece,
    PiecewiseLinearMap,
)
from pwmap.plane import ParameterPlane, Strip, parameter_plane

__all__ = [
    "Branch",
    "BranchKind",
    "Budget",
    "BudgetError",
    "Cycle",
    "Diagram",
    "FixedInterval",
    "FixedPoint",
    "Jump",
    "JumpCrossing",
    "ParameterCell",
    "ParameterCells",
    "ParameterPlane",
    "Piece",
    "PiecewiseLinearMap",
    "PointKind",
    "Progress",
    "SpecialPoint",
    "Strip",
    "UndecidedError",
    "bifurcation_diagram",
    "parameter_cells",
    "parameter_plane",
    "read_graph",
    "write_graph",
]
