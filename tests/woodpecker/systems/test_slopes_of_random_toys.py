"""Slopes of random returns of random toys under both laws, against those of the kernel.

Both are derivatives along a path, of the general method by variational equations and of the kernel
by closed forms. They are the same to 1e-8 of 1 + the slope. Nearly grazing motions decide: a
rounding of the start changes their slopes of 5e3 and 7e5 by 2e-10 and 5e-10, so some twenty such
roundings may come together before the grazing. If closed contacts drift, there are a hundred.
"""

from dataclasses import asdict

import numpy as np
import pytest
from needs import NEEDS_HEYOKA, NEEDS_NUMBA

from studies.common.random_toys import random_toy
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker import return_map as kernel_map

pytestmark = [NEEDS_HEYOKA, NEEDS_NUMBA, pytest.mark.nightly, pytest.mark.slow]

CLOSE = 1e-8


def apart(law: str, numbers: range) -> list[float]:
    """How far slopes are apart, over 1 + the slope."""
    map_, found = map_of(Toy(expansion_friction=law)), list[float]()
    names = {str(symbol) for symbol in map_.system.parameters}
    for number in numbers:
        drawn = random_toy(number)
        toy = drawn.toy.replace(expansion_friction=law)
        own = map_.holding(**{key: value for key, value in asdict(toy).items() if key in names})
        points = np.random.default_rng(number).uniform(*drawn.window, size=5)
        for x, slope in zip(points, kernel_map(toy, points).slope, strict=True):
            image = own.at(np.array([x]), own.p)
            assert np.isfinite(slope) == (not image.reason)
            if not image.reason:
                found.append(abs(image.jacobian[0, 0] - slope) / (1.0 + abs(slope)))
    return found


@pytest.mark.parametrize("law", ["summed", "separate"])
def test_slopes_of_random_toys(law: str) -> None:
    """Number 11 nearly grazes, with a slope of 5e3; a thousand points of each law."""
    assert max(apart(law, range(200))) < CLOSE
