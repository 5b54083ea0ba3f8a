"""An impact along a path: velocities, derivatives, and the margins of its index combinations."""

from __future__ import annotations

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import FORWARD, HOLD, REST
from woodpecker.mechanics.contact_problems import UNSOLVED, velocity_of
from woodpecker.mechanics.impacts import (
    carry_out,
    clear,
    clear_tangent,
    kick,
    one_change,
    pair_change,
    prepare,
    rates,
)
from woodpecker.mechanics.modes import (
    ANGLE,
    CONTACT,
    EPS,
    EXPANSION,
    FORCE,
    GAP,
    LEVER,
    MU,
    PAIR,
    SIGN,
    SUMMED,
)
from woodpecker.motion.codes import typed
from woodpecker.simulation.margins import (
    ALONG,
    COMPRESSION,
    CONE_MINUS,
    CONE_PLUS,
    EXPANDING,
    NORMAL_SIDE,
    OTHER_END,
    VANISHED,
    Route,
    note,
    note_quotient,
)


@part
def has_faint_bounces(model: Floats) -> bool:
    """Whether a restitution is infinitesimal: flights divide tangents by their speeds."""
    faint = False
    for i in range(3):
        faint = faint or 0.0 < model[CONTACT + i, EPS] <= VANISHED
    return faint


@part
def strike(model: Floats, change: Floats, n: int, k: int, notes: Floats, route: Route) -> None:
    """Carry out an impact at n contacts: velocities, their derivatives, and its margins."""
    # With g = G Lambda + free, and Lambda_T = -+F Lambda_N at contacts that slide, the derivative
    # of Lambda solves the same equations as Lambda, with d(free) + dG Lambda + G_T tau in place of
    # free; then tau = -+dF Lambda_N is added to its tangential part. So values and derivatives are
    # three rows of one array.
    # Margins are the slacks of all inequalities of the index combinations. Impulses and separation
    # speeds are divided by the approach speed, to which they are proportional where all contacts
    # slide, so that they do not vanish with it.
    choice, expands = route.choice, route.choice[2] != UNSOLVED
    contacts = route.touching[:n]
    if n == 2:
        prepare(model, contacts, route.z, route.pair)
    _begin(model, change, n, route)
    code = 1000 * k + 100 * COMPRESSION
    indeterminate = choice[0] != choice[1]  # impulses on a segment, all with velocities zero
    if indeterminate:
        _phase(model, change, n, choice[1], False, route)
        _slacks(model, change, n, choice[1], False, code + OTHER_END, notes, route)
        for m in range(3):
            for a in range(4):
                route.end[m, a] = route.p[m, a]
    _phase(model, change, n, choice[0], False, route)
    _slacks(model, change, n, choice[0], False, code, notes, route)
    if indeterminate:  # the impact goes on from the middle
        for m in range(3):
            for a in range(4):
                route.p[m, a] = 0.5 * (route.p[m, a] + route.end[m, a])
        velocity_of(choice[0], route.pair.delassus, route.free[0], route.p[0], route.v[0])
    _keep(0, n, route)
    _store_impulse(model, n, route)
    if expands:
        _phase(model, change, n, choice[2], True, route)
        code = 1000 * k + 100 * EXPANDING
        _slacks(model, change, n, choice[2], True, code, notes, route)
        _keep(1, n, route)
    _carry_out(model, change, contacts, route)


@part
def _keep(phase: int, n: int, route: Route) -> None:
    """Store the impulses of a phase, and add up the derivatives of those of both phases."""
    for a in range(2 * n):
        route.impulses[phase, a] = route.p[0, a]
        for m in range(2):
            route.d_impulses[m, a] += route.p[1 + m, a]


@part
def _carry_out(model: Floats, change: Floats, contacts: Ints, route: Route) -> None:
    """Change the velocities by the impulses of both phases, and the tangents likewise."""
    case, tangents, impulses = route.case, route.tangents, route.impulses
    for j in range(len(contacts)):
        i, a = contacts[j], 2 * j
        if len(change) > 0:
            p_n, p_t = impulses[0, a] + impulses[1, a], impulses[0, a + 1] + impulses[1, a + 1]
            kick(change, i, p_n, p_t, tangents[1])
        for m in range(2):
            kick(model, i, route.d_impulses[m, a], route.d_impulses[m, a + 1], tangents[m])
        route.pair.after[a] = route.v[0, a]
    carry_out(model, contacts, route.choice, route.z, case, impulses, route.pair)
    faint = len(contacts) if has_faint_bounces(model) else 0
    for m in range(2):
        for j in range(faint):  # as in z, their gap rates must be free of the rounding of kicks
            i = contacts[j]
            rate = route.v[1 + m, 2 * j]
            if m == 1 and len(change) > 0:
                rate -= rates(change, i, route.z)[0]
            tangents[m, 3 + ANGLE[i]] = SIGN[i] * rate / model[FORCE, LEVER + i]
        clear(model, contacts, case, tangents[m])
        if m == 1 and len(change) > 0:
            clear_tangent(change, contacts, case, route.z, tangents[m])


