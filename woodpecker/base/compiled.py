"""The kernel compiled with numba if that is installed, else plain Python."""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from woodpecker.base.cache import guard
from woodpecker.base.linking import pipelines

F = TypeVar("F", bound=Callable[..., Any])

numba: Any
try:
    import numba
except ImportError:  # the extra "fast" is optional
    numba = None

COMPILED: bool = numba is not None and os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
"""Whether the kernel is compiled in this process."""

_announced = not COMPILED


def _options() -> tuple[dict[str, Any], dict[str, Any]]:
    """Numba's options for functions called from Python, and for those that only they call."""
    whole: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    part = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    for_whole, for_part = pipelines()
    if for_whole is not None:
        whole["pipeline_class"], part["pipeline_class"] = for_whole, for_part
    return whole, part


_WHOLE, _PART = _options() if COMPILED else ({}, {})


def jit(function: F) -> F:
    """``numba.njit`` with a cache on disk and without the GIL, or the function itself.

    For functions called from Python; those that only compiled code calls are a :func:`part`. A
    warning says once if the cache cannot be written.
    """
    if not COMPILED:
        return np.errstate(all="ignore")(function)
    compiled: F
    try:
        compiled = numba.njit(cache=True, **_WHOLE)(function)
    except RuntimeError:
        compiled = numba.njit(**_WHOLE)(function)
        _say_that_nothing_is_cached()
    guard(compiled, _fingerprint())
    return compiled


def part(function: F) -> F:
    """Make a function callable from compiled code; see :mod:`woodpecker.base.linking`."""
    if not COMPILED:
        return function
    from numba.extending import register_jitable

    registered: F = register_jitable(**_PART)(function)
    return registered


@cache
def _fingerprint() -> str:
    """A digest of all sources of the package."""
    sources = sorted(Path(__file__).parents[1].rglob("*.py"))
    return hashlib.blake2b(b"".join(source.read_bytes() for source in sources)).hexdigest()


@cache
def _say_that_nothing_is_cached() -> None:
    logging.getLogger("woodpecker").warning(
        "the kernel is compiled anew in every process, which takes twenty to forty seconds, "
        "because neither the package's folder nor the user's cache folder can be written: "
        "set NUMBA_CACHE_DIR to one that can"
    )


def announce(function: Any) -> None:
    """Log once per process that the kernel will be compiled, if nothing is cached."""
    global _announced
    if _announced:
        return
    _announced = True
    if function.stats.cache_path is None:  # there is no cache: logged by ``jit`` already
        return
    if not _is_cached(function):
        logging.getLogger("woodpecker").warning(
            "compiling the kernel; this happens once and takes twenty to forty seconds"
        )


def _is_cached(function: Any) -> bool:
    """Whether a cache has something that was compiled from these sources, not from older ones."""
    index: Any = getattr(getattr(function, "_cache", None), "_cache_file", None)
    if hasattr(index, "_load_index"):
        with suppress(Exception):  # whatever pickle makes of wrong bytes: told where it is loaded
            return bool(index._load_index())
    folder = Path(function.stats.cache_path)
    module = Path(function.py_func.__code__.co_filename).stem
    return any(folder.glob(f"{module}.{function.py_func.__name__}-*.nbi"))
