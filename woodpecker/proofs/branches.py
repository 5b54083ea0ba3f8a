"""A branch proved over an interval of the parameter: pieces that join, from its low end to the high.

Each piece has exactly one cycle in its tubes for every parameter (:mod:`woodpecker.proofs.pieces`).
Where two pieces meet, what was found in one lies in the tubes of the other: so it is the same cycle
there, and the branch has no gap. A flip is a piece along which the multiplier is monotone, between
one where it is above -1 and one where it is below.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, arb_poly

from woodpecker.mechanics.toy import Toy
from woodpecker.proofs.forms import Undecided, sign
from woodpecker.proofs.pieces import (
    Interval,
    Piece,
    TooNarrow,
    Tube,
    curves_near,
    decimal,
    number,
    proved,
)

Progress = Callable[[float], object]


@dataclass(frozen=True)
class March:
    """How a branch is cut into pieces. No number here decides what is proved, only what it costs.

    Attributes
    ----------
    terms
        Coefficients along the branch; 8 are twice as fast as 4 or 12 at eps_n1 = 1/2.
    first, longest
        Of the interval, the length of the first piece that is tried, and of the longest one.
    shortest
        Of the interval, the piece at which it is given up.
    growth
        From one piece to the next, if it was proved at once.
    radius
        First radius of the tubes [rad]: near the rounding of what is computed.
    margin
        Of what was found in a tube, how much wider the tube is made.
    bits
        Precision.
    """

    terms: int = 8
    first: float = 0.01
    longest: float = 0.05
    shortest: float = 1e-9
    growth: float = 1.6
    radius: Fraction = Fraction(1, 10**14)
    margin: int = 2
    bits: int = 96


@dataclass(frozen=True)
class ProvedBranch:
    """A branch without a gap over an interval of the parameter.

    Attributes
    ----------
    toy
        Its own value of the parameter does not matter.
    parameter
        Name.
    pieces
        In ascending order of the parameter; each begins where the one before ends.
    flips
        Which of them hold a flip, exactly one each.
    """

    toy: Toy
    parameter: str
    pieces: tuple[Piece, ...]
    flips: tuple[int, ...]

    @property
    def span(self) -> Interval:
        """The interval of the parameter."""
        return Interval(self.pieces[0].p.low, self.pieces[-1].p.high)


def marched(
    toy: Toy, parameter: str, span: Interval, points: Sequence[float], march: March,
    progress: Progress,
) -> ProvedBranch:  # fmt: skip
    """Prove the branch through a cycle over an interval.

    Parameters
    ----------
    points
        The cycle at the low end of the span, as near as doubles are.
    progress
        Called with the part that is done.

    Raises
    ------
    Undecided
        Where it could not be followed; the sentence says at which value, and why.
    """
    walk = _Walk(toy, parameter, span, march, [[arb(x)] for x in points])
    while walk.at < span.high:
        walk.go_on()
        progress(float((walk.at - span.low) / (span.high - span.low)))
    flips = tuple(k for k, piece in enumerate(walk.pieces) if piece.turn is not None)
    return ProvedBranch(toy, parameter, tuple(walk.pieces), flips)


class _Walk:
    """The pieces so far, and how the next one is tried."""

    def __init__(
        self, toy: Toy, parameter: str, span: Interval, march: March, guesses: list[list[Any]]
    ) -> None:
        self._toy, self._parameter, self._span, self._march = toy, parameter, span, march
        self._guesses, self._centre = guesses, span.low
        self._step = (span.high - span.low) * Fraction(march.first)
        self._flip: Interval | None = None
        self._reach = Fraction(0)  # how far the curves of the last piece may be used
        self.pieces: list[Piece] = []
        self.at = span.low

    def go_on(self) -> None:
        """Prove one more piece."""
        length = self._span.high - self._span.low
        while True:
            wanted = self._next()
            try:
                piece = self._tried(wanted)
            except Undecided as reason:
                self._step = (wanted.high - wanted.low) / 2
                if self._step < length * Fraction(self._march.shortest):
                    raise Undecided(
                        f"the branch could be followed to {self._parameter} = "
                        f"{float(self.at):.12g} only: {reason}"
                    ) from None
                continue
            break
        self.pieces.append(piece)
        self.at, self._centre = wanted.high, wanted.centre
        self._reach = 2 * (wanted.high - wanted.low)
        self._guesses = [[number(c) for c in tube.curve] for tube in piece.tubes]
        longest = length * Fraction(self._march.longest)
        self._step = min(longest, (wanted.high - wanted.low) * Fraction(self._march.growth))
        if self._flip == wanted:
            self._flip = None

    def _next(self) -> Interval:
        """The interval to be tried: up to a flip that is known, or its own."""
        if self._flip is not None and self._flip.low == self.at:
            return self._flip
        end = self._flip.low if self._flip is not None else self._span.high
        high = min(end, _rounded(self.at + self._step))
        return Interval(self.at, end if end - high < self._step / 4 else high)

    def _tried(self, p: Interval) -> Piece:
        if p == self._flip:
            return self._turning(p)
        piece = self._enclosed(p)
        if not sign(piece.multiplier + 1):
            self._look_for_flip(p)
            raise Undecided("the multiplier may be -1")
        return piece

    def _enclosed(self, p: Interval, turns: bool = False) -> Piece:
        """A piece over an interval, in tubes that are widened as needed."""
        march = self._march
        curves = self._curves(p)
        radii = [max(march.radius, 2 * need) for need in self._needs(p, curves)]
        for _ in range(5):
            tubes = [Tube(curve, radius) for curve, radius in zip(curves, radii, strict=True)]
            try:
                return proved(self._toy, self._parameter, p, tubes, march.terms, turns)
            except TooNarrow as found:
                wider = [_above(abs(s).upper()) * march.margin for s in found.off]
                if any(r > Fraction(1, 1000) for r in wider):
                    raise
                radii = [max(a, b) for a, b in zip(radii, wider, strict=True)]
        raise Undecided("no tube holds what is found in it")

    def _curves(self, p: Interval, terms: int = 0) -> list[tuple[Fraction, ...]]:
        """Curves about the middle of an interval, from those of the last piece."""
        shift = arb_poly([number(p.centre - self._centre), 1])
        guesses = [arb_poly(list(guess))(shift).coeffs() for guess in self._guesses]
        if abs(p.centre - self._centre) > self._reach:  # too far for a polynomial
            guesses = [guess[:1] for guess in self._guesses]
        return curves_near(self._toy, self._parameter, p, guesses, terms or self._march.terms)

    def _needs(self, p: Interval, curves: Sequence[tuple[Fraction, ...]]) -> list[Fraction]:
        """How wide tubes must be to hold what was found where the last piece ends."""
        if not self.pieces:
            return [Fraction(0)] * len(curves)
        last, away = self.pieces[-1], number(p.low - p.centre)
        found = []
        for k, curve in enumerate(curves):
            here = arb_poly([number(c) for c in curve])(away)
            found.append(_above(abs(last.at(p.low, k) - here).upper()))
        return found

    def _multiplier(self, p: Fraction) -> Any:
        """Range of the multiplier at one value."""
        here = Interval(p, p)
        tubes = [Tube(curve, self._march.radius) for curve in self._curves(here, 1)]
        return proved(self._toy, self._parameter, here, tubes).multiplier

    def _look_for_flip(self, p: Interval) -> None:
        """Enclose a flip between the ends of an interval, if there is one, by bisection."""
        low, high = p
        sides = [sign(self._multiplier(end) + 1) for end in p]
        if None in sides or sides[0] == sides[1]:
            return
        while high - low > (p.high - p.low) / 2**20:
            middle = _rounded((low + high) / 2)
            if sign(self._multiplier(middle) + 1) == sides[0]:
                low = middle
            else:
                high = middle
        width = (p.high - p.low) / 4
        while width > 4 * (high - low):
            around = Interval(_rounded(low - width), _rounded(high + width))
            if around.low > p.low and around.high < p.high:
                try:
                    self._turning(around)
                except Undecided:
                    pass
                else:
                    self._flip = around
                    return
            width = width / 4

    def _turning(self, p: Interval) -> Piece:
        """A piece along which the multiplier is monotone."""
        piece = self._enclosed(p, turns=True)
        if not sign(piece.turn):
            raise Undecided("the multiplier may not be monotone")
        return piece


def _rounded(x: Fraction) -> Fraction:
    return Fraction(round(x * 10**15), 10**15)


def _above(x: Any) -> Fraction:
    """A short decimal above a positive number."""
    exact = decimal(x, 40) + Fraction(1, 10**40)
    digits = 0
    while exact * 10**digits < 100 and digits < 40:
        digits += 1
    return Fraction(int(exact * 10**digits) + 1, 10**digits)
