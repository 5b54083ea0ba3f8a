"""A boost converter in discontinuous mode: flips, folds, and a duty ratio that saturates.

    python -m studies.maps.boost [--fast] [--out DIR]

In discontinuous conduction the coil is empty at the end of each period T, so the voltage v of the
capacitor at that instant is the whole state, and one period is a map of the line [Tse1994]

    v -> alpha v + beta d^2 E^2/(v - E),    d = D - kappa (v - V)  kept within [0, 1],

with alpha = 1 - T/(C R) + T^2/(2 C^2 R^2), beta = T^2/(2 L C), and the circuit's E = 16 V,
V = 25 V, T = 1/3000 s, L = 208 uH, C = 222 uF, R = 12.5 Ohm. The parameter is the gain kappa of the
feedback. D is chosen such that v = V is the fixed point for every gain:

    D^2 = (1 - alpha) V (V - E)/(beta E^2).

Its multiplier alpha - 2 beta D kappa E^2/(V - E) - (1 - alpha) V/(V - E) is -1 at

    kappa_c = (1 + alpha - (1 - alpha) V/(V - E)) (V - E)/(2 beta D E^2) = 0.0800471,

the flip with which the published route to chaos begins. At d = 0, v = V + D/kappa, value and slope
(alpha) are continuous, since d enters as its square. So a cycle that begins to saturate changes its
word, but neither its kind nor its stability: this border is not a special point.

Measured here: kappa_c; the next flips and folds against 30-digit roots of their equations, by a
program that shares no code with the engine; the gain at which the 2-cycle begins to saturate, in
the same way; and the number of fixed points of the iterates against changes of sign on a grid.
"""

from __future__ import annotations

from pathlib import Path

import mpmath
import numpy as np
import sympy
from mpmath import mpf

from pwmap import Diagram, PointKind
from studies.common.record import Results, command
from studies.maps.following import changes, miscounted, searched
from woodpecker.base.settings import Settings
from woodpecker.maps.formulas import FormulaMap
from woodpecker.maps.symbolic import from_sympy
from woodpecker.search.search import Search

V, KAPPA = sympy.symbols("v kappa")
SOURCE, TARGET = sympy.Integer(16), sympy.Integer(25)  # V
PERIOD = sympy.Rational(1, 3000)  # s
COIL, CAPACITOR = sympy.Rational(208, 10**6), sympy.Rational(222, 10**6)  # H, F
LOAD = sympy.Rational(25, 2)  # Ohm
ALPHA = 1 - PERIOD / (CAPACITOR * LOAD) + (PERIOD / (CAPACITOR * LOAD)) ** 2 / 2
BETA = PERIOD**2 / (2 * COIL * CAPACITOR)
DUTY = sympy.sqrt((1 - ALPHA) * TARGET * (TARGET - SOURCE) / (BETA * SOURCE**2))
CRITICAL = (
    (1 + ALPHA - (1 - ALPHA) * TARGET / (TARGET - SOURCE))
    * (TARGET - SOURCE)
    / (2 * BETA * DUTY * SOURCE**2)
)
SETTINGS = Settings(span=(0.02, 0.25), window=(16.5, 60.0))
GRID = np.linspace(16.6, 60.0, 40_001)
DIGITS = 30  # of the roots that special points are compared with


def boost_map() -> FormulaMap:
    """The map: the switch stays open, stays closed, or is closed for a part of the period."""
    d, boost = DUTY - KAPPA * (V - TARGET), BETA * SOURCE**2 / (V - SOURCE)
    formula = sympy.Piecewise(
        (ALPHA * V, d < 0), (ALPHA * V + boost, d > 1), (ALPHA * V + d**2 * boost, True)
    )
    return from_sympy(formula, V, KAPPA, words=("open", "closed", "part"))


def step(v: mpf, kappa: mpf) -> mpf:
    """The map in many digits."""
    alpha, beta, duty = (mpmath.mpmathify(sympy.N(c, 40)) for c in (ALPHA, BETA, DUTY))
    d = min(max(duty - kappa * (v - 25), mpf(0)), mpf(1))
    return alpha * v + beta * d**2 * 256 / (v - 16)


def around(v: mpf, kappa: mpf, order: int) -> mpf:
    """An iterate in many digits."""
    for _ in range(order):
        v = step(v, kappa)
    return v


def special(order: int, multiplier: int, v: float, kappa: float) -> float:
    """The gain near a guess at which a cycle has a multiplier, from its two equations."""

    def equations(v: mpf, kappa: mpf) -> list[mpf]:
        slope = mpmath.diff(lambda s: around(s, kappa, order), v)
        return [around(v, kappa, order) - v, slope - multiplier]

    with mpmath.workdps(DIGITS):
        return float(mpmath.findroot(equations, (v, kappa))[1])


def saturation(kappa: float) -> float:
    """The gain near a guess at which the upper point of the 2-cycle has duty ratio 0."""

    def residual(kappa: mpf) -> mpf:
        upper = 25 + mpmath.mpmathify(sympy.N(DUTY, 40)) / kappa
        return around(upper, kappa, 2) - upper

    with mpmath.workdps(DIGITS):
        return float(mpmath.findroot(residual, kappa))


def largest_difference(diagram: Diagram, kinds: dict[PointKind, int]) -> float:
    """Largest distance of special points of cycles from the roots of their equations."""
    points = [point for point in diagram.points if point.kind in kinds and point.order > 1]
    return max(
        abs(point.parameter - special(point.order, kinds[point.kind], point.x, point.parameter))
        for point in points
    )


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compare, and give the headline numbers.

    Parameters
    ----------
    fast
        Orders 1 and 2 only.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``kappa_c``, ``first_flip_error``; ``special_points``: flips and folds, and the
        ``largest_difference`` of those of iterates from their equations; ``saturation``: the gain,
        the ``_error`` of the place where the branch changes its word, whether it ``_is_smooth``;
        ``border_collisions``: how many; ``miscounted``: slices of iterates in which changes of sign
        say something else.
    """
    orders = (1, 2) if fast else (1, 2, 3, 4)
    map_ = boost_map()
    network = searched(map_, SETTINGS, orders, Search(slices=15, finest=5e-3))
    diagram = network.diagram("kappa", "v")
    first = [p for p in diagram.points if p.kind is PointKind.PD and p.order == 1]
    gains = np.linspace(0.0213, 0.2477, 12).tolist()
    saturated = changes(network, 2)
    places, _ = saturated[0]
    saturates = saturation(min(places))
    return {
        "kappa_c": float(CRITICAL),
        "first_flip_error": max(abs(p.parameter - float(CRITICAL)) for p in first),
        "special_points": sum(p.kind in (PointKind.PD, PointKind.LP) for p in diagram.points),
        "largest_difference": largest_difference(diagram, {PointKind.PD: -1, PointKind.LP: 1}),
        "saturation": saturates,
        "saturation_error": min(abs(each - saturates) for each in places),
        "saturation_is_smooth": all(smooth for _, smooth in saturated),
        "border_collisions": sum(p.kind is PointKind.BC for p in diagram.points),
        "miscounted": miscounted(map_, diagram, orders, gains, GRID),
    }


if __name__ == "__main__":
    command(main, "map_boost")
