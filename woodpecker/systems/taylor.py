"""The motion within one mode by heyoka's Taylor series, compiled once for each mode."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import heyoka as hy
import numpy as np
import sympy

from woodpecker.base.arrays import Floats
from woodpecker.systems.equations import Equations
from woodpecker.systems.flows import STEPS_MOST, LostError, Step
from woodpecker.systems.modes import OPEN, SLIDE_UP, STICK, Mode

TOLERANCE = 2.0**-53  # of the Taylor series: the rounding of doubles
SMALL = 400  # numbers of a state from which on compiling in compact mode pays


class TaylorFlow:
    """The motion in one mode by Taylor series, with its variational equations if asked."""

    def __init__(self, eq: Equations, mode: Mode, *, varies: bool) -> None:
        self._eq, self._varies = eq, varies
        state = hy.make_vars(*(f"z{k}" for k in range(eq.size)))
        values = [hy.par[k] for k in range(len(eq.p))]
        names = dict(zip(eq.symbols, [*state, *values], strict=True))
        n = eq.n
        rates = [*state[n : 2 * n], *_accelerations(eq, mode, names), hy.expression(1.0)]
        system: Any = list(zip(state, rates, strict=True))
        if varies:
            system = hy.var_ode_sys(system, [*state, *(hy.par[k] for k in eq.places)], 1)
        size = eq.size * (1 + eq.columns if varies else 1)
        self._integrator = hy.taylor_adaptive(
            system, np.zeros(eq.size), tol=TOLERANCE, compact_mode=size > SMALL or varies
        )  # fmt: skip
        self._start = np.eye(eq.size, eq.columns).ravel() if varies else np.zeros(0)

    def steps(self, z: Floats, p: Floats, most: float) -> Iterator[Step]:
        """Steps in turn; the last one ends at a time that may be negative."""
        state = np.concatenate([z, self._start])
        t = 0.0
        for _ in range(STEPS_MOST):
            integrator = self._integrator  # others may have used it since
            if len(integrator.pars):
                integrator.pars[:] = p[: len(integrator.pars)]
            integrator.time = 0.0
            integrator.state[:] = state
            left = most - t
            if math.isinf(left):
                outcome, length = integrator.step(write_tc=True)
            else:
                outcome, length = integrator.step(left, write_tc=True)
            if outcome == hy.taylor_outcome.err_nf_state or not np.isfinite(integrator.state).all():
                raise LostError
            state = integrator.state.copy()
            yield _TaylorStep(self._eq, integrator.tc.copy(), length)
            t += length
            if outcome == hy.taylor_outcome.time_limit:
                return
        raise LostError


class _TaylorStep:
    """A step: the Taylor polynomials of all numbers of the state."""

    def __init__(self, eq: Equations, coefficients: Floats, length: float) -> None:
        self._eq, self._coefficients, self.length = eq, coefficients, length

    def states(self, times: Floats) -> Floats:
        """States (b, N)."""
        powers = times[:, None] ** np.arange(self._coefficients.shape[1])
        found: Floats = powers @ self._coefficients[: self._eq.size].T
        return found

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """The state and its derivatives, by Horner's rule."""
        y = self._coefficients[:, -1].copy()
        for column in self._coefficients.T[-2::-1]:
            y = y * t + column
        size = self._eq.size
        return y[:size], y[size:].reshape(size, -1)


def _accelerations(eq: Equations, mode: Mode, names: dict[sympy.Symbol, Any]) -> list[Any]:
    """The accelerations of a mode as expressions: the balance, eliminated."""
    mass, force, w_n, w_t, bar_n, bar_t, mu = (
        [[_converted(entry, names) for entry in row] for row in each.tolist()]
        for each in eq.expressions
    )
    n = eq.n
    closed = [i for i, state in enumerate(mode) if state != OPEN]
    stuck = [i for i in closed if mode[i] == STICK]
    zero, size = hy.expression(0.0), n + len(closed) + len(stuck)
    rows = [[zero] * (size + 1) for _ in range(size)]
    for j in range(n):
        rows[j][:n], rows[j][size] = mass[j], force[j][0]
        for k, i in enumerate(closed):
            pull = w_n[i][j]
            if mode[i] != STICK and eq.rubs[i]:
                friction = mu[i][0] * w_t[i][j]
                pull = pull - friction if mode[i] == SLIDE_UP else pull + friction
            rows[j][n + k] = -pull
        for k, i in enumerate(stuck):
            rows[j][n + len(closed) + k] = -w_t[i][j]
    for k, (row, bar) in enumerate([(w_n[i], bar_n[i]) for i in closed] +
                                   [(w_t[i], bar_t[i]) for i in stuck]):  # fmt: skip
        rows[n + k][:n], rows[n + k][size] = row, -bar[0]
    return _eliminated(rows)[:n]


def _converted(entry: sympy.Expr, names: dict[sympy.Symbol, Any]) -> Any:
    if entry.is_number:
        return hy.expression(float(entry))
    rounded = {r: sympy.Float(float(r)) for r in entry.atoms(sympy.Rational) if r.q & (r.q - 1)}
    try:
        return hy.from_sympy(entry.xreplace(rounded), names)
    except (TypeError, ValueError) as error:
        raise ValueError(f"heyoka has no Taylor series of {entry}: {error}") from error


def _eliminated(rows: list[list[Any]]) -> list[Any]:
    """The solution of a linear system of expressions, by elimination without pivoting.

    The mass matrix is positive definite, and so is what is left after it but for friction.
    """
    size = len(rows)
    for k in range(size):
        for j in range(k + 1, size):
            if _is_zero(rows[j][k]):
                continue
            factor = rows[j][k] / rows[k][k]
            rows[j] = [
                a if _is_zero(b) else a - factor * b for a, b in zip(rows[j], rows[k], strict=True)
            ]
    x: list[Any] = [None] * size
    for k in range(size - 1, -1, -1):
        total = rows[k][size]
        for j in range(k + 1, size):
            if not _is_zero(rows[k][j]):
                total = total - rows[k][j] * x[j]
        x[k] = total / rows[k][k]
    return x


def _is_zero(value: Any) -> bool:
    return bool(value == hy.expression(0.0))
