"""Marks that skip tests where an optional dependency is missing; most of these are slow, too."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest

from woodpecker.base.compiled import COMPILED


def both(one: pytest.MarkDecorator, other: pytest.MarkDecorator) -> Callable[[Any], Any]:
    """Two marks as one."""
    return lambda test: one(other(test))


NEEDS_NUMBA = pytest.mark.skipif(not COMPILED, reason="takes minutes without numba")
SLOW_TOY, NIGHTLY_TOY = both(pytest.mark.slow, NEEDS_NUMBA), both(pytest.mark.nightly, NEEDS_NUMBA)
NEEDS_HEYOKA = pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
SLOW_SYSTEM = both(pytest.mark.slow, NEEDS_HEYOKA)
NIGHTLY_SYSTEM = both(pytest.mark.nightly, NEEDS_HEYOKA)
EACH_BACKEND = pytest.mark.parametrize(
    "backend", [pytest.param("heyoka", marks=NEEDS_HEYOKA), "scipy"]
)
