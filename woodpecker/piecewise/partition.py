"""Pieces of a map at fixed parameter: maximal intervals of constant word, and what crosses in them.

The window is sampled, and every interval between samples is looked at again at its middle: where
the words of its ends differ it is bisected down to neighbouring doubles, where they agree the
middle must lie on the cubic through the values and exact slopes of both ends. An interval that
fails is halved, so samples gather where the map bends and where words change. All intervals of one
generation are mapped in one call.

Near a dip and near an accumulation of impacts there are infinitely many pieces. Below a stated
width no new word is looked for: such an interval is reported as unresolved.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from pwmap.diagrams.diagram import runs_of
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.checks import interval, number, positive, whole
from woodpecker.piecewise.borders import NEAR, WIDENINGS, Edge, is_continuous, limit_of
from woodpecker.piecewise.maps import BELOW, SEPARATOR, Evaluation, LabelledMap
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolution:
    """How closely a map is looked at.

    Parameters
    ----------
    spacing
        Largest distance of first samples.
    smallest
        Pieces narrower than this are not looked for: where one shows, the interval is unresolved.
    bend
        Largest distance of a value from the cubic through its neighbours.
    edge
        How well an edge is located at which values differ by less than ``close``; others, which may
        be jumps, are located to the last bit. Zero locates all of them to the last bit.
    far
        In a search for what crosses the diagonal, the width below which an interval is not looked
        at further if the slopes at both ends lead nowhere near it.
    """

    spacing: float = 1e-3
    smallest: float = 1e-8
    bend: float = 1e-6
    far: float = 1e-4
    edge: float = 0.0
    close: float = 1e-4

    def __post_init__(self) -> None:
        if not number("edge", self.edge) >= 0.0:
            raise ValueError(f"edge must not be negative, got {self.edge}")
        for name in ("spacing", "smallest", "bend", "far", "close"):
            positive(name, getattr(self, name))


class Samples(NamedTuple):
    """A map at many points; arrays of shape (n,). ``words`` are indices into a list of words."""

    x: Floats
    value: Floats
    slope: Floats
    rate: Floats
    words: Ints
    defined: Bools

    def take(self, index: slice | Ints | Bools) -> Samples:
        """Some of the points."""
        return Samples._make([column[index] for column in self])

    def joined(self, other: Samples) -> Samples:
        """Both, sorted by x."""
        order = np.argsort(np.concatenate([self.x, other.x]), kind="stable")
        return Samples._make(
            [np.concatenate(pair)[order] for pair in zip(self, other, strict=True)]
        )


class WordBook:
    """Numbers for words, given out as they come; several threads may ask at once.

    A copy begins anew: numbers mean something to the book only that has given them out.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._known: dict[Hashable, int] = {}
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type[WordBook], tuple[()]]:
        return WordBook, ()

    def index(self, key: Hashable, text: Callable[[], str]) -> int:
        """The number of a key; ``text`` makes its word when it is new."""
        found = self._known.get(key)
        if found is None:
            with self._lock:
                found = self._known.get(key)
                if found is None:
                    self.texts.append(text())
                    found = self._known[key] = len(self.texts) - 1
        return found


class SampledMap(Protocol):
    """A map that takes many points at once, such as :func:`sampled` makes of a labelled map."""

    @property
    def words(self) -> Sequence[str]:
        """Word of each index that ``sweep`` has given out so far."""

    def sweep(self, x: Floats, p: float) -> Samples:
        """The map at points (n,) and a parameter."""


def sampled(labelled_map: LabelledMap) -> SampledMap:
    """Any labelled map, one point after the other."""
    return _PointByPoint(labelled_map)


@dataclass(frozen=True, slots=True)
class _PointByPoint:
    map: LabelledMap
    book: WordBook = field(default_factory=WordBook, init=False, repr=False, compare=False)

    @property
    def words(self) -> Sequence[str]:
        return self.book.texts

    def sweep(self, x: Floats, p: float) -> Samples:
        laps = [self.map(value, p) for value in x.tolist()]
        value, slope, rate = np.array([lap[:3] for lap in laps], dtype=float).reshape(-1, 3).T
        index = np.array([self.book.index(w, w.__str__) for *_, w, _ in laps], dtype=np.int64)
        defined = np.array([lap.defined for lap in laps], dtype=bool)
        return Samples(x, value, slope, rate, index, defined)


