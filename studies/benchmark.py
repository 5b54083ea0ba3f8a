"""How fast and how exact is one return of the toy? The kernel against a general ODE solver.

    python -m studies.benchmark [--fast] [--out DIR]

All competitors run in turn, round after round, so that a busy machine hits them alike. Wall time
and CPU time (of the process) are kept of every round; ratios compare medians of CPU time.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from decimal import Decimal
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from pwmap.diagram import Diagram
from studies.peer_ode import IMAGE, PERIOD, PHI_S, first_return_ode
from woodpecker import Return, Toy, continuation, first_return, kernel, return_map, shoot
from woodpecker.compiled import COMPILED
from woodpecker.modes import model
from woodpecker.returns import EVENT_LIMIT

ROOT = Path(__file__).resolve().parents[1]
RTOL = 1e-10  # of the peer; its errors then are near 1e-10 rad
GUESS = -0.53  # rad, near the nominal cycle
WINDOW = (-2.5, -0.24)  # rad
NEEDS_NUMBA = "needs numba, which is not installed or switched off"

# One return in a process of its own: one measurement of `count` returns for each line it reads.
PLAIN = """
import sys, time, woodpecker
toy, phi_s = woodpecker.Toy(), float(sys.argv[1])
woodpecker.first_return(toy, phi_s)
print(flush=True)
for line in sys.stdin:
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(int(line)):
        woodpecker.first_return(toy, phi_s)
    print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)
"""
# Import, then the first return, in a fresh process.
FIRST = """
import sys, time
wall, cpu = [time.perf_counter()], [time.process_time()]
def note():
    wall.append(time.perf_counter()), cpu.append(time.process_time())
import woodpecker
note()
woodpecker.first_return(woodpecker.Toy(), float(sys.argv[1]))
note()
print(wall[1] - wall[0], cpu[1] - cpu[0], wall[2] - wall[1], cpu[2] - cpu[1])
"""


class Seconds(NamedTuple):
    """Wall and CPU time of one unit of work."""

    wall: float
    cpu: float


Job = Callable[[], Seconds]


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Seconds over all rounds."""

    rounds: int
    wall_median: float
    wall_minimum: float
    cpu_median: float
    cpu_minimum: float


def main(fast: bool = False) -> dict[str, Any]:
    """Measure everything; ``fast`` takes few rounds and does not compile from nothing.

    Returns
    -------
    dict
        ``timings`` (seconds for each job), ``ratio_*`` (CPU time over that of the compiled
        kernel), ``error_*`` (against the 30-digit reference), size of the main job's diagram,
        ``skipped`` (sentences) and ``environment``. What was skipped is None.
    """
    lap, peer = first_return(Toy(), PHI_S), first_return_ode(Toy(), PHI_S, rtol=RTOL)
    timings: dict[str, Timing] = {}
    with PlainKernel() as plain:
        jobs = {
            "return, kernel": sweep_job(1000 if COMPILED else 10),
            "return, first_return": clocked(
                lambda: first_return(Toy(), PHI_S), 200 if COMPILED else 10
            ),
            "return, plain Python": lambda: plain.seconds(10),
            "return, DOP853": clocked(lambda: first_return_ode(Toy(), PHI_S, rtol=RTOL)),
            "map of 1000 points": map_job(1000),
        }
        timings |= interleaved(jobs, 3 if fast else 25)
    skipped: dict[str, str] = {}
    timings |= interleaved(first_return_jobs(fast, skipped), 1 if fast else 2)
    diagrams: list[Diagram] = []
    if fast and not COMPILED:
        skipped["continuation"] = NEEDS_NUMBA
    else:
        timings |= interleaved({"continuation": main_job(diagrams)}, 1 if fast else 3)
    return {
        **ratios(timings, skipped),
        **errors(lap, peer.phi_s, peer.period),
        "word": lap.word,
        "word_peer": peer.word,
        "evaluations_peer": peer.evaluations,
        "branches": len(diagrams[0].branches) if diagrams else None,
        "points": len(diagrams[0].points) if diagrams else None,
        "timings": {name: asdict(timing) for name, timing in timings.items()},
        "skipped": skipped,
        "environment": environment(),
    }


def clocked(work: Callable[[], object], repeats: int = 1) -> Job:
    """Job that repeats some work and reports the time of one repetition."""

    def job() -> Seconds:
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(repeats):
            work()
        return Seconds(
            (time.perf_counter() - wall) / repeats, (time.process_time() - cpu) / repeats
        )

    return job


def interleaved(jobs: dict[str, Job], rounds: int) -> dict[str, Timing]:
    """Run all jobs in turn, round after round, after one round that does not count."""
    seconds: dict[str, list[Seconds]] = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, job in jobs.items():
            seconds[name].append(job())
    return {
        name: Timing(
            rounds=rounds,
            wall_median=statistics.median(each.wall for each in taken),
            wall_minimum=min(each.wall for each in taken),
            cpu_median=statistics.median(each.cpu for each in taken),
            cpu_minimum=min(each.cpu for each in taken),
        )
        for name, taken in seconds.items()
    }
