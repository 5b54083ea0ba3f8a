"""The pictures of ``docs/long_run.md``: P1^L and the skew tent map over a parameter, and at one.

    python -m studies.exact.long_run_pictures [--fast] [--out DIR]

Branches and crises are exact; bands are interpolated between exact bands at sampled parameters.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pwmap import Diagram, PiecewiseLinearMap, attractor_diagram, bifurcation_diagram, dynamics
from pwmap.longrun import AttractorDiagram
from pwmap.plot import plot_density, plot_kneading, plot_long_run
from studies.common.exact_maps import P1L, SKEW
from studies.common.record import Results, command
from studies.common.style import WIDTH, canvas, grid, keep, small

GOLDEN = {"a": "2", "b": "-3/2"}  # the third image of the break is the break


class Scene(NamedTuple):
    """A map of one parameter, an interval of it, and the orders of the branches."""

    map_: PiecewiseLinearMap
    parameter: str
    span: tuple[str, str]
    orders: tuple[int, ...]
    title: str
    compared: int = 3  # order up to which images of breaks are compared
    steps: int = 80  # places at which bands are computed

    def branches(self) -> Diagram:
        """The fixed points and jump crossings of its iterates."""
        return bifurcation_diagram(self.map_, self.parameter, self.span, self.orders)

    def attractors(self) -> AttractorDiagram:
        """What attracts, with its crises."""
        return attractor_diagram(self.map_, self.parameter, self.span, self.compared)

    def drawn(self, ax: Axes, fast: bool) -> AttractorDiagram:
        """All of it on axes; gives what attracts."""
        found = self.attractors()
        steps = 20 if fast else self.steps
        plot_long_run(self.branches(), found, self.map_, ax, steps=steps)
        ax.set_title(self.title)
        return found


PAPER = (
    Scene(P1L.at({"a": "5/4", "b": 0}), "r", ("-1/2", "12"), (1, 2, 3),
          r"$P_1^L$, flat on the left, $a = 5/4$", 1, 600),
    Scene(P1L.at({"a": "5/4", "b": "3/2"}), "r", ("3/2", "5"), (1, 2),
          r"$P_1^L$ with the slope 3/2 on the left, $a = 5/4$"),
)  # fmt: skip
TENTS = (
    Scene(SKEW.at({"a": "5/4"}), "b", ("-11/2", "-11/10"), (1, 2), "skew tent map, $a = 5/4$", 5),
    Scene(SKEW.at({"a": "1/2"}), "b", ("-5", "-43/10"), (1, 2, 3), "skew tent map, $a = 1/2$"),
)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find what is to be drawn, and draw it.

    Parameters
    ----------
    fast
        Draw bands at fewer places.
    out
        Folder for ``long_run_p1l.png``, ``long_run_skew.png`` and ``long_run_golden.png``.

    Returns
    -------
    dict
        ``crises``: of each scene over a parameter, the code, exact value and numbers of bands;
        ``density``: heights of the density at one value, as text.
    """
    crises: dict[str, list[list[str]]] = {}
    for name, scenes in (("long_run_p1l", PAPER), ("long_run_skew", TENTS)):
        figure, axes = canvas(3.7, 1, 2)
        for ax, scene in zip(axes, scenes, strict=True):
            found = scene.drawn(ax, fast)
            small(ax)
            crises[scene.title] = [
                [c.kind.value, str(c.parameter), f"{c.bands[0]} | {c.bands[1]}"]
                for c in found.crises
            ]
        if out is not None:
            keep(figure, out / f"{name}.png")
        plt.close(figure)
    seen = dynamics(SKEW, GOLDEN)
    density = seen.attractors[0].density
    assert density is not None
    if out is not None:
        keep(draw_golden(20_000 if fast else 1_000_000), out / "long_run_golden.png")
    return {"crises": crises, "density": [str(value) for value in density.values]}


def draw_golden(points: int) -> Figure:
    """A kneading table over a density."""
    figure = plt.figure(figsize=(WIDTH, 3.6), layout="constrained")
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 2.2)).flat
    top, bottom = above.subplots(), below.subplots()
    seen = dynamics(SKEW, GOLDEN)
    plot_kneading(seen, top, steps=20).ax.set_title(
        "skew tent map, $a = 2$, $b = -3/2$", fontsize=9
    )
    plot_density(seen, bottom, points=points)
    bottom.legend(loc="upper left", fontsize=7, frameon=False)
    bottom.set_xlabel("$x$")
    grid(bottom)
    return figure


if __name__ == "__main__":
    command(main, "long_run_pictures")
