"""A return along a given path: a smooth map, without a search for events or contact problems.

A *path* has for each phase the mode, the guard that ends it, and the index combinations of the
impact that began it. The return is a composition of smooth maps, with event times by Newton's
method, and exists also beyond the interval in which the toy takes this path. Where the path is
admissible is said by :mod:`woodpecker.simulation.margins`.
"""

from __future__ import annotations

import math

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import REST
from woodpecker.mechanics.contact_problems import UNSOLVED
from woodpecker.mechanics.impacts import hold, rates
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONTACT,
    FORCE,
    KAPPA,
    LIMIT,
    NORMAL,
    OMEGA,
    OPEN,
    POLE,
    SECTION,
    SIGN,
    SLIP,
    STICK,
    A,
    B,
    mode_states,
)
from woodpecker.motion.chatter import sum_bounces
from woodpecker.motion.codes import (
    CHATTER,
    CLOSED,
    FIRST,
    GUARD,
    MODE,
    OTHER,
    RETURNED,
    SECOND,
    STRUCK,
    STUCK,
    typed,
)
from woodpecker.motion.events import time_to_minimum
from woodpecker.motion.flow import copy, displace, measure, put_on_section, shut, spring, touch
from woodpecker.motion.guards import TWO_PI, first_root, stumpff_rates, time_of_lowest
from woodpecker.simulation.margins import (
    BOUNCES,
    LENGTH,
    Route,
    exact_jet,
    find_rates,
    inflections_decide,
    load_jets,
    minimum_rate,
    note,
    order_of,
    phase_margins,
    start_margins,
)
from woodpecker.simulation.roots import (
    Ratios,
    deflated,
    ratios,
    root_at_inflection,
    root_near,
    rounding_at,
)
from woodpecker.simulation.striking import has_faint_bounces, strike

NO_ROOT = -1  # status: a guard of the path has no root
BOUNCES_MOST = 1000  # repetitions of a bounce before its sum: a ratio of 0.97 needs so many


@part
def follow_path(
    model: Floats, change: Floats, path: Ints, times: Floats, phi_s: float, notes: Floats,
    route: Route,
) -> int:  # fmt: skip
    """Follow the toy from the section at phi_S along a path; RETURNED or NO_ROOT.

    ``model`` and ``change`` are the modes and their derivatives along the parameter, or FIXED. Of
    bounces that accumulate ``path`` (n, STEP_COLUMNS) has the first, which is repeated until the
    rest can be summed. ``times`` (n,) are durations of a neighbour, replaced by those found.
    ``notes`` (NOTES, MOST n or 0) takes margins, derivatives in phi_S and along the parameter, and
    ascending causes. ``route.seeds`` are the rates of restitutions along both. Output in ``route``:
    ``z`` on the section, ``tangents``, and the number of margins.
    """
    z, states, watched = route.z, route.states, notes.shape[1] > 0
    _start_on_section(model, change, phi_s, route)
    k, repeated = 0, 0
    while k < len(path):
        step = path[k]
        mode, guard = step[MODE], step[GUARD]
        _find_orders(step, route)
        if k > 0:
            _event(model, change, step, k, notes, route)
        states[0], states[1], states[2] = mode_states(mode)
        if watched:
            start_margins(model, change, step, k, mode, notes, route)
        after = _mode_after_rest(path, k + 1)
        t = _duration(model, step, mode, after, guard, times[k], repeated > 0, route)
        if not math.isfinite(t):
            return NO_ROOT
        c = ratios(model[mode, KAPPA], model[mode, OMEGA], t)
        _find_delays(model, change, step, mode, guard, t, c, route)
        if watched:
            phase_margins(model, change, step, mode, after, guard, t, k, c, notes, route)
        again = _bounces_on(model, path, k, t, route)
        if repeated == 0:
            times[k] = t
        _move(model, change, mode, t, c, route)
        if watched and model[FORCE, POLE] < math.inf:
            left, x, p = model[FORCE, POLE] + z[0], route.tangents[0, 0], route.tangents[1, 0]
            note(notes, route, 1000 * k + 100 * LENGTH, left, x, p)
        route.fired[0] = guard
        if not again:
            k, repeated = k + 1, 0
        elif repeated < BOUNCES_MOST:
            repeated += 1
        else:
            return NO_ROOT
    put_on_section(model, z)
    for m in range(2):
        for j in (1, 3, 4, 5):
            route.tangents[m, j] = 0.0
    if len(change) > 0:
        route.tangents[1, 1] = -change[CONTACT + 1, LIMIT]
    return RETURNED


