"""What a run records: symbols, phases, the path, and details of its events."""

from __future__ import annotations

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.modes import OPEN, SLIP, STICK
from woodpecker.motion.codes import (
    DETACH,
    EVENT_COLUMNS,
    MODE,
    REVERSAL,
    SLIP_START,
    STEP_COLUMNS,
    STICK_START,
)


@part
def append(word: Codes, counts: Ints, code: int) -> None:
    """Append a symbol to a word; symbols beyond the end of the buffer are only counted."""
    if counts[0] < len(word):
        word[counts[0]] = code
    counts[0] += 1


@part
def append_transitions(before: Ints, after: Ints, fired: int, word: Codes, counts: Ints) -> None:
    """Append a symbol for each contact that opened, stuck, began to slip or reversed."""
    for i in range(3):
        code = -1
        if after[i] == OPEN:
            if before[i] != OPEN:
                code = DETACH
        elif after[i] == STICK:
            if before[i] != STICK:
                code = STICK_START
        elif before[i] == STICK:
            code = SLIP_START
        elif fired >= SLIP and after[i] != before[i]:
            code = REVERSAL
        if code >= 0:
            append(word, counts, 8 * code + (1 << i))


@part
def record_phase(
    phases: Floats, path: Ints, counts: Ints, z: Floats, mode: int, decided: Ints
) -> None:
    """Append the start of a phase to the phases, and what was decided there to the path."""
    if counts[1] < len(phases):
        for k in range(7):
            phases[counts[1], k] = z[k]
        phases[counts[1], 7] = mode
        if len(path) > 0:
            for k in range(STEP_COLUMNS):
                path[counts[1], k] = decided[k]
            path[counts[1], MODE] = mode
        counts[1] += 1


@part
def record_events(
    events: Floats, counts: Ints, symbols: int, t: float, word: Codes, event: Floats
) -> None:
    """Append a row for each new symbol; the jump of velocities and impulses go to the first."""
    for k in range(symbols, min(counts[0], len(word))):
        if counts[2] >= len(events):
            return
        row = events[counts[2]]
        for c in range(EVENT_COLUMNS):
            row[c] = event[c]
        if k > symbols:
            for c in range(3):
                row[2 + c] = event[5 + c]
            for c in range(8, EVENT_COLUMNS):
                row[c] = 0.0
        row[0], row[1] = t, word[k]
        counts[2] += 1
