"""Where a gap hardly falls when it closes three of its roots meet: roots and margins stay exact."""

import math

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from woodpecker import Settings, Toy, ToyPieces, return_map, slices_at
from woodpecker.simulation.roots import root_at_inflection


@pytest.mark.parametrize("distance", [1e-3, 1e-9, 1e-15, 0.0, -1e-15, -1e-9, -1e-3])
def test_a_root_near_a_triple_one(distance: float) -> None:
    """f = f_0 + f_3 (t - sin t) with f_0 = 2 pi + distance: all derivatives vanish at 2 pi.

    With t = 2 pi + s it is s - sin s = distance; s is known from its series for small distances,
    and its residual is rounding: 4 spacings of 2 pi for the larger ones.
    """
    f3 = -1.0
    t = root_at_inflection(2.0 * math.pi + distance, 0.0, 0.0, f3, -1.0, 1.0, 2.0 * math.pi + 0.05)
    s = t - 2.0 * math.pi
    given = (2.0 * math.pi + distance) - 2.0 * math.pi  # what is left of it in a double
    assert s == pytest.approx(
        math.copysign(abs(6.0 * given) ** (1.0 / 3.0), given), rel=2e-3, abs=3e-5
    )
    assert s - math.sin(s) == pytest.approx(given, abs=4e-15)


@pytest.mark.nightly
@NEEDS_NUMBA
@pytest.mark.slow
@pytest.mark.parametrize(("eps_n1", "number"), [(0.3, 7), (0.38, 4), (0.5, 3)])
def test_no_fixed_point_hides_beside_such_a_border(eps_n1: float, number: int) -> None:
    """All that tabulation shows: changes of sign of P_1(x) - x, each a fixed point or a jump.

    A fixed point of slope m leaves a residual of some 20 spacings of doubles times m.
    """
    toy = Toy(eps_n1=eps_n1)
    settings = Settings(window=(-2.5, -0.24))
    (found,) = slices_at(ToyPieces(toy), eps_n1, (1,), settings)
    x = np.sort([float(orbit.x[0]) for orbit in found.cycles])
    assert len(x) == number
    there = return_map(toy, x)
    assert np.all(np.abs(there.phi_s - x) <= 1e-14 * (1.0 + np.abs(there.slope)))
    grid = np.linspace(-2.5, -0.24, 100_001)
    gap = return_map(toy, grid).phi_s - grid
    places = np.array([*x, *(jump.x for jump in found.jumps)])
    for k in np.flatnonzero(gap[1:] * gap[:-1] < 0.0):
        assert np.any((grid[k] <= places) & (places <= grid[k + 1]))
