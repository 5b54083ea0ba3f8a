"""Style of all pictures: colours for stable, unstable and jump branches, and for the methods."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pwmap.plot import INK, JUMP, STABLE, UNSTABLE

WIDTH = 7.6  # inches: what a page, or the README, shows without scaling
GREY = "#969696"
PALE = "#bdbdbd"
VIOLET = "#6a51a3"
RED = "#cb181d"

METHODS = {  # colour and marker of everything that is compared
    "kernel, compiled": (STABLE, "o"),
    "kernel, plain Python": ("#4292c6", "o"),
    "kernel, mpmath": ("#9ecae1", "o"),
    "ball arithmetic": (RED, "*"),
    "RK45": (UNSTABLE, "s"),
    "DOP853": ("#a63603", "s"),
    "Radau": ("#fd8d3c", "D"),
    "LSODA": ("#fdae6b", "D"),
    "Moreau, theta": (JUMP, "^"),
    "Moreau, midpoint": ("#74c476", "v"),
    "Siconos": (VIOLET, "P"),
}

__all__ = [
    "GREY", "INK", "JUMP", "METHODS", "PALE", "RED", "STABLE", "UNSTABLE", "VIOLET", "WIDTH",
    "canvas", "grid", "keep", "small", "without_legend",
]  # fmt: skip


def canvas(height: float = 4.6, rows: int = 1, columns: int = 1) -> tuple[Figure, Sequence[Axes]]:
    """A figure of the usual width with its axes in reading order."""
    figure = plt.figure(figsize=(WIDTH, height), layout="constrained")
    axes = np.ravel(figure.subplots(rows, columns, squeeze=False)).tolist()
    for ax in axes:
        grid(ax)
    return figure, axes


def keep(figure: Figure, path: Path) -> None:
    """Write a picture, and let go of it."""
    figure.savefig(path, dpi=200)
    plt.close(figure)


def without_legend(ax: Axes) -> None:
    """Take the legend off: a panel beside this one has the same."""
    legend = ax.get_legend()
    if legend is not None:
        legend.remove()


def small(ax: Axes) -> None:
    """Letters for a panel of a third of the width."""
    ax.tick_params(labelsize=7)
    ax.title.set_fontsize(8)
    legend = ax.get_legend()
    if legend is not None:
        plt.setp([*legend.get_texts(), legend.get_title()], fontsize=5.5)


def grid(ax: Axes) -> None:
    """The fine grid behind every picture."""
    ax.grid(alpha=0.25, linewidth=0.5)
    ax.set_axisbelow(True)
