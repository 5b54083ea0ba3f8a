"""Continuation of jump crossings, on maps whose jumps are known by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from maps import A, moving_edge, paper, staircase, two_lines

from pwmap.diagrams.diagram import PointKind
from woodpecker.piecewise.borders import Edge, edge_between
from woodpecker.piecewise.jumps import JumpPoint, follow_jump, jump_through
from woodpecker.piecewise.maps import Evaluation, LabelledMap, iterate
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.tracking import RESOLVED

BC, EP, FALL, WC = PointKind.BC, PointKind.EP, PointKind.FALL, PointKind.WC

# A limit meets the diagonal at slope 1 or so in p: found to the bit up to the 128 spacings of
# doubles times the slope by which a limit is uncertain.
COLLISION = 1e-12


def edge_near(labelled_map: LabelledMap, x: float, p: float) -> Edge:
    edge = edge_between(labelled_map, p, x - 0.05, x + 0.05)
    assert edge.crosses
    return edge


def run(
    labelled_map: LabelledMap,
    start: Edge,
    direction: int,
    span: tuple[float, float] = (-2.0, 3.0),
    window: tuple[float, float] = (-math.inf, math.inf),
) -> list[JumpPoint]:
    return list(follow_jump(labelled_map, start, Settings(span=span, window=window), direction))


def at(point: JumpPoint) -> tuple[float, float]:
    return float(point.p), float(point.edge.x)


def assert_crossing(path: list[JumpPoint], x: Callable[[float], float], words: str) -> None:
    """Every point before the end lies on x(p), crosses strictly and has the words ``L / R``."""
    assert len(path) > 10
    for point in path[:-1]:
        assert point.edge.x == pytest.approx(x(point.p), abs=COLLISION)
        assert point.edge.crosses
        assert f"{point.edge.left.word} / {point.edge.right.word}" == words


def kinds(path: list[JumpPoint]) -> list[PointKind]:
    return [point.kind for point in path if point.kind is not None]


@pytest.mark.parametrize(("direction", "end", "side"), [(1, 2.0, -1), (-1, 0.0, 1)])
def test_jump_of_the_paper(direction: int, end: float, side: int) -> None:
    """From r = 1 to B, where the left limit r - 2 is 0, and to A, where the right limit r is."""
    path = run(paper(), edge_near(paper(), 0.0, 1.0), direction)
    assert kinds(path) == [BC]
    assert path[-1].ends
    assert path[-1].side == side
    assert at(path[-1]) == pytest.approx((end, 0.0), abs=COLLISION)
    assert_crossing(path, lambda _: 0.0, "L / R")
    for point in path:
        assert point.edge.left_limit == pytest.approx(point.p - 2.0, abs=COLLISION)
        assert point.edge.right_limit == pytest.approx(point.p, abs=COLLISION)
    assert max(abs(b.p - a.p) for a, b in pairwise(path)) <= 0.02 + 1e-15


@pytest.mark.parametrize(("direction", "end", "side"), [(1, 1.0, 1), (-1, 0.0, -1)])
def test_jump_of_a_staircase(direction: int, end: float, side: int) -> None:
    """Persistence at both ends: the limits x_e + p - 1 (right) and x_e + p (left) reach x_e."""
    path = run(staircase(), edge_near(staircase(), 0.0, 0.5), direction)
    assert kinds(path) == [BC]
    assert path[-1].side == side
    assert at(path[-1]) == pytest.approx((end, 0.0), abs=COLLISION)
    assert_crossing(path, lambda _: 0.0, "L / R")


def test_collision_of_a_curved_limit() -> None:
    """The right limit p^3 - 0.2 meets 0 at the cube root of 0.2, at the rate 3 p^2 = 1.03."""

    def curved(x: float, p: float) -> Evaluation:
        if x < 0.0:
            return Evaluation(-1.0, 0.0, 0.0, "L")
        return Evaluation(p**3 - 0.2, 0.0, 3.0 * p * p, "R")

    path = run(curved, edge_near(curved, 0.0, 0.9), -1)
    assert kinds(path) == [BC]
    assert path[-1].side == 1
    assert path[-1].p == pytest.approx(0.2 ** (1 / 3), abs=1e-14)


@pytest.mark.parametrize("width", [3e-3, 2e-4, 3e-6])
@pytest.mark.parametrize("direction", [1, -1])
def test_collision_among_other_words(width: float, direction: int) -> None:
    """The left limit 0.1 - |p| crosses at 0.1, on a stretch of p on which its word is another.

    A step can pass over the stretch and see the same words at both ends.
    """

    def value(x: float, p: float) -> Evaluation:
        if x >= 0.0:
            return Evaluation(-1.0, 0.0, 0.0, "R")
        other = abs(abs(p) - 0.1) < width
        return Evaluation(0.1 - abs(p), 0.0, -math.copysign(1.0, p), "other" if other else "L")

    path = run(value, edge_near(value, 0.0, 0.0), direction)
    assert path[-1].kind is BC
    assert at(path[-1]) == pytest.approx((direction * 0.1, 0.0), abs=COLLISION)


@pytest.mark.parametrize("off", [1e-3, 1e-6, 3e-8])
def test_jump_whose_orbit_hugs_a_square_root(off: float) -> None:
    """P_1 jumps at p/10; p/10 - off + sqrt(x - root) takes x = root + off**2 there.

    The root 1/2 + p**2 moves on a curve: a straight guess leaves the piece, however small the step.
    """

    def value(x: float, p: float) -> Evaluation:
        beyond = x - 0.5 - p * p
        if beyond >= 0.0:
            height = math.sqrt(beyond)
            slope = 0.5 / height if height > 0.0 else math.inf
            return Evaluation(0.1 * p - off + height, slope, 0.1 - 2.0 * p * slope, "S")
        if x < 0.1 * p:
            return Evaluation(-1.0, 0.0, 0.0, "L")
        return Evaluation(2.0, 0.0, 0.0, "R")

    edge = edge_between(value, 0.1, -0.05, 0.05)
    start = jump_through(value, edge, (0.51 + 1.01 * off**2,), 2)
    assert start is not None
    path = list(follow_jump(value, start, Settings(span=(0.0, 1.0)), 1, 2))
    assert path[-1].note == "end of the parameter span"
    assert len(path) < 1.2 * 0.9 / Settings().probe  # at straight places words are looked for
    for point in path:
        # some roundings of numbers near 1
        assert point.edge.x == pytest.approx(0.5 + point.p**2 + off**2, abs=1e-15)
        assert (point.edge.left_limit, point.edge.right_limit) == (-1.0, 2.0)


# --- the second iterate of the paper's map -------------------------------------------------------


@pytest.mark.parametrize("r", [0.1, 1.0, 1.9])
def test_second_map_of_the_paper_crosses_at_the_preimage_only(r: float) -> None:
    second = iterate(paper(), 2)
    assert edge_near(second, r / A, r).x == pytest.approx(r / A, abs=COLLISION)
    at_zero = edge_between(second, r, -0.5 * r / A, 0.5 * r / A)
    limits = at_zero.left_limit, at_zero.right_limit
    assert limits == pytest.approx((r - 2.0, (1.0 - A) * r), abs=1e-14)  # both below 0
    assert not at_zero.crosses


def test_jump_of_the_second_map_upwards() -> None:
    """x = r/a crosses for 0 < r < 10, where its right limit r - 2 reaches it."""
    second = iterate(paper(), 2)
    path = run(second, edge_near(second, 0.8, 1.0), 1)
    assert kinds(path)[-1] is EP
    assert path[-1].note == "end of the parameter span"
    assert path[-1].p == 3.0
    assert_crossing(path, lambda r: r / A, "R | R / R | L")
    far = run(second, edge_near(second, 0.8, 1.0), 1, span=(-1.0, 11.0))
    assert kinds(far)[-1] is BC
    # the limits meet at the rate 1 - 1/a = 1/5
    assert at(far[-1]) == pytest.approx((10.0, 8.0), abs=10 * COLLISION)
    assert far[-1].side == 1


def test_jump_of_the_second_map_down_to_point_a() -> None:
    """It ends at (0, 0), where its left piece (0, r/a) vanishes: bisected to 1e-11 at least."""
    second = iterate(paper(), 2)
    path = run(second, edge_near(second, 0.8, 1.0), -1)
    assert at(path[-1]) == pytest.approx((0.0, 0.0), abs=1e-10)
    assert_crossing(path, lambda r: r / A, "R | R / R | L")


def test_jump_of_the_second_map_ends_in_a_collision_at_point_a() -> None:
    """Its left limit r and its place r/a meet there: a fixed point and the jump collide."""
    second = iterate(paper(), 2)
    path = run(second, edge_near(second, 0.8, 1.0), -1)
    assert path[-1].kind is BC


@pytest.mark.parametrize("direction", [1, -1])
def test_words_of_a_straight_jump_do_not_change(direction: int) -> None:
    second = iterate(paper(), 2)
    path = run(second, edge_near(second, 0.8, 1.0), direction)
    assert WC not in kinds(path)


# --- a moving edge -------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [-0.9, 0.0, 0.3])
@pytest.mark.parametrize("direction", [1, -1])
def test_moving_edge(p: float, direction: int) -> None:
    """x = p/2 with limits x + p - 1 and x + p + 1: collisions at p = +-1, no change of words."""
    path = run(moving_edge, edge_near(moving_edge, 0.5 * p, p), direction)
    assert kinds(path) == [BC]
    assert path[-1].side == -direction
    assert at(path[-1]) == pytest.approx((direction, 0.5 * direction), abs=COLLISION)
    assert_crossing(path, lambda q: 0.5 * q, "L / R")


@pytest.mark.parametrize("width", [1e-4, 1e-9])
@pytest.mark.parametrize("direction", [1, -1])
def test_moving_edge_of_a_thin_piece(width: float, direction: int) -> None:
    """The right piece is narrower than the way the edge moves in one step: prediction finds it."""

    def thin(x: float, p: float) -> Evaluation:
        here = moving_edge(x, p)
        return here._replace(word="beyond") if x >= 0.5 * p + width else here

    path = run(thin, edge_between(thin, 0.3, 0.1, 0.15 + 0.5 * width), direction)
    assert kinds(path) == [BC]
    assert at(path[-1]) == pytest.approx((direction, 0.5 * direction), abs=COLLISION)
    assert_crossing(path, lambda q: 0.5 * q, "L / R")


def test_curved_edge() -> None:
    """x = sin(3 p) with limits one above and one below: prediction is not exact here."""

    def curved(x: float, p: float) -> Evaluation:
        edge = math.sin(3.0 * p)
        side = -1.0 if x < edge else 1.0
        return Evaluation(edge + side, 0.0, 3.0 * math.cos(3.0 * p), "L" if side < 0.0 else "R")

    for direction, end in ((1, 3.0), (-1, -2.0)):
        path = run(curved, edge_near(curved, 0.0, 0.0), direction)
        assert kinds(path) == [EP]
        assert at(path[-1]) == pytest.approx((end, math.sin(3.0 * end)), abs=COLLISION)
        assert_crossing(path, lambda q: math.sin(3.0 * q), "L / R")


def test_steep_edge() -> None:
    """x = 5 p: the edge moves farther per step than it can be seen without prediction."""

    def steep(x: float, p: float) -> Evaluation:
        side = -1.0 if x < 5.0 * p else 1.0
        return Evaluation(5.0 * p + side, 0.0, 5.0, "L" if side < 0.0 else "R")

    path = run(steep, edge_near(steep, 0.5, 0.1), 1)
    assert kinds(path) == [EP]
    assert at(path[-1]) == pytest.approx((3.0, 15.0), abs=10 * COLLISION)


# --- ends and changes of word --------------------------------------------------------------------


@pytest.mark.parametrize(("direction", "end"), [(1, 0.5), (-1, -0.25)])
def test_end_of_the_span_is_met_exactly(direction: int, end: float) -> None:
    path = run(moving_edge, edge_near(moving_edge, 0.0, 0.0), direction, span=(-0.25, 0.5))
    assert kinds(path) == [EP]
    assert path[-1].note == "end of the parameter span"
    assert path[-1].p == end
    assert path[-1].edge.x == pytest.approx(end / 2.0, abs=math.ulp(1.0))


def test_end_of_the_window() -> None:
    """At most one step beyond the bound: 0.02 along the jump, 0.009 of it in x."""
    path = run(moving_edge, edge_near(moving_edge, 0.0, 0.0), 1, window=(-0.1, 0.2))
    assert kinds(path) == [EP]
    assert path[-1].note == "end of the window"
    assert 0.2 - COLLISION <= path[-1].edge.x <= 0.209
    assert all(point.edge.x <= 0.2 for point in path[:-1])


def test_words_change_along_a_jump() -> None:
    """The right piece is called R1 for p < -0.6: the branch goes on with its new words."""

    def renamed(x: float, p: float) -> Evaluation:
        here = two_lines()(x, p)
        return here._replace(word=here.word + ("1" if p < -0.6 else "2")) if x >= 0.0 else here

    path = run(renamed, edge_near(renamed, 0.0, -0.3), -1)
    assert kinds(path) == [WC, BC]
    change = next(k for k, point in enumerate(path) if point.kind is WC)
    assert not path[change].ends
    # not the last bit: Tolerances say 1e-11, and the piece beyond is found within 4 times that
    assert path[change].p == pytest.approx(-0.6, abs=4 * RESOLVED)
    assert path[change + 1].p == pytest.approx(-0.6, abs=10 * RESOLVED)
    assert {point.edge.right.word for point in path[: change + 1]} == {"R2"}
    assert {point.edge.right.word for point in path[change + 1 :]} == {"R1"}
    assert {point.edge.left.word for point in path} == {"L"}
    assert at(path[-1]) == pytest.approx((-1.0, 0.0), abs=COLLISION)


def test_jump_that_ends() -> None:
    """For p > 0.25 there is one piece only."""

    def healed(x: float, p: float) -> Evaluation:
        return two_lines()(x, p - 0.5) if p <= 0.25 else Evaluation(1.0 - 0.5 * x, -0.5, 0.0, "S")

    path = run(healed, edge_near(healed, 0.0, 0.0), 1)
    assert kinds(path) == [EP]
    assert path[-1].note == "the jump ends"
    assert path[-1].p == pytest.approx(0.25, abs=2 * RESOLVED)


def test_jump_beside_which_the_map_is_lost() -> None:
    """For p > 0.25 the right piece has no value: the branch ends in FALL, with the reason."""

    def lost(x: float, p: float) -> Evaluation:
        if x < 0.0:
            return Evaluation(0.5 * x - 1.0, 0.5, 0.0, "L")
        if p <= 0.25:
            return Evaluation(1.0 - 0.5 * x, -0.5, 0.0, "R")
        return Evaluation(math.nan, math.nan, math.nan, "free fall", False)

    path = run(lost, edge_near(lost, 0.0, 0.0), 1)
    assert path[-1].p == pytest.approx(0.25, abs=1e-8)
    assert path[-1].kind is FALL
    assert path[-1].note == "free fall"


def test_number_of_points_is_limited() -> None:
    chosen = Settings(span=(-2.0, 3.0), max_points=5)
    path = list(follow_jump(paper(), edge_near(paper(), 0.0, 1.0), chosen, 1))
    assert path[-1].kind is EP
    assert len(path) <= 6