def iterated(
    map_: SampledMap, order: int, window: tuple[float, float] = (-math.inf, math.inf)
) -> SampledMap:
    """P_order of a map for orbits that stay in a window.

    Where only the last point lies below the window the word is :data:`BELOW`, whatever happened: so
    the infinitely deep dips of a map cost nothing. Where an earlier point lies outside, the iterate
    is not followed and not defined.

    Raises
    ------
    ValueError
        If the order is no whole number of at least 1, or the window no two ascending numbers.
    """
    return _Iterated(map_, whole("order", order), interval("window", window))


@dataclass(frozen=True, slots=True)
class _Iterated:
    map: SampledMap
    order: int
    window: tuple[float, float]
    book: WordBook = field(default_factory=WordBook, init=False, repr=False, compare=False)

    @property
    def words(self) -> Sequence[str]:
        return self.book.texts

    def sweep(self, x: Floats, p: float) -> Samples:
        n, (low, high) = len(x), self.window
        value, slope, rate = x.astype(float), np.ones(n), np.zeros(n)
        laps, alive = np.full((n, self.order), -1), np.arange(n)
        for lap in range(self.order):
            here = self.map.sweep(value[alive], p)
            laps[alive, lap] = here.words
            slope[alive], rate[alive] = (
                here.slope * slope[alive],
                here.slope * rate[alive] + here.rate,
            )
            value[alive] = here.value
            stays = (low <= here.value) & (here.value <= high)
            followed = here.defined & (stays | (lap == self.order - 1))
            value[alive[~followed]] = np.nan
            alive = alive[followed]
        words, defined = self._numbers(laps, value), ~np.isnan(value)
        slope, rate = np.where(defined, slope, np.nan), np.where(defined, rate, np.nan)
        return Samples(x, value, slope, rate, words, defined)

    def _numbers(self, laps: Ints, value: Floats) -> Ints:
        """The words of orbits (n,), from those of their laps (n, order) and where they end (n,)."""
        below, book, texts = value < self.window[0], self.book, self.map.words
        numbers = np.empty(len(value), dtype=np.int64)
        for i, row in enumerate(laps.tolist()):
            if below[i]:
                numbers[i] = book.index(BELOW, BELOW.__str__)
            elif math.isnan(value[i]):
                last = [k for k in row if k >= 0][-1]
                lost = texts[last] if row[-1] >= 0 else BELOW
                numbers[i] = book.index((lost, last), lost.__str__)
            else:
                numbers[i] = book.index(tuple(row), partial(_joined_words, texts, row))
        return numbers


