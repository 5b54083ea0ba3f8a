"""Parts of motions: the smooth phases and impacts of some returns, as the kernel has them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from woodpecker import Toy, return_map
from woodpecker.base.arrays import Floats, Ints
from woodpecker.mechanics.impacts import rates
from woodpecker.mechanics.modes import (
    CONTACT,
    DELASSUS,
    EPS,
    EXPANSION,
    FORCE,
    MU,
    PAIR,
    SUMMED,
    mode_states,
    model,
)
from woodpecker.motion.codes import EVENT_COLUMNS, IMPACT, NO_PATH, PHASE_COLUMNS
from woodpecker.motion.events import next_event
from woodpecker.motion.flow import measure
from woodpecker.simulation import calls

EVENTS = 60  # room for one return
HALVINGS = 40  # of a distance of starts, down to 1e-14 rad
NEAR = 10.0 ** -np.arange(3.0, 11.0)  # rad; distances from an edge, above the error of the edge


class Phase(NamedTuple):
    """A smooth phase and the event that ends it."""

    z: Floats  # state at its start, (7,)
    mode: int
    before: int  # guard that began it, -1 for none
    time: float  # s, its length
    guard: int  # that ends it


class Impacts(NamedTuple):
    """Compressions and expansions of k impacts, padded to two contacts; (N, T) of each in turn."""

    size: Ints  # (k,) contacts that take part
    delassus: Floats  # (k, 4, 4)
    free: Floats  # (k, 4) relative velocities [m/s]
    mu: Floats  # (k, 2)
    floor: Floats  # (k, 2) smallest normal impulses [N s]
    first: Ints  # (k,) where the table of the two contacts begins in the model; 0 for one contact
    coupling: Floats  # (k,) what the other normal impulse adds to a bound of friction, over mu


class Smooth(NamedTuple):
    """Smooth phases as compiled code wants them."""

    table: Floats
    z: Floats  # (n, 7)
    modes: Ints
    before: Ints
    times: Floats


def recorded(toy: Toy, begin: Floats) -> tuple[list[Phase], Impacts]:
    """Smooth phases and impacts of the returns from these starts, as in the kernel."""
    table = model(toy)
    phases: list[Phase] = []
    gaps = np.zeros(3)
    impacts: list[tuple[Ints, Floats, Floats]] = []
    for phi_s in begin:
        rows, happened = _one_return(table, phi_s)
        before = -1
        for row in rows:
            mode = int(row[7])
            states = np.array(mode_states(mode))
            measure(table, row[:7], gaps)
            time, guard = next_event(table, mode, row[:7], gaps, states, True, math.inf, before, -1)
            phases.append(Phase(row[:7].copy(), mode, before, time, guard))
            before = guard
        for event in happened:
            impacts += _phases_of_impact(table, event)
    return phases, _padded(table, impacts)


def beside_edges(toy: Toy, begin: Floats) -> Floats:
    """Starts on both sides of every change of word between neighbours, closer and closer to it.

    There a guard just reaches zero, or just does not: the events that are easy to miss.
    """
    low, high = begin[:-1].copy(), begin[1:].copy()
    words = return_map(toy, begin).words
    change = np.array([one != other for one, other in pairwise(words)])
    low, high, left = low[change], high[change], np.array(words[:-1])[change]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = np.array(return_map(toy, middle).words) == left
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.concatenate([edge + sign * NEAR for edge in low for sign in (-1.0, 1.0)])


def _one_return(table: Floats, phi_s: float) -> tuple[Floats, Floats]:
    """Phases and events of one return, as :func:`woodpecker.simulation.calls.run` leaves them."""
    phases = np.zeros((EVENTS, PHASE_COLUMNS))
    happened = np.zeros((EVENTS, EVENT_COLUMNS))
    z, counts = np.zeros(7), np.zeros(3, np.int64)
    z[1], z[2] = -table[CONTACT + 1, 0], phi_s
    calls.run(
        table, z, np.array([0, 1, 0]), True, math.inf, np.zeros(EVENTS, np.int16), phases,
        NO_PATH, happened, counts,
    )  # fmt: skip
    return phases[: counts[1]], happened[: counts[2]]


def _phases_of_impact(table: Floats, event: Floats) -> list[tuple[Ints, Floats, Floats]]:
    """Contacts, free velocities and floors of the compression, and of the expansion if any."""
    code = int(event[1])
    if code == 0 or code % 64 // 8 != IMPACT:
        return []
    hit = np.array([i for i in range(3) if code % 8 >> i & 1])
    z = np.concatenate([np.zeros(3), event[2:5], [0.0]])
    free = np.concatenate([rates(table, i, z) for i in hit])
    columns = np.concatenate([8 + (0 if i == 0 else 2) + np.arange(2) for i in hit])
    compression = event[columns]
    out = [(hit, free, np.zeros(len(hit)))]
    floor = table[CONTACT + hit, EPS] * compression[::2]
    if floor.any():
        pick = np.concatenate([[2 * i, 2 * i + 1] for i in hit])
        after = free + table[DELASSUS + pick][:, pick] @ compression
        after[np.abs(after) < 1e-12 * np.abs(free).max()] = 0.0  # contacts that came to rest
        out.append((hit, after, floor))
    return out


def _padded(table: Floats, impacts: Sequence[tuple[Ints, Floats, Floats]]) -> Impacts:
    k = len(impacts)
    out = Impacts(
        np.zeros(k, np.int64), np.zeros((k, 4, 4)), np.zeros((k, 4)), np.zeros((k, 2)),
        np.zeros((k, 2)), np.zeros(k, np.int64), np.zeros(k),
    )  # fmt: skip
    for row, (hit, free, floor) in enumerate(impacts):
        n = len(hit)
        pick = np.concatenate([[2 * i, 2 * i + 1] for i in hit])
        out.size[row] = n
        out.delassus[row, : 2 * n, : 2 * n] = table[DELASSUS + pick][:, pick]
        out.free[row, : 2 * n], out.floor[row, :n] = free, floor
        out.mu[row, :n] = table[CONTACT + hit, MU]
        if n == 2:
            summed = bool(floor.any() and table[FORCE, SUMMED])  # elsewhere it is Coulomb's table
            out.first[row] = PAIR + 36 * (hit[1] - 1) + EXPANSION * summed
            out.coupling[row] = float(summed)
    return out


def thinned(impacts: Impacts, count: int) -> Impacts:
    """About ``count`` of them, evenly spread."""
    stride = max(1, len(impacts.size) // count)
    return Impacts._make(column[::stride] for column in impacts)


def gathered(toy: Toy, phases: Sequence[Phase]) -> Smooth:
    """The columns of some phases."""
    z, modes, before, times, _ = zip(*phases, strict=True)
    return Smooth(model(toy), np.array(z), np.array(modes), np.array(before), np.array(times))
