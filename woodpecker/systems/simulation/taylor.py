"""The motion within one mode by heyoka's Taylor series, compiled once for each mode.

Without derivatives the guards of the mode are integrated along with the state: their Taylor
polynomials say when they fire. So are edges, at which a step ends: there forces have kinks, or a
function that was constant up to rounding begins to change, which no Taylor series foresees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np
import sympy
from numpy.polynomial.polynomial import polyval

from woodpecker.base.arrays import Floats
from woodpecker.base.polynomials import WHOLE, bernstein, evaluated, roots, scaled
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.expressions import edges
from woodpecker.systems.mechanics.index_sets import KNOWN, Mode
from woodpecker.systems.mechanics.modes import Balance, balance, guard_values
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.flows import LARGE, NOISE, STEPS_MOST, Flow, Step

TOLERANCE = 2.0**-53  # of the Taylor series: the rounding of doubles
SUCCESS, TIME_LIMIT = hy.taylor_outcome.success, hy.taylor_outcome.time_limit
# Terms of the rates, written out: with more compiling takes minutes, unless in compact mode.
SMALL = 10_000
SHORT = 2.0**-40  # [s] of a step off the zero of a root, beside which series reach less far
KNOWN_SLOPE = 2.0**-30  # largest relative change of derivatives over such a step
GROWS = 2.0**-9  # relative growth of a state over such a step that means a motion to infinity
BEYOND = 2.0**-44  # of a step: it ends so far beyond an edge, twice as far if that is not enough
CONSTANT = {  # the modulus of the argument beyond which they, or their changes, are below rounding
    sympy.exp: 37, sympy.sinh: 37, sympy.cosh: 37, sympy.tanh: 19, sympy.erf: 6, sympy.erfc: 6
}  # fmt: skip
RELATIONS = {
    sympy.Lt: hy.lt, sympy.Le: hy.lte, sympy.Gt: hy.gt, sympy.Ge: hy.gte, sympy.Eq: hy.eq,
    sympy.Ne: hy.neq,
}  # fmt: skip


def taylor(eq: Equations, mode: Mode, varies: bool = False) -> Flow:
    """The motion in one mode by Taylor series, with variational equations or else with guards."""
    terms, rows = _Expressions(eq, mode), eq.size  # numbers of a state without edges
    system: Any = list(zip(terms.state, terms.rates, strict=True))
    marked = terms.edges()
    if varies:
        parameters = [hy.par[k] for k in eq.places]
        system = hy.var_ode_sys(system, [*terms.state, *parameters], 1).sys
        rows = eq.size * (1 + eq.columns)
    else:
        guards = terms.guards()
        marked, rows = guards + marked, rows + len(guards)
    names = [hy.expression(f"g{k}") for k in range(len(marked))]
    system += list(zip(names, map(terms.rate, marked), strict=True))
    values = hy.cfunc(marked, vars=terms.state) if marked else None
    compact = varies or sum(len(rate) for _, rate in system) > SMALL
    integrator = hy.taylor_adaptive(
        system, np.zeros(len(system)), tol=TOLERANCE, compact_mode=compact
    )
    size, numbers, state, series = eq.size, integrator.pars, integrator.state, integrator.tc
    start = np.eye(size, eq.columns).ravel() if varies else np.zeros(0)

    def marks(z: Floats, p: Floats) -> Floats:
        """Guards and edges at a state."""
        return np.zeros(0) if values is None else np.asarray(values(z, None, p[: values.nparams]))

    def steps(z: Floats, p: Floats, most: float) -> Iterator[Step]:
        kept = np.concatenate([z, start, marks(z, p)])
        t, beyond = 0.0, BEYOND
        for _ in range(STEPS_MOST):
            # others may have used the integrator since
            integrator.time, numbers[:], state[:] = 0.0, p[: len(numbers)], kept
            outcome, length = integrator.step(most - t, True)
            ends = outcome != SUCCESS
            kept, c = state.copy(), series.copy()
            if outcome != TIME_LIMIT and not (outcome == SUCCESS and length >= SHORT):
                c, length, ends = _linear_series(c, size), min(SHORT, most - t), False
                kept = evaluated(c, length)
            place = _first_root(c[rows:], length) if len(c) > rows else math.inf
            if place <= 1.0 - beyond:
                length, ends = (place + beyond) * length, False
                kept = evaluated(c, length)
                # rounding may have left the state before the edge: marks must be those of the state
                kept[rows:] = marks(kept[:size], p)[rows - len(kept) :]
            beyond = 2.0 * beyond if place <= beyond else BEYOND
            c, guards = (c[:rows], c[rows:rows]) if varies else (c[:size], c[size:rows])
            yield Step(length, guards, partial(_states, c[:size]), partial(_exact, c, size))
            t += length
            if ends:
                return
        raise StoppedError(MotionStatus.STEPS_LIMIT)

    return steps


def _linear_series(c: Floats, size: int) -> Floats:
    """Series cut after the linear term; StoppedError if that is not finite, or not enough."""
    if not np.isfinite(c[:size, :2]).all():
        known = np.isfinite(c[:size, 0]).all()
        raise StoppedError(MotionStatus.NO_FORCE if known else MotionStatus.OVERFLOW)
    state, rate = np.abs(c[:size, :2]).T
    if state.max() > LARGE or (rate * SHORT > GROWS * (1.0 + state)).any():
        raise StoppedError(MotionStatus.OVERFLOW)
    if not (np.abs(c[size:, 1]) * SHORT <= KNOWN_SLOPE * (1.0 + np.abs(c[size:, 0]))).all():
        raise StoppedError(MotionStatus.NO_SLOPE)
    return np.where(np.arange(c.shape[1]) < 2, c, 0.0)


def _first_root(c: Floats, length: float) -> float:
    """First place in a step, from 0 to 1, where one of some power series changes sign; or inf."""
    found = math.inf
    for row in scaled(c, length, np.zeros(len(c), dtype=np.int64)):
        b = row @ bernstein(len(row))[WHOLE]
        if np.abs(b).max() > NOISE:
            found = min([found, *roots(row, b, bernstein(len(row))).tolist()])
    return found


def _states(c: Floats, times: Floats) -> Floats:
    return np.asarray(polyval(times, c.T).T, dtype=float)  # powers of long times overflow


def _exact(c: Floats, size: int, t: float) -> tuple[Floats, Floats]:
    y = evaluated(c, t)
    return y[:size], y[size:].reshape(size, -1)


def jets(eq: Equations, mode: Mode) -> Callable[[Floats, Floats], Floats]:
    """Compile the jets of a mode to a function of state and parameters.

    It returns accelerations (n,), and forces lambda_N and lambda_T (m,); then for each guard of the
    mode its value and its time derivatives up to the order ``KNOWN``
    (:mod:`woodpecker.systems.mechanics.index_sets`).
    """
    terms = _Expressions(eq, mode)
    found = [*terms.a, *terms.l_n, *terms.l_t]
    for guard, value in zip(eq.sets(mode).places, terms.guards(), strict=True):
        jet = [value]
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
    """State z = (q, u, t), z', accelerations and forces in a mode, as expressions of heyoka."""

    def __init__(self, eq: Equations, mode: Mode) -> None:
        self._eq, self._sets = eq, eq.sets(mode)
        self.state = [hy.expression(f"z{k}") for k in range(eq.size)]
        values = [hy.par[k] for k in range(len(eq.p))]
        self.names = dict(zip(eq.symbols, [*self.state, *values], strict=True))
        empty: Any = np.empty(0)
        self._terms = Terms(*map(self._converted, eq.expressions._replace(eps=empty)))
        a, l_n, l_t = balance(self._sets, self._terms, _eliminated)
        self.a, self.l_n, self.l_t = self._kept(a), *map(_expressions, (l_n, l_t))
        self.rates = [*self.state[eq.n : 2 * eq.n], *self.a, hy.expression(1.0)]

    def _converted(self, array: Any) -> Any:
        found = np.empty(array.shape, dtype=object)
        for place, entry in np.ndenumerate(array):
            found[place] = _converted(entry, self.names)
        return found

    def _kept(self, a: Floats) -> list[Any]:
        """Accelerations that keep w a + bar at zero up to the rounding of this sum alone."""
        # The rounding of the whole system would add up over a phase, and a closed contact drift.
        # One is replaced only if it is safe to divide by its entry of w: a number, or the only one.
        found: list[Any] = a.tolist()
        left, t = set(range(len(a))), self._terms
        bars = [(t.w_n[i], t.bar_n[i]) for i in self._sets.closed]
        bars += [(t.w_t[i], t.bar_t[i]) for i in self._sets.stuck]
        for row, bar in bars:
            moves = [j for j, entry in enumerate(row) if not _is_zero(entry)]
            safe = [j for j in moves if j in left and (len(moves) == 1 or _is_number(row[j]))]
            if safe:
                j = safe[0]
                left.remove(j)
                found[j] = -(bar + hy.sum([row[k] * found[k] for k in moves if k != j])) / row[j]
        return found

    def guards(self) -> list[Any]:
        """All guards of the mode."""
        forces = Balance(*map(np.array, (self.a, self.l_n, self.l_t)))
        return [np.ravel(each)[0] for each in guard_values(self._sets, self._terms, forces)]

    def edges(self) -> list[Any]:
        """Expressions that vanish where a step has to end."""
        found, entries = edges(self._eq.entries), self._eq.entries
        for kind, most in CONSTANT.items():
            for each in sorted({a.args[0] for e in entries for a in e.atoms(kind)}, key=str):
                found += [each - most, each + most]
        return [_converted(each, self.names) for each in found]

    def rate(self, value: Any) -> Any:
        """The time derivative of an expression."""
        slopes = hy.diff_tensors([value], diff_args=self.state).gradient
        return hy.sum([d * v for d, v in zip(slopes, self.rates, strict=True) if not _is_zero(d)])


