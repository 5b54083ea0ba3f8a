"""The event loop of the toy [Leine2001, Fig. 1]: plain Python that numba compiles if it is there.

A state is z = (y, phi_M, phi_S, dy, dphi_M, dphi_S, t). Between events it follows the closed form
of its mode; the earliest guard root ends the mode; impacts and the contact problem on
acceleration level decide the next one. Along go derivatives of the state *at* the events (with
the event time as seventh entry): differentiating the map from event to event is the variational
flow with saltation, without a formula for the jump.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import borrowed, jit, part
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.impacts import (
    AMBIGUOUS,
    INDETERMINATE,
    MARKS,
    NO_SOLUTION,
    PAIR_ROOM,
    SOLVED,
    halts,
    hold,
    impact,
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
from woodpecker.simulation.guards import EPSILON, first_root, stumpff, stumpff_rates

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
            ("slips", "i8", (3,)),  # signs of the tangential velocities
            ("stopped", "i8", (3,)),  # nonzero where the last impact stopped the slip, in any phase
            ("gaps", "f8", (3,)),  # of the contacts, over their lever arms
            ("work", "f8", (7,)),  # a state
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
def guard_rates(
    model: Floats, mode: int, guard: int, end: Floats, tangent: Floats
) -> tuple[float, float]:
    """Change of a guard at the end of a phase: along a tangent at fixed time, and in time."""
    kind, i = (guard // 3) * 3, guard % 3
    d0, d1, d2 = spring(model, mode, end)
    if guard == SECTION:
        return tangent[5] - tangent[4], d2
    if kind == GAP:
        j = ANGLE[i]
        return tangent[j], end[3 + j]
    if kind == SLIP:
        change = rate = 0.0
        for j in range(3):
            w = model[CONTACT + i, TANGENT + j]
            change += w * tangent[3 + j]
            rate += w * (model[mode, A + j] + model[mode, B + j] * d0)
        return change, rate
    return tangent[2] - tangent[1], d1


@part
def advance(
    model: Floats, change: Floats, mode: int, guard: int, t: float, z: Floats, gaps: Floats,
    tangents: Floats, work: Floats,
) -> None:  # fmt: skip
    """Move the state and its tangents to the event at time t (guard -1: to a fixed time).

    Gaps are moved by displacements, so that a small one has no rounding of the large angle that it
    is a difference of.
    """
    _, s1, s2, s3, s4 = stumpff(model[mode, KAPPA], model[mode, OMEGA], t)
    displace(model, mode, z, t, s1, s2, s3, s4, work)
    for i in range(3):
        gaps[i] += SIGN[i] * work[ANGLE[i]]
    for j in range(3):
        work[j] += z[j]
    if len(tangents) == 0:
        copy(work, z)
        return
    end_d = work[2] - work[1]
    for m in range(len(tangents)):
        v = tangents[m]
        d0, d1 = v[2] - v[1], v[5] - v[4]
        for j in range(3):
            acceleration = model[mode, B + j]
            v[j] += v[3 + j] * t + acceleration * (s2 * d0 + s3 * d1)
            v[3 + j] += acceleration * (s1 * d0 + s2 * d1)
        moves = len(change) > 0 and m == len(tangents) - 1
        if moves:
            change_flow(model, change, mode, z, t, s1, s2, s3, s4, v)
        if guard < 0:
            continue
        shift, rate = guard_rates(model, mode, guard, work, v)
        if moves:
            shift += guard_change(model, change, mode, guard, work)
        delay = -shift / rate if rate != 0.0 else math.nan
        for j in range(3):
            v[j] += delay * work[3 + j]
            v[3 + j] += delay * (model[mode, A + j] + model[mode, B + j] * end_d)
        v[6] += delay
    copy(work, z)


@part
def change_flow(
    model: Floats, change: Floats, mode: int, z: Floats, t: float, s1: float, s2: float, s3: float,
    s4: float, v: Floats,
) -> None:  # fmt: skip
    """Add to a tangent what the coefficients of the mode, which change, do in a time t.

    qdd = A + B d, so q gains A t^2 / 2 + B (d integrated twice) and u gains A t + B (d integrated
    once), and d = d_0 c_0 + d_1 s_1 + ... depends on alpha and kappa.
    """
    kappa = model[mode, KAPPA]
    d0, d1, d2 = spring(model, mode, z)
    once = d0 * t + d1 * s2 + d2 * s3
    twice = 0.5 * d0 * t * t + d1 * s3 + d2 * s4
    dkappa = change[mode, KAPPA]
    dd2 = change[mode, ALPHA] + dkappa * d0
    k2, k3, k4 = stumpff_rates(kappa, t, s1, s2, s3, s4)
    d_once = dd2 * s3 + dkappa * (d1 * k2 + d2 * k3)
    d_twice = dd2 * s4 + dkappa * (d1 * k3 + d2 * k4)
    for j in range(3):
        a, b = change[mode, A + j], change[mode, B + j]
        v[j] += 0.5 * a * t * t + b * twice + model[mode, B + j] * d_twice
        v[3 + j] += a * t + b * once + model[mode, B + j] * d_once


@part
def guard_change(model: Floats, change: Floats, mode: int, guard: int, end: Floats) -> float:
    """Change of a guard with the table at a fixed state, in the units of :func:`guard_rates`."""
    kind, i = (guard // 3) * 3, guard % 3
    if guard == SECTION:
        return 0.0
    if kind == GAP:
        return SIGN[i] * float(change[CONTACT + i, LIMIT])
    if kind == SLIP:
        return rates(change, i, end)[1]
    d = end[2] - end[1]
    _, r = force_guard(model, mode, guard)
    column = LAMBDA + 4 * i
    normal = change[mode, column] + change[mode, column + 1] * d
    if kind == NORMAL:
        return float(normal / r)
    sign = 1.0 if kind == CONE_POSITIVE else -1.0
    tangential = change[mode, column + 2] + change[mode, column + 3] * d
    friction = model[CONTACT + i, MU] * normal
    friction += change[CONTACT + i, MU] * (model[mode, column] + model[mode, column + 1] * d)
    return float((friction - sign * tangential) / r)


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
def arrive(
    model: Floats, change: Floats, z: Floats, gaps: Floats, tangents: Floats, seed: Floats,
    fired: int, states: Ints, slips: Ints, word: Codes, counts: Ints, event: Floats, room: Room,
) -> int:  # fmt: skip
    """Apply an event: the impact if a gap closes, then the contact problem that follows.

    ``states`` becomes the new mode, ``slips`` keeps the signs of the tangential velocities (0:
    exactly zero), symbols go to ``word`` (their number is counts[0]), details to ``event``.
    """
    closed, before, decided = room.closed, room.before, room.decided
    for i in range(3):
        closed[i], before[i] = 0, states[i]
    for k in range(STEP_COLUMNS):
        decided[k] = 0
    n, striking = _touching(model, z, gaps, states, fired, closed, room.touching)
    for k in range(EVENT_COLUMNS):
        event[k] = z[1 + k] if 2 <= k < 5 else 0.0
    if striking:
        status = _strike(
            model, change, room.touching[:n], z, tangents, seed, slips, word, counts, event, room
        )
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
        if striking:
            still_contacts(states, tangents)
    return status


@part
def _strike(
    model: Floats, change: Floats, contacts: Ints, z: Floats, tangents: Floats, seed: Floats,
    slips: Ints, word: Codes, counts: Ints, event: Floats, room: Room,
) -> int:  # fmt: skip
    """The impact of some contacts: velocities, slips, which of them stay closed, and its symbol."""
    closed, case, impulses, marks = room.closed, room.case, room.impulses, room.marks
    marks[0] = marks[1] = 0
    status = impact(
        model, change, contacts, z, tangents, seed, room.choice, case, impulses, marks, room.pair
    )
    if status in (NO_SOLUTION, AMBIGUOUS):
        return status
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
def still_contacts(states: Ints, tangents: Floats) -> None:
    """Where a larger eps_N would make a closed contact bounce, the derivative is unknown.

    The bounces that it begins are not in this flow.
    """
    for i in range(3):
        if states[i] != OPEN:
            for m in range(len(tangents)):
                if tangents[m, 3 + ANGLE[i]] != 0.0:
                    tangents[m, 3 + ANGLE[i]] = math.nan


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


@jit
def run(
    model: Floats, change: Floats, z: Floats, tangents: Floats, seed: Floats, states: Ints,
    to_section: bool, t_end: float, word: Codes, phases: Floats, path: Ints, events: Floats,
    counts: Ints,
) -> int:  # fmt: skip
    """Follow the toy from event to event until it returns to the section or a limit is met.

    Parameters
    ----------
    change
        Derivative of the model along the last tangent (modes.CHANGE), or of length 0 if it stays.
    z, tangents, seed
        State (7,), derivatives of it (m, 7), derivatives of eps_N along them (m, 3); in place.
    states
        (3,) contact states before the start; contacts with zero gap are decided afresh.
    to_section, t_end
        Stop at the next minimum of phi_S on the jammed sleeve; stop at this time.
    word
        Buffer of event codes; its length is the event limit.
    phases, path, events
        Buffers for the trajectory, (n, 8), (n, 8) and (n, 16); of length 0 if it is not wanted. The
        path says what was decided before each phase, see STEP_COLUMNS.
    counts
        (3,) output: symbols, phases, events. Symbols already in the word are kept.
    """
    memory, owner = np.zeros((len(tangents), 7)), np.zeros(1, dtype=ROOM)
    return _follow(
        borrowed(model), borrowed(change), borrowed(z), borrowed(tangents), borrowed(seed),
        borrowed(states), to_section, t_end, borrowed(word), borrowed(phases), borrowed(path),
        borrowed(events), borrowed(counts), borrowed(memory), owner[0], owner, memory,
    )  # fmt: skip


@part
def _follow(
    model: Floats, change: Floats, z: Floats, tangents: Floats, seed: Floats, states: Ints,
    to_section: bool, t_end: float, word: Codes, phases: Floats, path: Ints, events: Floats,
    counts: Ints, memory: Floats, room: Room, owner: Any, owner_of_memory: Floats,
) -> int:  # fmt: skip
    """The same with borrowed arrays, and those that own ``room`` and ``memory``.

    ``memory`` holds (m, 7) tangents at the last bounce.
    """
    slips, gaps, work, event = room.slips, room.gaps, room.work, room.event
    measure(model, z, gaps)
    none = typed(-1)
    fired = room.bounce[0] = room.bounce[2] = none
    room.mark[7] = 0.0
    slips[0] = slips[1] = slips[2] = 0
    while True:
        symbols = counts[0]
        status = arrive(
            model, change, z, gaps, tangents, seed, fired, states, slips, word, counts, event, room
        )
        if len(events) > 0:
            _record_events(events, counts, symbols, z[6], word, event)
        if status == SOLVED and 0 <= fired < 3:
            status = _watch_bounces(
                model, change, z, gaps, tangents, fired, symbols, to_section, states, slips, word,
                counts, events, memory, room,
            )  # fmt: skip
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
        advance(model, change, mode, fired, t, z, gaps, tangents, work)
        if z[0] < -model[FORCE, POLE]:
            return POLE_END
        if fired == SECTION:
            put_on_section(model, change, z, tangents)
            return RETURNED
        if fired < 0:
            return TIME_REACHED


@part
def put_on_section(model: Floats, change: Floats, z: Floats, tangents: Floats) -> None:
    """Make exact what the section says: the sleeve at its lower contact, everything at rest."""
    z[1] = -model[CONTACT + 1, LIMIT]
    z[3] = z[4] = z[5] = 0.0
    for m in range(len(tangents)):
        tangents[m, 1] = tangents[m, 3] = tangents[m, 4] = tangents[m, 5] = 0.0
    if len(change) > 0:
        tangents[len(tangents) - 1, 1] = -change[CONTACT + 1, LIMIT]


@part
def _watch_bounces(
    model: Floats, change: Floats, z: Floats, gaps: Floats, tangents: Floats, i: int, symbols: int,
    to_section: bool, states: Ints, slips: Ints, word: Codes, counts: Ints, events: Floats,
    memory: Floats, room: Room,
) -> int:  # fmt: skip
    """After an impact at contact i: sum the bounces that accumulate, or remember this one."""
    bounce, mark = room.bounce, room.mark
    pair = _pair_at_rest(model, z, gaps, states, i, symbols, bounce)
    if pair != 0:
        counts[0] = bounce[2]
        bounce[0] = bounce[2] = -1
        return _close(
            model, change, z, gaps, tangents, pair, states, slips, word, counts, events, room
        )
    if counts[0] != symbols + 1 or states[i] != OPEN:
        bounce[0] = -1
        return SOLVED
    speed = SIGN[i] * z[3 + ANGLE[i]]
    ratio = speed / mark[7] if mark[7] > 0.0 else 1.0
    again = bounce[0] == i and bounce[1] == symbols and 0.0 <= ratio < 1.0
    if again and _chatters(model, z, gaps, states, to_section, i, mark[7], z[6] - mark[6], ratio):
        bounce[0] = -1
        return _close_chatter(
            model, change, z, gaps, tangents, ratio, i, states, slips, word, counts, events, memory,
            room,
        )  # fmt: skip
    bounce[0], bounce[1], mark[7] = i, counts[0], speed
    for k in range(7):
        mark[k] = z[k]
        for m in range(len(tangents)):
            memory[m, k] = tangents[m, k]
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
    model: Floats, change: Floats, z: Floats, gaps: Floats, tangents: Floats, ratio: float, i: int,
    states: Ints, slips: Ints, word: Codes, counts: Ints, events: Floats, memory: Floats,
    room: Room,
) -> int:  # fmt: skip
    """Sum the accumulating impacts at contact i and close it.

    In the word the run of equal impacts becomes the one symbol of the accumulation.
    """
    sum_bounces(z, gaps, tangents, memory, room.mark, ratio, i)
    last = word[counts[0] - 1]
    while counts[0] > 0 and word[counts[0] - 1] == last:
        counts[0] -= 1
    return _close(
        model, change, z, gaps, tangents, 1 << i, states, slips, word, counts, events, room
    )


@part
def sum_bounces(
    z: Floats, gaps: Floats, tangents: Floats, memory: Floats, mark: Floats, ratio: float, i: int
) -> None:
    """The state in which bounces at contact i end, which shrink by a ratio.

    With ``mark`` (and ``memory`` of the tangents) after the bounce before and z after the last one,
    it is z + (z - mark) ratio / (1 - ratio).
    """
    j, rest = 3 + ANGLE[i], ratio / (1.0 - ratio)
    for m in range(len(tangents)):
        change_of_ratio = SIGN[i] * (tangents[m, j] - ratio * memory[m, j]) / mark[7]
        change_of_rest = change_of_ratio / ((1.0 - ratio) * (1.0 - ratio))
        for k in range(7):
            tangents[m, k] += (tangents[m, k] - memory[m, k]) * rest
            tangents[m, k] += (z[k] - mark[k]) * change_of_rest
    for k in range(3):
        gaps[k] += SIGN[k] * (z[ANGLE[k]] - mark[ANGLE[k]]) * rest
    for k in range(7):
        z[k] += (z[k] - mark[k]) * rest


@part
def shut(
    model: Floats, change: Floats, mask: int, z: Floats, gaps: Floats, tangents: Floats
) -> None:
    """Make exact that the contacts of a mask are closed and stay so."""
    for k in range(3):
        if mask >> k & 1:
            j = ANGLE[k]
            touch(model, k, z, gaps)
            z[3 + j] = 0.0
            for m in range(len(tangents)):
                tangents[m, j] = tangents[m, 3 + j] = 0.0
            if len(change) > 0:
                tangents[len(tangents) - 1, j] = -SIGN[k] * change[CONTACT + k, LIMIT]


@part
def stop(model: Floats, change: Floats, k: int, z: Floats, tangents: Floats) -> None:
    """Make the slip of contact k exactly zero, and that of the tangents."""
    hold(model, k, z)
    for m in range(len(tangents)):
        hold(model, k, tangents[m])
    if len(change) > 0:
        tangents[len(tangents) - 1, 3] -= rates(change, k, z)[1]


@part
def _close(
    model: Floats, change: Floats, z: Floats, gaps: Floats, tangents: Floats, mask: int,
    states: Ints, slips: Ints, word: Codes, counts: Ints, events: Floats, room: Room,
) -> int:  # fmt: skip
    """Close the contacts of a mask at the end of their accumulating impacts, and decide the mode.

    Tangential velocities that every one of the impacts has stopped, in either phase, are zero in
    the limit, whatever rounding has left of them.
    """
    closed, before = room.closed, room.before
    for k in range(3):
        before[k] = states[k]
        closed[k] = 1 if states[k] != OPEN or mask >> k & 1 else 0
    for k in range(3):
        if mask >> k & 1:
            before[k] = SLIP_POSITIVE
    shut(model, change, mask, z, gaps, tangents)
    for k in range(3):
        if not closed[k] or states[k] == STICK:
            continue
        slips[k] = 0 if room.stopped[k] else _sign(rates(model, k, z)[1])
        if room.stopped[k]:
            stop(model, change, k, z, tangents)
    status = settle(model, z, gaps, closed, slips, typed(-1), states, room.trial)
    room.decided[CLOSED], room.decided[HELD] = mask, _held(closed, slips)
    symbols = counts[0]
    _append(word, counts, 8 * CHATTER_END + mask)
    for k in range(3):  # that they close is in the symbol
        before[k] = states[k] if mask >> k & 1 and states[k] > STICK else before[k]
    _append_transitions(before, states, typed(-1), word, counts)
    if len(events) > 0:
        event = np.zeros(EVENT_COLUMNS)
        for k in range(3):
            event[2 + k] = event[5 + k] = z[3 + k]
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
def sweep(
    model: Floats, change: Floats, starts: Floats, order: int, seed: Floats, out: Floats,
    status: Ints, lengths: Ints, words: Codes,
) -> None:  # fmt: skip
    """P_order at many starts on the section.

    Parameters
    ----------
    change
        Derivative of the model along the last direction (modes.CHANGE), or of length 0 if only
        restitution changes.
    starts
        (n,) values of phi_S.
    seed
        (k, 3) directions in (eps_N1, eps_N2, eps_N3) to differentiate along.
    out
        (n, 4 + k) output: phi_S, period, drop, d phi_S / d start, d phi_S along the seeds.
    status, lengths, words
        Output: (n,) why each run stopped, (n,) lengths of the words, (n, event limit) event codes;
        code 0 separates the returns of a word.
    """
    z, states = np.zeros(7), np.zeros(3, dtype=np.int64)
    tangents, seeds = np.zeros((1 + len(seed), 7)), np.zeros((1 + len(seed), 3))
    for k in range(len(seed)):
        for i in range(3):
            seeds[1 + k, i] = seed[k, i]
    counts, separator = np.zeros(3, dtype=np.int64), typed(0)
    nothing, no_events = np.zeros((0, PHASE_COLUMNS)), np.zeros((0, EVENT_COLUMNS))
    no_path = np.zeros((0, STEP_COLUMNS), dtype=np.int64)
    memory, owner = np.zeros((len(tangents), 7)), np.zeros(1, dtype=ROOM)
    for n in range(len(starts)):
        for k in range(7):
            z[k] = 0.0
            for m in range(len(tangents)):
                tangents[m, k] = 0.0
        counts[0] = 0
        z[1], z[2], tangents[0, 2] = -model[CONTACT + 1, LIMIT], starts[n], 1.0
        if len(change) > 0:
            tangents[len(seed), 1] = -change[CONTACT + 1, LIMIT]
        for lap in range(order):
            if lap > 0:
                _append(words[n], counts, separator)
            states[0], states[1], states[2] = OPEN, STICK, OPEN
            status[n] = _follow(
                borrowed(model), borrowed(change), borrowed(z), borrowed(tangents),
                borrowed(seeds), borrowed(states), True, math.inf, borrowed(words[n]),
                borrowed(nothing), borrowed(no_path), borrowed(no_events), borrowed(counts),
                borrowed(memory), owner[0], owner, memory,
            )  # fmt: skip
            if status[n] != RETURNED:
                break
        out[n, 0], out[n, 1], out[n, 2] = z[2], z[6], -z[0]
        for m in range(len(tangents)):
            out[n, 3 + m] = tangents[m, 2]
        lengths[n] = min(counts[0], words.shape[1])


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
