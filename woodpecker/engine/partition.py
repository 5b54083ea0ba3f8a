"""The pieces of a map at one parameter: from border to border through a window.

Margins say where a piece ends, so the next border is found by Newton's method, not by looking, and
no piece is stepped over. Where infinitely many of them accumulate, what is shorter than a cut-off
is passed, and its length is reported.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from woodpecker.engine.borders import Border, Reach, beyond, depth, nearest_code, reach_of
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
    todo = [window]
    while todo:
        low, high = todo.pop()
        todo += reversed(walk.cross(low, high))
    stretches = sorted(walk.stretches, key=lambda stretch: stretch.low)
    return Partition(p, window, tuple(stretches), tuple(sorted(walk.gaps)))


class _Walk:
    """Stretches and gaps as they are found."""

    def __init__(self, map_: PiecewiseMap, p: float, settings: Settings) -> None:
        self.map, self.p, self.settings = map_, p, settings
        self.stretches: list[Stretch] = []
        self.gaps: list[tuple[float, float]] = []
        self._finest = settings.finest * settings.x_scale
        self._least = settings.nearest * settings.x_scale

    def cross(self, low: float, high: float) -> list[tuple[float, float]]:
        """Walk from piece to piece; what is left to be crossed, if something is in the way."""
        at = low
        found = self.map.at(low, self.p)
        code = -1
        while True:
            if found.reason or depth(found) < -self._least:
                return self._passed(at, high)
            way = reach_of(found, at, self.p, 1, high, self.settings)
            self.stretches.append(Stretch(way.x, way.images, (code, way.code)))
            if way.end >= high:
                return []
            if way.code < 0 or way.end - at < self._finest:
                return self._passed(way.end, high)
            at = way.end
            found, code = beyond(self.map, at, self.p, 1, self.settings)

    def _passed(self, low: float, high: float) -> list[tuple[float, float]]:
        """Pass something by starting anew from the middle, back and ahead."""
        if high - low <= self._finest:
            self.gaps.append((low, high))
            return []
        step = self._finest
        while True:
            middle = low + step if low + 2.0 * step < high else 0.5 * (low + high)
            found = self.map.at(middle, self.p)
            if not found.reason and depth(found) >= -self._least:
                back = reach_of(found, middle, self.p, -1, low, self.settings)
                if middle - back.end >= 0.25 * step or low + 2.0 * step >= high:
                    break
            if low + 2.0 * step >= high:
                half = 0.5 * (low + high)
                return [(low, half), (half, high)]
            step *= 2.0
        ahead = reach_of(found, middle, self.p, 1, high, self.settings)
        x = (*back.x[::-1], *ahead.x[1:])
        images = (*back.images[::-1], *ahead.images[1:])
        self.stretches.append(Stretch(x, images, (back.code, ahead.code)))
        left = [(low, back.end)] if back.end - low > self._finest else []
        if back.end > low and not left:
            self.gaps.append((low, back.end))
        return [*left, *self._after(ahead, high)]

    def _after(self, ahead: Reach, high: float) -> list[tuple[float, float]]:
        return [] if ahead.end >= high else [(ahead.end, high)]
