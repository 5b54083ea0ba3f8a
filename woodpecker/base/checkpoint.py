"""A checkpoint: a text file with one line of JSON for each finished part of a run.

The first line describes the run. Each line ends with a digest of itself and of all lines before it.
An incomplete last line, which an interruption leaves behind, is dropped.
"""

from __future__ import annotations

import hashlib
import json
import operator
import os
import re
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, TextIO

from pwmap.diagrams.files import write_whole

Entry = dict[str, Any]
RUN = "run"  # key of the description of the run
START, MAP = "start", "map"  # keys in it: the starting points; the orbits that identify a map
DIGEST = 8  # bytes of a digest: one changed line in 2^64 is not noticed
TAIL = re.compile(rb', "digest": "([0-9a-f]{16})"\}$')
SAME = 1e-9  # relative above 1: such points may differ by this, as rounding does between machines
_MISSING = object()
WAIT = 3.0  # s: how long the workers of a killed run may still hold its lock


class Checkpoint:
    """A locked file of JSON lines, each of which is on disk before the search goes on.

    A new run keeps an older file as ``<name>.old``. A resumed run must be the same: its starts
    and orbits up to 1e-9, everything else exactly. ``version`` is the format, raised when older
    code would misread lines; ``parsed`` converts an entry, or raises an arithmetic, attribute,
    lookup, type or value error. ValueError if there is nothing to resume, the run is another one,
    or another process writes the file.
    """

    def __init__(
        self, path: str | os.PathLike[str], run: Entry, *, version: int,
        parsed: Callable[[Entry], Any], resume: bool = False,
    ) -> None:  # fmt: skip
        self.path = Path(path)
        self.entries: list[Any] = []
        run = json.loads(json.dumps(run))
        if resume:
            _existing(self.path)
        self._file: TextIO = self.path.open("a", encoding="utf-8", newline="\n")
        self._open = ExitStack()  # closing it unlocks the file and closes it
        self._open.enter_context(self._file)
        try:
            self._open.callback(_locked(self._file, self.path))
            old, self._digest = self.path.read_bytes(), ""
            first = {RUN: run, "version": version}
            if resume and not line_of(first, "").startswith(old):  # more than its first line
                header, self.entries = read(self.path, version=version, parsed=parsed)
                _compare(header, run, self.path)
                whole = old[: _whole(old)]
                self._digest = _digest_of(whole.splitlines()[-1])
                self._file.truncate(len(whole))  # drops an incomplete last line
            else:
                if old and not resume:
                    write_whole(self.path.with_name(self.path.name + ".old"), old)
                self._file.truncate(0)
                self.write(first)
        except BaseException:
            self.close()
            raise

    def write(self, entry: Entry) -> None:
        """Append one entry and write it to disk."""
        line = line_of(entry, self._digest)
        self._file.write(line.decode())
        self._file.flush()
        os.fsync(self._file.fileno())
        self._digest = _digest_of(line[:-1])

    def close(self) -> None:
        """Close and unlock the file."""
        self._open.close()


def _locked(file: TextIO, path: Path) -> Callable[[], object]:
    """Lock a file; returns the function that unlocks it, as does the end of the process."""
    take = _taken_beside if sys.platform == "win32" else _taken
    due = time.monotonic() + WAIT
    while True:
        try:
            return take(file, path)
        except (BlockingIOError, TimeoutError):
            if time.monotonic() > due:
                raise ValueError(
                    f"another run is writing {path}: wait until it ends, or choose another file"
                ) from None
        time.sleep(WAIT / 100)


def _taken(file: TextIO, _: Path) -> Callable[[], object]:
    """Lock the file itself, which others may still read (POSIX)."""
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a file system without locks
        return lambda: None
    return lambda: fcntl.flock(file, fcntl.LOCK_UN)  # forked copies of this process share the lock


def _taken_beside(_: TextIO, path: Path) -> Callable[[], object]:
    """Lock ``<name>.lock``, removed later: on Windows a lock on the file itself bars readers."""
    from filelock import FileLock

    lock = FileLock(f"{path}.lock", timeout=0)
    with suppress(NotImplementedError):  # a file system without locks
        lock.acquire()
    release: Callable[[], object] = lock.release
    return release


