"""What a command does when it is asked to end, by Ctrl-C or by SIGTERM.

It breaks off, writes what is finished as tables, and ends. Some libraries drop requests: they are
repeated until heard. While the kernel is compiled the system ends the process.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

AGAIN = 1.0  # s: until a request is repeated
REQUESTS = signal.SIGINT, signal.SIGTERM

_REPEATS = hasattr(signal, "setitimer")  # not on Windows


def listen() -> None:
    """Take requests to end, in a process that is a command's own."""
    from woodpecker.base import linking

    for number in REQUESTS:
        signal.signal(number, _interrupt)
    if _REPEATS:
        signal.signal(signal.SIGALRM, _interrupt)
    linking.ends_at_once = True


def _interrupt(_: int, __: FrameType | None) -> NoReturn:
    if _REPEATS:
        signal.setitimer(signal.ITIMER_REAL, AGAIN)
    raise KeyboardInterrupt


def heard() -> None:
    """Stop repeating a request to end: the command has heard it."""
    if _REPEATS and signal.getsignal(signal.SIGALRM) is _interrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextmanager
def held() -> Iterator[None]:
    """A block that is short and must be whole, as files are: a request waits until it is done."""
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
    """Ignore requests to end from now on: all results are there."""
    if signal.getsignal(signal.SIGTERM) is _interrupt:
        for number in REQUESTS:
            signal.signal(number, signal.SIG_IGN)
