"""Strips of two parameters, inside which edges of cells do not meet, and marks along them.

A mark is a place along one parameter with the bifurcation of cycles there.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy

from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import real_to_sympy
from pwmap.algebra.texts import printable
from pwmap.diagrams.data import PointKind
from pwmap.maps.cylinders import minimal_period
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import first_rotation
from pwmap.parameters.axis import Axis
from pwmap.parameters.bifurcations import classify, lowest
from pwmap.parameters.branches import Continuation
from pwmap.parameters.cells import Cell, ParameterCells
from pwmap.parameters.segments import Junction, SegmentEnd, connected


class PlaneEvent(NamedTuple):
    """A bifurcation of cycles."""

    kind: PointKind  # as of special points of a diagram
    note: str  # on the kind, such as "fold" or "persistence"
    words: tuple[str, ...]  # of the cycles, each the alphabetically first of its rotations


Mark = tuple[Any, PlaneEvent]  # a place on an axis, and the bifurcation there


def marks(map_: PiecewiseLinearMap, axis: Axis, cells: list[Cell]) -> list[Mark]:
    """All bifurcations of cycles along an axis, from left to right, each cycle once.

    Where only jumps end there is no bifurcation. Where the multiplier of a cycle passes -1 its flip
    is listed, but not the interval of points of twice the period; where the multiplier is -1 all
    along, such an interval persists, and other cycles that meet it are listed.
    """
    ends, step = (cells[0].lower, cells[-1].upper), len(map_.chain)
    continuation = Continuation(map_, axis, cells, ends)
    segments = continuation.segments()
    stops = continuation.stops
    found: dict[tuple[Any, tuple[str, ...]], list[tuple[PointKind, str]]] = defaultdict(list)
    for junction in connected(segments, continuation.junctions(segments), stops)[1]:
        if junction.place in stops:
            continue
        kind, note = classify(junction, at_span_end=False)
        own = _own(junction)
        words = {
            first_rotation(end.segment.key.word, step) for end in own if not _doubles(end, step)
        }
        says_more = any(_doubles(end, step) and end.segment.band is not None for end in own)
        if kind is not PointKind.EP and words and not says_more:
            spelled = tuple(sorted(map(map_.spelled, words)))
            found[junction.place, spelled].append((kind, note))
    return [(place, PlaneEvent(*_joined(each), words)) for (place, words), each in found.items()]


def _joined(happening: Sequence[tuple[PointKind, str]]) -> tuple[PointKind, str]:
    """The kind and note of a cycle from those of its points; a fold-flip has precedence."""
    kinds = [kind for kind, _ in happening]
    kind = PointKind.FF if PointKind.FF in kinds else kinds[0]
    notes = {note for each, note in happening if each is kind and note}
    return kind, " and ".join(sorted(notes))


def _own(junction: Junction) -> list[SegmentEnd]:
    """The ends of branches of the periodic points of lowest order at a junction."""
    order = lowest(junction.ends)
    return [end for end in junction.ends if end.is_fixed and end.length == order]


def _doubles(end: SegmentEnd, step: int) -> bool:
    """Whether points of a branch have twice the period of a cycle with the multiplier -1."""
    word = end.segment.key.word
    return step * minimal_period(word, step) < len(word)


@printable
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strip:
    """An open interval of one parameter, with cells of the other; see :func:`parameter_plane`.

    ``column`` is the interval, with the sample at which ``cells`` were found; the edges of cells
    are expressions in the first parameter. ``borders`` are the edges and both ends of the span as
    roots of polynomials, from the lowest on; ``marks`` are bifurcations. ``upright`` has the
    coefficients of polynomials in the first parameter alone whose signs were used.
    """

    column: Column
    cells: ParameterCells
    borders: tuple[Root, ...]
    marks: tuple[tuple[Root, PlaneEvent], ...]
    upright: tuple[tuple[int, ...], ...]

    @property
    def lower(self) -> sympy.Expr:
        """The exact lower end."""
        return real_to_sympy(self.column.low)

    @property
    def upper(self) -> sympy.Expr:
        """The exact upper end."""
        return real_to_sympy(self.column.high)
