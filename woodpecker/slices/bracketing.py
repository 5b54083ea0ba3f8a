"""Roots of scalar functions along a piece, between two of its samples."""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

from woodpecker.maps.pieces import Image
from woodpecker.slices.extents import Knot
from woodpecker.slices.margins import depth

SLACK = 1e-6  # fraction of the interval by which depth may be negative inside: half of the digits
STARTS = 4  # most known points from which a piece is continued to a new one, nearest first


def bracketed(
    a: Knot, b: Knot, p: float, function: Callable[[Image, float], float]
) -> tuple[float, Image] | None:
    """The root of ``function(image, x)`` between two samples of a piece; None without a bracket."""
    images = {a.x: a.image, b.x: b.image}

    def value(at: float) -> float:
        return function(_image_near(images, at, p), at)

    if not value(a.x) * value(b.x) <= 0.0:
        return None
    finest = max(math.ulp(a.x), math.ulp(b.x))  # of both: ulp(0) alone could never be reached
    try:
        root = float(brentq(value, a.x, b.x, xtol=finest))
    except ValueError:  # the piece has no value on the way
        return None
    return root, _image_near(images, root, p)


def _image_near(known: dict[float, Image], x: float, p: float) -> Image:
    """The image of x under a piece continued from the nearest known point; it is added to them."""
    # If that fails or ends outside of the margins, as it may beside a singularity, the piece is
    # continued from the next nearest point.
    if x in known:
        return known[x]
    slack = SLACK * (max(known) - min(known))
    starts = sorted((at for at in known if not known[at].reason), key=lambda at: abs(at - x))
    tried = (known[start].piece.at(x, p) for start in starts[:STARTS])
    inside = (each for each in tried if not each.reason and depth(each) >= -slack)
    return known.setdefault(x, next(inside, None) or known[starts[0]].piece.at(x, p))
