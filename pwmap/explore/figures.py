"""One look for all views: the colours, lines and symbols of :mod:`pwmap.plot`, for Bokeh.

A view is a figure whose glyphs take their columns from named tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    CrosshairTool,
    HoverTool,
    PanTool,
    Range1d,
    Slope,
    WheelZoomTool,
)
from bokeh.plotting import figure

from pwmap.diagrams.diagram import Diagram
from pwmap.plot import GREY, INK, JUMP, STABLE, UNSTABLE, VIOLET

FONT = "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif"
DOTTED, DASHED = [2, 3], [6, 3]
DASHES = {"stable": [], "unstable": DASHED, "jump crossing": DOTTED}
COLORS = {"stable": STABLE, "unstable": UNSTABLE, "jump crossing": JUMP}
MARKS = {  # symbols of pwmap.plot.MARKERS as Bokeh calls them
    "s": "square", "D": "diamond", "h": "hex", "P": "cross", "o": "circle", "*": "star",
    "v": "inverted_triangle", "|": "dash", "^": "triangle", "X": "x",
}  # fmt: skip
PALE = "#9ecae1"  # for parts that are not resolved
SHORT = 100  # arrays with fewer values are sent as lists
ROOM = 0.15  # margin of an axis that a moving slider outgrows, relative to what it shows
SHRUNK = 0.6  # part of an axis: what fills less of it is enlarged
SMALL, PLAIN = "11px", "12px"
Table = dict[str, Any]  # columns by their names
Rows = list[list[str]]
EMPTY = Diagram(parameter_name="", x_name="", branches=(), points=())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shown:
    """A part of what a page shows; tables and figures are addressed by their names."""

    name: str = ""  # of the answer, if there are several
    tables: Mapping[str, Table] = field(default_factory=dict)  # new columns
    ends: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # left, right, low, high
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # of both axes
    rows: Mapping[str, Rows] = field(default_factory=dict)  # texts, by their heading
    diagram: Diagram = EMPTY
    message: str = ""  # why it is not all, or how far it has come; empty if it is all


def new_figure(
    name: str,
    x_label: str,
    y_label: str,
    *,
    crosshair: bool = False,
    ticks: tuple[int, int] = (6, 5),
    **options: Any,
) -> Any:
    """Axes in the common look, named for the page; pan by dragging, zoom by the wheel."""
    made = figure(
        name=name, tools="", toolbar_location=None, sizing_mode="stretch_both",
        x_axis_label=x_label, y_axis_label=y_label, min_border=4, outline_line_color="#bdbdbd",
        **{"x_range": Range1d(0, 1), "y_range": Range1d(0, 1), **options},
    )  # fmt: skip
    zoom = WheelZoomTool()
    pan = PanTool()
    made.add_tools(pan, zoom)
    made.toolbar.active_scroll, made.toolbar.active_drag = zoom, pan
    if crosshair:
        made.add_tools(CrosshairTool(line_color=GREY, line_alpha=0.6))
    for axis in made.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size, axis.axis_label_text_font = PLAIN, FONT
        axis.major_label_text_font_size, axis.major_label_text_font = SMALL, FONT
        axis.axis_label_text_color = axis.major_label_text_color = INK
        axis.axis_label_standoff, axis.minor_tick_line_color = 3, None
        axis.major_tick_line_color, axis.axis_line_color = GREY, "#bdbdbd"
    made.grid.grid_line_color, made.grid.grid_line_alpha = "#d9d9d9", 0.6
    made.xaxis.ticker.desired_num_ticks, made.yaxis.ticker.desired_num_ticks = ticks
    return made


def source(name: str, *columns: str) -> ColumnDataSource:
    """An empty table with these columns."""
    return ColumnDataSource({each: [] for each in columns}, name=name)


def tables_of(figures: Iterable[Any]) -> dict[str, ColumnDataSource]:
    """The tables of figures by their names."""
    tables = [each.data_source for figure in figures for each in figure.renderers]
    return {table.name: table for table in tables}


def hover(glyph: Any, tips: str) -> HoverTool:
    """The tooltip of the nearest part of a glyph."""
    return HoverTool(renderers=[glyph], tooltips=tips, point_policy="snap_to_data")


def map_figure(x_label: str, y_label: str, tip: str, *told: str, color: str = STABLE) -> Any:
    """The view of a map with its jumps, the diagonal and a cobweb.

    ``told`` are further columns of the fixed points, which their ``tip`` shows.
    """
    made = new_figure("map", x_label, y_label, crosshair=True)
    made.add_layout(Slope(gradient=1.0, y_intercept=0.0, line_color=GREY, level="underlay"))
    for name, style in (
        ("steep", {"color": PALE}),
        ("jumps", {"color": GREY, "line_dash": DOTTED, "line_width": 1.4}),
        ("crossings", {"color": JUMP, "line_dash": DOTTED, "line_width": 2.2}),
        ("curve", {"color": color, "line_width": 1.8}),
        ("web", {"color": VIOLET, "line_width": 1.2}),
    ):
        made.line("x", "y", source=source(name, "x", "y"), **style)
    made.scatter(
        "x", "y", source=source("ends", "x", "y", "fill"), size=6, fill_color="fill", line_color=INK
    )
    made.scatter(
        "x", "y", source=source("rings", "x", "y"), size=11, fill_color=None, line_color=JUMP,
        line_width=2,
    )  # fmt: skip
    solutions(made, tip, *told)
    return made


def solutions(figure: Any, tip: str, *told: str) -> None:
    """Add dots for solutions, with the columns of :func:`judged` and ``told``, and the start."""
    dots = figure.scatter(
        "x", "y", source=source("fixed", "x", "y", "fill", "color", "kind", *told), size=10,
        fill_color="fill", line_color="color", line_width=2,
    )  # fmt: skip
    figure.scatter(
        "x", "y", source=source("start", "x", "y"), size=8, marker="square", color=VIOLET
    )
    figure.add_tools(hover(dots, tip))


def ring(figure: Any, table: ColumnDataSource) -> None:
    """Add a ring around the current place."""
    figure.scatter(
        "x", "y", source=table, size=12, fill_color=None, line_color=VIOLET, line_width=2.5,
        level="overlay",
    )  # fmt: skip


def set_range(axis_range: Any, low: float, high: float) -> None:
    """Move the ends of an axis, both at once."""
    if (axis_range.start, axis_range.end) != (low, high):
        axis_range.update(start=low, end=high)


def keep_in(axis_range: Any, low: float, high: float, *, moving: bool) -> None:
    """Show an interval; while a slider moves, only if it exceeds the axis or is much smaller."""
    if moving:
        start, end = axis_range.start, axis_range.end
        # moving an axis costs more than drawing its curves
        room = ROOM * (high - low)
        left = start if start <= low else low - room
        right = end if high <= end else high + room
        if high - low >= SHRUNK * (right - left):
            low, high = left, right
    set_range(axis_range, low, high)


def patch(table: ColumnDataSource, /, **columns: Any) -> None:
    """Replace the columns of a table in one message, short arrays as lists."""
    if any(map(len, columns.values())) or any(map(len, table.data.values())):
        table.data = {
            name: values.tolist() if isinstance(values, np.ndarray) and values.size < SHORT
            else values
            for name, values in columns.items()
        }  # fmt: skip


def judged(stable: Iterable[bool]) -> dict[str, list[str]]:
    """Colours, fills and kinds of solutions; those that attract are filled."""
    kinds = ["stable" if each else "unstable" for each in stable]
    color = [COLORS[kind] for kind in kinds]
    fill = [c if kind == "stable" else "white" for c, kind in zip(color, kinds, strict=True)]
    return {"color": color, "fill": fill, "kind": kinds}


def along(line: tuple[Any, Any]) -> Table:
    """The columns of a line, which is given by its coordinates x and y."""
    return {"x": line[0], "y": line[1]}
