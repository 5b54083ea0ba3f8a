"""P_1 at one parameter on the intervals where it is monotone, interpolated between samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from woodpecker.base.arrays import Bools, Floats, Ints
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import Image
from woodpecker.slices.bracketing import bracketed
from woodpecker.slices.extents import Knot, PieceExtent
from woodpecker.slices.margins import is_within
from woodpecker.slices.partition import Partition

DEEPEST = 60  # samples about a turning point, so many that they never end; a handful is usual
TURNED = 1e-7  # part of the window: a rise so small from a turning point is none


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """P_1 on the intervals where it is monotone: samples of each, in order of their values.

    Branch k has the samples ``first[k]`` to ``last[k]``; a slope is infinite beside a square root.
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
        """Smallest values (n,)."""
        return self.y[self.first]

    @property
    def high(self) -> Floats:
        """Largest values (n,)."""
        return self.y[self.last]

    def below(self, k: Ints, y: Floats) -> Ints:
        """The last samples of branches k (n,) whose values are at most y (n,)."""
        return self._found(k, lambda middle: self.y[middle] <= y)

    def inverse(self, k: Ints, y: Floats) -> Floats:
        """Where branches k (n,) take values y (n,)."""
        low = self.below(k, y)
        y0, y1, x0, x1 = self.y[low], self.y[low + 1], self.x[low], self.x[low + 1]
        run = y1 - y0
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.clip((y - y0) / run, 0.0, 1.0)
            straight = x0 + s * (x1 - x0)
            rates = run / self.slope[low], run / self.slope[low + 1]
            bent = _cubic(s, x0, x1, *rates)
        inside = (np.minimum(x0, x1) <= bent) & (bent <= np.maximum(x0, x1))
        found: Floats = np.where(inside, bent, np.where(run > 0.0, straight, 0.5 * (x0 + x1)))
        return found

    def forward(self, k: Ints, x: Floats) -> Floats:
        """Values of branches k (n,) at x (n,)."""
        rising = self.x[self.last[k]] > self.x[self.first[k]]
        low = self._found(k, lambda i: np.where(rising, self.x[i] <= x, self.x[i] >= x))
        x0, run = self.x[low], self.x[low + 1] - self.x[low]
        y0, y1 = self.y[low], self.y[low + 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.where(run != 0.0, np.clip((x - x0) / run, 0.0, 1.0), 0.0)
            rates = run * self.slope[low], run * self.slope[low + 1]
            found: Floats = _cubic(s, y0, y1, *rates)
            found = np.where(np.isinf(rates[0]), _root(s, y0, y1, rates[1]), found)
            found = np.where(np.isinf(rates[1]), _root(1.0 - s, y1, y0, -rates[0]), found)
            return np.where(np.isnan(found), y0 + s * (y1 - y0), found)

    def _found(self, k: Ints, is_before: Callable[[Ints], Bools]) -> Ints:
        """The last samples of branches k (n,), but for the very last, that lie before something."""
        low, high = self.first[k], self.last[k] - 1
        while (low < high).any():
            middle = (low + high + 1) // 2
            before = is_before(middle)
            low, high = np.where(before, middle, low), np.where(before, high, middle - 1)
        return low

    def image(self, k: int, y: float) -> Image:
        """The sample of a branch nearest below a value."""
        return self.images[int(self.below(np.array([k]), np.array([y]))[0])]

    def exact(self, k: int, y: float, p: float) -> tuple[float, Image] | None:
        """Where the branch itself takes a value."""
        i = int(self.below(np.array([k]), np.array([y]))[0])
        if not self.y[i] <= y <= self.y[i + 1]:
            i = i if y < self.y[i] else i + 1
            return float(self.x[i]), self.images[i]
        x, to = float(self.x[i]), float(self.x[i + 1])
        return bracketed(
            {x: self.images[i], to: self.images[i + 1]}, x, to, p,
            lambda image, _: (image.value - y, image.slope),
        )  # fmt: skip


def _cubic(s: Floats, y0: Floats, y1: Floats, rate0: Floats, rate1: Floats) -> Floats:
    """Cubics with given values and slopes at 0 and 1."""
    t = 1.0 - s
    found: Floats = (
        (1.0 + 2.0 * s) * t * t * y0 + s * s * (3.0 - 2.0 * s) * y1
        + s * t * (t * rate0 - s * rate1)
    )  # fmt: skip
    return found


def _root(s: Floats, y0: Floats, y1: Floats, rate1: Floats) -> Floats:
    """Parabolas in the root of s, from a square root at 0 to a value and a slope at 1."""
    bend = 2.0 * rate1 - (y1 - y0)
    u = np.sqrt(s)
    found: Floats = y0 + u * ((y1 - y0 - bend) + bend * u)
    return found


# --- Samples --------------------------------------------------------------------------------------


def branches_of(partition: Partition, settings: Settings) -> Branches:
    """The branches of a partition, from turning point to turning point."""
    turned = TURNED * settings.x_scale
    return _joined(
        [part for each in partition.cylinders for part in _parts(each, turned, partition.p)]
    )


def _parts(cylinder: PieceExtent, turned: float, p: float) -> Iterator[list[Knot]]:
    """Samples of the parts of a piece between its turning points, values ascending."""
    if cylinder[0].x == cylinder[-1].x:
        return
    samples = [cylinder[0]]
    for a, b in pairwise(cylinder):
        samples += [*_about_turn(a, b, turned, p), b]
    rises = np.diff([sample.image.value for sample in samples])
    turns = (np.flatnonzero(rises[1:] * rises[:-1] < 0.0) + 1).tolist()
    for first, last in zip([0, *turns], [*turns, len(samples) - 1], strict=True):
        part = samples[first : last + 1]
        yield part if part[-1].image.value >= part[0].image.value else part[::-1]


def _about_turn(a: Knot, b: Knot, turned: float, p: float) -> list[Knot]:
    """Samples about a turning point between two, the last ones next to it."""
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
    """Where the cubic with these slopes turns round, as a part of the way."""
    if not (math.isfinite(rate0) and math.isfinite(rate1)):
        return 0.5
    # its slope is rate0 + 2 half s + square s^2
    half, square = 3.0 * rise - 2.0 * rate0 - rate1, 3.0 * (rate0 + rate1 - 2.0 * rise)
    root = math.sqrt(max(0.0, half * half - square * rate0))
    both = half + math.copysign(root, -rate0)  # it rises through zero, or falls
    way = -rate0 / both if both != 0.0 else 0.0
    return way if 0.0 < way < 1.0 else rate0 / (rate0 - rate1)


def _joined(parts: list[list[Knot]]) -> Branches:
    """Monotone parts, one after the other."""
    counts = np.array([len(part) for part in parts], dtype=np.int64)
    last = np.cumsum(counts) - 1
    samples = [sample for part in parts for sample in part]
    images = tuple(sample.image for sample in samples)
    x = np.array([sample.x for sample in samples])
    y, slope = (np.array([each[k] for each in images]) for k in range(2))
    return Branches(last - counts + 1, last, x, y, slope, images)
