"""The prover as a peer: a return, and the cycle, in ball arithmetic.

Its result is not a number with an unknown error, but an interval that is proved to hold the exact
one. Half its width takes the place of the distance from a reference.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from flint import arb

from studies.peers.peer import LostError
from woodpecker import Toy, prove, shoot
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import precision
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.taylor import Frame
from woodpecker.proofs import NotProved


class Enclosed(NamedTuple):
    """One return, with what is proved of its image."""

    phi_s: float  # middle of the enclosure [rad]
    radius: float  # half its width [rad]
    word: str


def first_return_enclosed(toy: Toy, phi_s: float, bits: int) -> Enclosed:
    """One return in balls whose middles have so many bits.

    Raises
    ------
    LostError
        If a decision on the way is open.
    """
    start = Fraction(phi_s)
    with precision(bits):
        here = arb(start.numerator) / start.denominator
        try:
            (way,) = follow(BallToy(toy), Frame(arb(0), arb(0)), [here])
        except NotProved as reason:
            raise LostError(f"undecided: {reason}") from reason
        image = way.image.box
        return Enclosed(float(image.mid()), float(image.rad()), way.word)


def fixed_point_proved(toy: Toy, guess: float) -> tuple[float, float]:
    """Half widths of the boxes proved to hold a cycle [rad] and its multiplier."""
    content = prove(shoot(toy, guess)).content
    low, high = map(Fraction, content["multiplier"])
    return float(Fraction(content["inner"]["points"][0]["radius"])), float((high - low) / 2)
