"""Every Python block of the README runs, and prints what the README says it prints."""

import re
from importlib.util import find_spec
from pathlib import Path

import pages
import pytest
from pages import ROOT

README = ROOT / "README.md"
CHANGES = ROOT / "CHANGELOG.md"  # names that are gone have their place there


@pytest.mark.slow
def test_blocks_print_what_they_promise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tried, wrong = pages.run(README)
    assert wrong == ""
    assert tried >= 10


def test_every_name_that_a_page_documents_exists() -> None:
    import pwmap
    import woodpecker

    text = "".join(page.read_text(encoding="utf-8") for page in pages.written() if page != CHANGES)
    for package in (pwmap, woodpecker):
        for name in re.findall(rf"`{package.__name__}\.(\w+)\(?\)?`", text):
            full = f"{package.__name__}.{name}"
            assert hasattr(package, name) or find_spec(full) is not None, full


def test_it_is_short() -> None:
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 120
