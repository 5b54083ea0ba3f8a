"""Pictures of the long run: bands, kneading sequences, entropy, densities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import sympy
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from sympy import QQ

from pwmap.algebra.arguments import MOST, MOST_COLUMNS, check_kind, checked_count, explained
from pwmap.algebra.numbers import Exact, to_double
from pwmap.diagrams.data import FloatArray, PointKind
from pwmap.diagrams.diagram import Diagram
from pwmap.longrun.attractors import Bands
from pwmap.longrun.crises.bands import check_parameter, sampled, to_ends
from pwmap.longrun.crises.diagram import AttractorDiagram
from pwmap.longrun.dynamics import Attractor, Dynamics, FoundAttractors, Kneading, dynamics
from pwmap.longrun.entropy.constant import constant_entropy
from pwmap.longrun.entropy.entropies import EntropyIntervals
from pwmap.maps.budget import BUDGET, Meter
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.parameters.cells import checked_span
from pwmap.plot.diagrams import (
    BAND,
    MARKERS,
    PERIODS_NAMED,
    STABLE,
    STYLES,
    axis_label,
    bounded,
    draw_branches,
    legend_entries,
    order_samples,
)
from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, below, framed, sized, styled
from pwmap.plot.palette import named, of_period

STEP, POINTS, CRISIS = STABLE, "#c6dbef", "#cb181d"
LETTERS = ("#9ecae1", "#fdae6b", "#a1d99b", "#bcbddc", "#fde08b", "#d9d9d9")  # used in turn
DASHES: dict[PointKind, Any] = {
    PointKind.MC: "--",
    PointKind.XC: ":",
    PointKind.FC: "-",
    PointKind.BC: "-.",
    PointKind.PD: (0, (1, 3)),
}
CRISES = PointKind.MC, PointKind.XC, PointKind.FC  # of a chaotic attractor
EXACT = 12  # most characters of a number that is written exactly; longer ones are in decimals
STEPS = 12  # fewest places in each cell at which bands are computed
NEUTRAL, OPEN = "neutral intervals", "not known"
SHADES = (  # of bands, by how many attractors lie below theirs
    ("bands", BAND), ("bands of a second attractor", "#8fb3d9"),
    ("bands of further attractors", "#5f86b3"),
)  # fmt: skip
BEYOND = 10.0  # heights of the axes by which neutral intervals without end go on beyond them
UNKNOWN = "#eeeeee"
# a pale face shows also those that are too thin for a hatch
HATCHED: dict[str, Any] = {
    "facecolor": "#e3eef8",
    "edgecolor": STABLE,
    "hatch": "//////",
    "zorder": 0.6,
}
KNOWN = (
    *STYLES, *(name for name, _ in SHADES), NEUTRAL, OPEN, *PERIODS_NAMED,
    *(kind.label for kind in PointKind),
)  # fmt: skip
POLE = 32.0  # times smaller than elsewhere is 1 - multiplier of a cycle that tends to infinity
MARGIN = 0.12  # beyond bands, attracting cycles and crises, relative to their extent
BINS = 120  # of histograms
LETTERS_DRAWN = 1000  # most letters of a kneading sequence: the picture is then 6 m wide
SEED = 1  # of the random starts of orbits


# --- Over a parameter -----------------------------------------------------------------------------


@explained()
def plot_long_run(
    diagram: Diagram,
    found: AttractorDiagram,
    map_: PiecewiseLinearMap,
    ax: Axes | None = None,
    *,
    steps: int = 160,
    legend: bool = True,
    labels: bool | None = None,
    styles: Styles | None = None,
) -> Drawn:
    """Draw a diagram over the bands of its map, with their crises.

    A crisis is marked at the points of the repelling cycle that an image of a break meets.

    Parameters
    ----------
    diagram, found, map_
        Branches and attractors of one map over the same parameter, and the map.
    steps
        About how many values of the parameter bands are computed at, exactly.
    ax, legend, labels, styles
        As for :func:`pwmap.plot.plot_diagram`, errors included.

    Returns
    -------
    Drawn
        The axes, and the artists by the names in the legend.

    Raises
    ------
    ValueError
        If diagram and attractors are over different parameters.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram, bifurcation_diagram
    >>> from pwmap.plot import plot_long_run
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = attractor_diagram(tent, "a", ("5/4", "3/2"), 1)
    >>> branches = bifurcation_diagram(tent, "a", ("5/4", "3/2"), (1,))
    >>> drawn = plot_long_run(branches, found, tent, steps=8)
    >>> sorted(name for name, artists in drawn.artists.items() if artists)
    ['bands', 'merging crisis', 'names', 'unstable']
    """
    check_kind("diagram", diagram, Diagram)
    check_kind("found", found, AttractorDiagram)
    check_parameter(diagram, found)
    ax, shown = _draw_attractors(found, map_, ax, steps)
    every = draw_branches(diagram, ax, [k for k in MARKERS if k is not PointKind.EP], labels=labels)
    marked = [p.x for p in diagram.points if p.kind is not PointKind.EP and np.isfinite(p.x)]
    # in place of a fold at infinity, the branches that it joins
    folds = {p.id for p in diagram.points if p.kind is PointKind.LP and not np.isfinite(p.x)}
    marked += [x for b in diagram.branches if folds & {*b.ends} for x in bounded(b.x).tolist()]
    low, high = ax.get_ylim()
    margin = MARGIN * (high - low)
    ax.set_ylim(
        min([low, *(x - margin for x in marked)]), max([high, *(x + margin for x in marked)])
    )
    for name in shown.keys() & every.keys():  # crises that are points of the diagram, too
        every[name], shown[name] = [*shown[name], *every[name]], []
    add(every, shown)
    _without_end(ax, every.get(NEUTRAL, ()))
    styled(every, styles, KNOWN)
    if legend:
        _legend_below(ax, every, order_samples(diagram, every, styles))
    return Drawn((ax,), every)


@explained()
def plot_attractors(
    found: AttractorDiagram, map_: PiecewiseLinearMap, ax: Axes | None = None, *,
    steps: int = 160, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw bands as areas and attracting cycles as lines over the parameter, with crises.

    Neutral intervals, full of cycles, are hatched; places at which attractors are open are grey.

    Parameters
    ----------
    found, map_, ax, steps, styles
        As for :func:`plot_long_run`, errors included.

    Returns
    -------
    Drawn
        The axes, and the artists by the names in the legend.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, attractor_diagram
    >>> from pwmap.plot import plot_attractors
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> found = attractor_diagram(tent, "a", ("5/4", "3/2"), 1)
    >>> sorted(plot_attractors(found, tent, steps=8).artists)
    ['bands', 'merging crisis']
    """
    check_kind("found", found, AttractorDiagram)
    ax, shown = _draw_attractors(found, map_, ax, steps)
    _without_end(ax, shown.get(NEUTRAL, ()))
    ax.set(xlabel=axis_label(str(found.parameter)), ylabel=axis_label(str(map_.x)))
    styled(shown, styles, KNOWN)
    if shown:
        _legend_below(ax, shown)
    return Drawn((ax,), shown)


