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

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, Budget, bifurcation_diagram
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"]
    ... )
    >>> few = Budget(pieces=40)
    >>> diagram = bifurcation_diagram(p1.at({"a": "5/4"}), "r", (-1, 4), range(1, 9), budget=few)
    >>> diagram.given
    ('stopped after orders 1..2: order 3 takes more than 40 pieces in all cells',)
    """

    pieces: int = 500_000
    letters: int = 10_000


BUDGET = Budget()


class BudgetError(ValueError):
    """A budget is used up.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, BudgetError
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> try:
    ...     p1.iterate(10**6)
    ... except BudgetError as error:
    ...     print(error)
    the iterate of order 1000000 is too large: each of its pieces would have a word of 1000000
    letters, at most 10000 are allowed
    """


class Progress(NamedTuple):
    """What was completed: the last order, with its cells, edges included, and all pieces so far.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, bifurcation_diagram
    >>> p1 = PiecewiseLinearMap.from_sympy(
    ...     "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"]
    ... )
    >>> seen = []
    >>> at_a = p1.at({"a": "5/4"})
    >>> diagram = bifurcation_diagram(at_a, "r", (-1, 4), orders=(1, 2), progress=seen.append)
    >>> seen[-1]
    Progress(order=2, cells=7, pieces=34)
    """

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
