"""Figure 5 of the paper: phase portrait of the bird in the stable periodic motion.

    python -m studies.figures.fig05_phase_woodpecker [--fast] [--out DIR]

The paper's text names Figures 5 and 6 "phase space portraits" without saying of what. Here Figure 5
is the bird, whose angle is also the coordinate of the return map; Figure 6 shows sleeve and fall.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.record import Results, command
from studies.common.style import GREY, UNSTABLE, canvas
from studies.figures.fig07_frames import Frame, cycle, frames
from woodpecker import Trajectory
from woodpecker.plot.figures import QUANTITIES, plot_phase_portrait

Side = tuple[float, float] | None  # where a number stands, in points from its event


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Shoot the cycle and draw the bird's velocity over its angle.

    Parameters
    ----------
    fast
        Makes no difference: the study takes milliseconds.
    out
        Folder for ``fig05.png``.

    Returns
    -------
    dict
        ``period`` [s]; ``phi_s``, ``dphi_s``: least and largest value [rad], [rad/s];
        ``beak``: velocity of the bird before and after the beak strikes [rad/s], and
        ``beak_restitution``, the negative of their ratio.
    """
    orbit, motion = cycle()
    if out is not None:
        draw(motion, frames(motion)).savefig(out / "fig05.png", dpi=200)
        plt.close("all")
    (strike,) = (event for event in motion.events if event.symbol == "I1")
    before, after = strike.u_before[2], strike.u_after[2]
    return {
        "period": orbit.period,
        "phi_s": extremes(motion.q[:, 2]),
        "dphi_s": extremes(motion.u[:, 2]),
        "beak": (before, after),
        "beak_restitution": -after / before,
    }


def extremes(values: np.ndarray) -> tuple[float, float]:
    """Least and largest value."""
    return float(values.min()), float(values.max())


def draw(trajectory: Trajectory, shown: tuple[Frame, ...]) -> Figure:
    """Velocity over angle, up to the angle at which the beak strikes."""
    figure, (ax,) = canvas(4.4)
    plot_phase_portrait(trajectory, "phi_s", "dphi_s", ax)
    ax.axvline(trajectory.toy.phi_s_max, color=GREY, linewidth=0.8, linestyle=(0, (5, 3)))
    sides = ((0, 8), (0, 8), (8, -5), (9, 0), (-9, -3), (-4, 9), (0, 9), (0, -10))
    number(ax, trajectory, shown, ("phi_s", "dphi_s"), sides)
    return figure


def number(
    ax: Axes,
    trajectory: Trajectory,
    shown: Sequence[Frame],
    names: tuple[str, str],
    sides: Sequence[Side],
) -> None:
    """Number the events of Figure 7 at the state just before them; None where one shares a dot."""
    q, u = trajectory.at([frame.time for frame in shown], left=True)
    x, y = (QUANTITIES[name].of(q, u) for name in names)
    ax.plot(x, y, ".", color=UNSTABLE, markersize=5, zorder=4)
    for label, here, up, side in zip(joined(shown, sides), x, y, sides, strict=True):
        if side is not None:
            ax.annotate(
                label, (here, up), side, textcoords="offset points", ha="center", va="center",
                fontsize=8, color=UNSTABLE,
            )  # fmt: skip


def joined(shown: Sequence[Frame], sides: Sequence[Side]) -> list[str]:
    """Numbers, those without a place of their own behind the first of them that has one."""
    homeless = [str(frame.number) for frame, side in zip(shown, sides, strict=True) if side is None]
    labels = [str(frame.number) for frame in shown]
    labels[0] = ", ".join([labels[0], *homeless])
    return labels


if __name__ == "__main__":
    command(main, "fig05_phase_woodpecker")
