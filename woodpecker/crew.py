"""Who does the work of a search: this process, or several of it.

The tasks of a search depend on nothing but their arguments, so it does not matter who does them, or
whether some are done ahead and never needed: results and their order are the same.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

WATCH = 1.0  # s: how often a worker looks whether its parent is still there


class Done(NamedTuple):
    """What a task has returned, and how often it evaluated the map."""

    value: Any
    evaluations: int


class Ordered(Protocol):
    """A task that was ordered."""

    def result(self) -> Done:
        """Wait for it."""

    def cancel(self) -> bool:
        """Give it up."""


Task = Callable[..., Done]


class Crew(Protocol):
    """Takes orders for tasks."""

    ahead: int  # how many tasks are worth ordering before they are needed

    def order(self, *arguments: Any) -> Ordered:
        """Order a task."""


class _Later:
    """A task that is done when its result is asked for."""

    def __init__(self, task: Task, arguments: tuple[Any, ...]) -> None:
        self._task, self._arguments = task, arguments

    def result(self) -> Done:
        return self._task(*self._arguments)

    def cancel(self) -> bool:
        return True


class Alone:
    """The process itself: what is not asked for is not done."""

    ahead = 1

    def __init__(self, task: Task) -> None:
        self._task = task

    def order(self, *arguments: Any) -> Ordered:
        """A task, to be done when its result is asked for."""
        return _Later(self._task, arguments)


class Forked:
    """Copies of this process, made when the first task is ordered."""

    def __init__(self, pool: ProcessPoolExecutor, workers: int) -> None:
        self._pool, self.ahead = pool, 2 * workers

    def order(self, *arguments: Any) -> Future[Done]:
        """A task for the next copy that is free."""
        with warnings.catch_warnings():
            # A copy of a process with threads can find a lock of theirs taken. The workers call
            # nothing but the map, which takes none.
            warnings.simplefilter("ignore", DeprecationWarning)
            return self._pool.submit(_perform, *arguments)


_inherited: Task  # of the copies: arguments of tasks are sent to them, the map need not be


def _perform(*arguments: Any) -> Done:
    return _inherited(*arguments)


def _begin(parent: int) -> None:
    """A worker leaves Ctrl-C to its parent, and does not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def can_fork() -> bool:
    """Whether this system copies processes, safely as far as it says itself."""
    return "fork" in multiprocessing.get_all_start_methods() and os.uname().sysname == "Linux"


@contextmanager
def crew(task: Task, workers: int | None) -> Iterator[Crew]:
    """Someone to do the work.

    Parameters
    ----------
    task
        What is to be done with the arguments of an order.
    workers
        How many processes; by default one for each core where processes can be copied. One works in
        this process.

    Raises
    ------
    ValueError
        If there is to be nobody.
    """
    global _inherited
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    count = workers if workers is not None else (len(os.sched_getaffinity(0)) if can_fork() else 1)
    if count == 1 or not can_fork():
        yield Alone(task)
        return
    _inherited = task
    pool = ProcessPoolExecutor(
        count, multiprocessing.get_context("fork"), initializer=_begin, initargs=(os.getpid(),)
    )
    others = set(multiprocessing.active_children())
    try:
        yield Forked(pool, count)
    except BaseException:  # what they are at is not wanted any more
        for child in set(multiprocessing.active_children()) - others:
            child.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
