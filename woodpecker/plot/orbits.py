"""Pictures of orbit diagrams, alone or with a bifurcation diagram."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from pwmap.plot.diagrams import axis_label, earlier_entries
from pwmap.plot.drawn import Artists, Drawn, Styles, axes_for, framed, sized, styled
from pwmap.plot.palette import CHAOS, PERIODS, named, of_period
from woodpecker.base.checks import instance
from woodpecker.slices.attracting import OrbitDiagram

NO_PERIOD = "no period"
SAMPLE = 7.0  # size of a dot in the legend [pt]
SIZES = 1.2, 4.0  # least and largest size of a dot [pt]
BEHIND = 0.8  # zorder of the dots: above bands, below branches


def plot_orbits(
    found: OrbitDiagram, ax: Axes | None = None, *, size: float | None = None, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw an orbit diagram: a dot for each point of the orbits after their transients.

    On axes with a bifurcation diagram the dots lie behind its lines.

    Parameters
    ----------
    found
        From :func:`woodpecker.orbit_diagram`; for a system, one coordinate of its orbit diagram.
    ax
        Axes to draw on, perhaps with a diagram on them; new ones by default.
    size
        Size of a dot [pt], by default from 1.2 to 4, the larger the fewer parameters there are.
    legend, styles
        Whether to have a legend of all that is on the axes; properties of matplotlib by its names.

    Examples
    --------
    >>> from woodpecker import orbit_diagram
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.plot.orbits import plot_orbits
    >>> found = orbit_diagram(two_lines(), [-0.5, 0.5], [0.3], (-3, 3), transient=100, keep=8)
    >>> list(plot_orbits(found).artists)
    ['period 1', 'period 2']
    """
    instance("found", found, OrbitDiagram)
    alone = ax is None
    ax = axes_for(ax, 7.0, 4.6)
    shown: Artists = {}
    size = _size(found, ax) if size is None else size
    periods = {min(orbit.period, len(PERIODS)) for orbit in found.orbits}
    for period in sorted(periods, key=lambda each: each or math.inf):
        own = [o for o in found.orbits if min(o.period, len(PERIODS)) == period]
        name, colour = (named(period), of_period(period)) if period else (NO_PERIOD, CHAOS)
        shown[name] = [*ax.plot(
            *replace(found, orbits=tuple(own)).points(), ".", color=colour, markersize=size,
            markeredgewidth=0.0, zorder=BEHIND, rasterized=True,
        )]  # fmt: skip
        ax.plot([], [], ".", color=colour, markersize=SAMPLE, label=name)
    styled(shown, styles, (NO_PERIOD, *(named(k + 1) for k in range(len(PERIODS)))))
    if alone:
        framed(ax, axis_label(found.parameter_name), axis_label(found.x_name))
    handles, labels = ax.get_legend_handles_labels()
    if legend and handles:
        entries = {**earlier_entries(ax), **dict(zip(labels, handles, strict=True))}
        ax.legend(entries.values(), entries.keys(), fontsize=sized(7), loc="best", framealpha=0.9)
    return Drawn((ax,), shown)


def _size(found: OrbitDiagram, ax: Axes) -> float:
    """The size of a dot [pt] with which those of neighbouring parameters do not touch."""
    columns = max(1, len({orbit.p for orbit in found.orbits}))
    width = 72.0 * ax.get_window_extent().width / ax.figure.dpi
    return float(np.clip(0.5 * width / columns, *SIZES))
