"""Long computations in other processes, with their results as they arrive.

Processes are forked from one that has loaded the package; without fork (Windows) each loads it.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from multiprocessing import get_all_start_methods, get_context
from multiprocessing.connection import Connection
from threading import Event, Thread, current_thread, main_thread
from typing import Any

Work = Callable[..., Iterator[Any]]
METHOD = "forkserver" if "forkserver" in get_all_start_methods() else "spawn"
MEMORY = 2 << 30  # bytes that a job may allocate beyond what it starts with


class Job:
    """A generator function, at the top level of a module, that runs in another process.

    Once it is over, ``sentence`` says why it failed, if it did.
    """

    def __init__(self, work: Work, *arguments: Any, seconds: float = 600.0) -> None:
        context: Any = get_context(METHOD)
        self._results, sender = context.Pipe(duplex=False)
        self._process = context.Process(target=_carry_out, args=(sender, work, arguments))
        self._process.daemon = True
        self._process.start()
        sender.close()
        self._end, self._limit = time.monotonic() + seconds, seconds
        self.is_over, self.sentence = False, ""

    def results(self) -> list[Any]:
        """The results since the last call."""
        found: list[Any] = []
        try:
            while not self.is_over and self._results.poll():
                is_end, result = self._results.recv()
                if is_end:
                    self.stop(result)
                else:
                    found.append(result)
        except (EOFError, OSError):  # it was killed, for instance by the system
            self.stop("the work was broken off by the system")
        if not self.is_over and time.monotonic() > self._end:
            self.stop(f"given up after {self._limit:.0f} s, as long as allowed")
        return found

    def stop(self, sentence: str = "") -> None:
        """End the work at once; further calls have no effect."""
        if self.is_over:
            return
        self.is_over, self.sentence = True, sentence
        self._process.kill()
        self._process.join()
        self._results.close()


_warm = Event()


def warm_up(modules: Sequence[str]) -> None:
    """Load modules in the process that jobs are forked from, in the background."""
    context: Any = get_context(METHOD)
    if METHOD == "forkserver":
        context.set_forkserver_preload(list(modules))
        _start_server()
    Thread(target=_first_job, daemon=True).start()


def _start_server() -> None:
    """Start the process that jobs are forked from, which Ctrl-C does not reach while it loads."""
    from multiprocessing.forkserver import ensure_running

    if current_thread() is not main_thread():  # only the main thread may set signal handlers
        return
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the new process inherits this
    try:
        ensure_running()
    finally:
        signal.signal(signal.SIGINT, usual)


def is_warm() -> bool:
    """Whether jobs begin at once; until then starting a job blocks."""
    return _warm.is_set()


def _first_job() -> None:
    job = Job(nothing)
    while not job.is_over:
        job.results()
        time.sleep(0.01)
    _warm.set()


def nothing() -> Iterator[None]:
    """The shortest job."""
    yield None


def _carry_out(sender: Connection, work: Work, arguments: tuple[Any, ...]) -> None:
    with suppress(BrokenPipeError, KeyboardInterrupt):  # the page that asked is gone
        _limit_memory()
        sentence = ""
        try:
            for result in work(*arguments):
                sender.send((False, result))
        except MemoryError:
            sentence = "no memory is left"
        except Exception as error:  # of any kind: the page shows it, and no process hangs
            sentence = str(error) or type(error).__name__
        sender.send((True, sentence))


def _limit_memory() -> None:
    if sys.platform == "linux":
        import resource
        from pathlib import Path

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
