"""The pieces of a map at one parameter, from border to border through a window.

Margins say where a piece ends, so that no piece is stepped over. Where infinitely many accumulate,
pieces shorter than a cut-off are passed over, and their total length is reported.
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
from woodpecker.slices.borders import LEAST_PIECE, Border
from woodpecker.slices.extents import (
    SAME_BORDER,
    Knot,
    PieceExtent,
    samples_to_border,
    where_to_refine,
)
from woodpecker.slices.margins import depth, nearest_code, next_border

# Fraction of the window by which values in a gap may differ from those at its ends: neighbouring
# pieces that accumulate differ by a few hundredths of it.
GAP_TOLERANCE = 0.1
# Fraction of the window by which the rise between two samples may differ from that of their mean
# slope: cubics then err by a tenth of it, and where they come that close to the diagonal without
# crossing Newton's method is tried.
RISE_TOLERANCE = 5e-4
# Halvings of a gap that is shorter than the cut-off: near a parameter at which borders meet a few
# thin pieces lie side by side.
EXTRA_HALVINGS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """The pieces of a map at one parameter, ascending, and the gaps between them.

    In a gap the pieces are shorter than the cut-off, or the map has no value.
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
        """The borders of neighbouring pieces; two where a gap below the cut-off lies between."""
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
    """The pieces of a map in a finite window, except for some that are shorter than a cut-off.

    The cut-off is ``finest``, or ``coarse`` where no cycle or jump of the iterates ``orders`` can
    lie; without orders, where pieces lead out of the window of the settings. The longest gap is
    divided first, until ``max_pieces`` or the ``allowed`` evaluations, by default of P_1, are used.
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
    """Ascending intervals, of which those that touch are joined."""
    merged: list[tuple[float, float]] = []
    for low, high in gaps:
        if merged and low <= merged[-1][1]:
            low, high = merged[-1][0], max(high, merged.pop()[1])
        merged.append((low, high))
    return tuple(merged)


class _Gap(NamedTuple):
    """An interval whose pieces are not known yet; the longest comes first in a heap."""

    size: float  # minus its length, by which gaps are sorted
    low: float
    high: float
    # Values of the map at its ends: infinite at an end of the window, nan where the map has none.
    below: float = math.inf
    above: float = -math.inf
    left: int = EXTRA_HALVINGS  # halvings left once it is shorter than the cut-off


# The "side" of points without a value: intervals of them are divided as coarsely as those that lead
# to one side of the window, except at their ends.
NOWHERE = 2


class _Finder:
    """The pieces found so far, and the gaps left between them."""

    def __init__(
        self, map_: PiecewiseMap, p: float, settings: Settings, orders: Sequence[int]
    ) -> None:
        self.map, self.p, self.settings, self.orders = map_, p, settings, orders
        self.pieces: list[PieceExtent] = []
        self.gaps: list[tuple[float, float]] = []
        scale = settings.x_scale
        self._window, self._diagonal = settings.window, tuple(orders) == (1,)
        self._near, self._even = GAP_TOLERANCE * scale, RISE_TOLERANCE * scale
        self._nearest = settings.nearest * scale
        self._thin = LEAST_PIECE * settings.beside * scale
        self._short, self._finest = settings.coarse * scale, settings.finest * scale
        self._longest = settings.max_step * scale
        self._samples: Floats | None = None

    def matters(self, gap: _Gap) -> bool:
        """Whether a gap is longer than ``coarse``, or may hold a cycle or jump of ``orders``.

        Values in a gap are close to those at its ends. As the longest gaps are divided first, such
        values are known wherever orbits from the gap lead.
        """
        if -gap.size > self._short:
            return True
        if self._is_aside(gap):
            return False
        if not self.orders or math.isnan(gap.below + gap.above):  # an end of the map's values
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
        """Whether the map leads from both ends of a gap to the same side, and so from all of it."""
        return 0 != self._side(gap.low, gap.below) == self._side(gap.high, gap.above)

    def _image(self, low: float, high: float) -> tuple[float, float]:
        """The range of values over an interval, by the samples in it and next to it."""
        if self._samples is None:
            found = sorted((knot.x, knot.image.value) for piece in self.pieces for knot in piece)
            self._samples = np.array(found).reshape(-1, 2).T
        x, value = self._samples
        first, last = np.searchsorted(x, (low, high))
        near = value[max(first - 1, 0) : last + 1]
        return float(near.min(initial=math.inf)), float(near.max(initial=-math.inf))

    def crossed(self, gap: _Gap) -> Iterator[_Gap]:
        """Find the piece in the middle of a gap, and yield the gaps that remain on both sides."""
        x = 0.5 * (gap.low + gap.high)
        image = self.map.at(x, self.p)
        low, high, ends = x, x, (image.value, image.value)
        if image.reason or depth(image) < -self._thin:
            ends = math.nan, math.nan
        else:
            passed = self._is_aside(gap) and self._leads(image, x) == self._side(gap.low, gap.below)
            if not passed or next_border(image, -1.0)[0] + next_border(image, 1.0)[0] > self._short:
                x, image = self._within(x, image, gap)
                back = self._reach(image, x, -1, gap.low)
                ahead = self._reach(image, x, 1, gap.high)
                self.pieces.append((*reversed(back), *(ahead[1:] or ahead)))
                low, high = back[-1].x, ahead[-1].x
                ends = back[-1].image.value, ahead[-1].image.value
        yield from self._open(_Gap(gap.low - low, gap.low, low, gap.below, ends[0], gap.left))
        yield from self._open(_Gap(high - gap.high, high, gap.high, ends[1], gap.above, gap.left))

    def _within(self, x: float, image: Image, gap: _Gap) -> tuple[float, Image]:
        """The point from which a piece is followed, x or one beside it, and its image."""
        # If two events of a return coincide at x, the map takes at this single point a path with
        # both at once, which margins need not bound: its piece is none of an interval.
        if depth(image) > self._thin or not gap.low < x - self._thin < x + self._thin < gap.high:
            return x, image
        places = x - self._thin, x + self._thin
        before, after = (self.map.at(place, self.p) for place in places)
        holds = image.piece.key in (before.piece.key, after.piece.key)
        return (x, image) if holds else (places[1], after)

    def _open(self, gap: _Gap) -> Iterator[_Gap]:
        """Yield a gap if it is to be divided; one below the cut-off is added to ``gaps``."""
        if -gap.size > self._finest:
            yield gap
        elif gap.left > 0 and -gap.size > self._thin:
            yield gap._replace(left=gap.left - 1)
        elif gap.size < 0.0:
            self.gaps.append((gap.low, gap.high))

    def _reach(self, image: Image, x: float, way: int, limit: float) -> list[Knot]:
        """Samples of a piece up to its end, which is put at ``limit`` if the next piece touches."""
        found = samples_to_border(image, x, self.p, way, limit, self.settings, self._missing)
        end = found[-1]
        if len(found) > 1 and abs(end.x - limit) <= SAME_BORDER * self._nearest:
            code = end.code if end.code >= 0 else nearest_code(end.image, way)
            found[-1] = Knot(limit, end.image, code)
        return found

    def _leads(self, image: Image, x: float) -> int:
        """The side to which all of a piece leads, to first order; 0 if not all to the same."""
        ways = [side * min(next_border(image, side)[0], self._longest) for side in (-1.0, 1.0)]
        sides = {self._side(x + way, image.value + way * image.slope) for way in (0.0, *ways)}
        return sides.pop() if len(sides) == 1 else 0

    def _side(self, x: float, value: float) -> int:
        """The side of the window, for P_1 alone of the diagonal, of a value; 0 if in or near it."""
        low, high = (x - self._near, x + self._near) if self._diagonal else self._window
        if low <= value <= high:
            return 0
        return NOWHERE if math.isnan(value) else 1 if value > high else -1

    def _missing(self, here: Knot, there: Knot) -> float:
        """Where another sample is needed between two; 0 if nowhere, or if both lead to one side."""
        side = self._side(here.x, here.image.value)
        if side != 0 and side == self._side(there.x, there.image.value):
            return 0.0
        return where_to_refine(here, there, self._even)
