"""Impacts that accumulate at two contacts in turns: where and when they end, what they leave."""

import math

import mpmath
import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA
from scipy.optimize import fsolve

from woodpecker.base.arrays import Floats
from woodpecker.systems import (
    Contact,
    ContactSystem,
    MotionStatus,
    Section,
    SystemMap,
    shoot,
    simulate,
)

EPS, INERTIA, DRIFT = 0.2, 0.2, 2.0


def beam() -> ContactSystem:
    """A beam of mass 1 and half length 1 that falls on both of its ends, and drifts along x."""
    x, y, phi, g, eps = sympy.symbols("x y phi g eps")
    ends = [Contact(name=name, gap=y + side * phi, eps_n=eps) for name, side in ENDS]
    mass = sympy.diag(1, 1, INERTIA)
    return ContactSystem([x, y, phi], mass, [0, -g, 0], ends, {g: 1.0, eps: EPS})


ENDS = ("the left end", -1), ("the right end", 1)


def in_proportion() -> tuple[dict[str, float], float]:
    """A state after an impact of the left end, from which the next impact leaves its mirror image.

    It is smaller by a ratio r. After the impact the gaps are 0 and h, their rates 1 and b; at the
    next one, after t, the right end is thrown back by EPS and the left one pushed by kappa of it.
    Times of impacts are a geometric series: the beam rests after t / (1 - r), which comes, too.
    """
    kappa = (1.0 - 1.0 / INERTIA) / (1.0 + 1.0 / INERTIA)  # of W M^-1 W^T

    def away(unknown: Floats) -> list[float]:
        b, h, t, r = unknown
        hits = t - b
        return [
            h + b * t - 0.5 * t * t,
            r - EPS * hits,
            b * r - (1.0 - t + kappa * (1.0 + EPS) * hits),
            h * r * r - (t - 0.5 * t * t),
        ]

    b, h, t, r = fsolve(away, [-2.6, 0.6, 0.2, 0.6], xtol=1e-13)
    assert np.abs(away(np.array([b, h, t, r]))).max() < 1e-14
    assert h > 0.0
    assert 0.0 < r < 1.0
    start = {"y": 0.5 * h, "phi": 0.5 * h, "u_y": 0.5 * (1.0 + b), "u_phi": 0.5 * (b - 1.0)}
    return {"u_x": DRIFT, **start}, t / (1.0 - r)


@EACH_BACKEND
def test_a_beam_comes_to_rest_on_its_ends(backend: str) -> None:
    start, rest = in_proportion()
    motion = simulate(beam(), start, 10.0, backend=backend)
    assert motion.word == "C1+2"
    assert motion.status is MotionStatus.TIME_REACHED  # it drifts
    # rounding at the start, and in each of a dozen impacts until the rest is summed
    assert motion.events[-1].time == pytest.approx(rest, abs=1e-13)
    assert motion.z == pytest.approx([10 * DRIFT, 0, 0, DRIFT, 0, 0, 10.0], abs=1e-12)
    y, phi = motion.q[:, 1:].T  # samples do not go on into a contact while the rest is summed
    assert (y - np.abs(phi)).min() > -1e-12


@EACH_BACKEND
@pytest.mark.parametrize("away", [9.0, 1e9])
def test_a_beam_rests_long_before_it_rests_at_a_wall(away: float, backend: str) -> None:
    """Its way to the wall is a parabola, too, under a constant force, but no short flight."""
    start, rest = in_proportion()
    plain = beam()
    wall = Contact(name="wall", gap=away - plain.q[0], eps_n=EPS)
    system = ContactSystem(
        plain.q, plain.M, [1, *plain.h[1:]], [*plain.contacts, wall], plain.parameters
    )
    motion = simulate(system, start, 10.0, backend=backend)
    assert motion.word.split()[0] == "C1+2"
    (end,) = [event.time for event in motion.events if event.symbol == "C1+2"]
    assert end == pytest.approx(rest, abs=1e-13)


@EACH_BACKEND
@pytest.mark.parametrize("angle", [0, sympy.Rational(3, 10)])
def test_a_beam_that_falls_flat_bounces_on_both_ends(backend: str, angle: sympy.Rational) -> None:
    """Whatever rounding makes of its angle: rest comes after (1 + 2 eps/(1 - eps)) sqrt(2 h/g)."""
    y, phi = sympy.symbols("y phi")
    ends = [
        Contact(name=name, gap=y + side * (sympy.sin(phi + angle) - sympy.sin(angle)), eps_n=0.5)
        for name, side in ENDS
    ]
    beam = ContactSystem([y, phi], sympy.diag(1, 0.3), [-1, 0], ends, {})
    motion = simulate(beam, {"y": 1.0}, 9.0, backend=backend)
    assert motion.word == "C1+2"
    assert motion.status is MotionStatus.AT_REST
    assert motion.events[-1].time == pytest.approx(3 * math.sqrt(2.0), abs=1e-12)


