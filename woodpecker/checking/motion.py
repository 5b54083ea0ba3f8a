"""Verification of a return along a way: of every event, contact problem and guard.

A way names the guards that fire in turn, with brackets of the durations. Each contact problem must
have exactly one solution, by strict inequalities. Where a decision has two outcomes over the box,
the way implies which one it takes, and notes a comparator that is positive there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

from woodpecker.checking.forms import F, constant
from woodpecker.checking.guards import Guard, GuardValue, named
from woodpecker.checking.impacts import marked, rest_is_possible, slip, solve_impact, verdict
from woodpecker.checking.intervals import I, NotSeparated
from woodpecker.checking.plateaus import plateau
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, STICK, UP
from woodpecker.checking.tracker import Choice, States, Tracker, flown


def run(way: Tracker, events: Sequence[tuple[Guard, I]]) -> None:
    """Verify all events of a way, the last of which is the return."""
    settle(way, {1}, False, events[0][0])
    for k, (guard, bracket) in enumerate(events):
        last = k == len(events) - 1
        if (guard[0] == "section") != last:
            raise NotSeparated("a return ends with the section, and only there")
        if guard[0].startswith("plateau"):
            plateau(way, guard, bracket)
            continue
        phase(way, guard, bracket)
        way.events += 1
        if not last:
            event(way, events[k + 1][0])


def phase(way: Tracker, guard: Guard, bracket: I) -> None:
    """Verify that a guard ends the phase within a bracket, and move to the end of the phase."""
    curves = way.curves()
    if guard not in curves:
        raise NotSeparated(f"{named(guard)} is no guard of the mode")
    own = curves[guard]
    if (bracket.low if guard[0] == "section" else bracket.high).sign() != 1:
        raise NotSeparated("a phase has no duration")
    flies = guard[0] == "gap" and own.zeros == 2
    found = own.landing(bracket) if flies else None
    way.lands = guard[1] if found is not None else -1
    t = found or own.crossing(bracket, 1 if guard[0] == "section" else -1)
    if way.since.sign() == 1 and not way.since.less(t.value):
        raise NotSeparated(f"{named(guard)} may fire while a contact lands")
    way.since = I.of(0)
    end = t.value.high
    for curve in curves.values():
        if curve is own:
            if found is None and not own.lasts(bracket.low, bracket):
                raise NotSeparated(f"{named(guard)} may fire earlier")
        elif not curve.lasts(end, None):
            meeting(way, curve, own, bracket, t)
    move(way, t)
    way.before, way.fired = way.states, guard
    way.at_least_zero = {("gap", i) for i in range(3) if way.states[i] == OPEN}


def meeting(way: Tracker, rival: GuardValue, own: GuardValue, bracket: I, t: F) -> None:
    """Note the decision if another gap closes nearly at once: on this way it closes later."""
    other, guard = rival.guard, own.guard
    if other[0] != "gap" or guard[0] != "gap":
        raise NotSeparated(f"{named(other)} may fire before {named(guard)}")
    later = rival.crossing(bracket + (bracket - bracket.mid) * I.of(4), -1)
    both = bracket.hull(later.value)
    for curve in (rival, own):
        if curve.over(both, 1).sign() != -1 or not curve.lasts(both.low, both):
            raise NotSeparated(f"{named(other)} may fire before {named(guard)}")
    comparator = rival.at(t)
    assert isinstance(comparator, F)
    way.forks.append(Choice("meeting", (guard[1], other[1]), comparator, way.events))


def move(way: Tracker, t: F) -> None:
    """Move to the end of a phase."""
    way.q, way.u = flown(way.toy.mode(way.states), way.q, way.u, t)
    for i in range(3):
        if way.states[i] != OPEN:
            way.close(i)
    for i in range(3):
        if way.states[i] == STICK:
            way.hold(i)
    way.time = way.time + t


def event(way: Tracker, following: Guard) -> None:
    """Pass the event of the guard that fired: an impact, or a change of contact states."""
    kind, i = way.fired
    closed = {k for k in range(3) if way.states[k] != OPEN}
    if kind == "gap":
        strike(way, sorted(closed | {i}), i, following)
        return
    way.still = {k for k in closed if way.states[k] == STICK or kind == "slip"}
    if kind == "slip":
        way.hold(i)
    way.zeros = [2 if k in closed else 0 for k in range(3)]
    settle(way, closed, False, following)


def strike(way: Tracker, contacts: list[int], striking: int, following: Guard) -> None:
    """Pass an impact: compression, expansion, and which contacts stay closed."""
    toy, free = way.toy, []
    for i in contacts:
        rate = way.u[ANGLE[i]] * I.of(SIDE[i] * toy.lever[i])
        free.append(rate if i == striking else way.zero)
        free.append(way.zero if way.states[i] == STICK else slip(toy, i, way.u))
    approach = free[2 * contacts.index(striking)].value.sign()
    known = approach != -1
    if known and (way.lands != striking or len(contacts) > 1):
        raise NotSeparated("a contact may graze")
    none = [way.zero] * len(contacts)
    first = solve_impact(toy, contacts, free, none, False, known)
    floors = [floor(way, i, first.impulses[2 * k]) for k, i in enumerate(contacts)]
    signs = [floor.value.sign() for floor in floors]
    second = None
    if any(s != 0 for s in signs):
        if any(s not in (0, 1) for s in signs):
            raise NotSeparated("an impact may store no impulse")
        second = solve_impact(toy, contacts, first.velocities, floors, True, False)
    last = second or first
    for k, i in enumerate(contacts):
        for n in range(2):
            impulse = first.impulses[2 * k + n]
            if second is not None:
                impulse = impulse + second.impulses[2 * k + n]
            for j in range(3):
                way.u[j] = way.u[j] + impulse * I.of(toy.kick[2 * i + n][j])
    closed = {i for k, i in enumerate(contacts) if last.rests[k]}
    way.zeros = [0, 0, 0]
    for k, i in enumerate(contacts):
        way.q[ANGLE[i]] = constant(way.box, I.of(toy.touch[i]))
        way.zeros[i] = 2 if last.rests[k] else 1
        if last.rests[k]:
            way.close(i)
    for k, i in enumerate(contacts):
        if last.slips[k] == 0:
            way.hold(i)
    way.still = {i for k, i in enumerate(contacts) if last.slips[k] == 0 and i in closed}
    marks = [marked(first, second, k, signs[k]) for k in range(len(contacts))]
    way.word.append("I" + "+".join(f"{i + 1}{m}" for i, m in zip(contacts, marks, strict=True)))
    way.before = tuple(UP if s == OPEN and i in closed else s for i, s in enumerate(way.states))
    way.fired = ("impact", -1)
    plastic = len(contacts) == 1 and signs[0] == 0
    if not (known and plastic):
        way.lands = -1
    settle(way, closed, plastic, following)


def floor(way: Tracker, i: int, impulse: F) -> F:
    """Least normal impulse of the expansion, eps * the compression's; zero where either is."""
    eps = way.eps[i]
    if impulse.value.sign() == 0 or way.restitution(i).sign() == 0:
        return way.zero
    return impulse * eps


