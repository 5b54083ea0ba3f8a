"""Figure 9 of the paper, complete: every branch of P_1, with brute force underneath.

    python studies/fig09_order_one.py [--fast] [--out DIR]

The branches come from slices and continuation; the grey points are orbits from many starts, which
know nothing of them. What the orbits show must be a stable branch, or chaotic.

The work is compared with the paper's way, a table of P_1. A table that resolves what the branches
resolve cannot be made: their edges and fixed points are good to 1e-10 rad, and it would need
parameters as close as the two ends of the shortest branch (``shortest_branch``). So the table here
is a modest one. It has as many parameters as the diagram has different ones among its samples, N_p,
and at each of them starts that are evenly spaced by h over the window of width w:

    evaluations = N_p (floor(w / h) + 1)

with h = 1e-6 rad, the width to which slices look for pieces, or with h = 2e-3 rad, the spacing of
their first samples. The first finds what the slices find. The second misses every island and every
pair of edges thinner than 2e-3 rad; it is there to show what the branches cost beyond a picture.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from clocks import clocked
from fig08_return_map import ends
from matplotlib.axes import Axes
from record import Results, command
from style import GREY, PALE, WIDTH

from pwmap import Diagram, PointKind
from pwmap.plot import plot_diagram
from woodpecker import (
    Found,
    OrbitDiagram,
    Search,
    Toy,
    find_all,
    first_return,
    orbit_diagram,
    toy_samples,
    unexplained,
)

WINDOW = (-2.5, -0.24)  # rad
MARKED = tuple(kind for kind in PointKind if kind not in (PointKind.WC, PointKind.EP))
NAMED = {  # what the paper names in Figure 10, near (eps_N1, phi_S) of the stated model
    "A": (0.0422, -0.8848),
    "B": (0.3210, -0.8848),
    "C": (0.1851, -0.7578),
    "$I_1$": (0.3884, -0.8848),
    "$I_2$": (0.7959, -1.1220),
}
CLOSE = 1e-3  # in either coordinate: half a unit of the last digit above is much less


class Table(NamedTuple):
    """A tabulation of P_1 in the paper's way."""

    spacing: float  # of the starts [rad]
    parameters: int
    evaluations: int
    ratio: float  # to the evaluations that the diagram took


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find everything, simulate beside it, draw.

    Parameters
    ----------
    fast
        Only eps_N1 in (0.3, 0.4), with few slices and few orbits.
    out
        Folder for ``fig09.png``.

    Returns
    -------
    dict
        ``collisions``: kind, note, eps_N1 and phi_S of every BC and FF; ``branches``, ``points``,
        ``samples`` of the diagram; ``slices``: how many for each order; ``evaluations`` of P_1 in
        all; ``not_followed``: eps_N1 and phi_S that a slice shows and no branch explains;
        ``shortest_branch``: in eps_N1; ``tables``: see :class:`Table`; ``seconds`` of wall and CPU;
        ``orbits``, ``chaotic``, ``lost``, ``unexplained``: what the orbits do.
    """
    span, search = ((0.3, 0.4), Search(slices=8)) if fast else ((0.012, 1.0), Search())
    first_return(Toy(), -0.53)  # compiled
    kept: list[Found] = []
    taken = clocked(
        lambda: kept.append(find_all(Toy(), "eps_n1", span, (1,), WINDOW, search=search))
    )()
    found, diagram = kept[0], kept[0].diagram
    parameters = np.linspace(*span, 12 if fast else 800)[1:-1]
    starts = np.linspace(-2.4, -0.3, 12 if fast else 9)
    orbits = orbit_diagram(toy_samples(Toy()), parameters, starts, WINDOW)
    if out is not None:
        draw(diagram, orbits).savefig(out / "fig09.png", dpi=200)
        plt.close("all")
    spacings = (search.resolution.smallest, search.resolution.spacing)
    return {
        "collisions": [
            (str(p.kind), p.note, float(p.parameter), float(p.x))
            for p in diagram.points
            if p.kind in (PointKind.BC, PointKind.FF)
        ],
        "branches": len(diagram.branches),
        "points": len(diagram.points),
        "samples": sum(map(len, diagram.branches)),
        "slices": {f"P_{report.order}": len(report.slices) for report in found.reports},
        "evaluations": found.evaluations,
        "not_followed": [place for report in found.reports for place in report.not_followed],
        "shortest_branch": min(lengths(diagram)),
        "tables": [table(found, spacing)._asdict() for spacing in spacings],
        "seconds": taken._asdict(),
        "orbits": len(orbits.orbits),
        "chaotic": sum(orbit.period == 0 and orbit.exponent > 0.0 for orbit in orbits.orbits),
        "lost": orbits.lost,
        "unexplained": [(o.p, o.start, float(o.x[-1])) for o in unexplained(orbits, diagram)],
    }


def table(found: Found, spacing: float) -> Table:
    """What a table of P_1 costs that has a column at every parameter of the diagram."""
    parameters = len(np.unique(np.concatenate([b.parameter for b in found.diagram.branches])))
    evaluations = parameters * (math.floor((WINDOW[1] - WINDOW[0]) / spacing) + 1)
    return Table(spacing, parameters, evaluations, evaluations / found.evaluations)


def lengths(diagram: Diagram) -> list[float]:
    """Extent of every branch over eps_N1, of those that have one."""
    extents = [float(np.ptp(branch.parameter)) for branch in diagram.branches]
    return [extent for extent in extents if extent > 0.0]


def draw(diagram: Diagram, orbits: OrbitDiagram) -> plt.Figure:
    """Branches over the points that orbits settle on, and the band of centres above them."""
    figure = plt.figure(figsize=(WIDTH, 5.2), layout="constrained")
    ax = figure.gca()
    p, x = orbits.points()
    ax.plot(p, x, ".", color=GREY, markersize=0.8, markeredgewidth=0.0, zorder=0, rasterized=True)
    plot_diagram(diagram, ax, kinds=MARKED)
    band, top = ends(Toy()).band, -0.15
    ax.axhspan(*band, color=PALE, linewidth=0.0)
    ax.text(
        0.99, band[1] + 0.01, "centres", fontsize=7, ha="right", va="bottom",
        transform=ax.get_yaxis_transform(),
    )  # fmt: skip
    name_points(diagram, ax)
    ax.set_ylim(WINDOW[0] - 0.04, top)
    return figure


def name_points(diagram: Diagram, ax: Axes) -> None:
    """Write the paper's names at the special points, where the diagram has them."""
    for name, place in NAMED.items():
        for point in diagram.points:
            near = np.abs(np.subtract((point.parameter, point.x), place)).max() < CLOSE
            if near and point.kind in (PointKind.BC, PointKind.FF):
                ax.annotate(
                    name, (point.parameter, point.x), (-2, 6), textcoords="offset points",
                    fontsize=9, ha="right",
                )  # fmt: skip


if __name__ == "__main__":
    command(main, "fig09_order_one")
