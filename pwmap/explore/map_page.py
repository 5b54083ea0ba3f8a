"""The page of a piecewise-linear map, put together and served."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.models import Span

from pwmap.explore.diagram_views import DiagramView, GraphView
from pwmap.explore.diagrams import nearest_line, nearest_sample
from pwmap.explore.figures import (
    DOTTED,
    cobweb,
    hover,
    new_figure,
    on_click,
    patch,
    set_range,
    source,
    strokes,
)
from pwmap.explore.jobs import Failure, Job, JobFinished, is_warm, warm_up
from pwmap.explore.map_data import SECONDS, MapAnswer, answers
from pwmap.explore.map_state import MapState, from_query, python_of, rational, to_query
from pwmap.explore.page import Control, asked, fill
from pwmap.explore.serving import Site, serve
from pwmap.plot import GREY, INK, JUMP, STABLE, UNSTABLE, VIOLET

TEMPLATE = Path(__file__).parent / "files" / "pwmap.html"
TICK = 40  # ms between looks at what the other process has sent
CLICK = 14.0  # px
FINEST = 500  # the largest denominator of a place that is clicked on
UNDO = 100  # states that are kept
OF_FIXED = "<div class='tip'><b>@word</b> @kind<br>x = @exact</div>"
OF_CURVE = "<div class='tip'><b>@name</b> @tip</div>"
VIEWS = ("map", "diagram", "graph", "plane", "density")


class MapTab:
    """One tab: a map, its views, and what a user may ask for."""

    def __init__(self, state: MapState) -> None:
        self.state, self.past, self.message = state, list[MapState](), ""
        self.job: Job | None = None
        self.due = True
        self.rows: dict[str, dict[str, list[list[str]]]] = {}
        self.notes: dict[str, str] = {}
        self.diagram, self.graph = DiagramView("diagram", "", "x"), GraphView("graph")
        self._shown: Any = None
        self.branch, self.chaotic = "", False
        self._draw_map()
        self._draw_others()
        self.say: Callable[[Mapping[str, Any]], None] = lambda _: None

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
        fixed = figure.scatter("x", "y", source=self.fixed, size=10, fill_color="fill",
                               line_color="color", line_width=2)  # fmt: skip
        figure.add_tools(hover(fixed, OF_FIXED))
        on_click(figure, self._heard(self._tap_map))

    def _draw_others(self) -> None:
        on_click(self.diagram.figure, self._heard(self._tap_diagram))
        on_click(self.graph.figure, self._heard(self._tap_graph))
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
        on_click(self.plane, self._heard(self._tap_plane))
        self.density = new_figure("density", "x", "invariant density")
        self.steps = source("left", "right", "top")
        self.density.quad("left", "right", "top", 0.0, source=self.steps, fill_color=STABLE,
                          fill_alpha=0.35, line_color=STABLE)  # fmt: skip
        self.density.add_layout(Span(location=0.0, dimension="width", line_color=GREY))

    @property
    def roots(self) -> list[Any]:
        """The figures, for the page."""
        return [self.map, self.diagram.figure, self.graph.figure, self.plane, self.density]

    # --- State -> views ---------------------------------------------------------------------------

    def show(self, state: MapState, *, moving: bool = False) -> None:
        """Go to a state: what it shows is worked out in another process, the last wish only."""
        if not moving and state != self.state:
            self.past = [*self.past[-UNDO:], self.state]
        self.state, self.message, self.due = state, "", True
        if state.axis:
            value = float(rational(state.place[state.axis]))
            self.diagram.stand(value, np.nan)
        names = [name for name in state.plane if name in state.parameters]
        if len(names) == 2:
            x, y = (float(rational(state.place[name])) for name in names)
            patch(self.here, x=[x], y=[y])

    def tick(self) -> None:
        """Begin what is due, and show what has come."""
        if self.due and is_warm():
            self.due = False
            if self.job is not None:
                self.job.stop()
            self.job = Job(answers, self.state, seconds=SECONDS)
        told = False
        for result in self.job.results() if self.job is not None else ():
            told = True
            if isinstance(result, MapAnswer):
                self._take(result)
            elif isinstance(result, Failure):
                self.message = result.sentence
                self.rows = {}
            elif isinstance(result, JobFinished):
                self.message = next(filter(None, self.notes.values()), "")
        if told:
            self.say(self.answer())

    def _take(self, part: MapAnswer) -> None:
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
            axes = [*(n for n in self.state.plane if n in self.state.parameters), "", ""]
            self.plane.xaxis.axis_label, self.plane.yaxis.axis_label = axes[:2]

    def _show_map(self, tables: dict[str, dict[str, Any]]) -> None:
        patch(self.curve, **tables["curve"])
        ends, fixed, lines = tables["ends"], tables["fixed"], tables["crossings"]["lines"]
        fill = [INK if closed else "white" for closed in ends["closed"]]
        patch(self.ends, x=ends["x"], y=ends["y"], fill=fill)
        patch(self.crossings, **strokes(lines[:, ::2], lines[:, 1::2]))
        colors = [STABLE if stable else UNSTABLE for stable in fixed["stable"]]
        patch(
            self.fixed, x=fixed["x"], y=fixed["x"], color=colors,
            fill=[c if s else "white" for c, s in zip(colors, fixed["stable"], strict=True)],
            kind=["stable" if s else "unstable" for s in fixed["stable"]], word=fixed["word"],
            exact=fixed["exact"],
        )  # fmt: skip
        patch(self.web, **cobweb(tables["orbit"]["x"]))
        for axis_range in (self.map.x_range, self.map.y_range):
            set_range(axis_range, *tables["window"]["x"])
        self.map.yaxis.axis_label = rf"$$P_{{{self.state.order}}}(x)$$"

    def _show_diagram(self, part: MapAnswer) -> None:
        self._shown = part.shown
        self.diagram.figure.xaxis.axis_label = self.state.axis
        self.diagram.show(part.shown)
        self.graph.show(part.shown)
        low, high = map(_float, self.state.span)
        self.diagram.look((low, high))
        self._mark(self.branch)

    def _mark(self, branch: str) -> None:
        known = [b.id for b in self._shown.diagram.branches] if self._shown else []
        self.branch = branch if branch in known else ""
        self.diagram.select(self.branch)
        self.graph.select(self.branch)

    def answer(self) -> dict[str, Any]:
        """What the script of the page shows besides the views."""
        state = self.state
        rows = [
            {"title": title, "rows": lines}
            for part in self.rows.values() for title, lines in part.items()
        ]  # fmt: skip
        rows.sort(key=lambda each: each["title"] == "Orbit")  # the longest comes last
        branches = self._shown.diagram.branches if self._shown else ()
        return {
            "values": state.place, "query": to_query(state), "message": self.message, "rows": rows,
            "python": python_of(state), "order": state.order, "steps": state.steps,
            "start": state.start, "over": state.axis, "orders": state.orders, "focus": state.focus,
            "span": ", ".join(state.span), "busy": self.due or self._busy(), "branch": self.branch,
            "chaotic": self.chaotic, "branches": [
                {"id": b.id, "text": f"{b.id}: {b.kind} {b.word[:20]}"} for b in branches[:300]
            ],
        }  # fmt: skip

    def _busy(self) -> bool:
        return self.job is not None and not self.job.is_over

    # --- What a user may ask for ------------------------------------------------------------------

    def verbs(self) -> dict[str, Callable[[Mapping[str, Any]], Mapping[str, Any]]]:
        """Everything that a wish can name."""
        verbs: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "hello": lambda _: None,
            "set": self._set,
            "back": lambda wish: self.show(self.state.at(**{str(wish["name"]): "1"})),
            "reset": lambda _: self.show(replace(MapState(), map=self.state.map)),
            "undo": lambda _: self._undo(),
            "order": lambda wish: self._change(order=int(wish["value"])),
            "steps": lambda wish: self._change(steps=int(wish["value"])),
            "start": lambda wish: self._change(start=str(rational(wish["value"]))),
            "over": lambda wish: self._change(over=str(wish["value"])),
            "orders": lambda wish: self._change(orders=int(wish["value"])),
            "span": lambda wish: self._change(span=_pair(wish["value"])),
            "across": lambda wish: self._change(across=_pair(wish["value"])),
            "along": lambda wish: self._change(along=_pair(wish["value"])),
            "focus": lambda wish: self._change(focus=str(wish["value"])),
            "branch": lambda wish: self._select(str(wish["value"]), None),
        }

        def answering(verb: Callable[[Mapping[str, Any]], None]) -> Any:
            def answer(wish: Mapping[str, Any]) -> Mapping[str, Any]:
                verb(wish)
                return self.answer()

            return answer

        return {name: answering(verb) for name, verb in verbs.items()}

    def _change(self, **changes: Any) -> None:
        self.show(replace(self.state, **changes))

    def _set(self, wish: Mapping[str, Any]) -> None:
        values = {str(n): str(_exact(v)) for n, v in dict(wish["values"]).items()}
        self.show(self.state.at(**values), moving=bool(wish.get("drag")))

    def _undo(self) -> None:
        if self.past:
            last = self.past.pop()
            self.show(last)
            self.past.pop()

    def _heard(self, verb: Callable[[Any], None]) -> Callable[[Any], None]:
        def hear(event: Any) -> None:
            if event.x is not None:
                verb(event)
                self.say(self.answer())

        return hear

    def _tap_map(self, event: Any) -> None:
        self._change(start=str(_near(event.x, self.map.x_range)))

    def _tap_diagram(self, event: Any) -> None:
        if self._shown is not None:
            scale = self.diagram.scale
            branch, away = nearest_line(self._shown.lines, event.x, event.y, scale)
            if branch and away <= CLICK:
                chosen = self._shown.diagram.branch(branch)
                self._select(branch, nearest_sample(chosen, event.x, event.y, scale))
                return
        if self.state.axis:
            value = _near(event.x, self.diagram.figure.x_range)
            self.show(self.state.at(**{self.state.axis: str(value)}))

    def _tap_graph(self, event: Any) -> None:
        if self._shown is not None:
            branch, away = nearest_line(self._shown.edges, event.x, event.y, self.graph.scale)
            if branch and away <= 2.0 * CLICK:
                self._select(branch, None)

    def _tap_plane(self, event: Any) -> None:
        names = [name for name in self.state.plane if name in self.state.parameters]
        if len(names) == 2:
            axes = (event.x, self.plane.x_range), (event.y, self.plane.y_range)
            values = (str(_near(value, axis)) for value, axis in axes)
            self.show(self.state.at(**dict(zip(names, values, strict=True))))

    def _select(self, branch: str, sample: int | None) -> None:
        """Bring everything to a branch: the parameter, the iterate and a start on it."""
        if self._shown is None:
            return
        chosen = self._shown.diagram.branch(branch)
        k = len(chosen) // 2 if sample is None else sample
        value = Fraction(float(chosen.parameter[k])).limit_denominator(FINEST)
        start = Fraction(float(chosen.x[k])).limit_denominator(FINEST)
        self.branch = branch
        state = replace(self.state, order=chosen.order, start=str(start))
        self.show(state.at(**{self.state.axis: str(value)}))
        self._mark(branch)


def _exact(value: object) -> Fraction:
    """A rational from a field, or from a slider, whose steps are hundredths."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not np.isfinite(value) or abs(value) > 1e9:
            raise ValueError(f"expected a rational, got {value!r}")
        return Fraction(round(1000 * value), 1000)
    return rational(value)


