"""Checkpoints of a run: its curves, and which special points and slices are finished.

Adding the same curves in the same order restores the network. What was followed after the last
whole slice is taken over only when the search comes to it again, so that every decision is made
with the same branches known as in the interrupted run.
"""

from __future__ import annotations

import os
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pwmap.diagrams.encoding import from_plain, to_plain
from woodpecker.base.checkpoint import Checkpoint, Entry, read
from woodpecker.search.curves import BranchCurve, End, Keys
from woodpecker.search.network import Network


class Seen(NamedTuple):
    """A slice that was taken, and what was found from it.

    Attributes
    ----------
    p, evaluations
        Where it was taken, and how often the map was evaluated for it.
    new
        Orders of the branches that were found from it.
    unresolved
        Total length of intervals in which not all pieces were resolved.
    left
        (order, x) of orbits that no branch explains, though one was followed from there or as the
        search had come to a bound.
    then
        Where more slices were planned because of it.

    Examples
    --------
    >>> from woodpecker import Search
    >>> from woodpecker.diagrams import bifurcation_search
    >>> from woodpecker.examples import two_lines
    >>> few = Search(slices=4)
    >>> found = bifurcation_search(two_lines(), "p", (-1, 2), window=(-3, 3), search=few)
    >>> [(seen.p, seen.new, seen.unresolved) for seen in found.slices][:2]
    [(-0.99925, (1,), 0), (1.99925, (), 0)]
    """

    p: float
    new: tuple[int, ...]
    unresolved: float
    left: tuple[tuple[int, float], ...]
    evaluations: int
    then: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """The curves followed from one place, and how often the map was evaluated for them."""

    curves: tuple[BranchCurve, ...]
    evaluations: int


@dataclass(frozen=True, slots=True)
class Finished:
    """A special point of which all branches that start there were followed."""

    p: float  # its parameter
    evaluations: int  # of the map, to find what starts there
    starts: int = 0  # how many branches start there
    switches: bool = False  # a flip or a branch point rather than a border collision


Step = Kept | Finished
"""A record of a run between two slices."""


LINES: dict[str, type] = {"followed": Kept, "done": Finished, "slice": Seen}
"""The type of the one record that a line holds, by its name there; it is encoded by its types."""
VERSION = 7  # of the lines; raised when older code would misread them


class Record:
    """A checkpoint of a run, written as curves, special points and slices are finished.

    Parameters
    ----------
    path, run, resume
        See :class:`woodpecker.base.checkpoint.Checkpoint`.

    Examples
    --------
    >>> from woodpecker.search import Record
    >>> Record("lines.jsonl", {"map": "lines"}).close()
    >>> again = Record("lines.jsonl", {"map": "lines"}, resume=True)  # goes on with the run
    >>> again.entries, again.close()
    ([], None)
    """

    def __init__(self, path: str | os.PathLike[str], run: Entry, *, resume: bool = False) -> None:
        self._file = Checkpoint(path, run, version=VERSION, parsed=record_of, resume=resume)
        self.path = self._file.path
        self.entries: list[Step | Seen] = self._file.entries

    def followed(self, curves: Sequence[BranchCurve], evaluations: int = 0) -> None:
        """Record the curves followed from one place.

        Parameters
        ----------
        curves
            The curves.
        evaluations
            How often the map was evaluated for them.
        """
        self._file.write(entry_of(Kept(tuple(curves), evaluations)))

    def done(self, met: End, starts: int, evaluations: int = 0) -> None:
        """Record that all branches that start at the next special point were followed.

        Parameters
        ----------
        met, starts
            The special point, and how many branches start there.
        evaluations
            How often the map was evaluated to find them.
        """
        switches = met.collision is None
        self._file.write(entry_of(Finished(met.p, evaluations, starts, switches)))

    def seen(self, found: Seen) -> None:
        """Record a slice from which everything was followed."""
        self._file.write(entry_of(found))

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def entry_of(record: Step | Seen) -> Entry:
    """The entry of a file for a record; TypeError if the key of a piece cannot be stored."""
    if isinstance(record, Kept):
        for keys in (word.keys for curve in record.curves for word in curve.words):
            _check_kept(keys)
    return {name: to_plain(record) for name, kind in LINES.items() if isinstance(record, kind)}


def record_of(entry: Entry) -> Step | Seen:
    """The record of an entry; LookupError, TypeError or ValueError if it holds none."""
    ((name, data),) = entry.items()
    record: Step | Seen = from_plain(data, LINES[name])
    for curve in record.curves if isinstance(record, Kept) else ():
        if not len(curve.parameter) == len(curve.multiplier) == len(curve.points) > 0:
            raise ValueError("a curve has as many points as parameters")
        for met in (end.collision for end in curve.ends):
            if met is not None and not 0 < len(met.x) == len(met.kinds):
                raise ValueError("a collision has a kind for each of its points")
    return record


def _check_kept(keys: Keys) -> None:
    """TypeError if keys are not the same after they are written and read."""
    try:
        same = from_plain(to_plain(keys), Hashable) == keys
    except TypeError:
        same = False
    if not same:
        raise TypeError(
            "a run can be kept only if keys of pieces are text, bytes, numbers, or tuples and sets "
            f"of these: {keys}"
        )


def read_record(path: str | os.PathLike[str]) -> tuple[Entry, list[Step | Seen]]:
    """The description of the run of a checkpoint, and its records; ValueError if it is none."""
    return read(path, version=VERSION, parsed=record_of)


def restore(network: Network, records: Sequence[Step | Seen], path: str | os.PathLike[str]) -> None:
    """Restore a network from the records of a checkpoint.

    ValueError if a record does not follow from those before it.
    """
    for line, record in enumerate(records, 2):
        if isinstance(record, Kept):
            for curve in record.curves:
                network.add(curve)
        elif isinstance(record, Finished):
            waiting = network.switches if record.switches else network.waiting
            if not waiting or waiting[0].p != record.p:
                raise ValueError(
                    f"{Path(path)}, line {line}: nothing is left to follow at {record.p}"
                )
            waiting.popleft()
