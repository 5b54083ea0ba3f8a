"""The entry to the kernel: one compiled function, whose first argument is the task."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import announce, jit, part
from woodpecker.mechanics.modes import CONTACT, LIMIT, NO_RATES, OPEN, STICK
from woodpecker.motion.codes import (
    EVENT_COLUMNS,
    PHASE_COLUMNS,
    RETURNED,
    RETURNED_NO_SLOPE,
    ROOM,
    STEP_COLUMNS,
)
from woodpecker.motion.run import search
from woodpecker.simulation.following import follow_path
from woodpecker.simulation.margins import NOTES, ROUTE

SEARCH, FOLLOW, SWEEP = range(3)  # tasks
EVENT_LIMIT = 1000  # events of one return; the longest seen on the paper's data has some 20
SEPARATOR = 0  # code between the returns of a word
START, OUT, STATUS, LENGTH = 0, 1, 6, 7  # columns of the starts of a sweep
START_COLUMNS = 8

WORK = np.dtype((np.record, [("room", ROOM), ("route", ROUTE)]))  # of a search and of a path
Work = npt.NDArray[Any]  # (1,) of WORK

NO_STARTS: Floats = np.zeros((0, START_COLUMNS))
NO_WORDS: Codes = np.zeros((0, 0), dtype=np.int16)
NO_PHASES: Floats = np.zeros((0, PHASE_COLUMNS))
NO_TIMES: Floats = np.zeros(0)
NO_EVENTS: Floats = np.zeros((0, EVENT_COLUMNS))
NO_NOTES: Floats = np.zeros((NOTES, 0))


@jit
def compute(
    task: int, model: Floats, change: Floats, to_section: bool, number: float, starts: Floats,
    words: Codes, phases: Floats, path: Ints, times: Floats, events: Floats, notes: Floats,
    work: Work,
) -> int:  # fmt: skip
    """Carry out a task of the kernel, in arrays of the caller; those not needed have length 0.

    The task is SEARCH (:func:`run`), FOLLOW (:func:`follow`) or SWEEP (:func:`sweep`); ``number``
    is the final time, phi_S, or the order. ``starts`` of a sweep are (n, START_COLUMNS): start,
    five results, status and length of the word; ``words`` (n, event limit), of a search one row;
    ``times`` takes the durations of the phases of a search; ``work`` is (1,).
    """
    return _carry_out(
        task, model, change, to_section, number, starts, words, phases, path, times, events, notes,
        work[0].room, work[0].route,
    )  # fmt: skip


@part
def _carry_out(
    task: int, model: Floats, change: Floats, to_section: bool, number: float, starts: Floats,
    words: Codes, phases: Floats, path: Ints, times: Floats, events: Floats, notes: Floats,
    room: np.record, route: np.record,
) -> int:  # fmt: skip
    """The same, as a part, because functions that only parts call are compiled once."""
    if task == SEARCH:
        status = search(model, to_section, number, words[0], phases, path, events, room)
        _find_durations(phases, room, times)
        return status
    if task == FOLLOW:
        return follow_path(model, change, path, times, number, notes, route)
    for n in range(len(starts)):
        _iterate(
            model, change, starts[n], int(number), words[n], phases, path, times, events, notes,
            room, route,
        )  # fmt: skip
    return RETURNED


@part
def _iterate(
    model: Floats, change: Floats, row: Floats, order: int, word: Codes, phases: Floats, path: Ints,
    times: Floats, events: Floats, notes: Floats, room: np.record, route: np.record,
) -> None:  # fmt: skip
    """P_order at one start of a sweep, and its derivatives by the chain rule."""
    z, counts, states, status = room.z, room.counts, room.states, RETURNED
    for k in range(7):
        z[k] = 0.0
    z[1], z[2] = -model[CONTACT + 1, LIMIT], row[START]
    counts[0], slope, along = 0, 1.0, 0.0
    for iterate in range(order):
        if iterate > 0 and counts[0] < len(word):
            word[counts[0]] = SEPARATOR
        counts[0] += 1 if iterate > 0 else 0
        counts[1], counts[2], start = 0, 0, z[2]
        states[0], states[1], states[2] = OPEN, STICK, OPEN
        status = search(model, True, math.inf, word, phases, path, events, room)
        if status != RETURNED:
            slope = along = math.nan
            break
        _find_durations(phases, room, times)
        taken = follow_path(model, change, path[: counts[1]], times, start, notes, route)
        rate = route.tangents[0, 2] if taken == RETURNED else math.nan
        along = rate * along + route.tangents[1, 2]
        slope *= rate
    if status == RETURNED and not (abs(slope) < math.inf and abs(along) < math.inf):
        status = RETURNED_NO_SLOPE
    row[OUT], row[OUT + 1], row[OUT + 2] = z[2], z[6], 0.0 - z[0]
    row[OUT + 3], row[OUT + 4] = slope, along
    row[STATUS], row[LENGTH] = status, min(counts[0], len(word))


@part
def _find_durations(phases: Floats, room: np.record, times: Floats) -> None:
    n = room.counts[1]
    for k in range(min(n, len(times))):
        times[k] = (phases[k + 1, 6] if k + 1 < n else room.z[6]) - phases[k, 6]


def make_work() -> Work:
    """Allocate the workspace of a task."""
    return np.zeros(1, dtype=WORK)


def run(
    model: Floats, z: Floats, states: Ints, to_section: bool, t_end: float, word: Codes,
    phases: Floats, path: Ints, events: Floats, counts: Ints,
) -> int:  # fmt: skip
    """Follow the toy from event to event to the section (if ``to_section``), ``t_end`` or a limit.

    The section is the next minimum of phi_S on the jammed sleeve. Changed in place: the state ``z``
    (7,), and ``states`` (3,) of the contacts; those with zero gap are decided anew. Buffers:
    ``word`` for event codes, whose length is the event limit; ``phases`` (n, PHASE_COLUMNS),
    ``path`` (n, STEP_COLUMNS) and ``events`` (n, EVENT_COLUMNS), of length 0 if not needed;
    ``counts`` (3,) of symbols, phases and events. Returns a code of why the run stopped.
    """
    work = make_work()
    room = work["room"][0]
    room["z"], room["states"], room["counts"] = z, states, counts
    reason = compute(
        SEARCH, model, NO_RATES, bool(to_section), float(t_end), NO_STARTS, word.reshape(1, -1),
        phases, path, NO_TIMES, events, NO_NOTES, work,
    )  # fmt: skip
    z[:], states[:], counts[:] = room["z"], room["states"], room["counts"]
    return reason


def follow(
    model: Floats, change: Floats, path: Ints, times: Floats, phi_s: float, notes: Floats,
    work: Work,
) -> int:  # fmt: skip
    """Follow a path from the section, see :func:`woodpecker.simulation.following.follow_path`."""
    return compute(
        FOLLOW, model, change, True, phi_s, NO_STARTS, NO_WORDS, NO_PHASES, path, times, NO_EVENTS,
        notes, work,
    )  # fmt: skip


def sweep(
    model: Floats, change: Floats, starts: Floats, order: int, seed: Floats
) -> tuple[Floats, Ints, Ints, Codes]:
    """P_order at many starts (n,) on the section, with derivatives along the paths.

    ``seed`` (1, 3) is the direction of the parameter in (eps_N1, eps_N2, eps_N3). Returns columns
    (n, 5): phi_S, period, drop, d phi_S / d start and d phi_S along the parameter, nan where the
    toy does not return; codes of why each run stopped (n,); lengths of the words (n,); event codes
    of the words (n, EVENT_LIMIT order).
    """
    limit, work = EVENT_LIMIT * order, make_work()
    rows, words = np.empty((len(starts), START_COLUMNS)), np.empty((len(starts), limit), np.int16)
    rows[:, START], work["route"]["seeds"][0, 1] = starts, seed[0]
    announce(compute)
    compute(
        SWEEP, model, change, True, float(order), rows, words, np.empty((limit + 1, PHASE_COLUMNS)),
        np.empty((limit + 1, STEP_COLUMNS), dtype=np.int64), np.empty(limit + 1), NO_EVENTS,
        NO_NOTES, work,
    )  # fmt: skip
    codes, lengths = rows[:, STATUS:].astype(np.int64).T
    return rows[:, OUT:STATUS].copy(), codes.copy(), lengths, words
