"""The event loop of the toy [Leine2001, Fig. 1], compiled by numba if that is installed.

The state follows the closed form of its mode up to the first root of a guard. An impact, if there
is one, and the contact problem on acceleration level then decide the next mode.
"""

from __future__ import annotations

import math

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.contact_problems import NO_SOLUTION, SOLVED
from woodpecker.mechanics.modes import FORCE, POLE, SECTION, SLIP, STICK, mode_of
from woodpecker.motion.arriving import carry_out_event
from woodpecker.motion.chatter import check_accumulation
from woodpecker.motion.codes import (
    AT_REST,
    CONTACT_AMBIGUOUS,
    CONTACT_NO_SOLUTION,
    EVENT_LIMIT,
    FREE_FALL,
    GUARD,
    NEVER_JAMS,
    OVERFLOW,
    POLE_END,
    RETURNED,
    TIME_REACHED,
    Room,
    typed,
)
from woodpecker.motion.events import never_jams, next_event
from woodpecker.motion.flow import advance, copy, measure, put_on_section, representable
from woodpecker.motion.recording import record_events, record_phase


@part
def search(
    model: Floats, to_section: bool, t_end: float, word: Codes, phases: Floats, path: Ints,
    events: Floats, room: Room,
) -> int:  # fmt: skip
    """Run from event to event; returns the code of :func:`woodpecker.simulation.calls.run`."""
    counts = room.counts
    z, gaps, states = room.z, room.gaps, room.states
    if to_section and never_jams(model):
        return NEVER_JAMS
    measure(model, z, gaps)
    none = typed(-1)
    fired = room.bounce[0] = room.bounce[2] = none
    room.mark[7] = 0.0
    room.slips[0] = room.slips[1] = room.slips[2] = 0
    while True:
        symbols = counts[0]
        status = carry_out_event(model, fired, word, counts, room)
        if not representable(z):
            return _stopped(phases, counts, z)
        if len(events) > 0:
            record_events(events, counts, symbols, z[6], word, room.event)
        if status == SOLVED and 0 <= fired < 3:
            status = check_accumulation(
                model, fired, symbols, to_section, word, counts, events, room
            )
        if status != SOLVED:
            return CONTACT_NO_SOLUTION if status == NO_SOLUTION else CONTACT_AMBIGUOUS
        if counts[0] > len(word) or 0 < len(phases) == counts[1]:
            return EVENT_LIMIT  # phases count, too: an event that changes nothing has no symbol
        mode = mode_of(states)
        if len(phases) > 0:
            record_phase(phases, path, counts, z, mode, room.decided)
        horizon = t_end - z[6]
        t, fired = next_event(model, mode, z, gaps, states, to_section, horizon, fired, none)
        if t == math.inf:
            sticks = states[0] == STICK or states[1] == STICK or states[2] == STICK
            return AT_REST if sticks else FREE_FALL
        if len(path) > 0:
            together = SLIP <= fired < SECTION and mode >= 7 and mode % 7 > 0
            path[counts[1] - 1, GUARD] = SLIP if together else fired  # two that slide do so as one
        advance(model, mode, t, z, gaps, room.work)
        if not representable(z):
            return _stopped(phases, counts, z)
        if z[0] < -model[FORCE, POLE]:
            return POLE_END
        if fired == SECTION:
            put_on_section(model, z)
            return RETURNED
        if fired < 0:
            return TIME_REACHED


@part
def _stopped(phases: Floats, counts: Ints, z: Floats) -> int:
    """Go back to the start of the last phase, if recorded, because its end overflows."""
    if counts[1] > 0:
        copy(phases[counts[1] - 1], z)
    return OVERFLOW
