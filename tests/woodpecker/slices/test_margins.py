"""What margins say of the way between two points: exact parabolas, cubics and square roots."""

from __future__ import annotations

import math

import numpy as np
import pytest

from woodpecker.maps.pieces import Image, Piece
from woodpecker.slices.margins import (
    depth,
    first_part,
    is_within,
    lowest_dip,
    nearest_code,
    next_border,
)

NO_PIECE: Piece = None  # type: ignore[assignment]  # margins alone are asked here
NEAR = 1e-14  # some roundings at 1


def image(margins: dict[int, tuple[float, float]], slope: float = 1.0) -> Image:
    """An image with margins and their slopes in x, by their codes."""
    values = np.array([value for value, _ in margins.values()])
    gradients = np.array([(rate, 0.0) for _, rate in margins.values()]).reshape(-1, 2)
    causes = np.array(list(margins), dtype=np.int64)
    return Image(0.0, slope, 0.0, values, gradients, causes, NO_PIECE)


def test_distances_to_borders() -> None:
    here = image({3: (1.0, -2.0), 5: (3.0, 4.0), 7: (0.5, 0.0)})
    assert next_border(here, 1.0) == (0.5, 3)
    assert next_border(here, -1.0) == (0.75, 5)
    assert (nearest_code(here, 1), nearest_code(here, -1)) == (3, 5)
    assert (depth(here), depth(here, 3)) == (0.5, 0.75)
    assert is_within(here)


def test_a_margin_that_does_not_change_is_far_or_fatal() -> None:
    assert depth(image({1: (2.0, 0.0)})) == math.inf
    assert depth(image({1: (-2.0, 0.0), 2: (1.0, 1.0)})) == -math.inf
    assert next_border(image({1: (2.0, 0.0)}), 1.0) == (math.inf, -1)
    assert nearest_code(image({1: (2.0, 0.0)}), 1) == -1
    assert not is_within(image({1: (-2.0, 0.0)}))


def test_the_minimum_of_a_cubic_is_met() -> None:
    """h = (s - 1/4)^2 (2 - s) + 1/100 on (0, 1): its minimum is 1/100 at 1/4."""

    def h(s: float) -> tuple[float, float]:
        return (s - 0.25) ** 2 * (2.0 - s) + 0.01, (s - 0.25) * (4.0 - 2.0 * s - (s - 0.25))

    where = lowest_dip(image({4: h(0.0)}), image({4: h(1.0)}), 1.0)
    assert where == pytest.approx(0.25, abs=NEAR)


def test_a_minimum_that_takes_little_away_is_none() -> None:
    """1 + s (s - 1) has its minimum of 3/4 in the middle."""
    assert lowest_dip(image({4: (1.0, -1.0)}), image({4: (1.0, 1.0)}), 1.0) is None


def test_a_margin_that_falls_and_rises_and_falls() -> None:
    """1/2 - 5 s + 11 s^2 - 6 s^3 falls at both ends; its minimum is -0.17 at 0.31."""
    ends = image({4: (0.5, -5.0)}), image({4: (0.5, -1.0)})
    where = lowest_dip(*ends, 1.0)
    assert where == pytest.approx((11.0 - 31.0**0.5) / 18.0, abs=NEAR)


def test_a_dip_beside_a_square_root() -> None:
    """h = 1 - 4 u + 4.2 u^2, u^2 the distance from the second point, where the slope is infinite.

    A cubic in x, with the slope 1e-10 of the way before that end, would see a dip of -7400.
    """

    def h(u: float) -> tuple[float, float]:
        return 1.0 - 4.0 * u + 4.2 * u * u, (4.0 - 8.4 * u) / (2.0 * u)

    value, _ = h(0.0 + 1e-5)
    here, there = image({4: h(1.0)}), image({4: (value, h(1e-5)[1])}, slope=1e5)
    where = lowest_dip(here, there, 1.0)
    assert where == pytest.approx(1.0 - (4.0 / 8.4) ** 2, abs=1e-4)  # 1e-5 of the way is missing


def test_a_margin_that_only_one_point_has() -> None:
    one, other = image({2: (1.0, 0.0), 4: (0.5, -1.0)}), image({2: (1.0, 0.0), 5: (0.5, 0.1)})
    assert lowest_dip(one, other, 1.0) == 0.5
    assert lowest_dip(one, other, 0.4) is None


def test_the_first_of_two_margins_to_vanish() -> None:
    """1 - 2 s vanishes at 1/2 and 1 - 4 s at 1/4; a third is not there at the first point."""
    here = image({1: (1.0, -2.0), 2: (1.0, -4.0), 3: (1.0, 5.0)})
    there = image({1: (-1.0, -2.0), 2: (-3.0, -4.0), 3: (6.0, 5.0), 9: (-1.0, -2.0)})
    assert first_part(here, there, 1.0) == (pytest.approx(0.25, abs=NEAR), 2)
    assert first_part(here, here, 1.0) == (1.0, -1)
