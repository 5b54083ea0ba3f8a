"""Curves of special points over two parameters, as a picture."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.mechanics.toy import description, parameters
from woodpecker.plane.curve import Curve, PlaneKind

COLOURS = {
    PointKind.FF: "#b2182b",
    PointKind.BC: "#2166ac",
    PointKind.LP: "#4d4d4d",
    PointKind.PD: "#1b7837",
}
MEANINGS = {
    (PointKind.FF, "fold"): "fold-flip at a jump (FF)",
    (PointKind.BC, "fold"): "border collision, fold (BC)",
    (PointKind.BC, "persistence"): "border collision, persistence (BC)",
    (PointKind.LP, ""): "fold (LP)",
    (PointKind.PD, ""): "flip (PD)",
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


def plot_curves(curves: Mapping[str, Curve], ax: Axes | None = None) -> Axes:
    """Draw curves over the same two parameters, with their points of codimension two.

    Parameters
    ----------
    curves
        By the name that is written beside each.
    ax
        Where to draw; a new figure by default.

    Returns
    -------
    Axes
        With a legend of the kinds of curves and points that are there.

    Raises
    ------
    ValueError
        If there is no curve, or they are over different parameters.
    """
    names = {curve.names for curve in curves.values()}
    if len(names) != 1:
        raise ValueError(f"expected curves over the same two parameters, got {sorted(names)}")
    if ax is None:
        _, ax = plt.subplots(figsize=(6.4, 4.8), layout="constrained")
    (first, second) = next(iter(names))
    kinds, points = set[tuple[PointKind, str]](), set[PlaneKind]()
    for name, curve in curves.items():
        kinds |= _draw(ax, curve)
        points |= _mark(ax, curve)
        _name(ax, name, curve)
    ax.set_xlabel(_label(first))
    ax.set_ylabel(_label(second))
    _legend(ax, kinds, points)
    return ax


def _draw(ax: Axes, curve: Curve) -> set[tuple[PointKind, str]]:
    """The stretches of a curve, each as what it is; a short one is joined to the next."""
    drawn = set[tuple[PointKind, str]]()
    for code, note, first, last in curve.stretches():
        part = curve.values[first : last + 2]
        style = "--" if note == DASHED else "-"
        ax.plot(part[:, 0], part[:, 1], style, color=COLOURS[code], lw=1.4, zorder=2)
        drawn.add((code, note))
    return drawn


def _mark(ax: Axes, curve: Curve) -> set[PlaneKind]:
    """Its points of codimension two; ends that are open are hollow."""
    marked = set[PlaneKind]()
    for point in curve.points:
        marker = MARKERS.get(point.kind)
        is_open = point.status is PointStatus.OPEN
        if marker is None and not is_open:
            continue
        ax.plot(
            *point.values, marker or "o", color="black", ms=4.5, mew=0.8, zorder=3,
            mfc="white" if is_open else "black", clip_on=False,
        )  # fmt: skip
        if marker is not None:
            marked.add(point.kind)
    return marked


def _name(ax: Axes, name: str, curve: Curve) -> None:
    """The name of a curve, where it is highest."""
    if name:
        at = curve.values[curve.values[:, 1].argmax()]
        ax.annotate(
            name, (at[0], at[1]), xytext=(0, 3), textcoords="offset points", ha="center",
            va="bottom", fontsize=9, annotation_clip=False,
        )  # fmt: skip


def _label(name: str) -> str:
    """A parameter for an axis."""
    symbol = SYMBOLS.get(name, name)
    if name not in parameters():
        return symbol
    unit = description(name)[1]
    return symbol if unit == "-" else f"{symbol} [{unit}]"


def _legend(ax: Axes, kinds: set[tuple[PointKind, str]], points: set[PlaneKind]) -> None:
    lines = [
        Line2D([], [], color=COLOURS[kind[0]], ls="--" if kind[1] == DASHED else "-", label=text)
        for kind, text in MEANINGS.items()
        if kind in kinds
    ]
    marks = [
        Line2D([], [], color="black", ls="", marker=marker, ms=4.5, label=kind.label)
        for kind, marker in MARKERS.items()
        if kind in points
    ]
    ax.legend(handles=[*lines, *marks], fontsize=7.5, frameon=True, framealpha=0.9)
