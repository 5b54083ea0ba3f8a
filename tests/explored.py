"""A running explorer, and a browser that shows it, for tests of both pages."""

import io
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from processes import environment

CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
PICTURES = Path(os.environ.get("EXPLORER_PICTURES", "build/explorer"))
# Parts of a page that show less than they hold; a long word scrolls.
CUT = """[...document.querySelectorAll(
    ".bar, header, .field, .control, aside, .view:not(#view-word), #tour")]
  .filter((each) => each.checkVisibility() && each.scrollWidth > each.clientWidth + 1)
  .map((each) => `${each.tagName} ${each.id} ${each.className}`)"""
READY = 120_000  # ms: with a kernel that has to be compiled first


class Served:
    """A server of its own process."""

    def __init__(self, *words: str) -> None:
        command = [sys.executable, "-m", *words, "--no-browser"]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env=environment(MPLBACKEND="Agg"),
        )  # fmt: skip
        assert self.process.stdout is not None
        self.said = said = list[str]()
        for line in self.process.stdout:
            said.append(line)
            found = re.search(r"http://[\d.]+:\d+/", line)
            if found:
                self.address = found[0]
                self._rest = Thread(target=self._read, daemon=True)
                self._rest.start()
                return
        raise AssertionError("".join(said))

    def _read(self) -> None:
        """What it goes on to say: errors that it logs."""
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            self.said += lines

    def end(self, number: int = signal.SIGTERM) -> None:
        """Ask it to end, and wait until it has."""
        self.process.send_signal(number)
        self.process.wait(20.0)
        self._rest.join(5.0)


@contextmanager
def served(*words: str) -> Iterator[Served]:
    server = Served(*words)
    try:
        yield server
    finally:
        server.end()


@contextmanager
def browser() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api")
    if not Path(CHROMIUM).exists():
        pytest.skip(f"no browser at {CHROMIUM}")
    with api.sync_playwright() as playwright:
        made = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-dev-shm-usage"]
        )
        try:
            yield made
        finally:
            made.close()


class Tab:
    """One tab. Whatever goes wrong on the page, or is loaded from elsewhere, is kept."""

    def __init__(
        self, browser: Any, address: str, own: Sequence[str], size: tuple[int, int],
        *, touch: bool = False,
    ) -> None:  # fmt: skip
        self.errors, self.elsewhere = list[str](), list[str]()
        self.page = browser.new_page(
            viewport={"width": size[0], "height": size[1]}, reduced_motion="reduce",
            has_touch=touch, is_mobile=touch,
        )  # fmt: skip
        self.page.context.set_default_timeout(READY)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on(
            "request",
            lambda asked: asked.url.startswith(tuple(own)) or self.elsewhere.append(asked.url),
        )
        self.page.goto(address)

    def __call__(self, script: str) -> Any:
        return self.page.evaluate(script)

    def pixels(self, selector: str) -> bytes:
        found: bytes = self.page.locator(selector).screenshot()
        return found

    def colours(self, selector: str) -> int:
        """How many colours a part of the page has: one, if nothing is drawn."""
        from PIL import Image

        picture = Image.open(io.BytesIO(self.pixels(selector)))
        return len(picture.convert("RGB").getcolors(1 << 24) or ())

    def close(self) -> None:
        self.page.close()
        assert self.errors == []
        assert self.elsewhere == []  # nothing is loaded from the network


class Seen(Tab):
    """A tab of an explorer."""

    def __init__(
        self, browser: Any, address: str, query: str = "", size: tuple[int, int] = (1280, 720),
        *, touch: bool = False,
    ) -> None:  # fmt: skip
        own = (address, address.replace("http", "ws"), "data:", "blob:")
        super().__init__(
            browser, f"{address}?{query}" if query else address, own, size, touch=touch
        )
        self.page.wait_for_function("window.explorer && explorer.answer.values", timeout=READY)
        self.rest()

    def rest(self) -> None:
        """Wait until every wish is answered, and drawn by Bokeh unless a slider is held."""
        self.page.wait_for_function(
            "!explorer.waiting && !explorer.next && explorer.sent > 0"
            " && (dragging || !sketch.hidden.length)"
        )

    def ask(self, **wish: Any) -> dict[str, Any]:
        """Send a wish; what the page shows after it."""
        count = self("explorer.sent")
        self(f"explorer.ask({json.dumps(wish)})")
        self.page.wait_for_function(f"explorer.sent > {count} && !explorer.waiting")
        found: dict[str, Any] = self("explorer.answer")
        return found

    @property
    def answer(self) -> dict[str, Any]:
        found: dict[str, Any] = self("explorer.answer")
        return found

    def table(self, name: str) -> dict[str, list[Any]]:
        """The columns of a table."""
        found: dict[str, list[Any]] = self(
            f"""(() => {{
              const data = explorer.doc.get_model_by_name("{name}").data;
              return Object.fromEntries(Object.entries(data).map(([k, v]) => [k, Array.from(v)]));
            }})()"""
        )
        return found

    def wait(self, script: str, seconds: float = 60.0) -> None:
        self.page.wait_for_function(script, timeout=1000.0 * seconds)

    def complete(self) -> None:
        """Wait for the whole diagram."""
        self.wait("/^\\d+ branch/.test(explorer.answer.stage)", 120.0)
        self.page.wait_for_timeout(300)

    def click(self, figure: str, *places: tuple[float, float]) -> None:
        """Click at places of a figure, in its own coordinates, as fast as the mouse can."""
        pixels = self._pixels(figure, places)
        for _ in range(50):  # an answer may still move the figure, for seconds at most
            self.page.wait_for_timeout(100)
            before, pixels = pixels, self._pixels(figure, places)
            if pixels == before:
                break
        heard = self("explorer.answer.clicks ?? 0")  # other answers come of themselves
        for place in pixels:
            self.page.mouse.click(*place)
        self.wait(f"explorer.answer.clicks >= {heard + len(places)}")
        self.rest()

    def _pixels(self, figure: str, places: Iterable[tuple[float, float]]) -> list[Any]:
        return [
            self(
                f"""(() => {{
                  const view = Object.values(Bokeh.index.roots ?? Bokeh.index).map((v) => v)
                    .find((v) => v.model.name === "{figure}");
                  const box = view.el.getBoundingClientRect(), frame = view.frame.bbox;
                  const at = (range, v) => (v - range.start) / (range.end - range.start);
                  const {{ x_range, y_range }} = view.model;
                  return [
                    box.left + frame.left + frame.width * at(x_range, {x}),
                    box.top + frame.bottom - frame.height * at(y_range, {y}),
                  ];
                }})()"""
            )
            for x, y in places
        ]

    def picture(self, name: str) -> Path:
        """Keep what is seen as a result."""
        PICTURES.mkdir(parents=True, exist_ok=True)
        path = PICTURES / f"{name}.png"
        self.page.mouse.move(2, 2)
        self.page.wait_for_timeout(400)
        self.page.screenshot(path=path)
        return path