def _joined_words(words: Sequence[str], row: Sequence[int]) -> str:
    return SEPARATOR.join(words[k] for k in row)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A maximal interval of one word.

    Attributes
    ----------
    low, high
        First and last double that was found in it.
    samples
        What is known of the map there, in order of x.
    """

    word: str
    defined: bool
    samples: Samples

    @property
    def low(self) -> float:
        """First double that was found in it."""
        return float(self.samples.x[0])

    @property
    def high(self) -> float:
        """Last double that was found in it."""
        return float(self.samples.x[-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Partition:
    """The pieces of a map in a window, at one parameter.

    Attributes
    ----------
    pieces, edges
        From left to right; an edge between each two pieces that touch, as far as it was located.
    unresolved
        Intervals with more than two words that are narrower than the smallest width.
    evaluations
        How often the map was evaluated.
    """

    p: float
    window: tuple[float, float]
    pieces: tuple[Piece, ...]
    edges: tuple[Edge, ...]
    unresolved: tuple[tuple[float, float], ...]
    evaluations: int

    @property
    def unresolved_length(self) -> float:
        """Total length of the unresolved intervals."""
        return math.fsum(high - low for low, high in self.unresolved)


def partition(
    map_: SampledMap,
    p: float,
    window: tuple[float, float],
    resolution: Resolution | None = None,
    *,
    diagonal: bool = False,
) -> Partition:
    """Cut a window into pieces of constant word.

    Parameters
    ----------
    map_
        The map.
    p
        The parameter.
    window
        Interval of x; its ends must be points the map can be asked for.
    resolution
        How closely to look.
    diagonal
        Whether only what crosses the diagonal matters: then an edge with both sides above it, or
        both below, is found to the smallest width only.

    Raises
    ------
    ValueError
        If the window is no two finite, ascending numbers.
    """
    low, high = interval("window", window, finite=True)
    chosen = resolution if resolution is not None else Resolution()
    search = _Search(map_, p, chosen, diagonal)
    n = max(2, math.ceil((high - low) / chosen.spacing) + 1)
    samples = search.run(np.linspace(low, high, n))
    starts = np.flatnonzero(np.diff(samples.words) != 0) + 1
    runs = np.split(np.arange(len(samples.x)), starts)
    pieces = tuple(
        Piece(map_.words[samples.words[run[0]]], bool(samples.defined[run[0]]), samples.take(run))
        for run in runs
    )
    edges = tuple(search.edges(pieces))
    return Partition(
        p=p, window=(low, high), pieces=pieces, edges=edges,
        unresolved=tuple(search.unresolved), evaluations=search.evaluations,
    )  # fmt: skip


_Pair = tuple[Evaluation, Evaluation]


class _Search:
    """The refinement of one window."""

    def __init__(self, map_: SampledMap, p: float, resolution: Resolution, diagonal: bool) -> None:
        self.map, self.p, self.resolution, self.diagonal = map_, p, resolution, diagonal
        self.unresolved: list[tuple[float, float]] = []
        self.evaluations = 0

    def at(self, x: Floats) -> Samples:
        self.evaluations += len(x)
        return self.map.sweep(x, self.p)

    def run(self, grid: Floats) -> Samples:
        """All samples that were needed, sorted."""
        known = self.at(grid)
        left, right = known.take(slice(None, -1)), known.take(slice(1, None))
        while len(left.x):
            middle = self.at(0.5 * (left.x + right.x))
            differ = left.words != right.words
            width = right.x - left.x
            tiny = width <= 2.0 * NEAR * np.spacing(np.abs(left.x))
            third = (middle.words != left.words) & (middle.words != right.words)
            crowded = differ & third & (width < self.resolution.smallest) & ~tiny
            for a, b in zip(left.x[crowded], right.x[crowded], strict=True):
                self.unresolved.append((float(a), float(b)))
            bent = _bend(left, right, middle) > self.resolution.bend
            below = np.array([self.map.words[k] == BELOW for k in middle.words], dtype=bool)
            straight = ~differ & ~third & (~middle.defined | below | ~bent)
            apart = (middle.x > left.x) & (middle.x < right.x)
            keep = apart & ~crowded & ~(tiny & third)
            known = known.joined(middle.take(keep))
            go_on = keep & (differ | (~straight & (width > self.resolution.smallest)))
            a, m, b = left.take(go_on), middle.take(go_on), right.take(go_on)
            left = Samples._make([np.concatenate(pair) for pair in zip(a, m, strict=True)])
            right = Samples._make([np.concatenate(pair) for pair in zip(m, b, strict=True)])
            open_ = (left.words != right.words) & self._matters(left, right)
            open_ |= right.x - left.x > self.resolution.smallest
            open_ &= ~(self._is_far(left, right) | self._is_located(left, right))
            left, right = left.take(open_), right.take(open_)
        return known

    def _matters(self, left: Samples, right: Samples) -> Bools:
        """Whether a jump in an interval can cross the diagonal, or everything matters."""
        if not self.diagonal:
            return np.ones(len(left.x), dtype=bool)
        crosses: Bools = (left.value - left.x) * (right.value - right.x) <= 0.0
        return crosses

    def _is_far(self, left: Samples, right: Samples) -> Bools:
        """Whether an interval is narrow, and its pieces do not reach the diagonal in it."""
        width = right.x - left.x
        gaps = [side.value - side.x for side in (left, right)]
        with np.errstate(invalid="ignore"):
            clear = [
                np.abs(gap) > 4.0 * width * np.abs(side.slope - 1.0)
                for gap, side in zip(gaps, (left, right), strict=True)
            ]
        narrow: Bools = (width <= self.resolution.far) & (gaps[0] * gaps[1] > 0.0)
        return narrow & clear[0] & clear[1] & self.diagonal

    def _is_located(self, left: Samples, right: Samples) -> Bools:
        """Whether an interval is narrow enough for the continuous change of word in it."""
        narrow = right.x - left.x <= self.resolution.edge
        located: Bools = narrow & (np.abs(right.value - left.value) <= self.resolution.close)
        return located

    def edges(self, pieces: Sequence[Piece]) -> Iterator[Edge]:
        """Edges between the pieces, with limits read as in :mod:`woodpecker.piecewise.borders`."""
        pairs = list(pairwise(pieces))
        if self.diagonal:
            pairs = [pair for pair in pairs if self._matters(*_facing(*pair))[0]]
        if self.resolution.edge > 0.0:
            pairs = [pair for pair in pairs if not self._is_located(*_facing(*pair))[0]]
        if not pairs:
            return
        x = np.array([left.high for left, _ in pairs])
        beyond = np.array([right.low for _, right in pairs])
        found: list[Edge | None] = [None] * len(pairs)
        near, unsettled = NEAR * np.spacing(np.abs(x)), np.arange(len(pairs))
        for _ in range(1 + WIDENINGS):
            read = self._beside(x[unsettled], beyond[unsettled], near[unsettled])
            for k, (left, right) in zip(unsettled.tolist(), read, strict=True):
                settled = all(
                    each.word == piece.word
                    for side, piece in zip((left, right), pairs[k], strict=True)
                    for each in side
                )
                if settled or found[k] is None:
                    found[k] = Edge(
                        x=float(x[k]), p=self.p, left=left[0], right=right[0],
                        left_limit=limit_of(*left, -near[k]), right_limit=limit_of(*right, near[k]),
                    )  # fmt: skip
                near[k] = math.nan if settled else 4.0 * near[k]
            unsettled = unsettled[~np.isnan(near[unsettled])]
            if not len(unsettled):
                break
        yield from (edge for edge in found if edge is not None)

    def _beside(self, x: Floats, beyond: Floats, near: Floats) -> list[tuple[_Pair, _Pair]]:
        """The map left and right of edges, at a distance and at four times that."""
        read = [
            self._evaluations(start + side * scale * near)
            for start, side in ((x, -1.0), (beyond, 1.0))
            for scale in (1.0, 4.0)
        ]
        return [((a, b), (c, d)) for a, b, c, d in zip(*read, strict=True)]

    def _evaluations(self, x: Floats) -> list[Evaluation]:
        samples = self.at(x)
        columns = samples.value, samples.slope, samples.rate, samples.words, samples.defined
        return [
            Evaluation(value, slope, rate, self.map.words[word], defined)
            if defined
            else Evaluation(math.nan, math.nan, math.nan, self.map.words[word], False)
            for value, slope, rate, word, defined in zip(
                *(column.tolist() for column in columns), strict=True
            )
        ]


def _facing(left: Piece, right: Piece) -> tuple[Samples, Samples]:
    """The samples of two pieces that face each other."""
    return left.samples.take(slice(-1, None)), right.samples.take(slice(0, 1))


def _bend(left: Samples, right: Samples, middle: Samples) -> Floats:
    """Distance of the middles from the cubics through both ends."""
    width = right.x - left.x
    with np.errstate(invalid="ignore"):  # slopes next to a square root are infinite
        cubic = 0.5 * (left.value + right.value) + 0.125 * width * (left.slope - right.slope)
    bend: Floats = np.nan_to_num(np.abs(middle.value - cubic), nan=math.inf)
    return bend


# --- What lies on the diagonal --------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Slice:
    """All fixed points and jump crossings of a map in a window, at one parameter.

    Attributes
    ----------
    fixed_points
        Their x, ascending, and the words there.
    crossings
        Edges whose limits lie strictly on opposite sides of the diagonal.
    bands
        Intervals on which the map is the identity.
    """

    partition: Partition
    fixed_points: tuple[tuple[float, str], ...]
    crossings: tuple[Edge, ...]
    bands: tuple[tuple[float, float], ...]


def slice_of(
    map_: SampledMap,
    p: float,
    window: tuple[float, float],
    resolution: Resolution | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Slice:
    """Everything that lies on the diagonal at one parameter."""
    found = partition(map_, p, window, resolution, diagonal=True)
    bands: list[tuple[float, float]] = []
    fixed: list[tuple[float, str]] = []
    for piece in found.pieces:
        if not piece.defined or len(piece.samples.x) < 2:
            continue
        rests = _identical(piece.samples, tolerances)
        bands += [_widened(map_, p, piece, run, tolerances) for run in runs_of(rests)]
        fixed += [(x, piece.word) for x in _roots(map_, p, piece, rests)]
    crossing = [e for e in found.edges if _crosses(e, tolerances)]
    return Slice(
        partition=found, fixed_points=tuple(fixed), crossings=tuple(crossing), bands=_joined(bands)
    )


def _crosses(edge: Edge, tolerances: Tolerances) -> bool:
    """Whether both limits are off the diagonal by more than rounding, on opposite sides."""
    off = min(abs(edge.left_limit - edge.x), abs(edge.right_limit - edge.x))
    return edge.crosses and off > tolerances.residual and not is_continuous(edge, tolerances)


def _identical(samples: Samples, tolerances: Tolerances) -> Bools:
    """Where the map is the identity: (n,), at neighbouring samples."""
    rests = np.abs(samples.value - samples.x) <= tolerances.residual
    rests &= np.abs(samples.slope - 1.0) <= tolerances.jump
    lonely = rests.copy()
    lonely[1:] &= ~rests[:-1]
    lonely[:-1] &= ~rests[1:]
    identical: Bools = rests & ~lonely
    return identical


def _joined(bands: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Bands of neighbouring pieces as one."""
    joined: list[tuple[float, float]] = []
    for low, high in bands:
        if joined and low <= np.nextafter(joined[-1][1], math.inf):
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return tuple(joined)


