"""The command ``pwmap plane``: two parameters of a map, with the curves on which cycles change."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pwmap.cli_reading import assignments, map_of, orders_of
from pwmap.cli_screen import bar_on, in_words, screen, tell_written
from pwmap.diagrams.files import PictureFormat, in_format
from pwmap.maps.budget import BUDGET, Budget
from pwmap.plane.colours import Colours

if TYPE_CHECKING:
    from rich.table import Table

    from pwmap.plane.plane import ParameterPlane
    from pwmap.plane.rasters import PlaneRaster

FILES = ("plane.png", "plane_curves.csv", "plane_points.csv")


def draw_plane(
    formula: Annotated[str, typer.Argument(help="The map, as the text of a sympy Piecewise.")],
    across: Annotated[str, typer.Option(help="The parameter of the horizontal axis.")],
    along: Annotated[str, typer.Option(help="The parameter of the vertical axis.")],
    across_span: Annotated[tuple[str, str], typer.Option(help="Two rationals.")],
    along_span: Annotated[tuple[str, str], typer.Option(help="Two rationals.")],
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", help="Value of another parameter, such as a=5/4; repeatable."),
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
    picture: Annotated[
        PictureFormat, typer.Option("--format", help="Format of the pictures.")
    ] = PictureFormat.PNG,
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
    curves of crises and of the raster what is.

    Example: pwmap plane "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))" --across a --along b
    --across-span 1/10 11/10 --along-span -5 -1/2 --orders 1,2,3 --colours bands
    """
    from pwmap import parameter_plane, plane_raster, with_crises
    from pwmap.diagrams.record import keep_record, record_of
    from pwmap.plane.crisiscurves import SEARCH
    from pwmap.plane.rasters import RASTER

    errors = screen(stderr=True)
    try:
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        seen: PlaneRaster | None = None
        with bar_on(errors) as bar:
            task, interrupts = bar.add_task("strips", total=None), list[bool]()
            budget = Budget(
                pieces=pieces,
                progress=lambda at: bar.update(
                    task, description=at.what or "strips", completed=at.done, total=at.total or None
                ),
                on_interrupt=lambda: interrupts.append(True),
            )
            found = parameter_plane(
                map_, across, along, across_span, along_span, orders_of(orders), budget=budget
            )
            if crises is not None and not interrupts:
                found = with_crises(found, crises, budget=replace(budget, work=SEARCH.work))
            if colours is not None and not interrupts:
                seen = plane_raster(found, *raster, budget=replace(budget, work=RASTER.work))
        out.mkdir(parents=True, exist_ok=True)
        files = in_format(FILES, picture)
        _write(found, seen, colours, out, files)
        asked: dict[str, object] = {
            "map": formula, "variable": variable, "across": across, "along": along,
            "across_span": across_span, "along_span": along_span, "set": set_ or [],
            "given": given or [], "orders": orders, "colours": colours, "crises": crises,
            "raster": raster, "pieces": pieces, "format": picture,
        }  # fmt: skip
        gone = keep_record(out, "plane", files, asked)
    except KeyboardInterrupt:
        errors.print("Interrupted: there is nothing to keep yet", style="red")
        raise typer.Exit(130) from None
    except (ValueError, TypeError, OSError) as error:
        errors.print(f"Error: {in_words(error)}", style="red", highlight=False, soft_wrap=True)
        raise typer.Exit(2) from None
    console = screen()
    for table in tables(found):
        console.print(table)
    for sentence in filter(None, (found.left_out, seen.left_out if seen is not None else "")):
        console.print(sentence, highlight=False)
    tell_written(console, out, (*files, record_of("plane")), gone)
    if interrupts:
        errors.print("Interrupted: what was finished is kept", style="red")
        raise typer.Exit(130)


def _write(
    found: ParameterPlane, seen: PlaneRaster | None, colours: Colours | None, folder: Path,
    files: Sequence[str],
) -> None:  # fmt: skip
    """The picture and both tables."""
    from pwmap.diagrams.files import write_figure, write_table
    from pwmap.plane.tables import curve_columns, point_columns
    from pwmap.plot_plane import plot_plane

    drawn = plot_plane(found, raster=seen, colours=colours or Colours.PERIOD)
    write_figure(folder / files[0], drawn.figure)
    points = point_columns(found.points, (found.across, found.along))
    for name, columns in zip(files[1:], (curve_columns(found.curves), points), strict=True):
        write_table(folder / name, tuple(columns), zip(*columns.values(), strict=True))


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
