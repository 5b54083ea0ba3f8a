"""What ends a branch: special points, and how well they are located."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A cycle that meets a border.

    Its pieces are no part of it: the map is asked for them, so that what starts there does not
    depend on how the collision was met, or on an interruption.
    """

    p: float
    x: Floats  # (n,) points, of minimal period
    # code and note at each point: the jump of P_n may lie on other sides at the next
    kinds: tuple[tuple[PointKind, str], ...]
    cause: str  # a sentence on what happens there
    precision: float  # of the parameter

    def kind_at(self, x: float) -> tuple[PointKind, str]:
        """Code and note at the point nearest to a place."""
        return self.kinds[int(np.argmin(np.abs(self.x - x)))]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class End:
    """What ends a branch."""

    kind: PointKind  # code of the special point
    p: float
    x: Floats  # (n,) of the orbit; of a jump the first one only counts
    note: str = ""  # what it leaves open
    cause: str = ""  # a sentence on what happens there
    precision: float = 0.0  # of the parameter; 0 at an end of the span
    status: PointStatus = PointStatus.LOCATED  # located, or the branch was given up here
    collision: Collision | None = None  # the cycle that meets a jump, if one does

    def at(self, x: float) -> End:
        """The end as one of the points of its orbit sees it: there the kind may be another one."""
        if self.collision is None:
            return self
        kind, note = self.collision.kind_at(x)
        return replace(self, kind=kind, note=note)
