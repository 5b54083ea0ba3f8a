"""Brute force for piecewise-linear maps of the line, in fractions.

Nothing of pwmap is used. A map is a tuple of pieces from left to right. Values and one-sided limits
come from following single points, with the side from which they are approached; pieces of iterates
and what lies on the diagonal from following intervals (``independent``).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import independent

ONE = Fraction(1)
IDENTITY = (ONE, 0 * ONE)  # slope and intercept
LEFT, EXACT, RIGHT = -1, 0, 1  # where the followed points lie, seen from the point itself

SPLIT = "|"  # between the words on two sides; no map here has so many pieces
Word = tuple[int, ...]


class Part(NamedTuple):
    """``slope x + intercept`` between two ends; None is infinite, equal closed ends are a point."""

    lo: Fraction | None
    lo_closed: bool
    hi: Fraction | None
    hi_closed: bool
    slope: Fraction
    intercept: Fraction

    def holds(self, x: Fraction, side: int = EXACT) -> bool:
        """Whether x, or all points just beside it, belong to the piece."""
        above = self.lo is None or x > self.lo or (
            x == self.lo and (self.lo_closed if side == EXACT else side == RIGHT)
        )  # fmt: skip
        below = self.hi is None or x < self.hi or (
            x == self.hi and (self.hi_closed if side == EXACT else side == LEFT)
        )  # fmt: skip
        return above and below


Map = tuple[Part, ...]


class Side(NamedTuple):
    """What nested one-sided following of a point found."""

    value: Fraction
    word: Word


class FixedPoint(NamedTuple):
    """A fixed point that lies in no interval of fixed points."""

    x: Fraction
    word: Word
    multiplier: Fraction | None  # None where the point is a piece of its own
    period: int
    stable: bool
    at_border: bool


class Crossing(NamedTuple):
    """A point whose one-sided limits lie strictly on opposite sides of the diagonal."""

    x: Fraction
    left: Fraction
    right: Fraction
    left_word: Word
    right_word: Word


class Piece(NamedTuple):
    """One affine piece of an iterate."""

    part: Part
    word: Word


def map_of(
    breaks: Sequence[Fraction], owners: Sequence[str], formulas: Sequence[tuple[Fraction, Fraction]]
) -> Map:
    """A map from its breaks, who owns each (``"left"``, ``"right"``, ``"point"``), and formulas.

    There is one (slope, intercept) for each piece, points included, from left to right.
    """
    parts: list[Part] = []
    rest = iter(formulas)
    lo, lo_closed = None, False
    for x, owner in zip(breaks, owners, strict=True):
        parts.append(Part(lo, lo_closed, x, owner == "left", *next(rest)))
        if owner == "point":
            parts.append(Part(x, True, x, True, *next(rest)))
        lo, lo_closed = x, owner == "right"
    parts.append(Part(lo, lo_closed, None, False, *next(rest)))
    return tuple(parts)


# --- Following points -----------------------------------------------------------------------------


def letter(f: Map, x: Fraction, side: int = EXACT) -> int:
    """Index of the one piece that holds x, or the points just beside it."""
    found = [i for i, part in enumerate(f) if part.holds(x, side)]
    assert len(found) == 1, (x, side, found)
    return found[0]


def followed(f: Map, x: Fraction, j: int, side: int = EXACT) -> Side:
    """Nested evaluation at x, or of the points beside it: the one-sided limit."""
    word = []
    for _ in range(j):
        i = letter(f, x, side)
        word.append(i)
        x = f[i].slope * x + f[i].intercept
        if f[i].slope < 0:
            side = -side
        elif f[i].slope == 0:
            side = EXACT
    return Side(x, tuple(word))


def value(f: Map, x: Fraction, j: int) -> Fraction:
    """P_j(x)."""
    return followed(f, x, j).value


def period(f: Map, x: Fraction, longest: int) -> int:
    """Minimal period of a point, by following its orbit."""
    return next(d for d in range(1, longest + 1) if value(f, x, d) == x)


def composition(outer: Map, first: Map) -> Map:
    """The map x -> outer(first(x)), one piece for each pair of pieces; points are flat."""

    def along(x: Fraction, side: int = EXACT) -> tuple[Word, Fraction]:
        i = letter(first, x, side)
        slope = first[i].slope
        y = slope * x + first[i].intercept
        k = letter(outer, y, side if slope > 0 else -side if slope < 0 else EXACT)
        return (i, k), outer[k].slope * y + outer[k].intercept

    own = {part.lo for part in first if part.lo is not None}
    own |= {
        (part.lo - q.intercept) / q.slope
        for part in outer
        for q in first
        if part.lo is not None and q.slope != 0
    }
    cuts = [x for x in sorted(own) if len({along(x, s)[0] for s in (LEFT, EXACT, RIGHT)}) > 1]
    owners, formulas = [], []
    for lo, hi in gaps(cuts):
        points = inner(lo, hi)
        low, high = (along(x)[1] for x in points)
        slope = (high - low) / (points[1] - points[0])
        formulas.append((slope, low - slope * points[0]))
        if hi is not None:
            at, left, right = (along(hi, s) for s in (EXACT, LEFT, RIGHT))
            owners.append({left[0]: "left", right[0]: "right"}.get(at[0], "point"))
            if owners[-1] == "point":
                formulas.append((0 * ONE, at[1]))
    return map_of(cuts, owners, formulas)


# --- Pieces of an iterate -------------------------------------------------------------------------


@lru_cache(maxsize=32)
def parts(f: Map, j: int) -> independent.Parts:
    """The pieces of P_j, found by following intervals; a word has a character for each piece."""
    base = tuple(independent.Part(*part, chr(i)) for i, part in enumerate(f))
    return independent.iterated(base, j)[-1]


def word_of(text: str) -> Word:
    """A word as indices of pieces."""
    return tuple(map(ord, text))


def breaks(f: Map, j: int) -> list[Fraction]:
    """All points around which the words of P_j are not the same, from left to right."""
    return list(dict.fromkeys(part.lo for part in parts(f, j)[1:]))


def gaps(points: Sequence[Fraction]) -> list[tuple[Fraction | None, Fraction | None]]:
    """The open intervals between sorted points."""
    return list(pairwise([None, *points, None]))


def inner(lo: Fraction | None, hi: Fraction | None) -> tuple[Fraction, Fraction]:
    """Two points inside an open interval."""
    if lo is None:
        if hi is None:
            return 0 * ONE, ONE
        return hi - 2 * ONE, hi - ONE
    if hi is None:
        return lo + ONE, lo + 2 * ONE
    return lo + (hi - lo) / 3, lo + (hi - lo) * 2 / 3


@lru_cache(maxsize=32)
def pieces(f: Map, j: int) -> list[Piece]:
    """The pieces of P_j from left to right; of a point only the value counts."""
    found = []
    for p in parts(f, j):
        line = (0 * ONE, p(p.lo)) if p.is_point else (p.slope, p.intercept)
        found.append(Piece(Part(p.lo, p.lo_in, p.hi, p.hi_in, *line), word_of(p.word)))
    return found


# --- The diagonal ---------------------------------------------------------------------------------


def fixed_points(f: Map, j: int) -> list[FixedPoint]:
    """All fixed points of P_j but for those in bands, from left to right."""
    return [
        FixedPoint(p.x, word_of(p.word), p.multiplier, p.period, p.stable, p.at_border)
        for p in independent.fixed_points(parts(f, 1), parts(f, j), j)
    ]


def crossings(f: Map, j: int) -> list[Crossing]:
    """Breaks of P_j whose one-sided limits lie strictly on opposite sides of the diagonal."""
    found = independent.crossings(parts(f, j))
    words = ((c, *map(word_of, c.words.split(SPLIT))) for c in found)
    return [Crossing(c.x, c.left, c.right, left, right) for c, left, right in words]
