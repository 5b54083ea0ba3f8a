"""Margins of a return along a path: where it is admissible, with exact derivatives.

All margins are positive where the toy follows the path, and one vanishes at each border. Its code
is 1000 * phase + 100 * kind + item. Guards are deflated (:mod:`woodpecker.simulation.roots`), so
that only one margin vanishes where a phase becomes infinitely short. They are linear in the state
and in the model, so the derivative of a guard's jet along a tangent is a jet, too.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.contact_problems import PAIR_ROOM
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    CONTACT,
    GAP,
    GUARDS,
    KAPPA,
    LAMBDA,
    LIMIT,
    MU,
    NORMAL,
    OMEGA,
    SECTION,
    SIGN,
    SLIP,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    TANGENT,
    A,
    B,
)
from woodpecker.motion.codes import STRUCK, STUCK, typed
from woodpecker.motion.events import force_guard, guards_at_entry, jet, time_to_minimum
from woodpecker.motion.flow import spring
from woodpecker.motion.guards import TWO_PI, time_of_lowest
from woodpecker.simulation.roots import (
    Ratios,
    deflated,
    deflated_change,
    ratios,
)

# Kinds of margins, in the order in which a phase meets them.
COMPRESSION, EXPANDING, BOUNCES, START, EARLY, SPEED, MEETING, DIP, SWING, LENGTH = range(10)
# COMPRESSION, EXPANDING: slack 4 * contact + inequality of an impact (12 more at the second end of
# an indeterminate one); BOUNCES: 1 - ratio of bounces that accumulate; START: a guard where the
# phase begins; EARLY: the duration of a phase, if it is negative though its guard begins positive;
# SPEED: -f' |f'| of the guard f that fires (SLOWEST or STEEPEST more: f where it falls so, see
# _inflections); MEETING: a guard where another one fires; DIP: the least minimum of a guard in a
# phase; SWING: time between the ends of a phase on the jammed sleeve and minima of phi_S; LENGTH:
# what is left of the pole where a phase ends
NORMAL_SIDE, ALONG, CONE_PLUS, CONE_MINUS = range(4)  # the inequalities of a contact in an impact
OTHER_END = 12
SLOWEST, STEEPEST = 50, 60

GRAZING = 1e-7  # slope f' over f'' t below which a root counts as double: rounding moves a double
# root by about the square root of 1e-16
VANISHED = 1e-30  # a speed [m/s, rad/s] or a duration [s] below this is zero but for rounding

MARGIN, PER_START, PER_PARAMETER, CAUSE = range(4)  # rows of the notes
NOTES = 4
MOST = 40  # margins of one phase: at most 24 of an impact, 12 of guards, and 4

ROUTE = np.dtype(
    (
        np.record,
        [
            ("z", "f8", (7,)),  # state
            ("tangents", "f8", (2, 7)),  # along the start and along the parameter
            ("seeds", "f8", (2, 3)),  # rates of the restitutions along both
            ("gaps", "f8", (3,)),
            ("work", "f8", (7,)),
            ("states", "i8", (3,)),  # of the contacts
            ("orders", "i8", (3,)),  # how many derivatives of each gap the event made zero
            ("fired", "i8", (1,)),  # the guard that began the phase; -1: an impact, or none
            ("delays", "f8", (2,)),  # derivatives of the duration of the phase
            ("speed", "f8", (3,)),  # at which the guard fired, and its derivatives
            ("flight", "f8", (3,)),  # duration of a flight that began at rest, and its derivatives
            ("flown", "i8", (1,)),  # the contact that flew; -1: none
            ("settled", "i8", (1,)),  # the gap whose inflections have margins; -1: none
            ("jets", "f8", (3, 4)),  # jet of a guard, and its derivatives
            ("rates", "f8", (2, 2)),  # derivatives of its value and slope
            ("count", "i8", (1,)),  # number of margins
            ("touching", "i8", (2,)),  # contacts of an impact
            ("choice", "i8", (3,)),  # its index combinations
            ("case", "i8", (2,)),
            ("impulses", "f8", (2, 4)),  # of both phases,
            ("d_impulses", "f8", (2, 4)),  # and of both together along the tangents
            ("approach", "f8", (3,)),  # speed at which its gap closes, and its derivatives
            # rows of the value, and of its derivatives along both tangents:
            ("free", "f8", (3, 4)),  # velocities before one phase of an impact,
            ("floor", "f8", (3, 2)),
            ("p", "f8", (3, 4)),  # impulses
            ("end", "f8", (3, 4)),  # those of one end of an indeterminate compression
            ("v", "f8", (3, 4)),  # velocities after it
            ("bound", "f8", (3, 2)),  # of friction
            ("mark", "f8", (8,)),  # the state after the previous bounce, and the speed of the gap
            ("memory", "f8", (2, 7)),  # the tangents then
            ("pair", PAIR_ROOM),
        ],
    )
)
"""Workspace of a return along a path."""

Route = np.record  # of ROUTE


@part
def note(
    notes: Floats, route: Route, cause: int, margin: float, along_x: float, along_p: float
) -> None:
    """Enter a margin, with derivatives, by ascending causes; of repeated bounces the least."""
    last = route.count[0]
    k = last
    while k > 0 and notes[CAUSE, k - 1] > cause:
        k -= 1
    if k > 0 and notes[CAUSE, k - 1] == cause:
        k -= 1
        if margin >= notes[MARGIN, k]:
            return
    else:
        for j in range(last, k, -1):
            for row in range(NOTES):
                notes[row, j] = notes[row, j - 1]
        route.count[0] = last + 1
    notes[MARGIN, k], notes[PER_START, k], notes[PER_PARAMETER, k] = margin, along_x, along_p
    notes[CAUSE, k] = cause


@part
def note_quotient(
    notes: Floats, route: Route, cause: int, margin: float, along_x: float, along_p: float,
    scale: Floats,
) -> None:  # fmt: skip
    """Enter the quotient of a margin and a scale (value, derivatives) that vanishes with it."""
    if abs(scale[0]) > VANISHED:
        q = margin / scale[0]
        x, p = (along_x - q * scale[1]) / scale[0], (along_p - q * scale[2]) / scale[0]
        note(notes, route, cause, q, x, p)


@part
def order_of(guard: int, step: Ints, route: Route) -> int:
    """How many leading derivatives of a guard are exactly zero where its phase begins."""
    # At a detachment the gap has no acceleration yet; at a slip start the slip has none, because
    # lambda_T = +mu lambda_N at the edge of the cone is just the force of negative slip.
    i, fired = guard % 3, route.fired[0]
    if guard < NORMAL:
        return int(route.orders[i])
    if guard < SLIP:
        return 1 if guard == fired else 0
    if not step[STUCK] >> i & 1:
        return 0
    edge = CONE_POSITIVE if route.states[i] == SLIP_NEGATIVE else CONE_NEGATIVE
    return 2 if fired == edge + i else 1


@part
def _from_order(
    order: int, f0: float, f1: float, f2: float, f3: float
) -> tuple[float, float, float, float]:
    """A jet with the first ``order`` entries set to zero."""
    return (
        f0 if order < 1 else 0.0,
        f1 if order < 2 else 0.0,
        f2 if order < 3 else 0.0,
        f3,
    )


@part
def exact_jet(
    model: Floats, mode: int, guard: int, order: int, route: Route
) -> tuple[float, float, float, float]:
    """Jet of a guard at the start of its phase, the first ``order`` entries exactly zero."""
    return _from_order(order, *jet(model, mode, guard, route.z, route.gaps, route.states))


@part
def _jet_rates(
    model: Floats, change: Floats, mode: int, guard: int, order: int, m: int, route: Route
) -> tuple[float, float, float, float]:
    kind, i = (guard // 3) * 3, guard % 3
    z, v = route.z, route.tangents[m]
    kappa, moves = model[mode, KAPPA], m == 1 and len(change) > 0
    d0, d1, d2 = spring(model, mode, z)
    e0, e1 = v[2] - v[1], v[5] - v[4]
    e2 = kappa * e0
    if moves:
        e2 += change[mode, ALPHA] + change[mode, KAPPA] * d0
    if kind == GAP:
        j, sign = ANGLE[i], SIGN[i]
        b = model[mode, B + j]
        f0, f1, f2, f3 = sign * v[j], sign * v[3 + j], sign * b * e0, sign * b * e1
        if moves:
            more = change[mode, B + j]
            f0 += change[CONTACT + i, LIMIT]
            f2 += sign * (change[mode, A + j] + more * d0)
            f3 += sign * more * d1
    elif kind == SLIP:
        sign = 1.0 if route.states[i] == SLIP_POSITIVE else -1.0
        f0 = along = steady = more = 0.0
        for k in range(3):
            w = model[CONTACT + i, TANGENT + k]
            f0 += w * v[3 + k]
            along += w * model[mode, B + k]
            if moves:
                turn = change[CONTACT + i, TANGENT + k]
                f0 += turn * z[3 + k]
                steady += turn * model[mode, A + k] + w * change[mode, A + k]
                more += turn * model[mode, B + k] + w * change[mode, B + k]
        f0, f1 = sign * f0, sign * (steady + along * e0 + more * d0)
        f2, f3 = sign * (along * e1 + more * d1), sign * (along * e2 + more * d2)
    else:
        _, r = force_guard(model, mode, guard)
        f0, f1, f2, f3 = r * e0, r * e1, r * e2, r * kappa * e1
        if moves:
            steady, more = force_guard_change(model, change, mode, guard)
            f0 += steady + more * d0
            f1 += more * d1
            f2 += more * d2
            f3 += (more * kappa + r * change[mode, KAPPA]) * d1
    return _from_order(order, f0, f1, f2, f3)


@part
def force_guard_change(model: Floats, change: Floats, mode: int, guard: int) -> tuple[float, float]:
    """Derivatives, along the parameter, of :func:`woodpecker.motion.events.force_guard`."""
    kind, i = (guard // 3) * 3, guard % 3
    column = LAMBDA + 4 * i
    p, r = change[mode, column], change[mode, column + 1]
    if kind == NORMAL:
        return p, r
    sign = 1.0 if kind == CONE_POSITIVE else -1.0
    mu, more = model[CONTACT + i, MU], change[CONTACT + i, MU]
    return (
        mu * p + more * model[mode, column] - sign * change[mode, column + 2],
        mu * r + more * model[mode, column + 1] - sign * change[mode, column + 3],
    )


@part
def load_jets(
    model: Floats, change: Floats, mode: int, guard: int, order: int, route: Route
) -> None:
    """Write the jet of a guard at the start of its phase, and its derivatives, into the route."""
    jets = route.jets
    jets[0, 0], jets[0, 1], jets[0, 2], jets[0, 3] = exact_jet(model, mode, guard, order, route)
    for m in range(2):
        f0, f1, f2, f3 = _jet_rates(model, change, mode, guard, order, m, route)
        jets[1 + m, 0], jets[1 + m, 1], jets[1 + m, 2], jets[1 + m, 3] = f0, f1, f2, f3


@part
def find_rates(
    model: Floats, change: Floats, mode: int, order: int, t: float, c: Ratios, route: Route
) -> None:
    """Find the derivatives of g(t) and g'(t), g the deflated guard in the route, at a fixed t."""
    jets, found, kappa = route.jets, route.rates, model[mode, KAPPA]
    for m in range(2):
        f0, f1, f2, f3 = jets[1 + m, 0], jets[1 + m, 1], jets[1 + m, 2], jets[1 + m, 3]
        found[m, 0], found[m, 1], _ = deflated(order, f0, f1, f2, f3, kappa, t, c)
    if len(change) > 0:
        value, slope = deflated_change(order, jets[0, 2], jets[0, 3], t, c)
        found[1, 0] += value * change[mode, KAPPA]
        found[1, 1] += slope * change[mode, KAPPA]


