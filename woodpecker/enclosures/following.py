"""Returns of the toy over a box, from event to event, with decisions proved for the whole box.

A *way* is a return along one word. One decision may be open over the box. Then there are two ways
and a comparator, a form that is positive where the first way is taken, negative where the second:

- two gaps close at once: the comparator is the second gap when the first contact strikes;
- a contact stopped by an impact stays or leaves: it is the normal force. The gap of a contact that
  leaves is t^2 h(t) with h(0) proportional to the force, and it lands where h vanishes;
- a gap closes before or after the middle of a plateau of its motion: it is the gap there
  (:mod:`woodpecker.enclosures.plateaus`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from woodpecker.enclosures.balls import ZERO, sum_of
from woodpecker.enclosures.contacts import impulses_of, may_rest, only, verdict
from woodpecker.enclosures.forms import box, centre, sign, start
from woodpecker.enclosures.model import BallToy, State
from woodpecker.enclosures.motions import (
    NO_GUARD,
    OpenDecision,
    Way,
    direction_of_slip,
    flown,
    hold,
    slip,
    touch,
)
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.oscillator import (
    Guard,
    ZeroCrossing,
    crossing,
    landing,
    name_of,
)
from woodpecker.enclosures.plateaus import land_at_plateau
from woodpecker.enclosures.taylor import Frame
from woodpecker.mechanics.cases import HOLD, REST
from woodpecker.mechanics.contact_problems import UNSOLVED
from woodpecker.mechanics.impacts import MARKS, mark
from woodpecker.mechanics.modes import (
    ANGLE,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    GAP,
    NORMAL,
    OPEN,
    SECTION,
    SIGN,
    SLIP,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    watched,
)
from woodpecker.motion.codes import IMPACT
from woodpecker.motion.guards import first_root
from woodpecker.motion.recording import append_transitions

MOST_EVENTS = 400  # in one return; longer ones are not proved


def follow(model: BallToy, frame: Frame, curve: Sequence[Any], plateaus: bool = False) -> list[Way]:
    """The one or two ways of a return over a box, from the section at phi_S = curve(p) + s.

    ``curve`` has the coefficients of powers of p. With ``plateaus`` a landing near a plateau is one
    event, with first derivatives only. NotProved if another decision is open, or more than one.
    """
    phi_s = start(frame, curve)
    if sign(model.limits[0] - phi_s) != 1:
        raise NotProved("the beak may touch the pole at the start")
    motion = Way([ZERO, model.limits[1], phi_s], [ZERO] * 3, ZERO)
    todo, found = _settled(model, motion, {1}), list[Way]()
    while todo:  # at most one decision is open, so there are at most two ways
        current = todo.pop()
        for after in _next(model, current, plateaus):
            (found if after.log[-1].guard == SECTION else todo).append(after)
        if len(current.log) > MOST_EVENTS:
            raise NotProved("the toy does not return within so many events")
    return sorted(found, key=lambda way: [-fork.side for fork in way.forks])


def _guard(model: BallToy, motion: Way, states: State, guard: int) -> Guard:
    """A guard at the start of a phase in some contact states, with the exact zeros of its jet."""
    kind, i = guard // 3 * 3, guard % 3
    mode, q, u = model.mode(states), motion.q, motion.u
    d0, d1 = q[2] - q[1], u[2] - u[1]
    d2 = mode.alpha + mode.kappa * d0
    order, assumed = 0, guard in motion.assumed
    if guard == SECTION:
        order = int(box(d1).is_zero())
        jet = [d1, d2, mode.kappa * d1, mode.kappa * d2]
    elif kind == GAP:
        j, side = ANGLE[i], int(SIGN[i])
        order = motion.orders[i]
        # opened because its force vanished: then its acceleration is zero, too
        if order == 2 and motion.fired == NORMAL + i and _only_opens(motion.before, states, i):
            order = 3
        a, b = mode.a[j], mode.b[j]
        jet = [(q[j] - model.limits[i]) * side, u[j] * side, (a + b * d0) * side, b * d1 * side]
        if _let_go(motion, states, i):  # the sleeve's velocity and acceleration are still zero
            jet[1] = jet[2] = ZERO
        assumed = assumed or order == 0
    elif kind == SLIP:
        side = 1 if states[i] == SLIP_POSITIVE else -1
        w = [x * side for x in model.tangents[i]]
        along, steady, speed = (
            sum_of(x * y for x, y in zip(w, each, strict=True)) for each in (mode.b, mode.a, u)
        )
        jet = [speed, steady + along * d0, along * d1, along * d2]
        if i in motion.held:
            # slip that begins at the edge of the cone has no acceleration at first
            edge = CONE_POSITIVE if states[i] == SLIP_NEGATIVE else CONE_NEGATIVE
            order = 2 if motion.fired == edge + i else 1
    else:
        p, r = _force(model, mode.forces[i], kind, i)
        jet = [p + r * d0, r * d1, r * d2, r * mode.kappa * d1]
        order = int(guard == motion.fired and states == motion.before)
    return Guard(guard, (ZERO,) * order + tuple(jet[order:]), order, mode.kappa, assumed)


def _only_opens(before: State, states: State, i: int) -> bool:
    """Whether all contacts but i are in the states before."""
    return all(states[k] == before[k] for k in range(3) if k != i)


def _let_go(motion: Way, states: State, i: int) -> bool:
    """Whether the sleeve's other contact has just opened because its normal force vanished."""
    other = 3 - i
    return i > 0 and motion.fired == NORMAL + other and _only_opens(motion.before, states, other)