@EACH_BACKEND
def test_a_ball_rests_on_the_floor_long_before_it_rests_at_a_wall(backend: str) -> None:
    """The floor is reached at 1 s, and has stopped it at 3 s; it is pushed to the wall at 3.5 s."""
    x, y = sympy.symbols("x y")
    floor, wall = Contact(name="floor", gap=y, eps_n=0.5), Contact(name="wall", gap=x, eps_n=0.1)
    ball = ContactSystem([x, y], sympy.eye(2), [-1, -1], [floor, wall], {})
    motion = simulate(ball, {"x": 0.5 * 3.5**2, "y": 0.5}, 4.0, max_events=60, backend=backend)
    assert motion.word == "C1 I1+2"
    assert [event.time for event in motion.events[-2:]] == pytest.approx([3.0, 3.5], abs=1e-13)
    assert motion.z == pytest.approx([0.35 * 0.5 - 0.5**3, 0, -0.15, 0, 4], abs=1e-12)


@EACH_BACKEND
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("mu", [0.0, 0.1, 0.9])
def test_a_block_that_slides_flat_into_a_wall_stays_on_the_floor(
    law: str, mu: float, backend: str
) -> None:
    """It is thrown back by 0.8 of its speed; neither foot leaves, though no impulse presses it."""
    x, y, phi, u_y, u_phi = sympy.symbols("x y phi u_y u_phi")
    feet = [Contact(name=f"foot {name}", gap=y + side * phi, eps_n=0.8) for name, side in ENDS]
    sides = [
        Contact(name=f"wall {name}", gap=1 - x + 2 * side * phi, slip=u_y + u_phi, mu=mu, eps_n=0.8)
        for name, side in ENDS
    ]
    mass, force = sympy.diag(1, 1, 1), [0, -1, 0]
    block = ContactSystem([x, y, phi], mass, force, [*feet, *sides], {}, law=law)
    motion = simulate(block, {"u_x": 1.0}, 2.0, backend=backend)
    assert (len(motion.events), motion.status) == (1, MotionStatus.TIME_REACHED)
    assert motion.z == pytest.approx([0.2, 0.0, 0.0, -0.8, 0.0, 0.0, 2.0], abs=1e-14)


def wedge() -> ContactSystem:
    """A mass between two faces at a sharp angle, along whose edge nothing holds it; no forces."""
    x, y, s, eps = sympy.symbols("x y s eps")
    faces = [Contact(name=f"face {k}", gap=y + (-1) ** k * 3 * x, eps_n=eps) for k in (1, 2)]
    return ContactSystem([x, y, s], sympy.diag(1, 1, 1), [0, 0, 0], faces, {eps: 0.05})


@EACH_BACKEND
def test_a_mass_is_caught_in_a_wedge(backend: str) -> None:
    """Speeds shrink by another ratio than times; what is left is what no face can take."""
    start = {"x": 0.1, "y": 0.5, "u_x": 0.4, "u_y": -1.0, "u_s": DRIFT}
    motion = simulate(wedge(), start, 3.0, backend=backend)
    assert motion.word == "C1+2"
    assert motion.z == pytest.approx([0, 0, 3 * DRIFT, 0, 0, DRIFT, 3.0], abs=1e-13)
    assert motion.events[-1].time == pytest.approx(caught(), abs=1e-14)


def caught() -> float:
    """When it is: straight flights and reflections, in numbers of 60 digits."""
    with mpmath.workdps(60):
        x, y, u, v = (mpmath.mpf(each) for each in (0.1, 0.5, 0.4, -1.0))
        total, last = mpmath.mpf(0), 0
        while v * v + u * u > mpmath.mpf(10) ** -40:
            times = {k: -(y + k * x) / (v + k * u) for k in (-3, 3) if k != last and v + k * u < 0}
            last, t = min(times.items(), key=lambda each: each[1])
            total, x, y = total + t, x + t * u, y + t * v
            push = -(1 + mpmath.mpf(0.05)) * (v + last * u) / 10
            u, v = u + last * push, v + push
        return float(total)


