"""Edges of what can be followed and found: roots, corners, pairs close together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagrams import assert_graph, assert_places, chain
from maps import continued, grazing, skew_tent
from needs import NEEDS_NUMBA
from test_jumps import divided, jump_at, places
from test_partition import fixed, rising, shown

from woodpecker import Settings, Toy, ToyPieces, slices_at


def test_a_grazing_met_from_its_root() -> None:
    """The branch x = s^2, s = sqrt(1 + 2 p) - 1, comes down to the grazing at (0, 0)."""
    start = (math.sqrt(2.0) - 1.0) ** 2
    diagram = continued(grazing(-1.0), start, 0.5, Settings(span=(-1.0, 1.0)))
    for branch in diagram.branches:
        for x, p in zip(branch.x.tolist(), branch.parameter.tolist(), strict=True):
            exact = (math.sqrt(1.0 + 2.0 * p) - 1.0) ** 2 if p >= 0.0 else 2.0 * p
            assert x == pytest.approx(exact, abs=1e-8)
    assert_graph(diagram, chain("EP F BC F PD F EP"))


@pytest.mark.slow
def test_a_grazing_that_folds_met_from_its_root() -> None:
    start = (1.0 + math.sqrt(0.5)) ** 2
    diagram = continued(grazing(1.0), start, -0.25, Settings(span=(-1.0, 1.0)))
    assert_graph(diagram, chain("EP F BC F LP F EP"))
    end = (1.0 + math.sqrt(3.0)) ** 2
    assert_places(
        diagram, {"BC": [(0.0, 0.0)], "LP": [(-0.5, 1.0)], "EP": [(-1.0, -2.0), (1.0, end)]}
    )


def test_a_branch_has_its_own_multiplier_at_its_end() -> None:
    """L has slope 1/2 up to the corner, from whichever side the corner was met."""
    diagram = continued(skew_tent(0.5, -1.5), 0.04, 0.1, Settings(span=(-1.0, 1.0)))
    (left,) = [branch for branch in diagram.branches if branch.word == "L"]
    assert set(left.multiplier.tolist()) == {0.5}


def test_a_margin_in_the_parameter_alone() -> None:
    """The name of the right piece changes at p = -0.6, for every x: no step in x leads beyond."""
    curve = jump_at(divided(0.0), 0.0, -0.3)
    assert places(curve) == pytest.approx(np.array([[-1.0, 0.0], [0.0, 0.0]]), abs=1e-13)
    diagram = continued(divided(0.0), 0.9, 0.35, Settings(span=(-2.0, 2.0)))
    assert_graph(diagram, chain("EP F BC J BC F EP"))


@pytest.mark.parametrize("apart", [1e-3, 1e-5])
def test_two_fixed_points_close_together_in_one_piece(apart: float) -> None:
    """P(x) - x dips below zero between two samples; a root is off by rounding over its slope."""
    roots = (-0.5, 1 / 3, 1 / 3 + apart)
    assert fixed(shown(rising(*roots), 1, (-1.0, 1.0))) == pytest.approx(roots, abs=1e-15 / apart)


@pytest.mark.nightly
@NEEDS_NUMBA
def test_a_slice_of_the_toy_warns_of_nothing() -> None:
    """Pieces begin with infinite slopes there."""
    slices_at(ToyPieces(Toy()), 0.23, (1, 2), Settings(window=(-2.5, -0.24)))


@pytest.mark.slow
@NEEDS_NUMBA
def test_a_jump_of_the_second_iterate_beside_a_minimum() -> None:
    """eps_N1 = 0.36: P_2 jumps from -0.485 to -1.698 at a preimage of -0.88477 beside a minimum."""
    (second,) = slices_at(ToyPieces(Toy()), 0.36, (2,), Settings(window=(-2.5, -0.24)))
    assert min(abs(jump.x + 1.4590440994) for jump in second.jumps) < 1e-7
