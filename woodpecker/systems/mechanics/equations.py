"""The equations of a system as functions of numbers, with derivatives.

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
from woodpecker.systems.mechanics.index_sets import IndexSets
from woodpecker.systems.mechanics.model import Contact, ContactSystem

NEVER = Contact(name="no contact", gap=1)  # in place of contacts, where there are none: it is open
Numbers = Callable[..., list[Floats]]  # from a point, in parts, to arrays of numbers


class Terms(NamedTuple):
    """The terms of Eq. (1)-(3) at one state, or at a batch (...) of states.

    The gap rates are w_N u + w-hat_N, the slips w_T u + w-hat_T, and their derivatives
    w_N u' + w-bar_N and w_T u' + w-bar_T. The expression of a section is one more slip, the last.
    """

    mass: Floats  # (..., n, n)
    force: Floats  # (..., n), h
    w_n: Floats  # (..., m, n)
    w_t: Floats  # (..., m, n), or one row more
    gap: Floats  # (..., m)
    gap_rate: Floats
    slip: Floats  # (..., m), or one more
    bar_n: Floats
    bar_t: Floats
    mu: Floats
    eps: Floats


def compiled(symbols: Sequence[sympy.Symbol], arrays: Sequence[Any]) -> Numbers:
    """Compile arrays of expressions to a function of a point, whose coordinates come in parts.

    All entries are nan where one of them has no value.
    """
    tables = [np.array(each, dtype=object) for each in arrays]
    entries = [sympy.sympify(entry) for each in tables for entry in each.ravel().tolist()]
    ends = np.cumsum([each.size for each in tables]).tolist()
    parts = [(slice(end - each.size, end), each) for end, each in zip(ends, tables, strict=True)]
    made = sympy.lambdify(symbols, entries, "math", cse=True)

    def numbers(*point: Floats) -> list[Floats]:
        try:
            flat = np.array(made(*np.concatenate(point).tolist()), dtype=float)
        except (ValueError, ZeroDivisionError, OverflowError, TypeError):  # TypeError: complex
            flat = np.full(len(entries), np.nan)
        return [flat[part].reshape(each.shape) for part, each in parts]

    return numbers


class Equations:
    """All functions of a system that a motion needs.

    Parameters
    ----------
    system
        The system.
    free
        Names of the parameters in which derivatives are taken.
    when, sticking
        The expression of a section, if it has one, and which contacts must stick there.

    Attributes
    ----------
    n, m
        How many coordinates and contacts.
    size, columns
        How many numbers a state has, and how many derivatives: in z, then in free parameters.
    friction
        (m,) which contacts have friction.
    slips
        (m,) for each contact the first one with the same slip: such contacts stick together, as the
        feet of a body do, and only the sum of their friction is known.
    along
        The symbols in which derivatives are taken.
    expressions, entries
        The terms as arrays of expressions, and the list of all their entries.
    is_autonomous
        Whether M, h, gaps and slips do not contain time.
    kinematic_changes(z, p)
        Derivatives of gaps, gap rates and slips, (m, columns) each; of slips one more with a
        section.
    motion_changes(z, p, a, lambda_N, lambda_T)
        Those of M a - h - W lambda (n), of both contact accelerations (m), and of mu (m), at fixed
        accelerations and forces.
    impact_changes(z, p, u', Lambda_N, Lambda_T)
        Those of M (u' - u) - W Lambda, of gap rate and slip after, gap rate before, mu and eps_N,
        at fixed u' and Lambda.
    sets(mode)
        The index sets of a mode.
    jets, flow
        Of a mode: its compiled function of state and parameters
        (:func:`woodpecker.systems.simulation.taylor.jets`; None without a compiler), its motion.
    """

    def __init__(
        self, system: ContactSystem, free: Sequence[str] = (), when: sympy.Expr | None = None,
        sticking: Sequence[int] = (),
    ) -> None:  # fmt: skip
        self.system, self.n = system, system.n
        self.contacts = system.contacts or (NEVER,)
        self.m = len(self.contacts)
        self.size = 2 * self.n + 1
        self.free, moving = tuple(free), system.named(free)
        self.places = [list(system.parameters).index(symbol) for symbol in moving]
        self.columns = self.size + len(free)
        self.p = np.array(list(system.parameters.values()))
        self.friction = tuple(each.rubs for each in self.contacts)
        self.slips = _equal_slips(self.contacts, system.q)
        self.symbols = (*system.state, *system.parameters)
        self.along = (*system.state, *moving)
        self.when, on = when, None if when is None else tuple(sticking)
        self.sets = cache(partial(IndexSets, self.n, self.friction, self.slips, on))
        self._last: tuple[bytes, bytes, Terms] | None = None
        self.jets: Callable[[tuple[int, ...]], Callable[..., Floats]] | None = None
        self.flow: Callable[..., Callable[..., Iterator[Any]]]
        self.again: Callable[[], Equations] = partial(Equations, system, free, when, sticking)
        self._derive()

    def __reduce__(self) -> tuple[Callable[[], Equations], tuple[()]]:
        return self.again, ()  # compiled functions cannot be sent

    def _derive(self) -> None:
        """Set up Eq. (1)-(3) and their derivatives, by sympy."""
        system = self.system
        q, u, t = sympy.Matrix(system.q), sympy.Matrix(system.u), system.time
        a = sympy.Matrix(sympy.symbols(f"_a:{self.n}"))
        new = sympy.Matrix(sympy.symbols(f"_v:{self.n}"))
        l_n = sympy.Matrix(sympy.symbols(f"_n:{self.m}"))
        l_t = sympy.Matrix(sympy.symbols(f"_t:{self.m}"))
        gap = sympy.Matrix([each.gap for each in self.contacts])
        slips = [each.slip or sympy.Integer(0) for each in self.contacts]
        # a guard falls through zero, the expression of a section rises: hence the minus
        slip = sympy.Matrix(slips if self.when is None else [*slips, -self.when])
        mu = sympy.Matrix([each.mu for each in self.contacts])
        eps = sympy.Matrix([each.eps_n for each in self.contacts])
        w_n, w_t = gap.jacobian(q), slip.jacobian(u)
        rate = w_n * u + gap.diff(t)
        bar_n = rate.jacobian(q) * u + rate.diff(t)
        bar_t = slip.jacobian(q) * u + slip.diff(t)
        parts = system.M, system.h, w_n, w_t, gap, rate, slip, bar_n, bar_t, mu, eps
        made = [np.array(each, dtype=object) for each in parts]
        flat = [each.ravel() if each.shape[1] == 1 else each for each in made]
        self.expressions = Terms(made[0], flat[1], made[2], made[3], *flat[4:])
        self.entries: list[Any] = [each for array in self.expressions for each in array.flat]
        self.is_autonomous = not any(
            each.has(t) for each in (system.M, system.h, gap, sympy.Matrix(slips))
        )
        self._terms = compiled(self.symbols, self.expressions)
        pull = w_n.T * l_n + w_t[: self.m, :].T * l_t
        motion = [system.M * a - system.h - pull, w_n * a + bar_n, w_t * a + bar_t, mu]
        after = dict(zip(system.state[self.n : -1], new, strict=True))
        impact = [
            system.M * (new - u) - pull, rate.subs(after), slip.subs(after), rate, mu, eps,
        ]  # fmt: skip
        self.motion_changes = self._changes(motion, (*a, *l_n, *l_t))
        self.impact_changes = self._changes(impact, (*new, *l_n, *l_t))
        self.kinematic_changes = self._changes([gap, rate, slip], ())

    def _changes(self, parts: Sequence[Any], more: Sequence[sympy.Symbol]) -> Numbers:
        return compiled((*self.symbols, *more), [each.jacobian(self.along) for each in parts])

    def terms(self, z: Floats, p: Floats) -> Terms:
        """The terms at one state (N,), or at a batch (b, N); the last ones are remembered."""
        if z.ndim > 1:
            return Terms(*map(np.stack, zip(*(self._terms(each, p) for each in z), strict=True)))
        key = z.tobytes(), p.tobytes()
        if self._last is None or self._last[:2] != key:
            self._last = *key, Terms(*self._terms(z, p))
        return self._last[2]


def _equal_slips(contacts: Sequence[Contact], q: Sequence[Any]) -> tuple[int, ...]:
    """For each contact, the first one that has the same slip while both are closed."""
    found = list[int]()
    for i, each in enumerate(contacts):
        same = (
            k for k in sorted(set(found))
            if each.rubs and contacts[k].rubs
            and are_equal(
                each.slip, contacts[k].slip, (each.gap, contacts[k].gap), q
            )
        )  # fmt: skip
        found.append(next(same, i))
    return tuple(found)
