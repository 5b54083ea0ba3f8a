"""Moreau's time stepping: its order, and where it meets the kernel and where not."""

import numpy as np
import pytest
from needs import SLOW_TOY
from scenes import plain

from studies.peers import moreau
from studies.peers.moreau import (
    ASYMPTOTIC,
    LAWS,
    SCHEMES,
    SOLVERS,
    STICK,
    convergence,
    first_return_moreau,
    simulate_moreau,
    word_of_states,
)
from studies.peers.ode import PHI_S
from studies.peers.peer import LostError
from woodpecker import Toy, first_return
from woodpecker.base.compiled import COMPILED

TOY = Toy(expansion_friction="separate")  # Coulomb's law, the only one that the scheme knows
FINE = 1e-5 if COMPILED else 1e-4  # s; plain Python takes seconds for the finer one
EVERY_WAY = [(scheme, solver) for scheme in SCHEMES for solver in SOLVERS]
# rad per s of step, for a slope of -0.8: the largest |error| / step over 200 steps from 1e-4
# to 1e-6 s is 34. The error is that of placing eleven events by up to half a step.
PER_STEP = 60.0


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "solver"), EVERY_WAY)
def test_one_return_of_the_nominal_cycle(scheme: str, solver: str) -> None:
    once, kernel = (
        first_return_moreau(TOY, PHI_S, FINE, scheme, solver),
        first_return(TOY, PHI_S),
    )
    assert once.word == plain(kernel.word)
    for name in ("phi_s", "period", "drop"):
        assert getattr(once, name) == pytest.approx(getattr(kernel, name), abs=PER_STEP * FINE)
    assert once.evaluations == np.ceil(once.period / FINE)


@SLOW_TOY
@pytest.mark.parametrize(("scheme", "solver"), EVERY_WAY)
def test_the_order_is_one(scheme: str, solver: str) -> None:
    """The rms over nine steps scatters by 1/sqrt(18) = 24 %, 0.1 in the order over 1.5 decades."""
    table = convergence((1e-4, 3e-5, 1e-5, 3e-6), scheme, solver)
    assert table["order"] == pytest.approx(1.0, abs=0.2)
    assert max(np.divide(table["error"], table["step"])) < PER_STEP
    assert all(step <= ASYMPTOTIC for step in table["step"])


@SLOW_TOY
@pytest.mark.parametrize("eps_n1", [0.9, 0.5])
def test_images_agree_with_the_kernel_over_the_window(eps_n1: float) -> None:
    """All these starts have one contact at most in an impact of the beak, or one that slides."""
    toy, step = TOY.replace(eps_n1=eps_n1), 1e-5
    for phi_s in (-2.0, -1.1, -0.95, -0.85, -0.7, -0.6, -0.3):
        once, kernel = first_return_moreau(toy, phi_s, step), first_return(toy, phi_s)
        allowed = 2.0 * PER_STEP * step * max(1.0, abs(kernel.slope))
        assert once.phi_s == pytest.approx(kernel.phi_s, abs=allowed)


@SLOW_TOY
def test_newton_and_poisson_differ_where_the_beak_begins_to_stick() -> None:
    """No step makes up for another impact law: 6.9e-3 rad remain, a hundred times the error."""
    eps_n1, phi_s = LAWS
    image = first_return(TOY.replace(eps_n1=eps_n1), phi_s).phi_s
    assert "I1-s" in first_return(TOY.replace(eps_n1=eps_n1), phi_s).word
    for step in (1e-5, 1e-6):
        once = first_return_moreau(TOY.replace(eps_n1=eps_n1), phi_s, step)
        assert once.phi_s - image == pytest.approx(6.87e-3, abs=2.0 * PER_STEP * step)


@pytest.mark.parametrize(("scheme", "theta"), [("theta", 0.5), ("theta", 0.7), ("midpoint", 0.5)])
def test_free_steps_solve_the_equations_of_the_scheme(scheme: str, theta: float) -> None:
    """M (u_E - u_A) = dt (h_0 + h_1 d(q_F)), with M and h of the paper written out.

    Rounding: h_1 d is up to 1e-2 N m, u up to 50 rad/s times 3e-6 kg m^2, so 1e-18 and more.
    """
    toy, step = TOY, 1e-3
    run = simulate_moreau(toy, PHI_S, 1.0, step, scheme, "lcp", theta)
    far = (np.abs(run.q[:, 1]) < 0.09) & (run.q[:, 2] < 0.0)  # rad; the gaps close at 0.103, 0.12
    free = far[1:] & far[:-1]
    assert free.sum() > 50
    q_a, q_e, u_a, u_e = (x[free] for x in (run.q[:-1], run.q[1:], run.u[:-1], run.u[1:]))
    q_f = q_a + 0.5 * step * u_a if scheme == "midpoint" else theta * q_e + (1.0 - theta) * q_a
    m, m_l, m_g = toy.m_s, toy.m_s * toy.l_m, toy.m_s * toy.l_g
    mass = np.array([
        [m + toy.m_m, m_l, m_g],
        [m_l, toy.j_m + m_l * toy.l_m, m_l * toy.l_g],
        [m_g, m_l * toy.l_g, toy.j_s + m_g * toy.l_g],
    ])  # fmt: skip
    gravity = -toy.g * mass[0]
    spring = toy.c_phi * np.array([0.0, 1.0, -1.0])
    h = gravity + np.outer(q_f[:, 2] - q_f[:, 1], spring)
    assert (u_e - u_a) @ mass == pytest.approx(step * h, abs=1e-17)
    assert q_e == pytest.approx(q_a + step * ((1.0 - theta) * u_a + theta * u_e), abs=1e-15)


def test_what_cannot_be_followed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="expansion_friction='separate', got 'summed'"):
        first_return_moreau(Toy(), PHI_S)
    with pytest.raises(ValueError, match=r"below 0\.12"):
        first_return_moreau(TOY, 1.0)
    with pytest.raises(ValueError, match="step must be positive"):
        first_return_moreau(TOY, PHI_S, 0.0)
    with pytest.raises(ValueError, match="theta, midpoint"):
        first_return_moreau(TOY, PHI_S, 1e-3, "euler")
    with pytest.raises(ValueError, match="theta must lie"):
        simulate_moreau(TOY, PHI_S, 0.1, 1e-3, "midpoint", "lcp", 0.6)
    monkeypatch.setattr(moreau, "LONGEST", 0.1)  # s; the period is 0.146 s
    with pytest.raises(LostError, match="does not return within"):
        first_return_moreau(TOY, PHI_S, 1e-3)


def test_a_word_can_be_read_from_states() -> None:
    """A contact with restitution leaves without a D; one without leaves with one."""
    stuck, forward = STICK, moreau.FORWARD
    rows = [[0, stuck, 0], [0, forward, 0], [0, 0, 0], [0, 0, forward], [0, 0, 0], [stuck, 0, 0],
            [0, 0, 0], [0, forward, 0], [0, stuck, 0]]  # fmt: skip
    assert word_of_states(TOY, np.array(rows)) == "S2 D2 I3 D3 I1 I2 J2"
    assert word_of_states(TOY.replace(eps_n1=0.0), np.array(rows)) == "S2 D2 I3 D3 I1 D1 I2 J2"
