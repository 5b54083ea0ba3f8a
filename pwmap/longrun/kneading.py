"""The growth of laps from kneading sequences, of which only differences need to be known.

Give each piece a symbol e, and each germ the series of the symbols that it visits, the n-th with
the factor t^n and the sign of the slope of the way there. As a point moves along the line its
series jumps only where an image of it is a break, and always by t^n times the difference of the
series of both sides of that break, whether the map has a jump there or not. So these differences
count the preimages of breaks, and the growth of laps is one over the least root between 0 and 1 of
the determinant that they make [MilnorThurston1988].

A difference is a polynomial where both orbits *match*: after as many steps they are at one place,
with slopes of one sign. From there on they go on side by side, and what they do cancels. Where that
is so for an interval of parameters the entropy is constant, though orbits change everywhere
[Bruin2019].
"""

from __future__ import annotations

from collections.abc import Sequence

from sympy import QQ, ZZ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement, ring

from pwmap.algebra.roots import Real, real_roots
from pwmap.longrun.itineraries import Itinerary
from pwmap.longrun.line import Germ, Line
from pwmap.longrun.numbers import sign, work_of
from pwmap.maps.budget import BUDGET, Budget, Meter, metered

LARGEST = 400  # degree of a determinant whose roots are looked for
STEP = 10  # operations of one step
_RING, _T = ring("t", ZZ)


def matched(
    line: Line, number: int, steps: int, budget: Budget | Meter = BUDGET
) -> tuple[Itinerary, Itinerary] | None:
    """The itineraries of both sides of a break up to the step at which they match; None if none.

    Parameters
    ----------
    line, number
        A map, and which of its breaks, counted from the left.
    steps
        How far they are followed.
    budget
        What that may take.
    """
    meter = metered(budget)
    sides = line.germs[2 * number : 2 * number + 2]
    pieces = list[int](), list[int]()
    for _ in range(steps):
        meter.spend(sum(STEP + 3 * work_of(germ.x) for germ in sides))
        for germ, word in zip(sides, pieces, strict=True):
            word.append(line.number(germ))
        sides = line.image(sides[0]), line.image(sides[1])
        left, right = sides
        if not left.side or not right.side:
            return None
        if left == Germ(right.x, -right.side):
            one, other = (Itinerary(tuple(w), len(w), None) for w in pieces)
            return one, other
    return None


def growth_by_kneading(line: Line, itineraries: Sequence[Itinerary]) -> Real | None:
    """How laps grow: one over the least root of the kneading determinant, at least 1.

    Parameters
    ----------
    line
        The map, of which only the signs of slopes are looked at.
    itineraries
        Of all its germs, in its order, each known to the end, or matched with that of the other
        side.

    Returns
    -------
    Real or None
        None if the determinant is too large.
    """
    signs = [sign(branch.slope) for branch in line.branches]
    rows = list[list[PolyElement]]()
    for left, right in zip(itineraries[::2], itineraries[1::2], strict=True):
        (one, below), (other, above) = (_series(signs, each) for each in (left, right))
        row = [above[k] * one - below[k] * other for k in range(len(signs))]
        rows.append(row[1:])  # any column may be left out
    if not rows:
        return QQ.one
    size = len(rows)
    determinant = DomainMatrix(rows, (size, size), _RING.to_domain()).charpoly()[-1]
    if determinant.degree() > LARGEST:
        return None
    coefficients = [QQ(int(determinant.coeff(_T**n) if n else determinant.coeff(1)))
                    for n in range(determinant.degree() + 1)]  # fmt: skip
    roots = real_roots(coefficients)  # the lowest power first: they are one over those of it
    return max([QQ.one, *roots[-1:]])


def _series(signs: Sequence[int], itinerary: Itinerary) -> tuple[PolyElement, list[PolyElement]]:
    """A denominator, which has no root between 0 and 1, and the numerators of the symbols."""
    found = [_RING.zero for _ in signs]
    later = [_RING.zero for _ in signs]
    factor, start = 1, 1
    for n, k in enumerate(itinerary.pieces):
        if n == itinerary.start:
            start = factor
        part = found if n < itinerary.start else later
        part[k] += factor * _T**n
        factor *= signs[k]
    word = itinerary.word
    bottom = 1 - factor * start * _T ** len(word) if word else _RING.one
    return bottom, [a * bottom + b for a, b in zip(found, later, strict=True)]
