"""Pictures of curves of special points in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pwmap.diagrams.diagram import PointKind, PointStatus
from pwmap.plane.kinds import PlaneKind
from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, below, sized, styled
from pwmap.plot.labels import LabelledCurve as Named
from pwmap.plot.labels import Labels, Name
from pwmap.plot.palette import LINES
from woodpecker.base.checks import instance
from woodpecker.base.shown import shown as in_short
from woodpecker.mechanics.toy import description, parameters, symbol
from woodpecker.plane.curve import Curve, PlanePoint

LEAVES = {"color": "#404040", "linestyle": "-."}  # curves on which a cycle leaves the window
THIN = 1.3  # width of all curves [pt], as they often lie close together
MEANINGS = {
    (PointKind.FF, "fold"): "fold-flip at a jump (FF)",
    (PointKind.BC, "fold"): "border collision, fold (BC)",
    (PointKind.BC, "persistence"): "border collision, persistence (BC)",
    (PointKind.LP, ""): "fold (LP)",
    (PointKind.PD, ""): "flip (PD)",
    (PointKind.EP, ""): "a cycle leaves the window",
}
DASHED = "persistence"
TOY, STAR = "the toy", 8.0  # name and size [pt] of the star at the toy's parameters
MARKERS = {
    PlaneKind.CUSP: "^",
    PlaneKind.GENERALISED_FLIP: "v",
    PlaneKind.FOLD_BORDER: "s",
    PlaneKind.FLIP_BORDER: "D",
    PlaneKind.JUMP_CLOSES: "o",
    PlaneKind.DEGENERATE_GRAZING: "h",
    PlaneKind.TWO_BORDERS: "P",
    PlaneKind.DOMAIN: "X",
}


def plot_curves(
    curves: Mapping[str, Curve], ax: Axes | None = None, *, legend: bool = True,
    here: tuple[float, float] | None = None, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw curves over the same two parameters, with their points of codimension two.

    Where there is room points are named as in the table of :class:`woodpecker.Curve`; with several
    curves the name of the curve comes first.

    Parameters
    ----------
    curves
        Curves by the names that are written on them.
    ax
        Axes to draw on; new ones by default.
    here
        The toy's values of both parameters, marked by a star. The limits follow the curves; if the
        star lies outside, the legend says so.
    legend, styles
        Whether to have a legend below the axes; properties of matplotlib by the names of the
        curves, ``"points"``, ``"names"`` and ``"the toy"``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or the curves are not over the same parameters.

    Examples
    --------
    >>> from woodpecker.examples import border_curve
    >>> from woodpecker.plot.plane import plot_curves
    >>> curve = border_curve(0.5)
    >>> list(plot_curves({"A": curve}, here=(0.0, 1.25)).artists)
    ['points', 'names', 'A', 'the toy']
    """
    if not isinstance(curves, Mapping):
        raise TypeError(f"curves must be a mapping of names to curves, got {in_short(curves)}")
    for curve in curves.values():
        instance("curve", curve, Curve)
    names = {curve.names for curve in curves.values()}
    if len(names) != 1:
        raise ValueError(f"expected curves over the same two parameters, got {sorted(names)}")
    ax = axes_for(ax, 7.0, 5.4)
    (first, second) = next(iter(names))
    shown: Artists = {"points": [], "names": []}
    points: list[Name] = []
    for name, curve in curves.items():
        add(shown, {name: draw_curve(ax, curve)})
        shown["points"] += _mark(ax, curve)
        before = f"{name} " if len(curves) > 1 and name else ""
        points += [Name(f"{before}{p.id}", *p.values, always=False) for p in _marked(curve)]
    ax.margins(0.04)
    inside = here is not None and bool(ax.viewLim.contains(*here))
    if here is not None and inside:
        shown[TOY] = [*ax.plot(*here, "*", color="black", ms=STAR, mec="white", mew=0.5, zorder=5)]
    labels = name_curves(ax, curves, points, [here] if here is not None else [])
    shown["names"].append(labels)
    styled(shown, styles, (TOY,))
    ax.set(xlabel=label(first), ylabel=label(second))
    if legend:
        samples = handles(curves.values(), toy=inside)
        if here is not None and not inside:
            text = f"{TOY} ({here[0]:g}, {here[1]:g}) lies outside"
            samples.append(Line2D([], [], ls="", label=text))
        ax.legend(handles=samples, fontsize=sized(7.5), frameon=False, ncols=3, **below(ax))
    return Drawn((ax,), shown)


