"""The command ``woodpecker regions``: where in the plane of two parameters which cycles live."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pwmap.diagrams.files import PictureFormat, in_format
from pwmap.diagrams.shown import counted
from woodpecker.cli.curves import FILES as CURVES
from woodpecker.cli.curves import Parameters, Second, second_of, two_of, write_curves
from woodpecker.cli.diagram import orders_of
from woodpecker.cli.interrupts import heard
from woodpecker.cli.options import (
    INTERRUPTED,
    Format,
    Out,
    Window,
    complain,
    console,
    option,
    progress,
    report,
    results_in,
    say,
)
from woodpecker.mechanics.toy import Toy
from woodpecker.plane.survey import Survey
from woodpecker.window import WINDOW

if TYPE_CHECKING:
    from rich.table import Table

    from woodpecker import Curve, Regions

FILES = ("regions.png", "regions.csv", "region_borders.csv")


def regions(
    toy: Toy,
    parameters: Parameters = "eps_n1,mu_2",
    span: Annotated[tuple[float, float], option("Interval of the first parameter.")] = (0.1, 0.9),
    second_span: Second = None,
    orders: Annotated[str, option("Periods of the cycles that are counted.")] = "1",
    window: Window = WINDOW,
    checks: Annotated[
        int, option("Random places at which cycles are counted.", min=1)
    ] = Survey().checks,
    picture: Format = PictureFormat.PNG,
    out: Out = Path("out"),
) -> None:
    """Cut the plane of two parameters into regions in which the same cycles live.

    Curves between regions are found by counting cycles at random places. In the whole window there
    are hundreds of islands: a smaller one gives a simpler picture, sooner.

    Example: woodpecker regions --second-span 0.29 0.34 --window -0.9 -0.45
    """
    from woodpecker import parameter_regions

    first, second = two_of(parameters)
    spans, wanted = (span, second_of(toy, second, second_span)), orders_of(orders)
    with results_in(out) as target:
        with progress() as bar:
            task = bar.add_task(f"{first}, {second}", total=None)
            curves: list[Curve] = []

            def show(curve: Curve) -> None:
                curves.append(curve)
                bar.update(task, description=f"{curve.kind} over {first}, {second}")

            try:
                found = parameter_regions(
                    toy, (first, second), spans, orders=wanted, window=window,
                    survey=Survey(checks=checks), progress=show,
                )  # fmt: skip
            except KeyboardInterrupt:
                heard()
                _keep(curves, target)
                raise typer.Exit(INTERRUPTED) from None
        files = in_format(FILES, picture)
        _write(found, target, files)
    console.print(_table(found))
    say(
        f"{len(found.open)} places disagree with their region: a curve is missing there"
        if found.open
        else f"all of {found.checks} random places agree"
    )
    report(target, *files)


def _keep(curves: list[Curve], target: Path) -> None:
    """What a search that was interrupted has found: curves, of which some may be double."""
    if not curves:
        raise KeyboardInterrupt
    write_curves({str(number): curve for number, curve in enumerate(curves, start=1)}, target)
    report(target, *CURVES[1:])
    kept = counted(len(curves), "curve")
    complain(f"Interrupted: {kept} kept, as tables; no regions between them")


def _write(found: Regions, target: Path, files: Sequence[str]) -> None:
    from pwmap.diagrams.files import write_figure, write_table
    from woodpecker.plot.regions import plot_regions

    write_figure(target / files[0], plot_regions(found).figure)
    counts = [f"{word}_{n}" for n in found.orders for word in ("stable", "unstable")]
    write_table(
        target / files[1],
        ("region", "share", *found.names, *counts, "attractors", "agree"),
        (
            (
                number, region.share, *region.place,
                *(count for each in region.census for count in each[1:]),
                ", ".join(map(str, region.attractors)), region.agree,
            )
            for number, region in enumerate(found.regions, start=1)
        ),
    )  # fmt: skip
    write_table(
        target / files[2],
        ("region", "ring", *found.names),
        (
            (number, ring, *place)
            for number, region in enumerate(found.regions, start=1)
            for ring, outline in enumerate((region.outline, *region.holes))
            for place in outline.tolist()
        ),
    )


def _table(found: Regions) -> Table:
    from rich.table import Table

    from woodpecker.plot.regions import described

    table = Table("region", "share", *found.names, "lives there", "orbits come to")
    for number, region in enumerate(found.regions, start=1):
        table.add_row(
            str(number), f"{100.0 * region.share:.3g} %", *(f"{v:.5g}" for v in region.place),
            described(region.census), ", ".join(map(str, region.attractors)),
        )  # fmt: skip
    return table
