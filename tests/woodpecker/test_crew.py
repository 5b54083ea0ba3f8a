"""Who does the work of a search: the order of results, and no worker is left behind."""

from __future__ import annotations

import multiprocessing
import time
from typing import Any

import pytest

from woodpecker.crew import Alone, Done, can_fork, crew

forked = pytest.mark.skipif(not can_fork(), reason="this system does not copy processes")


def squared(x: int, pause: float = 0.0) -> Done:
    time.sleep(pause)
    return Done(x * x, 1)


def refuses(x: int) -> Done:
    raise ValueError(f"not {x}")


def test_alone_does_nothing_that_is_not_asked_for() -> None:
    done: list[int] = []

    def task(x: int) -> Done:
        done.append(x)
        return squared(x)

    with crew(task, 1) as hands:
        assert isinstance(hands, Alone)
        first, second = hands.order(1), hands.order(2)
        assert second.result().value == 4
        assert first.cancel()
    assert done == [2]


@forked
@pytest.mark.parametrize("workers", [2, 3])
def test_results_come_as_they_were_ordered(workers: int) -> None:
    with crew(squared, workers) as hands:
        orders = [hands.order(x, 0.02 * (3 - x)) for x in range(4)]
        assert [order.result().value for order in orders] == [0, 1, 4, 9]
    assert multiprocessing.active_children() == []


@forked
def test_copies_know_what_they_were_made_of() -> None:
    """A task that cannot be sent, because it remembers something, is inherited."""
    table = {3: 30}

    def task(key: int) -> Done:
        return Done(table[key], 1)

    with crew(task, 2) as hands:
        assert hands.order(3).result() == Done(30, 1)


@forked
def test_an_error_of_a_task_is_raised_here() -> None:
    with pytest.raises(ValueError, match="not 7"), crew(refuses, 2) as hands:
        hands.order(7).result()
    assert multiprocessing.active_children() == []


@forked
def test_an_interruption_does_not_wait_for_the_workers() -> None:
    begin = time.monotonic()

    def interrupted(hands: Any) -> None:
        hands.order(1, 60.0)
        time.sleep(0.2)  # it has begun
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), crew(squared, 2) as hands:
        interrupted(hands)
    assert time.monotonic() - begin < 30.0
    assert multiprocessing.active_children() == []


def test_somebody_must_work() -> None:
    with pytest.raises(ValueError, match="workers must be at least 1, got 0"), crew(squared, 0):
        pass
