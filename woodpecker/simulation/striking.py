"""An impact along a path: velocities, derivatives, and the margins of its index combinations."""

from __future__ import annotations

import math

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import FORWARD, FREE, HOLD, REST, impulse_of
from woodpecker.mechanics.contact_problems import UNSOLVED, one_contact_phase, velocity_of
from woodpecker.mechanics.impacts import (
    carry_out,
    clear,
    clear_change,
    kick,
    prepare,
    rates,
    row_of_pair,
)
from woodpecker.mechanics.modes import (
    ANGLE,
    CONTACT,
    DELASSUS,
    EPS,
    FORCE,
    GAP,
    MU,
    SUMMED,
)
from woodpecker.simulation.margins import (
    ALONG,
    COMPRESSION,
    CONE_MINUS,
    CONE_PLUS,
    EXPANDING,
    NORMAL_SIDE,
    OTHER_END,
    Route,
    note,
    note_quotient,
)


@part
def strike(model: Floats, change: Floats, n: int, k: int, notes: Floats, route: Route) -> None:
    """Change the velocities of a route and their derivatives by an impact at n contacts."""
    # Margins are the slack of all inequalities of the index combinations. Impulses and separation
    # speeds are divided by the approach speed, to which they are proportional where all contacts
    # slide, so that they do not vanish with it.
    choice, expands = route.choice, route.choice[2] != UNSOLVED
    contacts = route.touching[:n]
    prepare(model, contacts, route.z, route.pair)
    _begin(model, change, n, route)
    code = 1000 * k + 100 * COMPRESSION
    indeterminate = choice[0] != choice[1]  # it ends on a segment, where all velocities are zero
    if indeterminate:
        _phase(model, change, n, choice[1], False, route)
        _slacks(n, choice[1], code + OTHER_END, notes, route)
        for r in range(3):
            for a in range(4):
                route.end[r, a] = route.p[r, a]
    _phase(model, change, n, choice[0], False, route)
    _slacks(n, choice[0], code, notes, route)
    if indeterminate:  # it goes on from the middle
        for r in range(3):
            for a in range(4):
                route.p[r, a] = 0.5 * (route.p[r, a] + route.end[r, a])
        delassus = route.pair.delassus
        velocity_of(choice[0], delassus, route.free[0], route.p[0], route.v[0])
    for r in range(3):
        for a in range(2 * n):
            route.total[r, a] = route.p[r, a]
    _store_impulse(model, n, route)
    code = 1000 * k + 100 * EXPANDING
    if expands:
        _phase(model, change, n, choice[2], True, route)
        _slacks(n, choice[2], code, notes, route)
        _add_impulses(n, route)
    else:
        _leave_out_expansion(model, n, code, notes, route)
    _carry_out(model, change, contacts, route)


@part
def _add_impulses(n: int, route: Route) -> None:
    for r in range(3):
        for a in range(2 * n):
            route.total[r, a] += route.p[r, a]


@part
def _leave_out_expansion(model: Floats, n: int, code: int, notes: Floats, route: Route) -> None:
    """An impact without expansion: margins and derivatives of the one at a larger eps_N."""
    floor = route.floor
    if notes.shape[1] > 0:
        for j in range(n):
            if floor[0, j] > 0.0:  # it would expand
                note_quotient(
                    notes, route, code + 4 * route.touching[j], -floor[0, j], -floor[1, j],
                    -floor[2, j], route.approach,
                )  # fmt: skip
    if n == 2:
        return
    for r in range(3):
        for a in range(2):
            route.p[r, a] = 0.0
        if r > 0 and floor[r, 0] != 0.0:
            _row(model, 1, 3 * FREE + route.choice[0] % 3, False, r, route)
    _add_impulses(n, route)


@part
def _carry_out(model: Floats, change: Floats, contacts: Ints, route: Route) -> None:
    """Change the velocities by the impulses of both phases, and the tangents likewise."""
    case, tangents, total = route.case, route.tangents, route.total
    for j in range(len(contacts)):
        i, a = contacts[j], 2 * j
        if len(change) > 0:
            kick(change, i, total[0, a], total[0, a + 1], tangents[1])
        for m in range(2):
            kick(model, i, total[1 + m, a], total[1 + m, a + 1], tangents[m])
        route.pair.after[a] = route.v[0, a]
    carry_out(model, contacts, route.choice, route.z, case, total[:1], route.pair)
    for m in range(2):
        bounce = 0.0
        for i in contacts:
            if route.seeds[m, i] != 0.0 and model[CONTACT + i, EPS] == 0.0:
                bounce = tangents[m, 3 + ANGLE[i]] if len(contacts) == 1 else math.nan
        clear(model, contacts, case, tangents[m])
        if m == 1 and len(change) > 0:
            clear_change(change, contacts, case, route.z, tangents[m])
        if bounce != 0.0:  # a larger eps_N makes this contact bounce
            tangents[m, 3 + ANGLE[contacts[0]]] = bounce


@part
def _begin(model: Floats, change: Floats, n: int, route: Route) -> None:
    """Velocities before the compression, and their derivatives; its floors are zero."""
    free = route.free
    for j in range(n):
        i, a = route.touching[j], 2 * j
        free[0, a], free[0, a + 1] = route.pair.free[a], route.pair.free[a + 1]
        for m in range(2):
            free[1 + m, a], free[1 + m, a + 1] = rates(model, i, route.tangents[m])
        if len(change) > 0:
            more, along = rates(change, i, route.z)
            free[2, a], free[2, a + 1] = free[2, a] + more, free[2, a + 1] + along
        for r in range(3):
            route.floor[r, j] = 0.0
            if route.fired[0] == GAP + i:
                route.approach[r] = -free[r, a]


