"""The journal of a search: a text file that grows by one line with every branch that is finished.

A search is followed by what it has added, in order; reading the lines again puts it back where it
was, without a single evaluation of the map. So a run that is interrupted, or killed, loses nothing
but the branch that was being followed, and goes on to the same result.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TextIO

from pwmap.diagram import BranchKind, PointKind
from woodpecker.atlas import Sample
from woodpecker.edges import Edge
from woodpecker.labelled import Evaluation

Entry = dict[str, Any]
RUN, PATH, DONE, SLICE = "run", "path", "done", "slice"  # kinds of entries, by their first key


class Journal:
    """Lines of JSON, each written through before the search goes on.

    Parameters
    ----------
    path
        The file. A file that is there is kept as ``<name>.old`` unless the run is resumed.
    run
        What is searched, and how; a run can only be resumed with the same.
    resume
        Go on with the run in the file.

    Raises
    ------
    ValueError
        If there is nothing to resume, or the run in the file is another one.
    """

    def __init__(self, path: Path, run: Entry, *, resume: bool = False) -> None:
        self.path = path
        self.entries: list[Entry] = []
        run = json.loads(json.dumps(run))
        if resume:
            header, self.entries = read_journal(path)
            _compare(header, run, path)
        elif path.exists():
            path.replace(path.with_name(path.name + ".old"))
        self._file: TextIO = path.open("a" if resume else "w", encoding="utf-8")
        if resume:  # a last line that was being written is cut off
            self._file.truncate(_whole(path))
        else:
            self.write({RUN: run})

    def write(self, entry: Entry) -> None:
        """Append one entry and hand it to the system."""
        self._file.write(json.dumps(entry) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_journal(path: Path) -> tuple[Entry, list[Entry]]:
    """What a journal says of its run, and its entries so far."""
    if not path.exists():
        raise ValueError(f"there is no saved run: {path} does not exist")
    with path.open("rb") as file:
        lines = file.read(_whole(path)).decode("utf-8").splitlines()
    try:
        entries = [json.loads(line) for line in lines]
    except json.JSONDecodeError as error:
        raise ValueError(f"{path} is not the journal of a run: {error}") from None
    if not entries or RUN not in entries[0]:
        raise ValueError(f"{path} is not the journal of a run: its first line does not say which")
    return entries[0][RUN], entries[1:]


def _whole(path: Path) -> int:
    """Length in bytes of all lines that are complete."""
    return path.read_bytes().rfind(b"\n") + 1


def _compare(old: Entry, new: Entry, path: Path) -> None:
    for key in {**old, **new}:
        if old.get(key) != new.get(key):
            raise ValueError(
                f"cannot resume {path}: there {key} is {old.get(key)}, now it is {new.get(key)}"
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
    runs = [list(_samples(rows, entry["words"])) for rows in entry["runs"]]
    return runs, BranchKind(entry[PATH]), entry["order"]


def _samples(rows: list[list[Any]], words: list[str]) -> Iterator[Sample]:
    for p, x, multiplier, word, *special in rows:
        kind, note, inner, edge = special or (None, "", 0, None)
        yield Sample(
            p, x, multiplier, words[word], None if kind is None else PointKind(kind), note,
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
