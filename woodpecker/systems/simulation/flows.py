"""The motion within one mode, step by step: what both backends give, and scipy's DOP853."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Protocol

import numpy as np
from scipy.integrate import DOP853

from woodpecker.base.arrays import Floats
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.modes import Local, Mode

RELATIVE, ABSOLUTE = 1e-13, 1e-16  # tolerances of DOP853, near what its step control can resolve
STEPS_MOST = 100_000  # of one phase
KEPT_MOST = 2000  # of a phase: far off, where Newton's method may ask, a motion has millions


class LostError(Exception):
    """The motion leaves the numbers that doubles can hold."""


class Step(Protocol):
    """A piece of a motion, over times [0, length] from its own start."""

    @property
    def length(self) -> float:
        """How long it is."""

    @property
    def guards(self) -> Floats:
        """(g, order + 1) Taylor coefficients of the guards, if its flow has them."""

    def states(self, times: Floats) -> Floats:
        """States (b, N) at some times, a little outside too."""

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """The state (N,) and its derivatives (N, columns) in state and parameters at the start.

        As exact as the backend can; the latter are empty if the flow has none.
        """


class Flow(Protocol):
    """The motion in one mode."""

    @property
    def has_guards(self) -> bool:
        """Whether its steps have the Taylor coefficients of guards."""

    def steps(self, z: Floats, p: Floats, most: float, *, keeps: bool = True) -> Iterator[Step]:
        """Steps in turn from a state, the last one to a time; LostError if there are none.

        If they are not kept each may be used only until the next one is asked for.
        """


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

    def all(self) -> Iterator[Step]:
        """All steps, one after the other."""
        for k in range(KEPT_MOST):
            yield self.step(k)

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
                raise LostError
            self._made.append(step)
            self._begins.append(self._begins[-1] + step.length)
        return self._made[k]


class RungeFlow:
    """The motion in one mode by DOP853, with its variational equations if asked."""

    has_guards = False

    def __init__(self, eq: Equations, mode: Mode, *, varies: bool) -> None:
        self._eq, self._mode, self._varies = eq, mode, varies

    def steps(self, z: Floats, p: Floats, most: float, *, keeps: bool = True) -> Iterator[Step]:
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
                raise LostError
            yield _RungeStep(self, state, p, at, solver)
        raise LostError

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


class _RungeStep:
    """A step of DOP853; its dense output is less exact than itself."""

    guards: Floats = np.empty((0, 0))

    def __init__(
        self, flow: RungeFlow, start: Floats, p: Floats, at: float, solver: DOP853
    ) -> None:
        self._flow, self._start, self._p, self._at = flow, start, p, at
        self.length, self._dense = solver.t - at, solver.dense_output()

    def states(self, times: Floats) -> Floats:
        """States (b, N) by the dense output."""
        found: Floats = self._dense(self._at + times).T[:, : self._flow._eq.size]
        return found

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """The state by steps that end there, and derivatives from the start of the first step."""
        eq = self._flow._eq
        y = self._start
        if t != 0.0:
            solver = self._flow._solver(y, self._p, t)
            while solver.status == "running":
                solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise LostError
            y = solver.y
        return y[: eq.size], y[eq.size :].reshape(eq.size, -1)
