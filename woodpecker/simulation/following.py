"""A return along a given path: no search for events, no contact problem, a smooth map.

The kernel finds out what happens; a *path* is what it found: for each phase the mode, the guard
that ends it, and the index combinations of the impact that began it. With the path prescribed a
return is a composition of smooth maps. Each event time follows by Newton's method from that of a
neighbour, so the map exists beyond the interval where the kernel finds this path.

Where it is admissible is said by *margins*, numbers that are positive inside and of which one
vanishes at a border: the least value of a guard that must not fire in its phase, the speed of the
one that fires, the slack of every inequality of an index combination or of a contact that stays
closed. What a margin watches is its cause.
"""

from __future__ import annotations

import math

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics.cases import FORWARD, HOLD, REST, impulse_of
from woodpecker.mechanics.impacts import (
    UNSOLVED,
    carry_out,
    hold,
    one_contact_case,
    prepare,
    rates,
    rest_range,
    velocity_of,
)
from woodpecker.mechanics.modes import (
    ANGLE,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    CONTACT,
    DELASSUS,
    EPS,
    EXPANSION,
    FORCE,
    GAP,
    GUARDS,
    KAPPA,
    MU,
    NORMAL,
    OMEGA,
    OPEN,
    PAIR,
    SECTION,
    SIGN,
    SLIP,
    STICK,
    SUMMED,
)
from woodpecker.simulation.guards import EPSILON, TWO_PI, lowest, value
from woodpecker.simulation.kernel import (
    CLOSED,
    FIRST,
    GUARD,
    HELD,
    MODE,
    OTHER,
    RETURNED,
    SECOND,
    STRUCK,
    Room,
    advance,
    measure,
    put_on_section,
    shut,
    starting_jet,
    still_contacts,
    stop,
    sum_bounces,
    time_to_minimum,
    touch,
    typed,
)

NO_ROOT = -1  # a guard of the path has no root here

NEWTON = 40  # steps from a neighbour's event time; three are usual

# What a margin watches: code = 1000 * phase + 100 * kind + item.
MEETING, DIP, SPEED, START, COMPRESSION, EXPANDING, SWING, RESTING, BOUNCES = range(9)
# MEETING: a guard where another one fires; DIP: least value of a guard at its minima in a phase;
# SPEED: of the guard that fires, squared; START: of a guard where the phase begins; COMPRESSION,
# EXPANDING: slack 4 * contact + inequality of an impact; SWING: time between the minimum of phi_S
# that counts and the neighbouring ones; RESTING: what friction leaves to two contacts that hold
# the toy; BOUNCES: 1 - ratio of bounces that accumulate
NORMAL_SIDE, ALONG, CONE_PLUS, CONE_MINUS = range(4)  # the inequalities of a contact

MARGINS = 1024  # room for the margins of one return


@jit
def follow(
    model: Floats, change: Floats, path: Ints, times: Floats, z: Floats, tangents: Floats,
    seed: Floats, margins: Floats, causes: Ints, found: Ints, room: Room, memory: Floats,
) -> int:  # fmt: skip
    """Follow the toy from the section along a path until it returns.

    Parameters
    ----------
    model, change, tangents, seed
        As :func:`woodpecker.simulation.kernel.run` takes them; ``z`` is a state on the section.
    path
        (n, STEP_COLUMNS), what the kernel found for a neighbour.
    times
        (n,) durations of the phases: the neighbour's, and then those found here.
    margins, causes
        Output: margins and what they watch. Nothing is written if they have length 0.
    found
        (1,) output: the number of margins.
    room, memory
        Room for a run, and for the tangents (m, 7) after the bounce before.

    Returns
    -------
    RETURNED, or NO_ROOT.
    """
    gaps, work, states = room.gaps, room.work, room.closed
    measure(model, z, gaps)
    found[0] = 0
    fired = typed(-1)
    states[0] = states[1] = states[2] = OPEN
    for k in range(len(path)):
        step = path[k]
        if k > 0:
            _event(
                model, change, step, fired, k, z, gaps, tangents, seed, states, margins, causes,
                found, memory, room,
            )  # fmt: skip
            if step[STRUCK] != 0:
                fired = typed(-1)
        mode = step[MODE]
        unpack(mode, states)
        if step[STRUCK] != 0:
            still_contacts(states, tangents)
        if len(margins) > 0:
            _start_margins(model, step, k, z, gaps, states, fired, margins, causes, found)
        guard = step[GUARD]
        if guard == SECTION:
            t = _time_of_section(model, mode, z, times[k])
        else:
            f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, states, fired)
            t = root_near(f0, f1, f2, f3, model[mode, KAPPA], model[mode, OMEGA], times[k])
            if not math.isfinite(t):
                return NO_ROOT
        if len(margins) > 0:
            _phase_margins(model, mode, guard, t, k, z, gaps, states, fired, margins, causes, found)
        times[k] = t
        advance(model, change, mode, guard, t, z, gaps, tangents, work)
        fired = guard
    put_on_section(model, change, z, tangents)
    return RETURNED


