"""An impact along a path: velocities, derivatives, and the margins of its index combinations."""

from __future__ import annotations

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import FORWARD, HOLD, REST, impulse_of
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
    # free; then tau = -+dF Lambda_N is added to its tangential part.
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
        _slacks(n, choice[1], code + OTHER_END, notes, route)
        for a in range(4):
            route.end[a] = route.p[a]
            for m in range(2):
                route.d_end[m, a] = route.d_p[m, a]
    _phase(model, change, n, choice[0], False, route)
    _slacks(n, choice[0], code, notes, route)
    if indeterminate:  # the impact goes on from the middle
        for a in range(4):
            route.p[a] = 0.5 * (route.p[a] + route.end[a])
            for m in range(2):
                route.d_p[m, a] = 0.5 * (route.d_p[m, a] + route.d_end[m, a])
        velocity_of(choice[0], route.pair.delassus, route.free, route.p, route.v)
    _keep(0, n, route)
    _store_impulse(model, n, route)
    if expands:
        _phase(model, change, n, choice[2], True, route)
        _slacks(n, choice[2], 1000 * k + 100 * EXPANDING, notes, route)
        _keep(1, n, route)
    _carry_out(model, change, contacts, route)


@part
def _keep(phase: int, n: int, route: Route) -> None:
    """Store the impulses of a phase, and add up the derivatives of those of both phases."""
    for a in range(4):
        route.impulses[phase, a] = route.p[a] if a < 2 * n else 0.0
        if phase == 0:
            route.impulses[1, a] = 0.0
        for m in range(2):
            before = route.d_impulses[m, a] if phase == 1 else 0.0
            route.d_impulses[m, a] = before + (route.d_p[m, a] if a < 2 * n else 0.0)


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
        route.pair.after[a] = route.v[a]
    carry_out(model, contacts, route.choice, route.z, case, impulses, route.pair)
    for m in range(2):
        # as in z, gap rates of infinitesimal bounces must be free of the rounding of kicks
        for j in range(len(contacts) if has_faint_bounces(model) else 0):
            i = contacts[j]
            rate = route.d_v[m, 2 * j]
            if m == 1 and len(change) > 0:
                rate -= rates(change, i, route.z)[0]
            tangents[m, 3 + ANGLE[i]] = SIGN[i] * rate / model[FORCE, LEVER + i]
        clear(model, contacts, case, tangents[m])
        if m == 1 and len(change) > 0:
            clear_tangent(change, contacts, case, route.z, tangents[m])


@part
def _begin(model: Floats, change: Floats, n: int, route: Route) -> None:
    """Set up the compression: velocities before it with derivatives, and floors of zero."""
    for j in range(n):
        i, a = route.touching[j], 2 * j
        route.free[a], route.free[a + 1] = rates(model, i, route.z)
        route.floor[j] = 0.0
        for m in range(2):
            normal, tangential = rates(model, i, route.tangents[m])
            if m == 1 and len(change) > 0:
                more, along = rates(change, i, route.z)
                normal, tangential = normal + more, tangential + along
            route.d_free[m, a], route.d_free[m, a + 1] = normal, tangential
            route.d_floor[m, j] = 0.0
        if route.fired[0] == GAP + i:
            route.approach[0] = -route.free[a]
            route.approach[1], route.approach[2] = -route.d_free[0, a], -route.d_free[1, a]


@part
def _store_impulse(model: Floats, n: int, route: Route) -> None:
    """Set up the expansion: velocities and floors that the compression leaves, with derivatives."""
    for a in range(2 * n):
        route.free[a] = route.v[a]
        for m in range(2):
            route.d_free[m, a] = route.d_v[m, a]
    for j in range(n):
        i = route.touching[j]
        eps = model[CONTACT + i, EPS]
        route.floor[j] = eps * route.p[2 * j]
        for m in range(2):
            route.d_floor[m, j] = eps * route.d_p[m, 2 * j] + route.seeds[m, i] * route.p[2 * j]


