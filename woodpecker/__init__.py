"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations."""

from woodpecker.diagram import (
    Found,
    bifurcation_diagram,
    connected,
    continuation,
    find_all,
    saved_diagram,
    whole_diagram,
)
from woodpecker.engine.borders import Border, BorderKind
from woodpecker.engine.derivatives import check_derivatives
from woodpecker.engine.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.engine.iterates import Iterate
from woodpecker.engine.local import LocalModel, Start, local_model
from woodpecker.engine.pieces import Image, PiecewiseMap
from woodpecker.engine.settled import Orbit, OrbitDiagram, orbit_diagram, unexplained
from woodpecker.engine.stepping import BranchState
from woodpecker.engine.symbolic import from_pwmap, from_sympy
from woodpecker.engine.windows import borders_in, crosses, nearest_border
from woodpecker.mechanics.equations import (
    Equilibrium,
    energy,
    equilibrium,
    free_frequency,
    jam_limit,
)
from woodpecker.mechanics.toy import ExpansionFriction, Toy, parameters
from woodpecker.piecewise.explore import Stage
from woodpecker.piecewise.jumps import JumpPoint, follow_jump
from woodpecker.piecewise.maps import Cycle, Evaluation, LabelledMap, correct, iterate
from woodpecker.piecewise.partition import (
    Partition,
    Piece,
    Resolution,
    SampledMap,
    Slice,
    iterated,
    partition,
    sampled,
    slice_of,
)
from woodpecker.piecewise.search import Report, Search
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.stepping import PathPoint, follow
from woodpecker.piecewise.tolerances import Tolerances
from woodpecker.shooting import PeriodicOrbit, ShootingStatus, shoot
from woodpecker.simulation.returns import Return, ReturnMap, first_return, return_map
from woodpecker.simulation.status import Status
from woodpecker.simulation.trajectory import (
    EnergyBalance,
    Event,
    Impulse,
    State,
    Trajectory,
    energy_balance,
    simulate,
)
from woodpecker.simulation.words import EventKind
from woodpecker.solutions import OnBranch, observables, solutions
from woodpecker.toymaps import toy_map, toy_samples
from woodpecker.toypieces import ToyPieces

__all__ = [
    "Border",
    "BorderKind",
    "BranchState",
    "Cycle",
    "EnergyBalance",
    "Equilibrium",
    "Evaluation",
    "Event",
    "EventKind",
    "ExpansionFriction",
    "FormulaMap",
    "FormulaPiece",
    "Found",
    "Image",
    "Impulse",
    "Iterate",
    "JumpPoint",
    "LabelledMap",
    "LocalModel",
    "OnBranch",
    "Orbit",
    "OrbitDiagram",
    "Partition",
    "PathPoint",
    "PeriodicOrbit",
    "Piece",
    "PiecewiseMap",
    "Report",
    "Resolution",
    "Return",
    "ReturnMap",
    "SampledMap",
    "Search",
    "Settings",
    "ShootingStatus",
    "Slice",
    "Smooth",
    "Stage",
    "Start",
    "State",
    "Status",
    "Tolerances",
    "Toy",
    "ToyPieces",
    "Trajectory",
    "bifurcation_diagram",
    "borders_in",
    "check_derivatives",
    "connected",
    "continuation",
    "correct",
    "crosses",
    "energy",
    "energy_balance",
    "equilibrium",
    "find_all",
    "first_return",
    "follow",
    "follow_jump",
    "free_frequency",
    "from_pwmap",
    "from_sympy",
    "iterate",
    "iterated",
    "jam_limit",
    "local_model",
    "nearest_border",
    "observables",
    "orbit_diagram",
    "parameters",
    "partition",
    "return_map",
    "sampled",
    "saved_diagram",
    "shoot",
    "simulate",
    "slice_of",
    "solutions",
    "toy_map",
    "toy_samples",
    "unexplained",
    "whole_diagram",
]
