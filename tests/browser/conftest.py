"""What all tests in a browser share: Chromium, and one server of each page."""

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from explored import Seen, Served, browser, served

DOCS = Path(__file__).parents[2] / "docs" / "explore.md"


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    with browser() as made:
        yield made


@pytest.fixture(scope="session")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Served]]:
    """The server of a page: of the toy, of maps, or of the system that the docs show."""
    with ExitStack() as stack:

        @cache
        def server(page: str) -> Served:
            words = ["pwmap" if page == "maps" else "woodpecker", "explore", "--stay"]
            if page == "system":
                pytest.importorskip("heyoka")
                blocks = re.findall(r"```py\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)
                path = tmp_path_factory.mktemp("system") / "stop.py"
                path.write_text(next(each for each in blocks if "map_ =" in each), "utf-8")
                words.append(str(path))
            return stack.enter_context(served(*words))

        yield server


@pytest.fixture
def server(request: pytest.FixtureRequest, serving: Callable[[str], Served]) -> Served:
    """The server of the page that a module is about, its ``PAGE``."""
    return serving(request.module.PAGE)


@pytest.fixture
def tab(request: pytest.FixtureRequest, server: Served, chromium: Any) -> Iterator[Seen]:
    """That page as it is opened, once it is ``READY`` if the module says when."""
    seen = Seen(chromium, server.address)
    if ready := getattr(request.module, "READY", ""):
        seen.wait(ready, 60)
    yield seen
    seen.close()
