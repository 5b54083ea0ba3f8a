"""Pictures of motions: time histories and phase portraits [Leine2001, Figs. 4-6]."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pwmap.plot import JUMP, STABLE, UNSTABLE
from pwmap.plot.drawn import (
    Artists,
    Drawn,
    Styles,
    add,
    axes_for,
    framed,
    several_axes,
    sized,
    strokes,
    styled,
)
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance
from woodpecker.simulation.trajectory import Trajectory
from woodpecker.simulation.words import IMPACTS

LINE: dict[str, Any] = {"color": STABLE, "linewidth": 1.1}
BOUND: dict[str, Any] = {"color": "#969696", "linewidth": 0.8, "linestyle": (0, (5, 3))}
_Axes = Sequence[Axes]
Style = dict[str, Any]
Marks = dict[str, tuple[Sequence[float], Style]]  # times and style of events, by their name


QUANTITIES = {  # labels of coordinates and velocities, in the units of all tables
    "y": r"$y$ [m]",
    "phi_m": r"$\varphi_M$ [rad]",
    "phi_s": r"$\varphi_S$ [rad]",
    "dy": r"$\dot y$ [m/s]",
    "dphi_m": r"$\dot\varphi_M$ [rad/s]",
    "dphi_s": r"$\dot\varphi_S$ [rad/s]",
}
PORTRAITS = {  # by its name, what a phase portrait has across and up
    "phi_s": ("phi_s", "dphi_s"), "phi_m": ("phi_m", "dphi_m"), "fall": ("phi_s", "dy"),
}  # fmt: skip
STRUCK: dict[tuple[int, ...], tuple[str, dict[str, Any]]] = {  # impacts by their contacts
    (1,): ("impact of the beak", {"color": UNSTABLE, "linestyle": (0, (1, 1.2)), "marker": "o"}),
    (2,): ("impact of the lower edge", {"color": JUMP, "linestyle": (0, (4, 1.5)), "marker": "v"}),
    (3,): (
        "impact of the upper edge",
        {"color": "#6a51a3", "linestyle": (0, (4, 1.2, 1, 1.2)), "marker": "^"},
    ),
    (1, 2): (
        "impact of beak and lower edge",
        {"color": "#cb181d", "linestyle": (0, (1, 1.2)), "marker": "D"},
    ),
    (1, 3): (
        "impact of beak and upper edge",
        {"color": "#cb181d", "linestyle": (0, (3, 1.2)), "marker": "s"},
    ),
}
MOTION, START, DIRECTION, STOPS = "motion", "start", "direction of time", "stops"
KNOWN = (MOTION, START, DIRECTION, STOPS, *(name for name, _ in STRUCK.values()))
LEGEND_COLUMNS = 3  # entries in a row of a legend: more are wider than the axes
LOWEST, ROW = 0.032, 0.042  # first row of marks and distance of rows, parts of the axes' height
ARROWS = (0.1, 0.45, 0.8)  # wanted places of arrows, as parts of the arclength of the motion
HEAD = "-|>,head_length=0.55,head_width=0.2"
SHAFT = 0.01  # arclength from which an arrow takes its direction, as a part of the size
# How far an arrow may move from its place, as a part of the arclength, to keep off impacts; the
# distance from these that is enough, as a part of the size.
ARROW_SHIFT, ARROW_CLEARANCE = 0.08, 0.15


def quantity(name: str, q: Floats, u: Floats) -> Floats:
    """A quantity by its name in QUANTITIES, from coordinates and velocities (..., 3)."""
    values: Floats = np.concatenate([q, u], axis=-1)[..., list(QUANTITIES).index(name)]
    return values


def plot_time_history(
    trajectory: Trajectory, axes: _Axes | None = None, *, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw coordinates over time on three axes, with impacts as marks [Leine2001, Fig. 4].

    Parameters
    ----------
    trajectory
        From :func:`woodpecker.simulate`.
    axes
        Three axes, for y, phi_M and phi_S; new ones by default.
    legend, styles
        Whether to have a legend of impacts and stops (angles at which beak or sleeve touch the
        pole) above the first axes; properties of matplotlib by ``"motion"`` and the names in it.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or a style has an unknown name.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.plot.motions import plot_time_history
    >>> drawn = plot_time_history(simulate(Toy(), -0.52947197, 0.14597607, samples=201))
    >>> len(drawn.axes)
    3
    """
    instance("trajectory", trajectory, Trajectory)
    axes = several_axes(axes, 3, 1, (7.0, 5.6))
    toy = trajectory.toy
    stops: tuple[tuple[float, ...], ...] = (
        (), (-toy.phi_m_max, toy.phi_m_max), (toy.phi_s_max,),
    )  # fmt: skip
    rows = zip(list(QUANTITIES.values())[:3], trajectory.q.T, strict=True)
    shown = draw_histories(axes, trajectory.t, rows, _strikes(trajectory))
    for ax, limits in zip(axes, stops, strict=True):
        add(shown, {STOPS: [ax.axhline(limit, **BOUND) for limit in limits]})
    axes[-1].set_xlabel("$t$ [s]")
    axes[-1].set_xlim(0.0, trajectory.t_end)
    styled(shown, styles, KNOWN)
    if legend:
        legend_above(axes[0], shown, [*(name for name, _ in STRUCK.values()), STOPS])
    return Drawn(tuple(axes), shown)


