"""The motion of the toy over a box: its state where a phase begins, and the decisions so far."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from woodpecker.enclosures.balls import ZERO, sum_of
from woodpecker.enclosures.forms import Form, sign
from woodpecker.enclosures.model import BallToy, Mode, State
from woodpecker.enclosures.not_proved import NotProved
from woodpecker.enclosures.oscillator import ZeroCrossing
from woodpecker.enclosures.stumpff import stumpff
from woodpecker.mechanics.modes import ANGLE, OPEN, STICK
from woodpecker.simulation.words import word

NO_GUARD = -1
JAMMED: State = (OPEN, STICK, OPEN)  # at the start


class OpenDecision(NamedTuple):
    """A decision that is open over a box, as one way takes it."""

    comparator: Form
    side: int  # on which this way is taken: 1 where the comparator is positive, -1 where negative
    jumps: bool = False  # whether the map does there, as two gaps close at once


@dataclass
class Way:
    """The toy over a box, along one word: where a phase begins, first and last on the section."""

    q: list[Any]  # coordinates [m, rad], forms or exact balls
    u: list[Any]  # velocities
    time: Any  # since the start [s]
    states: State = JAMMED  # of the contacts
    # of each gap: how many of its value and derivatives are exactly zero
    orders: list[int] = field(default_factory=lambda: [0, 2, 0])
    held: frozenset[int] = frozenset({1})  # closed contacts whose slip is exactly zero
    fired: int = NO_GUARD  # the guard that ended the phase before; -1: an impact, or none
    before: State = JAMMED  # contact states of the phase before
    # guards that a fork makes at least zero, though their ranges are not: the gap of a contact that
    # has just opened at rest, or the normal force of one that stays
    assumed: frozenset[int] = frozenset()
    lands: int = NO_GUARD  # the contact that strikes after a flight from rest, with known approach
    since: Any = ZERO  # when a landing at a plateau, where the phase begins, is over at the latest
    codes: list[int] = field(default_factory=list)  # of events, for the word
    log: list[ZeroCrossing] = field(default_factory=list)  # what ended each phase
    forks: list[OpenDecision] = field(default_factory=list)

    @property
    def word(self) -> str:
        """The sequence of events."""
        return word(self.codes)

    @property
    def image(self) -> Form:
        """phi_S, at the return that of the map [rad]."""
        phi_s: Form = self.q[2]
        return phi_s

    @property
    def drop(self) -> Form:
        """Distance fallen [m]."""
        fallen: Form = -self.q[0]
        return fallen

    def copy(self) -> Way:
        """An independent copy."""
        found = copy(self)
        for name in ("q", "u", "orders", "codes", "log", "forks"):
            setattr(found, name, list(getattr(self, name)))
        return found


def flown(mode: Mode, q: Sequence[Any], u: Sequence[Any], t: Any) -> tuple[list[Any], list[Any]]:
    """Coordinates and velocities after a time in a mode: forms, or balls."""
    d0, d1 = q[2] - q[1], u[2] - u[1]
    _, s1, s2, s3, s4 = stumpff(mode.kappa, t)
    once = d0 * s1 + d1 * s2 + mode.alpha * s3
    twice = d0 * s2 + d1 * s3 + mode.alpha * s4
    half = t * t / 2
    return (
        [q[j] + u[j] * t + mode.a[j] * half + mode.b[j] * twice for j in range(3)],
        [u[j] + mode.a[j] * t + mode.b[j] * once for j in range(3)],
    )


def touch(model: BallToy, motion: Way, i: int) -> None:
    """Make the gap of a contact exactly zero."""
    motion.q[ANGLE[i]] = model.limits[i]


def hold(model: BallToy, motion: Way, i: int) -> None:
    """Make the slip of a contact exactly zero through the velocity of the sleeve."""
    _, w_m, w_s = model.tangents[i]
    motion.u[0] = -(w_m * motion.u[1] + w_s * motion.u[2])


def slip(model: BallToy, i: int, u: Sequence[Any]) -> Any:
    """Tangential velocity of a contact."""
    return sum_of(w * v for w, v in zip(model.tangents[i], u, strict=True))


def direction_of_slip(model: BallToy, i: int, u: Sequence[Any]) -> int:
    """Sign of that velocity; NotProved where it may be zero."""
    found = sign(slip(model, i, u))
    if not found:
        raise NotProved(f"contact {i + 1} may slip or not")
    return found
