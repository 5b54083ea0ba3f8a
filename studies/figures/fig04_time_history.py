"""Figure 4 of the paper: the coordinates over two periods of the stable periodic motion.

    python -m studies.figures.fig04_time_history [--fast] [--out DIR]

The motion starts on the section, where the bird is at its lowest while the sleeve jams. The
numbers are those of Figure 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.motion import Frame, cycle, extremes, frames
from studies.common.record import Results, command
from studies.common.style import GREY, WIDTH, canvas, keep
from woodpecker import Trajectory
from woodpecker.base.arrays import Floats
from woodpecker.plot.motions import plot_time_history

PERIODS = 2  # as in the paper


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Shoot the cycle and draw two periods of it.

    Parameters
    ----------
    fast
        Makes no difference: the study takes milliseconds.
    out
        Folder for ``fig04.png``.

    Returns
    -------
    dict
        ``period`` [s], ``drop`` of one period [m], ``speed`` of the fall, a mean [m/s];
        ``extremes``: least and largest value of y [m] and of phi_M, phi_S [rad] over one period;
        ``events``: symbol and time [s] of each event of one period.
    """
    orbit, motion = cycle(PERIODS)
    if out is not None:
        keep(draw(motion, frames(motion), orbit.period), out / "fig04.png")
    once = motion.q[motion.t <= orbit.period]
    return {
        "period": orbit.period,
        "drop": orbit.drop,
        "speed": orbit.drop / orbit.period,
        "extremes": {name: extremes(once[:, k]) for k, name in enumerate(("y", "phi_m", "phi_s"))},
        "events": [(e.symbol, e.time) for e in motion.events if e.time <= orbit.period],
    }


def draw(trajectory: Trajectory, shown: tuple[Frame, ...], period: float) -> Figure:
    """Three coordinates over time, the events numbered above."""
    figure, axes = canvas(5.2, 3, 1)
    drawn = plot_time_history(trajectory, axes, legend=False)
    struck = {name: marks[0] for name, marks in drawn.artists.items() if "impact" in name}
    figure.legend(struck.values(), struck.keys(), fontsize=8, frameon=False, ncols=len(struck),
                  loc="outside lower center")  # fmt: skip
    for ax in axes[:-1]:
        ax.sharex(axes[-1])
        ax.tick_params(labelbottom=False)
    for k in range(PERIODS):
        number(axes, [frame.time + k * period for frame in shown])
    return figure


def number(axes: Sequence[Axes], times: Sequence[float]) -> None:
    """Number instants above the first axes, with a thin line down through all."""
    for ax in axes:
        for t in times:
            ax.axvline(t, color=GREY, linewidth=0.4, zorder=0.5)
    inches_per_second = WIDTH / axes[0].get_xlim()[1]
    places = spread(np.array(times), 0.13 / inches_per_second)
    for k, (t, place) in enumerate(zip(times, places, strict=True), start=1):
        axes[0].annotate(
            str(k), (t, 1.0), (place, 1.08), xycoords=axes[0].get_xaxis_transform(),
            textcoords=axes[0].get_xaxis_transform(), ha="center", fontsize=8, color="#525252",
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.4, "shrinkA": 0,
                        "shrinkB": 0},
        )  # fmt: skip


def spread(places: Floats, gap: float) -> Floats:
    """Places moved as little as needed to be ``gap`` apart, in order: labels that do not touch.

    With the gaps taken out, what is left to do is isotonic regression: neighbours that are out of
    order share their mean.
    """
    offsets = gap * np.arange(len(places))
    groups: list[list[float]] = []
    for value in (places - offsets).tolist():
        groups.append([value])
        while len(groups) > 1 and np.mean(groups[-2]) > np.mean(groups[-1]):
            groups[-2:] = [groups[-2] + groups[-1]]
    means = [float(np.mean(group)) for group in groups for _ in group]
    apart: Floats = np.array(means) + offsets
    return apart


if __name__ == "__main__":
    command(main, "fig04_time_history")
