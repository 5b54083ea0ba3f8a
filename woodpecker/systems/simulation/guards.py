"""How guards begin, and when they fall through zero.

Over a step guards are polynomials, whose roots Bernstein coefficients isolate, so that no grazing
is missed. A guard with leading derivatives that the event at the start of the phase has made zero
is deflated: divided by that power of time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.polynomials import WHOLE, bernstein, first_series_to_cross, roots, scaled
from woodpecker.systems.mechanics.index_sets import SECTION, ContactState, IndexSets
from woodpecker.systems.simulation.flows import Step

CHOPPED = 2.0**-52  # relative: smaller coefficients are rounding
BENT = 1e-4  # of a step: distance from an extremum at which values say whether it is a minimum


class GuardStart(NamedTuple):
    """The start of a guard, of which an event may have made the first derivatives zero."""

    order: int  # how many are zero, the value included
    jet: Sequence[float]  # its derivatives as computed, these included; empty if none is zero

    def noise(self, t: float) -> float:
        """The part of the guard at t that is rounding of derivatives that are zero."""
        return sum(self.jet[k] * t**k / math.factorial(k) for k in range(self.order))

    def root(self) -> float:
        """Time of the next zero, by the first two derivatives that are not zero; inf if none.

        It is negative if the guard falls from the start, and would have been positive before.
        """
        k = self.order
        if k == 0 or len(self.jet) <= k + 1 or not self.jet[k + 1] < 0.0:
            return math.inf
        return -(k + 1) * self.jet[k] / self.jet[k + 1]


@lru_cache(maxsize=1024)
def beginning(sets: IndexSets, touch: ContactState, on_section: bool) -> tuple[Ints, Floats]:
    """Powers of time by which the guards of a phase are divided, and which may fire at once.

    These have a number above zero: they fire at the start if they are below zero there.
    """
    section = SECTION * sets.m  # it may be negative, and fires only where it falls
    orders = [
        int(on_section) if guard == section else touch.order(sets, guard) for guard in sets.places
    ]
    fires = [
        float(not order and guard != section)
        for guard, order in zip(sets.places, orders, strict=True)
    ]
    return np.array(orders, dtype=np.int64), np.array(fires)


def first_of(
    steps: Iterable[Step], orders: Ints, fires: Floats, skipped: Ints, until: float = math.inf
) -> tuple[int, float, float, Step | None]:
    """Find the guard that falls through zero first in a phase; -1 if none does before it ends.

    Returns the guard, the time at which its step begins, the time in the step, and the step, or the
    last one. A guard that is above zero at the end of a step, and below it at the start of the
    next, fires there. Only steps that begin before ``until`` are taken.
    """
    k, begin, time, last = -1, 0.0, 0.0, None
    for step in steps:
        begin += time
        if begin >= until:
            break
        k, time, fires = first_series_to_cross(
            step.guards, step.length, orders, fires, skipped, bernstein(step.guards.shape[1])
        )
        last, orders = step, 0 * orders
        if k >= 0:
            break
        time = step.length
    return k, begin, time, last


def extremes(
    step: Step, orders: Ints, begin: float, until: float
) -> Iterator[tuple[int, float, float, float]]:
    """Minima of guards, and of their negatives, in a step that begins at a time, up to another.

    Yields the guard, the sign that makes it a minimum, the value with that sign, and the time.
    """
    c, size = scaled(step.guards, step.length, orders), step.guards.shape[1]
    b = c @ bernstein(size)[WHOLE]
    for k, slope in enumerate(np.diff(b)):
        if np.abs(slope).max(initial=0.0) <= CHOPPED * np.abs(b[k]).max():
            continue
        for s in roots(c[k, 1:] * np.arange(1.0, size), slope, bernstein(size - 1)).tolist():
            t = begin + step.length * s
            value, *beside = np.polynomial.polynomial.polyval([s, s - BENT, s + BENT], c[k])
            sign = float(np.sign(sum(beside) - 2.0 * value))
            if t < until and sign:
                yield k, sign, sign * float(value) * t ** int(orders[k]), t
