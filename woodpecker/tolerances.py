"""Every tolerance of shooting and continuation, each with its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """Tolerances on angles [rad] unless said otherwise.

    Parameters
    ----------
    residual
        |P_j(x) - x| of an accepted fixed point. The map is good to 1e-14 or so; two orders more
        leave room for steep slopes.
    resolution
        Spacing of doubles near 1: a fixed point on a flank of slope s cannot have a residual below
        ``resolution * |s|``.
    jump
        One-sided limits closer than this count as one value. A square-root singularity changes by
        about 1e-8 over one spacing of doubles; real jumps are of the order of 0.01 to 1.
    edge
        Step of continuation below which a branch is said to have reached an edge of its piece; the
        edge is then bisected to the last bit.
    landing
        First offset in the parameter on the other side of an edge: far above rounding, far below
        the size of any piece worth drawing.
    """

    residual: float = 1e-12
    resolution: float = 2.0**-52
    jump: float = 1e-6
    edge: float = 1e-9
    landing: float = 1e-7

    def allowed(self, slope: float) -> float:
        """Largest residual of an accepted fixed point on a piece of this slope."""
        if not math.isfinite(slope):
            return self.residual
        return max(self.residual, 4.0 * self.resolution * abs(slope))


DEFAULT = Tolerances()
