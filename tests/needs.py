"""What some tests need, and are skipped without."""

import pytest

from woodpecker.base.compiled import COMPILED

NEEDS_NUMBA = pytest.mark.skipif(not COMPILED, reason="takes minutes without numba")
