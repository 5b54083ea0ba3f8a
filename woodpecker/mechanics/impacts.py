"""Impacts with friction at one or two contacts, solved directly.

Compression and expansion [Leine2001, Eqs. 2-5; Pfeiffer1996] are one problem: find impulses
Lambda with

    (g_N, g_T) = G Lambda + free,    G = W^T M^-1 W,
    0 <= g_N  perp  Lambda_N - floor >= 0      (floor = 0, or eps_N Lambda_NC in expansion),
    |Lambda_T| <= mu Lambda_N,  Lambda_T = -mu Lambda_N sign(g_T) where g_T != 0.

In the expansion of an impact at two contacts the paper's law bounds |Lambda_T| by mu times the sum
of both normal impulses, Coulomb's law contact by contact does not
(:class:`woodpecker.mechanics.toy.ExpansionFriction`).

With one contact the six index combinations have closed forms; with two, all 36 are tried from a
table of :mod:`woodpecker.mechanics.cases`. Either way a missing solution or a second one is seen.
:mod:`woodpecker.mechanics.lcp` solves the same problem by Lemke's method for any number of contacts
and is what this file is tested against.

Two sticking contacts have four impulses for three equations: a compression that ends with the
whole toy at rest fixes the velocities but leaves the normal impulses on a segment, and the
expansion feeds on them. Such an impact is reported as indeterminate and continued from the middle
of the segment, the one choice that prefers no contact.

Energy. No impact adds any if the restitutions of its contacts are equal, at one contact always, nor
without friction; mu and the law of expansion do not matter. With unequal restitutions the sum still
adds none for the paper's friction (proved for equal mu up to 0.432, not seen up to mu = 8); contact
by contact does where beak and upper edge strike at once: as searches say, above eps_N1 = 0.99 at
mu = 0.3, above some 0.92 for mu up to 0.6. A body close to jamming can gain under both laws
(``tests/woodpecker/mechanics/test_impact_energy.py`` has the proof and the examples).
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import FORWARD, FREE, HOLD, REST, impulse_of
from woodpecker.mechanics.modes import (
    ANGLE,
    CONTACT,
    DELASSUS,
    EPS,
    EXPANSION,
    FORCE,
    LEVER,
    MU,
    PAIR,
    RESPONSE_N,
    RESPONSE_T,
    SIGN,
    SUMMED,
    TANGENT,
    fill_pair,
)

# Outcome of a contact problem.
SOLVED, NO_SOLUTION, AMBIGUOUS, INDETERMINATE = 0, 1, 2, 3

UNSOLVED = -1

# A mark tells index combinations of one contact apart: compression + 3 * expansion, where
# compression is 0 slides, 1 sticks, 2 separates; expansion is 0 ends as usual (leaves if it stores
# impulse, stays if not) and slides or is missing, 1 as usual and sticks, 2 and 3 the other way.
MARKS = 12

SLACK = 1e-11  # used only where strict signs leave no combination: a solution on a boundary
SAME = 1e-8  # velocities closer than this (relative) are one solution found twice


@part
def one_contact_case(
    case: int, g_nn: float, g_nt: float, g_tt: float, free_n: float, free_t: float, mu: float,
    floor: float,
) -> tuple[float, float]:  # fmt: skip
    """Impulses (N, T) of one index combination, linear in (free_n, free_t, floor)."""
    tangential = case % 3
    if tangential == HOLD:
        if case // 3 == FREE:
            return floor, -(free_t + g_nt * floor) / g_tt
        determinant = g_nn * g_tt - g_nt * g_nt
        return (
            (g_nt * free_t - g_tt * free_n) / determinant,
            (g_nt * free_n - g_nn * free_t) / determinant,
        )
    friction = -mu if tangential == FORWARD else mu
    if case // 3 == FREE:
        return floor, friction * floor
    stiffness = g_nn + friction * g_nt
    impulse = -free_n / stiffness if stiffness != 0.0 else math.nan
    return impulse, friction * impulse


@part
def one_contact(
    g_nn: float, g_nt: float, g_tt: float, free_n: float, free_t: float, mu: float, floor: float
) -> tuple[int, int, float, float]:
    """Try the six index combinations of one contact: (outcome, combination, impulses N, T)."""
    scale_v = abs(free_n) + abs(free_t) + floor * g_nn
    scale_i = abs(free_n) / g_nn + abs(free_t) / g_tt + floor
    for slack in (0.0, SLACK):
        kept, kept_n, kept_t = UNSOLVED, 0.0, 0.0
        for case in range(6):
            p_n, p_t = one_contact_case(case, g_nn, g_nt, g_tt, free_n, free_t, mu, floor)
            v_n = free_n + g_nn * p_n + g_nt * p_t
            v_t = free_t + g_nt * p_n + g_tt * p_t
            tangential = case % 3
            if case // 3 == REST:
                if not p_n >= floor - slack * scale_i:
                    continue
            elif v_n < -slack * scale_v:
                continue
            if tangential == HOLD:
                if abs(p_t) > mu * p_n + slack * scale_i:
                    continue
            elif (v_t if tangential == FORWARD else -v_t) < -slack * scale_v:
                continue
            if kept == UNSOLVED:
                kept, kept_n, kept_t = case, p_n, p_t
            elif abs(p_n - kept_n) + abs(p_t - kept_t) > SAME * scale_i:
                return AMBIGUOUS, kept, kept_n, kept_t
        if kept != UNSOLVED:
            return SOLVED, kept, kept_n, kept_t
    return NO_SOLUTION, UNSOLVED, 0.0, 0.0


PAIR_ROOM = np.dtype(
    (
        np.record,
        [
            ("delassus", "f8", (4, 4)),
            ("friction", "f8", (2, 2)),
            ("system", "f8", (4, 10)),
            ("mu", "f8", (2,)),
            ("eps", "f8", (2,)),
            ("feeds", "i8", (2,)),
            ("floor", "f8", (2,)),
            ("free", "f8", (4,)),
            ("middle", "f8", (4,)),  # velocities between the phases
            ("after", "f8", (4,)),  # and after them
            ("first", "i8", (2, 2)),  # combinations of the compression
            ("second", "i8", (2, 2)),  # and of the expansion
            ("end", "f8", (4,)),  # impulses at one end of an indeterminate compression
            ("total", "f8", (4,)),  # impulses along a tangent
            ("more", "f8", (4,)),  # and those of one phase
            ("found", "i8", (36,)),  # combinations that hold
            ("violations", "f8", (36,)),
            ("impulses", "f8", (36, 4)),
            ("velocities", "f8", (36, 4)),
            ("sizes", "f8", (4,)),  # of the terms of the velocities
        ],
    )
)
"""Room for an impact at two contacts, (N, T) of each contact in turn.

