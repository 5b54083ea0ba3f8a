"""P_j at many starts: the kernel finds what happens, following its path finds the derivatives."""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import borrowed, jit, part
from woodpecker.mechanics.modes import CONTACT, LIMIT
from woodpecker.simulation.following import follow
from woodpecker.simulation.kernel import (
    EVENT_COLUMNS,
    OPEN,
    PHASE_COLUMNS,
    RETURNED,
    ROOM,
    STEP_COLUMNS,
    STICK,
    search,
)
from woodpecker.simulation.margins import NOTES, ROUTE

SEPARATOR = 0  # between the returns of a word


@jit
def sweep(
    model: Floats, change: Floats, starts: Floats, order: int, seed: Floats, out: Floats,
    status: Ints, lengths: Ints, words: Codes,
) -> None:  # fmt: skip
    """P_order at many starts on the section.

    Parameters
    ----------
    model, change
        As :func:`woodpecker.simulation.following.follow` takes them.
    starts
        (n,) values of phi_S.
    seed
        (1, 3) direction in (eps_N1, eps_N2, eps_N3) to differentiate along.
    out
        (n, 5) output: phi_S, period, drop, d phi_S / d start, d phi_S along the parameter. The
        derivatives are nan where the toy does not return.
    status, lengths, words
        Output: (n,) why each run stopped, (n,) lengths of the words, (n, event limit) event codes.
    """
    phases = np.zeros((words.shape[1] + 1, PHASE_COLUMNS))
    path = np.zeros((words.shape[1] + 1, STEP_COLUMNS), dtype=np.int64)
    times, counts = np.zeros(len(phases)), np.zeros(3, dtype=np.int64)
    events, notes = np.zeros((0, EVENT_COLUMNS)), np.zeros((NOTES, 0))
    owner, route = np.zeros(1, dtype=ROOM), np.zeros(1, dtype=ROUTE)
    room = owner[0]
    for i in range(3):
        route[0].seeds[1, i] = seed[0, i]
    for n in range(len(starts)):
        for k in range(7):
            room.z[k] = 0.0
        room.z[1], room.z[2] = -model[CONTACT + 1, LIMIT], starts[n]
        counts[0], slope, along = 0, 1.0, 0.0
        for lap in range(order):
            if lap > 0 and counts[0] < words.shape[1]:
                words[n, counts[0]] = SEPARATOR
            counts[0] += 1 if lap > 0 else 0
            counts[1], start = 0, room.z[2]
            room.states[0], room.states[1], room.states[2] = OPEN, STICK, OPEN
            status[n] = search(
                borrowed(model), True, math.inf, borrowed(words[n]), borrowed(phases),
                borrowed(path), borrowed(events), borrowed(counts), room,
            )  # fmt: skip
            if status[n] != RETURNED:
                slope = along = math.nan
                break
            _find_times(phases, counts[1], room.z[6], times)
            taken = follow(
                borrowed(model), borrowed(change), borrowed(path)[: counts[1]], borrowed(times),
                start, borrowed(notes), route,
            )  # fmt: skip
            rate = route[0].tangents[0, 2] if taken == RETURNED else math.nan
            along = rate * along + route[0].tangents[1, 2]
            slope *= rate
        out[n, 0], out[n, 1], out[n, 2] = room.z[2], room.z[6], -room.z[0]
        out[n, 3], out[n, 4] = slope, along
        lengths[n] = min(counts[0], words.shape[1])
    owner[0].z[0] = 0.0  # it lives until here


@part
def _find_times(phases: Floats, n: int, end: float, times: Floats) -> None:
    """Durations of the phases of a return."""
    for k in range(n):
        times[k] = (phases[k + 1, 6] if k + 1 < n else end) - phases[k, 6]
