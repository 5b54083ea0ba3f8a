"""What is assumed of the parameters, and the signs that follow from it.

Assumptions are polynomial inequalities. The sign of a polynomial is *proved* over all values they
admit, or reported as undecided: a sample decides nothing by itself. The proof eliminates one
parameter after the other. In one parameter it is complete (real roots cut the line). In several it
uses that a polynomial of degree one in a parameter takes its extreme values at the bounds of that
parameter; it never claims too much, but may miss a sign that needs more than that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product
from typing import Any, NamedTuple

import sympy
from sympy import QQ
from sympy.core.relational import Relational
from sympy.polys.rings import PolyElement

from pwmap.arithmetic import Arithmetic, Budget, worked_out
from pwmap.exact import (
    Number,
    Packed,
    Ring,
    cancelled,
    constant,
    dense,
    evaluate,
    is_constant,
    packed,
    polynomial_ring,
    sign,
    to_sympy,
    unpacked,
)
from pwmap.roots import Dense, gaps_and_roots, inside, real_roots, sign_at
from pwmap.terms import Operation, Term, shortened

_OPPOSITES = {
    Operation.LESS: Operation.GREATER_EQUAL,
    Operation.LESS_EQUAL: Operation.GREATER,
    Operation.GREATER: Operation.LESS_EQUAL,
    Operation.GREATER_EQUAL: Operation.LESS,
}
Signs = frozenset[int]
ANY: Signs = frozenset((-1, 0, 1))


class UndecidedError(ValueError):
    """A sign that the assumptions leave open."""


class Constraint(NamedTuple):
    """A polynomial that is positive (strict) or not negative."""

    polynomial: PolyElement
    strict: bool

    def holds(self, number_sign: int) -> bool:
        """Whether a sign of the polynomial is admitted."""
        return number_sign > 0 or (number_sign == 0 and not self.strict)

    @property
    def signs(self) -> Signs:
        """The admitted signs of the polynomial."""
        return frozenset((1,)) if self.strict else frozenset((0, 1))

    def __str__(self) -> str:
        """As an inequality."""
        return shortened(str(self.relation()))

    def relation(self) -> Relational:
        """As a sympy relation."""
        constant_, rest = sympy.factor(to_sympy(self.polynomial)).as_coeff_Add()
        if rest.could_extract_minus_sign():
            return (sympy.Lt if self.strict else sympy.Le)(-rest, constant_, evaluate=False)
        return (sympy.Gt if self.strict else sympy.Ge)(rest, -constant_, evaluate=False)


@dataclass(frozen=True)
class Region:
    """All parameter values that satisfy some inequalities.

    Parameters
    ----------
    ring
        The polynomial ring over all parameters, or None for no parameters.
    constraints
        The inequalities, in the ring.
    """

    ring: Ring
    constraints: tuple[Constraint, ...] = ()

    def __reduce__(self) -> tuple[Callable[..., Region], tuple[object, ...]]:
        kept = packed(self.ring, [constraint.polynomial for constraint in self.constraints])
        return _region, (kept, tuple(constraint.strict for constraint in self.constraints))

    @cached_property
    def sample(self) -> dict[str, Number]:
        """Values that satisfy all inequalities, by name.

        Raises
        ------
        ValueError
            If none were found.
        """
        found = next(self.samples(), None)
        if found is None:
            raise ValueError(f"no values of the parameters with {self} were found")
        return found

    def samples(self) -> Iterator[dict[str, Number]]:
        """Different values that satisfy all inequalities, one parameter after the other."""
        if self.ring is None:
            yield {}
            return
        yield from self._extended({}, [str(symbol) for symbol in self.ring.symbols])

    def _extended(self, values: dict[str, Number], names: list[str]) -> Iterator[dict[str, Number]]:
        if not names:
            yield values
            return
        name, *others = names
        assert self.ring is not None
        ring = polynomial_ring([self.ring.symbols[_index(self.ring, name)]])
        limits: list[Constraint] = []
        for constraint in self.constraints:
            if names_in(constraint.polynomial) <= {*values, name}:
                left = _with_values(constraint.polynomial, values, ring)
                if is_constant(left):
                    if not constraint.holds(sign(constant(left))):
                        return
                    continue
                limits.append(Constraint(left, constraint.strict))
        for value in _candidates(limits):
            yield from self._extended({**values, name: value}, others)

    def sign(self, polynomial: Number) -> int:
        """The one sign of a polynomial over the region.

        Raises
        ------
        UndecidedError
            If it is not proved to have one.
        """
        if is_constant(polynomial):
            return sign(constant(polynomial))
        found = possible_signs(polynomial, self.constraints)
        if len(found) != 1:
            raise UndecidedError(
                f"the sign of {shortened(str(sympy.factor(to_sympy(polynomial))))} "
                f"does not follow from {self}: "
                "assume more (given=[...]) or give a parameter a value (.at)"
            )
        return next(iter(found))

    def contains(self, values: Mapping[str, Number]) -> Constraint | None:
        """The first inequality that some values, given for all its parameters, break."""
        for constraint in self.constraints:
            if names_in(constraint.polynomial) <= set(values):
                value = evaluate(constraint.polynomial, values, None)
                if not constraint.holds(sign(value)):
                    return constraint
        return None

    def relations(self) -> tuple[Relational, ...]:
        """The inequalities as sympy relations."""
        return tuple(constraint.relation() for constraint in self.constraints)

    def __str__(self) -> str:
        """The inequalities, or "no assumption"; its middle left out if it is long."""
        return shortened(", ".join(str(r) for r in self.relations())) or "no assumption"


def _region(kept: Packed, strict: tuple[bool, ...]) -> Region:
    ring, polynomials = unpacked(kept)
    return Region(ring, tuple(map(Constraint, polynomials, strict)))


def read_constraints(given: Iterable[Term], ring: Ring) -> tuple[Constraint, ...]:
    """Inequalities from relations and conjunctions of them, and from what symbols assume.

    Raises
    ------
    ValueError
        If one is no inequality between quotients of polynomials in the parameters.
    """
    found: list[Constraint] = []
    symbols = ring.symbols if ring is not None else ()
    for symbol in symbols:
        for property_, text in (("positive", ">"), ("negative", "<"),
                                ("nonnegative", ">="), ("nonpositive", "<=")):  # fmt: skip
            if getattr(symbol, f"is_{property_}") and not (
                text.endswith("=") and symbol.is_nonzero
            ):
                sense = 1 if ">" in text else -1
                generator = ring.gens[symbols.index(symbol)]
                found.append(Constraint(sense * generator, "=" not in text))
    for condition in given:
        found.extend(_read(condition, Arithmetic(ring, Budget())))
    return tuple(dict.fromkeys(found))


def _read(term: Term, arithmetic: Arithmetic) -> Iterator[Constraint]:
    match term.operation:
        case Operation.AND:
            for argument in term.arguments:
                yield from _read(argument, arithmetic)
        case Operation.TRUTH if term.value:
            return
        case Operation.NOT if term.arguments[0].operation in _OPPOSITES:
            inner = term.arguments[0]
            yield from _read(replace(inner, operation=_OPPOSITES[inner.operation]), arithmetic)
        case Operation.LESS | Operation.LESS_EQUAL | Operation.GREATER | Operation.GREATER_EQUAL:
            yield from _inequality(term, arithmetic)
        case _:
            raise ValueError(f"an assumption must be an inequality such as a > 1, got {term}")


def _inequality(term: Term, arithmetic: Arithmetic) -> Iterator[Constraint]:
    (a, b), (c, d) = (worked_out(argument, arithmetic) for argument in term.arguments)
    strict = term.operation in (Operation.GREATER, Operation.LESS)
    sense = 1 if term.operation in (Operation.GREATER, Operation.GREATER_EQUAL) else -1
    times = arithmetic.times
    above, below = cancelled((sense * (times(a, d) - times(c, b)), times(b, d)))
    yield Constraint(times(above, below), strict)
    if not is_constant(below) and not strict:
        yield Constraint(times(below, below), True)


# --- Possible signs -------------------------------------------------------------------------------


def possible_signs(polynomial: PolyElement, constraints: tuple[Constraint, ...]) -> Signs:
    """A set that holds every sign the polynomial takes where the constraints hold."""
    if is_constant(polynomial):
        return frozenset((sign(constant(polynomial)),))
    unit, factors = _factors(polynomial)
    signs: Signs = frozenset((sign(unit),))
    for factor, exponent in factors:
        possible = _signs_of_factor(factor, constraints)
        if exponent % 2 == 0:
            possible = frozenset(abs(s) for s in possible)
        signs = frozenset(a * b for a in signs for b in possible)
    return signs


def _signs_of_factor(factor: PolyElement, constraints: tuple[Constraint, ...]) -> Signs:
    signs = ANY
    for constraint in constraints:
        scale = _proportion(constraint.polynomial, factor)
        if scale:
            signs &= frozenset(scale * s for s in constraint.signs)
    names = names_in(factor)
    if len(names) == 1:
        return signs & _univariate_signs(factor, constraints, next(iter(names)))
    for name in sorted(names):
        if len(signs) > 1 and _degree(factor, name) == 1:
            signs &= _signs_by_elimination(factor, constraints, name)
    return signs


def _univariate_signs(factor: PolyElement, constraints: tuple[Constraint, ...], name: str) -> Signs:
    """Complete: try each gap between the real roots of all polynomials in this parameter."""
    limits = [c for c in constraints if names_in(c.polynomial) == {name}]
    polynomials = [_dense(factor, name), *(_dense(c.polynomial, name) for c in limits)]
    found = set()
    for piece in gaps_and_roots(sorted({x for p in polynomials for x in real_roots(p)})):
        signs = [sign_at(p, inside(piece)) for p in polynomials]
        if all(c.holds(s) for c, s in zip(limits, signs[1:], strict=True)):
            found.add(signs[0])
    return frozenset(found)


def _signs_by_elimination(
    factor: PolyElement, constraints: tuple[Constraint, ...], name: str
) -> Signs:
    """Bound a polynomial that is affine in one parameter by its values at that one's bounds."""
    others = tuple(c for c in constraints if name not in names_in(c.polynomial))
    lower: list[tuple[Signs, bool]] = []
    upper: list[tuple[Signs, bool]] = []
    slope, rest = _affine(factor, name)
    for constraint in constraints:
        if _degree(constraint.polynomial, name) != 1:
            continue
        gain, shift = _affine(constraint.polynomial, name)
        side = possible_signs(gain, others)
        if side not in (frozenset((1,)), frozenset((-1,))):
            continue
        # at the bound, name = -shift/gain: the factor is (rest gain - slope shift)/gain
        (sense,) = side
        values = possible_signs(rest * gain - slope * shift, others)
        bound = frozenset(sense * s for s in values), not constraint.strict
        (lower if sense > 0 else upper).append(bound)
    slopes, rests = possible_signs(slope, others), possible_signs(rest, others)
    for ends, direction in ((lower, -1), (upper, 1)):
        if not ends:  # an infinite end
            infinite = {direction * s for s in slopes if s} | (rests if 0 in slopes else set())
            ends.append((frozenset(infinite), False))
    signs = ANY
    for (low, low_closed), (high, high_closed) in product(lower, upper):
        found = {s for a, b in product(low, high) for s in _between(a, b)}
        signs &= found | (low if low_closed else set()) | (high if high_closed else set())
    return signs


