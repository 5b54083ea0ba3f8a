"""Fold-flip points that accumulate: a chain of branches without end, and its limit.

A branch of cycles and one of jumps lead from a fold-flip point to the next. If the orbit goes round
an unstable periodic motion once more in each link, the points approach two limits in turn. Each of
the two sequences is asymptotically geometric, with the inverse multiplier of that motion as its
ratio, and its limit is the sum of a geometric series.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.search.curves import End

# Fold-flip points of a chain from which its limit is inferred: four near each of the two limits,
# which are three distances with two ratios.
LINKED = 8
# Relative difference of the ratios of a sequence that still counts as geometric: the first ones,
# where the map is not linear yet, differ by an eighth, and four times less with each link.
RATIO_TOLERANCE = 0.25
ENDLESS = "fold-flips accumulate"
ACCUMULATE = "infinitely many fold-flip points accumulate"


def limit_of(chain: Sequence[End], units: Floats) -> End | None:
    """The limit of every other fold-flip point of a chain of branches, or None.

    The chain begins with the point found last; ``units`` (1 + d,) are those of the parameter and of
    points. The limit is open, with its distance from that point as precision. None if the chain is
    too short, or does not shrink towards two limits.
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
    """The vector (1 + d,) from the first of some places to their limit; None if there is none."""
    steps = places[:-1] - places[1:]
    length = np.linalg.norm(steps, axis=1)
    if not (length > 0.0).all():
        return None
    ratios = length[:-1] / length[1:]
    ratio = float(ratios[0])
    off = np.linalg.norm(steps[:-1] - ratios[:, None] * steps[1:], axis=1)
    geometric = ratio < 1.0 and np.abs(ratios - ratio).max() <= RATIO_TOLERANCE * ratio
    if not geometric or (off > RATIO_TOLERANCE * length[:-1]).any():
        return None
    rest: Floats = steps[0] * ratio / (1.0 - ratio)  # ratio + ratio^2 + ... times the last step
    return rest
