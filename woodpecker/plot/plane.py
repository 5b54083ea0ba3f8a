"""Curves of special points over two parameters, as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pwmap.diagrams.diagram import PointKind, PointStatus
from pwmap.plane.kinds import PlaneKind
from pwmap.plot_drawn import Artists, Drawn, Styles, add, new_axes, styled
from woodpecker.mechanics.toy import description, parameters
from woodpecker.plane.curve import Curve

COLOURS = {
    PointKind.FF: "#b2182b",
    PointKind.BC: "#2166ac",
    PointKind.LP: "#4d4d4d",
    PointKind.PD: "#1b7837",
    PointKind.EP: "#bdbdbd",
}
MEANINGS = {
    (PointKind.FF, "fold"): "fold-flip at a jump (FF)",
    (PointKind.BC, "fold"): "border collision, fold (BC)",
    (PointKind.BC, "persistence"): "border collision, persistence (BC)",
    (PointKind.LP, ""): "fold (LP)",
    (PointKind.PD, ""): "flip (PD)",
    (PointKind.EP, ""): "a cycle leaves the window",
}
DASHED = "persistence"
MARKERS = {
    PlaneKind.CUSP: "^",
    PlaneKind.GENERALISED_FLIP: "v",
    PlaneKind.FOLD_BORDER: "s",
    PlaneKind.FLIP_BORDER: "D",
    PlaneKind.JUMP_CLOSES: "o",
    PlaneKind.TWO_BORDERS: "P",
    PlaneKind.DOMAIN: "X",
}
SYMBOLS = {
    "eps_n1": r"$\varepsilon_{N1}$", "eps_n2": r"$\varepsilon_{N2}$",
    "eps_n3": r"$\varepsilon_{N3}$", "mu_1": r"$\mu_1$", "mu_2": r"$\mu_2$", "mu_3": r"$\mu_3$",
    "c_phi": r"$c_\varphi$", "l_s": r"$l_S$", "l_m": r"$l_M$", "l_g": r"$l_G$", "h_s": r"$h_S$",
    "h_m": r"$h_M$", "r_0": r"$r_0$", "r_m": r"$r_M$",
}  # fmt: skip


def plot_curves(
    curves: Mapping[str, Curve], ax: Axes | None = None, *, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw curves over the same two parameters, with their points of codimension two.

    Parameters
    ----------
    curves
        By the name that is written beside each.
    ax
        Where to draw; a new figure by default.
    legend
        Whether to say, beside the axes, which kinds of curves and points are there.
    styles
        Properties of matplotlib by the names of the curves, ``"points"`` and ``"names"``.

    Returns
    -------
    Drawn
        The axes, and the artists by these names.

    Raises
    ------
    ValueError
        If there is no curve, they are over different parameters, or there is no part of the name
        of a style.
    """
    names = {curve.names for curve in curves.values()}
    if len(names) != 1:
        raise ValueError(f"expected curves over the same two parameters, got {sorted(names)}")
    ax = ax if ax is not None else new_axes(8.4, 4.8)
    (first, second) = next(iter(names))
    shown: Artists = {"points": [], "names": []}
    for name, curve in curves.items():
        add(shown, {name: draw_curve(ax, curve)})
        shown["points"] += _mark(ax, curve)
        shown["names"] += name_curve(ax, name, curve)
    styled(shown, styles)
    ax.set_xlabel(label(first))
    ax.set_ylabel(label(second))
    ax.margins(0.02)
    if legend:
        ax.legend(handles=handles(curves.values()), fontsize=7.5, frameon=False,
                  bbox_to_anchor=(1.0, 1.0), loc="upper left")  # fmt: skip
    return Drawn((ax,), shown)


def draw_curve(ax: Axes, curve: Curve) -> list[Artist]:
    """The stretches of a curve, each as what it is; a short one is joined to the next."""
    lines: list[Artist] = []
    for code, note, first, last in curve.stretches():
        part = curve.values[first : last + 2]
        style = "--" if note == DASHED else "-"
        lines += ax.plot(part[:, 0], part[:, 1], style, color=COLOURS[code], lw=1.3, zorder=2)
    return lines


def _mark(ax: Axes, curve: Curve) -> list[Artist]:
    """Its points of codimension two; ends that are open are hollow."""
    marks: list[Artist] = []
    for point in curve.points:
        marker = MARKERS.get(point.kind)
        is_open = point.status is PointStatus.OPEN
        if marker is not None or is_open:
            marks += ax.plot(
                *point.values, marker or "o", color="black", ms=3.8, mew=0.7, zorder=3,
                mfc="white" if is_open else "black",
            )  # fmt: skip
    return marks


def name_curve(ax: Axes, name: str, curve: Curve) -> list[Artist]:
    """The name of a curve, on the longest of its stretches; none if it is empty."""
    if not name:
        return []
    _, _, first, last = max(curve.stretches(), key=lambda each: _length(curve, *each[2:]))
    at = curve.values[(first + last) // 2]
    text = ax.annotate(
        name, (at[0], at[1]), ha="center", va="center", fontsize=8, zorder=4,
        bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85},
    )  # fmt: skip
    return [text]


def _length(curve: Curve, first: int, last: int) -> float:
    """How far a part of a curve goes, over what the whole curve extends over."""
    size = np.ptp(curve.values, axis=0)
    part = curve.values[first : last + 1] / np.where(size > 0.0, size, 1.0)
    return float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum())


def label(name: str) -> str:
    """A parameter for an axis."""
    symbol = SYMBOLS.get(name, name)
    if name not in parameters():
        return symbol
    unit = description(name)[1]
    return symbol if unit == "-" else f"{symbol} [{unit}]"


def line_handles(curves: Iterable[Curve]) -> list[Line2D]:
    """What a legend of curves shows: their kinds."""
    kinds = {stretch[:2] for curve in curves for stretch in curve.stretches()}
    return [
        Line2D([], [], color=COLOURS[kind[0]], ls="--" if kind[1] == DASHED else "-", label=text)
        for kind, text in MEANINGS.items()
        if kind in kinds
    ]


def handles(curves: Iterable[Curve]) -> list[Line2D]:
    """The kinds of curves and of their points."""
    drawn = list(curves)
    points = {point.kind for curve in drawn for point in curve.points}
    is_open = any(p.status is PointStatus.OPEN for curve in drawn for p in curve.points)
    marks = [
        Line2D([], [], color="black", ls="", marker=marker, ms=3.8, label=kind.label)
        for kind, marker in MARKERS.items()
        if kind in points
    ]
    if is_open:
        marks.append(
            Line2D([], [], color="black", ls="", marker="o", mfc="white", ms=3.8, label="open")
        )
    return [*line_handles(drawn), *marks]
