"""Bands as branches and crises as special points of a bifurcation diagram."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sympy
from sympy import QQ

from pwmap.algebra.arguments import check_kind, explained
from pwmap.algebra.exact import Number, to_float
from pwmap.algebra.roots import algebraic, equally_spaced, simplest_between
from pwmap.diagrams.data import Branch, BranchKind, FloatArray, PointKind, SpecialPoint, Stretch
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import counted
from pwmap.longrun.crises.diagram import AttractorCell, AttractorDiagram
from pwmap.longrun.crises.meetings import meeting_x
from pwmap.longrun.crises.samples import WORK
from pwmap.longrun.dynamics import FoundAttractors, dynamics
from pwmap.maps.budget import BUDGET, Budget, Meter

PLACES = 7  # of each cell, at which bands are computed exactly
# Parts of the distance between two places within which the simplest rational is taken: in turn, as
# at very simple ones attractors are often open because a break returns to itself
NEAR = QQ(1, 8), QQ(1, 1024)


@explained()
def with_attractors(diagram: Diagram, found: AttractorDiagram) -> Diagram:
    """A diagram with the bands of chaotic attractors added as branches, and crises as points.

    Parameters
    ----------
    diagram, found
        Branches and special points of a map, and its attractors, over the same parameter.

    Returns
    -------
    Diagram
        A branch of kind ``BAND`` has the number of its attractor's bands as order and the columns
        ``low`` and ``high``; ``exact`` holds the formulas ``lower`` and ``upper``, unless other
        images of breaks become outermost. Where bands give way to a cycle, they end in the special
        point at which the cycle loses stability, if the diagram has it.

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
    points = {point.id: point for point in diagram.points}
    branches = list(diagram.branches)
    for number, rows in enumerate(_pieces(found), start=1):
        branches.append(_branch(f"B{number}", rows, found, points))
    return replace(diagram, branches=tuple(branches), points=tuple(points.values()))


def check_parameter(diagram: Diagram, found: AttractorDiagram) -> None:
    """TypeError if an argument is of another kind, ValueError if their parameters differ."""
    check_kind("diagram", diagram, Diagram)
    check_kind("found", found, AttractorDiagram)
    if diagram.parameter_name != str(found.parameter):
        raise ValueError(
            f"expected attractors over {diagram.parameter_name}, got them over {found.parameter}"
        )


# a band in a cell: the cell, the number of bands of its attractor, a table of the parameter and
# both ends, and formulas of the ends if these hold in the whole cell
Row = tuple[AttractorCell, int, FloatArray, dict[str, object]]


def _branch(
    name: str, rows: Sequence[Row], found: AttractorDiagram, points: dict[str, SpecialPoint]
) -> Branch:
    """The branch of a band from one crisis to the next, through one or more cells."""
    cells, orders, tables, formulas = zip(*rows, strict=True)
    parameter, low, high = np.hstack(tables)
    middle = 0.5 * (low + high)
    starts = np.cumsum([0, *(table.shape[1] for table in tables[:-1])]).tolist()
    ends = (cells[0].lower, middle[0]), (cells[-1].upper, middle[-1])
    ids = list[str]()
    for place, x in ends:
        point = _point(found, points, place, float(x))
        points[point.id] = replace(point, branches=(*point.branches, name))
        ids.append(point.id)
    return Branch(
        id=name,
        kind=BranchKind.BAND,
        order=orders[0],
        word="",
        parameter=parameter,
        x=middle,
        multiplier=np.full(len(middle), np.nan),
        ends=(ids[0], ids[1]),
        exact=formulas[0],
        attracts=True,
        words=tuple(Stretch(k, "", exact=each) for k, each in zip(starts, formulas, strict=True)),
        columns={"low": low, "high": high},
    )


