"""The command ``woodpecker map``: the return map, as table and picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pwmap.diagrams.files import PictureFormat, in_format
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

if TYPE_CHECKING:
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
    open. Ctrl-C keeps what there is.

    Example: woodpecker map --eps-n1 0.125 --window -1.2 -0.4
    """
    import numpy as np

    from pwmap.diagrams.files import write_figure
    from woodpecker.base.checks import interval
    from woodpecker.plot.curve import Link
    from woodpecker.plot.figures import plot_curve
    from woodpecker.simulation.returns import checked_starts

    low, high = interval("window", window, finite=True)
    starts = checked_starts(toy, np.linspace(low, high, points))
    files = in_format(FILES, picture)
    with results_in(out) as target:
        found = _computed(toy, order, starts)
        write_figure(
            target / files[0], plot_curve(found.curve, order=order, returns=found.returns).figure
        )
        _write_table(found.returns, target / files[1])
    console.print(_outcomes(found.returns))
    if found.curve.between(Link.OPEN).size:
        say(_left_out(found.curve, order))
    report(target, *files)
    if found.stopped:
        kept = f"{len(found.returns.start)} of {points} starts are kept"
        complain(f"Interrupted: {kept}, and the picture is as far as it was")
        raise typer.Exit(INTERRUPTED)


class _Computed(NamedTuple):
    """A return map, and whether Ctrl-C ended it."""

    returns: ReturnMap
    curve: Curve
    stopped: bool


def _computed(toy: Toy, order: int, starts: Floats) -> _Computed:
    """The map at the starts, and its picture; after Ctrl-C as much as there is."""
    from woodpecker import return_map
    from woodpecker.plot.figures import curves
    from woodpecker.simulation.returns import CHUNK, joined

    parts: list[ReturnMap] = []
    curve, stopped = None, False
    return_map(toy, starts[:1], order)  # compiled in this thread, which hears of signals
    with progress() as bar:
        task = bar.add_task(f"P_{order}", total=len(starts))
        try:
            for k in range(0, len(starts), 4 * CHUNK):
                parts.append(return_map(toy, starts[k : k + 4 * CHUNK], order))
                bar.advance(task, len(parts[-1].start))
            bar.update(task, description="steep places", total=None)
            for curve in curves(toy, joined(parts), order):
                bar.update(task, description=f"steep places, {curve.evaluations} more starts")
        except KeyboardInterrupt:
            heard()
            stopped = True
    if not parts:
        raise KeyboardInterrupt
    returns = joined(parts)
    if curve is None:
        curve = next(curves(toy, returns, order))
    return _Computed(returns, curve, stopped)


def _write_table(returns: ReturnMap, path: Path) -> None:
    """One row for each start."""
    from pwmap.diagrams.files import write_table

    names = [reason.name.lower() for reason in returns.status]
    numbers = (
        column.tolist()
        for column in (returns.start, returns.phi_s, returns.period, returns.drop, returns.slope)
    )
    write_table(path, COLUMNS, zip(*numbers, names, returns.words, strict=True))


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
