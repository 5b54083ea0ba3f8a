"""Exact values as text: Python writes no integer of more than 4300 digits, and nor does sympy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from fractions import Fraction
from functools import cache
from typing import Any, TypeVar

from pwmap.algebra.arguments import shown

Kind = TypeVar("Kind")

# by which ends are open, as sympy writes it
OPEN = {(False, False): "", (True, True): ".open", (True, False): ".Lopen", (False, True): ".Ropen"}


def text(value: Any, usual: Callable[[object], str] = str) -> str:
    """``str(value)``, or by ``repr``; of numbers that are too long to be written, their sizes."""
    try:
        return usual(value)
    except ValueError:
        if hasattr(value, "numerator"):  # as rationals of Python have, and of sympy without flint
            return shown(Fraction(int(value.numerator), int(value.denominator)))
        return str(_printer().doprint(value))


def printable(kind: type[Kind]) -> type[Kind]:
    """A dataclass whose ``repr`` has the sizes of numbers that are too long to be written."""
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
    """The printer of sympy, which is loaded when it is needed, with sizes of long numbers."""
    from sympy.printing.str import StrPrinter

    def sized(_: object, number: Any) -> str:
        return text(Fraction(int(number.p), int(number.q)))

    def interval(self: Any, value: Any) -> str:  # sympy's own leaves its ends to Python
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
