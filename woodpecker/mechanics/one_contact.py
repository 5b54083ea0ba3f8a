"""Impacts of any system, compiled: data of the contact problem, and its solution for one contact.

The data are the velocities at c contacts without impulses, normal ones first, and the matrix
W M^-1 W^T that maps impulses to changes of velocities [Pfeiffer1996, ch. 8].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit, part
from woodpecker.mechanics.cases import BACKWARD, EXACT, FORWARD, FREE, HOLD, REST, SAME, SLACK

SOLVED, NO_SOLUTION, AMBIGUOUS = range(3)


@jit
def stated(
    mass: Floats, w_n: Floats, w_t: Floats, rates: Floats, slips: Floats, mu: Floats, eps: Floats,
    contacts: Ints, still: Ints,
) -> tuple[Floats, Floats, Floats, Floats, Floats]:  # fmt: skip
    """Data of an impact at c of m contacts: W M^-1 W^T, M^-1 W^T (n, 2c), velocities, mu, eps (c,).

    They are made of mass (n, n), directions w_n and w_t (m, n), gap rates, slips, mu and eps (m,);
    ``still`` (2c,) is nonzero where a velocity is exactly zero, whatever rounding says.
    """
    n, c = len(mass), len(contacts)
    w, free, both = np.empty((2 * c, n)), np.zeros(2 * c), np.empty((2, c))
    for k in range(c):
        i = contacts[k]
        w[k], w[c + k] = w_n[i], w_t[i]
        if not still[k]:
            free[k] = rates[i]
        if not still[c + k]:
            free[c + k] = slips[i]
        both[0, k], both[1, k] = mu[i], eps[i]
    response: Any = np.linalg.solve(mass, w.T.copy())
    return w @ response, response, free, both[0], both[1]


@jit
def given(
    delassus: Floats, response: Floats, free: Floats, u: Floats, impulse: Floats, feeds: Floats,
    contacts: Ints, into: Floats,
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Velocities (n,), those at contacts (2c,), and floors of the expansion (c,), after an impulse.

    delassus, response and free are those of :func:`stated`. The floors are ``feeds`` times the
    normal impulses, which come first. The impulses are written ``into`` (2, m).
    """
    c = len(contacts)
    floor = np.empty(c)
    for k in range(c):
        into[0, contacts[k]], into[1, contacts[k]] = impulse[k], impulse[c + k]
        floor[k] = feeds[k] * max(impulse[k], 0.0)  # rounding may have left it below zero
    return u + response @ impulse, free + delassus @ impulse, floor


@jit
def one_contact(
    delassus: Floats, free: Floats, mu: float, floor: float, rubs: bool
) -> tuple[int, int, float, float]:
    """Outcome, case and impulses (N, T) at one contact; delassus (2, 2), free (2,) from `stated`.

    If several cases hold with the same velocities, the first one that is exact up to rounding
    counts (rest before free, stick before slide), else the one with the least violation.
    """
    kept, count = np.empty((6, 6)), 0
    for normal in (REST, FREE):
        for tangential in (HOLD, FORWARD, BACKWARD):
            if rubs or tangential == FORWARD:
                found = _tried(delassus, free, mu, floor, normal, tangential)
                worst = _violation(delassus, free, mu, floor, normal, tangential, found, rubs)
                if worst <= SLACK:
                    kept[count, 0], kept[count, 1] = worst, 3 * normal + tangential
                    for k in range(4):
                        kept[count, 2 + k] = found[k]
                    count += 1
    if count == 0:
        return NO_SOLUTION, 0, 0.0, 0.0
    best = 0
    for k in range(1, count):
        if kept[best, 0] > EXACT and kept[k, 0] < kept[best, 0]:
            best = k
    most = max(abs(kept[best, 2]), abs(kept[best, 3]))
    for k in range(1 + rubs):
        size = abs(free[k]) + (abs(delassus[k, 0]) + abs(delassus[k, 1])) * most
        for other in range(count):
            if abs(kept[other, 4 + k] - kept[best, 4 + k]) > SAME * size:
                return AMBIGUOUS, 0, 0.0, 0.0
    return SOLVED, int(kept[best, 1]), float(kept[best, 2]), float(kept[best, 3])


@part
def _tried(
    delassus: Floats, free: Floats, mu: float, floor: float, normal: int, tangential: int
) -> tuple[float, float, float, float]:
    """Impulses and velocities in a case, normal ones first; nan if its equations are singular."""
    # They are if both directions are parallel, or if friction jams the contact (a pivot of 0).
    g_nn, g_nt = float(delassus[0, 0]), float(delassus[0, 1])
    g_tn, g_tt = float(delassus[1, 0]), float(delassus[1, 1])
    f_n, f_t = float(free[0]), float(free[1])
    sign = -1.0 if tangential == FORWARD else 1.0
    p_n = floor
    if normal == REST and tangential == HOLD:
        det = g_nn * g_tt - g_nt * g_tn
        if det <= SLACK * g_nn * g_tt:
            return np.nan, np.nan, np.nan, np.nan
        p_n, p_t = (g_nt * f_t - g_tt * f_n) / det, (g_tn * f_n - g_nn * f_t) / det
    elif tangential == HOLD:
        p_t = -(f_t + g_tn * floor) / g_tt
    else:
        if normal == REST:
            pivot = g_nn + sign * mu * g_nt
            if abs(pivot) <= SLACK * g_nn:
                return np.nan, np.nan, np.nan, np.nan
            p_n = -f_n / pivot
        p_t = sign * mu * p_n
    v_n = 0.0 if normal == REST else f_n + g_nn * p_n + g_nt * p_t
    v_t = 0.0 if tangential == HOLD else f_t + g_tn * p_n + g_tt * p_t
    return p_n, p_t, v_n, v_t


@part
def _violation(
    delassus: Floats, free: Floats, mu: float, floor: float, normal: int, tangential: int,
    found: tuple[float, float, float, float], rubs: bool,
) -> float:  # fmt: skip
    """Largest violation of the inequalities of a case, relative to the terms that were rounded."""
    p_n, p_t, v_n, v_t = found
    most = max(abs(p_n), abs(p_t))
    if normal == REST:
        worst = _relative(floor - p_n, max(most, floor))
    else:
        size = abs(free[0]) + (abs(delassus[0, 0]) + abs(delassus[0, 1])) * most
        worst = _relative(-v_n, size)
    if rubs:
        sign = -1.0 if tangential == FORWARD else 1.0
        size = abs(free[1]) + (abs(delassus[1, 0]) + abs(delassus[1, 1])) * most
        if tangential == HOLD:
            worst = max(worst, _relative(abs(p_t) - mu * p_n, most))
        else:
            worst = max(worst, _relative(sign * v_t, size))
    return worst


@part
def _relative(excess: float, size: float) -> float:
    """A positive excess relative to a size, else 0; inf for nan."""
    if excess <= 0.0:
        return 0.0
    return excess / size if excess > 0.0 else np.inf
