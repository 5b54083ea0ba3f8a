"""What a rule to stop sees of a branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats


class BranchState(NamedTuple):
    """What a rule to stop sees of a place on a branch.

    Attributes
    ----------
    kind, order, parameter
        Cycles of P_order, or jumps of it, and where.
    points
        (n,) points of the cycle, or those up to the border of a jump.
    multiplier
        Of the cycle; nan for a jump.
    word
        The words of the pieces.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, shoot
    >>> flips = lambda state: state.multiplier < -0.9  # state is a BranchState
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), span=(0.48, 0.7), stop=flips)
    >>> [(round(point.parameter, 9), point.note) for point in diagram.points]
    [(0.48, 'end of the parameter span'), (0.636607185, 'stopped as asked')]
    """

    kind: BranchKind
    order: int
    parameter: float
    points: Floats
    multiplier: float
    word: str

    @property
    def x(self) -> float:
        """The first point."""
        return float(self.points[0])


StopRule = Callable[[BranchState], bool]
"""Whether a branch is to end at a place."""
