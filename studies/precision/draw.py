"""The picture of :mod:`studies.precision.work_precision`."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from studies.common.style import GREY, METHODS, WIDTH, grid
from studies.peers.cases import SCENES
from studies.precision.measuring import Row
from studies.precision.methods import KERNEL, PROVER, TWIN

FLOOR = 1e-17  # rad; where smaller errors are drawn, a tenth of the spacing of doubles near 0.5
NOTES = {TWIN: f", below {FLOOR:.0e}", PROVER: ": what is proved"}  # of the legend


def draw(tasks: dict[str, list[Row]]) -> Figure:
    """Error against CPU time: one panel for each task, all on the same axes."""
    figure = plt.figure(figsize=(WIDTH, 5.8), layout="constrained")
    axes = np.ravel(figure.subplots(2, 3, sharex=True, sharey=True)).tolist()
    titles = {scene.name: f"{scene.name}, one return" for scene in SCENES}
    for ax, letter, (task, rows) in zip(axes, "abcde", tasks.items(), strict=False):
        grid(ax)
        ax.set_title(f"({letter}) {titles.get(task, task)}", fontsize=8.5, loc="left")
        panel(ax, rows)
    first = axes[0]
    first.set(xscale="log", yscale="log", xlim=(3e-18, 3.0))
    first.xaxis.set_major_locator(LogLocator(numticks=20, subs=(1.0,), base=1e4))
    first.yaxis.set_major_locator(LogLocator(numticks=20))
    for ax in axes[:5]:
        ax.xaxis.set_minor_locator(NullLocator())
        ax.yaxis.set_minor_locator(NullLocator())
        ax.tick_params(labelsize=8)
    axes[2].tick_params(labelbottom=True)
    for ax in (axes[0], axes[3]):
        ax.set_ylabel("CPU time [s]", fontsize=9)
    for ax, unit in zip(axes[2:5], ("[rad]", "[rad]", "[rad], [-]"), strict=True):
        ax.set_xlabel(f"error {unit}", fontsize=9)
    legend(axes[5], {row["method"] for rows in tasks.values() for row in rows})
    return figure


def panel(ax: Axes, rows: Sequence[Row]) -> None:
    """Curves of one task, a line along the knob of each method and variant."""
    curves: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row["error"] is not None:
            curves.setdefault((row["method"], row["variant"]), []).append(row)
    kernel = curves[KERNEL, ""][0]
    ax.axhline(kernel["cpu"], color=METHODS[KERNEL][0], linewidth=0.6, linestyle=(0, (1, 2)))
    for (method, variant), points in curves.items():
        color, marker = METHODS[method]
        errors = [max(point["error"], FLOOR) for point in points]
        times = [point["cpu"] for point in points]
        dashes = {"pgs": (0, (4, 2))}.get(variant, "-")
        ax.plot(errors, times, color=color, linewidth=0.9, linestyle=dashes, zorder=2)
        for error, time, point in zip(errors, times, points, strict=True):
            hollow = point["word_right"] is False
            ax.plot(
                error, time, marker, color=color, zorder=5 if method == KERNEL else 3,
                markersize=6 if method == KERNEL else (3.0 if point["scaled"] else 4.0),
                markerfacecolor="white" if hollow else color, markeredgewidth=0.9,
            )  # fmt: skip


def legend(ax: Axes, present: set[str]) -> None:
    """Methods and marks, in the place of the sixth panel."""
    ax.axis("off")
    handles = [
        Line2D(
            [],
            [],
            color=color,
            marker=marker,
            linewidth=0.9,
            markersize=4.5,
            label=method + NOTES.get(method, ""),
        )
        for method, (color, marker) in METHODS.items()
        if method in present
    ]
    handles += [
        Line2D([], [], color=GREY, linewidth=0.9, linestyle=(0, (4, 2)),
               label="dashed: Gauss-Seidel, not LCP"),
        Line2D([], [], color=GREY, marker="o", linewidth=0.0, markerfacecolor="white",
               markersize=4.5, label="hollow: wrong word"),
        Line2D([], [], color=GREY, marker="o", linewidth=0.0, markersize=3.0,
               label="small: 12 of 1000 points, scaled"),
    ]  # fmt: skip
    ax.legend(handles=handles, loc="center", fontsize=8, frameon=False)