@part
def _start_on_section(model: Floats, change: Floats, phi_s: float, route: Route) -> None:
    z, tangents = route.z, route.tangents
    for c in range(7):
        z[c] = tangents[0, c] = tangents[1, c] = 0.0
    z[1], z[2], tangents[0, 2] = -model[CONTACT + 1, LIMIT], phi_s, 1.0
    if len(change) > 0:
        tangents[1, 1] = -change[CONTACT + 1, LIMIT]
    measure(model, z, route.gaps)
    route.states[0] = route.states[2] = OPEN
    route.states[1] = STICK
    route.fired[0], route.flown[0], route.count[0] = typed(-1), typed(-1), typed(0)
    route.settled[0] = typed(-1)


@part
def bounce_repeats(path: Ints, k: int) -> bool:
    """Whether row k of a path is a bounce to be repeated until the next row closes its contact."""
    if k == 0 or k + 1 >= len(path) or path[k + 1, CLOSED] not in (1, 2, 4):
        return False
    if path[k, CLOSED] != 0:
        return False
    same = True
    for column in (STRUCK, FIRST, OTHER, SECOND):
        same = same and path[k, column] == path[k + 1, column]
    return same


@part
def _bounces_on(model: Floats, path: Ints, k: int, t: float, route: Route) -> bool:
    """Whether bounces of duration t are still too long to be summed as a geometric series."""
    if not bounce_repeats(path, k):
        return False
    mode, guard = path[k, MODE], path[k, GUARD]
    _, _, f2, f3 = exact_jet(model, mode, guard, typed(1), route)
    turn = abs(f3 / f2) if f2 != 0.0 else math.inf
    return bool(abs(t) * (model[mode, OMEGA] + turn) > CHATTER)


@part
def _find_orders(step: Ints, route: Route) -> None:
    """Find how many derivatives of each gap an event makes zero; ``states`` are those before it."""
    # A gap that strikes and leaves begins with a speed; one that was closed, or stays closed, has
    # none, and at a detachment no acceleration either.
    last = step[SECOND] if step[SECOND] != UNSOLVED else step[FIRST]
    struck, n = step[STRUCK], 0
    for i in range(3):
        route.orders[i] = 0
        if struck >> i & 1:
            case = last // 6 if n == 1 else last % 6
            n += 1
            rests = case // 3 == REST or step[CLOSED] >> i & 1
            route.orders[i] = 2 if rests else 1
        elif route.states[i] != OPEN or step[CLOSED] >> i & 1:
            route.orders[i] = 3 if route.fired[0] == NORMAL + i else 2


@part
def _mode_after_rest(path: Ints, k: int) -> int:
    """Mode of phase k if it begins with an impact after which its only contact rests; else -1."""
    if k >= len(path) or path[k, STRUCK] not in (1, 2, 4):
        return -1
    step = path[k]
    last = step[SECOND] if step[SECOND] != UNSOLVED else step[FIRST]
    rests = last % 6 // 3 == REST or step[CLOSED] != 0
    return step[MODE] if rests else -1


@part
def _duration(
    model: Floats, step: Ints, mode: int, after: int, guard: int, near: float, again: bool,
    route: Route,
) -> float:  # fmt: skip
    """Duration of a phase, near that of a neighbour; nan if there is none."""
    # Where Newton's method fails from the neighbour's duration, the guard fires at its first root,
    # as on an admissible path. So does a bounce that is repeated (``again``): it has no neighbour.
    kappa, omega = model[mode, KAPPA], model[mode, OMEGA]
    if guard == SECTION:
        t, swing = time_to_minimum(model, mode, route.z), TWO_PI / omega
        return float(t + swing * math.floor((near - t) / swing + 0.5))
    order = order_of(guard, step, route)
    f0, f1, f2, f3 = exact_jet(model, mode, guard, order, route)
    if again:
        return first_root(0.0, f1, f2, f3, kappa, omega, math.inf) if f1 > 0.0 else math.nan
    if guard < NORMAL and order == 0 and kappa < 0.0:
        t = root_at_inflection(f0, f1, f2, f3, kappa, omega, near)
        if math.isfinite(t):
            return t
    t = root_near(order, f0, f1, f2, f3, kappa, omega, near)
    leading = f0 if order == 0 else (f1 if order == 1 else f2)
    if t < 0.0 and leading > 0.0:
        # The guard rises from zero, so it fires later: near a bounce of no duration Newton's method
        # starts before the maximum of the gap and falls back. Within a swing the root is unique.
        first = first_root(f0, f1, f2, f3, kappa, omega, TWO_PI / omega)
        return first if omega * (first - t) < TWO_PI else t
    if t > 0.0 and after == mode and inflections_decide(guard, order, mode, after, kappa, f2, f3):
        return _root_before_lowest(f0, f1, f2, f3, kappa, omega, t)
    if math.isfinite(t):
        return t
    return first_root(f0, f1, f2, f3, kappa, omega, math.inf) if leading > 0.0 else math.nan