def _converted(entry: sympy.Expr, names: Mapping[sympy.Expr, Any]) -> Any:
    """An expression of heyoka, with whole powers as products: heyoka's own are nan at zero."""
    if entry.is_number:
        return hy.expression(float(entry))
    known: dict[sympy.Expr, Any] = dict(names)
    known |= {r: hy.expression(float(r)) for r in entry.atoms(sympy.Rational) if r.q & (r.q - 1)}
    known |= {cases: _selected(cases, names) for cases in entry.atoms(sympy.Piecewise)}
    for power in entry.atoms(sympy.Pow):
        if power.exp.is_Number and power.exp > 0 and float(power.exp).is_integer():
            known[power] = math.prod([_converted(power.base, names)] * int(power.exp))
    try:
        return hy.from_sympy(entry, known)
    except (TypeError, ValueError) as error:
        raise ValueError(f"heyoka has no Taylor series of {entry}: {error}") from error


def _selected(cases: sympy.Piecewise, names: Mapping[sympy.Expr, Any]) -> Any:
    """Cases of Piecewise as nested selections of heyoka."""
    # heyoka multiplies the derivatives of a case that does not hold by 0: a root of a negative
    # number would make them nan, so where the case does not hold it is the root of 1
    found, count = hy.expression(math.nan), len(cases.args)
    others = [(1, condition) for _, condition in cases.args]
    for k, (value, condition) in zip(range(count)[::-1], cases.args[::-1], strict=True):
        known = dict(names)
        for root in value.atoms(sympy.Pow):
            if not root.exp.is_integer:
                base = sympy.Piecewise(*others[:k], (root.base, condition), (1, True))
                known[root] = _converted(base, names) ** _converted(root.exp, names)
        own = _converted(value, known)
        found = own if condition == sympy.true else hy.select(_holds(condition, names), own, found)
    return found


