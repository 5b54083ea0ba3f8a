"""Studies in their short form, and what they leave behind."""

import json
from pathlib import Path
from typing import Any

import pytest

from studies import run_all

ShortRun = tuple[dict[str, Any], Path]


def short_run(name: str, folder: Path) -> dict[str, Any]:
    """What a study returns; its numbers are saved in a folder, where its pictures are."""
    results = run_all.run_all(True, folder, [name])[name]
    saved = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    assert set(saved) == {*results, "environment"}
    assert set(saved["environment"]) >= {"machine", "commit", "python", "numpy", "numba"}
    return results


def kept_run(name: str, folders: pytest.TempPathFactory) -> ShortRun:
    """The same for several tests, and the folder."""
    folder = folders.mktemp(name)
    return short_run(name, folder), folder


def is_picture(path: Path) -> bool:
    """Whether it is a PNG with something on it: an empty one of this size has 5 kB."""
    return path.read_bytes()[:4] == b"\x89PNG" and path.stat().st_size > 20_000
