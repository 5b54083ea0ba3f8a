"""The tour without a server, from a file: steps, events, the toy in motion, and a tablet."""

from collections.abc import Iterator
from typing import Any

import pytest
import tour_page
from explored import PICTURES, Tab

pytestmark = [pytest.mark.browser, pytest.mark.slow]
ADDRESS = (tour_page.DOCS / tour_page.LIVE).as_uri()
TABLETS = ((768, 1024), pytest.param((1024, 768), marks=pytest.mark.nightly))
CONTROLS = "button, select, input"


class Tour(Tab):
    """The page, which may load files alone."""

    def __init__(self, chromium: Any, size: tuple[int, int], step: int = 1) -> None:
        super().__init__(chromium, f"{ADDRESS}#{step}", ["file:"], size)
        self.at(step)

    def at(self, step: int) -> None:
        """Wait until a step is shown."""
        self.page.wait_for_function(f"tour.number === {step}", timeout=10_000)

    def text(self, selector: str) -> str:
        found: str = self.page.locator(selector).inner_text()
        return found


@pytest.fixture
def tour(chromium: Any) -> Iterator[Tour]:
    made = Tour(chromium, (1280, 800))
    yield made
    made.close()


def test_keys_lead_through_all_steps_and_back(tour: Tour) -> None:
    titles = []
    for step in range(1, 11):
        tour.at(step)
        titles.append(tour.text("#told h2"))
        assert titles[-1].startswith(f"{step}. ")
        for canvas in ("#toy", "#view-first canvas", "#view-second canvas"):
            assert tour.colours(canvas) > 15, (step, canvas)
        tour.page.keyboard.press("ArrowRight")
    assert len(set(titles)) == 10
    tour.at(10)  # the last: it stays
    assert tour.page.locator("#next").is_disabled()
    tour.page.keyboard.press("ArrowLeft")
    tour.at(9)
    assert tour("location.hash") == "#9"


def test_a_motion_is_gone_through_event_by_event(tour: Tour) -> None:
    """Also where two events share an instant: the upper edge strikes and detaches at once."""
    words = tour.page.locator("#word button")
    word = [words.nth(k).inner_text().split()[0] for k in range(words.count())]
    assert " ".join(word) == "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
    seen = [tour.pixels("#toy")]
    for symbol in word:
        tour.page.keyboard.press(".")
        assert tour.text("#word button[aria-current]").startswith(symbol)
        assert tour.text("#event").startswith(f"{symbol} at ")
        seen.append(tour.pixels("#toy"))
    assert len(set(seen)) == 1 + len(set(tour("tour.state.marks.map((mark) => mark[1])"))) == 10
    for symbol in reversed(word[:-1]):
        tour.page.keyboard.press(",")
        assert tour.text("#word button[aria-current]").startswith(symbol)
    tour.page.locator("#word button").nth(4).click()
    assert "I1 at 48.221 ms, impact: beak: contact 1: Λ_N 856.3 + 428.2" in tour.text("#event")
    for told in ("−0.529472 rad", "−0.83916", "145.9761 ms", "19.4454 mm"):
        assert told in tour.text("#numbers")


def test_the_motion_plays_and_follows_the_slider(tour: Tour) -> None:
    before = tour("tour.time")
    tour.page.locator("h1").click()
    tour.page.keyboard.press(" ")
    tour.page.wait_for_function(f"tour.time > {before} + 1", timeout=10_000)
    tour.page.keyboard.press(" ")
    assert not tour("tour.playing")
    tour.page.locator("#instant").fill("0.5")
    assert tour("tour.time") == pytest.approx(0.5 * 145.9761, abs=1e-3)
    tour.page.locator("#instant").press("ArrowRight")  # moves the instant, not the step
    assert tour("tour.number") == 1
    assert tour("tour.time") > 0.5 * 145.9761


@pytest.mark.parametrize(
    ("step", "labels"),
    [(8, ["P₁", "P₂", "P₃", "P₄"]), (10, ["contact by contact", "bounded by the sum"])],
)
def test_a_step_of_several_states_switches(chromium: Any, step: int, labels: list[str]) -> None:
    tour = Tour(chromium, (1280, 800), step)
    buttons = tour.page.locator("#switch button")
    assert buttons.all_inner_texts() == labels
    seen = set()
    for k in range(len(labels)):
        buttons.nth(k).click()
        seen.add(tour.pixels("#view-first canvas"))
        assert buttons.nth(k).get_attribute("aria-pressed") == "true"
    assert len(seen) == len(labels)
    tour.close()


@pytest.mark.parametrize("size", TABLETS, ids=lambda size: "x".join(map(str, size)))
def test_a_tablet_has_room_for_it(chromium: Any, size: tuple[int, int]) -> None:
    """No step is wider than the page; controls are large enough for a finger, and not covered."""
    tour = Tour(chromium, size)
    for step in range(1, 11):
        tour(f"tour.go({step})")
        tour.at(step)
        assert tour("document.documentElement.scrollWidth") <= size[0]
        assert tour(COVERED.replace("CONTROLS", CONTROLS)) == []
        if step == 9:
            PICTURES.mkdir(parents=True, exist_ok=True)
            tour("tour.event(3)")
            tour.page.screenshot(path=PICTURES / f"static_{size[0]}x{size[1]}.png")
    tour.close()


# What lies at the middle of each control that is not the control itself, and controls below 24 px.
COVERED = """[...document.querySelectorAll("CONTROLS")].flatMap((each) => {
  each.scrollIntoView({ block: "nearest" });
  const { left, top, width, height } = each.getBoundingClientRect();
  const found = document.elementFromPoint(left + width / 2, top + height / 2);
  const own = each.contains(found) && Math.min(width, height) >= 24;
  return own ? [] : [`${each.id || each.textContent}: ${found?.id} ${width} x ${height}`];
})"""
