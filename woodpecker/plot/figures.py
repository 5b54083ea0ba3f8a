"""Pictures of trajectories and return maps [Leine2001, Figs. 4-6, 8]."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from pwmap.diagrams.diagram import BranchKind, Diagram
from pwmap.plot import JUMP, MARKERS, STABLE, UNSTABLE, plot_diagram
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.toy import Toy
from woodpecker.piecewise.local import LocalModel
from woodpecker.plot.curve import Curve, Link, refined
from woodpecker.simulation.returns import ReturnMap, return_map
from woodpecker.simulation.trajectory import Trajectory
from woodpecker.simulation.words import EventKind

LINE: dict[str, Any] = {"color": STABLE, "linewidth": 1.1}
BOUND: dict[str, Any] = {"color": "#969696", "linewidth": 0.8, "linestyle": (0, (5, 3))}
_Axes = Sequence[Axes]


class Quantity(NamedTuple):
    """A coordinate or velocity as it is drawn."""

    label: str
    velocity: bool
    column: int  # of q or u
    scale: float  # drawn value over SI value

    def of(self, q: Floats, u: Floats) -> Floats:
        """Its values, from coordinates and velocities of shape (..., 3)."""
        values: Floats = self.scale * (u if self.velocity else q)[..., self.column]
        return values


QUANTITIES = {
    "y": Quantity(r"$y$ [mm]", False, 0, 1e3),
    "phi_m": Quantity(r"$\varphi_M$ [rad]", False, 1, 1.0),
    "phi_s": Quantity(r"$\varphi_S$ [rad]", False, 2, 1.0),
    "dy": Quantity(r"$\dot y$ [mm/s]", True, 0, 1e3),
    "dphi_m": Quantity(r"$\dot\varphi_M$ [rad/s]", True, 1, 1.0),
    "dphi_s": Quantity(r"$\dot\varphi_S$ [rad/s]", True, 2, 1.0),
}


def plot_time_history(trajectory: Trajectory, axes: _Axes | None = None) -> _Axes:
    """Coordinates over time on three axes, impacts as ticks [Leine2001, Fig. 4]."""
    if axes is None:
        figure = plt.figure(figsize=(7.0, 5.6), layout="constrained")
        axes = list(figure.subplots(3, 1, sharex=True))
    toy = trajectory.toy
    bounds: tuple[tuple[float, ...], ...] = (
        (), (-toy.phi_m_max, toy.phi_m_max), (toy.phi_s_max,),
    )  # fmt: skip
    impacts = [
        event.time
        for event in trajectory.events
        if event.kind in (EventKind.IMPACT, EventKind.INDETERMINATE_IMPACT)
    ]
    for ax, name, limits in zip(axes, ("y", "phi_m", "phi_s"), bounds, strict=True):
        drawn = QUANTITIES[name]
        ax.plot(trajectory.t, drawn.of(trajectory.q, trajectory.u), **LINE)
        for limit in limits:
            ax.axhline(limit, **BOUND)
        low = ax.get_ylim()[0]
        ax.plot(impacts, np.full(len(impacts), low), "|", color=UNSTABLE, markersize=9)
        ax.set_ylim(bottom=low)
        ax.set_ylabel(drawn.label)
        ax.grid(alpha=0.25, linewidth=0.5)
    axes[-1].set_xlabel("$t$ [s]; ticks mark impacts")
    axes[-1].set_xlim(0.0, trajectory.t_end)
    return axes


def plot_phase_portrait(trajectory: Trajectory, x: str, y: str, ax: Axes | None = None) -> Axes:
    """One quantity over another, such as ``"dphi_s"`` over ``"phi_s"``; see :data:`QUANTITIES`.

    Impacts, where the velocities jump, are dotted [Leine2001, Figs. 5 and 6].

    Raises
    ------
    ValueError
        If there is no such quantity.
    """
    for name in (x, y):
        if name not in QUANTITIES:
            raise ValueError(f"unknown quantity {name!r}, expected one of {', '.join(QUANTITIES)}")
    ax = ax if ax is not None else plt.figure(figsize=(4.6, 3.6), layout="constrained").gca()
    across, up = (QUANTITIES[name].of(trajectory.q, trajectory.u) for name in (x, y))
    jumps = np.flatnonzero(np.diff(trajectory.t) == 0.0)
    ax.plot(np.insert(across, jumps + 1, np.nan), np.insert(up, jumps + 1, np.nan), **LINE)
    pairs = jumps[:, None] + [0, 1]
    struck = _strokes(across[pairs], up[pairs])
    ax.plot(*struck, color=JUMP, linewidth=1.1, linestyle=(0, (1, 1.3)))
    ax.set_xlabel(QUANTITIES[x].label)
    ax.set_ylabel(QUANTITIES[y].label)
    ax.grid(alpha=0.25, linewidth=0.5)
    return ax


def plot_phase_portraits(trajectory: Trajectory, axes: _Axes | None = None) -> _Axes:
    """The bird's, the sleeve's and the fall's phase portrait on three axes."""
    if axes is None:
        figure = plt.figure(figsize=(9.6, 3.4), layout="constrained")
        axes = list(figure.subplots(1, 3))
    pairs = (("phi_s", "dphi_s"), ("phi_m", "dphi_m"), ("phi_s", "dy"))
    for ax, (x, y) in zip(axes, pairs, strict=True):
        plot_phase_portrait(trajectory, x, y, ax)
    return axes


