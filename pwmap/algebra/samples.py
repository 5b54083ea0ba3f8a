"""Rational points of the region that inequalities admit, or a proof that it is empty.

A point of the *interior* comes from linear programming or from an open cylindrical decomposition;
both are complete. Inequalities that cannot be strict together are solved for a parameter. Points
depend on the order of the parameters (:func:`ranked`), not on names or the order of inequalities.

The decomposition eliminates one parameter after another; each projection vanishes wherever the
order of the eliminated roots can change. Then the parameters get values in reverse order, one in
each gap between roots. Every open cell gets a point, so the search is complete [Strzebonski2000].
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from random import Random
from typing import Any

from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    HIGHEST,
    LOWEST,
    Fraction_,
    Infinite,
    Number,
    Ring,
    constant,
    degree_in,
    dense,
    is_constant,
    sign,
    total_degree,
)
from pwmap.algebra.inequalities import (
    Constraint,
    along,
    combined,
    connected,
    shown,
    value_at,
    variables,
)
from pwmap.algebra.rootfunctions import (
    at_root_of,
    coefficients_in,
    critical,
    irreducible_factors,
    resultant,
)
from pwmap.algebra.roots import Real, bounds, gap_around, real_roots, simplest_between


def open_point(
    constraints: Sequence[Constraint], order: Sequence[int]
) -> dict[int, Number] | list[Constraint]:
    """A point where inequalities hold strictly, else the weak ones, to be tried as equations."""
    ring = constraints[0].polynomial.ring
    polynomials = {factor for c in constraints for factor in irreducible_factors(c.polynomial)}
    levels: list[tuple[int, set[PolyElement]]] = []
    left = list(order)
    while left:
        # of equal cost, the first in the given order
        variable = min(left, key=lambda v: _cost(polynomials, v))
        left.remove(variable)
        levels.append((variable, {p for p in polynomials if variable in variables(p)}))
        polynomials -= levels[-1][1]
        if left:
            polynomials |= set(_projected(levels[-1][1], variable))
    values = [QQ.zero] * len(ring.gens)
    if _fill_in(values, constraints, levels, frozenset()):
        return {variable: values[variable] for variable in order}
    return [c for c in constraints if not c.strict]


def _cost(polynomials: Iterable[PolyElement], variable: int) -> tuple[int, int, int]:
    """The cost of eliminating a parameter: its degree, the total degree, and its frequency."""
    own = [p for p in polynomials if variable in variables(p)]
    return (
        max((degree_in(p, variable) for p in own), default=0),
        max((total_degree(p) for p in own), default=0),
        len(own),
    )


def _projected(polynomials: Iterable[PolyElement], variable: int) -> Iterator[PolyElement]:
    """Yield the factors of leading coefficients, discriminants and resultants in a parameter."""
    own = list(polynomials)
    for i, p in enumerate(own):
        meetings = (resultant(p, q, variable) for q in own[:i])
        for polynomial in (*critical(p, variable), *meetings):
            yield from irreducible_factors(polynomial)


def _fill_in(
    values: list[Number],
    constraints: Sequence[Constraint],
    levels: Sequence[tuple[int, set[PolyElement]]],
    known: frozenset[int],
) -> bool:
    """Fill in values, trying gap after gap, until all inequalities hold strictly."""
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
    inside = [simplest_between(*gap) for gap in pairwise((LOWEST, *roots, HIGHEST))]
    for value in sorted(inside, key=lambda x: (abs(x), -x)):
        values[variable] = value
        if all(value_at(c.polynomial, values) > 0 for c in ready) and _fill_in(
            values, constraints, levels[:-1], known
        ):
            return True
    values[variable] = QQ.zero
    return False


SEED = 1  # of random steps: fixed, so that samples are reproducible
DENOMINATORS = (7, 17, 97, 1009, 1000003)  # of steps in a gap: small ones first, for simple samples
WIDTH = 4  # of the part of an infinite gap that is divided into steps


class EmptyRegionError(ValueError):
    """No values satisfy the inequalities, or no rational ones were found."""


Solved = tuple[int, Fraction_]  # a parameter, given as a quotient of polynomials in others


# inequalities of the free parameters, values of these at which they hold strictly, and the other
# parameters as quotients, each in those that are free or come later
Interior = tuple[list[Constraint], dict[int, Number], list[Solved]]


def points(constraints: Sequence[Constraint], order: Sequence[int]) -> Iterator[list[Number]]:
    """Yield points that satisfy the constraints, simple ones first; EmptyRegionError if none."""
    limits, point, solved = _whole_interior(constraints, order)
    free = [variable for variable in order if variable in point]
    values = [point.get(variable, QQ.zero) for variable in range(len(order))]
    for variable in free:
        values[variable] = simplest_between(*_gap(limits, values, variable))
    yield _completed(values, solved)
    plain = list(values)
    rng = Random(SEED)  # always the same, as samples are part of a result
    for attempt in range(10**9):
        step = DENOMINATORS[min(attempt // 4, len(DENOMINATORS) - 1)]
        values[:] = plain
        for variable in free:
            values[variable] = _within(_gap(limits, values, variable), step, rng)
        yield _completed(values, solved)


def _gap(
    limits: Sequence[Constraint], values: Sequence[Number], variable: int
) -> tuple[Real, Real]:
    """The open interval in which one parameter can move from an interior point."""
    return gap_around(values[variable], (along(c.polynomial, values, variable) for c in limits))


def _within(gap: tuple[Real, Real], step: int, rng: Random) -> Number:
    """The simplest rational near a randomly chosen one of equal steps through a gap."""
    low, high = gap
    middle = simplest_between(low, high)
    first = middle - WIDTH if isinstance(low, Infinite) else bounds(low)[1]
    last = middle + WIDTH if isinstance(high, Infinite) else bounds(high)[0]
    k = rng.randrange(1, step)
    near = [first + (last - first) * QQ(n, 4 * step) for n in (4 * k - 1, 4 * k + 1)]
    return simplest_between(*near)  # simple, as denominators of several parameters multiply


def _completed(values: Sequence[Number], solved: Sequence[Solved]) -> list[Number]:
    completed = list(values)
    for variable, quotient in reversed(solved):
        top, bottom = (value_at(number, completed) for number in quotient)
        completed[variable] = top / bottom
    return completed


# --- Interiors ------------------------------------------------------------------------------------


def _whole_interior(constraints: Sequence[Constraint], order: Sequence[int]) -> Interior:
    """An interior, found separately for each group of parameters tied by inequalities."""
    for constraint in constraints:
        if is_constant(constraint.polynomial) and not _holds(constraint):
            raise EmptyRegionError(f"{NONE} {constraint}")
    ordered = tuple(sorted(dict.fromkeys(constraints), key=lambda c: _sorting_key(c, order)))
    left = list(order)
    limits, point, solved = list[Constraint](), dict[int, Number](), list[Solved]()
    while left:
        first = frozenset(left[:1])
        own = connected(ordered, first)
        tied = first.union(*(variables(c.polynomial) for c in own))
        try:
            part = _interior(own, [v for v in order if v in tied])
        except EmptyRegionError as error:
            raise EmptyRegionError(f"{error} {shown(c for c in constraints if c in own)}") from None
        limits, point, solved = limits + part[0], point | part[1], solved + part[2]
        left = [v for v in left if v not in tied]
    return limits, point, solved


def _holds(constraint: Constraint) -> bool:
    return constraint.holds(sign(constant(constraint.polynomial)))


def _sorting_key(constraint: Constraint, order: Sequence[int]) -> tuple[Any, ...]:
    """A key that orders inequalities independently of names."""
    terms = [(tuple(m[v] for v in order), n) for m, n in constraint.polynomial.terms()]
    return constraint.strict, sorted(terms)


NONE = "there are no values of the parameters with"
NOT_FOUND = "no rational values of the parameters were found with"


def _interior(constraints: Sequence[Constraint], order: Sequence[int]) -> Interior:
    """An interior, with some weak inequalities taken as equations if need be."""
    open_ones = []
    for constraint in constraints:
        if not is_constant(constraint.polynomial):
            open_ones.append(constraint)
        elif not _holds(constraint):
            raise EmptyRegionError(NONE)
    used = frozenset().union(*(variables(c.polynomial) for c in open_ones))
    point = {variable: QQ.zero for variable in order if variable not in used}
    used_order = [variable for variable in order if variable in used]
    if not open_ones:
        return [], point, []
    if all(total_degree(c.polynomial) == 1 for c in open_ones):
        found = _linear_point(open_ones, used_order)
    else:
        found = open_point(open_ones, used_order)
    if isinstance(found, dict):
        return open_ones, point | found, []
    return _with_equation(open_ones, order, found)


def _with_equation(
    constraints: Sequence[Constraint], order: Sequence[int], candidates: Sequence[Constraint]
) -> Interior:
    """An interior of the set on which one of the candidates is an equation."""
    complete = True
    for candidate in candidates:
        others = [c for c in constraints if c is not candidate]
        for factor in irreducible_factors(candidate.polynomial):
            solutions, is_all = _solutions(factor, order)
            complete = complete and is_all
            peaks = [] if is_all else list(_critical_solutions(factor, order))
            tried = [(others, s) for s in solutions] + [(list(constraints), s) for s in peaks]
            for given, solved in tried:
                variable, (_, bottom) = solved
                rest = [v for v in order if v != variable]
                kept = [_substituted(c, solved) for c in given]
                kept += [] if is_constant(bottom) else [Constraint(bottom**2, True)]
                try:
                    limits, point, more = _interior(kept, rest)
                except EmptyRegionError as error:
                    complete = complete and str(error) == NONE
                    continue
                return limits, point, [solved, *more]
    raise EmptyRegionError(NONE if complete else NOT_FOUND)


def _solutions(factor: PolyElement, order: Sequence[int]) -> tuple[list[Solved], bool]:
    """Solutions of an equation for one parameter, and whether they cover all of its points."""
    found = []
    for variable in order:
        if degree_in(factor, variable) == 1:
            rest, slope = coefficients_in(factor, variable)
            if is_constant(slope):
                return [(variable, (-rest, slope))], True
            found.append((variable, (-rest, slope)))
    (*others, only) = sorted(variables(factor))
    return found, not others and not real_roots(dense(factor, only))


def _critical_solutions(factor: PolyElement, order: Sequence[int]) -> Iterator[Solved]:
    """Yield solutions for points where a derivative vanishes, as at an extremum of value zero."""
    for variable in order:
        slope = factor.diff(variable)
        if not is_constant(slope):
            for part in irreducible_factors(slope):
                yield from _solutions(part, order)[0]


def _substituted(constraint: Constraint, solved: Solved) -> Constraint:
    """An inequality with a parameter replaced, times an even power of the denominator."""
    polynomial, (variable, (top, bottom)) = constraint.polynomial, solved
    line = bottom * polynomial.ring.gens[variable] - top
    total = at_root_of(polynomial, line, variable)
    odd = degree_in(polynomial, variable) % 2
    return Constraint(total * bottom if odd else total, constraint.strict)


def _linear_point(
    constraints: Sequence[Constraint], order: Sequence[int]
) -> dict[int, Number] | list[Constraint]:
    """A point where linear inequalities hold strictly, else those to be tried as equations."""
    strict = [c._replace(strict=True) for c in constraints]
    ring = constraints[0].polynomial.ring
    units = [ring.gens[variable].LM for variable in order]
    combines, numbers = combined(strict, [*units, ring.zero_monom])
    if combines:
        *weights, weight = numbers
        if weight:
            return []
        used = [c for c, w in zip(constraints, weights, strict=True) if w]
        return [] if any(c.strict for c in used) else used[:1]
    *coordinates, scale, _ = numbers
    ratios = [x / scale for x in coordinates]
    return {v: QQ(x.numerator, x.denominator) for v, x in zip(order, ratios, strict=True)}


# --- The order of parameters ---------------------------------------------------------------------


def ranked(
    ring: Ring, constraints: Sequence[Constraint], coefficients: Sequence[Number] = ()
) -> list[int]:
    """The parameters, ordered by the terms in which they occur, and by name only in a tie."""
    ranks = [0] * len(ring.gens)

    def signature(terms: Iterable[tuple[tuple[int, ...], Number]]) -> list[tuple[Any, ...]]:
        return sorted(
            (number, sorted((ranks[i], e) for i, e in enumerate(exponents) if e))
            for exponents, number in terms
        )

    numbers = [(i, n.terms()) for i, n in enumerate(coefficients) if isinstance(n, PolyElement)]
    # refine the ranks repeatedly by those of the parameters that occur in the same terms
    for _ in ranks:
        roles: list[list[Any]] = [[] for _ in ranks]
        terms_by_role: list[tuple[Any, Any]] = [((0, i, []), terms) for i, terms in numbers]
        terms_by_role += [
            ((1, int(c.strict), signature(c.polynomial.terms())), c.polynomial.terms())
            for c in constraints
        ]
        for role, terms in terms_by_role:
            for exponents, number in terms:
                for i, exponent in enumerate(exponents):
                    if exponent:
                        roles[i].append((role, exponent, signature([(exponents, number)])))
        own = [(rank, sorted(role)) for rank, role in zip(ranks, roles, strict=True)]
        ordered = sorted(own)
        ranks = [ordered.index(item) for item in own]
    return sorted(range(len(ranks)), key=lambda i: (ranks[i], str(ring.symbols[i])))
