"""How fast and how accurate is one return of the toy? The kernel against a general ODE solver.

    python -m studies.benchmark [--fast] [--out DIR]

Both run alternately in many rounds, so that a busy machine slows them down alike; wall and CPU time
of every round are kept. The kernel also computes the derivatives of the return with respect to
phi_S and eps_N1; the peer (:mod:`studies.peers.ode`) does not.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from pwmap.diagrams.diagram import Diagram
from studies.common.clocks import (
    Job,
    Seconds,
    Timing,
    clocked,
    race,
    ratio,
    shared,
    summary,
)
from studies.common.motion import GUESS
from studies.common.places import WINDOW
from studies.common.record import Results, command, environ
from studies.peers.cases import distance
from studies.peers.kernel import PlainPython
from studies.peers.ode import IMAGE, PERIOD, PHI_S, first_return_ode
from woodpecker import Toy, continuation, first_return, return_map, shoot
from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import COMPILED
from woodpecker.mechanics.modes import NO_RATES, model
from woodpecker.simulation.calls import sweep

RTOL = 1e-10  # of the peer, whose error then is of the same size

COMPILED_RETURN, CALLED_RETURN = "one return, compiled kernel", "one return, first_return()"
PLAIN_RETURN, PEER_RETURN = "one return, plain Python kernel", "one return, DOP853 rtol 1e-10"
MAP, MAIN_JOB = "map of 1000 points, one core", "continuation in eps_N1"
IMPORT, COLD, WARM = "import woodpecker", "first call, compiling", "first call, from the cache"

# The program of a fresh process: it measures its own start.
START = """
import sys, time
clocks = [(time.perf_counter(), time.process_time())]
import woodpecker
clocks.append((time.perf_counter(), time.process_time()))
woodpecker.first_return(woodpecker.Toy(), float(sys.argv[1]))
clocks.append((time.perf_counter(), time.process_time()))
for before, after in zip(clocks, clocks[1:]):
    print(*(b - a for a, b in zip(before, after)))
"""


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure everything.

    Parameters
    ----------
    fast
        Take few rounds and do not compile from nothing.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``ratio_*``: time of the peer and of the plain kernel over that of the compiled one
        (medians of CPU time, ``*_wall`` of wall time; ``ratio_peer_call``: over a call of
        ``first_return``). ``error_*``: distance from the 30-digit reference [rad], [s].
        ``branches``, ``points`` of the main job. ``timings``: seconds of every job. ``skipped``:
        why a number is None.
    """
    once, peer = first_return(Toy(), PHI_S), first_return_ode(Toy(), PHI_S, rtol=RTOL)
    skipped: dict[str, str] = {}
    timings = returns(3 if fast else 25)
    timings |= starts(1 if fast else 2, cold=not fast)
    if fast:
        skipped[COLD] = "left out of the fast run"
    diagram: Diagram | None = None
    if COMPILED:
        timings[MAIN_JOB], diagram = main_job(1 if fast else 3)
    else:
        reason = "needs numba, which is not installed or switched off"
        skipped |= dict.fromkeys((COMPILED_RETURN, COLD, WARM), reason)
        skipped[MAIN_JOB] = f"takes some minutes: {reason}"
    return {
        "ratio_peer": ratio(timings, PEER_RETURN, COMPILED_RETURN, "cpu"),
        "ratio_peer_wall": ratio(timings, PEER_RETURN, COMPILED_RETURN, "wall"),
        "ratio_peer_call": ratio(timings, PEER_RETURN, CALLED_RETURN, "cpu"),
        "ratio_plain": ratio(timings, PLAIN_RETURN, COMPILED_RETURN, "cpu"),
        "ratio_plain_wall": ratio(timings, PLAIN_RETURN, COMPILED_RETURN, "wall"),
        "error_kernel": distance(once.phi_s, IMAGE),
        "error_peer": distance(peer.phi_s, IMAGE),
        "error_period_kernel": distance(once.period, PERIOD),
        "error_period_peer": distance(peer.period, PERIOD),
        "word": once.word,
        "word_peer": peer.word,
        "evaluations_peer": peer.evaluations,
        "branches": len(diagram.branches) if diagram else None,
        "points": len(diagram.points) if diagram else None,
        "timings": timings,
        "skipped": skipped,
    }


def returns(rounds: int) -> dict[str, Timing]:
    """One return in every way, and the map, in turn; the first round does not count."""
    toy = Toy()
    with ThreadPoolExecutor(1) as one_core, PlainPython() as plain:
        jobs: dict[str, Job] = {
            CALLED_RETURN: clocked(lambda: first_return(toy, PHI_S), 200 if COMPILED else 10),
            PLAIN_RETURN: plain_job(plain),
            PEER_RETURN: clocked(lambda: first_return_ode(toy, PHI_S, rtol=RTOL)),
            MAP: clocked(lambda: map_window(toy, one_core)),
        }
        if COMPILED:
            jobs = {COMPILED_RETURN: clocked(equal_starts(toy, 1000), units=1000), **jobs}
        return race(jobs, rounds)


def equal_starts(toy: Toy, n: int) -> Callable[[], Floats]:
    """Work of n equal returns in one call of the kernel, in this thread; gives their images."""
    numbers, seed = model(toy), np.eye(3)[:1]
    begin = np.full(n, PHI_S)

    def work() -> Floats:
        return sweep(numbers, NO_RATES, begin, 1, seed)[0][:, 0]

    return work


def map_window(toy: Toy, executor: Executor) -> None:
    """P_1 at 1000 points."""
    return_map(toy, np.linspace(*WINDOW, 1000), executor=executor)


def plain_job(plain: PlainPython) -> Job:
    """Job of one return in plain Python, the mean of ten."""

    def job() -> Seconds:
        _, seconds = plain.ask("studies.benchmark:listed_starts", 10)
        return shared(seconds, 10)

    return job


def listed_starts(n: int) -> Callable[[], list[float]]:
    """Like :func:`equal_starts`, for another process."""
    work = equal_starts(Toy(), n)
    return lambda: work().tolist()


def _seconds(line: str) -> Seconds:
    wall, cpu = map(float, line.split())
    return Seconds(wall, cpu)


def starts(rounds: int, cold: bool) -> dict[str, Timing]:
    """Import and first return in fresh processes; if ``cold``, first with an empty cache."""
    taken: dict[str, list[Seconds]] = {}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as empty:
            variables = environ(NUMBA_CACHE_DIR=empty) if cold else environ()
            for name in (COLD, WARM) if cold else (WARM,):
                imported, called = (_seconds(line) for line in _start(variables).splitlines())
                taken.setdefault(IMPORT, []).append(imported)
                taken.setdefault(name, []).append(called)
    if not COMPILED:
        taken = {IMPORT: taken[IMPORT]}
    return {name: summary(seconds) for name, seconds in taken.items()}


def _start(variables: dict[str, str]) -> str:
    program = [sys.executable, "-c", START, repr(PHI_S)]
    return subprocess.run(
        program, env=variables, stdout=subprocess.PIPE, text=True, check=True
    ).stdout


def main_job(rounds: int) -> tuple[Timing, Diagram]:
    """Shoot, then follow every connected branch over eps_N1 in [0, 1]."""
    found: list[Diagram] = []
    job = clocked(lambda: found.append(continuation(Toy(), shoot(Toy(), GUESS))))
    return summary([job() for _ in range(rounds)]), found[-1]


if __name__ == "__main__":
    command(main, "benchmark")
