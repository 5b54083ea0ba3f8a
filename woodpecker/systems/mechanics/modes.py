"""Index sets: accelerations, forces, guards, and the contact problem on acceleration level.

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
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import sympy
from scipy.optimize import linprog

from woodpecker.base.arrays import Floats, Ints
from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.impacts import Outcome, solved

# states of a contact; SLIDE_UP: its slip is positive; IDLE: closed, because others are; EDGE_UP: it
# sticks, because others do, with the friction of SLIDE_UP
OPEN, STICK, SLIDE_UP, SLIDE_DOWN, IDLE, EDGE_UP, EDGE_DOWN = range(7)
GAP, NORMAL, CONE_UP, CONE_DOWN, SLIP = range(5)  # kinds of guards: kind * m + contact
SECTION = 5  # 5 m is the guard of a section
MOST_MODES = 256  # combinations that are tried on acceleration level
IMPLIED = 1e-10  # a direction that lies in the span of others but for rounding; a rate there
SAME = 1e-9  # relative: accelerations that are closer are one motion

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
def _places(n: int, mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...]) -> dict[int, int]:
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
        place = _places(self.eq.n, self.mode, self.eq.friction, self.eq.slips).get(guard)
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


# --- The contact problem on acceleration level ----------------------------------------------------


@dataclass(frozen=True, slots=True)
class Touch:
    """What an event leaves: the contacts that touch and stay, and what is exactly zero."""

    closed: frozenset[int]  # contacts with zero gap and zero gap rate
    held: frozenset[int] = frozenset()  # those of them whose slip is exactly zero
    leaving: frozenset[int] = frozenset()  # contacts with zero gap that open
    fired: frozenset[int] = frozenset()  # guards of forces or slips that have just become zero
    before: Mode = ()  # the mode that has ended: what slides in it goes on the same way

    def order(self, slips: Sequence[int], mode: Mode, guard: int) -> int:
        """How many derivatives of a guard, from its value on, are exactly zero.

        At a detachment the gap has no acceleration yet; at a slip start the slip has none, because
        lambda_T = +mu lambda_N at the edge of the cone is just the force of negative slip.
        """
        m = len(mode)
        kind, i = divmod(guard, m)
        if kind == GAP:
            if i in self.closed:
                return 3 if NORMAL * m + i in self.fired else 2
            return 1 if i in self.leaving else 0
        if kind == NORMAL:
            return 1 if guard in self.fired else 0
        edges = {each // m for each in self.fired if slips[each % m] == slips[i]}
        if kind != SLIP:
            return 1 if kind in edges else 0
        if i not in self.held:
            return 0
        return 2 if (CONE_UP if mode[i] == SLIDE_DOWN else CONE_DOWN) in edges else 1


def settle(eq: Equations, z: Floats, p: Floats, touch: Touch) -> tuple[Outcome, Mode]:
    """The mode that starts now: all combinations of states of the closed contacts are tried.

    One is admissible if all its guards of these contacts are positive right after now, judged by
    the first derivative that the event has not made zero.
    """
    if not touch.closed:
        return Outcome.SOLVED, (OPEN,) * eq.m
    tried = [Local(eq, mode, z, p) for mode in _modes(eq, eq.terms(z, p), touch)]
    kept = [each for each in tried if _admissible(each, touch)]
    if not kept:
        return Outcome.NO_SOLUTION, (OPEN,) * eq.m
    first, size = kept[0], 0.0
    for other in kept[1:]:
        size = size or float(np.abs(first.balance.a).max() + np.abs(first.free).max())
        if np.abs(other.balance.a - first.balance.a).max() > SAME * size:
            return Outcome.AMBIGUOUS, first.mode
    return Outcome.SOLVED, first.mode


def resting_mode(eq: Equations, z: Floats, p: Floats, touch: Touch) -> Mode | None:
    """The mode of a system at rest that more contacts hold than there are coordinates, or None.

    Its forces are open, so that no mode can be tried: it is at rest if there are any within all
    cones that balance the others.
    """
    if touch.leaving or len(touch.closed) + len(touch.held) <= eq.n:
        return None
    closed, held = sorted(touch.closed), sorted(i for i in touch.held if eq.rubs[i])
    slides = any(eq.rubs[i] and i not in touch.held for i in closed)
    if slides or len(closed) + len(held) <= eq.n:
        return None
    rank, moved, terms = holding(eq, z, p, closed, held)
    if moved or rank < eq.n:
        return None
    rows = np.vstack([terms.w_n[closed], terms.w_t[held]])
    cones = np.zeros((2 * len(held), len(rows)))
    for k, i in enumerate(held):
        cones[2 * k : 2 * k + 2, closed.index(i)] = -terms.mu[i]
        cones[2 * k : 2 * k + 2, len(closed) + k] = 1.0, -1.0
    size = max(1.0, float(np.abs(terms.force).max()))
    found = linprog(
        np.zeros(len(rows)), cones, np.zeros(len(cones)), rows.T, -terms.force / size,
        [(0.0, None)] * len(closed) + [(None, None)] * len(held),
    )  # fmt: skip
    if not found.success:
        return None
    return tuple(
        OPEN if i not in touch.closed else STICK if i in held else SLIDE_UP for i in range(eq.m)
    )


def holding(
    eq: Equations, z: Floats, p: Floats, closed: Sequence[int], stuck: Sequence[int]
) -> tuple[int, bool, Terms]:
    """In how many directions contacts hold a system, and whether they move by themselves.

    The terms are those without velocities: a belt or a support has some all the same.
    """
    still = z.copy()
    still[eq.n : 2 * eq.n] = 0.0
    terms = eq.terms(still, p)
    rank = int(np.linalg.matrix_rank(np.vstack([terms.w_n[closed], terms.w_t[stuck]])))
    return rank, bool(terms.gap_rate[closed].any() or terms.slip[stuck].any()), terms


def _modes(eq: Equations, terms: Terms, touch: Touch) -> Sequence[Mode]:
    """Combinations of states to be tried: sticking first, opening last."""
    forward = _forward(terms, touch)
    found = _combinations(eq.friction, eq.slips, touch.closed, touch.held, forward)
    found = _proposed(eq, terms, touch) if found is None else found
    normals = terms.w_n[sorted(touch.closed)]
    along = terms.w_t[sorted({eq.slips[i] for i in touch.held if eq.rubs[i]})]
    count = len(normals) + len(along)
    if count < 2 or np.linalg.matrix_rank(np.vstack([normals, along])) == count:
        return found
    resolved = (_resolved(eq, terms, mode, touch) for mode in found)
    return list(dict.fromkeys(mode for mode in resolved if mode is not None))


def _resolved(eq: Equations, terms: Terms, mode: Mode, touch: Touch) -> Mode | None:
    """A mode with the contacts that others keep closed, or from slipping, in states of their own.

    None if its forces are open.
    """
    closed, stuck, _ = parts_of(mode, eq.slips)
    rows = np.vstack([terms.w_n[closed], terms.w_t[stuck]])
    if np.linalg.matrix_rank(rows) < len(rows):
        return None
    bars, inverse = np.concatenate([terms.bar_n[closed], terms.bar_t[stuck]]), np.linalg.pinv(rows)

    def is_implied(row: Floats, bar: float) -> bool:
        shares = row @ inverse
        away = np.abs(row - shares @ rows).max() <= IMPLIED * np.abs(row).max()
        size = abs(bar) + np.abs(shares) @ np.abs(bars)
        return bool(away and abs(bar - shares @ bars) <= IMPLIED * size)

    found = list(mode)
    for i in touch.closed:
        slides = mode[i] in (SLIDE_UP, SLIDE_DOWN) and eq.rubs[i] and i in touch.held
        if mode[i] == OPEN and is_implied(terms.w_n[i], terms.bar_n[i]):
            found[i] = IDLE
        elif slides and is_implied(terms.w_t[i], terms.bar_t[i]):
            found[i] = EDGE_UP if mode[i] == SLIDE_UP else EDGE_DOWN
    return tuple(found)


def _forward(terms: Terms, touch: Touch) -> tuple[bool, ...]:
    """Which contacts slide forward: as they did, whatever rounding has made of a slip near zero."""
    states = touch.before or (OPEN,) * len(terms.slip)
    return tuple(
        state == SLIDE_UP if state in (SLIDE_UP, SLIDE_DOWN) else slip > 0.0
        for state, slip in zip(states, terms.slip.tolist(), strict=True)
    )


@lru_cache(maxsize=1024)
def _combinations(
    rubs: tuple[bool, ...], slips: tuple[int, ...], closed: Set[int], held: Set[int],
    forward: tuple[bool, ...],
) -> list[Mode] | None:  # fmt: skip
    """All combinations of states of closed contacts, of which some slide; None if too many."""
    choices, count = list[tuple[int, ...]](), 1
    for i, moves in enumerate(forward):
        states: tuple[int, ...] = (OPEN,)
        if i in closed:
            if not rubs[i]:
                states = (SLIDE_UP, OPEN)
            elif i in held:
                states = (STICK, SLIDE_UP, SLIDE_DOWN, OPEN)
            else:
                states = (SLIDE_UP if moves else SLIDE_DOWN, OPEN)
        choices.append(states)
        count *= len(states)
    if count > MOST_MODES:
        return None
    return [mode for mode in product(*choices) if _is_together(rubs, slips, mode)]


def _is_together(rubs: tuple[bool, ...], slips: tuple[int, ...], mode: Mode) -> bool:
    """Whether closed contacts with the same slip do the same."""
    first = dict[int, int]()
    return all(
        state == OPEN or not rubs[i] or first.setdefault(slips[i], state) == state
        for i, state in enumerate(mode)
    )


def _proposed(eq: Equations, terms: Terms, touch: Touch) -> list[Mode]:
    """The combination of the solution to which Lemke's path leads."""
    c = sorted(touch.closed)
    w = np.vstack([terms.w_n[c], terms.w_t[c]])
    response = np.linalg.solve(terms.mass, np.column_stack([w.T, terms.force]))
    free = w @ response[:, -1] + np.concatenate([terms.bar_n[c], terms.bar_t[c]])
    forward = _forward(terms, touch)
    slides = np.array(
        [0 if i in touch.held or not eq.rubs[i] else 1 if forward[i] else -1 for i in c]
    )
    found = solve_contact_lcp(w @ response[:, :-1], free, terms.mu[c], 0.0, slides)
    if not found.success:
        return []
    mode = [OPEN] * eq.m
    for k, i in enumerate(c):
        if found.impulse_n[k] > 0.0:
            slip = slides[k] or np.sign(found.gamma_t[k])
            sticks = eq.rubs[i] and slip == 0.0
            mode[i] = STICK if sticks else SLIDE_DOWN if slip < 0.0 and eq.rubs[i] else SLIDE_UP
    return [tuple(mode)]


