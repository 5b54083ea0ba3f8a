"""Speed, for `pytest-benchmark compare`: nothing here fails because a machine is slow."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from woodpecker import Toy, first_return, return_map, shoot
from woodpecker.base.compiled import COMPILED

PHI_S = -0.52947197  # the nominal cycle
POINTS = 1000 if COMPILED else 20

pytestmark = pytest.mark.benchmark(min_rounds=3, max_time=0.3, warmup=False)


@pytest.fixture(autouse=True)
def _compiled() -> None:
    """The first call compiles; it is not measured."""
    first_return(Toy(), PHI_S)


def test_one_return(benchmark: BenchmarkFixture) -> None:
    lap = benchmark(first_return, Toy(), PHI_S)
    assert lap.status.success


def test_map_on_one_core(benchmark: BenchmarkFixture) -> None:
    starts = np.linspace(-2.5, -0.24, POINTS)
    with ThreadPoolExecutor(1) as one_core:
        curve = benchmark(return_map, Toy(), starts, executor=one_core)
    assert curve.phi_s.shape == (POINTS,)


def test_shoot(benchmark: BenchmarkFixture) -> None:
    orbit = benchmark(shoot, Toy(), -0.53)
    assert orbit.success
