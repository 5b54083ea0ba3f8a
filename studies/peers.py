"""What a peer is: any other way to follow the toy from the section to its next return."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from woodpecker import Toy


class PeerReturn(NamedTuple):
    """One return to the section, by any method."""

    phi_s: float  # image [rad]
    period: float  # s
    drop: float  # m, positive down
    word: str  # sequence of events, as far as the method sees them
    evaluations: int  # of the right-hand side, or steps


class LostError(RuntimeError):
    """A method that could not follow the toy to its next return; the message says why."""


Peer = Callable[[Toy, float], PeerReturn]  # toy, phi_s at the start [rad]
