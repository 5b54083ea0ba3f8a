"""The command ``pwmap``: exact analysis of a piecewise-linear map given as text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import matplotlib as mpl
import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from pwmap.cli_certificates import check_files, prove_map
from pwmap.cli_longrun import LongRun
from pwmap.cli_plane import draw_plane
from pwmap.cli_reading import assignments, map_of, orders_of
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import PictureFormat, write_figure
from pwmap.diagrams.tables import FILES, table_of_branches, table_of_points, write_results
from pwmap.maps.budget import BUDGET, Budget, Progress
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.bifurcations import bifurcation_diagram

app = typer.Typer(
    help="Exact analysis of piecewise-linear discontinuous maps of the line.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
console = Console()
errors = Console(stderr=True)
INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C has ended


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
    out: Annotated[Path, typer.Option(help="Folder for the results; made if missing.")] = Path(
        "out"
    ),
) -> None:
    """Find all branches and special points over a parameter, exactly; draw and export them.

    The iterates are taken order by order. If that takes more pieces than allowed, or is ended by
    Ctrl-C, the orders that were completed are kept. What attracts in the long run, and how complex
    it is, is asked for by --attractors and --entropy, which need a span, and by --density.

    Example: pwmap analyse "Piecewise((r - 2, x <= 0), (r - a*x, True))" --parameter r --set a=5/4
    """
    try:
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        found, interrupted = _computed(
            map_, parameter, span, orders_of(orders), Budget(pieces=pieces)
        )
        more = LongRun(map_, parameter, span, attractors=attractors, entropy=entropy,
                       density=tuple(density or ()), order=max(orders_of(orders)))  # fmt: skip
        out.mkdir(parents=True, exist_ok=True)
        pictures = _draw(found, more, out, picture)
        found = more.added(found)
        write_results(found, out)
        written = more.write(out, picture)
    except KeyboardInterrupt:
        errors.print("Interrupted: there is nothing to keep yet", style="red")
        raise typer.Exit(INTERRUPTED) from None
    except (ValueError, TypeError, OSError) as error:
        errors.print(f"Error: {error}", style="red", highlight=False, markup=False, soft_wrap=True)
        raise typer.Exit(2) from None
    console.print(table_of_branches(found))
    console.print(table_of_points(found))
    for table in more.tables():
        console.print(table)
    names = (*pictures, *FILES, *written)
    console.print("wrote " + ", ".join(str(out / name) for name in names), soft_wrap=True)
    if interrupted:
        errors.print("Interrupted: the orders that were completed are kept", style="red")
        raise typer.Exit(INTERRUPTED)


def _computed(
    map_: PiecewiseLinearMap,
    parameter: str,
    span: tuple[str, str] | None,
    orders: list[int],
    budget: Budget,
) -> tuple[Diagram, bool]:
    """The diagram, and whether Ctrl-C ended it; with a bar that leaves nothing behind."""
    interrupts: list[bool] = []
    bar = Bar(
        TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=errors,
        transient=True, disable=not errors.is_terminal,
    )  # fmt: skip
    with bar:
        task = bar.add_task("order 1", total=max(orders, default=1))

        def tell(done: Progress) -> None:
            more = f"order {done.order + 1}" if done.order < max(orders) else "points and branches"
            text = f"{more}, {done.cells} cells and {done.pieces} pieces so far"
            bar.update(task, completed=done.order, description=text)

        found = bifurcation_diagram(
            map_,
            parameter,
            span,
            orders,
            budget=budget,
            progress=tell,
            on_interrupt=lambda: interrupts.append(True),
        )
    return found, bool(interrupts)


def _draw(found: Diagram, more: LongRun, out: Path, picture: PictureFormat) -> list[str]:
    """The diagram, over its bands if these are known, and each order if there are several."""
    mpl.use("Agg")
    from pwmap.plot import plot_diagram

    drawn = [more.drawn(found) if more.found is not None else plot_diagram(found)]
    orders = sorted({branch.order for branch in found.branches})
    several = orders if len(orders) > 1 else []
    drawn += [plot_diagram(found.of_order(order)) for order in several]
    names = [f"{name}.{picture}" for name in ("diagram", *(f"order_{j}" for j in several))]
    for name, each in zip(names, drawn, strict=True):
        write_figure(out / name, each.figure)
    return names


app.command("plane")(draw_plane)
app.command("prove")(prove_map)
app.command("check")(check_files)


def run() -> None:
    """Entry point of the command."""
    app()


if __name__ == "__main__":
    run()
