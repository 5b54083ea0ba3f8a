"""Iterates of maps as maps: values and derivatives by the chain rule, borders at preimages."""

import math

import pytest
from diagrams import JUMP, assert_curve, assert_graph, assert_places, chain, of_kind
from maps import A, continued, logistic, paper, two_lines

from woodpecker import Settings, Toy, ToyPieces
from woodpecker.maps import Iterate, check_derivatives

NEAR = 1e-15  # a few roundings at 1


def test_values_and_derivatives_of_the_logistic_maps_second_iterate() -> None:
    x, p = 0.3, 3.2
    y = p * x * (1.0 - x)
    image = Iterate(logistic(), 2).at(x, p)
    assert image.value == pytest.approx(p * y * (1.0 - y), abs=NEAR)
    assert image.slope == pytest.approx(p * (1.0 - 2.0 * y) * p * (1.0 - 2.0 * x), abs=NEAR)
    by_p = y * (1.0 - y) + p * (1.0 - 2.0 * y) * x * (1.0 - x)
    assert image.d_parameter == pytest.approx(by_p, abs=NEAR)
    assert image.piece.word == "S | S"


def test_margins_of_an_iterate_are_those_of_its_returns() -> None:
    """R then L of two lines: x >= 0, and -x/2 + p + 1 < 0."""
    x, p = 1.5, -0.5
    image = Iterate(two_lines(), 2).at(x, p)
    assert image.piece.word == "R | L"
    assert image.margins.tolist() == [1.5, 0.75 - 0.5]
    assert image.gradients.tolist() == [[1.0, 0.0], [0.5, -1.0]]
    causes = [image.piece.cause(code) for code in image.causes.tolist()]
    assert causes == ["x reaches the border, in return 1", "x reaches the border, in return 2"]
    beyond = image.piece.at(0.5, p)  # the same pieces, outside: the map takes R and R there
    assert beyond.value == pytest.approx(0.5 * (-0.25 + 0.5) - 0.5, abs=NEAR)
    assert beyond.margins.tolist() == [0.5, -0.25]


def test_point_a_of_the_papers_second_iterate() -> None:
    """0 and r/a, the ends of its piece R | R, meet in A: the jump at r/a starts there."""
    settings = Settings(span=(-1.0, 3.0))
    diagram = continued(Iterate(paper(), 2), 1.0 / (1.0 + A), 1.0, settings)
    assert_graph(diagram, chain("EP F FF J EP"))
    assert_places(diagram, {"FF": [(0.0, 0.0)], "EP": [(3.0, 3.0 / (1.0 + A)), (3.0, 3.0 / A)]})
    (jump,) = of_kind(diagram, JUMP)
    assert_curve(jump, lambda r: r / A)


def test_an_orbit_that_is_lost_says_why() -> None:
    map_ = Iterate(ToyPieces(Toy(pole=0.015)), 3)  # the pole ends within the first return
    image = map_.at(-0.53, 0.5)
    assert math.isnan(image.value)
    assert image.reason == map_.map.at(-0.53, 0.5).reason != ""
    assert image.piece.at(-0.53, 0.5).reason == image.reason


@pytest.mark.slow
def test_derivatives_of_the_toys_iterates() -> None:
    for order in (2, 3):
        check_derivatives(Iterate(ToyPieces(Toy()), order), [(-0.53, 0.5), (-0.95, 0.125)])
