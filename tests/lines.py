"""Piecewise-smooth maps of the line that can be solved by hand, for tests of the engine.

Pieces are named "L" (left of the border) and "R" (right of it); on the border itself R holds.
"""

from __future__ import annotations

from dataclasses import dataclass

from woodpecker.engine.formulas import FormulaMap, FormulaPiece, Smooth

A = 1.25  # the constant a of the paper's example


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


def lines(left: Line, right: Line, speed: float = 0.0) -> FormulaMap:
    """Two lines with a border at speed * p, of one map or of two."""
    below, above = Line(-1.0, speed), Line(1.0, -speed)
    return FormulaMap(
        [
            FormulaPiece("R", right.smooth(), {"x reaches the border": above.smooth()}),
            FormulaPiece("L", left.smooth(), {"x reaches the border": below.smooth()}),
        ]
    )


def paper(a: float = A) -> FormulaMap:
    """P1^L: -2 + r for x < 0, -a x + r for x >= 0 [Leine2001, Eq. 14]; the parameter is r.

    Fixed points r - 2 (r < 2) and r/(1 + a) (r > 0); the jump at 0 crosses for 0 < r < 2. The
    second iterate has the jumps 0 and r/a, of which only r/a crosses [Eq. 15].
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


def skew_tent(a: float, b: float) -> FormulaMap:
    """Continuous: a x + p for x < 0, b x + p for x >= 0."""
    return lines(Line(a, 1.0), Line(b, 1.0))


def logistic() -> FormulaMap:
    """p x (1 - x): fixed point 1 - 1/p with multiplier 2 - p."""
    return FormulaMap([FormulaPiece("S", Smooth(_parabola, _parabola_dx, _parabola_dp))])


def _parabola(x: float, p: float) -> float:
    return p * x * (1.0 - x)


def _parabola_dx(x: float, p: float) -> float:
    return p * (1.0 - 2.0 * x)


def _parabola_dp(x: float, _p: float) -> float:
    return x * (1.0 - x)
