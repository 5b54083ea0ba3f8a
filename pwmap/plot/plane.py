"""Pictures of two parameters: cells or a raster in colours, bifurcation curves, points."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from sympy import QQ

from pwmap.algebra.arguments import MOST_COLUMNS, check_kind, checked_count, explained
from pwmap.algebra.exact import to_float
from pwmap.algebra.roots import bounds, equally_spaced
from pwmap.diagrams.data import FloatArray
from pwmap.diagrams.shown import listed
from pwmap.plane.colours import Colours
from pwmap.plane.curves import PlaneCurve, doubles
from pwmap.plane.plane import ParameterPlane, attracting
from pwmap.plane.rasters import PlaneRaster, arc_arrays, root_array
from pwmap.plane.strips import Strip
from pwmap.plot.diagrams import NAMES, axis_label
from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, below, sized, styled
from pwmap.plot.labels import LabelledCurve, Labels, Name
from pwmap.plot.palette import BACKGROUND, CHAOS, LINES, NOTHING, PERIODS, of_period

NEAR = QQ(1, 10**6)  # part of a strip's width that borders keep from its ends, where they may meet
POINTS = "of codimension two"
HALO = (withStroke(linewidth=3.0, foreground="white"),)  # around curves, on areas of any colour
FRAME = "#969696"  # around a colour in the legend, which may be white
HATCHES = ("", "///", "xxx")  # of cells in which one, two or more periods attract


@explained()
def plot_plane(
    plane: ParameterPlane,
    ax: Axes | None = None,
    *,
    raster: PlaneRaster | None = None,
    colours: Colours = Colours.PERIOD,
    samples: int = 200,
    legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:
    """Draw two parameters: colours, bifurcation curves, and the points in which they meet.

    Curves and points have the names of the plane, where there is room.

    Parameters
    ----------
    plane, raster, colours
        The plane, the attractors at points of it, and the quantity that colours show; without a
        raster, cells are coloured by the attracting cycles of the orders of the plane.
    samples, ax, legend, styles
        Points along a curve across the plane; others, and errors, as for ``plot_diagram``.

    Returns
    -------
    Drawn
        The axes, and the artists of curves and points by the names in the legend.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, parameter_plane
    >>> from pwmap.plot import plot_plane
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    >>> plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2))
    >>> list(plot_plane(plane, samples=20).artists)
    ['flip', 'names']
    """
    check_kind("plane", plane, ParameterPlane)
    check_kind("colours", colours, Colours)
    if raster is not None:
        check_kind("raster", raster, PlaneRaster)
    samples = checked_count(samples, "samples", MOST_COLUMNS)
    ax = axes_for(ax, 6.0, 6.2)
    if raster is None:
        title, patches = "attracting periods", _cells(ax, plane, samples)
    else:
        title, draw = _SCHEMES[colours]
        patches = draw(ax, raster)
    low, high = map(to_float, plane.across_span)
    step = (high - low) / samples
    shown: Artists = {}
    for curve in plane.curves:
        line = ax.plot(*_joined(curve, step), **LINES[curve.kind], zorder=3, path_effects=HALO)
        add(shown, {curve.kind.label: line})
    for point in plane.points:
        mark = ax.plot(*doubles(point), "o", markersize=4.0, color="black", linestyle="none",
                       markerfacecolor="white", markeredgewidth=0.9, zorder=4)  # fmt: skip
        add(shown, {POINTS: mark})
    names = [kind.label for kind in LINES]
    styled(shown, styles, (*names, POINTS))
    ax.set(
        xlabel=axis_label(str(plane.across)), ylabel=axis_label(str(plane.along)),
        xlim=(low, high), ylim=(*map(to_float, plane.along_span),),
    )  # fmt: skip
    shown[NAMES] = [_named(ax, plane, step)]
    drawn = [name for name in (*names, POINTS) if name in shown]
    handles = [*patches, *(shown[name][0] for name in drawn)]
    labels = [*(str(patch.get_label()) for patch in patches), *drawn]
    if legend:
        ax.legend(handles, labels, fontsize=sized(7), ncols=2, title=title if patches else None,
                  title_fontsize=sized(7), frameon=False, **below(ax))  # fmt: skip
    return Drawn((ax,), shown)


def _joined(curve: PlaneCurve, step: float) -> FloatArray:
    """A curve as one line, so that its dashes run on; nan between arcs that do not meet."""
    line = np.empty((2, 0))
    for arc in curve.arcs:
        new = np.array(arc_arrays(arc, step))
        if not line.size or np.array_equal(line[:, -1], new[:, 0]):
            line = np.hstack([line, new])
        elif np.array_equal(line[:, 0], new[:, -1]):
            line = np.hstack([new, line])
        else:
            line = np.hstack([line, np.full((2, 1), np.nan), new])
    return line


def _named(ax: Axes, plane: ParameterPlane, step: float) -> Labels:
    curves = list[LabelledCurve]()
    for curve in plane.curves:
        arcs = [arc_arrays(arc, step) for arc in curve.arcs]
        longest = max(range(len(arcs)), key=lambda k: len(arcs[k][0]), default=0)
        color = LINES[curve.kind]["color"]
        for k, (across, along) in enumerate(arcs):
            text = curve.id if k == longest else ""
            curves.append(LabelledCurve(text, across, along, color, 0.0))
    points = [Name(point.id, *doubles(point), always=False) for point in plane.points]
    labels = Labels(points, curves)
    ax.add_artist(labels)
    return labels


# --- Colours --------------------------------------------------------------------------------------


def _cells(ax: Axes, plane: ParameterPlane, samples: int) -> list[Patch]:
    """Draw cells in the colours of attracting periods, hatched if there are several."""
    found = set[tuple[int, ...]]()
    low, high = map(to_float, plane.across_span)
    for strip in plane.strips:
        count = max(2, int(samples * (float(strip.upper) - float(strip.lower)) / (high - low)))
        across, borders = _borders(strip, count)
        opened = [cell for cell in strip.cells if not cell.is_edge]
        for cell, lower, upper in zip(opened, borders[:-1], borders[1:], strict=True):
            periods = tuple(sorted({*attracting(cell, strip.cells.orders).values()}))
            found.add(periods)
            if len(periods) > 1:  # hatches have the edge, so that strips would part in white
                ax.fill_between(across, lower, upper, **_face(periods[:1]))
            ax.fill_between(across, lower, upper, **_face(periods))
    return [
        Patch(**_face(key) | ({} if key else {"edgecolor": FRAME}),
              label=f"period{'s' * (len(key) > 1)} {listed(key)}" if key else "none found")
        for key in sorted(found)
    ]  # fmt: skip


def _face(periods: tuple[int, ...]) -> dict[str, Any]:
    """The fill of an area: the colour of the shortest period, hatched in that of the next."""
    first, second = (*map(of_period, periods), NOTHING, NOTHING)[:2]
    hatch = HATCHES[min(max(len(periods), 1), len(HATCHES)) - 1]
    edge = second if hatch else first  # its own edge hides the white line between two strips
    return {"facecolor": first, "edgecolor": edge, "hatch": hatch, "linewidth": 0.3 * (not hatch)}


def _borders(strip: Strip, count: int) -> tuple[FloatArray, list[FloatArray]]:
    """Values across a strip, from just inside its start to just inside its end, and borders."""
    low, high = bounds(strip.column.low)[1], bounds(strip.column.high)[0]
    near = (high - low) * NEAR
    values = [low + near, *equally_spaced(low, high, count), high - near]
    return np.array(list(map(to_float, values))), [
        root_array(border, strip.column, values) for border in strip.borders
    ]


def _corners(raster: PlaneRaster) -> Iterator[FloatArray]:
    for axis in (raster.across, raster.along):
        middles = np.array(list(map(to_float, axis)))
        half = 0.5 * (middles[1] - middles[0]) if len(middles) > 1 else 0.5
        yield np.append(middles - half, middles[-1] + half)


def _periods(ax: Axes, raster: PlaneRaster) -> list[Patch]:
    """Draw the shortest attracting period; dark where only bands attract."""
    return _listed(ax, raster, raster.periods, "period {}", (raster.bands, "bands", CHAOS))


def _bands(ax: Axes, raster: PlaneRaster) -> list[Patch]:
    return _listed(
        ax, raster, raster.bands, "{} bands", (raster.periods, "cycles only", BACKGROUND)
    )


def _listed(
    ax: Axes, raster: PlaneRaster, numbers: Any, label: str, else_: tuple[Any, str, str]
) -> list[Patch]:
    """Colour rectangles by their numbers, and all those where only the other number is not 0."""
    others, other, colour = else_
    palette = (NOTHING, colour, *PERIODS)
    last = len(palette) - 1  # stands for all larger numbers
    places = np.where(numbers > 0, numbers + 1, np.where(others > 0, 1, 0))
    shown = np.minimum(places, last)
    ax.pcolormesh(*_corners(raster), shown, cmap=ListedColormap(palette), rasterized=True,
                  norm=BoundaryNorm(np.arange(-0.5, last + 1.0), last + 1))  # fmt: skip
    texts = ["none known", other, *(label.format(k) for k in range(1, last))]
    texts[2] = texts[2].replace("1 bands", "1 band")
    if places.max() > last:
        texts[last] += " or more"
    return [
        Patch(facecolor=palette[k], edgecolor=FRAME, linewidth=0.4, label=texts[k])
        for k in np.unique(shown).tolist()
    ]


def _entropy(ax: Axes, raster: PlaneRaster) -> list[Patch]:
    most = float(raster.entropy.max()) or math.log(2.0)  # if all are 0, that of the full tent
    mesh = ax.pcolormesh(*_corners(raster), raster.entropy, cmap="YlGnBu", vmin=0.0, vmax=most,
                         rasterized=True)  # fmt: skip
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02, aspect=30)
    bar.set_label("topological entropy", fontsize=sized(8))
    bar.ax.tick_params(labelsize=sized(7))
    return []


_SCHEMES: dict[Colours, tuple[str, Callable[[Axes, PlaneRaster], list[Patch]]]] = {
    Colours.PERIOD: ("what attracts", _periods),
    Colours.ENTROPY: ("", _entropy),
    Colours.BANDS: ("chaotic attractors", _bands),
}
