"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations."""

from woodpecker.diagram import connected, continuation
from woodpecker.follow import PathPoint, Settings, follow
from woodpecker.jumps import JumpPoint, follow_jump
from woodpecker.labelled import Cycle, Evaluation, LabelledMap, correct, iterate
from woodpecker.mechanics import Equilibrium, energy, equilibrium, free_frequency, jam_limit
from woodpecker.returns import Return, ReturnMap, first_return, return_map
from woodpecker.shooting import PeriodicOrbit, ShootingStatus, shoot, toy_map
from woodpecker.status import Status
from woodpecker.tolerances import Tolerances
from woodpecker.toy import Toy, parameters
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
    "Impulse",
    "JumpPoint",
    "LabelledMap",
    "PathPoint",
    "PeriodicOrbit",
    "Return",
    "ReturnMap",
    "Settings",
    "ShootingStatus",
    "State",
    "Status",
    "Tolerances",
    "Toy",
    "Trajectory",
    "connected",
    "continuation",
    "correct",
    "energy",
    "energy_balance",
    "equilibrium",
    "first_return",
    "follow",
    "follow_jump",
    "free_frequency",
    "iterate",
    "jam_limit",
    "parameters",
    "return_map",
    "shoot",
    "simulate",
    "toy_map",
]
