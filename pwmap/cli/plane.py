"""The command ``pwmap plane``: two parameters of a map, with the curves on which cycles change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pwmap.cli.reading import assignments, exact, map_of, orders_of
from pwmap.cli.screen import (
    Formats,
    bar_on,
    complain,
    in_words,
    picture_format,
    say,
    screen,
    show,
    tell_replaced,
    tell_written,
)
from pwmap.diagrams.files import in_format
from pwmap.maps.budget import BUDGET, Budget
from pwmap.plane.colours import Colours

INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C has ended

if TYPE_CHECKING:
    from rich.table import Table

    from pwmap.plane.plane import ParameterPlane
    from pwmap.plane.rasters import PlaneRaster

PICTURE, TABLES = "plane.png", ("plane_curves.csv", "plane_points.csv")


def draw_plane(
    formula: Annotated[str, typer.Argument(help="The map, as the text of a sympy Piecewise.")],
    across: Annotated[str, typer.Option(help="The parameter of the horizontal axis.")],
    along: Annotated[str, typer.Option(help="The parameter of the vertical axis.")],
    across_span: Annotated[tuple[str, str], typer.Option(help="Two rationals.")],
    along_span: Annotated[tuple[str, str], typer.Option(help="Two rationals.")],
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Value of another parameter, such as a=5/4 or a=1.25; repeatable."
        ),
    ] = None,
    orders: Annotated[str, typer.Option(help="Iterates to look at, such as 1,2,3.")] = "1,2",
    given: Annotated[
        list[str] | None, typer.Option(help="An assumption on the parameters, such as 'a > 1'.")
    ] = None,
    variable: Annotated[str, typer.Option(help="The variable of the map.")] = "x",
    pieces: Annotated[
        int, typer.Option(help="How many pieces of all iterates of a strip may be computed.", min=1)
    ] = BUDGET.pieces,
    colours: Annotated[
        Colours | None,
        typer.Option(help="What attracts at each point of a raster; by default that of cells."),
    ] = None,
    raster: Annotated[tuple[int, int], typer.Option(help="Columns and rows of the raster.")] = (
        48,
        36,
    ),
    crises: Annotated[
        int | None,
        typer.Option(help="Curves of crises, too: by words up to this order first.", min=1),
    ] = None,
    picture: Formats = None,
    out: Annotated[
        Path,
        typer.Option(
            help="Folder for the results, made if missing; about_<command>.json says what made "
            "them."
        ),
    ] = Path("out"),
) -> None:
    """Cut a rectangle of two parameters into cells, exactly, and name the curves between them.

    Strips of cells are found from left to right; Ctrl-C keeps those that are finished, and of
    curves of crises and of the raster what is, as tables and as a picture.

    Example: pwmap plane "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))" --across a --along b
    --across-span 1/10 11/10 --along-span -5 -1/2 --orders 1,2,3 --colours bands
    """
    from pwmap import parameter_plane
    from pwmap.diagrams.record import keep_record, record_of
    from pwmap.plane import plane_raster, with_crises
    from pwmap.plane.crisiscurves import SEARCH
    from pwmap.plane.rasters import RASTER

    asked: dict[str, object] = {
        "map": formula, "variable": variable, "across": across, "along": along,
        "across_span": across_span, "along_span": along_span, "set": set_ or [],
        "given": given or [], "orders": orders, "colours": colours, "crises": crises,
        "raster": raster, "pieces": pieces, "format": picture or [],
    }  # fmt: skip
    names, interrupts = list[str](), list[bool]()
    try:
        (file,) = in_format((PICTURE,), picture_format(picture))
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        seen: PlaneRaster | None = None
        tell_replaced(out, "plane")
        with bar_on(screen(stderr=True)) as bar:
            task = bar.add_task("strips", total=None)
            budget = Budget(
                pieces=pieces,
                progress=lambda at: bar.update(
                    task, description=at.what or "strips", completed=at.done, total=at.total or None
                ),
                on_interrupt=lambda: interrupts.append(True),
            )
            found = parameter_plane(
                map_,
                across,
                along,
                (exact(across_span[0]), exact(across_span[1])),
                (exact(along_span[0]), exact(along_span[1])),
                orders_of(orders),
                budget=budget,
            )
            if crises is not None and not interrupts:
                found = with_crises(found, crises, budget=replace(budget, work=SEARCH.work))
            if colours is not None and not interrupts:
                seen = plane_raster(found, *raster, budget=replace(budget, work=RASTER.work))
        out.mkdir(parents=True, exist_ok=True)
        _write(found, out)
        names += TABLES
        try:
            show(*tables(found))
            _draw(found, seen, colours, out / file)
            names.append(file)
        except KeyboardInterrupt:  # the tables are there
            interrupts.append(True)
        gone = keep_record(out, "plane", names, asked)
    except KeyboardInterrupt:
        complain("Interrupted: there is nothing to keep yet")
        raise typer.Exit(INTERRUPTED) from None
    except (ValueError, TypeError, OSError) as error:
        complain(f"Error: {in_words(error)}")
        raise typer.Exit(2) from None
    for sentence in filter(None, (found.left_out, seen.left_out if seen is not None else "")):
        say(sentence)
    tell_written(out, (*names, record_of("plane")), gone)
    if interrupts:
        without = "" if file in names else ", without the picture"
        complain(f"Interrupted: what was finished is kept{without}")
        raise typer.Exit(INTERRUPTED)


def _write(found: ParameterPlane, folder: Path) -> None:
    """Both tables."""
    from pwmap.diagrams.files import write_table
    from pwmap.plane.tables import curve_columns, point_columns

    points = point_columns(found.points, (found.across, found.along))
    for name, columns in zip(TABLES, (curve_columns(found.curves), points), strict=True):
        write_table(folder / name, tuple(columns), zip(*columns.values(), strict=True))


def _draw(
    found: ParameterPlane, seen: PlaneRaster | None, colours: Colours | None, path: Path
) -> None:
    """The picture."""
    from pwmap.diagrams.files import write_figure
    from pwmap.plot.plane import plot_plane

    drawn = plot_plane(found, raster=seen, colours=colours or Colours.PERIOD)
    write_figure(path, drawn.figure)


def tables(found: ParameterPlane) -> Iterator[Table]:
    """Curves and points for a person."""
    from rich.table import Table

    from pwmap.plane.tables import doubles

    curves = Table("curve", "what", "cycles", "zero on it", "ends", title="Curves")
    for curve in found.curves:
        what = f"{curve.kind.label}{', ' * bool(curve.note)}{curve.note}"
        ends = " and ".join(filter(None, curve.ends))
        curves.add_row(curve.id, what, " ".join(curve.words), str(curve.polynomial), ends)
    yield curves
    points = Table("point", "what", str(found.across), str(found.along), "curves", title="Points")
    for point in found.points:
        values = (f"{value:.12g}" for value in doubles(point))
        points.add_row(point.id, point.kind.label, *values, " ".join(point.curves))
    yield points
