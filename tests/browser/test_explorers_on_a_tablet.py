"""All three explorers on a tablet, held upright and across, with fingers in place of a mouse."""

from collections.abc import Callable
from typing import Any

import pytest
from explored import CUT, PICTURES, Seen, Served

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.nightly]
Serving = Callable[[str], Served]
UPRIGHT, ACROSS = (768, 1024), (1024, 768)
FINGER = 24  # px: what a finger hits at least [WCAG 2.2, 2.5.8]; of a box its label counts
TOUR = "tour=9&eps_n1=0.113&phi_s=-0.8823&window=-1.0,-0.7"
DRAWN = "/branch|complete/.test(explorer.answer.stage ?? 'complete')"

# Controls whose middle is something else, after they were scrolled to, and those too small.
UNREACHABLE = """[...document.querySelectorAll("button, select, input, summary")].flatMap(each => {
  if (!each.checkVisibility({ checkVisibilityCSS: true })) return [];
  each.scrollIntoView({ block: "center" });
  const { left, top, width, height } = each.getBoundingClientRect();
  const found = document.elementFromPoint(left + width / 2, top + height / 2);
  const label = each.closest("label")?.getBoundingClientRect();
  const box = ["checkbox", "radio"].includes(each.type);
  const small = Math.min(box ? label.width : width, box ? label.height : height) < FINGER;
  const own = each.contains(found) || each.closest("label")?.contains(found);
  return own && !small ? [] : [`${each.id || each.textContent}: ${found?.id} ${width} ${height}`];
})"""


@pytest.mark.parametrize("size", [UPRIGHT, ACROSS], ids=["upright", "across"])
@pytest.mark.parametrize(
    ("page", "query"), [("toy", ""), ("toy", TOUR), ("maps", ""), ("system", "")]
)
def test_all_is_reached_with_a_finger(
    serving: Serving, chromium: Any, page: str, query: str, size: tuple[int, int]
) -> None:
    seen = Seen(chromium, serving(page).address, query, size, touch=True)
    seen.wait(DRAWN, 60)
    assert seen(UNREACHABLE.replace("FINGER", str(FINGER))) == []
    assert seen(CUT) == []
    assert seen("document.documentElement.scrollWidth") <= size[0]
    for name in ("stable", "unstable", "jump crossing"):  # what lines mean is said here, too
        assert seen.page.locator("header .legend", has_text=name).is_visible()
    PICTURES.mkdir(parents=True, exist_ok=True)
    seen("document.querySelector('#body').scrollTo(0, 0)")
    seen.page.screenshot(path=PICTURES / f"tablet_{page}{'_tour' * bool(query)}_{size[0]}.png")
    seen.page.locator(".menu > summary").last.tap()
    last = seen.page.locator(".menu[open] .list > :last-child").bounding_box()
    assert last["x"] + last["width"] <= size[0]
    assert last["y"] + last["height"] <= size[1]
    seen.close()


def test_a_sentence_has_a_row_of_its_own(serving: Serving, chromium: Any) -> None:
    """It was squeezed between the buttons, and cut."""
    seen = Seen(chromium, serving("toy").address, "phi_s=nan", ACROSS)
    line = seen.page.locator("#message")
    assert len(line.inner_text()) > 20
    assert seen("(() => { const m = document.querySelector('#message');"
                " return m.scrollWidth <= m.clientWidth && m.clientWidth > 900; })()")  # fmt: skip
    seen.close()


PLACE = """(k => {
  const views = Object.values(Bokeh.index.roots ?? Bokeh.index);
  const view = views.find((each) => each.model.name === "word"), { x_range, y_range } = view.model;
  view.el.scrollIntoView({ block: "center" });
  const { left, top } = view.el.getBoundingClientRect(), frame = view.frame.bbox;
  return [left + frame.left + (k - x_range.start) / (x_range.end - x_range.start) * frame.width,
          top + frame.top + (y_range.end - 0.14) / (y_range.end - y_range.start) * frame.height];
})(EVENT)"""
TIPS = """(() => {
  const within = (root) => [...root.querySelectorAll("*")].flatMap((each) =>
    [each, ...(each.shadowRoot ? within(each.shadowRoot) : [])]);
  return within(document).filter((each) => each.matches(".tip")).map((each) => each.textContent);
})()"""


def test_a_tap_tells_what_a_mouse_is_told(serving: Serving, chromium: Any) -> None:
    """A finger does not hover; the third event of the motion is an impact of the upper edge."""
    seen = Seen(chromium, serving("toy").address, "", ACROSS, touch=True)
    assert seen(TIPS) == []
    seen.page.touchscreen.tap(*seen(PLACE.replace("EVENT", "2")))
    seen.wait(f"{TIPS}.length > 0")
    (tip,) = seen(TIPS)
    assert tip.startswith("I3 at 45.1200 ms: impact: upper edge")
    seen.close()