# --- Friction that turns back in every flight -----------------------------------------------------

X, Y, PHI, V, T = sympy.symbols("x y phi u_x t")
MU, E, F = sympy.symbols("mu e F")
STOP = Contact(name="the stop", gap=1 - X, eps_n=E)


def pushed_block(force: sympy.Expr, **values: float) -> ContactSystem:
    """A block on a rough table, pushed against a stop."""
    table = Contact(name="the table", gap=Y, slip=V, mu=MU)
    values = {"mu": 0.2, "e": 0.5, "F": 0.5} | values
    return ContactSystem([X, Y], sympy.diag(1, 1), [force, -1], [table, STOP], values)


def pushed_on_two_feet(**values: float) -> ContactSystem:
    """The same with a foot at each end."""
    feet = [Contact(name=name, gap=Y + side * PHI, slip=V, mu=MU) for name, side in ENDS]
    return ContactSystem([X, Y, PHI], sympy.eye(3), [F, -1, 0], [*feet, STOP], {"F": 0.5} | values)


def pressed(mu: float, e: float) -> float:
    """When it rests: it leaves at 1, is slowed down by F + mu, and comes back with F - mu."""
    ratio = math.sqrt((0.5 - mu) / (0.5 + mu))
    return (1.0 / (0.5 + mu) + ratio / (0.5 - mu)) / (1.0 - e * ratio)


@EACH_BACKEND
@pytest.mark.parametrize(
    ("mu", "e", "feet", "word"),
    [(0.2, 0.5, 1, "C2 J1"), (0.2, 1.0, 1, "C2 J1"), (0.0, 0.5, 1, "C2 J1"),
     (0.2, 0.5, 2, "C3 J1 J2")],
)  # fmt: skip
def test_a_block_is_pressed_against_a_stop(
    mu: float, e: float, feet: int, word: str, backend: str
) -> None:
    """Friction alone makes impacts accumulate that lose no speed."""
    block = pushed_block(F, mu=mu, e=e) if feet == 1 else pushed_on_two_feet(mu=mu, e=e)
    motion = simulate(block, {"x": 1.0, "u_x": -1.0}, 20.0, backend=backend)
    assert (motion.word, motion.status) == (word, MotionStatus.AT_REST)
    assert motion.events[-1].time == pytest.approx(pressed(mu, e), abs=2e-12)
    assert motion.z[:-1] == pytest.approx([1.0, *[0.0] * (2 * block.n - 1)], abs=1e-14)


def between(room: int, eps: float) -> ContactSystem:
    """A free particle between two walls."""
    walls = [Contact(name=name, gap=gap, eps_n=eps) for name, gap in (("-", X), ("+", room - X))]
    return ContactSystem([X], [[1]], [0], walls, {})


def test_a_fall_that_is_too_fast_for_its_final_time_says_so() -> None:
    """It lasts 1e-40 s of 30 s, less than the search for events resolves."""
    y = sympy.Symbol("y")
    floor = Contact(name="floor", gap=y, eps_n=0.5)
    ball = ContactSystem([y], [[1]], [-1e80], [floor], {})
    motion = simulate(ball, {"y": 1.0}, 30.0)
    assert motion.status is MotionStatus.PASSED
    assert "times are far shorter than those asked for" in motion.status.value
    assert simulate(ball, {"y": 1.0}, 1e-38).word == "C1"


@EACH_BACKEND
@pytest.mark.parametrize("ratio", [1.0, 1.0 - 2.0**-20])
def test_two_walls_without_room_between_them(backend: str, ratio: float) -> None:
    """Every impact turns the velocity round, at once: there is no motion if none is lost."""
    motion = simulate(between(0, ratio), {"u_x": 1.0}, 5.0, max_events=10, backend=backend)
    assert (motion.status is MotionStatus.ENDLESS) == (ratio == 1.0)
    assert motion.z[-1] == 0.0
    speeds = [event.before[0] for event in motion.events if event.symbol in ("I1", "I2")]
    assert speeds == pytest.approx([(-ratio) ** k for k in range(len(speeds))], rel=1e-14)


def test_elastic_walls_far_apart_are_struck_for_ever() -> None:
    """A unit speed over a unit of length: an impact each second, with nothing lost."""
    motion = simulate(between(1, 1), {"u_x": 1.0}, 5.5)
    assert [event.time for event in motion.events] == pytest.approx([1, 2, 3, 4, 5], abs=1e-12)
    assert motion.status is MotionStatus.TIME_REACHED


