"""Marks that skip tests where an optional dependency is missing."""

from importlib.util import find_spec

import pytest

from woodpecker.base.compiled import COMPILED

NEEDS_NUMBA = pytest.mark.skipif(not COMPILED, reason="takes minutes without numba")
NEEDS_HEYOKA = pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
EACH_BACKEND = pytest.mark.parametrize(
    "backend", [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]
)
