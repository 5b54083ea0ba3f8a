"""Random systems keep what they must, and both backends say the same words."""

from pathlib import Path

import pytest
from needs import NEEDS_HEYOKA
from short_runs import short_run

from studies.systems.random_systems import survey
from woodpecker.systems import MotionStatus

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]


def test_random_systems(tmp_path: Path) -> None:
    found = short_run("system_random", tmp_path)
    assert found["faults"] == 0
    assert found["same_words"] == found["compared"] == found["systems"] > 0
    assert found["differ"] == {}
    assert set(found["statuses"]) <= {"TIME_REACHED", "AT_REST", "PASSED", "EVENT_LIMIT"}


def test_a_contact_at_rest_takes_part_in_impacts_of_another() -> None:
    """In this one, twenty times: compression and expansion leave it on the edge of two cases."""
    assert survey([35], 1)["same_words"] == 1


def test_rounding_does_not_order_impacts_in_turns() -> None:
    """Bounces below the root of the rounding of a gap, of two contacts in turns, some nested."""
    found = survey([170, 526, 922], 3)
    assert found["statuses"] == {MotionStatus.TIME_REACHED.name: 3}
    assert found["same_words"] == 3
