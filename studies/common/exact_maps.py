"""Piecewise-linear maps of several studies: the paper's P1^L, and tent maps."""

from __future__ import annotations

from typing import Final

import sympy

from pwmap import PiecewiseLinearMap

X, A, R = sympy.symbols("x a r")
FORMULA: Final = sympy.Piecewise((R - 2, X <= 0), (R - A * X, True))  # [Leine2001, Eq. 14]
FLAT: Final = PiecewiseLinearMap.from_sympy(FORMULA, X, given=[A > 1])
PAPERS: Final = FLAT.at({A: sympy.Rational(5, 4)})  # of its Figure 12
P1L: Final = PiecewiseLinearMap.from_sympy("Piecewise((r - 2 + b*x, x <= 0), (r - a*x, True))")
TENT: Final = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW: Final = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