def _near(value: float, axis_range: Any) -> Fraction:
    """The simplest rational within half a pixel or so of a place."""
    size = abs(float(axis_range.end - axis_range.start)) / 600.0
    for most in (1, 2, 4, 5, 10, 20, 50, 100, 200, FINEST):
        found = Fraction(float(value)).limit_denominator(most)
        if abs(float(found) - value) <= size:
            return found
    return Fraction(float(value)).limit_denominator(10_000)


def _pair(value: object) -> tuple[str, str]:
    parts = [str(rational(part)) for part in str(value).split(",")]
    if len(parts) != 2:
        raise ValueError("expected two rationals, such as -1, 4")
    return parts[0], parts[1]


def _float(text: str) -> float:
    return float(rational(text))


# --- Serving --------------------------------------------------------------------------------------


def controls(state: MapState) -> list[Control]:
    """A slider for each parameter of the map."""
    found = []
    for name, text in state.place.items():
        value = float(rational(text))
        low, high = float(np.floor(value) - 2.0), float(np.ceil(value) + 2.0)
        found.append(
            Control(
                name=name, label=name, meaning=f"parameter {name}, an exact rational", unit="-",
                low=low, high=high, step=0.01, default="1", group="1:parameters", exact=True,
            )
        )  # fmt: skip
    return found


