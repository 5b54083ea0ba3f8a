"""Verification of impacts: strict inequalities prove one index combination, refute all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import product
from operator import add
from typing import Any

from woodpecker.checking.forms import F, constant
from woodpecker.checking.intervals import I, NotSeparated
from woodpecker.checking.toy import SIDE, ExactToy


@dataclass
class ImpactSolution:
    """One phase of an impact: its index combination, impulses and velocities (N, T by contact)."""

    rests: tuple[bool, ...]
    slips: tuple[int, ...]
    impulses: list[F]
    velocities: list[F]


def marked(first: ImpactSolution, second: ImpactSolution | None, k: int, stores: int | None) -> str:
    """Letters of a contact in a word: s sticks, f separates; after - in expansion, r unusual."""
    letters = "f" if not first.rests[k] else ("s" if first.slips[k] == 0 else "")
    if second is None:
        return letters
    unusual = second.rests[k] == (stores == 1)
    tail = ("r" if unusual else "") + ("s" if second.slips[k] == 0 else "")
    return letters + (f"-{tail}" if tail else "")


def verdict(conditions: Sequence[Any]) -> bool | None:
    """Whether all conditions are positive: False if one is negative, None if open."""
    signs = [(c.value if isinstance(c, F) else c).sign() for c in conditions]
    if -1 in signs:
        return False
    return True if all(s == 1 for s in signs) else None


def solve_impact(
    toy: ExactToy, contacts: list[int], free: list[F], floors: list[F], expands: bool, known: bool
) -> ImpactSolution:
    """The only solution of a phase of an impact; ``known``: the one contact does approach."""
    coupled = expands and toy.summed and len(contacts) > 1
    kept: ImpactSolution | None = None
    slips_of = list(product((0, 1, -1), repeat=len(contacts)))
    for rests, slips in product(product((True, False), repeat=len(contacts)), slips_of):
        table = toy.case(tuple(contacts), rests, slips, coupled)
        if table is None:
            if not (all(rests) and not any(slips) and len(contacts) == 2):
                raise NotSeparated("an impact is degenerate")
            load = momentum(toy, contacts, free)
            if rest_is_possible(toy, contacts[1], load, floors, coupled) is not False:
                raise NotSeparated("the impulses of an impact may not be unique")
            continue
        holds, solution = _combination(
            toy, contacts, free, floors, rests, slips, table, coupled, known
        )  # fmt: skip
        if holds is False:
            continue
        if holds is None or kept is not None:
            raise NotSeparated("an impact is not decided")
        kept = solution
    if kept is None:
        raise NotSeparated("an impact has no solution")
    return kept


def _combination(
    toy: ExactToy, contacts: list[int], free: list[F], floors: list[F], rests: tuple[bool, ...],
    slips: tuple[int, ...], table: list[list[Fraction]], coupled: bool, known: bool,
) -> tuple[bool | None, ImpactSolution | None]:  # fmt: skip
    """Whether an index combination holds, decided by ranges, then by forms; and its solution."""
    if known and not all(rests):
        return False, None  # v_N <= 0 before: without an impulse the contact would still approach
    at = [2 * i + k for i in contacts for k in (0, 1)]
    for ranges in (True, False):
        start, low = ([x.value if ranges else x for x in each] for each in (free, floors))
        p = [total(row, [*start, *low]) for row in table]
        conditions: list[Any] = []
        v: list[Any] = []
        still = [zero for k in range(len(contacts)) for zero in (rests[k], slips[k] == 0)]
        for a in range(len(at)):
            none = I.of(0) if ranges else constant(free[0].box, I.of(0))
            row = [toy.g[at[a]][j] for j in at]
            v.append(none if still[a] else start[a] + total(row, p))
        for k, i in enumerate(contacts):
            stiffness = toy.g[2 * i][2 * i] - slips[k] * toy.mu[i] * toy.g[2 * i][2 * i + 1]
            if known and slips[k] and stiffness > 0:  # impulse = -v_N / stiffness >= 0, v_N before
                conditions.append(I.of(1))
            else:
                conditions.append(p[2 * k] - low[k] if rests[k] else v[2 * k])
            most = p[2 * k] + p[2 - 2 * k] if coupled else p[2 * k]
            bound = most * I.of(toy.mu[i])
            if slips[k] == 0:
                conditions += [bound - p[2 * k + 1], bound + p[2 * k + 1]]
            else:
                conditions.append(v[2 * k + 1] if slips[k] == 1 else -v[2 * k + 1])
        holds = verdict(conditions)
        if ranges and holds is False:
            return False, None
    return holds, ImpactSolution(rests, slips, p, v)


def momentum(toy: ExactToy, contacts: list[int], free: list[F]) -> list[F]:
    """-M u, from the free velocities (N, T) of the beak and a contact of the sleeve."""
    k = contacts[1]
    u_s = free[0] * I.of(-1 / toy.lever[0])
    u_m = free[2] * I.of(SIDE[k] / toy.lever[k])
    u_y = free[3] - u_m * I.of(toy.tangent[k][1])
    return [-total(row, [u_y, u_m, u_s]) for row in toy.mass]


def rest_is_possible(
    toy: ExactToy, k: int, load: list[F], floors: list[F], coupled: bool
) -> bool | None:
    """False if W lambda = load has no solution in both friction cones, else None."""
    # One of four forces is free, s = lambda_T1; all conditions are linear in it, c + rate s >= 0.
    (_, l_m, arm), r_m = toy.tangent[0], toy.tangent[k][1]
    hs, hk = toy.lever[0], SIDE[k] * toy.lever[k]
    beak = (-load[2] * I.of(1 / hs), arm / hs)
    sleeve = ((load[1] - load[0] * I.of(r_m)) * I.of(1 / hk), (r_m - l_m) / hk)
    along = [(constant(load[0].box, I.of(0)), Fraction(1)), (load[0], Fraction(-1))]
    lines = [(beak[0] - floors[0], beak[1]), (sleeve[0] - floors[1], sleeve[1])]
    for i, own, (c, rate) in ((0, beak, along[0]), (k, sleeve, along[1])):
        most = (beak[0] + sleeve[0], beak[1] + sleeve[1]) if coupled else own
        mu = toy.mu[i]
        lines.append((most[0] * I.of(mu) + c, most[1] * mu + rate))
        lines.append((most[0] * I.of(mu) - c, most[1] * mu - rate))
    for c, rate in lines:
        if rate == 0 and c.value.sign() == -1:
            return False
        for c2, rate2 in lines:
            if rate > 0 > rate2 and (c2 * I.of(rate) - c * I.of(rate2)).value.sign() == -1:
                return False
    return None


def slip(toy: ExactToy, i: int, u: Sequence[Any]) -> Any:
    """Tangential velocity of a contact, as a function over the box or its range."""
    return total(toy.tangent[i], u)


def total(row: Sequence[Fraction], x: Sequence[Any]) -> Any:
    """A linear combination of functions over the box, or of intervals."""
    terms = [y * I.of(c) for c, y in zip(row, x, strict=True) if c]
    none = I.of(0) if isinstance(x[0], I) else constant(x[0].box, I.of(0))
    return reduce(add, terms) if terms else none
