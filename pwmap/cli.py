"""The command ``pwmap``: exact analysis of a piecewise-linear map given as text."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pwmap.cli_certificates import check_files, prove_map
from pwmap.cli_plane import draw_plane
from pwmap.cli_reading import assignments, map_of, orders_of
from pwmap.cli_screen import bar_on, in_words, screen, tell_written
from pwmap.diagrams.files import PictureFormat
from pwmap.maps.budget import BUDGET, Budget, Progress

if TYPE_CHECKING:  # help and refusals come before what computes is loaded
    from rich.progress import Progress as Bar

    from pwmap.cli_longrun import LongRun
    from pwmap.diagrams.diagram import Diagram
    from pwmap.maps.piecewise_linear import PiecewiseLinearMap

app = typer.Typer(
    help="Exact analysis of piecewise-linear discontinuous maps of the line.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
console = screen()
errors = screen(stderr=True)
INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C has ended


def _tell_version(asked: bool) -> None:
    if asked:
        from pwmap import __version__

        console.print(f"pwmap {__version__}", highlight=False)
        raise typer.Exit


@app.callback()
def _before(
    _: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and leave.", callback=_tell_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Exact analysis of piecewise-linear discontinuous maps of the line."""
    os.environ["MPLBACKEND"] = "Agg"  # draw into files only, said before matplotlib is loaded


