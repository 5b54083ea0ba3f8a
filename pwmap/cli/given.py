"""The warning that an answer holds only for a part of what was assumed."""

from __future__ import annotations

import re
from collections.abc import Sequence

import sympy

from pwmap.diagrams.diagram import Diagram
from pwmap.maps.piecewise_linear import PiecewiseLinearMap


def in_a_part_only(map_: PiecewiseLinearMap, diagram: Diagram) -> str:
    """A sentence if a diagram holds for a part of what was assumed, and on how to get the rest."""
    part = diagram.in_part
    if not part:
        return ""
    values = ", ".join(f"{name} = {value}" for name, value in diagram.sample.items())
    decided = f"This is decided {part}: at {values}."
    if ends := diagram.left_out_ends:
        texts = " or ".join(f"--set {each.replace(' ', '')}" for each in ends if _is_value(each))
        way = f": give it by {texts or '--set'} and another folder by --out."
        return f"{decided} What holds there takes a run of its own{way}"
    varied = diagram.parameter_name
    assumed = [each for each in map_.given if varied not in map(str, each.free_symbols)]
    named = {str(symbol): symbol for symbol in map_.parameters if str(symbol) in diagram.sample}
    held = [each for each in diagram.given if re.search("[<>=]", each)]  # others are sentences
    beyond = _beyond(assumed, held, named)
    way = f", such as --sample {beyond}," if beyond else " by --sample,"
    return (
        f"{decided} For the rest, where the answer may differ, run it again: give a value "
        f"there{way} and another folder by --out."
    )


def _is_value(equation: str) -> bool:
    """Whether an equation gives a parameter a rational value, as ``a = 2`` does."""
    return bool(re.fullmatch(r"[^\W\d]\w* = -?[\d/]+", equation))


def _beyond(
    assumed: Sequence[sympy.Basic], held: Sequence[str], named: dict[str, sympy.Symbol]
) -> str:
    """A value of the only symbolic parameter for which the answer does not hold; else empty."""
    if len(named) != 1:
        return ""
    (name,) = named
    conditions = [sympy.sympify(text, locals=named) for text in held]
    rest = sympy.And(*assumed, sympy.Not(sympy.And(*conditions))).as_set()
    for part in rest.args if isinstance(rest, sympy.Union) else (rest,):
        if isinstance(part, sympy.Interval):
            low, high = part.start, part.end
            middle = high - 1 if low.is_infinite else low + 1 if high.is_infinite else None
            value = sympy.nsimplify((low + high) / 2 if middle is None else middle)
            if value.is_Rational:
                return f"{name}={value}"
            near = sympy.Rational(str(sympy.N(value, 3)))
            if part.contains(near) is sympy.true:
                return f"{name}={near}"
    return ""
