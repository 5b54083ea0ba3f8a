"""Forces that are powers of what is exactly zero at a start: no backend makes a nan of them."""

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA
from scipy.special import ellipk

from woodpecker.systems import Contact, ContactSystem, MotionStatus, Section, SystemMap, simulate

BACKENDS = [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]
X, V, STIFF = sympy.symbols("x u_x k")


def spring() -> ContactSystem:
    """A mass on a cubic spring, far from a stop."""
    stop = Contact(name="the stop", gap=X + 10)
    return ContactSystem([X], [[1]], [-STIFF * X**3], [stop], {STIFF: 1.0})


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_cubic_spring_from_the_middle(backend: str) -> None:
    """From speed 1 a period takes 4 K(1/2)/a, where a = 2**(1/4) is the amplitude."""
    section = Section(when=X, free=[V], horizon=100.0)
    map_ = SystemMap(spring(), section, ["k"], backend=backend)
    image = map_.at(np.array([1.0]), np.array([1.0]))
    assert image.value == pytest.approx([1.0], abs=1e-12)  # it rises through zero once in a period
    period = 4.0 * ellipk(0.5) / 2.0**0.25
    motion = simulate(spring(), {"u_x": 1.0}, period, backend=backend)
    assert motion.status is MotionStatus.TIME_REACHED
    assert motion.z[:2] == pytest.approx([0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize("backend", BACKENDS)
def test_friction_that_varies_with_the_slip_where_it_sticks(backend: str) -> None:
    """A mass is carried by a belt until the spring equals friction, at x = 1.5 and t = 1.5."""
    y = sympy.Symbol("y")
    slip = V - 1
    belt = Contact(name="the belt", gap=y, slip=slip, mu=1.5)
    force = [-X + 1.5 * slip - 0.45 * slip**3, -1]
    brick = ContactSystem([X, y], [[1, 0], [0, 1]], force, [belt], {})
    motion = simulate(brick, {"x": 0.0, "u_x": 1.0}, 2.0, backend=backend)
    assert motion.word == "S1"
    assert motion.events[0].time == pytest.approx(1.5, abs=1e-12)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_motion_that_is_lost_at_once_says_so(backend: str) -> None:
    """A force without a value at the start: a status with a sentence, and the start is kept."""
    y = sympy.Symbol("y")
    floor = Contact(name="floor", gap=y)
    lost = ContactSystem([X, y], [[1, 0], [0, 1]], [1 / X, -1], [floor], {})
    motion = simulate(lost, {"y": 1.0}, 1.0, backend=backend)
    assert not motion.status.success
    assert not motion.events
    assert motion.q[0].tolist() == [0.0, 1.0]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_restitution_that_heyoka_cannot_differentiate(backend: str) -> None:
    """No flow needs it: it falls for 1 s, and is at rest after 1/(1 - eps) - 1 times 2 s more."""
    eps = sympy.Symbol("eps")
    floor = Contact(name="floor", gap=X, eps_n=sympy.Max(eps, sympy.Rational(1, 4)))
    ball = ContactSystem([X], [[1]], [-10], [floor], {eps: 0.5})
    motion = simulate(ball, {"x": 5.0}, 4.0, backend=backend)
    assert motion.word == "C1"
    assert motion.events[-1].time == pytest.approx(3.0, abs=1e-13)
