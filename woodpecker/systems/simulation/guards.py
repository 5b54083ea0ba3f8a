"""How guards begin, and over which times they fall through zero.

Over a step guards are Taylor polynomials, of which Bernstein coefficients isolate the roots: so no
grazing is passed over. A guard of which the event that began the phase has made leading derivatives
zero is divided by that power of time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.polynomials import WHOLE, bernstein, fall, roots, scaled
from woodpecker.systems.mechanics.modes import SECTION, Local, Mode, guards_in, guards_of
from woodpecker.systems.mechanics.settling import Touch

CHOPPED = 2.0**-52  # relative: coefficients that are smaller are rounding
BENT = 1e-4  # of a step: how far from an extreme its neighbours say whether it is a minimum


@dataclass(frozen=True, slots=True, eq=False)
class GuardStart:
    """How a guard begins."""

    order: int  # how many derivatives, from the value on, are exactly zero
    jet: Sequence[float] = ()  # its derivatives as computed, those included
    # whether it is that of a section, which may be negative: it fires only as it falls through zero
    is_section: bool = False

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
    starts
        How the guards begin where that is zero.
    before
        What :meth:`ends` has said of the step before: a guard that was above zero there fires at
        once where this step begins below.
    """

    def __init__(
        self, length: float, guards: Floats, begin: float, starts: Sequence[GuardStart],
        before: Floats | None = None,
    ) -> None:  # fmt: skip
        self._begin, self._length = begin, length
        self._orders, fires = divisors(starts)
        if begin != 0.0:
            self._orders = np.zeros_like(self._orders)
        self._before = fires if before is None else before
        self._c = scaled(guards, length, self._orders)
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


def divisors(starts: Sequence[GuardStart]) -> tuple[Ints, Floats]:
    """By which powers of time guards are divided; above zero for those that may fire at once.

    They do if they are below zero where the phase begins.
    """
    orders = np.array([each.order for each in starts], dtype=np.int64)
    fires = [0.0 if each.order or each.is_section else 1.0 for each in starts]
    return orders, np.array(fires)


@lru_cache(maxsize=1024)
def beginning(
    mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...], touch: Touch, counts: bool,
    on_section: bool,
) -> tuple[tuple[int, ...], Ints, Floats]:  # fmt: skip
    """The guards of a phase, with that of a section if it counts, and their divisors."""
    guards = guards_in(mode, rubs, slips)
    starts = [GuardStart(touch.order(slips, mode, guard)) for guard in guards]
    if counts:
        guards = (*guards, SECTION * len(mode))
        starts.append(GuardStart(int(on_section), (), True))
    return guards, *divisors(starts)


def starts_of(here: Local, touch: Touch, *, on_section: bool) -> dict[int, GuardStart]:
    """How all guards of a phase begin, where an event has made some of their derivatives zero."""
    found = dict[int, GuardStart]()
    for guard in guards_of(here.eq, here.mode):
        order = touch.order(here.eq.slips, here.mode, guard)
        found[guard] = GuardStart(order, here.jet(guard) if order else ())
    if here.section is not None:
        guard = SECTION * here.eq.m
        jet = here.jet(guard, 1) if on_section else ()
        found[guard] = GuardStart(int(on_section), jet, True)
    return found
