"""The plane of both slopes of the skew tent map: periods, entropy, bands, and the curves between.

python -m studies.exact.parameter_plane [--fast] [--out DIR]
"""

from __future__ import annotations

from collections import Counter
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from pwmap import parameter_plane
from pwmap.plane import Colours, ParameterPlane, PlaneRaster, plane_raster, with_crises
from pwmap.plot import plot_plane
from studies.common.clocks import timed
from studies.common.exact_maps import SKEW
from studies.common.record import Results, command
from studies.common.style import canvas, keep, small

SPANS = (("1/10", "11/10"), (-5, "-1/2"))
ORDERS = (1, 2, 3, 4, 5)
TITLES = {
    Colours.PERIOD: "what attracts",
    Colours.ENTROPY: "topological entropy",
    Colours.BANDS: "bands of chaotic attractors",
}


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find cells, curves and crises, and draw them over colours.

    Parameters
    ----------
    fast
        Lower orders, few points, and crises in a part of the plane.
    out
        Folder for ``parameter_plane.png``.

    Returns
    -------
    dict
        CPU times [s] of cells and curves by the highest order, of crises and of a raster; curves
        with their kind, words and polynomial, and points with their values.
    """
    orders = ORDERS[: 3 if fast else None]
    costs = []
    for highest in orders:
        plane, seconds = timed(
            partial(parameter_plane, SKEW, "a", "b", *SPANS, range(1, highest + 1))
        )
        costs.append(
            {"order": highest, "cpu": seconds.cpu, "strips": len(plane.strips),
             "curves": len(plane.curves), "points": len(plane.points)}
        )  # fmt: skip
    crises, of_crises = timed(partial(with_crises, plane, 1 if fast else 2, 1 if fast else 4))
    raster, of_raster = timed(partial(plane_raster, plane, *((8, 6) if fast else (64, 48))))
    if out is not None:
        keep(draw(crises, raster), out / "parameter_plane.png")
    return {
        "costs": costs,
        "crises": of_crises.cpu,
        "raster": {"cpu": of_raster.cpu, "points": int(raster.periods.size),
                   "open": int(raster.open.sum())},
        "curves": [
            [c.id, str(c.kind), " ".join(c.words), str(c.polynomial)] for c in crises.curves
        ],
        "points": [[p.id, str(p.kind), *map(str, p.values)] for p in crises.points],
        "kinds": dict(Counter(str(c.kind) for c in crises.curves)),
    }  # fmt: skip


def draw(plane: ParameterPlane, raster: PlaneRaster) -> Figure:
    """Three schemes of colours side by side."""
    figure, axes = canvas(5.0, 1, 3)
    for ax, colours in zip(axes, Colours, strict=True):
        plot_plane(plane, ax, raster=raster, colours=colours)
        ax.set_title(TITLES[colours])
        small(ax)
    for ax in axes[1:]:
        ax.set_ylabel("")  # as on the left; the scale of colours stands there
    return figure


if __name__ == "__main__":
    command(main, "parameter_plane")