def _pieces(found: AttractorDiagram) -> Iterator[tuple[Row, ...]]:
    """Yield the rows of each band from crisis to crisis, from left to right and bottom to top."""
    ends = {crisis.parameter for crisis in found.crises}
    run: list[list[Row]] = []  # the rows of each cell since the last crisis
    for cell in found.cells:
        rows = _rows(found, cell)
        if run and (cell.lower in ends or len(rows) != len(run[-1])):
            yield from zip(*run, strict=True)
            run = []
        run.append(rows)
    yield from zip(*run, strict=True)


def _rows(found: AttractorDiagram, cell: AttractorCell) -> list[Row]:
    """The rows of a cell's bands, from the lowest; none if the cell is open."""
    if cell.is_open:
        return []
    name, (places, seen) = found.parameter, sampled(found, cell, PLACES, Meter(BUDGET))
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
        rows.append((cell, orders[k], table, exact))
    return rows


def sampled(
    found: AttractorDiagram, cell: AttractorCell, count: int, meter: Meter
) -> tuple[list[Number], list[FoundAttractors]]:
    """Simple rationals, about equally spaced in a cell, and the attractors within a budget."""
    even = equally_spaced(algebraic(cell.lower), algebraic(cell.upper), count)
    near = (_near(found, p, even[1] - even[0], meter) for p in even)
    places, seen = zip(*near, strict=True)
    return [*places], [*seen]


def _near(
    found: AttractorDiagram, x: Number, width: Number, meter: Meter
) -> tuple[Number, FoundAttractors]:
    """A simple rational near a place, with its attractors: a less simple one if they are open."""
    for part in NEAR:
        place = simplest_between(x - part * width, x + part * width)
        where = {found.parameter: QQ.to_sympy(place)}
        own = Meter(Budget(work=max(1, min(WORK, meter.budget.work - meter.work))))
        seen = dynamics(found.map, where, budget=own).attractors
        meter.work += own.work
        if seen.cause or not seen.open:
            break
    return place, seen


def to_ends(over: Sequence[float], values: Sequence[float]) -> list[float]:
    """Values at inner places, extrapolated linearly to both ends where all are finite."""
    if len(values) == 1 or not np.isfinite(values).all():
        return [values[0], *values, values[-1]]
    first, last = (
        values[i] + (values[i] - values[j]) * (over[end] - over[m]) / (over[m] - over[n])
        for end, i, j, m, n in ((0, 0, 1, 1, 2), (-1, -1, -2, -2, -3))
    )
    return [first, *values, last]


def _point(
    found: AttractorDiagram, points: Mapping[str, SpecialPoint], place: sympy.Expr, x: float
) -> SpecialPoint:
    """The special point in which a band ends: that of a crisis, known or new, or an end point."""
    exact: dict[str, object] = {"parameter": place}
    crisis = next((each for each in found.crises if each.parameter == place), None)
    if crisis is None:
        is_end = place in (found.cells[0].lower, found.cells[-1].upper)
        note = "end of the parameter span" if is_end else "beyond, what attracts is open"
        about: dict[str, Any] = {"kind": PointKind.EP, "note": note}
    else:
        # where a cycle gives way to bands, the diagram may have its bifurcation
        kinds = (PointKind.BC, PointKind.FF) if crisis.kind is PointKind.BC else (crisis.kind,)
        own = [p for p in points.values()
               if p.kind in kinds and p.exact.get("parameter") == place]  # fmt: skip
        if own:
            return min(own, key=lambda point: point.order)
        note = f"{counted(crisis.bands[0], 'band')} on the left, {crisis.bands[1]} on the right"
        about = {"kind": crisis.kind, "note": note, "precision": crisis.width}
        if crisis.meetings:
            meeting = min(crisis.meetings, key=lambda each: (len(each.image), each))
            value = meeting_x(found.map, meeting).subs(found.parameter, place)
            exact["x"] = value = sympy.radsimp(value)
            x = float(value)
            cause = f"the image {meeting.image} of a border meets the cycle {meeting.cycle}"
            about["cause"] = cause
    number = 1 + sum(point.kind is about["kind"] for point in points.values())
    id_ = f"{about['kind']}{number}"
    return SpecialPoint(id=id_, parameter=float(place), x=x, exact=exact, **about)
