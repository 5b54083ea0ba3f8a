"""How guards begin, and over which times they fall through zero.

Over a step guards are Taylor polynomials, of which Bernstein coefficients isolate the roots: so no
grazing is passed over. A guard of which the event that began the phase has made leading derivatives
zero is divided by that power of time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.polynomials import WHOLE, bernstein, fall, roots, scaled
from woodpecker.systems.mechanics.index_sets import SECTION, IndexSets, Touch

CHOPPED = 2.0**-52  # relative: coefficients that are smaller are rounding
BENT = 1e-4  # of a step: how far from an extreme its neighbours say whether it is a minimum


class GuardStart(NamedTuple):
    """How a guard begins of which an event has made some derivatives zero."""

    order: int  # how many, from the value on
    jet: Sequence[float]  # its derivatives as computed, those included; none if it is positive

    def noise(self, t: float) -> float:
        """What rounding has left of the derivatives that are zero."""
        return sum(self.jet[k] * t**k / math.factorial(k) for k in range(self.order))

    def root(self) -> float:
        """Time at which it comes back to zero, as its first two derivatives say; else infinite.

        It is negative where a guard that falls to zero would have begun before.
        """
        k = self.order
        if k == 0 or len(self.jet) <= k + 1 or not self.jet[k + 1] < 0.0:
            return math.inf
        return -(k + 1) * self.jet[k] / self.jet[k + 1]


class Polynomials:
    """All guards over a step, from their Taylor coefficients; each over a power of time.

    Parameters
    ----------
    length, guards
        Of the step: its length, and the coefficients (g, order + 1).
    begin
        The time of the phase at which it begins.
    orders
        By which powers of time guards are divided.
    before
        What :meth:`ends` has said of the step before: a guard that was above zero there fires at
        once where this step begins below.
    """

    def __init__(
        self, length: float, guards: Floats, begin: float, orders: Ints, before: Floats
    ) -> None:
        self._begin, self._length, self._orders, self._before = begin, length, orders, before
        self._c = scaled(guards, length, orders)
        self._b = self._c @ bernstein(guards.shape[1])[WHOLE]

    def ends(self) -> Floats:
        """(g,) their values where the step ends, each over what it has been divided by."""
        return np.asarray(self._b[:, -1])

    def falls(self, k: int) -> float:
        """The first time at which the k-th falls through zero; infinite if there is none."""
        at_once, size = bool(self._before[k] > 0.0), self._c.shape[1]
        return self._begin + self._length * fall(self._c[k], self._b[k], at_once, bernstein(size))

    def lowest(self, k: int, until: float, sign: float = 1.0) -> tuple[float, float]:
        """The k-th's least value at a minimum before a time, and when; of its negative if asked.

        Both are infinite if there is none.
        """
        slope, size = np.diff(self._b[k]), self._c.shape[1]
        best = math.inf, math.inf
        if np.abs(slope).max(initial=0.0) <= CHOPPED * np.abs(self._b[k]).max():
            return best
        for s in roots(self._c[k, 1:] * np.arange(1.0, size), slope, bernstein(size - 1)).tolist():
            t = self._begin + self._length * s
            around = np.polynomial.polynomial.polyval([s, s - BENT, s + BENT], self._c[k])
            value = sign * float(around[0]) * t ** int(self._orders[k])
            if t < until and sign * (around[1:].sum() - 2.0 * around[0]) > 0.0 and value < best[0]:
                best = value, t
        return best


@lru_cache(maxsize=1024)
def beginning(
    sets: IndexSets, touch: Touch, counts: bool, on_section: bool
) -> tuple[tuple[int, ...], Ints, Floats]:
    """The guards of a phase, with that of a section if it counts.

    By which powers of time they are divided follows; then a number above zero for those that fire
    at once where they are below zero.
    """
    orders = [touch.order(sets, guard) for guard in sets.places]
    fires = [0.0 if order else 1.0 for order in orders]
    if not counts:
        return tuple(sets.places), np.array(orders, dtype=np.int64), np.array(fires)
    guards = (*sets.places, SECTION * sets.m)  # it may be negative: only as it falls does it fire
    return guards, np.array([*orders, on_section], dtype=np.int64), np.array([*fires, 0.0])
