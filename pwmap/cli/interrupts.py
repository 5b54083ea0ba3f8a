"""How a command ends when it is asked to: by Ctrl-C, SIGTERM, or a terminal that is closed.

A request is repeated until the command has heard it, as some libraries drop it. Under ``nohup`` a
closed terminal is no request.
"""

from __future__ import annotations

import gc
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from io import TextIOWrapper
from threading import Thread, current_thread, main_thread
from types import FrameType
from typing import NoReturn

REPEAT_SECONDS = 1.0  # s until a request is repeated
# New objects until Python looks for cycles among them: with its own 700, looking through what is
# loaded takes a tenth of a short command.
RARELY = 200_000
INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C or SIGTERM has ended
AT_ONCE = "Interrupted before anything was finished"
REQUESTS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if hasattr(signal, name)  # the last one is not on Windows
]

_BAR_ENDS = "\r\x1b[2K\x1b[?25h"  # erases a line, and shows the cursor that a bar hides
_REPEATS = hasattr(signal, "setitimer")  # not on Windows


def listen() -> None:
    """Handle requests to end; for a process that runs one command only."""
    for number in REQUESTS:
        if number in REQUESTS[:2] or signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    if _REPEATS:
        signal.signal(signal.SIGALRM, _interrupt)
    sys.unraisablehook = _unraisable


def _unraisable(what: sys.UnraisableHookArgs) -> None:
    """Report exceptions that Python drops, but not a request, which is repeated."""
    if what.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(what)


@contextmanager
def from_the_start() -> Iterator[None]:
    """A block in which a command is loaded and runs: a request ends it with a sentence.

    So does an OSError, such as a full stdout while help is printed. Any characters can be printed.
    """
    gc.set_threshold(RARELY)
    try:
        listen()
        _write_any_text()
        yield
    except KeyboardInterrupt:
        stop_repeating()
        with suppress(OSError):  # of a terminal that is closed
            _nothing_is_finished()
        raise SystemExit(INTERRUPTED) from None
    except OSError as error:
        with suppress(OSError):  # stderr is full, too
            sys.stderr.write(f"Failed: {error.strerror or error}\n")
        raise SystemExit(1) from None


def _write_any_text() -> None:
    """Let streams write characters that their encoding lacks, such as those of a path, escaped."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")


def _interrupt(_: int, __: FrameType | None) -> NoReturn:
    if _REPEATS:
        signal.setitimer(signal.ITIMER_REAL, REPEAT_SECONDS)
    raise KeyboardInterrupt


def stop_repeating() -> None:
    """Stop repeating a request that the command has heard."""
    if _REPEATS and signal.getsignal(signal.SIGALRM) is _interrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _listening() -> list[signal.Signals]:
    """The requests that this process handles."""
    return [number for number in REQUESTS if signal.getsignal(number) is _interrupt]


@contextmanager
def held() -> Iterator[None]:
    """A short block that a request to end does not interrupt, such as the writing of a file."""
    came, numbers = list[bool](), _listening()
    for number in numbers:
        signal.signal(number, lambda *_: came.append(True))
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, _interrupt)
    if came:
        raise KeyboardInterrupt


def ignore_requests() -> None:
    """Ignore requests to end from now on, as all results are written."""
    for number in _listening():
        signal.signal(number, signal.SIG_IGN)


def _nothing_is_finished() -> None:
    sys.stderr.write(f"{AT_ONCE}\n")


farewell: ContextVar[Callable[[], None]] = ContextVar("farewell", default=_nothing_is_finished)
"""What is kept and said where a request ends a process :func:`at_once`."""


@contextmanager
def at_once() -> Iterator[None]:
    """A block in which Python handles no signals for many seconds, as a compiler runs."""
    # a thread hears a request to end, and ends the process
    numbers = _listening()
    if not numbers or current_thread() is not main_thread():
        yield
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    thread = Thread(target=copy_context().run, args=(_leave, reader), daemon=True)
    thread.start()
    before = signal.set_wakeup_fd(writer.fileno())  # written by the system's handler, at once
    try:
        for number in numbers:
            signal.signal(number, lambda *_: None)  # what Python's handler would do comes too late
        yield
    finally:
        for number in numbers:
            signal.signal(number, _interrupt)
        signal.set_wakeup_fd(before)
        writer.close()
        thread.join()
        reader.close()


def _leave(requests: socket.socket) -> None:
    """End this process with the first signal; return at the end of the block."""
    if requests.recv(1):
        try:
            if sys.stderr.isatty():
                sys.stderr.write(_BAR_ENDS)
            farewell.get()()
        finally:
            os._exit(INTERRUPTED)