def _legend_below(
    ax: Axes, shown: Artists, more: Mapping[str, Artist | None] | None = None
) -> None:
    entries = legend_entries(shown, more)
    ordered = sorted(entries, key=lambda name: (name in PERIODS_NAMED and name) or "")
    codes = {kind.label: f"{kind.label} ({kind})" for kind in PointKind}
    both: Any = [  # a line and a marker, where a point has both
        tuple({type(each): each for each in shown[name]}.values()) if name in codes
        else entries[name]
        for name in ordered
    ]  # fmt: skip
    ax.legend(both, [codes.get(name, name) for name in ordered], ncols=3, frameon=False,
              fontsize=sized(7), **below(ax))  # fmt: skip


def _draw_attractors(
    found: AttractorDiagram, map_: PiecewiseLinearMap, ax: Axes | None, steps: int
) -> tuple[Axes, Artists]:
    """Draw bands and attracting cycles, found exactly at places in each cell, and crises."""
    # The axes show the whole interval of the parameter, and all that is drawn with a margin in x.
    check_map(map_)
    ax, steps = axes_for(ax, 7.0, 4.6), checked_count(steps, "steps", MOST_COLUMNS)
    whole = float(found.cells[-1].upper - found.cells[0].lower)
    shown: Artists = {}
    cycles = dict[str, list[FloatArray]]()  # by word
    meter = Meter(BUDGET)  # of all open cells: places in them beyond it are shown as not known
    for cell in found.cells:
        low, high = float(cell.lower), float(cell.upper)
        count = max(STEPS, round(steps * (high - low) / whole))
        places, seen = sampled(found, cell, count, meter if cell.is_open else Meter(BUDGET))
        _areas(ax, [to_double(p) for p in places], seen, (low, high), shown, cycles)
    for rows in cycles.values():
        ax.update_datalim(_before_pole(np.hstack(rows)))
    shown |= _draw_crises(found, map_, ax)
    ax.set_xlim(float(found.cells[0].lower), float(found.cells[-1].upper))
    extent = ax.dataLim.frozen()
    if np.isfinite(extent.height) and extent.height > 0:
        margin = MARGIN * extent.height
        ax.set_ylim(extent.y0 - margin, extent.y1 + margin)
    return ax, shown


