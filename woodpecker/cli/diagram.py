"""The command ``woodpecker diagram``: branches of the return map over a parameter."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pwmap.diagrams.files import PictureFormat
from pwmap.diagrams.shown import counted
from woodpecker.base.lost import WorkerLostError
from woodpecker.cli.interrupts import heard
from woodpecker.cli.options import (
    GUESS,
    INTERRUPTED,
    Format,
    Out,
    Window,
    complain,
    console,
    motion,
    option,
    progress,
    report,
    results_in,
    say,
)
from woodpecker.mechanics.toy import Toy, known_parameter
from woodpecker.window import WINDOW

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from pwmap import Diagram
    from woodpecker import Found, Stage

RUN = "run.jsonl"
PAPER = "A=0.111,-0.884 B=0.29,-0.884 C=0.185,-0.757"
NAMED = "eps_n1"  # the parameter of these places
CORES = os.cpu_count() or 1


Parameter = Annotated[str, option("Parameter of the toy to vary.")]
Span = Annotated[tuple[float, float], option("Interval of the parameter.")]
Guess = Annotated[float, option("Guess for the periodic motion to start from, phi_S [rad].")]
Order = Annotated[int, option("Number of returns j of the motion.", min=1)]
Orders = Annotated[
    str | None, option("Every branch of these iterates, such as 1,2, not one motion's only.")
]
Also = Annotated[
    str | None,
    option(
        "Iterates, such as 2,4, to follow beside the motion's own: at a flip the doubled branch "
        "starts."
    ),
]
Step = Annotated[float, option("Largest step along a branch, in arclength.")]
Resume = Annotated[bool, option("Go on with an interrupted run in the folder.", "--resume")]
Workers = Annotated[
    int | None,
    option("Processes for --orders; by default, and at most, one for each core.", min=1),
]
Names = Annotated[
    str,
    option(
        "Names for the border collisions nearest to these places (eps_n1, phi_S); by default those "
        "of the paper, read off its Figure 10."
    ),
]
Words = Annotated[
    bool, option("Mark in the picture where the sequence of events changes.", "--words")
]
Observables = Annotated[
    str | None,
    option("Columns of branches.csv besides the multiplier: period [s], drop [m], or period,drop."),
]


def diagram(
    toy: Toy,
    parameter: Parameter = "eps_n1",
    span: Span = (0.0, 1.0),
    phi_s: Guess = GUESS,
    order: Order = 1,
    orders: Orders = None,
    also: Also = None,
    window: Window = WINDOW,
    step: Step = 0.02,
    resume: Resume = False,
    workers: Workers = None,
    names: Names = PAPER,
    words: Words = False,
    observables: Observables = None,
    picture: Format = PictureFormat.PNG,
    out: Out = Path("out"),
) -> None:
    """Follow a periodic motion in a parameter; draw its bifurcation diagram, export its graph.

    With --orders find every branch in the window instead, islands too. Every finished branch is
    kept in run.jsonl at once: an interrupted run goes on with --resume.

    Example: woodpecker diagram --orders 1,2 --span 0.03 0.2 --window -1.2 -0.45
    """
    from woodpecker import Settings

    settings = Settings(span=span, window=window, step=min(0.005, step), max_step=step)
    known_parameter(parameter)
    shows = _Shows(
        places=places_of(names) if parameter == NAMED else {},
        columns=_columns(observables) if observables is not None else (),
        words=words,
        picture=picture,
    )
    wanted = orders_of(orders) if orders is not None else None
    beside = orders_of(also, "--also") if also is not None else []
    if beside and wanted is not None:
        raise ValueError("--also follows one motion, --orders every branch: take one of them")
    if workers is not None and workers > CORES:
        raise ValueError(f"workers must be at most {CORES}, one for each core, got {workers}")
    with results_in(out) as target:
        keep: dict[str, Any] = {"run": target / RUN, "resume": resume, "settings": settings}
        if wanted is None:
            search = _of_motion(toy, phi_s, order, parameter, keep | {"orders": beside})
        else:
            search = _of_orders(toy, wanted, parameter, workers, keep)
        found = _searched(search, parameter, target / RUN)
        _write(toy, found, shows, target)
    if found.stopped:
        kept = counted(len(found.diagram.branches), "branch")
        complain(f"{found.stopped}: {kept} kept, as tables; go on with --resume")
        raise typer.Exit(found.status)


class _Shows(NamedTuple):
    """What is shown of a diagram, and in which format.

    Names by their places, columns of branches, whether changes of word are marked.
    """

    places: dict[str, tuple[float, float]]
    columns: tuple[str, ...]
    words: bool
    picture: PictureFormat


class _Searched(NamedTuple):
    """A diagram, what there is to say of the search, and why it was broken off, if it was.

    ``status`` is that with which the command ends.
    """

    diagram: Diagram
    summary: str = ""
    stopped: str = ""
    status: int = 0


_Show = Callable[["Stage"], None]
_Search = Callable[[_Show], _Searched]


def _of_motion(toy: Toy, phi_s: float, order: int, parameter: str, keep: dict[str, Any]) -> _Search:
    """How to find what hangs together with one motion."""
    from woodpecker import continuation

    orbit = motion(toy, phi_s, order)
    keep = keep | {"orders": (orbit.minimal_period, *keep["orders"])}
    summary = orbit.message if orbit.minimal_period < orbit.order else ""

    def search(show: _Show) -> _Searched:
        span = keep["settings"].span
        return _Searched(continuation(toy, orbit, parameter, span, progress=show, **keep), summary)

    return search


def _of_orders(
    toy: Toy, orders: list[int], parameter: str, workers: int | None, keep: dict[str, Any]
) -> _Search:
    """How to find everything in the window."""
    from woodpecker import find_all

    span, window = keep["settings"].span, keep["settings"].window

    def search(show: _Show) -> _Searched:
        everything = find_all(
            toy, parameter, span, orders, window, workers=workers, progress=show, **keep
        )
        return _Searched(everything.diagram, _summary(everything))

    return search


def _searched(search: _Search, parameter: str, run: Path) -> _Searched:
    """Search with a progress bar; after Ctrl-C what the run has kept."""
    from woodpecker import saved_diagram

    with progress() as bar:
        try:
            found = search(_shown(bar, parameter))
            left = str(found.diagram.about.get("left", ""))
            return found._replace(summary="\n".join(filter(None, (found.summary, left))))
        except (KeyboardInterrupt, WorkerLostError, MemoryError) as stopped:
            heard()
            if not run.exists():
                raise
            why, status = "Interrupted", INTERRUPTED
            if not isinstance(stopped, KeyboardInterrupt):
                why, status = "Broken off: " + (str(stopped) or "no memory is left"), 1
            return _Searched(saved_diagram(run), stopped=why, status=status)


def _shown(bar: Bar, parameter: str) -> _Show:
    """Shows how far a search has come."""
    task = bar.add_task(parameter, total=None)

    def show(stage: Stage) -> None:
        slices = f", slice {stage.slices}" if stage.slices else ""
        bar.update(
            task,
            description=f"P_{stage.order}{slices}, {stage.branches} branches, "
            f"{parameter} = {stage.parameter:.4f}",
        )

    return show


def _write(toy: Toy, found: _Searched, shows: _Shows, target: Path) -> None:
    """Pictures, tables and graphs; the special points on the screen too.

    Of a search that was broken off tables and graphs only, so that it ends at once.
    """
    from pwmap.diagrams.tables import FILES, table_of_points, write_results
    from woodpecker import observables as observed

    shown = found.diagram.named(shows.places)
    if found.stopped:
        write_results(shown, target)
        report(target, *FILES, RUN)
        return
    shown = observed(toy, shown, *shows.columns)
    write_results(shown, target)
    pictures = _draw(shown, target, shows)
    console.print(table_of_points(shown))
    if found.summary:
        say(found.summary)
    pictures += _draw_models(toy, shown, target, shows.picture)
    report(target, *pictures, *FILES, RUN)


def _draw(found: Diagram, target: Path, shows: _Shows) -> list[str]:
    """The diagram, and each order on its own if there are several."""
    from pwmap.diagrams.files import write_figure
    from pwmap.plot import plot_diagram

    words, form = shows.words, shows.picture
    names = [f"diagram.{form}"]
    write_figure(target / names[0], plot_diagram(found, words=words).figure)
    orders = sorted({branch.order for branch in found.branches})
    for order in orders if len(orders) > 1 else ():
        names.append(f"order_{order}.{form}")
        write_figure(target / names[-1], plot_diagram(found.of_order(order), words=words).figure)
    return names


def _draw_models(toy: Toy, found: Diagram, target: Path, form: PictureFormat) -> list[str]:
    """Fold-flips of P_1 with their models, where there is one."""
    from pwmap import PointKind
    from pwmap.diagrams.files import write_figure
    from woodpecker import ToyPieces, local_model
    from woodpecker.plot.figures import plot_local

    map_, names = ToyPieces(toy, found.parameter_name), list[str]()
    for point in found.points:
        if point.kind is PointKind.FF and point.order == 1:
            try:
                model = local_model(map_, point.x, point.parameter)
            except ValueError as reason:
                say(f"{point.id} has no local model: {reason}")
                continue
            names.append(f"local_{point.id}.{form}")
            write_figure(target / names[-1], plot_local(model, found).figure)
    return names


def _summary(everything: Found) -> str:
    """What a search came to, in a sentence or two."""
    slices = everything.slices
    unresolved = max(seen.unresolved for seen in slices)
    left = sum(len(seen.left) for seen in slices)
    return (
        f"{len(slices)} slices, {sum(bool(seen.new) for seen in slices)} showed something new, "
        f"{left} places could not be followed, at most {unresolved:.1e} rad of a slice unresolved\n"
        f"P_1 was evaluated {everything.evaluations} times"
    )


def places_of(text: str) -> dict[str, tuple[float, float]]:
    """Names and their places, such as ``A=0.111,-0.884``, separated by blanks."""
    found = {}
    for part in text.split():
        name, _, place = part.partition("=")
        try:
            p, x = (float(number) for number in place.split(","))
        except ValueError:
            raise ValueError(f"--names needs name=eps_n1,phi_S for each, got {part!r}") from None
        found[name] = p, x
    return found


def _columns(text: str) -> tuple[str, ...]:
    """Names of observables."""
    from woodpecker.solutions import known_observables

    names = tuple(part.strip() for part in text.split(","))
    known_observables(names)
    return names


def orders_of(text: str, name: str = "--orders") -> list[int]:
    """Iterates from text."""
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(f"{name} needs integers such as 1,2,3, got {text!r}") from None
