"""Moreau's time stepping: order, energy, its contact solvers, and where it meets the kernel."""

from pathlib import Path

import numpy as np
import pytest
from needs import NEEDS_NUMBA
from scenes import plain
from short_runs import short_run

from studies.peers import moreau
from studies.peers.moreau import (
    ASYMPTOTIC,
    DELASSUS,
    DIRECTION,
    FREE,
    IMPULSE,
    LAWS,
    MOTION,
    OPEN,
    PGS_STOP,
    RETURNED,
    SCHEMES,
    SOLVERS,
    STICK,
    convergence,
    discretise,
    enumerate_bases,
    enumerate_one,
    first_return_moreau,
    gauss_seidel,
    simulate_moreau,
    word_of_states,
)
from studies.peers.ode import IMAGE, PERIOD, PHI_S
from studies.peers.peer import LostError
from woodpecker import Toy, first_return
from woodpecker.base.arrays import Floats
from woodpecker.base.compiled import COMPILED
from woodpecker.mechanics.equations import energy, equilibrium
from woodpecker.mechanics.lcp import solve_contact_lcp

TOY = Toy(expansion_friction="separate")  # Coulomb's law, the only one that the scheme knows
EVERY_WAY = [(scheme, solver) for scheme in SCHEMES for solver in SOLVERS]
FINE = 1e-5 if COMPILED else 1e-4  # s; plain Python takes seconds for the finer one
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
    assert once.phi_s == pytest.approx(float(IMAGE), abs=PER_STEP * FINE)
    assert once.period == pytest.approx(float(PERIOD), abs=PER_STEP * FINE)
    assert once.drop == pytest.approx(kernel.drop, abs=PER_STEP * FINE)
    assert once.evaluations == np.ceil(once.period / FINE)


@pytest.mark.slow
@NEEDS_NUMBA
@pytest.mark.parametrize(("scheme", "solver"), EVERY_WAY)
def test_the_order_is_one(scheme: str, solver: str) -> None:
    """The rms over nine steps scatters by 1/sqrt(18) = 24 %, 0.1 in the order over 1.5 decades."""
    table = convergence((1e-4, 3e-5, 1e-5, 3e-6), scheme, solver)
    assert table["order"] == pytest.approx(1.0, abs=0.2)
    assert max(np.divide(table["error"], table["step"])) < PER_STEP
    assert all(step <= ASYMPTOTIC for step in table["step"])


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("eps_n1", "phi_s"), [(0.5, PHI_S), (0.125, -0.8), (0.1, -0.95)])
def test_both_solvers_give_the_same_motion(scheme: str, eps_n1: float, phi_s: float) -> None:
    """Velocities of up to 50 rad/s differ by the stopping rule in each of 2000 steps of 1e-4 s.

    The second and third start have two contacts closed at once.
    """
    toy = TOY.replace(eps_n1=eps_n1)
    direct, swept = (first_return_moreau(toy, phi_s, 1e-4, scheme, way) for way in SOLVERS)
    allowed = 2000 * PGS_STOP * 50.0
    assert swept.word == direct.word
    assert swept.evaluations == direct.evaluations
    assert swept.phi_s == pytest.approx(direct.phi_s, abs=allowed)
    assert swept.drop == pytest.approx(direct.drop, abs=allowed)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_energy_never_grows_and_smooth_motion_keeps_it(
    scheme: str, solver: str, step: float
) -> None:
    """Exactly, of T + V for theta = 1/2, of T + V - u.K u (dt/2)^2 / 2 for the midpoint rule.

    In both the change over a step is (gamma_A + gamma_E) . Lambda / 2. Rounding: 1e-2 J times
    2^-53 and some operations; what Gauss-Seidel leaves of a contact velocity, 1e-12 of 1 m/s,
    times impulses of 1e-3 N s, is 1e-15 J.
    """
    toy, rounding = TOY, 1e-16 if solver == "lcp" else 1e-15
    run = simulate_moreau(toy, PHI_S, 1.0, step, scheme, solver)
    kinetic, potential = energy(toy, run.q, run.u)
    total = kinetic + potential
    if scheme == "midpoint":
        total -= 0.5 * toy.c_phi * (0.5 * step * (run.u[:, 2] - run.u[:, 1])) ** 2
    change = np.diff(total)
    assert change.max() < rounding
    assert change.min() < -1e-6  # impacts dissipate
    margin = 1e-3  # rad; far from both ends of the clearance the sleeve touches nothing
    off = np.abs(run.q[:, 1]) < toy.phi_m_max - margin
    smooth = off[1:] & off[:-1] & (run.q[1:, 2] < toy.phi_s_max - 0.1)
    assert smooth.sum() > 100
    assert np.abs(change[smooth]).max() < 1e-16


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


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("step", [1e-3, 0.9e-3, 0.77e-3])
def test_the_minimum_is_found_within_the_step(scheme: str, step: float) -> None:
    """In the band of centres the jammed bird swings as phi'' = -omega^2 (phi - centre).

    Both schemes keep a quadratic form, and phi' = 0 at both ends, so they keep the amplitude A.
    That phi' is linear in a step leaves A (omega dt)^4; the period is off by (omega dt)^2 / 12 of
    itself.
    """
    toy, phi_s = TOY, -0.23
    omega = np.sqrt(toy.c_phi / (toy.j_s + toy.m_s * toy.l_g**2))
    amplitude = equilibrium(toy).phi_s - phi_s
    once = first_return_moreau(toy, phi_s, step, scheme)
    assert once.word == ""
    assert once.phi_s == pytest.approx(phi_s, abs=amplitude * (omega * step) ** 4)
    assert once.period == pytest.approx(2.0 * np.pi / omega, rel=(omega * step) ** 2)
    assert once.drop == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("contacts", [(0,), (1,), (2,), (0, 1), (0, 2)])