@part
def minimum_rate(model: Floats, change: Floats, mode: int, t: float, m: int, route: Route) -> float:
    """Derivative along a tangent of the time t of a minimum of phi_S."""
    # omega t = atan2(-d1, d2 / omega) up to full turns.
    z, v, omega = route.z, route.tangents[m], model[mode, OMEGA]
    d0, d1, d2 = spring(model, mode, z)
    e1, e2, turn = v[5] - v[4], model[mode, KAPPA] * (v[2] - v[1]), 0.0
    if m == 1 and len(change) > 0:
        e2 += change[mode, ALPHA] + change[mode, KAPPA] * d0
        turn = -0.5 * change[mode, KAPPA] / omega
    across = d2 / omega
    if d1 == 0.0 == across:
        return 0.0  # at rest, where the time of the minimum is arbitrary
    per_across = (e2 - across * turn) / omega
    angle = (d1 * per_across - e1 * across) / (d1 * d1 + across * across)
    return float((angle - t * turn) / omega)


@part
def start_margins(
    model: Floats, change: Floats, step: Ints, k: int, mode: int, notes: Floats, route: Route
) -> None:
    """Enter the margins of closed contacts, which keep their states, where a phase begins."""
    # A margin is the first derivative of a guard that the event has not made exactly zero. Where a
    # contact force or friction has just reached its bound, it is proportional to the speed at which
    # that happened; where a contact closes after a flight from rest, to the duration of the flight.
    # Then the margin is the quotient, which does not vanish with both.
    states = route.states
    for i in range(3):
        if route.orders[i] < 2:
            continue  # it is open, or leaves after its impact
        for guard in guards_at_entry(i, states[i], step[STUCK] >> i & 1 == 1):
            if guard >= 0:
                _start(model, change, step, k, mode, guard, notes, route)


