"""Borders of a map at one parameter, with the one-sided limits of value and slope."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from pwmap.diagrams.shown import brief
from woodpecker.base.settings import Settings
from woodpecker.engine.germs import image_beside
from woodpecker.engine.line import LineMap, LinePiece, image_on_line
from woodpecker.engine.maps import LIMIT_DISTANCE, Accumulating, root_of
from woodpecker.maps.pieces import Image, PiecewiseMap
from woodpecker.slices.margins import nearest_code

# Relative difference of the slopes at one and two LIMIT_DISTANCE from a border: above it the
# slope still grows towards the border, as beside a root singularity.
ROOT_GROWTH = 0.1
# A larger slope at a border is that of a square root: infinite, but some 1e8 after rounding.
STEEP_AT_BORDER = 1e6
# Relative rounding of images and margins: 20 spacings of doubles, what a return of the toy loses
# over its events.
IMAGE_BLUR = 20.0 * 2.0**-52
# Fraction of ``Settings.beside``: thinner pieces are passed over, as rounding can create them.
LEAST_PIECE = 1e-3
SLIGHT = 1e-2  # relative difference of slopes at a border: smaller ones may be those of rounding
# Slopes merge at a border if their difference falls to this fraction a hundred times closer to it,
# twice: that of a cube root falls to a fifth.
SHRINKS, CLOSER = 0.5, 0.01
# The value may change between two points by this factor times what the larger slope gives; if it
# changes more, the second point lies on another solution of the equations of the piece.
TOO_FAR = 2.0


class BorderKind(Enum):
    """How a map behaves at the border of two of its pieces, see :meth:`Border.kind`."""

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
        Its place, and the parameter.
    inner, code
        The image at the border under that piece, and the code of its margin that vanishes.
    side
        The side of that piece on which the border lies: +1 if at its upper end in x, else -1.
    outer, outer_code
        The same for the piece beyond the border; the code is -1 if it is not known.

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
        """``outer.value - inner.value``; nan if the map has no value beyond the border."""
        return self.outer.value - self.inner.value

    @property
    def cause(self) -> str:
        """A sentence on what happens there."""
        return self.inner.piece.cause(self.code)

    def kind(self, settings: Settings) -> BorderKind:
        """The kind of the border, decided by both values and slopes to within ``settings``."""
        if math.isnan(self.jump):
            return BorderKind.LOST
        one, other = self.inner.slope, self.outer.slope
        if self.is_jump(settings):
            return BorderKind.JUMP
        if not (abs(one) < STEEP_AT_BORDER and abs(other) < STEEP_AT_BORDER):
            return BorderKind.GRAZING
        off, size = abs(one - other), max(1.0, abs(one), abs(other))
        smooth = off <= settings.kink * size or (off <= SLIGHT * size and self._merges(settings))
        return BorderKind.SMOOTH if smooth else BorderKind.KINK

    def is_jump(self, settings: Settings) -> bool:
        """Whether the values differ by more than the errors of both limits."""
        if not abs(self.jump) > settings.jump * settings.x_scale:
            return False
        images = ((self.inner, self.code), (self.outer, self.outer_code))
        return abs(self.jump) > max(_error_of_limit(*each, self.x, settings) for each in images)

    def _merges(self, settings: Settings) -> bool:
        """Whether slopes come together at the border, as where they go like a cube root."""
        # There rounding of the place leaves a difference; next to the border it falls on and on.
        away = settings.nearest * settings.x_scale
        closest, near, far = (self._difference(away / CLOSER**k) for k in range(3))
        return 0.0 < closest <= SHRINKS * near <= SHRINKS**2 * far

    def _difference(self, away: float) -> float:
        """The difference of the slopes at a distance on both sides of the border."""
        step = self.side * away
        inner, outer = self.inner.piece, self.outer.piece
        slopes = (inner.at(self.x - step, self.p).slope, outer.at(self.x + step, self.p).slope)
        return abs(slopes[1] - slopes[0])


def _error_of_limit(image: Image, code: int, x: float, settings: Settings) -> float:
    """The error of a one-sided limit, as the border is known only to ``settings.nearest``."""
    # With the tolerance n of the place it is slope * n. Beside a square root b sqrt(d) the slope at
    # the distance d is b / (2 sqrt(d)), and the error is b sqrt(n) = 2 slope sqrt(d n).
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
    map_: PiecewiseMap, x: float, p: float, side: int, settings: Settings
) -> tuple[Image, int]:
    """The image of a border point under the piece beyond it, and the margin that vanishes there."""
    # that is the piece infinitesimally beside the border, see woodpecker/engine/maps.py
    lengths = settings.x_scale, settings.p_scale
    line, way = LineMap(map_, *lengths), np.array([float(side), 0.0])
    there = image_beside(line, np.array([x]), np.array([p]), way, np.array(lengths))
    image = image_on_line(there)
    if isinstance(there.piece, Accumulating):
        return image, -1
    image = one_sided_limit(
        image._replace(value=math.nan) if image.reason else image, x, p, side, settings
    )
    return image, nearest_code(image, -side)


def one_sided_limit(image: Image, x: float, p: float, side: int, settings: Settings) -> Image:
    """The one-sided limit at x of a piece that lies on one side of x and may end in a root there.

    At a root the limit is fitted and the slope infinite. Elsewhere a slope that is too steep to be
    true at x is made of rounding, and the slope right beside x takes its place.
    """
    if image.reason:
        return image
    way = np.array([side * settings.x_scale, 0.0])
    root = root_of(LinePiece(image.piece), np.array([x]), np.array([p]), way)
    if root is not None:
        slope = math.copysign(math.inf, side * float(root.growth[0]))
        return image._replace(value=float(root.value[0]), slope=slope)
    if abs(image.slope) < STEEP_AT_BORDER:
        return image
    near, far = (image.piece.at(x + n * LIMIT_DISTANCE * float(way[0]), p) for n in (1.0, 2.0))
    if near.reason or far.reason or abs(near.slope - far.slope) > ROOT_GROWTH * abs(far.slope):
        return image
    return image._replace(slope=near.slope)


def is_other_solution(here: Image, there: Image, way: float, settings: Settings) -> bool:
    """Whether a piece changes more than its slopes allow: it took another root of its equations.

    Beside a root singularity the slope at the nearer of the two points bounds all between them.
    """
    steepest = max(abs(here.slope), abs(there.slope))
    if math.isnan(there.slope):  # as at the end of a root: no slope to compare with
        return False
    change, allowed = abs(there.value - here.value), steepest * abs(way)
    if change <= TOO_FAR * allowed:
        return False
    rounding = max(1.0, steepest) * max(math.ulp(here.value), math.ulp(way))
    return change > TOO_FAR * (allowed + settings.spacings * rounding)
