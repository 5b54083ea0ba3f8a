"""Cycles and jumps of iterates from the pieces of P_1: maps solved by hand, then the toy."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from woodpecker.diagram import WINDOW
from woodpecker.mechanics.toy import Toy
from woodpecker.piecewise.maps import Evaluation, LabelledMap, minimal_period, windowed
from woodpecker.piecewise.partition import Resolution, iterated, partition, sampled, slice_of
from woodpecker.piecewise.pullback import Itineraries
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.slices import Found, Slicer
from woodpecker.toymaps import toy_map, toy_samples

COARSE = Resolution(spacing=0.02, smallest=1e-6, bend=1e-4, edge=1e-6, close=1e-3)


def tent(x: float, p: float) -> Evaluation:
    """Slope 2 on (0, 1): 2**j fixed points of P_j, k / (2**j -+ 1)."""
    slope = 2.0 if x < 0.5 else -2.0
    return Evaluation(slope * x + 1.0 - 0.5 * slope, slope, 0.0, "L" if x < 0.5 else "R")


def doubling(x: float, p: float) -> Evaluation:
    """2 x mod 1 on (0, 1): it jumps from 1 to 0 at 1/2."""
    left = x < 0.5
    return Evaluation(2.0 * x if left else 2.0 * x - 1.0, 2.0, 0.0, "LR"[not left])


def flat(x: float, p: float) -> Evaluation:
    """0.3 left of 1/2, 2 - 2 x right of it: 0.3 is a fixed point, and 2/3."""
    if x < 0.5:
        return Evaluation(0.3, 0.0, 0.0, "L")
    return Evaluation(2.0 - 2.0 * x, -2.0, 0.0, "R")


def sliced(labelled: LabelledMap, order: int, window: tuple[float, float] = (0.01, 0.99)) -> Found:
    inside = windowed(labelled, (window[0] - 0.005, window[1] + 0.005))
    slicer = Slicer(inside, sampled(inside), Settings(window=window), COARSE)
    (found,) = slicer.take(0.0, (order,))
    return found


@pytest.mark.parametrize("order", [2, 3, 4])
def test_every_cycle_of_the_tent_map(order: int) -> None:
    expected = set()
    for word in itertools.product((2.0, -2.0), repeat=order):
        slope, shift = 1.0, 0.0
        for s in word:  # x -> 2 x or 2 - 2 x
            slope, shift = s * slope, s * shift + (0.0 if s > 0.0 else 2.0)
        expected.add(round(shift / (1.0 - slope), 9))
    inside = {x for x in expected if 0.01 < x < 0.99}
    found = sliced(tent, order)
    assert found.failed == ()
    # orbits that leave the window are not followed; 0 and its neighbours do
    orbits = {x: orbit(tent, x, order) for x in inside}
    stays = {x for x in inside if min(orbits[x]) > 0.01 and max(orbits[x]) < 0.99}
    assert {round(float(cycle.x[0]), 9) for cycle in found.cycles} == stays
    assert all(cycle.residual < 1e-12 for cycle in found.cycles)


def orbit(labelled: LabelledMap, x: float, laps: int) -> list[float]:
    points = [x]
    for _ in range(laps - 1):
        points.append(labelled(points[-1], 0.0).value)
    return points


@pytest.mark.parametrize("order", [2, 3])
def test_every_jump_of_the_doubling_map(order: int) -> None:
    """P_j jumps at odd multiples of 2**-j, from 1 to 0: across the diagonal."""
    found = sliced(doubling, order, (-0.001, 1.001))
    expected = [k / 2**order for k in range(1, 2**order) if k % 2 or order == 1]
    deepest = [jump.x for jump in found.jumps if len(jump.points) == order - 1]
    np.testing.assert_allclose(deepest, expected, rtol=0.0, atol=1e-12)
    for jump in found.jumps:
        assert jump.whole.left_limit == pytest.approx(1.0, abs=1e-9)
        assert jump.whole.right_limit == pytest.approx(0.0, abs=1e-9)


def test_a_flat_piece_has_its_cycle() -> None:
    found = sliced(flat, 2)
    points = [float(cycle.x[0]) for cycle in found.cycles]
    assert points == pytest.approx([0.3, 2.0 / 3.0], abs=1e-12)
    assert [cycle.multiplier for cycle in found.cycles] == [0.0, 4.0]


def test_two_fixed_points_in_one_increasing_piece() -> None:
    """x + (x - 0.3)(x - 0.7) rises everywhere in (0.1, 0.95) and meets the diagonal twice."""

    def rising(x: float, p: float) -> Evaluation:
        return Evaluation(x + (x - 0.3) * (x - 0.7), 2.0 * x, 0.0, "A")

    found = sliced(rising, 2, (0.1, 0.95))
    assert [float(cycle.x[0]) for cycle in found.cycles] == pytest.approx([0.3, 0.7], abs=1e-9)


def rising(*roots: float) -> LabelledMap:
    """x + the product of x - root: an increasing piece with these fixed points."""

    def value(x: float, p: float) -> Evaluation:
        gaps = [x - root for root in roots]
        slope = sum(math.prod(gaps[:k] + gaps[k + 1 :]) for k in range(len(gaps)))
        return Evaluation(x + math.prod(gaps), 1.0 + slope, 0.0, "A")

    return value


@pytest.mark.parametrize(
    "roots",
    [
        (0.5, 0.502),  # closer than the points inside a piece that are looked at
        (0.3, 0.5, 0.7),  # three in a piece whose ends lie on different sides of the diagonal
        (0.3, 0.4, 0.6, 0.8),
    ],
)
@pytest.mark.parametrize("order", [2, 3])
def test_all_fixed_points_of_an_increasing_piece(roots: tuple[float, ...], order: int) -> None:
    found = sliced(rising(*roots), order, (0.1, 0.95))
    # Newton's residual of 1e-12 over a slope that differs from 1 by 0.002 at least
    assert [float(cycle.x[0]) for cycle in found.cycles] == pytest.approx(roots, abs=2e-9)


@pytest.mark.parametrize(("steepest", "kept"), [(4.1, 4), (3.9, 0)])
def test_steep_cycles_are_counted_and_left_out(steepest: float, kept: int) -> None:
    """The tent map's P_2 has slope 4 everywhere: 2/3, 0.4, 0.8 inside, and 0 at the very edge."""
    window = (-0.01, 1.01)
    inside = windowed(tent, (-0.02, 1.02))
    settings = Settings(window=window, steepest=steepest)
    (found,) = Slicer(inside, sampled(inside), settings, COARSE).take(0.0, (2,))
    assert (len(found.cycles), found.steep) == (kept, 4 - kept)
    assert found.failed == ()


