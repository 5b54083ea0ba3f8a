"""The event loop of the toy [Leine2001, Fig. 1]: plain Python that numba compiles if it is there.

A state is z = (y, phi_M, phi_S, dy, dphi_M, dphi_S, t). Between events it follows the closed form
of its mode; the earliest guard root ends the mode; impacts and the contact problem on
acceleration level decide the next one. What happened is recorded as a path; derivatives are those
of the map along it, see :mod:`woodpecker.simulation.following`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import cast

import numpy as np

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import jit, part
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.impacts import (
    AMBIGUOUS,
    INDETERMINATE,
    MARKS,
    NO_SOLUTION,
    PAIR_ROOM,
    SOLVED,
    carry_out,
    decide,
    halts,
    hold,
    rates,
    rest_is_possible,
)
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    CONTACT,
    FORCE,
    GAP,
    GUARDS,
    KAPPA,
    LAMBDA,
    LIMIT,
    MU,
    NORMAL,
    OMEGA,
    POLE,
    SECTION,
    SECULAR,
    SIGN,
    SLIP,
    TANGENT,
    A,
    B,
)
from woodpecker.simulation.guards import EPSILON, first_root, stumpff

# A number with a type: numba would compile every function anew for a literal argument.
typed = cast("Callable[[int], int]", np.int64)

# Why a run stopped.
RETURNED, TIME_REACHED, FREE_FALL, POLE_END, AT_REST = 0, 1, 2, 3, 4
EVENT_LIMIT, CONTACT_NO_SOLUTION, CONTACT_AMBIGUOUS = 5, 6, 7

# Event codes: 8 * kind + bit mask of the contacts + 64 * (marks of an impact, see contact.MARKS).
IMPACT, DETACH, SLIP_START, STICK_START, REVERSAL, CHATTER_END, INDETERMINATE_IMPACT = range(7)

# Contact states, as in modes.Contact.
OPEN, STICK, SLIP_POSITIVE, SLIP_NEGATIVE = 0, 1, 2, 3

CHATTER = 1e-9  # relative size of a bounce below which the rest of its geometric series is summed:
# the neglected second order is its square, below rounding
COLLAPSED = 1e-15  # angle of the free swing within which impacts of two contacts in turns must have
# ended: what they still do to the velocities is about that part of them
UNNAMED = 1e-7  # the same, below which they are not named: other orders change values by less than
# Tolerances.jump, and there are infinitely many
PHASE_COLUMNS = 8  # z and the mode at the start of a smooth phase
EVENT_COLUMNS = 16  # t, code, u before, u after, impulses (N, T) x (beak, sleeve) of both phases


STEP_COLUMNS = 8  # of a path: what one event decided, and the phase after it. Columns:
MODE, GUARD, STRUCK, FIRST, OTHER, SECOND, CLOSED, HELD = range(8)
# MODE of the phase; GUARD that ends it; STRUCK, mask of the contacts that take part in an impact,
# or 0; FIRST and OTHER, index combinations of its compression (two ends of a segment, if it is
# indeterminate), SECOND, that of the expansion (-1: none); CLOSED, mask of the contacts at which
# impacts have accumulated; HELD, mask of the contacts whose slip is exactly zero

NO_PATH: Ints = np.zeros((0, STEP_COLUMNS), dtype=np.int64)

ROOM = np.dtype(
    (
        np.record,
        [
            ("z", "f8", (7,)),  # the state
            ("states", "i8", (3,)),  # of the contacts
            ("counts", "i8", (3,)),  # of symbols, phases and events
            ("slips", "i8", (3,)),  # signs of the tangential velocities
            ("stopped", "i8", (3,)),  # nonzero where the last impact stopped the slip, in any phase
            ("gaps", "f8", (3,)),  # of the contacts, over their lever arms
            ("work", "f8", (7,)),  # another state
            ("event", "f8", (EVENT_COLUMNS,)),
            ("bounce", "i8", (3,)),  # the last: contact, symbols; symbols before unnamed ones
            ("mark", "f8", (8,)),  # its state and its speed
            ("closed", "i8", (3,)),  # contacts that touch and stay
            ("before", "i8", (3,)),  # states before an event
            ("touching", "i8", (2,)),  # contacts with zero gap
            ("choice", "i8", (3,)),  # index combinations of an impact
            ("case", "i8", (2,)),  # the last ones of each contact
            ("marks", "i8", (2,)),  # see contact.MARKS
            ("impulses", "f8", (2, 4)),
            ("trial", "i8", (3,)),  # states that are tried
            ("decided", "i8", (STEP_COLUMNS,)),  # what an event decides, see STEP_COLUMNS
            ("pair", PAIR_ROOM),
        ],
    )
)
"""Room for a run, made once: see :data:`woodpecker.mechanics.impacts.PAIR_ROOM`."""

Room = np.record  # of ROOM


def make_room() -> Room:
    """Room for a run, for those who call :func:`arrive` from outside."""
    room: Room = np.zeros(1, dtype=ROOM)[0]
    return room


@part
def mode_of(states: Ints) -> int:
    """Row of the mode table for the states of contacts 1, 2, 3."""
    sleeve = states[1]
    if sleeve == OPEN and states[2] != OPEN:
        sleeve = states[2] + 3
    return int(7 * states[0] + sleeve)


@part
def spring(model: Floats, mode: int, z: Floats) -> tuple[float, float, float]:
    """Stretch d, its rate, and its acceleration in a mode."""
    d = z[2] - z[1]
    return d, z[5] - z[4], model[mode, ALPHA] + model[mode, KAPPA] * d


@part
def flow(model: Floats, mode: int, z: Floats, t: float, out: Floats) -> None:
    """State after a time t in a mode."""
    _, s1, s2, s3, s4 = stumpff(model[mode, KAPPA], model[mode, OMEGA], t)
    displace(model, mode, z, t, s1, s2, s3, s4, out)
    for j in range(3):
        out[j] += z[j]


@part
def displace(
    model: Floats, mode: int, z: Floats, t: float, s1: float, s2: float, s3: float, s4: float,
    out: Floats,
) -> None:  # fmt: skip
    """Displacements, velocities and time after a time t in a mode, from s_k = t^k c_k."""
    kappa = model[mode, KAPPA]
    d0, d1, d2 = spring(model, mode, z)
    swinging = abs(kappa) * t * t >= 1.0
    for j in range(3):
        if swinging:  # oscillation about the secular motion; nothing grows that later cancels
            drift, rate, shift = model[mode, SECULAR + j], s1 * d2 / kappa, s2 * d2 / kappa
        else:
            drift, rate, shift = model[mode, A + j] + model[mode, B + j] * d0, s3 * d2, s4 * d2
        velocity = z[3 + j]
        out[j] = velocity * t + 0.5 * drift * t * t + model[mode, B + j] * (s3 * d1 + shift)
        out[3 + j] = velocity + drift * t + model[mode, B + j] * (s2 * d1 + rate)
    out[6] = z[6] + t


@part
def measure(model: Floats, z: Floats, gaps: Floats) -> None:
    """Gaps (3,) over their lever arms [rad] from the angles of a state."""
    for i in range(3):
        gaps[i] = model[CONTACT + i, LIMIT] + SIGN[i] * z[ANGLE[i]]


@part
def jet(
    model: Floats, mode: int, guard: int, z: Floats, gaps: Floats, states: Ints
) -> tuple[float, float, float, float]:
    """Value and first three derivatives of a guard at the start of a phase."""
    kind, i = (guard // 3) * 3, guard % 3
    d0, d1, d2 = spring(model, mode, z)
    kappa = model[mode, KAPPA]
    if kind == GAP:
        j, sign = ANGLE[i], SIGN[i]
        return (
            gaps[i],
            sign * z[3 + j],
            sign * (model[mode, A + j] + model[mode, B + j] * d0),
            sign * model[mode, B + j] * d1,
        )
    if kind == SLIP:
        sign = 1.0 if states[i] == SLIP_POSITIVE else -1.0
        velocity = along = steady = 0.0
        for k in range(3):
            w = model[CONTACT + i, TANGENT + k]
            velocity += w * z[3 + k]
            along += w * model[mode, B + k]
            steady += w * model[mode, A + k]
        return (
            sign * velocity,
            sign * (steady + along * d0),
            sign * along * d1,
            sign * along * d2,
        )
    p, r = force_guard(model, mode, guard)
    return p + r * d0, r * d1, r * d2, r * kappa * d1


@part
def starting_jet(
    model: Floats, mode: int, guard: int, z: Floats, gaps: Floats, states: Ints, fired: int
) -> tuple[float, float, float, float]:
    """Jet of a guard right after ``fired``, whose zero it shares: exact zeros, not rounding.

    At a detachment the gap has no acceleration yet; at a slip start the slip has none, because
    lambda_T = +mu lambda_N at the edge of the cone is just the force of negative slip.
    """
    f0, f1, f2, f3 = jet(model, mode, guard, z, gaps, states)
    if guard == fired:
        return 0.0, f1, f2, f3
    i = guard % 3
    if guard < NORMAL and fired == NORMAL + i:
        return 0.0, 0.0, 0.0, f3
    if guard >= SLIP:
        edge = CONE_POSITIVE if states[i] == SLIP_NEGATIVE else CONE_NEGATIVE
        if fired == edge + i:
            return 0.0, 0.0, f2, f3
    return f0, f1, f2, f3


@part
def force_guard(model: Floats, mode: int, guard: int) -> tuple[float, float]:
    """p, r of a guard p + r d on contact forces: lambda_N, or mu lambda_N -+ lambda_T."""
    kind, i = (guard // 3) * 3, guard % 3
    column = LAMBDA + 4 * i
    if kind == NORMAL:
        return model[mode, column], model[mode, column + 1]
    sign = 1.0 if kind == CONE_POSITIVE else -1.0
    return (
        model[CONTACT + i, MU] * model[mode, column] - sign * model[mode, column + 2],
        model[CONTACT + i, MU] * model[mode, column + 1] - sign * model[mode, column + 3],
    )


@part
def time_to_minimum(model: Floats, mode: int, z: Floats) -> float:
    """Time > 0 until phi_S, swinging on the jammed sleeve, is at its next minimum."""
    omega = model[mode, OMEGA]
    _, d1, d2 = spring(model, mode, z)
    angle = math.atan2(-d1, d2 / omega)
    return float((angle if angle > 0.0 else angle + 2.0 * math.pi) / omega)


@part
def next_event(
    model: Floats, mode: int, z: Floats, gaps: Floats, states: Ints, to_section: bool,
    horizon: float, before: int, ignored: int,
) -> tuple[float, int]:  # fmt: skip
    """Time to the first guard that fires before the horizon, and which it is (-1: none).

    ``before`` is the guard that began the phase; the guard ``ignored`` is not watched. The mode is
    admissible, so a guard that starts negative does so by rounding and counts as zero.
    """
    fired = -1
    kappa, omega = model[mode, KAPPA], model[mode, OMEGA]
    for column in range(GUARDS, GUARDS + 5):
        guard = int(model[mode, column])
        if guard < 0:
            break
        if guard == ignored:
            continue
        if guard == SECTION:
            t = time_to_minimum(model, mode, z) if to_section else math.inf
        else:
            f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, states, before)
            t = first_root(max(0.0, f0), f1, f2, f3, kappa, omega, horizon)
        if t < horizon:
            horizon, fired = t, guard
    return horizon, fired


@part
def advance(model: Floats, mode: int, t: float, z: Floats, gaps: Floats, work: Floats) -> None:
    """Move the state to time t.

    Gaps are moved by displacements, so that a small one has no rounding of the large angle that it
    is a difference of.
    """
    _, s1, s2, s3, s4 = stumpff(model[mode, KAPPA], model[mode, OMEGA], t)
    displace(model, mode, z, t, s1, s2, s3, s4, work)
    for i in range(3):
        gaps[i] += SIGN[i] * work[ANGLE[i]]
    for j in range(3):
        work[j] += z[j]
    copy(work, z)


@part
def copy(source: Floats, target: Floats) -> None:
    """Copy the seven entries of a state; loops compile much faster than slices."""
    for k in range(7):
        target[k] = source[k]


@part
def settle(
    model: Floats, z: Floats, gaps: Floats, closed: Ints, slips: Ints, fired: int, states: Ints,
    trial: Ints,
) -> int:  # fmt: skip
    """Contact problem on acceleration level: the mode that starts now.

    Every combination of states of the touching contacts is tried. One is admissible if each guard
    of the touching contacts is positive right after now, judged by its first non-zero derivative;
    derivatives that the event itself made zero are taken as zero.

    Parameters
    ----------
    closed
        (3,) nonzero for contacts with zero gap and zero gap rate.
    slips
        (3,) sign of the tangential velocity of those contacts, 0 if it is exactly zero.
    fired
        The guard that brought us here (-1: none that leaves a zero on acceleration level).
    states
        Output: (3,) contact states of the new mode.
    trial
        (3,) room for the states that are tried.
    """
    sleeve = 1 if closed[1] else (2 if closed[2] else -1)
    states[0] = states[1] = states[2] = OPEN
    if not closed[0] and sleeve < 0:
        return SOLVED
    beak_choices, sleeve_choices = 4 if closed[0] else 1, 4 if sleeve >= 0 else 1
    trial[0] = trial[1] = trial[2] = OPEN
    for strict in (True, False):
        chosen = typed(-1)
        for index in range(beak_choices * sleeve_choices):
            # Sticking (1) is tried first, opening (0) last.
            if closed[0]:
                trial[0] = (index % 4 + 1) % 4
            if sleeve >= 0:
                trial[sleeve] = (index // beak_choices + 1) % 4
            if not _matches(trial, slips) or not _admissible(
                model, z, gaps, closed, slips, fired, trial, sleeve, strict
            ):
                continue
            mode = mode_of(trial)
            if chosen < 0:
                chosen = mode
                for i in range(3):
                    states[i] = trial[i]
            elif not _same_motion(model, chosen, mode, z):
                return AMBIGUOUS
        if chosen >= 0:
            return SOLVED
    return NO_SOLUTION


@part
def _matches(trial: Ints, slips: Ints) -> bool:
    """A sliding contact keeps its direction; two closed contacts move as one."""
    together = OPEN
    for i in range(3):
        if trial[i] == OPEN:
            continue
        if slips[i] > 0 and trial[i] != SLIP_POSITIVE:
            return False
        if slips[i] < 0 and trial[i] != SLIP_NEGATIVE:
            return False
        if together not in (OPEN, trial[i]):
            return False
        together = trial[i]
    return True


@part
def _admissible(
    model: Floats, z: Floats, gaps: Floats, closed: Ints, slips: Ints, fired: int, trial: Ints,
    sleeve: int, strict: bool,
) -> bool:  # fmt: skip
    mode = mode_of(trial)
    if sleeve >= 0 and trial[0] == STICK and trial[sleeve] == STICK:
        return rest_is_possible(model, sleeve, z[2] - z[1])
    for i in range(3):
        if not closed[i]:
            continue
        if trial[i] == OPEN:
            watched, other = GAP + i, -1
        elif trial[i] == STICK:
            watched, other = CONE_POSITIVE + i, CONE_NEGATIVE + i
        else:
            watched, other = NORMAL + i, (SLIP + i if slips[i] == 0 else -1)
        for guard in (watched, other):
            if guard >= 0:
                f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, trial, fired)
                if guard >= SLIP:
                    f0 = 0.0  # it is watched where nothing slips yet
                weight = 0.0 if guard < NORMAL or guard >= SLIP else _weight(model, mode, i, z)
                if not _positive(f0, f1, f2, f3, weight, strict):
                    return False
    return True


@part
def _weight(model: Floats, mode: int, i: int, z: Floats) -> float:
    """Size of the contact force that a rounding error can hide in."""
    column = LAMBDA + 4 * i
    return float(abs(model[mode, column]) + abs(model[mode, column + 1] * (z[2] - z[1])))


@part
def _positive(f0: float, f1: float, f2: float, f3: float, weight: float, strict: bool) -> bool:
    """Sign right after 0 by the first non-zero derivative; f identically zero counts as inside.

    If not strict, a value within rounding of zero is passed over.
    """
    if f0 != 0.0 and (strict or abs(f0) > 1e-12 * weight):
        return f0 > 0.0
    if f1 != 0.0:
        return f1 > 0.0
    if f2 != 0.0:
        return f2 > 0.0
    return f3 >= 0.0


@part
def _same_motion(model: Floats, one: int, other: int, z: Floats) -> bool:
    """Whether two modes start with the same accelerations and rates of acceleration."""
    d0, d1 = z[2] - z[1], z[5] - z[4]
    a, b = model[one], model[other]
    for j in range(3):
        first, second = a[A + j] + a[B + j] * d0, b[A + j] + b[B + j] * d0
        size = abs(a[A + j]) + abs(a[B + j] * d0)
        if abs(first - second) > 1e-9 * size:
            return False
        first, second = a[B + j] * d1, b[B + j] * d1
        if abs(first - second) > 1e-9 * (abs(first) + abs(second)):
            return False
    return True


@part
def arrive(model: Floats, fired: int, word: Codes, counts: Ints, room: Room) -> int:
    """Apply an event: the impact if a gap closes, then the contact problem that follows.

    ``states`` becomes the new mode, ``slips`` keeps the signs of the tangential velocities (0:
    exactly zero), symbols go to ``word`` (their number is counts[0]), details to ``event``.
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
            before[i] = before[i] if before[i] != OPEN or not closed[i] else SLIP_POSITIVE
        fired = typed(-1)
    else:
        for i in range(3):
            stops = states[i] == STICK or fired == SLIP + i
            if closed[i] and stops:
                slips[i] = 0
                hold(model, i, z)
        for i in range(3):
            if closed[i] and states[i] != STICK and fired != SLIP + i:
                slips[i] = _sign(rates(model, i, z)[1])
    for j in range(3):
        event[5 + j] = z[3 + j]
    status = settle(model, z, gaps, closed, slips, fired, states, room.trial)
    decided[HELD] = _held(closed, slips)
    if status == SOLVED:
        _append_transitions(before, states, fired, word, counts)
    return status