def _admissible(here: Local, touch: Touch) -> bool:
    """Whether all guards of the closed contacts are positive right after now.

    A guard has the sign of the first derivative that the event has not made zero; one that stays
    zero counts as positive.
    """
    eq, numbers = here.eq, here.numbers
    if numbers is None and not math.isfinite(here.balance.a.sum()):
        return False
    for guard, place, order, most in _watched(eq.n, here.mode, eq.friction, eq.slips, touch):
        for k in range(order, most + 1):
            value = here.derivative(guard, k) if numbers is None else numbers[place + k]
            if value != 0.0:
                if not value > 0.0:
                    return False
                break
    return True


@lru_cache(maxsize=1024)
def _watched(
    n: int, mode: Mode, rubs: tuple[bool, ...], slips: tuple[int, ...], touch: Touch
) -> list[tuple[int, int, int, int]]:
    """Guards of closed contacts that may be zero, with their places among compiled numbers.

    The first derivative that the event has not made zero and the last that is known follow.
    """
    m, found = len(mode), list[tuple[int, int, int, int]]()
    for guard, place in _places(n, mode, rubs, slips).items():
        kind, i = divmod(guard, m)
        if i in touch.closed and (kind != SLIP or i in touch.held):
            found.append((guard, place, touch.order(slips, mode, guard), KNOWN[kind]))
    return found
