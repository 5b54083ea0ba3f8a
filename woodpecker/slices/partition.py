"""The pieces of a map at one parameter: from border to border through a window.

Margins say where a piece ends, so the next border is found by Newton's method, not by looking, and
no piece is stepped over. Where infinitely many of them accumulate, what is shorter than a cut-off
is passed, and its length is reported.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps.counting import Allowance, as_counting
from woodpecker.maps.pieces import Image, PiecewiseMap
from woodpecker.slices.borders import THIN, Border
from woodpecker.slices.extents import BOTH, Knot, PieceExtent, reach_of, uneven
from woodpecker.slices.margins import depth, nearest_code, reach

# Part of the window: by how much values in a gap may differ from those beside it, for neighbouring
# pieces of a map that accumulate differ by a few hundredths of it.
ASTRAY = 0.1
# Part of the window: samples of a piece lie so close that slopes at two of them and between them
# differ by such a rise; cubics are a tenth of it off, and what they do not tell is then so close to
# the diagonal that it is looked for by Newton's method.
EVEN = 5e-4
# How often a gap that is shorter than the cut-off is halved all the same: where borders meet as a
# parameter varies a few thin pieces lie beside each other.
FEW = 3


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """The pieces of a map at one parameter, in ascending order, and what is left between them.

    In the gaps pieces are shorter than the cut-off, or the map has no value.
    """

    p: float
    window: tuple[float, float]
    cylinders: tuple[PieceExtent, ...]
    gaps: tuple[tuple[float, float], ...]

    @property
    def unresolved(self) -> float:
        """Total length of the gaps."""
        return sum(high - low for low, high in self.gaps)

    def borders(self, settings: Settings) -> Iterator[Border]:
        """Borders of cylinders, with the images of the next ones beyond.

        Where a gap is left between two that is shorter than the cut-off, both its ends.
        """
        longest = settings.finest * settings.x_scale
        for left, right in pairwise(self.cylinders):
            one, other = left[-1], right[0]
            if other.x - one.x > longest:
                continue
            if one.code >= 0:
                yield Border(one.x, self.p, one.image, one.code, 1, other.image, other.code)
            if other.code >= 0 and (other.x > one.x or one.code < 0):
                yield Border(other.x, self.p, other.image, other.code, -1, one.image, one.code)


def partition(
    map_: PiecewiseMap, p: float, window: tuple[float, float], settings: Settings,
    orders: Sequence[int] = (), allowed: Allowance | None = None,
) -> Partition:  # fmt: skip
    """The pieces of a map in a finite window: all, but for some of those shorter than a cut-off.

    That is ``finest``, or ``coarse`` where no cycle or jump of the iterates ``orders`` can be; by
    default where pieces lead out of the window of the settings. Where there are more pieces, or it
    takes more evaluations, than allowed, by default for P_1, the longest gaps are crossed first.
    """
    counting = as_counting(map_)
    allowed = allowed or Allowance(counting, settings.of_slice((1,)))
    finder = _Finder(counting, p, settings, orders)
    todo = [_Gap(window[0] - window[1], *window)]
    while todo:  # each gap leaves shorter ones, and none that is shorter than the cut-off
        gap = heapq.heappop(todo)
        full = len(finder.pieces) >= settings.max_pieces or allowed.spent
        if full or not finder.matters(gap):
            finder.gaps.append((gap.low, gap.high))
        else:
            for each in finder.crossed(gap):
                heapq.heappush(todo, each)
    pieces = sorted(finder.pieces, key=lambda piece: piece[0].x)
    return Partition(p, window, tuple(pieces), _merged(sorted(finder.gaps)))


def _merged(gaps: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Intervals that touch each other as one."""
    merged: list[tuple[float, float]] = []
    for low, high in gaps:
        if merged and low <= merged[-1][1]:
            low, high = merged[-1][0], max(high, merged.pop()[1])
        merged.append((low, high))
    return tuple(merged)


class _Gap(NamedTuple):
    """An interval in which pieces are not known yet; the longest comes first.

    ``below`` and ``above`` are the values beside it: infinite at an end of the window, where none
    is known, and nan where the map has none. Shorter than the cut-off it is halved so often yet.
    """

    size: float  # its length, less than zero
    low: float
    high: float
    below: float = math.inf
    above: float = -math.inf
    left: int = FEW


# Where the map has no value. Such a stretch is looked at as coarsely as where all pieces lead
# elsewhere; its ends are closed in on.
NOWHERE = 2


