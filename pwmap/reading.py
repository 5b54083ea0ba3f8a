"""From formulas and conditions to the table of a map, with every fault named."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import groupby, pairwise
from string import ascii_uppercase

import sympy
from sympy import QQ
from sympy.core.relational import Relational

from pwmap.assumptions import Region, UndecidedError, read_constraints
from pwmap.exact import Number, Ring, element, expression, polynomial_ring
from pwmap.itineraries import Layout, Table


@dataclass(frozen=True, slots=True)
class Model:
    """A map as it was written: its variable, parameters, assumptions and coefficients."""

    x: sympy.Symbol
    ring: Ring
    region: Region
    table: Table
    letters: tuple[str, ...]

    def __reduce__(self) -> tuple[Callable[..., Model], tuple[object, ...]]:
        return _model, (self.x, self.region, self.table, self.letters)


def _model(x: sympy.Symbol, region: Region, table: Table, letters: tuple[str, ...]) -> Model:
    return Model(x, region.ring, region, table, letters)


def read(
    pieces: Sequence[tuple[object, object]],
    x: object,
    given: Iterable[object],
    letters: Sequence[str] | None,
    *,
    first_wins: bool,
) -> Model:
    """Read pieces (formula, condition), as in ``sympy.Piecewise``.

    With ``first_wins`` the first condition that holds counts, otherwise exactly one must hold.

    Raises
    ------
    ValueError, TypeError
        One sentence that names the piece and what is wrong with it.
    """
    variable = _symbol(x)
    for piece in pieces:
        if not isinstance(piece, Sequence) or isinstance(piece, str) or len(piece) != 2:
            raise ValueError(f"each piece must be a pair (formula, condition), got {piece!r}")
    if not pieces:
        raise ValueError("a map needs at least one piece")
    given = [given] if isinstance(given, str | sympy.Basic) else list(given)
    read_in = [expression(part, [variable]) for part in (*sum(map(tuple, pieces), ()), *given)]
    unified = _unified(read_in, variable)
    formulas, conditions = unified[: 2 * len(pieces) : 2], unified[1 : 2 * len(pieces) : 2]
    given = unified[2 * len(pieces) :]
    used = set().union(*(e.free_symbols for e in [*formulas, *conditions])) - {variable}
    ring = polynomial_ring(sorted(used, key=str))
    region = Region(ring, read_constraints(given, ring))
    _ = region.sample  # complains if the assumptions contradict each other
    affine = [_affine(formula, variable, ring) for formula in formulas]
    relations = sorted(set().union(*(c.atoms(Relational) for c in conditions)), key=str)
    sides = {relation: _side(relation, variable, ring) for relation in relations}
    breaks = _sorted_breaks({value for value, _ in sides.values()}, region, variable)

    def holding(slot: int) -> list[int]:
        """Which conditions hold on a slot."""
        truth = {
            relation: _truth(relation, sense * (slot - 2 * breaks.index(value) - 1))
            for relation, (value, sense) in sides.items()
        }
        return [i for i, c in enumerate(conditions) if c.xreplace(truth) == sympy.true]

    owner = _first if first_wins else _only
    slots = [
        owner(holding(slot), _slot_name(slot, breaks, variable))
        for slot in range(2 * len(breaks) + 1)
    ]
    return _assembled(variable, region, breaks, slots, affine, letters)


def _assembled(
    x: sympy.Symbol,
    region: Region,
    breaks: Sequence[Number],
    slots: Sequence[int],
    affine: Sequence[tuple[Number, Number]],
    letters: Sequence[str] | None,
) -> Model:
    """Give each maximal run of slots with one owner a letter; drop breaks inside a run."""
    runs = [(owner, len(list(group))) for owner, group in groupby(slots)]
    letter_of_slot = [i for i, (_, length) in enumerate(runs) for _ in range(length)]
    kept = [k for k in range(len(breaks)) if len(set(letter_of_slot[2 * k : 2 * k + 3])) > 1]
    layout = Layout(
        tuple(range(len(kept))),
        (letter_of_slot[0], *(letter_of_slot[2 * k + i] for k in kept for i in (1, 2))),
    )
    one = region.ring.one if region.ring is not None else QQ.one
    table = Table(
        tuple(affine[owner][0] for owner, _ in runs),
        tuple(affine[owner][1] for owner, _ in runs),
        tuple(breaks[k] for k in kept),
        (layout,),
        one,
    )
    return Model(x, region.ring, region, table, _letters(letters, len(runs)))


def _symbol(x: object) -> sympy.Symbol:
    symbol = sympy.Symbol(x) if isinstance(x, str) and x.isidentifier() else x
    if not isinstance(symbol, sympy.Symbol):
        raise ValueError(f"the variable must be a symbol such as x, got {x}")
    return symbol


def _unified(expressions: Sequence[sympy.Basic], x: sympy.Symbol) -> list[sympy.Basic]:
    """One symbol for each name: the variable, or the one of which most is assumed."""
    symbols = sorted(set().union(*(e.free_symbols for e in expressions)), key=_assumed)
    chosen = {symbol.name: symbol for symbol in symbols} | {x.name: x}
    return [e.xreplace({s: chosen[s.name] for s in e.free_symbols}) for e in expressions]


def _assumed(symbol: sympy.Symbol) -> tuple[int, str]:
    return len(symbol.assumptions0), str(symbol)


def _affine(formula: sympy.Basic, x: sympy.Symbol, ring: Ring) -> tuple[Number, Number]:
    """Slope and intercept of a formula."""
    polynomial = formula.as_poly(x) if isinstance(formula, sympy.Expr) else None
    if polynomial is None or polynomial.degree() > 1 or x in polynomial.free_symbols_in_domain:
        raise ValueError(f"the piece {formula} is not affine in {x}")
    what = f"the coefficients of the piece {formula}:"
    slope, intercept = polynomial.coeff_monomial(x), polynomial.coeff_monomial(1)
    return element(ring, slope, what), element(ring, intercept, what)


def _side(relation: Relational, x: sympy.Symbol, ring: Ring) -> tuple[Number, int]:
    """The break that a relation compares x with, and +1, or -1 if x is on its right side."""
    if x not in relation.free_symbols:
        raise ValueError(
            f"the condition {relation} does not contain {x}: put it among the assumptions (given)"
        )
    difference = sympy.expand(relation.lhs - relation.rhs)
    polynomial = difference.as_poly(x)
    slope = polynomial.coeff_monomial(x) if polynomial is not None else sympy.nan
    if polynomial is None or polynomial.degree() != 1 or not slope.is_Rational:
        raise ValueError(
            f"the condition {relation} must compare {x} with a polynomial in the parameters"
        )
    value = -polynomial.coeff_monomial(1) / slope
    return element(ring, value, "a break"), 1 if slope > 0 else -1


def _truth(relation: Relational, order: int) -> sympy.Basic:
    """Whether a relation holds if its left side minus its right side has a sign."""
    holds = {
        sympy.Eq: order == 0,
        sympy.Ne: order != 0,
        sympy.Lt: order < 0,
        sympy.Le: order <= 0,
        sympy.Gt: order > 0,
        sympy.Ge: order >= 0,
    }[relation.func]
    return sympy.true if holds else sympy.false


def _sorted_breaks(values: set[Number], region: Region, x: sympy.Symbol) -> list[Number]:
    def order(left: Number, right: Number) -> int:
        try:
            return region.sign(left - right)
        except UndecidedError as error:
            raise UndecidedError(f"the breaks of {x} have no certain order: {error}") from None

    listed = sorted(values, key=str)
    breaks = sorted(listed, key=cmp_to_key(order))
    for left, right in pairwise(breaks):
        if order(left, right) == 0:
            raise ValueError(f"the breaks {left} and {right} coincide under {region}")
    return breaks


def _first(holding: Sequence[int], slot: str) -> int:
    if not holding:
        raise ValueError(f"there is a gap: no piece covers {slot}")
    return holding[0]


def _only(holding: Sequence[int], slot: str) -> int:
    if len(holding) > 1:
        first, second = (i + 1 for i in holding[:2])
        raise ValueError(f"pieces {first} and {second} overlap: both cover {slot}")
    return _first(holding, slot)


def _slot_name(slot: int, breaks: Sequence[Number], x: sympy.Symbol) -> str:
    if slot % 2:
        return f"{x} = {breaks[slot // 2]}"
    left = f"{breaks[slot // 2 - 1]} < " if slot else ""
    right = f" < {breaks[slot // 2]}" if slot < 2 * len(breaks) else ""
    return f"{left}{x}{right}" if left or right else "the line"


def _letters(letters: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """Names of the pieces: L R, L M R, otherwise A B C ..., or the given ones."""
    if letters is None:
        standard = {1: "A", 2: "LR", 3: "LMR"}.get(n, ascii_uppercase[:n])
        letters = standard + "".join(chr(0x100 + i) for i in range(n - len(standard)))
    if len(letters) != n or len(set(letters)) != n or any(len(letter) != 1 for letter in letters):
        raise ValueError(f"expected {n} different letters, one for each piece, got {letters!r}")
    return tuple(letters)
