"""Figure 7 of the paper: the toy at the eight events that make up its stable periodic motion.

    python -m studies.figures.fig07_frames [--fast] [--out DIR]

The frames are drawn to scale, with the gaps of the model (:mod:`woodpecker.plot.drawing`). The
paper names eight events; the word of the motion has eleven. D3 comes with the first I3 and D2 with
the first I2; a second I2 follows 2.7 ms later, after which the sleeve slides: the paper's frame 7
covers both impacts of the lower edge.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from studies.common.motion import Frame, cycle, frames
from studies.common.record import Results, command
from studies.common.style import WIDTH, keep
from woodpecker import Event, Trajectory
from woodpecker.plot.drawing import animate, draw_frames


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Shoot the cycle, find the eight events, draw them.

    Parameters
    ----------
    fast
        Leave out the animation.
    out
        Folder for ``fig07.png`` and ``woodpecker.gif``.

    Returns
    -------
    dict
        ``period`` [s]; ``frames``: number, symbol and time [s] of each; ``second_impact``: time of
        the other impact of the lower edge [s]; ``share_before_jamming``: part of the period that
        has passed at frame 8; ``word``.
    """
    orbit, motion = cycle()
    shown = frames(motion)
    if out is not None:
        keep(draw(motion, shown), out / "fig07.png")
        if not fast:
            animate(motion, out / "woodpecker.gif")
    return {
        "period": orbit.period,
        "frames": [(f.number, f.symbol, f.time) for f in shown],
        "second_impact": _last(motion, "I2").time,
        "share_before_jamming": shown[-1].time / orbit.period,
        "word": orbit.word,
    }


def _last(trajectory: Trajectory, symbol: str) -> Event:
    return [event for event in trajectory.events if event.symbol == symbol][-1]


def draw(trajectory: Trajectory, shown: tuple[Frame, ...]) -> Figure:
    """The eight frames."""
    figure = plt.figure(figsize=(WIDTH, 7.0), layout="constrained")
    labels = [f"{f.number}: {f.caption}\n{f.symbol} at {1e3 * f.time:.2f} ms" for f in shown]
    draw_frames(trajectory, [f.time for f in shown], labels, figure)
    return figure


if __name__ == "__main__":
    command(main, "fig07_frames")
