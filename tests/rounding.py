"""Another rounding of the same program, so that tests show what depends on the last bits.

Compiled code may fuse a product and a sum into one operation with a single rounding, if processor
and compiler do; the last bit of nearly every number changes then. ROUNDING=fused asks for it, in a
cache of its own; GLIBC_TUNABLES asks the mathematical library (x86-64) not to.
"""

import functools
import os


def apply() -> None:
    """Before the package is imported: compile as the environment says."""
    if os.environ.get("ROUNDING") != "fused":
        return
    try:
        import numba
    except ImportError:
        return
    if not os.environ.get("NUMBA_CACHE_DIR"):
        raise ValueError("ROUNDING=fused needs a NUMBA_CACHE_DIR of its own")
    import numba.extending

    fused = {"fastmath": {"contract"}}
    numba.njit = functools.partial(numba.njit, **fused)
    numba.extending.register_jitable = functools.partial(numba.extending.register_jitable, **fused)
