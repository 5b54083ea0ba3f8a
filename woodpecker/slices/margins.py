"""Roots of the margins of a piece: to first order at one image, and between two images.

The loops are compiled: an image has some fifty margins, too few for numpy to be fast.
"""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit, part
from woodpecker.engine.ends import DIP_DEPTH
from woodpecker.maps.pieces import Image

REACH, NEAREST, DEPTH = range(3)  # tasks of the loop over the margins of one image
DIP, FIRST = range(2)  # tasks of the loop over those of two images
FAR = 2.0**52  # larger distances count as infinite: added to them, 1 is lost by rounding
FLAT = 1e-200  # smaller slopes of a margin count as zero, as dividing by them would overflow
CUBIC_STEPS = 60  # Newton steps for a root of a cubic: a handful, or bisections down to rounding
ROUNDED_PART = 1e-15  # rounding of a root in (0, 1)
# A margin has a square root at one end if its slope there is so many times larger than its change
# and its slope at the other end together.
BESIDE_ROOT = 10.0


def next_border(image: Image, side: float) -> tuple[float, int]:
    """First-order distance of the next border on a side, and its code; (inf, -1) if none."""
    away, code = _of_one(REACH, image, side)
    return (away, code) if code >= 0 and not away >= FAR else (math.inf, -1)


def nearest_code(image: Image, side: int) -> int:
    """The code of the margin that falls to a side and has the nearest root; -1 if none falls."""
    return _of_one(NEAREST, image, float(side))[1]


def depth(image: Image, ignored: int = -1) -> float:
    """First-order distance in x by which an image lies inside of its piece; negative outside."""
    return _of_one(DEPTH, image, 1.0, ignored)[0]


def is_within(image: Image) -> bool:
    """Whether an image has a value, and no margin is negative."""
    margins = image.margins
    return not image.reason and (not len(margins) or bool(margins[margins.argmin()] >= 0.0))


def lowest_dip(here: Image, there: Image, way: float) -> float | None:
    """Where a margin may dip to zero between two images inside, as a fraction of the way, or None.

    The margin is interpolated by a cubic or, beside a square root, by a parabola in the root of the
    distance. If only one image has it, and it falls below zero along its tangent before the other,
    the answer is the middle.
    """
    part, found = _of_two(DIP, here, there, way)
    return part if found >= 0 else None


def first_part(here: Image, there: Image, way: float) -> tuple[float, int]:
    """The first root of margins that are negative at the second image, and the code of its margin.

    The root is a fraction of the way; the code is -1 if the margins do not tell.
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
    """First-order distance of the nearest root of a margin, and the code of the margin or -1."""
    # REACH and NEAREST consider margins (m,) that fall to the side, DEPTH all except ``ignored``.
    # ``slopes`` (m, 2) are derivatives in x and the parameter, ``causes`` (m,) the codes. Only
    # NEAREST takes roots on both sides of the point, in modulus.
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
    """Where a margin dips or vanishes, as a fraction of the way, and its code or -1."""
    # Margins of both images are merged by their codes, which ascend; some exist at one end only.
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
    """The root of a margin that is b < 0 at the end, as a fraction of the way; 2 if unclear."""
    # It is that of the cubic with these values and slopes; of the tangent at the end if the margin
    # exists only there (a is nan).
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
    """Where a margin is least, and its value there less DIP_DEPTH times that at its lower end."""
    worth = DIP_DEPTH * min(a, b)
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    slow, fast = min(abs(da), abs(db)), max(abs(da), abs(db))
    # The square root lies at the end where the slope is large. With 1 - s = (1 - u)^2, s the part
    # of the way from the other end, the margin is a parabola in u, and ds/du = 2 at that end.
    if fast > BESIDE_ROOT * (abs(b - a) + slow):
        near, rate, far = (a, 2.0 * da, b) if fast == abs(db) else (b, -2.0 * db, a)
        bend = far - near - rate
        u = min(1.0, -rate / (2.0 * bend)) if bend > 0.0 > rate else 1.0
        s = (1.0 - u) ** 2
        return (1.0 - s if fast == abs(db) else s), near + u * (rate + u * bend) - worth
    root = c2 * c2 - 3.0 * c3 * da
    # A cubic lies above the least of its Bezier control points: this settles most margins.
    if root > 0.0 and min(a + da / 3.0, b - db / 3.0) < worth:
        root = math.sqrt(root)
        s = -da / (c2 + root) if c2 >= 0.0 else (root - c2) / (3.0 * c3) if c3 != 0.0 else 0.0
        least = a + s * (da + s * (c2 + s * c3))
        if 0.0 < s < 1.0 and least < worth:
            return s, least - worth
    return 0.0, 0.0
