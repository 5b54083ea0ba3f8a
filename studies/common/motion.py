"""The stable periodic motion of the paper's data set, and the eight events named in the paper."""

from __future__ import annotations

from typing import Final, NamedTuple

from woodpecker import PeriodicOrbit, Toy, Trajectory, shoot, simulate
from woodpecker.base.arrays import Floats

GUESS: Final = -0.53  # rad, the paper's value of the stable cycle at eps_N1 = 0.5
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
    """The motion, from the section on."""
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


def extremes(values: Floats) -> tuple[float, float]:
    """Least and largest value."""
    return float(values.min()), float(values.max())
