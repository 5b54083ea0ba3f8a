"""The command ``pwmap plane``: two parameters of a map, with its bifurcation curves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

import pwmap
from pwmap import plot
from pwmap.cli import reading, screen
from pwmap.cli.options import LOW_HIGH, Formula, Given, Orders, Out, Values, Variable
from pwmap.cli.results import Results, Writers, asked, results_in, table_in, typed
from pwmap.maps.budget import BUDGET, Budget
from pwmap.plane.colours import Colours

if TYPE_CHECKING:
    from pwmap.plane.plane import ParameterPlane
    from pwmap.plane.rasters import PlaneRaster

PICTURE, TABLES = "plane", ("plane_curves.csv", "plane_points.csv")
PLANE, RASTER = "plane.json", "plane_raster.json"  # itself, and the raster of --colours

Rationals = Annotated[tuple[str, str], screen.option("Two rationals.", metavar=LOW_HIGH)]


def draw_plane(
    context: typer.Context,
    formula: Formula,
    across: Annotated[str, screen.option("The parameter of the horizontal axis.")],
    along: Annotated[str, screen.option("The parameter of the vertical axis.")],
    across_span: Rationals,
    along_span: Rationals,
    set_: Values = None,
    orders: Orders = "1,2",
    given: Given = None,
    variable: Variable = "x",
    pieces: Annotated[
        int, screen.option("How many pieces of all iterates of a strip may be computed.", least=1)
    ] = BUDGET.pieces,
    colours: Annotated[
        Colours | None,
        screen.option("What attracts at each point of a raster; by default that of cells."),
    ] = None,
    raster: Annotated[
        tuple[int, int] | None,
        screen.option(
            "Columns and rows of the raster of --colours; by default 48 and 36.",
            metavar="<columns> <rows>",
            least=1,
        ),
    ] = None,
    crises: Annotated[
        int | None,
        screen.option(
            "Curves of crises, too, which takes minutes: by words up to this order first.", least=1
        ),
    ] = None,
    picture: screen.Formats = None,
    out: Out = Path("out"),
) -> None:
    """Cut a rectangle of two parameters into cells, exactly, and name the curves between them.

    Strips of cells are found from left to right. Ctrl-C keeps what is finished of them, of curves
    of crises and of the raster, as tables, as JSON and as a picture.

    Example: pwmap plane "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))" --across a --along b
    --across-span 1/10 11/10 --along-span -5 -1/2 --orders 1,2,3 --colours bands
    """
    from pwmap.plane.plane import checked_axes

    asked.set(("plane", {"map": formula, **typed(context)}))
    with screen.told(screen.NOTHING_KEPT):
        if raster is not None and colours is None:
            raise ValueError("--raster needs --colours, which say what is drawn on it")
        screen.take_formats(picture)
        fixed = reading.assignments(set_ or ())
        map_ = reading.map_of(formula, variable, given or (), fixed, across, along)
        spans = (
            reading.exact_span(across_span, "--across-span"),
            reading.exact_span(along_span, "--along-span"),
        )
        axes = (across, along, *spans, reading.orders_of(orders))
        checked_axes(map_, across, along)
        seen_on = None if colours is None else raster or (48, 36)
        with results_in(out) as results:
            with screen.progress() as bar, results.budget(bar, "plane", pieces) as budget:
                found, seen = _computed(map_, axes, crises, seen_on, budget, results)
            results.missing = ", without the picture"
            results.write(_files(found) | ({} if seen is None else {RASTER: seen.save}))
            screen.show(*tables(found))
            for sentence in filter(None, (found.left_out, "" if seen is None else seen.left_out)):
                screen.say(sentence)
            drawn = plot.plot_plane(found, raster=seen, colours=colours or Colours.PERIOD)
            results.draw(PICTURE, drawn.figure)


def _computed(
    map_: pwmap.PiecewiseLinearMap,
    axes: tuple[Any, ...],
    crises: int | None,
    raster: tuple[int, int] | None,
    budget: Budget,
    results: Results,
) -> tuple[ParameterPlane, PlaneRaster | None]:
    from pwmap.plane.crisiscurves import CRISIS_BUDGET
    from pwmap.plane.rasters import RASTER_BUDGET

    found, seen = pwmap.parameter_plane(map_, *axes, budget=budget), None
    if crises is not None and not results.stopped:
        found = pwmap.plane.with_crises(
            found, crises, budget=replace(budget, work=CRISIS_BUDGET.work)
        )
    if raster is not None and not results.stopped:
        seen = pwmap.plane.plane_raster(
            found, *raster, budget=replace(budget, work=RASTER_BUDGET.work)
        )
    return found, seen


def _files(found: ParameterPlane) -> Writers:
    from pwmap.plane.curves import curve_columns, point_columns

    points = point_columns(found.points, (found.across, found.along))
    files: Writers = {PLANE: found.save}
    for name, columns in zip(TABLES, (curve_columns(found.curves), points), strict=True):
        files[name] = table_in(tuple(columns), zip(*columns.values(), strict=True))
    return files


def tables(found: ParameterPlane) -> Iterator[Table]:
    """Tables of curves and points for people."""
    from pwmap.plane.curves import doubles

    curves = (
        (curve.id, f"{curve.kind.label}{', ' * bool(curve.note)}{curve.note}",
         " ".join(curve.words), str(curve.polynomial), " and ".join(filter(None, curve.ends)))
        for curve in found.curves
    )  # fmt: skip
    yield screen.table(("curve", "what", "cycles", "zero on it", "ends"), curves, "Curves")
    points = (
        (point.id, point.kind.label, *(f"{value:.12g}" for value in doubles(point)),
         " ".join(point.curves))
        for point in found.points
    )  # fmt: skip
    header = ("point", "what", str(found.across), str(found.along), "curves")
    yield screen.table(header, points, "Points")
