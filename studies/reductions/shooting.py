"""(c) One coordinate: Newton's method for the map, and for all five states on the section."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from studies.common.clocks import clocked, over, race
from studies.common.motion import GUESS
from studies.common.record import Results
from studies.peers.cases import FIXED_POINT, distance
from studies.reductions.motions import EVENTS
from studies.reductions.plan import Plan
from woodpecker import Toy
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.impacts import rates
from woodpecker.mechanics.modes import CONTACT, NO_RATES, model
from woodpecker.motion.codes import EVENT_COLUMNS, NO_PATH, PHASE_COLUMNS
from woodpecker.simulation import calls
from woodpecker.simulation.calls import sweep

QUOTIENT = 1e-7  # rad, rad/s, m/s; of difference quotients: noise 1e-15 and curvature 1e3 balance
CONVERGED = 1e-12  # rad; both ways end at a residual below it


class Found(NamedTuple):
    """A fixed point by Newton's method."""

    z: Floats
    jacobian: Floats
    returns: int  # simulated


def shooting(plan: Plan) -> Results:
    """Fixed point and multiplier with one unknown and with five."""
    toy = Toy()
    jobs = {
        "one": clocked(partial(shoot_one, toy, GUESS), 5),
        "five": clocked(partial(shoot_five, toy, GUESS), 5),
    }
    timings = race(jobs, plan.rounds)
    one, five = shoot_one(toy, GUESS), shoot_five(toy, GUESS)
    eigenvalues = sorted(np.linalg.eigvals(five.jacobian), key=abs, reverse=True)
    return {
        "error_one": distance(one.z[1], FIXED_POINT.phi_s),
        "error_five": distance(five.z[1], FIXED_POINT.phi_s),
        "multiplier_one": float(one.jacobian[0, 0]),
        "error_multiplier_one": distance(one.jacobian[0, 0], FIXED_POINT.multiplier),
        "eigenvalues_five": [[float(x.real), float(x.imag)] for x in eigenvalues],
        "error_multiplier_five": distance(eigenvalues[0].real, FIXED_POINT.multiplier),
        "largest_other_eigenvalue": float(abs(eigenvalues[1])),
        "returns_one": one.returns,
        "returns_five": five.returns,
        "ratio": over(timings, "five", "one"),
        "timings": timings,
    }


def land(table: Floats, z: Floats) -> Floats:
    """Next return of a state (phi_M, phi_S, dy, dphi_M, dphi_S) at or near the section.

    A minimum of phi_S before the beak or the upper sleeve contact has struck is the end of the
    disturbance of the start, not a return.
    """
    state, counts = np.concatenate([[0.0], z, [0.0]]), np.zeros(3, np.int64)
    touching = z[0] <= -table[CONTACT + 1, 0] and z[3] == 0.0
    slips = rates(table, 1, state)[1] != 0.0
    states = np.array([0, (2 if slips else 1) if touching else 0, 0])
    codes = np.zeros(EVENTS, np.int16)
    away = 0
    while not away:
        calls.run(
            table, state, states, True, math.inf, codes, np.zeros((0, PHASE_COLUMNS)),
            NO_PATH, np.zeros((0, EVENT_COLUMNS)), counts,
        )  # fmt: skip
        away = int(np.bitwise_or.reduce(codes[: counts[0]] % 8)) & 0b101
    return state[1:6]


def shoot_one(toy: Toy, guess: float, steps: int = 20) -> Found:
    """Newton's method in phi_S with the exact slope of the map."""
    table, phi_s = model(toy), np.array([guess])
    spent = 0
    for _ in range(steps):
        spent += 1
        out = sweep(table, NO_RATES, phi_s, 1, np.zeros((1, 3)))[0]
        residual, slope = out[0, 0] - phi_s[0], out[0, 3]
        if abs(residual) <= CONVERGED:
            break
        phi_s += residual / (1.0 - slope)
    z = np.array([-toy.phi_m_max, phi_s[0], 0.0, 0.0, 0.0])
    return Found(z, np.array([[slope]]), spent)


def shoot_five(toy: Toy, guess: float, steps: int = 20) -> Found:
    """Newton's method in all states on the section, with difference quotients of the flow.

    Differences go to the side where the sleeve is not inside the pole and phi_S is past its
    minimum.
    """
    table, z, spent = model(toy), np.array([-toy.phi_m_max, guess, 0.0, 0.0, 0.0]), 0
    for _ in range(steps):
        image = land(table, z)
        jacobian = np.column_stack(
            [(land(table, z + QUOTIENT * e) - image) / QUOTIENT for e in np.eye(5)]
        )
        spent += 6
        residual = image - z
        if np.abs(residual).max() <= CONVERGED:
            break
        z = z + np.linalg.solve(np.eye(5) - jacobian, residual)
    return Found(z, jacobian, spent)
