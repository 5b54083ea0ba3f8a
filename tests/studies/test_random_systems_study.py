"""Random systems keep what they must, and both backends say the same words."""

from __future__ import annotations

from pathlib import Path

import pytest
from needs import NEEDS_HEYOKA
from short_runs import short_run


@NEEDS_HEYOKA
@pytest.mark.slow
def test_random_systems(tmp_path: Path) -> None:
    found = short_run("system_random", tmp_path)
    assert found["faults"] == 0
    assert found["same_words"] == found["compared"] == found["systems"] > 0
    assert set(found["statuses"]) <= {"TIME_REACHED", "AT_REST", "PASSED", "EVENT_LIMIT"}
