"""Stick and slip: on a belt, on two feet, under forces that vanish, beside another contact."""

import math
from collections.abc import Mapping
from itertools import permutations
from typing import Any

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NIGHTLY_SYSTEM
from scipy.optimize import brentq
from scipy.special import ellipk

from studies.systems import belt
from studies.systems.toy import system_of
from woodpecker import Toy
from woodpecker.systems import (
    Contact,
    ContactSystem,
    MotionStatus,
    Section,
    SystemMap,
    continuation,
    shoot,
    simulate,
)

# --- The stick-slip oscillator on a belt against its closed form ----------------------------------


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize(("v", "d"), [(0.3, 0.1), (0.5, 0.4)])
def test_stick_slip_is_that_of_the_closed_form(v: float, d: float, backend: str) -> None:
    """From a guess that sticks, too; the belt's speed is a parameter with derivatives."""
    map_ = belt.map_of("v", backend=backend).holding(d=d)
    exact, slope = belt.lowest(v, 1.0, d), belt.lowest(1.0, 0.0, d)
    cycle = shoot(map_, [exact + 0.05], p=[v])
    assert cycle.word == "J1 S1"
    assert cycle.x[0, 0] == pytest.approx(exact, abs=1e-10)
    assert abs(cycle.multipliers[0]) < 1e-10  # it forgets while it sticks
    image = map_.at(cycle.x[0], cycle.p)
    assert image.jacobian[0, 1] == pytest.approx(slope, abs=1e-9)


@pytest.mark.slow
def test_without_sticking_it_spirals_off() -> None:
    """Around the steady sliding, by exp(pi d/sqrt(1 - d**2/4)) in each turn."""
    d = belt.VALUES[belt.D]
    image = belt.map_of(backend="scipy").at(np.array([0.8]), np.zeros(0))
    assert image.piece.word == ""
    exact = math.exp(math.pi * d / math.sqrt(1.0 - 0.25 * d * d))
    assert image.jacobian[0, 0] == pytest.approx(exact, abs=1e-10)
    steady = 1.0 - d * belt.VALUES[belt.BELT]
    assert image.value[0] == pytest.approx(steady + exact * (0.8 - steady), abs=1e-10)


# --- A body on two feet: they have one slip, stick and slide together, and it may tip -------------

X, Y, TURN, V, W_TURN, T = sympy.symbols("x y turn u_x u_turn t")
G = 9.81
Values = Mapping[sympy.Symbol, float]
NONE: Values = {}


def body(
    force: sympy.Expr, height: Any, mu: Any, values: Values = NONE, other_height: Any = None
) -> ContactSystem:
    """One of mass 1 and inertia 0.3 on feet 1 to both sides, its centre at a height above them.

    The height may be written in another way at the front foot.
    """
    heights = height, height if other_height is None else other_height
    feet = [
        Contact(name=name, gap=Y + side * TURN, slip=V + each * W_TURN, mu=mu)
        for name, side, each in zip(("rear foot", "front foot"), (-1, 1), heights, strict=True)
    ]
    return ContactSystem([X, Y, TURN], sympy.diag(1, 1, 0.3), [force, -G, 0], feet, values)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "other"),
    [(0.3, 3 * sympy.Float(0.1)), (1 + sympy.sqrt(2), sympy.sqrt(3 + 2 * sympy.sqrt(2)))],
)
def test_feet_slide_as_one_contact_however_their_slips_are_written(height: Any, other: Any) -> None:
    push = 5 * sympy.sin(3 * T)
    systems = body(push, height, 0.3), body(push, height, 0.3, other_height=other)
    assert systems[1].contacts[0].slip != systems[1].contacts[1].slip
    motions = [simulate(each, {}, 1.0, backend="scipy") for each in systems]
    assert motions[1].status is MotionStatus.TIME_REACHED
    assert motions[0].word == motions[1].word == "S1 S2"
    assert motions[0].z == pytest.approx(motions[1].z, abs=1e-13)


