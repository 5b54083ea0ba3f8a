"""What the checkpoint of a run holds: curves, and which special points and slices are finished.

A network is followed by what it has added, in order; adding it again puts it back where it was. A
run that goes on takes over the slices that were finished as a whole. What was followed since is
taken over step by step, where the search comes to it again: it makes every decision with the same
branches known as the run that was interrupted.
"""

from __future__ import annotations

import base64
import json
import os
from collections import deque
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.base.checkpoint import Checkpoint, Entry, checked_number, checked_type, read
from woodpecker.base.settings import Settings
from woodpecker.engine.germs import sides
from woodpecker.engine.line import LineMap
from woodpecker.engine.tracing import Change
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search.curves import BranchCurve, Word
from woodpecker.search.ends import Collision, End
from woodpecker.search.explorer import Finished, Kept, Seen, Step
from woodpecker.search.network import Network
from woodpecker.search.search import Past

CURVES, DONE, SWITCHED, SLICE = "curves", "done", "switched", "slice"  # kinds of entries
COST = "evaluations"  # beside all but a slice, which has its own
STARTS = "starts"  # of a special point that is done
VERSION = 6  # of the lines below; raised when older code would misread them


class Record:
    """A checkpoint of a run, written as curves and collisions are finished.

    Parameters
    ----------
    path, run, resume
        See :class:`woodpecker.base.checkpoint.Checkpoint`.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, from_sympy
    >>> from woodpecker.search.diagrams import whole_diagram
    >>> from woodpecker.search import Record
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings, few = Settings(span=(-1, 2), window=(-3, 3)), Search(slices=4)
    >>> record = Record("lines.jsonl", {"map": "lines"})
    >>> found = whole_diagram(lines, settings, search=few, record=record)
    >>> record.close()
    >>> again = Record("lines.jsonl", {"map": "lines"}, resume=True)  # goes on, or has all
    >>> len(again.entries) > 0
    True
    >>> again.close()
    """

    def __init__(self, path: str | os.PathLike[str], run: Entry, *, resume: bool = False) -> None:
        self._file = Checkpoint(path, run, version=VERSION, check=check_entry, resume=resume)
        self.entries, self.path = self._file.entries, self._file.path

    def followed(self, curves: Sequence[BranchCurve], evaluations: int = 0) -> None:
        """Keep the curves that a task has come to.

        Parameters
        ----------
        curves
            The curves.
        evaluations
            How often the map was evaluated for them.
        """
        self._file.write({CURVES: [_of_curve(curve) for curve in curves], COST: evaluations})

    def done(self, met: Collision | End, starts: int, evaluations: int = 0) -> None:
        """Keep that all that starts at the next special point was followed.

        Parameters
        ----------
        met
            The special point.
        starts
            How many branches start there.
        evaluations
            How often the map was evaluated to know that.
        """
        kind = DONE if isinstance(met, Collision) else SWITCHED
        self._file.write({kind: met.p, STARTS: starts, COST: evaluations})

    def seen(self, found: Seen) -> None:
        """Keep that all that a slice shows was followed.

        Parameters
        ----------
        found
            What the slice shows.
        """
        self._file.write({SLICE: found._asdict()})

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_record(path: str | os.PathLike[str]) -> tuple[Entry, list[Entry]]:
    """What a checkpoint says of its run, and its entries so far; ValueError if it is none."""
    return read(path, version=VERSION, check=check_entry)


def restore(
    network: Network, entries: Sequence[Entry], path: str | os.PathLike[str],
    map_: PiecewiseMap | None = None,
) -> tuple[tuple[Seen, ...], int]:  # fmt: skip
    """Put a network to where a checkpoint says it was; with a map if it is a run of that map.

    Returns
    -------
    The slices that were finished, and how often the map was evaluated for all of this.

    Raises
    ------
    ValueError
        If an entry does not follow from those before it, or branches start at a collision that is
        none of the map.
    """
    slices, evaluations = list[Seen](), 0
    for line, entry in enumerate(entries, 2):
        evaluations += entry[SLICE][COST] if SLICE in entry else entry[COST]
        if SLICE in entry:
            slices.append(_slice(entry[SLICE]))
        elif CURVES in entry:
            for curve in _curves(entry):
                network.add(curve)
        else:
            kind = DONE if DONE in entry else SWITCHED
            waiting: deque[Any] = network.waiting if kind == DONE else network.switches
            if not waiting or waiting[0].p != entry[kind]:
                raise ValueError(
                    f"{Path(path)}, line {line}: nothing is left to follow at {entry[kind]}"
                )
            met = waiting.popleft()
            starts = kind == DONE and entry[STARTS] > 0
            if starts and map_ is not None and not _is_of_map(met, map_, network.settings):
                raise ValueError(
                    f"{Path(path)}, line {line}: expected a collision of this map, got one at "
                    f"x = {met.x[0]}, p = {met.p}, where no piece ends"
                )
    return tuple(slices), evaluations


def past_of(
    network: Network, entries: Sequence[Entry], path: str | os.PathLike[str], map_: PiecewiseMap
) -> Past:
    """What an interrupted run had come to; its network is put to where it was at the last slice."""
    until = max((n for n, entry in enumerate(entries, 1) if SLICE in entry), default=0)
    slices, evaluations = restore(network, entries[:until], path, map_)
    return Past(slices, tuple(map(_step, entries[until:])), evaluations)


def _step(entry: Entry) -> Step:
    if CURVES in entry:
        return Kept(_curves(entry), entry[COST])
    return Finished(entry[DONE if DONE in entry else SWITCHED], entry[COST])