@jit
def unpack(mode: int, states: Ints) -> None:
    """Contact states (3,) of a mode; undoes :func:`woodpecker.simulation.kernel.mode_of`."""
    sleeve = mode % 7
    states[0] = mode // 7
    states[1] = sleeve if sleeve <= 3 else 0
    states[2] = sleeve - 3 if sleeve > 3 else 0


@jit
def root_near(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, t: float
) -> float:
    """Root of a guard near a time, by Newton's method; nan if that finds none.

    The root may lie before the phase begins: there two events have changed places.
    """
    before = math.inf
    for _ in range(NEWTON):
        f, slope = value(f0, f1, f2, f3, kappa, omega, t)
        if slope == 0.0:
            return math.nan
        step = -f / slope
        if abs(step) >= before and before <= 4.0 * EPSILON * abs(t):
            return t
        t += step
        if abs(step) <= 0.25 * EPSILON * abs(t) or f == 0.0:
            return t
        before = abs(step)
    return t if before <= 64.0 * EPSILON * abs(t) else math.nan


@jit
def _time_of_section(model: Floats, mode: int, z: Floats, near: float) -> float:
    """Time of the minimum of phi_S that is nearest to a time."""
    t, swing = time_to_minimum(model, mode, z), TWO_PI / model[mode, OMEGA]
    return float(t + swing * math.floor((near - t) / swing + 0.5))


@jit
def _event(
    model: Floats, change: Floats, step: Ints, fired: int, k: int, z: Floats, gaps: Floats,
    tangents: Floats, seed: Floats, states: Ints, margins: Floats, causes: Ints, found: Ints,
    memory: Floats, room: Room,
) -> None:  # fmt: skip
    """Carry out what begins a phase; ``states`` are those of the phase before."""
    struck, closed, mark = step[STRUCK], step[CLOSED], room.mark
    for i in range(3):
        if states[i] != OPEN or struck >> i & 1:
            touch(model, i, z, gaps)
    if struck == 0:
        for i in range(3):
            if states[i] == STICK or fired == SLIP + i:
                hold(model, i, z)
        return
    n, choice = 0, room.choice
    for i in range(3):
        if struck >> i & 1:
            room.touching[n] = i
            n += 1
    contacts = room.touching[:n]
    choice[0], choice[1], choice[2] = step[FIRST], step[OTHER], step[SECOND]
    if len(margins) > 0:
        _impact_margins(model, contacts, choice, k, z, margins, causes, found, room)
    if n == 2:
        prepare(model, contacts, z, room.pair)
    carry_out(
        model, change, contacts, choice, z, tangents, seed, room.case, room.impulses, room.pair
    )
    if closed == 0:
        for c in range(7):
            mark[c] = z[c]
            for m in range(len(tangents)):
                memory[m, c] = tangents[m, c]
        return
    if closed in (1, 2, 4):  # bounces at one contact; those of two in turns leave nothing to sum
        i = contacts[0]
        mark[7] = SIGN[i] * mark[3 + ANGLE[i]]
        ratio = SIGN[i] * z[3 + ANGLE[i]] / mark[7]
        _note(margins, causes, found, 1.0 - ratio, 1000 * k + 100 * BOUNCES + i)
        sum_bounces(z, gaps, tangents, memory, mark, ratio, i)
    shut(model, change, closed, z, gaps, tangents)
    for i in range(3):
        if step[HELD] >> i & 1:
            stop(model, change, i, z, tangents)


@jit
def _note(margins: Floats, causes: Ints, found: Ints, margin: float, cause: int) -> None:
    if found[0] < len(margins):
        margins[found[0]], causes[found[0]] = margin, cause
        found[0] += 1


@jit
def _start_margins(
    model: Floats, step: Ints, k: int, z: Floats, gaps: Floats, states: Ints, fired: int,
    margins: Floats, causes: Ints, found: Ints,
) -> None:  # fmt: skip
    """What keeps each touching contact in its state where a phase begins.

    It is the first derivative of a guard that the event has not made exactly zero.
    """
    sleeve = 1 if states[1] == STICK else 2
    if states[0] == STICK and states[sleeve] == STICK:
        low, high = rest_range(model, sleeve, z[2] - z[1])
        _note(margins, causes, found, high - low, 1000 * k + 100 * RESTING)
        return
    for i in range(3):
        if gaps[i] != 0.0 or z[3 + ANGLE[i]] != 0.0:
            continue
        held = step[HELD] >> i & 1
        if states[i] == OPEN:
            watched, other = GAP + i, -1
        elif states[i] == STICK:
            watched, other = CONE_POSITIVE + i, CONE_NEGATIVE + i
        else:
            watched, other = NORMAL + i, (SLIP + i if held else -1)
        for guard in (watched, other):
            if guard >= 0:
                f0, f1, f2, f3 = starting_jet(model, step[MODE], guard, z, gaps, states, fired)
                if guard >= SLIP:
                    f0 = 0.0  # nothing slips yet
                first = f0 if f0 != 0.0 else (f1 if f1 != 0.0 else (f2 if f2 != 0.0 else f3))
                _note(margins, causes, found, first, 1000 * k + 100 * START + guard)


