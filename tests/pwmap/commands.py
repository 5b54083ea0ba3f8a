"""The command ``pwmap analyse``, run in this process."""

from pathlib import Path

from typer.testing import CliRunner

from pwmap.cli.app import app


def run(*arguments: str, out: Path) -> tuple[int, str]:
    """Status and output."""
    found = CliRunner().invoke(app, ["analyse", *arguments, "--out", str(out)])
    return found.exit_code, found.output
