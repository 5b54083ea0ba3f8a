"""Itineraries of germs, and the growth of laps from kneading determinants [MilnorThurston1988].

An itinerary is followed up to the step from which all of it is known: the orbit has returned,
follows a word that attracts it, or moves outward on the outer pieces.

Each piece is a symbol, and each germ has a kneading series: the sum of the symbols that it visits,
the n-th times t^n and the sign of the slope of the n-th iterate. As x moves along the line, its
series jumps only where the n-th image of x is a break, by t^n times the difference of the series of
the two sides of that break. These differences therefore count the preimages of breaks, and the
growth of laps is one over the least root in (0, 1) of their determinant.

The difference is a polynomial if both orbits *match* (:mod:`pwmap.longrun.entropy.matching`).
"""

from __future__ import annotations

from collections.abc import Sequence

from sympy import QQ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, ring

from pwmap.algebra.exact import Affine, dense, sign
from pwmap.algebra.numbers import Exact
from pwmap.algebra.roots import Real, real_roots
from pwmap.longrun.fates import Fate, GermOrbit
from pwmap.longrun.line import IDENTITY, Germ, MapLine
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

WORK = 10  # operations of a step for each earlier step, as an attracting word may begin at any
STEPS = 64  # of an itinerary, at most


def itinerary_of(line: MapLine, germ: Germ, steps: int, meter: Meter) -> GermOrbit:
    """The orbit of a germ up to the step from which its itinerary is known; else OPEN."""
    seen, pieces, places = dict[Germ, int](), list[int](), list[Exact]()
    for step in range(steps):
        if germ in seen:
            return GermOrbit(line, tuple(seen), Fate.FINITE, seen[germ])
        meter.spend(WORK * (step + 1) + 3 * work_of(germ.x))
        seen[germ] = step
        pieces.append(line.number(germ))
        places.append(germ.x)
        if not line.branches[pieces[-1]].slope:
            return GermOrbit(line, tuple(seen), Fate.FLAT, step)
        germ = line.image(germ)
        start = _drawn_from(line, pieces)
        if start is not None:
            return GermOrbit(line, tuple(seen), Fate.DRAWN, start)
        start = _outward_from(line, pieces, [*places[-2:], germ.x])
        if start is not None:
            return GermOrbit(line, tuple(seen), Fate.LOST, start)
    return GermOrbit(line, tuple(seen), Fate.OPEN)


def _drawn_from(line: MapLine, pieces: Sequence[int]) -> int | None:
    """The step from which a word runs to the end that attracts all that follow it; or None."""
    whole = IDENTITY
    for start in range(len(pieces) - 1, -1, -1):
        whole = whole.after(Affine(*line.branches[pieces[start]][:2]))
        slope, word = whole.slope, pieces[start:]
        # a positive slope: the orbit approaches the fixed point from one side; if that follows the
        # word, too, so do all points between them, for ever
        if 0 < slope < 1 and line.follows(whole.fixed_point, word):
            return start
        # a negative slope: the first point and its image after one round lie on opposite sides of
        # the fixed point, and the interval between them is mapped into itself
        before = start - len(word)
        if -1 < slope < 0 and before >= 0 and pieces[before:start] == word:
            return start
    return None


def _outward_from(line: MapLine, pieces: Sequence[int], places: Sequence[Exact]) -> int | None:
    """The step from which an orbit moves outward for ever; None if it does not."""
    first, last = 0, len(line.branches) - 1
    for word in ((first,), (last,), (first, last), (last, first)):
        if tuple(pieces[-len(word) :]) != word:
            continue
        falls = [line.branches[k].slope < 0 for k in word]
        # on one increasing outer piece, or through two decreasing ones, the slope of the word is
        # positive, so that each round moves the orbit the same way
        way = sign(places[-1] - places[-1 - len(word)])
        if all(falls) == any(falls) == (len(word) == 2) and way == (1 if word[0] == last else -1):
            return len(pieces) - len(word)
    return None


LARGEST = 400  # degree of a determinant whose roots are computed, at most
RING, T = ring("t", QQ)


def growth_by_kneading(line: MapLine, itineraries: Sequence[GermOrbit]) -> Real | None:
    """The growth of laps, at least 1; None if the degree of the determinant is too high."""
    rows = _matrix(line, itineraries)
    return growth_from(_determinant(rows)) if rows else QQ.one


def _matrix(
    line: MapLine, itineraries: Sequence[GermOrbit], left_out: int = 0
) -> list[list[PolyElement]]:
    """The kneading matrix but for a column, rows times polynomials without roots in (0, 1)."""
    signs = [sign(branch.slope) for branch in line.branches]
    rows = list[list[PolyElement]]()
    for left, right in zip(itineraries[::2], itineraries[1::2], strict=True):
        (one, below), (other, above) = (_series(signs, each) for each in (left, right))
        row = [above[k] * one - below[k] * other for k in range(len(signs))]
        rows.append(row[:left_out] + row[left_out + 1 :])
    return rows


def _determinant(rows: Sequence[Sequence[PolyElement]]) -> PolyElement:
    """The determinant of a matrix of polynomials, up to the sign."""
    matrix = DomainMatrix([list(row) for row in rows], (len(rows), len(rows)), RING.to_domain())
    return matrix.charpoly()[-1]


def cofactors(line: MapLine, itineraries: Sequence[GermOrbit], number: int) -> list[PolyElement]:
    """The cofactors of the row of one break: their product with its series is the determinant."""
    rows = _matrix(line, itineraries, number)
    units = [[RING(k == j) for k in range(len(rows))] for j in range(len(rows))]
    found = [_determinant([*rows[:number], unit, *rows[number + 1 :]]) for unit in units]
    # the omitted column, that of the piece on the left of the break, has none
    return [*found[:number], RING.zero, *found[number:]]


def growth_from(found: PolyElement) -> Real | None:
    """One over the determinant's least root in (0, 1), or 1; None if its degree is too high."""
    if found.degree() > LARGEST:
        return None
    roots = real_roots(dense(found)[::-1])  # of the reversed polynomial, which are the reciprocals
    return max([QQ.one, *roots[-1:]])


def _series(signs: Sequence[int], itinerary: GermOrbit) -> tuple[PolyElement, list[PolyElement]]:
    """The kneading series: a denominator without roots in (0, 1), and a numerator per symbol."""
    found, later = ([RING.zero for _ in signs] for _ in range(2))
    factor, start = 1, 1
    for n, k in enumerate(itinerary.numbers):
        if n == itinerary.start:
            start = factor
        part = found if n < itinerary.start else later
        part[k] += factor * T**n
        factor *= signs[k]
    word = itinerary.word
    bottom = 1 - factor * start * T ** len(word) if word else RING.one
    return bottom, [a * bottom + b for a, b in zip(found, later, strict=True)]