def _is_of_map(met: Collision, map_: PiecewiseMap, settings: Settings) -> bool:
    """Whether pieces of a map end where a cycle of it is said to meet a border."""
    line, p = LineMap(map_, settings.x_scale, settings.p_scale), np.array([met.p])
    lengths = np.array([settings.x_scale, settings.p_scale])
    return any(len(sides(line, np.array([x]), p, lengths)) > 1 for x in met.x)


def check_entry(entry: Entry) -> None:
    """Raise one of the errors of a lookup unless an entry is what :class:`Record` writes."""
    for kind in (DONE, SWITCHED):
        if kind in entry:
            checked_number(entry[kind])
            checked_type(entry[STARTS], int)
            checked_type(entry[COST], int)
            return
    if SLICE in entry:
        _slice(entry[SLICE])
        return
    _curves(entry)
    checked_type(entry[COST], int)


def _slice(data: Entry) -> Seen:
    left = tuple((order, checked_number(x)) for order, x in data["left"])
    for value in (*data["new"], *(order for order, _ in left), data["evaluations"]):
        checked_type(value, int)
    return Seen(
        p=checked_number(data["p"]), new=tuple(data["new"]), left=left,
        unresolved=checked_number(data["unresolved"]), evaluations=data["evaluations"],
        then=tuple(map(checked_number, data["then"])),
    )  # fmt: skip


# --- Curves ---------------------------------------------------------------------------------------


def _of_curve(curve: BranchCurve) -> Entry:
    return {
        "kind": curve.kind.value,
        "order": curve.order,
        "parameter": curve.parameter.tolist(),
        "points": [points.tolist() for points in curve.points],
        "multiplier": curve.multiplier.tolist(),
        "words": [[word.first, word.text, _of_key(word.keys)] for word in curve.words],
        "marks": [list(mark) for mark in curve.marks],
        "ends": [_of_end(end) for end in curve.ends],
    }


def _curves(entry: Entry) -> tuple[BranchCurve, ...]:
    return tuple(map(_curve, entry[CURVES]))


def _curve(data: Entry) -> BranchCurve:
    checked_type(data["order"], int)
    parameter, multiplier = _floats(data["parameter"]), _floats(data["multiplier"])
    points = tuple(_floats(row) for row in data["points"])
    if not len(parameter) == len(multiplier) == len(points) > 0:
        raise ValueError("a curve has as many points as parameters")
    words = tuple(_word(*row) for row in data["words"])
    first, last = data["ends"]
    return BranchCurve(
        kind=BranchKind(data["kind"]), order=data["order"], parameter=parameter, points=points,
        multiplier=multiplier, words=words,
        marks=tuple(_mark(*row) for row in data["marks"]),
        ends=(_end(first), _end(last)),
    )  # fmt: skip


def _word(first: int, text: str, keys: Any) -> Word:
    _typed([first, text], int, str)
    return Word(first, text, _key(keys))


def _mark(sample: int, cause: str, smooth: bool) -> Change:
    _typed([sample, cause, smooth], int, str, bool)
    return Change(sample, cause, smooth)


def _of_end(end: End) -> Entry:
    return {
        "kind": end.kind.value,
        "p": end.p,
        "x": end.x.tolist(),
        "note": end.note,
        "cause": end.cause,
        "precision": end.precision,
        "status": end.status.value,
        "collision": None if end.collision is None else _of_collision(end.collision),
    }


def _end(data: Entry) -> End:
    note, cause = _typed([data["note"], data["cause"]], str, str)
    met = data["collision"]
    return End(
        kind=PointKind(data["kind"]), p=checked_number(data["p"]), x=_floats(data["x"]), note=note,
        cause=cause, precision=checked_number(data["precision"]),
        status=PointStatus(data["status"]), collision=None if met is None else _collision(met),
    )  # fmt: skip


def _floats(values: Any) -> Floats:
    return np.array([checked_number(value) for value in values])


def _typed(values: Sequence[Any], *types: type) -> Sequence[Any]:
    for value, kind in zip(values, types, strict=True):
        checked_type(value, kind)
    return values


# --- Keys of pieces -------------------------------------------------------------------------------


def _of_key(key: Hashable) -> Any:
    """A key as JSON."""
    match key:
        case bytes():
            return {"bytes": base64.b64encode(key).decode()}
        case tuple():
            return {"tuple": [_of_key(part) for part in key]}
        case frozenset():
            return {"set": sorted((_of_key(part) for part in key), key=json.dumps)}
        case str() | int():
            return key
    raise TypeError(f"a run can be kept only if keys of pieces are bytes, text or integers: {key}")


def _key(data: Any) -> Any:
    """A key from JSON."""
    if not isinstance(data, dict):
        checked_type(data, (str, int))
        return data
    ((kind, value),) = data.items()
    match kind:
        case "bytes":
            return base64.b64decode(value, validate=True)
        case "tuple":
            return tuple(_key(part) for part in value)
        case "set":
            return frozenset(_key(part) for part in value)
    raise ValueError(f"unknown kind of key {kind!r}")


# --- Collisions -----------------------------------------------------------------------------------


def _of_collision(met: Collision) -> Entry:
    """The cycle, and what each of its points is."""
    return {
        "x": met.x.tolist(),
        "p": met.p,
        "kinds": [[kind.value, note] for kind, note in met.kinds],
        "cause": met.cause,
        "precision": met.precision,
    }


def _collision(data: Entry) -> Collision:
    _typed([data["cause"]], str)
    met = Collision(
        p=checked_number(data["p"]), x=_floats(data["x"]), cause=data["cause"],
        precision=checked_number(data["precision"]),
        kinds=tuple((PointKind(kind), *_typed([note], str)) for kind, note in data["kinds"]),
    )  # fmt: skip
    if not 0 < len(met.x) == len(met.kinds):
        raise ValueError("a collision has a kind for each of its points")
    return met
