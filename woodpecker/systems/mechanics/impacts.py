"""Impacts: compression and expansion of all touching contacts [Leine2001; Pfeiffer1996].

One phase of an impact seeks impulses Lambda with

    M (u' - u) = W_N Lambda_N + W_T Lambda_T,
    0 <= gamma_N'  perp  Lambda_N - floor >= 0,
    |Lambda_T| <= B,  Lambda_T = -B sign(gamma_T') where gamma_T' != 0,  B = mu F Lambda_N.

Compression has floor 0, expansion floor eps_N Lambda_NC (Poisson); Newton's law is one phase with
gamma_N' + eps_N gamma_N in place of gamma_N'. For each contact a *case* says which equations hold:
its gap rate is given or its impulse at the floor; it sticks or slides. All cases of few contacts
are tried, so that a missing or a second solution is seen; of many, Lemke's path proposes some. If
several have one motion, the rule of :mod:`woodpecker.mechanics.contact_problems` chooses the name.

With its cases prescribed a phase is linear in the velocities, and its derivatives solve the same
equations.
"""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.mechanics.cases import (
    BACKWARD,
    EXACT,
    FORWARD,
    FREE,
    HOLD,
    REST,
    SAME,
    SLACK,
)
from woodpecker.mechanics.contact_problems import NO_SOLUTION, SOLVED
from woodpecker.mechanics.impact_terms import alone, given, stated
from woodpecker.mechanics.impacts import letters_of, mark
from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.systems.mechanics.equations import Equations, Terms
from woodpecker.systems.mechanics.index_sets import ContactState
from woodpecker.systems.mechanics.model import FrictionBound, ImpactLaw
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

EXPANSION = 2**11  # number of this phase, above those of compression: one for each vertex
IMPLIED = 1e-10  # relative: what rounding may leave of a direction, or a rate, that others imply
ENUMERATED = 6**4  # cases up to which all are tried: those of four contacts with friction

Cases = tuple[int, ...]

_CASES = {  # of one contact without and with friction
    False: (3 * REST + FORWARD, 3 * FREE + FORWARD),
    True: tuple(range(6)),
}