@part
def _strike(model: Floats, contacts: Ints, word: Codes, counts: Ints, room: Room) -> int:
    """The impact of some contacts: velocities, slips, which of them stay closed, and its symbol."""
    z, slips, event, closed = room.z, room.slips, room.event, room.closed
    case, impulses, marks = room.case, room.impulses, room.marks
    marks[0] = marks[1] = 0
    status = decide(model, contacts, z, room.choice, marks, room.pair)
    if status in (NO_SOLUTION, AMBIGUOUS):
        return status
    carry_out(model, contacts, room.choice, z, case, impulses, room.pair)
    kind = INDETERMINATE_IMPACT if status == INDETERMINATE else IMPACT
    mask = 0
    for k in range(len(contacts)):
        i = contacts[k]
        mask += 1 << i
        closed[i] = 1 if case[k] // 3 == REST else 0
        slips[i] = 0 if case[k] % 3 == HOLD else _sign(rates(model, i, z)[1])
        room.stopped[i] = 1 if status == INDETERMINATE or halts(marks[k]) else 0
        column = 8 + (0 if i == 0 else 2)
        for phase in range(2):
            event[column + 4 * phase] = impulses[phase, 2 * k]
            event[column + 4 * phase + 1] = impulses[phase, 2 * k + 1]
    _append(word, counts, 64 * (marks[0] + MARKS * marks[1]) + 8 * kind + mask)
    room.decided[STRUCK] = mask
    for k in range(3):
        room.decided[FIRST + k] = room.choice[k]
    return status


