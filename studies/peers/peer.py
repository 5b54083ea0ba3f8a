"""Definition of a peer: any other way to follow the toy from the section to its next return.

Siconos and Moreau's scheme know only Coulomb's law contact by contact, and refuse a toy whose
friction is bounded by a sum (:func:`contact_by_contact`). The ODE solver uses the project's contact
problems, so it can follow both laws; where all are compared, it follows Coulomb's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from woodpecker import ExpansionFriction, Toy


class PeerReturn(NamedTuple):
    """One return to the section, by any method."""

    phi_s: float  # image [rad]
    period: float  # s
    drop: float  # m, positive down
    word: str  # sequence of events, as far as the method sees them
    evaluations: int  # of the right-hand side, or steps


class LostError(RuntimeError):
    """A method that could not follow the toy to its next return; the message says why."""


def contact_by_contact(toy: Toy) -> Toy:
    """The toy itself; ValueError if its friction in the expansion is bounded by a sum."""
    if toy.expansion_friction is not ExpansionFriction.SEPARATE:
        raise ValueError(
            "this program bounds friction contact by contact: expected a toy with "
            f"expansion_friction='separate', got {str(toy.expansion_friction)!r}"
        )
    return toy


Peer = Callable[[Toy, float], PeerReturn]  # toy, phi_s at the start [rad]
