"""Reading formulas and conditions into the table of a map; each error names the piece."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from string import ascii_uppercase

import sympy
from sympy import QQ

from pwmap.algebra.arguments import is_several, shown
from pwmap.algebra.arithmetic import MAX_PARAMETERS, Arithmetic, NotPolynomialError, Quotient
from pwmap.algebra.assumptions import AssumedRegion, UndecidedError, read_constraints
from pwmap.algebra.exact import (
    Affine,
    Fraction_,
    Number,
    Ring,
    cancelled,
    constant,
    evaluate,
    is_constant,
    polynomial_ring,
    to_sympy,
)
from pwmap.algebra.inequalities import variables
from pwmap.algebra.parsing import check_meaning, checked_name, term_of
from pwmap.algebra.terms import Operation, Term, plain_name
from pwmap.maps.profiles import Profile, ProfileLine, slot_name
from pwmap.maps.words import Layout, Table

NOT_AFFINE = "the piece {} is not affine in {}; woodpecker.from_sympy takes maps with curved pieces"


@dataclass(frozen=True, slots=True)
class Definition:
    """A map as it was written: its variable, parameters, assumptions and coefficients."""

    x: sympy.Symbol
    region: AssumedRegion
    table: Table
    letters: tuple[str, ...]

    @property
    def ring(self) -> Ring:
        """The ring of polynomials in its parameters."""
        return self.region.ring

    @property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """The parameters that have no value yet."""
        return tuple(self.ring.symbols) if self.ring is not None else ()


def read(
    pieces: Sequence[tuple[object, object]],
    x: object,
    given: Iterable[object],
    letters: Sequence[str] | None,
) -> Definition:
    """Read pieces (formula, condition), exactly one of which must hold at each point.

    ValueError or TypeError names the piece and what is wrong with it.
    """
    variable = _symbol(x)
    if not is_several(pieces):
        what = f"pieces must be pairs (formula, condition), got {shown(pieces)}"
        raise TypeError(f"{what}; one formula is read by from_sympy")
    pieces = list(pieces)
    for piece in pieces:
        if not isinstance(piece, Sequence) or not is_several(piece) or len(piece) != 2:
            raise ValueError(f"each piece must be a pair (formula, condition), got {shown(piece)}")
    if not pieces:
        raise ValueError("a map needs at least one piece")
    pairs = [(term_of(f, [variable]), term_of(c, [variable])) for f, c in pieces]
    return _read(pairs, variable, given, letters, first_wins=False)


def read_formula(
    formula: object, x: object, given: Iterable[object], letters: Sequence[str] | None
) -> Definition:
    """Read one formula; in a Piecewise the first condition that holds counts; see :func:`read`."""
    variable = _symbol(x)
    term = term_of(formula, [variable])
    pairs = [(term, Term(Operation.TRUTH, value=True, source=True))]
    if term.operation is Operation.PIECEWISE:
        pairs = [(pair.arguments[0], pair.arguments[1]) for pair in term.arguments]
    return _read(pairs, variable, given, letters, first_wins=True)


def _read(
    pairs: Sequence[tuple[Term, Term]],
    x: sympy.Symbol,
    given: Iterable[object],
    letters: Sequence[str] | None,
    *,
    first_wins: bool,
) -> Definition:
    if isinstance(given, str | sympy.Basic):
        given = [given]
    elif not is_several(given):
        raise TypeError(f"given must be inequalities such as ['a > 1'], got {shown(given)}")
    assumed = [term_of(condition, [x]) for condition in given]
    region = _region([term for pair in pairs for term in pair], assumed, x)
    line = ProfileLine(x, region, Arithmetic(region.ring))
    conditions = [line.condition(condition) for _, condition in pairs]
    formulas = [_formula(formula, line) for formula, _ in pairs]
    breaks = line.union([*conditions, *formulas])
    holds = [line.spread(condition, breaks) for condition in conditions]
    values = [line.spread(formula, breaks) for formula in formulas]
    owners, affine = list[int](), list[Affine]()
    for slot in range(2 * len(breaks) + 1):
        name = partial(slot_name, slot, breaks, x)
        holding = [i for i in range(len(pairs)) if holds[i][slot]]
        if not holding:
            raise ValueError(f"there is a gap: no piece covers {name()}")
        if len(holding) > 1 and not first_wins:
            first, second = (i + 1 for i in holding[:2])
            raise ValueError(f"pieces {first} and {second} overlap: both cover {name()}")
        owners.append(holding[0])
        affine.append(_affine(values[holding[0]][slot], pairs[holding[0]][0], name, x))
    _join_points(breaks, owners, affine)
    return _assembled(x, region, breaks, list(zip(owners, affine, strict=True)), letters)


def _formula(term: Term, line: ProfileLine) -> Profile:
    try:
        return line.formula(term)
    except NotPolynomialError:
        raise ValueError(NOT_AFFINE.format(term, line.x)) from None


def _region(terms: Sequence[Term], assumed: Sequence[Term], x: sympy.Symbol) -> AssumedRegion:
    """The region that the assumptions leave to the parameters of some trees."""
    used = set().union(*(term.names() for term in terms)) - {plain_name(x)}
    chosen = Term(Operation.PAIR, (*terms, *assumed)).names()
    for condition in assumed:
        if plain_name(x) in condition.names():
            raise ValueError(f"the assumption {condition} holds {x}, the variable of the map")
    for name in (plain_name(x), *chosen):
        check_meaning(name)
    if len(chosen) > MAX_PARAMETERS:
        raise ValueError(f"a map may have {MAX_PARAMETERS} parameters, this one has more")
    named = set().union(*(condition.names() for condition in assumed))
    every = polynomial_ring(sorted((chosen[name] for name in used | named), key=str))
    whole = AssumedRegion(every, read_constraints(assumed, every))
    _ = whole.sample  # raises if the assumptions contradict each other
    ring = polynomial_ring(sorted((chosen[name] for name in used), key=str))
    if ring == every:
        return whole
    absent = {str(chosen[name]): QQ.zero for name in named - used}
    places = {i for i, symbol in enumerate(every.symbols) if str(symbol) in absent}
    kept = [c for c in whole.constraints if not variables(c.polynomial) & places]
    return AssumedRegion(every, tuple(kept)).moved(ring, lambda p: evaluate(p, absent))


def _affine(
    value: Quotient | None, formula: Term, slot: Callable[[], str], x: sympy.Symbol
) -> Affine:
    if value is None:
        raise ValueError(f"there is a gap: no piece of {formula} covers {slot()}")
    if len(value.top) > 2:
        raise ValueError(NOT_AFFINE.format(formula, x))
    zero = value.bottom - value.bottom
    intercept, slope = (*value.top, zero, zero)[:2]
    return Affine(cancelled((slope, value.bottom)), cancelled((intercept, value.bottom)))


def _join_points(breaks: Sequence[Fraction_], owners: Sequence[int], affine: list[Affine]) -> None:
    """Give a break the formula beside it if that is of the same piece and agrees there."""
    for i, b in enumerate(breaks):
        slot = 2 * i + 1
        for beside in (slot + 1, slot - 1):
            if (
                owners[beside] == owners[slot]
                and affine[slot] not in (affine[slot - 1], affine[slot + 1])
                and _value(affine[slot], b) == _value(affine[beside], b)
            ):
                affine[slot] = affine[beside]


def _assembled(
    x: sympy.Symbol,
    region: AssumedRegion,
    breaks: Sequence[Fraction_],
    slots: Sequence[tuple[int, Affine]],
    letters: Sequence[str] | None,
) -> Definition:
    """Give each maximal run of slots with one owner a letter; drop breaks inside a run."""
    runs = [(affine, len(list(group))) for (_, affine), group in groupby(slots)]
    letter_of_slot = [i for i, (_, length) in enumerate(runs) for _ in range(length)]
    kept = [k for k in range(len(breaks)) if len(set(letter_of_slot[2 * k : 2 * k + 3])) > 1]
    layout = Layout(
        tuple(range(len(kept))),
        (letter_of_slot[0], *(letter_of_slot[2 * k + i] for k in kept for i in (1, 2))),
    )
    one = region.ring.one if region.ring is not None else QQ.one
    slopes, intercepts = zip(*(affine for affine, _ in runs), strict=True)
    kept_breaks = [breaks[k] for k in kept]
    denominator = _denominator((*slopes, *intercepts, *kept_breaks), region, one)

    def numerators(fractions: Iterable[Fraction_]) -> tuple[Number, ...]:
        return tuple(
            top * one / constant(bottom) * denominator
            if is_constant(bottom)
            else top * denominator.quo(bottom)
            for top, bottom in fractions
        )

    table = Table(
        numerators(slopes),
        numerators(intercepts),
        numerators(kept_breaks),
        (layout,),
        one,
        denominator,
    )
    return Definition(x, region, table, _letters(letters, len(runs)))


def _value(affine: Affine, x: Fraction_) -> Fraction_:
    (m, n), (c, d) = affine
    return cancelled((m * x[0] * d + c * n * x[1], n * d * x[1]))


def _denominator(fractions: Iterable[Fraction_], region: AssumedRegion, one: Number) -> Number:
    """A positive common multiple of denominators; UndecidedError if the sign of one is open."""
    common = one
    for _, bottom in fractions:
        if not is_constant(bottom) and bottom != common:
            common = bottom if is_constant(common) else common.lcm(bottom)
    try:
        sense = region.sign(common)
    except UndecidedError as error:
        sentence = f"a denominator must have a sign, but {error}"
        raise UndecidedError(sentence, error.polynomial) from None
    if sense == 0:
        raise ValueError(f"the denominator {to_sympy(common)} is zero under {region}")
    return sense * common


def _symbol(x: object) -> sympy.Symbol:
    if isinstance(x, sympy.Symbol):
        return x
    if not isinstance(x, str):
        raise ValueError(f"the variable must be a symbol such as x, got {shown(x)}")
    try:
        return sympy.Symbol(checked_name(x))
    except ValueError as error:
        raise ValueError(f"the variable must be a symbol such as x: {error}") from None


def _letters(letters: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """Names of the pieces: L R, L M R, otherwise A B C ..., or the given ones."""
    if letters is None:
        standard = {1: "A", 2: "LR", 3: "LMR"}.get(n, ascii_uppercase[:n])
        letters = standard + "".join(chr(0x100 + i) for i in range(n - len(standard)))
    if not isinstance(letters, Sequence) or not all(isinstance(each, str) for each in letters):
        raise TypeError(f"expected {n} different letters, one for each piece, got {shown(letters)}")
    if len(letters) != n or len(set(letters)) != n or any(len(letter) != 1 for letter in letters):
        raise ValueError(f"expected {n} different letters, one for each piece, got {letters!r}")
    return tuple(letters)
