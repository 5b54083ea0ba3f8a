"""Which cycles of the toy exist where in the plane of two parameters.

    python -m studies.regions [--fast] [--out DIR]

Three planes through the paper's toy are divided into regions by the curves of A, B, C and others.
Further curves between regions are found where the numbers of cycles at two places differ; counts at
random places tell how much is still wrong.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pwmap import SpecialPoint
from studies.common.motion import GUESS
from studies.common.record import Results, command
from studies.common.style import WIDTH, grid, keep
from studies.main_job import PAPER
from studies.two_parameters import FLIP
from studies.two_parameters import NAMES as POINTS
from woodpecker import Curve, Toy, continuation, curve_in_two, shoot
from woodpecker.plot.plane import name_curves
from woodpecker.plot.regions import described, handles, plot_regions
from woodpecker.regions import Regions, Survey, parameter_regions

FIRST, SPAN = "eps_n1", (0.1, 0.9)
SECOND = {"mu_2": (0.29, 0.34), "l_s": (0.0197, 0.02025), "c_phi": (0.005, 0.0064)}
Spans = tuple[tuple[float, float], tuple[float, float]]
WINDOW = (-0.9, -0.45)  # of phi_S: with the stable motion, and A, B and C
NAMES = {  # special points over eps_N1 of the paper's toy in this window
    "A": 0.11197091445663, "B": 0.29152171188505, "C": 0.18512695093092,
    "FF1": 0.18815862092540, "BC2": 0.7911249390906, "PD1": 0.64854920022763, "I1": 0.3883495889,
}  # fmt: skip
STAR: dict[str, Any] = {
    "ls": "", "marker": "*", "color": "black", "ms": 9.0, "mec": "white", "mew": 0.5
}  # fmt: skip
SAME = 1e-3  # of such a value: curves are straight between their samples


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Cut the planes, and draw them.

    Parameters
    ----------
    fast
        A part of the first plane only.
    out
        Folder for the picture ``regions.png``.

    Returns
    -------
    dict
        For each second parameter curves, random places and which disagree, and the regions: share
        of the rectangle, a place, what lives there, and what orbits come to.
    """
    toy = Toy()
    names = (FLIP,) if fast else (*POINTS, FLIP)
    diagram = continuation(toy, shoot(toy, GUESS), FIRST).named(PAPER)
    found, results = dict[str, Regions](), dict[str, Results]()
    for second, span in ({"mu_2": (0.297, 0.303)} if fast else SECOND).items():
        spans = ((0.55, 0.75) if fast else SPAN, span)
        survey = Survey(checks=20 if fast else Survey().checks)
        points = [diagram.point(name) for name in names]
        found[second] = _regions(toy, points, second, spans, survey)
        results[second] = _about(found[second])
    if out is not None:
        keep(draw(toy, found), out / "regions.png")
    return results


def _regions(
    toy: Toy, points: list[SpecialPoint], second: str, spans: Spans, survey: Survey
) -> Regions:
    """The curves of special points, and the regions between these and others."""
    over = FIRST, second
    curves = [curve_in_two(toy, point, over, spans) for point in points]
    return parameter_regions(toy, over, spans, curves=curves, window=WINDOW, survey=survey)


def _about(found: Regions) -> Results:
    return {
        "curves": len(found.curves),
        "checks": found.checks,
        "open": [list(place) for place, _ in found.open],
        "regions": [
            {
                "share": each.share, "place": list(each.place), "lives": described(each.census),
                "attractors": [str(attractor) for attractor in each.attractors],
                "agree": each.agree,
            }
            for each in found.regions
        ],
    }  # fmt: skip


def draw(toy: Toy, found: dict[str, Regions]) -> Figure:
    """One panel for each second parameter."""
    figure = plt.figure(figsize=(WIDTH, 0.62 * WIDTH), layout="constrained")
    axes = figure.subplots(1, len(found), squeeze=False)[0].tolist()
    for ax, (name, regions) in zip(axes, found.items(), strict=True):
        grid(ax)
        plot_regions(regions, ax, legend=False)
        here = toy.eps_n1, getattr(toy, name)
        known = {_name(curve, here[1]): curve for curve in regions.curves}
        name_curves(ax, {text: curve for text, curve in known.items() if text}, (), [here])
        ax.plot(*here, **STAR, zorder=5)
    star = Line2D([], [], **STAR, label="the paper's toy")
    shown = [*handles(found.values()), star]
    figure.legend(handles=shown, loc="outside lower center", ncols=4, fontsize=7, frameon=False)
    return figure


def _name(curve: Curve, second: float) -> str:
    """The name of a curve by where it passes the toy of the paper; empty if it has none."""
    met = np.array([first for first, _ in curve.crossings(1, second)])
    return next((n for n, at in NAMES.items() if len(met) and np.abs(met - at).min() < SAME), "")


if __name__ == "__main__":
    command(main, "regions")
