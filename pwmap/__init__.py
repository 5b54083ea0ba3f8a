"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs."""

from pwmap.algebra.assumptions import UndecidedError
from pwmap.certificates import Certificate, prove
from pwmap.checking import Refused, check_certificate
from pwmap.diagrams.diagram import (
    Branch,
    BranchKind,
    Diagram,
    PointKind,
    PointStatus,
    SpecialPoint,
    Stretch,
    load_diagram,
)
from pwmap.diagrams.graph import read_graph, write_graph
from pwmap.longrun.bands import with_attractors
from pwmap.longrun.constant import (
    ConstantEntropy,
    EntropyGap,
    EntropyIntervals,
    GapCause,
    constant_entropy,
)
from pwmap.longrun.crises import (
    AttractorCell,
    AttractorDiagram,
    Crisis,
    Meeting,
    attractor_diagram,
    meeting_curve,
)
from pwmap.longrun.cycles import FoundCycle, FoundCycles, cycles
from pwmap.longrun.densities import Density
from pwmap.longrun.dynamics import Attractor, Dynamics, Extremum, Kneading, MinMax, dynamics
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
from pwmap.plane.crisiscurves import with_crises
from pwmap.plane.kinds import PlaneKind
from pwmap.plane.network import CodimensionTwo, PlaneCurve
from pwmap.plane.plane import ParameterPlane, parameter_plane
from pwmap.plane.rasters import Colours, PlaneRaster, plane_raster
from pwmap.plane.strips import Strip
from pwmap.rotations.centres import (
    CentreKind,
    OrganisingCentre,
    organising_centre,
    organising_centres,
)
from pwmap.rotations.families import WordFamily, word_family
from pwmap.rotations.numbers import (
    RotationInterval,
    RotationNumber,
    rotation_interval,
    rotation_number_at,
)
from pwmap.rotations.tongues import Tongue, tongues
from pwmap.rotations.words import farey, rotation_number, rotational_word

__all__ = [
    "Attractor",
    "AttractorCell",
    "AttractorDiagram",
    "Branch",
    "BranchKind",
    "Budget",
    "BudgetError",
    "CentreKind",
    "Certificate",
    "CodimensionTwo",
    "Colours",
    "ConstantEntropy",
    "Crisis",
    "Cycle",
    "Density",
    "Diagram",
    "Dynamics",
    "Entropy",
    "EntropyGap",
    "EntropyIntervals",
    "Extremum",
    "FixedInterval",
    "FixedPoint",
    "FoundCycle",
    "FoundCycles",
    "GapCause",
    "Jump",
    "JumpCrossing",
    "Kneading",
    "Meeting",
    "MinMax",
    "OrganisingCentre",
    "ParameterCell",
    "ParameterCells",
    "ParameterPlane",
    "Piece",
    "PiecewiseLinearMap",
    "PlaneCurve",
    "PlaneKind",
    "PlaneRaster",
    "PointKind",
    "PointStatus",
    "Progress",
    "Refused",
    "RotationInterval",
    "RotationNumber",
    "SpecialPoint",
    "Stretch",
    "Strip",
    "Tongue",
    "UndecidedError",
    "WordFamily",
    "attractor_diagram",
    "bifurcation_diagram",
    "check_certificate",
    "constant_entropy",
    "cycles",
    "dynamics",
    "farey",
    "load_diagram",
    "meeting_curve",
    "organising_centre",
    "organising_centres",
    "parameter_cells",
    "parameter_plane",
    "plane_raster",
    "prove",
    "read_graph",
    "rotation_interval",
    "rotation_number",
    "rotation_number_at",
    "rotational_word",
    "tongues",
    "with_attractors",
    "with_crises",
    "word_family",
    "write_graph",
]