def name_curves(
    ax: Axes, curves: Mapping[str, Curve], points: Sequence[Name] = (),
    marks: Sequence[tuple[float, float]] = (),
) -> Labels:  # fmt: skip
    """Write names on the longest stretch of each curve and beside points, without overlaps."""
    written: list[Named] = []
    for name, curve in curves.items():
        stretches = list(curve.stretches())
        lengths = [_length(curve, *stretch[2:]) for stretch in stretches]
        for k, (code, _, first, last) in enumerate(stretches):
            part = curve.values[first : last + 2]
            text = name if k == int(np.argmax(lengths)) else ""
            colour = _line(code, "")["color"]
            written.append(Named(text, part[:, 0], part[:, 1], colour, shortest=0.0))
    labels = Labels(points, written, marks)
    ax.add_artist(labels)
    return labels


def draw_curve(ax: Axes, curve: Curve) -> list[Artist]:
    """Draw the stretches of a curve, each in the style of its kind and joined to the next."""
    lines: list[Artist] = []
    for code, note, first, last in curve.stretches():
        part = curve.values[first : last + 2]
        lines += ax.plot(part[:, 0], part[:, 1], zorder=2, **_line(code, note))
    return lines


def _line(code: PointKind, note: str) -> dict[str, Any]:
    """The style of a stretch: as in exact planes, dashed where a border collision persists."""
    own = LINES.get(code, LEAVES)
    dashes = {"linestyle": "--"} if note == DASHED else {}
    return own | dashes | {"linewidth": THIN}


def _marked(curve: Curve) -> list[PlanePoint]:
    """The points of a curve that get a mark: those of codimension two, and open ends."""
    return [p for p in curve.points if p.kind in MARKERS or p.status is PointStatus.OPEN]


def _mark(ax: Axes, curve: Curve) -> list[Artist]:
    """Draw the marks of points of codimension two; those of open ends are hollow."""
    marks: list[Artist] = []
    for point in _marked(curve):
        is_open = point.status is PointStatus.OPEN
        marks += ax.plot(
            *point.values, MARKERS.get(point.kind, "o"), color="black", ms=3.8, mew=0.7, zorder=3,
            mfc="white" if is_open else "black",
        )  # fmt: skip
    return marks


def _length(curve: Curve, first: int, last: int) -> float:
    """Length of a part of a curve, with both parameters scaled by the extent of the whole."""
    size = np.ptp(curve.values, axis=0)
    part = curve.values[first : last + 1] / np.where(size > 0.0, size, 1.0)
    return float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum())


def label(name: str) -> str:
    """The label of a parameter on an axis: symbol and unit."""
    if name not in parameters():
        return name
    unit = description(name).unit.replace("^2", "$^2$")
    return formula(name) if unit == "-" else f"{formula(name)} [{unit}]"


def formula(parameter: str) -> str:
    """The symbol of a parameter of the toy for a label of Matplotlib."""
    letter, index = symbol(parameter)
    return f"${letter}_{{{index}}}$"


def line_handles(curves: Iterable[Curve]) -> list[Line2D]:
    """Legend entries for the kinds of stretches of curves."""
    kinds = {stretch[:2] for curve in curves for stretch in curve.stretches()}
    return [
        Line2D([], [], label=text, **_line(*kind))
        for kind, text in MEANINGS.items()
        if kind in kinds
    ]


def handles(curves: Iterable[Curve], toy: bool = False) -> list[Line2D]:
    """Legend entries for the kinds of stretches and points, with codes, and for the toy's star."""
    drawn = list(curves)
    points = {point.kind for curve in drawn for point in curve.points}
    is_open = any(p.status is PointStatus.OPEN for curve in drawn for p in curve.points)
    mark: dict[str, Any] = {"color": "black", "ls": ""}
    marks = [
        Line2D([], [], marker=marker, ms=3.8, label=f"{kind.label} ({kind})", **mark)
        for kind, marker in MARKERS.items()
        if kind in points
    ]
    if is_open:
        marks.append(Line2D([], [], marker="o", mfc="white", ms=3.8, label="open", **mark))
    if toy:
        marks.append(Line2D([], [], marker="*", ms=STAR, label=TOY, **mark))
    return [*line_handles(drawn), *marks]
