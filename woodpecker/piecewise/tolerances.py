"""Every tolerance of shooting and continuation, each with its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from woodpecker.base.checks import positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """Tolerances on angles [rad] unless said otherwise.

    Parameters
    ----------
    residual
        Largest gap between a lap of an accepted cycle and its next point. The map is good to 1e-14
        or so; two orders more leave room for steep slopes.
    resolution
        Rounding of one lap, for each unit of its slope: measured on the toy it is some 5 spacings
        of doubles, and 20 at most; this is 32 of them.
    closing
        |P_j(x) - x| of every sample of a branch of fixed points.
    jump
        One-sided limits closer than this count as one value. A square-root singularity changes by
        about 1e-8 over one spacing of doubles; real jumps are of the order of 0.01 to 1.
    edge
        Step of continuation below which a branch is said to have reached an edge of its piece; the
        edge is then bisected to the last bit.
    landing
        First offset in the parameter on the other side of an edge: far above rounding, far below
        the size of any piece worth drawing.

    Raises
    ------
    ValueError
        Unless all are positive and finite.
    """

    residual: float = 1e-12
    resolution: float = 2.0**-47
    closing: float = 1e-11
    jump: float = 1e-6
    edge: float = 1e-9
    landing: float = 1e-7

    def __post_init__(self) -> None:
        for each in fields(self):
            object.__setattr__(self, each.name, positive(each.name, getattr(self, each.name)))

    def allowed(self, slope: float) -> float:
        """Largest residual of an accepted fixed point on a piece of this slope."""
        if not math.isfinite(slope):
            return self.residual
        return max(self.residual, self.resolution * abs(slope))


DEFAULT = Tolerances()
