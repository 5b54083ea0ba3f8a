"""Every block of Python in the pages runs, and every link leads to what exists."""

import ast
import os
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import pages
import pytest
import rooms
import typer
from needs import NIGHTLY_TOY
from pages import DOCS, ROOT

import pwmap
import woodpecker
from pwmap.cli.app import app as pwmap_app
from woodpecker.cli.app import app as woodpecker_app

PAGES = pages.written()
README = ROOT / "README.md"
CHANGES = ROOT / "CHANGELOG.md"  # names that are gone have their place there
WITH_CODE = [page for page in PAGES if any(pages.blocks(page))]


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
    assert tried >= (10 if page == README else 1)


def test_a_block_runs_where_there_is_what_it_needs(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    block = "```python\n>>> {}\n```\n"
    wants = ["", *(f"<!-- needs: {each} -->\n" for each in ("json.dumps", "json.nothing", "none"))]
    page.write_text("".join(want + block.format(k) for k, want in enumerate(wants)))
    assert [text for _, text in pages.blocks(page)] == [">>> 0\n", ">>> 1\n"]


def test_every_name_that_a_page_documents_exists() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES if page != CHANGES)
    for package in (pwmap, woodpecker):
        for name in re.findall(rf"`{package.__name__}\.(\w+)\(?\)?`", text):
            full = f"{package.__name__}.{name}"
            assert hasattr(package, name) or find_spec(full) is not None, full


def test_the_readme_is_short() -> None:
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 120


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


# --- Equations ------------------------------------------------------------------------------------

ROWS = [
    line.strip("| \n").split(" | ")
    for line in (DOCS / "reference" / "equations.md").read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and "`" in line
]


def test_every_equation_of_the_paper_has_a_row() -> None:
    numbered = [row[0] for row in ROWS if len(row) == 4]
    assert numbered == [f"({number})" for number in range(1, 16)]
    assert len(ROWS) - len(numbered) >= 10  # of what goes beyond it


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_an_equation_has_code_and_a_test(row: list[str]) -> None:
    *_, what, code, test = row
    assert what
    for column, start in ((code, ("pwmap/", "woodpecker/")), (test, ("tests/",))):
        named = re.findall(r"`([\w/.]+)::(\w+)`", column)
        assert named
        assert column.count("`") == 2 * len(named)
        for path, function in named:
            assert path.startswith(start)
            assert function in functions(ROOT / path), f"{path} has no {function}"


def functions(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


# --- Reference ------------------------------------------------------------------------------------


@pytest.mark.parametrize("package", [pwmap, woodpecker], ids=["pwmap", "woodpecker"])
def test_the_reference_has_every_public_name_once(package: ModuleType) -> None:
    """What is at the top and in a room, too, at one of these; what is pwmap's not again."""
    page = (DOCS / "reference" / f"{package.__name__}.md").read_text(encoding="utf-8")
    listed = list[Any]()
    head = r"^\.\. currentmodule:: ([\w.]+)\n\n\.\. autosummary::\n   :toctree: generated\n\n"
    for module, names in re.findall(head + r"((?:   \w+\n)+)", page, flags=re.M):
        listed += [getattr(import_module(module), name) for name in names.split()]
    places = [package, *rooms.ROOMS[package]]
    public = [getattr(place, name) for place in places for name in place.__all__ if name[0] != "_"]
    wanted = {id(value): value for value in public if not isinstance(value, ModuleType)}
    assert len(listed) == len({id(value) for value in listed})
    assert not {id(value) for value in listed} & elsewhere(package)
    missing = wanted.keys() - {id(value) for value in listed} - elsewhere(package)
    assert [wanted[each] for each in missing] == []


def elsewhere(package: ModuleType) -> set[int]:
    """Names of pwmap that woodpecker has, too."""
    return {id(pwmap.plane.PlaneKind), id(pwmap.load_diagram)} if package is woodpecker else set()


def test_every_page_is_reached_from_the_index() -> None:
    """Sphinx says so too; here it takes no build."""
    reached, new = set(), {DOCS / "index.md"}
    while new:
        page = new.pop()
        reached.add(page)
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text("utf-8"), flags=re.S):
            targets = {page.parent / f"{name}.md" for name in tree.split()}
            new |= {target for target in targets if target.is_file()} - reached
    assert {page for page in PAGES if DOCS in page.parents} == reached


# --- Tutorials ------------------------------------------------------------------------------------

