"""Borders at one parameter, and the images on both sides of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.rooted import ROOTED
from woodpecker.maps.pieces import Image, PiecewiseMap
from woodpecker.slices.margins import depth, nearest_code

STEEP_AT_BORDER = 1e6  # larger slopes are those of a square root at its border: rounded, some 1e8
# Relative rounding of images and margins: 20 spacings of doubles, what a return of the toy loses
# over its events.
IMAGE_BLUR = 20.0 * 2.0**-52
# Part of a distance from a border: thinner pieces are passed over, for rounding can feign them.
THIN = 1e-3
NEARER = 0.1  # factor of the distance from a border at which the piece beyond is asked for next
# Part of a distance from a border at which a second slope identifies a square root: the next term,
# linear in the distance, is negligible there.
PROBE = 1e-4
FARTHEST_PROBE = 0.2  # the largest such part, if rounding leads to another solution at smaller ones
# Largest difference from 1/2 of the exponent with which slopes grow beside a square root: half way
# to a pole (1) or a kink (0).
OFF_ROOT = 0.25
# Factor of the change that the larger slope at two points allows; a larger change means another
# solution of the piece.
TOO_FAR = 2.0


class BorderKind(Enum):
    """What a map does at a border of two of its pieces, see :meth:`Border.kind`."""

    JUMP = "the values differ"
    KINK = "the values agree, the slopes differ"
    GRAZING = "the values agree, one slope is infinite"
    SMOOTH = "values and slopes agree"
    LOST = "there is no value on one side"


@dataclass(frozen=True, slots=True, eq=False)
class Border:
    """A border as seen from one of the two pieces that meet there.

    Attributes
    ----------
    x, p
        Its place.
    inner, code
        The image at the border under that piece, and the code of its margin that vanishes.
    side
        The side on which the border lies: +1 if that piece lies at smaller x, else -1.
    outer, outer_code
        The same for the piece beyond; the code is -1 if it is not known.

    Examples
    --------
    >>> from woodpecker import Settings
    >>> from woodpecker.examples import two_lines
    >>> from woodpecker.slices import borders_in
    >>> border, = borders_in(two_lines(), 0.5, (-2, 2))
    >>> border.inner.value, border.outer.value, border.jump, border.cause
    (0.5, -0.5, -1.0, 'x = 0')
    >>> border.kind(Settings()).value
    'the values differ'
    """

    x: float
    p: float
    inner: Image
    code: int
    side: int
    outer: Image
    outer_code: int

    def __repr__(self) -> str:
        words = f"{brief(self.inner.piece.word)!r} to {brief(self.outer.piece.word)!r}"
        return (
            f"Border(x={self.x:.10g}, p={self.p:.10g}: {words}, jump {self.jump:.6g}, "
            f"{self.cause!r})"
        )

    @property
    def jump(self) -> float:
        """``outer.value - inner.value``; nan if there is no value beyond."""
        return self.outer.value - self.inner.value

    @property
    def cause(self) -> str:
        """A sentence on what happens there."""
        return self.inner.piece.cause(self.code)

    def kind(self, settings: Settings) -> BorderKind:
        """What the map does there, by values and slopes and the tolerances of ``settings``."""
        if math.isnan(self.jump):
            return BorderKind.LOST
        one, other = self.inner.slope, self.outer.slope
        if abs(self.jump) > settings.jump * settings.x_scale:
            images = ((self.inner, self.code), (self.outer, self.outer_code))
            if abs(self.jump) > max(_unsure(*each, self.x, settings) for each in images):
                return BorderKind.JUMP
        if not (abs(one) < STEEP_AT_BORDER and abs(other) < STEEP_AT_BORDER):
            return BorderKind.GRAZING
        size = max(1.0, abs(one), abs(other))
        return BorderKind.KINK if abs(one - other) > settings.kink * size else BorderKind.SMOOTH


def _unsure(image: Image, code: int, x: float, settings: Settings) -> float:
    """Error of a value at a border, whose x is known only to ``settings.nearest``.

    Beside a square root b sqrt(d) the slope at the distance d is b / (2 sqrt(d)); the value at the
    tolerated distance n is b sqrt(n).
    """
    slope, near = abs(image.slope), settings.nearest * settings.x_scale
    if not math.isfinite(slope):
        return 0.0
    rounded = IMAGE_BLUR * abs(x)
    margin, by = abs(image.margin(code)), abs(float(image.gradient(code)[0]))
    away = max(margin / by, rounded) if by > 0.0 else near
    if not away < near:
        return slope * near
    return min(slope * near, 2.0 * slope * math.sqrt(away * near))


def beyond(
    map_: PiecewiseMap, x: float, p: float, side: int, settings: Settings,
    away: float | None = None,
) -> tuple[Image, int]:  # fmt: skip
    """The image of a border under the piece beyond it, and the code of the margin that vanishes.

    The map is asked for that piece at a distance, by default ``settings.beside``. If the margins of
    the piece say that it ends before the border, another lies between: the distance shrinks.
    """
    away = settings.beside * settings.x_scale if away is None else away
    least = settings.nearest * settings.x_scale
    found, code = map_.at(x + side * away, p), -1
    while True:  # until ``away`` has shrunk to the least
        there = found.piece.at(x, p) if not found.reason else found
        if found.reason or there.reason or strays(found, there, away, settings):
            there = _limit_of(found, x, p, side * away, settings)
        elif _begins(found, there, x + side * THIN * away, p, max(least, THIN * away)):
            return _beside(there, found), nearest_code(there, -side)
        code = nearest_code(there, -side)
        if away <= least:
            return _beside(there, found), code
        away *= NEARER
        found = map_.at(x + side * away, p)


def _begins(found: Image, there: Image, near: float, p: float, thin: float) -> bool:
    """Whether a piece found beyond a border begins at the border, without another in between.

    Where its slope is that of a square root margins at the border may be, too, and do not say where
    they vanish: then those at a place ``near`` the border decide.
    """
    if depth(there) < -thin:
        return False
    if abs(there.slope) <= ROOTED * max(1.0, abs(found.slope)):
        return True
    beside = found.piece.at(near, p)
    return bool(beside.reason) or depth(beside) >= -thin


def _beside(there: Image, found: Image) -> Image:
    """An image at a border with the piece as it is continued from beside the border.

    At a grazing two solutions of a piece meet at the border itself.
    """
    return there._replace(piece=found.piece)


def _limit_of(image: Image, x: float, p: float, away: float, settings: Settings) -> Image:
    """The limit at a border of a piece that has no value there, or only that of another root."""
    part = PROBE
    closer = image.piece.at(x + part * away, p) if not image.reason else image
    while not image.reason and (
        closer.reason or strays(image, closer, (1.0 - part) * away, settings)
    ):
        part = math.sqrt(part)
        if part > FARTHEST_PROBE:
            return _beside(limit(image, away), image)
        closer = image.piece.at(x + part * away, p)
    if closer.reason:
        return limit(image, away)
    root = is_square_root(image.slope, closer.slope, 1.0 / part)
    return _beside(limit(closer, part * away) if root else closer, image)


def limit(image: Image, away: float) -> Image:
    """The limit at its border of a piece that ends in a square root, from an image beside it.

    The value is a + b sqrt(away), and b sqrt(away) is twice the slope times the distance.
    """
    return image._replace(
        value=image.value - 2.0 * image.slope * away,
        slope=math.copysign(math.inf, image.slope * away),
        margins=moved(image, -away),
    )


def moved(image: Image, way: float) -> Floats:
    """The margins (m,) of an image at x + way, to first order."""
    found: Floats = image.margins + way * image.gradients[:, 0]
    return found


def is_square_root(slope: float, closer: float, ratio: float) -> bool:
    """Whether slopes at two distances from a border are those of a square root.

    Those grow with the root of the ratio of the distances; beside a pole or a logarithm, as in the
    dips of a map, slopes grow much faster.
    """
    if slope == 0.0:
        return False
    least, most = 0.5 - OFF_ROOT, 0.5 + OFF_ROOT
    return bool(ratio**least <= abs(closer / slope) <= ratio**most)


def strays(here: Image, there: Image, way: float, settings: Settings) -> bool:
    """Whether a piece changes more than its slopes allow: it took another root of its equations.

    Beside a singularity the slope at the nearer point is the largest on the way.
    """
    steepest = max(abs(here.slope), abs(there.slope))
    if math.isnan(there.slope):  # at the end of a root there is none
        return False
    change, allowed = abs(there.value - here.value), steepest * abs(way)
    if change <= TOO_FAR * allowed:
        return False
    rounding = max(1.0, steepest) * max(math.ulp(here.value), math.ulp(way))
    return change > TOO_FAR * (allowed + settings.spacings * rounding)
