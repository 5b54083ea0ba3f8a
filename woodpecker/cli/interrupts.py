"""What a command does when it is asked to end, by Ctrl-C or by SIGTERM.

It breaks off what it computes, writes what is finished as tables, and ends; where there is nothing
to keep it ends at once. A request may be lost: some libraries drop every exception that reaches a
function of theirs. So it is repeated until the command has heard it. While the kernel is compiled
nothing of Python runs for many seconds: the process is ended by the system then.
"""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn

AGAIN = 1.0  # s: until a request is repeated

_REPEATS = hasattr(signal, "setitimer")  # not on Windows


def listen() -> None:
    """Take requests to end, in a process that is a command's own."""
    from woodpecker.base import linking

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    if _REPEATS:
        signal.signal(signal.SIGALRM, _interrupt)
    linking.ends_at_once = True


def _interrupt(_: int, __: FrameType | None) -> NoReturn:
    if _REPEATS:
        signal.setitimer(signal.ITIMER_REAL, AGAIN)
    raise KeyboardInterrupt


def heard() -> None:
    """The request is heard: what follows takes the time that it takes."""
    if _REPEATS and signal.getsignal(signal.SIGALRM) is _interrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
