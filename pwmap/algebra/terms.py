"""Formulas and conditions of maps as trees of bounded size; numbers and sympy as such trees."""

from __future__ import annotations

import numbers
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from typing import Any

import sympy
from sympy import QQ
from sympy.logic.boolalg import BooleanAtom

from pwmap.algebra.arguments import shortened, shown

MAX_DEPTH = 100  # of nesting, within the recursion limit of Python
MAX_TERMS = 100_000  # numbers, names and operations of one formula
MAX_DIGITS = 1000  # of an integer in a text
MAX_BITS = 20_000  # of an integer that is computed


class Operation(Enum):
    """The operation of a tree on its arguments; the value is its sign or name."""

    NUMBER = "a rational number"
    NAME = "a name"
    TRUTH = "True or False"
    SUM = "+"
    NEGATIVE = "-"
    PRODUCT = "*"
    INVERSE = "1/"
    POWER = "**"
    ABS = "Abs"
    MAX = "Max"
    MIN = "Min"
    LESS = "<"
    LESS_EQUAL = "<="
    GREATER = ">"
    GREATER_EQUAL = ">="
    EQUAL = "Eq"
    UNEQUAL = "Ne"
    AND = "And"
    OR = "Or"
    NOT = "Not"
    PIECEWISE = "Piecewise"
    PAIR = "a pair (formula, condition)"


# the signs of left side minus right side for which each relation holds
RELATIONS = {
    Operation.LESS: {-1},
    Operation.LESS_EQUAL: {-1, 0},
    Operation.GREATER: {1},
    Operation.GREATER_EQUAL: {0, 1},
    Operation.EQUAL: {0},
    Operation.UNEQUAL: {-1, 1},
}
INEQUALITIES = tuple(RELATIONS)[:4]
CONDITIONS = {*RELATIONS, Operation.TRUTH, Operation.AND, Operation.OR, Operation.NOT}


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """A formula or condition as a tree: an operation and its arguments."""

    operation: Operation
    arguments: tuple[Term, ...] = ()
    value: Any = None  # an element of QQ, a symbol for a name, a bool for a truth value
    source: object = None  # the text or expression that it was read from, for messages

    def __str__(self) -> str:
        """The source on one line; the middle of a long one is left out."""
        return shortened(" ".join(str(self.source).split()))

    def names(self) -> dict[str, sympy.Symbol]:
        """All symbols by :func:`plain_name`; of several, the one with the most assumptions."""
        found = {term.value for term in self.walk() if term.operation is Operation.NAME}
        ordered = sorted(found, key=lambda s: (len(s.assumptions0), s.name))
        return {plain_name(symbol): symbol for symbol in ordered}

    def with_values(self, values: Mapping[str, Term]) -> Term:
        """The tree with other trees substituted for names, by :func:`plain_name`."""
        if self.operation is Operation.NAME:
            return values.get(plain_name(self.value), self)
        return replace(self, arguments=tuple(each.with_values(values) for each in self.arguments))

    def walk(self) -> Iterator[Term]:
        """Yield this tree and all trees inside it, each once."""
        waiting, seen = [self], {id(self)}
        while waiting:
            term = waiting.pop()
            yield term
            for argument in term.arguments:
                if id(argument) not in seen:
                    seen.add(id(argument))
                    waiting.append(argument)


def plain_name(name: object) -> str:
    """A name in Unicode's NFKC form, as in Python: the micro sign is the letter mu."""
    return unicodedata.normalize("NFKC", str(name))


def own_name(name: object, symbols: Iterable[sympy.Symbol]) -> str:
    """The name of the matching one of some symbols, or the name itself if none matches."""
    plain = plain_name(name)
    found = next((str(s) for s in symbols if plain_name(s) == plain), None)
    return found or (name if isinstance(name, str) and name.isidentifier() else shown(name))


def checked_parameter(name: object, symbols: Sequence[sympy.Symbol]) -> str:
    """The name of a parameter of a map; ValueError if it has no such parameter."""
    own, names = own_name(name, symbols), [str(symbol) for symbol in symbols]
    if own not in names:
        raise ValueError(f"{own} is no parameter of this map, it has {names or 'none'}")
    return own


