"""Where the tasks of a search are carried out: here, in processes of its own, or by an executor.

Tasks depend on nothing but their arguments, so it does not matter who carries them out, or whether
some are submitted ahead and never needed: results and their order are the same.

What carries a task out is sent with it, as bytes, and no process inherits anything but code. So any
executor will do, several searches can run side by side in threads, and where the system cannot make
processes a search works alone.
"""

from __future__ import annotations

import logging
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from concurrent import futures
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from functools import lru_cache, partial
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple, Protocol

from woodpecker.base.checks import whole
from woodpecker.base.lost import WorkerLostError

WATCH = 0.5  # s: how often a worker looks whether its owner is still there, if nothing tells it
PATIENCE = 2.0  # s: what takes less is done before processes that are started anew could help
READY = 64  # tasks for each worker that would have nothing to do while one takes long
KEPT = 4  # descriptions of tasks that a process remembers: one for each search it works for


class Done(NamedTuple):
    """What a task has returned, and how often it evaluated the map."""

    value: Any
    evaluations: int


class Pending(Protocol):
    """A task that was submitted."""

    def result(self) -> Done:
        """Wait for it."""

    def done(self) -> bool:
        """Whether it is finished."""

    def cancel(self) -> bool:
        """Give it up."""


Work = Callable[..., Done]


class Scheduler(Protocol):
    """Takes tasks."""

    @property
    def ahead(self) -> int:
        """How many tasks are worth submitting before they are needed."""

    @property
    def spare(self) -> int:
        """How many tasks are worth having ready for whoever would have nothing to do."""

    @property
    def is_idle(self) -> bool:
        """Whether somebody may soon have nothing to do."""

    def submit(self, *arguments: Any) -> Pending:
        """Submit a task."""

    def later(self, *arguments: Any) -> Pending:
        """Submit a task that gives way to others until its result is asked for."""

    def waited(self, pending: Pending) -> bool:
        """Wait until a task is finished, or another one; whether its result is there for asking."""


class _Later:
    """A task that is carried out when its result is asked for."""

    def __init__(self, work: Work, arguments: tuple[Any, ...]) -> None:
        self._work, self._arguments = work, arguments

    def result(self) -> Done:
        return self._work(*self._arguments)

    def done(self) -> bool:
        return False

    def cancel(self) -> bool:
        return True


class Serial:
    """The calling thread: what is not asked for is not done."""

    ahead = spare = 1
    is_idle = False

    def __init__(self, work: Work) -> None:
        self._work = work

    def submit(self, *arguments: Any) -> Pending:
        """A task, to be carried out when its result is asked for."""
        return _Later(self._work, arguments)

    later = submit

    def waited(self, _: Pending) -> bool:
        """Whether the result is there: it will be when it is asked for."""
        return True


class Parallel:
    """An executor: tasks are carried out while others are waited for."""

    def __init__(self, executor: Executor, work: Work, workers: int) -> None:
        self._executor, self._work, self._workers = executor, work, workers
        self.ahead, self.spare = 2 * workers, READY * workers
        self._open, self._fillers = set[Future[Done]](), set[Future[Done]]()
        self._ready, self._most = deque[_Spare](), max(1, workers - 1)
        self._lock = threading.RLock()  # futures are done in another thread

    @property
    def is_idle(self) -> bool:
        """Whether somebody may soon have nothing to do."""
        return len(self._open) < self._workers

    def submit(self, *arguments: Any) -> Future[Done]:
        """A task for the next worker that is free."""
        future = self._executor.submit(self._work, *arguments)
        with self._lock:
            self._open.add(future)
        future.add_done_callback(self._is_done)
        return future

    def later(self, *arguments: Any) -> Pending:
        """A task for a worker that would have nothing to do."""
        task = _Spare(self, arguments)
        with self._lock:
            self._ready.append(task)
            self._fill()
        return task

    def waited(self, pending: Pending) -> bool:
        """Wait until a task is finished, or another one; whether its result is there for asking."""
        with self._lock:
            others = {each for each in self._open if not each.done()}
        if others and not pending.done():
            futures.wait(others, return_when=futures.FIRST_COMPLETED)
        return pending.done() or not others

    def take(self, task: _Spare) -> None:
        """Submit a task that is ready now; or give it up, if it is cancelled."""
        with self._lock:
            if task in self._ready:
                self._ready.remove(task)
                if not task.cancelled:
                    task.future = self.submit(*task.arguments)
                    self._fillers.add(task.future)

    def wait_for(self, task: _Spare) -> Done:
        """The result of a task that was ready; nothing is more urgent now, so all fill up."""
        with self._lock:
            self.take(task)
            self._most = self._workers
            self._fill()
        assert task.future is not None
        try:
            return task.future.result()
        finally:
            self._most = max(1, self._workers - 1)

    def cancel(self) -> None:
        """Give up what is not begun."""
        with self._lock:
            self._ready.clear()
            waiting = tuple(self._open)
        for future in waiting:
            future.cancel()

    def _is_done(self, future: Future[Done]) -> None:
        with self._lock, suppress(RuntimeError):  # who asks for a result learns of a broken pool
            self._open.discard(future)
            self._fillers.discard(future)
            self._fill()

    def _fill(self) -> None:
        """Keep workers busy, but for one: the next of what is submitted step by step is urgent."""
        while self._ready and len(self._open) < self._workers and len(self._fillers) < self._most:
            self.take(self._ready[0])


