"""Where a root goes as the other parameter tends to an end of its interval, exactly."""

from __future__ import annotations

from bisect import bisect_left
from itertools import pairwise

from sympy.polys.rings import PolyElement

from pwmap.algebra.bivariate import resultant
from pwmap.algebra.exact import dense
from pwmap.algebra.inequalities import along
from pwmap.algebra.rootfunctions import Column, Root, minimal_polynomial
from pwmap.algebra.roots import Real, RealRoot, bounds, real_roots, simplest_between


def limit_of(root: Root, column: Column, end: Real) -> Real | None:
    """The value that a root tends to at an end of a column; None if it grows without bound.

    It is among the roots of the polynomial there. Rationals part these; close enough to the end the
    polynomial is not zero at any of them, so that the root has no way past them.
    """
    found = _candidates(root.factor, column.along, end)
    if not found:
        return None
    between = [simplest_between(low, high) for low, high in pairwise(found)]
    walls = [bounds(found[0])[0] - 1, *between, bounds(found[-1])[1] + 1]
    near: Real = column.sample
    for wall in walls:
        for crossing in real_roots(along(root.factor, (wall, wall), 1 - column.along)):
            if near < crossing < end or end < crossing < near:
                near = crossing
    value = column.number(root, simplest_between(*sorted((near, end))))
    assert value is not None
    place = bisect_left(walls, value)
    return found[place - 1] if 0 < place < len(walls) else None


def _candidates(factor: PolyElement, index: int, end: Real) -> tuple[Real, ...]:
    """Numbers among which all roots of a polynomial at a value of the other parameter are."""
    if not isinstance(end, RealRoot):
        return real_roots(along(factor, (end, end), index))
    minimal = minimal_polynomial(factor.ring, 1 - index, end)
    return real_roots(dense(resultant(factor, minimal, 1 - index), index))
