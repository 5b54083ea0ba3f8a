"""How often a map is evaluated: counted, and bounded.

Every search ends, and on every machine with the same result: what bounds it is no time but a count
of evaluations. It is looked at where work is begun (a step along a branch, a piece of a slice, the
next branch of a network); what is begun is finished, and what is left then is said.
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
    """How often a map may be evaluated from now on.

    Parameters
    ----------
    map_
        The map.
    most
        How often.
    """

    def __init__(self, map_: Counting, most: int) -> None:
        self._map, self._last = map_, map_.evaluations + most

    @property
    def spent(self) -> bool:
        """Whether it was evaluated as often."""
        return self._map.evaluations >= self._last