def test_what_a_search_of_the_iterate_finds_is_there() -> None:
    """At 0.23 the toy's P_2 has cycles that its pieces of 1e-6 rad do not show; not vice versa."""
    toy = Toy(eps_n1=0.23)
    samples, look = toy_samples(toy), Resolution(spacing=2e-3, smallest=1e-6, bend=1e-5)
    inside = windowed(toy_map(toy), (WINDOW[0] - 0.05, WINDOW[1] + 0.05))
    settings = Settings(window=WINDOW, steepest=math.inf)
    (found,) = Slicer(inside, samples, settings, look).take(0.23, (2,))
    points = np.array([x for cycle in found.cycles for x in cycle.x])
    direct = slice_of(iterated(samples, 2, WINDOW), 0.23, WINDOW, look)
    steep = 0
    for x, _ in direct.fixed_points:
        steep += np.abs(points - x).min() > 1e-6  # some of them are jumps that the pieces hide
    assert steep <= 0.05 * len(direct.fixed_points)
    assert len(found.cycles) > len(direct.fixed_points)
    twos = [cycle for cycle in found.cycles if minimal_period(cycle) == 2]
    assert len(twos) >= 26
    for cycle in found.cycles:
        assert cycle.residual <= 2.0**-47 * max(abs(lap.slope) for lap in cycle.laps) + 1e-12


@pytest.mark.parametrize("order", [2, 3])
def test_where_nothing_stays_there_is_nothing(order: int) -> None:
    """x - 2 leads below the window (0, 1) from everywhere; with a jump to 3 as well."""

    def away(x: float, p: float) -> Evaluation:
        return Evaluation(x - 2.0 if x < 0.5 else 3.0 + x, 1.0, 0.0, "L" if x < 0.5 else "R")

    found = sliced(lambda x, p: Evaluation(x - 2.0, 1.0, 0.0, "A"), order)
    assert (found.cycles, found.jumps) == ((), ())
    assert sliced(away, order).cycles == ()


def test_cylinders_partition_what_stays() -> None:
    """The pieces of P_2 of the tent map on (0, 1): four intervals of length 1/4."""
    map_ = sampled(tent)
    pieces = partition(iterated(map_, 1, (0.0, 1.0)), 0.0, (0.0, 1.0), COARSE)
    orbits = Itineraries(map_, pieces)
    found = orbits._of(2)
    lengths = np.sort(found.high - found.low)
    np.testing.assert_allclose(lengths[-4:], 0.25, atol=1e-5)
    assert math.fsum(lengths) == pytest.approx(1.0, abs=1e-5)
