"""How a search tells how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Stage(NamedTuple):
    """How far a search has come.

    Attributes
    ----------
    parameter, order
        Where a branch of P_order was followed to.
    slices, branches
        How many slices were taken, and how many branches are known.

    Examples
    --------
    >>> from woodpecker import Search, bifurcation_diagram
    >>> from woodpecker.examples import two_lines
    >>> few, seen = Search(slices=4), []
    >>> found = bifurcation_diagram(
    ...     two_lines(), "p", (-1, 2), window=(-3, 3), search=few, progress=seen.append
    ... )
    >>> seen[-1].branches
    3
    """

    parameter: float
    order: int
    slices: int
    branches: int


Progress = Callable[[Stage], None]
