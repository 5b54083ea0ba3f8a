"""The views of map, motion and word: figures of Bokeh whose tables are patched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from bokeh.models import ColumnDataSource, Range1d, Span

from pwmap.explore.figures import (
    DASHED,
    DOTTED,
    FONT,
    Put,
    cobweb,
    hover,
    judged,
    keep_in,
    new_figure,
    patch,
    set_range,
    solutions,
    source,
    strokes,
)
from pwmap.plot import GREY, INK, JUMP, STABLE, VIOLET
from woodpecker.explore.model import DrawnMotion, MapCurve, Mark, as_columns
from woodpecker.explore.state import PORTRAITS, PageState
from woodpecker.mechanics.toy import description
from woodpecker.plot.motions import STRUCK, way_of

Floats = npt.NDArray[np.float64]

CONTACTS = {k: STRUCK[(k,)][1]["color"] for k in (1, 2, 3)}
BOTH = STRUCK[(1, 3)][1]["color"]
NO_COLOR, PALE = "#737373", "#9ecae1"
LABELS = {
    "phi_s": (r"$$\varphi_S\ [\mathrm{rad}]$$", r"$$\dot\varphi_S\ [\mathrm{rad/s}]$$"),
    "phi_m": (r"$$\varphi_M\ [\mathrm{rad}]$$", r"$$\dot\varphi_M\ [\mathrm{rad/s}]$$"),
    "fall": (r"$$\varphi_S\ [\mathrm{rad}]$$", r"$$\dot y\ [\mathrm{m/s}]$$"),
}
OF_EVENT = (
    "<div class='tip'><b>@symbol</b> at @time{0.0000} ms: @what<br>@impulses<br>@velocities</div>"
)
OF_FIXED = "<div class='tip'><b>@kind fixed point</b> of P_@order<br>at @x{0.000000}</div>"
WORD_ROOM = 30  # events that have room for their symbols and times


PHI = r"$$\varphi_S\ [\mathrm{rad}]$$"


def axis_label(parameter: str) -> str:
    """A parameter as the paper writes it, with its unit, for an axis."""
    letter, _, index = parameter.partition("_")
    greek = {"mu": r"\mu", "eps": r"\varepsilon"}.get(letter, letter)
    index = {"phi": r"\varphi", "n1": "N1", "n2": "N2", "n3": "N3"}.get(index, index.upper())
    unit = description(parameter).unit
    told = "" if unit == "-" else rf"\ [\mathrm{{{unit.replace(' ', chr(92) + ' ')}}}]"
    return f"$${greek}{f'_{{{index}}}' if index else ''}{told}$$"


class MapView:
    """The return map with the diagonal, its jumps and a cobweb."""

    def __init__(self, symbol: str = r"\varphi_S", unit: str = r"\ [\mathrm{rad}]") -> None:
        base, _, index = symbol.partition("_")
        self._label = f"$${base}_{{{index}{',' if index else ''}k{{}}}}{unit}$$"
        self.figure = new_figure("map", self._told(""), self._told("+1"), crosshair=True)
        self.curve, self.web = source("x", "y"), source("x", "y")
        self.jumps, self.crossings, self.steep = (source("x", "y") for _ in range(3))
        self.rings, self.start = source("x", "y"), source("x", "y")
        self.fixed = source("x", "y", "fill", "color", "kind", "order")
        figure = self.figure
        figure.line([-9, 9], [-9, 9], color=GREY, line_width=1.0)
        figure.line("x", "y", source=self.steep, color=PALE, line_width=1.0)
        figure.line("x", "y", source=self.jumps, color=GREY, line_dash=DOTTED, line_width=1.4)
        figure.line("x", "y", source=self.crossings, color=JUMP, line_dash=DOTTED, line_width=2.2)
        figure.line("x", "y", source=self.curve, color=STABLE, line_width=1.6)
        figure.line("x", "y", source=self.web, color=VIOLET, line_width=1.2)
        figure.scatter("x", "y", source=self.rings, size=11, fill_color=None, line_color=JUMP,
                       line_width=2)  # fmt: skip
        fixed = solutions(figure, self.fixed)
        figure.scatter("x", "y", source=self.start, size=8, marker="square", color=VIOLET)
        figure.add_tools(hover(fixed, OF_FIXED))

    def look(self, window: tuple[float, float]) -> None:
        """Show an interval on both axes."""
        set_range(self.figure.x_range, *window)
        set_range(self.figure.y_range, *window)

    def show(self, found: MapCurve, order: int, put: Put = patch) -> None:
        """Draw a map."""
        put(self.curve, x=found.x, y=found.y)
        for table, lines in (
            (self.jumps, found.jumps), (self.crossings, found.crossings), (self.steep, found.steep),
        ):  # fmt: skip
            put(table, **strokes(lines[:, ::2], lines[:, 1::2]))
        at = found.crossings[:, 0]
        put(self.rings, x=at, y=at)
        put(
            self.fixed, x=found.fixed, y=found.fixed, order=[order] * len(found.fixed),
            **judged(found.stable),
        )  # fmt: skip
        self.figure.yaxis.axis_label = self._told(f"+{order}")

    def _told(self, step: str) -> str:
        return self._label.replace("{}", step)

    def follow(self, orbit: Floats, put: Put = patch) -> None:
        """Draw the cobweb of an orbit."""
        put(self.web, **cobweb(orbit))
        put(self.start, x=orbit[:1], y=orbit[:1])


class MotionView:
    """Time histories and a phase portrait, with the instant ``now`` that the browser moves."""

    def __init__(self) -> None:
        wide = Range1d(0, 1)
        self.angles = new_figure(
            "angles", "", r"$$\varphi\ [\mathrm{rad}]$$", x_range=wide, ticks=(5, 4)
        )
        self.fall = new_figure(
            "fall", r"$$t\ [\mathrm{ms}]$$", r"$$y\ [\mathrm{mm}]$$", x_range=wide, ticks=(5, 4)
        )
        self.portrait = new_figure("portrait", *LABELS["phi_s"], ticks=(4, 5))
        columns = ("t", "y", "phi_m", "phi_s", "dy", "dphi_m", "dphi_s", "closed")
        self.motion, self.way = source(*columns, name="motion"), source("x", "y", name="way")
        self.impacts = source("t", "a", "y", "color", "symbol")
        self.strokes = source("x0", "y0", "x1", "y1", "color")
        self.now = ColumnDataSource({"x": [0.0], "y": [0.0]}, name="now", syncable=False)
        self.instant = ColumnDataSource({"t": [0.0]}, name="instant", syncable=False)
        self._stops: list[Span] = []
        self._draw_histories()
        portrait = self.portrait
        portrait.line("x", "y", source=self.way, color=STABLE, line_width=1.7)
        portrait.segment("x0", "y0", "x1", "y1", source=self.strokes, color="color",
                         line_dash=DASHED, line_width=1.7)  # fmt: skip
        portrait.scatter("x", "y", source=self.now, size=11, color=VIOLET, line_color="white",
                         level="overlay")  # fmt: skip

    def _draw_histories(self) -> None:
        for column, dash in (("phi_s", "solid"), ("phi_m", DASHED)):
            self.angles.line("t", column, source=self.motion, color=STABLE, line_width=1.7,
                             line_dash=dash)  # fmt: skip
        self.fall.line("t", "y", source=self.motion, color=STABLE, line_width=1.7)
        self.angles.xaxis.major_label_text_font_size = "0px"
        self.angles.xaxis.axis_label_text_font_size = "0px"
        for _ in range(3):
            stop = Span(location=0.0, dimension="width", line_color=GREY, line_dash=DASHED)
            self._stops.append(stop)
            self.angles.add_layout(stop)
        self.angles.scatter("t", "a", source=self.impacts, size=7, color="color")
        self.fall.scatter("t", "y", source=self.impacts, size=7, color="color")
        for figure in (self.angles, self.fall):
            figure.vspan("t", source=self.instant, color=VIOLET, line_width=1.6, level="overlay")

    def show(
        self, motion: DrawnMotion, state: PageState, put: Put = patch, *, moving: bool
    ) -> None:
        """Draw a motion; while a slider moves axes stay where they are, if they can."""
        columns = as_columns(motion)
        put(self.motion, **columns)
        limits = (-state.toy.phi_m_max, state.toy.phi_m_max, state.toy.phi_s_max)
        for stop, limit in zip(self._stops, limits, strict=True):
            stop.location = limit
        end = float(columns["t"][-1])
        keep_in(self.angles.x_range, 0.0, end * (1.04 if moving else 1.0), moving=moving)
        both = np.concatenate([columns["phi_s"], columns["phi_m"], [state.toy.phi_s_max]])
        keep_in(self.angles.y_range, *_room(both, 0.1), moving=moving)
        keep_in(self.fall.y_range, *_room(columns["y"], 0.1), moving=moving)
        impacts = _impacts(motion, columns)
        put(self.impacts, **impacts)
        across = columns["phi_m" if state.portrait == "phi_m" else "phi_s"]
        up = columns[PORTRAITS[state.portrait]]
        put(self.way, **dict(zip(("x", "y"), way_of(columns["t"], across, up), strict=True)))
        colors = dict(zip(impacts["t"], impacts["color"], strict=True))
        put(self.strokes, **jumps_of(columns["t"], across, up, colors))
        keep_in(self.portrait.x_range, *_room(across, 0.06), moving=moving)
        keep_in(self.portrait.y_range, *_room(up, 0.06), moving=moving)
        labels = LABELS[state.portrait]
        self.portrait.xaxis.axis_label, self.portrait.yaxis.axis_label = labels


def jumps_of(t: Floats, across: Floats, up: Floats, colors: Mapping[float, str]) -> dict[str, Any]:
    """Jumps of velocity, in the colours of their contacts by time."""
    struck = np.flatnonzero(np.diff(t) == 0.0)
    return {
        "x0": across[struck], "y0": up[struck], "x1": across[struck + 1], "y1": up[struck + 1],
        "color": [colors.get(time, NO_COLOR) for time in t[struck].tolist()],
    }  # fmt: skip


def _impacts(motion: DrawnMotion, columns: dict[str, Any]) -> dict[str, Any]:
    struck = [mark for mark in motion.marks if mark.symbol.startswith("I")]
    times = [1e3 * mark.time for mark in struck]
    at = np.minimum(np.searchsorted(columns["t"], times), len(columns["t"]) - 1)
    return {
        "t": times, "a": columns["phi_s"][at], "y": columns["y"][at],
        "color": [color_of(mark.contacts) for mark in struck],
        "symbol": [mark.symbol for mark in struck],
    }  # fmt: skip


class WordView:
    """The word of the motion as a strip of its events."""

    def __init__(self) -> None:
        self.figure = new_figure("word", "", "", y_range=Range1d(-0.62, 0.62))
        self.events = source(
            "x", "color", "symbol", "time", "what", "impulses", "velocities", "t", "alpha", "label",
            name="events",
        )  # fmt: skip
        figure = self.figure
        figure.axis.visible = figure.grid.visible = False
        figure.toolbar.active_scroll = figure.toolbar.active_drag = None
        boxes = figure.rect(
            "x", 0.14, width=0.92, height=0.66, source=self.events, fill_color="color",
            fill_alpha="alpha", line_color="color", border_radius=4,
        )  # fmt: skip
        figure.text(
            "x", 0.14, text="label", source=self.events, text_font={"value": FONT},
            text_font_size="13px",
            text_align="center", text_baseline="middle", text_color=INK, text_font_style="bold",
        )  # fmt: skip
        self.times = figure.text(
            "x", -0.42, text="t", source=self.events, text_font={"value": FONT},
            text_font_size="10px",
            text_align="center", text_baseline="middle", text_color="#525252",
        )  # fmt: skip
        self.now = ColumnDataSource({"x": [-0.5]}, name="word_now", syncable=False)
        figure.scatter("x", -0.2, source=self.now, size=9, marker="triangle", color=VIOLET,
                       level="overlay")  # fmt: skip
        figure.add_tools(hover(boxes, OF_EVENT))

    def show(self, marks: tuple[Mark, ...], put: Put = patch) -> None:
        """Draw the events of a motion."""
        n = len(marks)
        put(
            self.events, x=list(range(n)), color=[color_of(mark.contacts) for mark in marks],
            symbol=[mark.symbol for mark in marks], time=[1e3 * mark.time for mark in marks],
            what=[mark.what for mark in marks], impulses=[mark.impulses for mark in marks],
            velocities=[mark.velocities for mark in marks],
            t=[f"{1e3 * mark.time:.2f}" if n <= WORD_ROOM else "" for mark in marks],
            label=[mark.symbol if n <= WORD_ROOM else "" for mark in marks],
            alpha=[0.45 if mark.symbol.startswith("I") else 0.12 for mark in marks],
        )  # fmt: skip
        set_range(self.figure.x_range, -0.7, max(n, 8) - 0.3)


def color_of(contacts: tuple[int, ...]) -> str:
    """The colour of a contact, as in all pictures of motions; of several, that of both."""
    if len(contacts) > 1:
        return str(BOTH)
    return str(CONTACTS.get(contacts[0], NO_COLOR)) if contacts else NO_COLOR


def _room(values: Floats, part: float) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    margin = part * (high - low) or 1e-3
    return low - margin, high + margin
