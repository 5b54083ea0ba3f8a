"""Pictures of any system with contacts: motions with their events, return maps, basins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from pwmap.plot import JUMP, STABLE, UNSTABLE, place_legend
from pwmap.plot.drawn import Artists, Drawn, Styles, axes_for, framed, several_axes, sized, styled
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, interval, whole
from woodpecker.plot.curve import refined
from woodpecker.plot.figures import plot_curve
from woodpecker.plot.motions import (
    LINE,
    MOTION,
    START,
    Marks,
    Style,
    draw_histories,
    draw_jumps,
    legend_above,
    with_gaps,
)
from woodpecker.simulation.words import EventKind
from woodpecker.systems.diagrams import basins
from woodpecker.systems.mechanics.model import ContactSystem
from woodpecker.systems.returns import SystemMap
from woodpecker.systems.verbs import Motion, SystemCycle, return_map

NO_CYCLE = "none of them"
DOTTED: Style = {"linestyle": (0, (1, 1.2))}
EVENTS: dict[str, tuple[tuple[EventKind, ...], dict[str, Any]]] = {
    "impact": (
        (EventKind.IMPACT, EventKind.CHATTER, EventKind.INDETERMINATE_IMPACT),
        {"color": UNSTABLE, "marker": "o"},
    ),
    "sticks": ((EventKind.STICK,), {"color": JUMP, "marker": "s"}),
    "slips": ((EventKind.SLIP, EventKind.REVERSAL), {"color": "#6a51a3", "marker": "^"}),
    "detaches": ((EventKind.DETACH,), {"color": "#969696", "marker": "v"}),
}
BUDGET = 300  # returns for steep places: seconds, at some 10 ms each
ROUNDED = 1e-6  # of the ends of an axis: a smaller coordinate of a cycle is rounding, and 0
BASINS = ("#9ecae1", "#fdae6b", "#a1d99b", "#bcbddc", "#fc9272", "#d9d9d9")


def plot_system_motion(
    system: ContactSystem, motion: Motion, names: Sequence[Any] | None = None,
    axes: Sequence[Axes] | None = None, *, legend: bool = True, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw coordinates and velocities over time, with events as marks.

    Parameters
    ----------
    system, motion
        The system, and its motion from :func:`woodpecker.systems.simulate`.
    names
        Symbols of the state, or their names; by default all coordinates.
    axes
        One for each of them; new ones by default.
    legend, styles
        Whether to have a legend of the marks; properties by its names, and ``"motion"``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or a name is no symbol of the state.

    Examples
    --------
    >>> from woodpecker.examples import bouncing_ball
    >>> from woodpecker.plot.systems import plot_system_motion
    >>> from woodpecker.systems import simulate
    >>> ball = bouncing_ball()
    >>> drawn = plot_system_motion(ball, simulate(ball, {"y": 5.0}, 1.5), ["y", "u_y"])
    >>> sorted(drawn.artists)
    ['impact', 'motion']
    """
    wanted = system.q if names is None else names
    values = [_values(system, motion, name) for name in wanted]
    axes = several_axes(axes, len(values), 1, (7.0, 1.2 + 1.5 * len(values)))
    rows = [(_label(name), each) for name, each in zip(wanted, values, strict=True)]
    shown = draw_histories(axes, motion.t, rows, _marks(motion))
    for ax in axes:
        ax.margins(x=0.0)
    axes[-1].set_xlabel("$t$")
    styled(shown, styles, (MOTION, *EVENTS))
    if legend:
        legend_above(axes[0], shown, EVENTS)
    return Drawn(tuple(axes), shown)