@part
def _start(
    model: Floats, change: Floats, step: Ints, k: int, mode: int, guard: int, notes: Floats,
    route: Route,
) -> None:  # fmt: skip
    order = order_of(guard, step, route)
    load_jets(model, change, mode, guard, order, route)
    margin, along_x, along_p = route.jets[0, order], route.jets[1, order], route.jets[2, order]
    code = 1000 * k + 100 * START + guard
    if guard < SLIP and guard % 3 == route.settled[0]:
        return
    if order == 3 or (order == 2 and guard >= SLIP):
        note_quotient(notes, route, code, margin, along_x, along_p, route.speed)
    elif guard == NORMAL + route.flown[0] and step[STRUCK] == 1 << route.flown[0]:
        note_quotient(notes, route, code, margin, along_x, along_p, route.flight)
    else:
        note(notes, route, code, margin, along_x, along_p)


@part
def phase_margins(
    model: Floats, change: Floats, step: Ints, mode: int, after: int, fired: int, t: float, k: int,
    c: Ratios, notes: Floats, route: Route,
) -> None:  # fmt: skip
    """Enter the margins of a phase of duration t: one guard fires, and no other.

    ``after`` is the mode of the next phase if the impact between brings its only contact to rest,
    to stay or to leave from rest; else -1.
    """
    kappa, omega, delays = model[mode, KAPPA], model[mode, OMEGA], route.delays
    jets, found = route.jets, route.rates
    route.settled[0] = typed(-1)
    for column in range(GUARDS, GUARDS + 5):
        guard = int(model[mode, column])
        if guard < 0:
            break
        if guard == SECTION:
            if k > 0:
                _swing_margins(model, change, mode, fired, t, k, notes, route)
            continue
        if guard != fired and guard >= SLIP and fired >= SLIP:
            continue  # two contacts that slide do so as one
        order = order_of(guard, step, route)
        load_jets(model, change, mode, guard, order, route)
        find_rates(model, change, mode, order, t, c, route)
        f0, f1, f2, f3 = jets[0, 0], jets[0, 1], jets[0, 2], jets[0, 3]
        known = math.inf  # time of a minimum that has a margin already
        g, slope, bend = deflated(order, f0, f1, f2, f3, kappa, t, c)
        x, along_x, p, along_p = found[0, 0], found[0, 1], found[1, 0], found[1, 1]
        if guard == fired:
            if t < 0.0 and jets[0, order] > 0.0:
                note(notes, route, 1000 * k + 100 * EARLY + guard, t, delays[0], delays[1])
            route.settled[0] = (
                guard if inflections_decide(guard, order, mode, after, kappa, f2, f3) else -1
            )
            if route.settled[0] >= 0:
                leaves = after == mode
                known = _inflections(model, change, mode, guard, leaves, t, k, notes, route)
            else:
                # the sign of the slope at a double root is rounding: it counts as falling
                rate = slope if abs(slope) > GRAZING * abs(bend * t) else -abs(slope)
                size = -2.0 * abs(rate)
                turn = 1.0 if rate == slope else -1.0
                note(
                    notes, route, 1000 * k + 100 * SPEED + guard, -rate * abs(rate),
                    size * turn * (along_x + bend * delays[0]),
                    size * turn * (along_p + bend * delays[1]),
                )  # fmt: skip
        else:
            note(
                notes, route, 1000 * k + 100 * MEETING + guard, g, x + slope * delays[0],
                p + slope * delays[1],
            )  # fmt: skip
        if not _may_dip(f1, f2, f3, omega if kappa < 0.0 else 0.0, t, c):
            continue
        low = time_of_lowest(f0, f1, f2, f3, kappa, omega, t)
        if low < math.inf and omega * abs(low - known) > 1.0:  # minima are a swing apart
            at = ratios(kappa, omega, low)
            g, _, _ = deflated(typed(0), f0, f1, f2, f3, kappa, low, at)
            find_rates(model, change, mode, order, low, at, route)
            power = 1.0
            for _ in range(order):
                power *= low
            x, p = power * found[0, 0], power * found[1, 0]
            note(notes, route, 1000 * k + 100 * DIP + guard, g, x, p)


