"""The study of speed, and the general ODE solver that it compares with."""

from pathlib import Path

import numpy as np
import pytest
from short_runs import short_run

from studies import benchmark
from studies.peers.ode import IMAGE, PERIOD, PHI_S, first_return_ode
from woodpecker import Toy, first_return
from woodpecker.base.compiled import COMPILED

NOMINAL = "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
RTOL = 1e-10
AGREES = 1e-7  # rad; a thousand times the peer's tolerance, for slopes and eleven phases


@pytest.mark.slow
def test_the_benchmark(tmp_path: Path) -> None:
    """It compares the same motion; the kernel is closer to the reference than the peer."""
    measured = short_run("benchmark", tmp_path)
    assert measured["word"] == measured["word_peer"] == NOMINAL
    assert measured["error_kernel"] < measured["error_peer"] < AGREES
    assert measured["error_period_kernel"] < measured["error_period_peer"] < AGREES
    assert measured["error_kernel"] < 1e-14  # some spacings of doubles
    missing = [key for key, value in measured.items() if value is None]
    assert measured["skipped"] if missing else COMPILED
    for name, timing in measured["timings"].items():
        assert 0.0 <= timing["wall_minimum"] <= timing["wall_median"], name
        assert 0.0 <= timing["cpu_minimum"] <= timing["cpu_median"], name
    if COMPILED:  # the main job takes minutes without
        assert measured["branches"] >= 1
        assert measured["points"] >= 2


def test_the_peer_returns_near_the_reference() -> None:
    once = first_return_ode(Toy(), PHI_S, rtol=RTOL)
    assert once.word == NOMINAL
    assert once.phi_s == pytest.approx(float(IMAGE), abs=AGREES)
    assert once.period == pytest.approx(float(PERIOD), abs=AGREES)
    assert once.drop == pytest.approx(first_return(Toy(), PHI_S).drop, abs=AGREES)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("eps_n1", "law"),
    [(0.9, "summed"), (0.5, "summed"), (0.2, "summed"), (0.5, "separate"), (0.1, "separate")],
)
def test_the_peer_agrees_with_the_kernel_over_the_window(eps_n1: float, law: str) -> None:
    """Image, period, drop and word from start to start; no chatter among these starts."""
    toy = Toy(eps_n1=eps_n1, expansion_friction=law)  # type: ignore[arg-type]
    for phi_s in (-2.4, -2.0, -1.6, -1.1, -0.95, -0.6, -0.4, -0.3):
        once, peer = first_return(toy, phi_s), first_return_ode(toy, phi_s, rtol=RTOL)
        assert peer.word == once.word
        allowed = AGREES * max(1.0, abs(once.slope))
        assert peer.phi_s == pytest.approx(once.phi_s, abs=allowed)
        assert peer.period == pytest.approx(once.period, abs=allowed)
        assert peer.drop == pytest.approx(once.drop, abs=allowed)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "LSODA"])
def test_the_peer_converges_to_the_reference(method: str) -> None:
    """Three orders of tolerance gain at least one order of accuracy; the word stays."""
    coarse, fine = (
        first_return_ode(Toy(), PHI_S, method, rtol, 1e-2 * rtol) for rtol in (1e-7, 1e-11)
    )
    assert coarse.word == fine.word == NOMINAL
    errors = [abs(once.phi_s - float(IMAGE)) for once in (coarse, fine)]
    assert errors[1] < 0.1 * errors[0]
    assert fine.evaluations > coarse.evaluations


def test_the_peer_refuses_what_it_cannot_follow() -> None:
    with pytest.raises(ValueError, match="below"):
        first_return_ode(Toy(), 1.0)
    with pytest.raises(RuntimeError, match="closer than"):  # impacts accumulate
        first_return_ode(Toy(eps_n1=0.1), -0.7)


def test_what_is_timed_is_the_return() -> None:
    images = benchmark.equal_starts(Toy(), 5)()
    assert images.shape == (5,)
    assert np.all(images == first_return(Toy(), PHI_S).phi_s)


def test_distance_does_not_round_the_reference() -> None:
    third = "0.333333333333333333333333333333"
    assert np.isclose(benchmark.distance(1.0 / 3.0, third), 2.0**-54 / 3.0, rtol=1e-10, atol=0.0)