@part
def _root_before_lowest(
    f0: float, f1: float, f2: float, f3: float, kappa: float, omega: float, t: float
) -> float:
    """The root at which a contact leaves again; t if the gap does not vanish before t."""
    # There g' < 0 < g'': it lies before the minimum of the gap, or is the minimum, up to rounding.
    # Beyond the border at which it ends Newton's method finds a later root, which is the wrong one
    # once the path is admissible again.
    _, slope, bend = deflated(typed(0), f0, f1, f2, f3, kappa, t, ratios(kappa, omega, t))
    if slope < 0.0 < bend:
        return t
    low = time_of_lowest(f0, f1, f2, f3, kappa, omega, t)
    if not 0.0 < omega * (t - low) < TWO_PI:  # no minimum, or that of an earlier swing
        return t
    c = ratios(kappa, omega, low)
    gap, _, _ = deflated(typed(0), f0, f1, f2, f3, kappa, low, c)
    if gap < 0.0:
        return min(low, first_root(f0, f1, f2, f3, kappa, omega, low))
    return low if gap <= rounding_at(typed(0), f0, f1, f2, f3, low, c) else t


@part
def _find_delays(
    model: Floats, change: Floats, step: Ints, mode: int, guard: int, t: float, c: Ratios,
    route: Route,
) -> None:  # fmt: skip
    """Derivatives -g_p / g_t of the duration of a phase, and the speed at which its guard fires."""
    route.flown[0] = typed(-1)
    if guard == SECTION:
        for m in range(2):
            route.delays[m] = minimum_rate(model, change, mode, t, m, route)
        return
    order = order_of(guard, step, route)
    load_jets(model, change, mode, guard, order, route)
    find_rates(model, change, mode, order, t, c, route)
    jets, found = route.jets, route.rates
    f0, f1, f2, f3 = jets[0, 0], jets[0, 1], jets[0, 2], jets[0, 3]
    _, slope, bend = deflated(order, f0, f1, f2, f3, model[mode, KAPPA], t, c)
    route.speed[0] = -slope
    for m in range(2):
        shift, turn = found[m, 0], found[m, 1]
        delay = -shift / slope if slope != 0.0 else math.nan
        route.delays[m], route.speed[1 + m] = delay, -(turn + bend * delay)
    if guard < NORMAL and order == 2:
        route.flown[0] = guard
        route.flight[0], route.flight[1], route.flight[2] = t, route.delays[0], route.delays[1]


@part
def _move(model: Floats, change: Floats, mode: int, t: float, c: Ratios, route: Route) -> None:
    """Move the state and its tangents to the event that ends a phase."""
    z, work, tangents = route.z, route.work, route.tangents
    s1, s2, s3, s4 = t * c[1], t * t * c[2], t * t * t * c[3], t * t * t * t * c[4]
    displace(model, mode, z, t, s1, s2, s3, s4, work)
    for i in range(3):
        route.gaps[i] += SIGN[i] * work[ANGLE[i]]
    for j in range(3):
        work[j] += z[j]
    end = work[2] - work[1]
    for m in range(2):
        v, delay = tangents[m], route.delays[m]
        d0, d1 = v[2] - v[1], v[5] - v[4]
        for j in range(3):
            acceleration = model[mode, B + j]
            v[j] += v[3 + j] * t + acceleration * (s2 * d0 + s3 * d1)
            v[3 + j] += acceleration * (s1 * d0 + s2 * d1)
        if m == 1 and len(change) > 0:
            _change_flow(model, change, mode, z, t, s1, s2, s3, s4, v)
        for j in range(3):
            v[j] += delay * work[3 + j]
            v[3 + j] += delay * (model[mode, A + j] + model[mode, B + j] * end)
        v[6] += delay
    copy(work, z)


