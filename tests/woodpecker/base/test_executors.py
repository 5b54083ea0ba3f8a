"""Where the tasks of a search are carried out: the order of results, and no worker left behind."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from woodpecker.base import executors
from woodpecker.base.executors import Done, Serial, scheduler, start_method, worker_count


def squared(x: int, pause: float = 0.0) -> Done:
    time.sleep(pause)
    return Done(x * x, 1)


def refuses(x: int) -> Done:
    raise ValueError(f"not {x}")


def dies(x: int) -> Done:
    os._exit(x)


def whose(_: int) -> Done:
    return Done(os.getpid(), 0)


def short(x: int) -> Done:
    with scheduler(squared, 2) as tasks:
        return tasks.submit(x).result()


class Table:
    """A task that remembers something."""

    def __init__(self, table: dict[int, int]) -> None:
        self.table = table

    def __call__(self, key: int) -> Done:
        return Done(self.table[key], 1)


def test_alone_does_nothing_that_is_not_asked_for() -> None:
    done: list[int] = []

    def task(x: int) -> Done:
        done.append(x)
        return squared(x)

    with scheduler(task, 1) as tasks:
        assert isinstance(tasks, Serial)
        first, second = tasks.submit(1), tasks.submit(2)
        assert second.result().value == 4
        assert first.cancel()
    assert done == [2]


@pytest.mark.parametrize("workers", [2, 3])
def test_results_come_as_they_were_submitted(workers: int) -> None:
    with scheduler(squared, workers) as tasks:
        pending = [tasks.submit(x, 0.02 * (3 - x)) for x in range(4)]
        assert [task.result().value for task in pending] == [0, 1, 4, 9]
    assert multiprocessing.active_children() == []


def test_spare_tasks_give_way_to_others() -> None:
    """One worker, held up by a first task: the second urgent one comes before the spare ones."""
    begin, done = threading.Event(), list[int]()

    def task(x: int) -> Done:
        assert begin.wait(60.0)
        done.append(x)
        return squared(x)

    with ThreadPoolExecutor(1) as pool, scheduler(task, 1, pool) as tasks:
        first = tasks.submit(0)
        spare = [tasks.later(x) for x in (1, 2, 3)]
        urgent = tasks.submit(4)
        assert spare[1].cancel()
        begin.set()
        assert [t.result().value for t in (first, urgent, spare[2], spare[0])] == [0, 16, 9, 1]
    assert done[:2] == [0, 4]
    assert sorted(done[2:]) == [1, 3]


def test_spare_tasks_leave_a_worker_free() -> None:
    """Of two workers one is kept for what is submitted step by step, until a spare one is asked."""
    release, begun = threading.Event(), list[int]()

    def task(x: int) -> Done:
        begun.append(x)
        assert x == 9 or release.wait(60.0)
        return squared(x)

    with ThreadPoolExecutor(2) as pool, scheduler(task, 2, pool) as tasks:
        spare = [tasks.later(x) for x in (1, 2, 3)]
        step = tasks.submit(9)
        while not tasks.waited(step):
            pass
        assert step.result().value == 81
        assert not spare[0].done()
        assert tasks.is_idle
        assert begun == [1, 9]
        release.set()
        assert [each.result().value for each in spare] == [1, 4, 9]


def test_waiting_ends_when_anything_is_done() -> None:
    """The quick task ends while the slow one is waited for: half a second later."""
    release, soon = threading.Event(), threading.Event()

    def task(x: int) -> Done:
        assert (soon if x == 1 else release).wait(60.0)
        return squared(x)

    with ThreadPoolExecutor(2) as pool, scheduler(task, 2, pool) as tasks:
        slow, quick = tasks.submit(2), tasks.submit(1)
        threading.Timer(0.5, soon.set).start()
        assert not tasks.waited(slow)
        assert quick.done()
        release.set()
        while not tasks.waited(slow):
            pass
        assert slow.result().value == 4


@pytest.mark.parametrize("workers", [1, 2])
def test_spare_tasks_are_done_without_being_asked_for(workers: int) -> None:
    with scheduler(squared, workers) as tasks:
        spare = [tasks.later(x) for x in range(5)]
        assert [task.result().value for task in spare] == [0, 1, 4, 9, 16]
    assert multiprocessing.active_children() == []


def test_spare_tasks_of_a_broken_pool_say_so() -> None:
    with pytest.raises(RuntimeError, match="ended before its task"), scheduler(dies, 2) as tasks:
        [tasks.later(3) for _ in range(4)][-1].result()


def test_what_a_task_remembers_is_sent() -> None:
    with scheduler(Table({3: 30}), 2) as tasks:
        assert tasks.submit(3).result() == Done(30, 1)


def test_an_error_of_a_task_is_raised_here() -> None:
    with pytest.raises(ValueError, match="not 7"), scheduler(refuses, 2) as tasks:
        tasks.submit(7).result()
    assert multiprocessing.active_children() == []


def test_a_worker_that_dies_is_named() -> None:
    with pytest.raises(RuntimeError, match="ended before its task"), scheduler(dies, 2) as tasks:
        tasks.submit(3).result()
    assert multiprocessing.active_children() == []


def test_an_interruption_does_not_wait_for_the_workers() -> None:
    begin = time.monotonic()

    def interrupted(tasks: Any) -> None:
        tasks.submit(1, 60.0)
        time.sleep(0.2)  # it has begun
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), scheduler(squared, 2) as tasks:
        interrupted(tasks)
    assert time.monotonic() - begin < 30.0
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_processes_are_not_copied_beside_other_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are started anew; until they are there this one goes on alone."""
    monkeypatch.setattr(executors, "PATIENCE", 0.0)
    found: list[int] = []

    def other() -> None:
        assert start_method() == "spawn"
        with scheduler(whose, 2) as tasks:
            assert tasks.ahead == 1
            while found[-1:] in ([], [os.getpid()]):
                found.append(tasks.submit(0).result().value)
            assert tasks.ahead == 4

    with ThreadPoolExecutor(1) as thread:
        thread.submit(other).result(timeout=120.0)
    assert found[0] == os.getpid()


