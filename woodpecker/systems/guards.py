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

from woodpecker.base.arrays import Floats
from woodpecker.systems.flows import Flow, Step
from woodpecker.systems.modes import SECTION, Local, Touch, guard_values, guards_of
from woodpecker.systems.sections import SectionGuard

NODES = 24  # of an interpolant: a Taylor step of order 20, and guards that are no polynomials
CHOPPED = 2.0**-52  # relative: coefficients that are smaller are rounding
REAL = 1e-9  # imaginary parts below are those of a double root
SHORT = 1e-3  # of a step: what follows the third derivative changes a time by 1e-12 of it
SOLVED = 4  # iterations of Newton's method for it, from where two derivatives place it
RESOLVED = 1e-9  # relative: last coefficients of a guard that is resolved
NOISE = 1e-12  # a guard that is no larger is zero all along, such as the slip of a block at rest
HALVINGS = 40  # of a window: as far as doubles tell times apart
WINDOW = 4.0  # times the time at which a guard comes back, as its first derivatives say

FLAT = 1e-24  # a polynomial that is no larger is zero all along
CLOSE = 2.0**-51  # relative: Newton's steps that are shorter have converged
SOLVING = 100  # steps of a bracketed Newton's method: bisection alone needs 53
AT_ONCE = 1e-6  # of a step: a guard that begins below zero but for rounding fires so near its start

_POINTS = np.cos(math.pi * (np.arange(NODES) + 0.5) / NODES)[::-1]  # ascending in (-1, 1)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_POINTS, NODES - 1))


Watched = Callable[[Floats], Floats]
"""Values (guards, b) of guards at many states (b, N)."""


@dataclass(frozen=True, slots=True, eq=False)
class GuardStart:
    """How a guard begins.

    Attributes
    ----------
    order
        How many derivatives, from the value on, are exactly zero.
    jet
        Its derivatives as computed, those included.
    is_section
        Whether it is that of a section, which may be negative: it fires only as it falls through
        zero.
    """

    order: int
    jet: Sequence[float] = ()
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
    """A guard over an interval of a phase, as a Chebyshev series.

    Attributes
    ----------
    low, high
        The interval, in time from the start of the phase.
    c
        The coefficients; of the guard over t**order.
    order
        As above; 0 unless the interval begins where the phase does.
    at_once
        Whether it fires where it begins at zero or below, and falls.
    """

    low: float
    high: float
    c: Floats
    order: int = 0
    at_once: bool = False

    def __call__(self, t: float) -> float:
        """Its value, divided."""
        return float(chebyshev.chebval(2.0 * (t - self.low) / (self.high - self.low) - 1.0, self.c))

    @property
    def is_positive(self) -> bool:
        """Whether the coefficients alone say that it has no root."""
        return bool(self.c[0] > np.abs(self.c[1:]).sum())

    def extremes(self, order: int | None = None) -> Floats:
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
        if self.is_positive or np.abs(self.c).max() <= NOISE**2:
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


@lru_cache(maxsize=8)
def _bernstein(size: int) -> Floats:
    """The matrix (size, size) by which power coefficients over [0, 1] become Bernstein's."""
    n = size - 1
    rows = [[math.comb(j, k) / math.comb(n, k) for j in range(size)] for k in range(size)]
    return np.array(rows)


@lru_cache(maxsize=8)
def _exponents(size: int) -> Floats:
    return np.arange(float(size))


@lru_cache(maxsize=8)
def _halving(size: int) -> tuple[Floats, Floats]:
    """The matrices that make of Bernstein coefficients those of either half."""
    left = np.array([[math.comb(j, k) / 2.0**j for j in range(size)] for k in range(size)])
    return left, left[::-1, ::-1].copy()


def _crossings(b: Floats) -> Iterator[tuple[float, float, float, bool]]:
    """Intervals of [0, 1] with one root each, ascending; a guess of it; and whether b falls there.

    Bernstein coefficients have no fewer changes of sign than the polynomial has roots. Where they
    still have several in the narrowest interval there is a double root, which is none.
    """
    left, right = _halving(len(b))
    open_ = [(0.0, 1.0, b, 0)]
    while open_:
        low, high, b, depth = open_.pop()
        above = b > 0.0
        changes = np.count_nonzero(above[1:] != above[:-1])
        if changes == 0:
            continue
        if changes == 1 or (depth == HALVINGS and above[0] != above[-1]):
            first, last = float(b[0]), float(b[-1])
            yield low, high, low + (high - low) * first / (first - last), bool(above[0])
        elif depth < HALVINGS:
            middle = 0.5 * (low + high)
            open_ += [(middle, high, b @ right, depth + 1), (low, middle, b @ left, depth + 1)]


def _solved(c: list[float], low: float, high: float, x: float, *, falls: bool) -> float:
    """The root of a polynomial, highest coefficient first, between two numbers; near a third."""
    for _ in range(SOLVING):
        value = slope = 0.0
        for each in c:
            slope = slope * x + value
            value = value * x + each
        if (value > 0.0) == falls:
            low = x
        else:
            high = x
        new = x - value / slope if slope != 0.0 else low
        if abs(new - x) <= CLOSE * abs(new):
            return new  # also where it has just left the bracket
        if not low < new < high:
            new = 0.5 * (low + high)
            if abs(new - x) <= CLOSE * abs(new):
                return new
        x = new
    return x


