"""Edges of pieces: where they are, and the limits on both sides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from maps import grazing, line, lost_beyond, moving_edge, paper, pieces, skew_tent, two_lines

from woodpecker.piecewise.borders import (
    Edge,
    bisect,
    edge_at,
    edge_between,
    is_continuous,
    nearest_edge,
)
from woodpecker.piecewise.maps import Evaluation, LabelledMap, iterate

NEAR = 64  # spacings of doubles at which the first value beside an edge is read


def strip(low: float, high: float) -> LabelledMap:
    """Words A, B, C with edges at low and high."""
    return lambda x, _p: Evaluation(x, 1.0, 0.0, "A" if x < low else "B" if x < high else "C")


@pytest.mark.parametrize("edge", [0.3, -0.884773, 1.0, 1e-9, -700.1])
@pytest.mark.parametrize("side", [-1, 1])
def test_bisect_ends_on_neighbouring_doubles(edge: float, side: int) -> None:
    """Whichever side it starts from; 0.3 itself belongs to the right piece."""
    step = pieces(line(0.0, 0.0), line(0.0, 0.0), edge)
    inside, outside = bisect(step, 0.0, edge - side * 0.7, edge + side * 0.9)
    assert outside == math.nextafter(inside, side * math.inf)
    assert max(inside, outside) == edge
    assert step(inside, 0.0).word == step(edge - side * 0.7, 0.0).word
    assert step(outside, 0.0).word != step(inside, 0.0).word


def test_edge_between_holds_both_sides() -> None:
    edge = edge_between(two_lines(), 0.25, -0.3, 0.1)
    assert edge.x == pytest.approx(0.0, abs=1e-300)
    assert edge.p == 0.25
    assert (edge.left.word, edge.right.word) == ("L", "R")
    assert (edge.left.slope, edge.right.slope) == (0.5, -0.5)
    assert (edge.left_limit, edge.right_limit) == (0.25, 1.25)
    assert edge.jump == 1.0
    assert not edge.crosses


def test_edge_between_does_not_depend_on_the_way() -> None:
    one, two = (edge_between(moving_edge, 0.5, *way) for way in ((0.0, 0.6), (0.6, 0.0)))
    assert (one.left.word, one.right.word) == (two.left.word, two.right.word) == ("L", "R")
    assert abs(one.x - two.x) <= math.ulp(0.25)


@pytest.mark.parametrize("slope", [0.0, 0.5, -1.25, 40.0])
def test_limits_of_linear_sides(slope: float) -> None:
    """Read from two points 64 and 256 spacings away: off by 128 spacings times the slope."""
    x = -0.75
    edge = edge_between(pieces(line(slope, 1.0), line(-slope, 1.0, 1.0), x), 0.125, -0.8, -0.7)
    for limit, exact in (
        (edge.left_limit, slope * x + 0.125),
        (edge.right_limit, -slope * x + 1.125),
    ):
        error = (2 * NEAR * abs(slope) + 4) * math.ulp(max(1.0, abs(exact)))
        assert limit == pytest.approx(exact, abs=error)


@pytest.mark.parametrize("x", [0.0, 0.7, -0.884773])
@pytest.mark.parametrize("c", [1.0, -1.0, 30.0])
@pytest.mark.parametrize("side", [-1, 1])
def test_limit_of_a_square_root(x: float, c: float, side: int) -> None:
    """L + c sqrt|x - x_e|: the value read 64 spacings away is off by 1e-7 c, the limit is not."""

    def root(t: float, p: float) -> Evaluation:
        word = "L" if t < x else "R"
        if (t - x) * side > 0.0:
            return Evaluation(p + c * math.sqrt(abs(t - x)), math.inf, 1.0, word)
        return Evaluation(p + 2.0, 0.0, 1.0, word)

    edge = edge_between(root, 0.5, x - 0.1, x + 0.1)
    limit, other = edge.left_limit, edge.right_limit
    here = edge.left
    if side > 0:
        limit, other, here = other, limit, edge.right
    assert other == 2.5
    # the last double of the left piece lies one spacing short of x, which leaves
    # 2 sqrt(65) - sqrt(257) = 0.0117 * 8 spacings under the root
    value = abs(c) * math.sqrt(NEAR * math.ulp(x))
    assert limit == pytest.approx(0.5, abs=4 * math.ulp(1.0) + 0.012 * value)
    if x != 0.0:
        assert abs(here.value - 0.5) == pytest.approx(value, rel=0.02)


def test_limit_beside_a_lost_side_is_nan() -> None:
    edge = edge_between(lost_beyond(1.0), 0.25, 0.9, 1.1)
    assert edge.x == math.nextafter(1.0, 0.0)
    assert edge.left_limit == pytest.approx(0.75, abs=2 * NEAR * math.ulp(1.0))
    assert math.isnan(edge.right_limit)
    assert math.isnan(edge.jump)
    assert edge.right.word == "lost"
    assert not edge.crosses
    assert not is_continuous(edge)


def test_a_piece_as_thin_as_rounding_is_wide_is_passed() -> None:
    """100 spacings: so far a word can show that has no interval, and no limit is read there."""
    x, ulp = 0.5, math.ulp(0.5)

    def thin(t: float, _p: float) -> Evaluation:
        low, high = t < x, t < x + 100 * ulp
        return Evaluation(1.0 if low else 3.0 if high else 7.0, 0.0, 0.0, f"{low}{high}")

    edge = edge_between(thin, 0.0, x - 0.1, x + 50 * ulp)
    assert (edge.left_limit, edge.right_limit) == (1.0, 7.0)


@pytest.mark.parametrize("spacings", [3, 65, 300, 1000])
def test_limits_are_read_where_words_no_longer_flicker(spacings: int) -> None:
    """Rounding decides between the words of a jump, at random, that far on both sides of it."""
    x, ulp, rng = 0.5, math.ulp(0.5), np.random.default_rng(1)  # the slopes are 2 and -1

    def flickers(t: float, _p: float) -> Evaluation:
        left = t < x if abs(t - x) > spacings * ulp else bool(rng.integers(2))
        return Evaluation(2.0 * t if left else 0.5 - t, 2.0 if left else -1.0, 0.0, "RL"[left])

    for _ in range(20):
        edge = edge_between(flickers, 0.0, x - 0.1, x + 0.1)
        assert (edge.left.word, edge.right.word) == ("L", "R")
        # the slopes are exact, so only the place of the edge is uncertain
        assert edge.left_limit == pytest.approx(1.0, abs=4.0 * spacings * ulp)
        assert edge.right_limit == pytest.approx(0.0, abs=4.0 * spacings * ulp)
    if spacings <= 65:  # beyond these it looks for two words first
        assert edge_at(flickers, x, 0.0, 1e-6).right_limit == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("left", "right", "crosses"),
    [(-1.0, 1.0, True), (1.0, -1.0, True), (0.3, 0.4, True), (0.5, 0.6, False), (0.2, 0.1, False),
     (0.35, 1.0, False), (1.0, 0.35, False)],
)  # fmt: skip
def test_crossing_is_strict(left: float, right: float, crosses: bool) -> None:
    here = Evaluation(0.0, 0.0, 0.0, "S")
    edge = Edge(x=0.35, p=0.0, left=here, right=here, left_limit=left, right_limit=right)
    assert edge.crosses is crosses


def test_second_iterate_of_the_paper() -> None:
    """At r = 1: P2^L jumps at r/a = 0.8 across the diagonal, at 0 only below it [Eq. 15]."""
    second = iterate(paper(), 2)
    at_zero = edge_between(second, 1.0, -0.1, 0.1)
    assert (at_zero.left_limit, at_zero.right_limit) == (-1.0, -0.25)
    assert not at_zero.crosses
    at_preimage = edge_between(second, 1.0, 0.7, 0.9)
    assert at_preimage.x == pytest.approx(0.8, abs=math.ulp(1.0))
    # slope 25/16 on the left, 128 spacings away
    assert at_preimage.left_limit == pytest.approx(1.0, abs=1.6 * 2 * NEAR * math.ulp(0.8))
    assert at_preimage.right_limit == -1.0
    assert at_preimage.crosses


@pytest.mark.parametrize(
    ("left", "right", "side"),
    [(1e-6, 1e-3, -1), (1e-3, 1e-6, 1), (1e-12, 1e-2, -1), (1e-2, 1e-12, 1), (1e-6, 1.5e-6, -1),
     (1.5e-6, 1e-6, 1), (0.004, 0.005, -1)],
)  # fmt: skip
def test_nearest_edge_is_the_nearest(left: float, right: float, side: int) -> None:
    x = 0.5
    found = nearest_edge(strip(x - left, x + right), x, 0.0, "B")
    assert found is not None
    edge, on = found
    assert on == side
    assert edge.x - x == pytest.approx(-left if side < 0 else right, abs=2 * math.ulp(x))
    assert (edge.left.word, edge.right.word) == (("A", "B") if side < 0 else ("B", "C"))


def test_nearest_edge_is_looked_for_nearby_only() -> None:
    assert nearest_edge(strip(0.475, 0.525), 0.5, 0.0, "B") is None  # beyond 0.02 on both sides
    assert nearest_edge(strip(-1.0, 1.0), 0.5, 0.0, "B") is None


@pytest.mark.parametrize("offset", [-20, -5, -2, 0, 1, 2, 5, 20])
def test_nearest_edge_passes_ghosts_of_rounding(offset: int) -> None:
    """Two spacings around an edge show a word that has no interval; neither side reports it."""
    e, ulp = 0.5, math.ulp(0.5)

    def haunted(t: float, p: float) -> Evaluation:
        if abs(t - e) <= 2 * ulp:
            return Evaluation(t, 1.0, 0.0, "ghost")
        return strip(e, 2.0)(t, p)

    found = nearest_edge(haunted, e + offset * ulp, 0.0, "A" if offset < 0 else "B")
    assert found is not None
    edge, side = found
    assert side == (1 if offset < 0 else -1)
    assert abs(edge.x - e) <= 4 * ulp
    assert (edge.left.word, edge.right.word) == ("A", "B")


@pytest.mark.parametrize("offset", [-9, -4, 0, 3, 8])
@pytest.mark.parametrize("word", ["A", "B"])
def test_nearest_edge_where_rounding_mixes_the_words(offset: int, word: str) -> None:
    """Within ten spacings the words alternate; the piece asked for lies where it has room."""
    e, ulp = 0.5, math.ulp(0.5)

    def mixed(t: float, p: float) -> Evaluation:
        if abs(t - e) <= 10 * ulp:
            return Evaluation(t, 1.0, 0.0, "AB"[round((t - e) / ulp) % 2])
        return strip(e, 2.0)(t, p)

    found = nearest_edge(mixed, e + offset * ulp, 0.0, word)
    assert found is not None
    edge, side = found
    assert side == (1 if word == "A" else -1)
    assert abs(edge.x - e) <= 11 * ulp
    assert (edge.left.word, edge.right.word) == ("A", "B")


def test_nearest_edge_of_a_point_that_rounds_onto_the_edge() -> None:
    """Both neighbours of the last double before an edge are found, from either side."""
    edge_at = 0.3
    below, step = math.nextafter(edge_at, 0.0), strip(edge_at, 9.0)
    for x, word, side in ((below, "A", 1), (edge_at, "B", -1)):
        found = nearest_edge(step, x, 0.0, word)
        assert found is not None
        assert found[1] == side
        assert abs(found[0].x - edge_at) <= math.ulp(edge_at)


@pytest.mark.parametrize(
    ("labelled_map", "continuous"),
    [
        (skew_tent(0.5, -1.5), True),
        (grazing(-1.0), True),
        (grazing(30.0), True),
        (two_lines(), False),
        (pieces(line(0.5, 1.0), line(0.5, 1.0, 1e-7)), True),  # below Tolerances.jump = 1e-6
        (pieces(line(0.5, 1.0), line(0.5, 1.0, 1e-5)), False),
    ],
)
def test_is_continuous(labelled_map: LabelledMap, continuous: bool) -> None:
    assert is_continuous(edge_between(labelled_map, 0.0, -0.01, 0.01)) is continuous
