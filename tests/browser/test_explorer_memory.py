"""What an explorer holds on to of each wish (``explorer_speed.py --memory``: of ten minutes)."""

from collections.abc import Iterator
from typing import Any

import pytest
from explored import Seen, Served, served
from explorer_speed import DRAG, memory

pytestmark = [pytest.mark.browser, pytest.mark.slow]
WISHES = 150
LETTER = 0.034  # MB: the 4200 doubles of one letter, which is what each wish would leave behind


@pytest.fixture(scope="module")
def server() -> Iterator[Served]:
    with served("woodpecker", "explore", "--stay") as made:
        yield made


def test_a_drag_leaves_nothing_behind(server: Served, chromium: Any) -> None:
    seen = Seen(chromium, server.address)
    seen.complete()
    inside = seen.page.context.new_cdp_session(seen.page)

    def held() -> tuple[float, float]:
        """MB after some wishes: of the server with its processes, and of the page."""
        seen(DRAG.replace("COUNT", str(WISHES)))
        inside.send("HeapProfiler.collectGarbage")
        heap = float(inside.send("Runtime.getHeapUsage")["usedSize"]) / 1e6
        return memory(server.process.pid), heap

    first = held()  # what is loaded and kept once is there now
    last = held()
    for before, after in zip(first, last, strict=True):
        assert after - before < LETTER * WISHES, (first, last)
    seen.close()
