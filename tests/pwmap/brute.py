"""Brute force for piecewise-linear maps of the line, in fractions and by following points only.

Nothing of pwmap is used. A map is a tuple of pieces from left to right. All that is known of an
iterate comes from nested evaluation of single points: its slopes are differences between two of
them, its one-sided limits follow a point together with the side from which it is approached.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

ONE = Fraction(1)
IDENTITY = (ONE, 0 * ONE)  # slope and intercept
LEFT, EXACT, RIGHT = -1, 0, 1  # where the followed points lie, seen from the point itself

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
    """A fixed point that is no inner point of an interval of fixed points."""

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
def breaks(f: Map, j: int) -> list[Fraction]:
    """All points around which the words of P_j are not the same, from left to right."""
    own = {part.lo for part in f if part.lo is not None}
    found = set(own)
    for _ in range(j - 1):
        back = {
            (y - part.intercept) / part.slope
            for part in f
            if part.slope != 0
            for y in found
            if part.holds((y - part.intercept) / part.slope)
        }
        found = own | back
    return [
        x
        for x in sorted(found)
        if len({followed(f, x, j, side).word for side in (LEFT, EXACT, RIGHT)}) > 1
    ]


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


def affine(f: Map, j: int, lo: Fraction | None, hi: Fraction | None) -> tuple[Fraction, Fraction]:
    """Slope and intercept of P_j between two neighbouring breaks, from two points."""
    p, q = inner(lo, hi)
    (low, word), (high, other) = followed(f, p, j), followed(f, q, j)
    assert word == other
    slope = (high - low) / (q - p)
    return slope, low - slope * p


@lru_cache(maxsize=32)
def pieces(f: Map, j: int) -> list[Piece]:
    """The pieces of P_j from left to right."""
    found: list[Piece] = []
    lo_closed = False
    for lo, hi in gaps(breaks(f, j)):
        slope, intercept = affine(f, j, lo, hi)
        word = followed(f, inner(lo, hi)[0], j).word
        if hi is None:
            found.append(Piece(Part(lo, lo_closed, None, False, slope, intercept), word))
            break
        at, left, right = (followed(f, hi, j, side).word for side in (EXACT, LEFT, RIGHT))
        assert left == word
        found.append(Piece(Part(lo, lo_closed, hi, at == left, slope, intercept), word))
        lo_closed = at == right
        if at not in (left, right):
            flat = Part(hi, True, hi, True, 0 * ONE, value(f, hi, j))
            found.append(Piece(flat, at))
    return found


# --- The diagonal ---------------------------------------------------------------------------------


def bands(f: Map, j: int) -> list[tuple[Fraction | None, Fraction | None]]:
    """Open intervals between neighbouring breaks of which every point is fixed by P_j."""
    return [ends for ends in gaps(breaks(f, j)) if affine(f, j, *ends) == IDENTITY]


def fixed_points(f: Map, j: int) -> list[FixedPoint]:
    """All fixed points of P_j but for inner points of bands, from left to right."""
    cuts = breaks(f, j)
    lines = {lo: affine(f, j, lo, hi) for lo, hi in gaps(cuts)}
    found: list[tuple[Fraction, Fraction | None, bool]] = []
    for lo, hi in gaps(cuts):
        slope, intercept = lines[lo]
        if slope != 1:
            x = intercept / (1 - slope)
            if (lo is None or lo < x) and (hi is None or x < hi):
                assert value(f, x, j) == x
                found.append((x, slope, False))
        if hi is not None and value(f, hi, j) == hi:
            at, left, right = (followed(f, hi, j, side).word for side in (EXACT, LEFT, RIGHT))
            owner = lines[lo][0] if at == left else lines[hi][0] if at == right else None
            found.append((hi, owner, True))
    return [
        FixedPoint(
            x, followed(f, x, j).word, slope, period(f, x, j), is_stable(f, j, x, cuts), border
        )
        for x, slope, border in found
    ]


def is_stable(f: Map, j: int, x: Fraction, cuts: Sequence[Fraction]) -> bool:
    """Whether points beside a fixed point x of P_j converge to it, by following one on each side.

    They lie so near that three steps see the two affine pieces beside x only. The first step may
    change the side, after it each step keeps it or each changes it: compare the third with it.
    """
    room = min([abs(cut - x) for cut in cuts if cut != x], default=ONE)
    steepest = max([ONE, *(abs(part.slope) for part in f)])
    eps = min(ONE, room) / (2 * steepest ** (4 * j))
    for start in (-eps, eps):
        far, near = (value(f, x + step, j) for step in (start, start / 2))
        if 2 * near - far != x:  # the one-sided limit is elsewhere
            return False
        distances = [abs(value(f, x + start, n * j) - x) for n in (1, 3)]
        if not (distances[0] == 0 or distances[1] < distances[0]):
            return False
    return True


def crossings(f: Map, j: int) -> list[Crossing]:
    """Breaks of P_j whose one-sided limits lie strictly on opposite sides of the diagonal."""
    found = []
    for x in breaks(f, j):
        left, right = (followed(f, x, j, side) for side in (LEFT, RIGHT))
        if (left.value - x) * (right.value - x) < 0:
            found.append(Crossing(x, left.value, right.value, left.word, right.word))
    return found
