"""What ``pwmap analyse`` finds: a diagram and, if it is asked for, the long run of its map."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from rich.progress import Progress as Bar
from rich.table import Table

from pwmap import plot
from pwmap.algebra.arguments import shortened
from pwmap.cli.results import Results, Writers, table_in
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import write_whole
from pwmap.diagrams.shown import counted
from pwmap.diagrams.tables import results_as_bytes, table_of_branches, table_of_points
from pwmap.longrun.crises.bands import with_attractors
from pwmap.longrun.crises.diagram import AttractorDiagram, attractor_diagram
from pwmap.longrun.dynamics import Attractor, Dynamics, dynamics
from pwmap.longrun.entropy.constant import constant_entropy
from pwmap.longrun.entropy.entropies import EntropyIntervals
from pwmap.maps.budget import Budget, Progress
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.bifurcations import bifurcation_diagram

Found = TypeVar("Found")

MAX_CRISIS_ORDER = 5  # highest order whose crises are looked for


class Analysis:
    """A diagram of a map, with attractors and entropy over its span, and densities at values.

    After Ctrl-C nothing more is begun, and the completed orders are kept.
    """

    def __init__(
        self, map_: PiecewiseLinearMap, parameter: str, span: tuple[str, str] | None,
        about: Mapping[str, object], results: Results, bar: Bar,
    ) -> None:  # fmt: skip
        self._map, self._parameter, self._span = map_, parameter, span
        self._about, self._results, self._bar = about, results, bar
        self.diagram: Any = None  # a Diagram of the completed orders, if there is one
        self._files = dict[str, bytes]()  # of the diagram
        self.found: AttractorDiagram | None = None
        self.constant: EntropyIntervals | None = None
        self.at = dict[str, Dynamics]()
        self.left_out = list[str]()  # sentences on what is not known
        self.failed = list[str]()  # why densities that were asked for are not drawn

    @contextmanager
    def going_on(self) -> Iterator[None]:
        """Let Ctrl-C end this block if a diagram is kept; a second one ends the command."""
        try:
            yield
        except KeyboardInterrupt:
            if self.diagram is None or self._results.stopped:
                raise
            self._results.interrupt()

    def follow(self, orders: list[int], sample: Mapping[str, str] | None, pieces: int) -> Diagram:
        """The diagram of some orders; after Ctrl-C that of the completed ones."""
        task = self._bar.add_task("order 1", total=max(orders, default=1))

        def tell(done: Progress) -> None:
            more = f"order {done.order + 1}" if done.order < max(orders) else "all orders"
            cells, pieces = counted(done.cells, "cell"), counted(done.pieces, "piece")
            text = f"{more}, {cells} and {pieces} so far"
            self._bar.update(task, completed=done.order, description=text)

        budget = Budget(pieces=pieces, on_interrupt=self._results.interrupt)
        found = bifurcation_diagram(
            self._map, self._parameter, self._span, orders, sample,
            budget=budget, progress=tell, finished=self._keep,
        )  # fmt: skip
        self._keep(found)  # with the sentence on where a budget ended it
        return found

    def _keep(self, diagram: Diagram) -> None:
        """Make the files of a diagram; after Ctrl-C the earlier ones stay."""
        if not self._results.stopped and self.diagram is not diagram:
            about = {**diagram.about, **self._about}
            content = results_as_bytes(replace(diagram, about=about))  # Ctrl-C may end it here
            self.diagram, self._files = diagram, content

    def ask(self, *, attractors: bool, entropy: bool, density: tuple[str, ...], order: int) -> None:
        """Compute what is asked for, until Ctrl-C."""
        map_, name, span = self._map, self._parameter, self._span
        if span is not None and attractors:
            question = partial(attractor_diagram, map_, name, span, min(order, MAX_CRISIS_ORDER))
            self.found = self._asked("attractors", question)
        if span is not None and entropy:
            self.constant = self._asked("entropy", partial(constant_entropy, map_, name, span))
        for value in density:
            seen = self._asked(f"density at {value}", partial(self._at, value))
            if seen is not None:
                self.at[value] = seen
        if self.found is not None and self.diagram is not None and not self._results.stopped:
            self._keep(with_attractors(self.diagram, self.found))

    def _asked(self, what: str, question: Callable[..., Found | None]) -> Found | None:
        """The answer to a question; None if Ctrl-C ended it before anything was found."""
        found: Found | None = None
        if not self._results.stopped:
            with self._results.budget(self._bar, what) as budget:
                try:
                    found = question(budget=budget)
                except KeyboardInterrupt:
                    self._results.interrupt()
        if found is None:
            self.left_out.append(f"left out: {what}")
        elif left_out := getattr(found, "left_out", ""):
            self.left_out.append(f"{what}: {left_out}")
        return found

    def _at(self, value: str, budget: Budget) -> Dynamics | None:
        """The long run at a value with all densities; None without any, or after Ctrl-C."""
        seen = dynamics(self._map, {self._parameter: value}, budget=budget)
        dense = [each for each in seen.attractors if each.density is not None]
        if self._results.stopped:
            return None
        if not dense:
            what = f"at {self._parameter} = {shortened(value)} no chaotic attractor has a density"
            self.failed.append("; ".join(filter(None, (what, seen.attractors.left_out))))
            return None
        return seen

    def write(self) -> None:
        """Write all tables."""
        files: Writers = dict.fromkeys(
            self._files, lambda path: write_whole(path, self._files[path.name])
        )
        if self.found is not None:
            files |= {
                "attractors.csv": table_in(CELLS, _cells(self.found)),
                "crises.csv": table_in(CRISES, _crises(self.found)),
            }
        if self.constant is not None:
            files |= {"entropy.csv": table_in(INTERVALS, _intervals(self.constant))}
        self._results.write(files)

    def _drawn(self, diagram: Diagram) -> Any:
        """A picture of a diagram, over the attractors if they were found."""
        if self.found is None:
            return plot.plot_diagram(diagram)
        return plot.plot_long_run(diagram, self.found, self._map)

    def draw(self, diagram: Diagram) -> None:
        """Draw a diagram and the long run."""
        orders = sorted({branch.order for branch in diagram.branches})
        values = ", ".join(f"{name} = {value}" for name, value in diagram.sample.items())
        for order in (0, *(orders if len(orders) > 1 else ())):
            drawn = plot.plot_diagram(diagram.of_order(order)) if order else self._drawn(diagram)
            title = f"$P_{{{order}}}$" if order else drawn.ax.get_title()
            if values:  # the diagram is exact in symbolic parameters, a picture needs their values
                title += f"{', ' * bool(title)}drawn at {values}"
            if order or values:
                drawn.ax.set_title(title, fontsize=9)
            self._results.draw(f"order_{order}" if order else "diagram", drawn.figure)
        if self.constant is not None and self._span is not None:
            drawn = plot.plot_entropy(
                self._map, self._parameter, self._span, intervals=self.constant
            )
            self._results.draw("entropy", drawn.figure)
        for value, seen in self.at.items():
            name = f"density_{value.replace('/', '_')}"
            self._results.draw(name, plot.plot_density(seen).figure)

    def tables(self) -> Iterator[Table]:
        """Tables of branches and points, of crises, and of the long run at single values."""
        if self.diagram is not None:
            yield table_of_branches(self.diagram)
            yield table_of_points(self.diagram)
        if self.found is not None:
            table = Table("crisis", self._parameter, "exact", "bands", "cycle", title="Crises")
            for c in self.found.crises:
                bands = f"{c.bands[0]} | {c.bands[1]}"
                exact = str(c.parameter) if not c.width else f"open, within {c.width:.0e}"
                cycle = c.cycles[0] if c.cycles else ""
                table.add_row(c.kind.label, f"{float(c.parameter):.12g}", exact, bands, cycle)
            told = (self.found.summary,) if self.found.open or self.found.left_out else ()
            none = () if self.found.crises else ("none was found",)
            table.caption = "; ".join(filter(None, (*none, *told, self.found.left_out))) or None
            yield table
        if self.at:
            table = Table(self._parameter, "attractors", "entropy", "Lyapunov exponent", "kneading")
            for value, seen in self.at.items():
                table.add_row(
                    value,
                    "\n".join(filter(None, (*map(str, seen.attractors), seen.attractors.left_out))),
                    _entropy(seen),
                    "\n".join(filter(None, map(_exponent, seen.attractors))),
                    "\n".join(each.word[:24] for each in seen.kneading),
                )
            yield table


CELLS = ("lower", "upper", "sample", "cycles", "neutral", "band", "from", "to", "open")
CRISES = ("kind", "parameter", "parameter_exact", "before", "after", "cycles", "images")
INTERVALS = (
    "lower", "upper", "lower_exact", "upper_exact", "lower_closed", "upper_closed", "entropy",
    "entropy_exact", "cycles", "open_because",
)  # fmt: skip


def _cells(found: AttractorDiagram) -> Iterator[list[str]]:
    for cell in found.cells:
        bands = enumerate(band for bands in cell.bands for band in bands)
        rows = [[*map(str, (number, *band))] for number, band in bands] or [["", "", ""]]
        words = " ".join(cell.cycles), " ".join(cell.neutral)
        ends = cell.lower, cell.upper, cell.sample
        for row in rows:
            yield [*map(str, ends), *words, *row, "open" if cell.is_open else ""]


def _crises(found: AttractorDiagram) -> Iterator[Sequence[object]]:
    for c in found.crises:
        words = " ".join(c.cycles), " ".join(c.images)
        yield c.kind, float(c.parameter), c.parameter, *c.bands, *words


def _intervals(found: EntropyIntervals) -> list[list[str]]:
    rows: list[tuple[object, ...]] = [
        (float(e.lower), float(e.upper), e.lower, e.upper, *e.closed,
         0.5 * (e.entropy.low + e.entropy.high), e.entropy.value, " ".join(e.cycles), "")
        for e in found.intervals
    ]  # fmt: skip
    rows += [
        (float(g.lower), float(g.upper), g.lower, g.upper, *[""] * 5,
         "; ".join(cause.value for cause in g.causes))
        for g in found.gaps
    ]  # fmt: skip
    return [[*map(str, row)] for row in sorted(rows, key=lambda row: float(str(row[0])))]


def _entropy(seen: Dynamics) -> str:
    found = seen.entropy
    return str(found.value) if found.value is not None else f"{found.low:.9g} to {found.high:.9g}"


def _exponent(attractor: Attractor) -> str:
    if attractor.exponent is not None:
        return str(attractor.exponent)
    bounds = attractor.exponent_bounds
    return "" if bounds is None else f"{bounds[0]:.12g}"
