"""Polynomials in two parameters: the real roots in one, followed over the other.

They are continuous and keep their order while neither the leading coefficient nor the discriminant
vanishes, and do not meet those of another polynomial while the resultant does not.
"""

from __future__ import annotations

from functools import lru_cache

from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import Number, degree_in, factored, is_constant, polynomial_ring


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
    symbols = first.ring.symbols if index == 0 else first.ring.symbols[::-1]
    eliminating = polynomial_ring(symbols)  # sympy eliminates the first generator
    step = 1 if index == 0 else -1
    both = [eliminating.from_dict({m[::step]: c for m, c in p.items()}) for p in (first, second)]
    found = both[0].resultant(both[1])
    if is_constant(found):
        return first.ring.one
    terms = {((0, n) if index == 0 else (n, 0)): c for (n,), c in found.items()}
    return normalised(first.ring.from_dict(terms))


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
