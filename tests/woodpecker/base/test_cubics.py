"""Zeros of cubics that are known by values and slopes at 0 and 1."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from woodpecker.base.cubics import zero_of_cubic


def sizes(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers whose logarithms lie in an interval."""
    return st.floats(low, high).map(lambda power: 10.0**power)


@pytest.mark.nightly
@given(sizes(-3, 0), sizes(-18, -10), sizes(0, 8), sizes(0, 8), st.booleans(), st.booleans())
def test_a_cubic_between_different_signs_has_azero_of_cubic(
    before: float, after: float, rise: float, there: float, up: bool, down: bool
) -> None:
    """Also where it is so steep that rounding changes its sign at the far end."""
    rise, there = rise if up else -rise, there if down else -there
    assert 0.0 <= zero_of_cubic(before, -after, rise, there) <= 1.0


@pytest.mark.parametrize("coefficients", [(1.0, -3.0, 0.5, 0.7), (2.0, 1.0, -1.0, -4.0)])
def test_the_root_is_that_of_the_cubic(coefficients: tuple[float, ...]) -> None:
    """Against the eigenvalues of numpy; both are rounded in the last digits."""
    d, c, b, a = coefficients
    value = np.polynomial.Polynomial([d, c, b, a])
    scaled = value if value(0.0) * value(1.0) < 0.0 else value - 0.5 * (value(0.0) + value(1.0))
    slope = scaled.deriv()
    root = zero_of_cubic(
        float(scaled(0.0)), float(scaled(1.0)), float(slope(0.0)), float(slope(1.0))
    )
    expected = [z.real for z in scaled.roots() if abs(z.imag) < 1e-9 and 0.0 < z.real < 1.0]
    assert min(abs(root - each) for each in expected) < 1e-12


def test_of_an_infinite_slope_the_straight_line_is_taken() -> None:
    assert zero_of_cubic(3.0, -1.0, math.inf, -4.0) == 0.75
