"""How a search reports its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Stage(NamedTuple):
    """The progress of a search.

    Attributes
    ----------
    parameter, order
        The parameter to which a branch of P_order has been followed.
    slices, branches
        How many slices have been taken, and how many branches are known.

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


Report = Callable[[Stage], None]
