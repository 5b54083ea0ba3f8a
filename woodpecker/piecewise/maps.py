"""Labelled maps, and cycles of them solved by multiple shooting.

A labelled map takes (x, p) to a value, its derivatives, and a word that names the smooth piece it
used. Nothing here knows the toy: :mod:`woodpecker.piecewise.stepping` continues the cycles of any
such map.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from woodpecker.base.arrays import Floats
from woodpecker.base.checks import interval, whole
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances

NEWTON_STEPS = 25  # quadratic convergence takes 4 to 6; more is needed on curved flanks only
SEPARATOR = " | "
SAME_CYCLE = 1e-9  # points of a cycle closer than this are one: its minimal period is shorter


class Evaluation(NamedTuple):
    """A labelled map at one point."""

    value: float
    slope: float  # d value / dx
    rate: float  # d value / dp
    word: str
    defined: bool = True  # False if the map has no value here; the word then says why


LabelledMap = Callable[[float, float], Evaluation]


class Cycle(NamedTuple):
    """A cycle x_0 -> x_1 -> ... -> x_0 of a labelled map at parameter p."""

    x: Floats  # (j,)
    p: float
    laps: tuple[Evaluation, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """The piece of each lap."""
        return tuple(lap.word for lap in self.laps)

    @property
    def word(self) -> str:
        """The words of all laps, separated by bars."""
        return SEPARATOR.join(self.words)

    @property
    def multiplier(self) -> float:
        """Product of the slopes."""
        return float(np.prod([lap.slope for lap in self.laps]))

    @property
    def steepness(self) -> float:
        """What rounding of one point can grow by: the largest product of successive slopes."""
        slopes = [abs(lap.slope) for lap in self.laps]
        largest = products = slopes
        for _ in slopes[1:]:
            slopes = [*slopes[1:], slopes[0]]
            products = [a * b for a, b in zip(products, slopes, strict=True)]
            largest = [*largest, *products]
        return math.inf if any(map(math.isnan, largest)) else max(largest)

    @property
    def residual(self) -> float:
        """Largest |f(x_i) - x_{i+1}|."""
        return float(np.abs(gaps(self)).max())


def evaluate(labelled_map: LabelledMap, x: Floats, p: float) -> Cycle:
    """The laps of a candidate cycle; ``x`` (j,) need not close."""
    return Cycle(x, p, tuple(labelled_map(float(value), p) for value in x))


def gaps(cycle: Cycle) -> Floats:
    """f(x_i) - x_{i+1}, shape (j,)."""
    x = cycle.x.tolist()
    return np.array([lap.value - x[k + 1 - len(x)] for k, lap in enumerate(cycle.laps)])


def jacobian(cycle: Cycle, last_row: Floats) -> Floats:
    """Derivatives of the gaps with respect to (x, p), bordered by ``last_row`` (j + 1,)."""
    j = len(cycle.x)
    matrix = np.zeros((j + 1, j + 1))
    for i, lap in enumerate(cycle.laps):
        matrix[i, i] += lap.slope
        matrix[i, (i + 1) % j] -= 1.0
        matrix[i, j] = lap.rate
    matrix[j] = last_row
    return matrix


def tangent(cycle: Cycle, along: Floats) -> Floats:
    """Unit tangent (j + 1,) of the branch in (x, p), oriented like ``along``; nan if singular."""
    border = np.zeros(len(along))
    border[-1] = 1.0
    direction = _solved(cycle, along, border)
    unit: Floats = direction / np.linalg.norm(direction)
    return unit


def correct(
    labelled_map: LabelledMap,
    x: npt.ArrayLike,
    p: float,
    direction: Floats | None = None,
    tolerances: Tolerances = DEFAULT,
    words: tuple[str, ...] | None = None,
) -> tuple[Cycle, bool, int]:
    """Newton's method for a cycle near (x, p), in the hyperplane normal to ``direction``.

    Without a direction the parameter is held. Returns the last iterate, whether its residual is
    small enough, and the number of steps. Iterates that the map does not take, or whose words
    differ from ``words`` if these are given, stop it.
    """
    start = np.atleast_1d(np.asarray(x, dtype=float))
    j = len(start)
    last_row = np.eye(j + 1)[j] if direction is None else direction
    cycle = evaluate(labelled_map, start, p)
    rhs = np.zeros(j + 1)
    for step in range(NEWTON_STEPS):
        if not all(lap.defined for lap in cycle.laps) or words not in (None, cycle.words):
            return cycle, False, step
        accepted = cycle.residual <= allowed(cycle, tolerances)
        rhs[:j] = -gaps(cycle)
        move = _solved(cycle, last_row, rhs)
        if not np.isfinite(move).all():
            return cycle, accepted, step
        trial = evaluate(labelled_map, cycle.x + move[:j], cycle.p + move[j])
        if accepted:  # keep the last polishing step only if it helps
            better = trial.words == cycle.words and trial.residual < cycle.residual
            return (trial if better else cycle), True, step
        cycle = trial
    return cycle, False, NEWTON_STEPS


def _solved(cycle: Cycle, last_row: Floats, rhs: Floats) -> Floats:
    """Solution of the bordered linear equations of a cycle; nan if they are singular.

    Fixed points are most of the work, and a system of two is solved by Cramer's rule.
    """
    if len(cycle.x) > 1:
        try:
            return np.asarray(np.linalg.solve(jacobian(cycle, last_row), rhs), dtype=float)
        except np.linalg.LinAlgError:
            return np.full(len(rhs), np.nan)
    a, b = cycle.laps[0].slope - 1.0, cycle.laps[0].rate
    (c, d), (first, second) = last_row.tolist(), rhs.tolist()
    determinant = a * d - b * c
    if determinant == 0.0:
        return np.full(2, np.nan)
    return np.array(
        [(first * d - b * second) / determinant, (a * second - first * c) / determinant]
    )


def minimal_period(cycle: Cycle, same: float = SAME_CYCLE) -> int:
    """The smallest shift that maps a cycle to itself."""
    n = len(cycle.x)
    divisors = (d for d in range(1, n + 1) if n % d == 0)
    return next(d for d in divisors if np.abs(np.roll(cycle.x, -d) - cycle.x).max() < same)


def allowed(cycle: Cycle, tolerances: Tolerances) -> float:
    """Largest residual at which a cycle is accepted."""
    return tolerances.allowed(max(abs(lap.slope) for lap in cycle.laps))


BELOW = "below the window"


def windowed(labelled_map: LabelledMap, window: tuple[float, float]) -> LabelledMap:
    """A labelled map of a window: not defined outside, and one word where it leads below.

    Dips of a map are infinitely deep and have infinitely many words; what is there does not matter.

    Raises
    ------
    ValueError
        If the window is no two ascending numbers.
    """
    low, high = interval("window", window)
    return _Windowed(labelled_map, low, high)


@dataclass(frozen=True, slots=True)
class _Windowed:
    map: LabelledMap
    low: float
    high: float

    def __call__(self, x: float, p: float) -> Evaluation:
        if not self.low <= x <= self.high:
            return Evaluation(math.nan, math.nan, math.nan, "outside the window", False)
        lap = self.map(x, p)
        return lap._replace(word=BELOW) if lap.value < self.low else lap


def iterate(labelled_map: LabelledMap, order: int) -> LabelledMap:
    """The labelled map of ``order`` laps, derivatives by the chain rule.

    Raises
    ------
    ValueError
        If the order is no whole number of at least 1.
    """
    order = whole("order", order)
    return labelled_map if order == 1 else _Iterated(labelled_map, order)


@dataclass(frozen=True, slots=True)
class _Iterated:
    map: LabelledMap
    order: int

    def __call__(self, x: float, p: float) -> Evaluation:
        return composed(self._laps(x, p))

    def _laps(self, x: float, p: float) -> Iterator[Evaluation]:
        for _ in range(self.order):
            lap = self.map(x, p)
            yield lap
            x = lap.value


def composed(laps: Iterable[Evaluation]) -> Evaluation:
    """Several laps as one, by the chain rule, up to the first that is not defined."""
    slope, rate, words, value = 1.0, 0.0, [], math.nan
    for lap in laps:
        words.append(lap.word)
        if not lap.defined:
            return lap._replace(word=SEPARATOR.join(words))
        value, slope, rate = lap.value, slope * lap.slope, lap.slope * rate + lap.rate
    return Evaluation(value, slope, rate, SEPARATOR.join(words))
