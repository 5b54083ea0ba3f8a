"""Names of points and of curves in a picture, so that none covers another.

Places depend on what is shown, so they are looked for anew whenever the picture is drawn: after a
zoom, too, which makes room for names that are left out where points crowd. A name stands close to
its point if there is room; otherwise it moves away from it, and a thin line leads back. It avoids
other names and the legend first, then markers, then curves. A curve's name stands on the curve, and
is left out where there is no room.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox, IdentityTransform

Floats = npt.NDArray[np.float64]

SIZE, CURVE_SIZE = 7.5, 7.0  # of letters [pt]
NEAR = (7.0, 13.0, 20.0, 29.0, 40.0)  # distances from a point to its name that are tried [pt]
LED = 15.0  # farther names have a line that leads to them [pt]
MARKER = 4.5  # half the size of a marker [pt]
DENSEST = 2.0  # optional names per square inch of the axes; if there were more, there are none
EDGE = 2.0  # between a name and the frame [pt]
STEP = 4.0  # between places of a curve that are kept free [pt]
COSTS = {"names": 100.0, "markers": 12.0, "curves": 1.0}  # of covering one of each
SAME = 1.0  # px: distances that differ by less are the same
STRANGE = 10.0  # cost of standing closer to another point than to its own
FARTHER = 0.06  # what a point of distance costs: curves may be crossed for a while before
SHORTEST = 55.0  # of a curve that has a name [pt]
AGAIN = 90.0  # to the next of the same name on another curve [pt]
ALONG = (0.5, 0.62, 0.38, 0.74, 0.26, 0.85, 0.15)  # places on a curve that are tried for its name
DIRECTIONS = tuple(math.radians(angle) for angle in (45, 135, -45, -135, 90, -90, 0, 180))


class Name(NamedTuple):
    """What is written beside a point of the picture; always, or if there is room for all such."""

    text: str
    x: float
    y: float
    always: bool = True


class Curve(NamedTuple):
    """A curve, and what is written on it; nothing if the text is empty."""

    text: str
    x: Floats
    y: Floats
    color: Any = "black"


class Labels(Artist):
    """The names in a picture.

    Parameters
    ----------
    names
        Names of points.
    curves
        Curves, which names of points do not cover if there is room elsewhere.
    markers
        Places (n, 2) of markers besides those of ``names``.
    """

    def __init__(
        self, names: Sequence[Name], curves: Sequence[Curve] = (), markers: Any = ()
    ) -> None:
        super().__init__()
        self.names, self.curves = list(names), list(curves)
        places = [(name.x, name.y) for name in names]
        self.markers: Floats = np.array([*places, *markers]).reshape(-1, 2)
        self.placed: list[tuple[str, Bbox]] = []  # when it was drawn last
        self.set_zorder(6.0)
        self.set_in_layout(False)

    def draw(self, renderer: Any) -> None:
        """Look for places and write the names there."""
        if self.axes is None or not self.get_visible():
            return
        room = _Room(self, renderer)
        self.placed = []
        for curve in sorted(self.curves, key=lambda each: -_length(room.seen(each))):
            if curve.text:
                room.write_on(curve)
        for name in self.names:
            if name.always or room.for_all:
                room.write_beside(name)
        self.placed = room.placed


class _Room:
    """What is taken in a picture, in pixels."""

    def __init__(self, labels: Labels, renderer: Any) -> None:
        self.labels, self.renderer = labels, renderer
        axes: Any = labels.axes
        self.frame: Bbox = axes.bbox
        self.pt = float(axes.figure.dpi) / 72.0
        self.to_pixels = axes.transData.transform
        curves = [_spaced(self.seen(curve), STEP * self.pt) for curve in labels.curves]
        self.on_curves: Floats = np.concatenate([np.empty((0, 2)), *curves])
        self.markers: Floats = self.to_pixels(labels.markers)
        self.placed: list[tuple[str, Bbox]] = []
        legend = axes.get_legend()
        self.legend = [legend.get_window_extent(renderer)] if legend is not None else []
        optional = [name for name in labels.names if not name.always and self._shows(name)]
        inches = self.frame.width * self.frame.height / float(axes.figure.dpi) ** 2
        self.for_all = len(optional) <= DENSEST * inches

    def _shows(self, name: Name) -> bool:
        return bool(self.frame.contains(*self.to_pixels((name.x, name.y))))

    def seen(self, curve: Curve) -> Floats:
        """A curve in pixels, (n, 2)."""
        places: Floats = self.to_pixels(np.column_stack([curve.x, curve.y]))
        return places[np.isfinite(places).all(axis=1)]

    def write_on(self, curve: Curve) -> None:
        """The name of a curve at its middle or near it, where that is seen and free."""
        places = _spaced(self.seen(curve), STEP * self.pt)
        x, y = places.T
        inside = (
            (x > self.frame.x0) & (x < self.frame.x1) & (y > self.frame.y0) & (y < self.frame.y1)
        )
        places = places[inside]
        if len(places) * STEP < SHORTEST:
            return
        text = self._text(curve.text, CURVE_SIZE, curve.color)
        for part in ALONG:
            at = places[round(part * (len(places) - 1))]
            box = self._box(text, at)
            free = not any(box.overlaps(other) for other in self.legend) and not any(
                box.overlaps(other) or (name == curve.text and _apart(box, other) < AGAIN * self.pt)
                for name, other in self.placed
            )
            if free and not _within(box, self.markers, MARKER * self.pt):
                self._write(text, curve.text, box)
                return

    def write_beside(self, name: Name) -> None:
        """The name of a point at the place that covers least."""
        if not self._shows(name):
            return
        point = self.to_pixels((name.x, name.y))
        text = self._text(name.text, SIZE, "black")
        best, least, led = None, math.inf, False
        for distance in NEAR:
            for angle in DIRECTIONS:
                turn = np.array([math.cos(angle), math.sin(angle)])
                box = self._box(text, point, turn, distance * self.pt)
                strange = self._is_strange(box, point)
                cost = self._cost(box) + FARTHER * distance + STRANGE * strange
                if cost < least:
                    best, least, led = box, cost, strange or distance >= LED
        assert best is not None
        if led:
            self._lead(point, best)
        self._write(text, name.text, best)

    def _is_strange(self, box: Bbox, point: Floats) -> bool:
        """Whether a name stands closer to another point than to its own."""
        away = np.hypot(*(self.markers - np.clip(self.markers, box.min, box.max)).T)
        own = float(np.hypot(*(point - np.clip(point, box.min, box.max))))
        others = np.hypot(*(self.markers - point).T) > MARKER * self.pt
        return bool((away[others] < own + SAME).any())

    def _cost(self, box: Bbox) -> float:
        """What a name would cover."""
        boxes = [*self.legend, *(other for _, other in self.placed)]
        taken = sum(bool(box.overlaps(other)) for other in boxes)
        inner = self.frame.padded(-EDGE * self.pt)
        outside = not (inner.contains(*box.min) and inner.contains(*box.max))
        return (
            COSTS["names"] * (taken + outside)
            + COSTS["markers"] * _within(box, self.markers, MARKER * self.pt)
            + COSTS["curves"] * _within(box, self.on_curves, self.pt)
        )

    def _text(self, written: str, size: float, color: Any) -> Text:
        text = Text(0.0, 0.0, written, fontsize=size, color=color, ha="left", va="bottom")
        text.set_figure(self.labels.axes.figure)  # type: ignore[union-attr]
        text.set_path_effects([patheffects.withStroke(linewidth=2.2, foreground="white")])
        text.set_transform(IdentityTransform())
        return text

    def _box(self, text: Text, at: Any, turn: Any = (0.0, 0.0), away: float = 0.0) -> Bbox:
        """Where a text stands that is moved away from a place in some direction."""
        size = text.get_window_extent(self.renderer)
        half = np.array([size.width, size.height]) / 2.0
        direction = np.asarray(turn)
        middle = np.asarray(at) + direction * away
        if away:
            middle = middle + np.sign(np.round(direction, 6)) * half
        return Bbox([middle - half, middle + half])

    def _write(self, text: Text, written: str, box: Bbox) -> None:
        own = text.get_window_extent(self.renderer)
        text.set_position((box.x0 - own.x0, box.y0 - own.y0))
        text.draw(self.renderer)
        self.placed.append((written, box))

    def _lead(self, point: Any, box: Bbox) -> None:
        """A thin line from a point to the nearest place of its name."""
        end = np.clip(point, [box.x0, box.y0], [box.x1, box.y1])
        line = Line2D([point[0], end[0]], [point[1], end[1]], color="#737373", linewidth=0.5)
        line.set_figure(self.labels.axes.figure)  # type: ignore[union-attr]
        line.set_transform(IdentityTransform())
        line.draw(self.renderer)


def _apart(box: Bbox, other: Bbox) -> float:
    """How far the middles of two boxes are apart."""
    return 0.5 * math.hypot(
        box.x0 + box.x1 - other.x0 - other.x1, box.y0 + box.y1 - other.y0 - other.y1
    )


def _within(box: Bbox, places: Floats, margin: float) -> int:
    """How many places lie in a box, or next to it."""
    x, y = places.T
    inside = (x > box.x0 - margin) & (x < box.x1 + margin)
    inside &= (y > box.y0 - margin) & (y < box.y1 + margin)
    return int(inside.sum())


def _length(places: Floats) -> float:
    return float(np.hypot(*np.diff(places, axis=0).T).sum()) if len(places) > 1 else 0.0


def _spaced(places: Floats, step: float) -> Floats:
    """Places along a polyline, evenly spaced, in pixels."""
    if len(places) < 2:
        return places
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    at = np.linspace(0.0, along[-1], min(5000, max(2, math.ceil(along[-1] / step) + 1)))
    return np.column_stack([np.interp(at, along, column) for column in places.T])
