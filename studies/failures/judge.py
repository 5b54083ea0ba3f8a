"""How an outcome is judged: the verdict is a function of the measurement and of the reference.

``exact`` means that the error is below the kernel's bound: rounding, amplified by the map itself.
Otherwise the verdict counts the correct digits, if there are any.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from enum import Enum
from typing import NamedTuple

from studies.peers.cases import plain

ROUNDING = 2.0**-53  # relative, of one operation
PROMISE, PROMISE_SLOPE = 1e-12, 1e-13  # rad; asserted in simulation/test_reference.py
USELESS = 1e-2  # rad; an image further away than this is another motion


class Kind(Enum):
    """Verdicts, from the best to the worst; the value is how a table calls them."""

    EXACT = "exact"
    DIGITS = "digits"
    BOUNDED = "bound stated"
    UNDECIDED = "gave up"
    WORD = "wrong word"
    SILENT = "does not say so"
    PART = "some guesses"
    LOST = "lost"
    SIDE = "wrong side"
    VALUE = "wrong"
    NONE = "not applicable"

    @property
    def right(self) -> bool:
        """Whether word and side are right."""
        return self in (Kind.EXACT, Kind.DIGITS, Kind.BOUNDED)


class Truth(NamedTuple):
    """What a method should find.

    ``image`` is None if there is no return. Then ``leaves`` says that only leaving is asked for;
    otherwise the toy never returns, and a method should know it. ``other`` is the limit of the map
    on the other side of a jump. ``ends`` are the images of both ends of a segment of impulses that
    the contact laws leave open.
    """

    image: Decimal | None
    word: str = ""
    slope: float = 0.0
    other: float = math.nan
    leaves: bool = False
    ends: tuple[float, float] | None = None


class Outcome(NamedTuple):
    """What a method said; ``image`` is None if there was no return, the message then says why."""

    image: float | None
    word: str = ""
    message: str = ""
    decided: bool = False  # the method proved that there is no return
    open_impulse: bool = False  # the method said that an impulse is not unique


class Verdict(NamedTuple):
    """A judged outcome."""

    kind: Kind
    text: str
    error: float | None = None  # rad
    allowed: float | None = None  # rad, what the kernel promises here
    roundings: float | None = None  # error over |slope| * rounding
    word_right: bool | None = None
    side_right: bool | None = None


def verdict(outcome: Outcome, truth: Truth) -> Verdict:
    """Judge one outcome."""
    if truth.ends is not None:
        return _of_open_impulse(outcome, truth.ends)
    if truth.image is None:
        return _without_return(outcome, truth.leaves)
    if outcome.image is None:
        text = f"lost: {reason(outcome.message)}"
        return Verdict(Kind.LOST, text, word_right=False, side_right=False)
    error = float(abs(Decimal(outcome.image) - truth.image))
    word_right = plain(outcome.word) == plain(truth.word)
    side_right = not abs(outcome.image - truth.other) < error
    scale = max(1.0, abs(truth.slope))
    allowed = PROMISE + PROMISE_SLOPE * abs(truth.slope)
    measured = (error, allowed, error / (ROUNDING * scale), word_right, side_right)
    if not side_right:
        return Verdict(Kind.SIDE, Kind.SIDE.value, *measured)
    if not error <= USELESS:
        return Verdict(Kind.VALUE, f"wrong by {error:.1g}", *measured)
    if not word_right:
        return Verdict(Kind.WORD, f"wrong word, {digits(error)} digits", *measured)
    if error <= allowed:
        return Verdict(Kind.EXACT, Kind.EXACT.value, *measured)
    return Verdict(Kind.DIGITS, f"{digits(error)} digits", *measured)


def _without_return(outcome: Outcome, leaves: bool) -> Verdict:
    if outcome.image is not None:
        return Verdict(Kind.VALUE, "false return", word_right=False)
    if leaves:
        return Verdict(Kind.EXACT, "leaves")
    if outcome.decided:
        return Verdict(Kind.EXACT, "decided")
    return Verdict(Kind.UNDECIDED, f"gave up: {reason(outcome.message)}")


def _of_open_impulse(outcome: Outcome, ends: tuple[float, float]) -> Verdict:
    low, high = sorted(ends)
    if outcome.image is None:
        return Verdict(Kind.LOST, f"lost: {reason(outcome.message)}")
    if not low <= outcome.image <= high:
        return Verdict(Kind.VALUE, "wrong, not said")
    if not outcome.open_impulse:
        return Verdict(Kind.SILENT, Kind.SILENT.value)
    return Verdict(Kind.BOUNDED, f"stated: within {power(high - low)}", high - low)


REASONS = {  # part of a message: what a table calls it
    "closer than": "events too close",
    "within": "no return in time",
    "does not return": "no return in time",
    "event limit": "event limit",
    "no single solution": "contact problem",
    "contact problem": "contact problem",
    "basis": "contact problem",
    "not finite": "no number",
}


def reason(message: str) -> str:
    """A message in two or three words."""
    return next((short for part, short in REASONS.items() if part in message), "see message")


def digits(error: float) -> int:
    """Number of decimals of an image [rad] that are right."""
    return max(0, math.floor(-math.log10(error))) if error > 0.0 else 16


def power(value: float) -> str:
    """A small number as people write it: 1e-8, not 1e-08."""
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def worst(verdicts: Sequence[Verdict]) -> Verdict:
    """The one that counts: the worst kind, and of these the largest error."""
    order = list(Kind)
    return max(verdicts, key=lambda v: (order.index(v.kind), v.error or 0.0))


def reach(distances: Sequence[float], right: Sequence[bool | None]) -> float | None:
    """The smallest distance down to which all is right; None if nothing is."""
    wrong = [d for d, good in zip(distances, right, strict=True) if not good]
    above = [d for d in distances if d > max(wrong, default=0.0)]
    return min(above, default=None)
