"""Pictures of trajectories and return maps [Leine2001, Figs. 4-6, 8]."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from pwmap.plot import JUMP, STABLE, UNSTABLE
from woodpecker.arrays import Floats
from woodpecker.labelled import iterate
from woodpecker.returns import ReturnMap
from woodpecker.shooting import toy_map
from woodpecker.toy import Toy
from woodpecker.trajectory import Trajectory
from woodpecker.words import EventKind

LINE: dict[str, Any] = {"color": STABLE, "linewidth": 1.1}
BOUND: dict[str, Any] = {"color": "#969696", "linewidth": 0.8, "linestyle": (0, (5, 3))}
_Axes = Sequence[Axes]


def plot_time_history(trajectory: Trajectory, axes: _Axes | None = None) -> _Axes:
    """Coordinates over time on three axes, impacts as ticks [Leine2001, Fig. 4]."""
    if axes is None:
        figure = plt.figure(figsize=(7.0, 5.6), layout="constrained")
        axes = list(figure.subplots(3, 1, sharex=True))
    labels = (r"$y$ [mm]", r"$\varphi_M$ [rad]", r"$\varphi_S$ [rad]")
    toy = trajectory.toy
    bounds: tuple[tuple[float, ...], ...] = (
        (), (-toy.phi_m_max, toy.phi_m_max), (toy.phi_s_max,),
    )  # fmt: skip
    impacts = [
        event.time
        for event in trajectory.events
        if event.kind in (EventKind.IMPACT, EventKind.INDETERMINATE_IMPACT)
    ]
    for k, ax in enumerate(axes):
        scale = 1e3 if k == 0 else 1.0
        ax.plot(trajectory.t, scale * trajectory.q[:, k], **LINE)
        for bound in bounds[k]:
            ax.axhline(bound, **BOUND)
        low = ax.get_ylim()[0]
        ax.plot(impacts, np.full(len(impacts), low), "|", color=UNSTABLE, markersize=9)
        ax.set_ylim(bottom=low)
        ax.set_ylabel(labels[k])
        ax.grid(alpha=0.25, linewidth=0.5)
    axes[-1].set_xlabel("$t$ [s]; ticks mark impacts")
    axes[-1].set_xlim(0.0, trajectory.t_end)
    return axes


def plot_phase_portraits(trajectory: Trajectory, axes: _Axes | None = None) -> _Axes:
    """Velocities over coordinates on three axes [Leine2001, Figs. 5 and 6].

    Impacts, where the velocities jump, are dotted.
    """
    if axes is None:
        figure = plt.figure(figsize=(9.6, 3.4), layout="constrained")
        axes = list(figure.subplots(1, 3))
    q, u = trajectory.q, trajectory.u
    panels: tuple[tuple[Floats, Floats, str, str], ...] = (
        (q[:, 2], u[:, 2], r"$\varphi_S$ [rad]", r"$\dot\varphi_S$ [rad/s]"),
        (q[:, 1], u[:, 1], r"$\varphi_M$ [rad]", r"$\dot\varphi_M$ [rad/s]"),
        (q[:, 2], 1e3 * u[:, 0], r"$\varphi_S$ [rad]", r"$\dot y$ [mm/s]"),
    )
    jumps = np.flatnonzero(np.diff(trajectory.t) == 0.0)
    for ax, (x, y, x_label, y_label) in zip(axes, panels, strict=True):
        smooth = np.insert(y.copy(), jumps + 1, np.nan)
        ax.plot(np.insert(x, jumps + 1, np.nan), smooth, **LINE)
        for k in jumps:
            ax.plot(x[k : k + 2], y[k : k + 2], color=JUMP, linewidth=1.1, linestyle=(0, (1, 1.3)))
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        ax.grid(alpha=0.25, linewidth=0.5)
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
        The toy, to locate the jumps between neighbouring samples of different words.
    returns
        Map at ascending starts, from :func:`woodpecker.return_map`.
    order
        The order of ``returns``.
    depth
        Lower end of the vertical axis; the dips have no bottom. By default the map's left end.
    """
    ax = ax if ax is not None else plt.figure(figsize=(7.0, 4.6), layout="constrained").gca()
    bottom = float(depth if depth is not None else returns.start[0])
    x, y, jumps = _refined(toy, returns, order, bottom)
    ax.plot(returns.start, returns.start, color="#969696", linewidth=0.8, label="diagonal")
    ax.plot(np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan), label=f"$P_{order}$", **LINE)
    shown = [k for k in jumps if min(y[k - 1], y[k]) > bottom]
    for number, k in enumerate(shown):
        ax.plot(
            x[k - 1 : k + 1],
            y[k - 1 : k + 1],
            color=JUMP,
            linewidth=1.4,
            linestyle=(0, (1, 1.3)),
            label="jump" if number == 0 else None,
        )
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(bottom, max(x[-1], float(np.nanmax(y))) + 0.1)
    ax.set_xlabel(r"$\varphi_{S,k}$ [rad]")
    ax.set_ylabel(rf"$\varphi_{{S,k+{order}}}$ [rad]")
    ax.grid(alpha=0.25, linewidth=0.5)
    ax.legend(fontsize=8, frameon=True, framealpha=0.9)
    return ax


SEEN = 0.02  # rad: a discontinuity smaller than this does not show in a picture of the whole map
FINEST = 1e-9  # rad: what still differs by more than SEEN over this width is drawn as a jump


def _refined(
    toy: Toy, returns: ReturnMap, order: int, bottom: float
) -> tuple[Floats, Floats, list[int]]:
    """Samples with more of them on steep flanks, and the indices right of each jump.

    An interval is halved until its ends lie close together, below the picture, or at one place.
    """
    labelled_map = iterate(toy_map(toy), order)
    x, y, jumps = [float(returns.start[0])], [float(returns.phi_s[0])], []
    pending = list(zip(returns.start[:0:-1].tolist(), returns.phi_s[:0:-1].tolist(), strict=True))
    while pending:
        right, image = pending[-1]
        visible = max(y[-1], image) > bottom  # False if one of them is nan
        if visible and abs(image - y[-1]) > SEEN and right - x[-1] > FINEST:
            middle = 0.5 * (x[-1] + right)
            pending.append((middle, labelled_map(middle, toy.eps_n1).value))
            continue
        if abs(image - y[-1]) > SEEN:
            jumps.append(len(x))
        x.append(right)
        y.append(image)
        pending.pop()
    return np.array(x), np.array(y), jumps
