"""Where a function along a piece vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from scipy.optimize import brentq

from woodpecker.engine.pieces import Image


def bracketed(
    ends: Mapping[float, Image],
    x: float,
    to: float,
    p: float,
    function: Callable[[Image, float], tuple[float, float]],
    tolerance: float = 0.0,
) -> tuple[float, Image] | None:
    """Where a function of a piece vanishes between two points; None if it does not.

    Newton's method as long as it stays inside, for a few steps; then Brent's.

    Parameters
    ----------
    ends
        Images of the two points.
    x, to
        The points; Newton's method starts from the first.
    function
        The function and its slope, of an image and its point; the function changes its sign
        between the two points.
    tolerance
        How closely, if not to the last bit.
    """
    images = dict(ends)
    finest = max(tolerance, math.ulp(x))

    def value(at: float) -> float:
        return function(image_near(images, at, p), at)[0]

    first, at = value(x), x
    low, high = x, to
    for _ in range(NEWTON):
        f, slope = function(images[at], at)
        trial = at - f / slope if slope != 0.0 else math.nan
        if abs(trial - at) <= finest:
            return at, images[at]
        if not min(low, high) < trial < max(low, high):
            break
        at = trial
        f = value(at)
        if not math.isfinite(f):
            return None
        low, high = (at, high) if f * first > 0.0 else (low, at)
    if not value(low) * value(high) <= 0.0:
        return None
    try:
        root = float(brentq(value, low, high, xtol=finest))
    except ValueError:  # the piece has no value on the way
        return None
    return root, image_near(images, root, p)


def image_near(known: dict[float, Image], x: float, p: float) -> Image:
    """The image of a point under a piece, from the nearest known one; it becomes known.

    Where a piece finds no value from so far, it is led there in smaller steps.
    """
    for _ in range(HALVINGS):
        if x in known:
            return known[x]
        start = min((at for at in known if not known[at].reason), key=lambda at: abs(at - x))
        at = x
        for _ in range(HALVINGS):
            image = known[start].piece.at(at, p)
            if not image.reason:
                break
            at = 0.5 * (start + at)
        known[at] = image
        if image.reason:
            break
    return known.setdefault(x, image)


HALVINGS = 8  # of a way on which a piece is lost: after that it is said to have no value
NEWTON = 6  # steps after which Newton's method is given up: five are enough where it converges
