"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations."""

from woodpecker.complete import Report, Search
from woodpecker.diagram import (
    Found,
    bifurcation_diagram,
    connected,
    continuation,
    find_all,
    saved_diagram,
    whole_diagram,
)
from woodpecker.explore import Stage
from woodpecker.follow import PathPoint, follow
from woodpecker.jumps import JumpPoint, follow_jump
from woodpecker.labelled import Cycle, Evaluation, LabelledMap, correct, iterate
from woodpecker.local import LocalModel, Start, local_model
from woodpecker.mechanics import Equilibrium, energy, equilibrium, free_frequency, jam_limit
from woodpecker.orbits import Orbit, OrbitDiagram, orbit_diagram, unexplained
from woodpecker.pieces import (
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
from woodpecker.returns import Return, ReturnMap, first_return, return_map
from woodpecker.settings import Settings
from woodpecker.shooting import PeriodicOrbit, ShootingStatus, shoot
from woodpecker.status import Status
from woodpecker.tolerances import Tolerances
from woodpecker.toy import ExpansionFriction, Toy, parameters
from woodpecker.toymaps import toy_map, toy_samples
from woodpecker.trajectory import (
    EnergyBalance,
    Event,
    Impulse,
    State,
    Trajectory,
    energy_balance,
    simulate,
)
from woodpecker.words import EventKind

__all__ = [
    "Cycle",
    "EnergyBalance",
    "Equilibrium",
    "Evaluation",
    "Event",
    "EventKind",
    "ExpansionFriction",
    "Found",
    "Impulse",
    "JumpPoint",
    "LabelledMap",
    "LocalModel",
    "Orbit",
    "OrbitDiagram",
    "Partition",
    "PathPoint",
    "PeriodicOrbit",
    "Piece",
    "Report",
    "Resolution",
    "Return",
    "ReturnMap",
    "SampledMap",
    "Search",
    "Settings",
    "ShootingStatus",
    "Slice",
    "Stage",
    "Start",
    "State",
    "Status",
    "Tolerances",
    "Toy",
    "Trajectory",
    "bifurcation_diagram",
    "connected",
    "continuation",
    "correct",
    "energy",
    "energy_balance",
    "equilibrium",
    "find_all",
    "first_return",
    "follow",
    "follow_jump",
    "free_frequency",
    "iterate",
    "iterated",
    "jam_limit",
    "local_model",
    "orbit_diagram",
    "parameters",
    "partition",
    "return_map",
    "sampled",
    "saved_diagram",
    "shoot",
    "simulate",
    "slice_of",
    "toy_map",
    "toy_samples",
    "unexplained",
    "whole_diagram",
]
