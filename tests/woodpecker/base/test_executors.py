"""Where the tasks of a search are carried out: the order of results, and no worker left behind."""

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import pytest
from processes import is_running

from woodpecker.base import executors
from woodpecker.base.executors import (
    Done,
    Scheduler,
    scheduler,
    start_method,
)

pytestmark = pytest.mark.usefixtures("workers_at_once")


def squared(x: int, pause: float = 0.0) -> Done:
    time.sleep(pause)
    return Done(x * x, 1)


def refuses(x: int) -> Done:
    raise ValueError(f"not {x}")


def dies(x: int) -> Done:
    os._exit(x)


def whose(_: object) -> Done:
    return Done(os.getpid(), 0)


def elsewhere(tasks: Scheduler, *call: Any) -> Done:
    """A task as somebody else carries it out."""
    tasks.expect([call])
    deadline = time.monotonic() + 60.0
    while (done := tasks.peek(*call)) is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert done is not None
    assert tasks.result(*call) is done
    return done


def test_alone_does_nothing_that_is_not_asked_for() -> None:
    done: list[int] = []

    def task(x: int) -> Done:
        done.append(x)
        return squared(x)

    with scheduler(task, 1) as tasks:
        tasks.expect([(1,), (2,)])
        assert tasks.peek(2) is None
        assert tasks.result(2).value == 4
    assert done == [2]


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_results_are_those_of_the_tasks(workers: int) -> None:
    calls = [(x, 0.02 * (6 - x)) for x in range(6)]
    with scheduler(squared, workers) as tasks:
        for k, call in enumerate(calls):
            tasks.expect(calls[k + 1 :])
            assert tasks.result(*call).value == k * k
    assert multiprocessing.active_children() == []


def test_what_is_expected_is_begun_by_others() -> None:
    with scheduler(whose, 2) as tasks:
        assert elsewhere(tasks, "one").value != os.getpid()
        assert tasks.result("two").value == os.getpid()


def test_what_nobody_has_begun_is_done_here_and_others_while_waiting() -> None:
    """The one thread is held up by the first of three tasks, which is asked for first."""
    release, by = threading.Event(), dict[str, str]()

    def task(name: str) -> Done:
        by[name] = threading.current_thread().name
        if name == "held up":
            assert release.wait(60.0)
        if name == "last":
            release.set()
        return Done(name, 1)

    here = threading.current_thread().name
    with ThreadPoolExecutor(1, "other") as pool, scheduler(task, 1, pool) as tasks:
        tasks.expect([("held up",), ("next",), ("last",)])
        assert tasks.result("next").value == "next"
        assert tasks.result("held up").value == "held up"
        assert tasks.result("last").value == "last"
    assert by == {"held up": "other_0", "next": here, "last": here}


def test_what_is_not_expected_any_more_is_forgotten() -> None:
    begun, release = list[str](), threading.Event()

    def task(name: str) -> Done:
        begun.append(name)
        assert release.wait(60.0)
        return Done(name, 1)

    with ThreadPoolExecutor(1) as pool, scheduler(task, 1, pool) as tasks:
        tasks.expect([("one",), ("two",)])
        tasks.expect([("one",), ("three",)])
        release.set()
        assert tasks.result("three").value == "three"
    assert "two" not in begun


def test_the_calling_thread_and_others_share_the_map() -> None:
    """It is sent once: what refers to it refers to that of the other side."""
    table = {3: 30}

    def task(key: int, there: dict[int, int]) -> Done:
        return Done((there is table, there), table[key])

    with scheduler(task, 2, shared=table) as tasks:
        done = elsewhere(tasks, 3, table)
    assert done.evaluations == 30
    assert done.value[0]
    assert done.value[1] is table


def test_an_error_waits_for_its_turn() -> None:
    with scheduler(refuses, 2) as tasks:
        tasks.expect([(7,), (8,)])
        assert tasks.peek(7) is None
        with pytest.raises(ValueError, match="not 7"):
            tasks.result(7)
    assert multiprocessing.active_children() == []


def test_a_worker_that_dies_is_named() -> None:
    def asked(tasks: Scheduler) -> Done:
        tasks.expect([(3,)])
        return tasks.result(3)

    with pytest.raises(RuntimeError, match="ended before its task"), scheduler(dies, 2) as tasks:
        asked(tasks)
    assert multiprocessing.active_children() == []