@EACH_BACKEND
def test_a_high_body_tips_while_its_feet_stick(backend: str) -> None:
    """A push R t at a height of 2 lifts the rear foot where its moment is that of the weight."""
    rate = 4.0
    motion = simulate(body(rate * T, 2.0, 0.6), {}, 1.5, backend=backend)
    assert motion.word.split()[0] == "D1"
    assert motion.events[0].time == pytest.approx(G / (2.0 * rate), abs=1e-14)


@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_a_shaken_block_flat_on_its_corners_is_a_particle(unit: float) -> None:
    """Its corners have one slip only where both are closed, as its finite rotation then is zero.

    Rounding of that rotation made them slide one by one, or the forces have no solution. A particle
    shaken with a sin(w t) starts to slide where this exceeds mu g, and stops by its momentum.
    """
    x, y, turn, t = sympy.symbols("x y p t")
    wide, high, mu, g, a, w = 0.3 * unit, 0.5 * unit, 0.3, 9.81 * unit, 4.0 * unit, 5.0
    sides = [high * sympy.cos(turn) + side * wide * sympy.sin(turn) for side in (1, -1)]
    corners = [
        Contact(name=f"corner {k}", gap=y - arm, slip=V + arm * sympy.Symbol("u_p"), mu=mu)
        for k, arm in enumerate(sides)
    ]
    inertia = sympy.diag(1.0, 1.0, 0.12 * unit**2)
    block = ContactSystem([x, y, turn], inertia, [a * sympy.sin(w * t), -g, 0], corners, {})
    motion = simulate(block, {y: high, V: 0.3 * unit}, 2.6, backend="scipy")
    assert motion.word == "J1 J2 S1 S2 J1 J2 S1 S2 J1 J2 S1 S2 J1 J2"
    exceeds = math.asin(mu * g / a)
    begins, sign, v, exact = 0.0, -1.0, 0.3 * unit, list[float]()  # sign of friction
    for k in range(4):

        def speed(s: float, b: float = begins, v: float = v, sign: float = sign) -> float:
            pushed = a / w * (math.cos(w * b) - math.cos(w * s))
            return v + pushed + sign * mu * g * (s - b)

        stops = brentq(speed, begins + 0.1, (math.pi * k + math.pi) / w + 0.05, xtol=1e-15)
        begins, sign, v = (math.pi * (k + 1) + exceeds) / w, -sign, 0.0
        exact += [stops, stops, begins, begins]
    times = [each.time for each in motion.events]
    assert times == pytest.approx(exact[: len(times)], abs=1e-11)  # of DOP853


# --- Forces that are powers of what is exactly zero at a start: no nan of them --------------------

R, U, STIFF = sympy.symbols("x u_x k")


def spring() -> ContactSystem:
    """A mass on a cubic spring, far from a stop."""
    stop = Contact(name="the stop", gap=R + 10)
    return ContactSystem([R], [[1]], [-STIFF * R**3], [stop], {STIFF: 1.0})


@pytest.mark.nightly
@EACH_BACKEND
def test_a_cubic_spring_from_the_middle(backend: str) -> None:
    """From speed 1 a period takes 4 K(1/2)/a, where a = 2**(1/4) is the amplitude."""
    section = Section(when=R, free=[U], horizon=100.0)
    map_ = SystemMap(spring(), section, ["k"], backend=backend)
    image = map_.at(np.array([1.0]), np.array([1.0]))
    assert image.value == pytest.approx([1.0], abs=1e-12)  # it rises through zero once in a period
    period = 4.0 * ellipk(0.5) / 2.0**0.25
    motion = simulate(spring(), {"u_x": 1.0}, period, backend=backend)
    assert motion.status is MotionStatus.TIME_REACHED
    assert motion.z[:2] == pytest.approx([0.0, 1.0], abs=1e-12)


