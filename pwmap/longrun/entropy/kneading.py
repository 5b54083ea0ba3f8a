"""The growth of laps from kneading sequences, of which only differences need to be known.

Give each piece a symbol e, and each germ the series of the symbols that it visits, the n-th with
the factor t^n and the sign of the slope up to there. Along the line the series of a point jumps
only where an image of it is a break, by t^n times the difference of the series of both sides of
that break. So these differences count the preimages of breaks, and the growth of laps is one over
the least root in (0, 1) of the determinant that they make [MilnorThurston1988].

A difference is a polynomial where both orbits *match* (:mod:`pwmap.longrun.entropy.matching`).
"""

from __future__ import annotations

from collections.abc import Sequence

from sympy import QQ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, ring

from pwmap.algebra.exact import sign
from pwmap.algebra.roots import Real, real_roots
from pwmap.longrun.entropy.itineraries import Itinerary
from pwmap.longrun.line import MapLine

LARGEST = 400  # degree of a determinant whose roots are looked for
RING, T = ring("t", QQ)


def growth_by_kneading(line: MapLine, itineraries: Sequence[Itinerary]) -> Real | None:
    """The growth of laps, at least 1; None if the kneading determinant is too large."""
    rows = _matrix(line, itineraries)
    # one over the least root of the kneading determinant
    return growth_from(_determinant(rows)) if rows else QQ.one


def _matrix(
    line: MapLine, itineraries: Sequence[Itinerary], left_out: int = 0
) -> list[list[PolyElement]]:
    """The differences of both sides of each break, times polynomials with no root in (0, 1)."""
    signs = [sign(branch.slope) for branch in line.branches]
    rows = list[list[PolyElement]]()
    for left, right in zip(itineraries[::2], itineraries[1::2], strict=True):
        (one, below), (other, above) = (_series(signs, each) for each in (left, right))
        row = [above[k] * one - below[k] * other for k in range(len(signs))]
        rows.append(row[:left_out] + row[left_out + 1 :])
    return rows


def _determinant(rows: Sequence[Sequence[PolyElement]]) -> PolyElement:
    """The determinant of polynomials, but for its sign."""
    matrix = DomainMatrix([list(row) for row in rows], (len(rows), len(rows)), RING.to_domain())
    return matrix.charpoly()[-1]


def cofactors(line: MapLine, itineraries: Sequence[Itinerary], number: int) -> list[PolyElement]:
    """The factors of the pieces in the series of one break that give the determinant."""
    rows = _matrix(line, itineraries, number)
    units = [[RING(k == j) for k in range(len(rows))] for j in range(len(rows))]
    found = [_determinant([*rows[:number], unit, *rows[number + 1 :]]) for unit in units]
    # the piece on the left of the break has the factor zero
    return [*found[:number], RING.zero, *found[number:]]


def growth_from(found: PolyElement) -> Real | None:
    """One over the least root between 0 and 1 of a determinant, or 1; None if it is too large."""
    if found.degree() > LARGEST:
        return None
    coefficients = [QQ.zero] * (found.degree() + 1)
    for (power,), coefficient in found.terms():
        coefficients[power] = coefficient
    roots = real_roots(coefficients)  # the lowest power first: they are one over those of it
    return max([QQ.one, *roots[-1:]])


def _series(signs: Sequence[int], itinerary: Itinerary) -> tuple[PolyElement, list[PolyElement]]:
    """A denominator, which has no root between 0 and 1, and the numerators of the symbols."""
    found = [RING.zero for _ in signs]
    later = [RING.zero for _ in signs]
    factor, start = 1, 1
    for n, k in enumerate(itinerary.pieces):
        if n == itinerary.start:
            start = factor
        part = found if n < itinerary.start else later
        part[k] += factor * T**n
        factor *= signs[k]
    word = itinerary.word
    bottom = 1 - factor * start * T ** len(word) if word else RING.one
    return bottom, [a * bottom + b for a, b in zip(found, later, strict=True)]
