"""Figure 9 of the paper, complete: every branch of P_1, with brute force underneath, and both laws.

    python -m studies.figures.fig09_order_one [--fast] [--out DIR]

The branches come from slices and continuation; the grey points are independent orbits from many
starts. These must settle on stable branches, or be chaotic.

A second picture compares the two laws of friction in the expansion of an impact at two contacts.
With the sum, A and B lie where the paper has them, and the branch that starts at B is stable; with
Coulomb's law contact by contact they do not. That the paper's program took the sum is inferred.

The work is compared with the paper's method, a table of P_1. A table with the resolution of the
branches is out of reach: their edges and fixed points are accurate to 1e-10 rad, and it would need
parameters as close as the two ends of the shortest branch (``shortest_branch``). So a modest table
is assumed: it has N_p parameters, as many as there are different ones among the diagram's samples,
and at each of them starts that are evenly spaced by h over the window of width w:

    evaluations = N_p (floor(w / h) + 1)

with h = 1e-6 rad, the width to which slices look for pieces, or with h = 2e-3 rad, the spacing of
their first samples. The first finds what the slices find. The second misses every island and every
pair of edges closer than 2e-3 rad; it shows what the branches cost beyond a mere picture.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap import Diagram, PointKind
from pwmap.plot import plot_diagram
from studies.common.laws import LAWS, SEPARATE, SUMMED, TITLES, TOYS
from studies.common.places import (
    POINT_A,
    POINT_B,
    POINT_C,
    SPAN,
    WINDOW,
    collisions,
    told,
)
from studies.common.record import Results, command
from studies.common.style import GREY, PALE, WIDTH, keep, without_legend
from studies.common.whole import Part, not_followed, searched
from studies.figures.fig08_return_map import ends
from woodpecker import ExpansionFriction, OrbitDiagram, Search, ToyPieces, orbit_diagram
from woodpecker.search import Found
from woodpecker.slices import unexplained

FAST = Part((0.28, 0.4), WINDOW, Search(slices=8))
FULL = Part(SPAN, WINDOW, Search())
MARKED = tuple(kind for kind in PointKind if kind is not PointKind.EP)
SPACINGS = (1e-6, 2e-3)  # rad: of tables that show the thinnest pieces, and most of them
NAMED = {  # what the paper names in Figures 9 and 10, near (eps_N1, phi_S)
    SUMMED: {
        "A": POINT_A[SUMMED],
        "B": POINT_B[SUMMED],
        "C": POINT_C,
        "$I_1$": (0.3883, -0.8848),
        "$I_2$": (0.7952, -1.1218),
    },
    SEPARATE: {
        "A": POINT_A[SEPARATE],
        "B": POINT_B[SEPARATE],
        "C": POINT_C,
        "$I_1$": (0.3884, -0.8848),
        "$I_2$": (0.7959, -1.1220),
    },
}
CLOSE = 1e-3  # in either coordinate: half a unit of the last digits above is much less


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
        Only eps_N1 in (0.28, 0.4), with few slices and few orbits.
    out
        Folder for ``fig09.png`` and ``fig09_laws.png``.

    Returns
    -------
    dict
        ``collisions``: kind, note, eps_N1 and phi_S of every BC and FF; ``branches``, ``points``,
        ``samples`` of the diagram; ``slices``: how many; ``evaluations`` of P_1 in
        all; ``not_followed``: eps_N1, order and phi_S that a slice shows and no branch explains;
        ``shortest_branch``: in eps_N1; ``tables``: see :class:`Table`; ``seconds`` of wall and CPU;
        ``orbits``, ``chaotic``, ``lost``, ``unexplained``: what the orbits do. All of this under
        the toy's own law; ``separate``: the first of them under the other one, see
        :func:`described`.
    """
    part = FAST if fast else FULL
    results, both = {}, {}
    for law in LAWS:
        results[law], both[law] = described(part._replace(law=law))
    found, diagram = both[SUMMED], both[SUMMED].diagram
    parameters = np.linspace(*part.span, 12 if fast else 800)[1:-1]
    starts = np.linspace(-2.4, -0.3, 12 if fast else 9)
    orbits = orbit_diagram(ToyPieces(TOYS[SUMMED]), parameters, starts, WINDOW)
    left = unexplained(orbits, diagram, ToyPieces(TOYS[SUMMED]))
    if out is not None:
        keep(draw(diagram, orbits), out / "fig09.png")
        keep(compare({law: each.diagram for law, each in both.items()}), out / "fig09_laws.png")
    return {
        **results[SUMMED],
        "samples": sum(map(len, diagram.branches)),
        "shortest_branch": min(lengths(diagram)),
        "tables": [table(found, spacing)._asdict() for spacing in SPACINGS],
        "orbits": len(orbits.orbits),
        "chaotic": sum(orbit.period == 0 and orbit.exponent > 0.0 for orbit in orbits.orbits),
        "lost": orbits.lost,
        "unexplained": [(o.p, o.start, float(o.x[-1])) for o in left],
        "separate": results[SEPARATE],
    }


