"""What all three pages have in common, in a browser."""

from collections.abc import Callable
from typing import Any

import pytest
from explored import CUT, Seen, Served

pytestmark = [pytest.mark.browser, pytest.mark.slow]
Serving = Callable[[str], Served]
DRAWN = {  # when all is there
    "toy": "/^\\d+ branch/.test(explorer.answer.stage)",
    "maps": "explorer.answer.busy === false && explorer.answer.rows.length > 5",
    "system": "explorer.answer.numbers?.period && !explorer.answer.busy"
    " && explorer.answer.branches.length > 0",
}
VIEWS = {
    "toy": ("map", "diagram", "angles", "fall", "portrait", "graph", "word"),
    "maps": ("map", "diagram", "plane", "graph"),
    "system": ("map", "diagram", "position", "velocity", "portrait", "graph", "word"),
}
PARAMETER = {"toy": "mu_2", "maps": "r", "system": "F"}
VALUES = {"toy": (0.31, 0.32), "maps": ("7/3", "5/2"), "system": (7.5, 7.25)}
pages = pytest.mark.parametrize("page", DRAWN)


@pages
def test_every_view_is_drawn_and_every_file_is_named(
    page: str, serving: Serving, chromium: Any
) -> None:
    seen = Seen(chromium, serving(page).address)
    seen.wait(DRAWN[page], 120)
    seen.page.wait_for_timeout(300)
    for view in VIEWS[page]:
        assert seen.colours(f"#plot-{view}") > 8, view
    texts = seen("[...document.querySelectorAll('a.export')].map((each) => each.textContent)")
    assert {"branches of the diagram (CSV)", "the state (JSON)"} < {*texts}
    seen.picture({"toy": "explorer"}.get(page, page))
    seen.close()


@pages
@pytest.mark.parametrize("width", [1280, 1100, 400])
def test_no_control_is_cut(page: str, width: int, serving: Serving, chromium: Any) -> None:
    """Buttons were, behind the end of their bar; and an enlarged view has room, on a phone too."""
    seen = Seen(chromium, serving(page).address, size=(width, 800))
    assert seen(CUT) == []
    assert seen("document.documentElement.scrollWidth") <= width
    seen.page.click(".menu > summary")
    listed = seen.page.locator(".menu .list").bounding_box()
    assert 0 <= listed["x"] <= width - listed["width"]
    seen.page.keyboard.press("Escape")
    seen.page.click("#view-map .enlarge")
    seen.rest()
    assert seen.page.locator("#plot-map").bounding_box()["height"] > 400
    seen.close()


@pages
def test_a_field_takes_a_number_and_refuses_other_text(
    page: str, serving: Serving, chromium: Any
) -> None:
    seen, name = Seen(chromium, serving(page).address), PARAMETER[page]
    field, value = seen.page.locator(f"#field-{name}"), VALUES[page][0]
    field.fill(str(value))
    field.press("Enter")
    seen.rest()
    assert seen.answer["values"][name] == value
    for text in ("nonsense", "__import__('os').system('true')"):
        field.fill(text)
        field.press("Enter")
        seen.rest()
        said = seen.page.locator("#message").inner_text()
        assert f"{name} must be a number" in said or "expected a rational" in said
        assert seen.answer["values"][name] == value
    seen.page.click(f".back[data-name={name}]")
    seen.rest()
    assert seen.answer["values"][name] != value
    seen.close()


@pages
def test_a_link_that_is_none_is_told_until_something_changes(
    page: str, serving: Serving, chromium: Any
) -> None:
    """Also when answers have come."""
    seen = Seen(chromium, serving(page).address, "nonsense=1")
    seen.wait(DRAWN[page], 120)
    seen.page.wait_for_timeout(1000)
    said = seen.page.locator("#message").inner_text()
    assert said == "The link was not understood: unknown name in the link: 'nonsense'"
    answer = seen.ask(do="set", values={PARAMETER[page]: VALUES[page][0]})
    assert "understood" not in answer["message"]
    seen.close()


@pytest.mark.nightly
@pages
def test_two_tabs_do_not_mix(page: str, serving: Serving, chromium: Any) -> None:
    """And undo takes back what was changed in its own."""
    one, other = (Seen(chromium, serving(page).address) for _ in range(2))
    name, (first, second) = PARAMETER[page], VALUES[page]
    before = other.answer["values"][name]
    one.ask(do="set", values={name: first})
    assert other.answer["values"][name] == before
    other.ask(do="set", values={name: second})
    assert one.answer["values"][name] == first
    assert str(first) in one.page.url
    assert other.ask(do="undo")["values"][name] == before
    one.close()
    other.close()


@pytest.mark.nightly
@pages
def test_two_states_side_by_side(page: str, serving: Serving, chromium: Any) -> None:
    """Both are where the page was, and each half is moved on its own."""
    seen, name, (first, second) = (
        Seen(chromium, serving(page).address), PARAMETER[page], VALUES[page]
    )  # fmt: skip
    seen.ask(do="set", values={name: first})
    with seen.page.context.expect_page() as opened:
        seen.page.click("#compare")
    both = opened.value
    for side in "ab":
        half = both.wait_for_selector(f"iframe[name={side}]").content_frame()
        half.wait_for_function("window.explorer && explorer.answer.values")
        assert half.evaluate("explorer.answer.values")[name] == first
    half.evaluate(f"explorer.ask({{do: 'set', values: {{{name}: '{second}'}}}})" if page == "maps"
                  else f"explorer.ask({{do: 'set', values: {{{name}: {second}}}}})")  # fmt: skip
    both.wait_for_function(f"decodeURIComponent(location.search).includes('{second}')")
    assert both.title().endswith(": two states")
    both.close()
    seen.close()
