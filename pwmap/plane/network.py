"""Curves of bifurcations over two parameters, and the points in which they meet.

In a strip every mark is a root of a polynomial, an arc from one end to the other; at the ends arcs
meet, and there are upright arcs where everything changes at one value across. Where just two arcs
of one polynomial and event meet they are one curve; all else is of codimension two.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement

from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import Portable, to_float, to_sympy
from pwmap.algebra.rootfunctions import Column, Root, minimal_polynomial
from pwmap.algebra.roots import Real, bounds, real_to_sympy, sign_at, simplest_between
from pwmap.diagrams.data import PointKind
from pwmap.parameters.curves import tips_of, traced
from pwmap.plane.kinds import PlaneKind
from pwmap.plane.marks import PlaneEvent
from pwmap.plane.strips import Rectangle, Strip

Node = tuple[Real, Real]  # values of both parameters


@dataclass(frozen=True, slots=True, eq=False)
class PlaneArc(Portable):
    """A part of a curve that is a function of one of the parameters."""

    event: PlaneEvent  # what happens on it
    polynomial: PolyElement  # zero on it; irreducible
    ends: tuple[Node, Node]  # values of both parameters, the one across first
    column: Column | None = None  # where it is a root; None for an upright arc
    root: Root | None = None


Tip = tuple[PlaneArc, int]  # one end of an arc: 0 or 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneCurve:
    """A curve of two parameters on which cycles bifurcate, of :func:`pwmap.parameter_plane`.

    Attributes
    ----------
    id
        The code of its kind with a number.
    kind, note
        What happens, as at a special point of a diagram.
    words
        Of the cycles to which it happens, each from its first letter in the alphabet on.
    polynomial
        Irreducible, and zero on the curve.
    arcs
        One after the other.
    ends
        Names of the points at both ends; empty at an end of a span, or if it is closed.
    """

    id: str
    kind: PointKind
    note: str
    words: tuple[str, ...]
    polynomial: sympy.Expr
    arcs: tuple[PlaneArc, ...]
    ends: tuple[str, str]

    def along(self, across: object) -> tuple[sympy.Expr, ...]:
        """Exact values of the second parameter on the curve, ascending, for a rational first one.

        There are none where the curve does not exist, is upright, or two arcs meet.
        """
        value = rational(across)
        found = [
            each
            for arc in self.arcs
            if arc.column is not None and arc.root is not None
            if (each := arc.column.number(arc.root, value)) is not None
        ]
        return tuple(real_to_sympy(each) for each in sorted(found))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CodimensionTwo:
    """A point of two parameters in which bifurcation curves of :func:`pwmap.parameter_plane` meet.

    ``id`` is the code of its kind with a number, ``node`` has the values of both parameters, the
    one across first, ``curves`` the names of curves that pass or end here.
    """

    id: str
    kind: PlaneKind
    node: Node
    curves: tuple[str, ...]

    @property
    def values(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Exact values of both parameters, the one across first."""
        return real_to_sympy(self.node[0]), real_to_sympy(self.node[1])


Meeting = dict[
    tuple[PlaneEvent, PolyElement], list[Tip]
]  # the ends of arcs at a node, by their curves


def network(
    rectangle: Rectangle, strips: Sequence[Strip]
) -> tuple[tuple[PlaneCurve, ...], tuple[CodimensionTwo, ...]]:
    """The curves of a rectangle, and the points in which they meet."""
    arcs = list(_arcs(rectangle, strips))
    meetings: dict[Node, Meeting] = defaultdict(lambda: defaultdict(list))
    for arc in arcs:
        for which, node in enumerate(arc.ends):
            meetings[node][arc.event, arc.polynomial].append((arc, which))
    following: dict[Tip, Tip] = {}
    for meeting in meetings.values():
        for tips in meeting.values():
            if len(tips) == 2:
                following.update(zip(tips, tips[::-1], strict=True))
    lines = list(traced(arcs, following))
    names = dict[PlaneArc, str]()
    counts: dict[str, int] = defaultdict(int)
    for line in lines:
        kind = line[0][0].event.kind
        counts[kind] += 1
        names.update((arc, f"{kind}{counts[kind]}") for arc, _ in line)
    points = tuple(_points(rectangle, meetings, names))
    at = {point.node: point.id for point in points}
    curves = tuple(
        curve_of(names[line[0][0]], [arc for arc, _ in line], _ends(line, following, at))
        for line in lines
    )
    return curves, points


def curve_of(name: str, arcs: Sequence[PlaneArc], ends: tuple[str, str] = ("", "")) -> PlaneCurve:
    """The curve of arcs that have one event and one polynomial."""
    first = arcs[0]
    polynomial = to_sympy(first.polynomial)
    return PlaneCurve(
        id=name, **first.event._asdict(), polynomial=polynomial, arcs=tuple(arcs), ends=ends
    )


