"""The pieces of a map at one parameter: from border to border through a window.

Margins say where a piece ends, so the next border is found by Newton's method, not by looking, and
no piece is stepped over. Where infinitely many of them accumulate, what is shorter than a cut-off
is passed, and its length is reported.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from woodpecker.base.settings import Settings
from woodpecker.maps.counting import Allowance, as_counting
from woodpecker.maps.pieces import Image, PiecewiseMap
from woodpecker.slices.borders import THIN, Border, beyond
from woodpecker.slices.extents import Knot, Reach, reach_of, uneven
from woodpecker.slices.margins import depth, reach

# Part of the window: a value this close to the diagonal may have a fixed point near it, for
# neighbouring pieces of a map that accumulate differ by a few hundredths of it.
NEAR_DIAGONAL = 0.1
# Part of the window: samples of a piece lie so close that slopes at two of them and between them
# differ by such a rise; cubics are a tenth of it off, and what they do not tell is then so close to
# the diagonal that it is looked for by Newton's method.
EVEN = 5e-4
# Part of a step: a piece that reaches back by this is worth stopping at; shorter ones are stepped
# over, where infinitely many accumulate.
LONG = 0.25
# Pieces in a row that are shorter than the cut-off and are taken all the same: where borders meet
# as a parameter varies a few thin ones lie beside each other, and of infinitely many no more. Nor
# are those so thin that another one may lie between them.
FEW = 5
# Part of the shortest pieces that are looked for where all lead elsewhere: how closely the ends of
# longer ones are located there.
ROUGH = 0.0625


@dataclass(frozen=True, slots=True, eq=False)
class PieceExtent:
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
    cylinders
        In ascending order. Where one begins before the one before it ends, two words differ by
        rounding only.
    gaps
        Intervals in which pieces are shorter than the cut-off, or the map has no value.
    """

    p: float
    window: tuple[float, float]
    cylinders: tuple[PieceExtent, ...]
    gaps: tuple[tuple[float, float], ...]

    @property
    def unresolved(self) -> float:
        """Total length of the gaps."""
        return sum(high - low for low, high in self.gaps)

    def borders(self) -> Iterator[Border]:
        """Borders between cylinders that touch each other."""
        for left, right in zip(self.cylinders[:-1], self.cylinders[1:], strict=True):
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
    return lambda _, value: int(value > high) - int(value < low)


def beside_diagonal(settings: Settings) -> Side:
    """Below or above the diagonal, and not near: pieces that have no fixed point."""
    near = NEAR_DIAGONAL * settings.x_scale
    return lambda x, value: int(value - x > near) - int(value - x < -near)


def partition(
    map_: PiecewiseMap, p: float, window: tuple[float, float], settings: Settings,
    side: Side | None = None, allowed: Allowance | None = None,
) -> Partition:  # fmt: skip
    """The pieces of a map in a window.

    Where there are more of them, or where it takes more evaluations, than the settings allow, the
    longest gaps are crossed, and the others remain.

    Parameters
    ----------
    map_, p
        The map and the parameter.
    window
        Interval of x, finite.
    settings
        Scales, and the cut-offs: ``finest``, and ``coarse`` where pieces lead elsewhere.
    side
        What is looked for: borders between pieces that lead elsewhere are passed over then. By
        default all, with fewer of those that lead out of the window of the settings.
    allowed
        How often the map may be evaluated; by default as often as for a slice of P_1.
    """
    counting = as_counting(map_)
    allowed = allowed or Allowance(counting, settings.of_slice((1,)))
    walk = _Walk(counting, p, settings, side, allowed)
    todo = _Longest(_Gap(*window, 0))
    while todo:  # each gap leaves shorter ones, and none that is shorter than the cut-off
        todo.add(walk.cross(todo.pop()))
    cylinders = sorted(walk.cylinders, key=lambda cylinder: cylinder.low)
    return Partition(p, window, tuple(cylinders), _merged(sorted(walk.gaps)))


