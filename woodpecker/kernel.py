"""The event loop of the toy [Leine2001, Fig. 1]: plain Python that numba compiles if it is there.

A state is z = (y, phi_M, phi_S, dy, dphi_M, dphi_S, t). Between events it follows the closed form
of its mode; the earliest guard root ends the mode; impacts and the contact problem on
acceleration level decide the next one. Along go derivatives of the state *at* the events (with
the event time as seventh entry): differentiating the map from event to event is the variational
flow with saltation, without a formula for the jump.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.compiled import jit
from woodpecker.contact import (
    AMBIGUOUS,
    HOLD,
    NO_SOLUTION,
    REST,
    SOLVED,
    impact,
    rest_is_possible,
)
from woodpecker.guards import first_root, stumpff
from woodpecker.modes import (
    ALPHA,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    GAP,
    KAPPA,
    LAMBDA,
    NORMAL,
    OMEGA,
    SECTION,
    SECULAR,
    SLIP,
    A,
    B,
    Floats,
    Ints,
    Model,
)

# Why a run stopped.
RETURNED, TIME_REACHED, FREE_FALL, POLE_END, AT_REST = 0, 1, 2, 3, 4
EVENT_LIMIT, CONTACT_NO_SOLUTION, CONTACT_AMBIGUOUS = 5, 6, 7

# Event codes: 8 * kind + bit mask of the contacts.
IMPACT, DETACH, SLIP_START, STICK_START, REVERSAL, CHATTER_END = 0, 1, 2, 3, 4, 5

# Contact states, as in modes.Contact.
OPEN, STICK, SLIP_POSITIVE, SLIP_NEGATIVE = 0, 1, 2, 3

CHATTER = 1e-9  # relative size of a bounce below which the rest of its geometric series is summed:
# the neglected second order is its square, below rounding
LAMBDA_P, LAMBDA_R = 0, 1  # offsets of p and r in the table's pairs (lambda_N, then lambda_T)
PHASE_COLUMNS = 8  # z and the mode at the start of a smooth phase
EVENT_COLUMNS = 16  # t, code, u before, u after, impulses (N, T) x (beak, sleeve) of both phases


@jit
def mode_of(states: Ints) -> int:
    """Row of the mode table for the states of contacts 1, 2, 3."""
    sleeve = states[1]
    if sleeve == OPEN and states[2] != OPEN:
        sleeve = states[2] + 3
    return 7 * states[0] + sleeve


@jit
def spring(model: Model, mode: int, z: Floats) -> tuple[float, float, float]:
    """Stretch d, its rate, and its acceleration in a mode."""
    d = z[2] - z[1]
    return d, z[5] - z[4], model.table[mode, ALPHA] + model.table[mode, KAPPA] * d


@jit
def flow(model: Model, mode: int, z: Floats, t: float, out: Floats) -> None:
    """State after a time t in a mode."""
    row = model.table[mode]
    kappa = row[KAPPA]
    d0, d1, d2 = spring(model, mode, z)
    _, s1, s2, s3, s4 = stumpff(kappa, row[OMEGA], t)
    swinging = abs(kappa) * t * t >= 1.0
    for j in range(3):
        if swinging:  # oscillation about the secular motion; nothing grows that later cancels
            drift, rate, shift = row[SECULAR + j], s1 * d2 / kappa, s2 * d2 / kappa
        else:
            drift, rate, shift = row[A + j] + row[B + j] * d0, s3 * d2, s4 * d2
        velocity = z[3 + j]
        out[j] = z[j] + velocity * t + 0.5 * drift * t * t + row[B + j] * (s3 * d1 + shift)
        out[3 + j] = velocity + drift * t + row[B + j] * (s2 * d1 + rate)
    out[6] = z[6] + t


@jit
def jet(
    model: Model, mode: int, guard: int, z: Floats, states: Ints
) -> tuple[float, float, float, float]:
    """Value and first three derivatives of a guard at the start of a phase."""
    row = model.table[mode]
    kind, i = (guard // 3) * 3, guard % 3
    d0, d1, d2 = spring(model, mode, z)
    kappa = row[KAPPA]
    if kind == GAP:
        j, sign = model.angle[i], model.sign[i]
        return (
            model.limit[i] + sign * z[j],
            sign * z[3 + j],
            sign * (row[A + j] + row[B + j] * d0),
            sign * row[B + j] * d1,
        )
    if kind == SLIP:
        sign = 1.0 if states[i] == SLIP_POSITIVE else -1.0
        w = model.tangent[i]
        along = w[0] * row[B] + w[1] * row[B + 1] + w[2] * row[B + 2]
        steady = w[0] * row[A] + w[1] * row[A + 1] + w[2] * row[A + 2]
        return (
            sign * (w[0] * z[3] + w[1] * z[4] + w[2] * z[5]),
            sign * (steady + along * d0),
            sign * along * d1,
            sign * along * d2,
        )
    p, r = force_guard(model, mode, guard)
    return p + r * d0, r * d1, r * d2, r * kappa * d1


@jit
def force_guard(model: Model, mode: int, guard: int) -> tuple[float, float]:
    """p, r of a guard p + r d on contact forces: lambda_N, or mu lambda_N -+ lambda_T."""
    kind, i = (guard // 3) * 3, guard % 3
    column = LAMBDA + 4 * i
    row = model.table[mode]
    if kind == NORMAL:
        return row[column], row[column + 1]
    sign = 1.0 if kind == CONE_POSITIVE else -1.0
    return (
        model.mu[i] * row[column] - sign * row[column + 2],
        model.mu[i] * row[column + 1] - sign * row[column + 3],
    )


@jit
def time_to_minimum(model: Model, mode: int, z: Floats) -> float:
    """Time > 0 until phi_S, swinging on the jammed sleeve, is at its next minimum."""
    omega = model.table[mode, OMEGA]
    _, d1, d2 = spring(model, mode, z)
    angle = math.atan2(-d1, d2 / omega)
    return (angle if angle > 0.0 else angle + 2.0 * math.pi) / omega


@jit
def next_event(
    model: Model, mode: int, z: Floats, states: Ints, to_section: bool, horizon: float, ignored: int
) -> tuple[float, int]:
    """Time to the first guard that fires before the horizon, and which it is (-1: none)."""
    fired = -1
    kappa, omega = model.table[mode, KAPPA], model.table[mode, OMEGA]
    for guard in model.guards[mode]:
        if guard < 0:
            break
        if guard == ignored:
            continue
        if guard == SECTION:
            t = time_to_minimum(model, mode, z) if to_section else math.inf
        else:
            f0, f1, f2, f3 = jet(model, mode, guard, z, states)
            t = first_root(f0, f1, f2, f3, kappa, omega, horizon)
        if t < horizon:
            horizon, fired = t, guard
    return horizon, fired


@jit
def guard_rates(
    model: Model, mode: int, guard: int, end: Floats, tangent: Floats
) -> tuple[float, float]:
    """Change of a guard at the end of a phase: along a tangent at fixed time, and in time."""
    row = model.table[mode]
    kind, i = (guard // 3) * 3, guard % 3
    d0, d1, d2 = spring(model, mode, end)
    if guard == SECTION:
        return tangent[5] - tangent[4], d2
    if kind == GAP:
        j = model.angle[i]
        return tangent[j], end[3 + j]
    if kind == SLIP:
        w = model.tangent[i]
        change = rate = 0.0
        for j in range(3):
            change += w[j] * tangent[3 + j]
            rate += w[j] * (row[A + j] + row[B + j] * d0)
        return change, rate
    return tangent[2] - tangent[1], d1


@jit
def advance(
    model: Model, mode: int, guard: int, t: float, z: Floats, tangents: Floats, work: Floats
) -> None:
    """Move the state and its tangents to the event at time t (guard -1: to a fixed time)."""
    row = model.table[mode]
    flow(model, mode, z, t, work)
    kappa, omega = row[KAPPA], row[OMEGA]
    end_d = work[2] - work[1]
    for m in range(len(tangents)):
        v = tangents[m]
        d0, d1 = v[2] - v[1], v[5] - v[4]
        _, s1, s2, s3, s4 = stumpff(kappa, omega, t)
        for j in range(3):
            acceleration = row[B + j]
            v[j] += v[3 + j] * t + acceleration * (s2 * d0 + s3 * d1)
            v[3 + j] += acceleration * (s1 * d0 + s2 * d1)
        if guard < 0:
            continue
        change, rate = guard_rates(model, mode, guard, work, v)
        delay = -change / rate if rate != 0.0 else math.nan
        for j in range(3):
            v[j] += delay * work[3 + j]
            v[3 + j] += delay * (row[A + j] + row[B + j] * end_d)
        v[6] += delay
    for j in range(7):
        z[j] = work[j]


@jit
def settle(
    model: Model, z: Floats, closed: Ints, slips: Ints, fired: int, states: Ints
) -> int:
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
    """
    sleeve = 1 if closed[1] else (2 if closed[2] else -1)
    chosen = -1
    trial = np.zeros(3, dtype=np.int64)
    for strict in (True, False):
        for index in range(16):
            beak_state, sleeve_state = index % 4, index // 4
            if (beak_state != OPEN and not closed[0]) or (sleeve_state != OPEN and sleeve < 0):
                continue
            # Sticking is tried first, opening last.
            trial[0] = (beak_state + 1) % 4 if closed[0] else OPEN
            trial[1] = trial[2] = OPEN
            if sleeve >= 0:
                trial[sleeve] = (sleeve_state + 1) % 4
            if not _matches(trial, slips) or not _admissible(
                model, z, closed, slips, fired, trial, sleeve, strict
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


@jit
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


@jit
def _admissible(
    model: Model, z: Floats, closed: Ints, slips: Ints, fired: int, trial: Ints, sleeve: int,
    strict: bool,
) -> bool:  # fmt: skip
    mode = mode_of(trial)
    if sleeve >= 0 and trial[0] == STICK and trial[sleeve] == STICK:
        return rest_is_possible(model, sleeve, z[2] - z[1])
    for i in range(3):
        if not closed[i]:
            continue
        if trial[i] == OPEN:
            _, _, f2, f3 = jet(model, mode, GAP + i, z, trial)
            f2 = 0.0 if fired == NORMAL + i else f2
            if not _positive(0.0, 0.0, f2, f3, 0.0, strict):
                return False
        elif trial[i] == STICK:
            for guard in (CONE_POSITIVE + i, CONE_NEGATIVE + i):
                f0, f1, f2, f3 = jet(model, mode, guard, z, trial)
                f0 = 0.0 if fired == guard else f0
                if not _positive(f0, f1, f2, f3, _weight(model, mode, i, z), strict):
                    return False
        else:
            f0, f1, f2, f3 = jet(model, mode, NORMAL + i, z, trial)
            f0 = 0.0 if fired == NORMAL + i else f0
            if not _positive(f0, f1, f2, f3, _weight(model, mode, i, z), strict):
                return False
            if slips[i] == 0:
                _, f1, f2, f3 = jet(model, mode, SLIP + i, z, trial)
                # lambda_T = +mu lambda_N at the edge of the cone is the force of negative slip.
                edge = CONE_POSITIVE if trial[i] == SLIP_NEGATIVE else CONE_NEGATIVE
                f1 = 0.0 if fired == edge + i else f1
                if not _positive(0.0, f1, f2, f3, 0.0, strict):
                    return False
    return True


@jit
def _weight(model: Model, mode: int, i: int, z: Floats) -> float:
    """Size of the contact force that a rounding error can hide in."""
    column = LAMBDA + 4 * i
    row = model.table[mode]
    return abs(row[column]) + abs(row[column + 1] * (z[2] - z[1]))


@jit
def _positive(
    f0: float, f1: float, f2: float, f3: float, weight: float, strict: bool
) -> bool:
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


@jit
def _same_motion(model: Model, one: int, other: int, z: Floats) -> bool:
    """Whether two modes start with the same accelerations and rates of acceleration."""
    d0, d1 = z[2] - z[1], z[5] - z[4]
    a, b = model.table[one], model.table[other]
    for j in range(3):
        first, second = a[A + j] + a[B + j] * d0, b[A + j] + b[B + j] * d0
        size = abs(a[A + j]) + abs(a[B + j] * d0)
        if abs(first - second) > 1e-9 * size:
            return False
        first, second = a[B + j] * d1, b[B + j] * d1
        if abs(first - second) > 1e-9 * (abs(first) + abs(second)):
            return False
    return True


@jit
def arrive(
    model: Model, z: Floats, tangents: Floats, seed: Floats, fired: int, states: Ints,
    slips: Ints, word: Ints, counts: Ints, event: Floats,
) -> int:  # fmt: skip
    """Apply an event: the impact if a gap closes, then the contact problem that follows.

    ``states`` becomes the new mode, ``slips`` keeps the signs of the tangential velocities (0:
    exactly zero), symbols go to ``word`` (their number is counts[0]), details to ``event``.
    """
    closed, before = np.zeros(3, dtype=np.int64), states.copy()
    taking_part, striking = _touching(model, z, states, fired, closed)
    for j in range(3):
        event[2 + j] = z[3 + j]
    if striking:
        case, impulses = np.zeros(len(taking_part), dtype=np.int64), np.zeros((2, 4))
        used = impulses[:, : 2 * len(taking_part)]
        status = impact(model, taking_part, z, tangents, seed, case, used)
        if status != SOLVED:
            return status
        mask = 0
        for k in range(len(taking_part)):
            i = taking_part[k]
            mask += 1 << i
            closed[i] = 1 if case[k] // 3 == REST else 0
            slips[i] = 0 if case[k] % 3 == HOLD else _sign(_slip_velocity(model, i, z))
            column = 8 + (0 if i == 0 else 2)
            for phase in range(2):
                event[column + 4 * phase] = used[phase, 2 * k]
                event[column + 4 * phase + 1] = used[phase, 2 * k + 1]
        _append(word, counts, 8 * IMPACT + mask)
        for i in range(3):
            before[i] = before[i] if before[i] != OPEN or not closed[i] else SLIP_POSITIVE
        fired = -1
    else:
        for i in range(3):
            stops = states[i] == STICK or fired == SLIP + i
            if closed[i] and stops:
                slips[i] = 0
                z[3] = -(model.tangent[i, 1] * z[4] + model.tangent[i, 2] * z[5])
        for i in range(3):
            if closed[i] and states[i] != STICK and fired != SLIP + i:
                slips[i] = _sign(_slip_velocity(model, i, z))
    for j in range(3):
        event[5 + j] = z[3 + j]
    status = settle(model, z, closed, slips, fired, states)
    if status == SOLVED:
        _append_transitions(before, states, fired, word, counts)
    return status


@jit
def _touching(
    model: Model, z: Floats, states: Ints, fired: int, closed: Ints
) -> tuple[Ints, bool]:
    """Contacts with zero gap, and whether one of them strikes; their angles become exact."""
    found = np.zeros(2, dtype=np.int64)
    n, striking = 0, False
    for i in range(3):
        j, sign = model.angle[i], model.sign[i]
        gap = model.limit[i] + sign * z[j]
        if states[i] != OPEN:
            closed[i] = 1
        elif fired == GAP + i:
            striking = True
        elif gap <= 0.0 and sign * z[3 + j] < 0.0:
            striking = True  # closes in the same instant
        elif gap < 0.0:
            z[j] = -sign * model.limit[i]
            continue
        elif gap > 0.0:
            continue
        z[j] = -sign * model.limit[i]
        if n < 2:
            found[n] = i
            n += 1
    return found[:n], striking


@jit
def _slip_velocity(model: Model, i: int, z: Floats) -> float:
    w = model.tangent[i]
    return w[0] * z[3] + w[1] * z[4] + w[2] * z[5]


@jit
def _sign(value: float) -> int:
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@jit
def _append(word: Ints, counts: Ints, code: int) -> None:
    if counts[0] < len(word):
        word[counts[0]] = code
    counts[0] += 1


@jit
def _append_transitions(
    before: Ints, after: Ints, fired: int, word: Ints, counts: Ints
) -> None:
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
        elif fired == SLIP + i:
            code = REVERSAL
        if code >= 0:
            _append(word, counts, 8 * code + (1 << i))


@jit
def run(
    model: Model, z: Floats, tangents: Floats, seed: Floats, states: Ints, to_section: bool,
    t_end: float, word: Ints, phases: Floats, events: Floats, counts: Ints,
) -> int:  # fmt: skip
    """Follow the toy from event to event until it returns to the section or a limit is met.

    Parameters
    ----------
    z, tangents, seed
        State (7,), derivatives of it (m, 7), derivatives of eps_N along them (m, 3); in place.
    states
        (3,) contact states before the start; contacts with zero gap are decided afresh.
    to_section, t_end
        Stop at the next minimum of phi_S on the jammed sleeve; stop at this time.
    word
        Buffer of event codes; its length is the event limit.
    phases, events
        Buffers for the trajectory, (n, 8) and (n, 16); of length 0 if it is not wanted.
    counts
        (3,) output: symbols, phases, events. Symbols already in the word are kept.
    """
    slips, work = np.zeros(3, dtype=np.int64), np.zeros(7)
    event = np.zeros(EVENT_COLUMNS)
    mark, mark_tangents = z.copy(), tangents.copy()
    mark_contact, mark_symbols, mark_speed = -1, -1, 0.0
    fired, status = -1, SOLVED
    while True:
        symbols = counts[0]
        event[:] = 0.0
        status = arrive(model, z, tangents, seed, fired, states, slips, word, counts, event)
        if len(events) > 0:
            _record_events(events, counts, symbols, z[6], word, event)
        if status != SOLVED:
            return CONTACT_NO_SOLUTION if status == NO_SOLUTION else CONTACT_AMBIGUOUS
        if counts[0] > len(word):
            return EVENT_LIMIT
        if 0 <= fired < 3 and counts[0] == symbols + 1 and states[fired] == OPEN:
            speed = model.sign[fired] * z[3 + model.angle[fired]]
            ratio = speed / mark_speed if mark_speed > 0.0 else 1.0
            if (
                mark_contact == fired
                and mark_symbols == symbols
                and 0.0 <= ratio < 1.0
                and _chatters(model, z, states, fired, mark_speed, z[6] - mark[6], ratio)
            ):
                status = _close_chatter(
                    model, z, tangents, mark, mark_tangents, ratio, fired, states, slips, word,
                    counts, events,
                )  # fmt: skip
                mark_contact = -1
                if status != SOLVED:
                    return CONTACT_NO_SOLUTION if status == NO_SOLUTION else CONTACT_AMBIGUOUS
            else:
                mark_contact, mark_symbols, mark_speed = fired, counts[0], speed
                mark[:] = z
                mark_tangents[:] = tangents
        mode = mode_of(states)
        if len(phases) > 0:
            _record_phase(phases, counts, z, mode)
        t, fired = next_event(model, mode, z, states, to_section, t_end - z[6], -1)
        if t == math.inf:
            sticks = states[0] == STICK or states[1] == STICK or states[2] == STICK
            return AT_REST if sticks else FREE_FALL
        advance(model, mode, fired, t, z, tangents, work)
        if z[0] < -model.pole:
            return POLE_END
        if fired == SECTION:
            z[1] = -model.limit[1]
            z[3] = z[4] = z[5] = 0.0
            for m in range(len(tangents)):
                tangents[m, 1] = 0.0
                tangents[m, 3:6] = 0.0
            return RETURNED
        if fired < 0:
            return TIME_REACHED


@jit
def _chatters(
    model: Model, z: Floats, states: Ints, i: int, speed: float, lap: float, ratio: float
) -> bool:
    """Whether the bounces at contact i are so small that the rest is a geometric series.

    No other event may fall into twice the time that is summed.
    """
    mode = mode_of(states)
    _, _, f2, f3 = jet(model, mode, GAP + i, z, states)
    if f2 >= 0.0:
        return False
    flight = -2.0 * speed / f2
    if flight * (model.table[mode, OMEGA] - f3 / f2) > CHATTER:
        return False
    if flight * abs(f3 / f2) > CHATTER:
        return False
    tail = lap * ratio / (1.0 - ratio)
    return next_event(model, mode, z, states, True, 2.0 * tail, GAP + i)[1] < 0


@jit
def _close_chatter(
    model: Model, z: Floats, tangents: Floats, mark: Floats, mark_tangents: Floats, ratio: float,
    i: int, states: Ints, slips: Ints, word: Ints, counts: Ints, events: Floats,
) -> int:  # fmt: skip
    """Sum the accumulating impacts at contact i and close it.

    Laps shrink by ``ratio``, so the state tends to z + (z - mark) ratio / (1 - ratio). In the word
    the run of equal impacts becomes the one symbol of the accumulation.
    """
    rest = ratio / (1.0 - ratio)
    j = model.angle[i]
    for k in range(7):
        z[k] += (z[k] - mark[k]) * rest
        for m in range(len(tangents)):
            tangents[m, k] += (tangents[m, k] - mark_tangents[m, k]) * rest
    z[j], z[3 + j] = -model.sign[i] * model.limit[i], 0.0
    for m in range(len(tangents)):
        tangents[m, j] = tangents[m, 3 + j] = 0.0
    before, closed = states.copy(), np.zeros(3, dtype=np.int64)
    for k in range(3):
        closed[k] = 1 if k == i or states[k] != OPEN else 0
        if states[k] != OPEN and states[k] != STICK:
            slips[k] = _sign(_slip_velocity(model, k, z))
    if slips[i] != 0:
        slips[i] = _sign(_slip_velocity(model, i, z))
    before[i] = SLIP_POSITIVE
    status = settle(model, z, closed, slips, -1, states)
    last = word[counts[0] - 1]
    while counts[0] > 0 and word[counts[0] - 1] == last:
        counts[0] -= 1
    symbols = counts[0]
    _append(word, counts, 8 * CHATTER_END + (1 << i))
    _append_transitions(before, states, -1, word, counts)
    if len(events) > 0:
        event = np.zeros(EVENT_COLUMNS)
        for k in range(3):
            event[2 + k] = event[5 + k] = z[3 + k]
        _record_events(events, counts, symbols, z[6], word, event)
    return status


@jit
def _record_phase(phases: Floats, counts: Ints, z: Floats, mode: int) -> None:
    if counts[1] < len(phases):
        for k in range(7):
            phases[counts[1], k] = z[k]
        phases[counts[1], 7] = mode
        counts[1] += 1


@jit
def _record_events(
    events: Floats, counts: Ints, symbols: int, t: float, word: Ints, event: Floats
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
def returns(
    model: Model, phi_s: float, order: int, seed: Floats, out: Floats, word: Ints
) -> tuple[int, int]:
    """P_order at one start: (status, length of the word).

    ``out`` receives phi_S, period, drop, then d phi_S / d phi_S0 and the derivatives of phi_S along
    the rows of ``seed`` (k, 3). Code 0 separates the returns in the word.
    """
    z = np.zeros(7)
    z[1], z[2] = -model.limit[1], phi_s
    tangents, seeds = np.zeros((1 + len(seed), 7)), np.zeros((1 + len(seed), 3))
    tangents[0, 2] = 1.0
    seeds[1:] = seed
    states, counts = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    nothing = np.zeros((0, PHASE_COLUMNS))
    no_events = np.zeros((0, EVENT_COLUMNS))
    status = RETURNED
    for lap in range(order):
        if lap > 0:
            _append(word, counts, 0)
        states[0] = states[2] = OPEN
        states[1] = STICK
        status = run(
            model, z, tangents, seeds, states, True, math.inf, word, nothing, no_events, counts
        )
        if status != RETURNED:
            break
    out[0], out[1], out[2] = z[2], z[6], -z[0]
    for m in range(len(tangents)):
        out[3 + m] = tangents[m, 2]
    return status, min(counts[0], len(word))


@jit
def sweep(
    model: Model, starts: Floats, order: int, seed: Floats, out: Floats, status: Ints,
    lengths: Ints, words: Ints, limit: int,
) -> None:  # fmt: skip
    """P_order at many starts; words of all starts go to rows of ``words``."""
    word = np.zeros(limit, dtype=np.int64)
    for n in range(len(starts)):
        status[n], lengths[n] = returns(model, starts[n], order, seed, out[n], word)
        for k in range(min(lengths[n], words.shape[1])):
            words[n, k] = word[k]


@jit
def sample(model: Model, phases: Floats, times: Floats, out: Floats) -> None:
    """States at ascending or descending times from the phases of a trajectory; right-continuous."""
    starts = phases[:, 6]
    for n in range(len(times)):
        k = max(0, np.searchsorted(starts, times[n], side="right") - 1)
        flow(model, int(phases[k, 7]), phases[k, :7], times[n] - starts[k], out[n])
