"""The commands ``woodpecker simulate`` and ``woodpecker animate``: a motion of the toy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from rich.table import Table

import woodpecker
from pwmap.cli.results import Writers, results_in, table_in
from pwmap.cli.screen import Formats, option, progress, say, show, table
from pwmap.diagrams.shown import counted
from woodpecker.cli.options import GUESS, CommandError, Out, Start, motion
from woodpecker.mechanics.toy import Toy

LISTED = 40  # events that are printed
PICTURES = ("time_history", "phase_portraits")
SPEEDS = ("dy", "dphi_m", "dphi_s")


def simulate(
    toy: Toy,
    phi_s: Start = None,
    t_end: Annotated[float | None, option("Time to stop at [s]; by default two periods.")] = None,
    samples: Annotated[int, option("Evenly spaced samples.", least=2)] = 2001,
    picture: Formats = None,
    out: Out = Path("out"),
) -> None:
    """Follow the toy in time; draw its time history and phase portraits, list its events.

    Example: woodpecker simulate --eps-n1 0.3 --phi-s -0.6 --t-end 0.5
    """
    from woodpecker.plot.motions import plot_phase_portraits, plot_time_history

    _check(toy, phi_s, t_end)
    with results_in(out) as results:
        start, finish = _start_and_end(toy, phi_s, t_end, periods=2.0)
        trajectory = woodpecker.simulate(toy, start, finish, samples=samples)
        results.write(_tables(trajectory))
        show(_events(trajectory))
        for name, plot in zip(PICTURES, (plot_time_history, plot_phase_portraits), strict=True):
            results.draw(name, plot(trajectory).figure)
    _complete(trajectory)


def animate(
    toy: Toy,
    phi_s: Start = None,
    t_end: Annotated[float | None, option("Time to stop at [s]; by default one period.")] = None,
    slow: Annotated[float, option("How many times slower than nature.")] = 40.0,
    fps: Annotated[float, option("Frames per second [1/s].")] = 25.0,
    size: Annotated[
        tuple[float, float], option("In inches of 100 pixels each.", metavar="<width> <height>")
    ] = (3.0, 4.0),
    file: Annotated[str, option("Name in the folder, .gif or .mp4.")] = "woodpecker.gif",
    out: Out = Path("out"),
) -> None:
    """Draw the moving toy: an animated GIF, or an MP4 where ffmpeg is installed.

    Example: woodpecker animate --eps-n1 0.3 --slow 60
    """
    from woodpecker.plot import drawing

    if Path(file).name != file:
        raise ValueError(f"file must be a name without folders, got {file!r}")
    drawing.film_writer(Path(file), slow, fps, size)
    _check(toy, phi_s, t_end)
    with results_in(out, file) as results:
        start, finish = _start_and_end(toy, phi_s, t_end, periods=1.0)
        trajectory = woodpecker.simulate(toy, start, finish)
        results.replace()
        with progress() as bar:
            task = bar.add_task("frames", total=1.0)
            drawing.animate(
                trajectory, results.folder / file, slow=slow, fps=fps, size=size,
                progress=lambda share: bar.update(task, completed=share),
            )  # fmt: skip
        results.names.append(file)
        say(_end(trajectory))
    _complete(trajectory)


def _check(toy: Toy, phi_s: float | None, t_end: float | None) -> None:
    """ValueError for an impossible start or end; called before old files are replaced."""
    from woodpecker.base.checks import positive
    from woodpecker.simulation.returns import checked_starts

    if phi_s is not None:
        checked_starts(toy, phi_s)
    if t_end is not None:
        positive("t_end", t_end)


def _start_and_end(
    toy: Toy, phi_s: float | None, t_end: float | None, periods: float
) -> tuple[float, float]:
    """Start [rad] and end [s] of a motion, by default from the periodic motion."""
    if phi_s is not None and t_end is not None:
        return phi_s, t_end
    try:
        orbit = motion(toy, GUESS if phi_s is None else phi_s)
    except CommandError as reason:
        if t_end is not None:
            raise
        raise CommandError(
            f"{reason}; to follow another motion, give --phi-s and --t-end"
        ) from None
    return (
        orbit.phi_s if phi_s is None else phi_s,
        periods * orbit.period if t_end is None else t_end,
    )


def _tables(trajectory: woodpecker.Trajectory) -> Writers:
    columns = trajectory.t.tolist(), *trajectory.q.T.tolist(), *trajectory.u.T.tolist()
    sides = (f"{name}_{side}" for side in ("before", "after") for name in SPEEDS)
    events = ((e.time, e.symbol, *e.u_before, *e.u_after) for e in trajectory.events)
    return {
        "trajectory.csv": table_in(
            ("t", "y", "phi_m", "phi_s", *SPEEDS), zip(*columns, strict=True)
        ),
        "events.csv": table_in(("t", "event", *sides), events),
    }


def _events(trajectory: woodpecker.Trajectory) -> Table:
    rows = [(f"{event.time:.9f}", event.symbol) for event in trajectory.events[:LISTED]]
    if len(trajectory.events) > LISTED:
        rows.append(("...", f"{len(trajectory.events) - LISTED} more in events.csv"))
    return table(("t [s]", "event"), rows, _end(trajectory))


def _end(trajectory: woodpecker.Trajectory) -> str:
    fell = "without end" if math.isinf(trajectory.drop) else f"{trajectory.drop:.7f} m"
    return f"{trajectory.status.value}; fell {fell}"


def _complete(trajectory: woodpecker.Trajectory) -> None:
    status = woodpecker.Status
    gave_up = (
        status.EVENT_LIMIT, status.CONTACT_NO_SOLUTION, status.CONTACT_AMBIGUOUS, status.OVERFLOW
    )  # fmt: skip
    if trajectory.status in gave_up:
        raise CommandError(
            f"the motion was followed to t = {trajectory.t_end:.9g} s only, after "
            f"{counted(len(trajectory.events), 'event')}: {trajectory.status.value}"
        )
