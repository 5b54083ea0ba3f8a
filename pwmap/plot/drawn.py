"""The result of a plot function, and helpers for axes, legends and styles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import rcParamsDefault
from matplotlib.artist import Artist, ArtistInspector
from matplotlib.axes import Axes
from matplotlib.cbook import strip_math
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import AutoLocator, MaxNLocator, ScalarFormatter
from matplotlib.transforms import offset_copy

from pwmap.algebra.arguments import check_mapping, shortened
from pwmap.diagrams.data import FloatArray

Artists = dict[str, list[Artist]]  # by the name of a part, as a legend has it
Styles = Mapping[str, Mapping[str, Any]]  # properties of artists, by the same names

STYLE, PROPERTIES = "{'stable': {'color': 'k'}}", "{'color': 'k'}"  # examples in messages
DIGIT, GAP = 0.64, 0.6  # width of a digit, and least gap between numbers of an axis, in font sizes
LABEL = 30.0  # height of the numbers and the name of an axis [pt]


@dataclass(frozen=True, slots=True)
class Drawn:
    """The result of a plot function such as :func:`pwmap.plot.plot_map`.

    ``axes`` are those on which it was drawn, in order; ``artists`` has lists of artists of
    matplotlib by their names in the legend, each of which ``artist.set(color="k")`` can change.
    """

    axes: tuple[Axes, ...]
    artists: Mapping[str, Sequence[Artist]]

    @property
    def ax(self) -> Axes:
        """The axes, or the first of several."""
        return self.axes[0]

    @property
    def figure(self) -> Figure | SubFigure:
        """The figure that holds the axes."""
        return self.axes[0].figure


def figure_of(width: float, height: float) -> Figure:
    """A new figure of a size [inch], unless matplotlib's ``figure.figsize`` was changed."""
    own = plt.rcParams["figure.figsize"]
    kept = list(own) == list(rcParamsDefault["figure.figsize"])
    return plt.figure(figsize=(width, height) if kept else own, layout="constrained")


def axes_for(ax: Axes | None, width: float, height: float) -> Axes:
    """The given axes, or new ones in a figure of a size [inch]; TypeError if they are no axes."""
    if ax is None:
        ax = figure_of(width, height).gca()
    if not isinstance(ax, Axes):
        raise TypeError(f"ax must be axes of matplotlib, got {shortened(repr(ax))}")
    return _with_powers(ax)


def _with_powers(ax: Axes) -> Axes:
    """The axes, on which a common factor of numbers is a power of ten, not 1e-6."""
    for axis in (ax.xaxis, ax.yaxis):
        formatter = axis.get_major_formatter()
        if isinstance(formatter, ScalarFormatter):
            formatter.set_useMathText(True)
    return ax


def sized(points: float) -> float:
    """Scale a size of text [pt], chosen for a ``font.size`` of 10, to matplotlib's setting."""
    return points * float(plt.rcParams["font.size"]) / 10.0


def framed(ax: Axes, x: str, y: str) -> None:
    """Label both axes, draw a grid, and avoid numbers that overlap."""
    ax.set(xlabel=x, ylabel=y)
    ax.grid(alpha=0.25, linewidth=0.5)
    if type(ax.xaxis.get_major_locator()) is AutoLocator:  # unless the caller has chosen another
        ax.xaxis.set_major_locator(_SparseTicks())


class _SparseTicks(AutoLocator):
    """Ticks of a horizontal axis, fewer than matplotlib's if their numbers would overlap."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Ticks from below ``vmin`` to above ``vmax``."""
        ticks = super().tick_values(vmin, vmax)
        for fewer in range(len(ticks) - 2, 0, -1):
            if self._apart(ticks, abs(vmax - vmin)):
                break
            ticks = MaxNLocator(fewer, steps=[1, 2, 2.5, 5, 10]).tick_values(vmin, vmax)
        return ticks

    def _apart(self, ticks: Sequence[float], extent: float) -> bool:
        axis: Any = self.axis
        size = axis.majorTicks[0].label1.get_fontsize()
        texts = axis.get_major_formatter().format_ticks(ticks)
        widest = DIGIT * size * max(len(strip_math(text)) for text in texts)
        points = 72.0 * axis.axes.bbox.width / axis.axes.figure.dpi
        return bool((widest + GAP * size) * extent <= points * (ticks[1] - ticks[0]))


def several_axes(
    axes: Sequence[Axes] | None, rows: int, columns: int, size: tuple[float, float]
) -> list[Axes]:
    """The given axes, rows * columns, or those of a new figure; a single column shares x."""
    if axes is None:
        figure = figure_of(*size)
        axes = [*figure.subplots(rows, columns, sharex=columns == 1, squeeze=False).flat]
        figure.align_ylabels(axes)
    found = list(axes) if isinstance(axes, Iterable) else [axes]
    if len(found) != rows * columns or not all(isinstance(ax, Axes) for ax in found):
        raise TypeError(
            f"axes must be {rows * columns} axes of matplotlib, got {shortened(repr(axes))}"
        )
    return [_with_powers(ax) for ax in found]


def strokes(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coordinates of n segments, (n, 2), as one line with gaps."""
    gap = np.full((len(x), 1), np.nan)
    return np.hstack([x, gap]).ravel(), np.hstack([y, gap]).ravel()


def stairs(orbit: Sequence[float] | FloatArray) -> tuple[FloatArray, FloatArray]:
    """The line of an orbit x_0, x_1, ... between the diagonal and the map, a cobweb."""
    x = np.repeat(orbit, 2)
    return x[:-1], np.append(x[:1], x[2:])


def below(ax: Axes) -> dict[str, Any]:
    """Arguments that place a legend below the horizontal axis and its label, at any height."""
    figure: Any = ax.figure
    place = offset_copy(ax.transAxes, figure, y=-LABEL, units="points")
    return {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": place}


def styled(artists: Artists, styles: Styles | None, known: Iterable[str] = ()) -> None:
    """Set properties of artists by name; ValueError for an unknown name or property."""
    names = dict.fromkeys((*artists, *known))
    styles = {} if styles is None else styles
    check_mapping("styles", styles, STYLE)
    for name, properties in styles.items():
        if name not in names:
            raise ValueError(f"a style must be of one of {', '.join(names)}, got {name!r}")
        check_mapping(f"the style of {name!r}", properties, PROPERTIES)
        for artist in artists.get(name, ()):
            for key in properties:
                if not hasattr(artist, f"set_{key}"):
                    possible = ", ".join(ArtistInspector(artist).get_setters())
                    raise ValueError(
                        f"the style of {name!r} has no property {key!r}; possible are {possible}"
                    )
            artist.set(**properties)


def add(artists: Artists, more: Mapping[str, Iterable[Artist]]) -> None:
    """Add artists to those with the same names."""
    for name, values in more.items():
        artists.setdefault(name, []).extend(values)
