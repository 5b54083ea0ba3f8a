"""The two pictures of :mod:`studies.failures.failures`."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from studies.common.style import GREY, METHODS, RED, STABLE, WIDTH, canvas
from studies.failures.judge import Kind
from studies.failures.methods import Method

Row = dict[str, Any]
FILL = {  # fill of a cell, and colour of its text
    Kind.EXACT: (STABLE, "white"),
    Kind.DIGITS: ("#9ecae1", "black"),
    Kind.BOUNDED: ("#cbc9e2", "black"),
    Kind.UNDECIDED: ("#e5e5e5", "black"),
    Kind.WORD: ("#fdd0a2", "black"),
    Kind.SILENT: ("#fdd0a2", "black"),
    Kind.PART: ("#fff2cc", "black"),
    Kind.LOST: (GREY, "black"),
    Kind.SIDE: (RED, "white"),
    Kind.VALUE: (RED, "white"),
    Kind.NONE: ("white", GREY),
}
LEGEND = {
    Kind.EXACT: "exact, or decided",
    Kind.DIGITS: "right to some digits",
    Kind.BOUNDED: "open, bound stated",
    Kind.UNDECIDED: "gave up, undecided",
    Kind.WORD: "wrong word or silent",
    Kind.PART: "from some guesses only",
    Kind.LOST: "lost, and says so",
    Kind.SIDE: "wrong motion",
}
CELL = 0.285  # height of a row [inch]: two lines of SMALL
SMALL = 6.4  # points
NARROW, BROAD = 21, 44  # characters in a line of a cell
LOWEST = 1e-18  # rad; below it an error is drawn here
PANELS = {"jump A": "the jump at $-0.884773$", "grazing": "the grazing at $-0.277882$"}


def draw_matrix(rows: Sequence[Row], ends: Sequence[Row]) -> Figure:
    """Scenes times methods, and below it where branches end; colour and text give the verdict."""
    tables = [(part, width) for part, width in ((rows, NARROW), (ends, BROAD)) if part]
    heights = [len({row["scene"] for row in part}) for part, _ in tables]
    size = (WIDTH, CELL * sum(heights) + 1.45)
    figure = plt.figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(tables), 1, height_ratios=heights, squeeze=False)[:, 0]
    for ax, (part, width) in zip(axes, tables, strict=True):
        _table(ax, part, width)
    handles = [
        Patch(facecolor=FILL[kind][0], edgecolor="none", label=text)
        for kind, text in LEGEND.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7, frameon=False)
    return figure


def _table(ax: Axes, rows: Sequence[Row], width: int) -> None:
    """One table: rows by scene, columns by method, both in the order they come."""
    labels = {row["scene"]: row["label"] for row in rows}
    names = list(dict.fromkeys(row["method"] for row in rows))
    cells = {(row["scene"], row["method"]): row for row in rows}
    for j, scene in enumerate(labels):
        for i, name in enumerate(names):
            _cell(ax, i, j, cells.get((scene, name)), width)
    ax.set_xlim(0, len(names))
    ax.set_ylim(len(labels), 0)
    heads = [name.replace(", ", "\n") for name in names]
    ax.set_xticks([i + 0.5 for i in range(len(names))], heads, fontsize=7, fontweight="bold")
    ax.set_yticks([j + 0.5 for j in range(len(labels))], list(labels.values()), fontsize=7)
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)


def _cell(ax: Axes, i: int, j: int, row: Mapping[str, Any] | None, width: int) -> None:
    kind, text = (Kind(row["kind"]), row["verdict"]) if row else (Kind.NONE, "not applicable")
    fill, ink = FILL[kind]
    ax.add_patch(Rectangle((i, j), 1, 1, facecolor=fill, edgecolor="white", linewidth=1.5))
    lines = textwrap.fill(text, width)
    ax.text(i + 0.5, j + 0.5, lines, color=ink, fontsize=SMALL, ha="center", va="center",
            linespacing=1.0)  # fmt: skip


def draw_distances(points: Sequence[Row], columns: Sequence[Method]) -> Figure:
    """Error of the image over the distance of the start from a jump and from a grazing."""
    figure, axes = canvas(3.7, 1, len(PANELS))
    for ax, (scene, title) in zip(axes, PANELS.items(), strict=True):
        here = [point for point in points if point["scene"] == scene]
        for k, method in enumerate(columns):
            _curve(ax, [point for point in here if point["method"] == method.name], method, k)
        _promise(ax, here)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlim(2.5e-3, 4e-15)  # towards the edge
        ax.set_ylim(0.3 * LOWEST, 10.0)
        ax.set_title(f"beside {title}", fontsize=9)
        ax.set_xlabel(r"distance of the start from the edge, $|\Delta\varphi_S|$ [rad]", fontsize=8)
        ax.tick_params(labelsize=8)
    axes[0].set_ylabel("error of the image [rad]", fontsize=8)
    axes[1].tick_params(labelleft=False)
    figure.legend(handles=_handles(columns), loc="outside lower center", ncols=4, fontsize=7,
                  frameon=False)  # fmt: skip
    return figure


def _curve(ax: Axes, points: Sequence[Row], method: Method, k: int) -> None:
    """The worse of both sides over the distance; hollow where a word is wrong, a cross where lost.

    Equal values of two methods are told apart by a small shift along the axis.
    """
    color, marker = METHODS[method.look]
    distances = sorted({point["distance"] for point in points}, reverse=True)
    shift = 10.0 ** (0.06 * (k - 2))
    xs: list[float] = []
    ys: list[float] = []
    for distance in distances:
        both = [point for point in points if point["distance"] == distance]
        errors = [point["error"] for point in both if point["error"] is not None]
        if len(errors) < len(both):
            ax.plot(distance * shift, 2.0, marker="x", color=color, markersize=4)
        if not errors:
            xs, ys = [*xs, distance], [*ys, math.nan]
            continue
        right = all(point["word_right"] for point in both if point["error"] is not None)
        error = max(*errors, LOWEST)
        ax.plot(distance * shift, error, marker=marker, color=color, markersize=4,
                markerfacecolor=color if right else "white", zorder=3)  # fmt: skip
        xs, ys = [*xs, distance * shift], [*ys, error]
    ax.plot(xs, ys, color=color, linewidth=0.9, linestyle=_dashes(method))


def _dashes(method: Method) -> Literal["-", "--"]:
    """The finer step of two of the same look is dashed."""
    return "--" if "1e-6" in method.name else "-"


def _promise(ax: Axes, points: Sequence[Row]) -> None:
    """What the kernel promises, and the height of the jump, if there is one."""
    known = sorted((p["distance"], p["allowed"]) for p in points if p["allowed"] is not None)
    bounds = dict(known)  # of two sides, or methods, the larger one stays
    ax.plot(list(bounds), list(bounds.values()), color=STABLE, linewidth=0.8, linestyle=":")
    height = abs(points[0]["jump"]) if points else 0.0
    if height > 1e-3:
        ax.axhline(height, color=RED, linewidth=0.8, linestyle=":")
        ax.annotate("height of the jump", (1.0, height), xycoords=("axes fraction", "data"),
                    xytext=(-3, -9), textcoords="offset points", fontsize=7, color=RED,
                    ha="right")  # fmt: skip


def _handles(columns: Sequence[Method]) -> list[Line2D]:
    handles = []
    for method in columns:
        color, marker = METHODS[method.look]
        handles.append(
            Line2D([], [], color=color, marker=marker, markersize=4, linewidth=0.9,
                   linestyle=_dashes(method), label=method.name)
        )  # fmt: skip
    black: dict[str, Any] = {"color": "black", "linestyle": "none", "markersize": 4}
    return [
        *handles,
        Line2D(
            [], [], color=STABLE, linestyle=":", linewidth=0.8, label="what the kernel promises"
        ),
        Line2D([], [], marker="o", markerfacecolor="white", label="hollow: wrong word", **black),
        Line2D([], [], marker="x", label="lost on one side or both", **black),
    ]
