"""Impacts with friction at one or two contacts, solved directly.

Compression and expansion [Leine2001, Eqs. 2-5; Pfeiffer1996] are one problem: find impulses
Lambda with

    (g_N, g_T) = G Lambda + free,    G = W^T M^-1 W,
    0 <= g_N  perp  Lambda_N - floor >= 0      (floor = 0, or eps_N Lambda_NC in expansion),
    |Lambda_T| <= mu Lambda_N,  Lambda_T = -mu Lambda_N sign(g_T) where g_T != 0.

With one or two contacts there are at most 36 index combinations: all are tried, so a missing
solution or a second one is seen. :mod:`woodpecker.lcp` solves the same problem by Lemke's method
for any number of contacts and is what this file is tested against.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.compiled import jit
from woodpecker.modes import Floats, Ints, Model

# Outcome of a contact problem.
SOLVED, NO_SOLUTION, AMBIGUOUS = 0, 1, 2

# Index combination of one contact: 3 * normal + tangential.
REST, FREE = 0, 1  # gap rate stays zero / Lambda_N stays at its floor
HOLD, FORWARD, BACKWARD = 0, 1, 2  # tangential velocity zero / positive / negative
UNSOLVED = -1

SINGULAR = 1e-11  # pivot over row norm below which a combination is rank-deficient: rounding of G
# is near 1e-15, and the only rank-deficient combinations are exactly so (four directions in R^3)
SLACK = 1e-11  # used only where strict signs leave no combination: a solution on a boundary
SAME = 1e-8  # velocities closer than this (relative) are one solution found twice


@jit
def solve_case(
    case: Ints, delassus: Floats, free: Floats, mu: Floats, floor: Floats, impulse: Floats
) -> bool:
    """Impulses of one index combination by elimination; False if it is rank-deficient.

    Order of rows and unknowns: (N, T) of the first contact, then of the second. The map from
    (free, floor) to impulses is linear, so derivatives come from the same function.
    """
    n = 2 * len(case)
    system = np.zeros((4, 5))
    for k in range(len(case)):
        row_n, row_t = 2 * k, 2 * k + 1
        normal, tangential = case[k] // 3, case[k] % 3
        if normal == REST:
            for j in range(n):
                system[row_n, j] = delassus[row_n, j]
            system[row_n, 4] = -free[row_n]
        else:
            system[row_n, row_n] = 1.0
            system[row_n, 4] = floor[k]
        if tangential == HOLD:
            for j in range(n):
                system[row_t, j] = delassus[row_t, j]
            system[row_t, 4] = -free[row_t]
        else:
            system[row_t, row_t] = 1.0
            system[row_t, row_n] = mu[k] if tangential == FORWARD else -mu[k]
    return _eliminate(system, n, impulse)


@jit
def _eliminate(system: Floats, n: int, solution: Floats) -> bool:
    """Gauss elimination of n rows (right-hand side in column 4), scaled partial pivoting."""
    for i in range(n):
        norm = 0.0
        for j in range(n):
            norm = max(norm, abs(system[i, j]))
        for j in range(5):
            system[i, j] /= norm
    for i in range(n):
        pivot = i
        for j in range(i + 1, n):
            if abs(system[j, i]) > abs(system[pivot, i]):
                pivot = j
        if abs(system[pivot, i]) < SINGULAR:
            return False
        if pivot != i:
            for j in range(5):
                system[i, j], system[pivot, j] = system[pivot, j], system[i, j]
        for k in range(i + 1, n):
            factor = system[k, i] / system[i, i]
            for j in range(i, 5):
                system[k, j] -= factor * system[i, j]
    for i in range(n - 1, -1, -1):
        total = system[i, 4]
        for j in range(i + 1, n):
            total -= system[i, j] * solution[j]
        solution[i] = total / system[i, i]
    return True


@jit
def _admissible(
    case: Ints, velocity: Floats, impulse: Floats, mu: Floats, floor: Floats,
    slack_v: float, slack_i: float,
) -> bool:  # fmt: skip
    """Whether the inequalities of an index combination hold, up to the slacks."""
    for k in range(len(case)):
        normal, tangential = case[k] // 3, case[k] % 3
        if normal == REST:
            if impulse[2 * k] < floor[k] - slack_i:
                return False
        elif velocity[2 * k] < -slack_v:
            return False
        if tangential == HOLD:
            if abs(impulse[2 * k + 1]) > mu[k] * impulse[2 * k] + slack_i:
                return False
        elif tangential == FORWARD:
            if velocity[2 * k + 1] < -slack_v:
                return False
        elif velocity[2 * k + 1] > slack_v:
            return False
    return True


@jit
def contact_problem(
    delassus: Floats, free: Floats, mu: Floats, floor: Floats, need_unique: Ints,
    case: Ints, impulse: Floats,
) -> int:  # fmt: skip
    """Try every index combination of one or two contacts.

    Parameters
    ----------
    delassus
        (2n, 2n), (N, T) of each contact in turn; free is (2n,), mu and floor are (n,).
    need_unique
        (n,) nonzero where the normal impulse itself matters afterwards (it feeds the expansion).
    case, impulse
        Output: the index combination (n,) and its impulses (2n,).

    Returns
    -------
    SOLVED, NO_SOLUTION, or AMBIGUOUS if two combinations give different velocities (or different
    normal impulses where these matter).
    """
    n = len(case)
    trial, found = np.zeros(n, dtype=np.int64), np.zeros(2 * n)
    velocity, kept = np.zeros(2 * n), np.zeros(2 * n)
    scale_v, scale_i = 0.0, 0.0
    for k in range(2 * n):
        scale_v = max(scale_v, abs(free[k]))
        scale_i = max(scale_i, abs(free[k]) / delassus[k, k])
    for k in range(n):
        scale_i = max(scale_i, floor[k])
        scale_v = max(scale_v, floor[k] * delassus[2 * k, 2 * k])
    for slack in (0.0, SLACK):
        solutions = 0
        for index in range(6**n):
            for k in range(n):
                trial[k] = (index // 6**k) % 6
            if not solve_case(trial, delassus, free, mu, floor, found):
                continue
            _velocities(trial, delassus, free, found, velocity)
            if not _admissible(trial, velocity, found, mu, floor, slack * scale_v, slack * scale_i):
                continue
            if solutions == 0:
                for k in range(2 * n):
                    kept[k], impulse[k] = velocity[k], found[k]
                for k in range(n):
                    case[k] = trial[k]
                solutions = 1
                continue
            for k in range(2 * n):
                if abs(velocity[k] - kept[k]) > SAME * scale_v:
                    return AMBIGUOUS
            for k in range(n):
                if need_unique[k] and abs(found[2 * k] - impulse[2 * k]) > SAME * scale_i:
                    return AMBIGUOUS
        if solutions > 0:
            return SOLVED
    return NO_SOLUTION


@jit
def _velocities(
    case: Ints, delassus: Floats, free: Floats, impulse: Floats, velocity: Floats
) -> None:
    """G Lambda + free, with exact zeros where the index combination says zero."""
    n = 2 * len(case)
    for i in range(n):
        total = free[i]
        for j in range(n):
            total += delassus[i, j] * impulse[j]
        velocity[i] = total
    for k in range(len(case)):
        if case[k] // 3 == REST:
            velocity[2 * k] = 0.0
        if case[k] % 3 == HOLD:
            velocity[2 * k + 1] = 0.0


@jit
def impact(
    model: Model, taking_part: Ints, z: Floats, tangents: Floats, seed: Floats,
    case: Ints, impulses: Floats,
) -> int:  # fmt: skip
    """Poisson impact with Coulomb friction: compression, then expansion.

    Parameters
    ----------
    taking_part
        (n,) the one or two contacts (0-based) with zero gap.
    z, tangents
        State (7,) and derivatives of states (m, 7); their velocities are updated in place.
    seed
        (m, 3) derivative of eps_N along each tangent.
    case, impulses
        Output: index combination of the expansion (n,), impulses (2, 2n) of both phases.
    """
    n = len(taking_part)
    delassus, directions = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 3))
    responses = np.zeros((2 * n, 3))
    mu, floor, zero = np.zeros(n), np.zeros(n), np.zeros(n)
    compression = np.zeros(n, dtype=np.int64)
    feeds, never = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for k in range(n):
        i = taking_part[k]
        mu[k] = model.mu[i]
        feeds[k] = 1 if model.eps[i] > 0.0 else 0
        for j in range(3):
            directions[2 * k, j], directions[2 * k + 1, j] = model.normal[i, j], model.tangent[i, j]
    for a in range(2 * n):
        for j in range(3):
            for l in range(3):
                responses[a, j] += model.inverse_mass[j, l] * directions[a, l]
    for a in range(2 * n):
        for b in range(2 * n):
            for j in range(3):
                delassus[a, b] += directions[a, j] * responses[b, j]

    free = _project(directions, z)
    status = contact_problem(delassus, free, mu, zero, feeds, compression, impulses[0])
    if status != SOLVED:
        return status
    for k in range(n):
        floor[k] = model.eps[taking_part[k]] * impulses[0, 2 * k]
    middle = np.zeros(2 * n)
    _velocities(compression, delassus, free, impulses[0], middle)
    status = contact_problem(delassus, middle, mu, floor, never, case, impulses[1])
    if status != SOLVED:
        return status

    change, total = np.zeros(2 * n), np.zeros(2 * n)
    for m in range(len(tangents)):
        free = _project(directions, tangents[m])
        solve_case(compression, delassus, free, mu, zero, change)
        for k in range(n):
            i = taking_part[k]
            floor[k] = model.eps[i] * change[2 * k] + seed[m, i] * impulses[0, 2 * k]
        _velocities(compression, delassus, free, change, middle)
        solve_case(case, delassus, middle, mu, floor, total)
        for a in range(2 * n):
            total[a] += change[a]
        _kick(responses, total, tangents[m])
    _kick(responses, impulses[0] + impulses[1], z)
    _clear(model, taking_part, case, z)
    for m in range(len(tangents)):
        _clear(model, taking_part, case, tangents[m])
    return SOLVED


@jit
def _project(directions: Floats, z: Floats) -> Floats:
    velocity = np.zeros(len(directions))
    for a in range(len(directions)):
        for j in range(3):
            velocity[a] += directions[a, j] * z[3 + j]
    return velocity


@jit
def _kick(responses: Floats, impulse: Floats, z: Floats) -> None:
    for a in range(len(responses)):
        for j in range(3):
            z[3 + j] += responses[a, j] * impulse[a]


@jit
def _clear(model: Model, taking_part: Ints, case: Ints, z: Floats) -> None:
    """Velocities that an index combination makes zero become exactly zero."""
    for k in range(len(case)):
        if case[k] // 3 == REST:
            z[3 + model.angle[taking_part[k]]] = 0.0
    for k in range(len(case)):
        if case[k] % 3 == HOLD:
            i = taking_part[k]
            z[3] = -(model.tangent[i, 1] * z[4] + model.tangent[i, 2] * z[5])


@jit
def rest_is_possible(model: Model, k: int, d: float) -> bool:
    """Whether contacts 1 and k + 1 can hold the toy at rest: some forces lie in both cones.

    Equilibrium 0 = h + W lambda leaves one force free; with s = lambda_T1 every condition is
    linear in s.
    """
    low, high = -math.inf, math.inf
    h_y = model.force[0, 0] + model.force[1, 0] * d
    h_m = model.force[0, 1] + model.force[1, 1] * d
    h_s = model.force[0, 2] + model.force[1, 2] * d
    for cone in (1.0, -1.0):
        # Contact 1: mu lambda_N1 + cone s >= 0; row phi_S fixes lambda_N1(s).
        lever = -model.normal[0, 2]
        constant = model.mu[0] * h_s / lever
        rate = model.mu[0] * model.tangent[0, 2] / lever + cone
        low, high = _half_line(constant, rate, low, high)
        # Contact k: lambda_Tk = -h_y - s, and row phi_M fixes lambda_Nk(s).
        lever = -model.normal[k, 1]
        constant = model.mu[k] * (h_m - model.tangent[k, 1] * h_y) / lever - cone * h_y
        rate = model.mu[k] * (model.tangent[0, 1] - model.tangent[k, 1]) / lever - cone
        low, high = _half_line(constant, rate, low, high)
    return low <= high


@jit
def _half_line(constant: float, rate: float, low: float, high: float) -> tuple[float, float]:
    """Intersect [low, high] with {s : constant + rate s >= 0}."""
    if rate > 0.0:
        return max(low, -constant / rate), high
    if rate < 0.0:
        return low, min(high, -constant / rate)
    return (low, high) if constant >= 0.0 else (math.inf, -math.inf)
