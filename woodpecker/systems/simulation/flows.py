"""The motion within one mode, step by step: what both backends give, and scipy's DOP853."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import DOP853

from woodpecker.base.arrays import Floats
from woodpecker.base.polynomials import HALVINGS
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.modes import (
    KNOWN,
    SECTION,
    Local,
    Mode,
    SectionGuard,
    balance,
    guard_values,
    guards_of,
)
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

RELATIVE, ABSOLUTE = 1e-13, 1e-16  # tolerances of DOP853, near what its step control can resolve
STEPS_MOST = 100_000  # of one phase
KEPT_MOST = 2000  # of a phase: far off, where Newton's method may ask, a motion has millions
NODES = 8  # of a guard over a step: as many coefficients as the dense output has
SIZE = NODES + max(KNOWN.values()) + 1  # of a power series of a guard, with known derivatives
RESOLVED = 1e-9  # relative: last coefficients of a guard that is resolved
NOISE = 1e-12  # a guard that is no larger is zero all along, such as the slip of a block at rest

_ANGLES = math.pi * (np.arange(NODES) + 0.5) / NODES
_POINTS = 0.5 - 0.5 * np.cos(_ANGLES)  # Chebyshev's, ascending in (0, 1)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(2.0 * _POINTS - 1.0, NODES - 1))
_TO_POWERS = np.linalg.inv(np.vander(_POINTS, increasing=True))
_NONE: Floats = np.empty((0, 0))


class Step(NamedTuple):
    """A piece of a motion, over times [0, length] from its own start."""

    length: float
    guards: Floats  # (g, size) their power series in time; none of a flow with derivatives
    states: Callable[[Floats], Floats]  # (b, N) at some times (b,), a little outside too
    # the state (N,) at a time and its derivatives (N, columns) in state and parameters at the
    # start, as exact as the backend can; the latter are empty if the flow has none
    exact: Callable[[float], tuple[Floats, Floats]]


class Flow(Protocol):
    """The motion in one mode."""

    def steps(self, z: Floats, p: Floats, most: float) -> Iterator[Step]:
        """Steps in turn, the last one to a time; StoppedError if there are none."""


class KeptSteps:
    """The steps of a phase, made as far as they are asked for."""

    def __init__(self, flow: Flow, z: Floats, p: Floats, most: float) -> None:
        self.start = z, p, most
        self._source = flow.steps(z, p, most)
        self._made: list[Step] = []
        self._begins = [0.0]

    @property
    def first(self) -> Step:
        """The first step."""
        return self.step(0)

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """State and derivatives at a time, also before the start of the phase."""
        while self._begins[-1] < t or not self._made:
            self.step(len(self._made))
        k = max(0, int(np.searchsorted(self._begins, t)) - 1)
        return self._made[k].exact(t - self._begins[k])

    def step(self, k: int) -> Step:
        """The k-th step."""
        while len(self._made) <= k:
            step = next(self._source, None)
            if step is None or len(self._made) == KEPT_MOST:
                raise StoppedError(MotionStatus.OVERFLOW)
            self._made.append(step)
            self._begins.append(self._begins[-1] + step.length)
        return self._made[k]


class RungeFlow:
    """The motion in one mode by DOP853, with its variational equations or else with guards.

    Steps with guards are as short as polynomials resolve these.
    """

    def __init__(
        self, eq: Equations, mode: Mode, *, varies: bool, section: SectionGuard | None = None
    ) -> None:
        self._eq, self._mode, self._varies, self._section = eq, mode, varies, section

    def steps(self, z: Floats, p: Floats, most: float) -> Iterator[Step]:
        """Steps in turn; the last one ends at a time that may be negative."""
        eq = self._eq
        start = z if not self._varies else np.concatenate(
            [z, np.eye(eq.size, eq.columns).ravel()]
        )  # fmt: skip
        solver = self._solver(start, p, most)
        for _ in range(STEPS_MOST):
            if solver.t == most:
                return
            at, state = solver.t, solver.y.copy()
            with np.errstate(all="ignore"), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise StoppedError(MotionStatus.OVERFLOW)
            states = partial(self._states, solver.dense_output())
            windows = [(0.0, solver.t - at, _NONE)]
            for low, length, guards in (
                windows if self._varies else self._windows(states, state, p, at, solver.t - at)
            ):
                yield Step(
                    length, guards, partial(states, at + low), partial(self._exact, state, p, low)
                )
        raise StoppedError(MotionStatus.OVERFLOW)

    def _solver(self, start: Floats, p: Floats, most: float) -> DOP853:
        return DOP853(
            lambda _, y: self._rate(y, p), 0.0, start, most, rtol=RELATIVE, atol=ABSOLUTE,
        )  # fmt: skip

    def _rate(self, y: Floats, p: Floats) -> Floats:
        size, eq = self._eq.size, self._eq
        here = Local(eq, self._mode, y[:size], p)
        if not self._varies:
            return here.flow
        jacobian, tangents = here.jacobian, y[size:].reshape(size, eq.columns)
        turned = jacobian[:, :size] @ tangents
        turned[:, size:] += jacobian[:, size:]
        return np.concatenate([here.flow, turned.ravel()])

    def _states(self, dense: Callable[[Floats], Floats], at: float, times: Floats) -> Floats:
        """By the dense output, which is less exact than the step itself."""
        return dense(at + times).T[:, : self._eq.size]

    def _exact(self, y: Floats, p: Floats, low: float, t: float) -> tuple[Floats, Floats]:
        """The state by steps that end there, and derivatives from the start of the first step."""
        if low + t != 0.0:
            solver = self._solver(y, p, low + t)
            while solver.status == "running":
                solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise StoppedError(MotionStatus.OVERFLOW)
            y = solver.y
        size = self._eq.size
        return y[:size], y[size:].reshape(size, -1)

    # --- Guards -----------------------------------------------------------------------------------

    def _windows(
        self, states: Callable[[float, Floats], Floats], z: Floats, p: Floats, at: float,
        whole: float,
    ) -> Iterator[tuple[float, float, Floats]]:  # fmt: skip
        """Parts of a step, halved until polynomials resolve all guards, and these (g, size).

        Where the phase begins they have all derivatives that are known there.
        """
        left = [(0.0, whole, 0)]
        while left:
            low, length, depth = left.pop()
            times = low + _POINTS * length
            values = self._guards(states(at, times), p)
            if depth < HALVINGS and not _are_resolved(values):
                half = 0.5 * length
                left += [(low + half, half, depth + 1), (low, half, depth + 1)]
                continue
            jets: list[list[float]] = [[] for _ in values]
            if at == 0.0 == low:
                here = Local(self._eq, self._mode, z, p, self._section)
                jets = [here.jet(guard) for guard in self._watched]
            guards = np.zeros((len(values), SIZE))
            for row, value, jet in zip(guards, values, jets, strict=True):
                row[:] = _series(value, jet, length)
            yield low, length, guards

    @property
    def _watched(self) -> list[int]:
        own = guards_of(self._eq, self._mode)
        return [*own] if self._section is None else [*own, SECTION * self._eq.m]

    def _guards(self, states: Floats, p: Floats) -> Floats:
        """Values (g, b) of all guards at states (b, N)."""
        eq, mode, rows = self._eq, self._mode, np.empty((0, len(states)))
        terms = eq.terms(states, p)
        found = guard_values(eq, mode, terms, balance(eq, mode, terms))
        if self._section is not None:
            found.append(self._section.values(states, p))
        return np.vstack([rows, *found])


def _are_resolved(values: Floats) -> bool:
    """Whether the last coefficients of all guards are small, or rounding."""
    c = np.abs(values @ _TO_SERIES.T)
    size = np.maximum(RESOLVED * c.max(axis=1, initial=0.0), NOISE)
    return bool((c[:, -3:].max(axis=1, initial=0.0) <= size).all())


def _series(values: Floats, jet: Sequence[float], length: float) -> Floats:
    """The power series (SIZE,) of a guard with these values and with derivatives at the start."""
    order = len(jet)
    c = np.array([each / math.factorial(k) * length**k for k, each in enumerate(jet)])
    rest = (values - _POINTS[:, None] ** np.arange(order) @ c) / _POINTS**order
    found = np.zeros(SIZE)
    found[:order], found[order : order + NODES] = c, _TO_POWERS @ rest
    return found / length ** np.arange(SIZE)
