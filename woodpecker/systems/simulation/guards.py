"""How guards begin, and over which times they fall through zero.

Over a step guards are Taylor polynomials, of which Bernstein coefficients isolate the roots: so no
grazing is passed over. A guard of which the event that began the phase has made leading derivatives
zero is divided by that power of time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.polynomials import WHOLE, bernstein, first_fall, roots, scaled
from woodpecker.systems.mechanics.index_sets import SECTION, IndexSets, Touch
from woodpecker.systems.simulation.flows import Step

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


@lru_cache(maxsize=1024)
def beginning(sets: IndexSets, touch: Touch, on_section: bool) -> tuple[Ints, Floats]:
    """By which powers of time the guards of a phase are divided.

    Then a number above zero for those that fire at once where they are below zero.
    """
    section = SECTION * sets.m  # it may be negative: only as it falls does it fire
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
    """The guard that falls through zero first in a phase; -1 if none does before it ends.

    In which step follows: when that begins, the time from there on, and the step itself, or the
    last one. A guard that was above zero at the end of a step fires at once where the next begins
    below. Only steps that begin before ``until`` are looked at.
    """
    k, begin, time, last = -1, 0.0, 0.0, None
    for step in steps:
        begin += time
        if begin >= until:
            break
        k, time, fires = first_fall(
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
    """Minima of guards and of their negatives in a step that begins at a time, before another.

    Which guard, the sign that makes it a minimum, the least value with that sign, and when.
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