class _Spare:
    """A task that is ready for a worker that would have nothing to do."""

    def __init__(self, parallel: Parallel, arguments: tuple[Any, ...]) -> None:
        self._parallel, self.arguments, self.cancelled = parallel, arguments, False
        self.future: Future[Done] | None = None

    def result(self) -> Done:
        return self._parallel.wait_for(self)

    def done(self) -> bool:
        return self.future is not None and self.future.done()

    def cancel(self) -> bool:
        self.cancelled = True
        self._parallel.take(self)
        return self.future is None or self.future.cancel()


class Joined:
    """The calling thread, and processes that join it once they have been started anew.

    Parameters
    ----------
    work, sent
        What is to be done with the arguments of a task, and what does it elsewhere.
    workers
        How many processes.
    stack
        Ends the processes.
    """

    def __init__(self, work: Work, sent: Work, workers: int, stack: ExitStack) -> None:
        self._here, self._sent, self._workers, self._stack = Serial(work), sent, workers, stack
        self._elsewhere: Parallel | None = None
        self._ready, self._due = threading.Event(), time.monotonic() + PATIENCE

    @property
    def ahead(self) -> int:
        """How many tasks are worth submitting before they are needed."""
        return self._now.ahead

    @property
    def spare(self) -> int:
        """How many tasks are worth having ready for whoever would have nothing to do."""
        return self._now.spare

    @property
    def is_idle(self) -> bool:
        """Whether somebody may soon have nothing to do."""
        return self._now.is_idle

    @property
    def _now(self) -> Scheduler:
        if self._elsewhere is not None and self._ready.is_set():
            return self._elsewhere
        return self._here

    def submit(self, *arguments: Any) -> Pending:
        """A task for the processes if they are there, for the calling thread if not."""
        self._grow()
        return self._now.submit(*arguments)

    def later(self, *arguments: Any) -> Pending:
        """The same, for a process that would have nothing to do."""
        self._grow()
        return self._now.later(*arguments)

    def waited(self, pending: Pending) -> bool:
        """Wait until a task is finished, or another one; whether its result is there for asking."""
        if self._elsewhere is None or isinstance(pending, _Later):
            return True
        return self._elsewhere.waited(pending)

    def _grow(self) -> None:
        """Start processes when it takes long."""
        if time.monotonic() >= self._due:
            self._due = math.inf
            pool = self._stack.enter_context(processes(self._workers))
            if pool is not None:
                self._elsewhere = Parallel(pool, self._sent, self._workers)
                pool.submit(os.getpid).add_done_callback(lambda _: self._ready.set())
                self._stack.callback(self._elsewhere.cancel)


@contextmanager
def scheduler(
    work: Work, workers: int | None, executor: Executor | None = None
) -> Iterator[Scheduler]:
    """Where tasks are carried out, for the time of a search.

    Parameters
    ----------
    work
        What is to be done with the arguments of a task.
    workers
        How many processes are started for it; by default one for each core. One works in this
        thread, and so does whoever cannot make processes: the workers of a
        :class:`multiprocessing.Pool`, or a system without them. Where processes cannot be copied
        safely, beside other threads and on systems other than Linux, this thread works alone until
        they have been started anew.
    executor
        What carries the tasks out instead; it is not shut down. ``workers`` then says how many it
        does at once.

    Raises
    ------
    ValueError
        If there is to be nobody, or the work cannot be sent to other processes.
    WorkerLostError
        If a process ends before its task does.
    """
    count = worker_count(workers)
    if executor is not None:
        with _given_up(Parallel(executor, _portable(work, executor), count)) as parallel:
            yield parallel
        return
    if count == 1:
        yield Serial(work)
        return
    sent = _sent(work)
    with ExitStack() as stack:
        if start_method() != "fork":
            yield Joined(work, sent, count, stack)
            return
        pool = stack.enter_context(processes(count))
        if pool is None:
            yield Serial(work)
            return
        with _given_up(Parallel(pool, sent, count)) as parallel:
            yield parallel


