"""The equations of a system as functions of numbers, with their derivatives.

A state is z = (q, u, t); p are the values of all parameters. Derivatives are taken in z and in some
of the parameters, which are called free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import sympy

from woodpecker.base.arrays import Floats
from woodpecker.systems.mechanics.expressions import are_equal
from woodpecker.systems.mechanics.index_sets import STICK, IndexSets, Mode
from woodpecker.systems.mechanics.model import ContactSystem


class Terms(NamedTuple):
    """What Eq. (1)-(3) consist of, at one state or at a batch (...) of them.

    The gap rates are w_N u + w-hat_N, the slips w_T u + w-hat_T, and their derivatives
    w_N u' + w-bar_N and w_T u' + w-bar_T.
    """

    mass: Floats  # (..., n, n)
    force: Floats  # (..., n), h
    w_n: Floats  # (..., m, n)
    w_t: Floats  # (..., m, n)
    gap: Floats  # (..., m)
    gap_rate: Floats
    slip: Floats
    bar_n: Floats
    bar_t: Floats
    mu: Floats
    eps: Floats


class Function:
    """A list of arrays of expressions, compiled once; of numbers, or of arrays of them."""

    def __init__(self, symbols: Sequence[sympy.Symbol], arrays: Sequence[Any]) -> None:
        ends = np.cumsum([each.size for each in arrays]).tolist()
        shapes = [each.shape for each in arrays]
        parts = map(slice, [0, *ends[:-1]], ends)
        self._parts = list(zip(parts, shapes, strict=True))
        self._flat = [sympy.sympify(entry) for each in arrays for entry in each.ravel().tolist()]
        self._symbols = symbols
        self._one: Callable[..., Any] = self._compiled("math")
        self._many: Callable[..., Any] | None = None

    def _compiled(self, modules: str) -> Callable[..., Any]:
        made: Callable[..., Any] = sympy.lambdify(
            self._symbols, self._flat, modules=modules, cse=True
        )
        return made

    def __call__(self, *numbers: Floats) -> list[Floats]:
        """Arrays at one point, whose coordinates are given in parts; nan where there are none."""
        try:
            flat = np.array(self._one(*np.concatenate(numbers).tolist()), dtype=float)
        except (ValueError, ZeroDivisionError, OverflowError, TypeError):  # TypeError: complex
            flat = np.full(len(self._flat), np.nan)
        return [
            flat[part] if len(shape) == 1 else flat[part].reshape(shape)
            for part, shape in self._parts
        ]

    def batch(self, z: Floats, p: Floats) -> list[Floats]:
        """The same at many states (b, N), the batch first."""
        if self._many is None:
            self._many = self._compiled("scipy")
        flat = np.empty((len(z), len(self._flat)))
        with np.errstate(all="ignore"):
            for k, value in enumerate(self._many(*z.T, *p)):
                flat[:, k] = value
        return [flat[:, part].reshape(-1, *shape) for part, shape in self._parts]


class Equations:
    """All functions of a system that a motion needs.

    Parameters
    ----------
    system
        The system.
    free
        Names of the parameters in which derivatives are taken.

    Attributes
    ----------
    n, m
        How many coordinates and contacts.
    size, columns
        Numbers of a state, and of derivatives: those in z, then those in free parameters.
    friction
        (m,) which contacts have it.
    slips
        (m,) for each contact the first one with the same slip: such contacts stick together, as the
        feet of a body do, and only the sum of their friction is known.
    along
        The symbols in which derivatives are taken.
    expressions, entries
        The terms as arrays of expressions, and all of these.
    is_autonomous
        Whether none of them has time.
    kinematic_changes(z, p)
        Derivatives of gaps, gap rates and slips, (m, columns) each.
    motion_changes(z, p, a, lambda_N, lambda_T)
        Those of M a - h - W lambda (n), of both contact accelerations (m), and of mu (m), with
        accelerations and forces fixed.
    impact_changes(z, p, u', Lambda_N, Lambda_T)
        Those of M (u' - u) - W Lambda, of gap rate and slip after, gap rate before, mu and eps_N,
        with u' and Lambda fixed.
    sets(mode)
        What follows from a mode.
    section
        The guard of a section; None if there is none, or if its event is an impact.
    jets, flow
        Make of a mode a compiled function of state and parameters
        (:func:`woodpecker.systems.simulation.taylor.jets`; None without a compiler) and its motion.
    """

    def __init__(self, system: ContactSystem, free: Sequence[str] = ()) -> None:
        self.system, self.n, self.m = system, system.n, len(system.contacts)
        self.size = 2 * self.n + 1
        self.free, moving = tuple(free), system.named(free)
        self.places = [list(system.parameters).index(symbol) for symbol in moving]
        self.columns = self.size + len(free)
        self.p = np.array(list(system.parameters.values()))
        self.friction = tuple(each.rubs for each in system.contacts)
        self.slips = _equal_slips(system)
        self.symbols = (*system.state, *system.parameters)
        self.along = (*system.state, *moving)
        self.sets = cache(partial(IndexSets, self.n, self.friction, self.slips))
        self.section: SectionGuard | None = None
        self._last: tuple[bytes, bytes, Terms] | None = None
        self.jets: Callable[[tuple[int, ...]], Callable[..., Floats]] | None = None
        self.flow: Callable[..., Callable[..., Iterator[Any]]]
        self._derive()

    def _derive(self) -> None:
        """The derivatives of Eq. (1)-(3), by sympy."""
        system = self.system
        q, u, t = sympy.Matrix(system.q), sympy.Matrix(system.u), system.time
        a = sympy.Matrix(sympy.symbols(f"_a:{self.n}"))
        new = sympy.Matrix(sympy.symbols(f"_v:{self.n}"))
        l_n = sympy.Matrix(sympy.symbols(f"_n:{self.m}"))
        l_t = sympy.Matrix(sympy.symbols(f"_t:{self.m}"))
        gap = sympy.Matrix([each.gap for each in system.contacts])
        slip = sympy.Matrix([each.slip or sympy.Integer(0) for each in system.contacts])
        mu = sympy.Matrix([each.mu for each in system.contacts])
        eps = sympy.Matrix([each.eps_n for each in system.contacts])
        w_n, w_t = gap.jacobian(q), slip.jacobian(u)
        rate = w_n * u + gap.diff(t)
        bar_n = rate.jacobian(q) * u + rate.diff(t)
        bar_t = slip.jacobian(q) * u + slip.diff(t)
        parts = system.M, system.h, w_n, w_t, gap, rate, slip, bar_n, bar_t, mu, eps
        made = [np.array(each, dtype=object) for each in parts]
        flat = [each.ravel() if each.shape[1] == 1 else each for each in made]
        self.expressions = Terms(made[0], flat[1], made[2], made[3], *flat[4:])
        self.entries: list[Any] = [each for array in self.expressions for each in array.flat]
        self.is_autonomous = not any(each.has(t) for each in self.entries)
        self._terms = Function(self.symbols, self.expressions)
        pull = w_n.T * l_n + w_t.T * l_t
        motion = [system.M * a - system.h - pull, w_n * a + bar_n, w_t * a + bar_t, mu]
        after = dict(zip(system.state[self.n : -1], new, strict=True))
        impact = [
            system.M * (new - u) - pull, rate.subs(after), slip.subs(after), rate, mu, eps,
        ]  # fmt: skip
        self.motion_changes = self._changes(motion, (*a, *l_n, *l_t))
        self.impact_changes = self._changes(impact, (*new, *l_n, *l_t))
        self.kinematic_changes = self._changes([gap, rate, slip], ())

    def _changes(self, parts: Sequence[Any], more: Sequence[sympy.Symbol]) -> Function:
        return self.function([each.jacobian(self.along) for each in parts], more)

    def terms(self, z: Floats, p: Floats) -> Terms:
        """The terms at one state (N,), or at a batch (b, N); the last ones are remembered."""
        if z.ndim > 1:
            return Terms(*self._terms.batch(z, p))
        key = z.tobytes(), p.tobytes()
        if self._last is None or self._last[:2] != key:
            self._last = *key, Terms(*self._terms(z, p))
        return self._last[2]

    def function(self, arrays: Sequence[Any], more: Sequence[sympy.Symbol] = ()) -> Function:
        """Expressions of state, parameters and some more, compiled."""
        return Function((*self.symbols, *more), [np.array(each, dtype=object) for each in arrays])

    def section_in(self, mode: Mode) -> SectionGuard | None:
        """The guard of the section, if it counts in a mode."""
        found = self.section
        counts = found is not None and all(mode[i] == STICK for i in found.sticking)
        return found if counts else None


class SectionGuard:
    """An expression that rises through zero while some contacts stick, as a guard that falls."""

    def __init__(self, eq: Equations, when: sympy.Expr, sticking: Sequence[int]) -> None:
        a = sympy.symbols(f"_a:{eq.n}")
        flow = (*eq.system.state[eq.n : -1], *a, sympy.Integer(1))
        value = -when
        rate = sum(value.diff(s) * v for s, v in zip(eq.system.state, flow, strict=True))
        both = sympy.Matrix([value, rate])
        self._function = eq.function([both.jacobian(eq.along), both.jacobian(a)], a)
        self._values = eq.function([both], a)
        self._value = eq.function([sympy.Matrix([value])])
        self.when, self.sticking = when, sticking

    def values(self, z: Floats, p: Floats) -> Floats:
        """Values (b,) at states (b, N)."""
        return self._value.batch(z, p)[0].reshape(-1)

    def jet(self, z: Floats, p: Floats, a: Floats) -> list[float]:
        """Value and rate, from state, parameters and accelerations."""
        found: list[float] = self._values(z, p, a)[0][:, 0].tolist()
        return found

    def gradients(self, z: Floats, p: Floats, a: Floats, changes: Floats) -> tuple[Floats, Floats]:
        """Derivatives (columns,) of value and rate, from those of accelerations (n, columns)."""
        along, per_a = self._function(z, p, a)
        return along[0], along[1] + per_a[1] @ changes


def _equal_slips(system: ContactSystem) -> tuple[int, ...]:
    """For each contact the first one with the same slip."""
    found = list[int]()
    for i, each in enumerate(system.contacts):
        same = (
            k for k in sorted(set(found))
            if each.rubs and system.contacts[k].rubs
            and are_equal(each.slip, system.contacts[k].slip)
        )  # fmt: skip
        found.append(next(same, i))
    return tuple(found)