@part
def _store_impulse(model: Floats, n: int, route: Route) -> None:
    """Velocities and floors at the start of the expansion, from the compression."""
    p, floor = route.p, route.floor
    for r in range(3):
        for a in range(2 * n):
            route.free[r, a] = route.v[r, a]
        for j in range(n):
            i = route.touching[j]
            floor[r, j] = model[CONTACT + i, EPS] * p[r, 2 * j]
            if r > 0:
                floor[r, j] += route.seeds[r - 1, i] * p[0, 2 * j]


@part
def _phase(
    model: Floats, change: Floats, n: int, combination: int, expansion: bool, route: Route
) -> None:
    """Impulses, velocities and bounds of friction of one phase of an impact, and derivatives."""
    p = route.p
    _row(model, n, combination, expansion, 0, route)
    _row(model, n, combination, expansion, 1, route)
    if len(change) > 0:
        _changed_row(model, change, n, combination, expansion, route)
    else:
        _row(model, n, combination, expansion, 2, route)
    for j in range(n):
        i = route.touching[j]
        for r in range(3):
            load = p[r, 2 * j]
            if n == 2 and expansion:
                load += model[FORCE, SUMMED] * p[r, 2 - 2 * j]
            route.bound[r, j] = load
        more = change[CONTACT + i, MU] * route.bound[0, j] if len(change) > 0 else 0.0
        for r in range(3):
            route.bound[r, j] *= model[CONTACT + i, MU]
        route.bound[2, j] += more


@part
def _row(model: Floats, n: int, index: int, expands: bool, r: int, route: Route) -> None:
    """Impulses and velocities of a phase (row 0), or their derivatives along a tangent."""
    p, v, free, floor, g = route.p, route.v, route.free, route.floor, route.pair.delassus
    if n == 1:
        p[r, 0], p[r, 1], v[r, 0], v[r, 1] = one_contact_phase(
            index, g[0, 0], g[0, 1], g[1, 1], free[r, 0], free[r, 1], route.pair.mu[0], floor[r, 0]
        )
        return
    impulse_of(model, row_of_pair(route.touching, expands) + index, free[r], floor[r], p[r])
    velocity_of(index, g, free[r], p[r], v[r])


@part
def _changed_row(
    model: Floats, change: Floats, n: int, index: int, expands: bool, route: Route
) -> None:
    """The derivatives along the parameter, where it changes the model."""
    # Where g = G Lambda + free, and Lambda_T = -+F Lambda_N at contacts that slide, the derivative
    # of Lambda solves the same equations as Lambda, with d(free) + dG Lambda + G_T tau for free and
    # tau = -+dF Lambda_N added to its tangential part.
    p, free, kept, tau, contacts = route.p, route.free, route.kept, route.tau, route.touching
    for a in range(2 * n):
        kept[a], row = free[2, a], DELASSUS + 2 * contacts[a // 2] + a % 2
        for b in range(2 * n):
            free[2, a] += change[row, 2 * contacts[b // 2] + b % 2] * p[0, b]
    for k in range(n):
        case, tau[k] = index // 6 if k else index % 6, 0.0
        if case % 3 != HOLD:
            load = p[0, 2 * k]
            if n == 2 and expands:
                load += model[FORCE, SUMMED] * p[0, 2 - 2 * k]
            dmu = change[CONTACT + contacts[k], MU]
            tau[k] = -dmu * load if case % 3 == FORWARD else dmu * load
        for a in range(2 * n):
            free[2, a] += route.pair.delassus[a, 2 * k + 1] * tau[k]
    _row(model, n, index, expands, 2, route)
    for a in range(2 * n):
        free[2, a] = kept[a]
    for k in range(n):
        p[2, 2 * k + 1] += tau[k]


@part
def _slacks(n: int, combination: int, code: int, notes: Floats, route: Route) -> None:
    # Two gap rates and a slip that are zero bring the whole toy to rest: then the other slip is
    # zero too, whatever its friction.
    if notes.shape[1] == 0:
        return
    first, second = combination % 6, combination // 6
    rests = n == 2 and first // 3 == REST and second // 3 == REST
    still = rests and (first % 3 == HOLD or second % 3 == HOLD)
    p, v, slack, scale = route.p, route.v, route.slack, route.approach
    for j in range(n):
        case = second if j == 1 else first
        at, a, b = code + 4 * route.touching[j], 2 * j, 2 * j + 1
        for r in range(3):
            slack[r] = p[r, a] - route.floor[r, j] if case // 3 == REST else v[r, a]
        note_quotient(notes, route, at + NORMAL_SIDE, slack[0], slack[1], slack[2], scale)
        if case % 3 == HOLD:
            for side in (CONE_PLUS, CONE_MINUS):
                for r in range(3):
                    along = p[r, b] if side == CONE_PLUS else -p[r, b]
                    slack[r] = route.bound[r, j] - along
                note_quotient(notes, route, at + side, slack[0], slack[1], slack[2], scale)
        elif not still:
            sign = 1.0 if case % 3 == FORWARD else -1.0
            note(notes, route, at + ALONG, sign * v[0, b], sign * v[1, b], sign * v[2, b])
