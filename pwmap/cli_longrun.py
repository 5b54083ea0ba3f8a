"""What ``pwmap analyse`` adds of the long run: tables, files and pictures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.table import Table

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.files import PictureFormat, write_figure, write_table
from pwmap.longrun.bands import with_attractors
from pwmap.longrun.constant import EntropyIntervals, constant_entropy
from pwmap.longrun.crises.diagram import AttractorDiagram, attractor_diagram
from pwmap.longrun.dynamics import Dynamics, dynamics
from pwmap.maps.piecewise_linear import PiecewiseLinearMap

HIGHEST = 5  # order up to which crises are looked for


class LongRun:
    """Attractors and entropy over a parameter, and densities at values of it.

    Parameters
    ----------
    map_, parameter, span
        A map of that parameter alone, its name, and two rationals if it is asked for more than
        densities.
    attractors, entropy
        Whether these are asked for.
    density
        Values of the parameter.
    order
        Up to which words are compared.

    Raises
    ------
    ValueError
        If something is asked for over a parameter without a span, or there is no density.
    """

    def __init__(
        self, map_: PiecewiseLinearMap, parameter: str, span: tuple[str, str] | None, *,
        attractors: bool, entropy: bool, density: tuple[str, ...], order: int,
    ) -> None:  # fmt: skip
        if span is None and (attractors or entropy):
            raise ValueError("--attractors and --entropy need an interval of the parameter: --span")
        self._map, self._parameter, self._span = map_, parameter, span
        self.found: AttractorDiagram | None = None
        if attractors and span is not None:
            self.found = attractor_diagram(map_, parameter, span, min(order, HIGHEST))
        self.constant: EntropyIntervals | None = None
        if entropy and span is not None:
            self.constant = constant_entropy(map_, parameter, span)
        self.at: dict[str, Dynamics] = {p: dynamics(map_, {parameter: p}) for p in density}
        for value, seen in self.at.items():
            if all(each.density is None for each in seen.attractors):
                what = f"at {parameter} = {value} no chaotic attractor has a density"
                raise ValueError("; ".join(filter(None, (what, seen.attractors.left_out))))

    def added(self, diagram: Diagram) -> Diagram:
        """A diagram with the bands and crises that were found."""
        return diagram if self.found is None else with_attractors(diagram, self.found)

    def drawn(self, diagram: Diagram) -> Any:
        """A diagram over the attractors that were found."""
        from pwmap.plot_longrun import plot_long_run

        assert self.found is not None
        return plot_long_run(diagram, self.found, self._map)

    def write(self, folder: Path, picture: PictureFormat) -> list[str]:
        """Write what was asked for into a folder, and name the files."""
        names = list[str]()
        from pwmap.plot_longrun import plot_density, plot_entropy

        def keep(name: str, figure: Any) -> None:
            write_figure(folder / name, figure)
            names.append(name)

        if self.found is not None:
            self._write_cells(folder / "attractors.csv")
            self._write_crises(folder / "crises.csv")
            names += ["attractors.csv", "crises.csv"]
        if self.constant is not None and self._span is not None:
            drawn = plot_entropy(self._map, self._parameter, self._span, intervals=self.constant)
            keep(f"entropy.{picture}", drawn.figure)
            self._write_intervals(folder / "entropy.csv")
            names.append("entropy.csv")
        for value, seen in self.at.items():
            keep(f"density_{value.replace('/', '_')}.{picture}", plot_density(seen).figure)
        return names

    def _write_cells(self, path: Path) -> None:
        assert self.found is not None
        rows = [
            (cell.lower, cell.upper, cell.sample, " ".join(cell.cycles), number, low, high,
             "open" if cell.is_open else "")
            for cell in self.found.cells
            for number, (low, high) in enumerate(
                [band for bands in cell.bands for band in bands] or [("", "")]
            )
        ]  # fmt: skip
        header = ("lower", "upper", "sample", "cycles", "band", "from", "to", "open")
        write_table(path, header, ([str(each) for each in row] for row in rows))

    def _write_crises(self, path: Path) -> None:
        assert self.found is not None
        header = ("kind", "parameter", "parameter_exact", "before", "after", "cycles", "images")
        write_table(
            path,
            header,
            (
                (c.kind, float(c.parameter), c.parameter, *c.bands, " ".join(c.cycles),
                 " ".join(c.images))
                for c in self.found.crises
            ),
        )  # fmt: skip

    def _write_intervals(self, path: Path) -> None:
        assert self.constant is not None
        header = ("lower", "upper", "lower_exact", "upper_exact", "lower_closed", "upper_closed",
                  "entropy", "entropy_exact", "cycles", "open_because")  # fmt: skip
        rows: list[tuple[object, ...]] = [
            (float(e.lower), float(e.upper), e.lower, e.upper, *e.closed,
             0.5 * (e.entropy.low + e.entropy.high), e.entropy.value, " ".join(e.cycles), "")
            for e in self.constant.intervals
        ]  # fmt: skip
        rows += [
            (float(g.lower), float(g.upper), g.lower, g.upper, "", "", "", "", "",
             "; ".join(cause.value for cause in g.causes))
            for g in self.constant.gaps
        ]  # fmt: skip
        rows.sort(key=lambda row: float(str(row[0])))
        write_table(path, header, ([str(each) for each in row] for row in rows))

    def tables(self) -> Iterator[Table]:
        """Crises, and what is known at single values."""
        if self.found is not None:
            table = Table("crisis", self._parameter, "exact", "bands", "cycle", title="Crises")
            for c in self.found.crises:
                bands = f"{c.bands[0]} | {c.bands[1]}"
                exact = str(c.parameter) if not c.width else f"open, within {c.width:.0e}"
                cycle = c.cycles[0] if c.cycles else ""
                table.add_row(c.kind.label, f"{float(c.parameter):.12g}", exact, bands, cycle)
            if self.found.open or self.found.left_out:
                table.caption = "; ".join(filter(None, (self.found.summary, self.found.left_out)))
            yield table
        if self.at:
            table = Table(self._parameter, "attractors", "entropy", "Lyapunov exponent", "kneading")
            for value, seen in self.at.items():
                table.add_row(
                    value,
                    "\n".join(filter(None, (*map(str, seen.attractors), seen.attractors.left_out))),
                    _entropy(seen),
                    "\n".join(
                        filter(None, (_exponent(seen, k) for k in range(len(seen.attractors))))
                    ),
                    "\n".join(each.word[:24] for each in seen.kneading),
                )
            yield table


def _entropy(seen: Dynamics) -> str:
    found = seen.entropy
    return str(found.value) if found.value is not None else f"{found.low:.9g} to {found.high:.9g}"


def _exponent(seen: Dynamics, number: int) -> str:
    """The Lyapunov exponent of one attractor as text."""
    attractor = seen.attractors[number]
    if attractor.exponent is not None:
        return str(attractor.exponent)
    bounds = attractor.exponent_bounds
    return "" if bounds is None else f"{bounds[0]:.12g}"
