"""An event: the impact if a gap closes, and the contact problem on acceleration level."""

from __future__ import annotations

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.contact_problems import AMBIGUOUS, INDETERMINATE, NO_SOLUTION, SOLVED
from woodpecker.mechanics.impacts import MARKS, carry_out, decide, hold, rates, sticks
from woodpecker.mechanics.modes import ANGLE, GAP, OPEN, SIGN, SLIP, SLIP_POSITIVE, STICK
from woodpecker.motion.codes import (
    EVENT_COLUMNS,
    FIRST,
    IMPACT,
    INDETERMINATE_IMPACT,
    STEP_COLUMNS,
    STRUCK,
    STUCK,
    Room,
    typed,
)
from woodpecker.motion.flow import touch
from woodpecker.motion.recording import append, append_transitions
from woodpecker.motion.settling import settle


@part
def carry_out_event(model: Floats, fired: int, word: Codes, counts: Ints, room: Room) -> int:
    """Carry out the event of the guard ``fired`` (-1: none) on the state in the workspace.

    Output: the ``states`` of the next mode, ``slips``, the signs of the tangential velocities (0:
    exactly zero), ``event``, and symbols in ``word`` (counts[0] is their number).
    """
    z, gaps, states, slips, event = room.z, room.gaps, room.states, room.slips, room.event
    closed, before, decided = room.closed, room.before, room.decided
    for i in range(3):
        closed[i], before[i] = 0, states[i]
    for k in range(STEP_COLUMNS):
        decided[k] = 0
    n, striking = _touching(model, z, gaps, states, fired, closed, room.touching)
    for k in range(EVENT_COLUMNS):
        event[k] = z[1 + k] if 2 <= k < 5 else 0.0
    if striking:
        status = _strike(model, room.touching[:n], word, counts, room)
        if status in (NO_SOLUTION, AMBIGUOUS):
            return status
        for i in range(3):
            # a contact that the impact closes may stick or detach at once, which has a symbol
            before[i] = before[i] if before[i] != OPEN or not closed[i] else SLIP_POSITIVE
        fired = typed(-1)  # an impact leaves no guard exactly zero
    else:
        for i in range(3):
            stops = states[i] == STICK or fired == SLIP + i
            if closed[i] and stops:
                slips[i] = 0
                hold(model, i, z)
        for i in range(3):
            if closed[i] and states[i] != STICK and fired != SLIP + i:
                slips[i] = sign_of(rates(model, i, z)[1])
    for j in range(3):
        event[5 + j] = z[3 + j]
    status = settle(model, z, gaps, closed, slips, fired, states, room.trial)
    decided[STUCK] = held(closed, slips)
    if status == SOLVED:
        append_transitions(before, states, fired, word, counts)
    return status


@part
def _strike(model: Floats, contacts: Ints, word: Codes, counts: Ints, room: Room) -> int:
    """Carry out an impact: velocities, slips, the contacts that stay closed, and its symbol."""
    z, slips, event, closed = room.z, room.slips, room.event, room.closed
    case, impulses, marks = room.case, room.impulses, room.marks
    marks[0] = marks[1] = 0
    status = decide(model, contacts, z, room.choice, marks, impulses, room.pair)
    if status in (NO_SOLUTION, AMBIGUOUS):
        return status
    carry_out(model, contacts, room.choice, z, case, impulses, room.pair)
    kind = INDETERMINATE_IMPACT if status == INDETERMINATE else IMPACT
    mask = 0
    for k in range(len(contacts)):
        i = contacts[k]
        mask += 1 << i
        closed[i] = 1 if case[k] // 3 == REST else 0
        slips[i] = 0 if case[k] % 3 == HOLD else sign_of(rates(model, i, z)[1])
        room.stopped[i] = 1 if status == INDETERMINATE or sticks(marks[k]) else 0
        column = 8 + (0 if i == 0 else 2)
        for phase in range(2):
            event[column + 4 * phase] = impulses[phase, 2 * k]
            event[column + 4 * phase + 1] = impulses[phase, 2 * k + 1]
    append(word, counts, 64 * (marks[0] + MARKS * marks[1]) + 8 * kind + mask)
    room.decided[STRUCK] = mask
    for k in range(3):
        room.decided[FIRST + k] = room.choice[k]
    return status


@part
def held(closed: Ints, slips: Ints) -> int:
    """Bit mask of the closed contacts whose slip is exactly zero."""
    mask = 0
    for i in range(3):
        if closed[i] and slips[i] == 0:
            mask += 1 << i
    return mask


@part
def _touching(
    model: Floats, z: Floats, gaps: Floats, states: Ints, fired: int, closed: Ints, found: Ints
) -> tuple[int, bool]:
    """Number of contacts with zero gap, whose angles are made exact, and whether one strikes."""
    n, striking = 0, False
    for i in range(3):
        if states[i] != OPEN:
            closed[i] = 1
        elif fired == GAP + i or (gaps[i] <= 0.0 and SIGN[i] * z[3 + ANGLE[i]] < 0.0):
            striking = True  # the second condition: another gap closes in the same instant
        else:
            if gaps[i] < 0.0:  # it is just leaving, and rounding has put it inside
                touch(model, i, z, gaps)
            continue
        touch(model, i, z, gaps)
        if n < 2:
            found[n] = i
            n += 1
    return n, striking


@part
def sign_of(value: float) -> int:
    """The sign of a number: -1, 0 or 1."""
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)
