"""Cycles and jumps of P_j at one parameter, from the monotone branches of P_1.

P_j has a piece for each itinerary, the sequence of pieces of P_1 that an orbit visits. Where P_1 is
steep these pieces are too thin to be found by sampling P_j. They are pulled back instead, return by
return, through the monotone branches of P_1, whose inverses contract where P_1 is steep.

The result is guesses that are as good as the interpolation between samples, and the pieces of their
orbits. Newton's method on these pieces makes them exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Bools, Floats, Ints
from woodpecker.base.settings import Settings
from woodpecker.maps.counting import Allowance
from woodpecker.maps.pieces import Image
from woodpecker.slices.borders import Border
from woodpecker.slices.monotone import branches_of
from woodpecker.slices.orbits import Orbit, at_parameter, is_inside
from woodpecker.slices.partition import RISE_TOLERANCE, Partition

OF_ITERATE = 10  # most pieces of an iterate, for each piece that P_1 may have (``max_pieces``)
PAIRS = 10**8  # most pairs of pieces compared at once, with one byte each
# Times that an orbit is pulled back point by point if Newton's method fails: each time divides its
# error by the product of its slopes.
MOST_PULL_BACKS = 3
# Fraction of its length by which a piece of an iterate may miss the diagonal and still be tried, as
# its ends are interpolated.
NEAR_MISS = 0.02
# Bisections of the interval of a cycle before Newton's method: to 6e-8 of it, finer than the errors
# of cubics.
BISECTIONS = 24
# Samples of an increasing piece of an iterate, on which two cycles may lie between its ends, and
# the number of grids, each about the sample nearest to the diagonal: as fine as one of thousands.
INTERIOR, ZOOMS = 16, 4
# Doublings, towards the end of an increasing piece, of the distance at which P_n(x) - x is tried
# for the change of sign that brackets another cycle.
OUTWARD = 16


class Guess(NamedTuple):
    """A guess of a cycle: its branches (n,) and points (n,).

    On an increasing piece of P_n, over the interval ``ends`` of the first point, ``rises`` tells
    that P_n crosses the diagonal upwards here, which needs a multiplier above 1.
    """

    branches: Ints
    x: Floats
    ends: tuple[float, float] | None = None
    rises: bool = False


Points = list[tuple[tuple[float, ...], tuple[int, ...]]]
"""For each orbit that leads to a border: its points before the border, and their branches."""

Wanted = Callable[[Border, int, float], bool]
"""Whether a border orbit is wanted, by its border, its number of points and roughly its first."""


@dataclass(frozen=True, slots=True, eq=False)
class _Cylinders:
    """Intervals (n,) of x_0 whose orbits visit branches (n, j), and the values of P_j at ends."""

    low: Floats
    high: Floats
    at_low: Floats
    at_high: Floats
    branches: Ints

    def take(self, chosen: Bools) -> _Cylinders:
        """Those that a mask (n,) selects."""
        return _Cylinders(
            self.low[chosen], self.high[chosen], self.at_low[chosen], self.at_high[chosen],
            self.branches[chosen],
        )  # fmt: skip


def _cylinders(x: Floats, at: Floats, branches: Ints) -> _Cylinders:
    """Cylinders from the ends x (2, n) of their intervals, in any order, and the values there."""
    turned = x[0] > x[1]
    (low, high), (at_low, at_high) = (np.where(turned, ends[::-1], ends) for ends in (x, at))
    return _Cylinders(low, high, at_low, at_high, branches)


def _by_cycle(guesses: list[Guess]) -> Iterator[list[list[Guess]]]:
    """For each cyclic sequence of branches its guesses, grouped by rotation, the largest first."""
    circles: dict[tuple[int, ...], dict[tuple[int, ...], list[Guess]]] = {}
    for guess in guesses:
        key = tuple(guess.branches.tolist())
        circle = min(key[k:] + key[:k] for k in range(len(key)))
        circles.setdefault(circle, {}).setdefault(key, []).append(guess)
    for each in circles.values():
        yield sorted(each.values(), key=len, reverse=True)


class Itineraries:
    """Orbits of P_1 at one parameter in the window of a partition; ``left`` if some are omitted."""

    def __init__(self, partition: Partition, settings: Settings, allowed: Allowance) -> None:
        self.partition, self.p, self.settings = partition, partition.p, settings
        self.window, self._allowed, self.left = partition.window, allowed, False
        self._most = OF_ITERATE * settings.max_pieces
        self.branches = branches_of(partition, settings)
        self._cylinders = [self._first()]

    def cycles(self, order: int) -> list[Orbit]:
        """Cycles of P_order, with those of lower periods; some are listed from several points."""
        if not len(self.branches):  # no orbit stays in the window
            return []
        found = list[Orbit]()
        for guesses in _by_cycle([*self._sure(order), *self._perhaps(order)]):
            for same in guesses:  # each cycle is guessed from each of its points: one is enough
                orbits = self._different(same)
                found += orbits
                if len(orbits) >= len(same):
                    break
        return found

    def _different(self, guesses: list[Guess]) -> list[Orbit]:
        """The cycles to which Newton's method leads from guesses, each once."""
        found, same = list[Orbit](), self.settings.same * self.settings.x_scale
        todo = guesses[::-1]
        while todo:  # a guess with ``ends`` adds two guesses at most, which have none
            if self._allowed.spent:
                self.left = True
                break
            guess = todo.pop()
            orbit = self._solved(guess.branches, guess.x)
            if orbit is None and guess.ends is not None:
                todo += self._beside(guess, None)
            if orbit is not None and all(np.abs(orbit.x - e.x).max() > same for e in found):
                found.append(orbit)
                if guess.ends is not None and (orbit.multiplier > 1.0) is not guess.rises:
                    todo += self._beside(guess, orbit)
        return found

    def _beside(self, guess: Guess, orbit: Orbit | None) -> Iterator[Guess]:
        """Guesses on both sides of one that failed, or of a cycle that crosses the other way."""
        # Just beyond a flip of P_(n/2) three cycles of P_n lie too close together for samples to
        # tell them apart. Newton's method has led to another one of them, so P_n(x) - x is divided
        # by the distance of x from this one: the quotient, multiplier - 1 at the cycle itself,
        # changes its sign at the others only. Without a cycle P_n(x) - x itself is bracketed.
        if orbit is None:
            xs, pieces = guess.x.tolist(), guess.branches.tolist()
            images: Sequence[Image] = self._images(pieces, xs, np.roll(guess.x, -1).tolist())
        else:
            xs, images = orbit.x.tolist(), orbit.images
        start = xs[0]

        def points(x: float) -> list[float]:
            found = [x]
            for image in images:
                found.append(float(image.piece.at(found[-1], self.p).value))
            return found

        def left(x: float) -> float:
            if orbit is None:
                return points(x)[-1] - x
            return orbit.multiplier - 1.0 if x == start else (points(x)[-1] - x) / (x - start)

        here = left(start)
        for end in guess.ends or ():
            away = ((end - start) * 0.5**k for k in reversed(range(OUTWARD)))
            past = next((to for by in away if left(to := start + by) * here < 0.0), None)
            if past is not None:
                with suppress(ValueError):  # a piece has no value on the way
                    x = float(brentq(left, start, past, xtol=math.ulp(max(abs(start), abs(past)))))
                    yield Guess(guess.branches, np.array(points(x)[:-1]))

    def heads(
        self, borders: Sequence[Border], order: int, wanted: Wanted
    ) -> Iterator[tuple[Orbit, Border]]:
        """Guesses of border orbits of at most ``order`` points, with the borders they end on."""
        for border in borders:
            targets = np.array([border.x])
            points: Points = [((), ())]
            for before in range(order):
                if len(targets) > self._most:
                    self.left = True
                    break
                for xs, branches in points:
                    if wanted(border, before + 1, (*xs, border.x)[0]):
                        if self._allowed.spent:
                            self.left = True
                            return
                        yield self._head(xs, branches, border), border
                if before < order - 1:
                    targets, points = self._preimages(targets, points)

    def _head(self, xs: tuple[float, ...], branches: tuple[int, ...], border: Border) -> Orbit:
        """The border orbit of points ``xs`` on ``branches`` and the border to which they lead."""
        points = [*xs, border.x]
        images = self._images(branches, points[:-1], points[1:])
        return Orbit(np.array(points), self.p, (*images, border.inner))

    def _preimages(self, targets: Floats, points: Points) -> tuple[Floats, Points]:
        low, high = self.branches.low[:, None], self.branches.high[:, None]
        k, hit = np.nonzero((low < targets) & (targets < high))
        x = self.branches.inverse(k, targets[hit])
        found = zip(k.tolist(), hit.tolist(), x.tolist(), strict=True)
        return x, [((a, *points[i][0]), (b, *points[i][1])) for b, i, a in found]

    def _solved(self, branches: Ints, x: Floats) -> Orbit | None:
        """The cycle on given branches near a guess; None if none, or outside of their pieces."""
        images = self._images(branches.tolist(), x.tolist(), np.roll(x, -1).tolist())
        orbit = Orbit(np.asarray(x), self.p, tuple(images))
        for _ in range(MOST_PULL_BACKS):
            found = at_parameter(orbit, self.settings)
            if found is not None and self._is_inside(found):
                return found
            pulled = self._pulled(branches, orbit.x)
            if pulled is None:
                return None
            orbit = pulled
        return None

    def _is_inside(self, orbit: Orbit) -> bool:
        low, high = self.window
        return bool(low <= orbit.x.min() and orbit.x.max() <= high) and is_inside(orbit)

    def _images(
        self, branches: Sequence[int], xs: Sequence[float], ys: Sequence[float]
    ) -> list[Image]:
        """Images of points xs under the pieces of branches, continued from the samples near ys."""
        return [
            self.branches.image(k, y).piece.at(x, self.p)
            for k, x, y in zip(branches, xs, ys, strict=True)
        ]

    def _pulled(self, branches: Ints, x: Floats) -> Orbit | None:
        """The orbit with each point, from the last on, pulled back by its piece; None if lost."""
        points, images = x.copy(), [self.branches.images[0]] * len(x)
        for i in reversed(range(len(x))):
            found = self.branches.exact(int(branches[i]), float(points[(i + 1) % len(x)]), self.p)
            if found is None:
                return None
            points[i], images[i] = found
        return Orbit(points, self.p, tuple(images))

    # --- Guesses ----------------------------------------------------------------------------------

    def _sure(self, order: int) -> Iterator[Guess]:
        """Guesses in all cylinders on which P_order crosses the diagonal."""
        found = self._of(order)
        rising = found.at_high > found.at_low
        crosses = (found.at_low > found.low) != (found.at_high > found.high)
        meets = np.maximum(found.low, found.at_low) <= np.minimum(found.high, found.at_high)
        yield from self._roots(found.take(crosses & ~rising))
        whole = found.take(meets & rising)
        parts, rows, beside = self._halves(whole)
        for k, guess in self._roots_by_part(parts):
            ends = float(whole.low[rows[k]]), float(whole.high[rows[k]])
            yield guess._replace(ends=ends, rises=bool(parts.low[k] > parts.at_low[k]))
        yield from beside

    def _perhaps(self, order: int) -> Iterator[Guess]:
        """Guesses at the ends of cylinders that miss the diagonal by no more than interpolation."""
        found = self._of(order)
        gaps = found.at_low - found.low, found.at_high - found.high
        width, nearer = found.high - found.low, np.abs(gaps[0]) < np.abs(gaps[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            off = width * np.where(nearer, gaps[0], gaps[1]) / np.abs(gaps[1] - gaps[0])
        near = (np.abs(off) <= NEAR_MISS * width) & (width > 0.0) & (gaps[0] * gaps[1] > 0.0)
        y = np.where(nearer, found.at_low, found.at_high)
        yield from map(Guess, found.branches[near], self._back(found.branches[near], y[near]))

    def _first(self) -> _Cylinders:
        b, ends = self.branches, np.array([self.branches.first, self.branches.last])
        return _cylinders(b.x[ends], b.y[ends], np.arange(len(b))[:, None])

    def _of(self, order: int) -> _Cylinders:
        while len(self._cylinders) < order:
            self._cylinders.append(self._fewer(self._pulled_back(self._cylinders[-1])))
        return self._cylinders[order - 1]

    def _pulled_back(self, later: _Cylinders) -> _Cylinders:
        """Cylinders of one return more: each branch, followed by all cylinders its image meets."""
        b, later = self.branches, self._fewer(later)
        k, hit = np.nonzero((later.low <= b.high[:, None]) & (later.high >= b.low[:, None]))
        bottom, top = np.maximum(later.low[hit], b.low[k]), np.minimum(later.high[hit], b.high[k])
        x_bottom = np.where(bottom == b.low[k], b.x[b.first[k]], b.inverse(k, bottom))
        x_top = np.where(top == b.high[k], b.x[b.last[k]], b.inverse(k, top))
        at = np.array([self._at(later, hit, end) for end in (bottom, top)])
        branches = np.column_stack([k, later.branches[hit]])
        return _cylinders(np.array([x_bottom, x_top]), at, branches)

    def _fewer(self, found: _Cylinders) -> _Cylinders:
        """All cylinders, or only the widest if there are too many."""
        most = min(self._most, PAIRS // max(1, len(self.branches)))
        if len(found.low) <= most:
            return found
        self.left = True
        kept = np.zeros(len(found.low), dtype=bool)
        kept[np.argsort(found.low - found.high, kind="stable")[:most]] = True
        return found.take(kept)

    def _at(self, later: _Cylinders, hit: Ints, x: Floats) -> Floats:
        """Interpolated values at points x of cylinders ``hit`` after all of their returns."""
        at_low, at_high = later.at_low[hit], later.at_high[hit]
        inside = (later.low[hit] < x) & (x < later.high[hit])
        value = x.copy()
        for branch in later.branches[hit].T:
            value = self.branches.forward(branch, value)
        ends = np.where(x <= later.low[hit], at_low, at_high)
        found: Floats = np.where(inside, value, ends)
        return found

    def _back(self, branches: Ints, y: Floats) -> Floats:
        """Orbits (n, j) that visit branches (n, j) and end in y (n,)."""
        points = np.empty(branches.shape)
        for i in reversed(range(branches.shape[1])):
            y = points[:, i] = self.branches.inverse(branches[:, i], y)
        return points

    def _roots(self, found: _Cylinders) -> Iterator[Guess]:
        """Guesses in cylinders at whose two ends P_j lies on different sides of the diagonal."""
        return (guess for _, guess in self._roots_by_part(found))

    def _roots_by_part(self, found: _Cylinders) -> Iterator[tuple[int, Guess]]:
        """As :meth:`_roots`, each guess with the number of its cylinder."""
        # Bisection in the value y, from which inverse branches lead to x: they contract where P_j
        # is steep. Where P_j is flat, a secant in x and the branches forward are better.
        a, b = found.at_low.copy(), found.at_high.copy()
        below = found.low < found.at_low
        for _ in range(BISECTIONS if len(a) else 0):
            middle = 0.5 * (a + b)
            same = (self._back(found.branches, middle)[:, 0] < middle) == below
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        points = self._back(found.branches, 0.5 * (a + b))
        gaps = found.at_low - found.low, found.at_high - found.high
        with np.errstate(divide="ignore", invalid="ignore"):
            x = found.low + gaps[0] / (gaps[0] - gaps[1]) * (found.high - found.low)
        ahead = [x]
        for branch in found.branches.T[:-1]:
            ahead.append(self.branches.forward(branch, ahead[-1]))
        flat = np.abs(found.at_high - found.at_low) <= found.high - found.low
        for k, orbit in enumerate(np.where(flat[:, None], np.column_stack(ahead), points)):
            if np.isfinite(orbit).all():
                yield k, Guess(found.branches[k], orbit)

    def _halves(self, found: _Cylinders) -> tuple[_Cylinders, Ints, list[Guess]]:
        """Parts of increasing cylinders where P_j crosses the diagonal, their rows, and guesses."""
        # Grids are refined about the samples nearest to the diagonal, in search of a crossing. If a
        # sample comes within the error of interpolation without crossing, two cycles may lie beside
        # it: its neighbours on the first grid are the guesses.
        rows, parts = np.arange(len(found.low)), []
        low = np.maximum(found.low, found.at_low)  # fixed points can only lie in between
        high = np.minimum(found.high, found.at_high)
        around = np.full((len(rows), 2), np.nan)  # neighbours of a nearest sample on its first grid
        off = np.full(len(rows), np.inf)
        for _ in range(ZOOMS if len(rows) else 0):
            y = low[:, None] + np.linspace(0.0, 1.0, INTERIOR) * (high - low)[:, None]
            many = np.repeat(found.branches[rows], INTERIOR, axis=0)
            x = self._back(many, y.ravel())[:, 0].reshape(y.shape)
            row, k = np.nonzero((x[:, :-1] < y[:, :-1]) != (x[:, 1:] < y[:, 1:]))
            parts.append((x[row, k], x[row, k + 1], y[row, k], y[row, k + 1], rows[row]))
            row, k = _nearest(x - y)
            off, rows = np.abs(x - y)[row, k], rows[row]
            low, high = y[row, np.maximum(k - 1, 0)], y[row, np.minimum(k + 1, INTERIOR - 1)]
            seen = around[row]
            around = np.where(np.isnan(seen), np.column_stack([low, high]), seen)
            if not len(rows):
                break
        if not parts:
            return found, rows, []
        near = off <= RISE_TOLERANCE * self.settings.x_scale
        both = rows[near].repeat(2)
        points = self._back(found.branches[both], around[near].ravel())
        beside = list(map(Guess, found.branches[both], points))
        x0, x1, y0, y1, chosen = (np.concatenate(column) for column in zip(*parts, strict=True))
        return _Cylinders(x0, x1, y0, y1, found.branches[chosen]), chosen, beside


def _nearest(off: Floats) -> tuple[Ints, Ints]:
    """Rows and columns of local minima of abs(off) beside which ``off`` keeps its sign."""
    size, below = np.abs(off), off < 0.0
    alike, falls = below[:, 1:] == below[:, :-1], size[:, 1:] < size[:, :-1]
    ends = np.ones((len(off), 1), dtype=bool)
    found = np.hstack([ends, alike & falls]) & np.hstack([alike & ~falls, ends])
    rows, columns = np.nonzero(found)
    return rows, columns
