"""What ends a branch: special points, and how well they are located."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A cycle that meets a border: all that must be known to follow what starts there.

    Its pieces are no part of it: the map is asked for them, so that what starts there does not
    depend on how the collision was met, or on whether a run was interrupted since.

    Attributes
    ----------
    p, x
        The parameter, and the points (n,) of the cycle, of minimal period.
    kinds
        For each point of the orbit the code of the special point, and whether branches fold or
        persist: the jump of P_n at one point can lie on the other side than that at the next.
    cause
        A sentence on what happens there.
    precision
        How well the parameter is located.
    """

    p: float
    x: Floats
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str
    precision: float

    def kind_at(self, x: float) -> tuple[PointKind, str]:
        """Code and note at the point nearest to a place."""
        return self.kinds[int(np.argmin(np.abs(self.x - x)))]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """What ends a branch.

    Attributes
    ----------
    kind, note, cause
        The code of the special point, what it leaves open, and a sentence on what happens there.
    p, x
        Parameter, and the points (n,) of the orbit; of a jump the first one only counts.
    precision
        How well the parameter is located; 0 at an end of the span.
    status
        Whether it is located, or the branch was given up here.
    collision
        The cycle that meets a jump, if one does.
    """

    kind: PointKind
    p: float
    x: Floats
    note: str = ""
    cause: str = ""
    precision: float = 0.0
    status: PointStatus = PointStatus.LOCATED
    collision: Collision | None = None

    def at(self, x: float) -> End:
        """The same as one of the points of its orbit sees it."""
        if self.collision is None:
            return self
        kind, note = self.collision.kind_at(x)
        return replace(self, kind=kind, note=note)
