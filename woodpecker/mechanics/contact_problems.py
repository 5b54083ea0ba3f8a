"""Contact problems of impacts with friction, solved by trying index combinations.

Compression and expansion [Leine2001, Eqs. 2-5; Pfeiffer1996] have one form: find impulses Lambda
with

    (g_N, g_T) = G Lambda + free,    G = W^T M^-1 W,
    0 <= g_N  perp  Lambda_N - floor >= 0      (floor = 0, or eps_N Lambda_NC in expansion),
    |Lambda_T| <= mu Lambda_N,  Lambda_T = -mu Lambda_N sign(g_T) where g_T != 0.

In expansion at two contacts the paper's law bounds |Lambda_T| by mu times the sum of both normal
impulses (:class:`woodpecker.mechanics.toy.ExpansionFriction`). One contact has closed forms for its
six index combinations; for two, all 36 of a table are tried (``cases``), so that a missing or a
second solution is seen. Tests compare with :mod:`woodpecker.mechanics.lcp`.

On a boundary several combinations give the same motion. The first one that holds up to EXACT names
it, in the order of their numbers: a contact rests before it leaves, and sticks before it slides. If
of two contacts none does, it is the one with the least violation, at most SLACK. The same rule in
:mod:`woodpecker.systems.mechanics.impacts` makes words of both independent of rounding.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import part
from woodpecker.mechanics.cases import (
    EXACT,
    FORWARD,
    FREE,
    HOLD,
    REST,
    SAME,
    SINGULAR,
    SLACK,
    impulse_of,
)
from woodpecker.mechanics.modes import CONTACT, FORCE, LEVER, MU, SIGN, TANGENT

# Outcome of a contact problem.
SOLVED, NO_SOLUTION, AMBIGUOUS, INDETERMINATE = 0, 1, 2, 3

UNSOLVED = -1


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
    """Outcome, index combination and impulses (N, T) of the contact problem of one contact."""
    # On a boundary, too, rounding leaves one combination that holds up to EXACT.
    regular = g_nn * g_tt - g_nt * g_nt > SINGULAR * g_nn * g_tt
    kept, kept_n, kept_t, slip = UNSOLVED, 0.0, 0.0, 0.0
    for case in range(0 if regular else 1, 6):  # case 0 rests and sticks
        p_n, p_t = one_contact_case(case, g_nn, g_nt, g_tt, free_n, free_t, mu, floor)
        v_n = free_n + g_nn * p_n + g_nt * p_t
        v_t = free_t + g_nt * p_n + g_tt * p_t
        most, tangential = max(abs(p_n), abs(p_t)), case % 3
        size_n = abs(free_n) + (g_nn + abs(g_nt)) * most
        size_t = abs(free_t) + (abs(g_nt) + g_tt) * most
        if case // 3 == REST:
            # a sliding contact multiplies it by mu; the comparison fails if it is nan, too
            if not p_n >= floor - EXACT * max(most / max(1.0, mu), floor):
                continue
        elif not v_n >= -EXACT * size_n:
            continue
        if tangential == HOLD:
            if not abs(p_t) <= mu * p_n + EXACT * most:
                continue
        elif not (v_t if tangential == FORWARD else -v_t) >= -EXACT * size_t:
            continue
        if kept == UNSOLVED:
            kept, kept_n, kept_t, slip = case, p_n, p_t, v_t
        elif abs(v_t - slip) > SAME * size_t:  # for one v_t there is one v_n, as det(G) > 0
            return AMBIGUOUS, kept, kept_n, kept_t
    return (NO_SOLUTION if kept == UNSOLVED else SOLVED), kept, kept_n, kept_t


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
            ("more", "f8", (4,)),  # impulses of a phase along a tangent
            ("found", "i8", (36,)),  # combinations whose inequalities hold
            ("violations", "f8", (36,)),
            ("impulses", "f8", (36, 4)),
            ("velocities", "f8", (36, 4)),
            ("sizes", "f8", (4,)),  # of the terms of the velocities
        ],
    )
)
"""Workspace of an impact at two contacts, (N, T) of each in turn; all entries are overwritten.

Compiled code passes a record by its address; to pass separate arrays would take longer than the
arithmetic.
"""

Pair = np.record  # of PAIR_ROOM


@part
def two_contacts(
    table: Floats, first: int, delassus: Floats, free: Floats, mu: Floats, coupling: float,
    floor: Floats, feeds: Ints, cases: Ints, impulse: Floats, pair: Pair,
) -> int:  # fmt: skip
    """Solve the contact problem of two contacts by trying every index combination.

    ``table`` has their coefficients from row ``first`` on (:mod:`woodpecker.mechanics.cases`), for
    ``coupling``, 0 or 1: the part of the other contact's normal impulse in the bound of friction.
    delassus (4, 4) and free (4,) have (N, T) of each contact in turn; mu, floor and feeds are (2,),
    feeds nonzero where a normal impulse enters the expansion. Output: ``impulse`` (4,), or the
    middle of a segment of them; ``cases`` (2, 2), the index combination twice, or those of the two
    ends of the segment, ordered by the impulse that varies most.

    Returns SOLVED; NO_SOLUTION; AMBIGUOUS if two combinations give different velocities; or
    INDETERMINATE if they differ only in normal impulses that enter the expansion.
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
        if violations[best] > EXACT and violations[s] < violations[best]:
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
        low, high = _ends(impulses, count, SAME * _largest(impulses[best]))
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
    """Largest violation of the inequalities of contact k (0 or 1); inf if above SLACK, or nan."""
    # Each is relative to the terms that were rounded, so that a slow impact of a contact that
    # slides fast is judged by its own velocities.
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
    """Size of the terms of velocity i, whose impulses have errors relative to the largest."""
    row = abs(delassus[i, 0]) + abs(delassus[i, 1]) + abs(delassus[i, 2]) + abs(delassus[i, 3])
    return float(abs(free[i]) + row * _largest(p))


@part
def _largest(p: Floats) -> float:
    return float(max(abs(p[0]), abs(p[1]), abs(p[2]), abs(p[3])))


@part
def _ends(points: Floats, count: int, same: float) -> tuple[int, int]:
    """The two ends of points on a segment, by its longest coordinate; of ties the first."""
    first = last = 0
    longest = -1.0
    for k in range(points.shape[1]):
        low = high = points[0, k]
        for s in range(1, count):
            low, high = min(low, points[s, k]), max(high, points[s, k])
        if high - low > longest + same:
            longest, first, last = high - low, 0, 0
            while points[first, k] > low + same:
                first += 1
            while points[last, k] < high - same:
                last += 1
    return first, last


@part
def velocity_of(
    index: int, delassus: Floats, free: Floats, impulse: Floats, velocity: Floats
) -> None:
    """G Lambda + free, with the exact zeros of the index combination."""
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
def rest_is_possible(model: Floats, k: int, d: float) -> bool:
    """Whether contacts 1 and k + 1 can hold the toy at rest with forces inside both cones."""
    low, high = rest_range(model, k, d)
    return low <= high


@part
def rest_range(model: Floats, k: int, d: float) -> tuple[float, float]:
    """Interval of lambda_T1 for rest on contacts 1 and k + 1; low > high if there is none."""
    # Equilibrium 0 = h + W lambda leaves one of four forces free, s = lambda_T1, and every
    # condition of the cones is linear in s.
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
