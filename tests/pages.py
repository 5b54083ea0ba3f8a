"""Pages of the documentation: where they are, the code blocks in them, and their links."""

import doctest
import re
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
FENCE = re.compile(r"^(`{3,}|~{3,})(.*?)\n(.*?)^\1\s*$", flags=re.MULTILINE | re.DOTALL)
NEEDS = re.compile(r"(?:<!-- needs: [\w.]+ -->\n)+\Z")  # in front of a block
LINK = re.compile(r"\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(([^)\s]+)\)")


def written() -> list[Path]:
    """All pages of Markdown in the repository but for those that are made."""
    results = ROOT / "studies" / "results"
    pages = [
        ROOT / "README.md",
        ROOT / "CHANGELOG.md",
        results / "README.md",
        results / "diagrams.md",
    ]
    return [*pages, *sorted(page for page in DOCS.rglob("*.md") if not made(page))]


def made(page: Path) -> bool:
    """Whether a page is written by the build of the documentation."""
    return bool({"generated", "gallery", "_build"} & set(page.relative_to(DOCS).parts))


def blocks(page: Path) -> Iterator[tuple[int, str]]:
    """Line and text of each block of Python that can run here."""
    text = page.read_text(encoding="utf-8")
    for found in FENCE.finditer(text):
        if found[2].strip() == "python":
            needs = NEEDS.search(text[: found.start()])
            wanted = re.findall(r"needs: ([\w.]+)", needs[0]) if needs else []
            if all(map(there_is, wanted)):
                yield text.count("\n", 0, found.start(3)), found[3]


def there_is(name: str) -> bool:
    """Whether a module, or something of a module, can be imported."""
    module, _, attribute = name.partition(".")
    if find_spec(module) is None:
        return False
    return not attribute or hasattr(import_module(module), attribute)


def run(page: Path) -> tuple[int, str]:
    """Run the blocks of a page one after the other: how many lines of code, and what is wrong."""
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    names: dict[str, Any] = {"__name__": "__main__"}
    report: list[str] = []
    for line, block in blocks(page):
        test = doctest.DocTestParser().get_doctest(block, names, page.stem, str(page), line)
        assert test.examples, f"{page.name}, line {line + 1}: a block without a >>> line"
        runner.run(test, out=report.append, clear_globs=False)
        names = test.globs
    return runner.tries, "".join(report)


def wrong_links(page: Path) -> list[str]:
    """Links of a page that lead nowhere; an address of the web must only look like one."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    return [
        link for link in LINK.findall(re.sub(r"`[^`\n]*`", "code", text)) if not leads(page, link)
    ]


def leads(page: Path, link: str) -> bool:
    """Whether a link leads to a file, a folder or a heading that exists."""
    parts = urlsplit(link)
    if parts.scheme:
        return parts.scheme == "https" and "." in parts.netloc and " " not in link
    target = page if not parts.path else page.parent / unquote(parts.path)
    if target.resolve() == DOCS / "gallery" / "index.rst":  # the build makes it of the tutorials
        target = DOCS / "tutorials" / "GALLERY_HEADER.rst"
    if not target.exists():
        return False
    return not parts.fragment or (target.suffix == ".md" and parts.fragment in anchors(target))


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as GitHub and the documentation make them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    return {slug(found) for found in re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)}


def slug(heading: str) -> str:
    """The anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
