"""Random toys around the paper's, each with a parameter and its span.

The toy of a number does not depend on which others are drawn. A toy that cannot be built, or whose
sleeve does not jam over the whole span, is drawn again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from woodpecker import Toy, jam_limit, return_map

SEED = 20
ASIDE = {  # how far parameters lie from the paper's, at most
    **dict.fromkeys(("m_m", "m_s", "j_m", "j_s", "c_phi", "g"), 0.2),
    **dict.fromkeys(("mu_1", "mu_2", "mu_3"), 0.1),
    **dict.fromkeys(("r_0", "r_m", "h_m", "l_m", "l_g", "h_s", "l_s"), 0.02),
}
BOUNCY, BOUNCE = 4, 0.3  # every fourth toy has restitution at both edges of the sleeve, up to this
RESTITUTION, WIDTH = (0.02, 0.7), 0.3  # of the beak: where its span begins, and how wide it is
PART = 0.03  # half a span of another parameter, of its value
DRAWS = 100  # of one toy at most
LOWEST, BELOW = -2.5, 0.0018  # rad: of windows, which end so far below the band of centres


class Drawn(NamedTuple):
    """A random toy and where it is looked at."""

    toy: Toy
    parameter: str
    span: tuple[float, float]
    window: tuple[float, float]  # of phi_S [rad], up to the band of centres
    refused: int  # how many were drawn before


def random_toy(number: int) -> Drawn:
    """The toy of a number.

    Raises
    ------
    ValueError
        If none of many can be had.
    """
    rng = np.random.default_rng([SEED, number])
    for refused in range(DRAWS):
        changed = {
            name: getattr(Toy(), name) * (1.0 + rng.uniform(-part, part))
            for name, part in ASIDE.items()
        }
        if number % BOUNCY == BOUNCY - 1:
            changed |= {name: rng.uniform(0.0, BOUNCE) for name in ("eps_n2", "eps_n3")}
        low = rng.uniform(*RESTITUTION)
        parameter = "eps_n1" if rng.random() < 0.5 else str(rng.choice(list(ASIDE)))
        try:
            toy = Toy(**changed)
            span = (low, low + WIDTH) if parameter == "eps_n1" else beside(toy, parameter)
            ends = [toy.replace(**{parameter: end}) for end in span]
        except ValueError:
            continue
        if all(each.mu_2 > jam_limit(each) for each in ends):
            return Drawn(toy, parameter, span, window_of(ends), refused)
    raise ValueError(f"none of {DRAWS} toys of number {number} jams")


def beside(toy: Toy, parameter: str) -> tuple[float, float]:
    """An interval about the value of a parameter."""
    value = getattr(toy, parameter)
    return (1.0 - PART) * value, (1.0 + PART) * value


def window_of(toys: list[Toy]) -> tuple[float, float]:
    """A window that ends below the band in which each of some toys swings without an event."""
    tops = []
    for toy in toys:
        found = return_map(toy, np.linspace(-1.0, 0.0, 4001))
        moves = zip(found.words, found.status, strict=True)
        rests = [not word and status.success for word, status in moves]
        tops.append(float(found.start[rests].min(initial=0.0)))
    return LOWEST, min(tops) - BELOW
