"""How a command ends when it is asked to, by Ctrl-C or by SIGTERM.

A request is repeated until the command has heard it, as some libraries drop it.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

AGAIN = 1.0  # s until a request is repeated
INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C or SIGTERM has ended
AT_ONCE = "Interrupted before anything was finished"
REQUESTS = signal.SIGINT, signal.SIGTERM

_REPEATS = hasattr(signal, "setitimer")  # not on Windows


def listen() -> None:
    """Handle requests to end; for a process that runs one command only."""
    for number in REQUESTS:
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

    So does an OSError, such as a full stdout while help is printed.
    """
    try:
        listen()
        yield
    except KeyboardInterrupt:
        heard()
        sys.stderr.write(f"{AT_ONCE}\n")
        raise SystemExit(INTERRUPTED) from None
    except OSError as error:
        sys.stderr.write(f"Error: {error.strerror or error}\n")
        raise SystemExit(2) from None


def _interrupt(_: int, __: FrameType | None) -> NoReturn:
    if _REPEATS:
        signal.setitimer(signal.ITIMER_REAL, AGAIN)
    raise KeyboardInterrupt


def heard() -> None:
    """Stop repeating a request that the command has heard."""
    if _REPEATS and signal.getsignal(signal.SIGALRM) is _interrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextmanager
def held() -> Iterator[None]:
    """A short block that a request to end does not interrupt, such as the writing of a file."""
    if signal.getsignal(signal.SIGTERM) is not _interrupt:
        yield
        return
    came = list[bool]()
    for number in REQUESTS:
        signal.signal(number, lambda *_: came.append(True))
    try:
        yield
    finally:
        for number in REQUESTS:
            signal.signal(number, _interrupt)
    if came:
        raise KeyboardInterrupt


def finished() -> None:
    """Ignore requests to end from now on, as all results are written."""
    if signal.getsignal(signal.SIGTERM) is _interrupt:
        for number in REQUESTS:
            signal.signal(number, signal.SIG_IGN)
