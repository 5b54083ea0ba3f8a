"""Instances against closed forms and against the closed-form kernel of the toy."""

import math
from collections.abc import Callable
from dataclasses import asdict

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA, NIGHTLY_SYSTEM, SLOW_TOY

from pwmap import PointKind
from studies.common.random_toys import random_toy
from studies.systems import den_hartog, table
from studies.systems.toy import map_of
from woodpecker import Toy
from woodpecker import return_map as kernel_map
from woodpecker.systems import (
    Contact,
    ContactSystem,
    CycleStatus,
    MotionStatus,
    Section,
    SystemMap,
    continuation,
    return_map,
    shoot,
    simulate,
)

SLOPES = 1e-8  # relative to 1 + the slope


def compare(law: str, numbers: range, *, equal: bool = False) -> None:
    """Five returns of each of some random toys: the same words and statuses, images and slopes.

    Derivatives along a path are of the general method by variational equations, of the kernel by
    closed forms. Nearly grazing motions decide how far they are apart: a rounding of the start
    changes slopes of 5e3 and 7e5 by 2e-10 and 5e-10 of themselves, so some twenty such roundings
    may come together before the grazing. If closed contacts drift, there are a hundred.
    """
    map_ = map_of(Toy(expansion_friction=law))
    names = {str(symbol) for symbol in map_.system.parameters}
    for number in numbers:
        drawn = random_toy(number)
        toy = drawn.toy.replace(expansion_friction=law)
        if equal:  # then impacts at two contacts often have several solutions with one motion
            eps = 0.125 * (number % 4)
            toy = toy.replace(eps_n1=eps, eps_n2=eps, eps_n3=eps)
        x = np.random.default_rng(number).uniform(*drawn.window, size=5)
        exact = kernel_map(toy, x)
        values = {name: value for name, value in asdict(toy).items() if name in names}
        own = map_.holding(**values)
        found = return_map(own, x)
        assert found.words == tuple(exact.words)
        assert [each.name for each in found.status] == [each.name for each in exact.status]
        returns = np.isfinite(exact.phi_s)
        away = np.abs(found.images[:, 0] - exact.phi_s) / (1.0 + np.abs(exact.slope))
        assert away[returns].max(initial=0.0) < 1e-10
        for start, slope in zip(x, exact.slope, strict=True):
            image = own.at(np.array([start]), own.p)
            assert np.isfinite(slope) == (not image.reason)
            if not image.reason:
                assert abs(image.jacobian[0, 0] - slope) < SLOPES * (1.0 + abs(slope))


@NEEDS_HEYOKA
@SLOW_TOY
@pytest.mark.parametrize("law", ["summed", "separate"])
@pytest.mark.parametrize(
    "numbers", [range(17, 21), pytest.param(range(200), marks=pytest.mark.nightly)]
)
def test_random_returns_of_random_toys(numbers: range, law: str) -> None:
    """Number 18 and 20 have an indeterminate impact, of which both ends are named; 11 grazes."""
    compare(law, numbers)
    compare(law, range(21, 25), equal=True)


@pytest.mark.parametrize("eps", [0.2, 0.5, 0.8])
@EACH_BACKEND
def test_ball_on_a_table_folds_and_flips(eps: float, backend: str) -> None:
    """A multiplier is -1 at the flip, and the orbit closes between fold and flip."""
    map_, (low, high) = table.map_of("Gamma", backend=backend).holding(eps=eps), table.limits(eps)
    for gamma in (0.5 * (low + high), high):
        x = table.orbit(gamma, eps)
        image = map_.at(x, np.array([gamma]))
        assert image.value == pytest.approx(x, abs=1e-10)
        jacobian = image.jacobian[:, :2]
        assert np.linalg.det(jacobian) == pytest.approx(eps**2, abs=1e-10)
    assert 1.0 + np.trace(jacobian) + eps**2 == pytest.approx(0.0, abs=1e-9)


def test_the_flip_of_the_inelastic_ball() -> None:
    """Gamma = sqrt(4 + pi^2) is the limit of the flip as the restitution goes to zero."""
    assert table.limits(0.0)[1] == pytest.approx(np.sqrt(4.0 + np.pi**2), abs=1e-15)


@NIGHTLY_SYSTEM
def test_continuation_of_the_ball_finds_fold_and_flip() -> None:
    points = {q.kind: q.parameter for q in table.followed(0.8).points}
    for kind, exact in zip((PointKind.LP, PointKind.PD), table.limits(0.8), strict=True):
        assert points[kind] == pytest.approx(exact, abs=1e-10)