@EACH_BACKEND
def test_friction_that_varies_with_the_slip_where_it_sticks(backend: str) -> None:
    """A mass is carried by a belt until the spring equals friction, at x = 1.5 and t = 1.5."""
    y = sympy.Symbol("y")
    slip = U - 1
    belt = Contact(name="the belt", gap=y, slip=slip, mu=1.5)
    force = [-R + 1.5 * slip - 0.45 * slip**3, -1]
    brick = ContactSystem([R, y], [[1, 0], [0, 1]], force, [belt], {})
    motion = simulate(brick, {"x": 0.0, "u_x": 1.0}, 2.0, backend=backend)
    assert motion.word == "S1"
    assert motion.events[0].time == pytest.approx(1.5, abs=1e-12)


@EACH_BACKEND
def test_a_motion_that_is_lost_at_once_says_so(backend: str) -> None:
    """A force without a value at the start: a status with a sentence, and the start is kept."""
    y = sympy.Symbol("y")
    floor = Contact(name="floor", gap=y)
    lost = ContactSystem([R, y], [[1, 0], [0, 1]], [1 / R, -1], [floor], {})
    motion = simulate(lost, {"y": 1.0}, 1.0, backend=backend)
    assert not motion.status.success
    assert not motion.events
    assert motion.q[0].tolist() == [0.0, 1.0]


@EACH_BACKEND
@pytest.mark.parametrize("value", [0.3, 0.5, 0.9])
def test_a_ball_comes_to_rest_with_a_restitution_that_heyoka_cannot_differentiate(
    value: float, backend: str
) -> None:
    """No flow needs it: it falls for 1 s, and is at rest after 2 eps/(1 - eps) s more."""
    eps = sympy.Symbol("eps")
    floor = Contact(name="floor", gap=R, eps_n=sympy.Max(eps, sympy.Rational(1, 4)))
    ball = ContactSystem([R], [[1]], [-10], [floor], {eps: value})
    motion = simulate(ball, {"x": 5.0}, 100.0, backend=backend)
    assert (motion.word, motion.status) == ("C1", MotionStatus.AT_REST)
    assert motion.events[-1].time == pytest.approx(1.0 + 2.0 * value / (1.0 - value), rel=1e-13)


# --- An impact where another contact is closed: its word does not hang on rounding ----------------

ROUNDING = 1e-13  # of a velocity of 1, after some thousand operations
EPS, MU = 0.5, 0.1


def two_contacts() -> ContactSystem:
    """A body that slides along the ground, on to a wall that leans over it."""
    x, y, s, u, v, slip = sympy.symbols("x y s u_x u_y u_s")
    ground = Contact(name="ground", gap=y, slip=slip, mu=MU, eps_n=EPS)
    wall = Contact(name="wall", gap=1 - x - y / 2, eps_n=EPS)
    mass = sympy.diag(1, 2, 1)
    return ContactSystem([x, y, s], mass, [0, -1, 0], [ground, wall], {}, u=[u, v, slip])


@pytest.mark.parametrize("wrong", [-ROUNDING, 0.0, ROUNDING])
def test_the_ground_keeps_its_case(wrong: float) -> None:
    """With one restitution and no change of sliding the expansion is the compression times it.

    So the gap rate of the ground is zero after both, and its impulse just what it has to give back:
    it rests, and that is what the word says.
    """
    start = {"x": 1.0, "u_x": 1.0, "u_y": wrong, "u_s": 1.0}
    impact, *_ = simulate(two_contacts(), start, 0.1, backend="scipy").events
    assert impact.symbol == "I1-r+2"
    # By hand, with forces (0, 1) and (-1, -1/2) of ground and wall on (x, y): x stops by the wall's
    # impulse 1, the ground's is half of it; both come back EPS times, and friction along s.
    assert impact.impulses[:, 0] == pytest.approx(np.array([[0.5, 1.0], [0.5 * EPS, EPS]]))
    u = [-EPS, 0.0, 1.0 - MU * 0.5 * (1.0 + EPS)]
    assert impact.after == pytest.approx(u, abs=10 * ROUNDING)


