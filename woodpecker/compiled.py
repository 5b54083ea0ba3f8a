"""Compile the kernel with numba where it is installed; otherwise run it as plain Python."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

numba: Any
try:
    import numba
except ImportError:  # the extra "fast" is optional
    numba = None

COMPILED: bool = numba is not None and os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
"""Whether the kernel is compiled in this process."""

_announced = not COMPILED


def jit(function: F) -> F:
    """``numba.njit`` with a cache on disk and without the GIL, or the function itself."""
    if not COMPILED:
        return function
    compiled: F = numba.njit(cache=True, error_model="numpy", nogil=True)(function)
    return compiled


def announce(function: Any) -> None:
    """Log once per process that the kernel is about to be compiled, if nothing is cached."""
    global _announced
    if _announced:
        return
    _announced = True
    cache = Path(function.stats.cache_path)
    module = Path(function.py_func.__code__.co_filename).stem
    if not any(cache.glob(f"{module}.{function.py_func.__name__}-*.nbi")):
        logging.getLogger("woodpecker").warning(
            "compiling the kernel; this happens once and takes some seconds"
        )
