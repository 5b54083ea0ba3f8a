"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations."""

from woodpecker.continued import continuation
from woodpecker.diagram import bifurcation_diagram, find_all
from woodpecker.engine.borders import Border, BorderKind
from woodpecker.engine.derivatives import check_derivatives
from woodpecker.engine.diagrams import Found, connected, cycle_near, whole_diagram
from woodpecker.engine.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.engine.iterates import Iterate
from woodpecker.engine.local import LocalModel, Start, local_model
from woodpecker.engine.pieces import Image, PiecewiseMap
from woodpecker.engine.search import Search, Seen, Stage
from woodpecker.engine.settings import Settings
from woodpecker.engine.settled import Orbit, OrbitDiagram, orbit_diagram, unexplained
from woodpecker.engine.slices import Slice, slices_at
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
from woodpecker.runs import saved_diagram
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
from woodpecker.toypieces import ToyPieces

__all__ = [
    "Border",
    "BorderKind",
    "BranchState",
    "EnergyBalance",
    "Equilibrium",
    "Event",
    "EventKind",
    "ExpansionFriction",
    "FormulaMap",
    "FormulaPiece",
    "Found",
    "Image",
    "Impulse",
    "Iterate",
    "LocalModel",
    "OnBranch",
    "Orbit",
    "OrbitDiagram",
    "PeriodicOrbit",
    "PiecewiseMap",
    "Return",
    "ReturnMap",
    "Search",
    "Seen",
    "Settings",
    "ShootingStatus",
    "Slice",
    "Smooth",
    "Stage",
    "Start",
    "State",
    "Status",
    "Toy",
    "ToyPieces",
    "Trajectory",
    "bifurcation_diagram",
    "borders_in",
    "check_derivatives",
    "connected",
    "continuation",
    "crosses",
    "cycle_near",
    "energy",
    "energy_balance",
    "equilibrium",
    "find_all",
    "first_return",
    "free_frequency",
    "from_pwmap",
    "from_sympy",
    "jam_limit",
    "local_model",
    "nearest_border",
    "observables",
    "orbit_diagram",
    "parameters",
    "return_map",
    "saved_diagram",
    "shoot",
    "simulate",
    "slices_at",
    "solutions",
    "unexplained",
    "whole_diagram",
]
