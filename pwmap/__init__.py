"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""

from pwmap.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.graph import read_graph, write_graph

__all__ = [
    "Branch",
    "BranchKind",
    "Diagram",
    "PointKind",
    "SpecialPoint",
    "read_graph",
    "write_graph",
]
