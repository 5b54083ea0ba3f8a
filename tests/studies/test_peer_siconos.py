"""Siconos follows the toy as the project's own Moreau scheme does, step by step."""

import numpy as np
import pytest

from studies.peers import siconos_peer
from studies.peers.moreau import first_return_moreau, simulate_moreau
from studies.peers.ode import PHI_S
from studies.peers.peer import LostError
from studies.peers.siconos_peer import available, first_return_siconos, main, simulate_siconos
from woodpecker import Toy
from woodpecker.base.compiled import COMPILED

WHY_NOT = available()
TOY = Toy(expansion_friction="separate")  # Coulomb's law, the only one that Siconos knows
needs_siconos = pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT or "runs")
NOMINAL = "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
# rad, s, m; Lemke's path rounds a contact velocity to 1e-12 or so in each of up to 1e4 steps, and
# a return amplifies what comes of it by its slope, up to 2 here
SAME = 1e-8


@needs_siconos
@pytest.mark.slow
@pytest.mark.parametrize(
    ("eps_n1", "phi_s"), [(0.5, PHI_S), (0.9, -0.4), (0.125, -0.8), (0.1, -0.95), (0.1, -0.7)]
)
@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_siconos_and_the_project_take_the_same_steps(
    eps_n1: float, phi_s: float, step: float
) -> None:
    """Impacts with two contacts closed and accumulating ones are among them."""
    toy = TOY.replace(eps_n1=eps_n1)
    there, here = first_return_siconos(toy, phi_s, step), first_return_moreau(toy, phi_s, step)
    assert there.word == here.word
    assert there.evaluations == here.evaluations
    assert there.phi_s == pytest.approx(here.phi_s, abs=SAME)
    assert there.period == pytest.approx(here.period, abs=SAME)
    assert there.drop == pytest.approx(here.drop, abs=SAME)


@needs_siconos
@pytest.mark.slow
def test_samples_are_those_of_the_project() -> None:
    there = simulate_siconos(TOY, PHI_S, 0.3, 1e-4, every=10)
    here = simulate_moreau(TOY, PHI_S, 0.3, 1e-4)
    n = len(there.t)
    assert there.t == pytest.approx(here.t[::10][:n], abs=1e-12)
    assert there.q == pytest.approx(here.q[::10][:n], abs=SAME)
    assert there.u == pytest.approx(here.u[::10][:n], abs=1e3 * SAME)  # some 10 rad/s, stiff
    assert there.steps >= 2999  # rounding decides whether the last step is taken
    assert there.seconds > 0.0


@needs_siconos
@pytest.mark.slow
def test_gauss_seidel_of_siconos_solves_one_contact_to_rounding() -> None:
    lemke, swept = (first_return_siconos(TOY, PHI_S, 1e-4, way) for way in ("LEMKE", "NSGS"))
    assert swept.word == lemke.word == NOMINAL
    assert swept.phi_s == pytest.approx(lemke.phi_s, abs=SAME)


@needs_siconos
@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="the study imports what is slow without numba")
def test_the_study_measures_the_period() -> None:
    """A step of 2e-5 s gives 0.14605 +- 0.00016 s; the mean of twelve scatters by a third of it.

    The exact period is 0.145976 s; the scheme is late by half a step at some of eleven events.
    """
    results = main(fast=True)
    coarse, fine = results["cycle"]["1e-04"], results["cycle"]["2e-05"]
    assert fine["period_mean"] == pytest.approx(0.14605, abs=1.6e-4)
    assert fine["period_mean"] == pytest.approx(0.14597607, abs=11 * 2e-5)
    assert coarse["period_mean"] == pytest.approx(0.14597607, abs=11 * 1e-4)
    assert 0.0 < fine["period_spread"] < coarse["period_spread"]
    assert fine["seconds_per_second"] > coarse["seconds_per_second"] > 0.0
    assert [row["word"] for row in results["return"].values()] == [NOMINAL] * 2
    errors = [row["error"] for row in results["return"].values()]
    assert np.all(np.diff(errors) < 0.0)


def test_a_missing_siconos_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(siconos_peer, "PYTHON", "/nowhere/python3")
    assert "/nowhere/python3" in available()
    assert main(fast=True) == {"skipped": available()}
    with pytest.raises(LostError, match="cannot be asked for"):
        first_return_siconos(TOY, PHI_S)


def test_wrong_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="expansion_friction='separate', got 'summed'"):
        first_return_siconos(Toy(), PHI_S)
    with pytest.raises(ValueError, match=r"below 0\.12"):
        first_return_siconos(TOY, 1.0)
    with pytest.raises(ValueError, match="0 < step < t_end"):
        simulate_siconos(TOY, PHI_S, 0.1, 0.2)
