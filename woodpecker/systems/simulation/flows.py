"""The motion within one mode, step by step: the form of both backends, and scipy's DOP853."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import DOP853

from woodpecker.base.arrays import Floats
from woodpecker.base.polynomials import HALVINGS
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.impacts import total
from woodpecker.systems.mechanics.index_sets import GAP, KNOWN, SLIP, Mode
from woodpecker.systems.mechanics.modes import Local, balance, guard_values
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

RELATIVE, ABSOLUTE = 1e-13, 1e-16  # tolerances of DOP853, near what its step control can resolve
STEPS_MOST = 20_000  # of one phase
KEPT_MOST = 2000  # of a phase: far away, where Newton's method may look, a motion has millions
NODES = 8  # of a guard over a step: as many as the dense output has coefficients
LARGE = 2.0**512  # larger numbers have no square, and their series soon no coefficients
ROUNDED = 2.0**20  # units in the last place of time: over shorter steps guards are not smooth
SIZE = NODES + max(KNOWN.values()) + 1  # of the power series of a guard, with its known derivatives
RESOLVED = 1e-9  # relative: the last coefficients of a guard that is resolved
# Of its terms: a guard that is nowhere larger is zero, such as the slip of a block at rest.
NOISE = 1e-12

_ANGLES = math.pi * (np.arange(NODES) + 0.5) / NODES
_POINTS = 0.5 - 0.5 * np.cos(_ANGLES)  # Chebyshev's, ascending in (0, 1)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(2.0 * _POINTS - 1.0, NODES - 1))
_TO_POWERS = np.linalg.inv(np.vander(_POINTS, increasing=True))
_NONE: Floats = np.empty((0, 0))


class Step(NamedTuple):
    """A piece of a motion, over times [0, length] from its own start."""

    length: float
    guards: Floats  # (g, size) power series in time; empty for a flow with derivatives
    states: Callable[[Floats], Floats]  # (b, N) at times (b,), also a little outside
    # the state (N,) at a time and its derivatives (N, columns) in state and parameters at the
    # start, as exact as the backend can; the latter are empty if the flow has none
    exact: Callable[[float], tuple[Floats, Floats]]


def along(length: float, *series: Floats) -> Step:
    """A step for samples, along a power series in time whose coefficients are (N,) each."""

    def states(times: Floats) -> Floats:
        return np.vander(times, len(series), increasing=True) @ np.array(series)

    return Step(length, _NONE, states, lambda t: (states(np.array([t]))[0], _NONE))


Flow = Callable[[Floats, Floats, float], Iterator[Step]]
"""The motion in one mode: from a state and parameters, steps in turn up to a final time.

That may be negative. StoppedError if there is no motion.
"""


class KeptSteps:
    """The steps of a phase, computed as far as they are needed."""

    def __init__(self, flow: Flow, z: Floats, p: Floats, most: float) -> None:
        self.start, self._source = (z, p, most), flow(z, p, most)
        self._made, self._begins = list[Step](), [0.0]
        self.length = self._next().length  # of the first step

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """State and derivatives at a time, also before the start of the phase."""
        while self._begins[-1] < t:
            self._next()
        k = max(0, int(np.searchsorted(self._begins, t)) - 1)
        return self._made[k].exact(t - self._begins[k])

    def _next(self) -> Step:
        step = next(self._source, None)
        if step is None or len(self._made) == KEPT_MOST:
            raise StoppedError(MotionStatus.OVERFLOW)
        self._made.append(step)
        self._begins.append(self._begins[-1] + step.length)
        return step


def dop853(eq: Equations, mode: Mode, varies: bool = False) -> Flow:
    """The motion in one mode by DOP853, with its variational equations or else with guards.

    Steps with guards are so short that polynomials resolve these.
    """
    size = eq.size

    def rate(y: Floats, p: Floats) -> Floats:
        here = Local(eq, mode, y[:size], p)
        if not varies:
            return here.flow
        turned = total(eq, here.jacobian, y[size:].reshape(size, eq.columns))
        return np.concatenate([here.flow, turned.ravel()])

    def solver(start: Floats, p: Floats, most: float) -> DOP853:
        return DOP853(lambda _, y: rate(y, p), 0.0, start, most, rtol=RELATIVE, atol=ABSOLUTE)

    def exact(y: Floats, p: Floats, low: float, t: float) -> tuple[Floats, Floats]:
        """State, and derivatives if there are any, from an integration that ends there."""
        if low + t != 0.0:
            whole = solver(y, p, low + t)
            while whole.status == "running":
                _advance(whole)
            y = whole.y
        return y[:size], y[size:].reshape(size, -1)

    def states(dense: Callable[[Floats], Floats], at: float, times: Floats) -> Floats:
        """States by the dense output, which is less exact than the step itself."""
        return dense(at + times).T[:, :size]

    def steps(z: Floats, p: Floats, most: float) -> Iterator[Step]:
        start = np.concatenate([z, np.eye(size, eq.columns).ravel()]) if varies else z
        whole = solver(start, p, most)
        for _ in range(STEPS_MOST):
            if whole.t == most:
                return
            at, state = whole.t, whole.y.copy()
            _advance(whole)
            seen, length = partial(states, whole.dense_output()), whole.t - at
            parts = iter([(0.0, length, _NONE)])
            if not varies:
                parts = _windows(eq, mode, seen, state, p, at, length)
            for low, part, guards in parts:
                yield Step(part, guards, partial(seen, at + low), partial(exact, state, p, low))
        raise StoppedError(MotionStatus.STEPS_LIMIT)

    return steps


def _advance(solver: DOP853) -> None:
    """Make one step; StoppedError if there is none."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        solver.step()
    if solver.status == "failed" or not (np.abs(solver.y) < LARGE).all():
        raise StoppedError(MotionStatus.OVERFLOW)


