"""Pictures of diagrams: stable solid, unstable dashed, jumps dotted."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pwmap.diagram import Branch, BranchKind, Diagram, FloatArray, PointKind

STABLE, UNSTABLE, JUMP = "#08306b", "#d95f0e", "#238b45"
MARKERS = {
    PointKind.LP: ("s", "#6a51a3"),
    PointKind.PD: ("D", "#6a51a3"),
    PointKind.BC: ("o", "#cb181d"),
    PointKind.FF: ("*", "#cb181d"),
    PointKind.FALL: ("v", "#525252"),
    PointKind.EP: ("|", "#525252"),
}


def plot_diagram(
    diagram: Diagram,
    ax: Axes | None = None,
    *,
    kinds: Iterable[PointKind] = tuple(MARKERS),
    legend: bool = True,
) -> Axes:
    """Draw all branches of a diagram and its special points.

    Parameters
    ----------
    diagram
        What to draw.
    ax
        Axes to draw on; new ones by default.
    kinds
        Special points to mark; word changes are left out by default, there can be hundreds.
    legend
        Whether to explain the lines and markers that occur.
    """
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 4.6), layout="constrained").gca()
    styles: dict[str, Line2D] = {}
    for label, p, x in _curves(diagram):
        (line,) = ax.plot(p, x, solid_capstyle="round", **_STYLES[label])
        styles.setdefault(label, line)
    handles = [styles[label] for label in _STYLES if label in styles]
    labels = [label for label in _STYLES if label in styles]
    for kind in kinds:
        points = [point for point in diagram.points if point.kind is kind]
        if points:
            marker, color = MARKERS.get(kind, (".", "#969696"))
            handles.append(
                ax.scatter(
                    [point.parameter for point in points], [point.x for point in points],
                    s=70 if marker == "*" else 26, marker=marker, zorder=5, color=color,
                    edgecolors="white" if marker not in "|" else None, linewidths=0.6,
                )  # type: ignore[arg-type]
            )  # fmt: skip
            labels.append(kind.meaning)
    ax.set_xlabel(axis_label(diagram.parameter_name))
    ax.set_ylabel(axis_label(diagram.x_name))
    ax.grid(alpha=0.25, linewidth=0.5)
    if legend:
        ax.legend(handles, labels, fontsize=7, loc="best", frameon=True, framealpha=0.9)
    return ax


_STYLES: dict[str, dict[str, Any]] = {
    "stable": {"color": STABLE, "linestyle": "-", "linewidth": 1.6},
    "unstable": {"color": UNSTABLE, "linestyle": (0, (4, 1.5)), "linewidth": 1.2},
    "jump crossing": {"color": JUMP, "linestyle": (0, (1, 1.3)), "linewidth": 1.4},
}


def _curves(diagram: Diagram) -> list[tuple[str, FloatArray, FloatArray]]:
    """Style, parameters and x of curves; branches of one style that follow each other are one.

    A dash pattern starts anew with each curve, and hundreds of short branches would look solid.
    """
    curves: list[tuple[str, list[FloatArray], list[FloatArray]]] = []
    last_end = ""
    for branch in diagram.branches:
        for label, stretch in _stretches(branch):
            p, x = branch.parameter[stretch], branch.x[stretch]
            if (
                (stretch.start == 0 and branch.ends[0] != last_end)
                or not curves
                or curves[-1][0] != label
            ):
                curves.append((label, [], []))
            curves[-1][1].append(p)
            curves[-1][2].append(x)
        last_end = branch.ends[1]
    return [(label, np.concatenate(p), np.concatenate(x)) for label, p, x in curves]


def _stretches(branch: Branch) -> list[tuple[str, slice]]:
    """Parts of a branch with one line style; neighbours share their common point."""
    if branch.kind is BranchKind.JUMP:
        return [("jump crossing", slice(0, len(branch)))]
    stable = branch.stable.copy()
    if len(branch) > 2:  # the ends may be flips, where the multiplier is -1 but for rounding
        stable[0], stable[-1] = stable[1], stable[-2]
    cuts = np.flatnonzero(stable[1:] != stable[:-1]) + 1
    edges = [0, *cuts.tolist(), len(branch)]
    return [
        ("stable" if stable[a] else "unstable", slice(max(0, a - 1), b)) for a, b in pairwise(edges)
    ]


def axis_label(name: str) -> str:
    """Axis label for a parameter or coordinate, in mathematical notation where it is known."""
    known = {
        "phi_s": r"$\varphi_S$ [rad]",
        "eps_n1": r"$\varepsilon_{N1}$",
        "eps_n2": r"$\varepsilon_{N2}$",
        "eps_n3": r"$\varepsilon_{N3}$",
        "mu_1": r"$\mu_1$",
        "mu_2": r"$\mu_2$",
        "mu_3": r"$\mu_3$",
        "c_phi": r"$c_\varphi$ [N m/rad]",
        "g": r"$g$ [m/s$^2$]",
    }
    return known.get(name, name)
