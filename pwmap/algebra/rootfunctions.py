"""Polynomials in two parameters, and their real roots in one as functions of the other.

Roots are continuous and keep their order as long as neither the leading coefficient nor the
discriminant vanishes, and do not meet those of another polynomial as long as the resultant does not
vanish. They are numbered at a sample of the other parameter.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, total_ordering
from itertools import pairwise
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    Infinite,
    Number,
    Portable,
    Ring,
    degree_in,
    dense,
    factored,
    is_constant,
    normalised,
    polynomial_ring,
    reduced_to_sympy,
    to_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import along
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    dense_of,
    real_roots,
    real_to_sympy,
    sign_at,
    simplest_between,
)
from pwmap.algebra.texts import printable


def coefficients_in(polynomial: PolyElement, index: int) -> list[PolyElement]:
    """The coefficients of the powers of one parameter, lowest first, in the ring of both."""
    ring = polynomial.ring
    powers: list[dict[tuple[int, ...], Number]] = [
        {} for _ in range(degree_in(polynomial, index) + 1)
    ]
    for exponents, coefficient in polynomial.terms():
        others = (*exponents[:index], 0, *exponents[index + 1 :])
        powers[exponents[index]][others] = coefficient
    return [ring.from_dict(terms) for terms in powers]


def leading_in(polynomial: PolyElement, index: int) -> PolyElement:
    """The coefficient of the highest power of one parameter."""
    return coefficients_in(polynomial, index)[-1]


def irreducible_factors(polynomial: PolyElement) -> tuple[PolyElement, ...]:
    """The irreducible factors, each once, with coprime integer coefficients; none of a constant."""
    return tuple(normalised(factor) for factor, _ in factored(polynomial)[1])


def divides(factor: PolyElement, polynomial: PolyElement) -> bool:
    """Whether ``factor`` divides a polynomial."""
    return not polynomial.rem(factor)


@lru_cache(maxsize=65536)
def resultant(first: PolyElement, second: PolyElement, index: int) -> PolyElement:
    """The resultant in one parameter, up to a constant; zero wherever both have a common root."""
    ring = first.ring
    symbols = [ring.symbols[index], *ring.symbols[:index], *ring.symbols[index + 1 :]]
    turned = polynomial_ring(symbols)  # sympy eliminates the first generator
    found = to_ring(first.set_ring(turned).resultant(second.set_ring(turned)), ring)
    return ring.one if is_constant(found) else normalised(found)


def critical(polynomial: PolyElement, index: int) -> Iterator[PolyElement]:
    """Yield polynomials that vanish wherever the number of real roots in a parameter can change.

    These are the leading coefficient and the discriminant, which is zero where two roots meet.
    """
    yield leading_in(polynomial, index)
    if degree_in(polynomial, index) > 1:
        yield resultant(polynomial, polynomial.diff(index), index)


def at_root_of(polynomial: PolyElement, line: PolyElement, index: int) -> PolyElement:
    """A polynomial of degree n at the root of a linear one, times the n-th power of its slope."""
    rest, slope = coefficients_in(line, index)
    value, scale = polynomial.ring.zero, polynomial.ring.one
    for power in reversed(coefficients_in(polynomial, index)):  # Horner's rule
        value = value * -rest + power * scale
        scale = scale * slope
    return value


class RealRootOf(sympy.Function):  # type: ignore[misc]
    """A real root, in one symbol, of a polynomial that also has a parameter."""

    nargs = 3  # the polynomial, the symbol, and the number of the root, from the lowest on
    is_real = True

    @classmethod
    def eval(cls, polynomial: Any, symbol: Any, number: Any) -> Any:
        """The root itself once the polynomial has no parameter left; None before."""
        if polynomial.free_symbols <= {symbol}:
            roots = real_roots(dense_of(sympy.Poly(polynomial, symbol, domain="QQ")))
            return real_to_sympy(roots[int(number)])
        return None


@total_ordering
@dataclass(frozen=True, slots=True, eq=False)
class Root(Portable):
    """A root as a function of the other parameter; equal at the sample, or :func:`identical`."""

    value: Real  # at the sample of the other parameter
    factor: PolyElement  # irreducible, in both parameters; it vanishes on the root
    number: int  # index among the real roots in the one parameter, from the lowest

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Root) and self.value == other.value

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: Root) -> bool:
        return bool(self.value < other.value)

    def to_sympy(self, column: Column) -> sympy.Expr:
        """The root as an expression: a quotient, with a square root, or an unevaluated function."""
        powers = coefficients_in(self.factor, column.along)
        if len(powers) == 2:
            return reduced_to_sympy(-powers[0], powers[1], str(column.symbols[column.along]))
        if len(powers) == 3:
            rest, linear, square = map(to_sympy, powers)
            rises = sign_at(column.across(powers[2]), column.sample) > 0
            side = 1 if (self.number == 1) == rises else -1
            radicand = sympy.factor(linear**2 - 4 * square * rest)
            with suppress(ValueError):  # of sympy 1.14, which fails to factor some large numbers
                return (-linear + side * sympy.sqrt(radicand)) / (2 * square)
        symbol = column.symbols[column.along]
        return RealRootOf(to_sympy(self.factor), symbol, sympy.Integer(self.number))


@printable
@dataclass(frozen=True, slots=True)
class Column(Portable):
    """An open interval, or the whole line, of one of two parameters."""

    symbols: tuple[sympy.Symbol, sympy.Symbol]
    along: int  # index of the symbol in which roots are taken
    low: Real  # lower end, of the other symbol, as high is the upper one
    high: Real
    sample: Number  # a value of the other symbol inside

    def holds(self, value: Number) -> bool:
        """Whether a value of the other parameter lies inside the interval."""
        return bool(self.low < value < self.high)

    def at_sample(self, polynomial: PolyElement) -> Dense:
        """The polynomial at the sample, in the parameter of the roots."""
        return along(polynomial, (self.sample, self.sample), self.along)

    def across(self, polynomial: PolyElement) -> Dense:
        """The coefficients of a polynomial in the other parameter alone."""
        return dense(polynomial, 1 - self.along)

    def keeps(self, polynomial: PolyElement) -> bool:
        """Whether a polynomial in the other parameter alone has no zero inside."""
        roots = real_roots(self.across(polynomial))
        return not any(self.holds(root) for root in roots)

    def is_apart(self, root: Root, polynomial: PolyElement) -> bool:
        """Whether a root meets no root of a polynomial inside; it must not be one of them."""
        if not degree_in(polynomial, self.along):
            return self.keeps(polynomial)
        return self.keeps(resultant(root.factor, polynomial, self.along))

    def number(self, root: Root | Infinite, value: Number) -> Real | None:
        """The value of a root at a value of the other parameter; None if that lies outside."""
        if isinstance(root, Infinite):
            return root
        if not self.holds(value):
            return None
        return real_roots(along(root.factor, (value, value), self.along))[root.number]

    def limit(self, root: Root, end: Real) -> Real | None:
        """The limit of a root at an end of the interval; None if it grows without bound."""
        found = self._candidates(root.factor, end)
        if not found:
            return None
        # the limit is one of the candidates at the end, which walls separate; close enough to the
        # end the polynomial has no zero on a wall, and the root stays between two of them
        between = [simplest_between(low, high) for low, high in pairwise(found)]
        walls = [bounds(found[0])[0] - 1, *between, bounds(found[-1])[1] + 1]
        near: Real = self.sample
        for wall in walls:
            for crossing in real_roots(along(root.factor, (wall, wall), 1 - self.along)):
                if near < crossing < end or end < crossing < near:
                    near = crossing
        value = self.number(root, simplest_between(*sorted((near, end))))
        assert value is not None
        place = bisect_left(walls, value)
        return found[place - 1] if 0 < place < len(walls) else None

    def _candidates(self, factor: PolyElement, end: Real) -> tuple[Real, ...]:
        """Numbers that include all roots of a polynomial at a value of the other parameter."""
        if not isinstance(end, RealRoot):
            return real_roots(along(factor, (end, end), self.along))
        minimal = minimal_polynomial(factor.ring, 1 - self.along, end)
        return real_roots(dense(resultant(factor, minimal, 1 - self.along), self.along))


def minimal_polynomial(ring: Ring, index: int, value: Real) -> PolyElement:
    """The minimal polynomial of a real number, in one of the generators of a ring."""
    coefficients = value.polynomial if isinstance(value, RealRoot) else (QQ.one, -value)
    powers = enumerate(reversed(coefficients))
    return normalised(sum((c * ring.gens[index] ** n for n, c in powers), start=ring.zero))
