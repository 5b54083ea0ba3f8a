"""Index sets: accelerations, forces and guards of a system of contacts.

A mode is the state of every contact. In it accelerations and contact forces solve

    M a - W_N lambda_N - W_T lambda_T = h,   gap acceleration zero where a contact is closed,
    slip acceleration zero where it sticks,  lambda_T = -+mu lambda_N where it slides.

Where closed contacts hold a system more than once, as three feet do in the plane, their forces are
open but the motion is not: those that the others keep closed are idle, and have no force, and of
those that the others keep from slipping some have the most friction that they can.

A guard is a function of the state that is positive as long as the mode lasts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy

from woodpecker.base.arrays import Floats, Ints
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.impacts import solved

# states of a contact; SLIDE_UP: its slip is positive; IDLE: closed, because others are; EDGE_UP: it
# sticks, because others do, with the friction of SLIDE_UP
OPEN, STICK, SLIDE_UP, SLIDE_DOWN, IDLE, EDGE_UP, EDGE_DOWN = range(7)
GAP, NORMAL, CONE_UP, CONE_DOWN, SLIP = range(5)  # kinds of guards: kind * m + contact
SECTION = 5  # 5 m is the guard of a section

# derivatives of guards in time that are known
KNOWN = {GAP: 3, NORMAL: 1, CONE_UP: 1, CONE_DOWN: 1, SLIP: 2, SECTION: 2}

Mode = tuple[int, ...]


def guards_of(eq: Equations, mode: Mode) -> tuple[int, ...]:
    """All guards of a mode: gaps of open contacts, forces of closed ones, slips of sliding ones.

    Where a contact sticks its force vanishes only where a cone is reached, too; but not in a team
    of contacts with the same slip, of which the first has the cone of all.
    """
    return guards_in(mode, eq.friction, eq.slips)


@lru_cache(maxsize=1024)
def team_of(mode: Mode, slips: tuple[int, ...], i: int) -> tuple[int, ...]:
    """The contacts that stick together with one, itself among them."""
    return tuple(k for k in range(len(mode)) if mode[k] == STICK and slips[k] == slips[i])


@lru_cache(maxsize=1024)
def places_of(n: int, mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...]) -> dict[int, int]:
    """Where the guards of a mode are among its compiled numbers."""
    m, found = len(mode), dict[int, int]()
    place = n + 2 * m
    for guard in guards_in(mode, rubs, slips):
        found[guard] = place
        place += KNOWN[guard // m] + 1
    return found


@lru_cache(maxsize=1024)
def guards_in(mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...]) -> tuple[int, ...]:
    """The same, of contacts that have friction and of those with the same slip."""
    m, found = len(mode), list[int]()
    for i, state in enumerate(mode):
        if state == OPEN:
            found.append(GAP * m + i)
        elif state == STICK:
            team = team_of(mode, slips, i)
            if team[0] == i:
                found += [CONE_UP * m + i, CONE_DOWN * m + i]
            if len(team) > 1:
                found.append(NORMAL * m + i)
        elif state != IDLE:
            found.append(NORMAL * m + i)
            if rubs[i] and state in (SLIDE_UP, SLIDE_DOWN):
                found.append(SLIP * m + i)
    return tuple(found)


class Balance(NamedTuple):
    """Accelerations and forces."""

    a: Floats  # (..., n)
    l_n: Floats  # (..., m)
    l_t: Floats  # (..., m)


def balance(
    eq: Equations, mode: Mode, terms: Terms, solve: Callable[[Floats, Floats], Floats] | None = None
) -> Balance:
    """Accelerations and forces in a mode, at one state or a batch; nan where there are none.

    With a way to solve linear systems of expressions the terms may be expressions.
    """
    n, m, kind = eq.n, eq.m, terms.force.dtype
    closed, stuck, sign = parts_of(mode, eq.slips)
    batch = terms.force.shape[:-1]
    middle, size = n + len(closed), n + len(closed) + len(stuck)
    right = np.zeros((*batch, size), kind)
    right[..., :n] = terms.force
    right[..., n:middle], right[..., middle:] = (
        -terms.bar_n[..., closed],
        -terms.bar_t[..., stuck],
    )
    x = (solve or _solve)(_matrix(eq, mode, terms), right)
    l_n, l_t = np.zeros((*batch, m), kind), np.zeros((*batch, m), kind)
    l_n[..., closed] = x[..., n:middle]
    l_t[...] = sign * terms.mu * l_n
    l_t[..., stuck] = x[..., middle:]
    return Balance(x[..., :n], l_n, l_t)


def _matrix(eq: Equations, mode: Mode, terms: Terms) -> Floats:
    """The matrix (..., n + c, n + c) of the linear system that they solve."""
    n = eq.n
    closed, stuck, sign = parts_of(mode, eq.slips)
    middle, size = n + len(closed), n + len(closed) + len(stuck)
    k = np.zeros((*terms.force.shape[:-1], size, size), terms.force.dtype)
    k[..., :n, :n] = terms.mass
    if len(closed):
        pull = terms.w_n + (sign * terms.mu)[..., None] * terms.w_t
        k[..., :n, n:middle] = -np.swapaxes(pull[..., closed, :], -1, -2)
        k[..., :n, middle:] = -np.swapaxes(terms.w_t[..., stuck, :], -1, -2)
        k[..., n:middle, :n] = terms.w_n[..., closed, :]
        k[..., middle:, :n] = terms.w_t[..., stuck, :]
    return k


@lru_cache(maxsize=1024)
def parts_of(mode: Mode, slips: tuple[int, ...]) -> tuple[Ints, Ints, Floats]:
    """Closed contacts, the first of each team that sticks, signs of lambda_T = sign mu lambda_N."""
    states = np.array(mode)
    sign = np.array([0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 1.0])[states]
    stuck = [
        i for i, state in enumerate(mode) if state == STICK and team_of(mode, slips, i)[0] == i
    ]
    return np.flatnonzero((states != OPEN) & (states != IDLE)), np.array(stuck, dtype=int), sign


def _solve(k: Floats, right: Floats) -> Floats:
    """Solutions of systems (..., s, s) with one right side (..., s) each; nan without."""
    try:
        return np.asarray(np.linalg.solve(k, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        return solved(k.reshape(-1, *k.shape[-2:]), right.reshape(-1, right.shape[-1])).reshape(
            right.shape
        )


def _solve_columns(k: Floats, right: Floats) -> Floats:
    """The solution (s, c) of one system (s, s) with several right sides; nan without."""
    try:
        return np.asarray(np.linalg.solve(k, right))
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)


def guard_values(eq: Equations, mode: Mode, terms: Terms, forces: Balance) -> list[Any]:
    """Values (...) of all guards of a mode, at one state or a batch, or as expressions."""
    rows = []
    for guard in guards_of(eq, mode):
        kind, i = divmod(guard, eq.m)
        if kind == GAP:
            rows.append(terms.gap[..., i])
        elif kind == SLIP:
            rows.append(terms.slip[..., i] if mode[i] == SLIDE_UP else -terms.slip[..., i])
        else:
            bound = _bound(eq, mode, i, terms.mu, forces.l_n)
            rows.append(_force_guard(kind, forces.l_n[..., i], bound, forces.l_t[..., i]))
    return rows


def _force_guard(kind: int, l_n: Floats, bound: Floats, l_t: Floats) -> Floats:
    if kind == NORMAL:
        return l_n
    return bound - l_t if kind == CONE_UP else bound + l_t


def _bound(eq: Equations, mode: Mode, i: int, mu: Floats, l_n: Floats) -> Floats:
    """The bound (...) of the friction of all that stick together with a contact."""
    team = list(team_of(mode, eq.slips, i))
    found: Floats = (mu[..., team] * l_n[..., team]).sum(axis=-1)
    return found


class SectionGuard:
    """An expression that rises through zero, as a guard that falls."""

    def __init__(self, eq: Equations, when: sympy.Expr) -> None:
        a = sympy.symbols(f"_a:{eq.n}")
        system = eq.system
        flow = (*system.u, *a, sympy.Integer(1)) if system.u is not None else ()
        value = -when
        rate = sum(value.diff(s) * v for s, v in zip(system.state, flow, strict=True))
        both = sympy.Matrix([value, rate])
        self._function = eq.function([both.jacobian(eq.along), both.jacobian(a)], a)
        self._values = eq.function([both], a)
        self._value = eq.function([sympy.Matrix([value])])
        self.when = when

    def values(self, z: Floats, p: Floats) -> Floats:
        """Values (b,) at states (b, N)."""
        return self._value.batch(z, p)[0].reshape(-1)

    def jet(self, here: Local) -> list[float]:
        """Value and rate."""
        found: list[float] = self._values(here.z, here.p, here.balance.a)[0][:, 0].tolist()
        return found

    def gradients(self, here: Local) -> tuple[Floats, Floats]:
        """Derivatives (columns,) of value and rate."""
        along, per_a = self._function(here.z, here.p, here.balance.a)
        return along[0], along[1] + per_a[1] @ here.changes[0]


class Local:
    """A mode at one state: motion and guards, and their derivatives where they are asked for.

    Attributes
    ----------
    section
        The guard of a section that counts in the mode, if any.
    numbers
        Accelerations, forces and guards with derivatives, if they are compiled and finite.
    """

    def __init__(
        self, eq: Equations, mode: Mode, z: Floats, p: Floats, section: SectionGuard | None = None
    ) -> None:
        self.eq, self.mode, self.z, self.p, self.section = eq, mode, z, p, section
        self.numbers: list[float] | None = None
        if eq.jets is not None:
            found: list[float] = eq.jets(mode)(z, p).tolist()
            self.numbers = found if math.isfinite(sum(found)) else None

    @cached_property
    def terms(self) -> Terms:
        """The terms of the equations of motion."""
        return self.eq.terms(self.z, self.p)

    @cached_property
    def balance(self) -> Balance:
        """Accelerations and forces."""
        found, n, m = self.numbers, self.eq.n, self.eq.m
        if found is None:
            return balance(self.eq, self.mode, self.terms)
        whole = np.array(found[: n + 2 * m])
        return Balance(whole[:n], whole[n : n + m], whole[n + m :])

    @cached_property
    def flow(self) -> Floats:
        """(N,) z' = (u, a, 1)."""
        n = self.eq.n
        return np.concatenate([self.z[n : 2 * n], self.balance.a, [1.0]])

    @cached_property
    def changes(self) -> tuple[Floats, Floats, Floats]:
        """Derivatives (.., columns) of accelerations and forces, in z and free parameters."""
        eq, t, n = self.eq, self.terms, self.eq.n
        l_n, k = self.balance.l_n, _matrix(eq, self.mode, self.terms)
        closed, stuck, sign = parts_of(self.mode, eq.slips)
        motion, d_n, d_t, d_mu = self._partial
        load = (sign * l_n)[:, None] * d_mu
        right = -np.vstack([motion - t.w_t.T @ load, d_n[closed], d_t[stuck]])
        x = _solve_columns(k, right)
        change_n, change_t = np.zeros((eq.m, eq.columns)), np.zeros((eq.m, eq.columns))
        change_n[closed] = x[n : n + len(closed)]
        change_t[:] = (sign * t.mu)[:, None] * change_n + load
        change_t[stuck] = x[n + len(closed) :]
        return x[:n], change_n, change_t

    @cached_property
    def _partial(self) -> list[Floats]:
        return self.eq.motion_changes(self.z, self.p, *self.balance)

    @cached_property
    def jacobian(self) -> Floats:
        """(N, columns) derivatives of z'."""
        n, size = self.eq.n, self.eq.size
        found = np.zeros((size, self.eq.columns))
        found[:n, n : 2 * n] = np.eye(n)
        found[n : 2 * n] = self.changes[0]
        return found

    def jet(self, guard: int, order: int = 3) -> list[float]:
        """Value of a guard and its derivatives in time, up to an order or as far as known.

        Known are three derivatives of gaps, two of slips and a section, one of forces.
        """
        most = min(order, KNOWN[guard // self.eq.m])
        return [self.derivative(guard, k) for k in range(most + 1)]

    def derivative(self, guard: int, order: int) -> float:
        """A guard's derivative in time of an order that is known; its value for 0."""
        place = places_of(self.eq.n, self.mode, self.eq.friction, self.eq.slips).get(guard)
        if place is not None and self.numbers is not None:
            return self.numbers[place + order]
        kind, i = divmod(guard, self.eq.m)
        t = self.terms
        if kind == SECTION and order < 2:
            assert self.section is not None
            return self.section.jet(self)[order]
        if kind in (GAP, SLIP):
            sign = 1.0 if kind == GAP or self.mode[i] == SLIDE_UP else -1.0
            if kind == GAP and order < 2:
                return float(t.gap_rate[i] if order else t.gap[i])
            if order == 0:
                return sign * float(t.slip[i])
            if order == KNOWN[kind] - 1:
                w, bar = (t.w_n, t.bar_n) if kind == GAP else (t.w_t, t.bar_t)
                return sign * float(w[i] @ self.balance.a + bar[i])
            return sign * float(self._acceleration_change(kind, i)[: self.eq.size] @ self.flow)
        if order == 0:
            l_n, l_t = self.balance.l_n, self.balance.l_t
            bound = _bound(self.eq, self.mode, i, t.mu, l_n)
            return float(_force_guard(kind, l_n[i], bound, l_t[i]))
        return float(self.gradient(guard, order - 1)[: self.eq.size] @ self.flow)

    def _acceleration_change(self, kind: int, i: int) -> Floats:
        """Derivatives (columns,) of the acceleration of a gap or a slip."""
        w = self.terms.w_n if kind == GAP else self.terms.w_t
        return np.asarray(self._partial[1 if kind == GAP else 2][i] + w[i] @ self.changes[0])

    @cached_property
    def free(self) -> Floats:
        """(n,) accelerations without contact forces."""
        return np.asarray(np.linalg.solve(self.terms.mass, self.terms.force))

    def gradient(self, guard: int, order: int = 0) -> Floats:
        """Derivatives (columns,) of a guard, or of its derivative in time of an order.

        Known are those of gaps to order 2, of slips and a section to order 1, of forces to order 0.
        """
        kind, i = divmod(guard, self.eq.m)
        if kind == SECTION:
            assert self.section is not None
            return self.section.gradients(self)[order]
        sign = -1.0 if kind == SLIP and self.mode[i] != SLIDE_UP else 1.0
        if kind in (GAP, SLIP):
            if order == (2 if kind == GAP else 1):
                return sign * self._acceleration_change(kind, i)
            gap, rate, slip = self.eq.kinematic_changes(self.z, self.p)
            return np.asarray(sign * (slip if kind == SLIP else rate if order else gap)[i])
        _, change_n, change_t = self.changes
        if kind == NORMAL:
            return np.asarray(change_n[i])
        team = list(team_of(self.mode, self.eq.slips, i))
        cone = self.terms.mu[team] @ change_n[team]
        cone += self.balance.l_n[team] @ self._partial[3][team]
        return np.asarray(cone - change_t[i] if kind == CONE_UP else cone + change_t[i])