One record, because compiled code passes it by its address: arrays of their own take longer to make,
and to pass, than the arithmetic. All entries are overwritten each time.
"""

Pair = np.record  # of PAIR_ROOM


def make_pair() -> Pair:
    """Room for impacts at two contacts, for those who call :func:`decide` from outside."""
    pair: Pair = np.zeros(1, dtype=PAIR_ROOM)[0]
    return pair


@part
def two_contacts(
    table: Floats, first: int, delassus: Floats, free: Floats, mu: Floats, coupling: float,
    floor: Floats, feeds: Ints, cases: Ints, impulse: Floats, pair: Pair,
) -> int:  # fmt: skip
    """Try every index combination of two contacts.

    Parameters
    ----------
    table, first
        Impulses of the index combinations, see :mod:`woodpecker.mechanics.cases`, from row
        ``first`` on.
    delassus
        (4, 4), (N, T) of each contact in turn; free is (4,), mu and floor are (2,).
    coupling
        What the other contact's normal impulse adds to the bound of friction, in units of mu: 0,
        or 1 for the sum. The table is made for it.
    feeds
        (2,) nonzero where the normal impulse itself matters afterwards (it feeds the expansion).
    cases
        (2, 2) output: the index combination, twice; if indeterminate both ends of the segment.
    impulse
        (4,) output: the impulses, or the middle of the segment.
    pair
        Room for the combinations that hold.

    Returns
    -------
    SOLVED, NO_SOLUTION, AMBIGUOUS if two combinations give different velocities, INDETERMINATE if
    they give the same velocities but different normal impulses where these matter.
    """
    found, violations = pair.found, pair.violations
    impulses, velocities, sizes = pair.impulses, pair.velocities, pair.sizes
    count = 0
    for index in range(36):
        p, v = impulses[count], velocities[count]
        impulse_of(table, first + index, free, floor, p)
        velocity_of(index, delassus, free, p, v)
        worst = _violation(index % 6, 0, delassus, free, mu[0], coupling, floor, p, v)
        if worst <= SLACK:
            second = _violation(index // 6, 1, delassus, free, mu[1], coupling, floor, p, v)
            worst = max(worst, second)
        if worst <= SLACK:
            found[count], violations[count] = index, worst
            count += 1
    if count == 0:
        return NO_SOLUTION
    best = 0
    for s in range(1, count):
        if violations[s] < violations[best]:
            best = s
    for i in range(4):
        sizes[i] = _size(i, delassus, free, impulses[best])
    status = SOLVED
    for s in range(count):
        for i in range(4):
            if abs(velocities[s, i] - velocities[best, i]) > SAME * sizes[i]:
                return AMBIGUOUS
        for k in range(2):
            apart = abs(impulses[s, 2 * k] - impulses[best, 2 * k])
            if feeds[k] and apart > SAME * _largest(impulses[best]):
                status = INDETERMINATE
    low = high = best
    if status == INDETERMINATE:
        low, high = _ends(impulses, count)
    cases[0, 0], cases[0, 1] = found[low] % 6, found[low] // 6
    cases[1, 0], cases[1, 1] = found[high] % 6, found[high] // 6
    for i in range(4):
        impulse[i] = 0.5 * (impulses[low, i] + impulses[high, i])
    return status


@part
def _violation(
    case: int, k: int, delassus: Floats, free: Floats, mu: float, coupling: float, floor: Floats,
    p: Floats, v: Floats,
) -> float:  # fmt: skip
    """Largest violation of the inequalities of contact k (0 or 1); inf for no impulses at all.

    Each is relative to the terms that rounding was made in, so that a slow impact of a contact
    that slides fast is judged by its own velocities.
    """
    n, t = 2 * k, 2 * k + 1
    if case // 3 == REST:
        normal = floor[k] - p[n]
        if normal > 0.0:
            normal /= max(_largest(p), floor[k])
    else:
        normal = -v[n]
        if normal > 0.0:
            normal /= _size(n, delassus, free, p)
    if case % 3 == HOLD:
        bound = mu * (p[n] + coupling * p[2 - n])
        tangential = abs(p[t]) - bound
        if tangential > 0.0:
            tangential /= _largest(p)
    else:
        tangential = -v[t] if case % 3 == FORWARD else v[t]
        if tangential > 0.0:
            tangential /= _size(t, delassus, free, p)
    if not (normal <= SLACK and tangential <= SLACK):
        return math.inf
    return float(max(0.0, normal, tangential))


@part
def _size(i: int, delassus: Floats, free: Floats, p: Floats) -> float:
    """Size of the terms that a velocity is the sum of, and that rounding of impulses enters."""
    row = abs(delassus[i, 0]) + abs(delassus[i, 1]) + abs(delassus[i, 2]) + abs(delassus[i, 3])
    return float(abs(free[i]) + row * _largest(p))


@part
def _largest(p: Floats) -> float:
    """Largest modulus of an impulse."""
    return float(max(abs(p[0]), abs(p[1]), abs(p[2]), abs(p[3])))


@part
def _ends(points: Floats, count: int) -> tuple[int, int]:
    """The two ends among points that lie on one segment: extremes of its longest coordinate."""
    first = last = 0
    longest = -1.0
    for k in range(points.shape[1]):
        low = high = 0
        for s in range(1, count):
            if points[s, k] < points[low, k]:
                low = s
            if points[s, k] > points[high, k]:
                high = s
        if points[high, k] - points[low, k] > longest:
            longest, first, last = points[high, k] - points[low, k], low, high
    return first, last


@part
def velocity_of(
    index: int, delassus: Floats, free: Floats, impulse: Floats, velocity: Floats
) -> None:
    """G Lambda + free, with exact zeros where the index combination says zero."""
    for i in range(4):
        total = free[i]
        for j in range(4):
            total += delassus[i, j] * impulse[j]
        velocity[i] = total
    for k in range(2):
        case = index // 6 if k else index % 6
        if case // 3 == REST:
            velocity[2 * k] = 0.0
        if case % 3 == HOLD:
            velocity[2 * k + 1] = 0.0


@part
def _mark(first: int, second: int, expands: bool, floor: float) -> int:
    """What the compression and the expansion did at one contact, as a number below MARKS."""
    compression = 2 if first // 3 == FREE else (1 if first % 3 == HOLD else 0)
    if not expands:
        return compression
    usual = FREE if floor > 0.0 else REST
    expansion = (0 if second // 3 == usual else 2) + (1 if second % 3 == HOLD else 0)
    return compression + 3 * expansion


@part
def halts(mark: int) -> bool:
    """Whether a contact with this mark sticks at the end of the compression or of the expansion."""
    return mark % 3 == 1 or mark // 3 % 2 == 1


@part
def decide(model: Floats, contacts: Ints, z: Floats, choice: Ints, marks: Ints, pair: Pair) -> int:
    """Find the index combinations of an impact.

    Parameters
    ----------
    contacts
        (n,) the one or two contacts (0-based) with zero gap, ascending.
    z
        State (7,) before the impact.
    choice
        Output (3,): combinations c_1 + 6 c_2 of the compression, twice (if it is indeterminate both
        ends of its segment), and of the expansion, or UNSOLVED if there is none.
    marks
        Output: a mark (2,) for each contact: between equal marks the impact depends smoothly on the
        state.
    pair
        Room for an impact at two contacts.
    """
    if len(contacts) == 1:
        return _decide_single(model, contacts[0], z, choice, marks)
    return _decide_double(model, contacts, z, choice, marks, pair)


@part
def carry_out(
    model: Floats, contacts: Ints, choice: Ints, z: Floats, case: Ints, impulses: Floats, pair: Pair
) -> None:
    """Change the velocities as given index combinations say: a smooth map of the state.

    Parameters
    ----------
    contacts, choice
        As :func:`decide` takes and gives them.
    z
        State (7,); its velocities are updated in place.
    case, impulses
        Output: the last index combination of each contact (2,), impulses (2, 4) of both phases.
    pair
        Room for an impact at two contacts, as :func:`prepare` or :func:`decide` leaves it.
    """
    _find_impulses(model, contacts, choice, z, case, impulses, pair)
    _kick_off(model, contacts, case, z, impulses, pair)


@part
def carry_out_along(
    model: Floats, change: Floats, contacts: Ints, choice: Ints, z: Floats, tangents: Floats,
    seed: Floats, case: Ints, impulses: Floats, pair: Pair,
) -> None:  # fmt: skip
    """The same with derivatives.

    They need no other table: where g = G Lambda + free, and Lambda_T = -+F Lambda_N at contacts
    that slide, the derivative of Lambda solves the same equations as Lambda with
    d(free) + dG Lambda + G_T tau for free and tau = -+dF Lambda_N added to its tangential part.

    Parameters
    ----------
    change
        Derivative of the model along the last tangent, or of length 0 if it stays.
    tangents
        Derivatives of states (m, 7); their velocities are updated in place.
    seed
        (m, 3) derivative of eps_N along each tangent.
    """
    _find_impulses(model, contacts, choice, z, case, impulses, pair)
    for m in range(len(tangents)):
        along = m if len(change) > 0 and m == len(tangents) - 1 else UNSOLVED
        if len(contacts) == 1:
            _single_tangent(
                model, change, along, contacts[0], choice, z, tangents[m], seed[m], impulses
            )
        else:
            _pair_tangent(
                model, change, along, contacts, choice, z, tangents[m], seed[m], impulses, pair
            )
    _kick_off(model, contacts, case, z, impulses, pair)
    for m in range(len(tangents)):
        bounce = 0.0
        for k in range(len(contacts)):
            i = contacts[k]
            if seed[m, i] != 0.0 and model[CONTACT + i, EPS] == 0.0:
                bounce = tangents[m, 3 + ANGLE[i]] if len(contacts) == 1 else math.nan
        _clear(model, contacts, case, tangents[m])
        if len(change) > 0 and m == len(tangents) - 1:
            _clear_change(change, contacts, case, z, tangents[m])
        if bounce != 0.0:  # a larger eps_N makes this contact bounce
            tangents[m, 3 + ANGLE[contacts[0]]] = bounce


@part
def _find_impulses(
    model: Floats, contacts: Ints, choice: Ints, z: Floats, case: Ints, impulses: Floats, pair: Pair
) -> None:
    """Impulses of both phases, and the gap rates that they leave in ``pair.after``."""
    for k in range(4):
        impulses[0, k] = impulses[1, k] = 0.0
    last = choice[2] if choice[2] != UNSOLVED else choice[0]
    case[0], case[1] = last % 6, last // 6
    if len(contacts) == 1:
        _find_single_impulses(model, contacts[0], choice, z, impulses, pair)
    else:
        _find_pair_impulses(model, contacts, choice, case, impulses, pair)


@part
def _kick_off(
    model: Floats, contacts: Ints, case: Ints, z: Floats, impulses: Floats, pair: Pair
) -> None:
    """Change the velocities by the impulses; those that are zero become exactly so.

    Gap rates are set without the rounding of the kicks: a bounce can be slower than the rounding of
    the velocity that it reverses.
    """
    for k in range(len(contacts)):
        p_n = impulses[0, 2 * k] + impulses[1, 2 * k]
        p_t = impulses[0, 2 * k + 1] + impulses[1, 2 * k + 1]
        _kick(model, contacts[k], p_n, p_t, z)
    for k in range(len(contacts)):
        i = contacts[k]
        z[3 + ANGLE[i]] = SIGN[i] * pair.after[2 * k] / model[FORCE, LEVER + i]
    _clear(model, contacts, case, z)


@part
def rates(model: Floats, i: int, z: Floats) -> tuple[float, float]:
    """Gap rate and tangential velocity [m/s] of contact i (0-based)."""
    w = CONTACT + i
    return (
        SIGN[i] * model[FORCE, LEVER + i] * z[3 + ANGLE[i]],
        model[w, TANGENT] * z[3] + model[w, TANGENT + 1] * z[4] + model[w, TANGENT + 2] * z[5],
    )


@part
def _kick(model: Floats, i: int, p_n: float, p_t: float, z: Floats) -> None:
    """Change the velocities by the impulses (p_n, p_t) at contact i."""
    row = CONTACT + i
    for j in range(3):
        z[3 + j] += p_n * model[row, RESPONSE_N + j] + p_t * model[row, RESPONSE_T + j]


@part
def _decide_single(model: Floats, i: int, z: Floats, choice: Ints, marks: Ints) -> int:
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    mu, eps = model[CONTACT + i, MU], model[CONTACT + i, EPS]
    free_n, free_t = rates(model, i, z)
    status, first, c_n, c_t = one_contact(g_nn, g_nt, g_tt, free_n, free_t, mu, 0.0)
    choice[0], choice[1], choice[2] = first, first, UNSOLVED
    if status != SOLVED:
        return status
    floor, second = eps * c_n, first
    if floor > 0.0:  # otherwise the compression was all
        v_n = 0.0 if first // 3 == REST else free_n
        v_t = 0.0 if first % 3 == HOLD else free_t + g_nt * c_n + g_tt * c_t
        status, second, _, _ = one_contact(g_nn, g_nt, g_tt, v_n, v_t, mu, floor)
        choice[2] = second
        if status != SOLVED:
            return status
    marks[0] = _mark(first, second, floor > 0.0, floor)
    return SOLVED


@part
def _find_single_impulses(
    model: Floats, i: int, choice: Ints, z: Floats, impulses: Floats, pair: Pair
) -> None:
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    mu, first, e_n, e_t = model[CONTACT + i, MU], choice[0], 0.0, 0.0
    free_n, free_t = rates(model, i, z)
    c_n, c_t = one_contact_case(first, g_nn, g_nt, g_tt, free_n, free_t, mu, 0.0)
    v_n = 0.0 if first // 3 == REST else free_n
    if choice[2] != UNSOLVED:
        v_t = 0.0 if first % 3 == HOLD else free_t + g_nt * c_n + g_tt * c_t
        floor = model[CONTACT + i, EPS] * c_n
        e_n, e_t = one_contact_case(choice[2], g_nn, g_nt, g_tt, v_n, v_t, mu, floor)
    impulses[0, 0], impulses[0, 1], impulses[1, 0], impulses[1, 1] = c_n, c_t, e_n, e_t
    pair.after[0] = v_n + g_nn * e_n + g_nt * e_t


@part
def _single_tangent(
    model: Floats, change: Floats, along: int, i: int, choice: Ints, z: Floats, tangent: Floats,
    seed: Floats, impulses: Floats,
) -> None:  # fmt: skip
    """Change the velocities of a tangent by what an impact at one contact does to them."""
    c_n, c_t, e_n, e_t = impulses[0, 0], impulses[0, 1], impulses[1, 0], impulses[1, 1]
    first, expands = choice[0], choice[2] != UNSOLVED
    dv_n, dv_t = rates(model, i, tangent)
    if along >= 0:
        more_n, more_t = rates(change, i, z)
        dv_n, dv_t = dv_n + more_n, dv_t + more_t
    dc_n, dc_t, dv_n, dv_t = one_change(model, change, along, i, first, c_n, c_t, dv_n, dv_t, 0.0)
    dfloor = model[CONTACT + i, EPS] * dc_n + seed[i] * c_n
    de_n = de_t = 0.0
    if expands or dfloor != 0.0:
        case = choice[2] if expands else 3 * FREE + first % 3
        de_n, de_t, _, _ = one_change(model, change, along, i, case, e_n, e_t, dv_n, dv_t, dfloor)
    if along >= 0:
        _kick(change, i, c_n + e_n, c_t + e_t, tangent)
    _kick(model, i, dc_n + de_n, dc_t + de_t, tangent)


@part
def one_change(
    model: Floats, change: Floats, along: int, i: int, case: int, p_n: float, p_t: float,
    free_n: float, free_t: float, floor: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Derivatives of impulses (N, T) and velocities of one phase, from those of free and floor."""
    n, t = DELASSUS + 2 * i, 2 * i
    g_nn, g_nt, g_tt = model[n, t], model[n, t + 1], model[n + 1, t + 1]
    tau = 0.0
    if along >= 0:
        if case % 3 != HOLD:
            dmu = change[CONTACT + i, MU]
            tau = -dmu * p_n if case % 3 == FORWARD else dmu * p_n
        free_n += change[n, t] * p_n + change[n, t + 1] * p_t + g_nt * tau
        free_t += change[n + 1, t] * p_n + change[n + 1, t + 1] * p_t + g_tt * tau
    d_n, d_t = one_contact_case(
        case, g_nn, g_nt, g_tt, free_n, free_t, model[CONTACT + i, MU], floor
    )
    v_n = 0.0 if case // 3 == REST else free_n + g_nn * d_n + g_nt * d_t
    v_t = 0.0 if case % 3 == HOLD else free_t + g_nt * d_n + g_tt * d_t
    return d_n, d_t + tau, v_n, v_t


