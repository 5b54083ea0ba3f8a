"""How a picture looks at a map: jumps told from flanks, within a budget that is kept."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from woodpecker.base.arrays import Floats
from woodpecker.plot import curve as curves
from woodpecker.plot.curve import FINEST, Link, MapSamples, refined

GRID = np.linspace(-1.0, 1.0, 101)
PLACE = 0.3 + 1e-4  # between two points of the grid
WIDTH = FINEST * math.ulp(PLACE)  # of the interval a jump is known to lie in


def last(image: Callable[[Floats], Floats], *, bottom: float = -2.0) -> MapSamples:
    """The best curve over the grid."""
    *_, curve = refined(image, GRID, image(GRID), bottom=bottom)
    return curve


def step(x: Floats) -> Floats:
    return np.where(x < PLACE, x, x - 1.0)


def test_a_jump_is_found_between_doubles() -> None:
    curve = last(step)
    (k,) = curve.between(Link.JUMP)
    assert curve.x[k] < PLACE <= curve.x[k + 1]
    assert curve.x[k + 1] - curve.x[k] <= WIDTH
    assert curve.between(Link.OPEN).size == 0
    assert curve.open_width == 0.0
    # Each interval of the grid is a little higher than what shows; 43 more halvings lead from its
    # width of 0.02 to 64 spacings of 5.6e-17.
    assert curve.evaluations <= 101 + 43


def test_samples_stay_and_ascend() -> None:
    curve = last(step)
    assert np.isin(GRID, curve.x).all()
    assert (np.diff(curve.x) > 0.0).all()
    np.testing.assert_array_equal(curve.y, step(curve.x))
    assert curve.links.shape == (len(curve.x) - 1,)
    assert len(curve.x) == len(GRID) + curve.evaluations


def dip(x: Floats) -> Floats:
    """Left like a power, right by a quarter of a radian for each decade to the last one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        left, right = -1e-3 / np.sqrt(PLACE - x), 0.25 * np.log10(x - PLACE)
    return np.where(x < PLACE, left, right)


@pytest.mark.parametrize(
    "image",
    [
        *(lambda x, width=10.0**-n: np.tanh((x - PLACE) / width) for n in (3, 6, 9, 12)),
        lambda x: np.sqrt(np.maximum(x - PLACE, 0.0)),
        lambda x: np.where(x < PLACE, x, np.nan),
        dip,
    ],
)
def test_what_is_no_jump(image: Callable[[Floats], Floats]) -> None:
    """Steep flanks, a square root, the end of a map, a dip."""
    curve = last(image, bottom=-9.0)
    assert curve.between(Link.JUMP).size == 0
    ends = curve.x[np.isfinite(curve.y)].max()
    if ends < 1.0:
        assert ends == pytest.approx(PLACE, abs=WIDTH)
    else:
        assert curve.between(Link.OPEN).size == 0
    if image is dip:
        assert np.nanmin(curve.y) < -1.0  # the grid shows -0.43


def test_what_lies_below_the_picture_is_not_looked_at() -> None:
    curve = last(lambda x: np.where(x < PLACE, 0.0, -5.0) - (x > 0.8), bottom=-2.0)
    assert curve.bottom == -2.0
    assert curve.x[curve.between(Link.JUMP)] == pytest.approx([PLACE], abs=WIDTH)
    assert np.count_nonzero(curve.y < -5.5) == np.count_nonzero(GRID > 0.8)


def noise(x: Floats) -> Floats:
    """Differs wherever one looks: what an iterate of high order is in wide parts of its window."""
    return np.sin(1e13 * x)


@pytest.mark.parametrize(("budget", "cost"), [(0, 1), (30, 1), (3000, 1), (3000, 10), (20_000, 3)])
def test_the_budget_is_kept_and_what_is_left_is_counted(budget: int, cost: int) -> None:
    seen = []

    def counted(x: Floats) -> Floats:
        seen.append(len(x))
        return noise(x)

    *_, curve = refined(counted, GRID, noise(GRID), bottom=-1.0, cost=cost, budget=budget)
    assert sum(seen) == curve.evaluations
    assert cost * curve.evaluations <= budget
    width = np.diff(curve.x)[curve.between(Link.OPEN)]
    assert width.size > 0
    assert curve.open_width == pytest.approx(width.sum(), rel=1e-12)


def test_the_largest_differences_come_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of 1, 1/2, 1/4, ...: a budget for two of them is spent on the first two."""
    places = np.array([-0.7, -0.3, 0.1, 0.5]) + 1e-4

    def steps(x: Floats) -> Floats:
        return (x[:, None] > places) @ np.array([0.25, 1.0, 0.125, 0.5])

    monkeypatch.setattr(curves, "PIXEL", 1.0)  # no interval is wider
    *_, curve = refined(steps, GRID, steps(GRID), bottom=0.0, budget=2 * 48)
    found = curve.x[curve.between(Link.JUMP)]
    np.testing.assert_allclose(found, places[[1, 3]], atol=WIDTH)
    assert len(curve.between(Link.OPEN)) == 2
    assert curve.open_width == pytest.approx(2 * 0.02, rel=1e-9)


def test_each_curve_goes_on_from_the_one_before() -> None:
    sizes = [len(curve.x) for curve in refined(noise, GRID, noise(GRID), bottom=-1.0)]
    assert sizes[0] == len(GRID)
    assert sizes == sorted(sizes)
    assert len(sizes) > 5


def test_a_map_without_values_or_height() -> None:
    assert last(lambda x: np.full(len(x), np.nan)).evaluations == 0
    assert last(np.zeros_like, bottom=0.0).evaluations == 0