def settle(way: Tracker, closed: set[int], plastic: bool, following: Guard) -> None:
    """Solve the contact problem on acceleration level, and note the changes in the word."""
    choices = [[OPEN] for _ in range(3)]
    for i in closed:
        direction = 0 if i in way.still else slip(way.toy, i, way.u).value.sign()
        if direction is None:
            raise NotSeparated("the direction of slip is open")
        choices[i] += {0: [STICK, UP, DOWN], 1: [UP], -1: [DOWN]}[direction]
    verdicts = {}
    for trial in product(*choices):
        if len({s for s in trial if s != OPEN}) <= 1:
            verdicts[trial] = admissible(way, closed, trial)
    way.at_least_zero |= {("normal", way.lands)} if way.lands >= 0 else set()
    held = [trial for trial, holds in verdicts.items() if holds]
    open_ = [trial for trial, holds in verdicts.items() if holds is None]
    if len(held) == 1 and not open_:
        chosen = held[0]
    elif plastic and len(closed) == 1 and len(open_) == 2 and len(verdicts) == 2:
        chosen = stays_or_leaves(way, min(closed), open_, following)
    else:
        raise NotSeparated("a contact problem is not decided")
    note(way, chosen)
    way.lands = -1


def stays_or_leaves(way: Tracker, i: int, trials: list[States], following: Guard) -> States:
    """Let a contact whose force may be zero after an impact stay or leave, as the way goes on."""
    stay, leave = sorted(trials, key=lambda trial: trial[i] == OPEN)
    side = 1 if stay[i] == UP else -1
    g = way.toy.g
    if g[2 * i][2 * i] - side * way.toy.mu[i] * g[2 * i][2 * i + 1] <= 0:
        raise NotSeparated("a contact may neither stay nor leave")
    force = way.guard(("normal", i), stay).jet[0]
    assert isinstance(force, F)
    leaves = following == ("gap", i)
    way.forks.append(Choice("rest", (i,), -force if leaves else force, way.events, leaves))
    way.at_least_zero |= {("gap", i) if leaves else ("normal", i)}
    return leave if leaves else stay


def admissible(way: Tracker, closed: set[int], states: States) -> bool | None:
    """Whether all guards of the closed contacts become positive right after now; None if open."""
    if sum(s == STICK for s in states) == 2:
        d = way.q[2] - way.q[1]
        load = [
            -(d * I.of(y) + I.of(x))
            for x, y in zip(way.toy.at_rest, way.toy.per_stretch, strict=True)
        ]
        return rest_is_possible(way.toy, max(closed), load, [way.zero] * 2, False)
    conditions: list[Any] = []
    for i in closed:
        state = states[i]
        guards: list[Guard] = [("gap", i)]
        if state == STICK:
            guards = [("cone+", i), ("cone-", i)]
        elif state != OPEN:
            guards = [("normal", i)] + ([("slip", i)] if i in way.still else [])
        if i == way.lands:  # it is accelerated towards the pole, so that its force is positive
            conditions.append(-I.of(1) if state == OPEN else I.of(1))
            guards = guards[1:]
        for guard in guards:
            found = way.guard(guard, states)
            conditions.append(found.jet[found.zeros])
    return verdict(conditions)


def note(way: Tracker, after: States) -> None:
    """Add symbols to the word for contacts that open, stick, begin to slip or reverse."""
    for i in range(3):
        was, now = way.before[i], after[i]
        symbol = ""
        if now == OPEN:
            symbol = "D" if was != OPEN else ""
        elif now == STICK:
            symbol = "J" if was != STICK else ""
        elif was == STICK:
            symbol = "S"
        elif way.fired[0] == "slip" and was != now:
            symbol = "R"
        if symbol:
            way.word.append(f"{symbol}{i + 1}")
    way.states = after
