"""Borders at one parameter: how far a piece reaches, and what lies beyond."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats
from woodpecker.engine.pieces import Image, PiecewiseMap
from woodpecker.engine.settings import Settings

OUT_OF_REACH = 2.0**52  # a distance that is infinite for all purposes
BEYOND = 1.25  # a step over a border that is ahead is this part of the way to it


class BorderKind(Enum):
    """What a map does at a border of two of its pieces."""

    JUMP = "the values differ"
    KINK = "the values agree, the slopes differ"
    GRAZING = "the values agree, one slope is infinite"
    SMOOTH = "values and slopes agree"
    LOST = "there is no value on one side"


@dataclass(frozen=True, slots=True, eq=False)
class Border:
    """A border as one piece meets it.

    Attributes
    ----------
    x, p
        Where it is.
    inner, code
        The image at the border under the piece that was followed, and its margin that vanishes.
    side
        On which side of x the border is met: +1 if that piece lies at smaller x.
    outer, outer_code
        The image at the border under the piece beyond, and its margin that vanishes; -1 if it is
        not known.
    """

    x: float
    p: float
    inner: Image
    code: int
    side: int
    outer: Image
    outer_code: int

    @property
    def jump(self) -> float:
        """Value beyond less value inside; nan if there is none beyond."""
        return self.outer.value - self.inner.value

    @property
    def cause(self) -> str:
        """What happens there."""
        return self.inner.piece.cause(self.code)

    def kind(self, settings: Settings) -> BorderKind:
        """What the map does there."""
        if math.isnan(self.jump):
            return BorderKind.LOST
        if abs(self.jump) > settings.jump * settings.x_scale:
            return BorderKind.JUMP
        one, other = self.inner.slope, self.outer.slope
        if not (abs(one) < STEEP and abs(other) < STEEP):
            return BorderKind.GRAZING
        size = max(1.0, abs(one), abs(other))
        return BorderKind.KINK if abs(one - other) > settings.kink * size else BorderKind.SMOOTH


# A slope beside a border above which it is that of a square root: the derivative of one, rounded at
# the border, is about 1e8.
STEEP = 1e6


def reach(image: Image, side: float) -> tuple[float, int]:
    """How far the margins of an image let x move to a side, to first order, and which stops it."""
    rate = side * image.gradients[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where(rate < 0.0, -image.margins / rate, OUT_OF_REACH)
    k = int(np.argmin(away)) if len(away) else -1
    return (
        (math.inf, -1)
        if k < 0 or away[k] >= OUT_OF_REACH
        else (float(away[k]), int(image.causes[k]))
    )


def depth(image: Image, ignored: int = -1) -> float:
    """Distance in x by which an image lies inside its piece; negative if it lies outside.

    To first order, by the margin that is nearest to its border.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        away = image.margins / np.abs(image.gradients[:, 0])
    away = np.where(np.isnan(away), np.inf, away)[image.causes != ignored]
    return float(away.min()) if len(away) else math.inf


