"""Records in files of their own: one JSON object that says what it holds, and in which version.

A file whose name ends with ``.gz`` is compressed. Other programs find the content under the name
of what it is, say ``json.load(file)["diagram"]["branches"]``.
"""

from __future__ import annotations

import gzip
import json
import zlib
from pathlib import Path
from typing import Any

from pwmap.algebra.terms import shortened
from pwmap.diagrams.encoding import from_plain, to_plain
from pwmap.diagrams.files import write_whole

FORMAT, VERSION = "format", "version"
ZIPPED = ".gz"


def write_record(path: Path, record: Any, name: str, version: int) -> None:
    """Write a record of some name, in the version of its format; the file is whole or not there."""
    content = {FORMAT: f"pwmap {name}", VERSION: version, name: to_plain(record)}
    data = json.dumps(content, allow_nan=False, ensure_ascii=False, separators=(",", ":")).encode()
    write_whole(path, gzip.compress(data, mtime=0) if path.suffix == ZIPPED else data)


def read_record(path: Path, kind: type, name: str, version: int) -> Any:
    """Read what :func:`write_record` wrote, in this or an older version.

    Raises
    ------
    ValueError
        If the file is none of these.
    """
    data = path.read_bytes()
    try:
        content = json.loads(gzip.decompress(data) if path.suffix == ZIPPED else data)
        if not isinstance(content, dict) or content.get(FORMAT) != f"pwmap {name}":
            raise ValueError(f"it does not begin with the format 'pwmap {name}'")
        written = content[VERSION]
        if written <= version:
            return from_plain(content[name], kind)
    except RecursionError:
        reason = "it is nested too deep"
    except (ArithmeticError, AttributeError, EOFError, LookupError, OSError, TypeError, ValueError,
            zlib.error) as error:  # fmt: skip
        reason = shortened(" ".join(str(error).split()), 200)
    else:
        raise ValueError(
            f"{path} has version {written} of the format 'pwmap {name}', and this pwmap reads up "
            f"to version {version}: a newer one is needed"
        )
    raise ValueError(f"{path} is no saved {name}: {reason}")
