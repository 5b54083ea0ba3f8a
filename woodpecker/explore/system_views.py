"""Views of systems only: points in a plane, and one coordinate over time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from bokeh.models import Range1d

from pwmap.explore.figures import (
    DASHED,
    hover,
    judged,
    new_figure,
    patch,
    set_range,
    solutions,
    source,
)
from pwmap.plot import STABLE, VIOLET
from woodpecker.explore.model import DrawnMotion, MapCurve
from woodpecker.explore.views import color_of, jumps_of
from woodpecker.plot.motions import way_of

Floats = npt.NDArray[np.float64]

OF_POINT = "<div class='tip'><b>@kind cycle</b><br>@x{0.000000}, @y{0.000000}</div>"
OF_IMPACT = "<div class='tip'><b>@symbol</b> at @t{0.000000} s</div>"
MARGIN = 0.08  # of the height, above and below a curve


class PlaneView:
    """Returns in the plane of the first two coordinates of a section: an orbit, and a cycle."""

    def __init__(self, x_label: str, y_label: str) -> None:
        self.figure = new_figure("map", x_label, y_label, crosshair=True)
        self.points, self.start = source("x", "y"), source("x", "y")
        self.fixed = source("x", "y", "fill", "color", "kind")
        figure = self.figure
        figure.line("x", "y", source=self.points, color=VIOLET, line_alpha=0.3)
        figure.scatter("x", "y", source=self.points, size=5, color=VIOLET)
        fixed = solutions(figure, self.fixed)
        figure.scatter("x", "y", source=self.start, size=8, marker="square", color=VIOLET)
        figure.add_tools(hover(fixed, OF_POINT))

    def look(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        """Show an interval on each axis."""
        set_range(self.figure.x_range, *across)
        set_range(self.figure.y_range, *up)

    def show(self, found: MapCurve, _: int) -> None:
        """Draw the points of a cycle."""
        patch(self.fixed, x=found.fixed[:, 0], y=found.fixed[:, 1], **judged(found.stable))

    def follow(self, orbit: Floats) -> None:
        """Draw an orbit (n, d), from the start on."""
        patch(self.points, x=orbit[:, 0], y=orbit[:, 1])
        patch(self.start, x=orbit[:1, 0], y=orbit[:1, 1])


class HistoryView:
    """One coordinate and its velocity over time, and both against each other."""

    def __init__(self) -> None:
        wide = Range1d(0, 1)
        self.position = new_figure("position", "", "", x_range=wide, ticks=(5, 4))
        self.velocity = new_figure("velocity", "t [s]", "", x_range=wide, ticks=(5, 4))
        self.portrait = new_figure("portrait", "", "", ticks=(4, 5))
        self.motion, self.way = source("t", "q", "u"), source("q", "u")
        self.impacts = source("t", "q", "u", "color", "symbol")
        self.strokes = source("x0", "y0", "x1", "y1", "color")
        for figure, column in ((self.position, "q"), (self.velocity, "u")):
            figure.line("t", column, source=self.motion, color=STABLE, line_width=1.7)
            dots = figure.scatter("t", column, source=self.impacts, size=7, color="color")
            figure.add_tools(hover(dots, OF_IMPACT))
        self.position.xaxis.major_label_text_font_size = "0px"
        self.portrait.line("q", "u", source=self.way, color=STABLE, line_width=1.7)
        self.portrait.segment("x0", "y0", "x1", "y1", source=self.strokes, color="color",
                              line_dash=DASHED, line_width=1.7)  # fmt: skip

    def show(self, motion: DrawnMotion, coordinate: int, names: tuple[str, str]) -> None:
        """Draw a motion, by the number of its coordinate and the names of that and its velocity."""
        t, q, u = motion.t, motion.q[:, coordinate], motion.u[:, coordinate]
        patch(self.motion, t=t, q=q, u=u)
        impacts = [mark for mark in motion.marks if mark.symbol.startswith(("I", "C"))]
        at = np.minimum(np.searchsorted(t, [mark.time for mark in impacts]), len(t) - 1)
        color = [color_of(mark.contacts) for mark in impacts]
        patch(
            self.impacts, t=t[at], q=q[at], u=u[at], color=color,
            symbol=[mark.symbol for mark in impacts],
        )  # fmt: skip
        patch(self.way, **dict(zip(("q", "u"), way_of(t, q, u), strict=True)))
        patch(self.strokes, **jumps_of(t, q, u, dict(zip(t[at].tolist(), color, strict=True))))
        set_range(self.position.x_range, 0.0, float(t[-1]))
        for axis_range, values in (
            (self.position.y_range, q), (self.velocity.y_range, u), (self.portrait.x_range, q),
            (self.portrait.y_range, u),
        ):  # fmt: skip
            margin = MARGIN * float(np.ptp(values)) or 1.0
            set_range(axis_range, float(values.min()) - margin, float(values.max()) + margin)
        self.position.yaxis.axis_label, self.velocity.yaxis.axis_label = names
        self.portrait.xaxis.axis_label, self.portrait.yaxis.axis_label = names
