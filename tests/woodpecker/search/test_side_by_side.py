"""Searches of the toy side by side, in threads, processes and pools: each as if it were alone."""

import math
import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import rounding
from diagrams import to_the_last_bit
from needs import NEEDS_NUMBA

from woodpecker import Search, Toy, bifurcation_diagram, continuation, shoot
from woodpecker.base.settings import Settings
from woodpecker.diagrams import bifurcation_search

FRICTIONS = (0.30, 0.31, 0.32, 0.33)
Shown = list[tuple[object, ...]]

pytestmark = pytest.mark.usefixtures("workers_at_once")


def searched(mu_2: float, **options: Any) -> Shown:
    found = bifurcation_diagram(
        Toy(mu_2=mu_2),
        "eps_n1",
        (0.1, 0.2),
        (1,),
        (-0.95, -0.6),
        search=Search(slices=8),
        **options,
    )
    return to_the_last_bit(found)


def alone(mu_2: float) -> Shown:
    return searched(mu_2, workers=1)


@pytest.fixture(scope="module")
def expected() -> list[Shown]:
    return [alone(mu_2) for mu_2 in FRICTIONS]


def in_threads(task: Callable[[float], Shown]) -> list[Shown]:
    with ThreadPoolExecutor(len(FRICTIONS)) as threads:
        return list(threads.map(task, FRICTIONS))


def in_one_executor_of_threads() -> list[Shown]:
    with ThreadPoolExecutor(3) as threads:
        return [searched(mu_2, executor=threads) for mu_2 in FRICTIONS]


def in_one_executor_of_processes() -> list[Shown]:
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, spawned, initializer=rounding.apply) as processes:
        return [searched(mu_2, executor=processes, workers=1) for mu_2 in FRICTIONS]


def in_a_pool() -> list[Shown]:
    with multiprocessing.Pool(2) as pool:
        return pool.map(searched, FRICTIONS)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "way",
    [
        lambda: [searched(mu_2) for mu_2 in FRICTIONS],
        lambda: in_threads(alone),
        lambda: in_threads(searched),
        in_one_executor_of_threads,
        in_one_executor_of_processes,
        in_a_pool,
    ],
    ids=["one after the other", "threads", "threads with processes", "an executor of threads",
         "an executor of processes", "a pool"],
)  # fmt: skip
@NEEDS_NUMBA
def test_each_diagram_is_that_of_its_toy(
    way: Callable[[], list[Shown]], expected: list[Shown]
) -> None:
    assert len({str(each) for each in expected}) == len(FRICTIONS)
    assert way() == expected


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"window": (-math.inf, -0.24)}, r"needs a finite window, got \(-inf, -0.24\)"),
        ({"span": (0.0, math.inf)}, r"span must be finite, got \(0.0, inf\)"),
        ({"parameter": "pole", "span": (0.01, math.inf)}, "span must be finite"),
        ({"orders": (True,)}, "orders must be a whole number of at least 1, got True"),
        ({"workers": 0}, "workers must be a whole number of at least 1, got 0"),
    ],
)
def test_a_search_that_is_refused_leaves_an_older_run_as_it_was(
    options: dict[str, Any], sentence: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.jsonl"
    path.write_text("kept\n", encoding="utf-8")
    with pytest.raises(ValueError, match=sentence):
        bifurcation_search(Toy(), run=str(path), **options)
    assert path.read_text(encoding="utf-8") == "kept\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_continuation_that_is_refused_leaves_an_older_run_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    path.write_text("kept\n", encoding="utf-8")
    orbit = shoot(Toy(), -0.53)
    with pytest.raises(ValueError, match="span must be finite"):
        continuation(Toy(pole=1.0), shoot(Toy(pole=1.0), -0.53), "pole", (0.01, math.inf), run=path)
    low = Settings(window=(-1.0, -0.8))
    with pytest.raises(ValueError, match="window must hold the orbit"):
        continuation(Toy(), orbit, settings=low, run=path)
    assert path.read_text(encoding="utf-8") == "kept\n"
    continuation(Toy(), orbit, span=(0.499, 0.501), run=str(path))
    assert path.with_name("run.jsonl.old").read_text(encoding="utf-8") == "kept\n"