@part
def _held(closed: Ints, slips: Ints) -> int:
    """Mask of the closed contacts whose slip is exactly zero."""
    mask = 0
    for i in range(3):
        if closed[i] and slips[i] == 0:
            mask += 1 << i
    return mask


@part
def touch(model: Floats, i: int, z: Floats, gaps: Floats) -> None:
    """Make exact that contact i has no gap."""
    z[ANGLE[i]], gaps[i] = -SIGN[i] * model[CONTACT + i, LIMIT], 0.0


@part
def _touching(
    model: Floats, z: Floats, gaps: Floats, states: Ints, fired: int, closed: Ints, found: Ints
) -> tuple[int, bool]:
    """Find contacts with zero gap, and whether one of them strikes; their angles become exact."""
    n, striking = 0, False
    for i in range(3):
        if states[i] != OPEN:
            closed[i] = 1
        elif fired == GAP + i or (gaps[i] <= 0.0 and SIGN[i] * z[3 + ANGLE[i]] < 0.0):
            striking = True  # the second: it closes in the same instant
        else:
            if gaps[i] < 0.0:  # it is just leaving, and rounding put it inside
                touch(model, i, z, gaps)
            continue
        touch(model, i, z, gaps)
        if n < 2:
            found[n] = i
            n += 1
    return n, striking


