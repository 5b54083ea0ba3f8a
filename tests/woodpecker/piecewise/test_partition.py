"""Pieces and slices of maps whose words and zeros are known, and of the toy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from woodpecker import Toy
from woodpecker.piecewise.maps import BELOW, SEPARATOR, Evaluation, windowed
from woodpecker.piecewise.partition import (
    Resolution,
    Samples,
    iterated,
    partition,
    sampled,
    slice_of,
)
from woodpecker.toymaps import toy_map, toy_samples

COARSE = Resolution(spacing=0.05, smallest=1e-9, bend=1e-6)


def steps(x: float, p: float) -> Evaluation:
    """Unit steps of x, each with its own word: floor(x) + p."""
    n = math.floor(x)
    return Evaluation(n + p, 0.0, 1.0, str(n))


def wave(x: float, p: float) -> Evaluation:
    """x + (x - 1/3)(x - 1/3 - p)(x + 1/2): zeros of P(x) - x at 1/3, 1/3 + p and -1/2."""
    a, b, c = x - 1 / 3, x - 1 / 3 - p, x + 0.5
    return Evaluation(x + a * b * c, 1 + b * c + a * c + a * b, -a * c, "A")


def sevenths(x: float, p: float) -> Evaluation:
    """Infinitely many pieces that shrink towards zero: word n where 7**-(n+1) < x <= 7**-n."""
    if x <= 0.0:
        return Evaluation(-1.0, 0.0, 0.0, "left")
    n = math.floor(-math.log(x) / math.log(7.0))
    return Evaluation(0.5 * x, 0.5, 0.0, str(n))


def grazing(x: float, p: float) -> Evaluation:
    """A continuous change of word at 0 with infinite slope on one side."""
    if x < 0.0:
        return Evaluation(0.2 * x, 0.2, 0.0, "L")
    root = math.sqrt(x) if x > 0.0 else 0.0
    return Evaluation(root, 0.5 / root if root else math.inf, 0.0, "R")


def test_edges_are_found_to_the_last_bit() -> None:
    found = partition(sampled(steps), 0.25, (-1.5, 2.5), COARSE)
    assert [piece.word for piece in found.pieces] == ["-2", "-1", "0", "1", "2"]
    for edge, at in zip(found.edges, (-1.0, 0.0, 1.0, 2.0), strict=True):
        assert edge.x < at <= np.nextafter(edge.x, math.inf)
        assert edge.left_limit == at - 1 + 0.25
        assert edge.right_limit == at + 0.25
        assert edge.jump == 1.0
    assert found.unresolved == ()
    for left, right in zip(found.pieces, found.pieces[1:], strict=False):
        assert np.nextafter(left.high, math.inf) == right.low


def test_infinitely_many_pieces_are_reported() -> None:
    found = partition(sampled(sevenths), 0.0, (-0.5, 0.9), COARSE)
    words = {piece.word for piece in found.pieces}
    assert words >= {str(n) for n in range(10)}  # 7**-10 = 3.5e-9 is above the smallest width
    assert found.unresolved
    assert 0.0 < found.unresolved_length <= 1e-9
    assert all(low <= 1e-9 for low, _ in found.unresolved)


def test_limits_next_to_a_square_root() -> None:
    (edge,) = partition(sampled(grazing), 0.0, (-0.5, 0.51), COARSE).edges
    assert abs(edge.x) < 1e-300
    assert abs(edge.jump) < 1e-8  # the limit extrapolates a square root from some doubles away


@pytest.mark.parametrize("p", [0.3, 1e-3, 1e-5])
def test_all_zeros_of_a_piece(p: float) -> None:
    """Also two that lie between neighbouring samples: between them the slope is 1."""
    found = slice_of(sampled(wave), p, (-1.0, 1.0), COARSE)
    rounding = 1e-15 / p  # P(x) - x has slope 5 p/6 at the zeros
    expected = [-0.5, 1 / 3, 1 / 3 + p]
    assert [x for x, _ in found.fixed_points] == pytest.approx(expected, abs=rounding)


def test_crossings_are_strict() -> None:
    found = slice_of(sampled(steps), 0.5, (-1.4, 2.4), COARSE)
    assert [edge.x for edge in found.crossings] == pytest.approx([-1.0, 0.0, 1.0, 2.0])
    for p in (0.0, 1.0):  # one limit lies on the diagonal
        assert slice_of(sampled(steps), p, (-1.4, 2.4), COARSE).crossings == ()
    assert slice_of(sampled(grazing), 0.0, (-0.5, 0.51), COARSE).crossings == ()


def test_a_band_of_fixed_points_is_an_interval() -> None:
    def centres(x: float, p: float) -> Evaluation:
        return Evaluation(x, 1.0, 0.0, "C") if 0.0 <= x <= 0.5 else steps(x, p)

    found = slice_of(sampled(centres), 0.25, (-0.9, 0.9), COARSE)
    ((low, high),) = found.bands
    assert (low, high) == (pytest.approx(0.0, abs=1e-15), pytest.approx(0.5, abs=1e-15))


def test_iterates_are_those_of_the_labelled_map() -> None:
    whole = iterated(sampled(wave), 3)
    x = np.linspace(-0.8, 0.8, 33)
    here = whole.sweep(x, 0.3)
    for i, start in enumerate(x.tolist()):
        point, slope, rate, words = start, 1.0, 0.0, []
        for _ in range(3):
            lap = wave(point, 0.3)
            words.append(lap.word)
            point, slope, rate = lap.value, slope * lap.slope, lap.slope * rate + lap.rate
        assert here.value[i] == point
        assert here.slope[i] == pytest.approx(slope, rel=1e-15)
        assert here.rate[i] == pytest.approx(rate, rel=1e-14)
        assert whole.words[here.words[i]] == SEPARATOR.join(words)


def test_orbits_that_leave_the_window() -> None:
    """Below it the last point has one word; an earlier one ends the orbit."""
    whole = iterated(sampled(steps), 1, (0.0, 3.0))
    here = whole.sweep(np.array([-1.5, 0.5, 2.5]), 0.25)
    assert [whole.words[i] for i in here.words] == [BELOW, "0", "2"]
    assert here.defined.all()
    twice = iterated(sampled(steps), 2, (0.0, 3.0))
    here = twice.sweep(np.array([-1.5, 0.5]), 0.25)
    assert here.defined.tolist() == [False, True]
    labelled = windowed(steps, (0.0, 3.0))
    assert not labelled(-0.5, 0.0).defined
    assert labelled(0.5, -1.0).word == BELOW


@pytest.mark.parametrize("name", ["spacing", "smallest", "bend", "far"])
def test_resolutions_are_positive(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must be positive and finite, got 0.0"):
        Resolution(**{name: 0.0})
    with pytest.raises(ValueError, match=f"{name} must be positive and finite, got nan"):
        Resolution(**{name: math.nan})


def test_a_window_ascends() -> None:
    with pytest.raises(ValueError, match=r"window must ascend, got \(1.0, 0.0\)"):
        partition(sampled(steps), 0.0, (1.0, 0.0))


@pytest.mark.parametrize("window", [(0.0, 1.0, 2.0), (0.0,), 1.0, (0.0, 1.0j), "01"])
def test_a_window_is_two_numbers(window: tuple[float, float]) -> None:
    for call in (
        lambda: partition(sampled(steps), 0.0, window),
        lambda: iterated(sampled(steps), 2, window),
        lambda: windowed(steps, window),
    ):
        with pytest.raises(ValueError, match="window must be two real numbers") as caught:
            call()
        assert str(caught.value).endswith(f"got {window!r}")


@pytest.mark.parametrize("order", [0, -1, 1.5, True])
def test_an_iterate_has_an_order(order: int) -> None:
    with pytest.raises(
        ValueError, match=f"order must be a whole number of at least 1, got {order}"
    ):
        iterated(sampled(steps), order)


# --- The toy --------------------------------------------------------------------------------------


def test_many_points_at_once_are_the_labelled_map() -> None:
    toy = Toy()
    one, many = toy_map(toy), toy_samples(toy)
    x = np.linspace(-2.4, -0.3, 41)
    here: Samples = many.sweep(x, 0.4)
    for i, start in enumerate(x.tolist()):
        lap = one(start, 0.4)
        assert (here.value[i], here.slope[i], here.rate[i]) == (lap.value, lap.slope, lap.rate)
        assert many.words[here.words[i]] == lap.word


@pytest.mark.slow
def test_slices_of_the_toy() -> None:
    """Fixed points and jumps at eps_N1 = 0.5 and 0.35, where the island I1 is open."""
    samples = iterated(toy_samples(Toy()), 1, (-2.5, -0.24))
    resolution = Resolution(spacing=2e-3, smallest=1e-6, bend=1e-5)
    half = slice_of(samples, 0.5, (-2.5, -0.24), resolution)
    assert [x for x, _ in half.fixed_points] == pytest.approx(
        [-1.2506951, -1.2247535, -0.52947197], abs=1e-6
    )
    assert half.crossings == ()
    island = slice_of(samples, 0.35, (-2.5, -0.24), resolution)
    assert [x for x, _ in island.fixed_points] == pytest.approx(
        [-1.3721674, -1.349971, -0.9823319, -0.5638865], abs=1e-6
    )
    assert [edge.x for edge in island.crossings] == pytest.approx([-0.8847733440], abs=1e-9)


@pytest.mark.slow
def test_the_band_of_centres_is_the_identity() -> None:
    found = slice_of(toy_samples(Toy()), 0.5, (-0.3, -0.21), Resolution(spacing=1e-3))
    ((low, high),) = found.bands
    assert (low, high) == (pytest.approx(-0.2382, abs=1e-4), pytest.approx(-0.2217, abs=1e-4))
