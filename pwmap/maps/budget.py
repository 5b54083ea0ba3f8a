"""How much may be computed, and how far a computation is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """Limits of a computation; counts, so that they are the same on every machine.

    Attributes
    ----------
    pieces
        Of one iterate of a map; of a diagram, of all iterates in all cells together. So many take
        about a minute and half a gigabyte.
    letters
        Of a word. What follows a word takes time in proportion to its square.
    """

    pieces: int = 500_000
    letters: int = 10_000


BUDGET = Budget()


class BudgetError(ValueError):
    """A budget is used up."""


class Progress(NamedTuple):
    """What was completed: the last order, with its cells, edges included, and all pieces so far."""

    order: int
    cells: int
    pieces: int


Report = Callable[[Progress], None]


def checked_size(order: int, maps: int, budget: Budget = BUDGET) -> None:
    """Refuse an iterate of a composition of some maps whose words would be too long.

    Raises
    ------
    BudgetError
        With the length they would have.
    """
    letters = order * maps
    if letters > budget.letters:
        raise BudgetError(
            f"the iterate of order {order} is too large: each of its pieces would have a word of "
            f"{letters} letters, at most {budget.letters} are allowed"
        )