STOPS, SLIDES = den_hartog.amplitude_with_stops, den_hartog.exact_amplitude


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize(
    ("w", "f", "exact"),
    [
        (0.6, 0.2, SLIDES), (1.4, 0.3, SLIDES), (2.2, 0.05, SLIDES),
        (0.6, 0.54, STOPS), (0.6, 0.8, STOPS), (0.7, 0.75, STOPS),
    ],
)  # fmt: skip
def test_amplitudes_of_den_hartog(
    w: float, f: float, exact: Callable[[float, float], float], backend: str
) -> None:
    assert (f > den_hartog.stops_from(w)) is (exact is STOPS)
    assert den_hartog.amplitude(w, f, backend=backend) == pytest.approx(exact(w, f), abs=1e-9)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_a_weakly_stable_cycle_of_den_hartog_is_followed_from_where_it_sticks() -> None:
    """Its multipliers are 0 and the squared cosine of the duration of a slide."""
    map_ = den_hartog.map_of("f").holding(w=0.34)
    cycle = shoot(map_, [1.0, -0.1], p=[0.13], transient=5)
    start = {"x": cycle.x[0, 0], "t": 0.0}
    events = simulate(map_.system.replace(f=0.13), start, 2 * math.pi / 0.34).events
    slip, stick = (next(e.time for e in events if e.symbol == name) for name in ("S1", "J1"))
    assert cycle.multipliers[0].real == pytest.approx(math.cos(stick - slip) ** 2, abs=1e-9)
    assert cycle.multipliers[0].real > 0.99
    found = continuation(map_, cycle, (0.125, 0.135), [(-3, 3), (-3, 3)], orders=(1,))
    ends = {(q.parameter, q.note) for q in found.diagram.points}
    assert ends == {(p, "end of the parameter span") for p in (0.125, 0.135)}


@NIGHTLY_SYSTEM
def test_stops_of_den_hartog_begin_where_the_closed_form_says() -> None:
    """The branch goes on there, with another word, and no special point is made of it."""
    diagram = den_hartog.followed(0.6)
    assert {q.kind for q in diagram.points} == {PointKind.EP}
    found, cause = den_hartog.border(diagram)
    assert found == pytest.approx(den_hartog.stops_from(0.6), abs=1e-9)
    assert cause == "the ground stops sliding where phase 1 begins"


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize("w", [0.6, 0.7])
def test_stops_of_den_hartog_begin_smoothly(w: float, backend: str) -> None:
    """With and without stops a return has one value and one slope at the border: no node."""
    map_, f = den_hartog.map_of("f", backend=backend).holding(w=w), den_hartog.stops_from(w)
    point, slope = den_hartog.at_border(w)
    followed = []
    for word, friction in (("R1 R1", f - 0.01), ("J1 S1 J1 S1", f + 0.01)):
        cycle = shoot(map_.holding(w=w, f=friction), point)
        beside = map_.at(cycle.x[0], np.array([friction]))
        assert beside.piece.word == word
        image = beside.piece.at(point, np.array([f]))
        assert image.value == pytest.approx(point, abs=1e-9)
        assert image.jacobian[:, :2] == pytest.approx(slope, abs=1e-9)
        followed.append(np.linalg.solve(np.eye(2) - image.jacobian[:, :2], image.jacobian[:, 2]))
    assert followed[0] == pytest.approx(followed[1], abs=1e-9)
    known = sorted(np.linalg.eigvals(slope).real)
    assert known == pytest.approx([0.0, np.cos(np.pi / w) ** 2], abs=1e-14)


@EACH_BACKEND
def test_a_brick_slides_sticks_and_is_carried(backend: str) -> None:
    """On a belt: it sticks as its speed reaches v, and slips where the spring equals friction."""
    x, z, ux, v = sympy.symbols("x z u_x v")
    belt = Contact(name="belt", gap=z, slip=ux - v, mu=0.3)
    brick = ContactSystem([x, z], [[1, 0], [0, 1]], [-x, -10], [belt], {v: 0.5})
    motion = simulate(brick, {"x": 5.0}, 8.0, backend=backend)
    assert motion.word == "J1 S1"
    stick, slip = (event.time for event in motion.events)
    # x = 3 + 2 cos(t) after release; turns back at x = 1 and goes up to v = sin(t') 2 against 3
    assert stick == pytest.approx(np.pi + np.arcsin(0.25), abs=1e-10)
    at_stick = 3.0 - 2.0 * np.cos(np.arcsin(0.25))
    assert slip - stick == pytest.approx((3.0 - at_stick) / 0.5, abs=1e-10)


