"""Run the tasks of a search in this thread and, ahead of time, in worker processes or an executor.

The calling thread does the task that is needed next; workers begin those likely to be needed later.
A task depends on its arguments only, so results and their order are those of a single thread.
"""

from __future__ import annotations

import io
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
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property, lru_cache, partial
from multiprocessing.connection import wait
from typing import Any, NamedTuple

import cloudpickle

from woodpecker.base.checks import whole
from woodpecker.base.lost import WorkerLostError
from woodpecker.base.shown import shown

WATCH = 0.5  # s: period at which a worker checks that its parent still runs
PATIENCE = 0.5  # s: shorter searches end before other processes could help
READY = 16  # tasks kept ready for each worker while the calling thread is busy
KEPT = 4  # works that a worker process keeps unpickled, one for each search


class Done(NamedTuple):
    """The result of a task, and the number of evaluations of the map that it took."""

    value: Any
    evaluations: int


Work = Callable[..., Done]
Call = tuple[Any, ...]


def _dumped(value: object, shared: object) -> bytes:
    """Pickle a task or a result, with a reference in place of the object ``shared``."""
    file = io.BytesIO()
    pickler: Any = cloudpickle.Pickler(file)
    pickler.persistent_id = lambda each: "shared" if each is shared else None
    pickler.dump(value)
    return file.getvalue()


def _loaded(sent: bytes, shared: object) -> Any:
    """Unpickle a task or a result, with this process's ``shared`` in place of the reference."""
    unpickler: Any = pickle.Unpickler(io.BytesIO(sent))
    unpickler.persistent_load = lambda _: shared
    return unpickler.load()


class _Begun:
    """A task that was begun; it keeps its arguments alive, because their ids identify it."""

    def __init__(
        self, call: Call, future: Future[Any], shared: object = None, again: Work | None = None
    ) -> None:
        self.call, self.future, self._shared, self._again = call, future, shared, again

    @cached_property
    def result(self) -> Done:
        try:
            found: Any = self.future.result()
            done: Done = _loaded(found, self._shared) if isinstance(found, bytes) else found
            return done
        except Exception:
            if self._again is None:
                raise
        return self._again(*self.call)


class Scheduler:
    """Does ``work`` for tuples of arguments; two calls with the same objects are one task.

    The calling thread does the tasks that are needed now. An executor may begin others: ``start``
    returns it, or None, and is called once ``patience`` [s] is over; it is given as many tasks at
    once as there are ``workers``. ``sent`` is the pickled work with what is ``shared``, empty for
    threads. If ``forgiving``, a task that fails in the executor is repeated in this thread.
    """

    def __init__(
        self, work: Work, sent: bytes = b"", shared: object = None,
        start: Callable[[], Executor | None] = lambda: None, workers: int = 0,
        patience: float = math.inf, *, forgiving: bool = False,
    ) -> None:  # fmt: skip
        self._work, self._sent, self._shared = work, sent, shared
        self._again = work if forgiving else None
        self._start, self._workers = start, workers
        self._due = time.monotonic() + patience
        self._executor: Executor | None = None
        self._ready, self._begun = dict[Call, Call](), dict[Call, _Begun]()
        self._open, self._lock = set[Future[Any]](), threading.RLock()

    def result(self, *call: Any) -> Done:
        """The result of a task; while a worker is at it, this thread does other expected tasks."""
        with self._lock:
            self._ready.pop(_key(call), None)
            begun = self._begun.pop(_key(call), None)
        if begun is None:
            return self._work(*call)
        while not begun.future.done() and self._do_next():
            pass
        return begun.result

    def expect(self, calls: Iterable[Call]) -> None:
        """Announce the tasks likely to be needed, in order; earlier announcements are dropped."""
        if self._executor is None and time.monotonic() >= self._due:
            self._due, self._executor = math.inf, self._start()
        if self._executor is None:
            return
        ready = dict[Call, Call]()
        for call in calls:
            if _key(call) not in self._begun:
                ready[_key(call)] = call
            if len(ready) >= READY * self._workers:
                break
        with self._lock:
            self._ready = ready
            self._fill()

    def peek(self, *call: Any) -> Done | None:
        """The result of an expected task if it is done, else None; :meth:`result` raises errors."""
        begun = self._begun.get(_key(call))
        if begun is None or not begun.future.done() or begun.future.cancelled():
            return None
        return None if begun.future.exception() is not None else begun.result

    def cancel(self) -> None:
        """Cancel all tasks that have not begun."""
        with self._lock:
            self._ready = {}
            waiting = tuple(self._open)
        for future in waiting:
            future.cancel()

    def _fill(self) -> None:
        """Submit expected tasks until all workers are busy; finished futures call this, too."""
        assert self._executor is not None
        while self._ready and len(self._open) < self._workers:
            key = next(iter(self._ready))
            call = self._ready.pop(key)
            future: Future[Any]
            if self._sent:
                future = self._executor.submit(_perform, self._sent, _dumped(call, self._shared))
            else:
                future = self._executor.submit(self._work, *call)
            self._begun[key] = _Begun(call, future, self._shared, self._again)
            self._open.add(future)
            future.add_done_callback(self._is_done)

    def _is_done(self, future: Future[Any]) -> None:
        with self._lock, suppress(RuntimeError):  # of a broken pool, which ``result`` raises
            self._open.discard(future)
            self._fill()

    def _do_next(self) -> bool:
        """Do the first expected task in this thread; False if there is none."""
        with self._lock:
            if not self._ready:
                return False
            key = next(iter(self._ready))
            begun = _Begun(self._ready.pop(key), Future())
            self._begun[key] = begun
        try:
            begun.future.set_result(self._work(*begun.call))
        except Exception as error:  # raised if the result is asked for
            begun.future.set_exception(error)
        return True


