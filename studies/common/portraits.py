"""Phase portraits in which the eight events of the paper are numbered (Figures 5 and 6)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from matplotlib.axes import Axes

from pwmap.plot import INK
from studies.common.motion import Frame, frames
from studies.common.style import GREY
from woodpecker import Trajectory
from woodpecker.plot.motions import plot_phase_portrait, quantity

Side = tuple[float, float] | None
"""Where a number stands, in points from its event; None if it shares the dot of the first."""


def portrait(
    trajectory: Trajectory,
    names: tuple[str, str],
    sides: Sequence[Side],
    ax: Axes,
    limits: Iterable[float] = (),
    *,
    legend: bool = True,
) -> None:
    """One quantity over another, with the angles at which a gap is closed.

    The events are numbered at the state just before them.
    """
    plot_phase_portrait(trajectory, *names, ax, legend=legend)
    for limit in limits:
        ax.axvline(limit, color=GREY, linewidth=0.8, linestyle=(0, (5, 3)))
    shown = frames(trajectory)
    q, u = trajectory.at([frame.time for frame in shown], left=True)
    x, y = (quantity(name, q, u) for name in names)
    ax.plot(x, y, ".", color=INK, markersize=4, zorder=4)
    ax.margins(0.09)  # numbers keep clear of the frame
    for label, here, up, side in zip(_joined(shown, sides), x, y, sides, strict=True):
        if side is not None:
            ax.annotate(
                label, (here, up), side, textcoords="offset points", ha="center", va="center",
                fontsize=8, color=INK,
            )  # fmt: skip


def _joined(shown: Sequence[Frame], sides: Sequence[Side]) -> list[str]:
    """Numbers, those without a place of their own behind the first of them that has one."""
    homeless = [str(frame.number) for frame, side in zip(shown, sides, strict=True) if side is None]
    labels = [str(frame.number) for frame in shown]
    labels[0] = ", ".join([labels[0], *homeless])
    return labels
