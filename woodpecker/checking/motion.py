"""A return along given guards, verified: every event, every contact problem, every guard between.

A way names the guards that fire in turn, with intervals that hold the durations. Each contact
problem must have one solution by strict inequalities and none else. Where one decision has two
outcomes over the box, the way says which it takes, with a comparator that is positive there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Any

from woodpecker.checking.forms import F, constant, waves
from woodpecker.checking.guards import Guard, GuardValue, named
from woodpecker.checking.impacts import marked, rest_is_possible, slip, solve_impact, verdict
from woodpecker.checking.intervals import Box, I, NotSeparated
from woodpecker.checking.pausing import Flight, pause
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, STICK, UP, Coasting, ExactToy


@dataclass
class Choice:
    """An open decision: its kind, the contacts, and a comparator positive on this way."""

    kind: str
    contacts: tuple[int, ...]
    comparator: F
    at: int  # counts the events before
    leaves: bool = False  # whether a contact that may rest leaves


@dataclass
class Tracker:
    """The toy on its way: state, contact states, and what the last event has made exactly zero."""

    toy: ExactToy
    box: Box
    eps: list[F | I]
    q: list[F]
    u: list[F]
    states: tuple[int, int, int] = (OPEN, STICK, OPEN)
    before: tuple[int, int, int] = (OPEN, STICK, OPEN)
    zeros: list[int] = field(default_factory=lambda: [0, 2, 0])  # of each gap: f, f', f''
    still: set[int] = field(default_factory=lambda: {1})  # closed contacts without slip
    fired: Guard = ("", -1)
    at_least_zero: set[Guard] = field(default_factory=set)
    lands: int = -1  # the contact that strikes after a flight that began at rest
    since: I = field(default_factory=lambda: I.of(0))  # the phase has begun by then
    word: list[str] = field(default_factory=list)
    forks: list[Choice] = field(default_factory=list)
    time: F | None = None
    events: int = 0

    def run(self, events: Sequence[tuple[Guard, I]]) -> None:
        """Follow all events; the last one is the return."""
        self.time = constant(self.box, I.of(0))
        self.settle({1}, False, events[0][0])
        for k, (guard, bracket) in enumerate(events):
            last = k == len(events) - 1
            if (guard[0] == "section") != last:
                raise NotSeparated("a return ends with the section, and only there")
            if guard[0].startswith("plateau"):
                self.plateau(guard, bracket)
                continue
            self.phase(guard, bracket)
            self.events += 1
            if not last:
                self.event(events[k + 1][0])

    def watched(self) -> Iterator[Guard]:
        """Guards of the mode."""
        for i, state in enumerate(self.states):
            if state == OPEN:
                if i == 0 or self.states[1] == self.states[2] == OPEN:
                    yield ("gap", i)
            elif state == STICK:
                yield ("cone+", i)
                yield ("cone-", i)
            else:
                yield ("normal", i)
                yield ("slip", i)
        if self.states == (OPEN, STICK, OPEN):
            yield ("section", 0)

    def curves(self) -> dict[Guard, GuardValue]:
        """The guards of the mode over the phase that begins now."""
        kappa, found = I.of(self.toy.mode(self.states).kappa), {}
        for guard in self.watched():
            jet, zeros = self.jet(guard, self.states)
            known = guard in self.at_least_zero
            found[guard] = GuardValue(self.box, guard, kappa, jet, zeros, known)
        return found

    def jet(self, guard: Guard, states: tuple[int, int, int]) -> tuple[list[F | I], int]:
        """Value and three derivatives of a guard where a phase begins, and how many are zero."""
        kind, i = guard
        m = self.toy.mode(states)
        d0, d1 = self.q[2] - self.q[1], self.u[2] - self.u[1]
        kappa = I.of(m.kappa)
        d2 = d0 * kappa + I.of(m.alpha)
        zeros = 0
        jet: list[F | I]
        if kind == "section":
            zeros = int(self.fired == ("", -1) and not self.word)
            jet = [d1, d2, d1 * kappa, d2 * kappa]
        elif kind == "gap":
            j, side = ANGLE[i], I.of(SIDE[i])
            zeros = self.zeros[i]
            others = all(states[k] == self.before[k] for k in range(3) if k != i)
            if zeros == 2 and self.fired == ("normal", i) and others:
                zeros = 3
            gap = (self.q[j] - I.of(self.toy.touch[i])) * side
            bend = (d0 * I.of(m.b[j]) + I.of(m.a[j])) * side
            jet = [gap, self.u[j] * side, bend, d1 * (I.of(m.b[j]) * side)]
            if self.let_go(i, states):
                jet[1] = jet[2] = I.of(0)
        elif kind == "slip":
            side = I.of(1) if states[i] == UP else -I.of(1)
            w = self.toy.tangent[i]
            along = sum((w[k] * m.b[k] for k in range(3)), Fraction(0))
            steady = sum((w[k] * m.a[k] for k in range(3)), Fraction(0))
            c = I.of(along) * side
            jet = [
                slip(self.toy, i, self.u) * side,
                (d0 * I.of(along) + I.of(steady)) * side,
                d1 * c,
                d2 * c,
            ]
            if i in self.still:
                edge = "cone+" if states[i] == DOWN else "cone-"
                zeros = 2 if self.fired == (edge, i) else 1
        else:
            p, r = force(self.toy, m, kind, i)
            jet = [d0 * r + p, d1 * r, d2 * r, d1 * (r * kappa)]
            zeros = int(self.fired == guard and states == self.before)
        return [I.of(0)] * zeros + jet[zeros:], zeros

    def let_go(self, i: int, states: tuple[int, int, int]) -> bool:
        """Whether the other contact of the sleeve has just opened, for want of a force."""
        k = 3 - i
        same = all(states[n] == self.before[n] for n in range(3) if n != k)
        return i > 0 and self.fired == ("normal", k) and states[k] == OPEN and same

    def plateau(self, guard: Guard, bracket: I) -> None:
        """A contact lands near a pause of its motion: from the middle of the pause it slides."""
        kind, i = guard
        gap = ("gap", i)
        if self.states != (OPEN, OPEN, OPEN) or not self.let_go(i, self.states):
            raise NotSeparated("a gap has a pause only where the sleeve has just let go")
        if self.restitution(i).sign() != 0:
            raise NotSeparated("only a contact without restitution lands at a plateau")
        curves = self.curves()
        own = curves.pop(gap)
        late = kind == "plateau+"
        flight = Flight(self.toy, self.box, self.q, self.u, tuple(curves.values()))
        after = pause(flight, i, late, bracket, own.jet)
        self.q, self.u, self.states, level = after.q, after.u, after.states, after.level
        self.close(i)
        assert self.time is not None
        self.time, self.since = self.time + after.middle, after.last
        if level.value.sign() is None:
            comparator = level if late else -level
            self.forks.append(Choice("plateau", (i,), comparator, self.events, not late))
        strike = f"I{i + 1}"
        self.word += [strike] if late else [strike, f"D{i + 1}", strike]
        self.fired, self.before = ("impact", -1), self.states
        self.zeros, self.still, self.lands = [2 if k == i else 0 for k in range(3)], set(), -1
        self.at_least_zero = {("normal", i)}
        self.events += 1

    def restitution(self, i: int) -> I:
        """The range of a restitution coefficient."""
        eps = self.eps[i]
        return eps if isinstance(eps, I) else eps.value

    def phase(self, guard: Guard, bracket: I) -> None:
        """Verify that a guard ends the phase within a bracket, and go there."""
        m = self.toy.mode(self.states)
        kappa = I.of(m.kappa)
        curves = self.curves()
        if guard not in curves:
            raise NotSeparated(f"{named(guard)} is no guard of the mode")
        own = curves[guard]
        if (bracket.low if guard[0] == "section" else bracket.high).sign() != 1:
            raise NotSeparated("a phase has no duration")
        flies = guard[0] == "gap" and own.zeros == 2
        found = own.landing(bracket) if flies else None
        self.lands = guard[1] if found is not None else -1
        t = (
            found
            if found is not None
            else own.crossing(bracket, 1 if guard[0] == "section" else -1)
        )
        if self.since.sign() == 1 and not self.since.less(t.value):
            raise NotSeparated(f"{named(guard)} may fire while a contact lands")
        self.since = I.of(0)
        end = t.value.high
        for other, curve in curves.items():
            if other == guard:
                if found is None and not curve.lasts(bracket.low, bracket):
                    raise NotSeparated(f"{named(guard)} may fire earlier")
            elif not curve.lasts(end, None):
                self.meeting(curve, other, own, guard, bracket, t)
        self.move(m, kappa, t)
        self.before, self.fired = self.states, guard
        self.at_least_zero = {("gap", i) for i in range(3) if self.states[i] == OPEN}

    def meeting(
        self, rival: GuardValue, other: Guard, own: GuardValue, guard: Guard, bracket: I, t: F
    ) -> None:
        """Another gap closes at nearly the same time: this way is taken where it closes later."""
        if other[0] != "gap" or guard[0] != "gap":
            raise NotSeparated(f"{named(other)} may fire before {named(guard)}")
        later = rival.crossing(bracket + (bracket - bracket.mid) * I.of(4), -1)
        both = bracket.hull(later.value)
        for curve in (rival, own):
            if curve.over(both, 1).sign() != -1 or not curve.lasts(both.low, both):
                raise NotSeparated(f"{named(other)} may fire before {named(guard)}")
        comparator = rival.at(t)
        assert isinstance(comparator, F)
        self.forks.append(Choice("meeting", (guard[1], other[1]), comparator, self.events))

    def move(self, m: Coasting, kappa: I, t: F) -> None:
        """The state at the end of a phase."""
        s = [x for x in waves(kappa, t) if isinstance(x, F)]
        d0, d1 = self.q[2] - self.q[1], self.u[2] - self.u[1]
        alpha, half = I.of(m.alpha), I.of(Fraction(1, 2))
        once = d0 * s[1] + d1 * s[2] + s[3] * alpha
        twice = d0 * s[2] + d1 * s[3] + s[4] * alpha
        square = t * t * half
        for j in range(3):
            a, b = I.of(m.a[j]), I.of(m.b[j])
            self.q[j] = self.q[j] + self.u[j] * t + square * a + twice * b
            self.u[j] = self.u[j] + t * a + once * b
        for i in range(3):
            if self.states[i] != OPEN:
                self.close(i)
        for i in range(3):
            if self.states[i] == STICK:
                self.hold(i)
        assert self.time is not None
        self.time = self.time + t

    def close(self, i: int) -> None:
        """A contact touches and stays."""
        self.q[ANGLE[i]] = constant(self.box, I.of(self.toy.touch[i]))
        self.u[ANGLE[i]] = constant(self.box, I.of(0))

    def hold(self, i: int) -> None:
        """The slip of a contact is exactly zero."""
        w = self.toy.tangent[i]
        self.u[0] = -(self.u[1] * I.of(w[1]) + self.u[2] * I.of(w[2]))

    def event(self, following: Guard) -> None:
        """What happens where a guard fires."""
        kind, i = self.fired
        closed = {k for k in range(3) if self.states[k] != OPEN}
        if kind == "gap":
            self.strike(sorted(closed | {i}), i, following)
            return
        self.still = {k for k in closed if self.states[k] == STICK or kind == "slip"}
        if kind == "slip":
            self.hold(i)
        self.zeros = [2 if k in closed else 0 for k in range(3)]
        self.settle(closed, False, following)

    def strike(self, contacts: list[int], striking: int, following: Guard) -> None:
        """An impact: compression, expansion, and what stays in contact."""
        toy, free = self.toy, []
        for i in contacts:
            rate = self.u[ANGLE[i]] * I.of(SIDE[i] * toy.lever[i])
            free.append(rate if i == striking else constant(self.box, I.of(0)))
            free.append(
                constant(self.box, I.of(0))
                if self.states[i] == STICK
                else slip(self.toy, i, self.u)
            )
        approach = free[2 * contacts.index(striking)].value.sign()
        known = approach != -1
        if known and (self.lands != striking or len(contacts) > 1):
            raise NotSeparated("a contact may graze")
        none = [constant(self.box, I.of(0))] * len(contacts)
        first = solve_impact(self.toy, contacts, free, none, False, known)
        floors = [self.floor(i, first.impulses[2 * k]) for k, i in enumerate(contacts)]
        signs = [floor.value.sign() for floor in floors]
        second = None
        if any(s != 0 for s in signs):
            if any(s not in (0, 1) for s in signs):
                raise NotSeparated("an impact may store no impulse")
            second = solve_impact(self.toy, contacts, first.velocities, floors, True, False)
        last = second or first
        for k, i in enumerate(contacts):
            for n in range(2):
                impulse = first.impulses[2 * k + n]
                if second is not None:
                    impulse = impulse + second.impulses[2 * k + n]
                for j in range(3):
                    self.u[j] = self.u[j] + impulse * I.of(toy.kick[2 * i + n][j])
        closed = {i for k, i in enumerate(contacts) if last.rests[k]}
        self.zeros = [0, 0, 0]
        for k, i in enumerate(contacts):
            self.q[ANGLE[i]] = constant(self.box, I.of(toy.touch[i]))
            self.zeros[i] = 2 if last.rests[k] else 1
            if last.rests[k]:
                self.close(i)
        for k, i in enumerate(contacts):
            if last.slips[k] == 0:
                self.hold(i)
        self.still = {i for k, i in enumerate(contacts) if last.slips[k] == 0 and i in closed}
        marks = [marked(first, second, k, signs[k]) for k in range(len(contacts))]
        self.word.append(
            "I" + "+".join(f"{i + 1}{m}" for i, m in zip(contacts, marks, strict=True))
        )
        states = [UP if s == OPEN and i in closed else s for i, s in enumerate(self.states)]
        self.before = (states[0], states[1], states[2])
        self.fired = ("impact", -1)
        plastic = len(contacts) == 1 and signs[0] == 0
        if not (known and plastic):
            self.lands = -1
        self.settle(closed, plastic, following)

    def floor(self, i: int, impulse: F) -> F:
        """The least impulse of the expansion."""
        eps = self.eps[i]
        if impulse.value.sign() == 0 or self.restitution(i).sign() == 0:
            return constant(self.box, I.of(0))
        return impulse * eps

    def settle(self, closed: set[int], plastic: bool, following: Guard) -> None:
        """The contact problem on acceleration level, and the symbols of what changes."""
        slips = {}
        for i in closed:
            slips[i] = 0 if i in self.still else slip(self.toy, i, self.u).value.sign()
            if slips[i] is None:
                raise NotSeparated("the direction of slip is open")
        choices = []
        for i in range(3):
            if i not in closed:
                choices.append([OPEN])
            elif slips[i] == 0:
                choices.append([OPEN, STICK, UP, DOWN])
            else:
                choices.append([OPEN, UP if slips[i] == 1 else DOWN])
        verdicts = {}
        for trial in product(*choices):
            if len({s for s in trial if s != OPEN}) <= 1:
                verdicts[(trial[0], trial[1], trial[2])] = self.admissible(closed, trial)
        self.at_least_zero |= {("normal", self.lands)} if self.lands >= 0 else set()
        held = [trial for trial, holds in verdicts.items() if holds]
        open_ = [trial for trial, holds in verdicts.items() if holds is None]
        if len(held) == 1 and not open_:
            chosen = held[0]
        elif plastic and len(closed) == 1 and len(open_) == 2 and len(verdicts) == 2:
            chosen = self.stays_or_leaves(min(closed), open_, following)
        else:
            raise NotSeparated("a contact problem is not decided")
        self.note(chosen)
        self.lands = -1

    def stays_or_leaves(
        self, i: int, trials: list[tuple[int, int, int]], following: Guard
    ) -> tuple[int, int, int]:
        """A contact that an impact has stopped, with a force near zero: as the way says."""
        stay, leave = sorted(trials, key=lambda trial: trial[i] == OPEN)
        side = 1 if stay[i] == UP else -1
        g = self.toy.g
        if g[2 * i][2 * i] - side * self.toy.mu[i] * g[2 * i][2 * i + 1] <= 0:
            raise NotSeparated("a contact may neither stay nor leave")
        force_ = self.jet(("normal", i), stay)[0][0]
        assert isinstance(force_, F)
        leaves = following == ("gap", i)
        self.forks.append(Choice("rest", (i,), -force_ if leaves else force_, self.events, leaves))
        self.at_least_zero |= {("gap", i) if leaves else ("normal", i)}
        return leave if leaves else stay

    def admissible(self, closed: set[int], trial: tuple[int, ...]) -> bool | None:
        """Whether all guards of the closed contacts are positive right after now."""
        states = (trial[0], trial[1], trial[2])
        if sum(s == STICK for s in states) == 2:
            d = self.q[2] - self.q[1]
            load = [
                -(d * I.of(y) + I.of(x))
                for x, y in zip(self.toy.at_rest, self.toy.per_stretch, strict=True)
            ]
            none = [constant(self.box, I.of(0))] * 2
            return (
                False
                if rest_is_possible(self.toy, max(closed), load, none, False) is False
                else None
            )
        conditions: list[Any] = []
        for i in closed:
            state = states[i]
            guards: list[Guard] = [("gap", i)]
            if state == STICK:
                guards = [("cone+", i), ("cone-", i)]
            elif state != OPEN:
                guards = [("normal", i)] + ([("slip", i)] if i in self.still else [])
            if i == self.lands:  # its acceleration towards the pole is known
                conditions.append(-I.of(1) if state == OPEN else I.of(1))
                guards = guards[1:]
            for guard in guards:
                jet, zeros = self.jet(guard, states)
                conditions.append(jet[zeros])
        return verdict(conditions)

    def note(self, after: tuple[int, int, int]) -> None:
        """Symbols of contacts that open, stick, begin to slip or reverse."""
        for i in range(3):
            was, now = self.before[i], after[i]
            symbol = ""
            if now == OPEN:
                symbol = "D" if was != OPEN else ""
            elif now == STICK:
                symbol = "J" if was != STICK else ""
            elif was == STICK:
                symbol = "S"
            elif self.fired[0] == "slip" and was != now:
                symbol = "R"
            if symbol:
                self.word.append(f"{symbol}{i + 1}")
        self.states = after


def force(toy: ExactToy, m: Coasting, kind: str, i: int) -> tuple[I, I]:
    """A guard p + r d on contact forces."""
    n0, n1, t0, t1 = m.forces[i]
    if kind == "normal":
        return I.of(n0), I.of(n1)
    side = 1 if kind == "cone+" else -1
    return I.of(toy.mu[i] * n0 - side * t0), I.of(toy.mu[i] * n1 - side * t1)
