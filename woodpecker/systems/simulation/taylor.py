"""The motion within one mode by heyoka's Taylor series, compiled once for each mode.

Without derivatives the guards of the mode are integrated along with the state: their Taylor
polynomials say when they fire.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import heyoka as hy
import numpy as np
import sympy

from woodpecker.base.arrays import Floats
from woodpecker.base.polynomials import evaluated
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.modes import (
    CONE_UP,
    GAP,
    KNOWN,
    NORMAL,
    OPEN,
    SLIDE_UP,
    SLIP,
    STICK,
    Mode,
    guards_of,
    team_of,
)
from woodpecker.systems.simulation.flows import STEPS_MOST, LostError, Step

TOLERANCE = 2.0**-53  # of the Taylor series: the rounding of doubles
SUCCESS, TIME_LIMIT = hy.taylor_outcome.success, hy.taylor_outcome.time_limit
SMALL = 400  # numbers of a state from which on compiling in compact mode pays


class TaylorFlow:
    """The motion in one mode by Taylor series, with its variational equations if asked.

    Parameters
    ----------
    eq, mode
        The equations, and the states of all contacts.
    varies
        Whether there are derivatives; else there are guards.
    when
        The expression of a section, whose fall through zero is the last guard; None: no section.
    """

    def __init__(
        self, eq: Equations, mode: Mode, *, varies: bool, when: sympy.Expr | None = None
    ) -> None:
        self._eq, self._varies, self.has_guards = eq, varies, not varies
        terms = _Expressions(eq, mode)
        system: Any = list(zip(terms.state, terms.rates, strict=True))
        self._starts: Any = None
        if varies:
            parameters = [hy.par[k] for k in eq.places]
            system = hy.var_ode_sys(system, [*terms.state, *parameters], 1)
            size = eq.size * (1 + eq.columns)
        else:
            values, rates = terms.guards(when)
            marks = [hy.expression(f"g{k}") for k in range(len(values))]
            system += list(zip(marks, rates, strict=True))
            size = eq.size + len(marks)
            if values:
                self._starts = hy.cfunc(values, vars=terms.state)
        self._integrator = hy.taylor_adaptive(
            system, np.zeros(eq.size if varies else size), tol=TOLERANCE,
            compact_mode=size > SMALL or varies,
        )  # fmt: skip
        self._pars, self._state = self._integrator.pars, self._integrator.state
        self._coefficients = self._integrator.tc
        self._last: Floats | None = None  # the state in which the integrator was left, and for whom
        self._start = np.eye(eq.size, eq.columns).ravel() if varies else np.zeros(0)

    def steps(self, z: Floats, p: Floats, most: float, *, keeps: bool = True) -> Iterator[Step]:
        """Steps in turn; the last one ends at a time that may be negative."""
        integrator, limited = self._integrator, not math.isinf(most)
        state, pars, coefficients = self._state, self._pars, self._coefficients
        more = self._start
        if self._starts is not None:
            more = self._starts(z, None, p[: self._starts.nparams])
        kept = np.concatenate([z, more])
        t = 0.0
        for _ in range(STEPS_MOST):
            if self._last is not kept:  # others have used the integrator since
                self._last, integrator.time = kept, 0.0
                pars[:], state[:] = p[: len(pars)], kept
            if limited:
                outcome, length = integrator.step(most - t, True)
            else:
                outcome, length = integrator.step(write_tc=True)
            ends = outcome != SUCCESS
            if ends and outcome != TIME_LIMIT:
                self._last = None
                raise LostError
            self._last = kept = state.copy()
            yield TaylorStep(
                coefficients.copy() if keeps else coefficients, length, self._eq.size,
                varies=self._varies,
            )  # fmt: skip
            t += length
            if ends:
                return
        raise LostError


class TaylorStep:
    """A step: the Taylor polynomials of all numbers of the state, and of guards.

    Parameters
    ----------
    coefficients
        (rows, order + 1) those of the state, and then of its derivatives or of guards.
    length
        How long it is.
    size
        Numbers of the state.
    varies
        Whether there are derivatives; else there are guards.
    """

    __slots__ = "_coefficients", "_size", "_varies", "length"

    def __init__(self, coefficients: Floats, length: float, size: int, *, varies: bool) -> None:
        self._coefficients, self.length = coefficients, length
        self._size, self._varies = size, varies

    @property
    def guards(self) -> Floats:
        """(g, order + 1) Taylor coefficients of the guards; empty if derivatives are known."""
        return self._coefficients[len(self._coefficients) if self._varies else self._size :]

    def states(self, times: Floats) -> Floats:
        """States (b, N)."""
        powers = np.arange(self._coefficients.shape[1])
        found: Floats = times[:, None] ** powers @ self._coefficients[: self._size].T
        return found

    def exact(self, t: float) -> tuple[Floats, Floats]:
        """The state and its derivatives, if any."""
        size = self._size
        y = evaluated(self._coefficients[: None if self._varies else size], t)
        return y[:size], y[size:].reshape(size, -1)


def jets(eq: Equations, mode: Mode) -> Callable[[Floats, Floats], Floats]:
    """A compiled function of state and parameters.

    It gives accelerations (n,), and forces lambda_N and lambda_T (m,); then for each guard of the
    mode its value and its derivatives in time, ``KNOWN`` of them
    (:mod:`woodpecker.systems.mechanics.modes`).
    """
    terms = _Expressions(eq, mode)
    found = [*terms.a, *terms.l_n, *terms.l_t]
    for guard, value, rate in zip(guards_of(eq, mode), *terms.guards(None), strict=True):
        jet = [value, rate]
        while len(jet) <= KNOWN[guard // eq.m]:
            jet.append(terms.rate(jet[-1]))
        found += jet
    function = hy.cfunc(found, vars=terms.state)
    needs = function.nparams

    def numbers(z: Floats, p: Floats) -> Floats:
        values: Floats = function(z, None, p[:needs])
        return values

    return numbers


class _Expressions:
    """The motion in a mode in heyoka's expressions.

    Attributes
    ----------
    state, rates
        z = (q, u, t), and z'.
    a, l_n, l_t
        Accelerations and contact forces.
    """

    def __init__(self, eq: Equations, mode: Mode) -> None:
        self._eq, self._mode = eq, mode
        self.state = [hy.expression(f"z{k}") for k in range(eq.size)]
        values = [hy.par[k] for k in range(len(eq.p))]
        self._names = dict(zip(eq.symbols, [*self.state, *values], strict=True))
        self._terms = [self._converted(each) for each in eq.expressions]
        self._balance()
        n = eq.n
        self.rates = [*self.state[n : 2 * n], *self.a, hy.expression(1.0)]

    def _converted(self, matrix: Any) -> list[list[Any]]:
        return [[_converted(entry, self._names) for entry in row] for row in matrix.tolist()]

    def _balance(self) -> None:
        """The linear system of :func:`woodpecker.systems.mechanics.modes.balance`, eliminated."""
        eq, mode, n = self._eq, self._mode, self._eq.n
        mass, force, w_n, w_t, bar_n, bar_t, mu = self._terms
        closed = [i for i, state in enumerate(mode) if state != OPEN]
        stuck = [i for i in closed if mode[i] == STICK and self._team(i)[0] == i]
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
        bars = [(w_n[i], bar_n[i]) for i in closed] + [(w_t[i], bar_t[i]) for i in stuck]
        for k, (row, bar) in enumerate(bars):
            rows[n + k][:n], rows[n + k][size] = row, -bar[0]
        x = _eliminated(rows)
        self.a, self.l_n, self.l_t = _kept(x[:n], bars), [zero] * eq.m, [zero] * eq.m
        for k, i in enumerate(closed):
            self.l_n[i] = x[n + k]
            if mode[i] != STICK and eq.rubs[i]:
                sign = -1.0 if mode[i] == SLIDE_UP else 1.0
                self.l_t[i] = sign * mu[i][0] * x[n + k]
        for k, i in enumerate(stuck):
            self.l_t[i] = x[n + len(closed) + k]

    def _team(self, i: int) -> tuple[int, ...]:
        return team_of(self._mode, self._eq.slips, i)

    def guards(self, when: sympy.Expr | None) -> tuple[list[Any], list[Any]]:
        """All guards of the mode, and their rates."""
        eq, values, rates = self._eq, list[Any](), list[Any]()
        w_t, bar_t, mu = self._terms[3], *self._terms[5:]
        gaps, gap_rates, slips = (
            [row[0] for row in self._converted(each)] for each in eq.kinematics
        )
        for guard in guards_of(eq, self._mode):
            kind, i = divmod(guard, eq.m)
            if kind == GAP:
                values.append(gaps[i])
                rates.append(gap_rates[i])
            elif kind == SLIP:
                sign = 1.0 if self._mode[i] == SLIDE_UP else -1.0
                values.append(sign * slips[i])
                turned = [w * a for w, a in zip(w_t[i], self.a, strict=True)]
                rates.append(sign * (hy.sum(turned) + bar_t[i][0]))
            else:
                cone = -1.0 if kind == CONE_UP else 1.0
                value = self.l_n[i]
                if kind != NORMAL:
                    bound = hy.sum([mu[k][0] * self.l_n[k] for k in self._team(i)])
                    value = bound + cone * self.l_t[i]
                values.append(value)
                rates.append(self.rate(value))
        if when is not None:
            values.append(-_converted(when, self._names))
            rates.append(self.rate(values[-1]))
        return values, rates

    def rate(self, value: Any) -> Any:
        """The derivative of an expression in time."""
        slopes = hy.diff_tensors([value], diff_args=self.state).gradient
        return hy.sum([d * v for d, v in zip(slopes, self.rates, strict=True) if not _is_zero(d)])


def _converted(entry: sympy.Expr, names: Mapping[sympy.Symbol, Any]) -> Any:
    """An expression of heyoka; whole powers as products, as those of heyoka are nan at zero."""
    if entry.is_number:
        return hy.expression(float(entry))
    rounded = {r: sympy.Float(float(r)) for r in entry.atoms(sympy.Rational) if r.q & (r.q - 1)}
    known, products = dict(names), dict[sympy.Expr, sympy.Expr]()
    for power in entry.atoms(sympy.Pow):
        if power.exp.is_Integer and power.exp > 1:
            products[power] = sympy.Dummy()
            known[products[power]] = math.prod([_converted(power.base, names)] * int(power.exp))
    try:
        return hy.from_sympy(entry.xreplace(products).xreplace(rounded), known)
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


def _kept(a: list[Any], bars: Sequence[tuple[list[Any], list[Any]]]) -> list[Any]:
    """Accelerations that keep w a + bar at zero but for the rounding of this sum alone.

    That of the whole system would add up over a phase: a contact that is closed would drift. Only
    where it is safe to divide, by a number or by what alone moves the contact.
    """
    found, left = list(a), set(range(len(a)))
    for row, bar in bars:
        moves = [j for j, entry in enumerate(row) if not _is_zero(entry)]
        safe = [j for j in moves if j in left and (len(moves) == 1 or _is_number(row[j]))]
        if safe:
            j = safe[0]
            left.remove(j)
            found[j] = -(bar[0] + hy.sum([row[k] * found[k] for k in moves if k != j])) / row[j]
    return found


def _is_number(value: Any) -> bool:
    return not hy.get_variables(value) and not hy.get_params(value)


def _is_zero(value: Any) -> bool:
    return bool(value == hy.expression(0.0))
