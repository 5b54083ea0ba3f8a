"""Branches of orbits with fixed pieces: predictor, corrector, step control, and one locator.

An *arc* is a part of a branch along which no piece changes. It ends where a condition holds: a
margin vanishes, an orbit leaves the window, the branch turns round. Each such end is an orbit that
obeys that condition, found by Newton's method, not the last of some halvings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import nullcontext, suppress

from woodpecker.piecewise.border_stops import at_border, is_first
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.counting import Allowance
from woodpecker.piecewise.hairpins import round_hairpin
from woodpecker.piecewise.limit_stops import at_diagonal, at_tails, still_crosses
from woodpecker.piecewise.samples import Arc, Sample, Stop, StopRule, angle, falls
from woodpecker.piecewise.stops import (
    FOLD,
    Ending,
    Test,
    UnclearError,
    at_branch_point,
    at_ends,
    at_stop,
    at_test,
    closing_up,
    first_of,
    is_asked,
    leaves,
)

TURNS = frozenset({Stop.FOLD, Stop.FLIP})


class Stepper:
    """Follows branches of one kind.

    Parameters
    ----------
    corrector
        Finds neighbouring orbits of that kind.
    tests
        Functions whose changes of sign end an arc.
    stop
        Whether to end somewhere, if anybody asks for it.
    """

    def __init__(
        self, corrector: Corrector, tests: Sequence[Test] = (), stop: StopRule | None = None
    ) -> None:
        self.corrector, self.tests, self.stop = corrector, tuple(tests), stop
        self.settings, self.order = corrector.settings, corrector.order

    def follow(
        self, start: Sample, ignored: Stop | None = None, origin: Sample | None = None,
        first: float = math.inf, allowed: Allowance | None = None,
    ) -> Arc:  # fmt: skip
        """Follow a branch from a sample to its end.

        Parameters
        ----------
        start
            A sample; it may lie on the end of another arc.
        ignored
            What ended that one: it is not looked for in the first step.
        origin
            A sample at which the branch has come round.
        first
            The first step, if it is shorter than the usual one.
        allowed
            How often the map may be evaluated, if not as often as samples need it.
        """
        corrector = self.corrector
        stop = leaves(corrector, start) or (Stop.ASKED if is_asked(self.stop, start) else None)
        if stop is not None:
            return Arc((start,), stop)
        samples, step, grows = [start], min(first, self.settings.step), True
        retry = self.settings.numerics.retry
        while len(samples) < self.settings.max_samples:  # each pass adds one, or shortens the step
            if allowed is not None and allowed.spent:
                return Arc(tuple(samples), Stop.SPENT)
            if step < self.settings.min_step:
                short = Arc(tuple(samples), Stop.SHORT)
                return self._round_hairpin(samples, step) or short
            last = samples[-1]
            before = samples[-2] if len(samples) > 1 else None
            found = corrector.to_end(last, step) or corrector.advance(last, step, before)
            if isinstance(found, float):
                step, grows = found, False
                continue
            skipped = ignored if len(samples) == 1 else None
            try:
                ending = self._ending(last, found, step, skipped, origin)
            except UnclearError:
                step, grows = 0.5 * step, False
                continue
            if ending is not None:
                turn = self._round_hairpin(samples, step) if ending.stop in TURNS else None
                if turn is not None:
                    return turn
                return Arc(
                    (*samples, ending.sample), ending.stop, ending.margins, ending.inner,
                    ending.meeting, step,
                )  # fmt: skip
            if not corrector.agrees(found.orbit):
                if retry * step < self.settings.min_step:
                    return Arc(tuple(samples), Stop.OTHER_PIECE)
                step, grows = retry * step, False
                continue
            samples.append(found)
            turned = angle(last.tangent, found.tangent) / corrector.turn(step)
            growth, wanted = 2.0 if grows else 1.0, self.settings.numerics.kept_turn
            growth = wanted / turned if growth * turned > wanted else growth
            step, grows = min(self.settings.max_step, step * growth), True
        return Arc(tuple(samples), Stop.MANY)

    def _round_hairpin(self, samples: list[Sample], step: float) -> Arc | None:
        """An arc that ends in a fold too sharp to be followed round; None if there is none.

        Steps are as short there as the shortest, and flip and fold are one point.
        """
        if self.order or step > self.settings.numerics.noise * self.settings.min_step:
            return None
        turn = round_hairpin(self.corrector, samples)
        if turn is None:
            return None
        fold, beyond = turn
        return Arc((*samples, fold), Stop.FOLD, step=self.settings.min_step, beyond=beyond)

    def _ending(
        self, a: Sample, b: Sample, step: float, skipped: Stop | None, start: Sample | None
    ) -> Ending | None:
        """The first end between two samples; UnclearError if a shorter step is needed to tell."""
        found = self._endings(a, b, step, skipped, start)
        if not found:
            return None
        first = first_of(found, self.settings)
        if not is_first(self.corrector, first):
            raise UnclearError
        return first

    def _endings(
        self, a: Sample, b: Sample, step: float, skipped: Stop | None, start: Sample | None
    ) -> list[Ending]:
        """Ends between two samples; UnclearError if a shorter step is needed to tell."""
        corrector = self.corrector
        found = [*at_border(corrector, a, b, step), *at_ends(corrector, a, b, step)]
        fell = not self.order and falls(a, b, self.settings)
        crosses = fell or (a.forward != b.forward and not self.order)
        for test in (FOLD, *self.tests):
            if test.stop is not skipped and not (crosses and test.stop is Stop.FOLD):
                found += at_test(corrector, a, b, step, test)
        if crosses and skipped is not Stop.BRANCHING:
            with suppress(UnclearError) if found and not fell else nullcontext():
                found += at_branch_point(corrector, a, b, step)
        if fell and not any(each.stop is Stop.BRANCHING for each in found):
            raise UnclearError  # a branch leads to cycles of smaller period through that point only
        found += at_tails(corrector, a, b, step)
        if skipped is not Stop.LIMIT:
            found += at_diagonal(corrector, a, self._until(found, b), step)
        if found and self.order and not still_crosses(corrector, a, first_of(found, self.settings)):
            raise UnclearError
        found += at_stop(corrector, self.stop, a, self._until(found, b), step)
        return found if start is None else [*found, *closing_up(corrector, a, b, start)]

    def _until(self, found: list[Ending], b: Sample) -> Sample:
        """The first end, or the second of two samples if there is none."""
        return first_of(found, self.settings).sample if found else b
