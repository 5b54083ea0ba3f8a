"""Borders at one parameter: how far a piece reaches, and what lies beyond."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

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


STEEP = 1e6  # a slope beside a border above which it is that of a square root: the derivative of one,
# rounded at the border, is about 1e8


def reach(image: Image, side: float) -> tuple[float, int]:
    """How far the margins of an image let x move to a side, to first order, and which stops it."""
    rate = side * image.gradients[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where(rate < 0.0, -image.margins / rate, OUT_OF_REACH)
    k = int(np.argmin(away)) if len(away) else -1
    return (math.inf, -1) if k < 0 or away[k] >= OUT_OF_REACH else (float(away[k]), int(image.causes[k]))


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

    Where the piece ends in a square root its value is a + b sqrt(away), so b sqrt(away) is twice the slope
    times the distance.
    """
    return image._replace(value=image.value - 2.0 * image.slope * away, slope=math.copysign(math.inf, image.slope * away))


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
        if there.reason or (len(there.margins) and float(there.margins.min()) < 0.0):
            root = _first_root(here, xs[-1], there, to, p, settings)
            if root is not None:
                xs.append(root[0]), images.append(root[1])
                return Reach(tuple(xs), tuple(images), root[2])
            step = 0.25 * abs(to - xs[-1])
            if step < least:
                return Reach(tuple(xs), tuple(images), -1)
            continue
        dip = lowest_dip(here, there, to - xs[-1], np.array([1.0, 0.0]), np.array([1.0, 0.0]))
        if dip is not None and dip * step > least:
            step = dip * abs(to - xs[-1]) / 2.0
            continue
        xs.append(to), images.append(there)
    return Reach(tuple(xs), tuple(images), -1)


def _first_root(
    here: Image, x: float, there: Image, to: float, p: float, settings: Settings
) -> tuple[float, Image, int] | None:
    """Where between two points the first margin vanishes; None if that is not clear yet."""
    tolerance = settings.nearest * settings.x_scale
    if there.reason:
        codes = [reach(here, math.copysign(1.0, to - x))[1]]
    else:
        codes = there.causes[there.margins < 0.0].tolist()
    for _ in range(MEETING_MOST):
        roots = []
        for code in codes:
            before, after = here.margin(code), there.margin(code)
            if not before > 0.0 or after > 0.0:
                return None
            found = bracketed(
                here, x, to, p, lambda image, _, c=code: (image.margin(c), image.gradient(c)[0])
            )
            if found is None:
                return None
            roots.append((*found, code))
        best = min(roots, key=lambda root: abs(root[0] - x))
        to, there = best[:2]
        away = there.margins < -tolerance * np.abs(there.gradients[:, 0])
        codes = [code for code in there.causes[away].tolist() if code != best[2]]
        if not codes:
            return best
    return None


MEETING_MOST = 8  # borders that may lie between two points, one before the other


def bracketed(
    here: Image, x: float, to: float, p: float,
    function: Callable[[Image, float], tuple[float, float]],
) -> tuple[float, Image] | None:
    """Where a function of a piece vanishes between two points: Newton's method kept inside.

    Parameters
    ----------
    here, x
        The image of the first point, where the function has the other sign than at ``to``. The
        piece need not have a value from some point on.
    function
        Value and slope of the function from an image and its point.

    Returns
    -------
    The point and its image, which has a value; None if the function has none at the first point.
    """
    value, slope = function(here, x)
    if not math.isfinite(value):
        return None
    sign, low, high, best = math.copysign(1.0, value), x, to, (x, here)
    at = x
    for _ in range(HALVINGS):
        trial = at - value / slope if slope != 0.0 else math.nan
        if not min(low, high) < trial < max(low, high):
            trial = 0.5 * (low + high)
        if trial in (low, high) or abs(trial - at) <= math.ulp(at):
            break
        at, image = trial, best[1].piece.at(trial, p)
        value, slope = function(image, at)
        if image.reason or not math.isfinite(value):
            high, (at, image) = at, best
            value, slope = function(image, at)
            slope = 0.0
            continue
        best = at, image
        if value == 0.0:
            break
        low, high = (at, high) if value * sign > 0.0 else (low, at)
    return best


HALVINGS = 100  # more than enough for all doubles between two points


def lowest_dip(
    here: Image, there: Image, step: float, along: Floats, along_there: Floats
) -> float | None:
    """Where between two points a margin may come closest to zero, as a part of the way; or None.

    Both points lie inside. A margin that falls at the first and rises at the second is a cubic in
    between; a minimum that takes away most of it is worth a look.
    """
    if here.causes.shape == there.causes.shape and (here.causes == there.causes).all():
        one, other = slice(None), slice(None)
    else:
        _, one, other = np.intersect1d(here.causes, there.causes, return_indices=True)
    a, b = here.margins[one], there.margins[other]
    da = step * (here.gradients[one] @ along)
    db = step * (there.gradients[other] @ along_there)
    may = (da < 0.0) & (db > 0.0)
    if not may.any():
        return None
    a, b, da, db = a[may], b[may], da[may], db[may]
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = np.sqrt(np.maximum(0.0, c2 * c2 - 3.0 * c3 * da))
    s = -da / (c2 + root)
    least = a + s * (da + s * (c2 + s * c3))
    k = int(np.argmin(least / np.minimum(a, b)))
    return float(s[k]) if least[k] < WORTH * min(a[k], b[k]) else None


WORTH = 0.25  # a margin that falls below this part of its smaller end is looked at
