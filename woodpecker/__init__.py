"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations."""

from pwmap.diagrams.diagram import load_diagram
from pwmap.plane.kinds import PlaneKind
from woodpecker.continued import continuation
from woodpecker.diagram import bifurcation_diagram, find_all
from woodpecker.mechanics.equations import (
    Equilibrium,
    energy,
    equilibrium,
    free_frequency,
    jam_limit,
)
from woodpecker.mechanics.toy import ExpansionFriction, Toy, parameters
from woodpecker.piecewise.borders import Border, BorderKind
from woodpecker.piecewise.derivatives import check_derivatives
from woodpecker.piecewise.diagrams import Found, connected, cycle_near, whole_diagram
from woodpecker.piecewise.explorer import Seen, Stage
from woodpecker.piecewise.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.piecewise.iterates import Iterate
from woodpecker.piecewise.local import LocalModel, Start, local_model
from woodpecker.piecewise.pieces import Image, PiecewiseMap
from woodpecker.piecewise.samples import BranchState
from woodpecker.piecewise.search import Search
from woodpecker.piecewise.settings import Numerics, Settings
from woodpecker.piecewise.settled import Orbit, OrbitDiagram, orbit_diagram, unexplained
from woodpecker.piecewise.slices import Slice, slices_at
from woodpecker.piecewise.symbolic import from_pwmap, from_sympy
from woodpecker.piecewise.windows import borders_in, crosses, nearest_border
from woodpecker.plane.census import Attractor, Count, Settles
from woodpecker.plane.curve import Curve, PlanePoint, PlaneStretch
from woodpecker.plane.families import Family, family_from_pwmap, family_from_sympy
from woodpecker.plane.following import curve_through
from woodpecker.plane.graph import graph_of_curves
from woodpecker.plane.regions import Region, Regions, Survey, regions_of
from woodpecker.proving import check_certificate, prove
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
from woodpecker.toyfamily import ToyFamily
from woodpecker.toypieces import ToyPieces
from woodpecker.toyregions import parameter_regions
from woodpecker.trouble.found import Effect, Limit, Robustness, Trouble
from woodpecker.trouble.robustness import robustness
from woodpecker.undecided import Undecided

__all__ = [
    "Attractor",
    "Border",
    "BorderKind",
    "BranchState",
    "Count",
    "Curve",
    "Effect",
    "EnergyBalance",
    "Equilibrium",
    "Event",
    "EventKind",
    "ExpansionFriction",
    "Family",
    "FormulaMap",
    "FormulaPiece",
    "Found",
    "Image",
    "Impulse",
    "Iterate",
    "Limit",
    "LocalModel",
    "Numerics",
    "OnBranch",
    "Orbit",
    "OrbitDiagram",
    "PeriodicOrbit",
    "PiecewiseMap",
    "PlaneKind",
    "PlanePoint",
    "PlaneStretch",
    "Region",
    "Regions",
    "Return",
    "ReturnMap",
    "Robustness",
    "Search",
    "Seen",
    "Settings",
    "Settles",
    "ShootingStatus",
    "Slice",
    "Smooth",
    "Stage",
    "Start",
    "State",
    "Status",
    "Survey",
    "Toy",
    "ToyFamily",
    "ToyPieces",
    "Trajectory",
    "Trouble",
    "Undecided",
    "bifurcation_diagram",
    "borders_in",
    "check_certificate",
    "check_derivatives",
    "connected",
    "continuation",
    "crosses",
    "curve_through",
    "cycle_near",
    "energy",
    "energy_balance",
    "equilibrium",
    "family_from_pwmap",
    "family_from_sympy",
    "find_all",
    "first_return",
    "free_frequency",
    "from_pwmap",
    "from_sympy",
    "graph_of_curves",
    "jam_limit",
    "load_diagram",
    "local_model",
    "nearest_border",
    "observables",
    "orbit_diagram",
    "parameter_regions",
    "parameters",
    "prove",
    "regions_of",
    "return_map",
    "robustness",
    "saved_diagram",
    "shoot",
    "simulate",
    "slices_at",
    "solutions",
    "unexplained",
    "whole_diagram",
]
