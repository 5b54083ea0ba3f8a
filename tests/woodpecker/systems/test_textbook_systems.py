"""Machines of textbooks, by the public names only, as somebody brings them in."""

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from pwmap.diagrams.data import UNDECIDED
from woodpecker.systems import (
    Contact,
    ContactSystem,
    MotionStatus,
    Section,
    SystemMap,
    continuation,
    from_kane,
    shoot,
    simulate,
)

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]
G = 9.81
T = sympy.Symbol("t")


def test_a_double_pendulum_on_a_wall_keeps_its_energy() -> None:
    """By Lagrange's method; an elastic wall without friction."""
    a, b = dynamicsymbols("a b")
    t = dynamicsymbols._t
    x, y = sympy.sin(a), -sympy.cos(a)
    end = x + sympy.sin(b), y - sympy.cos(b)
    speeds = [each.diff(t) for each in (x, y, *end)]
    g, eps = sympy.symbols("g eps")
    kinetic, potential = sum(v**2 for v in speeds) / 2, g * (y + end[1])
    method = LagrangesMethod(sympy.simplify(kinetic - potential), [a, b])
    method.form_lagranges_equations()
    wall = Contact(name="wall", gap=sympy.Rational(1, 2) - end[0], eps_n=eps)
    system = from_kane(method, [wall], {g: G, eps: 1.0})
    motion = simulate(system, {"a": -0.8, "b": -0.5}, 6.0)
    other = simulate(system, {"a": -0.8, "b": -0.5}, 6.0, backend="scipy")
    assert motion.word == other.word
    assert motion.word.split()[:3] == ["I1", "I1", "I1"]
    assert motion.z == pytest.approx(other.z, abs=1e-9)
    (p, q), (u, v) = motion.z[:2], motion.z[2:4]
    energy = u * u + 0.5 * v * v + u * v * np.cos(p - q) - G * (2.0 * np.cos(p) + np.cos(q))
    assert energy == pytest.approx(-G * (2.0 * np.cos(0.8) + np.cos(0.5)), abs=1e-11)


@pytest.mark.parametrize(("mu", "solved"), [(1.33, True), (1.35, False)])
def test_painleves_rod(mu: float, solved: bool) -> None:
    """It slides as long as mu < (1 + 3 s^2)/(3 s c), at 0.5 rad 1.3386; beyond, no force does."""
    x, y, th, u, w = sympy.symbols("x y th u_x u_th")
    tip = Contact(name="tip", gap=y - sympy.cos(th), slip=u - sympy.cos(th) * w, mu=mu)
    rod = ContactSystem([x, y, th], sympy.diag(1, 1, sympy.Rational(1, 3)), [0, -G, 0], [tip], {})
    motion = simulate(rod, {"th": 0.5, "y": np.cos(0.5), "u_x": -3.0}, 1e-3)
    assert motion.status is (MotionStatus.TIME_REACHED if solved else MotionStatus.NO_SOLUTION)


@pytest.mark.parametrize("backend", ["heyoka", "scipy"])
@pytest.mark.parametrize(("mu", "angle", "speed"), [(0.3, 1.2, 3.0), (2.0, 0.8, 3.0), (5, 1.2, -3)])
def test_a_rod_falls_flat_and_comes_to_rest(
    mu: float, angle: float, speed: float, backend: str
) -> None:
    """Its ends have one slip as it lies: they stop together, though rounding leaves it an angle."""
    x, y, th, u, w = sympy.symbols("x y th u_x u_th")
    arm = sympy.sin(th)
    ends = [
        Contact(name=f"end {k}", gap=y + side * arm, slip=u - side * arm * w, mu=mu, eps_n=0.3)
        for k, side in enumerate((-1, 1))
    ]
    rod = ContactSystem([x, y, th], sympy.diag(1, 1, sympy.Rational(1, 3)), [0, -G, 0], ends, {})
    start = {"y": np.sin(angle) + 0.2, "th": angle, "u_x": speed}
    motion = simulate(rod, start, 6.0, backend=backend)
    assert motion.status is MotionStatus.AT_REST
    rest = [motion.q[-1, 1], np.sin(motion.q[-1, 2]), *motion.u[-1]]
    assert rest == pytest.approx(np.zeros(5), abs=1e-15)


def test_a_motion_without_damping_is_neutral_whatever_is_rounded() -> None:
    """Multipliers exp(2 pi i / w) of a linear oscillator that comes nowhere near its stop."""
    x, u, w = sympy.symbols("x u_x w")
    stop = Contact(name="stop", gap=9 - x, eps_n=0.5)
    system = ContactSystem([x], [[1]], [sympy.cos(w * T) - x], [stop], {w: 2.8})
    map_ = SystemMap(system, Section(when=sympy.sin(w * T), free=[x, u], at={T: 0}), ["w"])
    for value in np.linspace(2.0, 4.0, 9):
        cycle = shoot(map_, [0.1, 0.0], p=[value])
        assert cycle.x == pytest.approx(np.array([[1.0 / (1.0 - value**2), 0.0]]), abs=1e-12)
        assert abs(cycle.multipliers) == pytest.approx([1.0, 1.0], abs=1e-14)
        assert (cycle.success, cycle.stable) == (True, False)
        assert cycle.message == f"a periodic solution was found: {UNDECIDED}"
    window = [(-2.0, 2.0), (-2.0, 2.0)]
    found = continuation(map_, shoot(map_, [0.1, 0.0]), (2.2, 3.8), window, orders=(1,))
    (branch,) = found.diagram.branches
    assert not branch.stable.any()


