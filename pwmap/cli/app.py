"""The command ``pwmap``: exact analysis of a piecewise-linear map given as text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pwmap.cli import reading, screen
from pwmap.cli.certificates import check_files, prove_map
from pwmap.cli.explore import explore
from pwmap.cli.options import Ends, Formula, Given, Orders, Out, Values, Variable
from pwmap.cli.plane import draw_plane
from pwmap.cli.results import asked, results_in, typed
from pwmap.maps.budget import BUDGET

app = screen.command_line(
    "pwmap", "Exact analysis of piecewise-linear discontinuous maps of the line."
)


@app.command()
def analyse(
    context: typer.Context,
    formula: Formula,
    parameter: Annotated[str, screen.option("The parameter to vary.")],
    set_: Values = None,
    orders: Orders = "1,2",
    span: Ends = None,
    given: Given = None,
    sample: Annotated[
        list[str] | None,
        screen.option(
            "A value, such as b=3, of a parameter that stays symbolic: formulas hold around "
            "it; repeatable, once for each such parameter. By default one that is admitted."
        ),
    ] = None,
    variable: Variable = "x",
    pieces: Annotated[
        int, screen.option("How many pieces of all iterates may be computed.", least=1)
    ] = BUDGET.pieces,
    attractors: Annotated[
        bool, screen.option("Attracting cycles, bands and crises, too.", "--attractors")
    ] = False,
    entropy: Annotated[
        bool, screen.option("Bounds of the topological entropy, too.", "--entropy")
    ] = False,
    density: Annotated[
        list[str] | None,
        screen.option("A value of the parameter whose invariant density is drawn; repeatable."),
    ] = None,
    picture: screen.Formats = None,
    out: Out = Path("out"),
) -> None:
    """Find all branches and special points over a parameter, exactly; draw and export them.

    Iterates are computed order by order. Beyond the allowed pieces, or after Ctrl-C, the completed
    orders are kept; a later Ctrl-C keeps the diagram, and what is known of the long run in other
    files. Tables are written and shown first, then pictures. Ctrl-C keeps what is there, and a
    second one ends the command at once. --attractors and --entropy, which need --span, and
    --density ask for the long run.

    Example: pwmap analyse "Piecewise((r - 2, x <= 0), (r - a*x, True))" --parameter r --set a=5/4
    """
    asked.set(("analyse", {"map": formula, **typed(context)}))
    with screen.told(screen.NOTHING_KEPT):
        from pwmap.algebra.terms import checked_parameter
        from pwmap.cli.analysis import Analysis
        from pwmap.cli.given import in_a_part_only

        screen.take_formats(picture)
        fixed = reading.assignments(set_ or ())
        map_ = reading.map_of(formula, variable, given or (), fixed, parameter)
        listed = reading.orders_of(orders)
        span = reading.exact_span(span)
        checked_parameter(parameter, map_.parameters)
        values = reading.sample_of(map_, parameter, sample or ())
        long_run = attractors or entropy
        densities = reading.densities_of(map_, parameter, span, long_run, density or ())
        with results_in(out) as results:
            with screen.progress() as bar:
                about = {"map": formula, "set": set_ or []}
                analysis = Analysis(map_, parameter, span, about, results, bar)
                with analysis.going_on():
                    found = analysis.follow(listed, values, pieces)
                    analysis.ask(
                        attractors=attractors, entropy=entropy, order=max(listed),
                        density=densities,
                    )  # fmt: skip
            results.missing = ", without pictures"
            analysis.write()
            if results.stopped:
                for sentence in (*analysis.diagram.given, *analysis.left_out):
                    screen.say(sentence)
            else:
                if part := in_a_part_only(map_, analysis.diagram):
                    screen.say(part)
                screen.show(*analysis.tables())
                analysis.draw(found)
                if analysis.failed:
                    results.fail("; ".join(analysis.failed))


app.command("plane")(draw_plane)
app.command("prove")(prove_map)
app.command("check")(check_files)
app.command("explore")(explore)
screen.prepare(app)
