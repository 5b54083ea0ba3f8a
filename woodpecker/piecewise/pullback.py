"""Cycles and jumps of P_j at one parameter, from the pieces of P_1.

P_j has a piece for each sequence of pieces of P_1 that an orbit can visit. Where P_1 is steep these
are too thin to be met by looking at P_j itself; but pulled back lap by lap through the monotone
branches of P_1 they are all there, and steepness helps: inverse branches contract.

What is found here is a guess, good to the interpolation between samples; Newton's method on the map
itself follows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, Ints
from woodpecker.piecewise.borders import Edge, is_continuous
from woodpecker.piecewise.maps import BELOW
from woodpecker.piecewise.partition import Bools, Partition, Piece, SampledMap

HALVINGS = 32  # of an interval of values in which a cycle lies
LOOSE = 0.02  # how far beyond a piece a cycle may seem to lie, as a part of it
INTERIOR = 16  # points inside an increasing piece at which a pair of fixed points is looked for
ZOOMS = 4  # and how often closer to the one nearest to the diagonal


class Backward(NamedTuple):
    """An orbit that leads to a jump of P_1, about."""

    points: tuple[float, ...]  # those before the edge
    edge: Edge


@dataclass(frozen=True, slots=True, eq=False)
class _Branches:
    """P_1 on the intervals where it is monotone: samples of each, in order of their values.

    ``first`` (n,) and ``last`` (n,) say where the samples of a branch begin and end in x, y and
    slope, all (m,).
    """

    first: Ints
    last: Ints
    x: Floats
    y: Floats
    slope: Floats

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

    def inverse(self, k: Ints, y: Floats) -> Floats:
        """Where branches k (n,) take values y (n,): cubics through samples, over y."""
        low, high = self.first[k], self.last[k] - 1  # of the samples at or below y
        while (low < high).any():
            middle = (low + high + 1) // 2
            below = self.y[middle] <= y
            low, high = np.where(below, middle, low), np.where(below, high, middle - 1)
        y0, y1, x0, x1 = self.y[low], self.y[low + 1], self.x[low], self.x[low + 1]
        run = y1 - y0
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.clip((y - y0) / run, 0.0, 1.0)
            straight = x0 + s * (x1 - x0)
            bent = (
                (1.0 + 2.0 * s) * (1.0 - s) ** 2 * x0 + s * s * (3.0 - 2.0 * s) * x1
                + s * (1.0 - s) * run
                * ((1.0 - s) / self.slope[low] - s / self.slope[low + 1])
            )  # fmt: skip
        inside = (np.minimum(x0, x1) <= bent) & (bent <= np.maximum(x0, x1))
        found: Floats = np.where(inside, bent, np.where(run > 0.0, straight, 0.5 * (x0 + x1)))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class _Cylinders:
    """Intervals of x_0 whose orbits visit given branches, and where P_j takes their ends.

    ``branches`` is (n, j); the other arrays are (n,).
    """

    low: Floats
    high: Floats
    at_low: Floats
    at_high: Floats
    branches: Ints

    def take(self, chosen: Bools) -> _Cylinders:
        """Some of them."""
        return _Cylinders(
            self.low[chosen], self.high[chosen], self.at_low[chosen], self.at_high[chosen],
            self.branches[chosen],
        )  # fmt: skip


class Itineraries:
    """Orbits of P_1 at one parameter.

    Parameters
    ----------
    map_
        P_1, for many points at once.
    partition
        Its pieces in a window; orbits that leave the window are not followed.
    """

    def __init__(self, map_: SampledMap, partition: Partition) -> None:
        self.map, self.p, self.window = map_, partition.p, partition.window
        self.evaluations = 0
        self.branches = _joined([b for piece in partition.pieces for b in _monotone(piece)])
        self.jumps = [e for e in partition.edges if not is_continuous(e) and _seen(e)]
        self._cylinders = [self._first()]

    def cycles(self, order: int) -> list[Floats]:
        """Cycles of P_order, those of lower periods among them, one for each of their points."""
        if not len(self.branches):  # no orbit stays in the window
            return []
        found = self._of(order)
        rising = found.at_high > found.at_low
        crosses = (found.at_low > found.low) != (found.at_high > found.high)
        meets = np.maximum(found.low, found.at_low) <= np.minimum(found.high, found.at_high)
        one = self._roots(found.take(crosses & ~rising))
        return [*one, *self._roots(self._halves(found.take(meets & rising)))]

    def perhaps(self, order: int) -> list[Floats]:
        """Where more cycles may be: right beside a piece, whose ends are not known exactly."""
        if not len(self.branches):
            return []
        found = self._of(order)
        gaps = found.at_low - found.low, found.at_high - found.high
        width, nearer = found.high - found.low, np.abs(gaps[0]) < np.abs(gaps[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            off = width * np.where(nearer, gaps[0], gaps[1]) / np.abs(gaps[1] - gaps[0])
        near = (np.abs(off) <= LOOSE * width) & (width > 0.0) & (gaps[0] * gaps[1] > 0.0)
        y = np.where(nearer, found.at_low, found.at_high)
        return list(self._back(found.branches[near], y[near]))

    def jumps_of(self, order: int) -> list[Backward]:
        """Orbits to jumps of P_1 where the limits of P_order lie on both sides of the diagonal."""
        found: list[Backward] = []
        for edge in self.jumps:
            left, right = (
                self._forward(np.array([limit]), order - 1)
                for limit in (edge.left_limit, edge.right_limit)
            )
            points: list[tuple[float, ...]] = [()]
            starts = np.array([edge.x])
            for before in range(order):
                one, other = float(left[order - 1 - before][0]), float(right[order - 1 - before][0])
                crosses = (one - starts) * (other - starts) < 0.0
                found += [Backward(points[k], edge) for k in np.flatnonzero(crosses)]
                if before < order - 1:
                    starts, points = self._preimages(starts, points)
        return found

    def _first(self) -> _Cylinders:
        ends = np.column_stack([self.branches.first, self.branches.last])
        turned = self.branches.x[ends[:, 0]] > self.branches.x[ends[:, 1]]
        ends[turned] = ends[turned, ::-1]
        (low, high), (at_low, at_high) = self.branches.x[ends].T, self.branches.y[ends].T
        return _Cylinders(low, high, at_low, at_high, np.arange(len(ends))[:, None])

    def _of(self, order: int) -> _Cylinders:
        while len(self._cylinders) < order:
            self._cylinders.append(self._pulled_back(self._cylinders[-1]))
        return self._cylinders[order - 1]

    def _pulled_back(self, later: _Cylinders) -> _Cylinders:
        """One lap more in front: each branch followed by whatever its image meets."""
        laps, b = later.branches.shape[1], self.branches
        ends = self._forward(np.concatenate([b.low, b.high]), laps)[laps].reshape(2, -1)
        k, hit = np.nonzero((later.low <= b.high[:, None]) & (later.high >= b.low[:, None]))
        bottom, top = np.maximum(later.low[hit], b.low[k]), np.minimum(later.high[hit], b.high[k])
        at_bottom = np.where(later.low[hit] >= b.low[k], later.at_low[hit], ends[0, k])
        at_top = np.where(later.high[hit] <= b.high[k], later.at_high[hit], ends[1, k])
        x_bottom = np.where(bottom == b.low[k], b.x[b.first[k]], b.inverse(k, bottom))
        x_top = np.where(top == b.high[k], b.x[b.last[k]], b.inverse(k, top))
        turned = x_bottom > x_top
        return _Cylinders(
            np.where(turned, x_top, x_bottom), np.where(turned, x_bottom, x_top),
            np.where(turned, at_top, at_bottom), np.where(turned, at_bottom, at_top),
            np.column_stack([k, later.branches[hit]]),
        )  # fmt: skip

    def _forward(self, x: Floats, laps: int) -> list[Floats]:
        """X and its images, nan from where an orbit leaves the window."""
        points = [x]
        for _ in range(laps):
            inside = (self.window[0] <= points[-1]) & (points[-1] <= self.window[1])
            images = np.full(len(x), math.nan)
            if inside.any():
                images[inside] = self.map.sweep(points[-1][inside], self.p).value
                self.evaluations += int(inside.sum())
            points.append(images)
        return points

    def _preimages(
        self, targets: Floats, points: list[tuple[float, ...]]
    ) -> tuple[Floats, list[tuple[float, ...]]]:
        low, high = self.branches.low[:, None], self.branches.high[:, None]
        k, hit = np.nonzero((low < targets) & (targets < high))
        x = self.branches.inverse(k, targets[hit])
        return x, [(a, *points[i]) for a, i in zip(x.tolist(), hit.tolist(), strict=True)]

    def _back(self, branches: Ints, y: Floats) -> Floats:
        """Orbits (n, j) that visit branches (n, j) and end in y (n,)."""
        points = np.empty(branches.shape)
        for lap in reversed(range(branches.shape[1])):
            y = points[:, lap] = self.branches.inverse(branches[:, lap], y)
        return points

    def _roots(self, found: _Cylinders) -> Iterator[Floats]:
        """Cycles in cylinders at whose ends P_j lies on different sides of the diagonal."""
        a, b = found.at_low.copy(), found.at_high.copy()  # values between which the cycle lies
        below = found.low < found.at_low
        for _ in range(HALVINGS if len(a) else 0):
            middle = 0.5 * (a + b)
            same = (self._back(found.branches, middle)[:, 0] < middle) == below
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        points = self._back(found.branches, 0.5 * (a + b))
        gaps = found.at_low - found.low, found.at_high - found.high
        secant = found.low + gaps[0] / (gaps[0] - gaps[1]) * (found.high - found.low)
        ahead = np.column_stack(self._forward(secant, found.branches.shape[1] - 1))
        flat = np.abs(found.at_high - found.at_low) <= found.high - found.low
        for orbit in np.where(flat[:, None], ahead, points):
            if np.isfinite(orbit).all():
                yield orbit

    def _halves(self, found: _Cylinders) -> _Cylinders:
        """Parts of increasing cylinders between which P_j changes its side of the diagonal.

        Where none shows, the neighbourhood of the point nearest to the diagonal is looked at.
        """
        low = np.maximum(found.low, found.at_low)  # a fixed point can only be in between
        high = np.minimum(found.high, found.at_high)
        rows, parts = np.arange(len(low)), []
        for _ in range(ZOOMS if len(low) else 0):
            y = low[:, None] + np.linspace(0.0, 1.0, INTERIOR) * (high - low)[:, None]
            many = np.repeat(found.branches[rows], INTERIOR, axis=0)
            x = self._back(many, y.ravel())[:, 0].reshape(y.shape)
            row, k = np.nonzero((x[:, :-1] < y[:, :-1]) != (x[:, 1:] < y[:, 1:]))
            parts.append((x[row, k], x[row, k + 1], y[row, k], y[row, k + 1], rows[row]))
            open_ = np.setdiff1d(np.arange(len(rows)), row)
            nearest = np.abs(x - y)[open_].argmin(axis=1)
            low = y[open_, np.maximum(nearest - 1, 0)]
            high = y[open_, np.minimum(nearest + 1, INTERIOR - 1)]
            rows = rows[open_]
            if not len(rows):
                break
        if not parts:
            return found
        x0, x1, y0, y1, chosen = (np.concatenate(column) for column in zip(*parts, strict=True))
        return _Cylinders(x0, x1, y0, y1, found.branches[chosen])


def _seen(edge: Edge) -> bool:
    """Whether the map has a value on both sides."""
    return not math.isnan(edge.jump)


def _monotone(piece: Piece) -> Iterator[tuple[Floats, Floats, Floats]]:
    """The parts of a piece between its turning points: x, values in ascending order, slopes."""
    samples = piece.samples
    if not piece.defined or piece.word == BELOW or len(samples.x) < 2:
        return
    x, y, slope = samples.x, samples.value, samples.slope
    turns = np.flatnonzero(np.diff(y)[1:] * np.diff(y)[:-1] < 0.0) + 1
    for first, last in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        part = slice(first, last + 1)
        way = 1 if y[last] >= y[first] else -1
        yield x[part][::way], y[part][::way], slope[part][::way]


def _joined(parts: list[tuple[Floats, Floats, Floats]]) -> _Branches:
    """Monotone parts, one after the other."""
    counts = np.array([len(x) for x, _, _ in parts], dtype=np.int64)
    last = np.cumsum(counts) - 1
    columns = [np.concatenate([np.empty(0), *column]) for column in zip(*parts, strict=True)]
    x, y, slope = columns or [np.empty(0)] * 3
    return _Branches(last - counts + 1, last, x, y, slope)
