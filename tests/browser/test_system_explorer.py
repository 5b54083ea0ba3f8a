"""The explorer of any system of contacts, in a browser."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import numpy as np
import pytest
from explored import Seen, Served, served

pytest.importorskip("heyoka")
pytestmark = [pytest.mark.browser, pytest.mark.slow]
DOCS = Path(__file__).parents[2] / "docs" / "explore.md"
DRAWN = "explorer.answer.numbers?.period && !explorer.answer.busy"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The file that the docs show."""
    blocks = re.findall(r"```py\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path_factory.mktemp("system") / "stop.py"
    path.write_text(next(block for block in blocks if "map_ =" in block), encoding="utf-8")
    with served("woodpecker", "explore", str(path), "--stay") as made:
        yield made


@pytest.fixture
def tab(server: Served, chromium: Any) -> Iterator[Seen]:
    seen = Seen(chromium, server.address)
    seen.wait(DRAWN, 60)
    yield seen
    seen.close()


def test_every_view_of_a_system_is_drawn(tab: Seen) -> None:
    tab.wait("explorer.answer.branches.length > 0", 60)
    for view in ("map", "diagram", "position", "velocity", "portrait", "graph", "word"):
        assert tab.colours(f"#plot-{view}") > 8, view
    assert tab.answer["numbers"]["period"] == pytest.approx(2.0 * np.pi / 2.8, abs=1e-9)
    assert tab.table("events")["what"] == ["impact: the stop"]
    tab.picture("system")


def test_a_slider_moves_the_motion_of_a_system(tab: Seen) -> None:
    before = tab.table("motion")["q"]
    tab.ask(do="set", values={"F": 7.0}, drag=True)
    tab.ask(do="set", values={"F": 7.5})
    tab.wait(DRAWN)
    assert tab.answer["values"]["F"] == 7.5
    assert tab.table("motion")["q"] != before
    assert "at_F=7.5" in tab.page.url
    field = tab.page.locator("#field-F")
    field.fill("__import__('os').system('true')")
    field.press("Enter")
    tab.rest()
    assert "F must be a number" in tab.page.locator("#message").inner_text()
    assert tab.answer["values"]["F"] == 7.5


@pytest.mark.nightly
def test_a_click_on_the_section_starts_there(tab: Seen) -> None:
    tab.click("map", (-3.0, 2.0))
    start = [float(part) for part in tab.answer["start"].split(",")]
    assert np.abs(np.array(start) - (-3.0, 2.0)).max() < 0.1  # a pixel is 0.03
    assert tab.answer["periodic"] is False
    tab.wait(DRAWN)
    tab.rest()  # until then the table may be that of the drawing before
    points = tab.table("web")
    assert (points["x"][0], points["y"][0]) == pytest.approx(tuple(start), abs=1e-9)
    assert tab.ask(do="start", value="one, two")["message"] == "start must be a number, got 'one'"


@pytest.mark.nightly
def test_files_of_a_system(tab: Seen, server: Served) -> None:
    def get(name: str) -> str:
        with urlopen(f"{server.address}export/{name}?at_F=7.5", timeout=60) as response:
            return str(response.read().decode())

    rows = get("motion.csv").splitlines()
    assert rows[0] == "t,x,u_x"
    last = [float(value) for value in rows[-1].split(",")]
    assert last[0] == pytest.approx(2.0 * np.pi / 2.8, abs=1e-9)
    assert "SystemMap" in get("lines.py")