def described(part: Part) -> tuple[Results, Found]:
    """The search under one law, in numbers, and what it found.

    Returns
    -------
    dict
        ``law``, ``first_slices``, ``seconds``, ``collisions``, ``branches``, ``points``,
        ``slices``, ``evaluations``, ``not_followed``: see :func:`main`.
    Found
        The diagram, and what the slices came to.
    """
    found, taken = searched(part, (1,))
    diagram = found.diagram
    return {
        "law": str(part.law),
        "first_slices": part.search.slices,
        "seconds": taken._asdict(),
        "collisions": [
            told(point) for point in diagram.points if point.kind in (PointKind.BC, PointKind.FF)
        ],
        "branches": len(diagram.branches),
        "points": len(diagram.points),
        "slices": len(found.slices),
        "evaluations": found.evaluations,
        "not_followed": not_followed(found),
    }, found


def table(found: Found, spacing: float) -> Table:
    """What a table of P_1 costs that has a column at every parameter of the diagram."""
    parameters = len(np.unique(np.concatenate([b.parameter for b in found.diagram.branches])))
    evaluations = parameters * (math.floor((WINDOW[1] - WINDOW[0]) / spacing) + 1)
    return Table(spacing, parameters, evaluations, evaluations / found.evaluations)


def lengths(diagram: Diagram) -> list[float]:
    """Extent of every branch over eps_N1, of those that have one."""
    extents = [float(np.ptp(branch.parameter)) for branch in diagram.branches]
    return [extent for extent in extents if extent > 0.0]


def draw(diagram: Diagram, orbits: OrbitDiagram) -> Figure:
    """Branches over the points that orbits settle on, and the band of centres above them."""
    figure = plt.figure(figsize=(WIDTH, 5.2), layout="constrained")
    ax = figure.gca()
    p, x = orbits.points()
    ax.plot(p, x, ".", color=GREY, markersize=0.8, markeredgewidth=0.0, zorder=0, rasterized=True)
    panel(diagram, SUMMED, ax)
    sample = Line2D([], [], ls="", marker=".", color=GREY, markersize=4.0)
    with_entries(ax, [(sample, "where orbits settle")])
    return figure


def compare(diagrams: dict[ExpansionFriction, Diagram]) -> Figure:
    """The diagrams of both laws side by side."""
    figure = plt.figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, (law, diagram) in zip(axes, diagrams.items(), strict=True):
        panel(diagram, law, ax)
        ax.set_title(TITLES[law], fontsize=8)
        ax.tick_params(labelsize=7)
    without_legend(axes[0])
    axes[1].set_ylabel("")
    return figure


def panel(diagram: Diagram, law: ExpansionFriction, ax: Axes) -> None:
    """All branches, the band of centres above them, and the paper's names."""
    plot_diagram(named(diagram, law), ax, kinds=MARKED)
    band, top = ends(TOYS[law]).band, -0.15
    ax.axhspan(*band, color=PALE, linewidth=0.0)
    ax.text(
        0.99, band[1] + 0.01, "centres", fontsize=7, ha="right", va="bottom",
        transform=ax.get_yaxis_transform(),
    )  # fmt: skip
    ax.set_ylim(WINDOW[0] - 0.04, top)


def named(diagram: Diagram, law: ExpansionFriction) -> Diagram:
    """The diagram with the paper's names of border collisions, where it has them."""
    found = dict[str, str]()
    for name, place in NAMED[law].items():
        near = list(collisions(diagram, place, CLOSE))
        if near:
            nearest = min(
                near, key=lambda p: float(np.hypot(p.parameter - place[0], p.x - place[1]))
            )
            found[nearest.id] = name
    points = tuple(replace(point, name=found.get(point.id, "")) for point in diagram.points)
    return replace(diagram, points=points)


def with_entries(ax: Axes, more: list[tuple[Artist, str]], **how: Any) -> None:
    """The legend of a diagram with more entries."""
    legend = ax.get_legend()
    assert legend is not None
    handles = [handle for handle in legend.legend_handles if handle is not None]
    texts = [text.get_text() for text in legend.get_texts()]
    ax.legend(
        [*handles, *(artist for artist, _ in more)], [*texts, *(text for _, text in more)],
        **{"fontsize": 7, "framealpha": 0.95, "loc": "best", **how},
    )  # fmt: skip


if __name__ == "__main__":
    command(main, "fig09_order_one")
