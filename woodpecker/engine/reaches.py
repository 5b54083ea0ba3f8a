"""How far a piece reaches to a side: samples on the way, and the first margin that vanishes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from woodpecker.engine.borders import limit
from woodpecker.engine.margins import IN_X, STEEPENED, first_part, is_within, lowest_dip, reach
from woodpecker.engine.pieces import Image
from woodpecker.engine.settings import Settings

BEYOND = 1.25  # a step over a border that is ahead is this part of the way to it
INSIDE, NO_VALUE = -1, -2  # instead of a margin that vanishes


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


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A point of a piece, and the margin that vanishes there, or INSIDE, or NO_VALUE beyond it."""

    x: float
    image: Image
    code: int = INSIDE


def reach_of(
    image: Image, x: float, p: float, side: int, limit: float, settings: Settings,
    tolerance: float = 0.0,
) -> Reach:  # fmt: skip
    """Follow a piece to one side until a margin vanishes or a limit is met.

    Parameters
    ----------
    image, x, p
        A point of the piece.
    side, limit
        Which way, and how far.
    settings
        Scales.
    tolerance
        How closely the end is located, if not as closely as can be.
    """
    samples, code = [_Sample(x, image)], INSIDE
    longest = settings.max_step * settings.x_scale
    least = max(settings.nearest * settings.x_scale, tolerance)
    while samples[-1].x != limit and code == INSIDE:
        ahead, code = reach(samples[-1].image, side)
        if ahead <= 0.0:
            break
        to = samples[-1].x + side * min(longest, BEYOND * ahead + least)
        found = _followed(samples[-1], limit if side * (to - limit) >= 0.0 else to, p, least)
        samples += found
        code = found[-1].code if found else NO_VALUE
    xs, images = tuple(each.x for each in samples), tuple(each.image for each in samples)
    return Reach(xs, images, max(code, -1))


def _followed(here: _Sample, to: float, p: float, least: float) -> list[_Sample]:
    """Samples from a point on, to another or to where the first margin vanishes; none if lost.

    Where a margin may dip to zero between two of them there is another one.
    """
    found = list[_Sample]()
    todo = [_next(here, to, p, least)]  # the farthest first
    while todo:
        there = todo[-1]
        if there is None:
            break
        way = there.x - here.x
        dip = lowest_dip(here.image, there.image, way, IN_X, IN_X)
        if dip is not None and least < dip * abs(way) < abs(way) - least:
            at = here.x + dip * way
            between = _next(here, at, p, least)
            if between is None or between.x != at or between.code != INSIDE:
                todo.clear()
            todo.append(between)
        else:
            here = there
            found.append(there)
            todo.pop()
    return found


def _next(here: _Sample, to: float, p: float, least: float) -> _Sample | None:
    """The sample at a point if the piece reaches it, or where it ends before; None if it is lost.

    Where it ends may not be clear at once; a shorter step is taken then.
    """
    while True:
        there = _Sample(to, here.image.piece.at(to, p))
        if is_within(there.image):
            return there
        root = _first_root(here, there, p, least)
        if root is not None:
            return root
        to = here.x + 0.25 * (to - here.x)
        if abs(to - here.x) < least:
            return None


# --- Where a margin vanishes ----------------------------------------------------------------------

ROOT_STEPS = 60  # after some all halve, so that 50 halvings are left where cubics mislead
STRAYED = 6  # steps after which every third halves: three are enough where cubics do not mislead
LOST = 0.125  # part of a step that is tried where a piece has no value at its end
SHORT = 2.0**-6  # part of the way to a root at which a piece is lost that is left, at first
WIDEN = 8.0  # how much more of it is left if the piece was lost all the same


def _first_root(low: _Sample, high: _Sample, p: float, tolerance: float) -> _Sample | None:
    """Where between two points the first margin vanishes; None if that is not clear yet.

    Each margin that is negative at the far end is a cubic in between; the point where the first of
    them vanishes takes the place of one of the ends. Where the piece has no value at the far end it
    is approached from inside.
    """
    start, before, left = low, low, 1.0
    for k in range(ROOT_STEPS):
        way = high.x - low.x
        ahead, code = reach(low.image, math.copysign(1.0, way))
        lost = bool(high.image.reason)
        if abs(way) <= tolerance or (ahead <= tolerance and (k > 0 or lost)):
            return _at_end(start, low, way, code if ahead <= 2.0 * tolerance else NO_VALUE, lost)
        ahead /= abs(way)
        if lost and ahead >= 1.0:
            part = 0.5 if k > 0 else LOST
        elif lost:
            part = _short_of(before, low, code, way, left, tolerance)
        else:
            part, first = first_part(low.image, high.image, way)
            if first < 0:
                return None
            if ahead < LOST or (ahead < 1.0 and not high.image.margin(code) < 0.0):
                part = ahead
            else:
                code = first
        trial = low.x + (part if k < STRAYED or k % 3 < 2 else 0.5) * way
        for end in (high, low):
            if abs(trial - end.x) <= tolerance and not math.isnan(end.image.margin(code)):
                return _Sample(end.x, end.image, code)
        found = _Sample(trial, low.image.piece.at(trial, p))
        if is_within(found.image):
            before, low, left = low, found, 1.0
        else:
            high, left = found, left * WIDEN
    return None


def _at_end(start: _Sample, low: _Sample, way: float, code: int, lost: bool) -> _Sample:
    """The last sample of a piece, at the end; where it ends in a square root, the limit there."""
    image = low.image
    usual = abs(start.image.slope) if math.isfinite(start.image.slope) else 0.0
    if lost and code >= 0 and abs(image.slope) > STEEPENED * max(1.0, usual):
        side = math.copysign(1.0, way)
        ahead = reach(image, side)[0] * side
        return _Sample(low.x + ahead, limit(image, -ahead), code)
    return _Sample(low.x, image, code)


def _short_of(
    before: _Sample, low: _Sample, code: int, way: float, left: float, tolerance: float
) -> float:
    """A point short of the one where a margin vanishes and the piece is lost, as a part of the way.

    The margin is a parabola, by its slopes at two points if there are; how far that is from a
    straight line says how much of the way is left.
    """
    side = math.copysign(1.0, way)
    h, slope = low.image.margin(code), side * float(low.image.gradient(code)[0])
    straight = distance = -h / slope
    short = SHORT
    run = side * (low.x - before.x)
    slope_before = side * float(before.image.gradient(code)[0])
    if run > 0.0 and math.isfinite(slope_before):
        square = slope * slope - 2.0 * h * (slope - slope_before) / run
        if square > 0.0:
            distance = 2.0 * h / (math.sqrt(square) - slope)
            short = min(SHORT, 4.0 * (distance / straight - 1.0) ** 2)
    short = min(0.5, left * max(short, 0.25 * tolerance / distance))
    return min(0.5 if distance >= abs(way) else 1.0, distance / abs(way)) * (1.0 - short)
