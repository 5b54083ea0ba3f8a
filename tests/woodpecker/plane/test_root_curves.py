"""Curves over two parameters of cycles on a border with a root, such as that of a grazing."""

import numpy as np
import pytest
from planes import SETTINGS, P, Q, X
from sympy import Piecewise, Rational, sqrt

from pwmap import PointKind
from woodpecker import (
    Settings,
    Toy,
    ToyPieces,
    bifurcation_diagram,
    continuation,
    curve_in_two,
    shoot,
)
from woodpecker.plane import Curve, PlaneKind, family_from_sympy, graph_of_curves

B = Rational(3, 10) * Q  # a border that moves: no double lies on it exactly


def test_the_border_of_a_square_root_may_move() -> None:
    """x = p - sqrt(x - 3 q/10) lies on its border x = 3 q/10 where p = 3 q/10."""
    family = family_from_sympy(
        Piecewise((P - 2 + X / 4, X < B), (P - sqrt(X - B), True)), X, (P, Q), words=["L", "R"]
    )
    diagram = bifurcation_diagram(family.over(0, (0.0, 0.3)), "p", (-1.0, 1.0), (1,), (-3.0, 3.0))
    (point,) = [each for each in diagram.points if each.kind is PointKind.FF]
    curve = curve_in_two(
        family, point, ("p", "q"), ((-1.0, 1.0), (0.1, 0.9)), value=0.3, settings=SETTINGS
    )
    p, q = curve.values.T
    assert np.abs(p - 0.3 * q).max() < 1e-15  # rounding; the root makes 4e-9 of it
    assert q[[0, -1]].tolist() == [0.1, 0.9]
    assert len(curve) < 100  # a straight line: steps as long as allowed
    assert set(curve.codes) == {PointKind.FF}


def test_codes_along_a_curve_are_those_of_its_first_point() -> None:
    """P_2 has a jump at every point of a cycle on a border: its limits differ, and so may codes."""
    right = P - Rational(1, 4) + 2 * X / 5 + 9 * X**2 / 10 - 3 * sqrt(X - B) / 10
    family = family_from_sympy(
        Piecewise((P + 6 * X / 5, X < B), (right, True)), X, (P, Q), words=["L", "R"]
    )
    over_p = family.over(0, (0.0, 0.2))
    diagram = bifurcation_diagram(over_p, "p", (0.1, 0.6), (2,), (-1.0, 1.0))
    points = [each for each in diagram.points if each.kind in (PointKind.BC, PointKind.FF)]
    cycles = {each.parameter: set[PointKind]() for each in points}
    for point in points:
        curve = curve_in_two(
            family, point, ("p", "q"), ((0.1, 0.6), (0.2, 0.201)), value=0.2, settings=SETTINGS
        )
        assert (curve.codes[0], curve.notes[0]) == (point.kind, point.note)
        cycles[point.parameter].add(point.kind)
    assert {PointKind.BC, PointKind.FF} in cycles.values()  # one cycle with both


def test_a_cycle_with_an_infinite_multiplier_folds_and_flips() -> None:
    """A fold into a crossing is an FF where the multiplier exceeds 1, also where no double is.

    P_2 jumps at both points of the cycle: it folds at the border itself, and persists at the other.
    """
    x, border = X, 283 * Q / 1000 + Rational(19, 1000)
    left = P - 4 * x / 1250 + 13 * x**3 / 200 - 213 * x**2 / 500 + 123 * x / 500
    middle = (
        P - Rational(241, 1000) - 61 * x**3 / 200 + 861 * x**2 / 1000 + 3769 * x / 10000
        - 3 * sqrt(x - border) / 10
    )  # fmt: skip
    right = P - Rational(3827, 10000) + 33 * x**3 / 100 - 61 * x**2 / 250 + 15241 * x / 10000
    formula = Piecewise((left, x <= border), (middle, x < Rational(1109, 10000)), (right, True))
    over_p = family_from_sympy(formula, x, (P, Q), words=["L", "C", "R"]).over(0, (0.0, 0.1))
    diagram = bifurcation_diagram(over_p, "p", (0.3, 0.32), (2,), (-2.5, 2.5))
    found = [each for each in diagram.points if each.kind in (PointKind.BC, PointKind.FF)]
    (flip, other) = sorted(found, key=lambda each: each.x)
    assert (flip.kind, flip.note) == (PointKind.FF, "fold")
    assert (other.kind, other.note) == (PointKind.BC, "persistence")
    assert flip.x == pytest.approx(0.0473, abs=1e-15)


