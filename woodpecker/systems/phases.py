"""A phase between two events: which guard ends it first, and how short a bounce is."""

from __future__ import annotations

import math

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.systems.flows import Flow, Step
from woodpecker.systems.guards import GuardStart, Polynomials, series
from woodpecker.systems.modes import GAP, SECTION, Local, Touch, guard_values, guards_of
from woodpecker.systems.sections import SectionGuard

CHATTER = 2.0**-26  # relative change of acceleration in a bounce below which the rest is a series
TIME = -2  # the guard of a phase that lasts to the end of time asked for


class Phase:
    """The guards of a phase, and which fires first.

    Parameters
    ----------
    here
        Its mode and the state in which it begins.
    flow
        What integrates it.
    touch
        What touches there.
    section
        The guard of a section that counts in this mode; None: none does.
    on_section
        Whether it begins on the section.

    Attributes
    ----------
    watched, starts
        The guards, and how they begin.
    width
        Of the interpolant by which the last root was found; 0 where that is as exact as doubles.
    """

    def __init__(
        self, here: Local, flow: Flow, touch: Touch, section: SectionGuard | None, *,
        on_section: bool,
    ) -> None:  # fmt: skip
        eq, mode = here.eq, here.mode
        self.mode, self.flow, self.width = mode, flow, 0.0
        self._eq, self._p, self._section = eq, here.p, section
        self.watched = guards_of(eq, mode)
        self._guards = list(self.watched)
        if self.flow.has_guards:
            self.starts = [GuardStart(touch.order(eq, mode, guard)) for guard in self.watched]
        else:
            self.starts = [started(here, touch, guard) for guard in self.watched]
        if self._section is not None:
            self.watched.append(SECTION * eq.m)
            jet = self._section.jet(here) if on_section else ()
            self.starts.append(GuardStart(int(on_section), jet, True))
        self._above: list[bool] | None = None

    def fired(self, step: Step, begin: float, ignored: int) -> tuple[int, float]:
        """The guard that fires first in a step that begins at a time, and when; TIME if none."""
        if self.flow.has_guards:
            return self._of_polynomials(step, begin, ignored)
        for window in series(step, begin, self._values, self.starts):
            best, time, self.width = TIME, math.inf, 0.0
            for guard, start, each in zip(self.watched, self.starts, window, strict=True):
                if guard == ignored:
                    continue
                early = start.soon(step.length) if begin == 0.0 else math.inf
                t = early if early < math.inf else each.falls()
                if t < time:
                    best, time = guard, t
                    self.width = 0.0 if early < math.inf else each.high - each.low
            if best != TIME:
                return best, time
        return TIME, math.inf

    def _of_polynomials(self, step: Step, begin: float, ignored: int) -> tuple[int, float]:
        best, time = TIME, math.inf
        found = Polynomials(step.length, step.guards, begin, self.starts, self._above)
        for k, (guard, low) in enumerate(zip(self.watched, found.lowest, strict=True)):
            if low <= 0.0 and guard != ignored:
                t = found[k].falls()
                if t < time:
                    best, time = guard, t
        self._above = found.ends_above()
        return best, time

    def _values(self, states: Floats) -> Floats:
        values = guard_values(self._eq, self.mode, self._guards, self._eq.terms(states, self._p))
        if self._section is None:
            return values
        return np.vstack([values, self._section.values(states, self._p)])


def short_flight(here: Local, i: int, speed: float) -> float:
    """The time of a bounce in which acceleration hardly changes; infinite if it does, or is up."""
    _, _, second, third = here.jet(GAP * here.eq.m + i)
    if not second < 0.0:
        return math.inf
    flight = -2.0 * speed / second
    if not flight * abs(third / second) <= CHATTER:
        return math.inf
    fastest = np.abs(np.linalg.eigvals(here.jacobian[:, : here.eq.size])).max()
    return flight if flight * fastest <= CHATTER else math.inf


def started(here: Local, touch: Touch, guard: int) -> GuardStart:
    """How a guard begins, where an event has made some of its derivatives zero."""
    order = touch.order(here.eq, here.mode, guard)
    return GuardStart(order, here.jet(guard) if order else ())
