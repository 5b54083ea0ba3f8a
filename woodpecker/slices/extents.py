"""How far a piece reaches to a side: samples on the way, and the first margin that vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image
from woodpecker.slices.borders import is_square_root, limit, moved, strays
from woodpecker.slices.margins import (
    depth,
    first_part,
    is_within,
    lowest_dip,
    margin_in_x,
    reach,
)

MOST_SAMPLES = 10_000  # samples of a piece: some tens are usual
AHEAD = 1.1  # part of the way to a border that a step over it has: to first order it lies there
RETRY = 0.25  # part of a step that is tried next if the map takes another piece at its end
ROOT_STEPS = 60  # to where a margin vanishes; then a shorter way is tried. A handful is usual
STRAYED = 6  # steps after which every third halves: three are enough where cubics do not mislead
SPLIT = 0.125  # part of a way that is tried first where its far end is lost, or the near one steep
BOTH = 16.0  # times as closely as a border is located other margins may vanish there too
# Part of the way to the border of a piece without a value beyond it that is left at first; and how
# much more if the piece was lost all the same. Both are closed in on fast.
SHORT, WIDEN = 2.0**-4, 8.0
SAFETY = 4.0  # times an estimated error: one bit more than the next term of a series makes of it
UNEVEN = 16.0  # slopes whose ratio is larger are split beside the steeper one
OTHER_WAY = "the piece goes another way"
WITHIN, NO_VALUE = -1, -2  # instead of a margin that vanishes


class Knot(NamedTuple):
    """A point at which a piece was evaluated; between such points it is interpolated.

    ``code`` is the margin that vanishes there, or WITHIN, or NO_VALUE beyond it.
    """

    x: float
    image: Image
    code: int = WITHIN


PieceExtent = tuple[Knot, ...]
"""Samples of a piece in ascending order, from end to end: their codes say why it ends there."""

Missing = Callable[[Knot, Knot], float]


def reach_of(
    image: Image, x: float, p: float, side: int, limit: float, settings: Settings,
    missing: Missing = lambda *_: 0.0,
) -> list[Knot]:  # fmt: skip
    """Samples of a piece to one side, from the point on until a margin vanishes or a limit is met.

    The last one has the code of the margin; -1 at the limit, or if there is no value further on.
    ``missing`` says where a sample is missing between two, as a part of the way; 0 if none is.
    """
    samples, code, scale = [Knot(x, image)], WITHIN, settings.x_scale
    longest, least = settings.max_step * scale, settings.nearest * scale
    while samples[-1].x != limit and code == WITHIN and len(samples) < MOST_SAMPLES:
        ahead, code = reach(samples[-1].image, side)
        if ahead <= 0.0:
            break
        to = samples[-1].x + side * min(longest, AHEAD * ahead + least)
        to = limit if side * (to - limit) >= 0.0 else to
        found = _followed(samples[-1], to, p, least, settings, missing)
        samples += found
        code = found[-1].code if found else NO_VALUE
    x, image, _ = samples[-1]
    samples[-1] = Knot(x, image, max(code, WITHIN))
    return samples


def _followed(
    here: Knot, to: float, p: float, least: float, settings: Settings, missing: Missing
) -> list[Knot]:
    """Samples from a point on, to another or to where the first margin vanishes; none if lost.

    Where a margin may dip to zero between two of them there is another one.
    """
    found = list[Knot]()
    todo = [_next(here, to, p, least, settings)]  # the farthest first
    while todo:  # each pass keeps a sample or puts one before it, of so many
        there = todo[-1]
        if there is None:
            break
        way = there.x - here.x
        longest = abs(way) - least
        dip = lowest_dip(here.image, there.image, way)
        if dip is None or not least < dip * abs(way) < longest:
            dip = missing(here, there)
        if least < dip * abs(way) < longest and len(todo) + len(found) < MOST_SAMPLES:
            at = here.x + dip * way
            between = _next(here, at, p, least, settings)
            if between is None or between.x != at or between.code != WITHIN:
                todo.clear()
            todo.append(between)
        else:
            here = there
            found.append(there)
            todo.pop()
    return found


def _next(here: Knot, to: float, p: float, least: float, settings: Settings) -> Knot | None:
    """The sample at a point if the piece reaches it, or where it ends before; None if it is lost.

    Where it ends may not be clear at once; a shorter step is taken then.
    """
    while True:  # the step becomes shorter, down to the least
        there = Knot(to, here.image.piece.at(to, p))
        if is_within(there.image):
            return there
        there = _unless_astray(here, there, settings)
        root = _first_root(here, there, p, least, settings)
        if root is not None and root.code == WITHIN:
            return root
        if root is not None:  # a piece that was met at a grazing may be continued the wrong way
            return Knot(root.x, root.image._replace(piece=here.image.piece), root.code)
        to = here.x + RETRY * (to - here.x)
        if abs(to - here.x) < least:
            return None


def _continued(here: Knot, x: float, p: float, settings: Settings) -> Knot:
    """A piece at another point; it has no value if it went another way."""
    return _unless_astray(here, Knot(x, here.image.piece.at(x, p)), settings)


def _unless_astray(here: Knot, there: Knot, settings: Settings) -> Knot:
    if there.image.reason or not strays(here.image, there.image, there.x - here.x, settings):
        return there
    return Knot(there.x, there.image._replace(reason=OTHER_WAY))


# --- Where a margin vanishes ----------------------------------------------------------------------


def _first_root(
    low: Knot, high: Knot, p: float, tolerance: float, settings: Settings
) -> Knot | None:
    """Where between two points the first margin vanishes, or as far as none does; None if unclear.

    Each margin that is negative at the far end is a cubic in between; the point where the first of
    them vanishes takes the place of one of the ends. Where the piece has no value at the far end it
    is approached from inside.
    """
    before, left, inside = low, 1.0, 0
    for k in range(ROOT_STEPS):
        way = high.x - low.x
        ahead, code = reach(low.image, math.copysign(1.0, way))
        lost = bool(high.image.reason)
        if abs(way) <= tolerance or (ahead <= tolerance and (k > 0 or lost)):
            code = code if ahead <= 2.0 * tolerance else NO_VALUE
            return _at_end(before, low, way, code) if lost else Knot(low.x, low.image, code)
        ahead /= abs(way)
        if inside > 1 and not lost and ahead >= 1.0:  # from afar it may have been continued wrongly
            high = _continued(low, high.x, p, settings)
            if is_within(high.image):
                return high
            lost = bool(high.image.reason)
        if lost and ahead >= 1.0:
            part = 0.5 if k > 0 else SPLIT
        elif lost:
            part = _short_of(before, low, code, way, left, tolerance)
        else:
            part, first = first_part(low.image, high.image, way)
            if first < 0:
                return None
            if ahead < SPLIT or (ahead < 1.0 and not margin_in_x(high.image, code)[0] < 0.0):
                part = ahead
            else:
                code = first
        trial = low.x + (part if k < STRAYED or k % 3 < 2 else 0.5) * way
        for end in (high, low):
            if abs(trial - end.x) <= tolerance and not math.isnan(margin_in_x(end.image, code)[0]):
                if math.isnan(end.image.value):
                    continue  # it is approached from inside
                if depth(end.image, code) >= -BOTH * tolerance:
                    return Knot(end.x, end.image, code)
                high, left = Knot(high.x, high.image._replace(reason=OTHER_WAY)), 1.0
                break
        else:
            found = _continued(low, trial, p, settings)
            if is_within(found.image):
                before, low, left, inside = low, found, 1.0, inside + 1
            else:
                high, left, inside = found, left * WIDEN, 0
    return None


def _at_end(before: Knot, low: Knot, way: float, code: int) -> Knot:
    """The last sample of a piece that has no value beyond.

    The value is the limit; where it ends in a square root the slope is infinite.
    """
    side = math.copysign(1.0, way)
    ahead, first = reach(low.image, side)
    run = side * (low.x - before.x)
    if first != code or ahead <= 0.0 or run <= 0.0:
        return Knot(low.x, low.image, code)
    way = side * ahead
    if is_square_root(before.image.slope, low.image.slope, (run + ahead) / ahead):
        return Knot(low.x + way, limit(low.image, -way), code)
    value, margins = low.image.value + way * low.image.slope, moved(low.image, way)
    return Knot(low.x + way, low.image._replace(value=value, margins=margins), code)


def _short_of(
    before: Knot, low: Knot, code: int, way: float, left: float, tolerance: float
) -> float:
    """A point short of the one where a margin vanishes and the piece is lost, as a part of the way.

    The margin is a parabola, by its slopes at two points if there are; how far that is from a
    straight line says how much of the way is left.
    """
    side = math.copysign(1.0, way)
    h, rate = margin_in_x(low.image, code)
    slope = side * rate
    straight = distance = -h / slope
    short = SHORT
    run = side * (low.x - before.x)
    slope_before = side * margin_in_x(before.image, code)[1]
    if run > 0.0 and math.isfinite(slope_before):
        square = slope * slope - 2.0 * h * (slope - slope_before) / run
        if square > 0.0:
            distance = 2.0 * h / (math.sqrt(square) - slope)
            short = min(short, SAFETY * (distance / straight - 1.0) ** 2)
    short = min(0.5, left * max(short, tolerance / (SAFETY * distance)))
    return min(0.5 if distance >= abs(way) else 1.0, distance / abs(way)) * (1.0 - short)


# --- Whether samples tell what lies between them --------------------------------------------------


def uneven(here: Knot, there: Knot, even: float) -> float:
    """Where a sample is missing between two, as a part of the way; 0 if none is.

    A rise may differ by ``even`` from those that the slopes at both ends make of it.
    """
    run, rise = there.x - here.x, there.image.value - here.image.value
    rates = here.image.slope * run, there.image.slope * run
    endless = math.isinf(rates[0]), math.isinf(rates[1])
    if any(endless):  # a square root
        rate = rates[1] if endless[0] else rates[0]
        return 0.5 if all(endless) or abs(rise - 2.0 * rate) > 2.0 * abs(rise) + even else 0.0
    if abs(rates[0] + rates[1] - 2.0 * rise) <= even:
        return 0.0
    steep = abs(rates[0]), abs(rates[1])
    if max(steep) <= UNEVEN * min(steep):
        return 0.5
    return SPLIT if steep[0] > steep[1] else 1.0 - SPLIT
