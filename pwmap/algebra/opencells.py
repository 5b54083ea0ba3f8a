"""Points at which polynomial inequalities hold strictly, by an open cylindrical decomposition.

Parameters are eliminated in turn; at the roots of what is left the order of the eliminated roots
can change. Then values are taken in each gap between roots, in the opposite order. Every open cell
gets a point, so the search is complete [Strzebonski2000].
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.bivariate import eliminated, leading_in
from pwmap.algebra.exact import Number, degree_in, is_constant, total_degree
from pwmap.algebra.inequalities import Constraint, along, factors, value_at, variables
from pwmap.algebra.roots import gaps_and_roots, real_roots, simplest_between


def open_point(
    constraints: Sequence[Constraint], order: Sequence[int]
) -> dict[int, Number] | list[Constraint]:
    """A point at which inequalities hold strictly, or the weak ones of which one is an equation."""
    ring = constraints[0].polynomial.ring
    polynomials = {f for c in constraints for f, _ in factors(c.polynomial)[1]}
    levels: list[tuple[int, set[PolyElement]]] = []
    left = list(order)
    while left:
        # of several of equal cost the first in the given order
        variable = min(left, key=lambda v: _cost(polynomials, v))
        left.remove(variable)
        levels.append((variable, {p for p in polynomials if variable in variables(p)}))
        polynomials -= levels[-1][1]
        if left:
            polynomials |= set(_projected(levels[-1][1], variable))
    values = [QQ.zero] * len(ring.gens)
    if _is_lifted(values, constraints, levels, frozenset()):
        return {variable: values[variable] for variable in order}
    return [c for c in constraints if not c.strict]


def _cost(polynomials: Iterable[PolyElement], variable: int) -> tuple[int, int, int]:
    """The work of eliminating a parameter: its degree, and how often it occurs."""
    own = [p for p in polynomials if variable in variables(p)]
    return (
        max((degree_in(p, variable) for p in own), default=0),
        max((total_degree(p) for p in own), default=0),
        len(own),
    )


def _projected(polynomials: Iterable[PolyElement], variable: int) -> Iterator[PolyElement]:
    """Where the order of real roots can change: leading coefficients, resultants, discriminants."""
    own = list(polynomials)
    for i, p in enumerate(own):
        found = [leading_in(p, variable), *(eliminated(p, q, variable) for q in own[:i])]
        if degree_in(p, variable) > 1:
            found.append(eliminated(p, p.diff(variable), variable))
        for polynomial in found:
            if not is_constant(polynomial):
                yield from (factor for factor, _ in factors(polynomial)[1])


def _is_lifted(
    values: list[Number],
    constraints: Sequence[Constraint],
    levels: Sequence[tuple[int, set[PolyElement]]],
    known: frozenset[int],
) -> bool:
    """Put values, gap by gap, until all inequalities hold."""
    if not levels:
        return True
    variable, polynomials = levels[-1]
    known = known | {variable}
    lines = [along(p, values, variable) for p in polynomials]
    roots = sorted({root for line in lines for root in real_roots(line)})
    ready = [
        c for c in constraints
        if variable in variables(c.polynomial) and variables(c.polynomial) <= known
    ]  # fmt: skip
    gaps = [piece for piece in gaps_and_roots(roots) if piece[0] is not piece[1]]
    for value in sorted((simplest_between(*gap) for gap in gaps), key=lambda x: (abs(x), -x)):
        values[variable] = value
        if all(value_at(c.polynomial, values) > 0 for c in ready) and _is_lifted(
            values, constraints, levels[:-1], known
        ):
            return True
    values[variable] = QQ.zero
    return False
