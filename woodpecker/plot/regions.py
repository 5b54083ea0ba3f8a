"""Pictures of the regions of a plane of two parameters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, sized, styled
from pwmap.plot.palette import of_period
from woodpecker.base.checks import instance
from woodpecker.plot.plane import draw_curve, label, line_handles
from woodpecker.regions.census import Census
from woodpecker.regions.regions import Region, Regions

NO_STABLE = "#7f7f7f"  # colour of regions without a stable cycle
LIGHTEST, STEP = 0.28, 0.18  # part of the colour in its mix with white: least, and per unstable
# cycle
HATCHES = ("", "///", "xxx", "...")  # by the number of stable cycles besides the first
OPEN = "a place that disagrees"


def plot_regions(
    regions: Regions, ax: Axes | None = None, *, legend: bool = True, styles: Styles | None = None
) -> Drawn:
    """Draw regions, coloured by the cycles that exist in them, and the curves between them.

    Parameters
    ----------
    regions
        From :func:`woodpecker.regions.parameter_regions`.
    ax
        Axes to draw on; new ones by default.
    legend, styles
        Whether to have a legend beside the axes; properties of matplotlib by the names of regions
        in it, ``"curves"`` and ``"open"``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or a style has an unknown name.

    Examples
    --------
    >>> from woodpecker.examples import paper_regions
    >>> from woodpecker.plot.regions import plot_regions
    >>> list(plot_regions(paper_regions()).artists)
    ['curves', 'open', 'period 1: 1 stable, 1 unstable', 'period 1: 1 stable']
    """
    instance("regions", regions, Regions)
    ax = axes_for(ax, 8.4, 4.8)
    shown: Artists = {"curves": [], "open": []}
    for region in regions.regions:
        patch = PathPatch(_path(region), **face(region.census), linewidth=0.0, zorder=0)
        add(shown, {described(region.census): [ax.add_patch(patch)]})
    for curve in regions.curves:
        shown["curves"] += draw_curve(ax, curve)
    for (first, second), _ in regions.open:
        shown["open"] += ax.plot(first, second, "x", color="black", ms=3.5, mew=0.7, zorder=4)
    styled(shown, styles)
    ax.set(
        xlim=regions.spans[0], ylim=regions.spans[1], xlabel=label(regions.names[0]),
        ylabel=label(regions.names[1]),
    )  # fmt: skip
    if legend:
        ax.legend(handles=handles([regions]), fontsize=sized(7.5), frameon=False,
                  bbox_to_anchor=(1.0, 1.0), loc="upper left")  # fmt: skip
    return Drawn((ax,), shown)


def face(census: Census) -> dict[str, Any]:
    """Properties of the patch of a region, from the cycles in it."""
    # The colour is that of the shortest stable period, darker with each unstable cycle; further
    # stable cycles add a hatch in the colour of the second stable period.
    stable = [each.period for each in census for _ in range(each.stable)]
    unstable = sum(each.unstable for each in census)
    base = of_period(stable[0]) if stable else NO_STABLE
    part = min(LIGHTEST + STEP * unstable, 1.0)
    red, green, blue = (part * each + 1.0 - part for each in to_rgb(base))
    hatch = HATCHES[min(max(len(stable) - 1, 0), len(HATCHES) - 1)]
    over = of_period(stable[1]) if len(stable) > 1 else base
    return {"facecolor": to_hex((red, green, blue)), "edgecolor": over, "hatch": hatch}


def described(census: Census) -> str:
    """The cycles of a region in words."""
    parts = []
    for each in census:
        counts = [
            f"{number} {word}"
            for number, word in ((each.stable, "stable"), (each.unstable, "unstable"))
            if number
        ]
        if counts:
            parts.append(f"period {each.period}: {', '.join(counts)}")
    return "; ".join(parts) or "no cycle of these orders"


def handles(planes: Iterable[Regions]) -> list[Artist]:
    """Legend entries for the cycles of regions, largest area first, and for the curves between."""
    drawn = list(planes)
    shares: dict[Census, float] = {}
    for region in (region for regions in drawn for region in regions.regions):
        shares[region.census] = shares.get(region.census, 0.0) + region.share
    ordered = sorted(shares, key=lambda census: -shares[census])
    areas = [Patch(**face(census), linewidth=0.0, label=described(census)) for census in ordered]
    lines = line_handles(curve for regions in drawn for curve in regions.curves)
    if any(regions.open for regions in drawn):
        lines.append(Line2D([], [], ls="", marker="x", color="black", ms=3.5, mew=0.7, label=OPEN))
    return [*areas, *lines]


def _path(region: Region) -> Path:
    rings = (region.outline, *region.holes)
    codes = [Path.MOVETO, Path.LINETO, Path.CLOSEPOLY]
    every = [np.repeat(np.array(codes, dtype=np.uint8), [1, len(ring) - 2, 1]) for ring in rings]
    return Path(np.concatenate(rings), np.concatenate(every))
