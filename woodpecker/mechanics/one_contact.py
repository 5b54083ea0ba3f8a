"""Impacts of any system, compiled: data of the contact problem, and its solution for one contact.

The data are velocities at c contacts without impulses, normal ones first, and the matrix W M^-1 W^T
that maps impulses to velocities [Pfeiffer1996, ch. 8].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics import contact_problems
from woodpecker.mechanics.contact_problems import NO_SOLUTION as NO_SOLUTION
from woodpecker.mechanics.contact_problems import SOLVED as SOLVED


@jit
def stated(
    mass: Floats, w_n: Floats, w_t: Floats, rates: Floats, slips: Floats, mu: Floats, eps: Floats,
    contacts: Ints, still: Ints,
) -> tuple[Floats, Floats, Floats, Floats, Floats]:  # fmt: skip
    """Data of an impact at c of m contacts: W M^-1 W^T, M^-1 W^T (n, 2c), velocities, mu, eps (c,).

    From mass (n, n), directions w_n and w_t (m, n), rates, slips, mu and eps (m,); ``still`` (2c,)
    is nonzero where a velocity is exactly zero.
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
    """Velocities (n,) and (2c,) at contacts after impulses (2c,), and floors of expansion (c,).

    delassus, response and free are those of :func:`stated`. Floors are the part ``feeds`` of the
    normal impulses, which come first. The impulses are entered ``into`` (2, m).
    """
    c = len(contacts)
    floor = np.empty(c)
    for k in range(c):
        into[0, contacts[k]], into[1, contacts[k]] = impulse[k], impulse[c + k]
        floor[k] = feeds[k] * max(impulse[k], 0.0)  # rounding may have left it below
    return u + response @ impulse, free + delassus @ impulse, floor


@jit
def one_contact(
    delassus: Floats, free: Floats, mu: float, floor: float, rubs: bool
) -> tuple[int, int, float, float]:
    """Outcome, case and impulses (N, T) at one contact; delassus (2, 2), free (2,) from `stated`.

    A contact without friction is one that slides forward.
    """
    g_nn, free_n = float(delassus[0, 0]), float(free[0])
    if not rubs:
        return contact_problems.one_contact(g_nn, 0.0, 1.0, free_n, 1.0, 0.0, floor)
    g_nt, g_tt, free_t = float(delassus[0, 1]), float(delassus[1, 1]), float(free[1])
    return contact_problems.one_contact(g_nn, g_nt, g_tt, free_n, free_t, mu, floor)
