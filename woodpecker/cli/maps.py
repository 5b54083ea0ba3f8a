"""The command ``woodpecker map``: the return map, as table and picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pwmap.diagrams.files import PictureFormat, in_format, rows_as_text, write_whole
from woodpecker.cli.interrupts import finished, heard, held
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

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.table import Table

    from woodpecker import ReturnMap
    from woodpecker.base.arrays import Floats
    from woodpecker.plot.curve import Curve

FILES = ("return_map.png", "return_map.csv")
COLUMNS = ("phi_s_start", "phi_s", "period", "drop", "slope", "status", "word")


def draw_map(
    toy: Toy,
    order: Annotated[int, option("Number of returns j of P_j.", min=1)] = 1,
    window: Window = (-2.5, 0.11),
    points: Annotated[int, option("Number of starts.", min=2)] = 4000,
    picture: Format = PictureFormat.PNG,
    out: Out = Path("out"),
) -> None:
    """Compute and draw the return map P_j with the diagonal and its jumps.

    The picture looks closer at steep places to tell jumps from flanks, and says how many it leaves
    open. Ctrl-C keeps the starts that are finished, as a table without the picture.

    Example: woodpecker map --eps-n1 0.125 --window -1.2 -0.4
    """
    import numpy as np

    from woodpecker.base.checks import interval
    from woodpecker.plot.curve import Link
    from woodpecker.simulation.returns import checked_starts

    low, high = interval("window", window, finite=True)
    starts = checked_starts(toy, np.linspace(low, high, points))
    files = in_format(FILES, picture)
    with results_in(out) as target, progress() as bar:
        found = _computed(toy, order, starts, bar)
        curve = None
        try:
            with held():
                write_whole(target / files[1], found.table.encode())
            if not found.stopped:
                curve = _drawn(toy, found.returns, order, target / files[0], bar)
        except KeyboardInterrupt:  # the table is there
            heard()
        finished()
    console.print(_outcomes(found.returns))
    if curve is not None and curve.between(Link.OPEN).size:
        say(_left_out(curve, order))
    report(target, *(files[1:] if curve is None else files))
    if curve is None:
        complain(f"Interrupted: {len(found.returns)} of {points} starts are kept, as a table")
        raise typer.Exit(INTERRUPTED)


class _Computed(NamedTuple):
    """A return map, the same as CSV, and whether Ctrl-C ended it."""

    returns: ReturnMap
    table: str
    stopped: bool


def _computed(toy: Toy, order: int, starts: Floats, bar: Bar) -> _Computed:
    """The map at the starts, as many as are finished at Ctrl-C.

    The table grows with it: a million rows take many seconds to become text, which nobody who
    wants the command to end would wait for.
    """
    from woodpecker import return_map
    from woodpecker.simulation.returns import chunk_of, joined

    parts: list[tuple[ReturnMap, str]] = []
    stopped, step = False, 4 * chunk_of(order)
    return_map(toy, starts[:1], order)  # compiled in this thread, which hears of signals
    task = bar.add_task(f"P_{order}", total=len(starts))
    try:
        for k in range(0, len(starts), step):
            part = return_map(toy, starts[k : k + step], order)
            parts.append((part, rows_as_text(_rows(part))))
            bar.advance(task, len(part))
    except KeyboardInterrupt:
        heard()
        stopped = True
    if not parts:
        raise KeyboardInterrupt
    returns, texts = zip(*parts, strict=True)
    return _Computed(joined(returns), "".join((rows_as_text([COLUMNS]), *texts)), stopped)


def _drawn(toy: Toy, returns: ReturnMap, order: int, path: Path, bar: Bar) -> Curve:
    """Draw the picture, and give what it shows."""
    from pwmap.diagrams.files import write_figure
    from woodpecker.plot.figures import curves, plot_curve

    task = bar.add_task("steep places", total=None)
    for curve in curves(toy, returns, order):
        bar.update(task, description=f"steep places, {curve.evaluations} more starts")
    write_figure(path, plot_curve(curve, order=order, returns=returns).figure)
    return curve


def _rows(returns: ReturnMap) -> Iterator[Sequence[object]]:
    """One row of the table for each start."""
    names = [reason.name.lower() for reason in returns.status]
    numbers = (
        column.tolist()
        for column in (returns.start, returns.phi_s, returns.period, returns.drop, returns.slope)
    )
    return zip(*numbers, names, returns.words, strict=True)


def _outcomes(returns: ReturnMap) -> Table:
    """How many starts ended how, for the screen."""
    from rich.table import Table

    table = Table("starts", "outcome", title=f"{len(set(returns.words))} words")
    for reason in dict.fromkeys(returns.status):
        table.add_row(str(returns.status.count(reason)), reason.value)
    return table


def _left_out(curve: Curve, order: int) -> str:
    """What the picture does not resolve."""
    from woodpecker.plot.curve import Detail, Link

    return (
        f"The picture leaves open, drawn pale, whether P_{order} jumps or is only steep at "
        f"{curve.between(Link.OPEN).size} places, together {curve.open_width:.3g} rad wide: "
        f"{order * curve.evaluations} of at most {Detail().budget} returns were spent on the others"
    )
