"""The growth of laps from the kneading determinant [MilnorThurston1988].

Each piece is a symbol, and each germ has a series: the symbols that it visits, the n-th with the
factor t^n and the sign of the slope up to there. Along the line the series of a point jumps only
where its n-th image is a break, by t^n times the difference of the series of both sides of that
break. So these differences count the preimages of breaks, and the growth of laps is one over the
least root in (0, 1) of their determinant.

A difference is a polynomial where both orbits *match* (:mod:`pwmap.longrun.entropy.matching`).
"""

from __future__ import annotations

from collections.abc import Sequence

from sympy import QQ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, ring

from pwmap.algebra.exact import dense, sign
from pwmap.algebra.roots import Real, real_roots
from pwmap.longrun.entropy.itineraries import Itinerary
from pwmap.longrun.line import MapLine

LARGEST = 400  # degree of a determinant whose roots are looked for
RING, T = ring("t", QQ)


def growth_by_kneading(line: MapLine, itineraries: Sequence[Itinerary]) -> Real | None:
    """The growth of laps, at least 1; None if the determinant's degree is too high."""
    rows = _matrix(line, itineraries)
    return growth_from(_determinant(rows)) if rows else QQ.one


def _matrix(
    line: MapLine, itineraries: Sequence[Itinerary], left_out: int = 0
) -> list[list[PolyElement]]:
    """The differences at each break, times polynomials without a root in (0, 1)."""
    signs = [sign(branch.slope) for branch in line.branches]
    rows = list[list[PolyElement]]()
    for left, right in zip(itineraries[::2], itineraries[1::2], strict=True):
        (one, below), (other, above) = (_series(signs, each) for each in (left, right))
        row = [above[k] * one - below[k] * other for k in range(len(signs))]
        rows.append(row[:left_out] + row[left_out + 1 :])
    return rows


def _determinant(rows: Sequence[Sequence[PolyElement]]) -> PolyElement:
    """The determinant of a matrix of polynomials, up to its sign."""
    matrix = DomainMatrix([list(row) for row in rows], (len(rows), len(rows)), RING.to_domain())
    return matrix.charpoly()[-1]


def cofactors(line: MapLine, itineraries: Sequence[Itinerary], number: int) -> list[PolyElement]:
    """The cofactors of the row of one break: the determinant is their product with its series."""
    rows = _matrix(line, itineraries, number)
    units = [[RING(k == j) for k in range(len(rows))] for j in range(len(rows))]
    found = [_determinant([*rows[:number], unit, *rows[number + 1 :]]) for unit in units]
    # the column of the piece on the left of the break is left out
    return [*found[:number], RING.zero, *found[number:]]


def growth_from(found: PolyElement) -> Real | None:
    """One over the least root of a determinant in (0, 1), or 1; None if its degree is too high."""
    if found.degree() > LARGEST:
        return None
    roots = real_roots(dense(found)[::-1])  # the lowest power first: one over those of it
    return max([QQ.one, *roots[-1:]])


def _series(signs: Sequence[int], itinerary: Itinerary) -> tuple[PolyElement, list[PolyElement]]:
    """A denominator, which has no root in (0, 1), and the numerators of the symbols."""
    found, later = ([RING.zero for _ in signs] for _ in range(2))
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
