"""The event loop on the hard scenes: boundaries, near coincidences, chatter, falling for ever."""

from __future__ import annotations

import json
import math

import mpmath
import numpy as np
import numpy.typing as npt
import pytest
from scenes import in_another_process, plain, run

from woodpecker import kernel, mechanics
from woodpecker.arrays import Ints
from woodpecker.compiled import COMPILED
from woodpecker.contact import AMBIGUOUS, NO_SOLUTION, SOLVED
from woodpecker.kernel import mode_of, settle
from woodpecker.lcp import enumerate_contacts, solve_contact_lcp
from woodpecker.mechanics import equilibrium
from woodpecker.modes import (
    ALPHA,
    CONE_NEGATIVE,
    CONE_POSITIVE,
    KAPPA,
    LAMBDA,
    NORMAL,
    SLIP,
    A,
    B,
    Contact,
    mode_index,
    model,
)
from woodpecker.returns import first_return, return_map
from woodpecker.status import Status, status
from woodpecker.toy import Toy
from woodpecker.trajectory import State, simulate

FloatArray = npt.NDArray[np.float64]

OPEN, STICK, UP, DOWN = (int(state) for state in Contact)
TOY = Toy()
MANY = 400 if COMPILED else 40  # plain Python is a hundred times slower

# Closed forms of a few terms: some roundings of 1e-16.
EXACT = 1e-14


def accelerations(states: tuple[int, ...], d: float, toy: Toy = TOY) -> FloatArray:
    row = model(toy)[mode_index(*states)]
    return np.asarray(row[A : A + 3] + row[B : B + 3] * d)


def state_at(d: float, rate: float, sleeve: int = 1, dy: float = 0.0) -> FloatArray:
    """State with a sleeve contact closed (0-based), stretch d [rad] and its rate [rad/s]."""
    phi_m = TOY.phi_m_max * (-1.0 if sleeve == 1 else 1.0)
    return np.array([0.0, phi_m, phi_m + d, dy, 0.0, rate, 0.0])


def decide(
    z: FloatArray, closed: tuple[int, ...], slip: int, fired: int, toy: Toy = TOY
) -> tuple[int, tuple[int, ...]]:
    """Outcome of :func:`settle` and the states it chose."""
    touching: Ints = np.zeros(3, dtype=np.int64)
    touching[list(closed)] = 1
    states: Ints = np.zeros(3, dtype=np.int64)
    outcome = settle(model(toy), z, touching, slip * touching, np.int64(fired), states)
    return outcome, tuple(states.tolist())


# --- Decisions on the boundary, by rate -----------------------------------------------------------


def stretch_on_cone(edge: int, sleeve: int = 1) -> float:
    """Stretch at which lambda_T of the sticking contact is +mu lambda_N or -mu lambda_N."""
    row = model(TOY)[mode_index(OPEN, *((STICK, OPEN) if sleeve == 1 else (OPEN, STICK)))]
    (p_n, r_n), (p_t, r_t) = row[LAMBDA + 4 * sleeve : LAMBDA + 4 * sleeve + 4].reshape(2, 2)
    sign = 1.0 if edge == CONE_POSITIVE else -1.0
    mu = (TOY.mu_1, TOY.mu_2, TOY.mu_3)[sleeve]
    return float(-(mu * p_n - sign * p_t) / (mu * r_n - sign * r_t))


def test_slip_starts_exactly_on_the_cone() -> None:
    """lambda_T2 = mu lambda_N2, no slip yet, no slip acceleration yet: the rate of d decides.

    The weight pulls down, so the force of the pole points up: the sleeve begins to slide down as
    the torque that jams it fades (d rises), and stays stuck if it grows (d falls).
    """
    d = stretch_on_cone(CONE_POSITIVE)
    assert d == pytest.approx(-0.2052 + TOY.phi_m_max, abs=5e-5)  # DESIGN: beyond it no jamming
    assert decide(state_at(d, 3.0), (1,), 0, CONE_POSITIVE + 1) == (SOLVED, (OPEN, DOWN, OPEN))
    assert decide(state_at(d, -3.0), (1,), 0, CONE_POSITIVE + 1) == (SOLVED, (OPEN, STICK, OPEN))
    # The force of sliding down at that point is that of sticking, so the motion is continuous.
    sliding, sticking = (accelerations((OPEN, s, OPEN), d) for s in (DOWN, STICK))
    np.testing.assert_allclose(sliding, sticking, atol=1e-10)  # of terms up to 1e3


@pytest.mark.parametrize("slip", [-1, 1])
def test_release_at_zero_normal_force(slip: int) -> None:
    """lambda_N2 = 0 while sliding: with a relaxed spring; the rate of d decides."""
    opening, pressing = state_at(0.0, 3.0, dy=0.4 * slip), state_at(0.0, -3.0, dy=0.4 * slip)
    sliding = UP if slip > 0 else DOWN
    assert decide(opening, (1,), slip, NORMAL + 1) == (SOLVED, (OPEN, OPEN, OPEN))
    assert decide(pressing, (1,), slip, NORMAL + 1) == (SOLVED, (OPEN, sliding, OPEN))


def test_end_of_sliding() -> None:
    """Inside the cone the sleeve jams, outside it slides on: down if too heavy, up if thrown."""
    inside = 1.5 * stretch_on_cone(CONE_POSITIVE)
    outside = 0.5 * stretch_on_cone(CONE_POSITIVE)
    assert decide(state_at(inside, 2.0), (1,), 0, SLIP + 1) == (SOLVED, (OPEN, STICK, OPEN))
    assert decide(state_at(outside, 2.0), (1,), 0, SLIP + 1) == (SOLVED, (OPEN, DOWN, OPEN))


def test_events_of_the_cycle_lie_on_their_boundaries() -> None:
    """Slip at lambda_T = mu lambda_N, detachment at d = 0, jamming at zero slip, by the kernel."""
    result = run(
        TOY, [0, -TOY.phi_m_max, -0.52947197, 0, 0, 0, 0], (OPEN, STICK, OPEN), to_section=True
    )
    assert plain(result.word) == "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
    symbols = plain(result.word).split()
    starts = {time: phase for *phase, _, time in []}
    assert not starts
    states = {row[0]: row for row in result.events}
    assert len(states) >= 8
    for event, text in zip(result.events, symbols, strict=True):
        phase = result.phases[np.searchsorted(result.phases[:, 6], event[0], side="left")]
        d = phase[2] - phase[1]
        if text == "S2":
            assert d == pytest.approx(stretch_on_cone(CONE_POSITIVE), rel=EXACT)
        elif text == "D2" and phase[3] < 0.0 and event[2] == event[5] and phase[5] > 0.0:
            assert abs(d) < 1.0
        elif text == "J2":
            assert phase[3:5].tolist() == [0.0, 0.0]
