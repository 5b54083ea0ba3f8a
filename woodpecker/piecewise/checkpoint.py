"""The journal of a search: a text file that grows by one line with every branch that is finished.

A search is followed by what it has added, in order; reading the lines again puts it back where it
was, without a single evaluation of the map. So a run that is interrupted, or killed, loses nothing
but the branch that was being followed, and goes on to the same result.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TextIO

from pwmap.diagrams.diagram import BranchKind, PointKind
from pwmap.diagrams.files import write_whole
from woodpecker.piecewise.borders import Edge
from woodpecker.piecewise.maps import SAME_CYCLE, Evaluation
from woodpecker.piecewise.network import Sample

fcntl: Any
try:
    import fcntl
except ImportError:  # Windows: nothing keeps two runs from writing one file
    fcntl = None

Entry = dict[str, Any]
RUN, PATH, DONE, SLICE = "run", "path", "done", "slice"  # kinds of entries, by their first key
VERSION = 1  # of the lines below; raised when older code would misread them
START = "start"  # of a run: the points from which it sets out
WAIT = 3.0  # s: as long as the workers of a killed run may take to notice, and hold its file


class Journal:
    """Lines of JSON, each written through before the search goes on.

    Where the system locks files (not on Windows) nobody else can write the file meanwhile.

    Parameters
    ----------
    path
        The file. What is in it is kept as ``<name>.old`` unless the run is resumed.
    run
        What is searched, and how; a run can only be resumed with the same. Points to start from
        are the same if they differ by 1e-9 at most: other machines round in other ways.
    resume
        Go on with the run in the file.

    Raises
    ------
    ValueError
        If there is nothing to resume, the run in the file is another one, or it is being written.
    """

    def __init__(self, path: str | os.PathLike[str], run: Entry, *, resume: bool = False) -> None:
        self.path = Path(path)
        self.entries: list[Entry] = []
        run = json.loads(json.dumps(run))
        if resume:
            _existing(self.path)
        self._file: TextIO = self.path.open("a", encoding="utf-8")
        try:
            _lock(self._file, self.path)
            if resume:
                header, self.entries = read_journal(self.path)
                _compare(header, run, self.path)
                self._file.truncate(_whole(self.path))  # a last line that was being written
            else:
                old = self.path.read_bytes()
                if old:
                    write_whole(self.path.with_name(self.path.name + ".old"), old)
                    self._file.truncate(0)
                self.write({RUN: run, "version": VERSION})
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


def read_journal(path: str | os.PathLike[str]) -> tuple[Entry, list[Entry]]:
    """What a journal says of its run, and its entries so far.

    Raises
    ------
    ValueError
        If the file does not exist, or is not a journal of this version from the first line to the
        last that is complete.
    """
    path = _existing(Path(path))
    with path.open("rb") as file:
        lines = file.read(_whole(path)).splitlines()
    header, *entries = [_read(line, n, path) for n, line in enumerate(lines, 1)] or [{}]
    if not isinstance(header.get(RUN), dict):
        raise ValueError(f"{path} is not the journal of a run: its first line does not say which")
    version = header.get("version")
    if version != VERSION:
        written = "without a number" if version is None else repr(version)
        raise ValueError(
            f"{path} holds a run in a format {written}, expected format {VERSION}: start the run "
            "anew"
        )
    for n, entry in enumerate(entries, 2):
        try:
            _check(entry)
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


def _check(entry: Entry) -> None:
    """Raise one of the errors of a lookup unless an entry is what :meth:`Journal.write` writes."""
    if PATH in entry:
        runs, _, _ = to_runs(entry)
        if any(not run or run[0].kind is None for run in runs):
            raise ValueError("a run begins at a special point")
    elif DONE in entry:
        _typed(entry[DONE], str)
        _typed(entry["order"], int)
    else:
        kinds = {SLICE: float, "unresolved": float, "order": int, "evaluations": int, "steep": int}
        for key, kind in kinds.items():
            _typed(entry[key], kind)
        _typed(entry["new"], bool)
        for p, x in entry["failed"]:
            _number(p), _number(x)


def _typed(value: object, kind: type) -> None:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise TypeError(f"expected {kind.__name__}")


def _number(value: object) -> float:
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
            raise ValueError(
                f"cannot resume {path}: there {key} is {old.get(key)}, now it is {new.get(key)}"
            )


def _close(old: object, new: object) -> bool:
    """Whether two lists of numbers are those of one solution, rounded in different ways."""
    if not isinstance(old, list) or not isinstance(new, list) or len(old) != len(new):
        return False
    return all(
        isinstance(a, float) and abs(a - b) <= SAME_CYCLE for a, b in zip(old, new, strict=True)
    )


def of_runs(runs: Sequence[Sequence[Sample]], kind: BranchKind, order: int) -> Entry:
    """The runs of one branch as an entry; its words are written once."""
    words: dict[str, int] = {}
    table = []
    for run in runs:
        rows = []
        for s in run:
            row: list[Any] = [s.p, s.x, s.multiplier, words.setdefault(s.word, len(words))]
            if s.kind is not None:
                row += [s.kind.value, s.note, s.inner, None if s.edge is None else _of_edge(s.edge)]
            rows.append(row)
        table.append(rows)
    return {PATH: kind.value, "order": order, "words": list(words), "runs": table}


def to_runs(entry: Entry) -> tuple[list[list[Sample]], BranchKind, int]:
    """The runs of an entry."""
    _typed(entry["order"], int)
    for text in entry["words"]:
        _typed(text, str)
    runs = [list(_samples(rows, entry["words"])) for rows in entry["runs"]]
    return runs, BranchKind(entry[PATH]), entry["order"]


def _samples(rows: list[list[Any]], words: list[str]) -> Iterator[Sample]:
    for p, x, multiplier, word, *special in rows:
        kind, note, inner, edge = special or (None, "", 0, None)
        yield Sample(
            _number(p), _number(x), _number(multiplier), words[word],
            None if kind is None else PointKind(kind), note,
            None if edge is None else _to_edge(edge), inner,
        )  # fmt: skip


def _of_edge(edge: Edge) -> list[Any]:
    return [edge.x, edge.p, list(edge.left), list(edge.right), edge.left_limit, edge.right_limit]


def _to_edge(row: list[Any]) -> Edge:
    x, p, left, right, left_limit, right_limit = row
    return Edge(
        x=x, p=p, left=Evaluation(*left), right=Evaluation(*right), left_limit=left_limit,
        right_limit=right_limit,
    )  # fmt: skip