def _holds(condition: Any, names: Mapping[sympy.Expr, Any]) -> Any:
    if isinstance(condition, sympy.And | sympy.Or):
        join = hy.logical_and if isinstance(condition, sympy.And) else hy.logical_or
        return join([_holds(each, names) for each in condition.args])
    if isinstance(condition, sympy.ITE):
        return _holds(condition.to_nnf(), names)
    return RELATIONS[type(condition)](*(_converted(each, names) for each in condition.args))


def _eliminated(matrix: Any, right: Any) -> Any:
    """The solution of a linear system of expressions, by elimination without pivoting."""
    # The mass matrix is positive definite, and so, but for friction, is its Schur complement.
    rows, x = np.column_stack([matrix, right]), np.array(right)
    for k in range(len(x)):
        for j in range(k + 1, len(x)):
            rows[j, k:] = rows[j, k:] - rows[j, k] / rows[k, k] * rows[k, k:]
    for k in reversed(range(len(x))):
        x[k] = rows[k, -1]
        for j in range(k + 1, len(x)):
            x[k] = x[k] - rows[k, j] * x[j]
        x[k] = x[k] / rows[k, k]
    return x


def _expressions(values: Any) -> list[Any]:
    """Values as expressions of heyoka, numbers included."""
    return [each if isinstance(each, hy.expression) else hy.expression(float(each))
            for each in values]  # fmt: skip


def _is_number(value: Any) -> bool:
    return not hy.get_variables(value) and not hy.get_params(value)


def _is_zero(value: Any) -> bool:
    return bool(value == hy.expression(0.0))