def read(
    path: str | os.PathLike[str], *, version: int, parsed: Callable[[Entry], Any]
) -> tuple[Entry, list[Any]]:
    """The description of a run, and its entries; ValueError unless intact and of this version."""
    path = _existing(Path(path))
    data = path.read_bytes()
    lines = data[: _whole(data)].split(b"\n")[:-1]
    header = _read(lines[0], 1, path) if lines else {}
    if not isinstance(header.get(RUN), dict):
        raise ValueError(f"{path} is not the checkpoint of a run: its first line names none")
    found = header.get("version")
    if found != version:
        written = "without a number" if found is None else repr(found)
        raise ValueError(
            f"{path} holds a run in a format {written}, expected format {version}: start the run "
            "anew"
        )
    _check_digests(lines, path)
    entries = list[Any]()
    for n, line in enumerate(lines[1:], 2):
        entry = _read(line, n, path)
        try:
            entries.append(parsed(entry))
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            raise ValueError(
                f"{path}, line {n}: expected an entry of a run, got {_short(entry)}"
            ) from None
    return header[RUN], entries


def line_of(entry: Entry, before: str) -> bytes:
    """The line of an entry; ``before`` is the digest of the line before it, empty for the first."""
    text = json.dumps(entry).encode()
    return text[:-1] + f', "digest": "{_digest(text, before)}"}}\n'.encode()


def _digest(text: bytes, before: str) -> str:
    return hashlib.blake2b(before.encode() + text, digest_size=DIGEST).hexdigest()


def _digest_of(line: bytes) -> str:
    """The digest that a line states; empty if none."""
    found = TAIL.search(line)
    return "" if found is None else found[1].decode()


def _check_digests(lines: Sequence[bytes], path: Path) -> None:
    """Raise ValueError at the first line whose digest does not match it and the lines before."""
    before = ""
    for n, line in enumerate(lines, 1):
        stated = _digest_of(line)
        if not stated or _digest(TAIL.sub(b"}", line), before) != stated:
            raise ValueError(
                f"{path}, line {n}: this is not what was written: the line was changed, or lines "
                "before it are missing or doubled; keep what comes before it to go on from there"
            )
        before = stated


def _existing(path: Path) -> Path:
    if not path.exists():
        raise ValueError(f"there is no saved run: {path} does not exist")
    return path


def _read(line: bytes, n: int, path: Path) -> Entry:
    try:
        entry = json.loads(line)
    except (RecursionError, ValueError) as error:  # no JSON, or no text
        raise ValueError(f"{path}, line {n}: not the checkpoint of a run: {error}") from None
    if not isinstance(entry, dict):
        raise ValueError(f"{path}, line {n}: expected an entry of a run, got {_short(entry)}")
    entry.pop("digest", None)
    return entry


def _short(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _whole(data: bytes) -> int:
    """Number of bytes up to the end of the last complete line."""
    return data.rfind(b"\n") + 1


def _compare(old: Entry, new: Entry, path: Path) -> None:
    for key in {**old, **new}:
        same = _close if key in (START, MAP) else operator.eq
        if not same(old.get(key, _MISSING), new.get(key, _MISSING)):
            raise ValueError(f"cannot resume {path}: {_difference(key, old, new, same)}")


def _difference(
    key: str, old: Entry, new: Entry, same: Callable[[object, object], bool], within: str = ""
) -> str:
    """Say which value differs first between two descriptions, by name, and how."""
    name = f"{key}{within}"
    if key not in new:
        return f"there {name} is {_short(old[key])}, now there is none"
    if key not in old:
        return f"there is no {name} there, now it is {_short(new[key])}"
    one, other = old[key], new[key]
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return f"there {name} is {one}, now it is {other}"
    inner = next(
        k for k in {**one, **other} if not same(one.get(k, _MISSING), other.get(k, _MISSING))
    )
    return _difference(inner, one, other, same, f" of {name}")


def _close(old: object, new: object) -> bool:
    """Whether values, nested in lists and dicts, agree; floats up to ``SAME``."""
    if isinstance(old, dict) and isinstance(new, dict):
        return old.keys() == new.keys() and all(_close(old[k], new[k]) for k in old)
    if isinstance(old, list) and isinstance(new, list):
        return len(old) == len(new) and all(map(_close, old, new))
    if isinstance(old, float) and isinstance(new, float):
        return abs(old - new) <= SAME * max(1.0, abs(old))
    return old == new
