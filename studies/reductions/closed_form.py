"""(a) Closed form: a smooth phase as one oscillator, against numerical integration."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from scipy.integrate import DOP853

from studies.common.clocks import Job, clocked, over, race, repeated
from studies.common.record import Results
from studies.peers.cases import CYCLE, distance, numbers
from studies.peers.kernel import PlainPython
from studies.peers.ode import first_return_ode
from studies.reductions.motions import Smooth, gathered, recorded
from studies.reductions.plan import Plan
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics.modes import A, B
from woodpecker.motion.flow import flow

TABLEAU = (np.array(DOP853.A), np.array(DOP853.B))  # of order 8, as in scipy
SMOOTH_TARGET = 1e-10  # rad; error at which integration is compared with the closed form


def closed_form(other: PlainPython, plan: Plan) -> Results:
    """The cycle in Python, with its events; its smooth phases alone, compiled."""
    toy = CYCLE.toy
    phases, _ = recorded(toy, np.array([CYCLE.phi_s]))
    rtol, once = 1e-3, first_return_ode(toy, CYCLE.phi_s, rtol=1e-3, atol=1e-5)
    while distance(once.phi_s, CYCLE.image) > SMOOTH_TARGET:
        rtol /= 10.0
        once = first_return_ode(toy, CYCLE.phi_s, rtol=rtol, atol=1e-2 * rtol)
    smooth = gathered(toy, phases)
    exact, steps = closed(smooth), 1
    while apart(exact, integrated(smooth, steps)) > SMOOTH_TARGET:
        steps += 1
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(toy), [CYCLE.phi_s])
    jobs: dict[str, Job] = {
        "python_closed": lambda: ask(count=5)[1],
        "python_integrated": clocked(
            lambda: first_return_ode(toy, CYCLE.phi_s, rtol=rtol, atol=1e-2 * rtol)
        ),
        "closed": repeated(partial(closed, smooth)),
        "integrated": repeated(partial(integrated, smooth, steps)),
    }
    timings = race(jobs, plan.rounds)
    return {
        "rtol": rtol,
        "error_python": distance(once.phi_s, CYCLE.image),
        "steps": steps,
        "step": float(smooth.times.max() / steps),
        "error": apart(exact, integrated(smooth, steps)),
        "ratio_python": over(timings, "python_integrated", "python_closed"),
        "ratio": over(timings, "integrated", "closed"),
        "timings": timings,
    }


def closed(smooth: Smooth) -> Floats:
    """Ends of the phases by the closed form."""
    out = np.empty((len(smooth.modes), 7))
    _flows(smooth.table, smooth.z, smooth.modes, smooth.times, out)
    return out


def integrated(smooth: Smooth, steps: int) -> Floats:
    """Ends of the phases by this many steps in the longest, in proportion in the others."""
    out = np.empty((len(smooth.modes), 7))
    _runge_kutta(smooth.table, smooth.z, smooth.modes, smooth.times, steps, *TABLEAU, out)
    return out


def apart(one: Floats, other: Floats) -> float:
    """Largest difference in a coordinate [m] or [rad]."""
    return float(np.abs(one[:, :3] - other[:, :3]).max())


@jit
def _flows(table: Floats, z: Floats, modes: Ints, times: Floats, out: Floats) -> None:
    for k in range(len(modes)):
        flow(table, modes[k], z[k], times[k], out[k])


@jit
def _runge_kutta(
    table: Floats, z: Floats, modes: Ints, times: Floats, steps: int, a: Floats, b: Floats,
    out: Floats,
) -> None:  # fmt: skip
    """An explicit Runge-Kutta method with equal steps for q'' = A + B (phi_S - phi_M)."""
    slopes, x = np.zeros((len(b), 6)), np.zeros(6)
    longest = times.max()
    for k in range(len(modes)):
        mode, n = modes[k], math.ceil(steps * times[k] / longest)
        h = times[k] / n
        for j in range(6):
            out[k, j] = z[k, j]
        for _ in range(n):
            for stage in range(len(b)):
                for j in range(6):
                    x[j] = out[k, j]
                    for earlier in range(stage):
                        x[j] += h * a[stage, earlier] * slopes[earlier, j]
                for j in range(3):
                    slopes[stage, j] = x[3 + j]
                    slopes[stage, 3 + j] = table[mode, A + j] + table[mode, B + j] * (x[2] - x[1])
            for stage in range(len(b)):
                for j in range(6):
                    out[k, j] += h * b[stage] * slopes[stage, j]
