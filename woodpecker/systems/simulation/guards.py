"""The first guard that fires in a phase, and the least values of those that do not.

Over a step guards are Taylor polynomials, of which Bernstein coefficients isolate the roots; or
Chebyshev interpolants, which are monotone between their extremes. So the first root is bracketed
and no grazing is passed over. A guard of which the event that began the phase has made leading
derivatives zero is divided by that power of time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.polynomials import HALVINGS, WHOLE, bernstein, fall, first_fall, roots, scaled
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.modes import (
    SECTION,
    Local,
    Mode,
    SectionGuard,
    Touch,
    guard_values,
    guards_in,
    guards_of,
)
from woodpecker.systems.simulation.flows import Flow, Step

NODES = 24  # of an interpolant: a Taylor step of order 20, and guards that are no polynomials
CHOPPED = 2.0**-52  # relative: coefficients that are smaller are rounding
REAL = 1e-9  # imaginary parts below are those of a double root
SHORT = 1e-3  # of a step: what follows the third derivative changes a time by 1e-12 of it
SOLVED = 4  # iterations of Newton's method for it, from where two derivatives place it
RESOLVED = 1e-9  # relative: last coefficients of a guard that is resolved
NOISE = 1e-12  # a guard that is no larger is zero all along, such as the slip of a block at rest
WINDOW = 4.0  # times the time at which a guard comes back, as its first derivatives say

_POINTS = np.cos(math.pi * (np.arange(NODES) + 0.5) / NODES)[::-1]  # ascending in (-1, 1)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_POINTS, NODES - 1))


Watched = Callable[[Floats], Floats]
"""Values (guards, b) of guards at many states (b, N)."""


@dataclass(frozen=True, slots=True, eq=False)
class GuardStart:
    """How a guard begins."""

    order: int  # how many derivatives, from the value on, are exactly zero
    jet: Sequence[float] = ()  # its derivatives as computed, those included
    # whether it is that of a section, which may be negative: it fires only as it falls through zero
    is_section: bool = False

    def noise(self, t: Floats) -> Floats:
        """What rounding has left of the derivatives that are zero."""
        found = np.zeros_like(t)
        for k in range(self.order):
            found += self.jet[k] * t**k / math.factorial(k)
        return found

    def comes_back(self) -> float:
        """Time at which it comes back to zero, as its first two derivatives say; else infinite."""
        t = self.root()
        return t if t > 0.0 else math.inf

    def root(self) -> float:
        """The same; negative where a guard that falls to zero would have begun before."""
        k = self.order
        if k == 0 or len(self.jet) <= k + 1 or not self.jet[k + 1] < 0.0:
            return math.inf
        return -(k + 1) * self.jet[k] / self.jet[k + 1]

    def soon(self, length: float, *, early: bool = False) -> float:
        """That time by all known derivatives, if it is short in a step of a length; else infinite.

        In so short a time the guard stays below the rounding of what it is computed from. Early
        ones are negative: a path goes on beyond where a phase has vanished.
        """
        t, k = self.root(), self.order
        if (t < 0.0 and not early) or not WINDOW * abs(t) <= SHORT * length:
            return math.inf
        if len(self.jet) < k + 3 and t > 0.0:
            return math.inf
        c = [value / math.factorial(k + j) for j, value in enumerate(self.jet[k:])]
        for _ in range(SOLVED):
            value = sum(a * t**j for j, a in enumerate(c))
            slope = sum(j * a * t ** (j - 1) for j, a in enumerate(c) if j)
            if slope == 0.0:
                return math.inf
            t -= value / slope
        return t if early or t > 0.0 else math.inf


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """A guard over an interval of a phase, as a Chebyshev series."""

    # the interval, in time from the start of the phase
    low: float
    high: float
    c: Floats  # the coefficients; of the guard over t**order
    order: int = 0  # as above; 0 unless the interval begins where the phase does
    at_once: bool = False  # whether it fires where it begins at zero or below, and falls

    def __call__(self, t: float) -> float:
        """Its value, divided."""
        return float(chebyshev.chebval(2.0 * (t - self.low) / (self.high - self.low) - 1.0, self.c))

    def extremes(self) -> Floats:
        """Times inside at which its slope vanishes; ascending."""
        c = self.c
        size = np.abs(c).max(initial=0.0)
        kept = np.flatnonzero(np.abs(c) > CHOPPED * size)
        if not kept.size or kept[-1] < 2:
            return np.empty(0)
        roots = chebyshev.chebroots(chebyshev.chebder(c[: kept[-1] + 1]))
        inside = np.sort(roots.real[(np.abs(roots.imag) < REAL) & (np.abs(roots.real) < 1.0)])
        return np.asarray(self.low + 0.5 * (inside + 1.0) * (self.high - self.low))

    def falls(self) -> float:
        """The first time at which it falls through zero; infinite if there is none."""
        is_positive = self.c[0] > np.abs(self.c[1:]).sum()  # the coefficients alone say so
        if is_positive or np.abs(self.c).max() <= NOISE**2:
            return math.inf
        times = [self.low, *self.extremes().tolist(), self.high]
        values = [self(t) for t in times]
        if self.at_once and values[0] <= 0.0 and values[1] < values[0]:
            return 0.0
        for t, value, after, next_value in zip(times, values, times[1:], values[1:], strict=False):
            if value > 0.0 >= next_value:
                if next_value == 0.0:
                    return float(after)
                return float(brentq(self, t, after, xtol=1e-300, rtol=8.9e-16))
        return math.inf


def series(
    step: Step, begin: float, watch: Watched, starts: Sequence[GuardStart]
) -> Iterator[list[Series]]:
    """Series of all guards over the windows of a step that begins at a time of the phase.

    A window in which a guard is not resolved is halved: the motion may be smoother than they are.
    """
    bounces = [each.comes_back() for each in starts if each.order == 1]
    soon = WINDOW * min(bounces, default=math.inf)
    left = [(0.0, step.length, 0)]
    if begin == 0.0 and 0.0 < soon < step.length:
        left = [(soon, step.length, 0), (0.0, soon, 0)]
    while left:
        low, high, depth = left.pop()
        first = begin == 0.0 == low
        times = low + 0.5 * (_POINTS + 1.0) * (high - low)
        values = watch(step.states(times))
        if depth < HALVINGS and not _are_resolved(values):
            middle = 0.5 * (low + high)
            left += [(middle, high, depth + 1), (low, middle, depth + 1)]
            continue
        yield [
            _series(value, start, times, (begin + low, begin + high), first=first)
            for value, start in zip(values, starts, strict=True)
        ]


def _are_resolved(values: Floats) -> bool:
    """Whether the last coefficients of all guards are small, or rounding."""
    c = np.abs(values @ _TO_SERIES.T)
    size = np.maximum(RESOLVED * c.max(axis=1, initial=0.0), NOISE)
    return bool((c[:, -3:].max(axis=1, initial=0.0) <= size).all())


def _series(
    value: Floats, start: GuardStart, times: Floats, window: tuple[float, float], *, first: bool
) -> Series:
    order = start.order if first else 0
    row = (value - start.noise(times)) / times**order if order else value
    at_once = first and order == 0 and not start.is_section
    return Series(*window, _TO_SERIES @ row, order, at_once)


@dataclass(slots=True, eq=False)
class Least:
    """The least values of guards at minima inside of a phase, as they come."""

    value: dict[int, float] = field(default_factory=dict)
    time: dict[int, float] = field(default_factory=dict)

    def add(self, key: int, one: Series | Power, until: float, *, lowest: bool = True) -> None:
        """Note the least minimum of a guard before a time; or the highest maximum."""
        sign = 1.0 if lowest else -1.0
        times = [t for t in one.extremes().tolist() if t < until]
        for t in times:
            value = sign * one(t) * t**one.order
            width = 1e-4 * (one.high - one.low)
            bends = sign * (one(t + width) + one(t - width) - 2.0 * one(t))
            if bends > 0.0 and value < self.value.get(key, math.inf):
                self.value[key], self.time[key] = value, t


# --- Taylor polynomials ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Power:
    """A guard over a step of a phase, as a power series in the time from its start."""

    # the step, in time from the start of the phase
    low: float
    high: float
    c: Floats  # the coefficients in units of the step's length; of the guard over t**order
    order: int  # as above; 0 unless the step begins where the phase does
    b: Floats  # the same polynomial's Bernstein coefficients
    at_once: bool = False  # whether it fires where it begins at zero or below, and falls

    def __call__(self, t: float) -> float:
        """Its value, divided."""
        s = (t - self.low) / (self.high - self.low)
        return float(np.polynomial.polynomial.polyval(s, self.c))

    def extremes(self) -> Floats:
        """Times inside at which its slope vanishes; ascending."""
        slope, size = np.diff(self.b), len(self.c)
        if np.abs(slope).max(initial=0.0) <= CHOPPED * np.abs(self.b).max():
            return np.empty(0)
        found = roots(self.c[1:] * np.arange(1.0, size), slope, bernstein(size - 1))
        return np.asarray(self.low + found * (self.high - self.low))

    def falls(self) -> float:
        """The first time at which it falls through zero; infinite if there is none."""
        s = fall(self.c, self.b, self.at_once, bernstein(len(self.c)))
        return self.low + s * (self.high - self.low)


class Polynomials:
    """All guards over a step, from their Taylor coefficients.

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
        self._begin, self._end = begin, begin + length
        self._orders = _orders(starts) if begin == 0.0 else _none(len(starts))
        self._before = _before(starts) if before is None else before
        self._c = scaled(guards, length, self._orders)
        self._b = self._c @ bernstein(guards.shape[1])[WHOLE]

    def __len__(self) -> int:
        return len(self._orders)

    def __iter__(self) -> Iterator[Power]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Power:
        order, fires = int(self._orders[k]), bool(self._before[k] > 0.0)
        return Power(self._begin, self._end, self._c[k], order, self._b[k], fires)

    def ends(self) -> Floats:
        """(g,) their values where the step ends, each over what it has been divided by."""
        return np.asarray(self._b[:, -1])