@part
def _sign(value: float) -> int:
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@part
def _append(word: Codes, counts: Ints, code: int) -> None:
    if counts[0] < len(word):
        word[counts[0]] = code
    counts[0] += 1


@part
def _append_transitions(before: Ints, after: Ints, fired: int, word: Codes, counts: Ints) -> None:
    """Symbols for contacts that opened, stuck, began to slip or reversed."""
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
            _append(word, counts, 8 * code + (1 << i))


@part
def search(
    model: Floats, to_section: bool, t_end: float, word: Codes, phases: Floats, path: Ints,
    events: Floats, room: Room,
) -> int:  # fmt: skip
    """From event to event, see :func:`woodpecker.simulation.calls.run`.

    State, contact states and counts are those of the room.
    """
    counts = room.counts
    z, gaps, states = room.z, room.gaps, room.states
    measure(model, z, gaps)
    none = typed(-1)
    fired = room.bounce[0] = room.bounce[2] = none
    room.mark[7] = 0.0
    room.slips[0] = room.slips[1] = room.slips[2] = 0
    while True:
        symbols = counts[0]
        status = arrive(model, fired, word, counts, room)
        if len(events) > 0:
            _record_events(events, counts, symbols, z[6], word, room.event)
        if status == SOLVED and 0 <= fired < 3:
            status = _watch_bounces(model, fired, symbols, to_section, word, counts, events, room)
        if status != SOLVED:
            return CONTACT_NO_SOLUTION if status == NO_SOLUTION else CONTACT_AMBIGUOUS
        if counts[0] > len(word):
            return EVENT_LIMIT
        mode = mode_of(states)
        if len(phases) > 0:
            _record_phase(phases, path, counts, z, mode, room.decided)
        horizon = t_end - z[6]
        t, fired = next_event(model, mode, z, gaps, states, to_section, horizon, fired, none)
        if t == math.inf:
            sticks = states[0] == STICK or states[1] == STICK or states[2] == STICK
            return AT_REST if sticks else FREE_FALL
        if len(path) > 0:
            together = SLIP <= fired < SECTION and mode >= 7 and mode % 7 > 0
            path[counts[1] - 1, GUARD] = SLIP if together else fired  # they slide as one
        advance(model, mode, t, z, gaps, room.work)
        if z[0] < -model[FORCE, POLE]:
            return POLE_END
        if fired == SECTION:
            put_on_section(model, z)
            return RETURNED
        if fired < 0:
            return TIME_REACHED