@jit
def _phase_margins(
    model: Floats, mode: int, fired: int, t: float, k: int, z: Floats, gaps: Floats, states: Ints,
    before: int, margins: Floats, causes: Ints, found: Ints,
) -> None:  # fmt: skip
    """What keeps all guards but one from firing in a phase of duration t, and lets it fire."""
    kappa, omega = model[mode, KAPPA], model[mode, OMEGA]
    for column in range(GUARDS, GUARDS + 5):
        guard = int(model[mode, column])
        if guard < 0:
            break
        if guard == SECTION:
            if k > 0:
                swing, minimum = TWO_PI / omega, time_to_minimum(model, mode, z)
                if fired == SECTION:
                    _note(margins, causes, found, t, 1000 * k + 100 * SWING)
                    _note(margins, causes, found, swing - t, 1000 * k + 100 * SWING + 1)
                else:
                    _note(margins, causes, found, minimum - t, 1000 * k + 100 * SWING + 2)
            continue
        if guard != fired and guard >= SLIP and fired >= SLIP:
            continue  # two contacts that slide do so as one
        f0, f1, f2, f3 = starting_jet(model, mode, guard, z, gaps, states, before)
        least = lowest(f0, f1, f2, f3, kappa, omega, t)
        end, slope = value(f0, f1, f2, f3, kappa, omega, t)
        if guard == fired:
            _note(margins, causes, found, slope * slope, 1000 * k + 100 * SPEED + guard)
        else:
            _note(margins, causes, found, end, 1000 * k + 100 * MEETING + guard)
        if least < math.inf:
            _note(margins, causes, found, least, 1000 * k + 100 * DIP + guard)


@jit
def _impact_margins(
    model: Floats, contacts: Ints, choice: Ints, k: int, z: Floats, margins: Floats, causes: Ints,
    found: Ints, room: Room,
) -> None:  # fmt: skip
    """Slack of all inequalities of the index combinations of an impact.

    An indeterminate compression lies on a segment whose ends have none; it gives no margins.
    """
    n, pair = len(contacts), room.pair
    free, floor, p, v, mu = pair.free, pair.floor, pair.end, pair.middle, pair.mu
    table, coupling = 0, 0.0
    if n == 2:
        prepare(model, contacts, z, pair)
        table = PAIR + 36 * (contacts[1] - 1)
    else:
        i = contacts[0]
        mu[0], floor[0] = model[CONTACT + i, MU], 0.0
        free[0], free[1] = rates(model, i, z)
    for phase in range(2):
        combination = choice[0] if phase == 0 else choice[2]
        if combination == UNSOLVED:
            return
        if phase == 1:
            for j in range(n):
                floor[j] = model[CONTACT + contacts[j], EPS] * p[2 * j]
            for j in range(2 * n):
                free[j] = v[j]
            coupling = model[FORCE, SUMMED] if n == 2 else 0.0
        if n == 2:
            row = table + combination + (EXPANSION if phase == 1 else 0)
            impulse_of(model, row, free, floor, p)
            velocity_of(combination, pair.delassus, free, p, v)
        else:
            _single_phase(model, contacts[0], combination, free, floor[0], p, v)
        if phase == 1 or choice[0] == choice[1]:
            kind = EXPANDING if phase == 1 else COMPRESSION
            for j in range(n):
                case = combination // 6 if j == 1 else combination % 6
                other = p[2 - 2 * j] if n == 2 else 0.0
                code = 1000 * k + 100 * kind + 4 * contacts[j]
                _contact_margins(
                    case, p[2 * j], p[2 * j + 1], v[2 * j], v[2 * j + 1], floor[j],
                    mu[j] * (p[2 * j] + coupling * other), code, margins, causes, found,
                )  # fmt: skip


@jit
def _single_phase(
    model: Floats, i: int, case: int, free: Floats, floor: float, p: Floats, v: Floats
) -> None:
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    mu = model[CONTACT + i, MU]
    p[0], p[1] = one_contact_case(case, g_nn, g_nt, g_tt, free[0], free[1], mu, floor)
    v[0] = 0.0 if case // 3 == REST else free[0] + g_nn * p[0] + g_nt * p[1]
    v[1] = 0.0 if case % 3 == HOLD else free[1] + g_nt * p[0] + g_tt * p[1]


@jit
def _contact_margins(
    case: int, p_n: float, p_t: float, v_n: float, v_t: float, floor: float, bound: float,
    code: int, margins: Floats, causes: Ints, found: Ints,
) -> None:  # fmt: skip
    """Slack at one contact in one phase of an impact."""
    normal = p_n - floor if case // 3 == REST else v_n
    _note(margins, causes, found, normal, code + NORMAL_SIDE)
    if case % 3 == HOLD:
        _note(margins, causes, found, bound - p_t, code + CONE_PLUS)
        _note(margins, causes, found, bound + p_t, code + CONE_MINUS)
    else:
        along = v_t if case % 3 == FORWARD else -v_t
        _note(margins, causes, found, along, code + ALONG)
