"""Scenes in which simulations of contact go wrong, each with its right outcome."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from woodpecker import State, Status, Toy, first_return, return_map, simulate

TOY = Toy()
ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize(
    ("eps_n1", "phi_s"), [(0.009, -0.885), (0.0105, -0.8849), (0.335, -0.885), (0.1469, -2.1086)]
)
def test_chatter_is_summed_to_its_end(eps_n1: float, phi_s: float) -> None:
    """The beak's bounces on the closed upper contact accumulate, and the motion goes on from rest
    with both angles at their stops: one image for all starts, -0.856354474973433798574924 in the
    30-digit reference."""
    once = first_return(Toy(eps_n1=eps_n1), phi_s)
    assert once.word.endswith("C1 D1 R3 D3 I2 J2")
    assert once.phi_s == pytest.approx(-0.8563544749734338, abs=1e-12)
    assert once.slope == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("law", "ratio"), [("separate", 0.335), ("summed", 0.1281112)])
def test_chatter_ends_where_the_bounces_lead(law: str, ratio: float) -> None:
    """Near its end the last summed time agrees with the geometric series of the flights."""
    path = simulate(Toy(eps_n1=0.335, expansion_friction=law), -0.885, 0.1)
    strikes = [event.time for event in path.events if event.symbol.startswith("I1+3")]
    (end,) = [event.time for event in path.events if event.symbol == "C1"]
    flights = np.diff(strikes)
    ratios = flights[1:] / flights[:-1]
    # the ratio tends to eps, or to the part of it that friction leaves, linearly in the flight
    # time, which is below 1e-8 for the last ones
    assert ratios[-3:] == pytest.approx(ratio, abs=1e-5)
    assert end - strikes[-1] == pytest.approx(flights[-1] * ratio / (1.0 - ratio), rel=1e-5)
    assert len(strikes) > 10


def test_free_fall_is_decided_from_the_closed_form() -> None:
    """Released from rest with the sleeve free, the toy touches nothing and turns nowhere: no event
    after the first, and no waiting."""
    for phi_s in (-0.09, -0.05, 0.0):
        once = first_return(TOY, phi_s)
        assert once.status is Status.FREE_FALL
        assert once.word == "D2"
        assert math.isinf(once.drop)


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


def test_flank_of_a_dip_is_crossed_in_one_step() -> None:
    """Fall times of many seconds cost no more events than short ones."""
    images = return_map(TOY, np.linspace(-1.2252, -1.2248, 2001))
    assert images.period.max() > 1.0
    assert max(len(word.split()) for word in images.words) < 40


def test_two_events_within_the_resolution_of_time() -> None:
    """Next to the jump at -0.884773 the beak and the sleeve strike 1e-14 s apart; the order is
    right on both sides, whatever the distance."""
    low, high = -0.88478, -0.88476
    word = first_return(TOY, low).word
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if first_return(TOY, middle).word == word else (low, middle)
    left, right = first_return(TOY, -0.88478).word, first_return(TOY, -0.88476).word
    assert left.split()[2] != right.split()[2]
    for distance in 10.0 ** np.arange(-13, -5, 0.5):
        assert first_return(TOY, low - distance).word == left
        assert first_return(TOY, high + distance).word == right
    motion = simulate(TOY, low - 1e-13, 0.06)
    times = [event.time for event in motion.events if event.kind.value == "I"]
    assert 0.0 < times[1] - times[0] < 1e-12


def test_slip_starts_on_the_friction_cone() -> None:
    """The jam ends where lambda_T = mu lambda_N: slip accelerates from zero acceleration, so the
    sleeve's fall begins with the cube of time."""
    path = simulate(TOY, -0.53, 0.035)
    start, end = path.events[0].time, path.events[1].time
    assert [event.symbol for event in path.events] == ["S2", "D2"]
    speeds = [float(path.at(start + h)[1][0]) for h in (1e-6, 2e-6, 4e-6)]
    assert speeds[1] / speeds[0] == pytest.approx(4.0, rel=1e-3)  # d ydot ~ t^2
    assert speeds[2] / speeds[1] == pytest.approx(4.0, rel=1e-3)
    assert end - start == pytest.approx(0.00582, abs=1e-5)


def test_release_at_vanishing_force() -> None:
    """At D2 the normal force is zero, and so is the gap's acceleration: it opens with t^3."""
    path = simulate(TOY, -0.53, 0.04)
    leave = path.events[1].time
    gaps = [float(path.at(leave + h)[0][1]) + TOY.phi_m_max for h in (1e-5, 2e-5, 4e-5)]
    assert gaps[1] / gaps[0] == pytest.approx(8.0, rel=1e-2)
    assert gaps[2] / gaps[1] == pytest.approx(8.0, rel=1e-2)


def test_hyperbolic_mode_is_passed() -> None:
    """Upper contact sliding up: kappa = +532 (word with R3 in mid-flight)."""
    once = first_return(Toy(eps_n1=0.3), -0.53)
    assert "R3" in once.word.split()
    assert once.status is Status.RETURNED


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


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_nothing_is_scaled_by_hand(scale: float) -> None:
    """Masses, inertias and stiffness together change no motion, only forces."""
    heavy = TOY.replace(
        **{name: scale * getattr(TOY, name) for name in ("m_m", "j_m", "m_s", "j_s", "c_phi")}
    )
    starts = np.linspace(-2.4, -0.3, 60)
    here, there = return_map(TOY, starts), return_map(heavy, starts)
    assert here.words == there.words
    bound = 1e-12 + 1e-13 * np.abs(here.slope)
    assert (np.abs(here.phi_s - there.phi_s) <= bound).all()


def test_painleve_is_reported_not_resolved() -> None:
    """With friction beyond every bound a contact problem has no or several solutions."""
    images = return_map(TOY.replace(mu_1=8.0, mu_2=8.0, mu_3=8.0), np.linspace(-2.4, -0.3, 400))
    reasons = set(images.status)
    assert reasons & {Status.CONTACT_AMBIGUOUS, Status.CONTACT_NO_SOLUTION}
    lost = np.array([not reason.success for reason in images.status])
    assert np.isnan(images.phi_s[lost]).all()


PLAIN = """
import json, sys
from woodpecker import Toy, first_return
from woodpecker.base.compiled import COMPILED
assert not COMPILED
rows = []
for phi_s, eps in json.load(sys.stdin):
    r = first_return(Toy(eps_n1=eps), phi_s)
    rows.append([r.phi_s, r.period, r.drop, r.slope, r.d_eps_n1, r.word])
print(json.dumps(rows))
"""


@pytest.mark.slow
def test_plain_python_gives_the_same_numbers() -> None:
    """Same operations, other order of rounding at most: 1e-12, and what the slope makes of it."""
    rng = np.random.default_rng(11)
    states = [(float(rng.uniform(-2.4, -0.3)), float(rng.uniform(0.0, 1.0))) for _ in range(60)] + [
        (-0.885, 0.009),
        (-0.8, 0.125),
    ]
    result = subprocess.run(
        [sys.executable, "-c", PLAIN],
        input=json.dumps(states), capture_output=True, text=True, check=True, cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    for (phi_s, eps), plain in zip(states, json.loads(result.stdout), strict=True):
        here = first_return(Toy(eps_n1=eps), phi_s)
        assert plain[5] == here.word
        scale = max(1.0, abs(here.slope))
        assert plain[:3] == pytest.approx([here.phi_s, here.period, here.drop], abs=1e-12 * scale)
        assert plain[3:5] == pytest.approx([here.slope, here.d_eps_n1], rel=1e-9, abs=1e-9)