# --- Guards ---------------------------------------------------------------------------------------


def _windows(
    eq: Equations, mode: Mode, states: Callable[[float, Floats], Floats], z: Floats, p: Floats,
    at: float, whole: float,
) -> Iterator[tuple[float, float, Floats]]:  # fmt: skip
    """Parts of a step, halved until polynomials (g, size) resolve all guards, and these."""
    # At the start of a phase polynomials have all derivatives of the guards that are known.
    left, shortest = [(0.0, whole, 0)], ROUNDED * math.ulp(at + whole)
    noise = NOISE * _sizes(eq, mode, z, p, whole)
    while left:
        low, length, depth = left.pop()
        times = low + _POINTS * length
        values = _guards(eq, mode, states(at, times), p)
        if depth < HALVINGS and length > shortest and not _are_resolved(values, noise):
            half = 0.5 * length
            left += [(low + half, half, depth + 1), (low, half, depth + 1)]
            continue
        jets: list[list[float]] = [[] for _ in values]
        if at == 0.0 == low:
            here = Local(eq, mode, z, p)
            jets = [here.jet(guard) for guard in here.sets.places]
        guards = np.zeros((len(values), SIZE))
        for row, value, jet in zip(guards, values, jets, strict=True):
            row[:] = _series(value, jet, length)
        yield low, length, guards


def _guards(eq: Equations, mode: Mode, states: Floats, p: Floats) -> Floats:
    """Values (g, b) of all guards at states (b, N)."""
    terms, sets = eq.terms(states, p), eq.sets(mode)
    found = guard_values(sets, terms, balance(sets, terms))
    return np.vstack([np.empty((0, len(states))), *found])


def _sizes(eq: Equations, mode: Mode, z: Floats, p: Floats, length: float) -> Floats:
    """Sizes (g,) of what the guards of a step are differences of."""
    terms, sets, n = eq.terms(z[: eq.size], p), eq.sets(mode), eq.n
    pushed = np.abs(np.linalg.solve(terms.mass, terms.force))
    speed = np.abs(z[n : 2 * n]) + pushed * length
    place = np.abs(z[:n]) + speed * length
    found = []
    for guard in sets.places:
        kind, i, _ = sets.kinematic(guard)
        if kind == GAP:
            found.append(np.abs(terms.w_n[i]) @ place)
        elif kind == SLIP:
            found.append(np.abs(terms.w_t[i]) @ speed)
        else:  # the normal force that alone would withstand the others
            found.append(np.abs(terms.w_n[i]) @ pushed / _yield(terms, i))
    return np.array(found)


def _yield(terms: Terms, i: int) -> float:
    """The acceleration of a gap that its normal force causes, per newton."""
    return float(terms.w_n[i] @ np.linalg.solve(terms.mass, terms.w_n[i]))


def _are_resolved(values: Floats, noise: Floats) -> bool:
    """Whether the last Chebyshev coefficients of all guards are small, or rounding."""
    c = np.abs(values @ _TO_SERIES.T)
    size = np.maximum(RESOLVED * c.max(axis=1, initial=0.0), noise)
    return bool((c[:, -3:].max(axis=1, initial=0.0) <= size).all())


def _series(values: Floats, jet: Sequence[float], length: float) -> Floats:
    """The power series (SIZE,) of a guard with given values, and derivatives at the start."""
    order = len(jet)
    c = np.array([each / math.factorial(k) * length**k for k, each in enumerate(jet)])
    rest = (values - _POINTS[:, None] ** np.arange(order) @ c) / _POINTS**order
    found = np.zeros(SIZE)
    found[:order], found[order : order + NODES] = c, _TO_POWERS @ rest
    return found / length ** np.arange(SIZE)
