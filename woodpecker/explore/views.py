"""Views of maps, motions and words, for the toy and any system, and the data that fill them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from bokeh.models import ColumnDataSource, Range1d

from pwmap.explore.figures import (
    DASHED,
    FONT,
    Shown,
    Table,
    along,
    hover,
    judged,
    new_figure,
    solutions,
    source,
)
from pwmap.plot import INK, STABLE, VIOLET
from pwmap.plot.drawn import stairs, strokes
from woodpecker.explore.model import MapCurve, Mark
from woodpecker.plot.motions import STRUCK, with_gaps

Floats = npt.NDArray[np.float64]

CONTACTS = {k: STRUCK[(k,)][1]["color"] for k in (1, 2, 3)}
BOTH = STRUCK[(1, 3)][1]["color"]
NO_COLOR = "#737373"
OF_EVENT = (
    "<div class='tip'><b>@symbol</b> at @time{0.0000} ms: @what<br>@impulses<br>@velocities</div>"
)
OF_POINT = "<div class='tip'><b>@kind cycle</b><br>@x{0.000000}, @y{0.000000}</div>"
OF_FIXED = "<div class='tip'><b>@kind fixed point</b> of P_@order<br>at @x{0.000000}</div>"
OF_IMPACT = "<div class='tip'><b>@symbol</b> at @t{0.000000}</div>"
WORD_ROOM = 30  # largest number of events that leaves room for symbols and times
MARGIN = 0.08  # on both sides of a curve, as a part of its extent


# --- Maps -----------------------------------------------------------------------------------------


def labels_of(symbol: str, unit: str = "", step: str = "+1") -> tuple[str, str]:
    """Axis labels of a coordinate of the map: before, and ``step`` returns later."""
    base, _, index = symbol.partition("_")
    before, after = (
        f"$${base}_{{{index}{',' if index else ''}k{each}}}{unit}$$" for each in ("", step)
    )
    return before, after


def of_map(found: MapCurve, order: int, labels: tuple[str, str]) -> Shown:
    """Data of a map of one coordinate; of a map of several, only its cycle."""
    x, y = found.fixed.T if found.fixed.ndim > 1 else (found.fixed, found.fixed)
    fixed = {"x": x, "y": y, **judged(found.stable)}
    if found.fixed.ndim > 1:
        return Shown(tables={"fixed": fixed})
    at = found.crossings[:, 0]
    tables: dict[str, Table] = {
        "curve": {"x": found.x, "y": found.y}, "rings": {"x": at, "y": at},
        "fixed": {**fixed, "order": [order] * len(found.fixed)},
    }  # fmt: skip
    for name in ("jumps", "crossings", "steep"):
        lines = getattr(found, name)
        tables[name] = along(strokes(lines[:, ::2], lines[:, 1::2]))
    return Shown(tables=tables, labels={"map": labels})


def of_orbit(orbit: Floats) -> Shown:
    """Data of the cobweb of an orbit (n,), or of points (n, d) by their first two coordinates."""
    x, y = (orbit, orbit) if orbit.ndim == 1 else orbit.T[:2]
    web = stairs(orbit) if orbit.ndim == 1 else (x, y)
    return Shown(tables={"web": along(web), "start": {"x": x[:1], "y": y[:1]}})


def section_figure(x_label: str, y_label: str) -> Any:
    """The view of a section in the plane of its first two coordinates."""
    figure = new_figure("map", x_label, y_label, crosshair=True)
    web = source("web", "x", "y")
    figure.line("x", "y", source=web, color=VIOLET, line_alpha=0.3)
    figure.scatter("x", "y", source=web, size=5, color=VIOLET)
    solutions(figure, OF_POINT)
    return figure


# --- Motions --------------------------------------------------------------------------------------


def motion_figures(
    panels: Mapping[str, Sequence[str]], labels: Sequence[str], *more: str
) -> tuple[Any, ...]:
    """Two time histories and a phase portrait.

    ``panels`` has the columns of each history by its name, ``labels`` the labels of both vertical
    axes and of time; ``more`` are columns that are not drawn.
    """
    wide, firsts = Range1d(0, 1), [first for first, *_ in panels.values()]
    drawn = [name for names in panels.values() for name in names]
    motion = source("motion", "t", *drawn, *more)
    impacts = source("impacts", "t", "color", "symbol", *firsts)
    figures = []
    for (name, names), label in zip(panels.items(), labels, strict=False):
        figure = new_figure(name, labels[-1], label, x_range=wide, ticks=(5, 4))
        for k, column in enumerate(names):
            figure.line("t", column, source=motion, color=STABLE, line_width=1.7,
                        line_dash=DASHED if k else "solid")  # fmt: skip
        dots = figure.scatter("t", names[0], source=impacts, size=7, color="color")
        figure.add_tools(hover(dots, OF_IMPACT))
        figures.append(figure)
    figures[0].xaxis.major_label_text_font_size = "0px"
    figures[0].xaxis.axis_label_text_font_size = "0px"
    portrait = new_figure("portrait", "", "", ticks=(4, 5))
    strokes_ = source("strokes", "x0", "y0", "x1", "y1", "color")
    portrait.line("x", "y", source=source("way", "x", "y"), color=STABLE, line_width=1.7)
    portrait.segment("x0", "y0", "x1", "y1", source=strokes_,
                     color="color", line_dash=DASHED, line_width=1.7)  # fmt: skip
    return *figures, portrait


def of_motion(
    columns: Table, marks: Sequence[Mark], second: float, panels: Mapping[str, Sequence[str]],
    portrait: tuple[str, str],
) -> Shown:  # fmt: skip
    """Data of the views of a motion and of its word; ``second`` is 1 s in the unit of ``t``."""
    t, (across, up) = columns["t"], (columns[name] for name in portrait)
    impacts = [mark for mark in marks if mark.symbol.startswith(("I", "C"))]
    times = [second * mark.time for mark in impacts]
    at = np.minimum(np.searchsorted(t, times), len(t) - 1)
    colors = [color_of(mark.contacts) for mark in impacts]
    firsts = {names[0]: columns[names[0]][at] for names in panels.values()}
    symbols = [mark.symbol for mark in impacts]
    struck = np.flatnonzero(np.diff(t) == 0.0)
    by_time = dict(zip(t[at].tolist(), colors, strict=True))
    tables = {
        "motion": columns, "way": along(with_gaps(t, across, up)), "events": word_of(marks),
        "impacts": {"t": t[at], "color": colors, "symbol": symbols, **firsts},
        "strokes": {
            "x0": across[struck], "y0": up[struck], "x1": across[struck + 1], "y1": up[struck + 1],
            "color": [by_time.get(time, NO_COLOR) for time in t[struck].tolist()],
        },
    }  # fmt: skip
    heights = {
        name: np.concatenate([columns[each] for each in names]) for name, names in panels.items()
    }
    return Shown(
        tables=tables,
        ends={
            **{name: (0.0, float(t[-1]), *room(values)) for name, values in heights.items()},
            "portrait": (*room(across), *room(up)),
            "word": (-0.7, max(len(marks), 8) - 0.3, *WORD_HEIGHT),
        },
    )


def room(values: Floats) -> tuple[float, float]:
    """Ends of an axis that shows some values with a margin."""
    low, high = float(np.min(values)), float(np.max(values))
    margin = MARGIN * (high - low) or 1e-3
    return low - margin, high + margin


# --- Words ----------------------------------------------------------------------------------------

WORD_HEIGHT = (-0.62, 0.62)  # ends of the vertical axis


def word_figure() -> Any:
    """The view of a word as a strip of events, with a mark that the browser moves with time."""
    figure = new_figure("word", "", "", y_range=Range1d(*WORD_HEIGHT))
    events = source(
        "events", "x", "color", "symbol", "time", "what", "impulses", "velocities", "t", "alpha",
        "label",
    )  # fmt: skip
    figure.axis.visible = figure.grid.visible = False
    figure.toolbar.active_scroll = figure.toolbar.active_drag = None
    boxes = figure.rect(
        "x", 0.14, width=0.92, height=0.66, source=events, fill_color="color", fill_alpha="alpha",
        line_color="color", border_radius=4,
    )  # fmt: skip
    for y, text, style in (
        (0.14, "label", {"text_font_size": "13px", "text_color": INK, "text_font_style": "bold"}),
        (-0.42, "t", {"text_font_size": "10px", "text_color": "#525252"}),
    ):
        figure.text("x", y, text=text, source=events, text_font={"value": FONT},
                    text_align="center", text_baseline="middle", **style)  # fmt: skip
    now = ColumnDataSource({"x": [-0.5]}, name="word_now", syncable=False)
    figure.scatter("x", -0.2, source=now, size=9, marker="triangle", color=VIOLET, level="overlay")
    figure.add_tools(hover(boxes, OF_EVENT))
    return figure


def word_of(marks: Sequence[Mark]) -> Table:
    """Data of the view of a word."""
    few = len(marks) <= WORD_ROOM
    return {
        "x": list(range(len(marks))), "color": [color_of(mark.contacts) for mark in marks],
        "symbol": [mark.symbol for mark in marks], "time": [1e3 * mark.time for mark in marks],
        "what": [mark.what for mark in marks], "impulses": [mark.impulses for mark in marks],
        "velocities": [mark.velocities for mark in marks],
        "t": [f"{1e3 * mark.time:.2f}" if few else "" for mark in marks],
        "label": [mark.symbol if few else "" for mark in marks],
        "alpha": [0.45 if mark.symbol.startswith("I") else 0.12 for mark in marks],
    }  # fmt: skip


def color_of(contacts: tuple[int, ...]) -> str:
    """The colour of a contact as in all pictures of motions; several contacts share one colour."""
    if len(contacts) > 1:
        return str(BOTH)
    return str(CONTACTS.get(contacts[0], NO_COLOR)) if contacts else NO_COLOR
