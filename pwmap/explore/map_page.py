"""The page of a piecewise-linear map: its views, its tab, and how it is served."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.models import Span

from pwmap.explore.diagrams import NOTHING
from pwmap.explore.figures import Shown, hover, map_figure, new_figure, ring, source
from pwmap.explore.jobs import warm_up
from pwmap.explore.map_data import CURVES, FILES, SECONDS, answers, completed, export
from pwmap.explore.map_state import FINEST, MapState, from_query, of_map, rational
from pwmap.explore.page import PARAMETERS, asked, control
from pwmap.explore.serving import Serve
from pwmap.explore.tab import Tab
from pwmap.plot import GREY, INK, STABLE

TEMPLATE = Path(__file__).parent / "files" / "pwmap.html"
OF_FIXED = "<div class='tip'><b>@word</b> @kind<br>x = @exact</div>"
OF_CURVE = "<div class='tip'><b>@name</b> @tip</div>"


def plane_figure() -> Any:
    """The figure of curves over two parameters, with the current place."""
    figure = new_figure("plane", "", "")
    lines = figure.multi_line("xs", "ys", source=source("curves", *CURVES), line_color="color",
                              line_dash="dash", line_width=1.8)  # fmt: skip
    figure.scatter("x", "y", source=source("meeting", "x", "y"), size=7, fill_color="white",
                   line_color="black")  # fmt: skip
    ring(figure, source("there", "x", "y"))
    figure.add_tools(hover(lines, OF_CURVE))
    return figure


def density_figure() -> Any:
    """The figure of the invariant density, which is a step function."""
    figure = new_figure("density", "x", "invariant density")
    figure.quad("left", "right", "top", 0.0, source=source("steps", "left", "right", "top"),
                fill_color=STABLE, fill_alpha=0.35, line_color=STABLE)  # fmt: skip
    figure.add_layout(Span(location=0.0, dimension="width", line_color=GREY))
    return figure


class MapTab(Tab[MapState]):
    """One tab of a piecewise-linear map."""

    def __init__(self, state: MapState, first: MapState) -> None:
        map_ = map_figure("x", "P(x)", OF_FIXED, "word", "exact", color=INK)
        super().__init__(state, first, [map_, plane_figure(), density_figure()], "x")
        self.parts = dict[str, Shown]()  # the answers, by their names
        self._before_them: dict[str, Shown] = {}  # earlier answers, shown until new ones arrive
        self.hear(self.figures["plane"], self._tap_plane)
        self.show(state)

    # --- State -> views ---------------------------------------------------------------------------

    def axis(self) -> str:
        return self.state.axis

    def show(self, state: MapState, *, moving: bool = False) -> None:
        self.keep(state, moving=moving)
        self.later(0.0, self._answer_all)
        self.draw(self.stand(np.nan))
        if names := state.plane_names:
            x, y = (float(rational(state.place[name])) for name in names)
            self.draw(Shown(tables={"there": {"x": [x], "y": [y]}}))

    def _answer_all(self) -> None:
        self._before_them |= self.parts
        self.stage, self.parts = "working …", {}
        self.begin("answers", self._take, answers, self.state, seconds=SECONDS)

    def _take(self, part: Shown) -> None:
        self.parts[part.name] = part
        if part.name == "diagram":
            self.take_diagram(part)
            self.look()
            self.stage = self.stage if self.state.axis else ""
        else:
            self.draw(part)

    def ended(self, name: str, sentence: str) -> None:
        """Say why the job failed, if it did, and drop answers about an earlier state."""
        said = (part.message for part in self.parts.values() if part.message)
        self.message = sentence or next(said, self.message)
        self._before_them = {}
        if "diagram" not in self.parts:
            self.take_diagram(NOTHING)
            self.stage = "no diagram"

    def told(self, *, whole: bool) -> dict[str, Any]:
        rows = [
            {"title": title, "rows": lines}
            for part in {**self._before_them, **self.parts}.values()
            for title, lines in part.rows.items()
        ]
        rows.sort(key=lambda each: each["title"] == "Orbit")  # the longest comes last
        return {
            "over": self.state.axis, "axes": list(self.state.plane_names), "rows": rows,
            "busy": self._answer_all in self.due or "answers" in self.jobs,
            "chaotic": bool(self.tables["steps"].data["top"]),
        }  # fmt: skip

    # --- What a user may ask for ------------------------------------------------------------------

    def _tap_map(self, event: Any) -> None:
        self.change(start=str(_simplest_rational(event.x, self.figures["map"].x_range)))

    def _tap_beside(self, event: Any) -> None:
        if self.state.axis:
            value = _simplest_rational(event.x, self.figures["diagram"].x_range)
            self.show(self.state.at({self.state.axis: str(value)}))

    def _tap_plane(self, event: Any) -> None:
        plane, names = self.figures["plane"], self.state.plane_names
        if names:
            axes = (event.x, plane.x_range), (event.y, plane.y_range)
            values = (str(_simplest_rational(value, axis)) for value, axis in axes)
            self.show(self.state.at(dict(zip(names, values, strict=True))))


def _simplest_rational(value: float, axis_range: Any) -> Fraction:
    """The simplest rational within half a pixel or so of a place."""
    size = abs(float(axis_range.end - axis_range.start)) / 600.0
    for most in (1, 2, 4, 5, 10, 20, 50, 100, 200, FINEST):
        found = Fraction(float(value)).limit_denominator(most)
        if abs(float(found) - value) <= size:
            return found
    return Fraction(float(value)).limit_denominator(10_000)


# --- Serving --------------------------------------------------------------------------------------


def controls(state: MapState, first: MapState) -> list[dict[str, Any]]:
    """A slider for each parameter of the map, around its value."""
    found = []
    for name, text in state.place.items():
        value, meaning = float(rational(text)), f"parameter {name}, an exact rational"
        low, high = float(np.floor(value) - 2.0), float(np.ceil(value) + 2.0)
        default = first.place[name]
        found.append(control(name, low, high, default, meaning=meaning, step=0.01, exact=True))
    return found


def make_page(document: Document, initial: MapState) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    same = (state.map, state.given) == (initial.map, initial.given)
    first = initial if same else of_map(state.map, state.given, {})
    state, first = map(_completed, (state, first))
    tab = MapTab(state, first)
    tab.message = refused
    tab.put_on(
        document, TEMPLATE, "piecewise-linear maps", files=FILES,
        controls=controls(state, first), open_group=PARAMETERS, state=state,
    )  # fmt: skip


def _completed(state: MapState) -> MapState:
    """The completed state; unchanged if that fails, as the answers will say what is missing."""
    try:
        return completed(state)
    except (ValueError, TypeError, ArithmeticError):
        return state


def run(initial: MapState, serve: Serve) -> None:
    """Load modules in the process that jobs are forked from, and serve the page."""
    warm_up(["pwmap.explore.map_data"])
    serve(partial(make_page, initial=initial), lambda *asked: (export, *asked))
