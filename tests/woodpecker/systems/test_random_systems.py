"""Random systems: no hang, no silent nan, no gain of energy, no contact passed."""

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA

from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, Motion, MotionStatus, simulate

COUNT = 25
HONEST = {  # what a motion that stops early may say
    MotionStatus.NO_SOLUTION, MotionStatus.AMBIGUOUS, MotionStatus.EVENT_LIMIT,
    MotionStatus.PASSED, MotionStatus.NO_FORCES,
}  # fmt: skip


def random_system(number: int) -> tuple[ContactSystem, Floats, Floats]:
    """One of 2 to 4 coordinates and 1 to 3 contacts; its mass matrix, and speeds to start with."""
    rng = np.random.default_rng([36, number])
    n, m = int(rng.integers(2, 5)), int(rng.integers(1, 4))
    q, u = sympy.symbols(f"x:{n}"), sympy.symbols(f"v:{n}")
    root, spring, damper = (rng.normal(size=(n, n)).round(2) for _ in range(3))
    mass = root @ root.T + n * np.eye(n)
    stiffness, damping = spring @ spring.T, 0.01 * damper @ damper.T
    push = 2.0 * rng.normal(size=n).round(2)
    force = -sympy.Matrix(stiffness) * sympy.Matrix(q) - sympy.Matrix(damping) * sympy.Matrix(u)
    mu, eps = rng.uniform(0.0, 0.6), rng.uniform(0.0, 0.9)  # of all contacts: no impact adds energy
    contacts = [
        Contact(
            name=f"contact {i}", mu=mu, eps_n=eps,
            gap=sympy.Matrix(rng.normal(size=n)).dot(sympy.Matrix(q)) + rng.uniform(0.1, 1.0),
            slip=sympy.Matrix(rng.normal(size=n)).dot(sympy.Matrix(u)),
        )
        for i in range(m)
    ]  # fmt: skip
    system = ContactSystem(q, mass, force + sympy.Matrix(push), contacts, {}, u=u)
    return system, mass, 2.0 * rng.normal(size=n)


def motion_of(number: int, backend: str) -> tuple[ContactSystem, Floats, Motion]:
    system, mass, speeds = random_system(number)
    start = dict(zip(system.state[system.n : -1], speeds.tolist(), strict=True))
    return system, mass, simulate(system, start, 4.0, backend=backend, max_events=300)


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(COUNT))
def test_what_a_random_motion_must_keep(number: int) -> None:
    system, mass, motion = motion_of(number, "scipy")
    assert np.isfinite(motion.q).all()
    assert np.isfinite(motion.u).all()
    assert motion.status.success or motion.status in {MotionStatus.AT_REST, *HONEST}
    for event in motion.events:
        before, after = (0.5 * u @ mass @ u for u in (event.before, event.after))
        assert after <= before * (1.0 + 1e-12) + 1e-12
    gaps = sympy.lambdify([system.q], [c.gap for c in system.contacts])
    if motion.status is not MotionStatus.PASSED:
        assert np.min([gaps(q) for q in motion.q]) > -1e-6  # rounding, and the dense output's error


@pytest.mark.nightly
@NEEDS_HEYOKA
def test_backends_agree_on_words() -> None:
    """But where impacts of several contacts accumulate in turns, and rounding orders them."""
    differ = 0
    for number in range(COUNT):
        words = [motion_of(number, backend)[2].word.split() for backend in ("heyoka", "scipy")]
        short = min(len(words[0]), len(words[1]), 30)
        differ += words[0][:short] != words[1][:short]
    assert differ <= 1
