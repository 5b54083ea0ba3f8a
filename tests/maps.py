"""Piecewise-smooth maps of the line that can be solved by hand, for tests of the engine.

Each docstring gives the solution. Two pieces are named "L" (left of the border) and "R" (right of
it), and on the border itself R holds; a single piece is named "S". All of them pickle.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from pwmap import Diagram
from woodpecker import PiecewiseMap, Search, Settings, continuation, shoot
from woodpecker.diagrams import bifurcation_search
from woodpecker.maps.formulas import FormulaMap, FormulaPiece, Smooth
from woodpecker.search import Found

A = 1.25  # the constant a of the paper's example
BORDER = "x reaches the border"  # the cause of all borders here


@dataclass(frozen=True)
class Line:
    """by_x * x + by_p * p + constant."""

    by_x: float
    by_p: float
    constant: float = 0.0

    def smooth(self) -> Smooth:
        """With its derivatives."""
        return Smooth(self._value, self._dx, self._dp)

    def _value(self, x: float, p: float) -> float:
        return self.by_x * x + self.by_p * p + self.constant

    def _dx(self, _x: float, _p: float) -> float:
        return self.by_x

    def _dp(self, _x: float, _p: float) -> float:
        return self.by_p


def two_pieces(left: Smooth, right: Smooth, at: float = 0.0, speed: float = 0.0) -> FormulaMap:
    """Two formulas with a border at ``at`` + speed * p."""
    below, above = Line(-1.0, speed, at), Line(1.0, -speed, -at)
    return FormulaMap(
        [
            FormulaPiece("R", right, {BORDER: above.smooth()}),
            FormulaPiece("L", left, {BORDER: below.smooth()}),
        ]
    )


def one_piece(formula: Smooth) -> FormulaMap:
    """One formula everywhere."""
    return FormulaMap([FormulaPiece("S", formula)])


# --- Two lines ------------------------------------------------------------------------------------


def lines(left: Line, right: Line, speed: float = 0.0, at: float = 0.0) -> FormulaMap:
    """Two lines with a border at ``at`` + speed * p, of one map or of two."""
    return two_pieces(left.smooth(), right.smooth(), at, speed)


def paper(a: float = A) -> FormulaMap:
    """P1^L: -2 + r for x < 0, -a x + r for x >= 0 [Leine2001, Eq. 14]; the parameter is r.

    Fixed points r - 2 (r < 2) and r/(1 + a) (r > 0); the jump at 0 crosses for 0 < r < 2. The
    second iterate has the jumps 0 and r/a, of which only r/a crosses, up to r = 10 for a = 5/4,
    where its right limit r - 2 meets it [Eq. 15].
    """
    return lines(Line(0.0, 1.0, -2.0), Line(-a, 1.0))


def two_lines() -> FormulaMap:
    """x/2 + p for x < 0, -x/2 + p + 1 for x >= 0.

    Fixed points 2 p (p < 0) and 2 (p + 1)/3 (p >= -1); the jump at 0 crosses for -1 < p < 0.
    """
    return lines(Line(0.5, 1.0), Line(-0.5, 1.0, 1.0))


def moving(speed: float, a: float = A) -> FormulaMap:
    """The paper's map in y = x - speed * p: every solution moves by speed * p."""
    return lines(Line(0.0, 1.0 + speed, -2.0), Line(-a, 1.0 + speed * (1.0 + a)), speed)


def moving_border() -> FormulaMap:
    """A jump at b = p/2, of limits b + p - 1 and b + p + 1, slopes 1/2 and -1/2.

    It crosses the diagonal for -1 < p < 1; fixed points b + 2 (p - 1) and b + 2 (p + 1)/3.
    """
    return lines(Line(0.5, 1.25, -1.0), Line(-0.5, 1.75, 1.0), speed=0.5)


def skew_tent(a: float, b: float) -> FormulaMap:
    """Continuous: a x + p for x < 0, b x + p for x >= 0.

    Fixed points p/(1 - a) on the left and p/(1 - b) on the right; they meet at (0, 0).
    """
    return lines(Line(a, 1.0), Line(b, 1.0))


def tent() -> FormulaMap:
    """2 x for x < 1/2, 2 - 2 x beyond, for every p: 2**j fixed points of P_j, k / (2**j -+ 1)."""
    return lines(Line(2.0, 0.0), Line(-2.0, 0.0, 2.0), at=0.5)


def doubling() -> FormulaMap:
    """2 x mod 1 on (0, 1): P_j jumps from 1 to 0 at odd multiples of 2**-j, and where P_i did."""
    return lines(Line(2.0, 0.0), Line(2.0, 0.0, -1.0), at=0.5)


