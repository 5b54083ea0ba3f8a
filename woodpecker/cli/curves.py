"""The command ``woodpecker curves``: curves of special points over two parameters."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Annotated

from rich.table import Table

import pwmap
import woodpecker
from pwmap.cli.results import Results, Writers, asked, results_in, table_in
from pwmap.cli.screen import Formats, option, progress, say, show
from pwmap.diagrams.record import attributes, program
from woodpecker.cli.diagram import PAPER, places_of
from woodpecker.cli.options import GUESS, CommandError, Near, Out, ends, motion
from woodpecker.cli.toys import parameter_of
from woodpecker.mechanics.toy import Toy

PICTURE = "curves"
TABLES = ("curves.csv", "curve_points.csv")
GRAPHS = ("curves.graphml", "curves.json")
ALL = "all"

Parameters = Annotated[str, option("Two parameters of the toy, the first that of the diagram.")]
Second = Annotated[
    tuple[float, float] | None,
    ends("Interval of the second parameter; by default from half to twice the toy's value."),
]


def curves(
    toy: Toy,
    from_: Annotated[
        str,
        option("Special points to start from, by name or id, such as A,B,PD1; or all.", "--from"),
    ] = "A",
    parameters: Parameters = "eps_n1,mu_2",
    span: Annotated[tuple[float, float], ends("Interval of the first parameter.")] = (0.0, 1.0),
    second_span: Second = None,
    phi_s: Near = GUESS,
    picture: Formats = None,
    out: Out = Path("out"),
) -> None:
    """Follow special points of a diagram over two parameters; draw the curves, export their graph.

    The diagram is that of the periodic motion over the first parameter.

    Example: woodpecker curves --from A,B,C --parameters eps_n1,mu_2 --second-span 0.286 0.6
    """
    first, second = two_of(parameters)
    spans = span, second_of(toy, second, second_span)
    with results_in(out) as results:
        diagram = woodpecker.continuation(toy, motion(toy, phi_s), first, span)
        named = diagram.named(places_of(PAPER)) if first == "eps_n1" else diagram
        wanted = _chosen(named, from_)
        found = _followed(toy, named, wanted, (first, second), spans, results)
        write_curves(found, results)
        show(_table(found))
        if not results.stopped:
            from woodpecker.plot.plane import plot_curves

            here = getattr(toy, first), getattr(toy, second)
            results.draw(PICTURE, plot_curves(found, here=here).figure)


def second_of(toy: Toy, name: str, span: tuple[float, float] | None) -> tuple[float, float]:
    """Interval of the second parameter, by default half to twice its value; ValueError if none."""
    from woodpecker.base.checks import interval

    value = getattr(toy, name)
    if span is None and not 0.0 < value < math.inf:
        raise ValueError(f"--second-span is needed where {name} is {value}")
    if span is None:
        return 0.5 * value, 2.0 * value
    return interval(f"span of {name}", span, finite=True)


def two_of(text: str) -> tuple[str, str]:
    """The names of two different parameters in a text; ValueError if it has none such."""
    names = [parameter_of(name) for name in text.split(",")]
    if len(names) != 2 or names[0] == names[1]:
        raise ValueError(
            f"--parameters needs two different names such as eps_n1,mu_2, got {text!r}"
        )
    return names[0], names[1]


def _chosen(diagram: pwmap.Diagram, text: str) -> list[str]:
    if text == ALL:
        kind = pwmap.PointKind
        starts = (kind.LP, kind.PD, kind.BC, kind.FF)
        return [point.name or point.id for point in diagram.points if point.kind in starts]
    wanted = [*dict.fromkeys(name.strip() for name in text.split(","))]
    known = [*sorted(p.name for p in diagram.points if p.name), *(p.id for p in diagram.points)]
    for name in wanted:
        if name not in known:
            raise ValueError(f"--from must be among {', '.join(known)}, got {name!r}")
    return wanted


def _followed(
    toy: Toy, diagram: pwmap.Diagram, names: list[str], over: tuple[str, str],
    spans: tuple[tuple[float, float], tuple[float, float]], results: Results,
) -> dict[str, woodpecker.Curve]:  # fmt: skip
    """Curves by the names of their starting points; after Ctrl-C those that are finished."""
    found: dict[str, woodpecker.Curve] = {}
    refused: list[str] = []
    with progress() as bar:
        task = bar.add_task(", ".join(over), total=len(names))
        for name in names:
            try:
                found[name] = woodpecker.curve_in_two(toy, diagram.point(name), over, spans)
            except ValueError as error:
                refused.append(f"{name}: {error}")
            except KeyboardInterrupt:
                if not found:
                    raise
                kept = f"{len(found)} of {len(names)} curves are kept, as tables"
                results.stop(f"Interrupted: {kept}")
                break
            bar.advance(task)
    if not found:
        raise CommandError("no curve could be followed: " + "; ".join(refused))
    for sentence in refused:
        say(f"left out: {sentence}")
    return found


def write_curves(found: dict[str, woodpecker.Curve], results: Results) -> None:
    """Write tables of curves and of their points, and the graph that connects them."""
    from woodpecker.plane import graph_of_curves

    graph = graph_of_curves(list(found.values()))
    graph.graph.update(attributes({"program": program(), **asked.get()[1]}))
    graphs = dict.fromkeys(GRAPHS, partial(pwmap.write_graph, graph))
    results.write({**_tables(found), **graphs})


def _tables(found: dict[str, woodpecker.Curve]) -> Writers:
    names = next(iter(found.values())).names
    samples = (
        (
            name, curve.codes[k], curve.notes[k], *curve.values[k].tolist(),
            float(curve.x[k, 0]), *curve.multipliers[k].tolist(), curve.word_at(k),
        )
        for name, curve in found.items()
        for k in range(len(curve))
    )  # fmt: skip
    points = (
        (name, p.id, p.kind, *p.values, p.x[0], p.cause, p.status, max(p.precision))
        for name, curve in found.items()
        for p in curve.points
    )
    of_samples = ("curve", "kind", "note", *names, "phi_s", "multiplier", "beyond", "word")
    of_points = ("curve", "id", "kind", *names, "phi_s", "cause", "status", "precision")
    return {TABLES[0]: table_in(of_samples, samples), TABLES[1]: table_in(of_points, points)}


def _table(found: dict[str, woodpecker.Curve]) -> Table:
    first, second = next(iter(found.values())).names
    table = Table("curve", "point", first, second, "what")
    for name, curve in found.items():
        for k, point in enumerate(curve.points):
            shown = name if k == 0 else ""
            table.add_row(shown, point.id, *(f"{v:.10g}" for v in point.values), point.cause)
        table.add_section()
    return table
