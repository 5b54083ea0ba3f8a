"""Impacts of any system, compiled: the data of contact problems, and the solution of the smallest.

The data are the velocities at c contacts without impulses, normal ones first, and the matrix
W M^-1 W^T that maps impulses to changes of velocities [Pfeiffer1996, ch. 8].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics.contact_problems import one_contact


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
def alone(
    delassus: Floats, free: Floats, mu: float, floor: float, rubs: bool
) -> tuple[int, int, float, float]:
    """The contact problem of one contact; one that does not rub has no tangential velocity."""
    t = 1.0 if rubs else 0.0
    return one_contact(
        delassus[0, 0], t * delassus[0, 1], t * delassus[1, 1], free[0], t * free[1], mu, floor
    )