def _force(model: BallToy, forces: Sequence[Any], kind: int, i: int) -> tuple[Any, Any]:
    """Coefficients (p, r) of a guard on contact forces, p + r d."""
    p_n, r_n, p_t, r_t = forces
    if kind == NORMAL:
        return p_n, r_n
    mu, side = model.mu[i], 1 if kind == CONE_POSITIVE else -1
    return mu * p_n - p_t * side, mu * r_n - r_t * side


def _next(model: BallToy, motion: Way, plateaus: bool) -> list[Way]:
    """The one or two motions at the start of the next phase, or at the return."""
    guards = [_guard(model, motion, motion.states, code) for code in watched(motion.states)]
    guesses = {guard.code: _guess(guard) for guard in guards}
    first = min(guards, key=lambda guard: guesses[guard.code])
    if guesses[first.code] == math.inf:
        raise NotProved("no event follows: the toy falls freely, or rests")
    if plateaus and first.code < NORMAL and _let_go(motion, motion.states, first.code):
        others = [guard for guard in guards if guard is not first]
        found = land_at_plateau(model, motion, first, others, guesses[first.code])
        if found:
            return found
    fires = _fires(first, guesses[first.code])
    if motion.since > 0 and not box(fires.duration).lower() > motion.since:
        raise NotProved("an event may follow at a plateau")
    end = box(fires.duration).upper()
    if not end > 0:
        raise NotProved("an event may lie in the past")
    rivals = [guard for guard in guards if guard is not first and not guard.lasts(end)]
    if rivals:
        return _meeting(model, motion, first, fires, rivals, guesses)
    if not fires.lands and not first.lasts(fires.bracket.lower(), fires.bracket):
        raise NotProved(f"{name_of(first.code)} may fire earlier")
    return _arrive(model, _moved(model, motion, fires))


def _meeting(
    model: BallToy, motion: Way, first: Guard, fires: ZeroCrossing, rivals: list[Guard],
    guesses: dict[int, float],
) -> list[Way]:  # fmt: skip
    # Both gaps fall: so the second is still positive when the first closes iff it closes later.
    second = rivals[0]
    if len(rivals) > 1 or first.code >= NORMAL or second.code >= NORMAL:
        raise NotProved(f"{name_of(second.code)} may fire before {name_of(first.code)}")
    other = crossing(second, guesses[second.code])
    span = fires.bracket.union(other.bracket)
    for guard in (first, second):
        if not guard.lasts(span.lower(), span):
            raise NotProved(f"{name_of(guard.code)} may fire earlier")
    comparator, found = second.near(fires.duration)(0), []
    for side, ends in ((1, fires), (-1, other)):
        way = motion.copy()
        way.forks.append(OpenDecision(comparator, side, jumps=True))
        found += _arrive(model, _moved(model, way, ends))
    return found


def _guess(guard: Guard) -> float:
    """Time at which a guard fires at the centre of the box, in doubles; inf if it does not."""
    f0, f1, f2, f3 = (float(centre(f)) for f in guard.jet)
    kappa = float(centre(guard.kappa))
    omega = math.sqrt(abs(kappa))
    if guard.code == SECTION:
        angle = math.atan2(-f0, f1 / omega)
        return (angle if angle > 0.0 else angle + 2.0 * math.pi) / omega
    leading = guard.jet[guard.order]
    if guard.assumed and sign(leading) is None:
        if guard.order == 0 and f1 < 0.0:
            return -f0 / f1
        if guard.order == 2 and f3 < 0.0:
            return -3.0 * f2 / f3
    return float(first_root(max(0.0, f0), f1, f2, f3, kappa, omega, math.inf))