def _areas(
    ax: Axes, places: Sequence[float], seen: Sequence[FoundAttractors],
    cell: tuple[float, float], shown: Artists, cycles: dict[str, list[FloatArray]],
) -> None:  # fmt: skip
    """Draw one cell; neighbouring places with the same numbers of bands and points are joined."""
    # points of cycles have no part in the limits of the axes, but are added to ``cycles``
    first = 0
    for _, group in groupby(seen, key=_shape):
        rows = list(group)
        last = first + len(rows) - 1
        inner = places[first : last + 1]
        low = 0.5 * (places[first - 1] + places[first]) if first else cell[0]
        high = 0.5 * (places[last] + places[last + 1]) if last + 1 < len(places) else cell[1]
        over = [low, *inner, high]
        if rows[0].left_out:
            add(shown, {OPEN: [ax.axvspan(low, high, color=UNKNOWN, zorder=0.4, linewidth=0.0)]})
        for number, attractors in enumerate(zip(*rows, strict=True)):
            name, color = SHADES[min(number, len(SHADES) - 1)]
            bands, neutral = [a.bands for a in attractors], [a.neutral for a in attractors]
            shade: dict[str, Any] = {"color": color, "zorder": 0.5}
            for label, areas, look in ((name, bands, shade), (NEUTRAL, neutral, HATCHED)):
                for row in zip(*areas, strict=True):
                    below = to_ends(over, [float(each.start) for each in row])
                    above = to_ends(over, [float(each.end) for each in row])
                    outline = np.column_stack([[*over, *over[::-1]], [*below, *above[::-1]]])
                    ax.update_datalim(outline[np.isfinite(outline[:, 1])])
                    area = PolyCollection([outline], linewidth=0.0, **look)
                    add(shown, {label: [ax.add_collection(area, autolim=False)]})
            period, gaps = len(attractors[0].points), list[float]()
            if period:
                gaps = [1.0 - float(a.multiplier) for a in attractors]
            for points in zip(*(sorted(map(float, p.points)) for p in attractors), strict=True):
                name, color = named(period), of_period(period)
                values = to_ends(over, points)
                known = cycles.setdefault(attractors[0].word, [])
                known.append(np.array([over, values, [gaps[0], *gaps, gaps[-1]]]))
                if len(points) == 1:
                    dot = Line2D(inner, points, linestyle="", marker=".", color=color,
                                 markersize=1.5, zorder=1.5)  # fmt: skip
                    add(shown, {name: [ax.add_artist(dot)]})
                    continue
                line = Line2D(over, values, color=color, linewidth=0.8, zorder=1.5)
                # a line first: the legend shows it
                shown[name] = [ax.add_artist(line), *shown.get(name, [])]
        first = last + 1


def _without_end(ax: Axes, areas: Sequence[Any]) -> None:
    """Let areas without end go on beyond the axes, of which they leave the limits to the others."""
    low, high = ax.get_ylim()
    far = BEYOND * (high - low)
    for area in areas:
        ends = area.get_paths()[0].vertices.copy()
        ends[ends == -np.inf], ends[ends == np.inf] = low - far, high + far
        area.set_verts([ends])


def _before_pole(cycle: FloatArray) -> FloatArray:
    # The places and values that axes show of a cycle, given with 1 minus its multiplier: like 1/p
    # it grows without bound as that tends to 0; they show it down to a quarter of the largest.
    *_, gap = cycle
    is_pole = gap.min() < gap.max() / POLE
    return cycle[:2, gap >= (0.25 * gap.max() if is_pole else 0.0)].T


