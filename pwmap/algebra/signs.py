"""The signs that a polynomial can take where inequalities hold: by proofs, not by samples.

Proofs are complete in one parameter (real roots), and for linear polynomials over linear
inequalities (linear programming). Otherwise a polynomial of degree one in a parameter is bounded by
its values at the bounds of that parameter, and signs are refuted by products of inequalities whose
sum is negative. A sign may then remain unproved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, partial
from itertools import chain, combinations, combinations_with_replacement, islice, product
from math import prod

from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    Number,
    Ring,
    constant,
    degree_in,
    dense,
    factored,
    is_constant,
    sign,
    total_degree,
)
from pwmap.algebra.inequalities import (
    ANY,
    Constraint,
    Signs,
    combined,
    connected,
    proportion,
    value_at,
    variables,
)
from pwmap.algebra.rootfunctions import coefficients_in
from pwmap.algebra.roots import gaps_and_roots, inside, real_roots, sign_at

Constraints = tuple[Constraint, ...]
Point = Sequence[Number]  # a value for each parameter
LIMIT = 200  # products in one refutation, at most: with more, linear programs take seconds


def possible_signs(
    polynomial: PolyElement,
    constraints: Constraints,
    points: Callable[[], Iterable[Point]] | None = tuple,
) -> Signs:
    """All signs that a polynomial may take where constraints hold; ``points`` satisfy these.

    They are products of signs of its factors, each under the constraints tied to it. Without
    ``points`` no sign is refuted by products.
    """
    if is_constant(polynomial):
        return frozenset((sign(constant(polynomial)),))
    unit, parts = factored(polynomial)
    signs: Signs = frozenset((sign(unit),))
    for factor, exponent in parts:
        own = connected(constraints, variables(factor))
        possible = _bounded(factor, own)
        if points is not None and len(possible) > 1 and not _is_complete(factor, own):
            seen = {sign(value_at(factor, point)) for point in points()}
            if len(seen) <= 1:  # otherwise more than one sign does occur
                sides = [side for side in (1, -1) if not seen or side in seen]
                possible &= _remaining_signs(factor, sides, partial(_is_refuted, constraints=own))
        if exponent % 2 == 0:
            possible = frozenset(abs(s) for s in possible)
        signs = frozenset(a * b for a in signs for b in possible)
    return signs


def _is_complete(factor: PolyElement, constraints: Constraints) -> bool:
    """Whether roots or a linear program alone are exact: each sign that they leave does occur."""
    polynomials = [factor, *(c.polynomial for c in constraints)]
    used = frozenset().union(*map(variables, polynomials))
    return len(used) == 1 or all(total_degree(p) == 1 for p in polynomials)


@cache
def _bounded(factor: PolyElement, constraints: Constraints) -> Signs:
    """The signs left by all proofs except the refutation by products."""
    signs = ANY
    for constraint in constraints:
        scale = proportion(constraint.polynomial, factor)
        if scale:
            signs = frozenset(s for s in signs if constraint.holds(scale * s))
    own = variables(factor)
    if len(signs) > 1 and len(own) == 1:
        signs &= _univariate_signs(factor, constraints, next(iter(own)))
    if len(signs) > 1 and total_degree(factor) == 1:
        signs &= _linear_signs(factor, constraints)
    if not _is_complete(factor, constraints):
        for variable in own:
            if len(signs) > 1 and degree_in(factor, variable) == 1:
                signs &= _signs_by_elimination(factor, constraints, variable)
    return signs


# --- One parameter, and linear ones ---------------------------------------------------------------


def _univariate_signs(factor: PolyElement, constraints: Constraints, variable: int) -> Signs:
    """The signs in one parameter, from each real root and gap between roots; complete."""
    limits = [c for c in constraints if variables(c.polynomial) == {variable}]
    admitted = [(dense(c.polynomial, variable), c) for c in limits]
    polynomial = dense(factor, variable)
    roots = {x for p in (polynomial, *(p for p, _ in admitted)) for x in real_roots(p)}
    found = set()
    for piece in gaps_and_roots(sorted(roots)):
        place = inside(piece)
        if all(c.holds(sign_at(p, place)) for p, c in admitted):
            found.add(sign_at(polynomial, place))
    return frozenset(found)


def _linear_signs(factor: PolyElement, constraints: Constraints) -> Signs:
    """The signs that do not contradict the linear constraints; complete if all are linear."""
    linear = [c for c in constraints if total_degree(c.polynomial) == 1]
    return _remaining_signs(factor, (1, -1), lambda claim: contradictory([*linear, claim]))


def _remaining_signs(
    factor: PolyElement, sides: Iterable[int], is_impossible: Callable[[Constraint], bool]
) -> Signs:
    """The signs of a polynomial that remain: a proved one, or all but the impossible ones."""
    for side in sides:
        if is_impossible(Constraint(-side * factor, False)):
            return frozenset((side,))
    return ANY - {-side for side in sides if is_impossible(Constraint(-side * factor, True))}


def without_implied(constraints: Sequence[Constraint], kept: int) -> list[Constraint]:
    """The constraints without linear ones that others imply; the first few are always kept."""
    left = list(constraints)
    for constraint in constraints[kept:]:
        linear = [c for c in left if total_degree(c.polynomial) == 1]
        if constraint in linear and constraint.strict:
            linear.remove(constraint)
            if contradictory([*linear, Constraint(-constraint.polynomial, False)]):
                left.remove(constraint)
    return left


def contradictory(constraints: Sequence[Constraint]) -> bool:
    """Whether nonnegative multiples of inequalities add up to a false inequality."""
    ground = constraints[0].polynomial.ring.zero_monom
    monomials = {m for c in constraints for m in c.polynomial.monoms()} - {ground}
    return combined(constraints, [*sorted(monomials), ground])[0]


# --- Several parameters ---------------------------------------------------------------------------


def _signs_by_elimination(factor: PolyElement, constraints: Constraints, variable: int) -> Signs:
    """The signs of a polynomial that is affine in a parameter, from its values at the bounds."""
    others = tuple(c for c in constraints if variable not in variables(c.polynomial))
    bounds = list(_bounds(constraints, others, variable))
    top = max(total_degree(p) for p in (factor, *(c.polynomial for c in constraints)))
    kept = (c for c in _eliminated(bounds) if total_degree(c.polynomial) <= top)  # no explosion
    others = tuple(dict.fromkeys((*others, *kept)))
    rest, slope = coefficients_in(factor, variable)
    ends: dict[int, list[tuple[Signs, bool]]] = {1: [], -1: []}  # at lower and upper bounds
    for sense, gain, shift, strict in bounds:
        # at the bound, the parameter is -shift/gain: the factor is (rest gain - slope shift)/gain
        values = possible_signs(rest * gain - slope * shift, others, None)
        ends[sense].append((frozenset(sense * s for s in values), not strict))
    if not (ends[1] and ends[-1]):
        slopes, rests = (possible_signs(p, others, None) for p in (slope, rest))
        for sense, found in ends.items():
            if not found:  # the parameter is not bounded on this side
                infinite = {-sense * s for s in slopes if s} | (rests if 0 in slopes else set())
                found.append((frozenset(infinite), False))
    signs = ANY
    for (low, low_closed), (high, high_closed) in product(ends[1], ends[-1]):
        between = {s for a, b in product(low, high) for s in _between(a, b)}
        signs &= between | (low if low_closed else set()) | (high if high_closed else set())
    return signs


def _between(low: int, high: int) -> Signs:
    """The signs of an affine function strictly between two ends, from those at the ends."""
    if low * high < 0:
        return ANY
    return frozenset((low or high,))


Bound = tuple[int, PolyElement, PolyElement, bool]  # sign of the slope, slope, rest, strict


def _bounds(constraints: Constraints, others: Constraints, variable: int) -> Iterator[Bound]:
    """Yield the inequalities that bound a parameter from below (sign +1) or above (-1)."""
    for constraint in constraints:
        if degree_in(constraint.polynomial, variable) == 1:
            shift, gain = coefficients_in(constraint.polynomial, variable)
            sides = possible_signs(gain, others, None)
            if sides in ({1}, {-1}):
                yield next(iter(sides)), gain, shift, constraint.strict


def _eliminated(bounds: Sequence[Bound]) -> Iterator[Constraint]:
    """Yield inequalities without the parameter: each lower bound is below each upper one."""
    for sense, gain, shift, strict in bounds:
        for other_sense, other_gain, other_shift, other_strict in bounds:
            if sense > 0 > other_sense:
                left = gain * other_shift - other_gain * shift
                if not is_constant(left):
                    yield Constraint(left, strict or other_strict)


@cache
def _is_refuted(claim: Constraint, constraints: Constraints) -> bool:
    """Whether products of the claim and of known inequalities have a negative sum."""
    known = (claim, *constraints)
    top = max(2, *(total_degree(c.polynomial) for c in known))
    used = sorted(frozenset().union(*(variables(c.polynomial) for c in known)))
    ring = claim.polynomial.ring
    # squares of monomials, and of their sums and differences, are never negative
    listed = chain(_products(known, top), _squares(ring, used, top // 2))
    tried = list(dict.fromkeys(islice(listed, LIMIT + 1)))
    return len(tried) <= LIMIT and contradictory(tried)


def _products(known: Constraints, top: int) -> Iterator[Constraint]:
    for i, first in enumerate(known):
        yield first
        left = top - total_degree(first.polynomial)
        if left > 0:
            for other in _products(known[i:], left):
                if total_degree(other.polynomial) <= left:
                    polynomial = first.polynomial * other.polynomial
                    yield Constraint(polynomial, first.strict and other.strict)


def _squares(ring: Ring, used: Sequence[int], half: int) -> Iterator[Constraint]:
    gens, degrees = [ring.gens[variable] for variable in used], range(half + 1)
    factors_ = chain.from_iterable(combinations_with_replacement(gens, n) for n in degrees)
    monomials = [prod(each, start=ring.one) for each in factors_]
    yield from (Constraint(m**2, False) for m in monomials[1:])
    for first, second in combinations(monomials, 2):
        yield from (Constraint((first + s * second) ** 2, False) for s in (1, -1))
