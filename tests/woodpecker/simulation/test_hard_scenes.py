"""Scenes in which simulations of contact go wrong, each with its right outcome."""

import math

import numpy as np
import pytest

from woodpecker import State, Status, Toy, return_map, simulate

TOY = Toy()


def test_sleeve_grazes_the_pole_for_ever() -> None:
    """From rest the gap of contact 2 is a (1 - cos): it touches zero each period and never
    closes."""
    path = simulate(TOY, -0.05, 20.0)
    assert path.word == "D2"
    gap = TOY.phi_m_max + path.q[:, 1]
    assert gap.min() >= -1e-12  # (1 - cos) at omega t = 9000: rounding of the phase
    period = 2.0 * math.pi / (2.0 * math.pi * 72.90849818769215)
    q, _ = path.at(period * np.arange(1, 100))
    assert np.abs(q[:, 1] + TOY.phi_m_max).max() < 1e-9


def test_rest_and_no_return() -> None:
    """With strong friction the toy hangs by its beak on the upper contact for good."""
    start = State(phi_m=TOY.phi_m_max, phi_s=TOY.phi_s_max)
    path = simulate(TOY.replace(mu_1=50.0, mu_3=50.0, c_phi=1e-6, g=9.81), start, 1.0)
    assert path.status is Status.TIME_REACHED
    assert len(path.events) <= 3


@pytest.mark.parametrize("eps_n1", [0.0, 1.0])
def test_ends_of_the_restitution(eps_n1: float) -> None:
    images = return_map(Toy(eps_n1=eps_n1), np.linspace(-2.5, -0.24, 500))
    assert {reason.success for reason in images.status} == {True}
    assert np.isfinite(images.phi_s).all()