@part
def prepare(model: Floats, contacts: Ints, z: Floats, pair: Pair) -> None:
    """Write what an impact at two contacts starts from into its room."""
    fill_pair(model, contacts[1], pair.delassus, pair.friction, pair.system)
    for a in range(4):
        for b in range(4):
            row, column = 2 * contacts[a // 2] + a % 2, 2 * contacts[b // 2] + b % 2
            pair.delassus[a, b] = model[DELASSUS + row, column]
    for k in range(2):
        i = contacts[k]
        pair.mu[k], pair.eps[k] = model[CONTACT + i, MU], model[CONTACT + i, EPS]
        pair.free[2 * k], pair.free[2 * k + 1] = rates(model, i, z)
        pair.floor[k] = 0.0


@part
def _decide_double(
    model: Floats, contacts: Ints, z: Floats, choice: Ints, marks: Ints, pair: Pair
) -> int:
    prepare(model, contacts, z, pair)
    delassus, mu, eps, floor = pair.delassus, pair.mu, pair.eps, pair.floor
    feeds, middle, impulse = pair.feeds, pair.middle, pair.end
    first, second = pair.first, pair.second
    for k in range(2):
        feeds[k] = 1 if eps[k] > 0.0 else 0
    table = PAIR + 36 * (contacts[1] - 1)
    outcome = two_contacts(
        model, table, delassus, pair.free, mu, 0.0, floor, feeds, first, impulse, pair
    )
    if outcome in (NO_SOLUTION, AMBIGUOUS):
        return outcome
    choice[0], choice[1] = first[0, 0] + 6 * first[0, 1], first[1, 0] + 6 * first[1, 1]
    choice[2] = UNSOLVED
    velocity_of(choice[0], delassus, pair.free, impulse, middle)
    expands = False
    for k in range(2):
        floor[k] = eps[k] * impulse[2 * k]
        expands = expands or floor[k] > 0.0
        second[0, k] = first[0, k]
        feeds[k] = 0
    if expands:
        status = two_contacts(
            model, table + EXPANSION, delassus, middle, mu, model[FORCE, SUMMED], floor, feeds,
            second, impulse, pair,
        )  # fmt: skip
        if status != SOLVED:
            return status
        choice[2] = second[0, 0] + 6 * second[0, 1]
    for k in range(2):
        marks[k] = _mark(first[0, k], second[0, k], expands, floor[k])
        if outcome == INDETERMINATE:  # tells the two ends of the segment apart
            marks[k] = first[k, 0] % 3 + 3 * (first[k, 1] % 3)
    return outcome


@part
def _find_pair_impulses(
    model: Floats, contacts: Ints, choice: Ints, case: Ints, impulses: Floats, pair: Pair
) -> None:
    free, floor, middle, impulse = pair.free, pair.floor, pair.middle, pair.end
    floor[0] = floor[1] = 0.0
    table = PAIR + 36 * (contacts[1] - 1)
    for side in range(2):
        impulse_of(model, table + choice[side], free, floor, impulse)
        for k in range(4):
            impulses[0, k] += 0.5 * impulse[k]
    for k in range(4):
        impulse[k] = impulses[0, k]
    velocity_of(choice[0], pair.delassus, free, impulse, middle)
    for k in range(2):
        floor[k] = pair.eps[k] * impulse[2 * k]
    for k in range(4):
        impulse[k] = 0.0
    if choice[2] != UNSOLVED:
        impulse_of(model, table + EXPANSION + choice[2], middle, floor, impulse)
        for k in range(4):
            impulses[1, k] = impulse[k]
    velocity_of(case[0] + 6 * case[1], pair.delassus, middle, impulse, pair.after)


@part
def _pair_tangent(
    model: Floats, change: Floats, along: int, contacts: Ints, choice: Ints, z: Floats,
    tangent: Floats, seed: Floats, impulses: Floats, pair: Pair,
) -> None:  # fmt: skip
    """Change the velocities of a tangent by what an impact at two contacts does to them.

    An indeterminate compression takes the mean of both ends of its segment.
    """
    free, floor, middle, impulse = pair.free, pair.floor, pair.middle, pair.end
    total, more = pair.total, pair.more
    table = PAIR + 36 * (contacts[1] - 1)
    for k in range(4):
        total[k] = 0.0
    for side in range(1, -1, -1):  # the first end comes last: its velocities go on
        floor[0] = floor[1] = 0.0
        if along >= 0:
            for k in range(2):
                free[2 * k], free[2 * k + 1] = rates(model, contacts[k], z)
            impulse_of(model, table + choice[side], free, floor, impulse)
        for k in range(2):
            free[2 * k], free[2 * k + 1] = rates(model, contacts[k], tangent)
            if along >= 0:
                more_n, more_t = rates(change, contacts[k], z)
                free[2 * k], free[2 * k + 1] = free[2 * k] + more_n, free[2 * k + 1] + more_t
        pair_change(model, change, along, contacts, table, choice[side], 0.0, impulse, pair)
        for k in range(4):
            total[k] += 0.5 * more[k]
    if choice[2] != UNSOLVED:
        for k in range(2):
            dfloor = seed[contacts[k]] * impulses[0, 2 * k]
            floor[k] = pair.eps[k] * total[2 * k] + dfloor
            free[2 * k], free[2 * k + 1] = middle[2 * k], middle[2 * k + 1]
        for k in range(4):
            impulse[k] = impulses[1, k]
        pair_change(
            model, change, along, contacts, table + EXPANSION, choice[2], model[FORCE, SUMMED],
            impulse, pair,
        )  # fmt: skip
        for k in range(4):
            total[k] += more[k]
    for k in range(2):
        if along >= 0:
            p_n = impulses[0, 2 * k] + impulses[1, 2 * k]
            p_t = impulses[0, 2 * k + 1] + impulses[1, 2 * k + 1]
            _kick(change, contacts[k], p_n, p_t, tangent)
        _kick(model, contacts[k], total[2 * k], total[2 * k + 1], tangent)


@part
def pair_change(
    model: Floats, change: Floats, along: int, contacts: Ints, table: int, index: int,
    coupling: float, impulse: Floats, pair: Pair,
) -> None:  # fmt: skip
    """Derivatives of impulses and velocities of one phase, from those of free and floor.

    ``pair.free`` and ``pair.floor`` hold the latter, and ``impulse`` is that of the phase; output
    are ``pair.more`` and ``pair.middle``.
    """
    free, out, tau_0, tau_1 = pair.free, pair.more, 0.0, 0.0
    if along >= 0:
        for a in range(4):
            row = DELASSUS + 2 * contacts[a // 2] + a % 2
            for b in range(4):
                free[a] += change[row, 2 * contacts[b // 2] + b % 2] * impulse[b]
        for k in range(2):
            case = index // 6 if k else index % 6
            if case % 3 == HOLD:
                continue
            tau = change[CONTACT + contacts[k], MU] * (
                impulse[2 * k] + coupling * impulse[2 - 2 * k]
            )
            tau = -tau if case % 3 == FORWARD else tau
            for a in range(4):
                free[a] += pair.delassus[a, 2 * k + 1] * tau
            tau_0, tau_1 = (tau_0, tau) if k else (tau, tau_1)
    impulse_of(model, table + index, free, pair.floor, out)
    velocity_of(index, pair.delassus, free, out, pair.middle)
    out[1] += tau_0
    out[3] += tau_1


@part
def _clear(model: Floats, contacts: Ints, case: Ints, z: Floats) -> None:
    """Velocities that an index combination makes zero become exactly zero."""
    for k in range(len(contacts)):
        if case[k] // 3 == REST:
            z[3 + ANGLE[contacts[k]]] = 0.0
    for k in range(len(contacts)):
        if case[k] % 3 == HOLD:
            hold(model, contacts[k], z)


@part
def _clear_change(change: Floats, contacts: Ints, case: Ints, z: Floats, tangent: Floats) -> None:
    """What a moving direction of sticking adds to the velocity of the sleeve that keeps it.

    Of two contacts that stick the last one has set that velocity.
    """
    for k in range(len(contacts) - 1, -1, -1):
        if case[k] % 3 == HOLD:
            tangent[3] -= rates(change, contacts[k], z)[1]
            return


@part
def hold(model: Floats, i: int, z: Floats) -> None:
    """Make the tangential velocity of contact i exactly zero through the velocity of the sleeve."""
    row = CONTACT + i
    z[3] = -(model[row, TANGENT + 1] * z[4] + model[row, TANGENT + 2] * z[5])


@part
def rest_is_possible(model: Floats, k: int, d: float) -> bool:
    """Whether contacts 1 and k + 1 can hold the toy at rest: some forces lie in both cones."""
    low, high = rest_range(model, k, d)
    return low <= high


@part
def rest_range(model: Floats, k: int, d: float) -> tuple[float, float]:
    """The interval of lambda_T1 with which contacts 1 and k + 1 hold the toy at rest.

    Equilibrium 0 = h + W lambda leaves one force free; with s = lambda_T1 every condition is
    linear in s. Where there is none the lower end is above the upper one.
    """
    low, high = -math.inf, math.inf
    h_y = model[FORCE, 0] + model[FORCE, 3] * d
    h_m = model[FORCE, 1] + model[FORCE, 4] * d
    h_s = model[FORCE, 2] + model[FORCE, 5] * d
    beak, sleeve = CONTACT, CONTACT + k
    for cone in (1.0, -1.0):
        # Contact 1: mu lambda_N1 + cone s >= 0; row phi_S fixes lambda_N1(s).
        scale = model[beak, MU] / model[FORCE, LEVER]
        rate = scale * model[beak, TANGENT + 2] + cone
        low, high = _half_line(scale * h_s, rate, low, high)
        # Contact k: lambda_Tk = -h_y - s, and row phi_M fixes lambda_Nk(s).
        scale = -model[sleeve, MU] * SIGN[k] / model[FORCE, LEVER + k]
        constant = scale * (h_m - model[sleeve, TANGENT + 1] * h_y) - cone * h_y
        rate = scale * (model[beak, TANGENT + 1] - model[sleeve, TANGENT + 1]) - cone
        low, high = _half_line(constant, rate, low, high)
    return low, high


@part
def _half_line(constant: float, rate: float, low: float, high: float) -> tuple[float, float]:
    """Intersect [low, high] with {s : constant + rate s >= 0}."""
    if rate > 0.0:
        return max(low, -constant / rate), high
    if rate < 0.0:
        return low, min(high, -constant / rate)
    return (low, high) if constant >= 0.0 else (math.inf, -math.inf)