def plot_return_map(
    toy: Toy,
    returns: ReturnMap,
    ax: Axes | None = None,
    *,
    order: int = 1,
    depth: float | None = None,
) -> Axes:
    """P_order over phi_S with the diagonal, its jumps dotted [Leine2001, Fig. 8].

    Parameters
    ----------
    toy
        The toy, to look closer where neighbouring samples lie far apart.
    returns
        Map at ascending starts, from :func:`woodpecker.return_map`.
    order
        The order of ``returns``.
    depth
        Lower end of the vertical axis; the dips have no bottom. By default the map's left end, or
        its least value if all lie higher.
    """
    *_, curve = curves(toy, returns, order, depth)
    return plot_curve(curve, ax, order=order)


def curves(
    toy: Toy, returns: ReturnMap, order: int = 1, depth: float | None = None
) -> Iterator[Curve]:
    """P_order as :func:`plot_curve` draws it, better and better (:mod:`woodpecker.plot.curve`)."""
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


def plot_curve(curve: Curve, ax: Axes | None = None, *, order: int = 1) -> Axes:
    """P_order with the diagonal; jumps are dotted, and what was not resolved is pale."""
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 4.6), layout="constrained").gca()
    ends = curve.x[[0, -1]]
    ax.plot(ends, ends, color="#969696", linewidth=0.8, label="diagonal")
    breaks = np.flatnonzero(curve.links != Link.CURVE) + 1
    x, y = (np.insert(column, breaks, np.nan) for column in (curve.x, curve.y))
    ax.plot(x, y, label=rf"$P_{{{order}}}$", **LINE)
    for link, style in STEEP.items():
        pairs = curve.between(link)[:, None] + [0, 1]
        if pairs.size:
            ax.plot(*_strokes(curve.x[pairs], curve.y[pairs]), **style)
    ax.set_xlim(*ends)
    ax.set_ylim(*_heights(curve))
    ax.set_xlabel(r"$\varphi_{S,k}$ [rad]")
    ax.set_ylabel(rf"$\varphi_{{S,k+{order}}}$ [rad]")
    ax.grid(alpha=0.25, linewidth=0.5)
    ax.legend(fontsize=8, frameon=True, framealpha=0.9)
    return ax


STEEP: dict[Link, dict[str, Any]] = {
    Link.OPEN: {"color": "#9ecae1", "linewidth": 0.8, "label": "not resolved", "zorder": 1.5},
    Link.JUMP: {"color": JUMP, "linewidth": 1.4, "linestyle": (0, (1, 1.3)), "label": "jump"},
}


def _heights(curve: Curve) -> tuple[float, float]:
    """Limits of the vertical axis, with a margin where the curve is not cut off."""
    values = curve.y[np.isfinite(curve.y)]
    low, high = float(values.min(initial=math.inf)), float(values.max(initial=curve.bottom))
    margin = 0.3 * MARGIN * (high - curve.bottom) or NARROWEST
    return curve.bottom - (margin if low >= curve.bottom else 0.0), high + margin


