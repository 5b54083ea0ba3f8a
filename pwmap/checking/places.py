"""Where signs are taken: at a number, or on an open interval of the parameter."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from pwmap.checking.polynomials import (
    Poly,
    changes,
    length,
    primitive,
    query,
    sign_near,
    sturm,
    text,
)
from pwmap.checking.refusing import STEP, Effort, brief, refuse


class Number(NamedTuple):
    """A rational number, or the only root of a polynomial in an open interval."""

    poly: Poly
    low: Fraction
    high: Fraction

    @property
    def is_root(self) -> bool:
        """Whether it lies strictly inside of its interval."""
        return self.low < self.high

    def sign(self, work: Effort, f: Poly) -> int:
        """The sign of a polynomial at the number."""
        if not self.is_root or len(f) < 2:
            return sign_near(work, f, self.low)
        return query(work, self.poly, f, self.low, self.high)

    def __str__(self) -> str:
        if not self.is_root:
            return str(self.low)
        return f"the root of {text(self.poly, 't')} between {self.low} and {self.high}"

    @property
    def brief(self) -> str:
        """The same with long numbers cut, for refusals."""
        low, high = brief(str(self.low)), brief(str(self.high))
        if not self.is_root:
            return low
        return f"the root of {brief(text(self.poly, 't'))} between {low} and {high}"


def between(low: Number, high: Number) -> Fraction:
    """A rational number strictly between two numbers; refused if none is sure to be there."""
    middle = (low.high + high.low) / 2
    after = low.high < middle or (low.is_root and low.high == middle)  # a root lies below its high
    before = middle < high.low or (high.is_root and high.low == middle)
    if not (after and before):
        both = f"{low.brief} and {high.brief}"
        refuse(f"edges must ascend, with intervals that part them, got {both}")
    return middle


class Place:
    """Values of the parameter for which every polynomial that is asked has one sign.

    One number, given twice, or all numbers between two.
    """

    def __init__(self, low: Number, high: Number, work: Effort) -> None:
        self.low, self.high = low, high
        self.is_edge = low is high
        self.sample = low.low if self.is_edge else between(low, high)
        self.work = work
        self._known: dict[Poly, int] = {}

    def sign(self, f: Poly) -> int:
        """The sign of a polynomial: at the edge, or all over the open interval."""
        self.work.spend(STEP + len(f) * (60 + length(f) // 16))  # to look it up
        if f not in self._known:
            found = self._sign(primitive(self.work, f))
            self.work.keep(f)
            self._known[f] = found
        return self._known[f]

    def _sign(self, f: Poly) -> int:
        if len(f) < 2:
            return sign_near(self.work, f, self.sample)
        if self.is_edge:
            return self.low.sign(self.work, f)
        if self._roots(f):
            where = f"between the edges {self.low.brief} and {self.high.brief}"
            refuse(f"{brief(text(f, 'p'))} has a root {where}")
        return sign_near(self.work, f, self.sample)

    def _roots(self, f: Poly) -> int:
        """How many roots a polynomial has in the open interval; 0 is sure."""
        work, (low, high) = self.work, (self.low, self.high)
        sequence = sturm(work, f)
        outer = [changes(sign_near(work, h, x) for h in sequence) for x in (low.low, high.high)]
        if outer[0] == outer[1]:
            return 0
        ends = [changes(end.sign(work, h) for h in sequence) for end in (low, high)]
        return ends[0] - ends[1] - (high.sign(work, f) == 0)
