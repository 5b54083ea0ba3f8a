"""The record of a command's run in a folder, with its input and files: ``about_<command>.json``.

With its list of files a new run removes those of an earlier one that it does not write itself.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from pwmap.diagrams.files import write_whole

LEFT_OUT_KEY = "left"  # key in ``about`` of a diagram: what a search left out because of its cost
FILES = "files"  # key in a record: digests by the names of files


def program() -> str:
    """The program and its version."""
    from pwmap.version import __version__  # reading it takes a tenth of the time of --help

    return f"woodpecker-toy {__version__}"


def record_of(command: str) -> str:
    """The file name of a command's record."""
    return f"about_{command}.json"


def keep_record(
    folder: Path, command: str, names: Iterable[str], about: Mapping[str, object]
) -> tuple[str, ...]:
    """Record what a command wrote; remove and return other, unchanged files of its last run."""
    path, written = folder / record_of(command), list(names)
    stale = [
        name
        for name, digest in files_of(path).items()
        if name not in written and _is_as_written(folder, name, digest)
    ]
    for name in stale:
        (folder / name).unlink()
    digests = {name: _digest(folder / name) for name in written}
    content = {"program": program(), "command": command, **plain(about), FILES: digests}
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())
    return tuple(stale)


def earlier_files(folder: Path, command: str) -> tuple[str, ...]:
    """The files that an earlier run of a command wrote into a folder and that are still there."""
    names = files_of(folder / record_of(command))
    return tuple(name for name in names if name == Path(name).name and (folder / name).is_file())


def plain(value: object) -> Any:
    """A value for JSON: enums by their values, infinite numbers as text."""
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, str | int | None):
        return value
    if isinstance(value, float) and value - value == 0.0:  # finite
        return value
    return str(value)


def attributes(about: Mapping[str, object]) -> dict[str, str | float]:
    """The entries of ``about`` as attributes of a graph: numbers, text, or JSON for the rest."""
    return {
        name: value if isinstance(value, str | float) else json.dumps(value)
        for name, value in plain(about).items()
    }


def files_of(path: Path) -> dict[str, str]:
    """The files of a record with their digests; none if there is no record that can be read."""
    try:
        found = json.loads(path.read_bytes())[FILES]
        return {name: digest for name, digest in found.items() if isinstance(digest, str)}
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return {}


def _is_as_written(folder: Path, name: str, digest: str) -> bool:
    path = folder / name
    inside = name == path.name and not path.is_symlink() and path.is_file()
    return inside and _digest(path) == digest


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
