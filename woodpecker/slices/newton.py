"""Newton's method, whatever its unknowns belong to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from woodpecker.base.settings import Settings
from woodpecker.engine.newton import LEAD_AWAY, STEPS

# Below this length [scaled] steps that become no shorter are as good as converged: rounding of an
# ill-conditioned orbit, five digits above the usual.
NO_SHORTER = 1e-10
# Times ``converged``, at most, of a last step that shrinks slowly, and roundings that may be left
# of an equation: two bits above the shortest step.
ROUNDINGS = 64.0


class Defined(Protocol):
    """What may have no value."""

    @property
    def defined(self) -> bool:
        """Whether it has."""


T = TypeVar("T", bound=Defined)


def newton(
    start: T,
    step: Callable[[T], Sequence[float]],
    shifted: Callable[[T, Sequence[float]], T],
    is_rounded: Callable[[T], bool],
    settings: Settings,
    *,
    contracts: bool = False,
) -> tuple[T, bool, int]:
    """Go from a guess to a solution by steps, in scaled unknowns.

    A step that leads where there is no value is halved. The last step is so short that the next, if
    it shrinks no faster than the last one, would be rounding.

    Parameters
    ----------
    start
        The guess; it has a value.
    step
        Newton's step from a place; not finite if the equations are singular there.
    shifted
        A place after a step.
    is_rounded
        Whether nothing is left of the residuals but rounding.
    settings
        How short the last step is.
    contracts
        Give up as soon as a step is much longer than the one before: near a solution none is.

    Returns
    -------
    The last place, whether it solves the equations, and how many steps were taken.
    """
    place, before, halvings = start, 0.0, 0
    for k in range(STEPS):
        move = step(place)
        if not all(map(math.isfinite, move)):
            return place, False, k
        length = max(map(abs, move))
        if 0.0 < before <= length <= NO_SHORTER and is_rounded(place):
            return place, True, k
        if contracts and before > 0.0 and length > LEAD_AWAY * before:
            return place, False, k
        trial = shifted(place, move)
        while not trial.defined and halvings < STEPS:
            move, halvings = [0.5 * each for each in move], halvings + 1
            trial = shifted(place, move)
        if not trial.defined:
            return place, False, k
        place = trial
        if length <= settings.converged or length * length <= settings.converged * before:
            return place, True, k + 1
        before = length
    return place, before <= ROUNDINGS * settings.converged, STEPS
