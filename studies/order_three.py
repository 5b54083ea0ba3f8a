"""Beyond the paper: every fixed point and jump crossing of P_1, P_2 and P_3 in the whole window.

    python -m studies.order_three [--fast] [--out DIR]

The paper stopped at P_2. Fixed points of P_3 are counted in slices, between the parameters at which
branches end, and every sample is simulated again. The picture has the colours and lines of all
diagrams, but marks no special points: there are too many. Those of P_1 are marked by
:mod:`studies.figures.fig09_order_one`, collisions of P_2 by :mod:`studies.figures.fig10_order_two`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap import Branch, BranchKind, Diagram, PointKind
from pwmap.plot.palette import of_period
from studies.common.record import Results, command
from studies.common.style import INK, canvas, keep
from studies.common.whole import Part, examined, searched
from studies.figures.fig10_order_two import FULL
from woodpecker import Search
from woodpecker.base.arrays import Floats

ORDERS = (1, 2, 3)
FAST = Part((0.105, 0.13), (-1.0, -0.65), Search(slices=7), 4)
LINES: dict[str, dict[str, Any]] = {  # as in all diagrams, and thin where they lie close
    "stable": {"linestyle": "-", "linewidth": 2.0},
    "unstable": {"linestyle": (0, (4, 1.2)), "linewidth": 0.8},
    "jump crossing": {"linestyle": (0, (1, 1.3)), "linewidth": 1.4},
}


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find all branches of P_1, P_2 and P_3, check them, draw.

    Parameters
    ----------
    fast
        Only what is next to A, a part without cycles of period 3.
    out
        Folder for ``order_three.png``.

    Returns
    -------
    dict
        See :func:`studies.common.whole.examined`.
    """
    part = FAST if fast else FULL
    found, taken = searched(part, ORDERS)
    if out is not None:
        keep(draw(found.diagram, part), out / "order_three.png")
    return examined(part, 3, found, taken)


def draw(diagram: Diagram, part: Part) -> Figure:
    """Fixed points by period, those that attract broad; jump crossings of P_1 dotted."""
    figure, (ax,) = canvas(5.6)
    for order in reversed(ORDERS):
        found: dict[str, list[Floats]] = {name: [] for name in LINES}
        for branch in diagram.of_order(order).branches:
            if branch.kind is BranchKind.FIXED_POINT or order == 1:
                found[_style(branch)].append(np.column_stack([branch.parameter, branch.x]))
        for name in ("unstable", "jump crossing", "stable"):  # the last above the others
            ax.add_collection(LineCollection(found[name], colors=of_period(order), **LINES[name]))
    ax.legend(handles=samples(diagram), fontsize=7, framealpha=0.95, loc="lower right")
    ax.set_xlim(*part.span)
    margin = 0.02 * (part.window[1] - part.window[0])
    ax.set_ylim(part.window[0] - margin, part.window[1] + margin)
    ax.set_xlabel(r"$\varepsilon_{N1}$")
    ax.set_ylabel(r"$\varphi_S$ [rad]")
    return figure


def _style(branch: Branch) -> str:
    """What most of a branch is."""
    if branch.kind is BranchKind.JUMP:
        return "jump crossing"
    return "stable" if np.median(np.abs(branch.multiplier)) < 1.0 else "unstable"


def samples(diagram: Diagram) -> list[Line2D]:
    """What the legend shows, and how many special points the picture leaves out."""
    found = [
        Line2D([], [], color=INK, **style, label=f"{name} of $P_1$" if "jump" in name else name)
        for name, style in LINES.items()
    ]
    found += [
        Line2D([], [], color=of_period(k), linewidth=4.0, label=f"period {k}") for k in ORDERS
    ]
    count = sum(point.kind is not PointKind.EP for point in diagram.points)
    found.append(Line2D([], [], ls="", label=f"{count} special points: too many to mark"))
    return found


if __name__ == "__main__":
    command(main, "order_three")
