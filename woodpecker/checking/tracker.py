"""State of the toy over a box, and its guards at the start of a phase."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from woodpecker.checking.forms import F, constant, waves
from woodpecker.checking.guards import Guard, GuardValue
from woodpecker.checking.impacts import slip, total
from woodpecker.checking.intervals import Box, I
from woodpecker.checking.toy import ANGLE, DOWN, OPEN, SIDE, STICK, UP, Coasting, ExactToy, dot

States = tuple[int, ...]  # of the three contacts


@dataclass
class Choice:
    """An open decision: its kind, its contacts, and a comparator that is positive on this way."""

    kind: str
    contacts: tuple[int, ...]
    comparator: F
    at: int  # number of events before it
    leaves: bool = False  # whether the contact leaves, where it may also stay


@dataclass
class Tracker:
    """The toy's state, its contacts, and what the last event has made exactly zero."""

    toy: ExactToy
    box: Box
    eps: list[F | I]
    q: list[F]
    u: list[F]
    states: States = (OPEN, STICK, OPEN)
    before: States = (OPEN, STICK, OPEN)
    zeros: list[int] = field(default_factory=lambda: [0, 2, 0])  # per gap, of f, f', f'', ..
    still: set[int] = field(default_factory=lambda: {1})  # closed contacts, slip exactly zero
    fired: Guard = ("", -1)
    at_least_zero: set[Guard] = field(default_factory=set)
    lands: int = -1  # the contact that strikes after a flight from rest
    since: I = field(default_factory=lambda: I.of(0))  # time by which a landing at a pause ends
    word: list[str] = field(default_factory=list)
    forks: list[Choice] = field(default_factory=list)
    events: int = 0

    def __post_init__(self) -> None:
        self.zero = self.time = constant(self.box, I.of(0))

    def curves(self) -> dict[Guard, GuardValue]:
        """The guards that are watched in the phase that begins now."""
        return {guard: self.guard(guard, self.states) for guard in self._watched()}

    def _watched(self) -> Iterator[Guard]:
        for i, state in enumerate(self.states):
            if state == OPEN:
                if i == 0 or self.states[1] == self.states[2] == OPEN:
                    yield ("gap", i)
            else:
                kinds = ("cone+", "cone-") if state == STICK else ("normal", "slip")
                yield from ((kind, i) for kind in kinds)
        if self.states == (OPEN, STICK, OPEN):
            yield ("section", 0)

    def guard(self, guard: Guard, states: States) -> GuardValue:
        """A guard in some contact states, from its value and three derivatives now."""
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
            # opened because its force vanished: then its acceleration is zero, too
            if zeros == 2 and self.fired == ("normal", i) and self._keeps(states, i):
                zeros = 3
            gap = (self.q[j] - I.of(self.toy.touch[i])) * side
            bend = (d0 * I.of(m.b[j]) + I.of(m.a[j])) * side
            jet = [gap, self.u[j] * side, bend, d1 * (I.of(m.b[j]) * side)]
            if self.let_go(i, states):
                jet[1] = jet[2] = I.of(0)
        elif kind == "slip":
            side = I.of(1) if states[i] == UP else -I.of(1)
            w = self.toy.tangent[i]
            along, steady = I.of(dot(w, m.b)), I.of(dot(w, m.a))
            c = along * side
            bend = (d0 * along + steady) * side
            jet = [slip(self.toy, i, self.u) * side, bend, d1 * c, d2 * c]
            if i in self.still:
                # slip that begins at the edge of the cone has no acceleration at first
                edge = "cone+" if states[i] == DOWN else "cone-"
                zeros = 2 if self.fired == (edge, i) else 1
        else:
            p, r = force(self.toy, m, kind, i)
            jet = [d0 * r + p, d1 * r, d2 * r, d1 * (r * kappa)]
            zeros = int(self.fired == guard and states == self.before)
        jet[:zeros] = [I.of(0)] * zeros
        return GuardValue(self.box, guard, kappa, jet, zeros, guard in self.at_least_zero)

    def _keeps(self, states: States, i: int) -> bool:
        """Whether all contacts but i keep their states."""
        return all(states[k] == self.before[k] for k in range(3) if k != i)

    def let_go(self, i: int, states: States) -> bool:
        """Whether the sleeve's other contact has just opened because its normal force vanished."""
        k = 3 - i
        fell = i > 0 and self.fired == ("normal", k) and states[k] == OPEN
        return fell and self._keeps(states, k)

    def restitution(self, i: int) -> I:
        """The range of a restitution coefficient."""
        eps = self.eps[i]
        return eps if isinstance(eps, I) else eps.value

    def close(self, i: int) -> None:
        """Set the gap of a contact and its rate to zero."""
        self.q[ANGLE[i]] = constant(self.box, I.of(self.toy.touch[i]))
        self.u[ANGLE[i]] = self.zero

    def hold(self, i: int) -> None:
        """Set the slip of a contact to zero by solving it for the sleeve's velocity."""
        w = self.toy.tangent[i]
        self.u[0] = -total(w[1:], self.u[1:])


def force(toy: ExactToy, m: Coasting, kind: str, i: int) -> tuple[I, I]:
    """Coefficients (p, r) of a guard on contact forces, p + r d."""
    n0, n1, t0, t1 = m.forces[i]
    if kind == "normal":
        return I.of(n0), I.of(n1)
    side = 1 if kind == "cone+" else -1
    return I.of(toy.mu[i] * n0 - side * t0), I.of(toy.mu[i] * n1 - side * t1)


def flown(m: Coasting, q: Sequence[Any], u: Sequence[Any], t: Any) -> tuple[Any, Any]:
    """Coordinates and velocities after a time in a mode, functions over the box or intervals."""
    s: list[Any] = waves(I.of(m.kappa), t)
    d0, d1, alpha = q[2] - q[1], u[2] - u[1], I.of(m.alpha)
    once = d0 * s[1] + d1 * s[2] + s[3] * alpha
    twice = d0 * s[2] + d1 * s[3] + s[4] * alpha
    square = t * t * I.of(Fraction(1, 2))
    places, speeds = [], []
    for j in range(3):
        a, b = I.of(m.a[j]), I.of(m.b[j])
        places.append(q[j] + u[j] * t + square * a + twice * b)
        speeds.append(u[j] + t * a + once * b)
    return places, speeds
