"""Where fixed points of P_1 meet its jumps over eps_N1: the paper's A, B and C, and others.

At these values of eps_N1 a one-sided limit of P_1 at a jump is the jump itself. They come from
bisection of simulations, and are good to 1e-13 (test_returns checks both sides of them).
"""

from typing import NamedTuple

UPPER, LOWER = -0.7577872573415617, -0.8847733440138271  # phi_S [rad]; eps_N1 does not move them


class Place(NamedTuple):
    """Code and note of a special point, its eps_N1, and the jump."""

    code: str
    note: str
    eps_n1: float
    phi_s: float


_ISLAND = {
    "I1 left": Place("BC", "persistence", 0.34192345438080, LOWER),
    "I1 right": Place("FF", "fold", 0.38834958888109, LOWER),
}
POINTS = {  # for each law of friction in the expansion at two contacts
    "summed": {
        "A": Place("FF", "fold", 0.11197091445663, LOWER),
        "B": Place("BC", "fold", 0.29152171188505, LOWER),
        "C": Place("BC", "fold", 0.18512695093092, UPPER),
        "end of the branch from A": Place("FF", "fold", 0.18815862092540, UPPER),
        "end of the branch from B": Place("BC", "persistence", 0.04532574146115, LOWER),
        **_ISLAND,
    },
    "separate": {
        "A": Place("FF", "fold", 0.04216433091293, LOWER),
        "B": Place("BC", "fold", 0.32103614645551, LOWER),
        "C": Place("BC", "persistence", 0.18512695093092, UPPER),
        "end of the branch from A": Place("BC", "persistence", 0.06981781629819, UPPER),
        **_ISLAND,
    },
}
EVERY = [(law, name) for law, points in POINTS.items() for name in points]
