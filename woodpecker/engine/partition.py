"""The pieces of a map at one parameter: from border to border through a window.

Margins say where a piece ends, so the next border is found by Newton's method, not by looking, and
no piece is stepped over. Where infinitely many of them accumulate, what is shorter than a cut-off
is passed, and its length is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from woodpecker.engine.borders import THIN, Border, beyond
from woodpecker.engine.margins import depth, reach
from woodpecker.engine.pieces import Image, PiecewiseMap
from woodpecker.engine.reaches import Reach, reach_of
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


Side = Callable[[float, float], int]
"""On which side of what is looked for a value P(x) lies, from x and P(x): -1, 1, or 0 if near."""


def beside_window(settings: Settings) -> Side:
    """Below or above the window: values from which an orbit does not go on."""
    low, high = settings.window
    return lambda _, value: (value > high) - (value < low)


def beside_diagonal(settings: Settings) -> Side:
    """Below or above the diagonal, and not near: pieces that have no fixed point."""
    near = settings.near * settings.x_scale
    return lambda x, value: (value - x > near) - (value - x < -near)


def partition(
    map_: PiecewiseMap, p: float, window: tuple[float, float], settings: Settings,
    side: Side | None = None,
) -> Partition:  # fmt: skip
    """The pieces of a map in a window.

    Parameters
    ----------
    map_, p
        The map and the parameter.
    window
        Interval of x, finite.
    settings
        Scales, and the cut-offs: ``finest``, and ``coarse`` where pieces lead elsewhere.
    side
        What is looked for; by default values in the window of the settings.
    """
    walk = _Walk(map_, p, settings, side if side is not None else beside_window(settings))
    todo = [_Gap(*window, 0)]
    while todo:
        todo += reversed(walk.cross(todo.pop()))
    stretches = sorted(walk.stretches, key=lambda stretch: stretch.low)
    return Partition(p, window, tuple(stretches), _merged(sorted(walk.gaps)))


def _merged(gaps: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Intervals that touch each other as one."""
    merged: list[tuple[float, float]] = []
    for low, high in gaps:
        if merged and low <= merged[-1][1]:
            low, high = merged[-1][0], max(high, merged.pop()[1])
        merged.append((low, high))
    return tuple(merged)


class _Gap(NamedTuple):
    """An interval to be crossed.

    ``side`` is where the pieces beside it lead; ``after`` says whether one of them ends at its low
    end.
    """

    low: float
    high: float
    side: int
    after: bool = False


class _Walk:
    """Stretches and gaps as they are found."""

    def __init__(self, map_: PiecewiseMap, p: float, settings: Settings, side: Side) -> None:
        self.map, self.p, self.settings, self._side_of = map_, p, settings, side
        self.stretches: list[Stretch] = []
        self.gaps: list[tuple[float, float]] = []
        self._thin = THIN * settings.beside * settings.x_scale

    def cross(self, gap: _Gap) -> list[_Gap]:
        """Walk from piece to piece; what is left to be crossed, if something is in the way."""
        at, high, side, after = gap
        while True:
            found, code = self._beyond(at) if after else (self.map.at(at, self.p), -1)
            if not self._holds(found):
                return self._passed(_Gap(at, high, side))
            way = reach_of(found, at, self.p, 1, high, self.settings)
            self.stretches.append(Stretch(way.x, way.images, (code, way.code)))
            if way.end >= high:
                return []
            side = self._common([*self._sides(way), *([side] if side else [])])
            if way.code < 0 or way.end - at < self._cut_off(side):
                return self._passed(_Gap(way.end, high, side, way.code >= 0))
            at, after = way.end, True

    def _beyond(self, x: float) -> tuple[Image, int]:
        return beyond(self.map, x, self.p, 1, self.settings)

    def _holds(self, image: Image) -> bool:
        """Whether the map has a value that a piece explains."""
        return not image.reason and depth(image) >= -self._thin

    def _sides(self, way: Reach) -> list[int]:
        """Where the samples of a piece lead."""
        return [self._side_of(x, image.value) for x, image in zip(way.x, way.images, strict=True)]

    @staticmethod
    def _common(sides: list[int]) -> int:
        """The side that all are on; 0 if what is looked for may lie between them."""
        return sides[0] if len(set(sides)) == 1 else 0

    def _cut_off(self, side: int) -> float:
        """Length of pieces that are not looked for one by one."""
        part = self.settings.coarse if side else self.settings.finest
        return part * self.settings.x_scale

    def _passed(self, gap: _Gap) -> list[_Gap]:
        """Pass something by starting anew at a distance, back and ahead."""
        low, high, side, after = gap = self._skimmed(gap)
        cut_off = step = self._cut_off(side)
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
                return [_Gap(low, middle, side, after), _Gap(middle, high, side)]
            step *= 2.0
        ahead = reach_of(found, middle, self.p, 1, high, self.settings)
        x = (*back.x[::-1], *ahead.x[1:])
        images = (*back.images[::-1], *ahead.images[1:])
        self.stretches.append(Stretch(x, images, (back.code, ahead.code)))
        sides = self._sides(back), self._sides(ahead)
        inner = _Gap(low, back.end, self._common([side, *sides[0]]), after)
        left = []
        if inner.high - inner.low > self._cut_off(inner.side):
            left.append(inner)
        elif inner.high > inner.low:
            self.gaps.append((inner.low, inner.high))
        if ahead.end < high:
            left.append(_Gap(ahead.end, high, self._common(sides[1]), ahead.code >= 0))
        return left

    def _skimmed(self, gap: _Gap) -> _Gap:
        """What is left of a gap without its first part, where all is short and leads elsewhere."""
        low, high, side, after = gap
        step = self._cut_off(side)
        while side and low + 2.0 * step < high:
            middle = low + step
            found = self.map.at(middle, self.p)
            if not self._holds(found) or self._length(found) > step:
                break
            rise = step * abs(found.slope)
            around = [self._side_of(middle, found.value + way * rise) for way in (-1.0, 0.0, 1.0)]
            if self._common([side, *around]) == 0:
                side = 0
                break
            self.gaps.append((low, middle))
            low, after = middle, False
        return _Gap(low, high, side, after)

    @staticmethod
    def _length(image: Image) -> float:
        """Of a piece, to first order."""
        return reach(image, -1.0)[0] + reach(image, 1.0)[0]