@part
def inflections_decide(
    guard: int, order: int, mode: int, after: int, kappa: float, f2: float, f3: float
) -> bool:
    """Whether the inflections of a swinging gap decide if its contact stays or leaves from rest."""
    if guard >= NORMAL or order > 0 or after < 0 or kappa >= 0.0 or (f2 == 0.0 and f3 == 0.0):
        return False
    if guard == 0:
        return mode % 7 == after % 7
    return mode == after or (mode // 7 == after // 7 and mode % 7 == 0)


@part
def _inflections(
    model: Floats, change: Floats, mode: int, guard: int, leaves: bool, t: float, k: int,
    notes: Floats, route: Route,
) -> float:  # fmt: skip
    """Enter the margins of a contact whose swinging gap closes: it leaves from rest, or stays.

    Returns the time of the minimum of the gap that is a margin; inf if there is none.
    """
    # It leaves if f'' > 0 at the impact, and stays if f'' < 0. So the impact must lie between the
    # inflections at which the gap falls most steeply and most slowly, and the signs of the gap
    # there say whether it does. These margins are smooth even where three roots of the gap meet, as
    # after a flight from rest for a full swing: there f' and f'' at the impact go like powers 2/3
    # and 1/3 of the distance from the border. If the gap rises where it falls most slowly, its
    # minimum before that counts.
    jets, omega = route.jets, model[mode, OMEGA]
    f0, f1, f2, f3 = jets[0, 0], jets[0, 1], jets[0, 2], jets[0, 3]
    kappa, angle, bend = model[mode, KAPPA], math.atan2(f2, f3 / omega), math.hypot(f2, f3 / omega)
    known = math.inf
    half = math.floor((omega * t + angle) / math.pi + 0.5)  # f'' = bend sin(omega t + angle)
    for slowest in range(2):
        turns = half
        if (half % 2 == 1) != (slowest == 1):  # the neighbour on the side of the impact
            turns += 1.0 if leaves == (slowest == 1) else -1.0
        at = (math.pi * turns - angle) / omega
        c = ratios(kappa, omega, at)
        slope, third = f1 + at * (f2 * c[1] + f3 * at * c[2]), bend * omega * (1 - 2 * slowest)
        if slowest == 1 and slope > 0.0:  # f' = slope - bend / omega (1 - cos(omega (t - at)))
            at -= 2.0 * math.asin(math.sqrt(min(1.0, 0.5 * omega * slope / bend))) / omega
            c, slope, known = ratios(kappa, omega, at), 0.0, at
        if at <= 0.0:
            continue  # the phase has not begun
        gap, _, _ = deflated(typed(0), f0, f1, f2, f3, kappa, at, c)
        find_rates(model, change, mode, typed(0), at, c, route)
        sign = -1.0 if leaves == (slowest == 1) else 1.0
        x, p = route.rates[0, 0], route.rates[1, 0]
        if slope != 0.0:
            turn = jets[2, 2] * c[0] + jets[2, 3] * at * c[1]
            if len(change) > 0:
                more = f2 * c[1] + f3 * at * (c[2] - c[3])
                turn += 0.5 * at * at * change[mode, KAPPA] * more
            x -= slope * (jets[1, 2] * c[0] + jets[1, 3] * at * c[1]) / third
            p -= slope * turn / third
        code = 1000 * k + 100 * SPEED + (SLOWEST if slowest == 1 else STEEPEST) + guard
        note(notes, route, code, sign * gap, sign * x, sign * p)
    return float(known)


@part
def _may_dip(f1: float, f2: float, f3: float, swing: float, t: float, c: Ratios) -> bool:
    """Whether f can have a minimum between 0 and t, by signs of f' and f'' at both ends."""
    # At a minimum f' rises through zero, and in half a swing f'' changes sign at most once.
    if t <= 0.0 or swing * t > math.pi:
        return t > 0.0
    slope, bend = f1 + t * (f2 * c[1] + f3 * t * c[2]), f2 * c[0] + f3 * t * c[1]
    if f2 <= 0.0 and bend <= 0.0:
        return False  # f' falls
    if f2 >= 0.0 and f1 >= 0.0:
        return False  # f' rises, or rises and falls
    return not (bend >= 0.0 >= slope)  # f' rises, or falls and rises


@part
def _swing_margins(
    model: Floats, change: Floats, mode: int, fired: int, t: float, k: int, notes: Floats,
    route: Route,
) -> None:  # fmt: skip
    """Enter the margins of a phase on the jammed sleeve: no minimum of phi_S lies inside it."""
    delays, swing, code = route.delays, TWO_PI / model[mode, OMEGA], 1000 * k + 100 * SWING
    if fired != SECTION:
        turn = time_to_minimum(model, mode, route.z)
        x = minimum_rate(model, change, mode, turn, typed(0), route)
        p = minimum_rate(model, change, mode, turn, typed(1), route)
        if turn < t and turn < 0.5 * swing:  # the phase begins just before a minimum
            note(notes, route, code + 3, -turn, -x, -p)
            return
        note(notes, route, code + 2, turn - t, x - delays[0], p - delays[1])
        if turn >= 0.5 * swing:  # time since the minimum before the phase
            longer = _change_of_swing(model, change, mode, swing)
            note(notes, route, code + 3, swing - turn, -x, longer - p)
        return
    note(notes, route, code, t, delays[0], delays[1])
    longer = _change_of_swing(model, change, mode, swing)
    note(notes, route, code + 1, swing - t, -delays[0], longer - delays[1])


@part
def _change_of_swing(model: Floats, change: Floats, mode: int, swing: float) -> float:
    """Derivative of the period of a mode along the parameter; omega^2 = -kappa."""
    if len(change) == 0:
        return 0.0
    return float(0.5 * swing * change[mode, KAPPA] / (model[mode, OMEGA] * model[mode, OMEGA]))
