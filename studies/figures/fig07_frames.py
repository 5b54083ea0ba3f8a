"""Figure 7 of the paper: the toy at the eight events that make up its stable periodic motion.

    python -m studies.figures.fig07_frames [--fast] [--out DIR]

The frames are drawn to scale, with the gaps of the model (:mod:`woodpecker.plot.drawing`). The
paper names eight events; the word of the motion has eleven. D3 follows the first I3 at once, D2 the
first I2 at once, and a second I2 follows 2.7 ms later, after which the sleeve slides: the paper's
frame 7 covers both impacts of the lower edge.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from studies.common.record import Results, command
from studies.common.style import WIDTH
from woodpecker import Event, PeriodicOrbit, Toy, Trajectory, shoot, simulate
from woodpecker.plot.drawing import animate, draw_frames

GUESS = -0.53  # rad, the paper's value of the stable cycle at eps_N1 = 0.5
SAMPLES = 4001  # two periods hold some forty swings of the free sleeve


class Frame(NamedTuple):
    """One frame of Figure 7."""

    number: int
    symbol: str  # of its event
    caption: str
    time: float  # s, from the section


SEQUENCE = (  # the text below Figure 5: what happens at t_1 .. t_8
    ("S2", "sleeve starts to slide"),
    ("D2", "lower edge leaves"),
    ("I3", "upper edge strikes"),
    ("I1", "beak strikes"),
    ("I3", "upper edge strikes"),
    ("D3", "upper edge leaves"),
    ("I2", "lower edge strikes"),
    ("J2", "sleeve jams"),
)


def cycle(periods: int = 1) -> tuple[PeriodicOrbit, Trajectory]:
    """The stable periodic motion of the paper's data set, from the section on."""
    toy = Toy()
    orbit = shoot(toy, GUESS)
    return orbit, simulate(toy, orbit.phi_s, periods * orbit.period, samples=SAMPLES)


def frames(trajectory: Trajectory) -> tuple[Frame, ...]:
    """The eight events in the first period of a motion.

    Raises
    ------
    ValueError
        If the motion has another order of events.
    """
    rest = iter(trajectory.events)
    found = []
    for number, (symbol, caption) in enumerate(SEQUENCE, start=1):
        event = next((event for event in rest if event.symbol == symbol), None)
        if event is None:
            raise ValueError(f"no {symbol} for frame {number} in {trajectory.word!r}")
        found.append(Frame(number, symbol, caption, event.time))
    return tuple(found)


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
        draw(motion, shown).savefig(out / "fig07.png", dpi=200)
        plt.close("all")
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