class _Finder:
    """The pieces that were found, and the gaps that are left between them."""

    def __init__(
        self, map_: PiecewiseMap, p: float, settings: Settings, orders: Sequence[int]
    ) -> None:
        self.map, self.p, self.settings, self.orders = map_, p, settings, orders
        self.pieces: list[PieceExtent] = []
        self.gaps: list[tuple[float, float]] = []
        scale = settings.x_scale
        self._window, self._diagonal = settings.window, tuple(orders) == (1,)
        self._near, self._even = ASTRAY * scale, EVEN * scale
        self._nearest = settings.nearest * scale
        self._thin = THIN * settings.beside * scale
        self._short, self._finest = settings.coarse * scale, settings.finest * scale
        self._longest = settings.max_step * scale
        self._samples: Floats | None = None

    def matters(self, gap: _Gap) -> bool:
        """Whether a gap is long, or a cycle or a jump that is asked for may lie in it.

        What is in a gap leads near to where the pieces beside it do. The longest gaps are crossed
        first, so that of all the others is known where they lead.
        """
        if -gap.size > self._short:
            return True
        if self._is_aside(gap):
            return False
        if not self.orders or math.isnan(gap.below + gap.above):  # the end of a map is closed in on
            return True
        low, high = min(gap.below, gap.above), max(gap.below, gap.above)
        for order in range(1, max(self.orders) + 1):
            low, high = low - self._near, high + self._near
            if order in self.orders and low <= gap.high and gap.low <= high:
                return True
            if order < max(self.orders):
                low, high = self._image(low, high)
        return False

    def _is_aside(self, gap: _Gap) -> bool:
        """Whether the pieces beside a gap lead to one side of all that is looked for."""
        return 0 != self._side(gap.low, gap.below) == self._side(gap.high, gap.above)

    def _image(self, low: float, high: float) -> tuple[float, float]:
        """Between which values the map leads from an interval, by the samples in and beside it."""
        if self._samples is None:
            found = sorted((knot.x, knot.image.value) for piece in self.pieces for knot in piece)
            self._samples = np.array(found).reshape(-1, 2).T
        x, value = self._samples
        first, last = np.searchsorted(x, (low, high))
        near = value[max(first - 1, 0) : last + 1]
        return float(near.min(initial=math.inf)), float(near.max(initial=-math.inf))

    def crossed(self, gap: _Gap) -> Iterator[_Gap]:
        """Look at the middle of a gap: what is left on both sides of the piece that is there."""
        x = 0.5 * (gap.low + gap.high)
        image = self.map.at(x, self.p)
        low, high, ends = x, x, (image.value, image.value)
        if image.reason or depth(image) < -self._thin:
            ends = math.nan, math.nan
        else:
            passed = self._is_aside(gap) and self._leads(image, x) == self._side(gap.low, gap.below)
            if not passed or reach(image, -1.0)[0] + reach(image, 1.0)[0] > self._short:
                x, image = self._within(x, image, gap)
                back = self._reach(image, x, -1, gap.low)
                ahead = self._reach(image, x, 1, gap.high)
                self.pieces.append((*reversed(back), *(ahead[1:] or ahead)))
                low, high = back[-1].x, ahead[-1].x
                ends = back[-1].image.value, ahead[-1].image.value
        yield from self._open(_Gap(gap.low - low, gap.low, low, gap.below, ends[0], gap.left))
        yield from self._open(_Gap(high - gap.high, high, gap.high, ends[1], gap.above, gap.left))

    def _within(self, x: float, image: Image, gap: _Gap) -> tuple[float, Image]:
        """A point of a piece that is about to be followed, and its image.

        Where two events of a return coincide the map takes a path of both at once at that point
        only, on whose border it is, and whose margins need not end it: then a point beside it.
        """
        if depth(image) > self._thin or not gap.low < x - self._thin < x + self._thin < gap.high:
            return x, image
        places = x - self._thin, x + self._thin
        before, after = (self.map.at(place, self.p) for place in places)
        holds = image.piece.key in (before.piece.key, after.piece.key)
        return (x, image) if holds else (places[1], after)

    def _open(self, gap: _Gap) -> Iterator[_Gap]:
        """A gap unless it is too short to be crossed."""
        if -gap.size > self._finest:
            yield gap
        elif gap.left > 0 and -gap.size > self._thin:
            yield gap._replace(left=gap.left - 1)
        elif gap.size < 0.0:
            self.gaps.append((gap.low, gap.high))

    def _reach(self, image: Image, x: float, way: int, limit: float) -> list[Knot]:
        """A piece to its end, or to that of the piece which it touches there."""
        found = reach_of(image, x, self.p, way, limit, self.settings, self._missing)
        end = found[-1]
        if len(found) > 1 and abs(end.x - limit) <= BOTH * self._nearest:
            code = end.code if end.code >= 0 else nearest_code(end.image, way)
            found[-1] = Knot(limit, end.image, code)
        return found

    def _leads(self, image: Image, x: float) -> int:
        """Where a piece leads from end to end, to first order; 0 if not to one side."""
        ways = [side * min(reach(image, side)[0], self._longest) for side in (-1.0, 1.0)]
        sides = {self._side(x + way, image.value + way * image.slope) for way in (0.0, *ways)}
        return sides.pop() if len(sides) == 1 else 0

    def _side(self, x: float, value: float) -> int:
        """On which side of all that is looked for a value lies; 0 if near."""
        low, high = (x - self._near, x + self._near) if self._diagonal else self._window
        if low <= value <= high:
            return 0
        return NOWHERE if math.isnan(value) else 1 if value > high else -1

    def _missing(self, here: Knot, there: Knot) -> float:
        """Where samples of a piece do not tell what lies between them, if it matters."""
        side = self._side(here.x, here.image.value)
        if side != 0 and side == self._side(there.x, there.image.value):
            return 0.0
        return uneven(here, there, self._even)
