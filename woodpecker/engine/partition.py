"""The pieces of a map at one parameter: from border to border through a window.

Margins say where a piece ends, so the next border is found by Newton's method, not by looking, and
no piece is stepped over. Where infinitely many of them accumulate, what is shorter than a cut-off
is passed, and its length is reported.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from woodpecker.engine.borders import THIN, Border, beyond, depth, reach_of
from woodpecker.engine.pieces import Image, PiecewiseMap
from woodpecker.engine.settings import Settings


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A piece of the map between two points.

    Attributes
    ----------
    x, images
        Samples in ascending order, from end to end.
    codes
        The margins that vanish at the ends; -1 at the end of the window or of what is resolved.
    """

    x: tuple[float, ...]
    images: tuple[Image, ...]
    codes: tuple[int, int]

    @property
    def low(self) -> float:
        """Where it begins."""
        return self.x[0]

    @property
    def high(self) -> float:
        """Where it ends."""
        return self.x[-1]


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """The pieces of a map at one parameter.

    Attributes
    ----------
    p, window
        The parameter, and the interval of x.
    stretches
        In ascending order. Where one begins before the one before it ends, two words differ by
        rounding only.
    gaps
        Intervals in which pieces are shorter than the cut-off, or the map has no value.
    """

    p: float
    window: tuple[float, float]
    stretches: tuple[Stretch, ...]
    gaps: tuple[tuple[float, float], ...]

    @property
    def unresolved(self) -> float:
        """Total length of the gaps."""
        return sum(high - low for low, high in self.gaps)

    def borders(self) -> Iterator[Border]:
        """Borders between stretches that touch each other."""
        for left, right in zip(self.stretches[:-1], self.stretches[1:], strict=True):
            if right.low <= left.high and left.codes[1] >= 0:
                yield Border(
                    left.high, self.p, left.images[-1], left.codes[1], 1, right.images[0],
                    right.codes[0],
                )  # fmt: skip


def partition(
    map_: PiecewiseMap, p: float, window: tuple[float, float], settings: Settings
) -> Partition:
    """The pieces of a map in a window.

    Parameters
    ----------
    map_, p
        The map and the parameter.
    window
        Interval of x, finite.
    settings
        Scales, and the cut-offs ``finest`` and ``coarse``.
    """
    walk = _Walk(map_, p, settings)
    todo = [_Gap(*window, True)]
    while todo:
        todo += reversed(walk.cross(todo.pop()))
    stretches = sorted(walk.stretches, key=lambda stretch: stretch.low)
    return Partition(p, window, tuple(stretches), tuple(sorted(walk.gaps)))


class _Gap(NamedTuple):
    """An interval to be crossed, and whether a piece beside it leads into the window."""

    low: float
    high: float
    matters: bool


class _Walk:
    """Stretches and gaps as they are found."""

    def __init__(self, map_: PiecewiseMap, p: float, settings: Settings) -> None:
        self.map, self.p, self.settings = map_, p, settings
        self.stretches: list[Stretch] = []
        self.gaps: list[tuple[float, float]] = []
        self._thin = THIN * settings.beside * settings.x_scale

    def cross(self, gap: _Gap) -> list[_Gap]:
        """Walk from piece to piece; what is left to be crossed, if something is in the way."""
        at, high, matters = gap
        found, code = self.map.at(at, self.p), -1
        while True:
            if not self._holds(found):
                return self._passed(_Gap(at, high, matters))
            way = reach_of(found, at, self.p, 1, high, self.settings)
            self.stretches.append(Stretch(way.x, way.images, (code, way.code)))
            if way.end >= high:
                return []
            matters = self._matters(way.images[-1])
            if way.code < 0 or way.end - at < self._cut_off(matters):
                return self._passed(_Gap(way.end, high, matters))
            at = way.end
            found, code = beyond(self.map, at, self.p, 1, self.settings)

    def _holds(self, image: Image) -> bool:
        """Whether the map has a value that a piece explains."""
        return not image.reason and depth(image) >= -self._thin

    def _matters(self, image: Image) -> bool:
        """Whether a piece leads into the window here."""
        low, high = self.settings.window
        return low <= image.value <= high

    def _cut_off(self, matters: bool) -> float:
        """Length of pieces that are not looked for one by one."""
        part = self.settings.finest if matters else self.settings.coarse
        return part * self.settings.x_scale

    def _passed(self, gap: _Gap) -> list[_Gap]:
        """Pass something by starting anew at a distance, back and ahead."""
        low, high, matters = gap
        cut_off = step = self._cut_off(matters)
        if high - low <= cut_off:
            self.gaps.append((low, high))
            return []
        while True:
            last = low + 2.0 * step >= high
            middle = 0.5 * (low + high) if last else low + step
            found = self.map.at(middle, self.p)
            if self._holds(found):
                back = reach_of(found, middle, self.p, -1, low, self.settings)
                if last or middle - back.end >= 0.25 * step:
                    break
            elif last:
                return [_Gap(low, middle, matters), _Gap(middle, high, matters)]
            step *= 2.0
        ahead = reach_of(found, middle, self.p, 1, high, self.settings)
        x = (*back.x[::-1], *ahead.x[1:])
        images = (*back.images[::-1], *ahead.images[1:])
        self.stretches.append(Stretch(x, images, (back.code, ahead.code)))
        inner = _Gap(low, back.end, matters or self._matters(back.images[-1]))
        left = []
        if inner.high - inner.low > self._cut_off(inner.matters):
            left.append(inner)
        elif inner.high > inner.low:
            self.gaps.append((inner.low, inner.high))
        if ahead.end < high:
            left.append(_Gap(ahead.end, high, self._matters(ahead.images[-1])))
        return left