def _strokes(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Lines (n, 2), each between two points, as one line with gaps."""
    gap = np.full((len(x), 1), np.nan)
    return np.hstack([x, gap]).ravel(), np.hstack([y, gap]).ravel()


def plot_local(
    model: LocalModel,
    diagram: Diagram,
    figure: Figure | SubFigure | None = None,
    *,
    reach: float = 2e-3,
) -> Figure | SubFigure:
    """A diagram next to a border collision, beside what its local model predicts.

    Both panels have the same axes. The predicted lines of those iterates that the diagram holds are
    also drawn behind it, in grey.

    Parameters
    ----------
    model
        From :func:`woodpecker.local_model`.
    diagram
        A diagram that holds the collision [Leine2001, Figs. 11, 12].
    figure
        Where to draw; a new one by default.
    reach
        How far the parameter goes from the collision.
    """
    figure = figure if figure is not None else plt.figure(figsize=(7.6, 3.6), layout="constrained")
    seen, predicted = figure.subplots(1, 2, sharex=True, sharey=True)
    near = diagram.within(model.p - 2.0 * reach, model.p + 2.0 * reach)
    plot_diagram(near, seen, kinds=(model.point.kind,), legend=False)
    lines = _predictions(model, reach)
    orders = {branch.order for branch in near.branches}
    for line in lines:
        if line.order in orders:
            seen.plot(line.p, line.x, color="#d9d9d9", linewidth=4.0, zorder=0.9)
        predicted.plot(line.p, line.x, **BRANCH[line.style])
    marker, color = MARKERS[model.point.kind]
    star = predicted.scatter(
        [model.p], [model.x], s=70 if marker == "*" else 26, marker=marker, color=color,
        edgecolors="white", linewidths=0.6, zorder=5, label=model.point.kind.label,
    )  # fmt: skip
    _frame(seen, model, lines)
    _name_lines(predicted, lines)
    seen.set_title("the toy, with the prediction in grey", fontsize=9)
    predicted.set_title("its local model, solved exactly", fontsize=9)
    predicted.set_xlabel(seen.get_xlabel())
    predicted.grid(alpha=0.25, linewidth=0.5)
    predicted.legend(
        handles=[
            *(
                Line2D([], [], label=name, **BRANCH[name])
                for name in BRANCH
                if name in {line.style for line in lines}
            ),
            star,
        ],
        fontsize=7, framealpha=0.9,
    )  # fmt: skip
    return figure


MARGIN = 0.12  # of the width and height of what is drawn
APART = 9.0  # points between names at the ends of lines, a little more than their height
NARROWEST = 0.02  # what is drawn around something without width or height
BRANCH: dict[str, dict[str, Any]] = {
    "stable": {"color": STABLE, "linestyle": "-", "linewidth": 1.6},
    "unstable": {"color": UNSTABLE, "linestyle": (0, (4, 1.5)), "linewidth": 1.2},
    "jump crossing": {"color": JUMP, "linestyle": (0, (1, 1.3)), "linewidth": 1.4},
}


class _Prediction(NamedTuple):
    """A straight line from a collision, as it is drawn."""

    order: int
    style: str
    p: tuple[float, float]
    x: tuple[float, float]


def _predictions(model: LocalModel, reach: float) -> list[_Prediction]:
    """All branches that start at a collision, as far as they are drawn."""
    p, x = model.p, model.x
    slopes = {"L": model.left.slope, "R": model.right.slope}
    lines = []
    for start in model.starts:
        multiplier = math.prod(slopes[letter] for letter in start.word.split("|")[0])
        style = (
            "jump crossing"
            if start.kind is BranchKind.JUMP
            else "stable"
            if abs(multiplier) < 1.0
            else "unstable"
        )
        end = p + start.side * reach, x + start.side * start.slope * reach
        lines.append(_Prediction(start.order, style, (p, end[0]), (x, end[1])))
    return lines


def _name_lines(ax: Axes, lines: Sequence[_Prediction]) -> None:
    """Names of iterates beside the ends of lines, moved apart where these lie close."""
    low, high = ax.get_ylim()
    height = 72.0 * ax.bbox.height / ax.figure.dpi  # points
    for side in (-1, 1):
        beside = [line for line in lines if (line.p[1] - line.p[0]) * side > 0.0]
        beside.sort(key=lambda line: line.x[1])
        at = np.array([(line.x[1] - low) / (high - low) * height for line in beside])
        for line, up in zip(beside, (spread(at, APART) - at).tolist(), strict=True):
            ax.annotate(
                f"$P_{line.order}$", (line.p[1], line.x[1]), (4 * side, up),
                textcoords="offset points", ha="right" if side < 0 else "left", va="center",
                fontsize=8, color=BRANCH[line.style]["color"],
            )  # fmt: skip


def spread(at: Floats, apart: float) -> Floats:
    """Ascending places (n,), moved by as little as can be until neighbours are so far apart.

    In the mean of squares: those that would overlap are moved together, about their mean.
    """
    groups: list[list[float]] = []
    for value in (at - apart * np.arange(len(at))).tolist():
        groups.append([value])
        while len(groups) > 1 and np.mean(groups[-2]) > np.mean(groups[-1]):
            groups[-2:] = [[*groups[-2], *groups[-1]]]
    means = [float(np.mean(group)) for group in groups for _ in group]
    moved: Floats = np.array(means) + apart * np.arange(len(at))
    return moved


def _frame(ax: Axes, model: LocalModel, lines: Sequence[_Prediction]) -> None:
    """Limits around what is predicted, with a margin for the names."""
    for values, set_limits in (
        ([model.p, *(line.p[1] for line in lines)], ax.set_xlim),
        ([model.x, *(line.x[1] for line in lines)], ax.set_ylim),
    ):
        margin = MARGIN * (max(values) - min(values)) or NARROWEST
        set_limits(min(values) - margin, max(values) + margin)
    ax.ticklabel_format(useOffset=False)
    ax.locator_params(axis="x", nbins=4)
