"""The explorer of any system of contacts, in a browser."""

import numpy as np
import pytest
from explored import Seen

pytest.importorskip("heyoka")
pytestmark = [pytest.mark.browser, pytest.mark.slow]
PAGE = "system"
READY = "explorer.answer.numbers?.period && !explorer.answer.busy"


def test_a_motion_of_a_system_has_its_period_and_its_impact(tab: Seen) -> None:
    assert tab.answer["numbers"]["period"] == pytest.approx(2.0 * np.pi / 2.8, abs=1e-9)
    assert tab.table("events")["what"] == ["impact: the stop"]


def test_a_slider_moves_the_motion_of_a_system(tab: Seen) -> None:
    before = tab.table("motion")["q"]
    tab.ask(do="set", values={"F": 7.0}, drag=True)
    tab.ask(do="set", values={"F": 7.5})
    tab.wait(READY)
    assert tab.answer["values"]["F"] == 7.5
    assert tab.table("motion")["q"] != before
    assert "at_F=7.5" in tab.page.url


@pytest.mark.nightly
def test_a_click_on_the_section_starts_there(tab: Seen) -> None:
    tab.click("map", (-3.0, 2.0))
    start = [float(part) for part in tab.answer["start"].split(",")]
    assert np.abs(np.array(start) - (-3.0, 2.0)).max() < 0.1  # a pixel is 0.03
    assert tab.answer["periodic"] is False
    tab.wait(READY)
    tab.rest()  # until then the table may be that of the drawing before
    points = tab.table("web")
    assert (points["x"][0], points["y"][0]) == pytest.approx(tuple(start), abs=1e-9)
    assert tab.ask(do="start", value="one, two")["message"] == "start must be a number, got 'one'"