@NIGHTLY_SYSTEM
def test_a_closed_contact_does_not_drift() -> None:
    """The jammed sleeve stays where it is to the last bit while the bird swings; then it slides."""
    toy = Toy(eps_n1=0.5)
    system, _ = system_of(toy)
    jammed = -(toy.r_m - toy.r_0) / toy.h_m
    motion = simulate(system, {"phi_m": jammed, "phi_s": -0.53}, 0.034)
    assert motion.word == "S2"
    assert (motion.q[:, 1] == jammed).all()
    assert not motion.u[:, 1].any()


# --- Events of several contacts in one instant ----------------------------------------------------

WEIGHT = 1.0


def two_blocks(force: sympy.Expr, side: float, values: Values) -> ContactSystem:
    """Two blocks, each on a floor of its own; the other one is the first times ``side``."""
    x, y, u = (sympy.symbols(f"{name}1 {name}2") for name in ("x", "y", "u_x"))
    floors = [
        Contact(name=f"floor {k + 1}", gap=y[k], slip=u[k], mu=sympy.Symbol("mu")) for k in (0, 1)
    ]
    forces = [force.subs(X, x[0]), side * force.subs(X, side * x[1]), -WEIGHT, -WEIGHT]
    return ContactSystem([*x, *y], sympy.eye(4), forces, floors, values)


PUSH, MU_OF = sympy.symbols("push mu")


@EACH_BACKEND
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("push", "mu", "letters"), [(0.0, 0.3, "J"), (0.7, 0.3, "RRR")])
def test_two_blocks_do_the_same_in_the_same_instants(
    backend: str, side: int, push: float, mu: float, letters: str
) -> None:
    """They stop, or turn round, at once: each does so once, as one block alone does."""
    system = two_blocks(PUSH * sympy.cos(T), side, {PUSH: push, MU_OF: mu})
    start = {"u_x1": 1.0, "u_x2": side}
    motion = simulate(system, start, 10.0, backend=backend, max_events=20)
    assert motion.status in (MotionStatus.TIME_REACHED, MotionStatus.AT_REST)
    assert sorted(motion.word.split()) == sorted(f"{each}{k}" for each in letters for k in (1, 2))
    times = [event.time for event in motion.events]
    assert times[::2] == pytest.approx(times[1::2], abs=1e-14)
    if not push:
        assert motion.z[:2] == pytest.approx([1 / 0.6, side / 0.6], abs=1e-14)  # u**2 / (2 mu g)


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize("start", [[0.2, 0.3], [0.0, 0.5]])
@pytest.mark.parametrize("mu", [0.3, 0.6])
def test_two_blocks_in_step_have_the_derivatives_of_one(
    backend: str, start: list[float], mu: float
) -> None:
    """Though all their events are of both: they turn round (mu 0.3), or stick for a while."""
    force, values = PUSH * sympy.cos(T) - X / 10, {PUSH: 0.7, MU_OF: mu}
    ground = Contact(name="ground", gap=Y, slip=V, mu=MU_OF)
    one = ContactSystem([X, Y], sympy.eye(2), [force, -WEIGHT], [ground], values)
    images = []
    for system in (one, two_blocks(force, 1, values)):
        count = system.n // 2
        free = [each for k in range(count) for each in (system.q[k], system.state[system.n + k])]
        section = Section(when=sympy.sin(T), free=free, at={T: 0})
        map_ = SystemMap(system, section, ["push", "mu"], backend=backend)
        images.append(map_.at(np.tile(start, count), map_.p))
    alone, both = images
    assert both.value == pytest.approx(np.tile(alone.value, 2), abs=1e-13)
    exact = np.hstack(
        [np.kron(np.eye(2), alone.jacobian[:, :2]), np.tile(alone.jacobian[:, 2:], (2, 1))]
    )
    assert both.jacobian == pytest.approx(exact, abs=1e-12)