@pytest.mark.slow
def test_a_grazing_of_the_toy_may_change_its_kind_along_a_curve() -> None:
    """Where the lower sleeve only just leaves, slopes grow without bound, or change like a root."""
    toy = Toy(r_m=0.003193)
    diagram = continuation(toy, shoot(toy, -0.53), "eps_n1", span=(0.5, 0.8))
    (point,) = [each for each in diagram.points if each.parameter == pytest.approx(0.74848, 1e-5)]
    curve = curve_in_two(toy, point, ("eps_n1", "r_m"), ((0.4, 0.8), (0.0031, 0.003193)))
    assert all(end.status.value == "located" for end in curve.ends)
    assert len(curve) < 100  # with gradients that are rounding errors, twenty times as many


@pytest.mark.slow
def test_flips_pass_a_border_that_they_touch_over_a_small_moment_of_inertia() -> None:
    """With j_m = 5e-9 measured against 1, margins with steep slopes seemed to vanish there.

    The curve ends where the diagram of the other toy has its flip, up to rounding.
    """
    toy = Toy(eps_n1=0.7)
    toys = toy, toy.replace(j_m=4.85e-9)
    (point,), (there,) = (
        [
            each
            for each in continuation(one, shoot(one, -0.516), "eps_n1", span=(0.6, 0.75)).points
            if each.kind is PointKind.PD
        ]
        for one in toys
    )
    curve = curve_in_two(toy, point, ("eps_n1", "j_m"), ((0.5, 0.8), (4.85e-9, 5e-9)))
    ends = sorted(curve.values[[0, -1]].tolist(), key=lambda each: each[1])
    assert ends[0] == pytest.approx([there.parameter, 4.85e-9], rel=1e-13)
    assert ends[1] == pytest.approx([point.parameter, 5e-9], rel=1e-13)


@pytest.mark.nightly
def test_all_collisions_of_a_toy_with_roots_can_be_followed() -> None:
    """At six of ten the lower sleeve only just leaves, where slopes may grow without bound.

    Three were given up: two as their limit changed by 2e-13 with the distance at which a root was
    fitted, one as the impact after the grazing was taken, 2e-5 off. Where the border is rounded by
    1e-16 a square root is off by 1e-8 times its factor, and images by less than 1e-7.
    """
    toy, window = Toy(r_m=0.003193), (-1.05, -0.45)
    diagram = bifurcation_diagram(toy, "eps_n1", (0.012, 1.0), (1,), window)
    points = [each for each in diagram.points if each.kind is PointKind.BC]
    assert len(points) == 10
    for point in points:
        curve = curve_in_two(
            toy, point, ("eps_n1", "r_m"), ((0.012, 1.0), (0.0031, 0.003193)),
            settings=Settings(window=window),
        )  # fmt: skip
        assert all(end.status.value == "located" for end in curve.ends)
        for (eps_n1, r_m), x in zip(curve.values.tolist(), curve.x[:, 0].tolist(), strict=True):
            map_ = ToyPieces(toy.replace(r_m=r_m))
            images = [map_.at(x + beside, eps_n1).value for beside in (-1e-12, 0.0, 1e-12)]
            assert min(abs(value - x) for value in images) < 1e-7


@pytest.mark.parametrize("slope", [Rational(1, 2), Rational(-17, 10)])
def test_folds_and_flips_end_where_the_root_at_a_border_vanishes(slope: Rational) -> None:
    """Of a x + p and, for x > 0, b sqrt(x) - x^2 with b = q - p - 1/10: at p = 0, q = 1/10.

    The multiplier a + b/(2 sqrt(x)) - 2 x is 1 or -1 at x of the order b^2, which goes to zero.
    """
    beyond = slope * X + P + (Q - P - Rational(1, 10)) * sqrt(X) - X**2
    family = family_from_sympy(Piecewise((slope * X + P, X < 0), (beyond, True)), X, (P, Q))
    curves, spans = list[Curve](), ((-1.0, 1.0), (-0.5, 0.7))
    for q in (0.6, -0.4):
        over_p = family.over(0, (0.0, q))
        diagram = bifurcation_diagram(over_p, "p", spans[0], (1,), (-0.5, 0.5))
        curves += [
            curve_in_two(family, point, ("p", "q"), spans, value=q, settings=SETTINGS)
            for point in diagram.points
            if point.kind in (PointKind.BC, PointKind.LP, PointKind.PD)
        ]
    assert {curve.kind for curve in curves} == {PointKind.BC, PointKind.LP, PointKind.PD}
    for curve in curves:
        (grazing,) = [each for each in curve.points if each.kind is PlaneKind.DEGENERATE_GRAZING]
        assert grazing.values[0] == pytest.approx(0.0, abs=1e-12)
        assert abs(grazing.values[1] - 0.1) < grazing.precision[1] < 1e-8
        assert (grazing in curve.ends) == (curve.kind is not PointKind.BC)
    nodes = graph_of_curves(curves).nodes(data="kind")
    assert [kind for _, kind in nodes].count("DG") == 1


