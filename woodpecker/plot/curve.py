"""Sampling of a discontinuous map for a picture, which tells jumps from steep flanks.

An interval between samples is halved while its difference in the map is visible and it is wider
than a pixel. Then bisection follows the half with the larger difference down to neighbouring
doubles: a difference that remains there, and did not decrease steadily, is a jump. (The flank of a
dip falls by a quarter of a radian per decade; dips narrower than a pixel can be deeper than drawn.)
The largest differences come first; those that the budget does not reach are drawn pale and counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from woodpecker.base.arrays import Bools, Floats, Ints

Image = Callable[[Floats], Floats]  # values (n,) of a map at points (n,); nan where it has none
BATCH = 1024  # intervals halved at once: enough for all cores, few enough to stop in time
HISTORY = 10  # halvings, three decades: a difference that decreases over them belongs to a flank
# Smallest modulus at which spacings of doubles are taken: rounding errors near zero are larger than
# the spacing there.
SPACING_FLOOR = 1e-3
ON_IT = 1e-9  # rad: samples of a continuum of fixed points are this close to the diagonal, on sides
# that rounding decides

SEEN = 1.0 / 128.0  # smallest visible step, in heights: 7 of 920 pixels
PIXEL = 1.0 / 2800.0  # narrowest visible interval, in widths: half of one of 1400 pixels
FINEST = 64.0  # narrowest interval that is halved, in spacings of doubles: beyond it is rounding
BUDGET = 150_000  # returns for steep places: seconds, at 12 us of a compiled return


class Link(IntEnum):
    """The kind of connection between two neighbouring samples."""

    CURVE = 0  # continuous, as far as a picture shows
    JUMP = 1
    OPEN = 2  # jump or flank, undecided: the budget is spent


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapSamples:
    """Samples of a map for a picture."""

    x: Floats  # ascending points (n,)
    y: Floats  # values of the map there; nan where it has none
    links: Ints  # between neighbours, (n - 1,): see :class:`Link`
    bottom: float  # lower end of the picture, below which nothing was refined
    evaluations: int  # of the map, besides the first samples

    def between(self, link: Link) -> Ints:
        """Indices of the left ends of the intervals of one kind."""
        return np.flatnonzero(self.links == link)

    @property
    def crosses(self) -> Bools:
        """For each interval (n - 1,), whether its end values lie on both sides of the diagonal."""
        above = self.y - self.x
        with np.errstate(invalid="ignore"):
            off = np.abs(above[1:]) + np.abs(above[:-1]) > ON_IT
            crosses: Bools = (above[1:] * above[:-1] < 0.0) & off
        return crosses

    def line(self) -> tuple[Floats, Floats]:
        """The continuous parts as one line, with gaps between them."""
        breaks = np.flatnonzero(self.links != Link.CURVE) + 1
        return np.insert(self.x, breaks, np.nan), np.insert(self.y, breaks, np.nan)

    def fixed(self, crosses: Bools) -> tuple[Floats, Floats]:
        """Fixed points and slopes there, by interpolation on continuous links that cross."""
        (k,) = np.nonzero(crosses & (self.links == Link.CURVE))
        slope = (self.y[k + 1] - self.y[k]) / (self.x[k + 1] - self.x[k])
        return self.x[k] + (self.y[k] - self.x[k]) / (1.0 - slope), slope

    @property
    def open_width(self) -> float:
        """Total width of the open intervals."""
        return math.fsum(np.diff(self.x)[self.between(Link.OPEN)].tolist())


def refined(
    image: Image,
    x: Floats,
    y: Floats,
    *,
    bottom: float,
    cost: int = 1,
    budget: int = BUDGET,
) -> Iterator[MapSamples]:
    """Yield finer and finer samples of a map, from (n,) first ones; one costs ``cost`` returns."""
    search = _Refinement(image, x, y, bottom, budget // cost)
    yield search.curve()
    for step in (search.wide, search.narrow):
        for _ in step():
            yield search.curve()


class _Refinement:
    """The samples while they are refined, and the budget that is left."""

    def __init__(self, image: Image, x: Floats, y: Floats, bottom: float, left: int) -> None:
        self.image, self.x, self.y = image, x, y
        self.told = np.full(len(x), Link.OPEN, dtype=np.int64)  # links to the right of each x
        self.left, self.evaluations = left, 0
        self.bottom, self.top = bottom, float(y[np.isfinite(y)].max(initial=bottom))
        self.height = max(self.top - bottom, math.ulp(bottom))

    def curve(self) -> MapSamples:
        """The samples so far."""
        links = np.where(self._gap(self.y[:-1], self.y[1:]) > SEEN, self.told[:-1], 0)
        return MapSamples(
            x=self.x, y=self.y, links=links, bottom=self.bottom, evaluations=self.evaluations
        )

    def wide(self) -> Iterator[None]:
        """Halve all intervals that are wider than a pixel and whose ends differ, until none is."""
        pixel = PIXEL * float(self.x[-1] - self.x[0])
        while self.left > 0:
            differs = self._gap(self.y[:-1], self.y[1:]) > SEEN
            places = np.flatnonzero(differs & (np.diff(self.x) > pixel))[: self.left]
            if not len(places):
                return
            middle = 0.5 * (self.x[places] + self.x[places + 1])
            self._keep(middle, self._at(middle), Link.OPEN)
            yield

    def narrow(self) -> Iterator[None]:
        """Decide between jump and flank where ends still differ, the largest differences first."""
        gaps = self._gap(self.y[:-1], self.y[1:])
        places = np.flatnonzero(gaps > SEEN)
        places = places[np.argsort(-gaps[places], kind="stable")]
        ends = np.array([self.x[places], self.x[places + 1], self.y[places], self.y[places + 1]])
        width = float((ends[1] - ends[0]).max(initial=0.0))
        while ends.size:
            halvings = 1 + math.ceil(math.log2(width / float(self._finest(ends[0]).min())))
            some = min(BATCH, self.left // halvings)
            if some < 1:
                return
            self._tell(ends[:, :some])
            ends = ends[:, some:]
            yield

    def _tell(self, ends: Floats) -> None:
        """Decide by bisection whether intervals (4, m), rows x, x, y, y, have jumps or flanks."""
        starts, jumps, seen = ends[0], [ends[0, :0]], [ends[::2, :0]]
        before = np.full((HISTORY, ends.shape[1]), np.nan)  # differences before halvings
        while ends.size:
            a, b, ya, yb = ends
            gap = self._gap(ya, yb)
            differ, tiny = gap > SEEN, b - a <= self._finest(np.fmax(abs(a), abs(b)))
            falls = before[0] - gap > SEEN
            jumps.append(a[differ & tiny & ~falls & ~np.isnan(ya + yb)])
            go_on = differ & ~tiny
            a, b, ya, yb = ends[:, go_on]
            before = np.vstack([before[1:], gap])[:, go_on]
            middle = 0.5 * (a + b)
            value = self._at(middle)
            seen.append(np.array([middle, value]))
            on_left = self._gap(ya, value) >= self._gap(value, yb)
            ends = np.where(on_left, [a, middle, ya, value], [middle, b, value, yb])
        self.told[np.searchsorted(self.x, starts)] = Link.CURVE
        points, values = np.concatenate(seen, axis=1)
        self._keep(points, values, Link.CURVE)
        self.told[np.searchsorted(self.x, np.concatenate(jumps))] = Link.JUMP

    def _finest(self, x: Floats) -> Floats:
        """Width of the narrowest interval at x that is still halved."""
        finest: Floats = FINEST * np.spacing(np.maximum(np.abs(x), SPACING_FLOOR))
        return finest

    def _at(self, x: Floats) -> Floats:
        self.left -= len(x)
        self.evaluations += len(x)
        return self.image(x)

    def _keep(self, x: Floats, y: Floats, told: Link) -> None:
        order = np.argsort(np.concatenate([self.x, x]), kind="stable")
        self.x = np.concatenate([self.x, x])[order]
        self.y = np.concatenate([self.y, y])[order]
        self.told = np.concatenate([self.told, np.full(len(x), told)])[order]

    def _gap(self, a: Floats, b: Floats) -> Floats:
        """Distance of values in the picture, as a part of its height; nan counts as the bottom."""
        with np.errstate(invalid="ignore"):
            low, high = (
                np.clip(np.where(np.isnan(y), self.bottom, y), self.bottom, self.top)
                for y in (a, b)
            )
        gap: Floats = np.abs(high - low) / self.height
        return gap
