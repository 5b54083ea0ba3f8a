"""The views of a diagram, for both packages: branches over the parameter, and their graph."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.models import Range1d

from pwmap.explore.diagrams import EDGES, LINES, NOTHING, POINTS, SAMPLES, Shown, Table
from pwmap.explore.figures import (
    FONT,
    Put,
    hover,
    new_figure,
    patch,
    select_style,
    set_range,
    source,
)
from pwmap.plot import GREY, INK, VIOLET
from pwmap.plot.labels import Floats, contained, overlap

CHARACTER, HEIGHT = 7.0, 13.0  # px: mean width of a character, height of a line
MARKER = 7.0  # px: half the size of what markers take
DIRECTIONS = ((1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
GAP = 3.0  # px between labels
COVERED = 5.0  # the cost of a marker under a label: those that cost more are left out
DISTANCES = (1.0, 6.0, 14.0)  # px from the point


def place(
    texts: Sequence[str], points: Floats, frame: tuple[float, float], must: Sequence[bool]
) -> list[tuple[int, float, float]]:
    """Places (which text, its middle beside its point [px]) for labels that cover no other one.

    The points (n, 2) and the frame are in pixels, y upward. Labels of ``must`` are placed first, in
    any case; others are left out if they would cover something.
    """
    taken: list[Floats] = []
    found: list[tuple[int, float, float]] = []
    shows = np.all((points >= 0.0) & (points <= np.array(frame)), axis=1)
    order = sorted(range(len(texts)), key=lambda k: not must[k])
    for k in order:
        if not texts[k] or not shows[k]:
            continue
        size = np.array([CHARACTER * len(texts[k]), HEIGHT])
        middles = np.array(
            [np.array(way) * (size / 2.0 + away) for away in DISTANCES for way in DIRECTIONS]
        )
        boxes = np.hstack([points[k] + middles - size / 2.0, points[k] + middles + size / 2.0])
        costs = 10.0 * ((boxes[:, :2] < 0.0) | (boxes[:, 2:] > frame)).any(axis=1)
        costs += 10.0 * overlap(boxes[:, None], np.array(taken).reshape(-1, 4)).sum(axis=1)
        costs += COVERED * contained(boxes, points, MARKER)
        best = int(np.argmin(costs + 0.01 * np.arange(len(costs))))
        if costs[best] < COVERED or must[k]:
            taken.append(boxes[best] + GAP * np.array([-1.0, -1.0, 1.0, 1.0]))
            found.append((k, float(middles[best, 0]), float(middles[best, 1])))
    return found


SIZE = ("inner_width", "inner_height")  # of a figure, as the page tells it
USUAL = (520.0, 230.0)  # px of a picture, until the page has told
MOST_LABELS = 30
POLE = 8.0  # how much higher a diagram is than most of it, if not all of it is shown
OF_BRANCH = (
    "<div class='tip'><b>@branch</b> @kind<br>@x{0.000000}, @y{0.000000}<br>"
    "multiplier @multiplier<br>@word</div>"
)
OF_POINT = "<div class='tip'><b>@label @id</b> @kind<br>at @where<br>@cause</div>"
OF_EDGE = "<div class='tip'><b>@branch</b> @tip</div>"


def _marks(figure: Any, table: Any) -> Any:
    return figure.scatter(
        "x", "y", source=table, marker="marker", size="size", angle="angle", fill_color="color",
        line_color="white", line_width=0.6, level="annotation",
    )  # fmt: skip


def _texts(figure: Any, table: Any, color: str = INK) -> Any:
    return figure.text(
        "x", "y", text="text", x_offset="dx", y_offset="dy", source=table, text_color=color,
        text_font={"value": FONT}, text_font_size="11px", text_align="center",
        text_baseline="middle", background_fill_color="white", background_fill_alpha=0.7,
        level="glyph",
    )  # fmt: skip


class DiagramView:
    """Branches as they are found, special points with their names, and the place of the page."""

    def __init__(self, name: str, x_label: str, y_label: str) -> None:
        self.figure = new_figure(name, x_label, y_label)
        self.lines, self.samples = source(*LINES), source(*SAMPLES)
        self.points, self.names = source(*POINTS), source("x", "y", "text", "dx", "dy")
        self.selected, self.orbits = source("xs", "ys"), source("x", "y")
        self.here = source("x", "y")
        self.moved = False  # whether somebody looks closer than at the whole
        self._shown = NOTHING
        figure = self.figure
        figure.scatter("x", "y", source=self.orbits, size=1.6, color="#636363", alpha=0.35)
        figure.multi_line("xs", "ys", source=self.selected, **select_style())
        figure.multi_line(
            "xs", "ys", source=self.lines, line_color="color", line_dash="dash", line_width="width"
        )
        samples = figure.scatter("x", "y", source=self.samples, size=9, alpha=0.0)
        marks = _marks(figure, self.points)
        _texts(figure, self.names)
        figure.vspan("x", source=self.here, color=VIOLET, line_alpha=0.7, level="overlay")
        figure.scatter(
            "x", "y", source=self.here, size=12, fill_color=None, line_color=VIOLET, line_width=2.5,
            level="overlay",
        )  # fmt: skip
        figure.add_tools(hover(marks, OF_POINT), hover(samples, OF_BRANCH))
        for axis_range in (figure.x_range, figure.y_range):
            _on_change(axis_range, "end", hear=self._name)
        _on_change(figure, *SIZE, hear=self._name)

    def look(self, x: tuple[float, float]) -> None:
        """Show an interval of the parameter, and all of the diagram there."""
        self.moved = False
        margin = 0.015 * (x[1] - x[0])
        set_range(self.figure.x_range, x[0] - margin, x[1] + margin)
        self._fit()

    def _fit(self) -> None:
        heights = np.asarray(self.samples.data["y"], dtype=float)
        heights = heights[np.isfinite(heights)]
        if not self.moved and heights.size:
            low, high = np.percentile(heights, [0.0, 100.0]).tolist()
            inner = np.percentile(heights, [10.0, 90.0]).tolist()
            if high - low > POLE * (inner[1] - inner[0]) > 0.0:  # a branch goes to infinity
                low, high = inner
            margin = 0.12 * (high - low) or 1.0
            set_range(self.figure.y_range, low - margin, high + margin)

    def show(self, found: Shown) -> None:
        """Draw a diagram."""
        self._shown = found
        patch(self.lines, **found.lines)
        patch(self.samples, **found.samples)
        patch(self.points, **found.points)
        self._fit()
        self._name()

    def select(self, branch: str) -> None:
        """Mark one branch."""
        patch(self.selected, **_part(self._shown.lines, branch))

    def stand(self, p: float, x: float, put: Put = patch) -> None:
        """Show the place of the page; nan if it has no height."""
        put(self.here, x=[p], y=[x])

    def _name(self) -> None:
        patch(self.names, **_named(self.figure, self._shown.points)[0])


class GraphView:
    """The graph of branches: special points are nodes, branches are edges."""

    def __init__(self, name: str) -> None:
        wide = Range1d(-0.12, 1.12)
        self.figure = new_figure(name, "", "", x_range=wide, y_range=Range1d(-0.15, 1.15))
        self.edges, self.nodes = source(*EDGES), source(*POINTS)
        self.names, self.tags = (source("x", "y", "text", "dx", "dy") for _ in range(2))
        self.selected = source("xs", "ys")
        self._shown = NOTHING
        figure = self.figure
        figure.axis.visible = figure.grid.visible = False
        figure.multi_line("xs", "ys", source=self.selected, **select_style())
        edges = figure.multi_line(
            "xs", "ys", source=self.edges, line_color="color", line_dash="dash", line_width=2.2
        )
        nodes = _marks(figure, self.nodes)
        _texts(figure, self.tags, GREY)
        _texts(figure, self.names)
        figure.add_tools(hover(nodes, OF_POINT), hover(edges, OF_EDGE))
        _on_change(figure, *SIZE, hear=self._name)

    def show(self, found: Shown) -> None:
        """Draw the graph of a diagram."""
        self._shown = found
        patch(self.edges, **found.edges)
        patch(self.nodes, **found.nodes)
        self._name()

    def _name(self) -> None:
        edges = self._shown.edges
        size = len(edges["x"])
        few = {**edges, "must": [False] * size}
        if size > MOST_LABELS:
            few["label"] = [""] * size
        names, tags = _named(self.figure, self._shown.nodes, few)
        patch(self.names, **names)
        patch(self.tags, **tags)

    def select(self, branch: str) -> None:
        """Mark one edge."""
        patch(self.selected, **_part(self._shown.edges, branch))


def _on_change(model: Any, *properties: str, hear: Callable[[], None]) -> None:
    def changed(attr: str, old: object, new: object) -> None:
        hear()

    for name in properties:
        model.on_change(name, changed)


def _size(figure: Any) -> tuple[float, float]:
    """Width and height [px] inside the axes, once the page has sent them."""
    try:
        return float(figure.inner_width), float(figure.inner_height)
    except UnsetValueError:
        return USUAL


def scale_of(figure: Any) -> tuple[float, float]:
    """Pixels for one unit of both axes."""
    width, height = _size(figure)
    across, up = figure.x_range, figure.y_range
    return width / (across.end - across.start), height / (up.end - up.start)


def _part(table: Table, branch: str) -> Table:
    rows = [k for k, each in enumerate(table["branch"]) if each == branch]
    return {name: [table[name][k] for k in rows] for name in ("xs", "ys")}


def _named(figure: Any, *tables: Table) -> list[Table]:
    scale, frame = np.array(scale_of(figure)), _size(figure)
    start = np.array([figure.x_range.start, figure.y_range.start])
    rows = [(k, i) for k, table in enumerate(tables) for i in range(len(table["x"]))]
    found = [Table(x=[], y=[], text=[], dx=[], dy=[]) for _ in tables]
    if not rows:
        return found
    places = np.array([(tables[k]["x"][i], tables[k]["y"][i]) for k, i in rows], dtype=float)
    labels = place(
        [tables[k]["label"][i] for k, i in rows], (places - start) * scale, frame,
        [tables[k]["must"][i] for k, i in rows],
    )  # fmt: skip
    for row, dx, dy in labels[: 2 * MOST_LABELS]:
        k, i = rows[row]
        values = places[row, 0], places[row, 1], tables[k]["label"][i], dx, -dy  # offsets go down
        for column, value in zip(found[k].values(), values, strict=True):
            column.append(value)
    return found