@EACH_BACKEND
def test_two_masses_leave_the_ground_in_one_instant(backend: str) -> None:
    """At sin t = 1/2; none of them strikes it again."""
    lift, heights = sympy.sin(T) - sympy.Rational(1, 2), sympy.symbols("a b")
    floors = [Contact(name=f"under {each}", gap=each) for each in heights]
    pair = ContactSystem(heights, sympy.eye(2), [lift, 3 * lift], floors, {})
    motion = simulate(pair, {}, 1.5, backend=backend)
    assert sorted(motion.word.split()) == ["D1", "D2"]
    after = 1.5 - math.pi / 6
    height = math.sqrt(0.75) * after - math.sin(1.5) + 0.5 - after**2 / 4
    assert motion.z[:2] == pytest.approx([height, 3 * height], abs=1e-14)


# --- More feet than are needed --------------------------------------------------------------------


def on_feet(
    places: tuple[float, ...], forces: list[Any], mu: float, values: Values = NONE,
    mass: float = 1, length: float = 1,
) -> ContactSystem:  # fmt: skip
    """A body of weight 10 on feet at these places, with the slip of its centre, in any units."""
    rubs = {"slip": V, "mu": mu} if mu else {}
    feet = [
        Contact(name=f"foot {k}", gap=Y + length * place * TURN, eps_n=0.5, **rubs)
        for k, place in enumerate(places)
    ]
    (along, about), force = forces, mass * length
    loads = [along * force, -10 * force, about * force * length]
    inertia = sympy.diag(mass, mass, 0.3 * mass * length**2)
    return ContactSystem([X, Y, TURN], inertia, loads, feet, values)


FEET = [(-1, 0, 1), (-1, -1, 1), (-1, -0.3, 0.3, 1)]


@pytest.mark.nightly
@pytest.mark.parametrize("places", FEET)
def test_more_feet_than_are_needed_slide_as_two(places: tuple[float, ...]) -> None:
    """How they share the weight is open; all of them stick and slip, and none leaves the ground."""
    push = [4 * sympy.sin(T), 0]
    motion, two = (simulate(on_feet(each, push, 0.3), {}, 6.0, backend="scipy", max_events=50)
                   for each in (places, (-1, 1)))  # fmt: skip
    assert two.word == "S1 S2 J1 J2 S1 S2"
    names = [" ".join(f"{letter}{k + 1}" for k in range(len(places))) for letter in "SJS"]
    assert motion.word == " ".join(names)
    assert motion.z == pytest.approx(two.z, abs=1e-13)


@pytest.mark.parametrize(("mass", "length"), [(1.0, 1.0), (1e-9, 1.0), (1e-12, 1e-6), (1e9, 1e3)])
@pytest.mark.parametrize(("mu", "rests"), [(0.35, True), (0.25, False)])
def test_a_body_on_three_feet_slides_in_all_units(
    mass: float, length: float, mu: float, rests: bool
) -> None:
    """On a slope of 0.3 it does where mu is less, also under forces of 1e-17 N."""
    body = on_feet((-1, 0, 1), [3, 0], mu, mass=mass, length=length)
    motion = simulate(body, {}, 2.0, backend="scipy")
    assert motion.word == ("" if rests else "S1 S2 S3")
    assert motion.z[0] / length == pytest.approx(0.0 if rests else 1.0, abs=1e-12)


