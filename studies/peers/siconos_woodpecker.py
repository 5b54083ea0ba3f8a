"""The toy in Siconos: reads one scene as JSON from stdin, and writes the motion to stdout.

    /usr/bin/python3 studies/peers/siconos_woodpecker.py < scene.json

Siconos comes with the system's Python, not with the project's, so this is a separate program that
imports nothing of the project; :mod:`studies.peers.siconos_peer` starts it. The entries of a scene
are in SI units: ``mass``, ``stiffness`` (3 x 3), ``force`` and ``q`` (3), per contact ``normals``,
``tangents`` (3), ``offsets``, ``mu``, ``eps``, then ``step``, ``t_end``, ``theta``, the name of the
``solver``, ``returns`` (after how many to stop, 0: never), ``samples`` (one state every so many
steps, 0: none) and ``states`` (whether to report the contacts of every step).
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any, NamedTuple

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn

BEAK, LOWER, UPPER = range(3)
OPEN, STICK, FORWARD, BACKWARD = range(4)
ON_POLE = 1e-14  # m; the start on the section is closed up to rounding
STILL = 1e-9  # m/s; what sticks moves slower than 1e-15 m/s here, and what begins to slide is
# faster than 1e-9 m/s after a step of 3e-6 s


class Scene(NamedTuple):
    """Everything of a scene: Siconos does not keep what Python hands to it alive."""

    body: Any
    simulation: Any
    contacts: list[Any]
    kept: tuple[Any, ...]


def build(scene: dict[str, Any]) -> Scene:
    """Body, contacts and simulation of a scene."""
    mass, stiffness, force, q, u = (
        np.array(values, dtype=float)
        for values in (scene["mass"], scene["stiffness"], scene["force"], scene["q"], [0.0] * 3)
    )
    body = sk.LagrangianLinearTIDS(q, u, mass)
    body.setKPtr(stiffness)
    body.setFExtPtr(force)
    system = sk.NonSmoothDynamicalSystem(0.0, scene["t_end"])
    system.insertDynamicalSystem(body)
    contacts, parts = [], []
    for i in (BEAK, LOWER, UPPER):
        directions = np.array([scene["normals"][i], scene["tangents"][i]], dtype=float)
        offset = np.array([scene["offsets"][i], 0.0])
        relation = sk.LagrangianLinearTIR(directions, offset)
        law = sk.NewtonImpactFrictionNSL(scene["eps"][i], 0.0, scene["mu"][i], 2)
        contacts.append(sk.Interaction(law, relation))
        parts += [directions, offset, relation, law]
        system.link(contacts[-1], body)
    integrator = sk.MoreauJeanOSI(scene["theta"])
    integrator.setConstraintActivationThreshold(ON_POLE)
    integrator.setIsWSymmetricDefinitePositive(True)  # M + (theta dt)^2 K: halves the time
    problem = sk.FrictionContact(2, getattr(sn, f"SICONOS_FRICTION_2D_{scene['solver']}"))
    clock = sk.TimeDiscretisation(0.0, scene["step"])
    simulation = sk.TimeStepping(system, clock, integrator, problem)
    simulation.setNewtonOptions(sk.SICONOS_TS_LINEAR)  # nothing here is nonlinear but the laws
    kept = (mass, stiffness, force, q, u, system, integrator, problem, clock, *parts)
    return Scene(body, simulation, contacts, kept)


def state_of(contact: Any) -> int:
    """State of a contact by its impulse and its velocity in the last step."""
    if contact.lambda_(1)[0] <= 0.0:
        return OPEN
    slip = contact.y(1)[1]
    if abs(slip) <= STILL:
        return STICK
    return FORWARD if slip > 0.0 else BACKWARD


def run(scene: dict[str, Any]) -> dict[str, Any]:
    """Step until the end or the last return; report samples, returns, steps and CPU seconds."""
    toy = build(scene)
    simulation, contacts = toy.simulation, toy.contacts
    q, u = toy.body.q(), toy.body.velocity()  # views: Siconos writes into them
    step, every, last = scene["step"], scene["samples"], scene["returns"]
    samples = [[0.0, *q, *u]] if every else []
    returns: list[list[float]] = []
    states: list[list[int]] = []
    steps, rate = 0, 0.0
    start = time.process_time()
    while simulation.hasNextEvent():
        simulation.computeOneStep()
        steps += 1
        if scene["states"]:
            states.append([state_of(contact) for contact in contacts])
        if every and steps % every == 0:
            samples.append([steps * step, *q, *u])
        if rate < 0.0 <= u[2] and state_of(contacts[LOWER]) == STICK:
            late = step * u[2] / (u[2] - rate)
            returns.append([steps * step - late, q[0] - late * u[0], q[2] - 0.5 * late * u[2]])
            if len(returns) == last:
                break
        rate = u[2]
        simulation.nextStep()  # forgets the impulses of contacts that have opened
    seconds = time.process_time() - start
    return {
        "samples": samples,
        "returns": returns,
        "states": states,
        "steps": steps,
        "seconds": seconds,
    }


if __name__ == "__main__":
    json.dump(run(json.load(sys.stdin)), sys.stdout)