def test_rattling_gears() -> None:
    """Backlash is a gap with two sides; nothing holds the shafts, so one multiplier is 1."""
    a, b, u, v, torque = sympy.symbols("a b u_a u_b torque")
    sides = [
        Contact(name=name, gap=sympy.Rational(1, 100) - sign * (a - b), eps_n=0.7)
        for name, sign in (("drive side", 1), ("coast side", -1))
    ]
    push = torque * sympy.cos(5 * T) - u / 10
    gears = ContactSystem([a, b], sympy.diag(1, 2), [push, -v / 10], sides, {torque: 2.0})
    map_ = SystemMap(gears, Section(when=sympy.sin(5 * T), free=[a, b, u, v], at={T: 0}))
    cycle = shoot(map_, [0.0, 0.0, 0.1, 0.0])
    assert cycle.success
    assert {"I1", "I2"} == set(cycle.word.split())
    assert np.abs(cycle.multipliers - 1.0).min() < 1e-9


def test_a_capsule_robot_walks() -> None:
    """A mass inside strikes a stop, and friction holds the capsule in between."""
    x, y, z, v, w, force = sympy.symbols("x y z u_x u_z force")
    contacts = [
        Contact(name="floor", gap=y, slip=v, mu=0.3),
        Contact(name="stop", gap=sympy.Rational(1, 10) - z, eps_n=0.4),
    ]
    mass = sympy.Matrix([[1.5, 0, 0.5], [0, 1.5, 0], [0.5, 0, 0.5]])
    inside = force * sympy.cos(6 * T) - 10 * z - w / 5
    capsule = ContactSystem([x, y, z], mass, [0, -1.5 * G, inside], contacts, {force: 6.0})
    map_ = SystemMap(capsule, Section(when=sympy.sin(6 * T), free=[v, z, w], at={T: 0}), ["force"])
    cycle = shoot(map_, [0.0, 0.05, 0.0])
    assert cycle.success
    assert cycle.stable
    assert cycle.word == "I1+2 J1 S1 J1 S1"


def test_a_ladder_on_a_wall_rests_just_above_its_angle() -> None:
    """tan(th) = (1 - mu_1 mu_2)/(2 mu_1), by statics; its three rates are held four times."""
    x, y, th, u, v, w = sympy.symbols("x y th u_x u_y u_th")
    across, up = sympy.cos(th) / 2, sympy.sin(th) / 2
    contacts = [
        Contact(name="ground", gap=y - up, slip=u - up * w, mu=0.3),
        Contact(name="wall", gap=x - across, slip=v + across * w, mu=0.2),
    ]
    inertia = sympy.diag(1, 1, sympy.Rational(1, 12))
    ladder = ContactSystem([x, y, th], inertia, [0, -G, 0], contacts, {})
    least = np.arctan((1.0 - 0.3 * 0.2) / (2.0 * 0.3))
    for away, status in ((1e-5, MotionStatus.AT_REST), (-1e-5, MotionStatus.TIME_REACHED)):
        angle = least + away
        start = {"th": angle, "x": np.cos(angle) / 2, "y": np.sin(angle) / 2}
        motion = simulate(ladder, start, 0.1)
        assert motion.status is status
        assert motion.word == ("" if status is MotionStatus.AT_REST else "S1 S2")


def test_three_balls_come_to_rest_at_once() -> None:
    """Impacts of all three accumulate together; whole energy and momentum go at one instant."""
    a, b, c = sympy.symbols("a b c")
    gaps = {"ground": a, "lower pair": b - a, "upper pair": c - b}
    contacts = [Contact(name=name, gap=gap, eps_n=0.6) for name, gap in gaps.items()]
    balls = ContactSystem([a, b, c], sympy.diag(1, 2, 1), [-10, -20, -10], contacts, {})
    start = {"a": 1.0, "b": 1.2, "c": 2.0}
    motions = [simulate(balls, start, 10.0, backend=backend) for backend in ("heyoka", "scipy")]
    assert motions[0].word == motions[1].word
    for motion in motions:
        assert motion.word.endswith("C1+2+3")
        assert motion.status is MotionStatus.AT_REST
        assert np.abs(motion.z[:6]).max() < 1e-13
    assert motions[0].events[-1].time == pytest.approx(motions[1].events[-1].time, abs=1e-12)