@pytest.mark.parametrize("places", list(permutations((-1, 0, 1))))
def test_the_order_of_feet_does_not_matter(places: tuple[float, ...]) -> None:
    """A body falls flat on three, and slides on until friction, 0.2 of all impulses, stops it."""
    feet = [
        Contact(name=f"foot {k}", gap=Y + sympy.Float(place) * sympy.sin(TURN), slip=V, mu=0.2)
        for k, place in enumerate(places)
    ]
    body = ContactSystem(
        [X, Y, TURN], sympy.diag(1, 1, sympy.Rational(1, 3)), [0, -10, 0], feet, {}
    )
    motion = simulate(body, {"y": 0.5, "u_x": 2.0}, 2.0, backend="scipy")
    assert motion.status.name == "AT_REST"  # held by all feet, not balanced on the middle one
    assert sorted(motion.word.split()[1:]) == ["J1", "J2", "J3"]
    assert motion.z[-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.nightly
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("places", FEET)
def test_a_body_on_many_feet_tips_about_the_last(places: tuple[float, ...], mu: float) -> None:
    """Where a moment 3 t is that of the weight, 10: all other feet leave in that instant."""
    motion = simulate(on_feet(places, [0, 3 * T], mu), {}, 4.0, backend="scipy", max_events=50)
    turned = [k + 1 for k, place in enumerate(places) if place > -1]
    assert motion.word == " ".join(f"D{k}" for k in turned)
    times = [event.time for event in motion.events]
    assert times == pytest.approx([10 / 3] * len(times), abs=1e-13)
    # about the last foot 1.3 phi'' = 3 t - 10
    assert motion.z[2] == pytest.approx((2 / 3) ** 3 / 2.6, abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("places", [(-1, 1), *FEET, (-1, -0.5, 0, 0.5, 1)])
def test_a_body_falls_flat_on_many_feet(places: tuple[float, ...], mu: float) -> None:
    """It bounces as a ball does: rest comes after (1 + 2 eps/(1 - eps)) sqrt(2 h/g)."""
    system = on_feet(places, [0, 0], mu)
    motion = simulate(system, {"y": 1.0, "u_x": 1.0}, 6.0, backend="scipy", max_events=200)
    rest = [e.time for e in motion.events if e.symbol[0] == "C"]
    assert rest == pytest.approx([3 * math.sqrt(0.2)], abs=1e-13)
    assert motion.word.split()[-1][0] == ("J" if mu else "C")
    assert motion.z[1:3] == pytest.approx([0, 0], abs=1e-14)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1)])
def test_a_body_that_falls_flat_does_not_turn_though_impulses_are_open(order: list[int]) -> None:
    """Its outer feet give back 0.6, the inner ones 0.2; how they share the impulse is a polygon.

    At its vertices one foot on either side takes all: in the mean 5/24 for each outer foot.
    """
    feet = [
        Contact(name=f"foot {place}", gap=Y + place * TURN, eps_n=eps)
        for place, eps in ((-2, 0.6), (-1, 0.2), (1, 0.2), (2, 0.6))
    ]
    system = ContactSystem([Y, TURN], sympy.eye(2), [-10, 0], [feet[k] for k in order], {})
    (event,) = simulate(system, {"y": 1.0}, 0.6, backend="scipy").events
    assert event.symbol[:2] == "I~"
    kept = 0.6 * 10 / 24 + 0.2 * 14 / 24
    assert event.after == pytest.approx([kept * math.sqrt(20), 0.0], abs=1e-14)


# --- Contacts that hold each other ----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.0, 0.2])
@pytest.mark.parametrize("start", [0.5, 1.0])
def test_a_block_is_pushed_into_a_corner_and_out(mu: float, start: float) -> None:
    """Ground and wall share the push 5 sin t as they may; the ground alone holds 3 of a pull."""
    ground = Contact(name="the ground", gap=Y, slip=V, mu=0.3)
    rubs = {"slip": sympy.Symbol("u_y"), "mu": mu} if mu else {}
    wall = Contact(name="the wall", gap=1 - X, **rubs)
    corner = ContactSystem([X, Y], sympy.eye(2), [5 * sympy.sin(T), -10], [ground, wall], {})
    motion = simulate(corner, {"x": start}, 9.5, backend="scipy", max_events=20)
    assert motion.status is MotionStatus.TIME_REACHED
    assert motion.word.endswith("S1 D2 J1 S1")
    slips = math.pi + math.asin(0.6)
    stops = brentq(lambda t: 3 * (t - slips) - 5 * math.cos(t) - 4, slips + 1, slips + 5)
    times = [event.time for event in motion.events[-4:]]
    assert times == pytest.approx([slips, slips, stops, slips + math.pi], abs=1e-12)
    assert motion.word[: -len(" S1 D2 J1 S1")] in ("", "S1 I1+2 J1", "S1 I1f+2s J1 J2")


