"""Labelled maps of the line that can be solved by hand, for the tests of continuation.

Each maker returns a map (x, p) -> :class:`woodpecker.piecewise.maps.Evaluation`. Its docstring
gives the solution; words are "L" (left of the edge) and "R" (right of it) unless said otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from woodpecker.piecewise.maps import Cycle, Evaluation, LabelledMap, correct

Formula = Callable[[float, float], tuple[float, float, float]]  # value, slope, rate

A = 1.25  # the constant a of the paper's example


def pieces(left: Formula, right: Formula, edge: float = 0.0, owner: str = "R") -> LabelledMap:
    """Two formulas that meet at a fixed edge, whose own value the piece ``owner`` gives."""

    return _Pieces(left, right, edge, owner)


@dataclass(frozen=True)
class _Pieces:
    left: Formula
    right: Formula
    edge: float
    owner: str

    def __call__(self, x: float, p: float) -> Evaluation:
        if x < self.edge or (x == self.edge and self.owner == "L"):
            return Evaluation(*self.left(x, p), "L")
        return Evaluation(*self.right(x, p), "R")


def line(slope: float, rate: float, constant: float = 0.0) -> Formula:
    """slope * x + rate * p + constant."""
    return _Line(slope, rate, constant)


@dataclass(frozen=True)
class _Line:
    slope: float
    rate: float
    constant: float

    def __call__(self, x: float, p: float) -> tuple[float, float, float]:
        return self.slope * x + self.rate * p + self.constant, self.slope, self.rate


def paper(a: float = A) -> LabelledMap:
    """P1^L: -2 + r for x <= 0, -a x + r for x > 0 [Leine2001, Eq. 14]; the parameter is r.

    Fixed points r - 2 (r < 2) and r/(1 + a) (r > 0); the jump at 0 crosses for 0 < r < 2. The
    second iterate has the jumps 0 and r/a, of which only r/a crosses [Eq. 15].
    """
    return pieces(line(0.0, 1.0, -2.0), line(-a, 1.0), owner="L")


def two_lines() -> LabelledMap:
    """x/2 + p for x < 0, -x/2 + p + 1 for x >= 0.

    Fixed points 2 p (p < 0) and 2 (p + 1)/3 (p >= -1); the jump at 0 crosses for -1 < p < 0.
    """
    return pieces(line(0.5, 1.0), line(-0.5, 1.0, 1.0))


def staircase() -> LabelledMap:
    """x/2 + p for x < 0, x/2 + p - 1 for x >= 0.

    Fixed points 2 p (p < 0) and 2 (p - 1) (p >= 1); the jump at 0 crosses in between.
    """
    return pieces(line(0.5, 1.0), line(0.5, 1.0, -1.0))


def skew_tent(a: float, b: float) -> LabelledMap:
    """Continuous: a x + p for x < 0, b x + p for x >= 0.

    Fixed points p/(1 - a) on the left and p/(1 - b) on the right; they meet at (0, 0).
    """
    return pieces(line(a, 1.0), line(b, 1.0))


def logistic(x: float, p: float) -> Evaluation:
    """p x (1 - x): fixed point 1 - 1/p with multiplier 2 - p.

    The orbit of period two, for p > 3, is (p + 1 +- sqrt((p - 3)(p + 1)))/(2 p), its multiplier
    4 + 2 p - p^2: it flips at 1 + sqrt(6).
    """
    return Evaluation(p * x * (1.0 - x), p * (1.0 - 2.0 * x), x * (1.0 - x), "S")


def logistic_pair(p: float) -> tuple[float, float]:
    """The lower and upper point of the logistic map's orbit of period two."""
    root = math.sqrt((p - 3.0) * (p + 1.0))
    return (p + 1.0 - root) / (2.0 * p), (p + 1.0 + root) / (2.0 * p)