@dataclass(frozen=True, slots=True, eq=False)
class Power:
    """A guard over a step of a phase, as a power series in the time from its start.

    Attributes
    ----------
    low, high
        The step, in time from the start of the phase.
    c
        The coefficients in units of the step's length; of the guard over t**order.
    order
        As above; 0 unless the step begins where the phase does.
    b
        The same polynomial's Bernstein coefficients.
    at_once
        Whether it fires where it begins at zero or below, and falls.
    """

    low: float
    high: float
    c: Floats
    order: int
    b: Floats
    at_once: bool = False

    def __call__(self, t: float) -> float:
        """Its value, divided."""
        s = (t - self.low) / (self.high - self.low)
        return float(np.polynomial.polynomial.polyval(s, self.c))

    def extremes(self) -> Floats:
        """Times inside at which its slope vanishes; ascending."""
        slope = np.diff(self.b)
        if np.abs(slope).max(initial=0.0) <= CHOPPED * np.abs(self.b).max():
            return np.empty(0)
        c = (self.c[1:] * np.arange(1, len(self.c)))[::-1].tolist()
        roots = [_solved(c, *each, falls=falls) for *each, falls in _crossings(slope)]
        return self.low + np.array(roots) * (self.high - self.low)

    def falls(self) -> float:
        """The first time at which it falls through zero; infinite if there is none."""
        size = float(np.abs(self.b).max())
        if size <= FLAT:
            return math.inf
        length, first = self.high - self.low, float(self.c[1])
        if self.at_once and self.c[0] <= 0.0 and first < 0.0:
            s = -float(self.c[0]) / first
            return self.low + (s if abs(s) < AT_ONCE else 0.0) * length
        for *each, falls in _crossings(self.b):
            if falls:
                return self.low + length * _solved(self.c[::-1].tolist(), *each, falls=True)
        return math.inf


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

    Attributes
    ----------
    lowest
        (g,) lower bounds of the guards.
    """

    def __init__(
        self, length: float, guards: Floats, begin: float, starts: Sequence[GuardStart],
        before: Floats | None = None,
    ) -> None:  # fmt: skip
        self._begin, self._end, self._starts, self._before = begin, begin + length, starts, before
        size = guards.shape[1]
        scales = length ** _exponents(size)
        self._c = guards * scales
        for k, start in enumerate(starts):
            if begin == 0.0 and start.order:
                self._c[k, : -start.order] = guards[k, start.order :] * scales[: -start.order]
                self._c[k, -start.order :] = 0.0
        self._b = self._c @ _bernstein(size)
        self.lowest: list[float] = self._b.min(axis=1).tolist()

    def __len__(self) -> int:
        return len(self._starts)

    def __iter__(self) -> Iterator[Power]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Power:
        start, begins = self._starts[k], self._begin == 0.0
        fires = begins and start.order == 0 and not start.is_section
        fires = fires or (self._before is not None and bool(self._before[k] > 0.0))
        order = start.order if begins else 0
        return Power(self._begin, self._end, self._c[k], order, self._b[k], fires)

    def ends(self) -> Floats:
        """(g,) their values where the step ends, each over what it has been divided by."""
        return self._b[:, -1]


# --- A phase --------------------------------------------------------------------------------------

TIME = -2  # the guard of a phase that lasts to the end of time asked for


class Phase:
    """The guards of a phase, and which fires first.

    Parameters
    ----------
    here
        Its mode and the state in which it begins.
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
    width
        Of the interpolant by which the last root was found; 0 where that is as exact as doubles.
    """

    def __init__(
        self, here: Local, flow: Flow, touch: Touch, section: SectionGuard | None, *,
        on_section: bool,
    ) -> None:  # fmt: skip
        eq, mode = here.eq, here.mode
        self.mode, self.flow, self.width = mode, flow, 0.0
        self._eq, self._p, self._section = eq, here.p, section
        self.watched = guards_of(eq, mode)
        self._guards = list(self.watched)
        if self.flow.has_guards:
            self.starts = [GuardStart(touch.order(eq, mode, guard)) for guard in self.watched]
        else:
            self.starts = [started(here, touch, guard) for guard in self.watched]
        if self._section is not None:
            self.watched.append(SECTION * eq.m)
            jet = self._section.jet(here) if on_section else ()
            self.starts.append(GuardStart(int(on_section), jet, True))
        self._before: Floats | None = None

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
        best, time = TIME, math.inf
        found = Polynomials(step.length, step.guards, begin, self.starts, self._before)
        for k, (guard, low) in enumerate(zip(self.watched, found.lowest, strict=True)):
            if low <= 0.0 and guard not in ignored:
                t = found[k].falls()
                if t < time:
                    best, time = guard, t
        self._before = found.ends()
        return best, time

    def _values(self, states: Floats) -> Floats:
        values = guard_values(self._eq, self.mode, self._guards, self._eq.terms(states, self._p))
        if self._section is None:
            return values
        return np.vstack([values, self._section.values(states, self._p)])


def started(here: Local, touch: Touch, guard: int) -> GuardStart:
    """How a guard begins, where an event has made some of its derivatives zero."""
    order = touch.order(here.eq, here.mode, guard)
    return GuardStart(order, here.jet(guard) if order else ())
