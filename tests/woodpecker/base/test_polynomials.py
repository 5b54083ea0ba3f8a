"""Roots of polynomials over [0, 1]: of products of known factors, and of random ones."""

import math

import numpy as np
import pytest

from woodpecker.base.arrays import Floats
from woodpecker.base.cubics import hermite_root
from woodpecker.base.polynomials import (
    WHOLE,
    bernstein,
    evaluated,
    fall,
    first_series_to_cross,
    roots,
)


def both(c: Floats) -> tuple[Floats, Floats]:
    return c, c @ bernstein(len(c))[WHOLE]


def made(*zeros: float, sign: float = 1.0) -> Floats:
    """Coefficients, lowest first, of a polynomial with some zeros."""
    return sign * np.poly(zeros)[::-1].copy()


def test_a_minimum_near_zero_is_a_fall_just_if_it_lies_below() -> None:
    """(s - 0.3)^2 -+ 1e-10 has its roots, or none, at 0.3 -+ 1e-5."""
    c, lift = made(0.3, 0.3), np.array([1e-10, 0.0, 0.0])
    assert fall(*both(c + lift), False, bernstein(3)) == math.inf
    # rounding of c moves a root by eps over the slope of 2e-5
    assert fall(*both(c - lift), False, bernstein(3)) == pytest.approx(0.3 - 1e-5, abs=1e-11)


def test_no_fall() -> None:
    assert fall(*both(made(1.5, -0.5, sign=-1.0)), False, bernstein(3)) == math.inf
    assert fall(*both(np.full(4, 1e-25)), False, bernstein(4)) == math.inf


@pytest.mark.parametrize(("at_once", "expected"), [(True, -1e-9), (False, math.inf)])
def test_what_begins_below_zero_falls_at_once_only_if_asked(at_once: bool, expected: float) -> None:
    c = np.array([-1e-9, -1.0, 0.25])
    assert fall(*both(c), at_once, bernstein(3)) == pytest.approx(expected, abs=1e-17)


def test_random_polynomials_agree_with_eigenvalues() -> None:
    """The roots of a companion matrix are as exact as its condition: the simple ones to 1e-9."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        c = rng.normal(size=12)
        every = np.roots(c[::-1])
        real = np.sort(every.real[np.abs(every.imag) < 1e-12])
        inside = real[(real > 0.0) & (real < 1.0)]
        assert roots(*both(c), bernstein(12)) == pytest.approx(inside, abs=1e-9)
        slope = np.polynomial.Polynomial(c).deriv()
        falls = [x for x in inside if slope(x) < 0.0]
        expected = falls[0] if falls else math.inf
        assert fall(*both(c), False, bernstein(12)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.nightly
def test_the_first_of_several_power_series_and_what_is_left_out() -> None:
    """Of t^2 (3 - t), 1 - t, 5 over [0, 4]: the second; passed over, the first at t = 3."""
    rows = np.array([[1e-17, 0.0, 3.0, -1.0], [1.0, -1.0, 0.0, 0.0], [5.0, 0.0, 0.0, 0.0]])
    orders, before, halves = np.array([2, 0, 0]), np.ones(3), bernstein(4)
    skipped = np.zeros(3, dtype=np.int64)
    k, place, ends = first_series_to_cross(rows, 4.0, orders, before, skipped, halves)
    assert (k, place) == (1, pytest.approx(1.0, rel=1e-15))
    assert ends == pytest.approx([-1.0, -3.0, 5.0])  # of 3 - t, 1 - t and 5 at 4
    skipped[1] = 1
    k, place, _ = first_series_to_cross(rows, 4.0, orders, before, skipped, halves)
    assert (k, place) == (0, pytest.approx(3.0, rel=1e-15))
    skipped[0] = 1
    assert first_series_to_cross(rows, 4.0, orders, before, skipped, halves)[:2] == (-1, math.inf)


def test_values() -> None:
    """1 + 2 t + 3 t^2 and -t at 2; binary numbers, so that nothing is rounded."""
    assert evaluated(np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 0.0]]), 2.0).tolist() == [17.0, -2.0]


# --- Cubics that are known by values and slopes at 0 and 1 ----------------------------------------


@pytest.mark.parametrize("coefficients", [(1.0, -3.0, 0.5, 0.7), (2.0, 1.0, -1.0, -4.0)])
def test_the_root_is_that_of_the_cubic(coefficients: tuple[float, ...]) -> None:
    """Against the eigenvalues of numpy; both are rounded in the last digits."""
    d, c, b, a = coefficients
    value = np.polynomial.Polynomial([d, c, b, a])
    scaled = value if value(0.0) * value(1.0) < 0.0 else value - 0.5 * (value(0.0) + value(1.0))
    slope = scaled.deriv()
    root = hermite_root(
        float(scaled(0.0)), float(scaled(1.0)), float(slope(0.0)), float(slope(1.0))
    )
    expected = [z.real for z in scaled.roots() if abs(z.imag) < 1e-9 and 0.0 < z.real < 1.0]
    assert min(abs(root - each) for each in expected) < 1e-12


def test_of_an_infinite_slope_the_straight_line_is_taken() -> None:
    assert hermite_root(3.0, -1.0, math.inf, -4.0) == 0.75
