"""Which axis a parameter is, by what else a map depends on."""

from __future__ import annotations

from pwmap.algebra.exact import Number
from pwmap.maps.reading import Definition
from pwmap.parameters.axis import Axis, RationalAxis
from pwmap.parameters.column import ColumnAxis
from pwmap.parameters.symbolic import SymbolicAxis


def axis_of(definition: Definition, name: str, sample: dict[str, Number]) -> Axis:
    """The axis of a parameter; the others, if any, stay symbolic, with values at a sample."""
    kind = (RationalAxis, ColumnAxis, SymbolicAxis)[min(len(sample), 2)]
    return kind(definition, name, sample)