def _merged(gaps: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Intervals that touch each other as one."""
    merged: list[tuple[float, float]] = []
    for low, high in gaps:
        if merged and low <= merged[-1][1]:
            low, high = merged[-1][0], max(high, merged.pop()[1])
        merged.append((low, high))
    return tuple(merged)


class _Longest:
    """Gaps to be crossed, the longest first: if not all can be, the shortest are left."""

    def __init__(self, first: _Gap) -> None:
        self._gaps = [(-first.length, first)]

    def __len__(self) -> int:
        return len(self._gaps)

    def add(self, gaps: Iterable[_Gap]) -> None:
        """More of them."""
        for gap in gaps:
            heapq.heappush(self._gaps, (-gap.length, gap))

    def pop(self) -> _Gap:
        """The next."""
        return heapq.heappop(self._gaps)[1]


class _Gap(NamedTuple):
    """An interval to be crossed.

    Attributes
    ----------
    low, high
        Its ends.
    side
        Where the piece below it leads: 0 if not to one side, or if there is none.
    after
        Whether that piece ends at ``low``.
    above
        Where the piece above it leads, if that is known.
    """

    low: float
    high: float
    side: int
    after: bool = False
    above: int | None = None

    @property
    def length(self) -> float:
        """How long it is."""
        return self.high - self.low

    @property
    def changes(self) -> bool:
        """Whether pieces below and above lead to different sides."""
        return self.above is not None and self.above != self.side


# The side where the map has no value. Such a stretch is looked at as coarsely as where all pieces
# lead elsewhere; its ends are closed in on.
NOWHERE = 2


class _Walk:
    """Cylinders and gaps as they are found."""

    def __init__(
        self, map_: PiecewiseMap, p: float, settings: Settings, side: Side | None,
        allowed: Allowance,
    ) -> None:  # fmt: skip
        self.map, self.p, self.settings, self._all = map_, p, settings, side is None
        self._side_of = side or beside_window(settings)
        self._allowed = allowed
        self.cylinders: list[PieceExtent] = []
        self.gaps: list[tuple[float, float]] = []
        self._even = EVEN * settings.x_scale
        self._thin = THIN * settings.beside * settings.x_scale
        self._short = settings.coarse * settings.x_scale
        self._rough = replace(settings, nearest=max(settings.nearest, ROUGH * settings.coarse))

    def cross(self, gap: _Gap) -> list[_Gap]:
        """Walk from piece to piece; what is left to be crossed, if something is in the way."""
        if self._is_full:
            return self._left(gap)
        if gap.changes:
            return self._halved(gap)
        at, high, side, after, _ = gap
        ahead: Image | None = None
        short = 0
        while True:  # each piece begins where the one before it ends, and they are counted
            found, code = ahead, -1
            if found is None:
                found, code = self._beyond(at) if after else (self.map.at(at, self.p), -1)
            if not self._holds(found):
                return self._passed(_Gap(at, high, NOWHERE if found.reason else side))
            way, ahead = self._onward(found, at, high)
            self.cylinders.append(PieceExtent(way.x, way.images, (code, way.code)))
            if way.end >= high:
                return []
            side = self._common([*self._sides(way), *([side] if side else [])])
            rest = _Gap(way.end, high, side, way.code >= 0)
            length = way.end - at
            short = short + 1 if length < self._cut_off(rest) else 0
            if way.code < 0 or short > FEW or (short and length < self._thin):
                return self._passed(rest)
            at, after = way.end if ahead is None else way.end + self._short, True
            if self._is_full:
                return self._left(rest)

    def _onward(self, image: Image, x: float, high: float) -> tuple[Reach, Image | None]:
        """How far a piece reaches; and the piece a short way beyond, if both lead to one side.

        Where exactly it ends does not matter then.
        """
        side = 0 if self._all else self._leads(image, x, 1, high)
        if side:
            way = reach_of(image, x, self.p, 1, high, self._rough, self._missing)
            to = way.end + self._short
            if self._common(self._sides(way)) == side and way.code >= 0 and to < high:
                ahead = self.map.at(to, self.p)
                if self._holds(ahead) and self._leads(ahead, to, -1, way.end) == side:
                    begin = to - reach(ahead, -1.0)[0]
                    if begin > way.end:
                        self.gaps.append((way.end, begin))
                    return way, ahead
        return self._reach(image, x, 1, high), None

    def _leads(self, image: Image, x: float, side: int, limit: float) -> int:
        """Where a piece leads from a point to its end on a side, to first order; 0 if not to one.

        No farther than to a limit, or than samples of it are apart.
        """
        longest = self.settings.max_step * self.settings.x_scale
        way = side * min(reach(image, side)[0], abs(limit - x), longest)
        ends = (x, image.value), (x + way, image.value + way * image.slope)
        return self._common([self._side_of(*end) for end in ends])

    @property
    def _is_full(self) -> bool:
        """Whether there are as many pieces as allowed, or the map was evaluated as often."""
        return len(self.cylinders) >= self.settings.max_pieces or self._allowed.spent

    def _left(self, gap: _Gap) -> list[_Gap]:
        """Leave a gap as it is."""
        self.gaps.append((gap.low, gap.high))
        return []

    def _missing(self, here: Knot, there: Knot) -> float:
        """Where samples of a piece do not tell what lies between them, if it matters."""
        sides = [self._side_of(each.x, each.image.value) for each in (here, there)]
        return 0.0 if self._common(sides) else uneven(here, there, self._even)

    def _reach(self, image: Image, x: float, side: int, limit: float) -> Reach:
        return reach_of(image, x, self.p, side, limit, self.settings, self._missing)

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

    def _cut_off(self, gap: _Gap) -> float:
        """Length of pieces that are not looked for one by one."""
        fine = gap.side == 0 or gap.changes
        return (self.settings.finest if fine else self.settings.coarse) * self.settings.x_scale

    def _passed(self, gap: _Gap) -> list[_Gap]:
        """Pass something by starting anew at a distance, back and ahead."""
        gap = self._skimmed(gap)
        step = self._cut_off(gap)
        if gap.length <= step:
            return self._left(gap)
        while True:  # the step doubles until it is half of the gap
            last = gap.low + 2.0 * step >= gap.high
            middle = 0.5 * (gap.low + gap.high) if last else gap.low + step
            found = self.map.at(middle, self.p)
            if self._holds(found):
                back = self._reach(found, middle, -1, gap.low)
                if last or middle - back.end >= LONG * step:
                    return self._around(gap, back)
            elif last:
                side = NOWHERE if found.reason else gap.side
                return [gap._replace(high=middle), _Gap(middle, gap.high, side)]
            step *= 2.0

    def _halved(self, gap: _Gap) -> list[_Gap]:
        """Close in on where pieces begin to lead to another side."""
        middle = 0.5 * (gap.low + gap.high)
        found = self.map.at(middle, self.p)
        if self._holds(found):
            return self._around(gap, self._reach(found, middle, -1, gap.low))
        halves = gap._replace(high=middle, above=NOWHERE), gap._replace(low=middle, side=NOWHERE)
        return self._kept(*halves)

    def _around(self, gap: _Gap, back: Reach) -> list[_Gap]:
        """Keep a piece that was followed to its low end; what it leaves of a gap."""
        found, middle = back.images[0], back.x[0]
        ahead = self._reach(found, middle, 1, gap.high)
        x = (*back.x[::-1], *ahead.x[1:])
        images = (*back.images[::-1], *ahead.images[1:])
        self.cylinders.append(PieceExtent(x, images, (back.code, ahead.code)))
        below, above = self._common(self._sides(back)), self._common(self._sides(ahead))
        inner = _Gap(gap.low, back.end, gap.side, gap.after, below)
        rest = _Gap(ahead.end, gap.high, above, ahead.code >= 0, gap.above)
        onward = self._kept(rest) if gap.above is not None else [rest] if rest.length > 0.0 else []
        return [*self._kept(inner), *onward]

    def _kept(self, *gaps: _Gap) -> list[_Gap]:
        """Those that are long enough to be crossed."""
        for gap in gaps:
            if 0.0 < gap.length <= self._cut_off(gap):
                self.gaps.append((gap.low, gap.high))
        return [gap for gap in gaps if gap.length > self._cut_off(gap)]

    def _skimmed(self, gap: _Gap) -> _Gap:
        """What is left of a gap without its first part, where all is short and leads elsewhere."""
        step = self._cut_off(gap)
        while gap.side and gap.low + 2.0 * step < gap.high and not self._is_full:
            middle = gap.low + step
            found = self.map.at(middle, self.p)
            if not self._holds(found) or self._length(found) > step:
                break
            rise = step * abs(found.slope)
            around = [self._side_of(middle, found.value + way * rise) for way in (-1.0, 0.0, 1.0)]
            if self._common([gap.side, *around]) == 0:
                return gap._replace(side=0)
            self.gaps.append((gap.low, middle))
            gap = gap._replace(low=middle, after=False)
        return gap

    @staticmethod
    def _length(image: Image) -> float:
        """Of a piece, to first order."""
        return reach(image, -1.0)[0] + reach(image, 1.0)[0]
