"""Where the tasks of a search are carried out: here, and by processes of its own or an executor.

The calling thread does what is needed next; others begin what is likely to be needed later. A task
depends on its arguments only, so results and their order are those of one thread.
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
from typing import Any, NamedTuple, Protocol

import cloudpickle

from woodpecker.base.checks import whole
from woodpecker.base.lost import WorkerLostError
from woodpecker.base.shown import shown

WATCH = 0.5  # s: how often a worker looks whether its parent is still there, if nothing tells it
PATIENCE = 0.5  # s: what takes less is done before other processes could help
READY = 16  # tasks kept ready for each worker: the calling thread may be at one of its own for long
KEPT = 4  # descriptions of tasks that a process remembers: one for each search it works for


class Done(NamedTuple):
    """What a task has returned, and how often it evaluated the map."""

    value: Any
    evaluations: int


Work = Callable[..., Done]
Call = tuple[Any, ...]


class Scheduler(Protocol):
    """Carries out tasks, each given by its arguments; the same objects mean the same task."""

    def result(self, *call: Any) -> Done:
        """The result of a task that is needed now."""

    def expect(self, calls: Iterable[Call]) -> None:
        """Say which tasks are likely to be needed later, the likeliest first."""

    def peek(self, *call: Any) -> Done | None:
        """The result of a task that was expected, if it is there."""


class Serial:
    """The calling thread: what is not asked for is not done."""

    def __init__(self, work: Work) -> None:
        self._work = work

    def result(self, *call: Any) -> Done:
        """Carry out a task."""
        return self._work(*call)

    def expect(self, _: Iterable[Call]) -> None:
        """Nobody else is there to begin anything."""

    def peek(self, *_: Any) -> Done | None:
        """Nothing was begun."""
        return None


class Sender:
    """Makes bytes of tasks and results, and the other way; what is ``shared`` is not sent again."""

    def __init__(self, shared: object) -> None:
        self._shared = shared

    def dumps(self, value: object) -> bytes:
        """The bytes of a value."""
        file = io.BytesIO()
        _Pickler(file, self._shared).dump(value)
        return file.getvalue()

    def loads(self, sent: bytes) -> Any:
        """The value again, with what is shared on this side in it."""
        return _Unpickler(io.BytesIO(sent), self._shared).load()


class _Pickler(cloudpickle.Pickler):  # type: ignore[misc]
    def __init__(self, file: io.BytesIO, shared: object) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_id(self, value: object) -> str | None:
        return "shared" if value is self._shared else None


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, shared: object) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, _: str) -> object:
        return self._shared


class _Begun:
    """A task that somebody is at, or has finished; its arguments are kept, and so their ids."""

    def __init__(
        self, call: Call, future: Future[Any], load: Callable[[Any], Done],
        again: Work | None = None,
    ) -> None:  # fmt: skip
        self.call, self.future, self._load, self._again = call, future, load, again

    @cached_property
    def result(self) -> Done:
        try:
            return self._load(self.future.result())
        except Exception:
            if self._again is None:
                raise
        return self._again(*self.call)


class Parallel:
    """The calling thread, and others that begin what is likely to be needed.

    ``start`` gives their executor, or None, after a ``patience`` [s]; they do as many tasks at once
    as there are ``workers``. ``sent`` is the work as bytes, none for threads; if ``forgiving``,
    tasks are carried out here where the others fail.
    """

    def __init__(
        self, work: Work, sent: bytes, sender: Sender, start: Callable[[], Executor | None],
        workers: int, patience: float, *, forgiving: bool = False,
    ) -> None:  # fmt: skip
        self._work, self._sent, self._sender = work, sent, sender
        self._again = work if forgiving else None
        self._start, self._workers = start, workers
        self._due = time.monotonic() + patience
        self._executor: Executor | None = None
        self._ready, self._begun = dict[Call, Call](), dict[Call, _Begun]()
        self._open, self._lock = set[Future[Any]](), threading.RLock()

    def result(self, *call: Any) -> Done:
        """The result of a task, of others or carried out here; meanwhile others are done."""
        with self._lock:
            self._ready.pop(_key(call), None)
            begun = self._begun.pop(_key(call), None)
        if begun is None:
            return self._work(*call)
        while not begun.future.done() and self._do_next():
            pass
        return begun.result

    def expect(self, calls: Iterable[Call]) -> None:
        """Have others begin tasks, the first ones first; forget those expected before."""
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
        """The result of a task that was expected, if it is there; errors wait for their turn."""
        begun = self._begun.get(_key(call))
        if begun is None or not begun.future.done() or begun.future.cancelled():
            return None
        return None if begun.future.exception() is not None else begun.result

    def cancel(self) -> None:
        """Give up what is not needed any more."""
        with self._lock:
            self._ready = {}
            waiting = tuple(self._open)
        for future in waiting:
            future.cancel()

    def _fill(self) -> None:
        """Keep the others busy. Futures call this from another thread when they are done."""
        assert self._executor is not None
        while self._ready and len(self._open) < self._workers:
            key = next(iter(self._ready))
            call = self._ready.pop(key)
            if self._sent:
                sent = self._sender.dumps(call)
                future: Future[Any] = self._executor.submit(_perform, self._sent, sent)
                self._begun[key] = _Begun(call, future, self._sender.loads, self._again)
            else:
                future = self._executor.submit(self._work, *call)
                self._begun[key] = _Begun(call, future, _itself, self._again)
            self._open.add(future)
            future.add_done_callback(self._is_done)

    def _is_done(self, future: Future[Any]) -> None:
        with self._lock, suppress(RuntimeError):  # who asks for a result learns of a broken pool
            self._open.discard(future)
            self._fill()

    def _do_next(self) -> bool:
        """Carry out the first of the tasks that are ready, if there is one."""
        with self._lock:
            if not self._ready:
                return False
            key = next(iter(self._ready))
            begun = _Begun(self._ready.pop(key), Future(), _itself)
            self._begun[key] = begun
        try:
            begun.future.set_result(self._work(*begun.call))
        except Exception as error:  # it is raised when its turn comes, if it comes
            begun.future.set_exception(error)
        return True


def _key(call: Call) -> Call:
    return tuple(map(id, call))


def _itself(done: Done) -> Done:
    return done


@contextmanager
def scheduler(
    work: Work, workers: int | None, executor: Executor | None = None, shared: object = None
) -> Iterator[Scheduler]:
    """Where tasks are carried out, for the time of a search.

    ``workers`` processes, this one among them, by default one for each core; it works alone if it
    cannot make others. Or an executor of :mod:`concurrent.futures` that helps, not shut down, with
    so many tasks at once. ``shared`` is a part of the work that tasks refer to, too. ValueError if
    there is to be nobody, or the work cannot be sent; TypeError if the executor is none;
    WorkerLostError if a process ends before its task does.
    """
    count = worker_count(workers)
    if not (executor is None or hasattr(executor, "submit")):
        raise TypeError(f"executor must have a method submit, got {shown(executor)}")
    if executor is None and count == 1:
        yield Serial(work)
        return
    sent = b"" if isinstance(executor, ThreadPoolExecutor) else _sent(work, shared)
    sender = Sender(shared)
    with ExitStack() as stack:
        if executor is None:
            own = processes(count - 1)
            start = partial(stack.enter_context, own)
            parallel = Parallel(work, sent, sender, start, count - 1, PATIENCE)
        else:
            parallel = Parallel(work, sent, sender, lambda: executor, count, 0.0, forgiving=True)
        try:
            yield parallel
        finally:
            parallel.cancel()


def worker_count(workers: int | None) -> int:
    """How many workers, by default one for each usable core; ValueError unless 1, 2, ..."""
    if workers is None:
        allowed = getattr(os, "sched_getaffinity", None)  # Linux
        return len(allowed(0)) if allowed is not None else os.cpu_count() or 1
    return whole("workers", workers)


def _sent(work: Work, shared: object) -> bytes:
    try:
        sent: bytes = cloudpickle.dumps((work, shared))
    except Exception as error:  # whatever the parts of a map raise
        raise ValueError(
            f"the map cannot be sent to other processes ({error}): search with workers=1"
        ) from None
    return sent


def _perform(sent: bytes, call: bytes) -> bytes:
    work, sender = _received(sent)
    return sender.dumps(work(*sender.loads(call)))


@lru_cache(maxsize=KEPT)
def _received(sent: bytes) -> tuple[Work, Sender]:
    work, shared = cloudpickle.loads(sent)
    return work, Sender(shared)


# --- Processes ------------------------------------------------------------------------------------


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor | None]:
    """Processes of this one's own, all started at once; None where none can be made.

    They end with the block or this process, and leave Ctrl-C to it. WorkerLostError if one ends
    before its task does.
    """
    if multiprocessing.current_process().daemon:  # such a process may have no children
        yield None
        return
    context = multiprocessing.get_context(start_method())
    try:
        pool = ProcessPoolExecutor(count, context, initializer=_begin)
        with warnings.catch_warnings():
            # Threads of compiled libraries count here; they look after their locks themselves.
            warnings.simplefilter("ignore", DeprecationWarning)
            for _ in range(count):  # each starts one if none is free
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
    """How processes are made: copied where that is safe, otherwise started anew, in a second."""
    # A copy has one thread, and the locks that others held at the time stay locked in it.
    alone = threading.active_count() == 1
    return "fork" if sys.platform == "linux" and alone else "spawn"


def _begin() -> None:
    """A worker leaves Ctrl-C to its parent, and ends when that is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # what a copy has of its parent's is not for it
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    """End this process when its parent has gone: the system closes what that has open."""
    # Another copy of the parent may hold it open: so who the parent is is looked up, too.
    parent = multiprocessing.parent_process()
    assert parent is not None
    while not wait([parent.sentinel], WATCH) and os.getppid() == parent.pid:
        pass
    os._exit(1)