def make_page(document: Document, initial: MapState) -> MapTab:
    """Fill the document of one tab."""
    state, refused = asked(document, from_query, initial)
    tab = MapTab(state)
    tab.show(state)
    tab.message = refused
    tab.say = fill(
        document, TEMPLATE, tab.roots, tab.verbs(), page_title="piecewise-linear maps",
        exports=[("lines.py", "lines of Python"), ("state.json", "the state (JSON)")],
        controls=[asdict(each) for each in controls(state)], open_group="1:parameters",
        state=state,
    )  # fmt: skip
    document.title = "pwmap"
    document.add_periodic_callback(tab.tick, TICK)
    document.on_session_destroyed(lambda _: tab.job.stop() if tab.job else None)
    return tab


def export(name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes one file: the state, or the lines of Python."""
    import json

    state = from_query(query)
    if name == "lines.py":
        yield "text/x-python; charset=utf-8", python_of(state).encode()
    elif name == "state.json":
        yield "application/json", json.dumps(asdict(state), indent=1).encode()
    else:
        raise ValueError(f"unknown file {name!r}")


def run(initial: MapState, port: int | None, *, stay: bool, ready: Callable[[str], None]) -> None:
    """Load what computes where jobs are forked from, and serve the page."""
    warm_up(["pwmap.explore.map_data"])

    def page(document: Document) -> None:
        make_page(document, initial)

    site = Site(page=page, export=lambda *asked: (export, *asked), compare="pwmap: two maps")
    serve(site, port, stay=stay, ready=ready)