def float_refusal(value: object) -> TypeError:
    """The error for a float, with the rational it probably means if that is short."""
    text = str(value)
    meant = ""
    if len(text) <= 40 and text.lower().lstrip("+-").rstrip("0123456789") in ("inf", "nan"):
        return TypeError(f"{text} is not a rational number")
    mantissa, _, exponent = text.lower().partition("e")
    if len(mantissa) <= 40 and len(exponent) <= 3:
        number = Fraction(text)
        bottom = f"/{number.denominator}" if number.denominator != 1 else ""
        meant = f"{number.numerator}{bottom}" if abs(int(exponent or 0)) <= 40 else ""
    return TypeError(
        f"{shortened(text)} is a float, but the analysis is exact: "
        f"write {f'the rational {meant}' if meant else 'a rational'} instead"
        f"{'' if isinstance(value, str) else ', as text or by sympy.Rational'}"
    )


def term_of_number(value: object) -> Term | None:
    """A truth value or exact number, also of sympy, as a tree, else None; TypeError for a float."""
    if isinstance(value, bool | BooleanAtom):
        return Term(Operation.TRUTH, value=bool(value), source=value)
    if isinstance(value, numbers.Rational | QQ.dtype):
        top, bottom = int(value.numerator), int(value.denominator)
        bits = max(top.bit_length(), bottom.bit_length())
        if bits > MAX_BITS:
            raise ValueError(f"an integer may have {MAX_BITS} bits, this one has {bits}")
        return Term(Operation.NUMBER, value=QQ(top, bottom), source=value)
    if isinstance(value, numbers.Real):
        raise float_refusal(value)
    return None


# --- From sympy -----------------------------------------------------------------------------------

_OPERATIONS: dict[Any, Operation] = {
    sympy.Add: Operation.SUM,
    sympy.Mul: Operation.PRODUCT,
    sympy.Abs: Operation.ABS,
    sympy.Max: Operation.MAX,
    sympy.Min: Operation.MIN,
    sympy.StrictLessThan: Operation.LESS,
    sympy.LessThan: Operation.LESS_EQUAL,
    sympy.StrictGreaterThan: Operation.GREATER,
    sympy.GreaterThan: Operation.GREATER_EQUAL,
    sympy.Equality: Operation.EQUAL,
    sympy.Unequality: Operation.UNEQUAL,
    sympy.And: Operation.AND,
    sympy.Or: Operation.OR,
    sympy.Not: Operation.NOT,
    sympy.Piecewise: Operation.PIECEWISE,
    sympy.functions.elementary.piecewise.ExprCondPair: Operation.PAIR,
}


def term_of_sympy(expr: sympy.Basic) -> Term:
    """A sympy expression as a tree; TypeError for floats, ValueError for unsupported functions."""
    known: dict[int, Term] = {}  # by id, as comparing expressions is slow

    def read(part: sympy.Basic, depth: int) -> Term:
        if id(part) not in known:
            if depth > MAX_DEPTH:
                raise ValueError(f"an expression is nested more than {MAX_DEPTH} deep")
            if len(known) > MAX_TERMS:
                raise ValueError(f"an expression has more than {MAX_TERMS} parts")
            # the term refers to the part, so that its id is not reused
            known[id(part)] = _leaf(part) or Term(
                _operation(part), tuple(read(a, depth + 1) for a in part.args), source=part
            )
        return known[id(part)]

    return read(expr, 0)


def _leaf(expr: sympy.Basic) -> Term | None:
    if isinstance(expr, sympy.Symbol):
        return Term(Operation.NAME, value=expr, source=expr)
    return term_of_number(expr)


def _operation(expr: sympy.Basic) -> Operation:
    if isinstance(expr, sympy.Pow) and isinstance(expr.exp, sympy.Integer):
        return Operation.POWER
    if expr.func not in _OPERATIONS:
        raise ValueError(
            "a formula must be polynomial in the parameters over the rationals, "
            f"got {shortened(str(expr))}"
        )
    return _OPERATIONS[expr.func]