def draw_histories(
    axes: _Axes, t: Floats, rows: Iterable[tuple[str, Floats]], marks: Marks
) -> Artists:
    """Draw labelled values over time, each with a row of marks below for each kind of event."""
    shown: Artists = {}
    for ax, (label, values) in zip(axes, rows, strict=True):
        add(shown, {MOTION: ax.plot(t, values, **LINE)})
        for row, (name, (times, style)) in enumerate(marks.items()):
            low = np.full(len(times), LOWEST + ROW * row)
            add(shown, {name: ax.plot(
                times, low, style["marker"], color=style["color"], markersize=3.8, mec="white",
                mew=0.4, transform=ax.get_xaxis_transform(), zorder=5,
            )})  # fmt: skip
        ax.margins(y=0.2)
        framed(ax, "", label)
    return shown


def legend_above(ax: Axes, shown: Artists, names: Iterable[str]) -> None:
    """Add a legend above the axes, in the order of ``names``."""
    entries = {name: shown[name][0] for name in names if name in shown}
    if entries:
        ax.legend(
            entries.values(), entries.keys(), fontsize=sized(7), frameon=False,
            ncols=min(len(entries), LEGEND_COLUMNS),
            loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handletextpad=0.4,
        )  # fmt: skip


def _strikes(trajectory: Trajectory) -> Marks:
    """Times and styles of impacts, by the name of the contacts that strike."""
    found: dict[tuple[int, ...], list[float]] = {}
    for event in trajectory.events:
        if event.kind in IMPACTS:
            found.setdefault(tuple(sorted(event.contacts)), []).append(event.time)
    return {STRUCK[each][0]: (found[each], STRUCK[each][1]) for each in STRUCK if each in found}


