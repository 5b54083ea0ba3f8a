"""Where the margins of images vanish, to first order and between two images.

The loops are compiled: an image has some fifty margins, too few for numpy to be fast.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit, part
from woodpecker.engine.ends import WORTH
from woodpecker.maps.pieces import Image

REACH, NEAREST, DEPTH = range(3)  # questions about the margins of one image
DIP, FIRST = range(2)  # and of two
FAR = 2.0**52  # larger distances count as infinite: beside them 1 is lost by rounding
FLAT = 1e-200  # smaller slopes of a margin count as zero: a quotient would overflow
CUBIC_STEPS = 60  # of Newton's method: a handful, or bisections down to rounding
ROUNDED_PART = 1e-15  # rounding of a place in (0, 1)
# Beside a square root the slope at one end is larger than this many times the change of the margin
# and its slope at the other end.
BESIDE_ROOT = 10.0


def reach(image: Image, side: float) -> tuple[float, int]:
    """First-order distance of the nearest border on a side, and its code; (inf, -1) if none."""
    away, code = _of_one(REACH, image, side)
    return (away, code) if code >= 0 and not away >= FAR else (math.inf, -1)


def nearest_code(image: Image, side: int) -> int:
    """The margin nearest to zero of those that fall to a side; -1 if none does."""
    return _of_one(NEAREST, image, float(side))[1]


def depth(image: Image, ignored: int = -1) -> float:
    """Distance in x, to first order, by which an image lies inside its piece; negative outside."""
    return _of_one(DEPTH, image, 1.0, ignored)[0]


def is_within(image: Image) -> bool:
    """Whether there is a value, and no margin is negative."""
    margins = image.margins
    return not image.reason and (not len(margins) or bool(margins[margins.argmin()] >= 0.0))


def lowest_dip(here: Image, there: Image, way: float) -> float | None:
    """Where, as a part of the way between images inside, a margin may dip to zero; None if none.

    A margin that falls at the first and rises at the second is a cubic, or, beside a square root, a
    parabola in the root of the distance. It is the middle if a margin that only one image has leads
    below zero.
    """
    part, found = _of_two(DIP, here, there, way)
    return part if found >= 0 else None


def first_part(here: Image, there: Image, way: float) -> tuple[float, int]:
    """Where, as a part of the way, a margin negative at the second image first vanishes, and which.

    The margin is -1 if none is clear.
    """
    return _of_two(FIRST, here, there, way)


def _of_one(task: int, image: Image, side: float, ignored: int = -1) -> tuple[float, int]:
    slopes = np.asfortranarray(image.gradients)
    return _nearest(task, ignored, side, image.margins, slopes, image.causes)


def _of_two(task: int, here: Image, there: Image, way: float) -> tuple[float, int]:
    return _between(
        task, way, here.margins, np.asfortranarray(here.gradients), here.causes,
        there.margins, np.asfortranarray(there.gradients), there.causes,
    )  # fmt: skip


@jit
def _nearest(
    task: int, ignored: int, side: float, margins: Floats, slopes: Floats, causes: Ints
) -> tuple[float, int]:
    """First-order distance of the nearest root of a margin, and its code or -1."""
    # REACH and NEAREST look at margins (m,) that fall to the side, DEPTH at all but ``ignored``;
    # ``slopes`` (m, 2) are derivatives in x and the parameter, ``causes`` (m,) the codes.
    nearest, which = math.inf, -1
    for k in range(len(margins)):
        rate = side * slopes[k, 0]
        away = math.inf
        if task == DEPTH:
            if causes[k] == ignored:
                continue
            if abs(rate) > FLAT:
                away = margins[k] / abs(rate)
            elif margins[k] < 0.0:
                away = -math.inf
        elif rate < -FLAT:
            away = abs(margins[k] / rate) if task == NEAREST else -margins[k] / rate
        if away < nearest:
            nearest, which = away, causes[k]
    return nearest, which


@jit
def _between(
    task: int, way: float, a: Floats, slopes: Floats, causes: Ints, b: Floats,
    slopes_there: Floats, causes_there: Ints,
) -> tuple[float, int]:  # fmt: skip
    """Where, as a part of the way, a margin dips or vanishes, and its code or -1; codes ascend."""
    i, j, best, part, which = 0, 0, 1.0 if task == FIRST else 0.0, 1.0, -1
    while i < len(a) or j < len(b):
        here = i < len(a) and (j >= len(b) or causes[i] <= causes_there[j])
        there = j < len(b) and (i >= len(a) or causes_there[j] <= causes[i])
        x, y, dx, dy, cause = math.nan, math.nan, math.nan, math.nan, -1
        if here:
            x, dx, cause = a[i], way * slopes[i, 0], causes[i]
            i += 1
        if there:
            y, dy, cause = b[j], way * slopes_there[j, 0], causes_there[j]
            j += 1
        if task == FIRST:
            s = _vanishes(x, dx, y, dy) if there and y < 0.0 else 2.0
            if s <= best:
                best, part, which = s, s, cause
        elif here and there:
            s, below = _dip(x, dx, y, dy)
            if below < best:
                best, part, which = below, s, cause
        elif (here and x > 0.0 and x + dx < 0.0) or (there and y > 0.0 and y - dy < 0.0):
            return 0.5, cause
    return part, which


@part
def _vanishes(a: float, da: float, b: float, db: float) -> float:
    """Where, as a part of the way, a margin vanishes that is b < 0 at its end; 2 if unclear."""
    # It is a cubic with these values and slopes, a straight line if it begins on the way (a is
    # nan).
    if a <= 0.0:
        return 2.0
    if not a > 0.0:
        return 1.0 - b / db if b > db else 0.5
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    low, high, s = 0.0, 1.0, a / (a - b)
    for _ in range(CUBIC_STEPS):
        f, slope = a + s * (da + s * (c2 + s * c3)), da + s * (2.0 * c2 + 3.0 * s * c3)
        if f > 0.0:
            low = s
        else:
            high = s
        after = s - f / slope if slope != 0.0 else low
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - s) <= ROUNDED_PART:
            break
        s = after
    return s


@part
def _dip(a: float, da: float, b: float, db: float) -> tuple[float, float]:
    """Where on the way a margin is least, and by how much it lies below WORTH of its ends."""
    worth = WORTH * min(a, b)
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    slow, fast = min(abs(da), abs(db)), max(abs(da), abs(db))
    if fast > BESIDE_ROOT * (abs(b - a) + slow):  # a square root: a parabola in it
        near, rate, far = (a, 2.0 * da, b) if fast == abs(db) else (b, -2.0 * db, a)
        bend = far - near - rate
        u = min(1.0, -rate / (2.0 * bend)) if bend > 0.0 > rate else 1.0
        s = (1.0 - u) ** 2
        return (1.0 - s if fast == abs(db) else s), near + u * (rate + u * bend) - worth
    root = c2 * c2 - 3.0 * c3 * da
    if root > 0.0 and min(a + da / 3.0, b - db / 3.0) < worth:  # its control points
        root = math.sqrt(root)
        s = -da / (c2 + root) if c2 >= 0.0 else (root - c2) / (3.0 * c3) if c3 != 0.0 else 0.0
        least = a + s * (da + s * (c2 + s * c3))
        if 0.0 < s < 1.0 and least < worth:
            return s, least - worth
    return 0.0, 0.0
