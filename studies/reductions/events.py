"""(d) Isolated roots: the first event from closed forms, against sampling of all guards."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from studies.common.clocks import clocked, over, race
from studies.common.record import Results
from studies.reductions.motions import Phase, Smooth, gathered
from studies.reductions.plan import Plan
from woodpecker import Toy
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics import free_frequency
from woodpecker.mechanics.modes import GUARDS, KAPPA, OMEGA, SECTION, mode_states
from woodpecker.motion.events import next_event, starting_jet, time_to_minimum
from woodpecker.motion.flow import measure
from woodpecker.motion.guards import bracketed, value

SAME_TIME = 1e-9  # s; events further apart are different ones
LONGEST = 0.5  # s; phases next to free fall last for seconds and only make sampling dearer
LOOK_AHEAD = 2.0 * LONGEST  # where sampling gives up
GRAZED = Toy(eps_n1=0.2)  # whose sleeve grazes the pole at many changes of word


def events(phases: Sequence[Phase], hard: Sequence[Phase], plan: Plan) -> Results:
    """Cost of both ways on phases of the map; failures there, and on phases next to grazing."""
    swing = 1.0 / free_frequency(Toy())
    usual, grazing = gathered(Toy(), phases), gathered(GRAZED, hard)
    jobs = {"isolated": clocked(partial(isolated, usual), 3, len(phases))}
    for n in plan.densities:
        jobs[str(n)] = clocked(partial(sampled, usual, swing / n), 1, len(phases))
    timings = race(jobs, plan.rounds)
    sampling = [
        {
            "per_swing": n,
            "missed": wrong(phases, *sampled(usual, swing / n)),
            "missed_next_to_grazing": wrong(hard, *sampled(grazing, swing / n)),
            "ratio": over(timings, str(n), "isolated"),
        }
        for n in plan.densities
    ]
    reliable = next((row for row in sampling if not row["missed_next_to_grazing"]), None)
    return {
        "phases": len(phases),
        "phases_next_to_grazing": len(hard),
        "isolated_missed": earlier(usual, swing / plan.densities[-1])
        + earlier(grazing, swing / plan.densities[-1]),
        "shortest_dip": shortest_dip(grazing.table, hard),
        "sampling": sampling,
        "reliable_per_swing": reliable["per_swing"] if reliable else None,
        "reason": None if reliable else "events were missed at every density tried",
        "timings": timings,
    }


def isolated(smooth: Smooth) -> tuple[Floats, Ints]:
    """Time and guard of the first event of each phase, as the kernel finds them."""
    times, which = np.empty(len(smooth.modes)), np.empty(len(smooth.modes), np.int64)
    _isolate(*smooth[:4], times, which)
    return times, which


def sampled(smooth: Smooth, step: float) -> tuple[Floats, Ints]:
    """The same by looking at all guards every ``step`` seconds."""
    times, which = np.empty(len(smooth.modes)), np.empty(len(smooth.modes), np.int64)
    _sample(*smooth[:4], step, times, which)
    return times, which


def short(phases: Sequence[Phase]) -> list[Phase]:
    """Those that sampling can be asked to follow."""
    return [phase for phase in phases if phase.time < LONGEST]


def earlier(smooth: Smooth, step: float) -> int:
    """Events that sampling finds before the one that isolation calls the first."""
    return int((sampled(smooth, step)[0] < smooth.times - SAME_TIME).sum())


def wrong(phases: Sequence[Phase], times: Floats, which: Ints) -> int:
    """Number of events that are not the first of their phase."""
    found = zip(phases, times, which, strict=True)
    return sum(int(p.guard != guard or abs(p.time - time) > SAME_TIME) for p, time, guard in found)


def shortest_dip(table: Floats, phases: Sequence[Phase]) -> float:
    """Shortest time [s] for which a guard that ends a phase would stay negative if ignored."""
    shortest, gaps = math.inf, np.zeros(3)
    for phase in phases:
        if phase.guard == SECTION:
            continue
        states = np.array(mode_states(phase.mode))
        measure(table, phase.z, gaps)
        jet = starting_jet(table, phase.mode, phase.guard, phase.z, gaps, states, phase.before)
        kappa, omega = table[phase.mode, KAPPA], table[phase.mode, OMEGA]
        ahead = phase.time + np.geomspace(1e-9, 0.01, 1000)
        up = [t for t in ahead if value(*jet, kappa, omega, t)[0] > 0.0]
        if up:
            shortest = min(shortest, up[0] - phase.time)
    return float(shortest)


@jit
def _states(mode: int, states: Ints) -> None:
    """States of the contacts in a mode, as in modes.mode_states."""
    sleeve = mode % 7
    states[0] = mode // 7
    states[1] = sleeve if sleeve <= 3 else 0
    states[2] = sleeve - 3 if sleeve > 3 else 0


@jit
def _isolate(
    table: Floats, z: Floats, modes: Ints, before: Ints, times: Floats, which: Ints
) -> None:
    states, gaps = np.zeros(3, dtype=np.int64), np.zeros(3)
    for k in range(len(modes)):
        _states(modes[k], states)
        measure(table, z[k], gaps)
        times[k], which[k] = next_event(
            table, modes[k], z[k], gaps, states, True, math.inf, before[k], -1
        )


@jit
def _sample(
    table: Floats, z: Floats, modes: Ints, before: Ints, step: float, times: Floats, which: Ints
) -> None:
    """First change of sign of a guard between two samples, then Newton's method for its root."""
    states, jets, gaps = np.zeros(3, dtype=np.int64), np.zeros((5, 4)), np.zeros(3)
    for k in range(len(modes)):
        mode = modes[k]
        _states(mode, states)
        measure(table, z[k], gaps)
        kappa, omega = table[mode, KAPPA], table[mode, OMEGA]
        end, fired, n = LOOK_AHEAD, -1, 0
        while n < 5 and table[mode, GUARDS + n] >= 0:
            guard = int(table[mode, GUARDS + n])
            if guard == SECTION:
                end, fired = time_to_minimum(table, mode, z[k]), guard
                break  # the last one
            jets[n, 0], jets[n, 1], jets[n, 2], jets[n, 3] = starting_jet(
                table, mode, guard, z[k], gaps, states, before[k]
            )
            n += 1
        low = 0.0
        while low < end:
            high = min(low + step, end)
            for i in range(n):
                f0, f1, f2, f3 = jets[i, 0], jets[i, 1], jets[i, 2], jets[i, 3]
                if value(f0, f1, f2, f3, kappa, omega, high)[0] < 0.0:
                    root = bracketed(f0, f1, f2, f3, kappa, omega, low, high)
                    if root < end:
                        end, fired = root, int(table[mode, GUARDS + i])
            low = high
        times[k], which[k] = end, fired
