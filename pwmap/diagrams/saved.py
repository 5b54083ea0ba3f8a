"""Records as files: JSON with a name, a version and the content, bounded in size and in cost."""

from __future__ import annotations

import gzip
import hashlib
import io
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sympy.polys.polyerrors import BasePolynomialError

from pwmap.algebra.arguments import checked_path, shortened
from pwmap.diagrams import formulas
from pwmap.diagrams.encoding import from_plain, to_plain
from pwmap.diagrams.files import json_file, write_whole

FORMAT, VERSION, SEAL = "format", "version", "seal"
ZIPPED = ".gz"
LARGEST = 2**24  # bytes that a compressed file of any size may expand to,
MAX_RATIO = 64  # or this many times its own size; files written here expand 3 to 25 times
MAX_COST = 1e8  # of all formulas in a file, see pwmap.diagrams.formulas.cost: some 15 s


def write_record(
    path: str | Path, record: Any, name: str, version: int, *, sealed: bool = False
) -> Path:
    """Write a record under the name and version of its format; ValueError for a wrong suffix.

    ``sealed`` adds a digest of the content, so that a changed file is refused when it is read.
    """
    file = json_file(path, zipped=True)
    data = record_as_bytes(record, name, version, sealed=sealed)
    write_whole(file, gzip.compress(data, mtime=0) if file.suffix.lower() == ZIPPED else data)
    return file


def record_as_bytes(record: Any, name: str, version: int, *, sealed: bool = False) -> bytes:
    """The bytes that :func:`write_record` writes into a file that is not compressed."""
    plain = to_plain(record)
    seal = {SEAL: _seal_of(plain)} if sealed else {}
    return _as_bytes({FORMAT: f"pwmap {name}", VERSION: version, **seal, name: plain})


def _as_bytes(content: Any) -> bytes:
    return json.dumps(content, allow_nan=False, ensure_ascii=False, separators=(",", ":")).encode()


def _seal_of(content: Any) -> str:
    return hashlib.sha256(_as_bytes(content)).hexdigest()


def read_record(
    path: str | Path, kind: type | Callable[[Any], Any], name: str, version: int, *,
    sealed: bool = False, check: Callable[[Any], None] = lambda _: None,
) -> Any:  # fmt: skip
    """Read what :func:`write_record` wrote, in this or an older version; ValueError otherwise.

    ``kind`` is the type of the record, or a function that makes it from JSON data; ``check`` raises
    ValueError for a record of the right types but with wrong values.
    """
    path = checked_path(path)
    data = path.read_bytes()
    try:
        content = json.loads(_unzipped(data) if path.suffix.lower() == ZIPPED else data)
        if not isinstance(content, dict) or content.get(FORMAT) != f"pwmap {name}":
            raise ValueError(f"it does not begin with the format 'pwmap {name}'")
        written = content[VERSION]
        if type(written) is not int or written < 1:
            raise ValueError(f"its version must be a whole number from 1 on, got {written!r}")
        if written <= version:
            if sealed and content.get(SEAL) != _seal_of(content[name]):
                raise ValueError("its content was changed after it was saved: the seal is another")
            if formulas.cost(content) > MAX_COST:
                raise ValueError("its formulas have numbers so long that they are not read")
            plain = content[name]
            found = from_plain(plain, kind) if isinstance(kind, type) else kind(plain)
            check(found)
            return found
    except RecursionError:
        reason = "it is nested too deep"
    except (ArithmeticError, AttributeError, BasePolynomialError, EOFError, LookupError, OSError,
            RuntimeError, TypeError, ValueError, zlib.error) as error:  # fmt: skip
        reason = shortened(" ".join(str(error).split()), 200)
    else:
        raise ValueError(
            f"{path} has version {written} of the format 'pwmap {name}', and this pwmap reads up "
            f"to version {version}: a newer one is needed"
        )
    raise ValueError(f"{path} is no saved {name}: {reason}")


def _unzipped(data: bytes) -> bytes:
    """Decompress; ValueError if it expands further than any file that is written here."""
    most = max(LARGEST, MAX_RATIO * len(data))
    with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
        found = file.read(most + 1)
    if len(found) > most:
        raise ValueError(f"{len(data)} bytes of it hold more than {most}")
    return found