def relabelled_logistic(edge: float) -> LabelledMap:
    """The logistic map with a word that changes at ``edge`` and nothing else."""
    return lambda x, p: logistic(x, p)._replace(word="L" if x < edge else "R")


def fold(x: float, p: float) -> Evaluation:
    """x + p - x^2: fixed points +-sqrt(p) with multiplier 1 -+ 2 sqrt(p), a fold at p = 0."""
    return Evaluation(x + p - x * x, 1.0 - 2.0 * x, 1.0, "S")


def grazing(c: float) -> LabelledMap:
    """x/2 + p for x < 0, x/2 + p + c sqrt(x) for x >= 0: continuous, of infinite slope at 0+.

    Fixed points 2 p (p < 0) and, with s = sqrt(x), s^2 - 2 c s - 2 p = 0: for c < 0 the branch
    goes on to p > 0 and flips at s = -c/3; for c > 0 it turns back and folds at s = c, p = -c^2/2.
    """

    def right(x: float, p: float) -> tuple[float, float, float]:
        s = math.sqrt(x)
        slope = 0.5 + 0.5 * c / s if s > 0.0 else math.copysign(math.inf, c)
        return 0.5 * x + p + c * s, slope, 1.0

    return pieces(line(0.5, 1.0), right)


def moving_edge(x: float, p: float) -> Evaluation:
    """A jump at x_e = p/2, of limits x_e + p - 1 and x_e + p + 1, slopes 1/2 and -1/2.

    It crosses the diagonal for -1 < p < 1; fixed points x_e + 2 (p - 1) and x_e + 2 (p + 1)/3.
    """
    edge = 0.5 * p
    if x < edge:
        return Evaluation(edge + p - 1.0 + 0.5 * (x - edge), 0.5, 1.25, "L")
    return Evaluation(edge + p + 1.0 - 0.5 * (x - edge), -0.5, 1.75, "R")


def lost_beyond(limit: float) -> LabelledMap:
    """x/2 + p for x < limit, no value beyond: the fixed point 2 p is lost at p = limit/2."""

    def labelled(x: float, p: float) -> Evaluation:
        if x < limit:
            return Evaluation(0.5 * x + p, 0.5, 1.0, "L")
        return Evaluation(math.nan, math.nan, math.nan, "lost", False)

    return labelled


def island(x_0: float, p_0: float, radius: float) -> LabelledMap:
    """x - ((x - x_0)^2 + (p - p_0)^2 - radius^2): its fixed points form a circle."""

    def labelled(x: float, p: float) -> Evaluation:
        dx, dp = x - x_0, p - p_0
        return Evaluation(x - (dx * dx + dp * dp - radius * radius), 1.0 - 2.0 * dx, -2.0 * dp, "S")

    return labelled


def two_cycle(x: float, p: float) -> Evaluation:
    """x/2 + 1 for x < 0, x/2 - 1 + p for x >= 0, with an orbit of period two.

    Its points are 4/3 (p - 1/2) < 0 and 1 + 2/3 (p - 1/2) >= 0: it lives for -1 <= p < 1/2, and at
    either end one of its points meets the jump. Multiplier 1/4. Fixed points 2 (p - 1), p >= 1.

    The second iterate jumps at 0 from p - 1/2 to (p + 1)/2 (to 3 (p - 1)/2 for p > 1), and at the
    preimages of 0, which are -2 and, for p <= 1, 2 - 2 p, from 1 to p - 1. So it crosses at -2 for
    p < -1, at 0 for -1 < p < 1/2 and at 2 - 2 p for 1/2 < p < 1.
    """
    return pieces(line(0.5, 0.0, 1.0), line(0.5, 1.0, -1.0))(x, p)


def start(labelled_map: LabelledMap, x: float | list[float], p: float) -> Cycle:
    """The cycle near x at p, which must exist."""
    cycle, good, _ = correct(labelled_map, np.atleast_1d(np.array(x, dtype=float)), p)
    assert good, cycle
    return cycle