def _shape(attractors: FoundAttractors) -> tuple[object, ...]:
    """Whether some are open, and the numbers of bands, neutral intervals and points of each."""
    counts = ((len(each.bands), len(each.neutral), len(each.points)) for each in attractors)
    return bool(attractors.left_out), *counts


def _draw_crises(found: AttractorDiagram, map_: PiecewiseLinearMap, ax: Axes) -> Artists:
    """Draw a named line at each crisis, and markers at the points of the cycle that is met."""
    shown: Artists = {}
    for crisis in found.crises:
        at, style = float(crisis.parameter), DASHES[crisis.kind]
        line = ax.axvline(at, color=CRISIS, linewidth=0.7, linestyle=style, zorder=1.2)
        marks: list[Artist] = [line]
        if crisis.kind in CRISES and crisis.cycles:
            points = map_.cycle(crisis.cycles[0]).points
            x = [float(point.subs(found.parameter, sympy.Float(at))) for point in points]
            marks.insert(0, ax.scatter(
                [at] * len(x), x, s=40, marker=MARKERS[crisis.kind][0], color=CRISIS, zorder=6,
                edgecolors="white", linewidths=0.6,
            ))  # fmt: skip
        add(shown, {crisis.kind.label: marks})
    if found.crises:  # named above the axes, where that covers nothing, and below a title
        places = [float(crisis.parameter) for crisis in found.crises]
        names = [f"{crisis.kind} ${_written(crisis.parameter)}$" for crisis in found.crises]
        above = ax.secondary_xaxis("top")
        above.set_xticks(places, names, rotation=90, fontsize=sized(6.5), color=CRISIS)
        above.tick_params(length=0.0)
    return shown


def _written(x: sympy.Expr) -> str:
    """A number for a formula: exact if that is short, else in decimals."""
    if len(str(x)) > EXACT:
        return f"{float(x):.5g}"
    return str(x) if x.is_Rational else str(sympy.latex(x))


# --- At one place ---------------------------------------------------------------------------------


@explained()
def plot_kneading(
    seen: Dynamics, ax: Axes | None = None, *, steps: int = 24, styles: Styles | None = None
) -> Drawn:
    """Draw the kneading sequences of both sides of all breaks, with the fates of their orbits.

    Each row is an orbit, each column a step. A repeating part is framed, its repetitions are paler.

    Parameters
    ----------
    seen, steps
        The long run of a map, and how many steps are shown.
    ax, styles
        As for :func:`pwmap.plot.plot_diagram`; names are the letters, ``"frames"`` and ``"texts"``.

    Returns
    -------
    Drawn
        The axes, and the artists by these names: rectangles by their letters.

    Raises
    ------
    TypeError, ValueError
        If an argument is of the wrong kind, the map has no break, or there is no step.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> from pwmap.plot import plot_kneading
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> drawn = plot_kneading(dynamics(tent, {"a": 2}), steps=4)
    >>> [text.get_text() for text in drawn.ax.get_yticklabels()]
    ['$1/2^-$', '$1/2^+$']
    """
    steps = checked_count(steps, "steps", LETTERS_DRAWN)
    check_kind("seen", seen, Dynamics)
    rows = seen.kneading
    if not rows:
        raise ValueError("expected a map with breaks, this one has none")
    ax = axes_for(ax, 2.6 + 0.24 * steps, 0.9 + 0.34 * len(rows))
    pieces = (*seen.line.branches, *seen.line.owners)
    letters = list(dict.fromkeys(piece.letter for piece in pieces))
    colors = {letter: LETTERS[k % len(LETTERS)] for k, letter in enumerate(letters)}
    shown: Artists = {}
    for number, row in enumerate(rows):
        add(shown, _draw_row(ax, number, row, steps, colors))
    styled(shown, styles, (*letters, "frames", "texts"))
    ax.set_xlim(-0.1, steps + 0.1)
    ax.set_ylim(len(rows) - 0.42, -0.58)
    sides = [f"${_written(row.x)}^{'-' if row.side < 0 else '+'}$" for row in rows]
    ax.set_yticks(range(len(rows)), sides)
    ax.set_xticks([k + 0.5 for k in range(0, steps, 4)], [str(k) for k in range(0, steps, 4)])
    ax.set_xlabel("step")
    ax.tick_params(length=0)
    for spine in ax.spines.values():
        spine.set_visible(False)
    return Drawn((ax,), shown)


