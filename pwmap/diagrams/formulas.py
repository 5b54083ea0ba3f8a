"""Exact numbers, formulas and sets of sympy as plain data of JSON, and back, without ``eval``.

A rational or an infinity is text such as ``"5/4"``; all else is a list that begins with a name:
``["Add", ["Symbol", "r"], "-2"]``, ``["CRootOf", ["1", "0", "-2"], ["Symbol", "t"], 1]`` with
coefficients, ``["RealRootOf", polynomial, ["Symbol", "b"], 0]``. Nothing is evaluated or sorted.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from pwmap.algebra.rootfunctions import RealRootOf

NUMBERS = {"oo": sympy.oo, "-oo": -sympy.oo, "nan": sympy.nan, "zoo": sympy.zoo}
OPERATIONS = {"Add": sympy.Add, "Mul": sympy.Mul, "Pow": sympy.Pow}
BITS = 3.3  # of a digit
LONGEST = 4096  # bits of a number that is written in decimals
SETS = {"FiniteSet": sympy.FiniteSet, "Union": sympy.Union}


def to_plain(value: sympy.Basic) -> Any:
    """A number, formula or set as nested lists and text; TypeError for any other kind."""
    match value:
        case sympy.Rational():
            top, bottom = _text(int(value.p)), _text(int(value.q))
            return top if bottom == "1" else f"{top}/{bottom}"
        case sympy.Symbol() if type(value) is sympy.Symbol:
            known = {k: v for k, v in value.assumptions0.items() if (k, v) != ("commutative", True)}
            return ["Symbol", value.name, *([known] if known else [])]
        case sympy.CRootOf():
            coefficients = [to_plain(c) for c in value.poly.all_coeffs()]
            return ["CRootOf", coefficients, to_plain(value.poly.gen), int(value.index)]
        case RealRootOf():
            polynomial, symbol, number = value.args
            return ["RealRootOf", to_plain(polynomial), to_plain(symbol), int(number)]
        case sympy.Interval():
            ends = [to_plain(value.start), to_plain(value.end)]
            return ["Interval", *ends, bool(value.left_open), bool(value.right_open)]
    for name, number in NUMBERS.items():
        if value is number:
            return name
    for name, kind in (OPERATIONS | SETS).items():
        if isinstance(value, kind):
            return [name, *map(to_plain, value.args)]
    raise TypeError(f"expected an algebraic formula or a set of such, got {value!r}")


@lru_cache(maxsize=65536, typed=True)
def text_of(value: object) -> str:
    """An exact value as text, cached: the files of a diagram hold each several times."""
    return str(value)


def from_plain(data: Any) -> Any:
    """The inverse of :func:`to_plain`; ValueError, TypeError or LookupError for other data."""
    if isinstance(data, str):
        return NUMBERS[data] if data in NUMBERS else _rational(data)
    name, *parts = data
    if name == "Symbol":
        return _symbol(*parts)
    if name == "CRootOf":
        coefficients, symbol, index = parts
        if not isinstance(coefficients, list):
            raise TypeError(f"expected a list of coefficients, got {coefficients!r}")
        if symbol[0] != "Symbol" or type(index) is not int:
            raise TypeError(f"expected a root by its symbol and number, got {symbol} and {index}")
        polynomial = sympy.Poly([_rational(c) for c in coefficients], from_plain(symbol))
        return sympy.CRootOf(polynomial, index, radicals=False)
    if name == "RealRootOf":
        root, symbol, number = parts
        if symbol[0] != "Symbol" or type(number) is not int:
            raise TypeError(f"expected a root by its symbol and number, got {symbol} and {number}")
        arguments = from_plain(root), from_plain(symbol), sympy.Integer(number)
        return RealRootOf(*arguments, evaluate=False)
    if name == "Interval":
        low, high, *is_open = parts
        if len(is_open) != 2 or not all(isinstance(each, bool) for each in is_open):
            raise TypeError(f"expected whether the ends of an interval are open, got {is_open}")
        return sympy.Interval(from_plain(low), from_plain(high), *is_open)
    if name in SETS:
        elements = [from_plain(part) for part in parts]
        if name == "Union" and not all(isinstance(each, sympy.Set) for each in elements):
            raise TypeError("expected a union of sets")
        return SETS[name](*elements, evaluate=False)
    return OPERATIONS[name](*map(from_plain, parts), evaluate=False)


def cost(data: Any) -> float:
    """The cost of reading all formulas in data of JSON, of factoring; 6 million take a second."""
    total, todo = 0.0, [data]
    while todo:
        match todo.pop():
            case dict() as part:
                todo += part.values()
            case list() as part:
                todo += part
                if part[:1] == ["CRootOf"] and isinstance(part[1], list):
                    digits = sum(len(each) for each in part[1] if isinstance(each, str))
                    total += (len(part[1]) * digits * BITS) ** 1.5
    return total


def _text(number: int) -> str:
    """An integer: its digits, or those of base 16 where Python refuses to write so many."""
    return str(number) if number.bit_length() <= LONGEST else hex(number)


def _rational(text: str) -> sympy.Rational:
    top, _, bottom = text.partition("/")
    return sympy.Rational(int(top, 0), int(bottom or "1", 0))


def _symbol(name: str, known: dict[str, bool] | None = None) -> sympy.Symbol:
    return sympy.Symbol(name, **(known or {}))