@EACH_BACKEND
@pytest.mark.parametrize("eps", [1e-12, 1e-18])
def test_a_ball_rests_however_small_its_restitution(eps: float, backend: str) -> None:
    """Also if the speeds of two impacts are all that rounding tells apart."""
    y = sympy.Symbol("y")
    ball = ContactSystem([y], [[1]], [-10], [Contact(name="floor", gap=y, eps_n=eps)], {})
    motion = simulate(ball, {"y": 5.0}, 5.0, backend=backend)
    assert (motion.word, motion.status) == ("C1", MotionStatus.AT_REST)
    assert motion.events[-1].time == pytest.approx(1.0 + 2.0 * eps, abs=1e-14)


@pytest.mark.parametrize("left", [1e-4, 1e-5])
def test_a_section_is_not_passed_over_while_bounces_accumulate(left: float) -> None:
    """It is reached so long before a ball rests, at 3 s; the k-th bounce begins 4/2^k s before."""
    y, u = sympy.symbols("y u_y")
    ball = ContactSystem([y], [[1]], [-10], [Contact(name="floor", gap=y, eps_n=0.5)], {})
    map_ = SystemMap(ball, Section(when=T - 3 + left, free=[y, u], at={T: 0}), backend="scipy")
    begins = 4.0 * 0.5 ** math.floor(math.log2(4.0 / left))
    speed, t = 2.5 * begins, begins - left
    image = map_.search(np.array([5.0, 0.0]), map_.p).point
    assert image == pytest.approx([speed * t - 5.0 * t * t, speed - 10.0 * t], abs=1e-12)


# --- A ball that comes to rest on a table that moves ----------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("height", [0.0, 0.3, 3.0])
def test_a_ball_at_rest_on_a_table_moves_as_it_does(height: float) -> None:
    """Once in a period it has the place 0 and the speed 2 A of A sin 2 t, wherever it came from."""
    y, v, t, a = sympy.symbols("y u_y t A")
    table = Contact(name="the table", gap=y - a * sympy.sin(2 * t), eps_n=0.5)
    ball = ContactSystem([y], [[1]], [-9.81], [table], {a: 0.1})
    section = Section(when=sympy.sin(2 * t), free=[y, v], at={t: 0})
    map_ = SystemMap(ball, section, ["A"], backend="scipy")
    image = map_.at(np.array([height, 0.2]), map_.p)
    assert image.value == pytest.approx([0.0, 0.2], abs=1e-14)
    assert image.jacobian == pytest.approx(np.array([[0, 0, 0], [0, 0, 2]]), abs=1e-7)
    cycle = shoot(map_, [height, 0.2])
    assert np.abs(cycle.multipliers).max() < 1e-7


@NEEDS_HEYOKA
@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_samples_of_a_tumbling_block_pass_no_contact_and_gain_no_energy(number: int) -> None:
    """Without friction it comes to rest on two corners, on which it bounces in turns as it turns.

    Flights are integrated to 1e-15, and gaps followed to 1e-12 while impacts accumulate.
    """
    x, y, phi = sympy.symbols("x y phi")
    sin, cos, half, high = sympy.sin(phi), sympy.cos(phi), 0.5, 0.3
    corners = [
        Contact(name=f"corner {a} {b}", gap=y + a * half * sin + b * high * cos, eps_n=0.7)
        for a in (-1, 1) for b in (-1, 1)
    ]  # fmt: skip
    mass = sympy.diag(1, 1, (half**2 + high**2) / 3)
    block = ContactSystem([x, y, phi], mass, [0, -10, 0], corners, {}, law="newton")
    rng = np.random.default_rng([4, number])
    start = {"x": 0.0, "y": rng.uniform(1.0, 2.0), "phi": rng.uniform(-0.7, 0.7), "u_phi": 1.0}
    motion = simulate(block, start, 6.0, samples=4001)
    assert (motion.status, motion.word.split()[-1][0]) == (MotionStatus.TIME_REACHED, "C")
    gaps = sympy.lambdify([x, y, phi], [corner.gap for corner in corners])
    assert np.array(gaps(*motion.q.T)).min() > -1e-12
    energy = 0.5 * motion.u**2 @ np.diag(np.array(mass, dtype=float)) + 10.0 * motion.q[:, 1]
    assert np.diff(energy).max() < 1e-11
