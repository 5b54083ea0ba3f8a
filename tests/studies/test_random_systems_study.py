"""Random systems keep what they must, and both backends say the same words."""

from __future__ import annotations

import pytest
from needs import NEEDS_HEYOKA

from studies.systems.random_systems import survey


@NEEDS_HEYOKA
@pytest.mark.slow
def test_random_systems() -> None:
    found = survey([0, 1, 9, 10, 18, 19], 6)  # of the two least shapes
    assert found["faults"] == 0
    assert found["same_words"] == found["compared"] == found["systems"] > 0
    assert set(found["statuses"]) <= {"TIME_REACHED", "AT_REST", "PASSED", "EVENT_LIMIT"}
