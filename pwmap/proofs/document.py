"""A certificate as a document: a statement with all that it takes to verify it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pwmap.diagrams.files import json_file, write_whole
from pwmap.diagrams.shown import brief


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Certificate:
    """A statement of :func:`pwmap.prove` with all that it takes to verify it.

    ``content`` is what is written to JSON, with its seal.
    """

    content: Mapping[str, Any]

    @property
    def statement(self) -> str:
        """The sentence that is proved, as ``check_certificate`` returns it for the file."""
        return str(self.content["statement"])

    def __repr__(self) -> str:
        return f"Certificate({self.content['kind']}: {brief(self.statement)!r})"

    def __str__(self) -> str:
        return self.statement

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write JSON, completely or not at all; ValueError for a suffix like ``.csv``."""
        file = json_file(path)
        lines = [f"{json.dumps(name)}: {_lines(value)}" for name, value in self.content.items()]
        write_whole(file, ("{\n" + ",\n".join(lines) + "\n}\n").encode("ascii"))
        return file


def _lines(value: object) -> str:
    if not isinstance(value, list | tuple) or not value:
        return json.dumps(value)
    return "[\n  " + ",\n  ".join(map(json.dumps, value)) + "\n]"
