"""Cycles that meet a jump where a root begins: the same place and kind from whichever branch.

On the side of the root a value is known to the root of what the place is: its limit says where the
cycle meets the border.
"""

import pytest
from scipy.optimize import brentq
from sympy import Expr, Piecewise, Rational, sqrt, symbols, tanh

from woodpecker import Search, Settings, bifurcation_diagram, continuation, from_sympy, shoot

x, p = symbols("x p", real=True)
SPAN, WINDOW = (-1.0, 1.0), (-3.0, 3.0)
ROOTED = Piecewise(
    (11 * p / 16 - 17 * x / 16, x < -Rational(11, 8)),
    (-2 * p + 19 * x**2 / 32 + x / 16, x < -p / 2 - Rational(1, 8)),
    (-27 * p / 16 + x / 16 + Rational(27, 16), x < Rational(19, 16)),
    (11 * p / 32 + sqrt(x - Rational(19, 16)) / 4 - Rational(323, 512), True),
)


def meets(at: float) -> float:
    """How far B(D(19/16)) lies from 19/16, without the root."""
    y = 11.0 * at / 32.0 - 323.0 / 512.0
    return float(-2.0 * at + 19.0 * y**2 / 32.0 + y / 16.0 - 19.0 / 16.0)


@pytest.mark.nightly
def test_a_collision_is_the_same_from_a_cycle_and_from_a_slice() -> None:
    place = brentq(meets, -0.5, -0.4, xtol=1e-16)
    map_ = from_sympy(ROOTED, x, p, words=["A", "B", "C", "D"])
    cycle = shoot(map_, 1.1925, p=-0.445, order=2)
    assert cycle.word in ("D | B", "B | D")
    whole = bifurcation_diagram(map_, "p", SPAN, (1, 2), WINDOW, search=Search(slices=15))
    own = continuation(map_, cycle, "p", SPAN, orders=(1, 2), settings=Settings(window=WINDOW))
    for diagram in (whole, own):
        met = [each for each in diagram.points if abs(each.parameter - place) < 1e-6]
        assert [each.kind.value for each in met] == ["FF", "FF"]
        for each in met:
            assert abs(each.parameter - place) < 1e-14  # some spacings
        assert sorted(each.x for each in met)[1] == pytest.approx(1.1875, abs=1e-14)


def flipping() -> Expr:
    """A branch that flips at p = -0.98156, a step before the end of the span."""
    first = -Rational(5, 16) * p * x - Rational(13, 16) * tanh(15 * x / 8) - Rational(29, 64)
    return Piecewise(
        (first, x < Rational(1, 2) - 5 * p / 32),
        (Rational(31, 64) * p * x - Rational(21, 16) * tanh(25 * x / 16) + Rational(7, 64), True),
    )


@pytest.mark.parametrize("at", [-0.9, 0.0, 0.1])
def test_what_lies_between_a_flip_and_the_end_of_the_span_is_drawn(at: float) -> None:
    """A step to the end of the span passes over the flip, or not."""
    map_ = from_sympy(flipping(), x, p)
    start = shoot(map_, -0.19, p=at)
    diagram = continuation(map_, start, "p", SPAN, settings=Settings(window=WINDOW))
    ends = sorted(float(q.parameter) for q in diagram.points if q.kind.value == "EP")
    assert ends == [-1.0, 1.0]
    (flip,) = [q for q in diagram.points if q.kind.value == "PD"]
    assert len(flip.branches) == 2
