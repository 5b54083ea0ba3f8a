"""A checkpoint: a text file that grows by one line of JSON with everything that is finished.

Each line is handed to the system before a search goes on, so that a run that is interrupted, or
killed, loses nothing but what was being done. The first line says what is searched, and how.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

from pwmap.diagrams.files import write_whole

fcntl: Any
try:
    import fcntl
except ImportError:  # Windows: nothing keeps two runs from writing one file
    fcntl = None

Entry = dict[str, Any]
RUN, START = "run", "start"  # what is searched; the points from which it sets out
SAME = 1e-9  # of points to start from: other machines round in other ways
WAIT = 3.0  # s: as long as the workers of a killed run may take to notice, and hold its file


class Checkpoint:
    """Lines of JSON, each written through before the search goes on.

    Where the system locks files (not on Windows) nobody else can write the file meanwhile.

    Parameters
    ----------
    path
        The file. What is in it is kept as ``<name>.old`` unless the run is resumed.
    run
        What is searched, and how; a run can only be resumed with the same. Points to start from
        are the same if they differ by 1e-9 at most: other machines round in other ways.
    version
        Of the lines; raised when older code would misread them.
    check
        Raises an error of a lookup, a TypeError or a ValueError unless an entry is a good one.
    resume
        Go on with the run in the file.

    Raises
    ------
    ValueError
        If there is nothing to resume, the run in the file is another one, or it is being written.
    """

    def __init__(
        self, path: str | os.PathLike[str], run: Entry, *, version: int,
        check: Callable[[Entry], object], resume: bool = False,
    ) -> None:  # fmt: skip
        self.path = Path(path)
        self.entries: list[Entry] = []
        run = json.loads(json.dumps(run))
        if resume:
            _existing(self.path)
        self._file: TextIO = self.path.open("a", encoding="utf-8", newline="\n")
        try:
            _lock(self._file, self.path)
            if resume:
                header, self.entries = read(self.path, version=version, check=check)
                _compare(header, run, self.path)
                self._file.truncate(_whole(self.path))  # a last line that was being written
            else:
                old = self.path.read_bytes()
                if old:
                    write_whole(self.path.with_name(self.path.name + ".old"), old)
                    self._file.truncate(0)
                self.write({RUN: run, "version": version})
        except BaseException:
            self.close()
            raise

    def write(self, entry: Entry) -> None:
        """Append one entry and hand it to the system."""
        self._file.write(json.dumps(entry) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file, and let others write it."""
        if fcntl is not None and not self._file.closed:  # copies of this process have it open too
            fcntl.flock(self._file, fcntl.LOCK_UN)
        self._file.close()


def _lock(file: TextIO, path: Path) -> None:
    """Keep others from writing a file, until it is closed or this process ends."""
    if fcntl is None:
        return
    patience = time.monotonic() + WAIT
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() < patience:
                time.sleep(0.05)
                continue
            raise ValueError(
                f"another run is writing {path}: wait until it ends, or choose another file"
            ) from None
        except OSError:  # a file system without locks
            return
        return


def version_of(path: str | os.PathLike[str]) -> object:
    """The version that the first line of a checkpoint states, or None."""
    with _existing(Path(path)).open("rb") as file:
        try:
            header = json.loads(file.readline())
        except ValueError:
            return None
    return header.get("version") if isinstance(header, dict) else None


def read(
    path: str | os.PathLike[str], *, version: int, check: Callable[[Entry], object]
) -> tuple[Entry, list[Entry]]:
    """What a checkpoint says of its run, and its entries so far.

    Raises
    ------
    ValueError
        If the file does not exist, or is not a checkpoint of this version from the first line to
        the last that is complete.
    """
    path = _existing(Path(path))
    with path.open("rb") as file:
        lines = file.read(_whole(path)).splitlines()
    header, *entries = [_read(line, n, path) for n, line in enumerate(lines, 1)] or [{}]
    if not isinstance(header.get(RUN), dict):
        raise ValueError(f"{path} is not the journal of a run: its first line does not say which")
    found = header.get("version")
    if found != version:
        written = "without a number" if found is None else repr(found)
        raise ValueError(
            f"{path} holds a run in a format {written}, expected format {version}: start the run "
            "anew"
        )
    for n, entry in enumerate(entries, 2):
        try:
            check(entry)
        except (KeyError, IndexError, TypeError, ValueError):
            raise ValueError(
                f"{path}, line {n}: expected an entry of a run, got {_short(entry)}"
            ) from None
    return header[RUN], entries


def _existing(path: Path) -> Path:
    if not path.exists():
        raise ValueError(f"there is no saved run: {path} does not exist")
    return path


def _read(line: bytes, n: int, path: Path) -> Entry:
    try:
        entry = json.loads(line)
    except ValueError as error:  # no JSON, or no text
        raise ValueError(f"{path}, line {n}: not the journal of a run: {error}") from None
    if not isinstance(entry, dict):
        raise ValueError(f"{path}, line {n}: expected an entry of a run, got {_short(entry)}")
    return entry


def _short(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."


def checked_type(value: object, kind: type | tuple[type, ...]) -> None:
    """Raise a TypeError unless a value is of a type; a bool is no number."""
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise TypeError(f"expected {kind}")


def checked_number(value: object) -> float:
    """A number as it was written."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError("expected a number")
    return float(value)


def _whole(path: Path) -> int:
    """Length in bytes of all lines that are complete."""
    return path.read_bytes().rfind(b"\n") + 1


def _compare(old: Entry, new: Entry, path: Path) -> None:
    for key in {**old, **new}:
        if key == START and _close(old.get(key), new.get(key)):
            continue
        if old.get(key) != new.get(key):
            raise ValueError(f"cannot resume {path}: {_difference(key, old, new)}")


def _difference(key: str, old: Entry, new: Entry, within: str = "") -> str:
    """The first value that differs, by its name, there and here."""
    name = f"{key}{within}"
    if key not in new:
        return f"there {name} is {_short(old[key])}, now there is none"
    if key not in old:
        return f"there is no {name} there, now it is {_short(new[key])}"
    one, other = old[key], new[key]
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return f"there {name} is {one}, now it is {other}"
    missing = object()
    inner = next(k for k in {**one, **other} if one.get(k, missing) != other.get(k, missing))
    return _difference(inner, one, other, f" of {name}")


def _close(old: object, new: object) -> bool:
    """Whether two lists of numbers are those of one solution, rounded in different ways."""
    if not isinstance(old, list) or not isinstance(new, list) or len(old) != len(new):
        return False
    return all(isinstance(a, float) and abs(a - b) <= SAME for a, b in zip(old, new, strict=True))