@dataclass(frozen=True, slots=True)
class Impact:
    """The contacts and cases of an impact: with these prescribed it is a smooth map."""

    contacts: tuple[int, ...]  # those that take part, ascending
    # their cases; those of all vertices of the polytope of solutions, if it is indeterminate
    compression: tuple[Cases, ...]
    expansion: Cases = ()  # their cases; empty without an expansion
    # contacts that give back impulse in the expansion, or, without one, whose gap rate Newton's law
    # reverses
    stores: tuple[int, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether its impulses are not unique (indeterminate)."""
        return len(self.compression) > 1

    @property
    def last(self) -> Cases:
        """The cases in which the impact ends."""
        return self.expansion or self.compression[0]

    @property
    def given(self) -> frozenset[int]:
        """Contacts whose gap rate afterwards is given: zero, or reversed by Newton's law."""
        return frozenset(
            i for i, case in zip(self.contacts, self.last, strict=True) if case // 3 == REST
        )

    @property
    def resting(self) -> frozenset[int]:
        """Contacts that stay closed."""
        return self.given if self.expansion else self.given - {*self.stores}

    @property
    def leaving(self) -> frozenset[int]:
        """Contacts of the impact that open."""
        return frozenset(self.contacts) - self.resting

    @property
    def held(self) -> frozenset[int]:
        """Contacts whose slip is exactly zero afterwards."""
        return frozenset(
            i for i, case in zip(self.contacts, self.last, strict=True) if case % 3 == HOLD
        )

    @property
    def symbol(self) -> str:
        """Its symbol in a word, see :mod:`woodpecker.simulation.words`."""
        contacts, first, last = self.contacts, self.compression[0], self.last
        if self.is_open:
            ends = [sum(case % 3 * 3**k for k, case in enumerate(end)) for end in self.compression]
            shown = [f"e{end}" for end in ends]
            letters = ["".join(shown[k :: len(contacts)]) for k in range(len(contacts))]
        else:
            expands = bool(self.expansion)
            letters = [
                letters_of(mark(first[k], last[k], expands, i in self.stores))
                for k, i in enumerate(contacts)
            ]
        texts = [f"{i + 1}{text}" for i, text in zip(contacts, letters, strict=True)]
        return ("I~" if self.is_open else "I") + "+".join(texts)


class ImpactPhase(NamedTuple):
    """One phase of an impact of c contacts, in the form above."""

    delassus: Floats  # (2c, 2c) W M^-1 W^T, normals first
    free: Floats  # (2c,) velocities without impulses
    bound: Floats  # (c, c) mu F
    floor: Floats  # (c,) least normal impulses
    rubs: tuple[bool, ...]  # (c,) which contacts have friction


def decide(
    eq: Equations, terms: Terms, contacts: Set[int], z: Floats, before: ContactState
) -> tuple[Impact, Floats, Floats]:
    """Find the cases of an impact at a state whose terms are given.

    Returns the cases, the state (N,) afterwards, and normal and tangential impulses of compression
    and expansion (2, 2, m); StoppedError if a phase has no solution or several.

    Contacts that were closed ``before`` have a gap rate of exactly zero, those held a slip of zero,
    whatever rounding has made of them: an impact elsewhere often leaves them on the boundary of two
    cases, as where the expansion is proportional to the compression (equal restitutions).
    """
    ordered, count, newton = tuple(sorted(contacts)), len(contacts), _reverses(eq)
    c, still, rubs = _taking_part(ordered, before, eq.friction)
    delassus, response, free, mu, eps = stated(
        terms.mass, terms.w_n, terms.w_t, terms.gap_rate, terms.slip, terms.mu, terms.eps, c, still
    )
    if newton:
        free[:count] *= 1.0 + eps
    none, impulses = np.zeros(count), np.zeros((2, 2, eq.m))
    feeds = none if newton else eps
    phase = ImpactPhase(delassus, free, np.diag(mu), none, rubs)
    ends, impulse = solutions(phase, feeds)
    speeds, after = slice(eq.n, 2 * eq.n), z.copy()
    u, left, floor = given(delassus, response, free, z[speeds], impulse, feeds, c, impulses[0])
    after[speeds] = u
    stores = tuple(c[floor > 0.0].tolist())
    if not stores:
        back = newton & (eps > 0.0) & (free[:count] < -SLACK * np.abs(free[:count]).max())
        return Impact(ordered, ends, stores=tuple(c[back].tolist())), after, impulses
    phase = ImpactPhase(delassus, left, _bound(eq, mu), floor, rubs)
    cases, impulse = solutions(phase, none)
    after[speeds], _, _ = given(delassus, response, left, u, impulse, none, c, impulses[1])
    return Impact(ordered, ends, cases[0], stores), after, impulses


@lru_cache(maxsize=1024)
def _taking_part(
    contacts: tuple[int, ...], before: ContactState, friction: tuple[bool, ...]
) -> tuple[Ints, Ints, tuple[bool, ...]]:
    """The contacts; which gap rates, then which slips, are exactly zero; which have friction."""
    still = [i in before.closed for i in contacts] + [i in before.held for i in contacts]
    return np.array(contacts), np.array(still, dtype=int), tuple(friction[i] for i in contacts)


def _bound(eq: Equations, mu: Floats) -> Floats:
    """The matrix mu F (c, c) by which normal impulses bound friction in the expansion."""
    return np.outer(mu, np.ones(len(mu))) if _is_summed(eq) else np.diag(mu)


def _reverses(eq: Equations) -> bool:
    return eq.system.law is ImpactLaw.NEWTON


def _is_summed(eq: Equations) -> bool:
    return eq.system.expansion_friction is FrictionBound.SUMMED


def solutions(phase: ImpactPhase, feeds: Floats) -> tuple[tuple[Cases, ...], Floats]:
    """The cases that solve a phase, and its impulses (2c,); StoppedError unless it is solved.

    Of several cases with the same velocities the first one counts that is exact up to rounding, or
    else the one with the least violation. If they differ in normal impulses of which a part
    ``feeds`` an expansion, the phase is indeterminate: the cases are those of all vertices of the
    polytope of solutions, the impulses the mean of these.
    """
    if len(phase.rubs) == 1:
        return _of_one(phase)
    count = math.prod(len(_CASES[each]) for each in phase.rubs)
    tried = _combinations(phase.rubs) if count <= ENUMERATED else _proposed(phase)
    impulses, velocities, worst = _try(phase, tried)
    kept = np.flatnonzero(worst <= SLACK)
    if not kept.size:
        raise StoppedError(MotionStatus.NO_SOLUTION)
    exact = np.flatnonzero(worst <= EXACT)  # the first of these rests, and sticks
    best = int(exact[0] if exact.size else kept[worst[kept].argmin()])
    cases = tuple(tried[best].tolist())
    if kept.size == 1:
        return (cases,), impulses[best]
    size = np.abs(phase.free) + np.abs(phase.delassus).sum(axis=1) * np.abs(impulses[best]).max()
    if (np.abs(velocities[kept] - velocities[best]) > SAME * size).any():
        raise StoppedError(MotionStatus.AMBIGUOUS)
    n = len(phase.rubs)
    apart = np.abs(impulses[kept] - impulses[best])[:, :n] * (feeds > 0.0)
    if (apart <= SAME * np.abs(impulses[best]).max()).all():
        return (cases,), impulses[best]
    vertices = kept[_distinct(impulses[kept], SAME * np.abs(impulses[best]).max())]
    return tuple(tuple(tried[k].tolist()) for k in vertices), impulses[vertices].mean(axis=0)


def _distinct(points: Floats, same: float) -> Ints:
    """The first of each of some points (b, 2c), in order of their longest coordinate."""
    # Of coordinates of equal length the first one counts.
    lengths = np.ptp(points, axis=0)
    longest = points[:, (lengths >= lengths.max() - same).argmax()]
    near = (np.abs(points[:, None] - points) <= same).all(axis=-1)
    first = np.flatnonzero(near.argmax(axis=1) == np.arange(len(points)))
    return first[longest[first].argsort(kind="stable")]


def _of_one(phase: ImpactPhase) -> tuple[tuple[Cases, ...], Floats]:
    """:func:`solutions` for one contact, in closed form."""
    mu, floor = phase.bound[0, 0], phase.floor[0]
    status, case, *impulse = alone(phase.delassus, phase.free, mu, floor, phase.rubs[0])
    if status != SOLVED:
        none = status == NO_SOLUTION
        raise StoppedError(MotionStatus.NO_SOLUTION if none else MotionStatus.AMBIGUOUS)
    return ((case,),), np.array(impulse)


@lru_cache(maxsize=64)
def _combinations(rubs: tuple[bool, ...]) -> Ints:
    """All cases (count, c) of contacts; one without friction slides forward."""
    return np.array(list(product(*(_CASES[each] for each in reversed(rubs)))))[:, ::-1]


def _proposed(phase: ImpactPhase) -> Ints:
    """The cases (4, c) of the solution to which Lemke's path leads."""
    # At a boundary both cases are tried: a contact without impulse and gap rate rests or leaves,
    # one at the edge of its cone sticks or slides (impulses of redundant contacts are not unique).
    n = len(phase.rubs)
    found = solve_contact_lcp(phase.delassus, phase.free, phase.bound, phase.floor)
    if not found.success:
        return np.empty((0, n), dtype=int)
    size, speed = np.abs(found.impulse_n).max(), np.abs(phase.free).max()
    pressed = found.impulse_n - phase.floor > SLACK * size
    sticks = (found.gamma_t == 0.0) & np.array(phase.rubs)
    edge = np.abs(found.impulse_t) >= phase.bound @ found.impulse_n - SLACK * size
    at_edge = np.where(found.impulse_t <= 0.0, FORWARD, BACKWARD)
    slides = np.where(found.gamma_t > 0.0, FORWARD, BACKWARD)
    tried = []
    for rests in (pressed | (found.gamma_n <= SLACK * speed), pressed):
        for holds in (sticks, sticks & ~edge):
            along = np.where(holds, HOLD, np.where(sticks, at_edge, slides))
            tried.append(3 * np.where(rests, REST, FREE) + np.where(phase.rubs, along, FORWARD))
    return np.array(tried)


def _try(phase: ImpactPhase, tried: Ints) -> tuple[Floats, Floats, Floats]:
    """Impulses and velocities (count, 2c) of cases, and their largest relative violations."""
    count, n = tried.shape
    rests, tangential = tried // 3 == REST, tried % 3
    sign = np.where(tangential == FORWARD, -1.0, 1.0)  # of friction
    matrix, right = np.zeros((count, 2 * n, 2 * n)), np.zeros((count, 2 * n))
    eye = np.eye(n)
    matrix[:, :n] = np.where(rests[..., None], phase.delassus[:n], np.hstack([eye, 0.0 * eye]))
    right[:, :n] = np.where(rests, -phase.free[:n], phase.floor)
    holds = tangential == HOLD
    slide = np.concatenate(
        [-sign[..., None] * phase.bound, np.broadcast_to(eye, (count, n, n))], axis=2
    )
    matrix[:, n:] = np.where(holds[..., None], phase.delassus[n:], slide)
    right[:, n:] = np.where(holds, -phase.free[n:], 0.0)
    impulses = solved(matrix, right)
    velocities = impulses @ phase.delassus.T + phase.free
    most = np.abs(impulses).max(axis=1, initial=0.0)
    size = np.abs(phase.free) + np.abs(phase.delassus).sum(axis=1) * most[:, None]
    bound = impulses[:, :n] @ phase.bound.T
    most = np.maximum(most, phase.floor.max(initial=0.0))[:, None]
    with np.errstate(all="ignore"):
        normal = np.where(
            rests, (phase.floor - impulses[:, :n]) / most, -velocities[:, :n] / size[:, :n]
        )
        along = np.where(
            holds, (np.abs(impulses[:, n:]) - bound) / most, sign * velocities[:, n:] / size[:, n:]
        )
    along = np.where(np.array(phase.rubs), along, 0.0)
    zero = np.isfinite(impulses).all(axis=1).reshape(-1, 1)
    violations = np.hstack([normal, along])
    violations = np.where(np.isnan(violations), np.where(zero, 0.0, np.inf), violations)
    return impulses, velocities, np.maximum(violations, 0.0).max(axis=1)


def solved(matrix: Floats, right: Floats) -> Floats:
    """Solutions (b, n) of a batch of linear systems; nan where one is singular."""
    n = matrix.shape[-1]
    with np.errstate(all="ignore"):
        size = np.abs(matrix).max(axis=-1, keepdims=True)
        bad = np.abs(np.linalg.det(matrix / np.where(size > 0.0, size, 1.0))) < SLACK
        usable = np.where((bad | ~np.isfinite(matrix).all((-1, -2)))[..., None, None],
                          np.eye(n), matrix)  # fmt: skip
        found = np.linalg.solve(usable, right[..., None])[..., 0]
    found[bad] = np.nan
    return np.asarray(found)


# --- With the cases prescribed --------------------------------------------------------------------


NORMAL_SIDE, ALONG, CONE_PLUS, CONE_MINUS = range(4)  # the inequalities of a contact

Slack = tuple[int, float, Floats]
"""The number of a strict inequality, its value, and its derivatives (columns,).

The number is phase (each vertex of compression, EXPANSION) * 4m + 4 * contact + which.
"""


def carry_out(
    eq: Equations, impact: Impact, z: Floats, p: Floats, tangents: Floats
) -> tuple[Floats, Floats, list[Slack]]:
    """The state after an impact with prescribed cases, its derivatives, and all inequalities."""
    contacts, c = impact.contacts, len(impact.contacts)
    none = np.zeros(c), np.zeros((c, tangents.shape[1]))
    ends = [
        _carry(eq, contacts, cases, z, p, tangents, none, side)
        for side, cases in enumerate(impact.compression)
    ]
    slacks = [slack for *_, each in ends for slack in each]
    z, tangents, impulse, change = (
        np.mean(part, axis=0) for part in zip(*(end[:4] for end in ends), strict=True)
    )
    if impact.expansion:
        at = list(contacts)
        eps = eq.terms(z, p).eps[at]
        d_eps = eq.impact_changes(z, p, z[eq.n : 2 * eq.n], *np.zeros((2, eq.m)))[5]
        d_floor = eps[:, None] * change[:c] + impulse[:c, None] * total(eq, d_eps[at], tangents)
        floor = eps * impulse[:c], d_floor
        z, tangents, _, _, more = _carry(
            eq, contacts, impact.expansion, z, p, tangents, floor, EXPANSION
        )
        slacks += more
    return z, tangents, slacks


def _carry(
    eq: Equations, contacts: tuple[int, ...], cases: Cases, z: Floats, p: Floats,
    tangents: Floats, floor: tuple[Floats, Floats], side: int,
) -> tuple[Floats, Floats, Floats, Floats, list[Slack]]:  # fmt: skip
    """The state and the impulses (2c,) after a phase, each with derivatives; its inequalities."""
    n, c, at, case, terms = eq.n, len(contacts), list(contacts), np.array(cases), eq.terms(z, p)
    w_n, w_t, mu, speeds = terms.w_n[at], terms.w_t[at], terms.mu[at], slice(n, 2 * n)
    expands, summed = side == EXPANSION, side == EXPANSION and _is_summed(eq)
    bound = _bound(eq, mu) if expands else np.diag(mu)
    rests, holds = (case // 3 == REST)[:, None], (case % 3 == HOLD)[:, None]
    sign = np.where(case % 3 == FORWARD, -1.0, 1.0)[:, None]
    k = np.block([
        [terms.mass, -w_n.T, -w_t.T],
        [rests * w_n, np.diag(~rests[:, 0]), np.zeros((c, c))],
        [holds * w_t, np.where(holds, 0.0, -sign) * bound, np.diag(~holds[:, 0])],
    ])  # fmt: skip

    def solution(
        kick: Floats, rate: Floats, slip: Floats, kept: Floats, floor: Floats, load: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Solve for u', the impulses and the slacks, or for derivatives of all of these.

        Arguments are the parts without u' and impulses: of the balance, the gap rates, the slips;
        what Newton's law keeps of gap rates; the floors; of the bounds of friction.
        """
        right = [kick, np.where(rests, rate + kept, -floor), np.where(holds, slip, -sign * load)]
        found = np.linalg.solve(k, -np.concatenate(right))
        new, l_n, l_t = np.split(found, [n, n + c])
        cone, rate, slip = bound @ l_n + load, rate + w_n @ new, slip + w_t @ new
        above = np.where(rests, l_n - floor, rate)
        return new, found[n:], np.array([above, -sign * slip, cone - l_t, cone + l_t])

    old, zero = z[speeds], np.zeros((c, 1))
    kept = terms.eps[at] * terms.gap_rate[at] if _reverses(eq) else np.zeros(c)
    known = -terms.mass @ old, terms.gap_rate[at] - w_n @ old, terms.slip[at] - w_t @ old, kept
    kick, rate, slip, keeps, least = (each[:, None] for each in (*known, floor[0]))
    new, impulse, sides = solution(kick, rate, slip, keeps, least, zero)
    after, moved = z.copy(), tangents.copy()
    after[speeds], impulse = new[:, 0], impulse[:, 0]
    l_n, l_t = np.zeros((2, eq.m))
    l_n[at], l_t[at] = impulse[:c], impulse[c:]
    kick, *changes = eq.impact_changes(z, p, after[speeds], l_n, l_t)  # u' and impulses fixed
    d_rate, d_slip, d_old, d_mu, d_eps = (total(eq, each[at], tangents) for each in changes)
    d_kept = terms.eps[at, None] * d_old + terms.gap_rate[at, None] * d_eps
    load = d_mu * (impulse[:c].sum() if summed else impulse[:c, None])
    moved[speeds], change, turns = solution(
        total(eq, kick, tangents), d_rate, d_slip, d_kept * _reverses(eq), floor[1], load
    )
    slacks = list[Slack]()
    fixed = np.vstack([w_n[rests[:, 0]], w_t[holds[:, 0]]])
    speed = np.abs(w_t) @ np.maximum(np.abs(old), np.abs(after[speeds]))
    for j, (i, one) in enumerate(zip(contacts, cases, strict=True)):
        which = [NORMAL_SIDE]
        if eq.friction[i]:
            which += [CONE_PLUS, CONE_MINUS] if one % 3 == HOLD else [ALONG]
            # the sign of a slip that stops with the other directions is rounding, and no margin
            if which[-1] == ALONG and abs(sides[ALONG, j, 0]) <= IMPLIED * speed[j]:
                which = which[: 1 if is_spanned(w_t[j], fixed) else 2]
        item = 4 * (eq.m * side + i)
        slacks += [(item + each, float(sides[each, j, 0]), turns[each, j]) for each in which]
    return after, moved, impulse, change, slacks


def is_spanned(row: Floats, rows: Floats) -> bool:
    """Whether a direction (n,) lies in the span of others (r, n), up to rounding."""
    away = row - row @ np.linalg.pinv(rows) @ rows
    return bool(np.abs(away).max() <= IMPLIED * np.abs(row).max())


def is_implied(row: Floats, value: float, rows: Floats, values: Floats, terms: float) -> bool:
    """Whether others imply a rate: its direction, and its value by theirs, up to rounding."""
    # ``terms`` is the size of what it is the sum of.
    if not is_spanned(row, rows):
        return False
    inverse = np.linalg.pinv(rows)  # rounding of its product with a row is that of their moduli
    size = abs(value) + np.abs(row) @ np.abs(inverse) @ np.abs(values) + terms
    return bool(abs(value - row @ inverse @ values) <= IMPLIED * size)


def total(eq: Equations, change: Floats, tangents: Floats) -> Floats:
    """Derivatives along the tangents by the chain rule; the last ones move the free parameters."""
    found = change[..., : eq.size] @ tangents
    k = len(eq.free)
    if k and tangents.shape[1]:
        found[..., tangents.shape[1] - k :] += change[..., eq.size :]
    return np.asarray(found)
