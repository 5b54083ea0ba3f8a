"""Modes: accelerations, forces and guards of a system with contacts.

In a mode accelerations and contact forces solve

    M a - W_N lambda_N - W_T lambda_T = h,   gap acceleration zero where a contact is closed,
    slip acceleration zero where it sticks,  lambda_T = -+mu lambda_N where it slides.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.impacts import solved
from woodpecker.systems.mechanics.index_sets import (
    CONE_UP,
    GAP,
    KNOWN,
    NORMAL,
    SLIP,
    IndexSets,
    Mode,
)


class Balance(NamedTuple):
    """Accelerations and contact forces."""

    a: Floats  # (..., n)
    l_n: Floats  # (..., m)
    l_t: Floats  # (..., m)


def balance(
    sets: IndexSets, terms: Terms, solve: Callable[[Floats, Floats], Floats] | None = None
) -> Balance:
    """Accelerations and forces in a mode, at one state or a batch; nan where there are none.

    The terms may be expressions if ``solve`` solves linear systems of these.
    """
    kind, (*batch, n) = terms.force.dtype, terms.force.shape
    closed, stuck = sets.closed, sets.stuck
    middle, size = n + len(closed), n + len(closed) + len(stuck)
    right = np.zeros((*batch, size), kind)
    right[..., :n] = terms.force
    right[..., n:middle] = -terms.bar_n[..., closed]
    right[..., middle:] = -terms.bar_t[..., stuck]
    x = (solve or _solve)(_matrix(sets, terms), right)
    l_n, l_t = np.zeros((*batch, sets.m), kind), np.zeros((*batch, sets.m), kind)
    l_n[..., closed] = x[..., n:middle]
    l_t[...] = sets.sign * terms.mu * l_n
    l_t[..., stuck] = x[..., middle:]
    return Balance(x[..., :n], l_n, l_t)


def _matrix(sets: IndexSets, terms: Terms) -> Floats:
    """The matrix (..., s, s) of that linear system, s = n + closed + stuck contacts."""
    *batch, n = terms.force.shape
    closed, stuck = sets.closed, sets.stuck
    middle, size = n + len(closed), n + len(closed) + len(stuck)
    k = np.zeros((*batch, size, size), terms.force.dtype)
    k[..., :n, :n] = terms.mass
    if len(closed):
        friction = (sets.sign * terms.mu)[..., closed, None] * terms.w_t[..., closed, :]
        k[..., :n, n:middle] = -np.swapaxes(terms.w_n[..., closed, :] + friction, -1, -2)
        k[..., :n, middle:] = -np.swapaxes(terms.w_t[..., stuck, :], -1, -2)
        k[..., n:middle, :n] = terms.w_n[..., closed, :]
        k[..., middle:, :n] = terms.w_t[..., stuck, :]
    return k


def _solve(k: Floats, right: Floats) -> Floats:
    """Solutions of systems (..., s, s) with one right-hand side (..., s) each; nan if singular."""
    try:
        return np.asarray(np.linalg.solve(k, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        return solved(k.reshape(-1, *k.shape[-2:]), right.reshape(-1, right.shape[-1])).reshape(
            right.shape
        )


def guard_values(sets: IndexSets, terms: Terms, forces: Balance) -> list[Any]:
    """Values (...) of all guards of a mode, at one state or a batch, or as expressions."""
    rows = []
    for guard in sets.places:
        kind, i, sign = sets.kinematic(guard)
        if kind in (GAP, SLIP):
            values = terms.gap if kind == GAP else terms.slip
            rows.append(values[..., i] if sign > 0.0 else -values[..., i])
        else:
            rows.append(_force_guard(sets, kind, i, terms.mu, forces))
    return rows


def _force_guard(sets: IndexSets, kind: int, i: int, mu: Floats, forces: Balance) -> Floats:
    """A normal force (...), or how far friction is from the bound of all that stick together."""
    if kind == NORMAL:
        return forces.l_n[..., i]
    team, l_t = sets.teams[i], forces.l_t[..., i]
    bound: Floats = (mu[..., team] * forces.l_n[..., team]).sum(axis=-1)
    return bound - l_t if kind == CONE_UP else bound + l_t


class Local:
    """A mode at one state: motion, guards, and their derivatives, found when they are needed.

    ``numbers`` are accelerations, forces, guards with time derivatives, if compiled and finite.
    """

    def __init__(self, eq: Equations, mode: Mode, z: Floats, p: Floats) -> None:
        self.eq, self.mode, self.z, self.p, self.sets = eq, mode, z, p, eq.sets(mode)
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
            return balance(self.sets, self.terms)
        whole = np.array(found[: n + 2 * m])
        return Balance(whole[:n], whole[n : n + m], whole[n + m :])

    @cached_property
    def flow(self) -> Floats:
        """(N,) z' = (u, a, 1)."""
        n = self.eq.n
        return np.concatenate([self.z[n : 2 * n], self.balance.a, [1.0]])

    @cached_property
    def changes(self) -> tuple[Floats, Floats, Floats]:
        """Derivatives (..., columns) of accelerations and forces, in z and free parameters."""
        eq, t, n, sets = self.eq, self.terms, self.eq.n, self.sets
        closed, stuck = sets.closed, sets.stuck
        motion, d_n, d_t, d_mu = self._partial
        load = (sets.sign * self.balance.l_n)[:, None] * d_mu
        right = -np.vstack([motion - t.w_t[: eq.m].T @ load, d_n[closed], d_t[stuck]])
        try:
            x = np.asarray(np.linalg.solve(_matrix(sets, t), right))
        except np.linalg.LinAlgError:
            x = np.full_like(right, np.nan)
        change_n, change_t = np.zeros((eq.m, eq.columns)), np.zeros((eq.m, eq.columns))
        change_n[closed] = x[n : n + len(closed)]
        change_t[:] = (sets.sign * t.mu)[:, None] * change_n + load
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

        Known are three derivatives of gaps, two of slips, one of forces.
        """
        most = min(order, KNOWN[guard // self.eq.m])
        return [self.derivative(guard, k) for k in range(most + 1)]

    def derivative(self, guard: int, order: int) -> float:
        """The time derivative of a guard of a known order; its value for order 0."""
        if self.numbers is not None:
            return self.numbers[self.sets.places[guard] + order]
        kind, i, sign = self.sets.kinematic(guard)
        if order == KNOWN[kind]:
            return float(self.gradient(guard, order - 1)[: self.eq.size] @ self.flow)
        t = self.terms
        if kind not in (GAP, SLIP):
            return float(_force_guard(self.sets, kind, i, t.mu, self.balance))
        w, bar, *values = (
            (t.w_n, t.bar_n, t.gap, t.gap_rate) if kind == GAP else (t.w_t, t.bar_t, t.slip)
        )
        found = values[order][i] if order < len(values) else w[i] @ self.balance.a + bar[i]
        return sign * float(found)

    def gradient(self, guard: int, order: int = 0) -> Floats:
        """Derivatives (columns,) of a guard, or of its time derivative of an order.

        Known are those of gaps to order 2, of slips to order 1, of forces to order 0.
        """
        kind, i, sign = self.sets.kinematic(guard)
        if kind in (GAP, SLIP):
            if order == KNOWN[kind] - 1:
                w, part = (self.terms.w_n, 1) if kind == GAP else (self.terms.w_t, 2)
                found = self._partial[part][i] + w[i] @ self.changes[0]
            else:
                gap, rate, slip = self.eq.kinematic_changes(self.z, self.p)
                found = (slip if kind == SLIP else rate if order else gap)[i]
            return np.asarray(sign * found)
        _, change_n, change_t = self.changes
        if kind == NORMAL:
            return np.asarray(change_n[i])
        team = self.sets.teams[i]
        cone = self.terms.mu[team] @ change_n[team]
        cone += self.balance.l_n[team] @ self._partial[3][team]
        return np.asarray(cone - change_t[i] if kind == CONE_UP else cone + change_t[i])
