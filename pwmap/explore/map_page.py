"""The page of a piecewise-linear map, put together and served."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.models import Span

from pwmap.explore.diagrams import summary
from pwmap.explore.figures import (
    DOTTED,
    cobweb,
    hover,
    judged,
    new_figure,
    patch,
    set_range,
    solutions,
    source,
    strokes,
)
from pwmap.explore.jobs import Failure, JobFinished, is_warm, warm_up
from pwmap.explore.map_data import SECONDS, MapAnswer, answers
from pwmap.explore.map_exports import FILES, export
from pwmap.explore.map_state import FINEST, MapState, from_query, of_map, rational
from pwmap.explore.page import Control, asked
from pwmap.explore.serving import serve
from pwmap.explore.tab import Demand, Tab, put_on_page
from pwmap.plot import GREY, INK, JUMP, STABLE, VIOLET

TEMPLATE = Path(__file__).parent / "files" / "pwmap.html"
OF_FIXED = "<div class='tip'><b>@word</b> @kind<br>x = @exact</div>"
OF_CURVE = "<div class='tip'><b>@name</b> @tip</div>"


class MapTab(Tab[MapState]):
    """One tab of a piecewise-linear map."""

    TEXTS = (*Tab.TEXTS, "start", "orders", "span", "across", "along")

    def __init__(self, state: MapState, first: MapState) -> None:
        self._draw_map()
        self._draw_others()
        super().__init__(state, first, [self.map, self.plane, self.density], "x")
        self.due, self.chaotic = True, False
        self.rows: dict[str, dict[str, list[list[str]]]] = {}
        self.notes: dict[str, str] = {}
        self._answered = set[str]()  # which parts of the last question
        self.hear(self.plane, self._tap_plane)
        self.show(state)

    def _draw_map(self) -> None:
        self.map = new_figure("map", "x", "P(x)", match_aspect=False)
        figure = self.map
        self.curve, self.web, self.crossings = (source("x", "y") for _ in range(3))
        self.ends = source("x", "y", "fill")
        self.fixed = source("x", "y", "fill", "color", "kind", "word", "exact")
        figure.line([-1e6, 1e6], [-1e6, 1e6], color=GREY)
        figure.line("x", "y", source=self.crossings, color=JUMP, line_dash=DOTTED, line_width=2.2)
        figure.line("x", "y", source=self.curve, color=INK, line_width=2)
        figure.scatter("x", "y", source=self.ends, size=6, fill_color="fill", line_color=INK)
        figure.line("x", "y", source=self.web, color=VIOLET, line_width=1.2)
        figure.add_tools(hover(solutions(figure, self.fixed), OF_FIXED))

    def _draw_others(self) -> None:
        self.plane = new_figure("plane", "", "")
        self.curves = source("xs", "ys", "color", "dash", "name", "tip")
        self.meeting, self.here = source("x", "y"), source("x", "y")
        lines = self.plane.multi_line("xs", "ys", source=self.curves, line_color="color",
                                      line_dash="dash", line_width=1.8)  # fmt: skip
        self.plane.scatter("x", "y", source=self.meeting, size=7, fill_color="white",
                           line_color="black")  # fmt: skip
        self.plane.scatter("x", "y", source=self.here, size=12, fill_color=None, line_color=VIOLET,
                           line_width=2.5, level="overlay")  # fmt: skip
        self.plane.add_tools(hover(lines, OF_CURVE))
        self.density = new_figure("density", "x", "invariant density")
        self.steps = source("left", "right", "top")
        self.density.quad("left", "right", "top", 0.0, source=self.steps, fill_color=STABLE,
                          fill_alpha=0.35, line_color=STABLE)  # fmt: skip
        self.density.add_layout(Span(location=0.0, dimension="width", line_color=GREY))

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: MapState, *, moving: bool = False) -> None:
        """Go to a state, computed in another process; only the last wish counts."""
        self.keep(state, moving=moving)
        self.due = True
        self.diagram.stand(state.value, np.nan)
        names = state.plane_names
        if names:
            x, y = (float(rational(state.place[name])) for name in names)
            patch(self.here, x=[x], y=[y])

    def tick(self) -> None:
        """Start due jobs, and show results that have arrived."""
        if self.due and is_warm():
            self.due, self.stage, self._answered = False, "working …", set()
            self.begin("answers", answers, self.state, seconds=SECONDS)
        told = self.results("answers")
        for result in told:
            if isinstance(result, MapAnswer):
                self._take(result)
            elif isinstance(result, Failure):
                self._fail(result.sentence)
            elif isinstance(result, JobFinished):
                self.message = next(filter(None, self.notes.values()), "")
        if told:
            self.say(self.answer())

    def _fail(self, sentence: str) -> None:
        """Keep new answers, but none about an earlier state."""
        self.message = sentence
        self.rows = {name: rows for name, rows in self.rows.items() if name in self._answered}
        if "diagram" not in self._answered:
            self.draw_diagram(None)
            self.stage = "no diagram"

    def _take(self, part: MapAnswer) -> None:
        self._answered.add(part.name)
        self.rows[part.name], self.notes[part.name] = part.rows, part.message
        tables = part.tables
        if part.name == "map" and tables:
            self._show_map(tables)
        elif part.name == "diagram":
            self._show_diagram(part)
        elif part.name == "long":
            steps = tables.get("density", {"left": [], "right": [], "top": []})
            self.chaotic = bool(steps["top"])
            patch(self.steps, **steps)
            if steps["top"]:
                set_range(self.density.x_range, steps["left"][0], steps["right"][-1])
                set_range(self.density.y_range, 0.0, 1.08 * max(steps["top"]))
        elif part.name == "plane":
            names = ("xs", "ys", "color", "dash", "name", "tip")
            patch(self.curves, **tables.get("plane", {name: [] for name in names}))
            patch(self.meeting, **tables.get("meeting", {"x": [], "y": []}))
            set_range(self.plane.x_range, *map(_float, self.state.across))
            set_range(self.plane.y_range, *map(_float, self.state.along))
            axes = self.state.plane_names or ("", "")
            self.plane.xaxis.axis_label, self.plane.yaxis.axis_label = axes

    def _show_map(self, tables: dict[str, dict[str, Any]]) -> None:
        patch(self.curve, **tables["curve"])
        ends, fixed, lines = tables["ends"], tables["fixed"], tables["crossings"]["lines"]
        fill = [INK if closed else "white" for closed in ends["closed"]]
        patch(self.ends, x=ends["x"], y=ends["y"], fill=fill)
        patch(self.crossings, **strokes(lines[:, ::2], lines[:, 1::2]))
        patch(
            self.fixed, x=fixed["x"], y=fixed["x"], word=fixed["word"], exact=fixed["exact"],
            **judged(fixed["stable"]),
        )  # fmt: skip
        patch(self.web, **cobweb(tables["orbit"]["x"]))
        for axis_range in (self.map.x_range, self.map.y_range):
            set_range(axis_range, *tables["window"]["x"])
        self.map.yaxis.axis_label = rf"$$P_{{{self.state.order}}}(x)$$"

    def _show_diagram(self, part: MapAnswer) -> None:
        self.diagram.figure.xaxis.axis_label = self.state.axis
        self.draw_diagram(part.shown)
        low, high = map(_float, self.state.span)
        self.diagram.look((low, high))
        self.stage = summary(part.shown) if part.shown is not None else part.message

    def told(self, *, whole: bool) -> dict[str, Any]:
        """The texts that the script of the page shows besides the views."""
        state = self.state
        rows = [
            {"title": title, "rows": lines}
            for part in self.rows.values() for title, lines in part.items()
        ]  # fmt: skip
        rows.sort(key=lambda each: each["title"] == "Orbit")  # the longest comes last
        return {
            "over": state.axis,
            "axes": list(state.plane_names),
            "rows": rows,
            "busy": self.due or self.is_running("answers"),
            "chaotic": self.chaotic,
        }

    # --- What a user may ask for ------------------------------------------------------------------

    def demands(self) -> Mapping[str, Demand]:
        """No wishes besides those of every tab."""
        return {}

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


def _float(text: str) -> float:
    return float(rational(text))


# --- Serving --------------------------------------------------------------------------------------


def controls(state: MapState, first: MapState) -> list[Control]:
    """A slider for each parameter of the map, about its value."""
    found = []
    for name, text in state.place.items():
        value = float(rational(text))
        low, high = float(np.floor(value) - 2.0), float(np.ceil(value) + 2.0)
        found.append(
            Control(
                name=name, label=name, meaning=f"parameter {name}, an exact rational", unit="-",
                low=low, high=high, step=0.01, default=first.place[name], group="1:parameters",
                exact=True,
            )
        )  # fmt: skip
    return found


def make_page(document: Document, initial: MapState) -> None:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    same = (state.map, state.given) == (initial.map, initial.given)
    first = initial if same else of_map(state.map, state.given, {})
    tab = MapTab(state, first)
    tab.message = refused
    put_on_page(
        document, TEMPLATE, tab, "piecewise-linear maps", exports=list(FILES.items()),
        controls=[asdict(each) for each in controls(state, first)], open_group="1:parameters",
        state=state,
    )  # fmt: skip


def run(initial: MapState, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Load modules in the process that jobs are forked from, and serve the page."""
    warm_up(["pwmap.explore.map_data"])

    serve(
        partial(make_page, initial=initial), lambda *asked: (export, *asked), "pwmap: two maps",
        port, stay=stay, ready=ready,
    )  # fmt: skip