def row(push: sympy.Expr, count: int = 3) -> ContactSystem:
    """Blocks in a row that touch, of weight 10, on rough ground; the first is pushed."""
    x, y, u = (sympy.symbols(f"{name}1:{count + 1}") for name in ("x", "y", "u_x"))
    floors = [Contact(name=f"under {k}", gap=y[k], slip=u[k], mu=0.2) for k in range(count)]
    between = [
        Contact(name=f"behind {k}", gap=x[k + 1] - x[k], eps_n=0.5) for k in range(count - 1)
    ]
    forces = [push, *[0] * (count - 1), *[-10] * count]
    return ContactSystem([*x, *y], sympy.eye(2 * count), forces, [*floors, *between], {})


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 5])
def test_blocks_in_a_row_start_together(count: int) -> None:
    """As a push 2 t reaches the friction of all n, 2 n: then n x'' = 2 t - 2 n.

    Of five there are 16 384 combinations of states.
    """
    motion = simulate(row(2 * T, count), {}, count + 2.0, backend="scipy", max_events=20)
    assert motion.word == " ".join(f"S{k + 1}" for k in range(count))
    times = [event.time for event in motion.events]
    assert times == pytest.approx([count] * count, abs=1e-13)
    places = [8 / 3 / count] * count + [0] * count
    assert motion.z[: 2 * count] == pytest.approx(places, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 4])
def test_a_block_strikes_a_row(count: int) -> None:
    """All get u / count in compression, and none jumps.

    The impulses between them fall by u / count from one to the next, and half of them are given
    back: every block gets u / (2 count) more, and the first one is thrown back by u / 2.
    """
    speed = math.sqrt(12.0)  # of 4 after 1 m with a deceleration of 2
    motion = simulate(row(sympy.Integer(0), count), {"x1": -1.0, "u_x1": 4.0}, 5.0, backend="scipy")
    assert motion.status is MotionStatus.AT_REST
    strike = motion.events[0]
    assert strike.before[0] == pytest.approx(speed, abs=1e-13)
    assert strike.after.sum() == pytest.approx(speed, abs=1e-13)
    assert strike.after[count:] == pytest.approx(np.zeros(count), abs=1e-14)
    after = np.full(count, 1.5 / count)
    after[0] -= 0.5
    assert strike.after[:count] == pytest.approx(speed * after, abs=1e-13)
    assert motion.z[count : 2 * count] == pytest.approx(np.zeros(count), abs=1e-14)


# --- Lengths far from 1 ---------------------------------------------------------------------------


@NIGHTLY_SYSTEM
@pytest.mark.parametrize(("x_scale", "p_scale"), [((1e-3, 0.3), (20.0,)), (None, None)])
def test_a_machine_in_si_units_is_followed_past_a_stop_that_ends(
    x_scale: tuple[float, ...] | None, p_scale: tuple[float, ...] | None
) -> None:
    """A lever of 2.5 kg that rattles in a gap of half a millimetre and rubs in its guide.

    While it rests nothing but the force changes: a step of the motion alone is as long as the
    horizon, and says nothing of when the guide slips. What begins where the stop ends leads away
    from there, also if its border is located next to its piece.
    """
    x, y, v, t, f = sympy.symbols("x y u_x t F")
    w = 40 * sympy.pi
    stop = Contact(name="the stop", gap=sympy.Rational(1, 2000) - x, eps_n=0.6)
    guide = Contact(name="the guide", gap=y, slip=v, mu=0.15)
    force = [f * sympy.cos(w * t) - 40_000 * x - 20 * v, -2.5 * 9.81]
    lever = ContactSystem([x, y], [[2.5, 0], [0, 2.5]], force, [stop, guide], {f: 34.6})
    section = Section(when=sympy.sin(w * t), free=[x, v], at={t: 0})
    map_ = SystemMap(lever, section, ["F"], x_scale=x_scale, p_scale=p_scale)
    cycle = shoot(map_, [3.6e-4, 0.19])
    window = [(-0.003, 0.001), (-1.0, 1.0)]
    found = continuation(map_, cycle, (34.3, 34.7), window, orders=(1,))
    (branch,) = found.diagram.branches
    assert {part.word for part in branch.words} == {"I1+2 J2 S2 R2", "I1+2 R2"}
    assert branch.parameter[[0, -1]].tolist() == [34.3, 34.7]
    for k in (0, -1):  # the motion itself comes back, too
        start = {"x": branch.x[k], "u_x": branch.columns["u_x"][k]}
        motion = simulate(lever.replace(F=float(branch.parameter[k])), start, t_end=0.05)
        end = motion.q[-1, 0], motion.u[-1, 0]
        assert end == pytest.approx(tuple(start.values()), abs=1e-10)


