"""The command ``woodpecker map``: the return map, as table and picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rich.table import Table

import woodpecker
from pwmap.cli.results import Results, results_in
from pwmap.cli.screen import Formats, option, progress, say, show, table
from pwmap.diagrams.files import rows_as_text, write_whole
from pwmap.diagrams.shown import counted
from woodpecker.cli.options import Out, Window
from woodpecker.mechanics.toy import Toy

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from woodpecker.base.arrays import Floats
    from woodpecker.plot.curve import MapSamples

PICTURE, TABLE = "return_map", "return_map.csv"
RETURNS_MOST = 10**7  # in all: some five minutes, and a table of 300 MB because of the words
COLUMNS = ("phi_s_start", "phi_s", "period", "drop", "slope", "status", "word")


def draw_map(
    toy: Toy,
    order: Annotated[int, option("Number of returns j of P_j.", least=1)] = 1,
    window: Window = (-2.5, 0.11),
    points: Annotated[int, option("Number of starts.", least=2)] = 4000,
    picture: Formats = None,
    out: Out = Path("out"),
) -> None:
    """Compute and draw the return map P_j with the diagonal and its jumps.

    More starts at steep places tell jumps from flanks; how many stay open is printed. Ctrl-C keeps
    the finished starts, as a table without the picture.

    Example: woodpecker map --eps-n1 0.125 --window -1.2 -0.4
    """
    import numpy as np

    from woodpecker.base.checks import interval
    from woodpecker.plot.curve import Link
    from woodpecker.plot.figures import plot_curve
    from woodpecker.simulation.returns import checked_starts

    if order * points > RETURNS_MOST:
        raise ValueError(
            f"--order times --points must be at most {RETURNS_MOST} returns, some five minutes, "
            f"got {order} times {points}: ask for fewer starts"
        )
    low, high = interval("window", window, finite=True)
    starts = checked_starts(toy, np.linspace(low, high, points))
    if not (np.diff(starts) > 0.0).all():
        raise ValueError(f"window has no {points} different numbers in it, got ({low}, {high})")
    with results_in(out) as results:
        with progress() as bar:
            returns, text = _computed(toy, order, starts, bar, results)
        results.write({TABLE: lambda path: write_whole(path, text.encode())})
        show(_outcomes(returns))
        if not results.stopped:
            with progress() as bar:
                curve = _looked_closer(toy, returns, order, bar)
            results.draw(PICTURE, plot_curve(curve, order=order, returns=returns).figure)
            if curve.between(Link.OPEN).size:
                say(_left_out(curve, order))


def _computed(
    toy: Toy, order: int, starts: Floats, bar: Bar, results: Results
) -> tuple[woodpecker.ReturnMap, str]:
    """The map at the starts, or after Ctrl-C at the finished ones; and the same as CSV."""
    # Rows become text as they are found: at the end a million rows would take many seconds.
    from woodpecker.simulation.returns import chunk_of, joined

    parts: list[tuple[woodpecker.ReturnMap, str]] = []
    step = 4 * chunk_of(order)
    # Compile in this thread, which can be interrupted.
    woodpecker.return_map(toy, starts[:1], order)
    task = bar.add_task(f"P_{order}", total=len(starts))
    try:
        for k in range(0, len(starts), step):
            part = woodpecker.return_map(toy, starts[k : k + step], order)
            parts.append((part, rows_as_text(_rows(part))))
            bar.advance(task, len(part))
    except KeyboardInterrupt:
        if not parts:
            raise
        kept = sum(len(part) for part, _ in parts)
        results.stop(f"Interrupted: {kept} of {len(starts)} starts are kept, as a table")
    returns, texts = zip(*parts, strict=True)
    return joined(returns), "".join((rows_as_text([COLUMNS]), *texts))


def _looked_closer(toy: Toy, returns: woodpecker.ReturnMap, order: int, bar: Bar) -> MapSamples:
    from woodpecker.plot.figures import curves

    task = bar.add_task("steep places", total=None)
    for curve in curves(toy, returns, order):
        bar.update(task, description=f"steep places, {curve.evaluations} more starts")
    return curve


def _rows(returns: woodpecker.ReturnMap) -> Iterator[Sequence[object]]:
    names = [reason.name.lower() for reason in returns.status]
    numbers = (
        column.tolist()
        for column in (returns.start, returns.phi_s, returns.period, returns.drop, returns.slope)
    )
    return zip(*numbers, names, returns.words, strict=True)


def _outcomes(returns: woodpecker.ReturnMap) -> Table:
    rows = [(str(returns.status.count(each)), each.value) for each in dict.fromkeys(returns.status)]
    return table(("starts", "outcome"), rows, counted(len(set(returns.words)), "word"))


def _left_out(curve: MapSamples, order: int) -> str:
    from woodpecker.plot.curve import BUDGET, Link

    return (
        f"The picture leaves open, drawn pale, whether P_{order} jumps or is only steep at "
        f"{curve.between(Link.OPEN).size} places, together {curve.open_width:.3g} rad wide: "
        f"{order * curve.evaluations} of at most {BUDGET} returns were spent on the others"
    )
