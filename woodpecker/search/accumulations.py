"""Fold-flip points that accumulate: a chain of branches without end, and its limit.

From a fold-flip point a branch of cycles and one of jumps lead on, each to the next such point. If
an orbit goes round an unstable motion once more in each link, the points approach two places in
turn. Both sequences are geometric in the limit, by the inverse multiplier of that motion, and what
is missing is the rest of a series.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.search.curves import End

# Fold-flip points in a chain that tell that it has no end: four at each of the two places that they
# approach, so that three distances shrink by two ratios.
LINKED = 8
# Part by which ratios of successive distances differ at most in a geometric series: of the first
# ones, where the map is not linear yet, by an eighth, then four times less with each.
ALIKE = 0.25
ENDLESS = "fold-flips accumulate"
ACCUMULATE = "infinitely many fold-flip points accumulate"


def limit_of(chain: Sequence[End], units: Floats) -> End | None:
    """The limit of every other fold-flip point of a chain, each linked to the next by a branch.

    The chain's last point was found first; ``units`` (1 + d,) are those of the parameter and of
    points. The limit is open, with its distance from the first point as precision; None if the
    chain is too short, or does not shrink to two places.
    """
    if len(chain) < LINKED or any(end.kind is not PointKind.FF for end in chain):
        return None
    places = np.array([[end.p, *end.x[0]] for end in chain[:LINKED]]) / units
    rest, other = (_rest(places[k::2]) for k in (0, 1))
    if rest is None or other is None:
        return None
    p, *x = ((places[0] + rest) * units).tolist()
    cause = f"{ACCUMULATE}: {chain[0].cause}"
    return End(
        kind=PointKind.EP, p=p, x=np.array([x]), note=ENDLESS, cause=cause,
        precision=abs(p - chain[0].p), status=PointStatus.OPEN,
    )  # fmt: skip


def _rest(places: Floats) -> Floats | None:
    """The way (1 + d,) from the first of some places to their limit; None if it has none."""
    steps = places[:-1] - places[1:]
    length = np.linalg.norm(steps, axis=1)
    if not (length > 0.0).all():
        return None
    ratios = length[:-1] / length[1:]
    ratio = float(ratios[0])
    off = np.linalg.norm(steps[:-1] - ratios[:, None] * steps[1:], axis=1)
    geometric = ratio < 1.0 and np.abs(ratios - ratio).max() <= ALIKE * ratio
    if not geometric or (off > ALIKE * length[:-1]).any():
        return None
    rest: Floats = steps[0] * ratio / (1.0 - ratio)
    return rest
