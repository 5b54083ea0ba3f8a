"""Where signs are taken: at a number, or on an open interval of the parameter."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from pwmap.checking.polynomials import Poly, changes, primitive, query, sign_near, sturm, text
from pwmap.checking.refusing import Work, refuse


class Number(NamedTuple):
    """A rational number, or the only root of a polynomial in an open interval."""

    poly: Poly
    low: Fraction
    high: Fraction

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial at the number."""
        if self.low == self.high or len(f) < 2:
            return sign_near(f, self.low)
        return query(self.poly, f, self.low, self.high)

    def __str__(self) -> str:
        if self.low == self.high:
            return str(self.low)
        return f"the root of {text(self.poly, 't')} between {self.low} and {self.high}"


def effort(*polynomials: Poly) -> int:
    """About how many steps Sturm's sequence takes of the product of some polynomials."""
    degree = sum(map(len, polynomials))
    bits = max(c.bit_length() for f in polynomials for c in f)
    return degree**3 * (1 + degree * bits // 500)


class Place:
    """Values of the parameter for which every polynomial that is asked has one sign."""

    def __init__(self, low: Number, high: Number, work: Work) -> None:
        self.low, self.high = low, high
        self.is_edge = low == high
        self.sample = (low.high + high.low) / 2
        self.work = work
        self._known: dict[Poly, int] = {}

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial: at the edge, or all over the open interval."""
        if f not in self._known:
            self._known[f] = self._sign(primitive(f))
        return self._known[f]

    def _sign(self, f: Poly) -> int:
        if len(f) < 2:
            return sign_near(f, self.sample)
        self.work.spend(effort(f, self.low.poly, self.high.poly))
        if self.is_edge:
            return self.low.sign(f)
        if self._roots(f):
            refuse(f"{text(f, 'p')} has a root between the edges {self.low} and {self.high}")
        return sign_near(f, self.sample)

    def _roots(self, f: Poly) -> int:
        """How many roots a polynomial has in the open interval; 0 is sure."""
        sequence, (low, high) = sturm(f), (self.low, self.high)
        outer = [changes(sign_near(h, x) for h in sequence) for x in (low.low, high.high)]
        if outer[0] == outer[1]:
            return 0
        ends = [changes(end.sign(h) for h in sequence) for end in (low, high)]
        return ends[0] - ends[1] - (high.sign(f) == 0)
