"""A discontinuous map as a picture shows it: samples where it is steep, jumps told from flanks.

Where neighbouring samples differ by more than shows, their interval is halved until it is narrower
than a pixel. To tell a jump from a flank, the half that differs more is followed down to
neighbouring doubles: what still differs there, and not less and less on the way, is a jump. (The
flank of a dip falls by a quarter of a radian for each decade; dips narrower than a pixel can be
deeper than is drawn.) An iterate has too many steep places for all of them: a budget of returns
takes the largest differences first, and what it leaves open is drawn otherwise and counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from woodpecker.base.arrays import Floats, Ints

Image = Callable[[Floats], Floats]  # values (n,) of a map at points (n,); nan where it has none
BATCH = 1024  # places looked at in one go: enough for all cores, few enough to stop in time
LATELY = 10  # halvings, three decades: what differs less and less over these is a flank to the end
NEAREST = 1e-3  # next to zero doubles are finer than rounding: spacings are not taken nearer to it


@dataclass(frozen=True, slots=True, kw_only=True)
class Detail:
    """How closely a picture looks."""

    # smallest step that shows, as a part of the height: 7 of the 920 pixels of a picture
    seen: float = 1.0 / 128.0
    # width of what is looked into, as a part of the width: half of one of its 1400 pixels
    pixel: float = 1.0 / 2800.0
    # spacings of doubles below which no interval is halved: rounding blurs the place of a jump
    finest: float = 64.0
    # returns of the toy to spend on steep places: seconds at 12 us of a compiled return
    budget: int = 150_000


class Link(IntEnum):
    """What lies between two neighbouring samples."""

    CURVE = 0  # the map, as far as a picture shows
    JUMP = 1
    OPEN = 2  # jump or steep flank: the budget ended before this was told


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapSamples:
    """Samples of a map for a picture."""

    x: Floats  # ascending points (n,)
    y: Floats  # and their values; nan where the map has none
    links: Ints  # what lies between neighbours, (n - 1,): see :class:`Link`
    bottom: float  # lower end of the picture; what lies below was not looked at
    evaluations: int  # how often the map was evaluated, besides the first samples

    def between(self, link: Link) -> Ints:
        """Indices left of all intervals of one kind."""
        return np.flatnonzero(self.links == link)

    @property
    def open_width(self) -> float:
        """Total width of the intervals that were not resolved."""
        return math.fsum(np.diff(self.x)[self.between(Link.OPEN)].tolist())


def refined(
    image: Image,
    x: Floats,
    y: Floats,
    *,
    bottom: float,
    cost: int = 1,
    detail: Detail | None = None,
) -> Iterator[MapSamples]:
    """Refine samples (n,) of a map, x ascending, each of ``cost`` returns: ever better curves."""
    search = _Refinement(image, x, y, bottom, cost, detail if detail is not None else Detail())
    yield search.curve()
    for step in (search.wide, search.narrow):
        for _ in step():
            yield search.curve()


class _Refinement:
    """A curve under construction."""

    def __init__(
        self, image: Image, x: Floats, y: Floats, bottom: float, cost: int, detail: Detail
    ) -> None:
        self.image, self.x, self.y, self.detail = image, x, y, detail
        self.told = np.full(len(x), Link.OPEN, dtype=np.int64)  # of the intervals right of x
        self.left, self.evaluations = detail.budget // cost, 0
        self.bottom, self.top = bottom, float(y[np.isfinite(y)].max(initial=bottom))
        self.height = max(self.top - bottom, math.ulp(bottom))

    def curve(self) -> MapSamples:
        """What is known so far."""
        links = np.where(self._gap(self.y[:-1], self.y[1:]) > self.detail.seen, self.told[:-1], 0)
        return MapSamples(
            x=self.x, y=self.y, links=links, bottom=self.bottom, evaluations=self.evaluations
        )

    def wide(self) -> Iterator[None]:
        """Halve what differs and is wider than a pixel, one generation after the other."""
        pixel = self.detail.pixel * float(self.x[-1] - self.x[0])
        while self.left > 0:
            differs = self._gap(self.y[:-1], self.y[1:]) > self.detail.seen
            places = np.flatnonzero(differs & (np.diff(self.x) > pixel))[: self.left]
            if not len(places):
                return
            middle = 0.5 * (self.x[places] + self.x[places + 1])
            self._keep(middle, self._at(middle), Link.OPEN)
            yield

    def narrow(self) -> Iterator[None]:
        """Tell jumps from flanks in what still differs, the largest differences first."""
        gaps = self._gap(self.y[:-1], self.y[1:])
        places = np.flatnonzero(gaps > self.detail.seen)
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
        """What some intervals are, given as x, x, y, y (4, m)."""
        starts, jumps, seen = ends[0], [ends[0, :0]], [ends[::2, :0]]
        before = np.full((LATELY, ends.shape[1]), np.nan)  # differences some halvings ago
        while ends.size:
            a, b, ya, yb = ends
            gap = self._gap(ya, yb)
            differ, tiny = gap > self.detail.seen, b - a <= self._finest(np.fmax(abs(a), abs(b)))
            falls = before[0] - gap > self.detail.seen
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
        """Width of an interval at x that is not halved."""
        finest: Floats = self.detail.finest * np.spacing(np.maximum(np.abs(x), NEAREST))
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
        """How far values lie apart in the picture, as a part of its height; nan is the bottom."""
        with np.errstate(invalid="ignore"):
            low, high = (
                np.clip(np.where(np.isnan(y), self.bottom, y), self.bottom, self.top)
                for y in (a, b)
            )
        gap: Floats = np.abs(high - low) / self.height
        return gap
