"""The command ``woodpecker``: simulate, animate, map, diagram."""

from __future__ import annotations

import inspect
import logging
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import matplotlib as mpl
import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from pwmap.diagram import Diagram, PointKind
from pwmap.files import write_figure, write_table
from pwmap.results import FILES, table_of_points, write_results
from woodpecker.diagram import WINDOW, Found, continuation, find_all, saved_diagram
from woodpecker.explore import Stage
from woodpecker.local import local_model
from woodpecker.returns import CHUNK, ReturnMap, return_map
from woodpecker.settings import Settings
from woodpecker.shooting import PeriodicOrbit, shoot, toy_map
from woodpecker.toy import Toy, known_parameter
from woodpecker.trajectory import simulate as run_simulation

app = typer.Typer(
    help="The Woodpecker Toy: exact simulation, return map, bifurcation diagram.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
console = Console()
errors = Console(stderr=True)

Out = Annotated[Path, typer.Option(help="Folder for the results; made if it is missing.")]
GUESS = -0.53  # rad, near the stable cycle of the paper's data set
UNITS = {
    "m_m": "kg", "m_s": "kg", "j_m": "kg m^2", "j_s": "kg m^2", "g": "m/s^2", "c_phi": "N m/rad",
    **dict.fromkeys(("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s", "pole"), "m"),
}  # fmt: skip


class _FailureError(Exception):
    """A computation that ended without a result; the message is for the user."""


def _with_toy(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command one option for each parameter of the toy, and turn errors into sentences.

    The command receives the toy as its first argument.
    """
    own = list(inspect.signature(command).parameters.values())[1:]
    toy_options = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=field.default,
            annotation=Annotated[
                float,
                typer.Option(
                    help=f"[{UNITS.get(field.name, '-')}]", rich_help_panel="Parameters of the toy"
                ),
            ],
        )
        for field in fields(Toy)
    ]

    def wrapped(**values: Any) -> None:
        try:
            toy = Toy(**{field.name: values.pop(field.name) for field in fields(Toy)})
            command(toy, **values)
        except (ValueError, TypeError, OSError) as error:
            errors.print(f"Error: {error}", style="red", highlight=False, soft_wrap=True)
            raise typer.Exit(2) from None
        except _FailureError as failure:
            errors.print(f"Failed: {failure}", style="red", highlight=False, soft_wrap=True)
            raise typer.Exit(1) from None

    keyword = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in own]
    wrapped.__signature__ = inspect.Signature([*keyword, *toy_options])  # type: ignore[attr-defined]
    wrapped.__annotations__ = {p.name: p.annotation for p in [*keyword, *toy_options]}
    wrapped.__doc__, wrapped.__name__ = command.__doc__, command.__name__
    return wrapped


@app.command()
@_with_toy
def simulate(
    toy: Toy,
    phi_s: Annotated[
        float | None,
        typer.Option(help="Start at rest on the section [rad]; by default on the periodic motion."),
    ] = None,
    t_end: Annotated[
        float | None, typer.Option(help="Time to stop at [s]; by default two periods.")
    ] = None,
    samples: Annotated[int, typer.Option(min=2, help="Evenly spaced samples.")] = 2001,
    out: Out = Path("out"),
) -> None:
    """Follow the toy in time; draw its time history and phase portraits, list its events.

    Example: woodpecker simulate --eps-n1 0.3 --phi-s -0.6 --t-end 0.5
    """
    folder, start, finish = _folder(out), phi_s, t_end
    if start is None or finish is None:
        orbit = _cycle(toy, GUESS if start is None else start)
        start = orbit.phi_s if start is None else start
        finish = 2.0 * orbit.period if finish is None else finish
    trajectory = run_simulation(toy, start, finish, samples=samples)
    figures = _plots()
    for name, axes in (
        ("time_history", figures.plot_time_history(trajectory)),
        ("phase_portraits", figures.plot_phase_portraits(trajectory)),
    ):
        write_figure(folder / f"{name}.png", axes[0].figure)
    columns = ("t", "y", "phi_m", "phi_s", "dy", "dphi_m", "dphi_s")
    samples_table = zip(
        trajectory.t.tolist(), *trajectory.q.T.tolist(), *trajectory.u.T.tolist(), strict=True
    )
    write_table(folder / "trajectory.csv", columns, samples_table)
    rows = [
        (event.time, event.symbol, *event.u_before, *event.u_after) for event in trajectory.events
    ]
    speeds = ("dy", "dphi_m", "dphi_s")
    header = ["t", "event", *(f"{name}_before" for name in speeds)]
    header += [f"{name}_after" for name in speeds]
    write_table(folder / "events.csv", header, rows)
    table = Table("t [s]", "event", title=f"{trajectory.status.value}; fell {_mm(trajectory.drop)}")
    for row in rows[:40]:
        table.add_row(f"{row[0]:.9f}", row[1])
    if len(rows) > 40:
        table.add_row("...", f"{len(rows) - 40} more in events.csv")
    console.print(table)
    _report(folder, "time_history.png", "phase_portraits.png", "trajectory.csv", "events.csv")


@app.command()
@_with_toy
def animate(
    toy: Toy,
    phi_s: Annotated[
        float | None,
        typer.Option(help="Start at rest on the section [rad]; by default on the periodic motion."),
    ] = None,
    t_end: Annotated[
        float | None, typer.Option(help="Time to stop at [s]; by default one period.")
    ] = None,
    slow: Annotated[float, typer.Option(help="How many times slower than nature.")] = 40.0,
    fps: Annotated[float, typer.Option(help="Frames per second.")] = 25.0,
    file: Annotated[str, typer.Option(help="Name in the folder, .gif or .mp4.")] = "woodpecker.gif",
    out: Out = Path("out"),
) -> None:
    """Draw the moving toy: an animated GIF, or an MP4 where ffmpeg is installed.

    Example: woodpecker animate --eps-n1 0.3 --slow 60
    """
    folder, start, finish = _folder(out), phi_s, t_end
    if start is None or finish is None:
        orbit = _cycle(toy, GUESS if start is None else start)
        start = orbit.phi_s if start is None else start
        finish = orbit.period if finish is None else finish
    trajectory = run_simulation(toy, start, finish)
    with _progress() as progress:
        task = progress.add_task("frames", total=1.0)
        _plots().animate(
            trajectory, folder / file, slow=slow, fps=fps,
            progress=lambda share: progress.update(task, completed=share),
        )  # fmt: skip
    console.print(f"{trajectory.status.value}; fell {_mm(trajectory.drop)}")
    _report(folder, file)


@app.command(name="map")
@_with_toy
def draw_map(
    toy: Toy,
    order: Annotated[int, typer.Option(min=1, help="Number of returns j of P_j.")] = 1,
    window: Annotated[tuple[float, float], typer.Option(help="Interval of phi_S [rad].")] = (
        -2.5,
        0.11,
    ),
    points: Annotated[int, typer.Option(min=2, help="Number of starts.")] = 4000,
    out: Out = Path("out"),
) -> None:
    """Compute and draw the return map P_j with the diagonal and its jumps.

    Example: woodpecker map --eps-n1 0.125 --window -1.2 -0.4
    """
    import numpy as np

    if not window[0] < window[1]:
        raise ValueError(f"window must ascend, got {window[0]} {window[1]}")
    folder, starts = _folder(out), np.linspace(*window, points)
    parts: list[ReturnMap] = []
    with _progress() as progress:
        task = progress.add_task("return map", total=points)
        for k in range(0, points, 4 * CHUNK):
            parts.append(return_map(toy, starts[k : k + 4 * CHUNK], order))
            progress.advance(task, len(parts[-1].start))
    returns = ReturnMap(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("start", "phi_s", "period", "drop", "slope", "d_eps_n1")
        },
        words=tuple(text for part in parts for text in part.words),
        status=tuple(reason for part in parts for reason in part.status),
    )
    figure = _plots().plot_return_map(toy, returns, order=order).figure
    write_figure(folder / "return_map.png", figure)
    columns = ("phi_s_start", "phi_s", "period", "drop", "slope", "status", "word")
    write_table(
        folder / "return_map.csv",
        columns,
        zip(
            returns.start.tolist(), returns.phi_s.tolist(), returns.period.tolist(),
            returns.drop.tolist(), returns.slope.tolist(),
            [reason.name.lower() for reason in returns.status], returns.words, strict=True,
        ),
    )  # fmt: skip
    outcomes = {reason: returns.status.count(reason) for reason in dict.fromkeys(returns.status)}
    table = Table("starts", "outcome", title=f"{len(set(returns.words))} words")
    for reason, count in outcomes.items():
        table.add_row(str(count), reason.value)
    console.print(table)
    _report(folder, "return_map.png", "return_map.csv")


@app.command()
@_with_toy
def diagram(
    toy: Toy,
    parameter: Annotated[str, typer.Option(help="Parameter of the toy to vary.")] = "eps_n1",
    span: Annotated[tuple[float, float], typer.Option(help="Interval of the parameter.")] = (
        0.0,
        1.0,
    ),
    phi_s: Annotated[
        float, typer.Option(help="Guess for the periodic motion to start from [rad].")
    ] = GUESS,
    order: Annotated[int, typer.Option(min=1, help="Number of returns j of the motion.")] = 1,
    orders: Annotated[
        str | None,
        typer.Option(help="Every branch of these iterates, such as 1,2, not one motion's only."),
    ] = None,
    window: Annotated[tuple[float, float], typer.Option(help="Interval of phi_S [rad].")] = WINDOW,
    step: Annotated[float, typer.Option(help="Largest step along a branch.")] = 0.02,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with an interrupted run in the folder.")
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes for --orders; by default one for each core."),
    ] = None,
    out: Out = Path("out"),
) -> None:
    """Follow a periodic motion in a parameter; draw its bifurcation diagram, export its graph.

    With --orders find every branch in the window instead, islands too. Every finished branch is
    kept in run.jsonl at once: an interrupted run goes on with --resume.

    Example: woodpecker diagram --orders 1,2 --span 0.03 0.2 --window -1.2 -0.45
    """
    settings = Settings(
        span=span, window=window, step=min(0.005, step), max_step=step
    )  # before anything is computed: it checks the values
    known_parameter(parameter)
    wanted = _orders(orders) if orders is not None else None
    folder = _folder(out)
    run_file = folder / "run.jsonl"
    orbit = _cycle(toy, phi_s, order) if wanted is None else None
    summary, stopped = "", False
    with _progress() as progress:
        task = progress.add_task(parameter, total=None)

        def show(stage: Stage) -> None:
            slices = f", slice {stage.slices}" if stage.slices else ""
            progress.update(
                task,
                description=f"P_{stage.order}{slices}, {stage.branches} branches, "
                f"{parameter} = {stage.parameter:.4f}",
            )

        keep: dict[str, Any] = {
            "settings": settings, "progress": show, "run": run_file, "resume": resume,
        }  # fmt: skip
        try:
            if orbit is not None:
                found = continuation(toy, orbit, parameter, span, **keep)
            else:
                everything = find_all(
                    toy, parameter, span, wanted or (), window, workers=workers, **keep
                )
                found, summary = everything.diagram, _searched(everything)
        except KeyboardInterrupt:
            found, stopped = saved_diagram(run_file), True
    names = _draw_diagrams(toy, found, folder)
    write_results(found, folder)
    console.print(table_of_points(found))
    if summary:
        console.print(summary, highlight=False)
    _report(folder, *names, *FILES)
    if stopped:
        errors.print(
            f"Interrupted: {len(found.branches)} branches are kept; go on with --resume",
            style="red", highlight=False, soft_wrap=True,
        )  # fmt: skip
        raise typer.Exit(130)


def _draw_diagrams(toy: Toy, found: Diagram, folder: Path) -> list[str]:
    """The diagram, each order on its own if there are several, and fold-flips with their models."""
    figures, names = _plots(), ["diagram.png"]
    write_figure(folder / names[0], figures.plot_diagram(found).figure)
    orders = sorted({branch.order for branch in found.branches})
    for order in orders if len(orders) > 1 else ():
        names.append(f"order_{order}.png")
        part = found.of_order(order)
        write_figure(folder / names[-1], figures.plot_diagram(part).figure)
    labelled_map = toy_map(toy, found.parameter_name)
    for point in found.points:
        if point.kind is PointKind.FF and point.order == 1:
            model = local_model(labelled_map, point.x, point.parameter)
            names.append(f"local_{point.id}.png")
            write_figure(folder / names[-1], figures.plot_local(model, found))
    return names


def _searched(everything: Found) -> str:
    """What a search came to, in lines."""
    lines = [
        f"P_{report.order}: {len(report.slices)} slices, {len(report.found_at)} showed something "
        f"new, {len(report.not_followed)} places could not be followed, at most {report.steep} "
        f"cycles of a slice too steep and {report.unresolved:.1e} rad of it unresolved"
        for report in everything.reports
    ]
    return "\n".join([*lines, f"P_1 was evaluated {everything.evaluations} times"])


def _cycle(toy: Toy, guess: float, order: int = 1) -> PeriodicOrbit:
    orbit = shoot(toy, guess, order)
    if not orbit.success:
        raise _FailureError(f"no periodic motion near phi_S = {guess}: {orbit.message}")
    return orbit


def _orders(text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(f"--orders needs integers such as 1,2,3, got {text!r}") from None


def _plots() -> Any:
    """The plotting functions, loaded when a picture is drawn and without a screen."""
    mpl.use("Agg")
    from types import SimpleNamespace

    from pwmap.plot import plot_diagram
    from woodpecker import drawing, plot

    return SimpleNamespace(animate=drawing.animate, **{**vars(plot), "plot_diagram": plot_diagram})


def _folder(out: Path) -> Path:
    """The folder for the results, made before anything long is computed."""
    out.mkdir(parents=True, exist_ok=True)
    return out


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=errors,
        transient=True,
    )  # fmt: skip


def _mm(length: float) -> str:
    return "without end" if math.isinf(length) else f"{1e3 * length:.4f} mm"


def _report(folder: Path, *names: str) -> None:
    console.print("wrote " + ", ".join(str(folder / name) for name in names), soft_wrap=True)


def run() -> None:
    """Entry point of the command."""
    logging.basicConfig(format="%(message)s")
    app()


if __name__ == "__main__":
    run()