def lost_beyond(limit: float) -> FormulaMap:
    """x/2 + p up to a limit, no value beyond: the fixed point 2 p is lost at p = limit/2."""
    inside = {BORDER: Line(-1.0, 0.0, limit).smooth()}
    return FormulaMap([FormulaPiece("L", Line(0.5, 1.0).smooth(), inside)])


# --- Curves ---------------------------------------------------------------------------------------


def logistic() -> FormulaMap:
    """p x (1 - x): fixed point 1 - 1/p with multiplier 2 - p.

    The cycle of period two, for p > 3, is (p + 1 +- sqrt((p - 3)(p + 1)))/(2 p), its multiplier
    4 + 2 p - p^2: it flips at 1 + sqrt(6).
    """
    return one_piece(_PARABOLA)


def renamed_logistic(at: float) -> FormulaMap:
    """The logistic map with a word that changes at a place, and nothing else."""
    return two_pieces(_PARABOLA, _PARABOLA, at)


def logistic_pair(p: float) -> tuple[float, float]:
    """The lower and upper point of the logistic map's cycle of period two."""
    root = math.sqrt((p - 3.0) * (p + 1.0))
    return (p + 1.0 - root) / (2.0 * p), (p + 1.0 + root) / (2.0 * p)


def _parabola(x: float, p: float) -> float:
    return p * x * (1.0 - x)


def _parabola_dx(x: float, p: float) -> float:
    return p * (1.0 - 2.0 * x)


def _parabola_dp(x: float, _p: float) -> float:
    return x * (1.0 - x)


_PARABOLA = Smooth(_parabola, _parabola_dx, _parabola_dp)


@dataclass(frozen=True)
class Circle:
    """x less the amount by which (x, p) lies outside of a circle; the circle is fixed."""

    x_0: float
    p_0: float
    radius: float

    def smooth(self) -> Smooth:
        """With its derivatives."""
        return Smooth(self._value, self._dx, self._dp)

    def _value(self, x: float, p: float) -> float:
        return x - ((x - self.x_0) ** 2 + (p - self.p_0) ** 2 - self.radius**2)

    def _dx(self, x: float, _p: float) -> float:
        return 1.0 - 2.0 * (x - self.x_0)

    def _dp(self, _x: float, p: float) -> float:
        return -2.0 * (p - self.p_0)


def island(x_0: float, p_0: float, radius: float) -> FormulaMap:
    """x - ((x - x_0)^2 + (p - p_0)^2 - radius^2): its fixed points form a circle.

    Their multiplier is 1 - 2 (x - x_0): folds at p = p_0 -+ radius, and flips where x = x_0 + 1.
    """
    return one_piece(Circle(x_0, p_0, radius).smooth())


def fold() -> FormulaMap:
    """x + p - x^2: fixed points +-sqrt(p) with multiplier 1 -+ 2 sqrt(p), a fold at p = 0."""
    return one_piece(Smooth(_fold, _fold_dx, _fold_dp))


def _fold(x: float, p: float) -> float:
    return x + p - x * x


def _fold_dx(x: float, _p: float) -> float:
    return 1.0 - 2.0 * x


def _fold_dp(_x: float, _p: float) -> float:
    return 1.0


@dataclass(frozen=True)
class Root:
    """x/2 + p + c sqrt(x)."""

    c: float

    def smooth(self) -> Smooth:
        """With its derivatives."""
        return Smooth(self._value, self._dx, _fold_dp)

    def _value(self, x: float, p: float) -> float:
        return 0.5 * x + p + self.c * math.sqrt(x)

    def _dx(self, x: float, _p: float) -> float:
        return 0.5 + 0.5 * self.c / math.sqrt(x)


def grazing(c: float) -> FormulaMap:
    """x/2 + p for x < 0, x/2 + p + c sqrt(x) for x >= 0: continuous, of infinite slope at 0+.

    Fixed points 2 p (p < 0) and, with s = sqrt(x), s^2 - 2 c s - 2 p = 0: for c < 0 the branch
    goes on to p > 0 and flips at s = -c/3; for c > 0 it turns back and folds at s = c, p = -c^2/2.
    """
    return two_pieces(Line(0.5, 1.0).smooth(), Root(c).smooth())


# --- What is found --------------------------------------------------------------------------------


def continued(
    map_: PiecewiseMap, x: npt.ArrayLike, p: float, settings: Settings, **options: Any
) -> Diagram:
    """What is connected with the cycle near a guess of its points."""
    return continuation(map_, shoot(map_, x, p=p, settings=settings), settings=settings, **options)


def everything(
    map_: PiecewiseMap, settings: Settings, orders: tuple[int, ...] = (1,),
    search: Search | None = None, **options: Any,
) -> Found:  # fmt: skip
    """All branches in the window of the settings, and what the slices came to."""
    return bifurcation_search(map_, orders=orders, settings=settings, search=search, **options)