def _key(call: Call) -> Call:
    return tuple(map(id, call))


@contextmanager
def scheduler(
    work: Work, workers: int | None, executor: Executor | None = None, shared: object = None
) -> Iterator[Scheduler]:
    """A :class:`Scheduler` for the duration of a search.

    It uses ``workers`` processes including this one, by default one per core, and this one alone if
    no others can be started; or an executor of :mod:`concurrent.futures`, which is left open, with
    as many tasks at once. ``shared`` is a part of the work to which tasks refer. ValueError if the
    number is below 1, or the work cannot be pickled; TypeError if the executor is none;
    WorkerLostError if a process ends before its task does.
    """
    count = worker_count(workers)
    if not (executor is None or hasattr(executor, "submit")):
        raise TypeError(f"executor must have a method submit, got {shown(executor)}")
    if executor is None and count == 1:
        yield Scheduler(work)
        return
    sent = b"" if isinstance(executor, ThreadPoolExecutor) else _sent(work, shared)
    with ExitStack() as stack:
        if executor is None:
            start = partial(stack.enter_context, processes(count - 1))
            tasks = Scheduler(work, sent, shared, start, count - 1, PATIENCE)
        else:
            tasks = Scheduler(work, sent, shared, lambda: executor, count, 0.0, forgiving=True)
        try:
            yield tasks
        finally:
            tasks.cancel()


def worker_count(workers: int | None) -> int:
    """The number of workers, by default one for each usable core; ValueError unless 1, 2, ..."""
    if workers is None:
        allowed = getattr(os, "sched_getaffinity", None)  # Linux
        return len(allowed(0)) if allowed is not None else os.cpu_count() or 1
    return whole("workers", workers)


def _sent(work: Work, shared: object) -> bytes:
    try:
        sent: bytes = cloudpickle.dumps((work, shared))
    except Exception as error:  # pickling the parts of a map may raise anything
        raise ValueError(
            f"the map cannot be sent to other processes ({error}): search with workers=1"
        ) from None
    return sent


def _perform(sent: bytes, call: bytes) -> bytes:
    work, shared = _received(sent)
    return _dumped(work(*_loaded(call, shared)), shared)


_received = lru_cache(maxsize=KEPT)(cloudpickle.loads)  # the work and what is shared


# --- Processes ------------------------------------------------------------------------------------


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor | None]:
    """A pool of ``count`` worker processes, all started at once; None if none can be started.

    They end with the block or this process, and ignore Ctrl-C. WorkerLostError if one ends early.
    """
    if multiprocessing.current_process().daemon:  # such a process may have no children
        yield None
        return
    context = multiprocessing.get_context(start_method())
    try:
        pool = ProcessPoolExecutor(count, context, initializer=_begin)
        with warnings.catch_warnings():
            # A fork beside threads of compiled libraries warns; these handle their locks.
            warnings.simplefilter("ignore", DeprecationWarning)
            for _ in range(count):  # each call starts a process if none is idle
                pool.submit(os.getpid)
    except (OSError, NotImplementedError) as error:
        logging.getLogger("woodpecker").info("working alone: no processes (%s)", error)
        yield None
        return
    workers = list(pool._processes.values())
    try:
        yield pool
    except BrokenProcessPool as error:
        raise WorkerLostError(_BROKEN) from error
    finally:
        for worker in workers:
            worker.kill()
        pool.shutdown(cancel_futures=True)


_BROKEN = (
    "a worker process ended before its task was done; where processes are started anew the script "
    "must guard its own start by `if __name__ == '__main__':`, and workers=1 needs no processes"
)


def start_method() -> str:
    """How processes are made: forked where that is safe, else spawned, which takes a second."""
    # In a fork only the calling thread lives on: locks that others held would never be released.
    alone = threading.active_count() == 1
    return "fork" if sys.platform == "linux" and alone else "spawn"


def _begin() -> None:
    """Let a worker ignore Ctrl-C and a closed terminal, and end when its parent is gone."""
    for number in (signal.SIGINT, getattr(signal, "SIGHUP", signal.SIGINT)):  # none on Windows
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a fork inherits its parent's handler
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    """End this process when its parent is gone: the system then closes the parent's sentinel."""
    # Another fork of the parent may keep the sentinel open, so the parent's id is checked, too.
    parent = multiprocessing.parent_process()
    assert parent is not None
    while not wait([parent.sentinel], WATCH) and os.getppid() == parent.pid:
        pass
    os._exit(1)
