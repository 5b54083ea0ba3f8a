"""An impact oscillator in PyDSTool: from impact to impact, found by its events.

    python3.9 studies/peers/pydstool_impacts.py '{"w": 2.0, "zeta": 0.05, "F": 2.0, ...}'

PyDSTool needs older versions of numpy and scipy than the project, so this is a separate program
that imports nothing of it; :mod:`studies.systems.peers` starts it. The argument holds the
parameters of x'' + 2 zeta x' + x = F cos(w t), the stop ``sigma``, the restitution ``eps``, the
start ``x``, ``v``, ``t`` and the end ``t_end``, ``tolerances``, and how many ``rounds`` are timed.
The output is JSON: the last x and v, and the CPU times [ms] of all rounds, for each tolerance.
"""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # PyDSTool talks, too

import PyDSTool  # noqa: E402  what follows may print

FIRST = 1e-2  # s, the first step
IMPACTS = 20  # more say that something is wrong


def model(wanted: dict[str, Any], tolerance: float) -> Any:
    """The flight, which ends where the stop is reached."""
    stop = PyDSTool.makeZeroCrossEvent(
        "x - sigma", 1,
        {
            "name": "stop", "term": True, "active": True, "eventtol": tolerance, "precise": True,
            "eventdelay": FIRST,
        },
        varnames=["x"], parnames=["sigma"],
    )  # fmt: skip
    names = "w", "zeta", "F", "sigma"
    return PyDSTool.Generator.Vode_ODEsystem(
        PyDSTool.args(
            name="flight", varspecs={"x": "v", "v": "F*cos(w*t) - 2*zeta*v - x"},
            pars={name: wanted[name] for name in names}, ics={"x": 0.0, "v": 0.0},
            algparams={"atol": tolerance, "rtol": tolerance, "init_step": FIRST}, events=[stop],
        )
    )  # fmt: skip


def follow(flight: Any, wanted: dict[str, Any]) -> list[float]:
    """The last x and v."""
    t, x, v = wanted["t"], wanted["x"], wanted["v"]
    for _ in range(IMPACTS):
        flight.set(ics={"x": x, "v": v}, tdata=[t, wanted["t_end"]])
        motion = flight.compute("motion")
        found = motion.getEvents("stop")
        if found is None:
            end = motion(wanted["t_end"])
            return [float(end["x"]), float(end["v"])]
        t, x = float(found["t"][0]), wanted["sigma"]
        v = -wanted["eps"] * float(found["v"][0])
    raise ArithmeticError("the oscillator does not come to its end")


def main(wanted: dict[str, Any]) -> dict[str, Any]:
    """The last states, and the times of all rounds."""
    ends, times = [], []
    for tolerance in wanted["tolerances"]:
        flight, spent = model(wanted, tolerance), []
        ends.append(follow(flight, wanted))
        for _ in range(wanted["rounds"]):
            start = time.process_time()
            follow(flight, wanted)
            spent.append(1e3 * (time.process_time() - start))
        times.append(spent)
    return {"ends": ends, "cpu_ms": times}


if __name__ == "__main__":
    print(json.dumps(main(json.loads(sys.argv[1]))), file=answers, flush=True)
