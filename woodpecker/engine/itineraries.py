"""Cycles and jumps of P_j at one parameter, from the pieces of P_1.

P_j has a piece for each sequence of pieces of P_1 that an orbit can visit. Where P_1 is steep these
are too thin to be met by looking at P_j itself; but pulled back return by return through the
monotone branches of P_1 they are all there, and steepness helps: inverse branches contract.

What is found here is a guess, good to the interpolation between samples, with the pieces that its
orbit takes; Newton's method on these pieces follows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Bools, Floats, Ints
from woodpecker.engine.borders import Border
from woodpecker.engine.bracketing import bracketed
from woodpecker.engine.orbits import Closed, Coordinate, Orbit, solve
from woodpecker.engine.partition import Partition, Stretch
from woodpecker.engine.pieces import Image
from woodpecker.engine.settings import Settings

HALVINGS = 32  # of an interval of values in which a cycle lies
LOOSE = 0.02  # how far beyond a piece a cycle may seem to lie, as a part of it
INTERIOR = 16  # points inside an increasing piece at which a pair of fixed points is looked for
ZOOMS = 4  # and how often closer to the one nearest to the diagonal
PULLS = 3  # times that an orbit is pulled back exactly, if Newton's method fails from a guess


@dataclass(frozen=True, slots=True, eq=False)
class _Branches:
    """P_1 on the intervals where it is monotone: samples of each, in order of their values.

    ``first`` (n,) and ``last`` (n,) say where the samples of a branch begin and end in x, y and
    slope, all (m,), and in ``images``.
    """

    first: Ints
    last: Ints
    x: Floats
    y: Floats
    slope: Floats
    images: tuple[Image, ...]

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

    def below(self, k: Ints, y: Floats) -> Ints:
        """The last samples of branches k (n,) whose values are at most y (n,)."""
        low, high = self.first[k], self.last[k] - 1
        while (low < high).any():
            middle = (low + high + 1) // 2
            below = self.y[middle] <= y
            low, high = np.where(below, middle, low), np.where(below, high, middle - 1)
        return low

    def inverse(self, k: Ints, y: Floats) -> Floats:
        """Where branches k (n,) take values y (n,): cubics through samples, over y."""
        low = self.below(k, y)
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

    def image(self, k: int, y: float) -> Image:
        """The sample of a branch nearest below a value."""
        return self.images[int(self.below(np.array([k]), np.array([y]))[0])]

    def exact(self, k: int, y: float, p: float) -> tuple[float, Image] | None:
        """Where the branch itself takes a value."""
        i = int(self.below(np.array([k]), np.array([y]))[0])
        if not self.y[i] <= y <= self.y[i + 1]:
            i = i if y < self.y[i] else i + 1
            return float(self.x[i]), self.images[i]
        x, to = float(self.x[i]), float(self.x[i + 1])
        return bracketed(
            {x: self.images[i], to: self.images[i + 1]}, x, to, p,
            lambda image, _: (image.value - y, image.slope),
        )  # fmt: skip


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
    partition
        The pieces of P_1 in a window; orbits that leave the window are not followed.
    settings
        Tolerances.
    """

    def __init__(self, partition: Partition, settings: Settings) -> None:
        self.partition, self.p, self.settings = partition, partition.p, settings
        self.window = partition.window
        self.branches = _joined([b for each in partition.stretches for b in _monotone(each)])
        self._cylinders = [self._first()]

    def cycles(self, order: int) -> list[Orbit]:
        """Cycles of P_order, those of lower periods among them, one for each of their points."""
        if not len(self.branches):  # no orbit stays in the window
            return []
        guesses = [*self._sure(order), *self._perhaps(order)]
        found = (self._solved(branches, x) for branches, x in guesses)
        return [orbit for orbit in found if orbit is not None]

    def heads(self, borders: Sequence[Border], order: int) -> Iterator[tuple[Orbit, Border]]:
        """Orbits that lead to borders within ``order`` points, about, the border their last."""
        for border in borders:
            targets = np.array([border.x])
            points: list[tuple[tuple[float, ...], tuple[int, ...]]] = [((), ())]
            for before in range(order):
                for xs, branches in points:
                    images = [
                        self.branches.image(k, y)
                        for k, y in zip(branches, (*xs, border.x)[1:], strict=True)
                    ]
                    pieces = [image.piece for image in images]
                    x = np.array([*xs, border.x])
                    own = [piece.at(float(a), self.p) for piece, a in zip(pieces, x, strict=False)]
                    yield Orbit(x, self.p, (*own, border.inner)), border
                if before < order - 1:
                    targets, points = self._preimages(targets, points)

    def _preimages(
        self, targets: Floats, points: list[tuple[tuple[float, ...], tuple[int, ...]]]
    ) -> tuple[Floats, list[tuple[tuple[float, ...], tuple[int, ...]]]]:
        low, high = self.branches.low[:, None], self.branches.high[:, None]
        k, hit = np.nonzero((low < targets) & (targets < high))
        x = self.branches.inverse(k, targets[hit])
        found = zip(k.tolist(), hit.tolist(), x.tolist(), strict=True)
        return x, [((a, *points[i][0]), (b, *points[i][1])) for b, i, a in found]

    def _solved(self, branches: Ints, x: Floats) -> Orbit | None:
        """The cycle of some branches near a guess; None if it lies outside of their pieces."""
        conditions = Closed(), Coordinate(-1, self.p)
        orbit = self._orbit(branches, x)
        for _ in range(PULLS):
            solution = solve(orbit, conditions, self.settings)
            if solution.converged:
                return self._inside(solution.orbit)
            pulled = self._pulled(branches, orbit.x)
            if pulled is None:
                return None
            orbit = pulled
        return None

    def _inside(self, orbit: Orbit) -> Orbit | None:
        low, high = self.window
        if not (low <= orbit.x.min() and orbit.x.max() <= high):
            return None
        inside = all(not len(i.margins) or i.margins.min() >= 0.0 for i in orbit.images)
        return orbit if inside else None

    def _orbit(self, branches: Ints, x: Floats) -> Orbit:
        images = [
            self.branches.image(int(k), float(y)).piece.at(float(a), self.p)
            for k, a, y in zip(branches, x, np.roll(x, -1), strict=True)
        ]
        return Orbit(np.asarray(x), self.p, tuple(images))

    def _pulled(self, branches: Ints, x: Floats) -> Orbit | None:
        """An orbit whose points are pulled back one after the other, exactly."""
        points, images = x.copy(), [self.branches.images[0]] * len(x)
        for i in reversed(range(len(x))):
            found = self.branches.exact(int(branches[i]), float(points[(i + 1) % len(x)]), self.p)
            if found is None:
                return None
            points[i], images[i] = found
        return Orbit(points, self.p, tuple(images))

    # --- Guesses ----------------------------------------------------------------------------------

    def _sure(self, order: int) -> Iterator[tuple[Ints, Floats]]:
        """Where P_order changes its side of the diagonal."""
        found = self._of(order)
        rising = found.at_high > found.at_low
        crosses = (found.at_low > found.low) != (found.at_high > found.high)
        meets = np.maximum(found.low, found.at_low) <= np.minimum(found.high, found.at_high)
        yield from self._roots(found.take(crosses & ~rising))
        yield from self._roots(self._halves(found.take(meets & rising)))

    def _perhaps(self, order: int) -> Iterator[tuple[Ints, Floats]]:
        """Where more cycles may be: right beside a piece, whose ends are interpolated."""
        found = self._of(order)
        gaps = found.at_low - found.low, found.at_high - found.high
        width, nearer = found.high - found.low, np.abs(gaps[0]) < np.abs(gaps[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            off = width * np.where(nearer, gaps[0], gaps[1]) / np.abs(gaps[1] - gaps[0])
        near = (np.abs(off) <= LOOSE * width) & (width > 0.0) & (gaps[0] * gaps[1] > 0.0)
        y = np.where(nearer, found.at_low, found.at_high)
        yield from zip(found.branches[near], self._back(found.branches[near], y[near]), strict=True)

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
        """One return more in front: each branch followed by whatever its image meets."""
        b = self.branches
        k, hit = np.nonzero((later.low <= b.high[:, None]) & (later.high >= b.low[:, None]))
        bottom, top = np.maximum(later.low[hit], b.low[k]), np.minimum(later.high[hit], b.high[k])
        at_bottom = self._at(later, hit, bottom)
        at_top = self._at(later, hit, top)
        x_bottom = np.where(bottom == b.low[k], b.x[b.first[k]], b.inverse(k, bottom))
        x_top = np.where(top == b.high[k], b.x[b.last[k]], b.inverse(k, top))
        turned = x_bottom > x_top
        return _Cylinders(
            np.where(turned, x_top, x_bottom), np.where(turned, x_bottom, x_top),
            np.where(turned, at_top, at_bottom), np.where(turned, at_bottom, at_top),
            np.column_stack([k, later.branches[hit]]),
        )  # fmt: skip

    def _at(self, later: _Cylinders, hit: Ints, x: Floats) -> Floats:
        """Where the later returns take points x of cylinders ``hit``: by the samples of pieces."""
        at_low, at_high = later.at_low[hit], later.at_high[hit]
        inside = (later.low[hit] < x) & (x < later.high[hit])
        value = x.copy()
        for branch in later.branches[hit].T:
            value = self._forward(branch, value)
        ends = np.where(x <= later.low[hit], at_low, at_high)
        found: Floats = np.where(inside, value, ends)
        return found

    def _forward(self, k: Ints, x: Floats) -> Floats:
        """Values of branches k (n,) at x (n,): cubics through samples."""
        b = self.branches
        rising = b.x[b.last[k]] > b.x[b.first[k]]
        low, high = b.first[k], b.last[k] - 1
        while (low < high).any():
            middle = (low + high + 1) // 2
            below = np.where(rising, b.x[middle] <= x, b.x[middle] >= x)
            low, high = np.where(below, middle, low), np.where(below, high, middle - 1)
        x0, run = b.x[low], b.x[low + 1] - b.x[low]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.where(run != 0.0, np.clip((x - x0) / run, 0.0, 1.0), 0.0)
        found: Floats = (
            (1.0 + 2.0 * s) * (1.0 - s) ** 2 * b.y[low] + s * s * (3.0 - 2.0 * s) * b.y[low + 1]
            + s * (1.0 - s) * run * ((1.0 - s) * b.slope[low] - s * b.slope[low + 1])
        )  # fmt: skip
        return found

    def _back(self, branches: Ints, y: Floats) -> Floats:
        """Orbits (n, j) that visit branches (n, j) and end in y (n,)."""
        points = np.empty(branches.shape)
        for i in reversed(range(branches.shape[1])):
            y = points[:, i] = self.branches.inverse(branches[:, i], y)
        return points

    def _roots(self, found: _Cylinders) -> Iterator[tuple[Ints, Floats]]:
        """Cycles in cylinders at whose ends P_j lies on different sides of the diagonal."""
        a, b = found.at_low.copy(), found.at_high.copy()  # values between which the cycle lies
        below = found.low < found.at_low
        for _ in range(HALVINGS if len(a) else 0):
            middle = 0.5 * (a + b)
            same = (self._back(found.branches, middle)[:, 0] < middle) == below
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        points = self._back(found.branches, 0.5 * (a + b))
        gaps = found.at_low - found.low, found.at_high - found.high
        with np.errstate(divide="ignore", invalid="ignore"):
            x = found.low + gaps[0] / (gaps[0] - gaps[1]) * (found.high - found.low)
        ahead = [x]
        for branch in found.branches.T[:-1]:
            ahead.append(self._forward(branch, ahead[-1]))
        flat = np.abs(found.at_high - found.at_low) <= found.high - found.low
        for k, orbit in enumerate(np.where(flat[:, None], np.column_stack(ahead), points)):
            if np.isfinite(orbit).all():
                yield found.branches[k], orbit

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


def _monotone(stretch: Stretch) -> Iterator[tuple[Floats, Floats, Floats, tuple[Image, ...]]]:
    """Parts of a stretch between turning points: x, ascending values, slopes, images."""
    if len(stretch.x) < 2:
        return
    x = np.array(stretch.x)
    y = np.array([image.value for image in stretch.images])
    slope = np.array([image.slope for image in stretch.images])
    turns = np.flatnonzero(np.diff(y)[1:] * np.diff(y)[:-1] < 0.0) + 1
    for first, last in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        part = slice(first, last + 1)
        way = 1 if y[last] >= y[first] else -1
        yield x[part][::way], y[part][::way], slope[part][::way], stretch.images[part][::way]


def _joined(parts: list[tuple[Floats, Floats, Floats, tuple[Image, ...]]]) -> _Branches:
    """Monotone parts, one after the other."""
    counts = np.array([len(part[0]) for part in parts], dtype=np.int64)
    last = np.cumsum(counts) - 1
    x, y, slope = (np.concatenate([np.empty(0), *(part[c] for part in parts)]) for c in range(3))
    images = tuple(image for part in parts for image in part[3])
    return _Branches(last - counts + 1, last, x, y, slope, images)