TUTORIALS = {  # what each prints, among other things
    "1_the_toy": [
        "phi_S -0.5294719671 rad, period 0.1459760651 s",
        "A    FF  0.1119709145 -0.88477334",
        "7 special points, 6 branches",
    ],
    "2_your_own_map": [
        "J1  jump         L / R  ('BC1', 'BC2')",
        "BC2  +1.000000000000 +0.000000000000  persistence x = 0",
        "10 branches, 9 special points",
    ],
    "3_two_parameters": [
        "PD3: a**2*b + 1 = 0,  LLR",
        "flip-border collision (-1/2 + sqrt(5)/2, -3/2 - sqrt(5)/2) ('PD3', 'BC1')",
        "JC  0.183213538 0.298813727 jump closes",
    ],
    "4_p1l": [
        "R r/(a + 1) multiplier -a stable: False",
        "RR  a**2*x - a*r + r  for 0 < x < r/a",
        "(0, 2, 2*a**2/(a**2 - a + 1), 2*a/(a - 1))",
        "FF fold at r = 0 ((), ('F2', 'J1', 'J2'))",
    ],
    "5_the_paper": [
        "phi_M -0.103448, phi_S -0.221694 rad, mu_2 at least 0.2851875",
        "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2",
        "A    border-collision fold-flip 0.11197091  fold",
        "P_2 jump RR|RL, along 4.3160 rad",
    ],
}


def test_every_tutorial_is_tested() -> None:
    assert {path.stem for path in (DOCS / "tutorials").glob("*.py")} == set(TUTORIALS)


@NIGHTLY_TOY
@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_prints_its_numbers(name: str, tmp_path: Path) -> None:
    script = DOCS / "tutorials" / f"{name}.py"
    path = os.pathsep.join(filter(None, [str(ROOT), *sys.path]))
    ran = subprocess.run(
        [sys.executable, "-W", "error", str(script)], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg"},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert [line for line in TUTORIALS[name] if line not in ran.stdout] == []


# --- Commands -------------------------------------------------------------------------------------

COMMAND = re.compile(r"(?:`|^    |&& )((?:woodpecker|pwmap) [a-z][^`\n]*)", flags=re.MULTILINE)
SHOWN = sorted(
    {
        tuple(found.split())
        for page in PAGES
        if page.name != "CHANGELOG.md"
        for found in COMMAND.findall(page.read_text(encoding="utf-8"))
    }
)


@pytest.mark.slow
@pytest.mark.parametrize("words", SHOWN, ids=" ".join)
def test_a_command_that_is_shown_exists_with_its_options(words: tuple[str, ...]) -> None:
    application = {"woodpecker": woodpecker_app, "pwmap": pwmap_app}[words[0]]
    group = typer.main.get_command(application)
    assert isinstance(group, typer.core.TyperGroup)
    command = group.commands[words[1]]
    known = {option for parameter in command.params for option in parameter.opts}
    known |= {option for parameter in command.params for option in parameter.secondary_opts}
    assert {word for word in words[2:] if word.startswith("--")} <= known | {"--help"}


def test_commands_are_shown() -> None:
    assert ("woodpecker", "diagram") in SHOWN
    assert len(SHOWN) >= 12


# --- Words ----------------------------------------------------------------------------------------

PLAIN_WORDS = {  # what a page does not say, and the word of the field, or a plain one
    "hang together": "are connected",
    "hangs together": "is connected",
    "nobody sees": "is hidden",
    "hairpin": "a sharp fold",
    "needle": "a sharp fold",
    "rooms of the house": "where things are",
    "atlas": "a network",
    "journal": "a checkpoint",
    "crew": "an executor",
}


@pytest.mark.parametrize("page", [p for p in PAGES if p.name != "CHANGELOG.md"], ids=name)
def test_pages_use_the_words_of_the_field(page: Path) -> None:
    text = page.read_text(encoding="utf-8").lower()
    found = {word for word in PLAIN_WORDS if re.search(rf"\b{word}\b", text)}
    assert {word: PLAIN_WORDS[word] for word in found} == {}


@pytest.mark.parametrize("page", [p for p in PAGES if p.name != "CHANGELOG.md"], ids=name)
def test_a_page_is_not_longer_than_one_reads(page: Path) -> None:
    lines = page.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 250
    for title in [line for line in lines if line.startswith("# ")][:1]:  # or it includes a page
        assert len(title.split()) - 1 <= 6, title


# --- Works ----------------------------------------------------------------------------------------


def test_every_entry_of_the_list_of_works_ends_before_the_next() -> None:
    text = (ROOT / "references.bib").read_text(encoding="utf-8")
    for entry in re.split(r"^(?=@)", text, flags=re.M)[1:]:
        assert entry.count("{") == entry.count("}"), entry.splitlines()[0]