@app.command()
def analyse(
    formula: Annotated[str, typer.Argument(help="The map, as the text of a sympy Piecewise.")],
    parameter: Annotated[str, typer.Option(help="The parameter to vary.")],
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", help="Value of another parameter, such as a=5/4; repeatable."),
    ] = None,
    orders: Annotated[str, typer.Option(help="Iterates to look at, such as 1,2,3.")] = "1,2",
    span: Annotated[
        tuple[str, str] | None,
        typer.Option(help="Two rationals; by default all that happens.", show_default=False),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option(help="An assumption on parameters that stay symbolic, such as 'a > 1'."),
    ] = None,
    sample: Annotated[
        list[str] | None,
        typer.Option(
            help="A value, such as b=3, of a parameter that stays symbolic: formulas hold around "
            "it; repeatable, once for each such parameter. By default one that is admitted."
        ),
    ] = None,
    variable: Annotated[str, typer.Option(help="The variable of the map.")] = "x",
    pieces: Annotated[
        int, typer.Option(help="How many pieces of all iterates may be computed.", min=1)
    ] = BUDGET.pieces,
    attractors: Annotated[
        bool, typer.Option("--attractors", help="Attracting cycles, bands and crises, too.")
    ] = False,
    entropy: Annotated[
        bool, typer.Option("--entropy", help="Bounds of the topological entropy, too.")
    ] = False,
    density: Annotated[
        list[str] | None,
        typer.Option(help="A value of the parameter whose invariant density is drawn; repeatable."),
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
    """Find all branches and special points over a parameter, exactly; draw and export them.

    The iterates are taken order by order. If that takes more pieces than allowed, or is ended by
    Ctrl-C, the orders that were completed are kept; Ctrl-C later keeps the diagram, and what is
    known of the long run. Files of tables are written then, pictures are not; Ctrl-C again ends it
    at once. What attracts in the long run, and how complex it is, is asked for by --attractors and
    --entropy, which need a span, and by --density.

    Example: pwmap analyse "Piecewise((r - 2, x <= 0), (r - a*x, True))" --parameter r --set a=5/4
    """
    from pwmap.cli_longrun import LongRun
    from pwmap.diagrams.record import keep_record, record_of
    from pwmap.diagrams.tables import FILES, write_results

    pictures, others, interrupts = list[str](), list[str](), list[bool]()
    try:
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        with bar_on(errors) as bar:
            budget = Budget(pieces=pieces, on_interrupt=lambda: interrupts.append(True))
            found = _computed(
                map_, parameter, span, orders_of(orders), budget,
                assignments(sample, "--sample") if sample else None, bar,
            )  # fmt: skip
            more = LongRun(map_, parameter, span, interrupts, bar)
            more.ask(
                attractors=attractors, entropy=entropy, density=tuple(density or ()),
                order=max(orders_of(orders)),
            )  # fmt: skip
        out.mkdir(parents=True, exist_ok=True)
        asked: dict[str, object] = {
            "map": formula, "variable": variable, "parameter": parameter, "set": set_ or [],
            "given": given or [], "orders": orders, "span": span, "sample": sample or [],
            "pieces": pieces, "attractors": attractors, "entropy": entropy,
            "density": density or [], "format": picture,
        }  # fmt: skip
        shown = more.added(found)
        shown = replace(shown, about={**shown.about, "map": formula, "set": set_ or []})
        write_results(shown, out)
        others += [*FILES, *more.write(out)]
        if not interrupts:
            try:
                for name in _draw(found, more, out, picture):
                    pictures.append(name)  # each is there, if the next one is interrupted
                for name in more.draw(out, picture):
                    others.append(name)
                _tell(shown, more)
            except KeyboardInterrupt:  # the tables are there
                interrupts.append(True)
        names = [*pictures, *others]
        gone = keep_record(out, "analyse", names, asked)
    except KeyboardInterrupt:
        kept = "files may be missing" if interrupts else "there is nothing to keep yet"
        errors.print(f"Interrupted: {kept}", style="red")
        raise typer.Exit(INTERRUPTED) from None
    except (ValueError, TypeError, OSError) as error:
        errors.print(f"Error: {in_words(error)}", style="red", highlight=False, soft_wrap=True)
        raise typer.Exit(2) from None
    tell_written(console, out, (*names, record_of("analyse")), gone)
    if interrupts:
        for sentence in (*shown.given, *more.left_out):
            console.print(sentence, highlight=False)
        errors.print("Interrupted: what was finished is kept, without pictures", style="red")
        raise typer.Exit(INTERRUPTED)


def _tell(found: Diagram, more: LongRun) -> None:
    """All tables for a person."""
    from pwmap.diagrams.tables import table_of_branches, table_of_points

    for table in (table_of_branches(found), table_of_points(found), *more.tables()):
        console.print(table)


def _computed(
    map_: PiecewiseLinearMap,
    parameter: str,
    span: tuple[str, str] | None,
    orders: list[int],
    budget: Budget,
    sample: dict[str, str] | None,
    bar: Bar,
) -> Diagram:
    """The diagram; a bar says how far it is."""
    from pwmap import bifurcation_diagram

    task = bar.add_task("order 1", total=max(orders, default=1))

    def tell(done: Progress) -> None:
        more = f"order {done.order + 1}" if done.order < max(orders) else "points and branches"
        text = f"{more}, {done.cells} cells and {done.pieces} pieces so far"
        bar.update(task, completed=done.order, description=text)

    return bifurcation_diagram(map_, parameter, span, orders, sample, budget=budget, progress=tell)


def _draw(found: Diagram, more: LongRun, out: Path, picture: PictureFormat) -> Iterator[str]:
    """The diagram, over its bands if these are known, and each order if there are several."""
    from pwmap.diagrams.files import write_figure
    from pwmap.plot import plot_diagram

    orders = sorted({branch.order for branch in found.branches})
    values = ", ".join(f"{name} = {value}" for name, value in found.sample.items())
    for order in (0, *(orders if len(orders) > 1 else ())):
        whole = not order
        if whole and more.found is not None:
            drawn = more.drawn(found)
        else:
            drawn = plot_diagram(found if whole else found.of_order(order))
        if not whole:
            drawn.ax.set_title(f"$P_{{{order}}}$", fontsize=9)
        if values:  # exact in other parameters, too: a picture needs values of them
            before = drawn.ax.get_title()
            drawn.ax.set_title(f"{before}{', ' * bool(before)}drawn at {values}", fontsize=9)
        name = f"{'diagram' if whole else f'order_{order}'}.{picture}"
        write_figure(out / name, drawn.figure)
        yield name


app.command("plane")(draw_plane)
app.command("prove")(prove_map)
app.command("check")(check_files)


def run() -> None:
    """Entry point of the command."""
    app()