EPS = 0.75


def to_a_wall(force: sympy.Expr, backend: str) -> SystemMap:
    """A particle of mass 1 once in each second; a wall is at 1."""
    x, u_x, t = sympy.symbols("x u_x t")
    wall = Contact(name="the wall", gap=1 - x, eps_n=EPS)
    system = ContactSystem([x], [[1]], [force], [wall], {})
    return SystemMap(
        system, Section(when=sympy.sin(2 * sympy.pi * t), free=[x, u_x], at={t: 0}), backend=backend
    )


@EACH_BACKEND
def test_a_return_starts_outside_of_contacts(backend: str) -> None:
    """At the wall a particle of speed 1 strikes at once, within rounding beyond it too."""
    free = to_a_wall(sympy.Integer(0), backend)
    found = return_map(free, [[1.0, 1.0], [1.0 + 1e-13, 1.0], [1.0, -1.0]])
    assert found.images == pytest.approx(np.array([[1 - EPS, -EPS]] * 2 + [[0, -1]]), abs=1e-12)
    assert found.words == ("I1", "I1", "")
    assert free.at(np.array([1.0 + 1e-13, 1.0]), np.zeros(0)).reason == ""
    inside = return_map(free, [[2.0, 0.0], [1.0 + 1e-9, 1.0], [1.5, -1.0]])
    assert set(inside.status) == {MotionStatus.INSIDE}
    assert np.isnan(inside.images).all()
    assert shoot(free, [2.0, 0.0]).status is CycleStatus.LOST


def test_which_path_is_taken_is_known_without_derivatives() -> None:
    free, none = to_a_wall(sympy.Integer(0), "scipy"), np.zeros(0)
    for x in ([0.5, 1.0], [0.5, -1.0]):
        path, value = free.taken(np.array(x), none)
        image = free.at(np.array(x), none)
        assert path == image.piece.key
        assert value == pytest.approx(image.value, abs=1e-12)
    path, value = free.taken(np.array([2.0, 0.0]), none)
    assert np.isnan(value).all()
    assert path.word == "the start penetrates 'the wall': its gap is -1"


@EACH_BACKEND
def test_a_return_may_start_at_rest_on_a_contact(backend: str) -> None:
    """What a force holds at the wall stays, what one of -cos^2 pulls off is 1/4 away after 1 s."""
    t = sympy.Symbol("t")
    push = sympy.cos(2 * sympy.pi * t) ** 2
    for force, image in ((push, [1.0, 0.0]), (-push, [0.75, -0.5])):
        found = return_map(to_a_wall(force, backend), [[1.0, 0.0]])
        assert found.images[0] == pytest.approx(image, abs=1e-11)


def test_a_bounce_begins_as_the_ball_leaves() -> None:
    y, u_y = sympy.symbols("y u_y")
    floor = Contact(name="floor", gap=y, eps_n=EPS)
    ball = ContactSystem([y], [[1]], [-1], [floor], {})
    found = return_map(SystemMap(ball, Section(when="floor", free=[u_y])), [-1.0, 0.0, 1.0])
    assert found.status == (MotionStatus.INSIDE, MotionStatus.AT_REST, MotionStatus.RETURNED)


@EACH_BACKEND
@pytest.mark.parametrize("height", 5.0 * 10.0 ** np.arange(-9, 13, 3))
def test_a_ball_is_dropped_from_any_height(height: float, backend: str) -> None:
    """It strikes after sqrt(2 h / g), though rounding of the height is more than most gaps."""
    y, g = sympy.symbols("y g")
    floor = Contact(name="floor", gap=y, eps_n=EPS)
    ball = ContactSystem([y], [[1]], [-g], [floor], {g: 10.0})
    falls = float(np.sqrt(2.0 * height / 10.0))
    motion = simulate(ball, {"y": height}, 2.0 * falls, backend=backend)
    assert motion.status is MotionStatus.TIME_REACHED
    assert [event.time for event in motion.events] == pytest.approx([falls], rel=1e-12)


@EACH_BACKEND
def test_a_body_may_fly_for_any_time(backend: str) -> None:
    """Its samples are x = 1 + t, though the 20th power of such times is no double."""
    x = sympy.Symbol("x")
    body = ContactSystem([x], [[1]], [0], [Contact(name="wall", gap=x)], {})
    motion = simulate(body, {"x": 1.0, "u_x": 1.0}, 1e18, samples=5, backend=backend)
    assert motion.q[:, 0] == pytest.approx(1.0 + motion.t, rel=1e-14)