@part
def _event(model: Floats, change: Floats, step: Ints, k: int, notes: Floats, route: Route) -> None:
    """Carry out the event that begins a phase; ``states`` are those of the previous phase."""
    struck, states = step[STRUCK], route.states
    for i in range(3):
        if states[i] != OPEN or struck >> i & 1:
            touch(model, i, route.z, route.gaps)
            if has_faint_bounces(model):
                _touch_tangents(change, i, route.tangents)
    if struck == 0:
        for i in range(3):
            if states[i] == STICK or route.fired[0] == SLIP + i:
                hold(model, i, route.z)
        return
    n, choice = 0, route.choice
    for i in range(3):
        if struck >> i & 1:
            route.touching[n] = i
            n += 1
    choice[0], choice[1], choice[2] = step[FIRST], step[OTHER], step[SECOND]
    strike(model, change, n, k, notes, route)
    route.fired[0] = typed(-1)
    if step[CLOSED] == 0:
        for c in range(7):
            route.mark[c] = route.z[c]
            for m in range(2):
                route.memory[m, c] = route.tangents[m, c]
    else:
        _close(model, change, step, k, notes, route)


@part
def _close(model: Floats, change: Floats, step: Ints, k: int, notes: Floats, route: Route) -> None:
    z, mark, closed, i = route.z, route.mark, step[CLOSED], route.touching[0]
    if closed in (1, 2, 4):  # bounces at one contact; of those at two nothing is left to sum
        j = 3 + ANGLE[i]
        mark[7] = SIGN[i] * mark[j]
        ratio = SIGN[i] * z[j] / mark[7]
        if notes.shape[1] > 0:
            x = SIGN[i] * (route.tangents[0, j] - ratio * route.memory[0, j]) / mark[7]
            p = SIGN[i] * (route.tangents[1, j] - ratio * route.memory[1, j]) / mark[7]
            note(notes, route, 1000 * k + 100 * BOUNCES + i, 1.0 - ratio, -x, -p)
        _sum_tangents(i, ratio, route)
        sum_bounces(z, route.gaps, mark, ratio)
    shut(model, closed, z, route.gaps)
    for i in range(3):
        if closed >> i & 1:
            _shut_tangents(change, i, route.tangents)
    for i in range(3):
        if step[STUCK] >> i & 1:
            _hold_tangents(model, change, i, route)


@part
def _sum_tangents(i: int, ratio: float, route: Route) -> None:
    """Derivatives of the end of bounces at contact i that :func:`sum_bounces` finds."""
    z, mark, tangents, memory = route.z, route.mark, route.tangents, route.memory
    j, rest = 3 + ANGLE[i], ratio / (1.0 - ratio)
    for m in range(2):
        change_of_ratio = SIGN[i] * (tangents[m, j] - ratio * memory[m, j]) / mark[7]
        change_of_rest = change_of_ratio / ((1.0 - ratio) * (1.0 - ratio))
        for k in range(7):
            tangents[m, k] += (tangents[m, k] - memory[m, k]) * rest
            tangents[m, k] += (z[k] - mark[k]) * change_of_rest


@part
def _touch_tangents(change: Floats, i: int, tangents: Floats) -> None:
    """Derivatives of the angle at which a contact closes, free of rounding."""
    tangents[0, ANGLE[i]] = tangents[1, ANGLE[i]] = 0.0
    if len(change) > 0:
        tangents[1, ANGLE[i]] = -SIGN[i] * change[CONTACT + i, LIMIT]


@part
def _shut_tangents(change: Floats, i: int, tangents: Floats) -> None:
    _touch_tangents(change, i, tangents)
    for m in range(2):
        tangents[m, 3 + ANGLE[i]] = 0.0


@part
def _hold_tangents(model: Floats, change: Floats, i: int, route: Route) -> None:
    hold(model, i, route.z)
    for m in range(2):
        hold(model, i, route.tangents[m])
    if len(change) > 0:
        route.tangents[1, 3] -= rates(change, i, route.z)[1]


@part
def _change_flow(
    model: Floats, change: Floats, mode: int, z: Floats, t: float, s1: float, s2: float, s3: float,
    s4: float, v: Floats,
) -> None:  # fmt: skip
    """Add to a tangent what the change of the mode's coefficients does over a time t."""
    # By qdd = A + B d, q gains A t^2 / 2 + B (d integrated twice), u gains A t + B (d integrated
    # once), and d = d_0 + d_1 s_1 + d_2 s_2 depends on alpha and kappa.
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
