"""An impact at one contact where another is closed: its word does not hang on rounding."""

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA

from studies.systems.toy import system_of
from woodpecker import Toy
from woodpecker.systems import Contact, ContactSystem, simulate
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.impacts import decide

ROUNDING = 1e-13  # of a velocity of 1, after some thousand operations
EPS, MU = 0.5, 0.1


def two_contacts() -> Equations:
    """A body that slides along the ground, on to a wall that leans over it."""
    x, y, s, u, v, slip = sympy.symbols("x y s u_x u_y u_s")
    ground = Contact(name="ground", gap=y, slip=slip, mu=MU, eps_n=EPS)
    wall = Contact(name="wall", gap=1 - x - y / 2, eps_n=EPS)
    mass = sympy.diag(1, 2, 1)
    return Equations(ContactSystem([x, y, s], mass, [0, -1, 0], [ground, wall], {}, u=[u, v, slip]))


@pytest.mark.parametrize("wrong", [-ROUNDING, 0.0, ROUNDING])
def test_the_ground_keeps_its_case(wrong: float) -> None:
    """With one restitution and no change of sliding the expansion is the compression times it.

    So the gap rate of the ground is zero after both, and its impulse just what it has to give back:
    it rests, and that is what the word says.
    """
    eq = two_contacts()
    z = np.array([1.0, 0.0, 0.0, 1.0, wrong, 1.0, 0.0])
    found = decide(eq, eq.terms(z, eq.p), (0, 1), z[3:6], closed={0})
    assert found.impact is not None
    assert found.impact.symbol == "I1-r+2"
    assert found.impact.resting == {0}
    # By hand, with forces (0, 1) and (-1, -1/2) of ground and wall on (x, y): x stops by the wall's
    # impulse 1, the ground's is half of it; both come back EPS times, and friction along s.
    assert found.impulses[:, 0] == pytest.approx(np.array([[0.5, 1.0], [0.5 * EPS, EPS]]))
    u = [-EPS, 0.0, 1.0 - MU * 0.5 * (1.0 + EPS)]
    assert found.u == pytest.approx(u, abs=10 * ROUNDING)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_a_closed_contact_does_not_drift() -> None:
    """The jammed sleeve stays where it is to the last bit while the bird swings; then it slides."""
    toy = Toy(eps_n1=0.5)
    system, _ = system_of(toy)
    jammed = -(toy.r_m - toy.r_0) / toy.h_m
    motion = simulate(system, {"phi_m": jammed, "phi_s": -0.53}, 0.034)
    assert motion.word == "S2"
    assert (motion.q[:, 1] == jammed).all()
    assert not motion.u[:, 1].any()
