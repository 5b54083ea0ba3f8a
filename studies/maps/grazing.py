"""Grazing of an impact oscillator: the square-root map, and its period adding.

    python -m studies.maps.grazing [--fast] [--out DIR]

Nordmark's map of an oscillator next to a grazing impact [Nordmark1991] becomes, for strong damping,
a map of the line [Chin1994, diBernardo2008, Ch. 4]

    x -> alpha x + rho      (x <= 0: no impact)
    x -> rho - sqrt(x)      (x > 0: an impact of low speed),      0 < alpha < 1.

A *maximal* cycle of period m has one impact. With s the root of its largest point,
a = alpha^(m-1) and c = (1 - alpha^m)/(1 - alpha), going round once gives

    s^2 + a s = c rho,      multiplier -a/(2 s).

It flips where s = a/2, and it ends where the point before its impact grazes, x = 0, where
s^2 = rho:

    rho_flip(m) = (3/4) alpha^(2m-2) (1 - alpha)/(1 - alpha^m),
    rho_graze(m) = (alpha^(m-2) (1 - alpha)/(1 - alpha^(m-1)))^2      (m >= 2).

It is stable between the two. For large m, rho_flip(m) < rho_graze(m) if and only if
3 alpha^2/4 < 1 - alpha, that is alpha < 2/3, and rho_flip(m) < rho_graze(m + 1) if and only if
alpha < 1/4. These are the published cases [Chin1994]: for alpha < 1/4 windows of neighbouring
periods overlap; for 1/4 < alpha < 2/3 they alternate with chaos; for alpha > 2/3 there are none
next to grazing. Their values of rho shrink by alpha^2 from one period to the next.

At grazing the map has slopes alpha and -infinity, and the branch folds: it turns back in rho as a
cycle with two impacts. For m = 2 that cycle has x and y with sqrt(x) + sqrt(y) = 1, and ends at the
flip of the fixed point, rho = 3/4.

Measured here: the flips and grazings of the followed branches, against the formulas; the cases, as
they show at the largest period; and one diagram of orders 1 to 3 from a search.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import sympy

from pwmap import PointKind
from studies.common.record import Results, command
from studies.maps.following import branch_near, ends_of, searched, stable_part
from woodpecker.base.settings import Settings
from woodpecker.maps.formulas import FormulaMap
from woodpecker.maps.symbolic import from_sympy
from woodpecker.search.curves import BranchCurve
from woodpecker.search.search import Search

X, RHO, ALPHA = sympy.symbols("x rho alpha")
FORMULA = sympy.Piecewise((ALPHA * X + RHO, X <= 0), (RHO - sympy.sqrt(X), True))
CASES = {"overlap": 0.2, "alternate": 0.5, "none": 0.8}  # alpha on both sides of 1/4 and 2/3
LARGEST = {"overlap": 6, "alternate": 10, "none": 10}  # period: rho falls like alpha^(2 m)
FAST = 5  # the first period with no window for alpha = 0.8


def square_root_map(alpha: float) -> FormulaMap:
    """The map, of parameter rho."""
    return from_sympy(FORMULA, X, RHO, {ALPHA: alpha}, words=("L", "R"))


def flip(alpha: float, m: int) -> float:
    """Where the maximal cycle of period m flips."""
    return 0.75 * alpha ** (2 * m - 2) * (1.0 - alpha) / (1.0 - alpha**m)


def grazing(alpha: float, m: int) -> float:
    """Where it grazes, m >= 2."""
    return float((alpha ** (m - 2) * (1.0 - alpha) / (1.0 - alpha ** (m - 1))) ** 2)


@dataclass(frozen=True, slots=True)
class Window:
    """What was found of a maximal cycle.

    Attributes
    ----------
    flip, grazing
        Parameters; the flip is nan if the cycle grazes before it.
    stable
        Length of the parameter on which the samples of its branch attract.
    """

    alpha: float
    m: int
    flip: float
    grazing: float
    stable: float

    @property
    def error(self) -> float:
        """Largest relative error of flip and grazing."""
        grazes = abs(self.grazing / grazing(self.alpha, self.m) - 1.0)
        flips = abs(self.flip / flip(self.alpha, self.m) - 1.0)
        return grazes if math.isnan(flips) else max(grazes, flips)


def window(alpha: float, m: int) -> Window:
    """Follow the maximal cycle of period m, from the middle between rho = 0 and its grazing.

    Scales are those of the grazing: x is of the size of the root of rho.
    """
    map_, at = square_root_map(alpha), 0.5 * grazing(alpha, m)
    a, c = alpha ** (m - 1), (1.0 - alpha**m) / (1.0 - alpha)
    points = [(0.5 * (math.sqrt(a * a + 4.0 * c * at) - a)) ** 2]
    while len(points) < m:
        points.append(map_.at(points[-1], at).value)
    size = 4.0 * math.sqrt(3.0 * at)
    low = 0.5 * min(flip(alpha, m), at)
    settings = Settings(span=(low, 3.0 * at), window=(-size, size))
    curves = branch_near(map_, points, at, settings)
    maximal = [curve for curve in curves if sum(map(is_impact, curve.words[0].keys)) == 1]
    flips = ends_of(maximal, PointKind.PD)
    folds = ends_of(curves, PointKind.BC, "fold")
    return Window(alpha, m, flips[0].p if flips else math.nan, folds[-1].p, stable_part(maximal))


def is_impact(key: object) -> bool:
    """Whether a piece, by its key, is that with an impact."""
    return key == "R"


def two_impacts() -> tuple[list[BranchCurve], float]:
    """The branch from the grazing of the 2-cycle at rho = 1, and its error at the flip 3/4."""
    settings = Settings(span=(0.5, 1.2), window=(-2.0, 2.0))
    map_ = square_root_map(0.5)
    curves = branch_near(map_, [0.64, 0.04], 0.84, settings)  # roots 0.8 and 0.2
    return curves, abs(ends_of(curves, PointKind.PD)[-1].p - 0.75)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Compare, and give the headline numbers.

    Parameters
    ----------
    fast
        Periods up to 5, and a search of few slices.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        ``windows``: how many maximal cycles, up to ``largest_period``; ``largest_error`` of their
        flips and grazings, relative; ``neighbours_overlap``, ``attract``: of the largest periods,
        by case; ``ratio_over_alpha_squared`` of the last two grazings, by case;
        ``two_impacts_error`` of that branch's flip; ``searched_branches``, ``searched_missing``,
        ``searched_others``: how many a search finds, and how many of its special points are missing
        or unknown to the formulas.
    """
    windows = {
        name: [window(alpha, m) for m in range(2, (FAST if fast else LARGEST[name]) + 1)]
        for name, alpha in CASES.items()
    }
    every = [found for row in windows.values() for found in row]
    last = {name: row[-2:] for name, row in windows.items()}
    whole = searched(
        square_root_map(0.2), Settings(span=(0.01, 1.2), window=(-1.5, 1.5)), (1, 2, 3),
        Search(slices=7 if fast else 31, finest=0.01),
    ).diagram("rho", "x")  # fmt: skip
    expected = [flip(0.2, 1), flip(0.2, 2), grazing(0.2, 2), grazing(0.2, 3)]
    places = [p.parameter for p in whole.points if p.kind in (PointKind.PD, PointKind.BC)]
    return {
        "windows": len(every),
        "largest_period": max(found.m for found in every),
        "largest_error": max(found.error for found in every),
        "neighbours_overlap": {name: two[0].flip < two[1].grazing for name, two in last.items()},
        "attract": {name: two[1].stable > 0.0 for name, two in last.items()},
        "ratio_over_alpha_squared": {  # of the last two grazings
            name: two[1].grazing / two[0].grazing / CASES[name] ** 2 for name, two in last.items()
        },
        "two_impacts_error": two_impacts()[1],
        "searched_branches": len(whole.branches),
        "searched_missing": sum(all(abs(place - p) > 1e-9 for place in places) for p in expected),
        "searched_others": sum(all(abs(place - p) > 1e-9 for p in expected) for place in places),
    }


if __name__ == "__main__":
    command(main, "map_grazing")
