"""The stick-slip oscillator on a belt against its closed form."""

import math

import numpy as np
import pytest
from needs import NEEDS_HEYOKA

from studies.systems import belt
from woodpecker.systems import shoot

BACKENDS = [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("v", "d"), [(0.3, 0.1), (0.5, 0.4)])
@pytest.mark.slow
def test_stick_slip_is_that_of_the_closed_form(v: float, d: float, backend: str) -> None:
    """From a guess that sticks, too; the belt's speed is a parameter with derivatives."""
    map_ = belt.map_of("v", backend=backend).holding(d=d)
    exact, slope = belt.lowest(v, 1.0, d), belt.lowest(1.0, 0.0, d)
    cycle = shoot(map_, [exact + 0.05], p=[v])
    assert cycle.word == "J1 S1"
    assert cycle.x[0, 0] == pytest.approx(exact, abs=1e-10)
    assert abs(cycle.multipliers[0]) < 1e-10  # it forgets while it sticks
    image = map_.at(cycle.x[0], cycle.p)
    assert image.jacobian[0, 1] == pytest.approx(slope, abs=1e-9)


def test_without_sticking_it_spirals_off() -> None:
    """Around the steady sliding, by exp(pi d/sqrt(1 - d**2/4)) in each turn."""
    d = belt.VALUES[belt.D]
    image = belt.map_of(backend="scipy").at(np.array([0.8]), np.zeros(0))
    assert image.piece.word == ""
    exact = math.exp(math.pi * d / math.sqrt(1.0 - 0.25 * d * d))
    assert image.jacobian[0, 0] == pytest.approx(exact, abs=1e-10)
    steady = 1.0 - d * belt.VALUES[belt.BELT]
    assert image.value[0] == pytest.approx(steady + exact * (0.8 - steady), abs=1e-10)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_the_study_of_the_belt() -> None:
    assert max(belt.main(fast=True).values()) < 1e-10
