"""Pieces that end in a root, a + b h^s + c h at a distance h from their border, of any power."""

from typing import Any

import numpy as np
import pytest
from sympy import Expr, Piecewise, Rational, log, symbols

from woodpecker import Search, bifurcation_diagram, from_sympy
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.formulas import expression_map
from woodpecker.engine.maps import root_of
from woodpecker.search.connected import connected

x, y, p = symbols("x y p", real=True)
POWERS = [Rational(k, 20) for k in (2, 3, 5, 9, 10, 11, 13, 15, 18, 19)]


@pytest.mark.parametrize("power", POWERS, ids=str)
@pytest.mark.parametrize("linear", [0, 1, -3])
def test_value_and_power_of_a_root_are_known_to_rounding(power: Rational, linear: int) -> None:
    h = p / 8 + Rational(3, 7) - x
    map_ = expression_map(
        (x,), (p,), {"L": (p / 2 + 3 * h**power / 4 + linear * h,)}, {"L": {"0": h}}
    )
    at = 0.3713
    border = np.array([at / 8 + 3 / 7])
    for way in ([-1.0, 0.0], [-1.0, 0.7]):
        root = root_of(map_.pieces[0], border, np.array([at]), np.array(way))
        assert root is not None
        assert root.exponent == pytest.approx(float(power), abs=1e-12)
        assert root.value[0] == pytest.approx(at / 2, abs=4e-15)  # some ten spacings


H = Rational(3, 7) - x  # the distance from a border


def root_at_border(value: Expr) -> Any:
    """What is told of a piece that ends there."""
    map_ = expression_map((x,), (p,), {"L": (value,)}, {"L": {"0": H}})
    return root_of(map_.pieces[0], np.array([3 / 7]), np.zeros(1), np.array([-1.0, 0.0]))


@pytest.mark.parametrize("bend", [10**6, 2 * 10**7])
def test_a_steep_root_that_bends_is_looked_at_closer(bend: int) -> None:
    """1/2 - 500 h^(1/2) (1 + K h): at h = 2^-33 the next term is K / 2^33 of the first."""
    root = root_at_border(Rational(1, 2) - 500 * H ** Rational(1, 2) * (1 + bend * H))
    assert root.exponent == 0.5
    # Values closer than 1e-7 are one. Rounding of h = 2^-41 leaves 2^-14 of it, and 1e-8 of values.
    # Where only h = 2^-33 was looked at the next term left errors of 9e-6 and 2e-4.
    assert root.value[0] == pytest.approx(0.5, abs=1e-7)


@pytest.mark.parametrize(
    "value",
    [
        # A root of h + 2^-34 looks like one at h = 2^-33, and does not closer to h = 0.
        Rational(1, 2) - 500 * (H + Rational(1, 2**34)) ** Rational(1, 2),
        # log h falls for ever, and so does h^(1/500) by all that doubles tell: its limit is -500
        # off. Returns of the toy that end in an endless fall are like that; a limit of -114 was
        # made of -3.
        log(H),
        500 * H ** Rational(1, 500),
        p + 50 * H + H**2,
    ],
    ids=["root at another border", "logarithm", "like a logarithm", "smooth"],
)
def test_what_is_no_root(value: Expr) -> None:
    assert root_at_border(value) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("border", "left", "right", "power", "exact"),
    [  # left - h^s/8 below the border, right above it: cycles end where a limit lies on the border
        (Rational(1, 8) - p / 4, p - 1, p + Rational(5, 8), Rational(13, 20), [0.9, -0.4]),
        (
            Rational(1, 4) - p / 8,
            p - Rational(7, 8),
            p - Rational(3, 4),
            Rational(7, 10),
            [1, 8 / 9],
        ),
        (Rational(1, 8), p - Rational(1, 8), p + Rational(1, 4), Rational(1, 10), [0.25, -0.125]),
    ],
)
def test_cycles_and_jumps_end_at_roots_where_they_are_said_to(
    border: Expr, left: Expr, right: Expr, power: Rational, exact: list[float]
) -> None:
    formula = Piecewise((left - (border - x) ** power / 8, x < border), (right, True))
    diagram = bifurcation_diagram(
        from_sympy(formula, x, p), "p", (-1.5, 1.5), (1,), (-3, 3), search=Search(slices=3)
    )
    met = [point for point in diagram.points if point.kind.value in ("BC", "FF")]
    assert sorted(point.parameter for point in met) == pytest.approx(sorted(exact), abs=1e-13)
    for point in met:
        assert min(abs(point.parameter - each) for each in exact) <= point.precision


@pytest.mark.nightly
def test_a_limit_on_its_border_for_all_parameters_is_no_error() -> None:
    """There rounding decides on which side of the border it lies."""
    left, right = p * (-3 * x / 2 - Rational(3, 4)) - Rational(1, 4), (x + Rational(1, 2))
    formula = Piecewise(
        (left, x < -Rational(1, 2)), (-11 * p * right ** Rational(1, 4) / 8 - Rational(1, 2), True)
    )
    diagram = bifurcation_diagram(
        from_sympy(formula, x, p), "p", (-1.5, 1.5), (1,), (-3, 3), search=Search(slices=3)
    )
    assert diagram.branches


BESIDE_ROOTS = CurveSettings(spans=((-1.5, 1.5),), window=((-4.0, 4.0), (-4.0, 4.0)))


@pytest.mark.slow
@pytest.mark.parametrize("power", [Rational(1, 4), Rational(1, 2), Rational(3, 4)], ids=str)
def test_jumps_of_the_plane_cross_beside_a_root(power: Rational) -> None:
    """At x = c both limits are known: c = (1 - s) (p/3 - 7/8) + s p, y = (1 - s) c/2 + 2 s/5."""
    border = -p / 7 + Rational(1, 9)
    h = border - x
    pieces = {
        "L": (p / 3 - Rational(7, 8) - 5 * h**power / 8, y / 2 + x / 4),
        "R": (p, y / 2 + Rational(1, 5)),
    }
    map_ = expression_map((x, y), (p,), pieces, {"L": {"0": h}, "R": {"0": -h}})
    found = connected(
        map_, [0.9, 0.4], [0.9], BESIDE_ROOTS, orders=(1,), names=("p", "x", "y")
    ).diagram
    assert not [point for point in found.points if point.status.value == "open"]
    (jump,) = (branch for branch in found.branches if branch.kind.value == "jump")
    at = jump.parameter
    assert at[[0, -1]] == pytest.approx([7 / 72, 1.5], abs=1e-15)
    c, inner = -at / 7 + 1 / 9, at / 3 - 7 / 8
    s = (c - inner) / (at - inner)
    assert jump.columns["y"] == pytest.approx((1 - s) * c / 2 + 2 * s / 5, abs=1e-14)