def plot_phase_portrait(
    trajectory: Trajectory, x: str, y: str, ax: Axes | None = None, *, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw one of :data:`QUANTITIES` over another, such as ``"dphi_s"`` over ``"phi_s"``.

    Arrows point along the motion. Impacts, where velocities jump, are broken lines that end in a
    mark, which differs between contacts [Leine2001, Figs. 5 and 6].

    Parameters
    ----------
    trajectory
        From :func:`woodpecker.simulate`.
    x, y
        Names of quantities: y, phi_m, phi_s, dy, dphi_m or dphi_s.
    ax
        Axes to draw on; new ones by default.
    legend, styles
        Whether to have a legend; properties of matplotlib by ``"motion"`` and the names in it.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or there is no such quantity.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.plot.motions import plot_phase_portrait
    >>> motion = simulate(Toy(), -0.52947197, 0.14597607, samples=201)
    >>> len(plot_phase_portrait(motion, "phi_s", "dphi_s").artists["direction of time"])
    3
    """
    instance("trajectory", trajectory, Trajectory)
    for name in (x, y):
        if name not in QUANTITIES:
            raise ValueError(f"unknown quantity {name!r}, expected one of {', '.join(QUANTITIES)}")
    ax = axes_for(ax, 4.6, 3.6)
    across, up = (quantity(name, trajectory.q, trajectory.u) for name in (x, y))
    shown: Artists = {MOTION: [*ax.plot(*with_gaps(trajectory.t, across, up), **LINE)]}
    shown[START] = [*ax.plot(across[0], up[0], ".", color="black", markersize=5, zorder=4)]
    for name, (times, style) in _strikes(trajectory).items():
        shown[name] = draw_jumps(ax, trajectory.t, across, up, times, style)
    shown[DIRECTION] = _arrows(ax, trajectory.t, across, up)
    framed(ax, QUANTITIES[x], QUANTITIES[y])
    styled(shown, styles, KNOWN)
    if legend:
        entries = _entries(shown)
        ax.legend(entries.values(), entries.keys(), fontsize=sized(6.5), loc="best", framealpha=0.9)
    return Drawn((ax,), shown)


def _entries(shown: Artists) -> dict[str, Any]:
    """Legend entries of a phase portrait: start, direction of time and impacts."""
    arrow = Line2D([], [], color=STABLE, linewidth=1.1, marker=">", markersize=4.5)
    names = (name for name, _ in STRUCK.values() if name in shown)
    return {START: shown[START][0], DIRECTION: arrow, **{name: shown[name][0] for name in names}}


def draw_jumps(
    ax: Axes, t: Floats, across: Floats, up: Floats, times: Sequence[float], style: Style
) -> list[Artist]:
    """Draw lines from the state before to that after an event; its time is sampled twice."""
    after = np.searchsorted(t, np.unique(times), side="right") - 1
    pairs = np.column_stack([np.maximum(after - 1, 0), after])
    return [*ax.plot(*strokes(across[pairs], up[pairs]), linewidth=1.1, markersize=3.4,
                     markevery=slice(1, None, 3), zorder=3, **style)]  # fmt: skip


def _arrows(ax: Axes, t: Floats, across: Floats, up: Floats) -> list[Artist]:
    """Draw arrow heads along the motion, near the places ARROWS but away from impacts."""
    size = [float(np.ptp(values)) or 1.0 for values in (across, up)]
    places = np.column_stack([across / size[0], up / size[1]])
    steps = np.hypot(*np.diff(places, axis=0).T)
    struck = np.flatnonzero(np.diff(t) == 0.0)
    steps[struck] = 0.0
    way = np.concatenate([[0.0], np.cumsum(steps)])
    ends = places[np.concatenate([struck, struck + 1])]
    arrows: list[Artist] = []
    for part in ARROWS:
        near = np.flatnonzero((np.abs(way - part * way[-1]) <= ARROW_SHIFT * way[-1]) & (way > 0.0))
        near = np.setdiff1d(near, struck + 1)
        if not len(near):
            continue
        away = [np.hypot(*(ends - places[k]).T).min(initial=ARROW_CLEARANCE) for k in near]
        head = int(near[int(np.argmax(away))])
        before = min(head - 1, int(np.searchsorted(way, way[head] - SHAFT)))
        earlier = struck[struck + 1 < head] + 1  # impacts before it
        tail = max(before, int(earlier.max(initial=0)))
        arrows.append(ax.annotate(
            "", (across[head], up[head]), (across[tail], up[tail]), zorder=4,
            arrowprops={"arrowstyle": HEAD, "color": STABLE, "shrinkA": 0, "shrinkB": 0,
                        "mutation_scale": 13, "linewidth": 0.0},
        ))  # fmt: skip
    return arrows


def plot_phase_portraits(
    trajectory: Trajectory, axes: _Axes | None = None, *, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw phase portraits of the bird, the sleeve and the fall on three axes.

    Parameters
    ----------
    trajectory, legend, styles
        As for :func:`plot_phase_portrait`, with its errors.
    axes
        Three axes; new ones by default.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.plot.motions import plot_phase_portraits
    >>> motion = simulate(Toy(), -0.52947197, 0.14597607, samples=201)
    >>> len(plot_phase_portraits(motion).axes)
    3
    """
    axes = several_axes(axes, 1, 3, (9.6, 3.7))
    shown: Artists = {}
    for ax, (x, y) in zip(axes, PORTRAITS.values(), strict=True):
        add(shown, plot_phase_portrait(trajectory, x, y, ax, legend=False, styles=styles).artists)
    if legend:
        entries = _entries(shown)
        axes[0].figure.legend(entries.values(), entries.keys(), fontsize=sized(7.5), frameon=False,
                              ncols=len(entries), loc="outside lower center")  # fmt: skip
    return Drawn(tuple(axes), shown)


def with_gaps(t: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Coordinates of a motion as a line with gaps at jumps, whose times are sampled twice."""
    jumps = np.flatnonzero(np.diff(t) == 0.0) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)