def _between(low: int, high: int) -> Signs:
    """Signs of an affine function strictly between two ends."""
    if low * high < 0:
        return ANY
    return frozenset((low or high,))


# --- Polynomials ----------------------------------------------------------------------------------


@cache
def _factors(polynomial: PolyElement) -> tuple[Number, list[tuple[PolyElement, int]]]:
    shared = [min(exponents) for exponents in zip(*polynomial.monoms(), strict=True)]
    rest = polynomial.quo(polynomial.ring.term_new(tuple(shared), QQ.one))
    powers = [(g, e) for g, e in zip(polynomial.ring.gens, shared, strict=True) if e]
    if rest.is_ground:
        return constant(rest), powers
    if all(sum(exponents) <= 1 for exponents in rest.monoms()):  # it has no factors
        return QQ.one, [*powers, (rest, 1)]
    unit, factors = rest.factor_list()
    return unit, [*powers, *factors]


def _proportion(polynomial: PolyElement, factor: PolyElement) -> int:
    """Sign of the constant c with polynomial = c factor, or 0 if there is none."""
    scale = polynomial.LC / factor.LC
    return sign(scale) if polynomial == scale * factor else 0


@cache
def names_in(polynomial: PolyElement) -> set[str]:
    """The parameters that occur in a polynomial."""
    symbols = polynomial.ring.symbols
    used = [max(exponents) for exponents in zip(*polynomial.monoms(), strict=True)]
    return {str(symbol) for symbol, degree in zip(symbols, used, strict=False) if degree}


