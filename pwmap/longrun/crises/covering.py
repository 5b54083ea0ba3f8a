"""Repelling cycles that lie inside of bands: an image of a break that meets them ends no band.

A short interval beside a point of the cycle is followed along it to a break, and on. If an image
surrounds a point of the cycle, the cycle lies inside of every band to which the break may belong,
there and nearby: no band ends, begins or merges. Doubles decide, with intervals that are shortened
at each step by far more than their error; in doubt nothing is claimed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pwmap.algebra.exact import Affine
from pwmap.longrun.line import MapLine, cut_at
from pwmap.longrun.numbers import to_double

STEPS = 24  # in which the interval grows, at most
PARTS = 24  # of its images, at most
SLACK = 1e-9  # relative length by which an interval is shortened at each step

Part = tuple[float, float]


@dataclass(frozen=True, slots=True)
class DoubleMap:
    """A map at one place, in doubles: slopes and intercepts of its pieces, and its breaks."""

    slopes: Sequence[float]
    intercepts: Sequence[float]
    breaks: Sequence[float]

    def cycle(self, word: Sequence[int]) -> tuple[list[float], float]:
        """The points of a cycle, given by the numbers of its pieces, and its multiplier."""
        whole = Affine(1.0, 0.0)
        for k in word:
            whole = Affine(self.slopes[k], self.intercepts[k]).after(whole)
        points = [whole.fixed_point]
        for k in word[:-1]:
            points.append(self.slopes[k] * points[-1] + self.intercepts[k])
        return points, whole.slope

    def images(self, part: Part) -> Iterator[Part]:
        """The images of an interval that is cut at breaks, each a bit shorter than it is."""
        for k, ends in cut_at(self.breaks, part):
            one, other = (self.slopes[k] * x + self.intercepts[k] for x in ends)
            slack = SLACK * (abs(one) + abs(other) + abs(self.intercepts[k]))
            one, other = min(one, other) + slack, max(one, other) - slack
            if one < other:
                yield one, other


def doubles_of(line: MapLine) -> DoubleMap:
    """A map in doubles."""
    slopes, intercepts = ([to_double(branch[k]) for branch in line.branches] for k in (0, 1))
    return DoubleMap(slopes, intercepts, [to_double(x) for x in line.breaks])


def is_covered(line: DoubleMap, word: Sequence[int], side: int) -> bool:
    """Whether late images of one side of a repelling cycle surround one of its points."""
    points, slope = line.cycle(word)
    first = _first_part(line, word if slope > 0.0 else (*word, *word), points[0], side)
    if first is None:
        return False
    known, new = [first], [first]
    for _ in range(STEPS):
        images = [image for part in new for image in line.images(part)]
        new = []
        for low, high in images:
            if any(a <= low and high <= b for a, b in known):
                continue
            met = [(a, b) for a, b in known if a < high and low < b]
            lows, highs = zip((low, high), *met, strict=True)
            new.append((min(lows), max(highs)))
            known = [*(part for part in known if part not in met), new[-1]]
        if any(_surrounds(part, x) for part in new for x in points):
            return True
        if not new or len(known) > PARTS:
            return False
    return False


def _first_part(line: DoubleMap, word: Sequence[int], x: float, side: int) -> Part | None:
    """The first interval from a point of a cycle to a break; None if that is not certain."""
    nearest, found, scale = math.inf, None, 1.0
    for k in word:
        end = k if side > 0 else k - 1
        if 0 <= end < len(line.breaks):
            y = line.breaks[end]
            slack = SLACK * (abs(x) + abs(y))
            if not (y - x) * side > 2.0 * slack:
                return None
            if abs(y - x) / scale < nearest:
                nearest = abs(y - x) / scale
                found = min(x, y) + slack, max(x, y) - slack
        scale *= abs(line.slopes[k])
        side = side if line.slopes[k] > 0.0 else -side
        x = line.slopes[k] * x + line.intercepts[k]
    return found


def _surrounds(part: Part, x: float) -> bool:
    slack = SLACK * (abs(x) + max(map(abs, part)))
    return part[0] + slack < x < part[1] - slack
