"""Assumptions on a map's parameters, as polynomial inequalities, and signs that they imply.

The sign of a polynomial is either *proved* on the whole region or undecided; no sample decides it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice

import sympy
from sympy.core.relational import Relational

from pwmap.algebra.arguments import shortened
from pwmap.algebra.arithmetic import Arithmetic, worked_out
from pwmap.algebra.exact import (
    Number,
    Portable,
    Ring,
    cancelled,
    constant,
    evaluate,
    is_constant,
    names_of,
    sign,
    to_sympy,
)
from pwmap.algebra.inequalities import Constraint, shown, variables
from pwmap.algebra.samples import points, ranked
from pwmap.algebra.signs import possible_signs
from pwmap.algebra.terms import INEQUALITIES, RELATIONS, Operation, Term

WITNESSES = 4  # sample points at which a sign is tried before its costly refutation


class UndecidedError(ValueError):
    """The assumptions do not decide a sign: assume more (``given``) or give values (``at``)."""

    def __init__(self, sentence: str, polynomial: sympy.Expr | None = None) -> None:
        super().__init__(sentence)
        self.polynomial = polynomial  # the one whose sign is missing, if that is the only cause


@dataclass(frozen=True)
class AssumedRegion(Portable):
    """The region of parameter values that satisfy polynomial inequalities."""

    ring: Ring  # None for no parameters
    constraints: tuple[Constraint, ...] = ()

    @cached_property
    def sample(self) -> dict[str, Number]:
        """One point of the region, as values by name; ValueError if there is none."""
        return next(self.samples())

    def samples(self, coefficients: Sequence[Number] = ()) -> Iterator[dict[str, Number]]:
        """Yield points of the region, simple ones first; ValueError if there are none."""
        if self.ring is None:
            yield {}
            return
        names = names_of(self.ring)
        # the coefficients of a map distinguish parameters that the inequalities do not
        order = ranked(self.ring, self.constraints, coefficients)
        for values in points(self.constraints, order):
            yield dict(zip(names, values, strict=True))

    @cached_property
    def _witnesses(self) -> tuple[list[Number], ...]:
        return tuple(list(values.values()) for values in islice(self.samples(), 1, 1 + WITNESSES))

    def known_sign(self, polynomial: Number) -> int | None:
        """The sign of a polynomial on the region, or None if none is proved."""
        if is_constant(polynomial):
            return sign(constant(polynomial))
        found = possible_signs(polynomial, self.constraints, lambda: self._witnesses)
        return next(iter(found)) if len(found) == 1 else None

    def sign(self, polynomial: Number) -> int:
        """The sign of a polynomial on the region; UndecidedError if none is proved."""
        found = self.known_sign(polynomial)
        if found is None:
            known = f"follow from {self}" if self.constraints else "follow without assumptions"
            raise UndecidedError(
                f"the sign of {shortened(str(sympy.factor(to_sympy(polynomial))))} "
                f"does not {known}: assume more of the parameters (given) or give one a value",
                to_sympy(polynomial),
            )
        return found

    def moved(self, ring: Ring, change: Callable[[Number], Number]) -> AssumedRegion:
        """The region in another ring, without constant inequalities; ValueError if it is empty."""
        moved = dict.fromkeys(Constraint(change(p), strict) for p, strict in self.constraints)
        region = AssumedRegion(ring, tuple(c for c in moved if not is_constant(c.polynomial)))
        _ = region.sample
        return region

    def contains(self, values: Mapping[str, Number]) -> Constraint | None:
        """The first inequality that values break, of those that they determine; None if none."""
        names = names_of(self.ring)

        def sign_of(polynomial: Number) -> int:
            known = all(names[i] in values for i in variables(polynomial))
            return sign(constant(evaluate(polynomial, values))) if known else 1

        return self.broken(sign_of)

    def broken(self, sign_of: Callable[[Number], int]) -> Constraint | None:
        """The first inequality that fails, given the signs of polynomials; None if all hold."""
        return next((c for c in self.constraints if not c.holds(sign_of(c.polynomial))), None)

    def relations(self) -> tuple[Relational, ...]:
        """The inequalities as sympy relations."""
        return tuple(constraint.relation() for constraint in self.constraints)

    def __str__(self) -> str:
        """The inequalities, or "no assumption"; the middle is left out if they are long."""
        return shortened(shown(self.constraints))


def read_constraints(given: Iterable[Term], ring: Ring) -> tuple[Constraint, ...]:
    """Inequalities from relations and sympy's assumptions; ValueError for any other condition."""
    found: list[Constraint] = []
    for symbol, generator in zip(ring.symbols, ring.gens, strict=True) if ring is not None else ():
        if symbol.is_nonnegative:
            found.append(Constraint(generator, bool(symbol.is_positive)))
        if symbol.is_nonpositive:
            found.append(Constraint(-generator, bool(symbol.is_negative)))
    for condition in given:
        found.extend(_read(condition, Arithmetic(ring)))
    return tuple(dict.fromkeys(found))


def _read(term: Term, arithmetic: Arithmetic) -> Iterator[Constraint]:
    match term.operation:
        case Operation.AND:
            for argument in term.arguments:
                yield from _read(argument, arithmetic)
        case Operation.TRUTH if term.value:
            return
        case Operation.NOT if term.arguments[0].operation in INEQUALITIES:
            inner = term.arguments[0]
            rest = {-1, 0, 1} - RELATIONS[inner.operation]
            opposite = next(each for each in INEQUALITIES if RELATIONS[each] == rest)
            yield from _read(replace(inner, operation=opposite), arithmetic)
        case operation if operation in INEQUALITIES:
            yield from _inequality(term, arithmetic)
        case _:
            raise ValueError(f"an assumption must be an inequality such as a > 1, got {term}")


def _inequality(term: Term, arithmetic: Arithmetic) -> Iterator[Constraint]:
    (a, b), (c, d) = (worked_out(argument, arithmetic) for argument in term.arguments)
    signs = RELATIONS[term.operation]
    strict, sense = 0 not in signs, 1 if 1 in signs else -1
    times = arithmetic.times
    above, below = cancelled((sense * (times(a, d) - times(c, b)), times(b, d)))
    if is_constant(below):
        yield Constraint(above if constant(below) > 0 else -above, strict)
        return
    yield Constraint(times(above, below), strict)
    if not strict:
        yield Constraint(times(below, below), True)
