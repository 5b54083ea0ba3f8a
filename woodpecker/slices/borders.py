"""Borders at one parameter: how far a piece reaches, and what lies beyond."""

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

STEEP_AT_BORDER = 1e6  # slopes above are those of a root right at its border: rounded, some 1e8
# Relative rounding of images and margins: 20 spacings of doubles, what a return of the toy loses
# over its events.
IMAGE_BLUR = 20.0 * 2.0**-52
# Part of a distance from a border, below which a piece is passed over: such a thin one is another,
# not rounding, from some parts in a thousand on.
THIN = 1e-3
NEARER = 0.1  # part of a distance from a border, at which the piece was not found, tried next
# Part of a distance from a border at which a second slope tells a square root: its next term,
# linear in the distance, is too small there to matter.
PROBE = 1e-4
FARTHEST_PROBE = 0.2  # the largest such part, where rounding leads to another solution nearer by
# By how much the power of the distance with which a slope grows may differ from 1/2, that of a
# square root: half of the way to a pole or a kink.
OFF_ROOT = 0.25
# Times the change that the larger slope at two points allows; beyond, a value lies on another
# solution of the piece: the slope in between may be larger, but not by that.
TOO_FAR = 2.0


class BorderKind(Enum):
    """What a map does at a border of two of its pieces.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, from_sympy
    >>> from woodpecker.slices import borders_in
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> border, = borders_in(lines, 0.5, (-2, 2))
    >>> border.kind(Settings()).value
    'the values differ'
    """

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

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import from_sympy
    >>> from woodpecker.slices import borders_in
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> border, = borders_in(lines, 0.5, (-2, 2))
    >>> border.x, border.inner.value, border.outer.value
    (0.0, 0.5, -0.5)
    >>> border.jump, border.cause
    (-1.0, 'x = 0')
    """

    x: float
    p: float
    inner: Image
    code: int
    side: int
    outer: Image
    outer_code: int

    def __repr__(self) -> str:
        """Where, how far the map jumps, between which words, and why."""
        words = f"{brief(self.inner.piece.word)!r} to {brief(self.outer.piece.word)!r}"
        return (
            f"Border(x={self.x:.10g}, p={self.p:.10g}: {words}, jump {self.jump:.6g}, "
            f"{self.cause!r})"
        )

    @property
    def jump(self) -> float:
        """Value beyond less value inside; nan if there is none beyond."""
        return self.outer.value - self.inner.value

    @property
    def cause(self) -> str:
        """What happens there."""
        return self.inner.piece.cause(self.code)

    def kind(self, settings: Settings) -> BorderKind:
        """What the map does there.

        Parameters
        ----------
        settings
            What counts as a jump or a kink.

        Returns
        -------
        BorderKind
            From values and slopes on both sides.
        """
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
    """How far a value at a border may be off, as x is only close to the border.

    A slope that is steep because x is closer than it must be is that of a square root, b sqrt(d):
    there it is b / (2 sqrt(d)), and b sqrt(n) at the distance n at which x might as well be.
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
    """The image of a border under the piece that lies on a side of it, and which margin vanishes.

    The piece beyond is asked for at a distance, the usual one or another. If its margins say that
    it ends before the border, there is another in between, and the distance shrinks.
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
    """Whether a piece that was found beyond a border begins there, and no other one in between.

    Where slopes are those of a square root margins may be, too: at the border they seem to vanish
    right beside it, wherever they do. A place near it tells.
    """
    if depth(there) < -thin:
        return False
    if abs(there.slope) <= ROOTED * max(1.0, abs(found.slope)):
        return True
    beside = found.piece.at(near, p)
    return bool(beside.reason) or depth(beside) >= -thin


def _beside(there: Image, found: Image) -> Image:
    """An image at a border whose piece goes on from right beside it.

    Where two of its solutions meet at the border, as at a grazing, either might follow from there.
    """
    return there._replace(piece=found.piece)


def _limit_of(image: Image, x: float, p: float, away: float, settings: Settings) -> Image:
    """An image at a distance from a border at which its piece has no value, taken to the border.

    Right beside the border rounding may lead to another solution of the piece, too.
    """
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
    """An image next to a border that its piece does not reach, taken to the border.

    Where the piece ends in a square root its value is a + b sqrt(away), and b sqrt(away) is twice
    the slope times the distance.
    """
    return image._replace(
        value=image.value - 2.0 * image.slope * away,
        slope=math.copysign(math.inf, image.slope * away),
        margins=moved(image, -away),
    )


def moved(image: Image, way: float) -> Floats:
    """The margins (m,) of an image some way on, to first order."""
    found: Floats = image.margins + way * image.gradients[:, 0]
    return found


def is_square_root(slope: float, closer: float, ratio: float) -> bool:
    """Whether slopes at two distances from a border are those of a square root.

    They grow with the root of the ratio of the distances; beside a pole or a logarithm, in which
    the dips of a map end, much more.
    """
    if slope == 0.0:
        return False
    least, most = 0.5 - OFF_ROOT, 0.5 + OFF_ROOT
    return bool(ratio**least <= abs(closer / slope) <= ratio**most)


def strays(here: Image, there: Image, way: float, settings: Settings) -> bool:
    """Whether a piece went another way than its slopes say: where roots meet it may take the other.

    Beside a singularity, however steep, the slope at the nearer point is the largest on the way.
    """
    steepest = max(abs(here.slope), abs(there.slope))
    if math.isnan(there.slope):  # at the end of a root there is none
        return False
    change, allowed = abs(there.value - here.value), steepest * abs(way)
    if change <= TOO_FAR * allowed:
        return False
    rounding = max(1.0, steepest) * max(math.ulp(here.value), math.ulp(way))
    return change > TOO_FAR * (allowed + settings.spacings * rounding)
