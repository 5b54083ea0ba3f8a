"""Mechanisms of a program, switched off one at a time as patches of its modules."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple
from unittest.mock import patch

from woodpecker.simulation import calls

PACKAGE = "woodpecker"


class Mechanism(NamedTuple):
    """A function, method or constant, and what takes its place.

    Attributes
    ----------
    module
        The module that defines it, without the name of the package.
    name
        Its name there, such as ``once`` or ``Arc.precision``.
    without
        Its trivial answer as a function, or the neutral value of a constant.
    purpose
        What it is for.
    """

    module: str
    name: str
    without: Any
    purpose: str


def gives(value: object) -> Callable[..., Any]:
    """A function that always gives the same."""
    return lambda *_, **__: value


def argument(place: int) -> Callable[..., Any]:
    """A function that gives one of its arguments; of a method the first one is its object."""
    return lambda *arguments, **__: arguments[place]


@contextmanager
def switched_off(mechanism: Mechanism) -> Iterator[None]:
    """The program without a mechanism, in this process.

    What other modules have imported by its name is replaced there, too.

    Raises
    ------
    AttributeError
        If there is no such mechanism.
    """
    module = importlib.import_module(f"{PACKAGE}.{mechanism.module}")
    *owners, name = mechanism.name.split(".")
    with ExitStack() as stack:
        if owners:
            owner = getattr(module, owners[0])
            static = isinstance(owner.__dict__[name], staticmethod)
            without = staticmethod(mechanism.without) if static else mechanism.without
            stack.enter_context(patch.object(owner, name, without))
        else:
            own = getattr(module, name)
            for each in [m for n, m in sys.modules.items() if n.startswith(f"{PACKAGE}.")]:
                if vars(each).get(name, stack) is own:
                    stack.enter_context(patch.object(each, name, mechanism.without))
        yield


class SpentError(RuntimeError):
    """The kernel was called as often as allowed."""


class Calls:
    """How often the kernel is called: once for each return that is found or followed."""

    def __init__(self, most: float) -> None:
        self.count, self._most, self._compute = 0, most, calls.compute

    def __call__(self, *arguments: Any) -> Any:
        """Call it; SpentError if that was often enough."""
        self.count += 1
        if self.count > self._most:
            raise SpentError("the kernel was called too often")
        return self._compute(*arguments)

    def __getattr__(self, name: str) -> Any:
        """Whatever else the kernel has, such as where it is cached."""
        return getattr(self._compute, name)


@contextmanager
def counted(most: float) -> Iterator[Calls]:
    """Count the calls of the kernel in this process; allow so many."""
    counter = Calls(most)
    with patch.object(calls, "compute", counter):
        yield counter
