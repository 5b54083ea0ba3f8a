"""An order of parameters by what they do, not by how they are named."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from sympy.polys.rings import PolyElement

from pwmap.algebra.exact import Number, Ring
from pwmap.algebra.inequalities import Constraint


def ranked(
    ring: Ring, constraints: Sequence[Constraint], coefficients: Sequence[Number] = ()
) -> list[int]:
    """The parameters in an order that depends on what they do, and on names only as a last resort.

    Each gets a rank by the terms in which it occurs, then by those of the parameters it occurs
    with, and so on.
    """
    ranks = [0] * len(ring.gens)

    def signature(terms: Iterable[tuple[tuple[int, ...], Number]]) -> list[tuple[Any, ...]]:
        return sorted(
            (number, sorted((ranks[i], e) for i, e in enumerate(exponents) if e))
            for exponents, number in terms
        )

    numbers = [(i, n.terms()) for i, n in enumerate(coefficients) if isinstance(n, PolyElement)]
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