@part
def put_on_section(model: Floats, z: Floats) -> None:
    """Make exact what the section says: the sleeve at its lower contact, everything at rest."""
    z[1] = -model[CONTACT + 1, LIMIT]
    z[3] = z[4] = z[5] = 0.0


@part
def _watch_bounces(
    model: Floats, i: int, symbols: int, to_section: bool, word: Codes, counts: Ints,
    events: Floats, room: Room,
) -> int:  # fmt: skip
    """After an impact at contact i: sum the bounces that accumulate, or remember this one."""
    z, gaps, states, bounce, mark = room.z, room.gaps, room.states, room.bounce, room.mark
    pair = _pair_at_rest(model, z, gaps, states, i, symbols, bounce)
    if pair != 0:
        counts[0] = bounce[2]
        bounce[0] = bounce[2] = -1
        return _close(model, pair, word, counts, events, room)
    if counts[0] != symbols + 1 or states[i] != OPEN:
        bounce[0] = -1
        return SOLVED
    speed = SIGN[i] * z[3 + ANGLE[i]]
    ratio = speed / mark[7] if mark[7] > 0.0 else 1.0
    again = bounce[0] == i and bounce[1] == symbols and 0.0 <= ratio < 1.0
    if again and _chatters(model, z, gaps, states, to_section, i, mark[7], z[6] - mark[6], ratio):
        bounce[0] = -1
        return _close_chatter(model, ratio, i, word, counts, events, room)
    bounce[0], bounce[1], mark[7] = i, counts[0], speed
    for k in range(7):
        mark[k] = z[k]
    return SOLVED


