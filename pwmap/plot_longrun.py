"""Pictures of the long run: bands under a diagram, entropy over a parameter, densities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import sympy
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from sympy import QQ

from pwmap.algebra.roots import simplest_between
from pwmap.diagrams.diagram import FloatArray, PointKind
from pwmap.longrun.constant import EntropyIntervals, constant_entropy
from pwmap.longrun.crises import AttractorDiagram
from pwmap.longrun.dynamics import Attractor, Dynamics, dynamics
from pwmap.longrun.numbers import to_double
from pwmap.maps.piecewise_linear import PiecewiseLinearMap

BAND, CYCLE, STEP, POINTS, CRISIS = "#9ecae1", "#08306b", "#08306b", "#c6dbef", "#cb181d"
DASHES: dict[PointKind, Any] = {
    PointKind.MC: "--",
    PointKind.XC: ":",
    PointKind.FC: "-",
    PointKind.BC: "-.",
    PointKind.PD: (0, (1, 3)),
}
STEPS = 12  # places in each cell at which bands are drawn, at least
BINS = 120  # of histograms
SEED = 1  # of starts of orbits


def plot_attractors(
    found: AttractorDiagram, map_: PiecewiseLinearMap, ax: Axes | None = None, *, steps: int = 160
) -> Axes:
    """Draw bands as areas and attracting cycles as lines over the parameter, with crises.

    Parameters
    ----------
    found
        What to draw.
    map_
        The map it is of.
    ax
        Axes to draw on; new ones by default.
    steps
        How many places the whole interval has; each is computed exactly.
    """
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 4.6), layout="constrained").gca()
    name = str(found.parameter)
    whole = float(found.cells[-1].upper - found.cells[0].lower)
    shown = dict[str, Patch | Line2D]()
    for cell in found.cells:
        low, high = float(cell.lower), float(cell.upper)
        places = np.linspace(low, high, max(STEPS, round(steps * (high - low) / whole)) + 2)[1:-1]
        near = 0.2 * (places[1] - places[0])
        exact = [simplest_between(_rational(p - near), _rational(p + near)) for p in places]
        seen = [dynamics(map_, {name: QQ.to_sympy(p)}).attractors for p in exact]
        _areas(ax, [to_double(p) for p in exact], seen, (low, high), shown)
    for crisis in found.crises:
        style = DASHES[crisis.kind]
        ax.axvline(float(crisis.parameter), color=CRISIS, linewidth=0.9, linestyle=style)
        shown.setdefault(
            crisis.kind.label, Line2D([], [], color=CRISIS, linewidth=0.9, linestyle=style)
        )
    ax.set_xlabel(name)
    ax.set_ylabel("x")
    ax.set_xlim(float(found.cells[0].lower), float(found.cells[-1].upper))
    if shown:
        ax.legend(shown.values(), shown.keys(), loc="upper center", bbox_to_anchor=(0.5, -0.13),
                  ncols=3, frameon=False, fontsize=8)  # fmt: skip
    return ax


def _rational(x: float) -> Any:
    return QQ(*float(x).as_integer_ratio())


def _areas(
    ax: Axes, places: Sequence[float], seen: Sequence[tuple[Attractor, ...]],
    cell: tuple[float, float], shown: dict[str, Patch | Line2D],
) -> None:  # fmt: skip
    """Bands and cycles of one cell; to its ends they go on as straight lines."""
    over = [cell[0], *places, cell[1]]
    for number in range(max((len(each) for each in seen), default=0)):
        rows = [each[number] for each in seen if number < len(each)]
        counts = {(len(row.bands), len(row.points)) for row in rows}
        if len(rows) < len(seen) or len(counts) > 1:
            continue
        for k in range(len(rows[0].bands)):
            low = _to_ends(over, [float(row.bands[k].start) for row in rows])
            high = _to_ends(over, [float(row.bands[k].end) for row in rows])
            ax.fill_between(over, low, high, color=BAND, linewidth=0.0)
            shown.setdefault("bands", Patch(color=BAND))
        for k in range(len(rows[0].points)):
            values = _to_ends(over, [sorted(map(float, row.points))[k] for row in rows])
            (line,) = ax.plot(over, values, color=CYCLE, linewidth=1.0)
            shown.setdefault("attracting cycle", line)


def _to_ends(over: Sequence[float], values: Sequence[float]) -> list[float]:
    """Values at inner places, with those at both ends on straight lines through the nearest two."""
    first, last = (
        values[i] + (values[i] - values[j]) * (over[end] - over[m]) / (over[m] - over[n])
        for end, i, j, m, n in ((0, 0, 1, 1, 2), (-1, -1, -2, -2, -3))
    )
    return [first, *values, last]


def plot_entropy(
    map_: PiecewiseLinearMap, parameter: str, span: tuple[object, object], ax: Axes | None = None,
    *, steps: int = 120, orders: tuple[int, ...] = (12, 24),
    intervals: EntropyIntervals | None = None,
) -> Axes:  # fmt: skip
    """Draw the topological entropy over a parameter, as the area between its bounds.

    Where it is known to be constant it is drawn as a thick horizontal piece.

    Parameters
    ----------
    map_
        A map of one parameter.
    parameter, span
        Its name, and two rationals.
    ax
        Axes to draw on; new ones by default.
    steps
        How many rational values.
    orders
        Up to which the graph of laps is made.
    intervals
        What :func:`pwmap.constant_entropy` found; by default it is asked.
    """
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 3.6), layout="constrained").gca()
    low, high = (sympy.Rational(str(end)) for end in span)
    places = [low + (high - low) * sympy.Rational(2 * k + 1, 2 * steps) for k in range(steps)]
    found = [dynamics(map_, {parameter: p}, orders=orders).entropy for p in places]
    over = [float(p) for p in places]
    ax.fill_between(over, [e.low for e in found], [e.high for e in found], color=POINTS,
                    linewidth=0.0, label="between bounds")  # fmt: skip
    ax.plot(over, [e.low for e in found], color=STEP, linewidth=0.9, label="bounds")
    ax.plot(over, [e.high for e in found], color=STEP, linewidth=0.9)
    known = intervals if intervals is not None else constant_entropy(map_, parameter, span)
    if known.intervals:
        ax.hlines([each.entropy.high for each in known.intervals],
                  [float(each.lower) for each in known.intervals],
                  [float(each.upper) for each in known.intervals],
                  color=CRISIS, linewidth=3.0, label="constant, proved")  # fmt: skip
    ax.set_xlim(float(low), float(high))
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(parameter)
    ax.set_ylabel("topological entropy")
    ax.legend(frameon=False, fontsize=8)
    return ax


def plot_density(found: Dynamics, ax: Axes | None = None, *, points: int = 200_000) -> Axes:
    """Draw the invariant densities of all bands over histograms of orbits.

    Parameters
    ----------
    found
        The long run of a map.
    ax
        Axes to draw on; new ones by default.
    points
        Of orbits in the histogram, of each attractor.

    Raises
    ------
    ValueError
        If no attractor has a density.
    """
    known = [(each, each.density) for each in found.attractors if each.density is not None]
    if not known:
        raise ValueError(
            "expected a map with a chaotic attractor, this one has none with a density"
        )
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 3.6), layout="constrained").gca()
    for attractor, density in known:
        ends = to_double(density.places[0]), to_double(density.places[-1])
        label = f"orbits, {points} points"
        sample = _orbits(found, attractor, points)
        ax.hist(sample, bins=BINS, range=ends, density=True, color=POINTS, label=label)
        heights = [to_double(v) if density.exact else float(v.mid) for v in density.values]
        label = "density, exact" if density.exact else f"density, to {density.error:.0e}"
        ax.stairs(heights, [to_double(x) for x in density.places], color=STEP, linewidth=1.1,
                  baseline=None, label=label)  # fmt: skip
    ax.set_xlabel("x")
    ax.set_ylabel("density")
    ax.set_ylim(bottom=0.0)
    ax.legend(frameon=False, fontsize=8)
    return ax


def _orbits(found: Dynamics, attractor: Attractor, points: int) -> FloatArray:
    """Points of orbits in doubles; noise of a rounding keeps them from ending in a short cycle."""
    line, rng = found.line, np.random.default_rng(SEED)
    slopes, shifts = (np.array([to_double(b[k]) for b in line.branches]) for k in (0, 1))
    breaks = np.array([to_double(x) for x in line.breaks])
    ends = [(float(band.start), float(band.end)) for band in attractor.bands]
    x = np.concatenate([rng.uniform(*end, max(1, points // (100 * len(ends)))) for end in ends])
    kept = []
    for step in range(300):
        k = np.searchsorted(breaks, x)
        x = slopes[k] * x + shifts[k] + rng.normal(0.0, 1e-15, len(x))
        if step >= 200:
            kept.append(x)
    every: FloatArray = np.concatenate(kept)
    return every
