"""Where a function along a piece vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from scipy.optimize import brentq

from woodpecker.maps.pieces import Image
from woodpecker.slices.margins import depth

NEWTON = 6  # steps after which Brent's method takes over: no result, but work, depends on it
SLACK = 1e-6  # of an interval: a point of it may seem to lie outside; half of the digits
KNOWN_STARTS = 4  # points from which a piece is continued at most
WAY_HALVINGS = 8  # of the way, before a piece is said to have no value at its end


def bracketed(
    ends: Mapping[float, Image],
    x: float,
    to: float,
    p: float,
    function: Callable[[Image, float], tuple[float, float]],
    tolerance: float = 0.0,
) -> tuple[float, Image] | None:
    """Where a function of a piece vanishes between two points; None if it does not.

    Newton's method from the first as long as it stays inside, for a few steps; then Brent's. The
    function, of an image and its point, has a slope; ``ends`` are the images of both points.
    """
    images = dict(ends)
    finest = max(tolerance, math.ulp(x))

    def value(at: float) -> float:
        return function(image_near(images, at, p), at)[0]

    first, at = value(x), x
    low, high = x, to
    for _ in range(NEWTON):
        f, slope = function(images[at], at)
        steps = slope != 0.0 and math.isfinite(slope)  # it is infinite beside a singularity
        trial = at - f / slope if steps else math.nan
        if abs(trial - at) <= finest:
            if at in (x, to) and f != 0.0:  # beside a singularity the slope says nothing
                break
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
    """The image of a point between known ones of a piece, from the nearest; it becomes known.

    Beside a singularity a piece may be continued the wrong way, or lost: it is outside of its
    margins then, and is tried from the next known point, and at last in smaller steps.
    """
    if x in known:
        return known[x]
    slack = SLACK * (max(known) - min(known))
    starts = sorted((at for at in known if not known[at].reason), key=lambda at: abs(at - x))
    starts = starts[:KNOWN_STARTS]
    for start in starts:
        image = known[start].piece.at(x, p)
        if not image.reason and depth(image) >= -slack:
            return known.setdefault(x, image)
    for start in starts:
        at, here = x, known[start]
        for _ in range(WAY_HALVINGS):
            at = 0.5 * (start + at)
            image = here.piece.at(at, p)
            if not image.reason and depth(image) >= -slack:
                known[at] = image
                there = image.piece.at(x, p)
                if not there.reason and depth(there) >= -slack:
                    return known.setdefault(x, there)
                start, here, at = at, image, x
    return known.setdefault(x, known[starts[0]].piece.at(x, p))
