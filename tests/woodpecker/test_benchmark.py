"""Speed, for `pytest-benchmark compare`: nothing here fails because a machine is slow."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from woodpecker import Toy, first_return, return_map, shoot
from woodpecker.base.compiled import COMPILED

PHI_S = -0.52947197  # the nominal cycle
IMAGE, FIXED = -0.529471964686405381795, -0.529471967110851035675  # of 30 digits
POINTS = 1000 if COMPILED else 20

pytestmark = pytest.mark.benchmark(min_rounds=3, max_time=0.3, warmup=False)


@pytest.fixture(autouse=True)
def _compiled() -> None:
    """The first call compiles; it is not measured."""
    first_return(Toy(), PHI_S)


def test_one_return(benchmark: BenchmarkFixture) -> None:
    once = benchmark(first_return, Toy(), PHI_S)
    assert once.phi_s == pytest.approx(IMAGE, abs=1e-14)  # some spacings of doubles


def test_map_on_one_core(benchmark: BenchmarkFixture) -> None:
    starts = np.linspace(-2.5, -0.24, POINTS)
    with ThreadPoolExecutor(1) as one_core:
        curve = benchmark(return_map, Toy(), starts, executor=one_core)
    assert curve.phi_s.shape == (POINTS,)
    assert curve.phi_s[0] == first_return(Toy(), starts[0]).phi_s


def test_shoot(benchmark: BenchmarkFixture) -> None:
    orbit = benchmark(shoot, Toy(), -0.53)
    assert orbit.success
    assert orbit.phi_s == pytest.approx(FIXED, abs=1e-12)  # where Newton's method stops
