"""Every block of Python in the pages runs, and every link leads to what exists."""

import re
from pathlib import Path

import pages
import pytest
from pages import DOCS, ROOT

PAGES = pages.written()
WITH_CODE = [page for page in PAGES if page != ROOT / "README.md" and any(pages.blocks(page))]


def name(page: Path) -> str:
    return page.relative_to(ROOT).with_suffix("").as_posix()


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_CODE, ids=name)
def test_blocks_print_what_they_promise(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tried, wrong = pages.run(page)
    assert wrong == ""
    assert tried >= 1


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_to_what_exists(page: Path) -> None:
    assert pages.wrong_links(page) == []


@pytest.mark.parametrize(
    ("link", "leads"),
    [
        ("proofs.md", True),
        ("proofs.md#the-theorem", True),
        ("proofs.md#no-such-heading", False),
        ("../pwmap/no_such_file.py", False),
        ("../pwmap", True),
        ("https://www.sphinx-doc.org/", True),
        ("http://example.org", False),
        ("https://nowhere", False),
    ],
)
def test_a_link_that_leads_nowhere_is_found(link: str, leads: bool) -> None:
    assert pages.leads(DOCS / "long_run.md", link) is leads


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=name)
def test_works_that_are_cited_are_in_the_list(page: Path) -> None:
    known = set(
        re.findall(
            r"^@\w+\{(\w+),", (ROOT / "references.bib").read_text(encoding="utf-8"), flags=re.M
        )
    )
    cited = re.findall(r"\b[A-Z][a-z]\w+\d{4}\b", page.read_text(encoding="utf-8"))
    assert set(cited) <= known
