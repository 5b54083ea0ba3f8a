"""Limits on work that is counted in calls, not timed, and so is the same on every machine."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sympy.external.gmpy import GROUND_TYPES

WEIGHT = 1 if GROUND_TYPES == "flint" else 3  # sympy's own rationals are written in Python


@contextmanager
def at_most(calls: int) -> Iterator[None]:
    """Assert that the block makes no more calls than that, of Python and of C together.

    That is with the rationals of flint; those of sympy make up to three times as many.
    """
    count, before = 0, sys.getprofile()

    def counted(frame: Any, event: str, argument: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        yield
    finally:
        sys.setprofile(before)
    assert count <= WEIGHT * calls