def _fires(guard: Guard, guess: float) -> ZeroCrossing:
    if guard.code == SECTION:
        turns = crossing(guard, guess, falls=1)
        if not turns.bracket > 0:
            raise NotProved("the bird may turn where the sleeve jams")
        return turns
    if guard.code < NORMAL and guard.order == 1 and sign(guard.jet[1]) != 1:
        raise NotProved("impacts may accumulate")
    if guard.code < NORMAL and guard.order == 2:
        lands = landing(guard, guess)
        if lands is not None:
            return lands
    return crossing(guard, guess)


def _moved(model: BallToy, motion: Way, fires: ZeroCrossing) -> Way:
    t, fired = fires.duration, fires.guard
    after = motion.copy()
    states = motion.states
    after.q, after.u = flown(model.mode(states), motion.q, motion.u, t)
    # The mode keeps these gaps and slips exactly at zero, which the ranges of forms do not show.
    for i in range(3):
        if states[i] != OPEN:
            touch(model, after, i)
            after.u[ANGLE[i]] = ZERO
    for i in range(3):
        if states[i] == STICK or (states[i] != OPEN and fired == SLIP + i):
            hold(model, after, i)
    after.time = motion.time + t
    after.log.append(fires)
    after.fired, after.before = fired, states
    after.lands = fired if fires.lands else NO_GUARD
    after.assumed = frozenset()
    after.since = ZERO
    return after


def _arrive(model: BallToy, motion: Way) -> list[Way]:
    fired, states = motion.fired, motion.states
    if fired == SECTION:
        return [motion]
    closed = {i for i in range(3) if states[i] != OPEN}
    if fired < NORMAL:
        return _strike(model, motion, sorted(closed | {fired}))
    slides = fired >= SLIP
    motion.held = frozenset(i for i in closed if states[i] == STICK or slides)
    motion.orders = [2 if i in closed else 0 for i in range(3)]
    return _settled(model, motion, closed)


def _strike(model: BallToy, motion: Way, contacts: list[int]) -> list[Way]:
    u, striking = motion.u, motion.fired
    free: list[Any] = []
    for i in contacts:
        j = ANGLE[i]
        rate = model.levers[i] * int(SIGN[i])
        free.append(u[j] * rate if i == striking else ZERO)
        free.append(ZERO if motion.states[i] == STICK else slip(model, i, u))
    # After a flight from rest a contact does approach, even if the range of its speed holds zero.
    visible = sign(free[2 * contacts.index(striking)]) == -1
    approaches = not visible and motion.lands == striking and len(contacts) == 1
    if not visible and not approaches:
        raise NotProved(f"contact {striking + 1} may only graze")
    first = impulses_of(model, contacts, free, None, approaches)
    floors = [_floor(model.eps[i], first.impulses[2 * k]) for k, i in enumerate(contacts)]
    second = None
    if any(sign(floor) != 0 for floor in floors):
        if any(sign(floor) is None for floor in floors):
            raise NotProved("an impact may store no impulse")
        second = impulses_of(model, contacts, first.velocities, floors, False)
    last = second or first
    for k, i in enumerate(contacts):
        for n in range(2):
            impulse = first.impulses[2 * k + n]
            if second is not None:
                impulse = impulse + second.impulses[2 * k + n]
            for j in range(3):
                u[j] = u[j] + model.responses[2 * i + n][j] * impulse
    marks, mask, closed = [0, 0], 0, set()
    motion.orders, held = [0, 0, 0], set()
    for k, i in enumerate(contacts):
        mask += 1 << i
        case = last.cases[k]
        expansion = UNSOLVED if second is None else second.cases[k]
        marks[k] = mark(first.cases[k], expansion, second is not None, sign(floors[k]) == 1)
        touch(model, motion, i)
        motion.orders[i] = 2 if case // 3 == REST else 1
        if case // 3 == REST:
            closed.add(i)
            u[ANGLE[i]] = ZERO
        if case % 3 == HOLD:
            held.add(i)
    for i in held:
        hold(model, motion, i)
    motion.codes.append(64 * (marks[0] + MARKS * marks[1]) + 8 * IMPACT + mask)
    motion.before = tuple(
        motion.states[i] if motion.states[i] != OPEN or i not in closed else SLIP_POSITIVE
        for i in range(3)
    )
    plastic = len(contacts) == 1 and sign(floors[0]) == 0
    motion.fired, motion.held = NO_GUARD, frozenset(held & closed)
    if not approaches or not plastic:
        motion.lands = NO_GUARD
    return _settled(model, motion, closed, plastic)


