"""Pictures of return maps, and of local models at border collisions [Leine2001, Figs. 8, 12]."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from pwmap.diagrams.diagram import BranchKind, Diagram, runs_of
from pwmap.plot import INK, JUMP, MARKERS, STABLE, STAR, UNSTABLE, place_legend, plot_diagram
from pwmap.plot.diagrams import STYLES, StyledCurve
from pwmap.plot.drawn import (
    Artists,
    Drawn,
    Styles,
    add,
    axes_for,
    figure_of,
    framed,
    sized,
    strokes,
    styled,
)
from pwmap.plot.palette import of_period
from woodpecker.base.arrays import Bools, Floats, Ints
from woodpecker.base.checks import instance
from woodpecker.mechanics.toy import Toy
from woodpecker.plot.curve import Link, MapSamples, refined
from woodpecker.plot.motions import LINE
from woodpecker.simulation.returns import ReturnMap, return_map
from woodpecker.simulation.status import Status
from woodpecker.slices.local import LocalModel


def plot_return_map(
    toy: Toy,
    returns: ReturnMap,
    ax: Axes | None = None,
    *,
    order: int = 1,
    depth: float | None = None,
    legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:
    """Draw P_order over phi_S with the diagonal; jumps are dotted [Leine2001, Fig. 8].

    Parameters
    ----------
    toy, returns, order
        The toy, its return map at ascending starts from :func:`woodpecker.return_map`, and the
        order of that; more starts are added where neighbouring values lie far apart.
    depth
        Lower end of the vertical axis, since dips are infinitely deep. By default the first start,
        or the least value if that is higher.
    ax, legend, styles
        As for :func:`plot_curve`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, starts do not ascend, or returns are of another order.

    Examples
    --------
    >>> import numpy as np
    >>> from woodpecker import Toy, return_map
    >>> from woodpecker.plot.figures import plot_return_map
    >>> toy = Toy()
    >>> drawn = plot_return_map(toy, return_map(toy, np.linspace(-0.6, -0.45, 50)))
    >>> list(drawn.artists)
    ['diagonal', '$P_{1}$', 'jump', 'stable fixed point', 'goes on below']
    """
    instance("toy", toy, Toy)
    instance("returns", returns, ReturnMap)
    *_, curve = curves(toy, returns, order, depth)
    return plot_curve(curve, ax, order=order, returns=returns, legend=legend, styles=styles)


def curves(
    toy: Toy, returns: ReturnMap, order: int = 1, depth: float | None = None
) -> Iterator[MapSamples]:
    """Yield finer and finer samples of P_order for :func:`plot_curve`; see :func:`refined`."""
    if len(returns) < 2 or not (np.diff(returns.start) > 0.0).all():
        raise ValueError(f"returns must have two or more ascending starts, got {returns!r}")
    for word, reason in zip(returns.words, returns.status, strict=True):
        if reason.success and (returned := word.count("|") + 1) != order:
            raise ValueError(f"returns must be of order {order}, got some of order {returned}")
    if depth is None:
        values = returns.phi_s[np.isfinite(returns.phi_s)]
        depth = max(returns.start[0], values.min(initial=returns.start[-1]))
    return refined(
        lambda x: return_map(toy, x, order).phi_s,
        returns.start,
        returns.phi_s,
        bottom=float(depth),
        cost=order,
    )


def plot_curve(
    curve: MapSamples,
    ax: Axes | None = None,
    *,
    order: int = 1,
    returns: ReturnMap | None = None,
    legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:
    """Draw P_order with the diagonal; jumps are dotted, and unresolved intervals are pale.

    Fixed points are marked, filled if they attract, and so are jumps across the diagonal. Starts
    without a return are hatched; triangles show where the map continues below the picture.

    Parameters
    ----------
    curve, order
        Samples from :func:`curves`, and the order of the map.
    ax
        Axes to draw on; new ones by default.
    returns
        The return map whose starts without a return are hatched; by default none are.
    legend, styles
        Whether to have a legend; properties of matplotlib by the names in it.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or a style has an unknown name.

    Examples
    --------
    >>> import numpy as np
    >>> from woodpecker import Toy, return_map
    >>> from woodpecker.plot.figures import curves, plot_curve
    >>> toy = Toy()
    >>> first = next(curves(toy, return_map(toy, np.linspace(-0.6, -0.5, 20))))
    >>> list(plot_curve(first).artists)
    ['diagonal', '$P_{1}$', 'not resolved']
    """
    instance("curve", curve, MapSamples)
    ax = axes_for(ax, 7.0, 4.6)
    ends = curve.x[[0, -1]]
    shown: Artists = {"diagonal": [*ax.plot(ends, ends, color="#969696", linewidth=0.8)]}
    shown[rf"$P_{{{order}}}$"] = [*ax.plot(*curve.line(), **LINE)]
    crosses = curve.crosses
    jumps = curve.links == Link.JUMP
    links = {
        "not resolved": curve.links == Link.OPEN,
        "jump": jumps & ~crosses,
        "jump crossing": jumps & crosses,
    }
    for name, flags in links.items():
        pairs = np.flatnonzero(flags)[:, None] + [0, 1]
        if pairs.size:
            line = ax.plot(*strokes(curve.x[pairs], curve.y[pairs]), **LINK_STYLES[name])
            add(shown, {name: line})
    add(shown, _fixed(ax, curve, crosses) | _at_rest(ax, curve))
    ax.set_xlim(*ends)
    ax.set_ylim(*_heights(curve))
    if returns is not None:
        add(shown, _lost(ax, returns))
    add(shown, _below(ax, curve))
    framed(ax, r"$\varphi_{S,k}$ [rad]", rf"$\varphi_{{S,k+{order}}}$ [rad]")
    known = (*LINK_STYLES, *FIXED.values(), REST, FALLS, LOST, BELOW)
    styled(shown, styles, known)
    place_legend(ax, shown, legend)
    return Drawn((ax,), shown)


FALLS, LOST, BELOW = "free fall", "no return", "goes on below"
FALLEN = (Status.FREE_FALL, Status.POLE_END)
NEAR = 0.008  # smallest distance of triangles at the lower edge, as a part of the width


def _lost(ax: Axes, returns: ReturnMap) -> Artists:
    """Hatch the intervals of starts without a return, those in free fall differently."""
    fallen = np.array([reason in FALLEN for reason in returns.status], dtype=bool)
    gone = ~np.array([reason.success for reason in returns.status], dtype=bool) & ~fallen
    shown: Artists = {}
    for name, flags, hatch in ((FALLS, fallen, "////"), (LOST, gone, "xxxx")):
        for first, last in runs_of(flags):
            area = ax.axvspan(
                returns.start[first], returns.start[last], facecolor="#f0f0f0", hatch=hatch,
                edgecolor="#969696", linewidth=0.5 if first == last else 0.0, zorder=0.4,
            )  # fmt: skip
            add(shown, {name: [area]})
    return shown


def _below(ax: Axes, curve: MapSamples) -> Artists:
    """Mark with triangles where the map leaves the picture at the bottom, or ends on a flank."""
    with np.errstate(invalid="ignore"):
        under = curve.y < ax.get_ylim()[0]
    places, least = list[float](), NEAR * float(np.ptp(curve.x))
    for first, last in runs_of(under):
        ends = [curve.x[k] for k in (first, last) if 0 < k < len(curve.x) - 1]
        if len(ends) == 2 and ends[1] - ends[0] <= least:
            ends = [0.5 * (ends[0] + ends[1])]
        places += [float(x) for x in ends if not places or x - places[-1] > least]
    style: dict[str, Any] = {"color": STABLE, "markersize": 4.5, "mec": "white", "mew": 0.4,
                             "zorder": 5, "linestyle": "none", "marker": "v"}  # fmt: skip
    marks: list[Artist] = []
    if places:
        low = np.full(len(places), 0.015)
        marks += ax.plot(places, low, transform=ax.get_xaxis_transform(), **style)
    flanks = _flanks(curve, ax.get_ylim()[0])
    if flanks.size:
        marks += ax.plot(curve.x[flanks], curve.y[flanks], **style)
    return {BELOW: marks} if marks else {}


def _flanks(curve: MapSamples, low: float) -> Ints:
    """Indices of samples in the picture from which the map falls steeply into a gap."""
    found = list[int]()
    lost = np.isnan(curve.y)
    for k in np.flatnonzero(~lost & (curve.y > low)).tolist():
        for beside, before in ((k + 1, k - 1), (k - 1, k + 1)):
            if min(beside, before) >= 0 and max(beside, before) < len(lost) and lost[beside]:
                fall = (curve.y[before] - curve.y[k]) / abs(curve.x[before] - curve.x[k])
                if fall > STEEPEST:
                    found.append(k)
    return np.array(found, dtype=np.int64)


LINK_STYLES: dict[str, dict[str, Any]] = {
    "not resolved": {"color": "#9ecae1", "linewidth": 0.8, "zorder": 1.5},
    "jump": {"color": "#969696", "linewidth": 1.0, "linestyle": (0, (1, 1.3))},
    "jump crossing": {"color": JUMP, "linewidth": 1.6, "linestyle": (0, (1, 1.3))},
}
FIXED = {True: "stable fixed point", False: "unstable fixed point"}
REST, ON = "all are fixed points", 1e-10  # ON: distance from the diagonal, part of the width


def _fixed(ax: Axes, curve: MapSamples, crosses: Bools) -> Artists:
    """Mark fixed points on continuous links; they are filled if they attract."""
    shown: Artists = {}
    places, slope = curve.fixed(crosses)
    for stable, name in FIXED.items():
        own = places[(np.abs(slope) < 1.0) == stable]
        if own.size:
            color = STABLE if stable else UNSTABLE
            add(shown, {name: ax.plot(
                own, own, "o", color=color, markersize=5, mfc=color if stable else "white",
                linestyle="none", zorder=5,
            )})  # fmt: skip
    return shown


def _at_rest(ax: Axes, curve: MapSamples) -> Artists:
    """Mark intervals of fixed points, where the toy stays jammed and the bird only swings."""
    with np.errstate(invalid="ignore"):
        on = np.abs(curve.y - curve.x) <= ON * float(np.ptp(curve.x))
    shown: Artists = {}
    for first, last in runs_of(on):
        if last - first > 1:
            ends = curve.x[[first, last]]
            line = ax.plot(ends, ends, color=STABLE, linewidth=4.5, alpha=0.35, zorder=1.8)
            add(shown, {REST: line})
    return shown


STEEPEST = 100.0  # slope beyond which a curve that falls into a gap is taken to continue below
CUT = 0.02  # part of the height: if the curve reaches less far below the picture, it is shown whole


def _heights(curve: MapSamples) -> tuple[float, float]:
    """Limits of the vertical axis, with a margin where the curve is not cut off."""
    values = curve.y[np.isfinite(curve.y)]
    low, high = float(values.min(initial=math.inf)), float(values.max(initial=curve.bottom))
    margin = 0.3 * MARGIN * (high - curve.bottom) or NARROWEST * max(1.0, abs(high))
    if low < curve.bottom - CUT * (high - curve.bottom):
        return curve.bottom, high + margin
    return min(low, curve.bottom) - margin, high + margin


def plot_local(
    model: LocalModel,
    diagram: Diagram,
    figure: Figure | SubFigure | None = None,
    *,
    reach: float | None = None,
    styles: Styles | None = None,
) -> Drawn:
    """Draw a diagram near a border collision beside the prediction of the local model.

    Both panels have the same limits. Predicted lines are also drawn behind the diagram, in grey, if
    it has branches of their order; the lines of other orders are thin and pale.

    Parameters
    ----------
    model, diagram
        From :func:`woodpecker.local_model`, and a diagram that holds the collision [Leine2001,
        Figs. 11, 12].
    figure
        Where to draw; a new one by default.
    reach
        Largest distance of the parameter from the collision; by default a fortieth of the shortest
        branch that starts there, since the model is of first order.
    styles
        Properties of matplotlib by names in the legends, and ``"prediction"`` for the lines behind.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or a style has an unknown name.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> from woodpecker import local_model
    >>> from woodpecker.examples import paper_family
    >>> from woodpecker.plot.figures import plot_local
    >>> model = local_model(paper_family().over(0, (0.0, 1.25)), 0.0, 0.0)
    >>> exact = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")
    >>> drawn = plot_local(model, bifurcation_diagram(exact, "r", (-1, 1), orders=(1, 2)))
    >>> [ax.get_title() for ax in drawn.axes]
    ['the toy, with the prediction in grey', 'its local model, solved exactly']
    """
    instance("model", model, LocalModel)
    instance("diagram", diagram, Diagram)
    figure = figure if figure is not None else figure_of(7.6, 3.6)
    seen, predicted = figure.subplots(1, 2, sharex=True, sharey=True)
    reach = reach if reach is not None else _reach(model, diagram)
    near = diagram.within(model.p - 2.0 * reach, model.p + 2.0 * reach)
    kinds = (model.point.kind,)
    shown: Artists = {"prediction": []}
    add(shown, plot_diagram(near, seen, kinds=kinds, legend=False).artists)
    lines = _predictions(model, reach)
    orders = {branch.order for branch in near.branches}
    for line in lines:
        followed = line.order in orders
        if followed:
            shown["prediction"] += seen.plot(
                line.p, line.x, color="#d9d9d9", linewidth=4.0, zorder=0.9
            )
        style = line.look if followed else OTHER
        add(shown, {line.label if followed else NOT_FOLLOWED:
                    predicted.plot(line.p, line.x, **style)})  # fmt: skip
    marker, color = MARKERS[model.point.kind]
    star = predicted.scatter(
        [model.p], [model.x], s=STAR if marker == "*" else 26, marker=marker, color=color,
        edgecolors="white", linewidths=0.6, zorder=5, label=model.point.kind.label,
    )  # fmt: skip
    add(shown, {model.point.kind.label: [star]})
    styled(shown, styles, (*STYLES, NOT_FOLLOWED))
    _frame(seen, model, lines)
    _name_lines(predicted, lines, orders)
    ink = INK if len(orders) > 1 else of_period(min(orders, default=1))
    seen.set_title("the toy, with the prediction in grey", fontsize=sized(9))
    predicted.set_title("its local model, solved exactly", fontsize=sized(9))
    predicted.set_xlabel(seen.get_xlabel())
    predicted.grid(alpha=0.25, linewidth=0.5)
    kept = {line.label for line in lines if line.order in orders}
    samples = [Line2D([], [], label=n, color=ink, **STYLES[n]) for n in STYLES if n in kept]
    if NOT_FOLLOWED in shown:
        samples.append(Line2D([], [], label=NOT_FOLLOWED, **OTHER))
    predicted.legend(handles=[*samples, star], fontsize=sized(7), framealpha=0.9)
    return Drawn((seen, predicted), shown)


PART = 1.0 / 40.0  # part of the shortest branch that is compared with its prediction
AT = 1e-9  # distance in parameter and x within which a point of the diagram is the model's
FARTHEST = 2e-3  # reach in the parameter if no branch of the diagram starts there


def _reach(model: LocalModel, diagram: Diagram) -> float:
    """Default reach of a local model: a part of the shortest branch that starts at its point."""
    at = {
        point.id for point in diagram.points
        if abs(point.parameter - model.p) < AT and abs(point.x - model.x) < AT
    }  # fmt: skip
    lengths = [float(np.ptp(b.parameter)) for b in diagram.branches if at & set(b.ends)]
    return PART * min((length for length in lengths if length > 0.0), default=FARTHEST / PART)


MARGIN = 0.12  # around the lines, as a part of their width and height
APART = 9.0  # distance of names at the ends of lines [pt], a little more than their height
NARROWEST = 0.02  # margin if the lines have no width or height
NOT_FOLLOWED = "of an order not followed"
NAMED = {"color": "#969696"}
OTHER: dict[str, Any] = {"color": "#bdbdbd", "linestyle": "-", "linewidth": 0.7}


def _predictions(model: LocalModel, reach: float) -> list[StyledCurve]:
    """The predicted branches from the collision, up to a distance ``reach`` in the parameter."""
    p, x = model.p, model.x
    slopes = {"L": model.left.slope, "R": model.right.slope}
    lines = []
    for start in model.starts:
        multiplier = math.prod(slopes[letter] for letter in start.word.split("|")[0])
        style = "stable" if abs(multiplier) < 1.0 else "unstable"
        if start.kind is BranchKind.JUMP:
            style = "jump crossing"
        along = start.side * reach * np.array([0.0, 1.0])
        ends = p + along, x + start.slope * along
        lines.append(StyledCurve(style, start.order, ("", ""), *ends))
    return lines


def _name_lines(ax: Axes, lines: Sequence[StyledCurve], orders: set[int]) -> None:
    """Write names of iterates beside the ends of lines, moved apart where they would overlap."""
    low, high = ax.get_ylim()
    height = 72.0 * ax.bbox.height / ax.figure.dpi  # points
    for side in (-1, 1):
        beside = [line for line in lines if (line.p[1] - line.p[0]) * side > 0.0]
        beside.sort(key=lambda line: line.x[1])
        at = np.array([(line.x[1] - low) / (high - low) * height for line in beside])
        moved = spread(at, APART)
        moved -= max(0.0, float(moved.max(initial=0.0)) + 0.5 * APART - height)  # in the frame
        for line, up in zip(beside, (moved - at).tolist(), strict=True):
            style = line.look if line.order in orders else NAMED
            ax.annotate(
                f"$P_{line.order}$", (line.p[1], line.x[1]), (4 * side, up),
                textcoords="offset points", ha="right" if side < 0 else "left", va="center",
                fontsize=sized(8), color=style["color"],
            )  # fmt: skip


def spread(at: Floats, apart: float) -> Floats:
    """Move ascending values (n,) by least squares until neighbours are at least ``apart``."""
    # at_k - k apart must ascend: isotonic regression, by pooling adjacent violators.
    groups: list[list[float]] = []
    for value in (at - apart * np.arange(len(at))).tolist():
        groups.append([value])
        while len(groups) > 1 and np.mean(groups[-2]) > np.mean(groups[-1]):
            groups[-2:] = [[*groups[-2], *groups[-1]]]
    means = [float(np.mean(group)) for group in groups for _ in group]
    moved: Floats = np.array(means) + apart * np.arange(len(at))
    return moved


def _frame(ax: Axes, model: LocalModel, lines: Sequence[StyledCurve]) -> None:
    """Set limits around the predicted lines, with a margin for the names."""
    for values, set_limits in (
        ([model.p, *(line.p[1] for line in lines)], ax.set_xlim),
        ([model.x, *(line.x[1] for line in lines)], ax.set_ylim),
    ):
        margin = MARGIN * (max(values) - min(values)) or NARROWEST
        set_limits(min(values) - margin, max(values) + margin)
    ax.ticklabel_format(useOffset=False)
    ax.locator_params(axis="x", nbins=3)
