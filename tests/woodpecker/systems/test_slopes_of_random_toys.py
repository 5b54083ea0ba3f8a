"""Slopes of random returns of random toys under both laws, against those of the kernel.

Both are derivatives along a path, of the general method by variational equations and of the kernel
by closed forms. They are the same to 1e-8 of 1 + the slope, but where the slope itself is not known
so well: a rounding of the start changes it by 2^-53 |x P''|, and a return has some hundred events
and steps, each with a rounding. Near a grazing P'' goes like the third power of the slope.
"""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from needs import NEEDS_HEYOKA, NEEDS_NUMBA

from studies.common.random_toys import random_toy
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker import return_map as kernel_map
from woodpecker.base.arrays import Floats

pytestmark = [NEEDS_HEYOKA, NEEDS_NUMBA, pytest.mark.slow]

CLOSE = 1e-8
ROUNDINGS = 1000  # of a return
BESIDE = 1e-9  # rad: where P'' is taken; a slope of 1e6 changes by a hundredth there


def compare(law: str, numbers: range) -> tuple[Floats, Floats]:
    """How far slopes are apart, over 1 + the slope; and what a rounding of x makes of it."""
    map_ = map_of(Toy(expansion_friction=law))
    names = {str(symbol) for symbol in map_.system.parameters}
    apart, rounding = list[float](), list[float]()
    for number in numbers:
        drawn = random_toy(number)
        toy = drawn.toy.replace(expansion_friction=law)
        own = map_.holding(**{key: value for key, value in asdict(toy).items() if key in names})
        for x in np.random.default_rng(number).uniform(*drawn.window, size=5):
            low, slope, high = kernel_map(toy, x + BESIDE * np.array([-1.0, 0.0, 1.0])).slope
            image = own.at(np.array([x]), own.p)
            assert np.isfinite(slope) == (not image.reason)
            if image.reason:
                continue
            size = 1.0 + abs(slope)
            apart.append(abs(image.jacobian[0, 0] - slope) / size)
            rounding.append(2.0**-53 * abs(x * (high - low) / (2.0 * BESIDE)) / size)
    return np.array(apart), np.array(rounding)


@pytest.mark.parametrize("law", ["summed", "separate"])
def test_slopes_of_random_toys(law: str) -> None:
    apart, _ = compare(law, range(10))
    assert apart.max() < CLOSE


@pytest.mark.nightly
@pytest.mark.parametrize("law", ["summed", "separate"])
def test_slopes_of_many_random_toys(law: str) -> None:
    """A thousand of each law; two of them nearly graze, with slopes of 5e3 and 7e5."""
    apart, rounding = compare(law, range(200))
    assert (apart < CLOSE).sum() >= len(apart) - 2
    assert (apart < np.maximum(CLOSE, ROUNDINGS * rounding)).all()
