"""Repelling cycles that lie inside of bands: an image of a break that meets them ends no band.

A short interval beside a point of the cycle is followed along it to a break, and on. If an image
surrounds a point of the cycle, the cycle lies inside of every band to which the break may belong,
there and nearby: no band ends, begins or merges. Doubles decide, with intervals that are shortened
at each step by far more than their error; in doubt nothing is claimed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate

from pwmap.longrun.line import MapLine, joined

STEPS = 24  # in which the interval grows, at most
PARTS = 24  # of its images, at most
SLACK = 1e-9  # relative length by which an interval is shortened at each step

Part = tuple[float, float]


def is_covered(line: MapLine, word: Sequence[int], side: int) -> bool:
    """Whether late images of one side of a repelling cycle surround one of its points."""
    points = points_of(line, word)
    rises = line.along(word).slope > 0.0
    first = _first_part(line, word if rises else (*word, *word), points[0], side)
    if first is None:
        return False
    known, new = [first], [first]
    for _ in range(STEPS):
        longer = joined([*known, *(image for part in new for image in _images(line, part))])
        known, new = longer, [part for part in longer if part not in known]
        if any(_surrounds(part, x) for part in new for x in points):
            return True
        if not new or len(known) > PARTS:
            return False
    return False


def points_of(line: MapLine, word: Sequence[int]) -> list[float]:
    """The points of a cycle, given by the numbers of its branches."""
    start = line.along(word).fixed_point
    return [*accumulate(word[:-1], lambda x, k: line.branches[k](x), initial=start)]


def _images(line: MapLine, part: Part) -> Iterator[Part]:
    """The images of an interval that is cut at breaks, each a bit shorter than it is."""
    for branch, ends in line.parts(part):
        low, high = branch.over(ends)
        slack = SLACK * (abs(low) + abs(high) + abs(branch.intercept))
        if low + slack < high - slack:
            yield low + slack, high - slack


def _first_part(line: MapLine, word: Sequence[int], x: float, side: int) -> Part | None:
    """The first interval from a point of a cycle to a break; None if that is not certain."""
    nearest, found, scale = math.inf, None, 1.0
    for k in word:
        branch = line.branches[k]
        y = branch.upper if side > 0 else branch.lower
        if math.isfinite(y):
            slack = SLACK * (abs(x) + abs(y))
            if not (y - x) * side > 2.0 * slack:
                return None
            if abs(y - x) / scale < nearest:
                nearest = abs(y - x) / scale
                found = min(x, y) + slack, max(x, y) - slack
        scale *= abs(branch.slope)
        side = side if branch.slope > 0.0 else -side
        x = branch(x)
    return found


def _surrounds(part: Part, x: float) -> bool:
    slack = SLACK * (abs(x) + max(map(abs, part)))
    return part[0] + slack < x < part[1] - slack
