"""Files that are written whole or not at all."""

from __future__ import annotations

import csv
import io
import os
import sys
import uuid
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pwmap.algebra.arguments import checked_path, shown


def json_file(path: str | os.PathLike[str], *, zipped: bool = False) -> Path:
    """The path of a file for JSON, which may be ``zipped``; ValueError for another suffix."""
    file = checked_path(path)
    suffix = file.suffix.lower()
    known = suffix in ("", ".json") or (zipped and suffix == ".gz")
    if not known and not suffix[1:].isdigit():  # a name may end in a number: a=0.5
        names = ".json or .json.gz" if zipped else ".json"
        raise ValueError(
            f"what is saved is JSON: expected a name in {names}, got {shown(file.name)}"
        )
    return file


def write_whole(path: Path, content: bytes) -> None:
    """Write a file whole or not at all: under another name, then renamed.

    FileNotFoundError without the folder; IsADirectoryError for a folder, FileExistsError for a
    device or a pipe; an OSError names the file.
    """
    if not path.parent.is_dir():
        raise FileNotFoundError(f"cannot write {path.name}: there is no folder {path.parent}")
    if path.is_dir():
        raise IsADirectoryError(f"cannot write {path}: it is a folder, expected a file in it")
    if path.exists() and not path.is_file():  # a file of that name would take its place
        raise FileExistsError(f"cannot write {path}: it is a device or a pipe, expected a file")
    temporary = path.with_name(f".{uuid.uuid4().hex}.tmp")
    try:
        with temporary.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:  # a full disk names no file
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table as CSV."""
    write_whole(path, table_as_text(header, rows).encode())


def table_as_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """The text that :func:`write_table` writes."""
    return rows_as_text([header]) + rows_as_text(rows)


def rows_as_text(rows: Iterable[Sequence[object]]) -> str:
    """Rows of a table as CSV."""
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    return text.getvalue()


def write_figure(path: Path, figure: Any) -> None:
    """Write a matplotlib figure in the format of the suffix, and close it."""
    write_whole(path, figure_as_bytes(figure, path.suffix[1:]))


def figure_as_bytes(figure: Any, form: str) -> bytes:
    """The bytes that :func:`write_figure` writes in a format; the figure is closed."""
    data = io.BytesIO()
    with sys.modules["matplotlib"].rc_context({"pdf.fonttype": 42, "svg.hashsalt": "woodpecker"}):
        # TrueType fonts as journals ask, a fixed salt and no date: equal figures give equal files
        figure.savefig(data, dpi=200, format=form, metadata=_UNDATED.get(form))
    if "matplotlib.pyplot" in sys.modules:  # pyplot keeps every figure until it is closed
        sys.modules["matplotlib.pyplot"].close(figure)
    return data.getvalue()


_UNDATED = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
