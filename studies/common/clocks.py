"""Timing: jobs alternate in rounds, so that a busy machine slows all of them down alike."""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar

T = TypeVar("T")
SHORTEST = 5e-3  # s; a job repeats its work until it lasts about this long
TICK = 1e-6  # s, of the clock


class Seconds(NamedTuple):
    """Wall and CPU time [s] of one unit of work."""

    wall: float
    cpu: float


Job = Callable[[], Seconds]
Timing = dict[str, float]


def clocked(work: Callable[[], object], count: int = 1, units: int = 1) -> Job:
    """Job that does some work ``count`` times and reports the time of one of its units."""

    def job() -> Seconds:
        wall, cpu = time.perf_counter(), spent()
        for _ in range(count):
            work()
        return shared(Seconds(time.perf_counter() - wall, spent() - cpu), count * units)

    return job


def shared(seconds: Seconds, units: int) -> Seconds:
    """Time of one of several equal units."""
    return Seconds(seconds.wall / units, seconds.cpu / units)


def repeats(cpu: float) -> int:
    """How often to do a work of so many CPU seconds."""
    return max(1, math.ceil(SHORTEST / max(cpu, TICK)))


def repeated(work: Callable[[], object]) -> Job:
    """Job that repeats a work, compiled by a first call, for about 5 ms."""
    work()
    return clocked(work, repeats(clocked(work)().cpu))


def timed(work: Callable[[], T]) -> tuple[T, Seconds]:
    """What a work gives, and the time of this one run."""
    kept: list[T] = []
    taken = clocked(lambda: kept.append(work()))()
    return kept[0], taken


def spent() -> float:
    """CPU time [s] of this process and of those it has waited for."""
    others = os.times()
    return time.process_time() + others.children_user + others.children_system


def race(jobs: Mapping[str, Job], rounds: int) -> dict[str, Timing]:
    """All jobs in turn; a first round, in which caches fill, does not count."""
    taken: dict[str, list[Seconds]] = {name: [] for name in jobs}
    for _ in range(1 + rounds):
        for name, job in jobs.items():
            taken[name].append(job())
    return {name: summary(seconds[1:]) for name, seconds in taken.items()}


def summary(seconds: Sequence[Seconds]) -> Timing:
    """Median and minimum of wall and CPU time [s]."""
    wall, cpu = [each.wall for each in seconds], [each.cpu for each in seconds]
    return {
        "wall_median": statistics.median(wall),
        "wall_minimum": min(wall),
        "cpu_median": statistics.median(cpu),
        "cpu_minimum": min(cpu),
        "rounds": len(seconds),
    }


def ratio(timings: Mapping[str, Timing], slow: str, quick: str, clock: str) -> float | None:
    """Ratio of medians; None if one was not measured."""
    if slow not in timings or quick not in timings:
        return None
    return timings[slow][f"{clock}_median"] / timings[quick][f"{clock}_median"]


def over(timings: Mapping[str, Timing], slow: str, quick: str) -> float:
    """Ratio of medians of CPU time of two that were measured."""
    return timings[slow]["cpu_median"] / timings[quick]["cpu_median"]
