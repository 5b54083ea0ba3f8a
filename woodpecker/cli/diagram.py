"""The command ``woodpecker diagram``: branches of the return map over a parameter."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import pwmap
import woodpecker
from pwmap import plot
from pwmap.cli.interrupts import INTERRUPTED
from pwmap.cli.reading import orders_of
from pwmap.cli.results import Results, results_in
from pwmap.cli.screen import Formats, in_words, option, progress, say, show
from pwmap.diagrams.files import write_whole
from pwmap.diagrams.shown import counted
from woodpecker.base.lost import WorkerLostError
from woodpecker.cli.options import GUESS, Out, Window, ends, motion
from woodpecker.cli.toys import parameter_of
from woodpecker.mechanics.toy import WINDOW, Toy

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from woodpecker.search import Found, Stage

RUN = "run.jsonl"
PAPER = "A=0.111,-0.884 B=0.29,-0.884 C=0.185,-0.757"
NAMED = "eps_n1"  # the parameter over which these places are named
CORES = os.cpu_count() or 1


def diagram(
    toy: Toy,
    parameter: Annotated[str, option("Parameter of the toy to vary.")] = "eps_n1",
    span: Annotated[tuple[float, float], ends("Interval of the parameter.")] = (0.0, 1.0),
    phi_s: Annotated[
        float, option("Guess for the periodic motion to start from, phi_S [rad].")
    ] = GUESS,
    order: Annotated[int, option("Number of returns j of the motion.", least=1)] = 1,
    orders: Annotated[
        str | None,
        option("Every branch of these iterates, such as 1,2 or 1-4, not one motion's only."),
    ] = None,
    also: Annotated[
        str | None,
        option(
            "Iterates, such as 2,4, to follow beside the motion's own: at a flip the doubled "
            "branch starts."
        ),
    ] = None,
    window: Window = WINDOW,
    step: Annotated[float, option("Largest step along a branch, in arclength.")] = 0.02,
    resume: Annotated[
        bool, option("Go on with an interrupted run in the folder.", "--resume")
    ] = False,
    workers: Annotated[
        int | None,
        option("Processes for --orders; by default, and at most, one for each core.", least=1),
    ] = None,
    names: Annotated[
        str,
        option(
            "Names for the border collisions nearest to these places (parameter, phi_S); by "
            "default, over eps_n1, those of the paper, read off its Figure 10. For any point, such "
            "as flip=PD1, by its id."
        ),
    ] = PAPER,
    words: Annotated[
        bool, option("Mark in the picture where the sequence of events changes.", "--words")
    ] = False,
    observables: Annotated[
        str | None,
        option(
            "Columns of branches.csv besides the multiplier: period [s], drop [m], or period,drop."
        ),
    ] = None,
    models: Annotated[
        bool,
        option("Draw each fold-flip of P_1 with the exact model of its neighbourhood.", "--models"),
    ] = False,
    picture: Formats = None,
    out: Out = Path("out"),
) -> None:
    """Follow a periodic motion in a parameter; draw its bifurcation diagram, export its graph.

    With --orders find every branch in the window instead, also islands. Every finished branch is
    written to run.jsonl at once: --resume goes on with an interrupted run.

    Example: woodpecker diagram --orders 1,2 --span 0.03 0.2 --window -1.2 -0.45
    """
    from woodpecker.diagrams import bifurcation_search

    settings = woodpecker.Settings(span=span, window=window, step=min(0.005, step), max_step=step)
    parameter = parameter_of(parameter)
    places = {} if names == PAPER and parameter != NAMED else places_of(names)
    columns = _columns(observables) if observables is not None else ()
    listed = orders_of(orders) if orders is not None else []
    beside = orders_of(also, "--also") if also is not None else []
    if beside and listed:
        raise ValueError("--also follows one motion, --orders every branch: take one of them")
    if workers is not None and workers > CORES:
        raise ValueError(f"workers must be at most {CORES}, one for each core, got {workers}")
    with results_in(out, RUN, kept=(RUN,) if resume else ()) as results:
        orbit = None if listed else motion(toy, phi_s, order)
        with progress() as bar:
            keep: dict[str, Any] = {"run": out / RUN, "resume": resume, "settings": settings}
            keep["progress"] = _shown(bar, parameter, results)
            try:
                if orbit is not None:
                    followed = (orbit.minimal_period, *beside)
                    found = woodpecker.continuation(
                        toy, orbit, parameter, span, orders=followed, **keep
                    )
                    summary = orbit.message if orbit.minimal_period < orbit.order else ""
                else:
                    search = bifurcation_search(
                        toy, parameter, span, listed, window, workers=workers, **keep
                    )
                    found, summary = search.diagram, _summary(search)
            except (KeyboardInterrupt, WorkerLostError, MemoryError) as stopped:
                found, summary = _kept(stopped, out / RUN, results), ""
        found, unnamed = _named(found, places)
        found = _written(toy, found, columns, summary, results)
        if not results.stopped:
            _draw(found, results, words)
            if models:
                _draw_models(toy, found, results)
            if unnamed:
                results.stop(f"Error: --names: {unnamed}", 2)


def _named(
    found: pwmap.Diagram, places: dict[str, tuple[float, float] | str]
) -> tuple[pwmap.Diagram, str]:
    """The diagram with names for its points and no reason, or unchanged with the reason."""
    try:
        return found.named(places), ""
    except (KeyError, ValueError) as error:
        return found, str(error.args[0])


def _kept(stopped: BaseException, run: Path, results: Results) -> pwmap.Diagram:
    if not run.exists():
        raise stopped
    why, status = "Interrupted", INTERRUPTED
    if not isinstance(stopped, KeyboardInterrupt):
        why, status = f"Broken off: {in_words(stopped)}", 1
    results.stop("", status)  # already now, since reading the kept branches takes a while
    kept = woodpecker.saved_diagram(run)
    branches = counted(len(kept.branches), "branch")
    results.stop(f"{why}: {branches} kept, as tables; go on with --resume", status)
    return kept


def _shown(bar: Bar, parameter: str, results: Results) -> Callable[[Stage], None]:
    task = bar.add_task(parameter, total=None)

    def show(stage: Stage) -> None:
        results.replace()  # not before: until a run has begun it may be refused
        slices = f", slice {stage.slices}" if stage.slices else ""
        bar.update(
            task,
            description=f"P_{stage.order}{slices}, {counted(stage.branches, 'branch')}, "
            f"{parameter} = {stage.parameter:.4f}",
        )

    return show


def _written(
    toy: Toy, found: pwmap.Diagram, columns: tuple[str, ...], summary: str, results: Results
) -> pwmap.Diagram:
    """Write tables and graphs, without observables if the search was interrupted."""
    from pwmap.diagrams.tables import FILES, results_as_bytes, table_of_points

    shown = found if results.stopped else woodpecker.observables(toy, found, *columns)
    content = cache(partial(results_as_bytes, shown))  # made where Ctrl-C does not end it
    results.write(dict.fromkeys(FILES, lambda path: write_whole(path, content()[path.name])))
    results.names.append(RUN)
    if not results.stopped:
        show(table_of_points(shown))
        for line in filter(None, (summary, str(found.about.get("left", "")))):
            say(line)
    return shown


def _draw(found: pwmap.Diagram, results: Results, words: bool) -> None:
    from woodpecker.plot.plane import label

    orders = sorted({branch.order for branch in found.branches})
    parts = {f"order_{order}": found.of_order(order) for order in orders}
    for name, part in {"diagram": found, **(parts if len(parts) > 1 else {})}.items():
        drawn = plot.plot_diagram(part, words=words)
        drawn.ax.set_xlabel(label(found.parameter_name))  # of the toy, and so with its unit
        results.draw(name, drawn.figure)


def _draw_models(toy: Toy, found: pwmap.Diagram, results: Results) -> None:
    from woodpecker.plot.figures import plot_local

    map_ = woodpecker.ToyPieces(toy, found.parameter_name)
    for point in found.points:
        if point.kind is pwmap.PointKind.FF and point.order == 1:
            try:
                model = woodpecker.local_model(map_, point.x, point.parameter)
            except ValueError as reason:
                say(f"{point.id} has no local model: {reason}")
                continue
            results.draw(f"local_{point.id}", plot_local(model, found).figure)


def _summary(everything: Found) -> str:
    slices = everything.slices
    unresolved = max(seen.unresolved for seen in slices)
    left = sum(len(seen.left) for seen in slices)
    new = sum(bool(seen.new) for seen in slices)
    return (
        f"{counted(len(slices), 'slice')}, {new} showed something new, {counted(left, 'place')} "
        f"could not be followed, at most {unresolved:.1e} rad of a slice unresolved\n"
        f"P_1 was evaluated {counted(everything.evaluations, 'time')}"
    )


def places_of(text: str) -> dict[str, tuple[float, float] | str]:
    """Names with places, as in ``A=0.111,-0.884``, or ids, as in ``flip=PD1``, from a text."""
    found: dict[str, tuple[float, float] | str] = {}
    for part in text.split():
        name, _, place = part.partition("=")
        if name in found:
            raise ValueError(f"--names needs one place for each name, got two for {name}")
        if name and place.isidentifier():
            if place in found.values():
                raise ValueError(f"--names needs one name for each point, got two for {place}")
            found[name] = place
            continue
        try:
            p, x = (float(number) for number in place.split(","))
            if not (math.isfinite(p) and math.isfinite(x)):
                raise ValueError
        except ValueError:
            raise ValueError(
                f"--names needs name=parameter,phi_S or name=id for each, got {part!r}"
            ) from None
        found[name] = p, x
    return found


def _columns(text: str) -> tuple[str, ...]:
    from woodpecker.branches import known_observables

    names = tuple(part.strip() for part in text.split(","))
    known_observables(names)
    return names