@part
def _chatters(
    model: Floats, z: Floats, gaps: Floats, states: Ints, to_section: bool, i: int, speed: float,
    lap: float, ratio: float,
) -> bool:  # fmt: skip
    """Whether the bounces at contact i are so small that the rest is a geometric series.

    No other event may fall into twice the time that is summed.
    """
    mode = mode_of(states)
    _, _, f2, f3 = jet(model, mode, GAP + i, z, gaps, states)
    if f2 >= 0.0:
        return False
    flight = -2.0 * speed / f2
    if flight * (model[mode, OMEGA] - f3 / f2) > CHATTER:
        return False
    if flight * abs(f3 / f2) > CHATTER:
        return False
    if lap > 2.0 * flight + 4.0 * EPSILON * z[6]:
        return False  # the one before came from further away than a bounce
    tail = lap * ratio / (1.0 - ratio)
    horizon = 2.0 * tail
    return next_event(model, mode, z, gaps, states, to_section, horizon, GAP + i, GAP + i)[1] < 0


@part
def _pair_at_rest(
    model: Floats, z: Floats, gaps: Floats, states: Ints, i: int, symbols: int, bounce: Ints
) -> int:
    """The beak and a contact of the sleeve, as a mask, if their impacts have come to an end; or 0.

    Impacts of two contacts can accumulate in turns. There is no series to sum, because their order
    need not repeat, but what remains of them soon falls below rounding. The last ones are not
    named in the word: their order changes less than is told apart anywhere.
    """
    sleeve = i if i > 0 else (1 if gaps[1] < gaps[2] else 2)
    swing = _remaining_swing(model, z, gaps, sleeve)
    if swing > UNNAMED:
        bounce[2] = -1
        return 0
    if states[0] != OPEN or states[sleeve] != OPEN:
        return 0  # one of them rests: what the other does is a series
    if bounce[2] < 0:
        bounce[2] = symbols
    return 1 + (1 << sleeve) if swing <= COLLAPSED else 0


