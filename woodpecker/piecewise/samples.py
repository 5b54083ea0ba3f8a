"""Samples of branches, and the arcs that they make up.

An *arc* is a part of a branch along which no piece changes. It ends where a condition holds: a
margin vanishes, an orbit leaves the window, the branch turns round.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from pwmap.diagrams.diagram import BranchKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.jumps import Jump
from woodpecker.piecewise.orbits import Margin, Orbit, shifts
from woodpecker.piecewise.settings import Settings


class Stop(Enum):
    """Why an arc ends."""

    BORDER = "a margin vanishes"
    FOLD = "the branch turns round"
    FLIP = "the multiplier is -1"
    BRANCHING = "another branch crosses"
    LIMIT = "a limit of the jump meets the diagonal"
    TAIL = "a limit of the jump meets a border"
    SPAN = "end of the parameter span"
    WINDOW = "end of the window"
    CLOSED = "the branch closes"
    OTHER_PIECE = "the map takes another piece"
    SHORT = "steps become too short"
    MANY = "as many samples as allowed"
    SPENT = "as many evaluations as allowed"
    ASKED = "stopped as asked"


class BranchState(NamedTuple):
    """What a rule to stop sees of a place on a branch.

    Attributes
    ----------
    kind, order
        Cycles of P_order, or jumps of it.
    parameter
        The parameter.
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


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """An orbit of a branch, and the way it goes.

    Attributes
    ----------
    orbit
        The orbit.
    tangent
        (n + 1,) in scaled unknowns, forward.
    forward
        Whether this is the sign of :func:`woodpecker.piecewise.orbits.tangent`; it changes at
        branch points.
    jump
        The jump at the end of a border orbit, if one is followed.
    """

    orbit: Orbit
    tangent: Floats
    forward: bool = True
    jump: Jump | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """Orbits of a branch whose pieces do not change.

    Attributes
    ----------
    samples
        From the start to the end, at least one.
    stop
        Why it ends.
    margins
        Which margins vanish at the end.
    inner, meeting
        Of a jump: which of its limits meets the diagonal or a border there, and the orbit up to
        that place.
    step
        The last step: the next arc may begin with it.
    beyond
        Where the branch goes on if it turns round too sharply for steps.
    """

    samples: tuple[Sample, ...]
    stop: Stop
    margins: tuple[Margin, ...] = ()
    inner: bool = True
    meeting: Orbit | None = None
    step: float = math.inf
    beyond: Sample | None = None

    @property
    def end(self) -> Orbit:
        """The last orbit."""
        return self.samples[-1].orbit


def angle(one: Floats, other: Floats) -> float:
    """Angle [rad] between two unit vectors."""
    return math.acos(min(1.0, max(-1.0, float(one @ other))))


def falls(one: Sample, other: Sample, settings: Settings) -> bool:
    """Whether a step leads from a cycle to one of smaller period, passed several times over.

    Where a cycle doubles, or meets a border with one of smaller period, its points come together
    too, but at the rate at which they did before. On a branch of smaller period they stay together.
    """
    x, same = other.orbit.x, settings.same * settings.x_scale
    for d in shifts(len(x))[:-1]:
        if np.abs(np.roll(x, -d) - x).max() > same:
            continue
        before, after = (
            float(np.abs(np.roll(along, -d) - along).max())
            for along in (one.tangent[:-1], other.tangent[:-1])
        )
        if before > settings.kink and after <= settings.numerics.together * before:
            return True
    return False
