"""Exact values as text: neither Python nor sympy writes integers of more than 4300 digits."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from fractions import Fraction
from functools import cache
from typing import Any, TypeVar

from pwmap.algebra.arguments import shown

Kind = TypeVar("Kind")

# suffix of sympy's Interval, by which ends are open
OPEN = {(False, False): "", (True, True): ".open", (True, False): ".Lopen", (False, True): ".Ropen"}
# at most as long as the integers of a formula
_DECIMAL = re.compile(r"[+-]?(?=.{1,999}$)(\d+\.\d*|\.?\d+)(e[+-]?\d{1,3})?", re.IGNORECASE)


def text(value: Any, usual: Callable[[object], str] = str) -> str:
    """``usual(value)``; of numbers that are too long to be written it shows the sizes."""
    try:
        return usual(value)
    except ValueError:
        if hasattr(value, "numerator"):  # a rational of Python, or of sympy without flint
            return shown(Fraction(int(value.numerator), int(value.denominator)))
        return str(_printer().doprint(value))


def printable(kind: type[Kind]) -> type[Kind]:
    """The dataclass, with a ``repr`` that gives the sizes of numbers too long to be written."""
    usual: Callable[[object], str] = kind.__repr__

    def shown_or_short(self: Any) -> str:
        try:
            return usual(self)
        except ValueError:
            names = [each.name for each in fields(self) if each.repr]
            values = (f"{name}={text(getattr(self, name), repr)}" for name in names)
            return f"{kind.__name__}({', '.join(values)})"

    kind.__repr__ = shown_or_short  # type: ignore[method-assign]
    return kind


@cache
def _printer() -> Any:
    """A sympy printer, loaded when needed, that writes the sizes of long numbers."""
    from sympy.printing.str import StrPrinter

    def sized(_: object, number: Any) -> str:
        return text(Fraction(int(number.p), int(number.q)))

    def interval(self: Any, value: Any) -> str:  # sympy leaves the ends to str(), which may fail
        ends = f"({self.doprint(value.start)}, {self.doprint(value.end)})"
        return f"Interval{OPEN[bool(value.left_open), bool(value.right_open)]}{ends}"

    def otherwise(_: object, value: object) -> str:
        return repr(value)

    names = ("Integer", "Rational")
    methods: dict[str, Any] = {f"_print_{name}": sized for name in names} | {
        "emptyPrinter": otherwise
    }
    methods["_print_Interval"] = interval
    return type("Short", (StrPrinter,), methods)()


def exact(text: str) -> str:
    """A decimal as an exact fraction, 1.25 as 5/4; other text as it is."""
    stripped = text.strip()
    return str(Fraction(stripped)) if _DECIMAL.fullmatch(stripped) else text