@lru_cache(maxsize=64)
def _none(count: int) -> Ints:
    return np.zeros(count, dtype=np.int64)


def _orders(starts: Sequence[GuardStart]) -> Ints:
    return np.array([each.order for each in starts], dtype=np.int64)


def _before(starts: Sequence[GuardStart]) -> Floats:
    """Above zero for guards that fire at once where a phase begins if they are below zero there."""
    return np.array([0.0 if each.order or each.is_section else 1.0 for each in starts])


# --- A phase --------------------------------------------------------------------------------------

TIME = -2  # the guard of a phase that lasts to the end of time asked for


class Phase:
    """The guards of a phase, and which fires first.

    Parameters
    ----------
    eq, mode, p
        The equations, the mode, and the values of all parameters.
    z
        The state in which it begins.
    flow
        What integrates it.
    touch
        What touches there.
    section
        The guard of a section that counts in this mode; None: none does.
    on_section
        Whether it begins on the section.

    Attributes
    ----------
    watched, starts
        The guards, and how they begin.
    section
        As above.
    width
        Of the interpolant by which the last root was found; 0 where that is as exact as doubles.
    """

    def __init__(
        self, eq: Equations, mode: Mode, z: Floats, p: Floats, flow: Flow, touch: Touch,
        section: SectionGuard | None, *, on_section: bool,
    ) -> None:  # fmt: skip
        self.mode, self.flow, self.section, self.width = mode, flow, section, 0.0
        self.starts: list[GuardStart] = []
        if flow.has_guards:
            key = mode, eq.friction, eq.slips, touch, section is not None, on_section
            self.watched, self._orders, self._before = _begun(*key)
            return
        here = Local(eq, mode, z, p, section)
        starts = starts_of(here, touch, on_section=on_section)
        self.watched, self.starts = tuple(starts), list(starts.values())
        self._values = watching(here)

    def fired(self, step: Step, begin: float, ignored: Set[int]) -> tuple[int, float]:
        """The guard that fires first in a step that begins at a time, and when; TIME if none."""
        if self.flow.has_guards:
            return self._of_polynomials(step, begin, ignored)
        for window in series(step, begin, self._values, self.starts):
            best, time, self.width = TIME, math.inf, 0.0
            for guard, start, each in zip(self.watched, self.starts, window, strict=True):
                if guard in ignored:
                    continue
                early = start.soon(step.length) if begin == 0.0 else math.inf
                t = early if early < math.inf else each.falls()
                if t < time:
                    best, time = guard, t
                    self.width = 0.0 if early < math.inf else each.high - each.low
            if best != TIME:
                return best, time
        return TIME, math.inf

    def _of_polynomials(self, step: Step, begin: float, ignored: Set[int]) -> tuple[int, float]:
        orders = self._orders if begin == 0.0 else _none(len(self._orders))
        skipped = _none(len(orders))
        if ignored:
            skipped = np.array([int(guard in ignored) for guard in self.watched])
        k, time, self._before = first_fall(
            step.guards, step.length, orders, self._before, skipped, bernstein(step.guards.shape[1])
        )
        return (TIME, math.inf) if k < 0 else (self.watched[k], begin + time)


@lru_cache(maxsize=1024)
def _begun(
    mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...], touch: Touch, counts: bool,
    on_section: bool,
) -> tuple[tuple[int, ...], Ints, Floats]:  # fmt: skip
    """The guards of a phase, and how they begin: as :func:`first_fall` takes it."""
    guards = guards_in(mode, rubs, slips)
    starts = [GuardStart(touch.order(slips, mode, guard)) for guard in guards]
    if counts:
        guards = (*guards, SECTION * len(mode))
        starts.append(GuardStart(int(on_section), (), True))
    return guards, _orders(starts), _before(starts)


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


def watching(here: Local) -> Watched:
    """All guards of a phase as a function of many states."""
    own = guards_of(here.eq, here.mode)

    def values(states: Floats) -> Floats:
        found = guard_values(here.eq, here.mode, own, here.eq.terms(states, here.p))
        if here.section is None:
            return found
        return np.vstack([found, here.section.values(states, here.p)])

    return values
