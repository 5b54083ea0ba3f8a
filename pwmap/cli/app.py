"""The command ``pwmap``: exact analysis of a piecewise-linear map given as text."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pwmap.cli import reading, screen
from pwmap.cli.certificates import check_files, prove_map
from pwmap.cli.explore import explore
from pwmap.cli.options import Ends, Formula, Given, Orders, Out, Values, Variable
from pwmap.cli.plane import draw_plane
from pwmap.maps.budget import BUDGET, Budget, Progress

if TYPE_CHECKING:  # help and refusals come before what computes is loaded
    from rich.progress import Progress as Bar

    from pwmap.cli.longrun import LongRun
    from pwmap.diagrams.diagram import Diagram
    from pwmap.maps.piecewise_linear import PiecewiseLinearMap

app = screen.command_line(
    "pwmap", "Exact analysis of piecewise-linear discontinuous maps of the line."
)


@app.command()
def analyse(
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
    asked: dict[str, object] = {
        "map": formula, "variable": variable, "parameter": parameter, "set": set_ or [],
        "given": given or [], "orders": orders, "span": span, "sample": sample or [],
        "pieces": pieces, "attractors": attractors, "entropy": entropy,
        "density": density or [], "format": picture or [],
    }  # fmt: skip
    kept = _Kept({"map": formula, "set": set_ or []})
    with screen.told(lambda: kept.lost):
        from pwmap import bifurcation_diagram
        from pwmap.cli.longrun import LongRun

        screen.check_folder(out)
        screen.take_formats(picture)
        fixed = reading.assignments(set_ or ())
        reading.check_unset(fixed, parameter)
        map_ = reading.map_of(formula, variable, given or (), fixed)
        listed = reading.orders_of(orders)
        span = reading.exact_span(span)
        reading.varied(map_, parameter)
        values = reading.sample_of(map_, parameter, sample or ())
        screen.tell_replaced(out, "analyse")
        with screen.progress() as bar:
            more = LongRun(map_, parameter, span, kept.interrupts, bar)
            with kept.going_on():
                question = partial(bifurcation_diagram, map_, parameter, span, listed, values)
                found = _computed(question, listed, pieces, kept, bar)
                more.ask(
                    attractors=attractors, entropy=entropy, order=max(listed),
                    density=tuple(map(reading.exact, density or ())),
                )  # fmt: skip
                if not kept.interrupts:
                    kept.keep(more.added(found))
        tables, pictures, failed = _written(kept, more, out), list[str](), more.failed
        with kept.going_on():
            if not kept.interrupts:
                _tell(map_, kept.diagram, more)
                try:  # each picture is named when it is there, though the next may fail
                    pictures += chain(_draw(found, more, out), more.draw(out))
                except OSError as error:
                    failed = screen.in_words(error)
        failed = screen.record(out, "analyse", [*tables, *pictures], asked) or failed
    if kept.interrupts:
        for sentence in (*kept.diagram.given, *more.left_out):
            screen.say(sentence)
    screen.tell_end(bool(kept.interrupts), failed, "" if pictures else ", without pictures")


@dataclass
class _Kept:
    """The diagram of the completed orders and the content of its files, both kept at Ctrl-C."""

    about: dict[str, object]
    interrupts: list[bool] = field(default_factory=list)
    diagram: Any = None  # a Diagram, if there is one
    files: dict[str, bytes] = field(default_factory=dict)

    def keep(self, diagram: Diagram) -> None:
        """Make the files of a diagram; after Ctrl-C the earlier ones stay."""
        from pwmap.diagrams.tables import results_as_bytes

        if not self.interrupts and self.diagram is not diagram:
            about = {**diagram.about, **self.about}
            self.diagram, self.files = diagram, results_as_bytes(replace(diagram, about=about))

    def write(self, folder: Path) -> list[str]:
        from pwmap.diagrams.files import write_whole

        for name, content in self.files.items():
            write_whole(folder / name, content)
        return [*self.files]

    @contextmanager
    def going_on(self) -> Iterator[None]:
        """Let Ctrl-C end this context, if something is kept; another one ends the command."""
        try:
            yield
        except KeyboardInterrupt:
            if self.diagram is None or self.interrupts:
                raise
            self.interrupts.append(True)

    @property
    def lost(self) -> str:
        """What is lost by an interrupt that ends the command."""
        return "there is nothing to keep yet" if self.diagram is None else "files may be missing"


def _computed(
    question: Callable[..., Diagram], orders: list[int], pieces: int, kept: _Kept, bar: Bar
) -> Diagram:
    task = bar.add_task("order 1", total=max(orders, default=1))

    def tell(done: Progress) -> None:
        more = f"order {done.order + 1}" if done.order < max(orders) else "all orders"
        text = f"{more}, {done.cells} cells and {done.pieces} pieces so far"
        bar.update(task, completed=done.order, description=text)

    budget = Budget(pieces=pieces, on_interrupt=lambda: kept.interrupts.append(True))
    found = question(budget=budget, progress=tell, finished=kept.keep)
    kept.keep(found)  # if the budget has ended it, that is what the files say
    return found


def _written(kept: _Kept, more: LongRun, out: Path) -> list[str]:
    """Write all tables, whole also if Ctrl-C comes meanwhile, and name them."""
    out.mkdir(parents=True, exist_ok=True)
    names = list[str]()
    while not names:
        with kept.going_on():
            names = [*kept.write(out), *more.write(out)]
    return names


def _tell(map_: PiecewiseLinearMap, found: Diagram, more: LongRun) -> None:
    from pwmap.cli.given import in_a_part_only
    from pwmap.diagrams.tables import table_of_branches, table_of_points

    if part := in_a_part_only(map_, found):
        screen.say(part)
    screen.show(table_of_branches(found), table_of_points(found), *more.tables())


def _draw(found: Diagram, more: LongRun, out: Path) -> Iterator[str]:
    from pwmap.plot import plot_diagram

    orders = sorted({branch.order for branch in found.branches})
    values = ", ".join(f"{name} = {value}" for name, value in found.sample.items())
    for order in (0, *(orders if len(orders) > 1 else ())):
        drawn = plot_diagram(found.of_order(order)) if order else more.drawn(found)
        title = f"$P_{{{order}}}$" if order else drawn.ax.get_title()
        if values:  # exact in other parameters, too: a picture needs values of them
            title += f"{', ' * bool(title)}drawn at {values}"
        if order or values:
            drawn.ax.set_title(title, fontsize=9)
        yield from screen.draw(out, f"order_{order}" if order else "diagram", drawn.figure)


app.command("plane")(draw_plane)
app.command("prove")(prove_map)
app.command("check")(check_files)
app.command("explore")(explore)
screen.in_paragraphs(app)


def run() -> None:
    """Entry point of the command, which SIGTERM ends as Ctrl-C does."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    app()
