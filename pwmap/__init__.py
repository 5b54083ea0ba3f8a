"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""

from pwmap.assumptions import UndecidedError
from pwmap.bifurcations import bifurcation_diagram
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

__all__ = [
    "Branch",
    "BranchKind",
    "Cycle",
    "Diagram",
    "FixedInterval",
    "FixedPoint",
    "Jump",
    "JumpCrossing",
    "ParameterCell",
    "ParameterCells",
    "Piece",
    "PiecewiseLinearMap",
    "PointKind",
    "SpecialPoint",
    "UndecidedError",
    "bifurcation_diagram",
    "parameter_cells",
    "read_graph",
    "write_graph",
]
