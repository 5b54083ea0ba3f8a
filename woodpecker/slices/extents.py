"""Samples of a piece from a point to one side, up to the border where its first margin vanishes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from woodpecker.base.settings import Settings
from woodpecker.engine.rooted import ROOTED
from woodpecker.maps.pieces import Image
from woodpecker.slices.borders import is_other_solution, one_sided_limit
from woodpecker.slices.margins import depth, first_part, is_within, lowest_dip, next_border

# Samples of a piece to one side of its first point: some tens are usual. Where a piece runs ever
# farther out of the window the rest becomes a gap, of which only the middle is evaluated.
MOST_SAMPLES = 300
AHEAD = 1.1  # step towards a border, in its first-order distance: just beyond, for a bracket
RETRY = 0.25  # factor by which a step is shortened if it is unclear what lies at its end
# Iterations for the root of a margin, of which a handful is usual; then a shorter step is tried.
ROOT_STEPS = 60
# Iterations after which every third is a bisection: three suffice where cubics fit the margins.
STRAYED = 6
SPLIT = 0.125  # fraction of an interval tried first if its far end is lost, or its near end steep
# Tolerances of a border's place within which a second margin counts as vanishing too.
SAME_BORDER = 16.0
# Where a piece has no values beyond its border, the first step leaves this fraction of the distance
# to it; each step that went too far makes the fraction larger by this factor.
SHORT, WIDEN = 2.0**-4, 8.0
SAFETY = 4.0  # factor of an error estimated by the next term of a series: one bit more than needed
UNEVEN = 16.0  # ratio of slopes at the ends above which an interval is split near the steeper end
OTHER_SOLUTION = "the piece goes another way"
WITHIN, NO_VALUE = -1, -2  # codes of samples where no margin vanishes


class Knot(NamedTuple):
    """A sample of a piece; ``code`` is the margin that vanishes there, else WITHIN or NO_VALUE."""

    x: float
    image: Image
    code: int = WITHIN


PieceExtent = tuple[Knot, ...]
"""Ascending samples of a piece from end to end; the codes of the two ends say why it ends there."""

Missing = Callable[[Knot, Knot], float]


def samples_to_border(
    image: Image, x: float, p: float, side: int, limit: float, settings: Settings,
    missing: Missing = lambda *_: 0.0,
) -> list[Knot]:  # fmt: skip
    """Samples of a piece from x to one side, up to the limit or where a margin vanishes before.

    The last sample has the code of that margin; -1 at the limit, or if the piece is lost before.
    ``missing`` returns where another sample is needed between two, as a fraction of the way, or 0.
    """
    samples, code, scale = [Knot(x, image)], WITHIN, settings.x_scale
    longest, least = settings.max_step * scale, settings.nearest * scale
    while samples[-1].x != limit and code == WITHIN and len(samples) < MOST_SAMPLES:
        ahead, code = next_border(samples[-1].image, side)
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
    """Samples from ``here`` to a point, or to the first border before it; empty if it is lost."""
    # A margin may dip to zero between two samples: there another is inserted.
    found = list[Knot]()
    todo = [_next(here, to, p, least, settings)]  # a stack: the farthest is at the bottom
    while todo:  # each pass keeps a sample or inserts one before it, at most MOST_SAMPLES
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
    """The sample at ``to``, or at the first border before it; None if the piece is lost."""
    while True:  # the step is shortened until it is clear what lies at its end, down to ``least``
        there = Knot(to, here.image.piece.at(to, p))
        if is_within(there.image):
            return there
        there = _unless_astray(here, there, settings)
        root = _first_root(here, there, p, least, settings)
        if root is not None and root.code == WITHIN:
            return root
        if root is not None:  # continued from a grazing itself, a piece may take another solution
            return Knot(root.x, root.image._replace(piece=here.image.piece), root.code)
        to = here.x + RETRY * (to - here.x)
        if abs(to - here.x) < least:
            return None


def _continued(here: Knot, x: float, p: float, settings: Settings) -> Knot:
    """The sample of a piece at x, continued from ``here``; a reason, no value, if it strays."""
    return _unless_astray(here, Knot(x, here.image.piece.at(x, p)), settings)


def _unless_astray(here: Knot, there: Knot, settings: Settings) -> Knot:
    if there.image.reason or not is_other_solution(
        here.image, there.image, there.x - here.x, settings
    ):
        return there
    return Knot(there.x, there.image._replace(reason=OTHER_SOLUTION))


# --- Where a margin vanishes ----------------------------------------------------------------------


def _first_root(
    low: Knot, high: Knot, p: float, tolerance: float, settings: Settings
) -> Knot | None:
    """The sample where the first margin vanishes before ``high``, or ``high``; None if unclear."""
    # Margins that are negative at the far end are interpolated by cubics; the sample at the first
    # of their roots replaces one end of the interval. If the piece has no value at the far end, the
    # border is approached from inside, always falling a little short of it.
    before, left, inside = low, 1.0, 0
    for k in range(ROOT_STEPS):
        way = high.x - low.x
        ahead, code = next_border(low.image, math.copysign(1.0, way))
        lost = bool(high.image.reason)
        if abs(way) <= tolerance or (ahead <= tolerance and (k > 0 or lost)):
            code = code if ahead <= 2.0 * tolerance else NO_VALUE
            return _at_end(low, p, way, code, settings) if lost else Knot(low.x, low.image, code)
        ahead /= abs(way)
        if inside > 1 and not lost and ahead >= 1.0:  # continued from afar, it may have strayed
            high = _continued(low, high.x, p, settings)
            if is_within(high.image):
                return high
            lost = bool(high.image.reason)
        if lost and ahead >= 1.0:  # no margin seems to vanish before the lost end
            part = 0.5 if k > 0 else SPLIT
        elif lost:  # a margin does: its border is approached from inside
            part = _point_inside_border(before, low, code, way, left, tolerance)
        else:
            part, first = first_part(low.image, high.image, way)
            if first < 0:
                return None
            if ahead < SPLIT or (ahead < 1.0 and not high.image.margin(code) < 0.0):
                part = ahead
            else:
                code = first
        trial = low.x + (part if k < STRAYED or k % 3 < 2 else 0.5) * way
        for end in (high, low):
            if abs(trial - end.x) <= tolerance and not math.isnan(end.image.margin(code)):
                if math.isnan(end.image.value):
                    continue  # a lost end is approached from inside
                if depth(end.image, code) >= -SAME_BORDER * tolerance:
                    return Knot(end.x, end.image, code)
                high, left = Knot(high.x, high.image._replace(reason=OTHER_SOLUTION)), 1.0
                break
        else:
            found = _continued(low, trial, p, settings)
            if is_within(found.image):
                before, low, left, inside = low, found, 1.0, inside + 1
            else:
                high, left, inside = found, left * WIDEN, 0
    return None


def _at_end(low: Knot, p: float, way: float, code: int, settings: Settings) -> Knot:
    """The last sample of a piece without values beyond: its limit, extrapolated to the border."""
    image, side = low.image, math.copysign(1.0, way)
    ahead, first = next_border(image, side)
    if first != code or ahead <= 0.0:
        return Knot(low.x, image, code)
    way = side * ahead
    x, value = low.x + way, image.value + way * image.slope
    image = image._replace(value=value, margins=image.margins + way * image.gradients[:, 0])
    steep = abs(image.slope) > ROOTED  # as beside a root singularity, where it is fitted instead
    return Knot(x, one_sided_limit(image, x, p, int(-side), settings) if steep else image, code)


def _point_inside_border(
    before: Knot, low: Knot, code: int, way: float, left: float, tolerance: float
) -> float:
    """A point just inside of the border where a margin vanishes, as a fraction of the way."""
    # The margin is a parabola by its slopes at ``before`` and ``low``, if both are known, else a
    # straight line. The relative difference of their roots, squared, estimates the error of the
    # parabola's, and so how far inside the point must lie.
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
            short = min(short, SAFETY * (distance / straight - 1.0) ** 2)
    short = min(0.5, left * max(short, tolerance / (SAFETY * distance)))
    return min(0.5 if distance >= abs(way) else 1.0, distance / abs(way)) * (1.0 - short)


# --- Where another sample is needed ---------------------------------------------------------------


def where_to_refine(here: Knot, there: Knot, even: float) -> float:
    """Where another sample is needed between two, as a fraction of the way; 0 if nowhere.

    None is needed if the mean of both slopes gives the rise of the value to within ``even`` / 2.
    """
    run, rise = there.x - here.x, there.image.value - here.image.value
    rates = here.image.slope * run, there.image.slope * run
    endless = math.isinf(rates[0]), math.isinf(rates[1])
    if any(endless):  # a square root b sqrt(d) from one end rises by twice its slope at the other
        rate = rates[1] if endless[0] else rates[0]
        return 0.5 if all(endless) or abs(rise - 2.0 * rate) > 2.0 * abs(rise) + even else 0.0
    if abs(rates[0] + rates[1] - 2.0 * rise) <= even:
        return 0.0
    steep = abs(rates[0]), abs(rates[1])
    if max(steep) <= UNEVEN * min(steep):
        return 0.5
    return SPLIT if steep[0] > steep[1] else 1.0 - SPLIT
