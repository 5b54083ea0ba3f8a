"""The kernel as a peer: compiled, as plain Python in another process, and in mpmath.

Whether the kernel is compiled is decided when :mod:`woodpecker` is imported, so plain Python needs
its own process; :class:`PlainPython` keeps one running and requests returns from it. The mpmath
twin is the independent program of :mod:`studies.peers.reference_mpmath`.
"""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Callable
from decimal import Decimal
from types import TracebackType
from typing import Any, NamedTuple

import numpy as np
from mpmath import nstr

from studies.common.clocks import Seconds, clocked
from studies.common.record import environ
from studies.peers import reference_mpmath
from studies.peers.cases import numbers
from studies.peers.peer import LostError, PeerReturn
from woodpecker import Toy, first_return, return_map, shoot

SERVE = """
import json, sys
from studies.peers.kernel import served
for line in sys.stdin:
    print(json.dumps(served(*json.loads(line))), flush=True)
"""
Work = Callable[[], Any]


class Precise(NamedTuple):
    """A return with more digits than a double holds."""

    phi_s: Decimal  # image [rad]
    period: Decimal  # s
    word: str


def first_return_kernel(toy: Toy, phi_s: float) -> PeerReturn:
    """One return by the kernel, as a user calls it; ``evaluations`` counts the events."""
    once = first_return(toy, phi_s)
    if not once.status.success:
        raise LostError(once.status.value)
    return PeerReturn(once.phi_s, once.period, once.drop, once.word, len(once.word.split()))


def first_return_mpmath(toy: Toy, phi_s: float, digits: int) -> Precise:
    """One return with about ``digits`` digits by :mod:`studies.peers.reference_mpmath`."""
    once = reference_mpmath.first_return(phi_s, numbers(toy), digits)
    if once.status != "returned":
        raise LostError(once.status)
    image, period = (Decimal(nstr(x, digits + 10)) for x in (once.phi_s, once.period))
    return Precise(image, period, once.word)


class PlainPython:
    """The kernel without numba, in a process that answers one line for each line it reads."""

    def __enter__(self) -> PlainPython:
        self.process = subprocess.Popen(
            [sys.executable, "-c", SERVE],
            env=environ(NUMBA_DISABLE_JIT="1"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        return self

    def ask(self, factory: str, *arguments: Any, count: int = 1) -> tuple[Any, Seconds]:
        """Result of a work and the time of one run of it, see :func:`served`."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([count, factory, *arguments]) + "\n")
        self.process.stdin.flush()
        result, seconds = json.loads(self.process.stdout.readline())
        return result, Seconds(*seconds)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.process.communicate()


def served(count: int, factory: str, *arguments: Any) -> tuple[Any, Seconds]:
    """What the other process does: make a work, then run it ``count`` times.

    ``factory`` is "module:function"; called with the arguments, which went through JSON, the
    function returns the work. Only the work is clocked.
    """
    module, name = factory.split(":")
    work: Work = getattr(importlib.import_module(module), name)(*arguments)
    kept: list[Any] = []
    seconds = clocked(lambda: kept.append(work()), count)()
    return kept[-1], seconds


def returns(toy: dict[str, Any], x: list[float]) -> Work:
    """Work for another process: images and words of these starts."""
    subject, begin = Toy(**toy), np.array(x)

    def work() -> tuple[list[float], list[str]]:
        map_ = return_map(subject, begin)
        return map_.phi_s.tolist(), list(map_.words)

    return work


def fixed_point(toy: dict[str, Any], guess: float) -> Work:
    """Work for another process: a fixed point and its multiplier."""
    subject = Toy(**toy)

    def work() -> tuple[float, float]:
        orbit = shoot(subject, guess)
        return orbit.phi_s, orbit.multiplier

    return work
