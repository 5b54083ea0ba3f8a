"""How often a map is evaluated: counted, and bounded.

A search is bounded by a count of evaluations, not by time, so that it ends with the same result on
every machine. The count is looked at where work is begun; what is left then is said.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from woodpecker.maps.pieces import Image, PiecewiseMap


@runtime_checkable
class Counting(PiecewiseMap, Protocol):
    """A map that knows how often it and its pieces were evaluated in this thread."""

    @property
    def evaluations(self) -> int:
        """The number so far."""


class _Counted:
    """A map that counts how often it is asked for a piece; what the piece does is its own."""

    def __init__(self, map_: PiecewiseMap) -> None:
        self._map, self.evaluations = map_, 0

    def at(self, x: float, p: float) -> Image:
        """The image of a point."""
        self.evaluations += 1
        return self._map.at(x, p)


def as_counting(map_: PiecewiseMap) -> Counting:
    """The map itself if it counts its evaluations, or one that does."""
    return map_ if isinstance(map_, Counting) else _Counted(map_)


class Allowance:
    """How often a map may be evaluated from now on: at most ``most`` times."""

    def __init__(self, map_: Counting, most: int) -> None:
        self._map, self._last = map_, map_.evaluations + most

    @property
    def spent(self) -> bool:
        """Whether the map was evaluated as often as allowed."""
        return self._map.evaluations >= self._last
