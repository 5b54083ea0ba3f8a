"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""

from pwmap.algebra.assumptions import UndecidedError
from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
    Stretch,
)
from pwmap.diagrams.graph import read_graph, write_graph
from pwmap.longrun.densities import Density
from pwmap.longrun.dynamics import Attractor, Dynamics, Kneading, dynamics
from pwmap.longrun.entropies import Entropy
from pwmap.maps.budget import Budget, BudgetError, Progress
from pwmap.maps.piecewise_linear import (
    Cycle,
    FixedInterval,
    FixedPoint,
    Jump,
    JumpCrossing,
    Piece,
    PiecewiseLinearMap,
)
from pwmap.parameters.bifurcations import bifurcation_diagram
from pwmap.parameters.cells import ParameterCell, ParameterCells, parameter_cells
from pwmap.parameters.plane import ParameterPlane, Strip, parameter_plane

__all__ = [
    "Attractor",
    "Branch",
    "BranchKind",
    "Budget",
    "BudgetError",
    "Cycle",
    "Density",
    "Diagram",
    "Dynamics",
    "Entropy",
    "FixedInterval",
    "FixedPoint",
    "Jump",
    "JumpCrossing",
    "Kneading",
    "ParameterCell",
    "ParameterCells",
    "ParameterPlane",
    "Piece",
    "PiecewiseLinearMap",
    "PointKind",
    "PointStatus",
    "Progress",
    "SpecialPoint",
    "Stretch",
    "Strip",
    "UndecidedError",
    "bifurcation_diagram",
    "dynamics",
    "parameter_cells",
    "parameter_plane",
    "read_graph",
    "write_graph",
]
