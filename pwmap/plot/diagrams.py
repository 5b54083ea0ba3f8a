"""Pictures of maps and diagrams: stable solid, unstable dashed, jumps dotted.

Branches have the colours of their periods, whether a diagram has one iterate or several.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import sympy
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from sympy import QQ

from pwmap.algebra.arguments import (
    MOST_COLUMNS,
    check_kind,
    check_mapping,
    checked_count,
    checked_pair,
    explained,
)
from pwmap.algebra.arguments import shown as shown_
from pwmap.algebra.arithmetic import rational
from pwmap.diagrams.data import (
    Branch,
    BranchKind,
    FloatArray,
    PointKind,
    SpecialPoint,
    stable_inside,
)
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import listed
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_values
from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, framed, sized, stairs, styled
from pwmap.plot.labels import LabelledCurve, Labels, Name
from pwmap.plot.palette import PERIODS, of_period
from pwmap.plot.palette import named as period_named

STABLE, UNSTABLE, JUMP, WORD = of_period(1), "#d95f0e", "#238b45", "#737373"
INK, GREY, VIOLET = "#252525", "#969696", "#6a51a3"
BAND = "#c6dbef"
FIXED_BAND = "interval of fixed points"
NEUTRAL: dict[str, Any] = {"color": STABLE, "alpha": 0.35, "linewidth": 6.0}
PERIODS_NAMED = tuple(period_named(k + 1) for k in range(len(PERIODS)))
NAMES = "names"  # key of the labels of points and curves among the artists of a picture
WIDTHS = (1.25, 1.0, 0.85, 0.75)  # relative line widths of the lowest order, the next, ...
SAMPLE = 3.0  # width of the line that shows a colour in a legend [pt]
STARS = 4.9  # zorder of stars: below the other, smaller markers
STAR = 100  # area of a star [pt^2]: its tips show behind another marker
ONE_COLUMN = 9  # most entries of a legend in one column: a taller one always covers markers
MOST_LABELS = 30  # most points that get labels unless the caller asks for all
FAR = 1e9  # for infinity, relative to finite samples: in doubles, lines to there end exactly enough
MARKERS = {
    PointKind.LP: ("s", "#6a51a3"),
    PointKind.PD: ("D", "#6a51a3"),
    PointKind.NS: ("h", "#6a51a3"),
    PointKind.BP: ("P", "#6a51a3"),
    PointKind.BC: ("o", "#cb181d"),
    PointKind.FF: ("*", "#cb181d"),
    PointKind.FALL: ("v", "#525252"),
    PointKind.EP: ("|", "#525252"),
    PointKind.MC: ("^", "#cb181d"),
    PointKind.XC: ("P", "#cb181d"),
    PointKind.FC: ("X", "#cb181d"),
}


@explained()
def plot_diagram(
    diagram: Diagram,
    ax: Axes | None = None,
    *,
    kinds: Iterable[PointKind] = tuple(MARKERS),
    legend: bool = True,
    words: bool = False,
    labels: bool | None = None,
    branches: bool | Mapping[str, str] = False,
    stable_only: bool = False,
    styles: Styles | None = None,
) -> Drawn:
    """Draw all branches of a diagram and its special points, with their names.

    Stable branches are solid, unstable ones dashed, jumps dotted. Iterates have the colours of
    their periods, thinner lines for higher ones, and names such as P_2 if there is room. Points
    whose markers overlap share one label. Axes end before a branch that goes to infinity.

    Parameters
    ----------
    diagram, ax
        The diagram, and the axes to draw on; new ones by default.
    kinds
        Special points to mark; points with a name are marked, too.
    legend
        Whether to explain the lines and markers that occur.
    words
        Whether to mark where the word of a branch changes; there may be hundreds of places.
    labels
        Whether to write names or ids beside all marked points, or only names. By default all points
        but end points have them if they are at most 30, and two to each square inch.
    branches
        Whether to write ids on branches, or texts by id.
    stable_only
        Whether to leave out unstable branches, jumps, and points at which no stable branch ends.
    styles
        Properties of matplotlib for parts of the picture, by their names in the legend, such as
        ``{"stable": {"linewidth": 2}}`` or, for several iterates, ``{"period 2": {"color": "k"}}``.
        If two of them apply, as to a stable branch of period 2, the later style holds.

    Returns
    -------
    Drawn
        The axes, and the artists by their names in the legend, with ``"names"`` for the labels.

    Raises
    ------
    TypeError, ValueError
        If an argument is of the wrong kind, or no part has the name of a style.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> from pwmap.plot import plot_diagram
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> list(plot_diagram(bifurcation_diagram(lines, "p", (-1, 2), orders=(1,))).artists)
    ['stable', 'jump crossing', 'border collision', 'end point', 'names']
    """
    check_kind("diagram", diagram, Diagram)
    ax = axes_for(ax, 7.0, 4.6)
    shown = draw_branches(
        diagram, ax, kinds, labels=labels, branches=branches, stable_only=stable_only
    )
    if words:
        marks = ax.scatter(*_word_changes(diagram), s=9, marker=".", zorder=4, color=WORD)
        shown["word change"] = [marks]
    if diagram.filled:
        iterates = listed(f"$P_{{{order}}}$" for order in diagram.filled)
        shown[f"not drawn: intervals of fixed points of {iterates}"] = [
            Line2D([], [], linestyle="")
        ]
    kinds_of_points = (kind.label for kind in PointKind)
    styled(shown, styles, (*STYLES, *kinds_of_points, "bands", "word change", *PERIODS_NAMED))
    place_legend(ax, shown, legend, order_samples(diagram, shown, styles))
    return Drawn((ax,), shown)


def place_legend(
    ax: Axes, shown: Artists, legend: bool = True, more: Mapping[str, Artist | None] | None = None
) -> None:
    """Draw a legend with the entries of an earlier one; artists have labels even without it."""
    entries = legend_entries(shown, more)
    for name, artist in entries.items():
        artist.set_label(name)
    if legend and entries:
        entries = {**earlier_entries(ax), **entries}
        ax.legend(
            entries.values(), entries.keys(), fontsize=sized(7), loc="best", framealpha=0.9,
            ncols=1 + (len(entries) > ONE_COLUMN),
        )  # fmt: skip


def earlier_entries(ax: Axes) -> dict[str, Artist]:
    """The entries of the legend on some axes, samples of which no artist there may be."""
    legend = ax.get_legend()
    handles = () if legend is None else zip(legend.get_texts(), legend.legend_handles, strict=True)
    return {text.get_text(): handle for text, handle in handles if handle is not None}


def legend_entries(
    shown: Artists, more: Mapping[str, Artist | None] | None = None
) -> dict[str, Artist]:
    """The artist of each name in a legend; ``more`` replaces some, or drops them with None."""
    entries = {name: each[0] for name, each in shown.items() if name != NAMES and each}
    return {n: artist for n, artist in {**entries, **(more or {})}.items() if artist is not None}


def order_samples(
    diagram: Diagram, shown: Artists, styles: Styles | None = None
) -> dict[str, Artist | None]:
    """Lines for a legend: styles in ink, and colours of periods; empty if there is one iterate.

    A period has None if the caller's styles have replaced its colour in all lines.
    """
    ranks = ranks_of(diagram)
    if len(ranks) < 2:
        return {}
    looks = {label: {**style, "color": INK} for label, style in STYLES.items()}
    for order in ranks:
        looks[period_named(order)] = {"color": of_period(order), "linewidth": SAMPLE}
    samples: dict[str, Artist | None] = {}
    for name in filter(shown.__contains__, looks):
        sample = Line2D([], [], **looks[name])
        sample.set(**(styles or {}).get(name, {}))
        colours = {line.get_color() for line in shown[name] if isinstance(line, Line2D)}
        seen = name in STYLES or sample.get_color() in colours
        samples[name] = sample if seen else None
    return samples


def ranks_of(diagram: Diagram) -> dict[int, int]:
    """The rank of each order of a diagram, from the lowest on."""
    return {order: k for k, order in enumerate(sorted({b.order for b in diagram.branches}))}


def width_of(rank: int) -> float:
    """The factor by which the line width of an order depends on its rank."""
    return WIDTHS[min(rank, len(WIDTHS) - 1)]


def draw_branches(
    diagram: Diagram, ax: Axes, kinds: Iterable[PointKind], *, labels: bool | None = None,
    branches: bool | Mapping[str, str] = False, stable_only: bool = False,
) -> Artists:  # fmt: skip
    """Draw branches, special points, names and axes; see :func:`plot_diagram`."""
    shown: Artists = {}
    for branch in diagram.branches:
        if branch.kind is BranchKind.BAND:
            ends = branch.columns["low"], branch.columns["high"]
            area = ax.fill_between(branch.parameter, *ends, color=BAND, linewidth=0.0, zorder=0.5)
            add(shown, {"bands": [area]})
    curves = [c for c in _curves(diagram) if c.label == "stable" or not stable_only]
    lines: Artists = {}
    ranks = ranks_of(diagram)
    far = FAR * max((abs(float(x)) for c in curves for x in c.x if 0 < abs(x) < np.inf), default=1)
    for curve in curves:
        style = curve.look
        if len(ranks) > 1:
            style["linewidth"] *= width_of(ranks[curve.order])
        ax.update_datalim(np.column_stack([curve.p, bounded(curve.x)]))
        line = Line2D(curve.p, np.clip(curve.x, -far, far), solid_capstyle="round", **style)
        ax.add_artist(line)  # unlike a plotted line, it has no part in the limits of the axes
        add(lines, {curve.label: [line]})
        if len(ranks) > 1:
            add(lines, {period_named(curve.order): [line]})
    ax.autoscale_view()
    shown |= {label: lines[label] for label in STYLES if label in lines}
    near = {end for curve in curves for end in curve.ends}
    if not stable_only:
        near = {point.id for point in diagram.points}
    marked: list[SpecialPoint] = []
    if isinstance(kinds, str) or not isinstance(kinds, Iterable):
        raise TypeError(f"kinds must be several kinds such as (PointKind.BC,), got {shown_(kinds)}")
    try:
        asked = tuple(map(PointKind, kinds))
    except ValueError as error:
        known = ", ".join(kind.value for kind in PointKind)
        raise ValueError(f"{error}, which is one of {known}") from None
    for kind in (*asked, *(other for other in MARKERS if other not in asked)):
        points = [
            point for point in diagram.points
            if point.kind is kind and point.id in near
            and (kind in asked or (point.name and labels is not False))
        ]  # fmt: skip
        if points:
            marked += points
            marker, color = MARKERS.get(kind, (".", "#969696"))
            shown[kind.label] = [ax.scatter(
                [point.parameter for point in points], [point.x for point in points],
                s=STAR if marker == "*" else 26, marker=marker, color=color,
                zorder=STARS if marker == "*" else 5.0,
                edgecolors="white" if marker not in "|" else None, linewidths=0.6,
            )]  # fmt: skip
    shown |= {name: lines[name] for name in PERIODS_NAMED if name in lines}
    named = [point for point in diagram.points if point.name and point.id in near]
    written = {b.id: b.id for b in diagram.branches} if branches is True else branches or {}
    check_mapping("branches", written, "{'F1': 'stable'}")
    on = [(text, diagram.branch(name)) for name, text in written.items()]
    shown[NAMES] = [_labels(ax, curves, marked, named, labels, on)]
    framed(ax, axis_label(diagram.parameter_name), axis_label(diagram.x_name))
    return shown


def bounded(x: FloatArray) -> FloatArray:
    """The values that axes show: towards infinity, those up to a quartile."""
    finite = x[np.isfinite(x)] if np.isfinite(x).any() else [0.0]
    low, high = np.quantile(finite, (0.25, 0.75))  # of 1/p, up to 4 times the least value
    return np.clip(x, low if -np.inf in x else -np.inf, high if np.inf in x else np.inf)


def _labels(
    ax: Axes, curves: Sequence[StyledCurve], marked: Sequence[SpecialPoint],
    named: Sequence[SpecialPoint], labels: bool | None, on: Sequence[tuple[str, Branch]],
) -> Labels:  # fmt: skip
    """Draw names of points, and of branches or, if there are several orders, of iterates."""
    told = [p for p in marked if p.kind is not PointKind.EP or labels]
    if labels is False or (labels is None and len(told) > MOST_LABELS):
        told = []
    written = {p.id: p for p in (*named, *told)} if labels is not False else {}
    iterated = any(curve.order > 1 for curve in curves) and not on
    names = [
        Name(p.name or p.id, float(p.parameter), float(p.x), bool(p.name or labels))
        for p in written.values()
    ]
    lines = [LabelledCurve(text, b.parameter, b.x, INK, 0.0) for text, b in on]
    texts = [f"$P_{{{c.order}}}$" if iterated else "" for c in curves]
    lines += [LabelledCurve(text, c.p, c.x, INK) for text, c in zip(texts, curves, strict=True)]
    found = Labels(names, lines, [(float(p.parameter), float(p.x)) for p in marked])
    ax.add_artist(found)
    return found


STYLES: dict[str, dict[str, Any]] = {
    "stable": {"linestyle": "-", "linewidth": 1.6},
    "unstable": {"linestyle": (0, (4, 1.5)), "linewidth": 1.2},
    "jump crossing": {"linestyle": (0, (1, 1.3)), "linewidth": 1.4},
}


def _word_changes(diagram: Diagram) -> tuple[list[float], list[float]]:
    p, x = list[float](), list[float]()
    for branch in diagram.branches:
        firsts = [stretch.first for stretch in branch.changes]
        p += branch.parameter[firsts].tolist()
        x += branch.x[firsts].tolist()
    return p, x


def _curves(diagram: Diagram) -> list[StyledCurve]:
    """Lines to draw, each in one style; branches of one style and order that meet are joined."""
    curves: list[StyledCurve] = []
    for branch in diagram.branches:
        parts = stretches(branch) if branch.kind is not BranchKind.BAND else []
        for k, (label, stretch) in enumerate(parts):
            first, last = branch.ends
            ends = (
                first if k == 0 else f"{branch.id}:{k}",
                last if k == len(parts) - 1 else f"{branch.id}:{k + 1}",
            )  # fmt: skip
            p, x = branch.parameter[stretch], branch.x[stretch]
            new = StyledCurve(label, branch.order, ends, p, x)
            # a dash pattern restarts with each line, so that short branches would look solid
            for known in [c for c in curves if c[:2] == new[:2] and set(c.ends) & set(ends)]:
                curves.remove(known)
                new = known.joined(new)
            curves.append(new)
    return curves


class StyledCurve(NamedTuple):
    """A line of one style, in the colour of its period, between two ends that may have names."""

    label: str
    order: int
    ends: tuple[str, str]  # names, empty where there is none
    p: FloatArray
    x: FloatArray

    @property
    def look(self) -> dict[str, Any]:
        """The properties of its line in matplotlib."""
        return STYLES[self.label] | {"color": of_period(self.order)}

    def turned(self) -> StyledCurve:
        """The same curve in the opposite direction."""
        return self._replace(ends=self.ends[::-1], p=self.p[::-1], x=self.x[::-1])

    def joined(self, other: StyledCurve) -> StyledCurve:
        """Both as one line; they must have an end in common."""
        first = self if self.ends[1] in other.ends else self.turned()
        second = other if other.ends[0] == first.ends[1] else other.turned()
        p, x = np.append(first.p, second.p), np.append(first.x, second.x)
        return self._replace(ends=(first.ends[0], second.ends[1]), p=p, x=x)


def stretches(branch: Branch) -> list[tuple[str, slice]]:
    """Parts of a branch with one line style; neighbours share their common point."""
    if branch.kind is BranchKind.JUMP:
        return [("jump crossing", slice(0, len(branch)))]
    stable = stable_inside(branch)
    cuts = np.flatnonzero(stable[1:] != stable[:-1]) + 1
    edges = [0, *cuts.tolist(), len(branch)]
    return [
        ("stable" if stable[a] else "unstable", slice(max(0, a - 1), b)) for a, b in pairwise(edges)
    ]


def axis_label(name: str) -> str:
    """The label of an axis for a parameter or coordinate, with its unit where that is known."""
    known = {
        "phi_s": r"$\varphi_S$ [rad]",
        "eps_n1": r"$\varepsilon_{N1}$",
        "eps_n2": r"$\varepsilon_{N2}$",
        "eps_n3": r"$\varepsilon_{N3}$",
        "c_phi": r"$c_\varphi$ [N m/rad]",
        "g": r"$g$ [m/s$^2$]",
    }
    latex = sympy.latex(sympy.Symbol(name)).replace(
        " ", r"\ "
    )  # of a name with several underscores
    return known.get(name, f"${latex}$" if name.isidentifier() else name)


# --- Maps -----------------------------------------------------------------------------------------


@explained()
def plot_map(
    map_: PiecewiseLinearMap,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:
    """Draw the graph of a map or an iterate with the diagonal, fixed points and jump crossings.

    At a jump, a filled end of a piece belongs to it, a hollow one does not. Jumps that cross the
    diagonal are dotted; fixed points are filled if they are stable.

    Parameters
    ----------
    map_, window
        A map without parameters, and an interval of x; by default around breaks and fixed points.
    ax, legend, styles
        As for :func:`plot_diagram`; more names are ``"diagonal"``, ``"pieces"`` and ``"ends"``.

    Returns
    -------
    Drawn
        The axes, and the artists by these names.

    Raises
    ------
    TypeError, ValueError
        As for :func:`plot_diagram`; ValueError also if the map still has parameters.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.plot import plot_map
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> list(plot_map(lines.at({"p": "1/2"})).artists)
    ['diagonal', 'pieces', 'ends', 'jump crossing']
    """
    check_values(map_)
    ax = axes_for(ax, 4.6, 4.4)
    low, high = _window(map_) if window is None else checked_pair("window", window)
    if not -math.inf < low < high < math.inf:
        raise ValueError(
            f"a window must ascend between finite ends, got ({low}, {high}): give one (window=...) "
            "where numbers do not fit into doubles"
        )
    shown: Artists = {name: [] for name in WITHOUT_LEGEND}
    shown["diagonal"] = [*ax.plot([low, high], [low, high], color=GREY, linewidth=0.8, zorder=1)]
    within, marked = pieces_within(map_, (low, high))
    for piece in within:
        shown["pieces"] += ax.plot(*zip(*piece, strict=True), color=INK, linewidth=1.5,
                                   solid_capstyle="butt")  # fmt: skip
    for x, y, closed in marked:
        face = INK if closed else "white"
        shown["ends"] += ax.plot(x, y, "o", markersize=3.4, mfc=face, mec=INK, mew=0.9, zorder=4)
    for band in map_.fixed_intervals():
        ends = np.clip([float(band.interval.inf), float(band.interval.sup)], low, high)
        add(shown, {FIXED_BAND: ax.plot(ends, ends, **NEUTRAL, zorder=1.5)})
    for crossing in map_.jump_crossings():
        x, limits = float(crossing.x), (float(crossing.left), float(crossing.right))
        line = ax.plot([x, x], limits, color=JUMP, linestyle=(0, (1, 1.3)), linewidth=1.6)
        ring = ax.plot(x, x, "o", markersize=6.5, mfc="none", mec=JUMP, mew=1.3, zorder=6)
        add(shown, {"jump crossing": [*line, *ring]})
    for point in map_.fixed_points():
        name, color = ("stable", STABLE) if point.stable else ("unstable", UNSTABLE)
        x = float(point.x)
        face = color if point.stable else "white"
        marker = ax.plot(
            x, x, "o", markersize=6.5, mfc=face, mec=color, mew=1.5, zorder=6, linestyle="none"
        )
        add(shown, {f"{name} fixed point": marker})
    ax.set_xlim(low, high)
    x_name = sympy.latex(map_.x)
    framed(ax, f"${x_name}$", f"$P_{{{map_.order}}}({x_name})$")
    return _styled(ax, shown, styles, legend)


def _styled(ax: Axes, shown: Artists, styles: Styles | None, legend: bool = True) -> Drawn:
    """Finish the picture of a map: apply styles, draw a legend."""
    points = "jump crossing", "stable fixed point", "unstable fixed point"
    styled(shown, styles, (*points, FIXED_BAND))
    explained = {name: each for name, each in shown.items() if name not in WITHOUT_LEGEND}
    place_legend(ax, explained, legend, _ENDS if shown["ends"] else None)
    return Drawn((ax,), shown)


_ENDS = {
    text: Line2D([], [], color=INK, ls="", marker="o", markersize=3.4, mfc=face, mew=0.9)
    for face, text in ((INK, "included end"), ("white", "excluded end"))
}
WITHOUT_LEGEND = ("diagonal", "pieces", "ends")  # parts of a map's picture that need no legend


def _window(map_: PiecewiseLinearMap) -> tuple[float, float]:
    """An interval around breaks, limits at breaks and fixed points, with a margin."""
    marks = [float(p.x) for p in map_.fixed_points()]
    for jump in map_.jumps():
        marks += [float(v) for v in (jump.x, jump.left, jump.value, jump.right)]
    marks += [float(piece.lower) for piece in map_.pieces[1:]]
    return around(marks)


def around(marks: Sequence[float]) -> tuple[float, float]:
    """The ends of an interval that contains some numbers, with a margin."""
    low, high = min(marks, default=-1.0), max(marks, default=1.0)
    margin = 0.2 * (high - low) or 1.0
    return low - margin, high + margin


def pieces_within(
    map_: PiecewiseLinearMap, window: tuple[float, float]
) -> tuple[list[tuple[tuple[float, float], ...]], list[tuple[float, float, bool]]]:
    """Lines of a map by their ends (x, y), and those at jumps, with whether the pieces own them."""
    lines, ends, jumps = [], [], {float(jump.x) for jump in map_.jumps()}
    for piece in map_.pieces:
        outer = float(piece.lower), float(piece.upper)
        left, right = max(window[0], outer[0]), min(window[1], outer[1])
        if left > right:
            continue
        places = (
            end if x == at else sympy.Rational(x)
            for end, at, x in zip((piece.lower, piece.upper), outer, (left, right), strict=True)
        )  # exact, as steep pieces lose all digits in doubles
        line = tuple((float(x), float(piece.slope * x + piece.intercept)) for x in places)
        lines.append(line)
        belongs = piece.lower_closed, piece.upper_closed
        ends += [(*place, closed) for place, end, closed in zip(line, outer, belongs, strict=True)
                 if place[0] == end in jumps]  # fmt: skip
    return lines, ends


@explained()
def plot_cobweb(
    map_: PiecewiseLinearMap,
    start: object,
    steps: int,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    styles: Styles | None = None,
) -> Drawn:
    """Draw a map with the cobweb of an orbit, which is followed exactly.

    Parameters
    ----------
    map_, start, steps
        A map without parameters, a rational start, and the number of steps, at least 1.
    ax, window, styles
        As for :func:`plot_map`, errors included; more names are ``"orbit"`` and ``"start"``, and by
        default the window contains the orbit.

    Returns
    -------
    Drawn
        The axes, and the artists by these names.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap
    >>> from pwmap.plot import plot_cobweb
    >>> lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    >>> (orbit,) = plot_cobweb(lines.at({"p": "1/2"}), "1/3", 2).artists["orbit"]
    >>> [round(float(x), 3) for x in orbit.get_xdata()]
    [0.333, 0.333, -0.389, -0.389, 0.306]
    """
    steps = checked_count(steps, "steps", MOST_COLUMNS)
    check_values(map_)
    orbit = [QQ.to_sympy(rational(start))]
    for _ in range(steps):
        orbit.append(map_(orbit[-1]))
    values = [float(x) for x in orbit]
    if window is None:
        low, high = _window(map_)
        edge = 0.05 * (max(values) - min(values))
        window = min(low, min(values) - edge), max(high, max(values) + edge)
    drawn = plot_map(map_, ax, window=window)
    ax = drawn.ax
    shown: Artists = {name: [*artists] for name, artists in drawn.artists.items()}
    line = ax.plot(*stairs(values), color=VIOLET, linewidth=0.9, zorder=3)
    start = ax.plot(values[0], values[0], "s", markersize=4, color=VIOLET, zorder=7)
    add(shown, {"orbit": line, "start": start})
    return _styled(ax, shown, styles)
