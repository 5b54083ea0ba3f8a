"""An index of objects by the value of a parameter."""

from __future__ import annotations

import math
from typing import Generic, TypeVar

T = TypeVar("T")


class Nearby(Generic[T]):
    """Objects at values of a parameter, of which those within ``width`` of a value are found."""

    def __init__(self, width: float) -> None:
        self._width, self._count = width, 0
        self._cells: dict[int, list[tuple[int, T]]] = {}

    def add(self, p: float, thing: T) -> None:
        """Add an object at a value."""
        self._cells.setdefault(math.floor(p / self._width), []).append((self._count, thing))
        self._count += 1

    def near(self, p: float) -> list[T]:
        """All objects within ``width`` of a value, and some farther off, in order of addition."""
        cell = math.floor(p / self._width)
        found = [each for k in (cell - 1, cell, cell + 1) for each in self._cells.get(k, ())]
        return [thing for _, thing in sorted(found, key=lambda each: each[0])]
