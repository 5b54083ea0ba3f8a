"""Slices of exact diagrams are exact: between, at and beside the ends of branches."""

import math
import pickle
from fractions import Fraction
from typing import Any

import pytest
import sympy
from sympy import Rational, sqrt

from pwmap import Diagram, PiecewiseLinearMap, bifurcation_diagram

A, P = sympy.symbols("a p")


def pole() -> Diagram:
    """p x + 1 on the right: its fixed point 1/(1 - p) is there for p < 1."""
    map_ = PiecewiseLinearMap([("p*x + 1", "x > 0"), ("0", "x <= 0")])
    return bifurcation_diagram(map_, "p", (0, 3), (1,))


@pytest.mark.slow
@pytest.mark.parametrize(
    "p",
    [
        *(0, Fraction(1, 3), "5/7", Rational(2, 3), sympy.Float(0.25), 0.1, 1 - 2.0**-53, 1e-300),
        *(sqrt(2) / 2, sympy.cbrt(2) / 2, sympy.rootof(A**5 + A - 1, 0)),
    ],
)
@pytest.mark.parametrize("way", [lambda d: d, lambda d: pickle.loads(pickle.dumps(d))])
def test_a_slice_near_a_pole_is_exact(p: Any, way: Any) -> None:
    """Beside p = 1 the fixed point is far away, but nothing is interpolated; at 1 there is none."""
    exact = sympy.Rational(p) if isinstance(p, float | sympy.Float) else sympy.sympify(p)
    below, beyond = way(pole()).at(p)
    assert (below.exact, below.x, below.multiplier) == ({"x": 0, "multiplier": 0}, 0.0, 0.0)
    x, multiplier = beyond.exact["x"], beyond.exact["multiplier"]
    assert sympy.simplify(x * (1 - exact) - 1) == 0
    assert sympy.simplify(multiplier - exact) == 0
    assert beyond.x == pytest.approx(float(1 / (1 - exact)), rel=2e-16)


def test_beyond_the_pole_only_the_other_branch_is_there() -> None:
    for p in (1, 1.0, 1 + 2.0**-52, "3/2", sqrt(2), 3):
        (hit,) = pole().at(p)
        assert hit.exact["x"] == 0
    assert pole().at(4) == ()


def test_ends_that_do_not_belong_to_a_branch() -> None:
    """P1^L: L owns 0, so that r/(1 + a) is there for r > 0 only, r - 2 for r <= 2."""
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - 5*x/4", "x > 0")])
    diagram = bifurcation_diagram(map_, "r", (-1, 3), (1, 2))
    shown = {
        r: [(hit.branch.order, hit.exact["x"], hit.exact.get("left")) for hit in diagram.at(r)]
        for r in (0, Fraction(1, 10**30), 1, 2, 2 + Fraction(1, 10**30))
    }
    assert shown[0] == [(1, -2, None)]
    tiny = Rational(1, 10**30)
    assert [x for _, x, _ in shown[Fraction(1, 10**30)]] == [
        tiny - 2, 0, 4 * tiny / 9, 4 * tiny / 5
    ]  # fmt: skip
    assert shown[1] == [
        (1, -1, None), (1, 0, -1), (1, Rational(4, 9), None), (2, Rational(4, 5), 1)
    ]  # fmt: skip
    assert [x for _, x, _ in shown[2]] == [0, Rational(8, 9), Rational(8, 5)]
    beyond = [x for _, x, _ in shown[2 + Fraction(1, 10**30)]]
    assert beyond == [0, 4 * (2 + tiny) / 9, 4 * (2 + tiny) / 5]


def test_a_slice_at_an_algebraic_edge() -> None:
    """At the golden ratio g, orbits of period three start at 1: 1, 1 - g and 0."""
    map_ = PiecewiseLinearMap([("a*x + 1", "x <= 0"), ("1 - a*x", "x > 0")])
    diagram = bifurcation_diagram(map_, "a", (1, 2), (1, 2, 3))
    g = (1 + sqrt(5)) / 2
    hits = diagram.at(g)
    (fixed,) = (h for h in hits if h.branch.order == 1 and h.exact["multiplier"] == -g)
    assert sympy.expand(fixed.exact["x"] - (3 - sqrt(5)) / 2) == 0
    third = [h.exact["x"] for h in hits if h.branch.order == 3]
    assert all(any(sympy.expand(x - y) == 0 for x in third) for y in (0, 1, 1 - g))
    assert [h.x for h in hits] == sorted(h.x for h in hits)
    beside = diagram.at(g - Rational(1, 10**40))
    assert not [h for h in beside if h.branch.order == 3]


def test_a_band_along_one_value_is_met_at_both_ends() -> None:
    """P = -x on the right: P_2 is the identity at p = -1 over 0 < x < 1."""
    map_ = PiecewiseLinearMap([("p*x + 1", "x > 0"), ("0", "x <= 0")])
    diagram = bifurcation_diagram(map_, "p", (-2, 3), (1, 2))
    bands = [hit for hit in diagram.at(-1) if "x" not in hit.branch.exact]
    half = Rational(1, 2)
    assert [(hit.exact["x"], hit.x) for hit in bands] == [(0, 0), (half, 0.5), (half, 0.5), (1, 1)]
    for p in (-1 - 2.0**-52, -1 + 2.0**-53):
        assert all("x" in hit.branch.exact for hit in diagram.at(p))


def test_slices_with_other_parameters_are_formulas_in_them() -> None:
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    diagram = bifurcation_diagram(map_, "r", (-1, 5), (1, 2), sample={"a": 3})
    assert diagram.sample == {"a": 3}
    left, jump, fixed, second = diagram.at(1)
    assert [hit.exact["x"] for hit in (left, jump, fixed, second)] == [-1, 0, 1 / (A + 1), 1 / A]
    assert [hit.x for hit in (left, jump, fixed, second)] == [-1, 0, 0.25, float(Rational(1, 3))]
    assert (fixed.exact["multiplier"], fixed.multiplier) == (-A, -3)
    assert (jump.exact["left"], jump.exact["right"]) == (-1, 1)
    assert math.isnan(jump.multiplier)


def test_sides_do_not_hang_on_floats() -> None:
    """Two edges 10^-30 apart are one float; each branch lies on its own side of them."""
    tiny = Rational(1, 10**30)
    pieces = [("r - 1", "x <= 0"), (f"r - {1 + tiny} - x", "x > 0")]
    diagram = bifurcation_diagram(PiecewiseLinearMap(pieces), "r", (0, 2), (1,))
    first, second = (next(p for p in diagram.points if p.exact["parameter"] == at)
                     for at in (1, 1 + tiny))  # fmt: skip
    assert first.parameter == second.parameter == 1.0
    for point in (first, second):
        left, right = diagram.sides(point.id)
        for name, side in ((left, -1), (right, 1)):
            for branch in map(diagram.branch, name):
                ends: Any = branch.exact["interval"]
                assert (ends.start + ends.end) / 2 * side > point.exact["parameter"] * side
    assert [len(side) for p in (first, second) for side in diagram.sides(p.id)] == [1, 1, 1, 1]
    (between,) = diagram.at(1 + tiny / 2)
    assert (between.exact["left"], between.exact["right"]) == (tiny / 2, -tiny / 2)
