"""Roots of functions along a piece."""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

from woodpecker.maps.pieces import Image
from woodpecker.slices.extents import Knot
from woodpecker.slices.margins import depth

SLACK = 1e-6  # part of an interval by which depth may be negative inside: half of the digits
STARTS = 4  # known points, at most, from which a piece is continued to a new one


def bracketed(
    a: Knot, b: Knot, p: float, function: Callable[[Image, float], float]
) -> tuple[float, Image] | None:
    """Where ``function(image, x)`` vanishes between two samples of a piece; None if it does not."""
    images = {a.x: a.image, b.x: b.image}

    def value(at: float) -> float:
        return function(_image_near(images, at, p), at)

    if not value(a.x) * value(b.x) <= 0.0:
        return None
    finest = max(math.ulp(a.x), math.ulp(b.x))  # of both: a root at zero is reached, too
    try:
        root = float(brentq(value, a.x, b.x, xtol=finest))
    except ValueError:  # the piece has no value on the way
        return None
    return root, _image_near(images, root, p)


def _image_near(known: dict[float, Image], x: float, p: float) -> Image:
    """The image of a point under a piece, continued from the nearest known one, and kept there."""
    # Where the result is lost or outside of its margins, as beside a singularity, the next known
    # point is tried.
    if x in known:
        return known[x]
    slack = SLACK * (max(known) - min(known))
    starts = sorted((at for at in known if not known[at].reason), key=lambda at: abs(at - x))
    tried = (known[start].piece.at(x, p) for start in starts[:STARTS])
    inside = (each for each in tried if not each.reason and depth(each) >= -slack)
    return known.setdefault(x, next(inside, None) or known[starts[0]].piece.at(x, p))
