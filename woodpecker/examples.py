"""Maps and systems of the examples in docstrings, among them the map of the paper's Section 4."""

from __future__ import annotations

from sympy import Piecewise, symbols

from woodpecker.base.settings import Settings
from woodpecker.diagrams import continuation
from woodpecker.maps.formulas import FormulaMap
from woodpecker.maps.symbolic import from_sympy
from woodpecker.plane.curve import Curve
from woodpecker.plane.families import SymbolicFamily, family_from_sympy
from woodpecker.regions.regions import Regions
from woodpecker.regions.survey import Survey
from woodpecker.regions.verb import parameter_regions
from woodpecker.shooting import shoot
from woodpecker.systems import Contact, ContactSystem
from woodpecker.two_parameters import curve_in_two

SETTINGS = Settings(span=(-1, 1), window=(-4, 4))


def two_lines() -> FormulaMap:
    """The map with pieces L, x/2 + p for x < 0, and R, x/3 + p - 1 for x >= 0."""
    x, p = symbols("x p")
    return from_sympy(Piecewise((x / 2 + p, x < 0), (x / 3 + p - 1, True)), x, p, words=["L", "R"])


def bouncing_ball() -> ContactSystem:
    """A point of unit mass at height y over a floor with eps_N = 0.5; g = 10 m/s^2."""
    y, g = symbols("y g")
    return ContactSystem([y], [[1]], [-g], [Contact(name="floor", gap=y, eps_n=0.5)], {g: 10.0})


def paper_family() -> SymbolicFamily:
    """P_1^L over r and a: r - 2 for x <= 0, r - a x for x > 0 [Leine2001, Eq. 14]."""
    x, a, r = symbols("x a r")
    p1 = Piecewise((r - 2, x <= 0), (r - a * x, True))
    return family_from_sympy(p1, x, (r, a), words=["L", "R"])


def border_curve(lowest: float = 1.1) -> Curve:
    """The border collision of that family at r = 0, for a from ``lowest`` to 2."""
    family = paper_family()
    over_r = family.over(0, (0.0, 1.25))
    point = continuation(over_r, shoot(over_r, 0.2, p=0.45), settings=SETTINGS).points[0]
    spans = (-1.0, 1.0), (lowest, 2.0)
    return curve_in_two(family, point, ("r", "a"), spans, value=1.25, settings=SETTINGS)


def paper_regions() -> Regions:
    """The regions on both sides of that curve, with their cycles."""
    family, spans = paper_family(), ((-1.0, 1.0), (1.1, 2.0))
    few = Survey(checks=4)
    return parameter_regions(family, family.names, spans, settings=SETTINGS, survey=few)