@part
def _remaining_swing(model: Floats, z: Floats, gaps: Floats, sleeve: int) -> float:
    """How long the beak and a contact of the sleeve can bounce, as an angle of the free swing."""
    d, fastest, pull = z[2] - z[1], 0.0, 0.0
    for i in (0, sleeve):
        pull = max(pull, abs(model[0, B + ANGLE[i]] * d))
    for i in (0, sleeve):
        speed = z[3 + ANGLE[i]]
        fastest = max(fastest, speed * speed + 2.0 * pull * max(0.0, gaps[i]))
    if fastest == 0.0 or pull == 0.0:
        return 1.0
    return float(model[0, OMEGA] * math.sqrt(fastest) / pull)


@part
def _close_chatter(
    model: Floats, ratio: float, i: int, word: Codes, counts: Ints, events: Floats, room: Room
) -> int:
    """Sum the accumulating impacts at contact i and close it.

    In the word the run of equal impacts becomes the one symbol of the accumulation.
    """
    sum_bounces(room.z, room.gaps, room.mark, ratio)
    last = word[counts[0] - 1]
    while counts[0] > 0 and word[counts[0] - 1] == last:
        counts[0] -= 1
    return _close(model, 1 << i, word, counts, events, room)


@part
def sum_bounces(z: Floats, gaps: Floats, mark: Floats, ratio: float) -> None:
    """The state in which bounces end, which shrink by a ratio.

    With ``mark`` after the bounce before and z after the last one, it is
    z + (z - mark) ratio / (1 - ratio).
    """
    rest = ratio / (1.0 - ratio)
    for k in range(3):
        gaps[k] += SIGN[k] * (z[ANGLE[k]] - mark[ANGLE[k]]) * rest
    for k in range(7):
        z[k] += (z[k] - mark[k]) * rest


