"""Runs commands of both packages in this process, and reads the tables that they write."""

import csv
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

from pwmap.cli.app import app


def invoked(program: typer.Typer, *arguments: str) -> Any:
    """What comes of a command; an exception that is none of its own is raised."""
    found = CliRunner().invoke(program, [*arguments])
    if found.exception is not None and not isinstance(found.exception, SystemExit):
        raise found.exception
    return found


def analyse(*arguments: str, out: Path) -> tuple[int, str]:
    """Status and output of ``pwmap analyse``."""
    found = invoked(app, "analyse", *arguments, "--out", str(out))
    return found.exit_code, found.output


def rows(path: Path) -> list[dict[str, str]]:
    """Those of a CSV file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