def _arcs(rectangle: Rectangle, strips: Sequence[Strip]) -> Iterator[PlaneArc]:
    """All arcs: those of strips from left to right, then upright ones."""
    heights: dict[Real, set[Real]] = defaultdict(lambda: {*rectangle.along_span})
    for strip in strips:
        column = strip.column
        for root, event in strip.marks:
            ends = [(end, column.limit(root, end)) for end in (column.low, column.high)]
            for across, along in ends:
                heights[across].add(along)
            yield PlaneArc(event, root.factor, (ends[0], ends[1]), column, root)
    for left, right in pairwise(strips):
        end = left.column.high
        if any(not sign_at(tuple(map(QQ, p)), end) for p in (*left.upright, *right.upright)):
            beside = left.column.sample, right.column.sample
            yield from _upright(rectangle, end, sorted(heights[end]), beside)


def _upright(
    rectangle: Rectangle, across: Real, heights: Sequence[Real], beside: tuple[Real, Real]
) -> Iterator[PlaneArc]:
    """Arcs along one value of the parameter across, between the ends of others."""
    polynomial = minimal_polynomial(rectangle.map.definition.ring, rectangle.index, across)
    span = simplest_between(beside[0], across), simplest_between(across, beside[1])
    for low, high in pairwise(heights):
        for place, event in rectangle.upright_marks(simplest_between(low, high), span):
            if place == across:
                yield PlaneArc(event, polynomial, ((across, low), (across, high)))


def _points(
    rectangle: Rectangle, meetings: Mapping[Node, Meeting], names: Mapping[PlaneArc, str]
) -> Iterator[CodimensionTwo]:
    """Nodes inside the rectangle through which more than one curve passes, or in which one ends."""
    counts: dict[str, int] = defaultdict(int)
    for node in sorted(meetings):
        meeting = meetings[node]
        inside = node[0] not in rectangle.across_span and node[1] not in rectangle.along_span
        passes = all(len(tips) == 2 for tips in meeting.values())
        if not inside or (passes and len({polynomial for _, polynomial in meeting}) == 1):
            continue
        kind = _kind(meeting, passes)
        counts[kind] += 1
        yield CodimensionTwo(
            id=f"{kind}{counts[kind]}",
            kind=kind,
            node=node,
            curves=tuple(dict.fromkeys(names[arc] for tips in meeting.values() for arc, _ in tips)),
        )


def _kind(meeting: Meeting, passes: bool) -> PlaneKind:
    words = [word for event, _ in meeting for word in event.words]
    kinds = {event.kind for event, _ in meeting}
    if passes and len(set(words)) == len(words):
        return PlaneKind.CROSSING
    if PointKind.PD in kinds:
        return PlaneKind.FLIP_BORDER
    return PlaneKind.FOLD_BORDER if PointKind.LP in kinds else PlaneKind.TWO_BORDERS


def _ends(
    line: Sequence[Tip], following: Mapping[Tip, Tip], at: Mapping[Node, str]
) -> tuple[str, str]:
    first, last = (
        "" if (arc, which) in following else at.get(arc.ends[which], "")
        for arc, which in tips_of(line)
    )
    return first, last


# --- As tables ------------------------------------------------------------------------------------

Columns = Mapping[str, Sequence[object]]


def curve_columns(curves: Iterable[PlaneCurve]) -> Columns:
    """One row for each curve; words are parted by blanks."""
    rows = list(curves)
    return {
        "id": [curve.id for curve in rows],
        "kind": [curve.kind.value for curve in rows],
        "note": [curve.note for curve in rows],
        "words": [" ".join(curve.words) for curve in rows],
        "polynomial": [curve.polynomial for curve in rows],
        "from": [curve.ends[0] for curve in rows],
        "to": [curve.ends[1] for curve in rows],
    }


def point_columns(points: Iterable[CodimensionTwo], symbols: Sequence[sympy.Symbol]) -> Columns:
    """One row for each point: both parameters as doubles, then exactly; names parted by blanks."""
    rows = list(points)
    names = [str(symbol) for symbol in symbols]
    return (
        {"id": [point.id for point in rows], "kind": [point.kind.value for point in rows]}
        | {name: [doubles(point)[k] for point in rows] for k, name in enumerate(names)}
        | {f"{name}_exact": [point.values[k] for point in rows] for k, name in enumerate(names)}
        | {"curves": [" ".join(point.curves) for point in rows]}
    )


def doubles(point: CodimensionTwo) -> tuple[float, float]:
    """Both parameters at a point, as doubles."""
    across, along = (to_float(bounds(value)[0]) for value in point.node)
    return across, along
