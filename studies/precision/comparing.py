"""Evaluation of the rows: the cheapest peer for an error, and orders of convergence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from studies.peers.cases import CYCLE, distance, same_events
from studies.peers.ode import first_return_ode
from studies.precision.measuring import Row, name
from studies.precision.methods import OURS, Plan
from studies.precision.tasks import FIXED

TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)  # errors [rad] of the table
EXPECTED = {  # order of the error in the step, and why
    "RK45": (5.0, "the formula and its interpolant, with which events are located"),
    "DOP853": (8.0, "the formula and its interpolant, with which events are located"),
    "Radau": (4.0, "the formula has order 5, but its cubic interpolant locates the events"),
    "Moreau, theta": (1.0, "an impact waits for the end of its step"),
    "Moreau, midpoint": (1.0, "an impact waits for the end of its step"),
    "Siconos": (1.0, "an impact waits for the end of its step"),
}
FINEST = 3  # steps whose slope tells whether the error still falls
FITTED = (1e-12, 1e-2)  # rad; above, the motion is another one, below, it is rounding. A ladder
# that has no two errors in it is fitted as a whole


def compared(rows: Sequence[Row]) -> list[Row]:
    """For each target error the cheapest peer that reaches it, and its time over the kernel's.

    A point with a wrong word counts for the peer.
    """
    kernel = rows[0]
    lines = []
    for target in TARGETS:
        able = [r for r in rows if r["method"] not in OURS and reaches(r, target)]
        best = min(able, key=lambda r: r["cpu"], default=None)
        lines.append({
            "error_below": target,
            "kernel_reaches": reaches(kernel, target),
            "peer": name(best) if best else None,
            "peer_cpu": best["cpu"] if best else None,
            "kernel_cpu": kernel["cpu"],
            "ratio": best["cpu"] / kernel["cpu"] if best else None,
            "reason": None if best else "no peer reaches this error at any setting measured",
        })  # fmt: skip
    return lines


def reaches(row: Row, target: float) -> bool:
    """Whether the error of a row is known and small enough."""
    return row["error"] is not None and row["error"] <= target


def ahead(rows: Sequence[Row]) -> bool:
    """Whether the compiled kernel reaches every target, and no peer below 1e-3 is as quick."""
    kernel, others = rows[0], [r for r in rows[1:] if r["method"] not in OURS]
    quicker = [r for r in others if reaches(r, max(TARGETS)) and r["cpu"] <= kernel["cpu"]]
    return reaches(kernel, min(TARGETS)) and not quicker


def orders(tasks: dict[str, list[Row]], plan: Plan) -> list[Row]:
    """Orders of convergence: the slope of log error over log step, expected and fitted.

    For Runge-Kutta methods, on the cycle, the error control is switched off (rtol = 1000) and
    max_step is the step; evaluations grow like its inverse. LSODA changes its order as it goes,
    so it has none to fit. Time stepping is fitted on every task. On the map it converges to another
    motion at one start, where the beak sticks during compression (``I1s``): its impact law is
    Newton's, and there Poisson's law says something else.
    """
    lines = []
    for solver in ("RK45", "DOP853", "Radau"):
        ladder = []
        for k in range(plan.halvings):
            step = 4e-3 / 2**k
            once = first_return_ode(CYCLE.toy, CYCLE.phi_s, solver, 1e3, 1e3, step)
            if same_events(once.word, CYCLE.word):
                ladder.append((step, distance(once.phi_s, CYCLE.image)))
        lines.append(order_of(CYCLE.name, solver, "", ladder))
    for task, rows in tasks.items():
        ladders: dict[tuple[str, str], list[tuple[float, float]]] = {}
        for row in rows:
            if row["knob"] == "step" and row["error"] is not None and task != FIXED:
                key = row["method"], row["variant"]
                ladders.setdefault(key, []).append((row["value"], row["error"]))
        lines += [order_of(task, *key, ladder) for key, ladder in ladders.items()]
    return lines


def order_of(task: str, method: str, variant: str, ladder: Sequence[tuple[float, float]]) -> Row:
    """One line: over which errors the slope was fitted, and whether there is convergence at all."""
    expected, why = EXPECTED[method]
    used = [(step, error) for step, error in ladder if FITTED[0] <= error <= FITTED[1]]
    used = used if len(used) >= 2 else list(ladder)
    fitted, finest = (_slope(used), _slope(used[-FINEST:])) if len(used) >= 2 else (None, None)
    return {
        "task": task,
        "method": method,
        "variant": variant,
        "expected": expected,
        "why": why,
        "fitted": fitted,
        "fitted_finest": finest,
        "reason": None if fitted is not None else "measured at one step only",
        "converges": None if finest is None else finest > 0.5 * expected,
        "steps": [used[0][0], used[-1][0]],
        "errors": [used[0][1], used[-1][1]],
        "points": len(used),
    }


def _slope(ladder: Sequence[tuple[float, float]]) -> float:
    log_steps, log_errors = np.log(np.array(ladder)).T
    return float(np.polyfit(log_steps, log_errors, 1)[0])
