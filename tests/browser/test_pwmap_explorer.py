"""The explorer of piecewise-linear maps in a browser."""

from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from explored import Seen, Served

pytestmark = [pytest.mark.browser, pytest.mark.slow]
PAGE = "maps"
READY = "explorer.answer.busy === false && explorer.answer.rows.length > 5"


def rows(tab: Seen, title: str) -> list[list[str]]:
    found = [each["rows"] for each in tab.answer["rows"] if each["title"].startswith(title)]
    return found[0] if found else []


def test_exact_values_are_listed(tab: Seen) -> None:
    text = tab.page.locator("#rows").inner_text()
    for told in ("4/9", "r/(a + 1)", "0 < r < 2 ← here", "cycle L through -1"):
        assert told in text


def test_a_field_takes_rationals_and_a_slider_too(tab: Seen) -> None:
    field = tab.page.locator("#field-r")
    field.fill("7/3")
    field.press("Enter")
    tab.rest()
    tab.wait(READY)
    assert tab.answer["values"] == {"a": "5/4", "r": "7/3"}
    assert rows(tab, "Cycles")[0][0] != "L"
    tab.page.focus("#slider-a")
    tab.page.keyboard.press("ArrowRight")
    tab.rest()
    assert tab.answer["values"]["a"] == "63/50"


def test_a_click_on_the_plane_shows_its_cell(tab: Seen) -> None:
    tab.click("plane", (2.0, 2.5))
    tab.wait(READY)
    values = tab.answer["values"]
    assert values["a"] == "2"  # the simplest rational within half a pixel or so
    assert abs(eval(values["r"]) - 2.5) < 0.05
    cycle = rows(tab, "Cycles")[0]
    assert "x = " in cycle[3]  # a formula in a and r, and its borders
    assert cycle[4] != ""


def test_clicks_on_the_map_the_diagram_and_the_graph(tab: Seen) -> None:
    tab.click("map", (0.75, -0.5))
    assert tab.answer["start"] == "3/4"
    tab.wait(READY)
    tab.click("diagram", (3.0, 4.0 / 3.0))  # the fixed point r/(a + 1) at r = 3
    assert tab.answer["branch"] == "F2"
    tab.wait(READY)
    edges = tab.table("edges")
    k = edges["branch"].index("J1")
    tab.click("graph", (edges["x"][k], edges["y"][k]))
    assert tab.answer["branch"] == "J1"


def test_another_map_is_typed(tab: Seen) -> None:
    tab.page.fill("#formula", "Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    tab.page.fill("#given", "")
    tab.page.click("#typed button")
    tab.page.wait_for_function("window.explorer?.answer.values && !('r' in explorer.answer.values)")
    tab.page.fill("#field-a", "2")
    tab.page.press("#field-a", "Enter")
    tab.wait("explorer.answer.values.a == 2 && explorer.answer.chaotic === true && " + READY)
    assert rows(tab, "Entropy")[0][1] == "= log(2)"
    assert tab.table("steps")["top"] == [1]
    assert tab.colours("#plot-density") > 10
    assert "two parameters" in tab.page.locator("#plane-told").inner_text()
    assert not tab.page.locator("#plot-plane").is_visible()  # no axes of nothing
    tab.picture("maps_tent")


@pytest.mark.parametrize(
    "formula",
    ["__import__('os').system('touch /tmp/never')", "<img src=x onerror=alert(1)>", "((((", "x**x"],
)
def test_a_hostile_text_is_refused_with_a_sentence(
    server: Served, chromium: Any, formula: str
) -> None:
    seen = Seen(chromium, server.address, f"map={quote(formula)}")
    seen.wait("explorer.answer.message && explorer.answer.busy === false", 60)
    assert seen("document.querySelectorAll('img').length") == 0
    assert seen.answer["rows"] == []
    assert seen.answer["stage"] == "no diagram"
    seen.close()


def test_a_text_that_takes_too_long_is_given_up(server: Served, chromium: Any) -> None:
    """The page answers meanwhile."""
    pieces = ", ".join(f"(x*{k + 2} - {k}, x < {k}/100)" for k in range(24))
    formula = f"Piecewise({pieces}, (x/2, True))"[:600].rpartition(", (")[0] + ", (x/2, True))"
    seen = Seen(chromium, server.address, f"map={quote(formula)}&order=8&orders=8")
    begun = seen("performance.now()")
    seen.ask(do="steps", value="5")
    assert seen("performance.now()") - begun < 5000  # it does not wait for the answers
    seen.close()


@pytest.mark.nightly
def test_files_are_downloaded_from_the_menu(tab: Seen) -> None:
    """Each link of the menu gives the file of the state that is shown."""
    tab.ask(do="set", values={"r": "7/3"})
    tab.wait(READY)
    begins = {"png": b"\x89PNG", "svg": b"<?xml", "csv": b"", "json": b"{", "py": b"from pwmap",
              "graphml": b"<"}  # fmt: skip
    for name in ("map.png", "plane.svg", "cycles.csv", "branches.csv", "diagram.json", "lines.py"):
        tab.page.click(".menu summary")
        with tab.page.expect_download() as waiting:
            tab.page.click(f"a[data-file='{name}']")
        assert waiting.value.suggested_filename == name
        content = Path(waiting.value.path()).read_bytes()
        assert content.lstrip().startswith(begins[name.partition(".")[2]])
        if name == "cycles.csv":
            assert b"28/27" in content  # r/(a + 1) at a = 5/4, r = 7/3
    tab.page.click(".menu summary")
    tab.page.click("#python")
    assert "'r': '7/3'" in tab.page.locator("#dialog pre").inner_text()


@pytest.mark.nightly
def test_reset_goes_back_to_what_the_command_gave(server: Served, chromium: Any) -> None:
    """Also of another map that is typed: its text stays, and nothing of the first map comes."""
    formula = "Piecewise((c*x + 1, x <= 0), (d*x + 1, True))"
    seen = Seen(chromium, server.address, f"map={quote(formula)}&at_c=1/2&at_d=-3/2")
    assert seen.ask(do="set", values={"c": "1/3"})["values"] == {"c": "1/3", "d": "-3/2"}
    answer = seen.ask(do="reset")
    assert answer["values"] == {"c": "1", "d": "1"}
    assert answer["axes"] == ["c", "d"]
    assert seen.ask(do="branch", value="")["message"] == ""
    seen.close()