def plot_system_portrait(
    system: ContactSystem, motion: Motion, x: Any, y: Any, ax: Axes | None = None, *,
    legend: bool = True, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw one coordinate or velocity over another; impacts are dotted, other events are marks.

    Parameters
    ----------
    system, motion, legend, styles
        As for :func:`plot_system_motion`, with its errors.
    x, y
        Symbols of the state, or their names.
    ax
        Axes to draw on; new ones by default.

    Examples
    --------
    >>> from woodpecker.examples import bouncing_ball
    >>> from woodpecker.plot.systems import plot_system_portrait
    >>> from woodpecker.systems import simulate
    >>> ball = bouncing_ball()
    >>> drawn = plot_system_portrait(ball, simulate(ball, {"y": 5.0}, 1.5), "y", "u_y")
    >>> sorted(drawn.artists)
    ['impact', 'motion', 'start']
    """
    across, up = _values(system, motion, x), _values(system, motion, y)
    ax = axes_for(ax, 5.4, 4.4)
    shown: Artists = {MOTION: [*ax.plot(*with_gaps(motion.t, across, up), **LINE)]}
    shown[START] = [*ax.plot(across[0], up[0], ".", color="black", markersize=6, zorder=4)]
    for kind, (times, style) in _marks(motion).items():
        if kind == "impact":
            shown[kind] = draw_jumps(ax, motion.t, across, up, times, DOTTED | style)
            continue
        after = np.searchsorted(motion.t, times, side="right") - 1
        shown[kind] = [*ax.plot(
            across[after], up[after], linestyle="none", markersize=4.4, mec="white", mew=0.4,
            zorder=5, **style,
        )]  # fmt: skip
    framed(ax, _label(x), _label(y))
    styled(shown, styles, (MOTION, START, *EVENTS))
    place_legend(ax, {name: shown[name] for name in shown if name != MOTION}, legend)
    return Drawn((ax,), shown)


def plot_system_map(
    map_: SystemMap, x: npt.ArrayLike, ax: Axes | None = None, *, order: int = 1,
    p: npt.ArrayLike | None = None, legend: bool = True, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw a one-dimensional return map of a system, with the diagonal; jumps are dotted.

    Parameters
    ----------
    map_
        The return map of a system to a section with one coordinate.
    x
        (n,) ascending starts; more are added where the map is steep.
    order
        Number of returns.
    p
        (k,) values of the free parameters; by default those of the system.
    ax, legend, styles
        As for :func:`woodpecker.plot.figures.plot_curve`.

    Raises
    ------
    TypeError, ValueError
        If ``map_`` is not a return map of one dimension.

    Examples
    --------
    >>> from woodpecker.examples import bouncing_ball
    >>> from woodpecker.plot.systems import plot_system_map
    >>> from woodpecker.systems import Section, SystemMap
    >>> bounces = SystemMap(bouncing_ball(), Section(when="floor", free=["u_y"]))
    >>> sorted(plot_system_map(bounces, [1, 2, 3]).artists)
    ['$P_{1}$', 'diagonal']
    """
    instance("map_", map_, SystemMap)
    if map_.d != 1:
        raise ValueError(f"a return map of one dimension can be drawn, got {map_.d}")

    def image(at: Floats) -> Floats:
        values: Floats = return_map(map_, at, order=order, p=p).images[:, 0]
        return values

    first = np.asarray(x, dtype=float)
    values = image(first)
    bottom = float(np.nanmin(np.append(values, first[0])))
    *_, curve = refined(image, first, values, bottom=bottom, cost=order, budget=BUDGET)
    drawn = plot_curve(curve, ax, order=order, legend=legend, styles=styles)
    name = _label(map_.section.free[0])
    after = "the return" if order == 1 else f"{order} returns"
    drawn.ax.set(xlabel=name, ylabel=f"{name} after {after}")
    return drawn


def plot_basins(
    map_: SystemMap, cycles: Sequence[SystemCycle], plane: Mapping[Any, tuple[float, float]],
    ax: Axes | None = None, *, at: Mapping[Any, float] | None = None, points: int = 40,
    returns: int = 200, near: float = 1e-3, p: npt.ArrayLike | None = None, legend: bool = True,
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw the basins of cycles in a plane of two coordinates of a section.

    Parameters
    ----------
    map_, cycles
        The return map of a system, of two dimensions or more, and its stable cycles.
    plane
        The two coordinates, horizontal and vertical, each with its interval.
    ax
        Axes to draw on; new ones by default.
    at
        Values of the other coordinates, by default zero.
    points
        Number of starts in each direction.
    returns, near, p
        As for :func:`woodpecker.systems.basins`.
    legend, styles
        Whether to have a legend; properties of matplotlib by ``"basins"`` and ``"cycles"``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or ``plane`` has not two coordinates of the section.
    """
    instance("map_", map_, SystemMap)
    free = [str(each) for each in map_.section.free]
    names = [str(each) for each in plane]
    for name in (*names, *map(str, at or {})):
        if name not in free:
            raise ValueError(f"unknown coordinate {name!r}, the section has {free}")
    if len(names) != 2:
        raise ValueError(f"a plane has two coordinates, got {len(names)}")
    points = whole("points", points, 2)
    ends = [interval("plane", each, finite=True) for each in plane.values()]
    across, up = (np.linspace(*each, points) for each in ends)
    starts = np.zeros((points, points, map_.d))
    for name, value in (at or {}).items():
        starts[..., free.index(str(name))] = value
    starts[..., free.index(names[0])] = across[None, :]
    starts[..., free.index(names[1])] = up[:, None]
    owner = basins(
        map_, cycles, starts.reshape(-1, map_.d), returns=returns, near=near, p=p
    ).reshape(points, points)  # fmt: skip
    ax = axes_for(ax, 5.6, 4.4)
    colours = ["white", *(BASINS[k % len(BASINS)] for k in range(len(cycles)))]
    mesh = ax.pcolormesh(
        across, up, owner, cmap=ListedColormap(colours), vmin=-1.5, vmax=len(cycles) - 0.5,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    shown: Artists = {"basins": [mesh]}
    marks, patches = list[Any](), list[Any]()
    for cycle, colour in zip(cycles, colours[1:], strict=True):
        x, y = (cycle.x[:, free.index(name)] for name in names)
        marks += ax.plot(x, y, "o", color=STABLE, markersize=4.5, mec="white", mew=0.6)
        first = zip(x[:2].tolist(), y[:2].tolist(), strict=True)
        where = ", ".join(f"({_short(a, ends[0])}, {_short(b, ends[1])})" for a, b in first)
        patches.append(Patch(facecolor=colour, label=where + (", ..." if len(x) > 2 else "")))
    shown["cycles"] = marks
    if (owner < 0).any():
        patches.append(Patch(facecolor="white", edgecolor="#969696", label=NO_CYCLE))
    ax.set(xlabel=_label(names[0]), ylabel=_label(names[1]), xlim=ends[0], ylim=ends[1])
    styled(shown, styles)
    if legend:
        ax.legend(
            handles=patches,
            title="comes to",
            fontsize=sized(7),
            title_fontsize=sized(7),
            loc="best",
        )
    return Drawn((ax,), shown)


def _short(value: float, ends: tuple[float, float]) -> str:
    """A coordinate with three digits; what is rounding beside the ends of its axis is 0."""
    if abs(value) < ROUNDED * max(map(abs, ends)):
        return "0"
    digits, _, power = f"{value:.3g}".partition("e")
    return rf"${digits} \times 10^{{{int(power)}}}$" if power else digits


def _values(system: ContactSystem, motion: Motion, name: Any) -> Floats:
    instance("system", system, ContactSystem)
    instance("motion", motion, Motion)
    known = [str(each) for each in system.state]
    if str(name) not in known:
        raise ValueError(f"unknown coordinate {str(name)!r}, the state has {known}")
    found: Floats = np.column_stack([motion.q, motion.u, motion.t])[:, known.index(str(name))]
    return found


def _marks(motion: Motion) -> Marks:
    times = {
        name: [event.time for event in motion.events if EventKind(event.symbol[0]) in kinds]
        for name, (kinds, _) in EVENTS.items()
    }
    return {name: (times[name], EVENTS[name][1]) for name in EVENTS if times[name]}


def _label(name: Any) -> str:
    import sympy

    symbol = name if isinstance(name, sympy.Symbol) else sympy.Symbol(str(name))
    return f"${sympy.latex(symbol)}$"