def _widened(
    map_: SampledMap, p: float, piece: Piece, run: tuple[int, int], tolerances: Tolerances
) -> tuple[float, float]:
    """The interval of a run of samples on which the map is the identity, to the last bit."""
    x = piece.samples.x
    ends = []
    for inner, outer in ((run[0], run[0] - 1), (run[1], run[1] + 1)):
        inside = float(x[inner])
        outside = float(x[outer]) if 0 <= outer < len(x) else inside
        while (middle := 0.5 * (inside + outside)) not in (inside, outside):
            here = map_.sweep(np.array([middle]), p)
            if abs(float(here.value[0]) - middle) <= tolerances.residual:
                inside = middle
            else:
                outside = middle
        ends.append(inside)
    return ends[0], ends[1]


def _roots(map_: SampledMap, p: float, piece: Piece, rests: Bools) -> Iterator[float]:
    """Zeros of P(x) - x on a piece: sign changes, and pairs between which the sign is the same.

    Two zeros between neighbouring samples have an extremum between them, where the slope is 1.
    """
    x, g, rise = piece.samples.x, piece.samples.value - piece.samples.x, piece.samples.slope - 1.0

    def gap(at: float) -> float:
        return float(map_.sweep(np.array([at]), p).value[0]) - at

    def climb(at: float) -> float:
        return float(map_.sweep(np.array([at]), p).slope[0]) - 1.0

    yield from x[(g == 0.0) & ~rests].tolist()
    for i in range(len(x) - 1):
        a, b = float(x[i]), float(x[i + 1])
        if g[i] * g[i + 1] < 0.0:
            yield float(brentq(gap, a, b, xtol=1e-16, rtol=1e-15))
        elif g[i] * g[i + 1] > 0.0 and _may_touch(g, rise, b - a, i):
            turn = float(brentq(climb, a, b, xtol=1e-15, rtol=1e-14))
            if gap(turn) * g[i] < 0.0:
                yield float(brentq(gap, a, turn, xtol=1e-16, rtol=1e-15))
                yield float(brentq(gap, turn, b, xtol=1e-16, rtol=1e-15))


def _may_touch(g: Floats, rise: Floats, width: float, i: int) -> bool:
    """Whether an extremum between two samples may lie on the other side of zero."""
    turns = rise[i] * g[i] < 0.0 and rise[i] * rise[i + 1] < 0.0
    near = min(abs(g[i]), abs(g[i + 1])) <= max(abs(rise[i]), abs(rise[i + 1])) * width
    return bool(turns and near)
