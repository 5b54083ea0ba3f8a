"""What the journal of a search holds: branches as they are finished, and what was done.

A search is followed by what it has added, in order; reading the lines again puts it back where it
was, without a single evaluation of the map. So a run that is interrupted, or killed, loses nothing
but the branch that was being followed, and goes on to the same result.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import Any

from pwmap.diagrams.diagram import BranchKind, PointKind
from woodpecker.base.checkpoint import Checkpoint, Entry, checked_number, checked_type
from woodpecker.base.checkpoint import read as read_checkpoint
from woodpecker.piecewise.borders import Edge
from woodpecker.piecewise.maps import Evaluation
from woodpecker.piecewise.network import Sample

PATH, DONE, SLICE = "path", "done", "slice"  # kinds of entries, by their first key
VERSION = 1  # of the lines below; raised when older code would misread them


class Journal(Checkpoint):
    """The checkpoint of a search, see :class:`woodpecker.base.checkpoint.Checkpoint`."""

    def __init__(self, path: str | os.PathLike[str], run: Entry, *, resume: bool = False) -> None:
        super().__init__(path, run, version=VERSION, check=_check, resume=resume)


def read_journal(path: str | os.PathLike[str]) -> tuple[Entry, list[Entry]]:
    """What a journal says of its run, and its entries so far; ValueError if it is none."""
    return read_checkpoint(path, version=VERSION, check=_check)


def _check(entry: Entry) -> None:
    """Raise one of the errors of a lookup unless an entry is what :meth:`Journal.write` writes."""
    if PATH in entry:
        runs, _, _ = to_runs(entry)
        if any(not run or run[0].kind is None for run in runs):
            raise ValueError("a run begins at a special point")
    elif DONE in entry:
        checked_type(entry[DONE], str)
        checked_type(entry["order"], int)
    else:
        kinds = {SLICE: float, "unresolved": float, "order": int, "evaluations": int, "steep": int}
        for key, kind in kinds.items():
            checked_type(entry[key], kind)
        checked_type(entry["new"], bool)
        for p, x in entry["failed"]:
            checked_number(p), checked_number(x)


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
    checked_type(entry["order"], int)
    for text in entry["words"]:
        checked_type(text, str)
    runs = [list(_samples(rows, entry["words"])) for rows in entry["runs"]]
    return runs, BranchKind(entry[PATH]), entry["order"]


def _samples(rows: list[list[Any]], words: list[str]) -> Iterator[Sample]:
    for p, x, multiplier, word, *special in rows:
        kind, note, inner, edge = special or (None, "", 0, None)
        yield Sample(
            checked_number(p), checked_number(x), checked_number(multiplier), words[word],
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
