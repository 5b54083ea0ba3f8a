"""Contact problems over a box: strict inequalities prove one case and refute all others.

See :mod:`woodpecker.mechanics.contact_problems` and :mod:`woodpecker.motion.settling`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple, TypeVar

from flint import arb

from woodpecker.enclosures.balls import ZERO, sum_of
from woodpecker.enclosures.forms import box, sign
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.mechanics.cases import FORWARD, HOLD, REST
from woodpecker.mechanics.contact_problems import one_contact_case
from woodpecker.mechanics.modes import SIGN

Numbers = Sequence[Any]
T = TypeVar("T")


class BallPhase(NamedTuple):
    """The compression or expansion phase of an impact."""

    cases: tuple[int, ...]  # the index combination of each contact
    impulses: Numbers  # (N, T) of each contact in turn
    velocities: Numbers  # (N, T) of each contact afterwards, exactly zero where it rests or sticks


def impulses_of(
    model: BallToy, contacts: Sequence[int], free: Numbers, floors: Numbers | None, approaches: bool
) -> BallPhase:
    """Solve the compression (no floors) or expansion at one contact, or at beak and sleeve.

    ``free`` are the velocities (N, T) of each without impulses. With ``approaches`` the normal
    velocity of the one contact is known to be at most zero, though its range is not. NotProved
    unless one index combination holds strictly and every other is violated strictly.
    """
    low = floors if floors is not None else [ZERO] * len(contacts)
    coupled = floors is not None and model.summed and len(contacts) > 1
    return only(_candidates(model, contacts, free, low, coupled, approaches), "an impact")


def only(candidates: Iterable[tuple[bool | None, T]], what: str) -> T:
    """The one candidate that holds; NotProved unless all others are refuted."""
    kept = list[T]()
    for holds, candidate in candidates:
        if holds is None or (holds and kept):
            raise NotProved(f"{what} is not decided")
        if holds:
            kept.append(candidate)
    if not kept:
        raise NotProved(f"{what} has no solution")
    return kept[0]


def verdict(conditions: Iterable[Any]) -> bool | None:
    """Whether all conditions (or signs) are positive: False if one is negative, None if open."""
    signs = [each if isinstance(each, int) else sign(each) for each in conditions]
    return False if -1 in signs else (True if all(each == 1 for each in signs) else None)


def _candidates(
    model: BallToy, contacts: Sequence[int], free: Numbers, floors: Numbers, coupled: bool,
    approaches: bool,
) -> Iterator[tuple[bool | None, BallPhase]]:  # fmt: skip
    """Judge each index combination, by ranges, then by forms; NotProved if both may stick."""
    for cases in product(range(6), repeat=len(contacts)):
        table = model.case(contacts[1], *cases, coupled) if len(contacts) == 2 else None
        if table is None and len(contacts) == 2:
            load = _momentum(model, contacts[1], free)
            if _may_hold(model, contacts[1], load, floors, coupled):
                raise NotProved("the impulses of an impact may not be unique")
            continue
        for look in (box, lambda x: x):
            looked = [look(x) for x in free], [look(x) for x in floors]
            holds, found = _combination(
                model, contacts, cases, table, *looked, coupled, approaches
            )  # fmt: skip
            if holds is False:
                break
        yield holds, found


def _combination(
    model: BallToy, contacts: Sequence[int], cases: tuple[int, ...], table: list[Numbers] | None,
    free: Numbers, floors: Numbers, coupled: bool, approaches: bool,
) -> tuple[bool | None, BallPhase]:  # fmt: skip
    """Whether an index combination holds, and its impulses and velocities; forms or ranges."""
    at, g = [2 * i + k for i in contacts for k in (0, 1)], model.delassus
    p: Numbers
    if table is None:
        n, t = at
        numbers = g[n][n], g[n][t], g[t][t], free[0], free[1], model.mu[contacts[0]], floors[0]
        p = one_contact_case(cases[0], *numbers)
    else:
        p = [sum_of(c * x for c, x in zip(row, [*free, *floors], strict=True)) for row in table]
    v: list[Any] = []
    for a, row in enumerate(at):
        case = cases[a // 2]
        still = case // 3 == REST if a % 2 == 0 else case % 3 == HOLD
        added = (g[row][at[b]] * p[b] for b in range(len(at)))
        v.append(ZERO if still else sum_of([free[a], *added]))
    conditions: list[Any] = []
    for k, case in enumerate(cases):
        mu, (n, t), tangential = model.mu[contacts[k]], (2 * k, 2 * k + 1), case % 3
        if case // 3 != REST:
            conditions.append(-1 if approaches else v[n])
        elif approaches and tangential != HOLD:  # p_n = -free_n / stiffness, and the floor is 0
            friction = -mu if tangential == FORWARD else mu
            stiffness = g[at[n]][at[n]] + friction * g[at[n]][at[t]]
            conditions.append(sign(stiffness) or p[n] - floors[k])
        else:
            conditions.append(p[n] - floors[k])
        if tangential == HOLD:
            bound = mu * (p[n] + p[2 - n]) if coupled else mu * p[n]
            conditions += [bound - p[t], bound + p[t]]
        else:
            conditions.append(v[t] if tangential == FORWARD else -v[t])
    return verdict(conditions), BallPhase(cases, p, v)


def _momentum(model: BallToy, sleeve: int, free: Numbers) -> Numbers:
    """-M u, the momentum that impulses must cancel so that both contacts rest and stick."""
    # u from three rows of W^T u: N1 = -h_S u_S, Nk = +-h_M u_M, Tk = u_y + r_M u_M
    u_s = free[0] / (-model.levers[0])
    u_m = free[2] / (model.levers[sleeve] * int(SIGN[sleeve]))
    u_y = free[3] - model.tangents[sleeve][1] * u_m
    u = (u_y, u_m, u_s)
    return [sum_of(-row[j] * u[j] for j in range(3)) for row in model.mass]


def _may_hold(model: BallToy, sleeve: int, load: Numbers, floors: Numbers, coupled: bool) -> bool:
    """False if no forces with W lambda = load lie in both friction cones."""
    # Three equations leave one of four forces free, s = lambda_T1, and every condition is linear in
    # it: constant + rate s >= 0. Two conditions that exclude each other refute all s.
    side = int(SIGN[sleeve])
    (_, l_m, arm), (_, r_m, _) = model.tangents[0], model.tangents[sleeve]
    lever, height = model.levers[sleeve] * side, model.levers[0]
    normal_1 = (-load[2] / height, arm / height)
    normal_k = ((load[1] - r_m * load[0]) / lever, (r_m - l_m) / lever)
    along_1, along_k = (ZERO, arb(1)), (load[0], arb(-1))
    mu_1, mu_k = model.mu[0], model.mu[sleeve]
    total = tuple(x + y for x, y in zip(normal_1, normal_k, strict=True))
    lines = [
        (normal_1[0] - floors[0], normal_1[1]),
        (normal_k[0] - floors[1], normal_k[1]),
    ]
    for mu, normal, along in ((mu_1, normal_1, along_1), (mu_k, normal_k, along_k)):
        bound = [mu * x for x in (total if coupled else normal)]
        lines += [(bound[0] + along[0] * s, bound[1] + along[1] * s) for s in (1, -1)]
    rising = [line for line in lines if sign(line[1]) == 1]
    falling = [line for line in lines if sign(line[1]) == -1]
    level = [constant for constant, rate in lines if sign(rate) == 0]
    low_above_high = (b * rate - a * fall for a, rate in rising for b, fall in falling)
    return not any(sign(each) == -1 for each in (*level, *low_above_high))


def may_rest(model: BallToy, sleeve: int, d: Any) -> bool:
    """False if the beak and a contact of the sleeve cannot hold the toy at rest at stretch d."""
    load = [-(x + y * d) for x, y in zip(model.h_0, model.h_1, strict=True)]
    return _may_hold(model, sleeve, load, [ZERO, ZERO], False)
