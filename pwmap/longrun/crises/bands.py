"""Bands as branches, and crises as special points, of a bifurcation diagram."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_kind, explained
from pwmap.algebra.exact import to_float
from pwmap.algebra.roots import algebraic, simplest_between, spread
from pwmap.diagrams.data import Branch, BranchKind, FloatArray, PointKind, SpecialPoint, Stretch
from pwmap.diagrams.diagram import Diagram
from pwmap.longrun.crises.diagram import AttractorCell, AttractorDiagram, Crisis
from pwmap.longrun.crises.meetings import meeting_x
from pwmap.longrun.dynamics import dynamics

PLACES = 7  # in each cell, at which bands are computed exactly
NEAR = QQ(1, 8)  # of the distance between two places: so close a simple rational is taken


@explained()
def with_attractors(diagram: Diagram, found: AttractorDiagram) -> Diagram:
    """The same diagram with bands of chaotic attractors as branches, and crises as points.

    Parameters
    ----------
    diagram, found
        Branches and special points of a map, and its attractors, over the same parameter.

    Returns
    -------
    Diagram
        A branch of kind ``BAND`` has the number of its attractor's bands as order, the columns
        ``low`` and ``high``, and in ``exact`` the formulas ``lower`` and ``upper``, unless other
        images of breaks become the outermost. Where bands give way to a cycle they end in the point
        at which it loses its stability, if the diagram has it.

    Raises
    ------
    ValueError
        If the two are over different parameters.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram, bifurcation_diagram
    >>> from pwmap.longrun import with_attractors
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> diagram = bifurcation_diagram(tent, "a", ("4/3", "3/2"), orders=(1,))
    >>> both = with_attractors(diagram, attractor_diagram(tent, "a", ("4/3", "3/2"), 1))
    >>> len(diagram.branches), len(both.branches), both.point("MC1").exact["parameter"]
    (2, 5, sqrt(2))
    """
    check_parameter(diagram, found)
    points = _Points(diagram, found)
    branches = tuple(
        _branch(f"B{number}", rows, points) for number, rows in enumerate(_pieces(found), start=1)
    )
    return replace(diagram, branches=(*diagram.branches, *branches), points=points.all())


def check_parameter(diagram: Diagram, found: AttractorDiagram) -> None:
    """TypeError if an argument is of another kind, ValueError if their parameters differ."""
    check_kind("diagram", diagram, Diagram)
    check_kind("found", found, AttractorDiagram)
    if diagram.parameter_name != str(found.parameter):
        raise ValueError(
            f"expected attractors over {diagram.parameter_name}, got them over {found.parameter}"
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    """A band in one cell: both ends at some values of the parameter, and formulas if they hold."""

    cell: AttractorCell
    order: int
    table: FloatArray  # (3, n): the parameter, and both ends
    formulas: dict[str, object]


def _branch(name: str, rows: Sequence[_Row], points: _Points) -> Branch:
    """A band from one crisis to the next, through one or more cells."""
    first, last = rows[0], rows[-1]
    parameter, low, high = np.hstack([row.table for row in rows])
    middle = 0.5 * (low + high)
    starts = np.cumsum([0, *(row.table.shape[1] for row in rows[:-1])]).tolist()
    words = tuple(
        Stretch(start, "", exact=row.formulas) for start, row in zip(starts, rows, strict=True)
    )
    return Branch(
        id=name,
        kind=BranchKind.BAND,
        order=first.order,
        word="",
        parameter=parameter,
        x=middle,
        multiplier=np.full(len(middle), np.nan),
        ends=(
            points.at(first.cell.lower, float(middle[0]), name),
            points.at(last.cell.upper, float(middle[-1]), name),
        ),
        exact=words[0].exact,
        attracts=True,
        words=words,
        columns={"low": low, "high": high},
    )


def _pieces(found: AttractorDiagram) -> Iterator[tuple[_Row, ...]]:
    """All bands from one crisis to the next, from left to right and bottom to top."""
    ends = {crisis.parameter for crisis in found.crises}
    run: list[list[_Row]] = []  # the rows of each cell since the last crisis
    for cell in found.cells:
        rows = _rows(found, cell)
        if run and (cell.lower in ends or len(rows) != len(run[-1])):
            yield from zip(*run, strict=True)
            run = []
        run.append(rows)
    yield from zip(*run, strict=True)


def _rows(found: AttractorDiagram, cell: AttractorCell) -> list[_Row]:
    """The bands of a cell, from the lowest; none if they are not known throughout."""
    if cell.is_open:
        return []
    low, high = algebraic(cell.lower), algebraic(cell.upper)
    even = spread(low, high, PLACES)
    near = (even[1] - even[0]) * NEAR
    places = [simplest_between(p - near, p + near) for p in even]
    name, map_ = found.parameter, found.map
    seen = [dynamics(map_, {name: QQ.to_sympy(p)}).attractors for p in places]
    bands = [[band for each in attractors for band in each.bands] for attractors in seen]
    orders = [len(each.bands) for each in seen[0] for _ in each.bands]
    formulas = [pair for pairs in cell.bands for pair in pairs]
    over = [float(cell.lower), *map(to_float, places), float(cell.upper)]
    rows = []
    for k in range(min(map(len, bands))):
        values = [each[k] for each in bands]
        known = formulas[k] if len(formulas) == len(orders) else ()
        if any(
            formula.subs(name, QQ.to_sympy(p)) != end
            for p, band in zip(places, values, strict=True)
            for formula, end in zip(known, band.args[:2], strict=False)
        ):
            known = ()
        ends = ([float(band.args[which]) for band in values] for which in (0, 1))
        table = np.array([over, *(to_ends(over, each) for each in ends)])
        for formula, line in zip(known, table[1:], strict=False):
            line[[0, -1]] = [float(formula.subs(name, end)) for end in (cell.lower, cell.upper)]
        exact: dict[str, object] = {}
        if known:
            interval = sympy.Interval.open(cell.lower, cell.upper)
            exact = {"lower": known[0], "upper": known[1], "interval": interval}
        rows.append(_Row(cell, orders[k], table, exact))
    return rows


def to_ends(over: Sequence[float], values: Sequence[float]) -> list[float]:
    """Values at inner places, extended to both ends by straight lines through the nearest two."""
    if len(values) == 1:
        return [*values, *values, *values]
    first, last = (
        values[i] + (values[i] - values[j]) * (over[end] - over[m]) / (over[m] - over[n])
        for end, i, j, m, n in ((0, 0, 1, 1, 2), (-1, -1, -2, -2, -3))
    )
    return [first, *values, last]


class _Points:
    """The special points of a diagram, with the ends of bands added."""

    def __init__(self, diagram: Diagram, found: AttractorDiagram) -> None:
        self._found = found
        self._points = {point.id: point for point in diagram.points}
        self._counts = Counter(str(point.kind) for point in diagram.points)
        self._crises = {crisis.parameter: crisis for crisis in found.crises}
        self._known: dict[sympy.Expr, str] = {}

    def all(self) -> tuple[SpecialPoint, ...]:
        return tuple(self._points.values())

    def at(self, parameter: sympy.Expr, x: float, branch: str) -> str:
        """The id of the point in which a band ends: that of a crisis, or one of its own."""
        crisis = self._crises.get(parameter)
        if crisis is None:
            ends = self._found.cells[0].lower, self._found.cells[-1].upper
            is_end = parameter in ends
            note = "end of the parameter span" if is_end else "beyond, what attracts is open"
            name = self._new(
                PointKind.EP, parameter=float(parameter), x=x, note=note,
                exact={"parameter": parameter},
            )  # fmt: skip
        else:
            name = self._known.get(parameter) or self._own(crisis) or self._added(crisis, x)
            self._known[parameter] = name
        point = self._points[name]
        self._points[name] = replace(point, branches=(*point.branches, branch))
        return name

    def _own(self, crisis: Crisis) -> str:
        """The id of the point of the diagram where a cycle ends and bands begin; empty if none."""
        kinds = {PointKind.BC: (PointKind.BC, PointKind.FF), PointKind.PD: (PointKind.PD,)}
        found = [
            point
            for point in self._points.values()
            if point.kind in kinds.get(crisis.kind, ())
            and point.exact.get("parameter") == crisis.parameter
        ]
        return min(found, key=lambda point: point.order).id if found else ""

    def _added(self, crisis: Crisis, x: float) -> str:
        exact: dict[str, object] = {"parameter": crisis.parameter}
        cause = ""
        if crisis.meetings:
            meeting = min(crisis.meetings, key=lambda each: (len(each.image), each))
            formula = meeting_x(self._found.map, meeting)
            value = sympy.radsimp(formula.subs(self._found.parameter, crisis.parameter))
            exact["x"], x = value, float(value)
            cause = f"the image {meeting.image} of a border meets the cycle {meeting.cycle}"
        before, after = crisis.bands
        return self._new(
            crisis.kind, parameter=float(crisis.parameter), x=x, exact=exact, cause=cause,
            note=f"{before} bands on the left, {after} on the right", precision=crisis.width,
        )  # fmt: skip

    def _new(self, kind: PointKind, **what: Any) -> str:
        self._counts[str(kind)] += 1
        name = f"{kind}{self._counts[str(kind)]}"
        self._points[name] = SpecialPoint(id=name, kind=kind, **what)
        return name