@part
def shut(model: Floats, mask: int, z: Floats, gaps: Floats) -> None:
    """Make exact that the contacts of a mask are closed and stay so."""
    for k in range(3):
        if mask >> k & 1:
            touch(model, k, z, gaps)
            z[3 + ANGLE[k]] = 0.0


@part
def _close(model: Floats, mask: int, word: Codes, counts: Ints, events: Floats, room: Room) -> int:
    """Close the contacts of a mask at the end of their accumulating impacts, and decide the mode.

    Tangential velocities that every one of the impacts has stopped, in either phase, are zero in
    the limit, whatever rounding has left of them.
    """
    z, gaps, states, slips = room.z, room.gaps, room.states, room.slips
    closed, before = room.closed, room.before
    for k in range(3):
        before[k] = states[k]
        closed[k] = 1 if states[k] != OPEN or mask >> k & 1 else 0
    for k in range(3):
        if mask >> k & 1:
            before[k] = SLIP_POSITIVE
    shut(model, mask, z, gaps)
    for k in range(3):
        if not closed[k] or states[k] == STICK:
            continue
        slips[k] = 0 if room.stopped[k] else _sign(rates(model, k, z)[1])
        if room.stopped[k]:
            hold(model, k, z)
    status = settle(model, z, gaps, closed, slips, typed(-1), states, room.trial)
    room.decided[CLOSED], room.decided[HELD] = mask, _held(closed, slips)
    symbols = counts[0]
    _append(word, counts, 8 * CHATTER_END + mask)
    for k in range(3):  # that they close is in the symbol
        before[k] = states[k] if mask >> k & 1 and states[k] > STICK else before[k]
    _append_transitions(before, states, typed(-1), word, counts)
    if len(events) > 0:
        event = room.event
        for k in range(EVENT_COLUMNS):
            event[k] = z[1 + k] if 2 <= k < 5 else (z[k - 2] if 5 <= k < 8 else 0.0)
        _record_events(events, counts, symbols, z[6], word, event)
    return status


@part
def _record_phase(
    phases: Floats, path: Ints, counts: Ints, z: Floats, mode: int, decided: Ints
) -> None:
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
def _record_events(
    events: Floats, counts: Ints, symbols: int, t: float, word: Codes, event: Floats
) -> None:
    """One row for each new symbol; velocities and impulses belong to the first of them."""
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


@jit
def sample(model: Floats, phases: Floats, times: Floats, left: bool, out: Floats) -> None:
    """States (n, 7) at given times from the phases of a trajectory.

    At an event time the state after it, or before it if ``left``.
    """
    starts = phases[:, 6]
    for n in range(len(times)):
        if left:
            k = max(0, np.searchsorted(starts, times[n], side="left") - 1)
        else:
            k = max(0, np.searchsorted(starts, times[n], side="right") - 1)
        flow(model, int(phases[k, 7]), phases[k, :7], times[n] - starts[k], out[n])