def test_contact_solvers_against_lemke(contacts: tuple[int, ...]) -> None:
    """Same velocities after the step as by the project's general Lemke solver.

    Tolerance: the slack of the enumeration and the stopping rule, over the condition of G (1e3).
    """
    rng = np.random.default_rng(1)
    toy = TOY.replace(mu_1=0.4, mu_2=0.7, mu_3=0.2)
    numbers, part = discretise(toy, 1e-4), np.array(contacts)
    rows = np.array([2 * i + axis for axis in (0, 1) for i in contacts])  # normals first
    delassus = numbers[:3, DELASSUS:].reshape(6, 6)[np.ix_(rows, rows)]
    mu = np.array([toy.mu_1, toy.mu_2, toy.mu_3])[part]
    seen = set()
    for _ in range(200):
        u = rng.normal(size=3) * [0.5, 20.0, 20.0]
        free = (numbers[:3, DIRECTION : DIRECTION + 6].reshape(6, 3) @ u)[rows]
        lemke = solve_contact_lcp(delassus, free, mu)
        gamma = np.append(lemke.gamma_n, lemke.gamma_t)
        for way in SOLVERS:
            z, states = np.zeros(MOTION), np.full((4, 3), OPEN)
            z[FREE + rows] = free
            assert _solve(way, numbers, z, states, part) == RETURNED
            found = delassus @ z[IMPULSE + rows] + free
            assert found == pytest.approx(gamma, abs=1e-9 * np.abs(free).max())
            seen.add(tuple(states[0, part].tolist()))
    assert len(seen) >= 3  # open, sticking or sliding: the sample is not of one kind


def _solve(way: str, numbers: Floats, z: Floats, states: Floats, part: Floats) -> int:
    if way == "pgs":
        return gauss_seidel(numbers, z, states, part, len(part))
    if len(part) == 1:
        general = z.copy()
        assert enumerate_bases(numbers, general, states.copy(), part, 1) == RETURNED
        end = enumerate_one(numbers, z, states, part[0])
        assert z == pytest.approx(general, rel=1e-12, abs=1e-12)  # elimination of two rows
        return end
    return enumerate_bases(numbers, z, states, part, len(part))


@pytest.mark.slow
@NEEDS_NUMBA
def test_the_beak_strikes_while_the_upper_contact_is_closed() -> None:
    """P1(-0.8) at eps_N1 = 0.125 is -0.52034 by an independent program."""
    once = first_return_moreau(TOY.replace(eps_n1=0.125), -0.8, 2e-6)
    assert once.phi_s == pytest.approx(-0.52034, abs=PER_STEP * 2e-6)
    assert once.word == "S2 D2 I3 D3 I3 I1+3 D3 I2 D2 I2 J2"


@pytest.mark.slow
@NEEDS_NUMBA
@pytest.mark.parametrize("eps_n1", [0.9, 0.5])
def test_images_agree_with_the_kernel_over_the_window(eps_n1: float) -> None:
    """All these starts have one contact at most in an impact of the beak, or one that slides."""
    toy, step = TOY.replace(eps_n1=eps_n1), 1e-5
    for phi_s in (-2.0, -1.1, -0.95, -0.85, -0.7, -0.6, -0.3):
        once, kernel = first_return_moreau(toy, phi_s, step), first_return(toy, phi_s)
        allowed = 2.0 * PER_STEP * step * max(1.0, abs(kernel.slope))
        assert once.phi_s == pytest.approx(kernel.phi_s, abs=allowed)


@pytest.mark.slow
@NEEDS_NUMBA
def test_newton_and_poisson_differ_where_the_beak_begins_to_stick() -> None:
    """No step makes up for another impact law: 6.9e-3 rad remain, a hundred times the error."""
    eps_n1, phi_s = LAWS
    image = first_return(TOY.replace(eps_n1=eps_n1), phi_s).phi_s
    assert "I1-s" in first_return(TOY.replace(eps_n1=eps_n1), phi_s).word
    for step in (1e-5, 1e-6):
        once = first_return_moreau(TOY.replace(eps_n1=eps_n1), phi_s, step)
        assert once.phi_s - image == pytest.approx(6.87e-3, abs=2.0 * PER_STEP * step)


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


@pytest.mark.slow
def test_the_study_runs(tmp_path: Path) -> None:
    results = short_run("peer_moreau", tmp_path)
    for scheme, solver in EVERY_WAY:
        table = results[f"{scheme}, {solver}"]
        assert all(np.diff(table["error"]) < 0.0)
        assert all(ms >= 0.0 for ms in table["cpu_ms"])
