"""Bifurcation curves over two parameters, the points in which they meet, and their tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy
from sympy.polys.rings import PolyElement

from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import Portable, to_float, to_sympy
from pwmap.algebra.rootfunctions import Column, Root
from pwmap.algebra.roots import Real, bounds, real_to_sympy
from pwmap.algebra.texts import printable
from pwmap.diagrams.data import PointKind
from pwmap.diagrams.frames import unique_names
from pwmap.plane.kinds import PlaneKind
from pwmap.plane.strips import PlaneEvent

Node = tuple[Real, Real]  # values of both parameters


@dataclass(frozen=True, slots=True, eq=False)
class PlaneArc(Portable):
    """A part of a curve that is a function of the parameter across, or upright at one value."""

    event: PlaneEvent  # the bifurcation on it
    polynomial: PolyElement  # zero on it; irreducible
    ends: tuple[Node, Node]  # values of both parameters, the one across first
    column: Column | None = None  # over which it is a root; None for an upright arc
    root: Root | None = None


@printable
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneCurve:
    """A curve of two parameters on which cycles bifurcate, from :func:`pwmap.parameter_plane`.

    ``id`` is the code of its kind with a number; ``kind`` and ``note`` are those of a special point
    of a diagram, ``words`` those of the cycles, each the alphabetically first of its rotations. The
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
        """Exact values of the second parameter on the curve for a rational first one, ascending.

        There are none where the curve does not exist or is upright, or where two arcs meet.
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


def curve_of(name: str, arcs: Sequence[PlaneArc], ends: tuple[str, str] = ("", "")) -> PlaneCurve:
    """A curve from its arcs, which have one event and one polynomial."""
    first = arcs[0]
    polynomial = to_sympy(first.polynomial)
    return PlaneCurve(
        id=name, **first.event._asdict(), polynomial=polynomial, arcs=tuple(arcs), ends=ends
    )


# --- As tables ------------------------------------------------------------------------------------

Columns = Mapping[str, Sequence[object]]


def curve_columns(curves: Iterable[PlaneCurve]) -> Columns:
    """A table with a row for each curve; words are separated by blanks."""
    names = ("id", "kind", "note", "words", "polynomial", "from", "to")
    rows = [(c.id, c.kind.value, c.note, " ".join(c.words), c.polynomial, *c.ends) for c in curves]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def point_columns(points: Iterable[CodimensionTwo], symbols: Sequence[sympy.Symbol]) -> Columns:
    """A table with a row for each point: both parameters as doubles and exactly, and its curves."""
    own = unique_names(
        map(str, symbols), ("id", "kind", "curves", *(f"{s}_exact" for s in symbols))
    )
    names = ("id", "kind", *own, *(f"{s}_exact" for s in symbols), "curves")
    rows = [(p.id, p.kind.value, *doubles(p), *p.values, " ".join(p.curves)) for p in points]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def doubles(point: CodimensionTwo) -> tuple[float, float]:
    """Both parameters at a point, as doubles."""
    across, along = (to_float(bounds(value)[0]) for value in point.node)
    return across, along
