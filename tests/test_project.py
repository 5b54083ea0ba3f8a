"""What the files around the packages say agrees: versions, Pythons, scripts, names."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
SOURCES = pytest.mark.skipif(not (ROOT / ".ci").is_dir(), reason="no part of a distribution")


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_one_version() -> None:
    cff, bib = text_of("CITATION.cff"), text_of("references.bib")
    assert re.findall(r"^version: (.+)$", cff, flags=re.MULTILINE) == [PROJECT["version"]]
    assert re.findall(r"version = \{(.+)\}", bib) == [PROJECT["version"]]
    (year,) = re.findall(r"^date-released: (\d+)", cff, flags=re.MULTILINE)
    assert f"year    = {{{year}}}" in bib


def test_one_list_of_pythons() -> None:
    start = "Programming Language :: Python :: "
    named = [each.removeprefix(start) for each in PROJECT["classifiers"] if each.startswith(start)]
    assert [each for each in named if "." in each] == PYTHONS
    assert PROJECT["requires-python"] == f">={PYTHONS[0]}"
    assert f"Python {PYTHONS[0]} or newer" in text_of("CONTRIBUTING.md")
    assert f"Python {PYTHONS[0]} to {PYTHONS[-1]}" in text_of("CONTRIBUTING.md")


@SOURCES
def test_the_workflow_runs_the_gate_on_all_of_them() -> None:
    text = text_of(".github/workflows/tests.yml")
    lists = [re.findall(r'"([\d.]+)"', row) for row in re.findall(r"python: (\[.*\])", text)]
    assert lists == [PYTHONS, [PYTHONS[0], PYTHONS[-1]]]
    assert re.findall(r"os: \[(.*)\]", text) == ["ubuntu-latest, macos-latest, windows-latest"] * 2
    assert re.findall(r"run: bash (\S+)", text) == [".ci/run", ".ci/distributions"]
    night = text_of(".github/workflows/nightly.yml")
    assert re.findall(r"run: bash (\S+)", night) == [".ci/nightly"]
    assert "cron:" in night


@SOURCES
@pytest.mark.parametrize("name", ["run", "nightly", "distributions", "environment"])
def test_scripts_are_what_a_shell_can_read(name: str) -> None:
    path = ROOT / ".ci" / name
    assert b"\r" not in path.read_bytes()
    subprocess.run(["bash", "-n", str(path)], check=True)


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "RELEASING.md"])
def test_pages_name_files_that_exist(page: str) -> None:
    named = re.findall(r"`((?:[\w.]+/)+[\w.]+\.(?:py|md|toml|bib|cff|pyi))`", text_of(page))
    assert [each for each in named if not (ROOT / each).is_file()] == []
    assert page != "CONTRIBUTING.md" or len(named) >= 8


@pytest.mark.parametrize("package", ["pwmap", "woodpecker"])
def test_tables_of_names_are_plain_text(package: str) -> None:
    """They are opened in whatever encoding the system has."""
    assert text_of(f"{package}/__init__.pyi").isascii()
