"""Studies in their short form, and what they leave behind."""

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ShortRun = tuple[dict[str, Any], Path]


def short_run(study: ModuleType, folders: pytest.TempPathFactory) -> ShortRun:
    """What a study returns, and the folder of its own that it writes to."""
    folder = folders.mktemp(study.__name__)
    return study.main(fast=True, out=folder), folder


def is_picture(path: Path) -> bool:
    """Whether it is a PNG with something on it: an empty one of this size has 5 kB."""
    return path.read_bytes()[:4] == b"\x89PNG" and path.stat().st_size > 20_000
