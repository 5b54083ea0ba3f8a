"""What all tests in a browser share."""

from collections.abc import Iterator
from typing import Any

import pytest
from explored import browser


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as made:
        yield made
