"""Counts of the evaluations of a map, and bounds on them.

A bound on evaluations rather than on time gives a search the same result on every machine. It is
checked before each piece of work.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from woodpecker.base.counting import Counter
from woodpecker.maps.pieces import Image, PiecewiseMap


class Counts(Protocol):
    """An object that counts the evaluations of a map and its pieces in this thread."""

    @property
    def evaluations(self) -> int:
        """The number so far."""


@runtime_checkable
class Counting(PiecewiseMap, Counts, Protocol):
    """A map that counts its evaluations."""


class _Counted:
    """A map that counts its evaluations, but not those of its pieces."""

    def __init__(self, map_: PiecewiseMap) -> None:
        self._map, self._counter = map_, Counter()

    @property
    def evaluations(self) -> int:
        """The number so far."""
        return self._counter.evaluations

    def at(self, x: float, p: float) -> Image:
        """The image of a point."""
        self._counter.evaluations += 1
        return self._map.at(x, p)


def as_counting(map_: PiecewiseMap) -> Counting:
    """The map itself if it counts its evaluations, else one that wraps it."""
    return map_ if isinstance(map_, Counting) else _Counted(map_)


class Allowance:
    """A bound on the evaluations of a map, counted from its creation on."""

    def __init__(self, counts: Counts, most: int) -> None:
        self._counts, self._last = counts, counts.evaluations + most

    @property
    def spent(self) -> bool:
        """Whether no evaluations are left."""
        return self._counts.evaluations >= self._last