@pytest.mark.slow
def test_folds_and_flips_end_where_they_touch_the_end_of_a_power() -> None:
    """p - x/2 and, for x > 0, p + (q - 2) x + x^(3/2): at x = 0 the slopes are -1/2 and q - 2.

    Flips end there with q = 1; folds of order 2 with both points at 0 and q = 0, or, of the right
    piece alone, with the points 0 and p, the slopes q - 2 and q - 1/2, and p = 1, q = 0.
    """
    beyond = P + (Q - 2) * X + X ** Rational(3, 2)
    family = family_from_sympy(Piecewise((P - X / 2, X < 0), (beyond, True)), X, (P, Q))
    expected = {(0.3, PointKind.PD): (0.0, 1.0), (0.3, PointKind.LP): (1.0, 0.0),
                (-0.3, PointKind.PD): (0.0, 1.0), (-0.3, PointKind.LP): (0.0, 0.0)}  # fmt: skip
    found = set[tuple[float, PointKind]]()
    for q in (0.3, -0.3):
        over_p = family.over(0, (0.0, q))
        diagram = bifurcation_diagram(over_p, "p", (-2.0, 2.0), (1, 2), (-3.0, 3.0))
        for point in diagram.points:
            if point.kind not in (PointKind.PD, PointKind.LP):
                continue
            curve = curve_in_two(
                family, point, ("p", "q"), ((-2.0, 2.0), (-1.0, 2.0)), value=q, settings=SETTINGS
            )
            (end,) = [each for each in curve.ends if each.kind.value in ("LPB", "PDB")]
            assert end.kind.value == f"{point.kind}B"
            off = np.abs(np.subtract(end.values, expected[q, point.kind]))
            assert off.max() < 1e-10
            assert all(off <= end.precision)
            assert max(end.precision) < 1e-4
            assert all(each.status.value == "located" for each in curve.points)
            found.add((q, point.kind))
    assert found == set(expected)


def test_folds_turn_sharply_beside_a_border() -> None:
    """Slopes q - 100 x - 5e-7/sqrt(x) are 1 at q with a minimum of radius 6e-9 at x = 1.8e-6.

    At the end beside the border the slope changes by 2e6 per unit of x, which is known to 1e-15.
    """
    beyond = P + Q * X - 50 * X**2 - sqrt(X) / 10**6
    family = family_from_sympy(Piecewise((P - X / 2, X < 0), (beyond, True)), X, (P, Q))
    over_p = family.over(0, (0.0, 1.005))
    diagram = bifurcation_diagram(over_p, "p", (-1.0, 1.0), (1,), (-0.5, 0.5))
    folds = [each for each in diagram.points if each.kind is PointKind.LP]
    spans, settings = ((-1.0, 1.0), (0.9, 1.01)), Settings(window=(-0.5, 0.5))
    for fold in folds:
        curve = curve_in_two(family, fold, ("p", "q"), spans, value=1.005, settings=settings)
        assert [end.cause for end in curve.ends] == ["end of the span of q"] * 2
        x, q = curve.x[:, 0], curve.values[:, 1]
        assert q == pytest.approx(1.0 + 100.0 * x + 5e-7 / np.sqrt(x), abs=2e-9)
        assert sorted(x[[0, -1]]) == pytest.approx([2.50013e-9, 9.94987e-5], rel=1e-5)
    assert len(folds) == 2


def test_a_cube_root_of_slopes_is_no_square_root() -> None:
    """With q x^(4/3) the slope changes like a cube root at a border, which keeps its kink."""
    beyond = P - 2 * X + Q * X ** Rational(4, 3)
    family = family_from_sympy(Piecewise((X / 2 + P, X < 0), (beyond, True)), X, (P, Q))
    diagram = bifurcation_diagram(family.over(0, (0.0, 0.5)), "p", (-1.0, 1.0), (1,), (-0.5, 0.5))
    (border,) = [each for each in diagram.points if each.kind is PointKind.BC]
    assert border.parameter == pytest.approx(0.0, abs=1e-12)
    spans = (-1.0, 1.0), (-0.7, 0.8)
    curve = curve_in_two(family, border, ("p", "q"), spans, value=0.5, settings=SETTINGS)
    assert [str(point.kind) for point in curve.points] == ["EP", "EP"]
    assert set(curve.notes) == {"persistence"}
