"""Exact numbers, formulas and sets as plain JSON data, and back, without ``eval``.

A rational or an infinity is text such as ``"5/4"``; all else is a list that begins with a name:
``["Add", ["Symbol", "r"], "-2"]``, ``["CRootOf", ["1", "0", "-2"], ["Symbol", "t"], 1]`` with
coefficients, ``["RealRootOf", polynomial, ["Symbol", "b"], 0]``. Nothing is evaluated or sorted.

The package's own numbers are ``["QQ", "5/4"]``, ``["Infinite", -1]`` and, with an interval that
isolates the root, ``["RealRoot", ["1", "0", "-2"], 1, "1", "2"]``; a ring is ``["QQ", symbols]``, a
polynomial such as 2 a b + 1 is ``["QQ", symbols, [[1, 1, "2"], [0, 0, "1"]]]``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement, PolyRing

from pwmap.algebra.exact import Infinite, pair, polynomial_ring, sign
from pwmap.algebra.rootfunctions import RealRootOf
from pwmap.algebra.roots import RealRoot, value_at
from pwmap.algebra.texts import text

NUMBERS = {"oo": sympy.oo, "-oo": -sympy.oo, "nan": sympy.nan, "zoo": sympy.zoo}
TRUTHS = {"true": sympy.true, "false": sympy.false}
RELATIONS = {"Gt": sympy.Gt, "Ge": sympy.Ge, "Lt": sympy.Lt, "Le": sympy.Le}
OPERATIONS = {"Add": sympy.Add, "Mul": sympy.Mul, "Pow": sympy.Pow, **RELATIONS}
BITS = 3.3  # bits per decimal digit, log2(10)
LONGEST = 4096  # bits of the longest number that is written in decimals
SETS = {"FiniteSet": sympy.FiniteSet, "Union": sympy.Union}


def to_plain(value: Any) -> Any:
    """A number, formula or set as nested lists and text; TypeError for any other kind."""
    match value:
        case QQ.dtype():
            return ["QQ", _quotient(value)]
        case PolyRing():
            return ["QQ", list(map(to_plain, value.symbols))]
        case PolyElement():
            terms = [[*exponents, _quotient(c)] for exponents, c in value.terms()]
            return [*to_plain(value.ring), terms]
        case Infinite():
            return ["Infinite", value.side]
        case RealRoot():
            polynomial, low, high = map(_quotient, value.polynomial), value.low, value.high
            return ["RealRoot", [*polynomial], value.index, _quotient(low), _quotient(high)]
        case sympy.Rational():
            return _quotient(QQ.from_sympy(value))
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
    for name, number in (NUMBERS | TRUTHS).items():
        if value is number:
            return name
    for name, kind in (OPERATIONS | SETS).items():
        if isinstance(value, kind):
            return [name, *map(to_plain, value.args)]
    raise TypeError(f"expected an algebraic formula or a set of such, got {value!r}")


@lru_cache(maxsize=65536, typed=True)
def text_of(value: object) -> str:
    """An exact value as text, cached: the files of a diagram hold each several times."""
    return text(value)


def from_plain(data: Any) -> Any:
    """The inverse of :func:`to_plain`; ValueError, TypeError or LookupError for other data."""
    if isinstance(data, str):
        known = NUMBERS | TRUTHS
        return known[data] if data in known else _rational(data)
    name, *parts = data
    if name in ("QQ", "RealRoot", "Infinite"):
        return _number(name, *parts)
    if name == "Symbol":
        return _symbol(*parts)
    if name in ("CRootOf", "RealRootOf"):
        polynomial, symbol, number = parts
        if symbol[0] != "Symbol" or type(number) is not int:
            raise TypeError(f"expected a root by its symbol and number, got {symbol} and {number}")
        if name == "RealRootOf":
            arguments = from_plain(polynomial), from_plain(symbol), sympy.Integer(number)
            return RealRootOf(*arguments, evaluate=False)
        if not isinstance(polynomial, list):
            raise TypeError(f"expected a list of coefficients, got {polynomial!r}")
        whole = sympy.Poly([_rational(c) for c in polynomial], from_plain(symbol))
        return sympy.CRootOf(whole, number, radicals=False)
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


def _number(name: str, first: Any, *rest: Any) -> Any:
    """A number of the package's own, a polynomial, or a ring."""
    if name == "Infinite":
        if first not in (-1, 1):
            raise ValueError(f"expected an infinity by its side -1 or 1, got {first!r}")
        return Infinite(first)
    if name == "RealRoot":
        index, *ends = rest
        if type(index) is not int:
            raise TypeError(f"expected the number of a root, got {index!r}")
        polynomial, (low, high) = tuple(map(_exact, first)), map(_exact, ends)
        if sign(value_at(polynomial, low)) * sign(value_at(polynomial, high)) >= 0:
            raise ValueError(f"expected ends on both sides of a root, got {ends}")
        return RealRoot.of_factor(polynomial, index, low, high)
    if isinstance(first, str):
        return _exact(first)
    ring = polynomial_ring(list(map(from_plain, first)))
    if not rest:
        return ring
    (terms,) = rest
    return ring.from_dict({tuple(e): _exact(c) for *e, c in terms})


def cost(data: Any) -> float:
    """The cost of factoring when all formulas in JSON data are read; 6 million take a second."""
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


def _quotient(number: Any) -> str:
    top, bottom = map(_text, pair(number))
    return top if bottom == "1" else f"{top}/{bottom}"


def _text(number: int) -> str:
    """An integer as text: decimal, or in base 16 where Python refuses so many decimal digits."""
    return str(number) if number.bit_length() <= LONGEST else hex(number)


def _rational(text: str) -> sympy.Rational:
    top, _, bottom = text.partition("/")
    return sympy.Rational(int(top, 0), int(bottom or "1", 0))


def _exact(text: str) -> Any:
    return QQ.from_sympy(_rational(text))


def _symbol(name: str, known: dict[str, bool] | None = None) -> sympy.Symbol:
    return sympy.Symbol(name, **(known or {}))
