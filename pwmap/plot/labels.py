"""Names of points and of curves in a picture, placed so that none covers another.

Places are found whenever the picture is drawn, also after a zoom. Points whose markers overlap
share one label: their names from left to right or, if there are many, kinds with runs of numbers,
such as FF3-FF9. A label moves away from its point to find room, with a thin line back if it is far
or nearer to another point. It avoids other labels, their lines and the legend first, then markers,
then curves. A curve's name stands on the curve, or is left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import cache
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox, IdentityTransform

from pwmap.plot.drawn import sized

Floats = npt.NDArray[np.float64]

SIZE, CURVE_SIZE = 7.5, 7.0  # font sizes of names of points and of curves [pt]
NEAR = (6.0, 9.0, 13.0, 20.0, 29.0, 40.0, 55.0, 72.0, 90.0)  # tried from a point to its name [pt]
LEADER_DISTANCE = 15.0  # distance from which on a thin line leads from a point to its name [pt]
MARKER = 4.5  # half the size of a marker [pt]
SHARED = 2.5  # points closer than this share one label: their markers hide one another [pt]
SAME_PLACE = 0.3  # points closer than this are one dot in print [pt]
LISTED = 4  # most names written out on one label; more become kinds with runs of numbers
LONGEST = 14  # letters of a label in one row; longer ones have two rows
DENSEST = 2.0  # most optional names per square inch of the axes; with more, none is written
EDGE = 2.0  # least distance of a name from the frame [pt]
CLEAR = 2.0  # least distance of a name from another [pt]
STEP = 4.0  # spacing of the places on a curve that names avoid [pt]
OUTSIDE = 1000.0  # cost of a name that the frame cuts off
COSTS = {"names": 100.0, "markers": 12.0, "curves": 1.0}  # of covering one of each
# Cost of a name that covers another or several markers: the next start begins with it.
RESTART_COST = 40.0
SAME = 1.0  # distances that differ by less are equal [px]
WRONG_POINT_COST = 10.0  # cost of standing closer to another point than to its own
DISTANCE_COST = 0.06  # cost per pt of distance: 1 pt costs less than covering a curve
SWEEPS = 6  # most passes through all names, in which each moves to its cheapest place
STARTS = 8  # most starts of the sweeps, each with the names first that covered something
ON_LINE = np.linspace(0.0, 1.0, 41)[1:-1]  # places at which a leading line is tested
SHORTEST = 55.0  # length of the shortest curve that gets a name [pt]
AGAIN = 90.0  # least distance between equal names on different curves [pt]
ALONG = (0.5, *(0.5 + 0.05 * side * k for k in range(1, 10) for side in (1, -1)))  # places on a
# curve, as fractions of it, that are tried for its name
TURNS = np.radians([45, 135, -45, -135, 90, -90, 0, 180, *np.arange(22.5, 360.0, 45.0)])
DIRECTIONS: Floats = np.column_stack([np.cos(TURNS), np.sin(TURNS)]).round(6)


class Name(NamedTuple):
    """The name of a point: written always, or only if there is room for all optional ones."""

    text: str
    x: float
    y: float
    always: bool = True


class LabelledCurve(NamedTuple):
    """A curve that names avoid, and its own name if it has one and is not too short [pt]."""

    text: str
    x: Floats
    y: Floats
    color: Any = "black"
    shortest: float = SHORTEST


class _Places(NamedTuple):
    """The n possible places of a label, in pixels, with their costs."""

    written: str
    text: Text
    point: Floats  # (2,), the middle of the points
    boxes: Floats  # (n, 4): left, lower, right and upper end
    led: npt.NDArray[np.bool_]  # (n,): whether a line leads there
    lines: Floats  # (n, m, 2): places on these lines; nan where there is none
    costs: Floats  # (n,): without the cost of covering other labels


class Labels(Artist):
    """The names in a picture; those of points avoid curves, and markers of other points."""

    def __init__(
        self, names: Sequence[Name], curves: Sequence[LabelledCurve] = (), markers: Any = ()
    ) -> None:
        super().__init__()
        self.names, self.curves = list(names), list(curves)
        places = [(name.x, name.y) for name in names]
        self.markers: Floats = np.array([*places, *markers]).reshape(-1, 2)
        self.placed: list[tuple[str, Bbox]] = []  # names and boxes of the latest drawing
        self.leads: list[tuple[int, Floats, Floats]] = []  # number in placed, point, end [px]
        self.set_zorder(6.0)
        self.set_in_layout(False)

    def before(self) -> list[Labels]:
        """The names of what was drawn on the same axes before."""
        artists: Any = () if self.axes is None else self.axes.artists
        every = [each for each in artists if isinstance(each, Labels)]
        return every[: every.index(self)] if self in every else []

    def draw(self, renderer: Any) -> None:
        """Find places and write the names there."""
        if self.axes is None or not self.get_visible():
            return
        self.placed, self.leads = [], []
        room = _TakenRoom(self, renderer)
        for curve in sorted(self.curves, key=lambda each: -_length(room.seen(each))):
            if curve.text:
                room.write_on(curve)
        room.write_beside([name for name in self.names if name.always or room.for_all])


class _TakenRoom:
    """The curves, markers, texts and legend that names avoid, in pixels."""

    def __init__(self, labels: Labels, renderer: Any) -> None:
        self.labels, self.renderer = labels, renderer
        axes: Any = labels.axes
        self.frame: Bbox = axes.bbox
        self.pt = float(axes.figure.dpi) / 72.0
        self.to_pixels = axes.transData.transform
        curves = [_spaced(self.seen(curve), STEP * self.pt) for curve in labels.curves]
        self.on_curves: Floats = np.concatenate([np.empty((0, 2)), *curves])
        self.markers: Floats = self.to_pixels(labels.markers)
        self.placed, self.leads = labels.placed, labels.leads
        there = [axes.get_legend(), *(text for text in axes.texts if text.get_visible())]
        # boxes of the legend, of texts that are not names, and of names that were written before
        self.legend = [each.get_window_extent(renderer) for each in there if each is not None]
        self.before = labels.before()
        self.legend += [box for each in self.before for _, box in each.placed]
        optional = [name for name in labels.names if not name.always and self._shows(name)]
        inches = self.frame.width * self.frame.height / float(axes.figure.dpi) ** 2
        self.for_all = len(optional) <= DENSEST * inches

    def _shows(self, name: Name) -> bool:
        return bool(self.frame.contains(*self.to_pixels((name.x, name.y))))

    def seen(self, curve: LabelledCurve) -> Floats:
        """A curve in pixels, (n, 2)."""
        places: Floats = self.to_pixels(np.column_stack([curve.x, curve.y]))
        return places[np.isfinite(places).all(axis=1)]

    def write_on(self, curve: LabelledCurve) -> None:
        """Write the name of a curve at or near its middle, where that is visible and free."""
        places = _spaced(self.seen(curve), STEP * self.pt)
        inside = (places > self.frame.min) & (places < self.frame.max)
        places = places[inside.all(axis=1)]
        if not len(places) or len(places) * STEP < curve.shortest:
            return
        text = self._text(curve.text, CURVE_SIZE, curve.color)
        for part in ALONG:
            at = places[round(part * (len(places) - 1))]
            box = self._box(text, at)
            clear = box.padded(CLEAR * self.pt)
            free = not any(box.overlaps(other) for other in self.legend) and not any(
                clear.overlaps(other)
                or (name == curve.text and _apart(box, other) < AGAIN * self.pt)
                for name, other in self.placed
            )
            free = free and self.frame.contains(*box.min) and self.frame.contains(*box.max)
            if free and not contained(np.array([box.extents]), self.markers, MARKER * self.pt)[0]:
                self._write(text, curve.text, box)
                return

    def write_beside(self, names: Sequence[Name]) -> None:
        """Write the names of points at the places that together cost least."""
        labels = [self._places(group) for group in self._groups(names)]
        for label, best in zip(labels, _chosen(labels), strict=True):
            box = Bbox(label.boxes[best].reshape(2, 2))
            if label.led[best]:
                self._lead(label.point, box)
            self._write(label.text, label.written, box)

    def _groups(self, names: Sequence[Name]) -> list[list[tuple[Name, Floats]]]:
        """Visible names with their points, grouped where markers overlap."""
        groups: list[list[tuple[Name, Floats]]] = []
        written = {name[:3] for each in self.before for name in each.names}
        for name in (each for each in names if self._shows(each) and each[:3] not in written):
            point: Floats = self.to_pixels((name.x, name.y))
            for group in groups:
                if all(np.hypot(*(point - other)) < SHARED * self.pt for _, other in group):
                    group.append((name, point))
                    break
            else:
                groups.append([(name, point)])
        return groups

    def _places(self, group: Sequence[tuple[Name, Floats]]) -> _Places:
        ordered = sorted(group, key=lambda each: float(each[1][0]))
        written = _shared_text([name.text for name, _ in ordered])
        own = np.array([point for _, point in group])
        point: Floats = own.mean(axis=0)
        text = self._text(_in_rows(written), SIZE, "black")
        size = text.get_window_extent(self.renderer)
        half = np.array([size.width, size.height]) / 2.0
        away = np.repeat(NEAR, len(DIRECTIONS)) * self.pt
        turns = np.tile(DIRECTIONS, (len(NEAR), 1))
        middle = point + turns * away[:, None] + np.sign(turns) * half
        boxes = np.hstack([middle - half, middle + half])
        strange = self._strange(boxes, own)
        led = strange | (away >= LEADER_DISTANCE * self.pt)
        ends = np.clip(point, boxes[:, :2], boxes[:, 2:])
        lines = point + ON_LINE[:, None] * (ends - point)[:, None]
        lines[~led] = np.nan
        costs = (
            DISTANCE_COST * away / self.pt
            + WRONG_POINT_COST * strange
            + self._covered(boxes, lines, own)
        )
        return _Places(written, text, point, boxes, led, lines, costs)

    def _strange(self, boxes: Floats, own: Floats) -> npt.NDArray[np.bool_]:
        """Whether labels stand closer to another point than to their own."""
        others = self._others(own, SAME_PLACE)
        if not len(others):
            return np.zeros(len(boxes), dtype=bool)
        near: npt.NDArray[np.bool_] = (
            _distances(boxes, others).min(axis=1) < _distances(boxes, own).min(axis=1) + SAME
        )
        return near

    def _others(self, own: Floats, near: float) -> Floats:
        """The markers that are farther than ``near`` [pt] from all points of a label."""
        apart = np.hypot(*(self.markers[:, None] - own).T).min(axis=0)
        found: Floats = self.markers[apart > near * self.pt]
        return found

    def _covered(self, boxes: Floats, lines: Floats, own: Floats) -> Floats:
        """The costs of what a label covers at each of its places, other labels apart."""
        inner = self.frame.padded(-EDGE * self.pt)
        outside = (boxes[:, :2] < inner.min).any(axis=1) | (boxes[:, 2:] > inner.max).any(axis=1)
        legends = np.array([box.extents for box in self.legend]).reshape(-1, 4)
        written = np.array([box.extents for _, box in self.placed]).reshape(-1, 4)
        taken = np.vstack([legends, _padded(written, CLEAR * self.pt)])
        overlaps = overlap(boxes[:, None], taken).sum(axis=1)
        overlaps = overlaps + _strike(lines[:, None], taken).sum(axis=1)
        others = self._others(own, SHARED)
        struck = np.hypot(*(lines[:, :, None] - others).T) < 0.6 * MARKER * self.pt
        markers = contained(boxes, self.markers, MARKER * self.pt) + struck.any(axis=1).sum(axis=0)
        reach = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
        near = ((self.on_curves > reach[0]) & (self.on_curves < reach[1])).all(axis=1)
        cost: Floats = (
            OUTSIDE * outside
            + COSTS["names"] * overlaps
            + COSTS["markers"] * markers
            + COSTS["curves"] * contained(boxes, self.on_curves[near], self.pt)
        )
        return cost

    def _text(self, written: str, size: float, color: Any) -> Text:
        text = Text(0.0, 0.0, written, fontsize=sized(size), color=color, ha="left", va="bottom")
        text.set_figure(self.labels.axes.figure)  # type: ignore[union-attr]
        text.set_path_effects([patheffects.withStroke(linewidth=2.2, foreground="white")])
        text.set_transform(IdentityTransform())
        return text

    def _box(self, text: Text, at: Floats) -> Bbox:
        """The box of a text with its middle at a place."""
        size = text.get_window_extent(self.renderer)
        half = np.array([size.width, size.height]) / 2.0
        return Bbox([at - half, at + half])

    def _write(self, text: Text, written: str, box: Bbox) -> None:
        own = text.get_window_extent(self.renderer)
        text.set_position((box.x0 - own.x0, box.y0 - own.y0))
        text.draw(self.renderer)
        self.placed.append((written, box))

    def _lead(self, point: Any, box: Bbox) -> None:
        """Draw a thin line from a point to the nearest place of its name."""
        end = np.clip(point, [box.x0, box.y0], [box.x1, box.y1])
        self.leads.append((len(self.placed), point, end))
        line = Line2D([point[0], end[0]], [point[1], end[1]], color="#737373", linewidth=0.5)
        line.set_figure(self.labels.axes.figure)  # type: ignore[union-attr]
        line.set_transform(IdentityTransform())
        line.draw(self.renderer)


def _chosen(labels: Sequence[_Places]) -> list[int]:
    """The index of a place for each label, chosen so that the sum of their costs is small."""
    # cached, as most labels stay where they are from one sweep to the next
    beside = cache(lambda k, other, place: _beside(labels[k], labels[other], place))

    def cost(chosen: dict[int, int], k: int) -> Floats:
        """The cost of each place of one label among the chosen places of the others."""
        others = (beside(k, other, place) for other, place in chosen.items() if other != k)
        total: Floats = sum(others, start=labels[k].costs)
        return total

    order = list(range(len(labels)))
    best, least = list[int](), math.inf
    for _ in range(STARTS):
        chosen = _settled(cost, order)
        costs = [cost(chosen, k)[chosen[k]] for k in range(len(labels))]
        if sum(costs) < least:
            best, least = [chosen[k] for k in range(len(labels))], sum(costs)
        worse = [k for k in order if costs[k] >= RESTART_COST]
        if not worse:
            break
        # labels that cover something are placed first at the next start
        order = [*worse, *(k for k in order if k not in worse)]
    return best


def _settled(cost: Callable[[dict[int, int], int], Floats], order: Sequence[int]) -> dict[int, int]:
    """The places of labels after each in turn has moved to its cheapest, until none moves."""
    chosen: dict[int, int] = {}
    for _ in range(SWEEPS):
        before = dict(chosen)
        for k in order:
            chosen[k] = int(np.argmin(cost(chosen, k)))
        if chosen == before:
            break
    return chosen


def _beside(label: _Places, other: _Places, place: int) -> Floats:
    """The costs of covering another label at its place, for each place of one label."""
    box, line = other.boxes[place], other.lines[place]
    gap = _padded(box[None], 0.2 * (box[3] - box[1]))
    names = (
        overlap(label.boxes, gap[0]).astype(float)
        + _strike(label.lines, box)
        + _strike(np.broadcast_to(line, label.lines.shape), label.boxes)
    )
    cost: Floats = COSTS["names"] * names
    return cost


def _shared_text(names: Sequence[str]) -> str:
    """The text of a shared label: all names or, if there are many, kinds with runs of numbers."""
    if len(names) <= LISTED:
        return ", ".join(names)
    parts = [re.fullmatch(r"(\D*)(\d*)", name) for name in names]
    known = sorted((m[1], int(m[2])) for m in parts if m is not None and m[2])
    plain = [name for name, m in zip(names, parts, strict=True) if m is None or not m[2]]
    for _, run in groupby(enumerate(known), key=lambda each: (each[1][0], each[1][1] - each[0])):
        ends = [f"{kind}{number}" for _, (kind, number) in run]
        plain += [f"{ends[0]}\u2013{ends[-1]}"] if len(ends) > 2 else ends
    return ", ".join(plain)


def _in_rows(written: str) -> str:
    commas = [match.end() for match in re.finditer(", ", written)]
    if len(written) <= LONGEST or not commas:
        return written
    at = min(commas, key=lambda comma: abs(2 * comma - len(written)))
    return f"{written[:at].rstrip()}\n{written[at:]}"


def _padded(boxes: Floats, margin: float) -> Floats:
    return boxes + margin * np.array([-1.0, -1.0, 1.0, 1.0])


def overlap(boxes: Floats, others: Floats) -> npt.NDArray[np.bool_]:
    """Whether boxes (..., 4) overlap ``others`` of the same shape."""
    low, high = boxes[..., :2] < others[..., 2:], boxes[..., 2:] > others[..., :2]
    overlaps: npt.NDArray[np.bool_] = np.all(low & high, axis=-1, keepdims=False)
    return overlaps


def _strike(lines: Floats, boxes: Floats) -> npt.NDArray[np.bool_]:
    """Whether lines, given by places (..., m, 2) on them, pass through boxes (..., 4)."""
    low, high = boxes[..., None, :2], boxes[..., None, 2:]
    with np.errstate(invalid="ignore"):
        within = ((lines > low) & (lines < high)).all(axis=-1)
    struck: npt.NDArray[np.bool_] = np.any(within, axis=-1, keepdims=False)
    return struck


def _distances(boxes: Floats, places: Floats) -> Floats:
    """The distances (n, m) of places (m, 2) from boxes (n, 4)."""
    nearest = np.clip(places, boxes[:, None, :2], boxes[:, None, 2:])
    away: Floats = np.hypot(*(places - nearest).T).T
    return away


def contained(boxes: Floats, places: Floats, margin: float) -> npt.NDArray[np.int64]:
    """How many places (m, 2) lie in each of some boxes (n, 4), or closer to it than a margin."""
    low, high = boxes[:, None, :2] - margin, boxes[:, None, 2:] + margin
    count: npt.NDArray[np.int64] = ((places > low) & (places < high)).all(axis=2).sum(axis=1)
    return count


def _apart(box: Bbox, other: Bbox) -> float:
    return 0.5 * math.hypot(
        box.x0 + box.x1 - other.x0 - other.x1, box.y0 + box.y1 - other.y0 - other.y1
    )


def _length(places: Floats) -> float:
    return float(np.hypot(*np.diff(places, axis=0).T).sum()) if len(places) > 1 else 0.0


def _spaced(places: Floats, step: float) -> Floats:
    """Places along a polyline, evenly spaced, in pixels."""
    if len(places) < 2:
        return places
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    at = np.linspace(0.0, along[-1], min(5000, max(2, math.ceil(along[-1] / step) + 1)))
    return np.column_stack([np.interp(at, along, column) for column in places.T])
