"""Studies in their short form."""

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ShortRun = tuple[dict[str, Any], Path]


def short_run(study: ModuleType, folders: pytest.TempPathFactory) -> ShortRun:
    """What a study returns, and the folder of its own that it writes to."""
    folder = folders.mktemp(study.__name__)
    return study.main(fast=True, out=folder), folder
