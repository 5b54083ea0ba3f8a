"""Curves of bifurcations over two parameters, and the points in which they meet.

In a strip every mark is an arc from one end to the other, the root of a polynomial. Arcs meet at
the ends of strips; upright arcs lie at a single value of the parameter across. Where just two arcs
of one polynomial and event meet they are one curve; other nodes are of codimension two.
"""

from __future__ import annotations

from collections import Counter, defaultdict
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
from pwmap.diagrams.frames import untaken
from pwmap.parameters.segments import tips_of, traced
from pwmap.plane.kinds import PlaneKind
from pwmap.plane.strips import PlaneEvent, Rectangle, Strip

Node = tuple[Real, Real]  # values of both parameters


@dataclass(frozen=True, slots=True, eq=False)
class PlaneArc(Portable):
    """A part of a curve that is a function of one of the parameters."""

    event: PlaneEvent  # the bifurcation on it
    polynomial: PolyElement  # zero on it; irreducible
    ends: tuple[Node, Node]  # values of both parameters, the one across first
    column: Column | None = None  # where it is a root; None for an upright arc
    root: Root | None = None


Tip = tuple[PlaneArc, int]  # one end of an arc: 0 or 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneCurve:
    """A curve of two parameters on which cycles bifurcate, of :func:`pwmap.parameter_plane`.

    ``id`` is the code of its kind with a number; ``kind`` and ``note`` are as at a special point of
    a diagram, ``words`` of the cycles, each from its first letter in the alphabet on. The
    ``polynomial`` is irreducible, and zero on the curve. ``arcs`` follow one another; ``ends`` are
    names of the points at both ends, empty at an end of a span or if the curve is closed.
    """

    id: str
    kind: PointKind
    note: str
    words: tuple[str, ...]
    polynomial: sympy.Expr
    arcs: tuple[PlaneArc, ...]
    ends: tuple[str, str]

    def along(self, across: object) -> tuple[sympy.Expr, ...]:
        """The values of the second parameter on the curve for a rational first one, ascending.

        They are exact. There are none where the curve does not exist, is upright, or two arcs meet.
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

    ``id`` is the code of its kind with a number, ``node`` the values of both parameters, the one
    across first, ``curves`` the names of curves that pass or end here.
    """

    id: str
    kind: PlaneKind
    node: Node
    curves: tuple[str, ...]

    @property
    def values(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Exact values of both parameters, the one across first."""
        return real_to_sympy(self.node[0]), real_to_sympy(self.node[1])


Meeting = dict[tuple[PlaneEvent, PolyElement], list[Tip]]  # ends of arcs at a node, by their curves


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
    counts = Counter[str]()
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
    """The nodes inside the rectangle in which several curves meet, or one ends."""
    counts = Counter[str]()
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
    """A table with a row for each curve; words are separated by blanks."""
    names = ("id", "kind", "note", "words", "polynomial", "from", "to")
    rows = [(c.id, c.kind.value, c.note, " ".join(c.words), c.polynomial, *c.ends) for c in curves]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def point_columns(points: Iterable[CodimensionTwo], symbols: Sequence[sympy.Symbol]) -> Columns:
    """A row for each point: both parameters as doubles, then exactly; names separated by blanks."""
    own = untaken(map(str, symbols), ("id", "kind", "curves", *(f"{s}_exact" for s in symbols)))
    names = ("id", "kind", *own, *(f"{s}_exact" for s in symbols), "curves")
    rows = [(p.id, p.kind.value, *doubles(p), *p.values, " ".join(p.curves)) for p in points]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def doubles(point: CodimensionTwo) -> tuple[float, float]:
    """Both parameters at a point, as doubles."""
    across, along = (to_float(bounds(value)[0]) for value in point.node)
    return across, along
