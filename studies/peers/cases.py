"""References with thirty digits: named scenes, a sample of the map, and the cycle.

The digits come from :mod:`studies.peers.reference_mpmath`, which shares no code with the packages,
and from starts that are the doubles written here; ``tests/studies/test_work_precision.py`` computes
them again.

Everything here is under Coulomb's law contact by contact (``expansion_friction="separate"``), the
only one that the other programs know. Returns without an impact at two contacts, among them the
cycle, are the same under the sum.

    python -m studies.peers.cases
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf, nstr

from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.places import WINDOW
from studies.peers.ode import IMAGE, PERIOD, PHI_S
from studies.peers.reference_mpmath import first_return
from woodpecker import Toy, parameters
from woodpecker.base.arrays import Floats

DIGITS = 30  # of every decimal below
PLACES = 40  # printed, so that the last of the thirty is not touched by rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """One return from rest on the section, with its exact end.

    Parameters
    ----------
    name, what
        A short name, and what makes the scene worth measuring.
    toy, phi_s
        The toy and the start [rad].
    image, period
        Angle [rad] and time [s] of the return, as decimals.
    word
        Sequence of events, without the letters that tell the phases of an impact apart.
    """

    name: str
    what: str
    toy: Toy
    phi_s: float
    image: str
    period: str
    word: str


class Cycle(NamedTuple):
    """A fixed point of P_1 [rad], its multiplier [-] and its period [s], as decimals."""

    phi_s: str
    multiplier: str
    period: str


CYCLE = Scene(
    name="cycle",
    what="the stable cycle at eps_N1 = 0.5",
    toy=CONTACT_BY_CONTACT,
    phi_s=PHI_S,
    image=IMAGE,
    period=PERIOD,
    word="S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2",
)
DOUBLE = Scene(
    name="double impact",
    what="the beak strikes while the upper sleeve contact is closed",
    toy=CONTACT_BY_CONTACT,
    phi_s=-0.8,
    image="-0.327395298718534276482106099406",
    period="0.0930575845885900083149150769701",
    word="S2 D2 I3 D3 I3 I1+3 D3 I2 J2",
)
TWO_SWINGS = Scene(
    name="two swings",
    what="a long return next to a dip of the map",
    toy=CONTACT_BY_CONTACT,
    phi_s=-1.26,
    image="-1.16216921723072560601352666882",
    period="0.482126898904724613706240550002",
    word="S2 D2 I1 I3 D3 I2 R2 D2 I3 D3 I3 I1+3 D3 I2 D2 I2 J2",
)
SCENES = (CYCLE, DOUBLE, TWO_SWINGS)

POINTS = 1000
SAMPLED = slice(41, None, 83)  # twelve of the thousand, evenly spread
SAMPLE_IMAGES = (
    "-0.337613119062106104719593784783",
    "-0.410972109340576544713908836374",
    "-0.461256155001330145954171997423",
    "-0.512222318870278000377090396128",
    "-0.643952092494512220231912245058",
    "-0.652840091981447884089707111497",
    "-1.0105914480993486837242209806",
    "-0.289275438811081443238330471545",
    "-0.45103386185643822598407665256",
    "-0.402591671745151939569841421614",
    "-0.529390113179420042638893242579",
    "-0.751333190881099319118027702958",
)

FIXED_POINT = Cycle(
    phi_s="-0.529471967110851035675129603749",
    multiplier="-0.839155653047585473340097603648",
    period="0.145976065143751815503165646909",
)


def starts() -> Floats:
    """The thousand starts of the map over the window [rad]."""
    return np.linspace(*WINDOW, POINTS)


def sample() -> Floats:
    """The twelve of them whose images are known to thirty digits [rad]."""
    return starts()[SAMPLED]


def plain(word: str) -> str:
    """A word without the letters that tell the phases of an impact apart."""
    return re.sub(r"(\d)(?:e\d+|[sfr-]+)", r"\1", word)


def same_events(word: str, other: str) -> bool:
    """Whether two words tell of the same events.

    A slip that reverses is at rest for one instant; a method that finds it at rest for one step
    writes ``J2 S2`` for ``R2``, and has missed nothing.
    """
    return _instants(word) == _instants(other)


def _instants(word: str) -> str:
    return re.sub(r"J(\d) S\1", r"R\1", plain(word))


def distance(value: float | Decimal, reference: str) -> float:
    """Distance of a number from a decimal one, without rounding the latter."""
    return float(abs(Decimal(value) - Decimal(reference)))


def numbers(toy: Toy) -> dict[str, float | str]:
    """The toy's parameters and its law as other programs read them, and as JSON can hold them.

    The pole is endless here, and left out.
    """
    values: dict[str, float | str] = {name: getattr(toy, name) for name in parameters()}
    del values["pole"]
    return values | {"expansion_friction": str(toy.expansion_friction)}


def recomputed(scene: Scene) -> tuple[str, str, str]:
    """Image, period and word of a scene by the thirty-digit program."""
    once = first_return(scene.phi_s, numbers(scene.toy), DIGITS)
    return nstr(once.phi_s, DIGITS), nstr(once.period, DIGITS), plain(once.word)


def recomputed_sample() -> tuple[str, ...]:
    """Images of the sample of the map by the thirty-digit program."""
    toy = numbers(CONTACT_BY_CONTACT)
    return tuple(nstr(first_return(float(x), toy).phi_s, DIGITS) for x in sample())


def recomputed_fixed_point(steps: int = 4) -> Cycle:
    """Newton's method on the thirty-digit program.

    The slope is a central difference over 1e-16 rad, so its error is of the order of 1e-32.
    """
    toy = numbers(CONTACT_BY_CONTACT)
    with mp.workdps(2 * DIGITS):
        x, h = mpf(PHI_S), mpf(10) ** -16
        for _ in range(steps):
            low, here, high = (first_return(x + k * h, toy, PLACES) for k in (-1, 0, 1))
            slope = (high.phi_s - low.phi_s) / (2 * h)
            x += (here.phi_s - x) / (1 - slope)
        return Cycle(nstr(x, DIGITS), nstr(slope, DIGITS), nstr(here.period, DIGITS))


if __name__ == "__main__":
    lines = [" ".join((scene.name, *recomputed(scene))) for scene in SCENES]
    lines += [*recomputed_sample(), *recomputed_fixed_point()]
    sys.stdout.write("\n".join(lines) + "\n")
