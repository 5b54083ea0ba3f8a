"""Figure 9 of the paper, complete: every branch of P_1, with brute force underneath.

    python studies/fig09_order_one.py [--fast] [--out DIR]

The branches come from slices and continuation; the grey points are orbits from many starts, which
know nothing of them. What the orbits show must be a stable branch, or chaotic.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from clocks import clocked
from record import Results, command

from pwmap import Diagram, PointKind
from pwmap.plot import plot_diagram
from woodpecker import (
    OrbitDiagram,
    Search,
    Toy,
    bifurcation_diagram,
    first_return,
    orbit_diagram,
    toy_samples,
    unexplained,
)

WINDOW = (-2.5, -0.24)  # rad
GREY = "#bdbdbd"


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find everything, simulate beside it, draw.

    Returns
    -------
    dict
        ``collisions``: kind, note, eps_N1 and phi_S of every BC and FF; ``branches``, ``points``;
        ``seconds`` of wall and CPU; ``orbits``, ``chaotic``, ``lost``, ``unexplained``: what the
        orbits do.
    """
    span, search = ((0.3, 0.4), Search(slices=8, quiet=4)) if fast else ((0.012, 1.0), Search())
    first_return(Toy(), -0.53)  # compiled
    kept: list[Diagram] = []
    taken = clocked(
        lambda: kept.append(bifurcation_diagram(Toy(), "eps_n1", span, (1,), WINDOW, search=search))
    )()
    diagram = kept[0]
    parameters = np.linspace(*span, 12 if fast else 800)[1:-1]
    starts = np.linspace(-2.4, -0.3, 12 if fast else 9)
    orbits = orbit_diagram(toy_samples(Toy()), parameters, starts, WINDOW)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        draw(diagram, orbits).savefig(out / "figure_9.png", dpi=200)
    return {
        "collisions": [
            (str(p.kind), p.note, float(p.parameter), float(p.x))
            for p in diagram.points
            if p.kind in (PointKind.BC, PointKind.FF)
        ],
        "branches": len(diagram.branches),
        "points": len(diagram.points),
        "seconds": taken._asdict(),
        "orbits": len(orbits.orbits),
        "chaotic": sum(orbit.period == 0 and orbit.exponent > 0.0 for orbit in orbits.orbits),
        "lost": orbits.lost,
        "unexplained": [(o.p, o.start, float(o.x[-1])) for o in unexplained(orbits, diagram)],
    }


def draw(diagram: Diagram, orbits: OrbitDiagram) -> plt.Figure:
    """Branches over the points that orbits settle on."""
    figure = plt.figure(figsize=(7.6, 5.0), layout="constrained")
    ax = figure.gca()
    p, x = orbits.points()
    ax.plot(p, x, ".", color=GREY, markersize=0.6, markeredgewidth=0.0, zorder=0, rasterized=True)
    plot_diagram(diagram, ax)
    ax.set_ylim(WINDOW[0] - 0.05, WINDOW[1])
    return figure


if __name__ == "__main__":
    command(main, "fig09_order_one")
