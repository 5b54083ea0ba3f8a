"""Where a function along a piece vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

from woodpecker.maps.pieces import Image
from woodpecker.slices.extents import Knot
from woodpecker.slices.margins import depth

SLACK = 1e-6  # of an interval: a point of it may seem to lie outside; half of the digits
STARTS = 4  # points from which a piece is continued at most


def bracketed(
    a: Knot, b: Knot, p: float, function: Callable[[Image, float], float]
) -> tuple[float, Image] | None:
    """Where a function of a piece vanishes between two samples; None if it does not.

    The function takes an image and its point.
    """
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
    """The image of a point between known ones of a piece, from the nearest; it becomes known.

    Beside a singularity a piece may be continued the wrong way, or lost: it is outside of its
    margins then, and is tried from the next known point.
    """
    if x in known:
        return known[x]
    slack = SLACK * (max(known) - min(known))
    starts = sorted((at for at in known if not known[at].reason), key=lambda at: abs(at - x))
    tried = (known[start].piece.at(x, p) for start in starts[:STARTS])
    inside = (each for each in tried if not each.reason and depth(each) >= -slack)
    return known.setdefault(x, next(inside, None) or known[starts[0]].piece.at(x, p))
