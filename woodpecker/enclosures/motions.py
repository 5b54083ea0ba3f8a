"""State of the toy over a box at the start of a phase, and the decisions that led there."""

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
JAMMED: State = (OPEN, STICK, OPEN)  # at the start of a return: the lower edge sticks


class OpenDecision(NamedTuple):
    """A decision that is open over a box, and its outcome on one way."""

    comparator: Form
    side: int  # sign of the comparator where this way is taken
    jumps: bool = False  # whether the map jumps where the sign changes: two gaps close at once


@dataclass
class Way:
    """Motion over a box along one word, at the start of a phase; first and last on the section."""

    q: list[Any]  # coordinates [m, rad], forms or exact balls
    u: list[Any]  # velocities
    time: Any  # since the start [s]
    states: State = JAMMED  # of the contacts, in the phase that begins
    # for each gap, how many of f, f', f'', .. are exactly zero
    orders: list[int] = field(default_factory=lambda: [0, 2, 0])
    held: frozenset[int] = frozenset({1})  # closed contacts whose slip is exactly zero
    fired: int = NO_GUARD  # the guard that ended the last phase; -1 after an impact, and at first
    before: State = JAMMED  # contact states of the last phase
    # guards that are at least zero on this side of an open decision, though their ranges are not:
    # the gap of a contact that leaves from rest, or the normal force of one that stays
    assumed: frozenset[int] = frozenset()
    lands: int = NO_GUARD  # the contact that strikes after a flight from rest: it does approach
    since: Any = ZERO  # time in this phase by which a landing at a plateau is over
    codes: list[int] = field(default_factory=list)  # codes of the events, which make the word
    log: list[ZeroCrossing] = field(default_factory=list)  # the events that ended the phases
    forks: list[OpenDecision] = field(default_factory=list)

    @property
    def word(self) -> str:
        """The word: the sequence of events as text."""
        return word(self.codes)

    @property
    def image(self) -> Form:
        """Angle phi_S [rad]: at the return it is the value of the map."""
        phi_s: Form = self.q[2]
        return phi_s

    @property
    def drop(self) -> Form:
        """Distance fallen [m]."""
        fallen: Form = -self.q[0]
        return fallen

    def copy(self) -> Way:
        """A copy that shares no lists, for the other side of a decision."""
        found = copy(self)
        for name in ("q", "u", "orders", "codes", "log", "forks"):
            setattr(found, name, list(getattr(self, name)))
        return found


def flown(mode: Mode, q: Sequence[Any], u: Sequence[Any], t: Any) -> tuple[list[Any], list[Any]]:
    """Coordinates and velocities after a time t in a mode, as forms or balls."""
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
    """Set the gap of a contact to exactly zero."""
    motion.q[ANGLE[i]] = model.limits[i]


def hold(model: BallToy, motion: Way, i: int) -> None:
    """Set the slip of a contact to exactly zero by solving it for the sleeve's velocity."""
    _, w_m, w_s = model.tangents[i]
    motion.u[0] = -(w_m * motion.u[1] + w_s * motion.u[2])


def slip(model: BallToy, i: int, u: Sequence[Any]) -> Any:
    """Tangential velocity of a contact."""
    return sum_of(w * v for w, v in zip(model.tangents[i], u, strict=True))


def direction_of_slip(model: BallToy, i: int, u: Sequence[Any]) -> int:
    """Sign of the tangential velocity of a contact; NotProved where it may be zero."""
    found = sign(slip(model, i, u))
    if not found:
        raise NotProved(f"contact {i + 1} may slip or not")
    return found
