"""Settings of all tests: import path, rounding mode, and examples of property tests.

Helper modules of the tests lie in this folder (``pythonpath`` of pytest), the studies in one beside
it. They come last on the path, so that the packages under test are the installed ones.

Property tests draw the same examples each time, on every machine. The profile ``explore`` draws
others, and many more: ``--hypothesis-profile=explore``, or that name in HYPOTHESIS_PROFILE.
"""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import rounding
from hypothesis import HealthCheck, settings

sys.path.append(str(Path(__file__).parents[1]))
rounding.apply()
os.environ["MPLBACKEND"] = "Agg"  # no picture opens a window
os.environ.pop("COLUMNS", None)  # some workers have one: tables would be as narrow as a terminal

settings.register_profile("same", derandomize=True, database=None, deadline=None)
settings.register_profile(
    "explore",
    derandomize=False,
    deadline=None,
    max_examples=2000,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What is for the night is slow, too."""
    for item in items:
        if item.get_closest_marker("nightly"):
            item.add_marker("slow")


@pytest.fixture(autouse=True)
def _close() -> Iterator[None]:
    """No picture of one test is left to the next."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture
def workers_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others than the calling process take part from the beginning."""
    monkeypatch.setattr("woodpecker.base.executors.PATIENCE", 0.0)
