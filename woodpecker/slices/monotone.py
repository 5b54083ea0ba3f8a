"""The monotone branches of P_1 at one parameter, forward and inverse, interpolated by cubics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit, part
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image
from woodpecker.slices.bracketing import bracketed
from woodpecker.slices.extents import Knot, PieceExtent
from woodpecker.slices.margins import is_within
from woodpecker.slices.partition import Partition

DEEPEST = 60  # most samples about a turning point; a handful is usual
FORWARD, INVERSE = range(2)  # tasks of the interpolation: y of x, x of y
# Fraction of the window: a turning point is located until less rise is left to it.
LEAST_RISE = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """Samples of monotone branches: branch k is ``first[k]`` to ``last[k]``, with ascending values.

    A slope is infinite at a square root.
    """

    first: Ints
    last: Ints
    x: Floats
    y: Floats
    slope: Floats
    images: tuple[Image, ...]

    def __len__(self) -> int:
        return len(self.first)

    @property
    def low(self) -> Floats:
        """The smallest value of each branch (n,)."""
        return self.y[self.first]

    @property
    def high(self) -> Floats:
        """The largest value of each branch (n,)."""
        return self.y[self.last]

    def inverse(self, k: Ints, y: Floats) -> Floats:
        """The points (n,) at which branches k (n,) take values y (n,)."""
        return self._interpolated(INVERSE, k, y)

    def forward(self, k: Ints, x: Floats) -> Floats:
        """Values of branches k (n,) at x (n,)."""
        return self._interpolated(FORWARD, k, x)

    def _interpolated(self, task: int, k: Ints, at: Floats) -> Floats:
        found = np.empty(len(k))
        _interpolate(task, self.first, self.last, self.x, self.y, self.slope, k, at, found)
        return found

    def _below(self, k: int, y: float) -> int:
        """The sample of branch k at which the interval of a value begins, never its last one."""
        first, last = int(self.first[k]), int(self.last[k])
        return first + int(self.y[first + 1 : last].searchsorted(y, "right"))

    def image(self, k: int, y: float) -> Image:
        """The image of the sample of a branch nearest below a value, to continue its piece from."""
        return self.images[self._below(k, y)]

    def exact(self, k: int, y: float, p: float) -> tuple[float, Image] | None:
        """The point where the piece itself takes a value, and its image; None if it is lost."""
        i = self._below(k, y)
        if not self.y[i] <= y <= self.y[i + 1]:
            i = i if y < self.y[i] else i + 1
            return float(self.x[i]), self.images[i]
        one, other = (Knot(float(self.x[j]), self.images[j]) for j in (i, i + 1))
        return bracketed(one, other, p, lambda image, _: image.value - y)


@jit
def _interpolate(
    task: int, first: Ints, last: Ints, xs: Floats, ys: Floats, slopes: Floats, k: Ints,
    at: Floats, found: Floats,
) -> None:  # fmt: skip
    """Fill ``found`` (n,) with the values of branches k at points, or, INVERSE, with points."""
    for n in range(len(k)):
        low, high, rising = first[k[n]], last[k[n]] - 1, xs[last[k[n]]] > xs[first[k[n]]]
        while low < high:
            middle = (low + high + 1) // 2
            if task == INVERSE:
                before = ys[middle] <= at[n]
            else:
                before = xs[middle] <= at[n] if rising else xs[middle] >= at[n]
            low, high = (middle, high) if before else (low, middle - 1)
        x, run, y, rise = xs[low], xs[low + 1] - xs[low], ys[low], ys[low + 1] - ys[low]
        if task == INVERSE:
            found[n] = _x_of(at[n], x, run, y, rise, slopes[low], slopes[low + 1])
        else:
            found[n] = _y_of(at[n], x, run, y, rise, slopes[low], slopes[low + 1])


@part
def _x_of(
    at: float, x: float, run: float, y: float, rise: float, slope: float, slope_there: float
) -> float:
    """The point where the interpolant from (x, y) to (x + run, y + rise) takes the value ``at``."""
    if not rise > 0.0:
        return x + 0.5 * run
    s = min(max((at - y) / rise, 0.0), 1.0)
    bent = _cubic(s, x, x + run, rise / slope, rise / slope_there)
    return bent if min(x, x + run) <= bent <= max(x, x + run) else x + s * run


@part
def _y_of(
    at: float, x: float, run: float, y: float, rise: float, slope: float, slope_there: float
) -> float:
    """The value of the interpolant at the point ``at``."""
    s = min(max((at - x) / run, 0.0), 1.0) if run != 0.0 else 0.0
    rate, rate_there = run * slope, run * slope_there
    if math.isinf(rate_there):
        found = _root(1.0 - s, y + rise, y, -rate)
    elif math.isinf(rate):
        found = _root(s, y, y + rise, rate_there)
    else:
        found = _cubic(s, y, y + rise, rate, rate_there)
    return y + s * rise if math.isnan(found) else found


@part
def _cubic(s: float, y0: float, y1: float, rate0: float, rate1: float) -> float:
    """The value at s of the cubic with given values and slopes at 0 and 1."""
    t = 1.0 - s
    ends = (1.0 + 2.0 * s) * t * t * y0 + s * s * (3.0 - 2.0 * s) * y1
    return ends + s * t * (t * rate0 - s * rate1)


@part
def _root(s: float, y0: float, y1: float, rate1: float) -> float:
    """The value at s of y0 + c sqrt(s) + d s, a square root at 0, with value and slope at 1."""
    bend, u = 2.0 * rate1 - (y1 - y0), math.sqrt(s)
    return y0 + u * ((y1 - y0 - bend) + bend * u)


# --- Samples --------------------------------------------------------------------------------------


def branches_of(partition: Partition, settings: Settings) -> Branches:
    """The monotone branches of all pieces of a partition, cut at their turning points."""
    turned = LEAST_RISE * settings.x_scale
    parts = [part for each in partition.cylinders for part in _parts(each, turned, partition.p)]
    counts = np.array([len(part) for part in parts], dtype=np.int64)
    last = np.cumsum(counts) - 1
    samples = [sample for part in parts for sample in part]
    images = tuple(sample.image for sample in samples)
    x = np.array([sample.x for sample in samples], dtype=float)
    y, slope = (np.array([each[k] for each in images], dtype=float) for k in range(2))
    return Branches(last - counts + 1, last, x, y, slope, images)


def _parts(cylinder: PieceExtent, turned: float, p: float) -> Iterator[list[Knot]]:
    """The samples of each part of a piece between turning points, in order of values."""
    if cylinder[0].x == cylinder[-1].x:
        return
    samples = [cylinder[0]]
    for a, b in pairwise(cylinder):
        if a.image.slope * b.image.slope < 0.0:
            samples += _about_turn(a, b, turned, p)
        samples.append(b)
    rises = [b.image.value - a.image.value for a, b in pairwise(samples)]
    turns = [k for k, (a, b) in enumerate(pairwise(rises), start=1) if a * b < 0.0]
    for first, last in zip([0, *turns], [*turns, len(samples) - 1], strict=True):
        part = samples[first : last + 1]
        yield part if part[-1].image.value >= part[0].image.value else part[::-1]


def _about_turn(a: Knot, b: Knot, turned: float, p: float) -> list[Knot]:
    """More samples between two that enclose a turning point, ever closer to it from both sides."""
    left, right = list[Knot](), list[Knot]()
    for _ in range(DEEPEST):
        run, rise = b.x - a.x, b.image.value - a.image.value
        rates = a.image.slope * run, b.image.slope * run
        if rates[0] * rates[1] >= 0.0 or min(abs(rates[0]), abs(rates[1])) <= turned:
            break
        x = a.x + _turning(rise, *rates) * run
        image = a.image.piece.at(x, p)
        if not (a.x < x < b.x and is_within(image)):
            break
        if image.slope * rates[0] > 0.0:
            a = Knot(x, image)
            left.append(a)
        else:
            b = Knot(x, image)
            right.append(b)
    return [*left, *right[::-1]]


def _turning(rise: float, rate0: float, rate1: float) -> float:
    """The turning point of the cubic with this rise and these slopes, as a fraction of the way."""
    if not (math.isfinite(rate0) and math.isfinite(rate1)):
        return 0.5
    # The slope of the cubic is rate0 + 2 half s + square s^2.
    half, square = 3.0 * rise - 2.0 * rate0 - rate1, 3.0 * (rate0 + rate1 - 2.0 * rise)
    root = math.sqrt(max(0.0, half * half - square * rate0))
    both = half + math.copysign(root, -rate0)  # the root where the slope loses the sign of rate0
    way = -rate0 / both if both != 0.0 else 0.0
    return way if 0.0 < way < 1.0 else rate0 / (rate0 - rate1)
