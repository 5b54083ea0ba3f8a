"""An impact oscillator in Siconos: the Moreau-Jean scheme with Newton's law of impact.

    /usr/bin/python3 studies/peers/siconos_impacts.py '{"w": 2.0, "zeta": 0.05, "F": 2.0, ...}'

Siconos comes with the system's Python, so this is a separate program that imports nothing of the
project; :mod:`studies.systems.peers` starts it. The argument holds the parameters of
x'' + 2 zeta x' + x = F cos(w t), the stop ``sigma``, the restitution ``eps``, the start ``x``,
``v``, ``t`` and the end ``t_end``, lists ``steps`` of step sizes [s], and how many ``rounds`` are
timed. The output is JSON: the last x and v for each step size, and the CPU times [ms] of all rounds
for the first of each list.
"""

from __future__ import annotations

import json
import math
import sys
import time
from typing import Any

import numpy as np
import siconos.kernel as sk

THETA = 0.5  # of the scheme: of second order but at impacts


def follow(wanted: dict[str, Any], step: float) -> list[float]:
    """The last x and v; the last step ends at a time."""
    long = wanted["t_end"] - wanted["t"]
    count = math.ceil(long / step)
    step = long / count
    q, u, force = np.array([wanted["x"]]), np.array([wanted["v"]]), np.zeros(1)
    mass, stiffness, damping = np.eye(1), np.eye(1), np.array([[2.0 * wanted["zeta"]]])
    body = sk.LagrangianLinearTIDS(q, u, mass)
    body.setKPtr(stiffness)
    body.setCPtr(damping)
    body.setFExtPtr(force)
    direction, offset = np.array([[-1.0]]), np.array([wanted["sigma"]])  # gap sigma - x
    relation = sk.LagrangianLinearTIR(direction, offset)
    law = sk.NewtonImpactNSL(wanted["eps"])
    contact = sk.Interaction(law, relation)
    system = sk.NonSmoothDynamicalSystem(0.0, long + step)
    system.insertDynamicalSystem(body)
    system.link(contact, body)
    integrator, problem = sk.MoreauJeanOSI(THETA), sk.LCP()
    clock = sk.TimeDiscretisation(0.0, step)
    simulation = sk.TimeStepping(system, clock, integrator, problem)
    at, speed, push = body.q(), body.velocity(), body.fExt()  # views of what Siconos works with
    for k in range(count):
        push[0] = wanted["F"] * math.cos(wanted["w"] * (wanted["t"] + (k + 0.5) * step))
        simulation.computeOneStep()
        simulation.nextStep()
    return [float(at[0]), float(speed[0])]


def main(wanted: dict[str, Any]) -> dict[str, Any]:
    """The last states, and the times of all rounds."""
    ends, times = [], []
    for steps in wanted["steps"]:
        ends.append([follow(wanted, step) for step in steps])
        spent = []
        for _ in range(wanted["rounds"]):
            start = time.process_time()
            follow(wanted, steps[0])
            spent.append(1e3 * (time.process_time() - start))
        times.append(spent)
    return {"ends": ends, "cpu_ms": times}


if __name__ == "__main__":
    print(json.dumps(main(json.loads(sys.argv[1]))))
