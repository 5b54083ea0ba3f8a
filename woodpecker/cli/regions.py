"""The command ``woodpecker regions``: which cycles exist where in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import woodpecker
from pwmap.cli.reading import orders_of
from pwmap.cli.results import Results, Writers, results_in, table_in
from pwmap.cli.screen import Formats, option, progress, say, show, table
from pwmap.diagrams.shown import counted
from woodpecker.cli.curves import Parameters, Second, second_of, two_of, write_curves
from woodpecker.cli.options import Out, Window, ends
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.regions.survey import CHECKS, Survey

PICTURE, TABLES = "regions", ("regions.csv", "region_borders.csv")


def regions(
    toy: Toy,
    parameters: Parameters = "eps_n1,mu_2",
    span: Annotated[tuple[float, float], ends("Interval of the first parameter.")] = (0.1, 0.9),
    second_span: Second = None,
    orders: Annotated[str, option("Periods of cycles to count, such as 1,2 or 1-4.")] = "1",
    window: Window = WINDOW,
    checks: Annotated[int, option("Random places at which cycles are counted.", least=1)] = CHECKS,
    picture: Formats = None,
    out: Out = Path("out"),
) -> None:
    """Divide the plane of two parameters into regions in which the same cycles exist.

    Cycles are counted at random places to find the curves between regions. The whole window has
    hundreds of islands: a smaller one gives a simpler picture, sooner.

    Example: woodpecker regions --second-span 0.29 0.34 --window -0.9 -0.45
    """
    from woodpecker.plot.regions import plot_regions

    first, second = two_of(parameters)
    spans, wanted = (span, second_of(toy, second, second_span)), orders_of(orders)
    with results_in(out) as results:
        curves: list[woodpecker.Curve] = []
        found: woodpecker.regions.Regions | None = None
        with progress() as bar:
            task = bar.add_task(f"{first}, {second}", total=None)

            def tell(curve: woodpecker.Curve) -> None:
                curves.append(curve)
                bar.update(task, description=f"{curve.kind} over {first}, {second}")

            try:
                found = woodpecker.regions.parameter_regions(
                    toy, (first, second), spans, orders=wanted, window=window,
                    survey=Survey(checks=checks), progress=tell,
                )  # fmt: skip
            except KeyboardInterrupt:
                _keep(curves, results)
        if found is not None:
            results.write(_tables(found))
            header = ("region", "share", *found.names, "lives there", "orbits come to")
            show(table(header, _described(found)))
            say(
                f"{len(found.open)} places disagree with their region: a curve is missing there"
                if found.open
                else f"all of {found.checks} random places agree; a region smaller than what lies "
                "between them may be missing: --checks takes more"
            )
            results.draw(PICTURE, plot_regions(found).figure)


def _keep(curves: list[woodpecker.Curve], results: Results) -> None:
    if not curves:
        raise KeyboardInterrupt
    kept = counted(len(curves), "curve")
    results.stop(f"Interrupted: {kept} kept, as tables; no regions between them")
    write_curves({str(number): curve for number, curve in enumerate(curves, start=1)}, results)


def _tables(found: woodpecker.regions.Regions) -> Writers:
    counts = [f"{word}_{n}" for n in found.orders for word in ("stable", "unstable")]
    regions = (
        (
            number, region.share, *region.place,
            *(count for each in region.census for count in each[1:]),
            ", ".join(map(str, region.attractors)), region.agree,
        )
        for number, region in enumerate(found.regions, start=1)
    )  # fmt: skip
    borders = (
        (number, ring, *place)
        for number, region in enumerate(found.regions, start=1)
        for ring, outline in enumerate((region.outline, *region.holes))
        for place in outline.tolist()
    )
    header = ("region", "share", *found.names, *counts, "attractors", "agree")
    return {
        TABLES[0]: table_in(header, regions),
        TABLES[1]: table_in(("region", "ring", *found.names), borders),
    }


def _described(found: woodpecker.regions.Regions) -> Iterator[tuple[str, ...]]:
    from woodpecker.plot.regions import described

    for number, region in enumerate(found.regions, start=1):
        place = (f"{v:.5g}" for v in region.place)
        attractors = ", ".join(map(str, region.attractors))
        share = f"{100.0 * region.share:.3g} %"
        yield str(number), share, *place, described(region.census), attractors
