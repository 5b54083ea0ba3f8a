"""What ends a branch: special points, and how well they are located."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

import numpy as np

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.orbits import Closed, Condition, Coordinate, Margin, Orbit, blurred
from woodpecker.piecewise.samples import Arc, Stop
from woodpecker.piecewise.settings import Settings

GIVEN_UP = frozenset({Stop.SHORT, Stop.OTHER_PIECE, Stop.MANY, Stop.SPENT})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """A cycle that meets a jump: all that must be known to follow what starts there.

    Its pieces are no part of it: the map is asked for them, right inside the border, so that what
    starts there does not depend on how the collision was met, or on whether a run was interrupted
    since.

    Attributes
    ----------
    p, x
        The parameter, and the points (n,) of the cycle, of minimal period.
    margin
        Which of its points lies on the border, and which margin of its piece vanishes there.
    side
        On which side of the border the piece inside lies, +1 or -1.
    key
        The key of the piece inside.
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
    margin: Margin
    side: int
    key: Hashable
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
        How well the parameter is located, if that is known already; else 0.
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


def end_at(
    kind: PointKind, orbit: Orbit, note: str = "", cause: str = "",
    status: PointStatus = PointStatus.LOCATED,
) -> End:  # fmt: skip
    """A special point that is no collision with a jump."""
    return End(kind=kind, p=orbit.p, x=orbit.x, note=note, cause=cause, status=status)


def end_of(met: Collision, orbit: Orbit) -> End:
    """A collision with a jump, as an orbit meets it."""
    kind, note = met.kind_at(float(orbit.x[0]))
    return End(
        kind=kind, p=orbit.p, x=orbit.x, note=note, cause=met.cause, precision=met.precision,
        collision=met,
    )  # fmt: skip


def located_to(orbit: Orbit, conditions: tuple[Condition, Condition], settings: Settings) -> float:
    """How well the parameter of an orbit is known that obeys two conditions."""
    return max(blurred(orbit, conditions, settings), settings.rounded_p(orbit.p))


def folded(end: End, orbit: Orbit, closing: Condition, settings: Settings) -> End:
    """A fold with its precision: an error of x changes its parameter by the square only."""
    held = Coordinate(0, float(orbit.x[0]))
    return replace(end, precision=located_to(orbit, (closing, held), settings))


def given_up_or_left(arc: Arc, settings: Settings) -> End:
    """Where a branch leaves the span or the window, closes, or was given up."""
    status = PointStatus.OPEN if arc.stop in GIVEN_UP else PointStatus.LOCATED
    stop, orbit, jump = arc.stop.value, arc.end, arc.samples[-1].jump
    end = end_at(PointKind.EP, orbit, stop, stop, status)
    if arc.stop is not Stop.WINDOW:
        return end
    closing = Closed() if jump is None else jump.closing
    i = int(np.argmin(np.min([np.abs(orbit.x - limit) for limit in settings.window], axis=0)))
    conditions = (closing, Coordinate(i, float(orbit.x[i])))
    return replace(end, precision=located_to(orbit, conditions, settings))
