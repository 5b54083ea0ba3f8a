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


STEEP = (
    1e6  # a slope beside a border above which it is that of a square root: the derivative of one,
)
# rounded at the border, is about 1e8


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
    xs, images = [x], [image]
    longest = settings.max_step * settings.x_scale
    least = settings.nearest * settings.x_scale
    step = longest
    while xs[-1] != limit:
        here = images[-1]
        ahead, code = reach(here, side)
        if ahead <= 0.0:
            return Reach(tuple(xs), tuple(images), code)
        step = min(2.0 * step, longest, BEYOND * ahead + least)
        to = xs[-1] + side * step
        if side * (to - limit) >= 0.0:
            to = limit
        there = here.piece.at(to, p)
        code = -1
        if there.reason or (len(there.margins) and float(there.margins.min()) < 0.0):
            root = _first_root(here, xs[-1], there, to, p, settings)
            if root is None:
                step = 0.25 * abs(to - xs[-1])
                if step < least:
                    break
                continue
            to, there, code = root
        ahead = abs(to - xs[-1])
        dip = lowest_dip(here, there, to - xs[-1], IN_X, IN_X)
        if dip is not None and dip * ahead > least:
            step = 0.5 * dip * ahead  # twice that is tried
            continue
        xs.append(to)
        images.append(there)
        if code >= 0:
            return Reach(tuple(xs), tuple(images), code)
    return Reach(tuple(xs), tuple(images), -1)


def _first_root(
    here: Image, x: float, there: Image, to: float, p: float, settings: Settings
) -> tuple[float, Image, int] | None:
    """Where between two points the first margin vanishes; None if that is not clear yet.

    Where the piece has no value from some point on, the interval is halved until it has one.
    """
    tolerance = settings.nearest * settings.x_scale
    code = -1
    while there.reason:
        if abs(to - x) <= tolerance:
            return x, here, reach(here, math.copysign(1.0, to - x))[1]
        middle = 0.5 * (x + to)
        image = here.piece.at(middle, p)
        if image.reason or (len(image.margins) and image.margins.min() < 0.0):
            to, there = middle, image
        else:
            x, here = middle, image
    for _ in range(MEETING_MOST):
        away = there.margins < -tolerance * np.abs(there.gradients[:, 0])
        fallen = [int(c) for c in there.causes[away] if c != code]
        if not fallen:
            return None if code < 0 else (to, there, code)
        ends = {x: here, to: there}
        roots = [(root, c) for c in fallen if (root := _margin_root(ends, x, to, p, c, tolerance))]
        if len(roots) < len(fallen):
            return None
        (to, there), code = min(roots, key=lambda found: abs(found[0][0] - x))
    return None


MEETING_MOST = 8  # borders that may lie between two points, one before the other


def _margin_root(
    ends: dict[float, Image], x: float, to: float, p: float, code: int, tolerance: float
) -> tuple[float, Image] | None:
    return bracketed(
        ends, x, to, p, lambda image, _: (image.margin(code), float(image.gradient(code)[0])),
        tolerance,
    )  # fmt: skip


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
    between; a minimum that takes away most of it is worth a look.
    """
    a, b = here.margins, there.margins
    da, db = step * (here.gradients @ along), step * (there.gradients @ along_there)
    if not np.array_equal(here.causes, there.causes):
        _, one, other = np.intersect1d(here.causes, there.causes, return_indices=True)
        a, b, da, db = a[one], b[other], da[one], db[other]
    may = (da < 0.0) & (db > 0.0)
    if not may.any():
        return None
    a, b, da, db = a[may], b[may], da[may], db[may]
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = np.sqrt(np.maximum(0.0, c2 * c2 - 3.0 * c3 * da))
    s = np.clip(-da / np.maximum(c2 + root, -da), 0.0, 1.0)  # where the cubic's slope vanishes
    least = a + s * (da + s * (c2 + s * c3))
    k = int(np.argmin(least / np.minimum(a, b)))
    return float(s[k]) if least[k] < WORTH * min(a[k], b[k]) else None


WORTH = 0.25  # a margin that falls below this part of its smaller end is looked at