def test_a_short_search_beside_other_threads_starts_no_processes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(executors, "processes", None)
    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(short, 3).result() == Done(9, 1)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux only")
def test_processes_are_copied_where_there_is_one_thread() -> None:
    assert threading.active_count() == 1
    assert start_method() == "fork"


def test_a_given_executor_is_used_and_not_shut_down() -> None:
    table = {3: 30}
    with ThreadPoolExecutor(2) as threads:
        with scheduler(lambda key: Done(table[key], 1), None, threads) as tasks:
            assert tasks.submit(3).result() == Done(30, 1)
        assert threads.submit(int).result() == 0
    with ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as processes:
        with scheduler(whose, None, processes) as tasks:
            assert tasks.submit(0).result().value != os.getpid()
        assert processes.submit(int).result() == 0


def test_an_executor_is_left_without_what_is_not_wanted() -> None:
    begin = time.monotonic()
    with ThreadPoolExecutor(1) as threads, scheduler(squared, 1, threads) as tasks:
        pending = [tasks.submit(x, 0.2) for x in range(100)]
        assert pending[0].result().value == 0
    assert time.monotonic() - begin < 10.0  # of 20 s


@pytest.mark.parametrize("own", [True, False])
def test_what_does_not_pickle_is_refused_in_a_sentence(own: bool) -> None:
    sentence = "the map cannot be sent to other processes .*, or search with workers=1"
    with ProcessPoolExecutor(1) as pool:
        executor: Executor | None = None if own else pool
        with (
            pytest.raises(ValueError, match=sentence),
            scheduler(lambda x: squared(x), 2, executor),
        ):
            pass


class Anything(Executor):
    """An executor that needs nothing pickled."""

    def submit(self, fn: Any, /, *arguments: Any, **options: Any) -> Any:
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(fn, *arguments, **options)


def test_other_executors_may_carry_what_does_not_pickle() -> None:
    with scheduler(lambda x: squared(x), 2, Anything()) as tasks:
        assert tasks.submit(3).result() == Done(9, 1)


def in_a_pool(_: int) -> tuple[str, int]:
    with scheduler(whose, None) as tasks:
        return type(tasks).__name__, tasks.submit(0).result().value - os.getpid()


def test_a_worker_of_a_pool_works_alone() -> None:
    """Such processes are daemons, which may have no children."""
    with multiprocessing.Pool(1) as pool:
        assert pool.map(in_a_pool, [0]) == [("Serial", 0)]


def test_where_no_processes_can_be_made_the_search_works_alone(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def impossible(*_: Any, **__: Any) -> Any:
        raise NotImplementedError("no semaphores")

    monkeypatch.setattr(executors, "ProcessPoolExecutor", impossible)
    with caplog.at_level("INFO", logger="woodpecker"), scheduler(squared, 4) as tasks:
        assert isinstance(tasks, Serial)
    assert caplog.messages == ["working alone: no processes (no semaphores)"]


ORPHANS = """
import os, time
from concurrent.futures import ThreadPoolExecutor
from woodpecker.base.executors import processes
def work():
    with processes(3) as pool:
        print(*[p.pid for p in pool._processes.values()], flush=True)
        time.sleep(60.0)
if __name__ == "__main__":
    {start}
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc who is there")
@pytest.mark.parametrize("start", ["work()", "ThreadPoolExecutor(1).submit(work).result()"])
def test_workers_do_not_outlive_a_process_that_is_killed(start: str, tmp_path: Any) -> None:
    script = tmp_path / "orphans.py"
    script.write_text(ORPHANS.format(start=start), encoding="utf-8")
    process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    workers = [int(pid) for pid in process.stdout.readline().split()]
    assert len(workers) == 3
    process.kill()
    process.wait()
    process.stdout.close()
    deadline = time.monotonic() + 60.0  # a busy machine; they look once a second
    while any(map(_is_running, workers)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(_is_running, workers))


def _is_running(pid: int) -> bool:
    """Whether a process is there, and is not a zombie that nobody has asked for."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:  # noqa: PTH123
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_somebody_must_work(workers: Any) -> None:
    with (
        pytest.raises(ValueError, match=f"workers must be a whole number .*{workers!r}"),
        scheduler(squared, workers),
    ):
        pass


def test_numbers_of_workers() -> None:
    assert worker_count(np.int64(3)) == 3
    assert worker_count(None) >= 1
