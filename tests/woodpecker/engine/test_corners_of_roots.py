"""Jump crossings of P_2 that change their border where a root begins, against closed forms.

Beyond x = c(p) a piece begins with a root: D(x) = D(c) + sqrt(x - c)/8. Where D(c) passes a border
b(p) the crossing leaves c: its first point goes on at c + 64 (b - D(c))^2, from where D leads to b.
"""

import numpy as np
import pytest
import sympy
from sympy import Piecewise, Rational, sqrt, symbols

from pwmap.diagrams.diagram import Diagram, PointStatus
from woodpecker import Search, bifurcation_diagram, from_sympy
from woodpecker.base.arrays import Floats

x, p = symbols("x p", real=True)
SPAN, WINDOW = (-1.0, 1.0), (-3.0, 3.0)
C = p / 16 + Rational(1, 2)
B = -5 * p / 32 - Rational(13, 16)
AT_C = Rational(519, 512) * p + 9 * C**2 / 64 + Rational(7, 64)
CORNER = -0.812237861075325081388919678507  # D(c) = b, by mpmath


def searched(map_: Piecewise) -> Diagram:
    words = ["A", "B", "C", "D"][: len(map_.args)]
    return bifurcation_diagram(
        from_sympy(map_, x, p, words=words), "p", SPAN, (1, 2), WINDOW, search=Search(slices=15)
    )


def first_point(at: Floats) -> Floats:
    """Of the crossing near the corner."""
    c, b, d = (sympy.lambdify(p, each)(at) for each in (C, B, AT_C))
    beyond = np.maximum(b - d, 0.0)  # D(c) lies below b just for p below the corner
    found: Floats = c + 64.0 * beyond**2
    return found


@pytest.mark.slow
def test_a_crossing_goes_round_a_corner_onto_another_border() -> None:
    diagram = searched(
        Piecewise(
            (2 * p + Rational(9, 32) * x**2 + Rational(7, 16) * x, x < B),
            (-x * (1 - x) * (p / 4 + 1) / 2 + Rational(3, 32), x < Rational(1, 16) - 7 * p / 16),
            (Rational(3, 2) * p + x**2 / 2 + Rational(27, 32) * x, x < C),
            (AT_C + sqrt(x - C) / 8, True),
        )
    )
    assert not [point for point in diagram.points if point.status is PointStatus.OPEN]
    (branch,) = [each for each in diagram.branches if each.word == "D | A / D | B"]
    words = [stretch.word for stretch in branch.words]
    assert words == ["D | A / D | B", "C | A / D | B", "C | A / C | B", "B | B / C | B"]
    first, second = (branch.words[k].first for k in (1, 2))
    assert abs(branch.parameter[first] - CORNER) < 1e-7  # c is left like the square of the way
    near = slice(0, second)
    # x is known to some spacings, or to those of b over the slope of the root, 1/16 at most
    off = np.abs(branch.x[near] - first_point(branch.parameter[near]))
    assert off.max() < 1e-12


@pytest.mark.slow
def test_crossings_from_both_sides_of_a_corner_are_one() -> None:
    border = Rational(1, 2) - 7 * p / 32
    diagram = searched(
        Piecewise(
            (Rational(25, 64) * p * x + sympy.tanh(3 * x / 4) / 4 - Rational(3, 32), x < p / 2),
            (-Rational(25, 16) * p + Rational(15, 8) * x + Rational(3, 4), x < border),
            (
                Rational(25, 128) * p * border
                + sqrt(x - border) / 8
                + sympy.tanh(3 * border / 4) / 8
                - Rational(3, 64),
                True,
            ),
        )
    )
    assert not [point for point in diagram.points if point.status is PointStatus.OPEN]
