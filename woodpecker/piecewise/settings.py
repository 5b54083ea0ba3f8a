"""How far and how finely branches are followed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from woodpecker.base.checks import interval, number, positive, whole
from woodpecker.piecewise.tolerances import DEFAULT, Tolerances

END_OF_SPAN = "end of the parameter span"  # why a branch ends


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How far and how finely to follow a branch.

    Parameters
    ----------
    span
        Interval of the parameter, finite; the branch ends (EP) at its ends.
    window
        Interval of x; the branch ends (EP) where it leaves it. A search for every branch needs a
        finite one.
    step, max_step
        First and largest step in arclength of (x, p).
    max_turn
        Largest angle [rad] between the tangents of neighbouring points.
    probe
        Largest distance along a step at which the word is looked at: a stretch of another word
        shorter than this can be missed.
    steepest
        Largest slope of a branch of fixed points, or of a part of its cycle: the branch ends (EP)
        where it is steeper. At 1e4 the doubles next to a fixed point miss it by up to 1e-11.
    max_points
        The branch ends (EP) after this many points.

    Raises
    ------
    ValueError
        If span or window are no two ascending numbers, or a length, an angle or a count is not
        positive.
    """

    span: tuple[float, float] = (0.0, 1.0)
    window: tuple[float, float] = (-math.inf, math.inf)
    step: float = 0.005
    max_step: float = 0.02
    max_turn: float = 0.1
    probe: float = 0.001
    steepest: float = 1e4
    max_points: int = 5000
    tolerances: Tolerances = field(default=DEFAULT)

    def __post_init__(self) -> None:
        for name in ("span", "window"):
            ends = interval(name, getattr(self, name), finite=name == "span")
            object.__setattr__(self, name, ends)
        for name in ("max_step", "max_turn", "probe"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if not 0.0 < number("step", self.step) <= self.max_step:
            raise ValueError(f"step must lie in (0, {self.max_step}], got {self.step}")
        if not number("steepest", self.steepest) > 1.0:
            raise ValueError(f"steepest must be larger than 1, got {self.steepest}")
        object.__setattr__(self, "max_points", whole("max_points", self.max_points))