def _draw_row(ax: Axes, number: int, row: Kneading, steps: int, colors: dict[str, str]) -> Artists:
    shown: Artists = {"frames": [], "texts": []}
    known, start = len(row.letters), len(row.letters) - row.repeating
    for step in range(steps if row.repeating else min(steps, known)):
        repeated = step >= known
        letter = row.letters[start + (step - start) % row.repeating if repeated else step]
        look: dict[str, Any] = {"facecolor": colors[letter], "alpha": 0.4 if repeated else 1.0}
        patch = Rectangle((step, number - 0.4), 1.0, 0.8, edgecolor="white", linewidth=0.8, **look)
        add(shown, {letter: [ax.add_patch(patch)]})
        shown["texts"].append(ax.text(
            step + 0.5, number, letter, ha="center", va="center", fontsize=sized(7),
            color="#737373" if repeated else "black",
        ))  # fmt: skip
    fate = row.fate
    if row.repeating:
        fate += f", period {row.repeating}"
        if start < steps:
            width = min(known, steps) - start
            frame = Rectangle((start, number - 0.4), width, 0.8, fill=False, edgecolor="black",
                              linewidth=1.1, zorder=3)  # fmt: skip
            shown["frames"].append(ax.add_patch(frame))
    elif known < steps:
        shown["texts"].append(
            ax.text(known + 0.15, number, "…", ha="left", va="center", fontsize=sized(8))
        )
    shown["texts"].append(ax.annotate(
        fate, (1.0, number), (4.0, 0.0), xycoords=("axes fraction", "data"),
        textcoords="offset points", va="center", fontsize=sized(7.5),
    ))  # fmt: skip
    return shown


