"""Bifurcations of cycles along one parameter: where they are, what happens, and to which cycles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

from pwmap.diagrams.diagram import PointKind
from pwmap.maps.cylinders import minimal_period
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.maps.words import Word
from pwmap.parameters.axis import Axis
from pwmap.parameters.bifurcations import classify, lowest
from pwmap.parameters.branches import Continuation, Junction
from pwmap.parameters.cells import Cell
from pwmap.parameters.curves import connected


class Event(NamedTuple):
    """What happens to cycles, and to which.

    Attributes
    ----------
    kind
        Of the special points of a diagram.
    note
        What it says beside that, such as "fold" or "persistence".
    words
        Of the cycles, each from its first letter in the alphabet on.
    """

    kind: PointKind
    note: str
    words: tuple[str, ...]


class Mark(NamedTuple):
    """A place on an axis at which something happens."""

    place: Any
    event: Event


def marks(map_: PiecewiseLinearMap, axis: Axis, cells: list[Cell]) -> list[Mark]:
    """All bifurcations of cycles along an axis, from left to right, each cycle once.

    Where jumps alone end nothing happens to a cycle; that is left out. So is what happens to
    intervals of points of twice a period right where a multiplier is -1: the cycle itself says it.
    """
    ends = cells[0].lower, cells[-1].upper
    continuation = Continuation(axis, cells, len(map_.chain), ends)
    segments = continuation.segments()
    stops = continuation.stops
    found: dict[tuple[Any, tuple[str, ...]], list[tuple[PointKind, str]]] = defaultdict(list)
    for junction in connected(segments, continuation.junctions(segments), stops)[1]:
        if junction.place in stops:
            continue
        kind, note = classify(junction, at_span_end=False)
        own = _own(junction)
        if kind is not PointKind.EP and all(minimal_period(word) == len(word) for word in own):
            words = {_first_turn(word, len(map_.chain)) for word in own}
            spelled = tuple(sorted(map(map_.spelled, words)))
            found[junction.place, spelled].append((kind, note))
    return [
        Mark(place, Event(*_joined(happening), words))
        for (place, words), happening in found.items()
    ]


def _joined(happening: Sequence[tuple[PointKind, str]]) -> tuple[PointKind, str]:
    """What happens to a cycle, from what does at its points: a fold-flip is more than a border."""
    kinds = dict.fromkeys(kind for kind, _ in happening)
    kind = PointKind.FF if PointKind.FF in kinds else next(iter(kinds))
    notes = {note for each, note in happening if each is kind and note}
    return kind, " and ".join(sorted(notes))


def _own(junction: Junction) -> set[Word]:
    """Words of the periodic points of lowest order that a junction joins."""
    order = lowest(junction.ends)
    return {end.segment.key.word for end in junction.ends if end.is_fixed and end.length == order}


def _first_turn(word: Word, step: int) -> Word:
    """The first of the words of a cycle in the alphabet."""
    return min(word[i:] + word[:i] for i in range(0, len(word), step))