@contextmanager
def _given_up(parallel: Parallel) -> Iterator[Parallel]:
    """Tasks that nobody waits for any more are given up at the end."""
    try:
        yield parallel
    finally:
        parallel.cancel()


def worker_count(workers: int | None) -> int:
    """The number itself, or that of the cores this process may use.

    Raises
    ------
    ValueError
        If it is not a whole number of at least 1.
    """
    if workers is None:
        allowed = getattr(os, "sched_getaffinity", None)  # Linux
        return len(allowed(0)) if allowed is not None else os.cpu_count() or 1
    return whole("workers", workers)


# --- Sending work ---------------------------------------------------------------------------------


def _portable(work: Work, executor: Executor) -> Work:
    """The work in a form that an executor can carry."""
    if isinstance(executor, ThreadPoolExecutor):
        return work
    try:
        return _sent(work)
    except ValueError:
        if isinstance(executor, ProcessPoolExecutor):
            raise
        return work  # other executors have other ways to send what pickle cannot


def _sent(work: Work) -> Work:
    """The work as bytes, made into what it was where a task is carried out."""
    try:
        return partial(_perform, pickle.dumps(work))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise ValueError(
            f"the map cannot be sent to other processes ({error}): define it at the top level of a "
            "module, or search with workers=1"
        ) from None


def _perform(description: bytes, *arguments: Any) -> Done:
    return _work(description)(*arguments)


@lru_cache(maxsize=KEPT)
def _work(description: bytes) -> Work:
    work: Work = pickle.loads(description)
    return work


# --- Processes ------------------------------------------------------------------------------------


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor | None]:
    """Processes of this one's own, all started at once; None where none can be made.

    Ctrl-C is left to this process. They end with the block, at once if it ends by an error, and
    do not outlive this process, however it ends. Those that are still starting are not waited for.

    Raises
    ------
    WorkerLostError
        If one ends before its task does.
    """
    if multiprocessing.current_process().daemon:  # such a process may have no children
        yield None
        return
    method = start_method()
    context = multiprocessing.get_context(method)
    leash, hand = context.Pipe(duplex=False)
    with leash, hand:
        try:
            pool = ProcessPoolExecutor(count, context, initializer=_begin, initargs=(leash,))
            started = _started(pool, count)
        except (OSError, NotImplementedError) as error:
            logging.getLogger("woodpecker").info("working alone: no processes (%s)", error)
            yield None
            return
        try:
            yield pool
        except BaseException as error:  # what they are at is not wanted any more
            hand.send_bytes(b"end")
            if isinstance(error, BrokenProcessPool):
                raise WorkerLostError(_BROKEN) from error
            raise
        finally:
            there = method == "fork" or all(future.done() for future in started)
            pool.shutdown(wait=there, cancel_futures=True)


_BROKEN = (
    "a worker process ended before its task was done; where processes are started anew the script "
    "must guard its own start by `if __name__ == '__main__':`, and workers=1 needs no processes"
)


def start_method() -> str:
    """How processes are made: copied where that is safe and quick, otherwise started anew.

    A copy has one thread, and the locks that others held at the time stay locked in it. Starting
    anew takes the time of an import, one or two seconds.
    """
    alone = threading.active_count() == 1
    return "fork" if sys.platform == "linux" and alone else "spawn"


def _started(pool: ProcessPoolExecutor, count: int) -> list[Future[int]]:
    """One task for each process, done when it is there."""
    with warnings.catch_warnings():
        # Threads of compiled libraries count here; they look after their locks themselves.
        warnings.simplefilter("ignore", DeprecationWarning)
        return [pool.submit(os.getpid) for _ in range(count)]  # each starts one if none is free


def _begin(leash: Connection) -> None:
    """A worker leaves Ctrl-C to its owner, and ends when its owner says so or is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # what a copy has of its owner's is not for it
    threading.Thread(target=_watch, args=(leash,), daemon=True).start()


def _watch(leash: Connection) -> None:
    """End this process when its owner says so or has gone.

    The system closes what the owner has open when it ends, however it does; that wakes this thread.
    A copy of the owner that lives longer may hold it open: so who the parent is is looked up, too.
    """
    owner = multiprocessing.parent_process()
    assert owner is not None
    while not wait([leash, owner.sentinel], WATCH) and os.getppid() == owner.pid:
        pass
    os._exit(1)