def _degree(polynomial: PolyElement, name: str) -> int:
    return int(polynomial.degree(_index(polynomial.ring, name)))


def _index(ring: Ring, name: str) -> int:
    return [str(symbol) for symbol in ring.symbols].index(name)


def _affine(polynomial: PolyElement, name: str) -> tuple[PolyElement, PolyElement]:
    """Coefficients of a polynomial that is affine in one parameter: slope and rest."""
    index = _index(polynomial.ring, name)
    return polynomial.diff(index), polynomial.subs(index, 0)


def _dense(polynomial: PolyElement, name: str) -> Dense:
    return dense(polynomial, _index(polynomial.ring, name))


def _with_values(polynomial: PolyElement, values: Mapping[str, Number], ring: Ring) -> Number:
    """A polynomial in the one generator of ``ring``, after values are put for the others."""
    kept = str(ring.symbols[0])
    zeros = {str(s): QQ.zero for s in polynomial.ring.symbols if str(s) != kept}
    return evaluate(polynomial, {**zeros, **values}, ring)


def _candidates(limits: list[Constraint]) -> Iterator[Number]:
    """Rational values of the one parameter of some constraints that satisfy them all."""
    polynomials = [_dense(c.polynomial, _only_name(c.polynomial)) for c in limits]
    roots = sorted({x for p in polynomials for x in real_roots(p)})
    pieces = gaps_and_roots(roots)
    for piece in sorted(pieces, key=lambda p: p[0] is not None and p[0] is p[1]):  # gaps first
        low, high = piece
        tries: list[Any] = [inside(piece)]
        if low is None or low is not high:  # more values of a gap, towards both ends
            for _ in range(3):
                tries += [inside((low, tries[0])), inside((tries[-1], high))]
            first, last = min(tries), max(tries)  # and some that are hardly special to any map
            tries += [first + (last - first) * QQ(k, 17) for k in (5, 11, 3, 14, 8, 2, 13)]
        for x in dict.fromkeys(tries):
            admitted = all(c.holds(sign_at(p, x)) for c, p in zip(limits, polynomials, strict=True))
            if admitted and isinstance(x, QQ.dtype):
                yield x


def _only_name(polynomial: PolyElement) -> str:
    (name,) = names_in(polynomial)
    return name