# --- Sections at which contacts rest although their coordinates are free --------------------------


def pushed(places: tuple[float, ...], force: float, phase: float) -> SystemMap:
    """The speed of a body on feet, mu = 0.3 and weight 10, once in a period of a push."""
    system = on_feet(places, [PUSH * sympy.sin(3 * T), 0], 0.3, {PUSH: force})
    section = Section(when=sympy.sin(3 * T - phase), free=[V], at={T: phase / 3})
    return SystemMap(system, section, ["push"], backend="scipy")


@pytest.mark.nightly
def test_a_section_on_which_a_body_sticks() -> None:
    """What slips a little there stops at once, whichever way: the return does not depend on it."""
    map_ = pushed((-1, 1), 3.8, 0.0)
    for speed in (0.0, 1e-14, -1e-14):
        image = map_.at(np.array([speed]), map_.p)
        assert image.piece.word.split()[:2] == ["S1", "S2"]
        assert np.abs(image.value) < 1e-14
        assert np.abs(image.jacobian).max() < 1e-14


@pytest.mark.nightly
@pytest.mark.parametrize("speed", [0.0, -1e-17, 1e-17])
def test_a_slip_that_turns_round_on_the_section_is_no_return(speed: float) -> None:
    """The push 20 sin 3 t is never less than the friction where it turns: it slips both ways."""
    start, period = 1.0 / 3.0, 2.0 * math.pi / 3.0

    def forth(t: float) -> float:
        return 20 / 3 * (math.cos(1.0) - math.cos(3 * t)) - 3 * (t - start)

    turn = float(brentq(forth, start + 0.5, start + period, xtol=1e-15))
    back = 20 / 3 * (math.cos(3 * turn) - math.cos(1.0)) + 3 * (start + period - turn)
    map_ = pushed((0,), 20.0, 1.0)
    assert map_.at(np.array([speed]), map_.p).value == pytest.approx([back], abs=1e-12)


@NIGHTLY_SYSTEM
def test_a_branch_along_which_three_feet_stick_on_the_section() -> None:
    """Up to the push f that the friction stops just there, f + sqrt(f**2 - 9) = 3 (pi - asin(3/f)).

    From t1 = asin(3/f)/3 until then, at pi/3, the integral of f sin 3 t - 3 is zero.
    """
    own = pushed((-1, 0, 1), 3.8, 0.0)
    map_ = SystemMap(own.system, own.section, own.parameters)
    diagram = continuation(map_, shoot(map_, [0.0]), (3.5, 4.5), [(-5, 5)], orders=(1,)).diagram
    limit = brentq(lambda f: f + math.sqrt(f * f - 9) - 3 * (math.pi - math.asin(3 / f)), 3.1, 5)
    (branch,) = diagram.branches
    assert [point.parameter for point in diagram.points] == pytest.approx([3.5, 4.5])
    sticks = branch.parameter < limit
    assert np.abs(branch.x[sticks]).max() < 1e-12
    assert np.abs(branch.multiplier).max() < 1e-9  # it forgets while it sticks
    changes = branch.parameter[[each.first for each in branch.words[1:]]]
    assert np.abs(changes - limit).min() < 1e-9
    assert len(branch.parameter) < 100
