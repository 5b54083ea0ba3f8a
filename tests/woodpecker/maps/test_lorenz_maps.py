"""Lorenz maps: slopes at the jump are 0 or infinite, and no piece has a value beyond it.

x -> 1 - p (-x)^e below x = 0, and minus that at -x above: the jump from 1 to -1 crosses the
diagonal at all p. The 2-cycle {y, -y} obeys p y^e = 1 - y, and splits where e p y^(e-1) = 1.
"""

import numpy as np
import pytest
from sympy import Piecewise, Rational, symbols

from pwmap import Branch, Diagram
from woodpecker import Search, bifurcation_diagram, from_sympy

SPAN, WINDOW = (0.2, 1.9), (-1.5, 1.5)
EXPONENTS = Rational(1, 2), Rational(3, 4), Rational(3, 2), 1
CHORD = 1e-3  # of x: branches are polygons between samples


def searched(exponent: Rational | int) -> Diagram:
    x, p = symbols("x p", real=True)
    map_ = Piecewise((1 - p * (-x) ** exponent, x < 0), (-1 + p * x**exponent, True))
    return bifurcation_diagram(
        from_sympy(map_, x, p, words=["L", "R"]), "p", SPAN, (1, 2), WINDOW,
        search=Search(slices=15),
    )  # fmt: skip


def iterated(x: np.ndarray, p: float, exponent: float, order: int) -> np.ndarray:
    for _ in range(order):
        x = np.sign(x) * (-1.0 + p * np.abs(x) ** exponent)
    return x


def shows(branch: Branch, order: int) -> bool:
    """Whether a table of P_order shows it: its own jumps, and all cycles that it maps to itself."""
    is_jump = branch.kind.value == "jump"
    return branch.order == order or (not is_jump and order % branch.order == 0)


@pytest.mark.nightly
@pytest.mark.parametrize("exponent", EXPONENTS, ids=str)
def test_all_cycles_and_jumps_of_a_table_are_drawn(exponent: Rational | int) -> None:
    diagram = searched(exponent)
    e = float(exponent)
    x = np.linspace(*WINDOW, 30_000)  # an even number: 0 is no point of it
    for p in (0.31, 0.57, 0.93, 1.21, 1.67):
        for order in (1, 2):
            inside = np.abs(iterated(x, p, e, 1)) <= WINDOW[1]
            off = iterated(x, p, e, order) - x
            (k,) = np.nonzero((off[1:] * off[:-1] < 0.0) & (inside[1:] | inside[:-1]))
            drawn = np.array([hit.x for hit in diagram.at(p) if shows(hit.branch, order)])
            assert len(k) == len(drawn), (p, order)
            assert np.abs(np.sort(drawn) - x[k]).max(initial=0.0) <= CHORD


@pytest.mark.nightly
@pytest.mark.parametrize("exponent", EXPONENTS[:3], ids=str)
def test_the_symmetric_cycle_splits_where_its_multiplier_is_one(exponent: Rational) -> None:
    e = float(exponent)
    diagram = searched(exponent)
    y = e / (1.0 + e)  # e p y^(e-1) = e (1 - y)/y = 1
    crossings = [point for point in diagram.points if point.kind.value == "BP"]
    assert len(crossings) == 2
    for point in crossings:
        assert point.parameter == pytest.approx((1.0 - y) / y**e, abs=1e-12)
        assert abs(point.x) == pytest.approx(y, abs=1e-9)  # as the cube root of rounding tells
