"""Polynomials in two parameters, and their real roots in one of these over the other.

Roots are continuous and keep their order while neither the leading coefficient nor the discriminant
vanishes; they do not meet those of another polynomial while the resultant does not vanish.
"""

from __future__ import annotations

from functools import lru_cache

from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import (
    Number,
    degree_in,
    factored,
    is_constant,
    polynomial_ring,
    to_ring,
)


def coefficients_in(polynomial: PolyElement, index: int) -> list[PolyElement]:
    """Coefficients of the powers of one parameter, from the zeroth on, as polynomials in both."""
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
    """The factors that are no constants, each once, with coprime integer coefficients."""
    return tuple(normalised(factor) for factor, _ in factored(polynomial)[1])


def normalised(polynomial: PolyElement) -> PolyElement:
    """The multiple with coprime integer coefficients, the leading one positive."""
    primitive = polynomial.primitive()[1]
    return -primitive if primitive.LC < 0 else primitive


def divides(factor: PolyElement, polynomial: PolyElement) -> bool:
    """Whether one polynomial is a factor of another one."""
    return not polynomial.rem(factor)


@lru_cache(maxsize=65536)
def resultant(first: PolyElement, second: PolyElement, index: int) -> PolyElement:
    """The resultant in one parameter, up to a constant: zero where both have a common root."""
    if degree_in(first, index) > degree_in(second, index):
        first, second = second, first
    if degree_in(first, index) == 1:
        return normalised(at_root_of(second, first, index))
    found = eliminated(first, second, index)
    return first.ring.one if is_constant(found) else normalised(found)


def eliminated(first: PolyElement, second: PolyElement, index: int) -> PolyElement:
    """The resultant in one parameter, among any number of them, as sympy scales it."""
    ring = first.ring
    symbols = [ring.symbols[index], *ring.symbols[:index], *ring.symbols[index + 1 :]]
    turned = polynomial_ring(symbols)  # sympy eliminates the first generator
    found = first.set_ring(turned).resultant(second.set_ring(turned))
    return to_ring(found, ring)


def discriminant(polynomial: PolyElement, index: int) -> PolyElement:
    """Zero just where two roots in one parameter meet, or the leading coefficient is zero."""
    return resultant(polynomial, polynomial.diff(index), index)


def at_root_of(polynomial: PolyElement, line: PolyElement, index: int) -> PolyElement:
    """A polynomial of degree n at the root of one of degree one, times its slope to the power n."""
    rest, slope = coefficients_in(line, index)
    value, scale = polynomial.ring.zero, polynomial.ring.one
    for power in reversed(coefficients_in(polynomial, index)):  # Horner's rule
        value = value * -rest + power * scale
        scale = scale * slope
    return value