def nearest_code(image: Image, side: int) -> int:
    """The margin nearest to vanishing of those that fall to a side; -1 if none does."""
    rate = side * image.gradients[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where(rate < 0.0, np.abs(image.margins / rate), np.inf)
    k = int(np.argmin(away)) if len(away) else -1
    return -1 if k < 0 or not np.isfinite(away[k]) else int(image.causes[k])


def beyond(
    map_: PiecewiseMap, x: float, p: float, side: int, settings: Settings
) -> tuple[Image, int]:
    """The image of a border under the piece that lies on a side of it, and which margin vanishes.

    The piece beyond is asked for at a distance. If its margins say that it ends before the border,
    there is another in between, and the distance shrinks.
    """
    away = settings.beside * settings.x_scale
    least = settings.nearest * settings.x_scale
    found, code = map_.at(x + side * away, p), -1
    while True:
        there = found.piece.at(x, p) if not found.reason else found
        if found.reason or there.reason:
            there = _limit(found, side * away)
        elif depth(there) >= -max(least, THIN * away):
            return there, nearest_code(there, -side)
        code = nearest_code(there, -side)
        if away <= least:
            return there, code
        away *= 0.1
        found = map_.at(x + side * away, p)


THIN = 1e-3  # a piece beside a border that is thinner than this part of a distance is passed over


def _limit(image: Image, away: float) -> Image:
    """An image next to a border that its piece does not reach, taken to the border.

    Where the piece ends in a square root its value is a + b sqrt(away), and b sqrt(away) is twice
    the slope times the distance.
    """
    return image._replace(
        value=image.value - 2.0 * image.slope * away,
        slope=math.copysign(math.inf, image.slope * away),
    )


IN_X = np.array([1.0, 0.0])  # the direction of x, in (x, p)


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """How far a piece reaches from a point to one side.

    Attributes
    ----------
    x, images
        Samples on the way, from the point on; the last lies at the end.
    code
        The margin that vanishes at the end; -1 if the limit of the search is met, or the piece has
        no value further on.
    """

    x: tuple[float, ...]
    images: tuple[Image, ...]
    code: int

    @property
    def end(self) -> float:
        """Where the piece ends."""
        return self.x[-1]


def reach_of(
    image: Image, x: float, p: float, side: int, limit: float, settings: Settings
) -> Reach:
    """Follow a piece to one side until a margin vanishes or a limit is met."""
    xs, images, code = [x], [image], INSIDE
    longest = settings.max_step * settings.x_scale
    least = settings.nearest * settings.x_scale
    while xs[-1] != limit:
        ahead, code = reach(images[-1], side)
        if ahead <= 0.0:
            break
        found = _step(
            images[-1], xs[-1], p, side, limit, min(longest, BEYOND * ahead + least), least
        )
        if found is None:
            code = INSIDE
            break
        to, there, code = found
        xs.append(to)
        images.append(there)
        if code != INSIDE:
            break
    return Reach(tuple(xs), tuple(images), max(code, -1))


def _step(
    here: Image, x: float, p: float, side: int, limit: float, step: float, least: float
) -> tuple[float, Image, int] | None:
    """The next sample, not farther than a step, and which margin vanishes there.

    None if no step is short enough.
    """
    while step >= least:
        to = x + side * step
        if side * (to - limit) >= 0.0:
            to = limit
        there, code = here.piece.at(to, p), INSIDE
        if not _is_inside(there):
            root = _first_root(here, x, there, to, p, least)
            if root is None:
                step = 0.25 * abs(to - x)
                continue
            to, there, code = root
        length = abs(to - x)
        dip = lowest_dip(here, there, to - x, IN_X, IN_X)
        if dip is None or dip * length <= least:
            return to, there, code
        step = dip * length
    return None


def _is_inside(image: Image) -> bool:
    return not image.reason and (not len(image.margins) or bool(image.margins.min() >= 0.0))


def _first_root(
    here: Image, x: float, there: Image, to: float, p: float, tolerance: float
) -> tuple[float, Image, int] | None:
    """Where between two points the first margin vanishes; None if that is not clear yet.

    Each margin that is negative at the far end is a cubic in between; the point where the first of
    them vanishes takes the place of one of the ends. Where the piece has no value at the far end
    the interval is halved until it has one.
    """
    low, high = (x, here), (to, there)
    for k in range(ROOT_STEPS):
        way = high[0] - low[0]
        ahead, code = reach(low[1], math.copysign(1.0, way))
        if abs(way) <= tolerance or (ahead <= tolerance and (k > 0 or high[1].reason)):
            return *low, code if ahead <= 2.0 * tolerance else NO_VALUE
        ahead /= abs(way)
        if high[1].reason:
            part = ahead if ahead < 1.0 else (LOST if k == 0 else 0.5)
        else:
            part, first = _first_part(low[1], high[1], way)
            if first < 0:
                return None
            if ahead < LOST or (ahead < 1.0 and not high[1].margin(code) < 0.0):
                part = ahead
            else:
                code = first
        trial = low[0] + (part if k % 3 < 2 else 0.5) * way
        for at, image in (high, low):
            if abs(trial - at) <= tolerance and not math.isnan(image.margin(code)):
                return at, image, code
        image = low[1].piece.at(trial, p)
        low, high = ((trial, image), high) if _is_inside(image) else (low, (trial, image))
    return None


def _first_part(low: Image, high: Image, length: float) -> tuple[float, int]:
    """Where the first margin vanishes, as a part of the way between two images, and which."""
    best, code = 1.0, -1
    for k in np.flatnonzero(high.margins < 0.0):
        c = int(high.causes[k])
        a, da = low.margin(c), length * float(low.gradient(c)[0])
        b, db = float(high.margins[k]), length * float(high.gradients[k, 0])
        if a <= 0.0:
            continue
        s = 1.0 - b / db if b > db else 0.5  # for one that is not there at the near end
        if a > 0.0:
            s = _root_of_cubic(a, da, b, db)
        if s <= best:
            best, code = s, c
    return best, code


def _root_of_cubic(a: float, da: float, b: float, db: float) -> float:
    """The root in (0, 1) of a cubic with these values, a > 0 > b, and slopes at 0 and 1."""
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    low, high, s = 0.0, 1.0, a / (a - b)
    for _ in range(ROOT_STEPS):
        f, slope = a + s * (da + s * (c2 + s * c3)), da + s * (2.0 * c2 + 3.0 * s * c3)
        low, high = (s, high) if f > 0.0 else (low, s)
        after = s - f / slope if slope != 0.0 else 0.5 * (low + high)
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - s) <= 1e-15:
            break
        s = after
    return s


INSIDE, NO_VALUE = -1, -2  # instead of a margin that vanishes
LOST = 0.125  # part of a step that is tried where a piece has no value at its end
ROOT_STEPS = 60  # every third halves, so that 20 halvings are left where cubics mislead


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


def lowest_dip(
    here: Image, there: Image, step: float, along: Floats, along_there: Floats
) -> float | None:
    """Where between two points a margin may come closest to zero, as a part of the way; or None.

    Both points lie inside. A margin that falls at the first and rises at the second is a cubic in
    between; a minimum that takes away most of it is worth a look. So is the middle if a margin that
    only one of the points has leads below zero.
    """
    a, b = here.margins, there.margins
    da, db = step * (here.gradients @ along), step * (there.gradients @ along_there)
    if not np.array_equal(here.causes, there.causes):
        ends = (a > 0.0) & (a + da < 0.0), (b > 0.0) & (b - db < 0.0)
        _, one, other = np.intersect1d(here.causes, there.causes, return_indices=True)
        if np.delete(ends[0], one).any() or np.delete(ends[1], other).any():
            return 0.5
        a, b, da, db = a[one], b[other], da[one], db[other]
    may = (da < 0.0) & (db > 0.0)
    if not may.any():
        return None
    a, b, da, db = a[may], b[may], da[may], db[may]
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = np.sqrt(np.maximum(0.0, c2 * c2 - 3.0 * c3 * da))
    s = np.clip(-da / np.maximum(c2 + root, -da), 0.0, 1.0)  # where the cubic's slope vanishes
    least = a + s * (da + s * (c2 + s * c3))
    k = int(np.argmin(least - WORTH * np.minimum(a, b)))
    return float(s[k]) if least[k] < WORTH * min(a[k], b[k]) else None


WORTH = 0.25  # a margin that falls below this part of its smaller end is looked at
