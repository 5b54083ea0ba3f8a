"""What a jump crossing is: one return map at three values of its parameter, and its diagram.

    python -m studies.jump_crossing [--fast] [--out DIR]

The map has two lines and a jump between them: p + x/2 for x <= 0, and p - 1 + x/3 for x > 0. Its
diagram is exact (:func:`pwmap.bifurcation_diagram`). A stable fixed point reaches the jump at
p = 0; from there to p = 1 the *jump* crosses the diagonal; then a stable fixed point begins on the
other side. A method that follows only fixed points finds two separate branches that end.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sympy import Piecewise, Rational, symbols

from pwmap import Diagram, PiecewiseLinearMap, PointKind, bifurcation_diagram
from pwmap.plot import plot_diagram, plot_map
from pwmap.plot.labels import LabelledCurve, Labels
from studies.common.record import Results, command
from studies.common.style import GREY, RED, WIDTH, grid, keep

X, P = symbols("x p")
MAP = PiecewiseLinearMap.from_sympy(Piecewise((P + X / 2, X <= 0), (P - 1 + X / 3, True)), X)
SPAN = (Rational(-1), Rational(2))
PANELS = (Rational(-1, 2), Rational(0), Rational(1, 2))  # before, at and after the collision
TITLES = ("a fixed point", "border collision", "a jump crossing")
REACH = 1.75  # of the panels, in x
TICKS = (-1, 0, 1)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Solve exactly and draw.

    Parameters
    ----------
    fast
        Nothing is left out: all takes a second.
    out
        Folder for ``jump_crossing.png``.

    Returns
    -------
    dict
        ``branches``: kind, first and last parameter of each; ``collisions``: parameters of the
        border collisions; ``panels``: what lies on the diagonal at the parameters of the panels.
    """
    diagram = bifurcation_diagram(MAP, P, SPAN, orders=(1,))
    if out is not None:
        keep(draw(diagram), out / "jump_crossing.png")
    return {
        "branches": [
            [str(branch.kind), float(branch.parameter[0]), float(branch.parameter[-1])]
            for branch in diagram.branches
        ],
        "collisions": [p.parameter for p in diagram.points if p.kind is PointKind.BC],
        "panels": {
            str(p): [[str(hit.branch.kind), hit.x] for hit in diagram.at(p)] for p in PANELS
        },
    }


def draw(diagram: Diagram) -> Figure:
    """Three panels of the map above its diagram, whose parameters are marked there."""
    figure = plt.figure(figsize=(WIDTH, 5.2), layout="constrained")
    rows = figure.subplot_mosaic([["0", "1", "2"], ["diagram"] * 3], height_ratios=[1.0, 0.85])
    for number, (p, title) in enumerate(zip(PANELS, TITLES, strict=True)):
        panel(rows[str(number)], diagram, p, f"{number + 1}   {title}")
    rows["0"].set_ylabel("$P(x)$")
    over_parameter(rows["diagram"], diagram)
    return figure


def panel(ax: Axes, diagram: Diagram, p: Rational, title: str) -> None:
    """The map at one parameter, with what it has on the diagonal."""
    plot_map(MAP.at({P: p}), ax, window=(-REACH, REACH), legend=False)
    for jump in () if MAP.at({P: p}).jump_crossings() else MAP.at({P: p}).jumps():
        limits = float(jump.left), float(jump.right)
        ax.plot([0.0, 0.0], limits, color=GREY, linestyle=":", linewidth=1.2, zorder=2)
    for point in diagram.points:
        if point.kind is PointKind.BC and point.exact["parameter"] == p:
            ax.plot(point.x, point.x, "o", color=RED, markersize=9.5, mec="white", zorder=7)
    ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), ylabel="", xticks=TICKS, yticks=TICKS)
    ax.set_aspect("equal")
    ax.set_title(title, fontsize=10, loc="left")


def over_parameter(ax: Axes, diagram: Diagram) -> None:
    """The diagram, with a line at the parameter of each panel."""
    (names,) = plot_diagram(diagram, ax, kinds=(PointKind.BC,)).artists["names"]
    assert isinstance(names, Labels)
    grid(ax)
    for number, p in enumerate(PANELS):
        ax.axvline(float(p), color=GREY, linewidth=0.6, linestyle=(0, (6, 4)), zorder=0)
        line = LabelledCurve("", np.full(2, float(p)), np.array([-REACH, REACH]))
        names.curves.append(line)  # names stand beside it
        ax.annotate(str(number + 1), (float(p), 1.0), (0, 3), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="center", color=GREY)  # fmt: skip
    ax.set(xlim=[float(p) for p in SPAN], xlabel="$p$", ylabel="$x$")


if __name__ == "__main__":
    command(main, "jump_crossing")
