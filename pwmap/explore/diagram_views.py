"""The views of a diagram, for both packages: branches over the parameter, and their graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.models import ColumnDataSource, Range1d

from pwmap.explore.diagrams import EDGES, LINES, MOST_LABELS, POINTS, SAMPLES
from pwmap.explore.figures import FONT, Table, hover, new_figure, patch, ring, set_range, source
from pwmap.plot import GREY, INK, VIOLET
from pwmap.plot.labels import Floats, contained, overlap

CHARACTER, HEIGHT = 7.0, 13.0  # px: mean width of a character, height of a line
MARKER = 7.0  # px: half the size of a marker
DIRECTIONS = ((1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
GAP = 3.0  # px: least distance between labels
COVERED = 5.0  # cost of covering a marker: optional labels that cost as much are left out
DISTANCES = (1.0, 6.0, 14.0)  # px: from a point to its label, tried in turn


def place(
    texts: Sequence[str], points: Floats, frame: tuple[float, float], must: Sequence[bool]
) -> list[tuple[int, float, float]]:
    """Place labels without overlaps: index of a text, and its middle relative to its point [px].

    The points (n, 2) and the frame are in pixels, y upward. Labels with ``must`` come first and are
    always placed; the others are left out if they would cover something.
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


SIZE = ("inner_width", "inner_height")  # properties of a figure that the page sends
USUAL = (520.0, 230.0)  # px: size of a figure until the page has sent it
OUTLIER_RATIO = 8.0  # a diagram that is so many times as high as its inner 80 % is not shown whole
OF_BRANCH = (
    "<div class='tip'><b>@branch</b> @kind<br>@x{0.000000}, @y{0.000000}<br>"
    "multiplier @multiplier<br>@word</div>"
)
OF_POINT = "<div class='tip'><b>@label @id</b> @kind<br>at @where<br>@cause</div>"
OF_EDGE = "<div class='tip'><b>@branch</b> @tip</div>"


SELECTED = {"line_color": "#fec44f", "line_width": 8, "line_alpha": 0.75, "line_cap": "round"}


def diagram_figure(y_label: str) -> Any:
    """The figure of branches over a parameter, named special points, and the current place."""
    figure = new_figure("diagram", "", y_label)
    figure.scatter("x", "y", source=source("orbits", "x", "y"), size=1.6, color="#636363",
                   alpha=0.35)  # fmt: skip
    figure.multi_line("xs", "ys", source=source("selected", "xs", "ys"), **SELECTED)
    figure.multi_line(
        "xs", "ys", source=source("lines", *LINES), line_color="color", line_dash="dash",
        line_width="width",
    )  # fmt: skip
    samples = figure.scatter("x", "y", source=source("samples", *SAMPLES), size=9, alpha=0.0)
    _marks(figure, points := source("points", *POINTS))
    _keep_named(figure, (points, _texts(figure, "names")))
    here = source("here", "x", "y")
    figure.vspan("x", source=here, color=VIOLET, line_alpha=0.7, level="overlay")
    ring(figure, here)
    figure.add_tools(hover(samples, OF_BRANCH))
    return figure


def graph_figure() -> Any:
    """The figure of the graph: special points are nodes, branches are edges."""
    wide = Range1d(-0.12, 1.12)
    figure = new_figure("graph", "", "", x_range=wide, y_range=Range1d(-0.15, 1.15))
    figure.axis.visible = figure.grid.visible = False
    figure.multi_line("xs", "ys", source=source("chosen", "xs", "ys"), **SELECTED)
    edges, nodes = source("edges", *EDGES), source("nodes", *POINTS)
    lines = figure.multi_line(
        "xs", "ys", source=edges, line_color="color", line_dash="dash", line_width=2.2
    )
    _marks(figure, nodes)
    tags = _texts(figure, "tags", GREY)
    _keep_named(figure, (nodes, _texts(figure, "node_names")), (edges, tags))
    figure.add_tools(hover(lines, OF_EDGE))
    return figure


def fit(figure: Any, samples: Table) -> None:
    """Show all samples on the vertical axis, or most of them if a branch goes to infinity."""
    heights = np.asarray(samples["y"], dtype=float)
    heights = heights[np.isfinite(heights)]
    if heights.size:
        low, high = np.percentile(heights, [0.0, 100.0]).tolist()
        inner = np.percentile(heights, [10.0, 90.0]).tolist()
        if high - low > OUTLIER_RATIO * (inner[1] - inner[0]) > 0.0:
            low, high = inner
        margin = 0.12 * (high - low) or 1.0
        set_range(figure.y_range, low - margin, high + margin)


def part(lines: Table, branch: str) -> Table:
    """The lines of one branch."""
    rows = [k for k, each in enumerate(lines["branch"]) if each == branch]
    return {name: [lines[name][k] for k in rows] for name in ("xs", "ys")}


def _marks(figure: Any, table: ColumnDataSource) -> None:
    marks = figure.scatter(
        "x", "y", source=table, marker="marker", size="size", angle="angle", fill_color="color",
        line_color="white", line_width=0.6, level="annotation",
    )  # fmt: skip
    figure.add_tools(hover(marks, OF_POINT))


def _texts(figure: Any, name: str, color: str = INK) -> ColumnDataSource:
    table = source(name, "x", "y", "text", "dx", "dy")
    figure.text(
        "x", "y", text="text", x_offset="dx", y_offset="dy", source=table, text_color=color,
        text_font={"value": FONT}, text_font_size="11px", text_align="center",
        text_baseline="middle", background_fill_color="white", background_fill_alpha=0.7,
        level="glyph",
    )  # fmt: skip
    return table


def _keep_named(figure: Any, *pairs: tuple[ColumnDataSource, ColumnDataSource]) -> None:
    """Place names again when a table or the view changes; pairs are (points, their names)."""

    def name(attr: str, old: object, new: object) -> None:
        for (_, texts), found in zip(
            pairs, _named(figure, *(t.data for t, _ in pairs)), strict=True
        ):
            patch(texts, **found)

    for axis_range in (figure.x_range, figure.y_range):
        axis_range.on_change("end", name)
    for each in SIZE:
        figure.on_change(each, name)
    for table, _ in pairs:
        table.on_change("data", name)


def _size(figure: Any) -> tuple[float, float]:
    """Width and height [px] inside the axes, once the page has sent them."""
    try:
        return float(figure.inner_width), float(figure.inner_height)
    except UnsetValueError:
        return USUAL


def scale_of(figure: Any) -> tuple[float, float]:
    """Pixels per unit of both axes."""
    width, height = _size(figure)
    across, up = figure.x_range, figure.y_range
    return width / (across.end - across.start), height / (up.end - up.start)


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
        values = places[row, 0], places[row, 1], tables[k]["label"][i], dx, -dy  # down is positive
        for column, value in zip(found[k].values(), values, strict=True):
            column.append(value)
    return found