def _floor(eps: Any, impulse: Any) -> Any:
    """Least normal impulse of the expansion, eps * the compression's; zero where either is."""
    return ZERO if sign(eps) == 0 or sign(impulse) == 0 else eps * impulse


def _settled(model: BallToy, motion: Way, closed: set[int], plastic: bool = False) -> list[Way]:
    """Solve the contact problem on acceleration level: the motions in one mode, or in two."""
    # All combinations of states of the closed contacts are tried. In the right one every guard is
    # positive right after now: so is the first of its derivatives that is not exactly zero.
    slips = {i: 0 if i in motion.held else direction_of_slip(model, i, motion.u) for i in closed}
    options = [[OPEN] if i not in closed else _options(slips[i]) for i in range(3)]
    # Two closed contacts share the velocity of the sleeve.
    trials = [each for each in product(*options) if len({*each} - {OPEN}) <= 1]
    verdicts = {trial: _admissible(model, motion, closed, trial) for trial in trials}
    open_ = [trial for trial in trials if verdicts[trial] is None]
    if plastic and len(closed) == 1 and len(open_) == 2 and len(trials) == 2:
        return _stays_or_leaves(model, motion, min(closed), trials)
    chosen = only([(verdicts[trial], trial) for trial in trials], "a contact problem")
    pressed = motion.lands >= 0 and chosen[motion.lands] != OPEN
    return [_set_off(motion, chosen, {NORMAL + motion.lands} if pressed else set())]


def _stays_or_leaves(model: BallToy, motion: Way, i: int, trials: list[State]) -> list[Way]:
    """Both ways of a contact at rest whose normal force may be zero: it stays, or it leaves."""
    # If it leaves, the gap's acceleration is -G times the force that it would have if it stayed,
    # with G = G_NN -+ mu G_NT > 0. So exactly one of the two holds.
    stay, leave = sorted(trials, key=lambda trial: trial[i] == OPEN)
    n, t = 2 * i, 2 * i + 1
    mu = model.mu[i]
    friction = -mu if stay[i] == SLIP_POSITIVE else mu
    if sign(model.delassus[n][n] + friction * model.delassus[n][t]) != 1:
        raise NotProved("a contact may be neither left nor held")
    force = _guard(model, motion, stay, NORMAL + i).jet[0]
    found = []
    for side, trial in ((1, stay), (-1, leave)):
        way = motion.copy()
        way.forks.append(OpenDecision(force, side))
        found.append(_set_off(way, trial, {(NORMAL if side == 1 else GAP) + i}))
    return found


def _options(slip: int) -> list[int]:
    if slip == 0:
        return [STICK, SLIP_POSITIVE, SLIP_NEGATIVE, OPEN]
    return [SLIP_POSITIVE if slip > 0 else SLIP_NEGATIVE, OPEN]


def _admissible(model: BallToy, motion: Way, closed: set[int], trial: State) -> bool | None:
    if sum(state == STICK for state in trial) == 2:
        if may_rest(model, max(closed), motion.q[2] - motion.q[1]):
            raise NotProved("the toy may come to rest")
        return False
    conditions: list[Any] = []
    for i in closed:
        if trial[i] == OPEN:
            codes = [GAP + i]
        elif trial[i] == STICK:
            codes = [CONE_POSITIVE + i, CONE_NEGATIVE + i]
        else:
            codes = [NORMAL + i] + ([SLIP + i] if i in motion.held else [])
        if motion.lands == i:  # it is accelerated towards the pole, so that its force is positive
            conditions.append(-1 if trial[i] == OPEN else 1)
            codes = codes[1:]
        for code in codes:
            guard = _guard(model, motion, trial, code)
            conditions.append(guard.jet[guard.order])
    return verdict(conditions)


def _set_off(motion: Way, states: State, assumed: set[int]) -> Way:
    codes, counts = np.zeros(3, dtype=np.int16), np.zeros(1, dtype=np.int64)
    append_transitions(np.array(motion.before), np.array(states), motion.fired, codes, counts)
    motion.codes += codes[: counts[0]].tolist()
    motion.states, motion.assumed, motion.lands = states, frozenset(assumed), NO_GUARD
    return motion
