"""Which axis a parameter is, by what else a map depends on."""

from __future__ import annotations

from typing import Any

from pwmap.algebra.exact import Number
from pwmap.algebra.rootfunctions import Root
from pwmap.maps.reading import Definition
from pwmap.parameters import column, symbolic
from pwmap.parameters.axis import Axis, RationalAxis
from pwmap.parameters.column import ColumnAxis
from pwmap.parameters.symbolic import SymbolicAxis, Threshold


def axis_of(definition: Definition, name: str, sample: dict[str, Number]) -> Axis:
    """The axis of a parameter; the others, if any, stay symbolic, with values at a sample."""
    match len(sample):
        case 0:
            return RationalAxis(definition)
        case 1:
            return ColumnAxis(definition, name, sample)
        case _:
            return SymbolicAxis(definition, name, sample)


def identical(first: Any, second: Any) -> bool:
    """Whether two equal places stay equal for other values of the symbolic parameters."""
    match first:
        case Root():
            return column.is_same(first, second)
        case Threshold():
            return symbolic.is_same(first, second)
        case _:
            return True