@explained()
def plot_entropy(
    map_: PiecewiseLinearMap, parameter: str, span: tuple[object, object], ax: Axes | None = None,
    *, steps: int = 120, orders: tuple[int, ...] = (12, 24),
    intervals: EntropyIntervals | None = None, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw the topological entropy at values of a parameter, as dots at its bounds.

    Dots are not joined, as nothing is known between them. Where the entropy is proved to be
    constant it is a thick horizontal line.

    Parameters
    ----------
    map_, parameter, span
        A map of one parameter, its name, and two rationals.
    steps, orders
        The number of rational values, and the orders of :func:`pwmap.dynamics`.
    intervals
        The result of :func:`pwmap.constant_entropy`, which is called by default.
    ax, styles
        As for :func:`pwmap.plot.plot_diagram`, errors included; names are ``"between"``,
        ``"bounds"`` and ``"constant"``.

    Returns
    -------
    Drawn
        The axes, and the artists by these names.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.plot import plot_entropy
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> drawn = plot_entropy(tent, "a", ("3/2", 2), steps=4, orders=(4,))
    >>> drawn.ax.get_ylabel()
    'topological entropy'
    """
    check_map(map_)
    if intervals is not None:
        check_kind("intervals", intervals, EntropyIntervals)
    low, high = map(QQ.to_sympy, checked_span(span))
    steps = checked_count(steps, "steps", MOST_COLUMNS)
    ax = axes_for(ax, 7.0, 3.6)
    places = [low + (high - low) * sympy.Rational(2 * k + 1, 2 * steps) for k in range(steps)]
    found = [dynamics(map_, {parameter: p}, orders=orders).entropy for p in places]
    over = [float(p) for p in places]
    lows, highs = [e.low for e in found], [e.high for e in found]
    area = ax.vlines(over, lows, highs, color=POINTS, linewidth=2.4)  # nothing is known between
    dots: dict[str, Any] = {"color": STEP, "markersize": 2.5, "mew": 0.0}
    (line,) = ax.plot(over, lows, ".", **dots)
    (upper,) = ax.plot(over, highs, ".", **dots)
    drawn: Artists = {"between": [area], "bounds": [line, upper], "constant": []}
    widest = max(high - low for low, high in zip(lows, highs, strict=True))
    known = intervals if intervals is not None else constant_entropy(map_, parameter, span)
    label = f"between bounds, at most {widest:.1g} apart" if widest else "exact"
    shown: list[tuple[Any, str]] = [((area, line), label)]
    if known.intervals:
        rows = [(each.entropy.high, float(each.lower), float(each.upper))
                for each in known.intervals]  # fmt: skip
        pieces = ax.hlines(*zip(*rows, strict=True), color=CRISIS, linewidth=3.0)
        shown.append((pieces, "constant, proved"))
        drawn["constant"].append(pieces)
    ax.set_xlim(float(low), float(high))
    ax.set_ylim(bottom=-0.04 * ax.get_ylim()[1])  # a line at 0 is seen beside the axis
    framed(ax, axis_label(parameter), "topological entropy")
    styled(drawn, styles)
    ax.legend(*zip(*shown, strict=True), ncols=2, frameon=False, fontsize=sized(8), **below(ax))
    return Drawn((ax,), drawn)


@explained()
def plot_density(
    found: Dynamics, ax: Axes | None = None, *, points: int = 200_000,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw the invariant densities of all bands over histograms of orbits.

    Parameters
    ----------
    found, points
        The long run of a map, and how many points of orbits each histogram has.
    ax, styles
        As for :func:`pwmap.plot.plot_diagram`; names are ``"orbits"`` (bars) and ``"densities"``.

    Returns
    -------
    Drawn
        The axes, and the artists by these names.

    Raises
    ------
    TypeError, ValueError
        If an argument is of the wrong kind, or no attractor has a density.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> from pwmap.plot import plot_density
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> drawn = plot_density(dynamics(tent, {"a": 2}), points=1000)
    >>> [step.get_label() for step in drawn.artists["densities"]]
    ['density, exact']
    """
    check_kind("found", found, Dynamics)
    points = checked_count(points, "points", MOST)
    known = [(each, each.density) for each in found.attractors if each.density is not None]
    if not known:
        raise ValueError(
            "expected a map with a chaotic attractor, this one has none with a density"
        )
    ax = axes_for(ax, 7.0, 3.6)
    shown: Artists = {}
    for number, (attractor, density) in enumerate(known):
        ends = to_double(density.places[0]), to_double(density.places[-1])
        label = "" if number else f"orbits, {points:,} points"
        sample = _orbits(found, attractor, points)
        style: dict[str, Any] = {"bins": BINS, "range": ends, "density": True, "color": POINTS}
        bars: Any = ax.hist(sample, label=label, **style)[2]
        heights = [to_double(v) if density.exact else float(v) for v in density.values]
        known_to = "exact" if density.exact else f"error below {density.error:.0e}"
        label = f"density, {known_to}"
        steps = ax.stairs(heights, [to_double(x) for x in density.places], color=STEP,
                          linewidth=1.1, baseline=None, label=label)  # fmt: skip
        add(shown, {"orbits": [*bars], "densities": [steps]})
    framed(ax, "x", "density")
    ax.set_axisbelow(True)
    ax.set_ylim(bottom=0.0)
    styled(shown, styles)
    ax.legend(ncols=2, frameon=False, fontsize=sized(8), **below(ax))
    return Drawn((ax,), shown)


def _orbits(found: Dynamics, attractor: Attractor, points: int) -> FloatArray:
    """Points of orbits in doubles; noise of the size of rounding errors avoids short cycles."""
    # The attractor is scaled to the interval from 0 to 1, so that it may be small or far away.
    core, rng = attractor.core, np.random.default_rng(SEED)
    assert isinstance(core, Bands)
    low, high = core.intervals[0][0], core.intervals[-1][1]

    def scaled(*places: Exact) -> list[float]:
        return [to_double((place - low) / (high - low)) for place in places]

    slopes = np.array([to_double(branch.slope) for branch in found.line.branches])
    shifts = np.array(scaled(*(branch(low) for branch in found.line.branches)))
    breaks = np.array(scaled(*found.line.breaks))
    ends = [scaled(*band) for band in core.intervals]
    number = max(1, points // (100 * len(ends)))
    x = np.concatenate([rng.uniform(start, end, number) for start, end in ends])
    kept = []
    for step in range(300):
        k = np.searchsorted(breaks, x)
        x = np.clip(slopes[k] * x + shifts[k] + rng.normal(0.0, 1e-15, len(x)), 0.0, 1.0)
        if step >= 200:
            kept.append(x)
    every: FloatArray = to_double(low) + np.concatenate(kept) * to_double(high - low)
    return every