@part
def _begin(model: Floats, change: Floats, n: int, route: Route) -> None:
    """Set up the compression: velocities before it, floors of zero, and no impulses yet."""
    for j in range(n):
        i, a, free = route.touching[j], 2 * j, route.free
        free[0, a], free[0, a + 1] = rates(model, i, route.z)
        for m in range(2):
            free[1 + m, a], free[1 + m, a + 1] = rates(model, i, route.tangents[m])
        if len(change) > 0:
            normal, tangential = rates(change, i, route.z)
            free[2, a] += normal
            free[2, a + 1] += tangential
        for m in range(3):
            route.floor[m, j] = 0.0
        if route.fired[0] == GAP + i:
            for m in range(3):
                route.approach[m] = -free[m, a]
    for a in range(2 * n):
        for m in range(2):
            route.impulses[m, a] = route.d_impulses[m, a] = 0.0


@part
def _store_impulse(model: Floats, n: int, route: Route) -> None:
    """Set up the expansion: velocities and floors that the compression leaves."""
    p, floor = route.p, route.floor
    for a in range(2 * n):
        for m in range(3):
            route.free[m, a] = route.v[m, a]
    for j in range(n):
        i, a = route.touching[j], 2 * j
        for m in range(3):
            floor[m, j] = model[CONTACT + i, EPS] * p[m, a]
        for m in range(2):
            floor[1 + m, j] += route.seeds[m, i] * p[0, a]


@part
def _phase(
    model: Floats, change: Floats, n: int, combination: int, expansion: bool, route: Route
) -> None:
    """Find impulses and velocities of one phase."""
    p, v, pair = route.p, route.v, route.pair
    table, coupling = typed(0), 0.0
    if n == 2:
        table = PAIR + 36 * (route.touching[1] - 1) + (EXPANSION if expansion else 0)
        coupling = model[FORCE, SUMMED] if expansion else 0.0
    for m in range(3):
        free, floor, own, after = route.free[m], route.floor[m], p[m], v[m]
        moves = m == 2 and len(change) > 0
        if n == 2:
            for a in range(4):
                pair.free[a] = free[a]
            pair.floor[0], pair.floor[1] = floor[0], floor[1]
            pair_change(
                model, change, moves, route.touching[:n], table, combination, coupling, p[0], pair
            )
            for a in range(4):
                own[a], after[a] = pair.more[a], pair.middle[a]
        else:
            own[0], own[1], after[0], after[1] = one_change(
                model, change, moves, route.touching[0], combination, p[0, 0], p[0, 1], free[0],
                free[1], floor[0],
            )  # fmt: skip


@part
def _slacks(
    model: Floats, change: Floats, n: int, combination: int, expansion: bool, code: int,
    notes: Floats, route: Route,
) -> None:  # fmt: skip
    # Two gap rates and a slip of zero mean that the whole toy rests: then the other slip is zero,
    # too, whatever its friction, and is no margin.
    if notes.shape[1] == 0:
        return
    first, second = combination % 6, combination // 6
    rests = n == 2 and first // 3 == REST and second // 3 == REST
    still = rests and (first % 3 == HOLD or second % 3 == HOLD)
    p, v, floor, bound, scale = route.p, route.v, route.floor, route.bound, route.approach
    coupling = model[FORCE, SUMMED] if expansion else 0.0
    for j in range(n):
        case = second if j == 1 else first
        at, a, b = code + 4 * route.touching[j], 2 * j, 2 * j + 1
        if case // 3 == REST:
            _slack(notes, route, at + NORMAL_SIDE, p, a, -1.0, floor, j)
        else:
            note_quotient(notes, route, at + NORMAL_SIDE, v[0, a], v[1, a], v[2, a], scale)
        if case % 3 == HOLD:
            mu = CONTACT + route.touching[j], MU
            for m in range(2, -1, -1):
                load = p[m, a] + (coupling * p[m, 2 - a] if n == 2 else 0.0)
                bound[m, j] = model[mu] * load
            if len(change) > 0:  # the last load is the value itself
                bound[2, j] += change[mu] * load
            _slack(notes, route, at + CONE_PLUS, bound, j, -1.0, p, b)
            _slack(notes, route, at + CONE_MINUS, bound, j, 1.0, p, b)
        elif not still:
            sign = 1.0 if case % 3 == FORWARD else -1.0
            note(notes, route, at + ALONG, sign * v[0, b], sign * v[1, b], sign * v[2, b])


@part
def _slack(
    notes: Floats, route: Route, cause: int, of: Floats, a: int, sign: float, other: Floats, b: int
) -> None:
    # a sum or difference of two numbers, over the approach speed
    note_quotient(
        notes, route, cause, of[0, a] + sign * other[0, b], of[1, a] + sign * other[1, b],
        of[2, a] + sign * other[2, b], route.approach,
    )  # fmt: skip