@part
def _phase(
    model: Floats, change: Floats, n: int, combination: int, expansion: bool, route: Route
) -> None:
    """Find impulses, velocities and bounds of friction of one phase, with derivatives."""
    p, v, pair = route.p, route.v, route.pair
    table, coupling = typed(0), 0.0
    if n == 2:
        table = PAIR + 36 * (route.touching[1] - 1) + (EXPANSION if expansion else 0)
        coupling = model[FORCE, SUMMED] if expansion else 0.0
        impulse_of(model, table + combination, route.free, route.floor, p)
        velocity_of(combination, pair.delassus, route.free, p, v)
    else:
        # linear in free and floor, as their derivatives are
        p[0], p[1], v[0], v[1] = one_change(
            model, change, UNSOLVED, route.touching[0], combination, 0.0, 0.0,
            route.free[0], route.free[1], route.floor[0],
        )  # fmt: skip
    for m in range(2):
        along = m if m == 1 and len(change) > 0 else UNSOLVED
        d_p, d_v = route.d_p[m], route.d_v[m]
        if n == 2:
            for a in range(4):
                pair.free[a] = route.d_free[m, a]
            pair.floor[0], pair.floor[1] = route.d_floor[m, 0], route.d_floor[m, 1]
            pair_change(
                model, change, along, route.touching[:n], table, combination, coupling, p, pair
            )
            for a in range(4):
                d_p[a], d_v[a] = pair.more[a], pair.middle[a]
        else:
            d_p[0], d_p[1], d_v[0], d_v[1] = one_change(
                model, change, along, route.touching[0], combination, p[0], p[1],
                route.d_free[m, 0], route.d_free[m, 1], route.d_floor[m, 0],
            )  # fmt: skip
    for j in range(n):
        i, other = route.touching[j], 2 - 2 * j
        mu = model[CONTACT + i, MU]
        load = p[2 * j] + (coupling * p[other] if n == 2 else 0.0)
        route.bound[j] = mu * load
        for m in range(2):
            d_load = route.d_p[m, 2 * j] + (coupling * route.d_p[m, other] if n == 2 else 0.0)
            route.d_bound[m, j] = mu * d_load
        if len(change) > 0:
            route.d_bound[1, j] += change[CONTACT + i, MU] * load


@part
def _slacks(n: int, combination: int, code: int, notes: Floats, route: Route) -> None:
    # Two gap rates and a slip of zero mean that the whole toy rests: then the other slip is zero,
    # too, whatever its friction, and is no margin.
    if notes.shape[1] == 0:
        return
    first, second = combination % 6, combination // 6
    rests = n == 2 and first // 3 == REST and second // 3 == REST
    still = rests and (first % 3 == HOLD or second % 3 == HOLD)
    p, v, floor, bound = route.p, route.v, route.floor, route.bound
    d_p, d_v, d_floor, d_bound = route.d_p, route.d_v, route.d_floor, route.d_bound
    scale = route.approach
    for j in range(n):
        case = second if j == 1 else first
        at, a, b = code + 4 * route.touching[j], 2 * j, 2 * j + 1
        if case // 3 == REST:
            x, y = d_p[0, a] - d_floor[0, j], d_p[1, a] - d_floor[1, j]
            note_quotient(notes, route, at + NORMAL_SIDE, p[a] - floor[j], x, y, scale)
        else:
            note_quotient(notes, route, at + NORMAL_SIDE, v[a], d_v[0, a], d_v[1, a], scale)
        if case % 3 == HOLD:
            x, y = d_bound[0, j] - d_p[0, b], d_bound[1, j] - d_p[1, b]
            note_quotient(notes, route, at + CONE_PLUS, bound[j] - p[b], x, y, scale)
            x, y = d_bound[0, j] + d_p[0, b], d_bound[1, j] + d_p[1, b]
            note_quotient(notes, route, at + CONE_MINUS, bound[j] + p[b], x, y, scale)
        elif not still:
            sign = 1.0 if case % 3 == FORWARD else -1.0
            note(notes, route, at + ALONG, sign * v[b], sign * d_v[0, b], sign * d_v[1, b])