def test_an_interruption_does_not_wait_for_the_workers() -> None:
    begin = time.monotonic()

    def interrupted(tasks: Any) -> None:
        tasks.expect([(1, 60.0)])
        time.sleep(0.2)  # it has begun
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), scheduler(squared, 2) as tasks:
        interrupted(tasks)
    assert time.monotonic() - begin < 30.0
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_processes_are_not_copied_beside_other_threads() -> None:
    """They are started anew; until they are there this one goes on alone."""

    def other() -> None:
        assert start_method() == "spawn"
        with scheduler(whose, 2) as tasks:
            assert elsewhere(tasks, 0).value != os.getpid()

    with ThreadPoolExecutor(1) as thread:
        thread.submit(other).result(timeout=120.0)


def test_a_short_search_starts_no_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "PATIENCE", 60.0)
    with scheduler(squared, 2) as tasks:
        tasks.expect([(3,)])
        assert multiprocessing.active_children() == []
        assert tasks.result(3) == Done(9, 1)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux only")
def test_processes_are_copied_where_there_is_one_thread() -> None:
    assert threading.active_count() == 1
    assert start_method() == "fork"


def test_a_given_executor_is_used_and_not_shut_down() -> None:
    with ThreadPoolExecutor(2) as threads:
        with scheduler(lambda key: Done(threading.current_thread().name, key), None, threads) as t:
            assert elsewhere(t, 3).value != threading.current_thread().name
        assert threads.submit(int).result() == 0
    with ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as processes:
        with scheduler(whose, None, processes) as tasks:
            assert elsewhere(tasks, 0).value != os.getpid()
        assert processes.submit(int).result() == 0


class Fumbling(ThreadPoolExecutor):
    """Its results do not arrive, as those of a cluster that loses a worker may not."""

    def submit(self, work: Any, /, *arguments: Any, **options: Any) -> Any:
        """A future that fails, whatever its task comes to."""

        def lose() -> None:
            work(*arguments, **options)
            raise ValueError("lost on the way")

        return super().submit(lose)


def test_what_a_given_executor_fails_to_hand_over_is_done_here() -> None:
    """An error of the task itself is raised here, too."""
    with Fumbling(1) as executor:
        for work in (squared, refuses):
            with scheduler(work, 1, executor) as tasks:
                tasks.expect([(3,)])
                if work is squared:
                    assert tasks.result(3).value == 9
                else:
                    with pytest.raises(ValueError, match="not 3"):
                        tasks.result(3)


def test_an_executor_is_left_without_what_is_not_wanted() -> None:
    begin = time.monotonic()
    with ThreadPoolExecutor(1) as threads, scheduler(squared, 1, threads) as tasks:
        tasks.expect([(x, 0.2) for x in range(100)])
        assert tasks.result(0, 0.0).value == 0
    assert time.monotonic() - begin < 10.0  # of 20 s


@pytest.mark.parametrize("own", [True, False])
def test_what_cannot_be_sent_is_refused_in_a_sentence(own: bool) -> None:
    lock, sentence = threading.Lock(), "the map cannot be sent to other processes .* workers=1"
    with ProcessPoolExecutor(1) as pool:
        executor: Executor | None = None if own else pool
        with pytest.raises(ValueError, match=sentence), scheduler(lambda x: lock, 2, executor):  # type: ignore[arg-type, return-value]
            pass


def in_a_pool(_: int) -> bool:
    with scheduler(whose, 2) as tasks:
        tasks.expect([(0,)])
        return tasks.peek(0) is None and tasks.result(0).value == os.getpid()


def test_a_worker_of_a_pool_works_alone() -> None:
    """Such processes are daemons, which may have no children."""
    with multiprocessing.Pool(1) as pool:
        assert pool.map(in_a_pool, [0]) == [True]


def test_where_no_processes_can_be_made_the_search_works_alone(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def impossible(*_: Any, **__: Any) -> Any:
        raise NotImplementedError("no semaphores")

    monkeypatch.setattr(executors, "ProcessPoolExecutor", impossible)
    with caplog.at_level("INFO", logger="woodpecker"), scheduler(whose, 4) as tasks:
        tasks.expect([(0,)])
        assert tasks.result(0).value == os.getpid()
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
    while any(map(is_running, workers)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_running, workers))


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_somebody_must_work(workers: Any) -> None:
    with (
        pytest.raises(ValueError, match=f"workers must be a whole number .*{workers!r}"),
        scheduler(squared, workers),
    ):
        pass
