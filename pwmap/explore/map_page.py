"""The page of a piecewise-linear map, put together and served."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.models import Span

from pwmap.explore.diagrams import NOTHING, summary
from pwmap.explore.figures import (
    DOTTED,
    hover,
    new_figure,
    patch,
    set_range,
    solutions,
    source,
)
from pwmap.explore.jobs import is_warm, warm_up
from pwmap.explore.map_data import SECONDS, MapAnswer, answers, completed
from pwmap.explore.map_exports import FILES, export
from pwmap.explore.map_state import FINEST, MapState, from_query, of_map, rational
from pwmap.explore.page import PARAMETERS, asked, control
from pwmap.explore.serving import serve
from pwmap.explore.tab import Tab
from pwmap.plot import GREY, INK, JUMP, STABLE, VIOLET

TEMPLATE = Path(__file__).parent / "files" / "pwmap.html"
EMPTIED = {"long": ("density",), "plane": ("curves", "meeting")}  # by answers without them
OF_FIXED = "<div class='tip'><b>@word</b> @kind<br>x = @exact</div>"
OF_CURVE = "<div class='tip'><b>@name</b> @tip</div>"


class MapTab(Tab[MapState]):
    """One tab of a piecewise-linear map."""

    TEXTS = (*Tab.TEXTS, "start", "orders", "span", "across", "along")

    def __init__(self, state: MapState, first: MapState) -> None:
        self._draw_map()
        self._draw_others()
        super().__init__(state, first, [self.map, self.plane, self.density], "x")
        self.due = True
        self.parts = dict[str, MapAnswer]()  # the last ones
        self._answered = set[str]()  # which parts of the last question
        self.hear(self.plane, self._tap_plane)
        self.show(state)

    def _draw_map(self) -> None:
        self.map = figure = new_figure("map", "x", "P(x)", match_aspect=False)
        curve, web, crossings = (source("x", "y") for _ in range(3))
        ends = source("x", "y", "fill")
        fixed = source("x", "y", "fill", "color", "kind", "word", "exact")
        figure.line([-1e6, 1e6], [-1e6, 1e6], color=GREY)
        figure.line("x", "y", source=crossings, color=JUMP, line_dash=DOTTED, line_width=2.2)
        figure.line("x", "y", source=curve, color=INK, line_width=2)
        figure.scatter("x", "y", source=ends, size=6, fill_color="fill", line_color=INK)
        figure.line("x", "y", source=web, color=VIOLET, line_width=1.2)
        figure.add_tools(hover(solutions(figure, fixed), OF_FIXED))
        self.tables = {
            "curve": curve, "web": web, "crossings": crossings, "ends": ends, "fixed": fixed,
        }  # fmt: skip

    def _draw_others(self) -> None:
        self.plane = new_figure("plane", "", "")
        curves = source("xs", "ys", "color", "dash", "name", "tip")
        meeting, self.here = source("x", "y"), source("x", "y")
        lines = self.plane.multi_line("xs", "ys", source=curves, line_color="color",
                                      line_dash="dash", line_width=1.8)  # fmt: skip
        self.plane.scatter("x", "y", source=meeting, size=7, fill_color="white",
                           line_color="black")  # fmt: skip
        self.plane.scatter("x", "y", source=self.here, size=12, fill_color=None, line_color=VIOLET,
                           line_width=2.5, level="overlay")  # fmt: skip
        self.plane.add_tools(hover(lines, OF_CURVE))
        self.density = new_figure("density", "x", "invariant density")
        steps = source("left", "right", "top")
        self.density.quad("left", "right", "top", 0.0, source=steps, fill_color=STABLE,
                          fill_alpha=0.35, line_color=STABLE)  # fmt: skip
        self.density.add_layout(Span(location=0.0, dimension="width", line_color=GREY))
        self.tables |= {"curves": curves, "meeting": meeting, "density": steps}

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: MapState, *, moving: bool = False) -> None:
        self.keep(state, moving=moving)
        self.due = True
        self.diagram.stand(state.value, np.nan)
        names = state.plane_names
        if names:
            x, y = (float(rational(state.place[name])) for name in names)
            patch(self.here, x=[x], y=[y])

    def tick(self) -> None:
        if self.due and is_warm():
            self.due, self.stage, self._answered = False, "working …", set()
            self.begin("answers", answers, self.state, seconds=SECONDS)
        told = self.results("answers")
        for result in told:
            if isinstance(result, MapAnswer):
                self._take(result)
            elif result.sentence:
                self._fail(result.sentence)
            else:
                self.message = next((p.message for p in self.parts.values() if p.message), "")
        if told:
            self.say(self.answer())

    def _fail(self, sentence: str) -> None:
        """Keep new answers, but none about an earlier state."""
        self.message = sentence
        self.parts = {name: self.parts[name] for name in self.parts if name in self._answered}
        if "diagram" not in self._answered:
            self.draw_diagram(NOTHING)
            self.stage = "no diagram"

    def _take(self, part: MapAnswer) -> None:
        self._answered.add(part.name)
        self.parts[part.name] = part
        for name in {*EMPTIED.get(part.name, ()), *part.tables}:
            table = self.tables[name]
            patch(table, **part.tables.get(name, {column: [] for column in table.data}))
        for name, ends in part.ranges.items():
            figure = getattr(self, name)
            set_range(figure.x_range, *ends[:2])
            set_range(figure.y_range, *ends[2:])
        if part.name == "map":
            self.map.yaxis.axis_label = rf"$$P_{{{self.state.order}}}(x)$$"
        elif part.name == "plane":
            axes = self.state.plane_names or ("", "")
            self.plane.xaxis.axis_label, self.plane.yaxis.axis_label = axes
        elif part.name == "diagram":
            self.diagram.figure.xaxis.axis_label = self.state.axis
            self.draw_diagram(part.shown or NOTHING)
            low, high = map(rational, self.state.span)
            self.diagram.look((float(low), float(high)))
            self.stage = summary(part.shown) if part.shown else part.message

    def told(self, *, whole: bool) -> dict[str, Any]:
        rows = [
            {"title": title, "rows": lines}
            for part in self.parts.values() for title, lines in part.rows.items()
        ]  # fmt: skip
        rows.sort(key=lambda each: each["title"] == "Orbit")  # the longest comes last
        return {
            "over": self.state.axis, "axes": list(self.state.plane_names), "rows": rows,
            "busy": self.due or self.is_running("answers"),
            "chaotic": bool(self.tables["density"].data["top"]),
        }  # fmt: skip

    # --- What a user may ask for ------------------------------------------------------------------

    def _tap_map(self, event: Any) -> None:
        self.change(start=str(_near(event.x, self.map.x_range)))

    def _tap_beside(self, event: Any) -> None:
        if self.state.axis:
            value = _near(event.x, self.diagram.figure.x_range)
            self.show(self.state.at({self.state.axis: str(value)}))

    def _tap_plane(self, event: Any) -> None:
        names = self.state.plane_names
        if names:
            axes = (event.x, self.plane.x_range), (event.y, self.plane.y_range)
            values = (str(_near(value, axis)) for value, axis in axes)
            self.show(self.state.at(dict(zip(names, values, strict=True))))


def _near(value: float, axis_range: Any) -> Fraction:
    """The simplest rational within half a pixel or so of a place."""
    size = abs(float(axis_range.end - axis_range.start)) / 600.0
    for most in (1, 2, 4, 5, 10, 20, 50, 100, 200, FINEST):
        found = Fraction(float(value)).limit_denominator(most)
        if abs(float(found) - value) <= size:
            return found
    return Fraction(float(value)).limit_denominator(10_000)


# --- Serving --------------------------------------------------------------------------------------


def controls(state: MapState, first: MapState) -> list[dict[str, Any]]:
    """A slider for each parameter of the map, about its value."""
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
        document, TEMPLATE, "piecewise-linear maps", exports=list(FILES.items()),
        controls=controls(state, first), open_group=PARAMETERS, state=state,
    )  # fmt: skip


def _completed(state: MapState) -> MapState:
    """The state with the signs that its map needs; as it is, if answers say what is missing."""
    try:
        return completed(state)
    except (ValueError, TypeError, ArithmeticError):
        return state


def run(initial: MapState, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Load modules in the process that jobs are forked from, and serve the page."""
    warm_up(["pwmap.explore.map_data"])

    serve(
        partial(make_page, initial=initial), lambda *asked: (export, *asked), "pwmap: two maps",
        port, stay=stay, ready=ready,
    )  # fmt: skip
