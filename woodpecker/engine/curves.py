"""Curves of orbits: predictor, corrector, step control, and one locator of what ends them.

An *arc* is a part of a curve along which no piece changes and no test function vanishes. Every
curve is followed by the one loop here, whatever its conditions are: cycles, jump crossings, special
points in two parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.cubics import zero_of_cubic
from woodpecker.engine.maps import Image, PiecewiseMap, length_of
from woodpecker.engine.newton import (
    BLUR,
    STEEP,
    Problem,
    across,
    branch_point,
    solve,
    tangent,
    uncertainty,
)
from woodpecker.engine.orbits import (
    AtLimit,
    Chained,
    Condition,
    Held,
    Multiplier,
    OnBorder,
    Orbit,
    completed,
    head_of,
    held_at,
    pulled_inside,
)

LOCATED = 1e-15  # of a step: a zero of a test function is bracketed as closely as doubles allow
CLOSED_IN = 2.0**-10  # of its values at both ends: what is left of one that does vanish
ITERATIONS = 80  # of that: halvings alone take fifty
ROUNDED_OFF = 2.0**-44  # scaled: a bound that is nearer than this is met
STRAIGHT = 1e-4  # angle between a chord and its tangents that any smooth curve may have [rad]
KEPT_TURN = 0.7  # of the largest turn: what the next step is to have, so that few are refused
SAME_VALUE = 1e-9  # scaled, times slopes: values of a piece that are farther apart are of two
# solutions of its events, as there are beside a grazing
BEGINS = 2.0**-20  # of a test function after a step: what rounding leaves of one that was zero
LOOKED = 2.0**-14  # scaled: steps longer than that are looked at halfway
TOGETHER = 2.0**-8  # of how far apart points of a cycle were a step before
WORTH = 0.25  # part of a margin that is left where it dips: less is worth a look
STEADY = 0.5  # of the smaller rate at both ends: by how much a margin falls at least in between
COARSE = 64.0  # least steps: a dip of a margin in a shorter step is left alone
MOST_BOUNDS = 32  # that are passed in a step, each before the last: more are left to shorter steps
NEAR = 1e-7  # scaled: a bound that is nearer than this where an arc begins is where it comes from


class UnclearError(Exception):
    """A shorter step is needed to tell what lies between two samples.

    Parameters
    ----------
    part
        How much shorter.
    """

    def __init__(self, part: float = 0.5) -> None:
        super().__init__(part)
        self.part = part


class Halt(NamedTuple):
    """What ends a curve besides what lies on it.

    Attributes
    ----------
    spent
        Whether the map was evaluated as often as allowed.
    asked
        Whether the curve is to end at a sample; None if nobody asks.
    """

    spent: Callable[[], bool] = lambda: False
    asked: Callable[[Sample], bool] | None = None


class Stop(Enum):
    """What ends an arc; the value is the sentence a user reads."""

    SPAN = "end of the parameter span"
    WINDOW = "end of the window"
    BORDER = "a margin vanishes"
    SHARE = "a limit of the jump meets the diagonal"
    LP = "the branch turns round"
    PD = "the multiplier is -1"
    NS = "a pair of multipliers lies on the unit circle"
    BP = "another branch crosses"
    SPECIAL = "a test function of the curve's own vanishes"
    CLOSED = "the branch closes"
    OTHER_PIECE = "the map takes another piece"
    SHORT = "steps become too short"
    MANY = "as many samples as allowed"
    SPENT = "as many evaluations as allowed"
    ASKED = "stopped as asked"

    @property
    def is_open(self) -> bool:
        """Whether the curve was given up here: how it goes on is not known."""
        return self in (Stop.OTHER_PIECE, Stop.SHORT, Stop.MANY, Stop.SPENT)


MULTIPLIERS = (Stop.BP, Stop.LP, Stop.PD, Stop.NS)


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveSettings:
    """How curves are followed, in scaled unknowns, and where they end.

    Parameters
    ----------
    spans
        Lower and upper end of each parameter that is free.
    window
        (d, 2) lower and upper ends of each coordinate.
    step, min_step, max_step
        The first step, the shortest and the longest.
    max_turn
        The largest angle between tangents of neighbours [rad].
    max_samples
        Of an arc.

    Raises
    ------
    ValueError
        If an interval is empty, or the steps do not ascend.
    """

    spans: tuple[tuple[float, float], ...]
    window: tuple[tuple[float, float], ...]
    step: float = 0.01
    min_step: float = 1e-9
    max_step: float = 0.05
    max_turn: float = 0.2
    max_samples: int = 5000

    def __post_init__(self) -> None:
        for low, high in (*self.spans, *self.window):
            if not low < high:
                raise ValueError(f"an interval must have low < high, got ({low}, {high})")
        if not 0.0 < self.min_step <= self.step <= self.max_step:
            raise ValueError(
                "expected 0 < min_step <= step <= max_step, got "
                f"{self.min_step}, {self.step}, {self.max_step}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """An orbit of a curve, and which way the curve goes.

    Attributes
    ----------
    orbit
        It solves the equations.
    tangent
        Unit vector in scaled unknowns.
    bordered
        The determinant of the equations bordered with it; nan if it was not asked for.
    """

    orbit: Orbit
    tangent: Floats
    bordered: float = math.nan

    @property
    def turned(self) -> Sample:
        """The same with the curve the other way round."""
        return Sample(self.orbit, -self.tangent, -self.bordered)


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A curve from a sample on to what ends it.

    Attributes
    ----------
    samples
        The end included.
    stop
        What ended it.
    curve
        What it is an arc of.
    border
        Of BORDER: which image's margin vanishes, and its code.
    beyond
        The sample after the end, where the curve does not end there.
    condition
        The equation that its end obeys besides those of the curve; None if there is none.
    test
        The test function that vanishes at its end, if one does.
    """

    samples: tuple[Sample, ...]
    stop: Stop
    curve: SolutionCurve
    border: tuple[int, int] | None = None
    beyond: Sample | None = None
    condition: Condition | None = None
    step: float = math.inf
    width: float = 0.0
    test: TestFunction | None = None

    @property
    def precision(self) -> float:
        """How well the first free parameter is known at its end; infinite if it was given up."""
        if self.stop is Stop.SPAN:
            return 0.0
        if self.stop in (*MULTIPLIERS, Stop.ASKED):
            orbit, column = self.samples[-1].orbit, self.curve.problem.free[0]
            scale = self.curve.problem.p_scale[column]
            rate = abs(_ahead(self.samples[-1])) * scale
            return self.width * rate + BLUR * max(scale, abs(float(orbit.p[column])))
        if self.condition is None:
            return math.inf
        known = uncertainty(self.curve.problem.with_(self.condition), self.samples[-1].orbit)
        return max(known, self._left())

    def _left(self) -> float:
        """How far the parameter is off as the end is only close to a border that is steep there.

        A steep slope is that of a square root, b / (2 sqrt(h)), and b sqrt(h) is left of it; twice
        that of other roots.
        """
        if self.border is None:
            return 0.0
        orbit, problem = self.samples[-1].orbit, self.curve.problem
        image = orbit.taken[self.border[0]]
        k, d = image.place(self.border[1]), orbit.x.shape[1]
        away = abs(float(image.margins[k])) / max(float(np.linalg.norm(image.gradients[k])), NEAR)
        steep = float(np.abs(image.jacobian[:, :d]).max())
        if steep < STEEP or not math.isfinite(steep):
            return 0.0
        return 4.0 * steep * away * problem.p_scale[problem.free[0]] / problem.x_scale[0]


@dataclass(frozen=True, slots=True, eq=False)
class TestFunction:
    """A function along a curve whose change of sign ends an arc.

    Attributes
    ----------
    stop
        What it means.
    value
        Of a sample.
    condition
        The same as an equation, to solve it to rounding; None if it is none of single orbits.
    border
        The margin, if it is one.
    rate
        How fast the value grows along the curve, at a sample; None if it is not known.
    name
        What it is called, if it is one of a curve's own.
    noise
        Values that are no larger are made of rounding: if both are, nothing is said to vanish.
    """

    stop: Stop
    value: Callable[[Sample], float]
    condition: Condition | None = None
    border: tuple[int, int] | None = None
    rate: Callable[[Sample], float] | None = None
    name: str = ""
    noise: float = 0.0


class ArcEnd(NamedTuple):
    """What may end an arc between two samples: at which distance from the first, and where.

    ``width`` is how far the distance may be off.
    """

    distance: float
    test: TestFunction
    sample: Sample
    width: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class SolutionCurve:
    """A problem with one unknown left free, and what is looked at along it.

    Attributes
    ----------
    map
        The map that its orbits are of.
    problem
        Its equations.
    settings
        How it is followed.
    ignored
        Margins, by image and code, that vanish all along it.
    tests
        Which multipliers are looked at: of LP, PD, NS, BP.
    own
        Other functions that are looked at, ``SPECIAL`` where they vanish.
    """

    map: PiecewiseMap
    problem: Problem
    settings: CurveSettings
    ignored: frozenset[tuple[int, int]] = frozenset()
    tests: tuple[Stop, ...] = MULTIPLIERS
    own: tuple[TestFunction, ...] = ()

    def start(self, orbit: Orbit, along: Floats | None = None) -> Sample:
        """An orbit as a sample; its tangent points along a direction in scaled unknowns."""
        return Sample(orbit, *tangent(self.problem, orbit, along))

    def advance(self, last: Sample, distance: float, before: Sample | None = None) -> Sample | None:
        """The sample at a distance; None if Newton's method leads to none.

        It is predicted along the tangent, or along the cubic through the sample before, too.
        """
        way = distance * last.tangent
        if before is not None:
            way = way + self._bend(before, last, distance)
        if last.orbit.outer is not None and last.orbit.x.shape[1] == 1:
            orbit = self._along_border(last, distance, way)
        else:
            at_distance = across(self.problem, last.orbit, last.tangent, distance)
            guess = self.problem.moved(last.orbit, way)
            if not guess.is_defined:
                guess = pulled_inside(guess, last.orbit)
            found = solve(self.problem.with_(at_distance), guess)
            orbit = found.orbit if found.converged else None
        if orbit is None or not orbit.is_defined:
            return None
        aside = self.problem.step_between(last.orbit, orbit) - distance * last.tangent
        if float(np.linalg.norm(aside)) > distance:
            return None
        sample = self.start(orbit, last.tangent)
        return sample if np.isfinite(sample.tangent).all() else None

    def _along_border(self, last: Sample, distance: float, way: Floats) -> Orbit | None:
        """A jump crossing in R^1: its points up to the border are solved for, the share follows."""
        (*_, border), problem = self.problem.conditions, self.problem
        assert isinstance(border, OnBorder)
        to = problem.stepped(last.orbit, way)
        head = head_of(last.orbit, to)
        if not head.is_defined:
            head = pulled_inside(head, head_of(last.orbit, last.orbit.unknowns))
        rounds = length_of(last.orbit.images[-1])
        on = OnBorder(border.image, border.code // rounds)
        heads = replace(problem, conditions=(Chained(), on))
        at_distance = across(problem, last.orbit, last.tangent, float(last.tangent @ way))
        found = solve(heads.with_(at_distance), head)
        return completed(found.orbit, last.orbit) if found.converged else None

    def _leaves(self, start: Sample) -> Stop | None:
        """Whether a sample lies at an end of span or window, or beyond, and the curve leaves."""
        orbit = start.orbit
        columns, low, high, stops = self._limits(orbit)
        at, along = orbit.unknowns[columns], self._wide(start)[columns]
        out = ((at <= low) & (along < 0.0)) | ((at >= high) & (along > 0.0))
        return next((stop for stop, is_out in zip(stops, out, strict=True) if is_out), None)

    def _to_end(self, last: Sample, step: float) -> Sample | None:
        """The sample at the end of a span, if a step leads there: beyond, there may be no map."""
        orbit, problem = last.orbit, self.problem
        size = orbit.x.size
        for j, (free, (low, high)) in enumerate(
            zip(problem.free, self.settings.spans, strict=True)
        ):
            rate, p = float(last.tangent[size + j]) * problem.p_scale[free], float(orbit.p[free])
            end = high if rate > 0.0 else low
            if rate == 0.0 or p == end or abs(end - p) >= step * abs(rate):
                continue
            guess = problem.moved(orbit, (end - p) / rate * last.tangent)
            found = solve(problem.with_(Held(size + free, end)), guess)
            if found.converged:
                sample = self.start(held_at(found.orbit, size + free, end), last.tangent)
                return sample if np.isfinite(sample.tangent).all() else None
        return None

    def _bend(self, a: Sample, b: Sample, distance: float) -> Floats:
        """What the cubic through two samples adds to the tangent at a distance from the second."""
        chord = self.problem.step_between(a.orbit, b.orbit)
        length = float(np.linalg.norm(chord))
        if length == 0.0:
            return np.zeros(len(chord))
        mean, part = chord / length, distance / length
        cubic = b.tangent + a.tangent - 2.0 * mean
        square = 2.0 * b.tangent + a.tangent - 3.0 * mean
        return np.asarray(distance * part * (square + part * cubic))

    def follow(
        self, start: Sample, first: float = math.inf, halt: Halt | None = None,
        origin: Sample | None = None,
    ) -> Arc:  # fmt: skip
        """Follow the curve from a sample to what ends it; the first step may be a shorter one.

        It closes where it comes back to its origin: the start, if no other sample is given.

        Each turn of the loop either keeps a sample, of which there are ``max_samples``, or shortens
        the step, of which ``min_step`` is the end.
        """
        settings, samples, grows, bent = self.settings, [start], True, 0.0
        step = min(first, settings.step)
        given_up, halt = Stop.SHORT, halt or Halt()
        leaves = self._leaves(start)
        if leaves is None and halt.asked is not None and halt.asked(start):
            leaves = Stop.ASKED
        if leaves is not None:
            return Arc((start,), leaves, self)
        while len(samples) < settings.max_samples:
            if halt.spent():
                return Arc(tuple(samples), Stop.SPENT, self)
            if step < settings.min_step:
                return Arc(tuple(samples), given_up, self)
            last = samples[-1]
            before = samples[-2] if len(samples) > 1 else None
            found = to_end = self._to_end(last, step)
            found = found or self.advance(last, step, before)
            turned = math.inf
            if found is not None and not self._strays(last, found, bent):
                turned = _angle(last, found) / settings.max_turn
            if found is None or turned > 1.0:
                step = self._shorter(step, max(0.25, min(0.5, KEPT_TURN / turned)))
                grows, given_up = False, Stop.SHORT
                continue
            try:
                ends = self._ends(last, found, step, starts=len(samples) == 1)
                if halt.asked is not None:
                    ends = self._asked(last, found, step, ends, halt.asked)
            except UnclearError as unclear:
                step, grows, given_up = self._shorter(step, unclear.part), False, Stop.SHORT
                continue
            end = ends[0] if ends else None
            if step > LOOKED and self._differs_between(last, found if end is None else end.sample):
                step, grows = 0.5 * step, False
                continue
            if not self.agrees(found.orbit if end is None else end.sample.orbit, end):
                step, grows, given_up = self._shorter(step, 0.25), False, Stop.OTHER_PIECE
                continue
            if end is not None:
                beyond: Sample | None = found
                if len(ends) > 1:
                    beyond = self.advance(last, 0.5 * (end.distance + ends[1].distance))
                test = end.test
                return Arc(
                    (*samples, end.sample), test.stop, self, test.border, beyond, test.condition,
                    step, end.width, test,
                )  # fmt: skip
            if to_end is not None:
                return Arc((*samples, to_end), Stop.SPAN, self)
            home = start if origin is None else origin
            is_away = len(samples) > 2 or home is not start
            if is_away and self._closes(home, last, found, step):
                return Arc((*samples, home), Stop.CLOSED, self)
            samples.append(found)
            bent = turned * settings.max_turn
            growth = min(2.0 if grows else 1.0, KEPT_TURN / max(turned, 1e-3))
            step, grows = min(settings.max_step, max(settings.min_step, step * growth)), True
        return Arc(tuple(samples), Stop.MANY, self)

    def _shorter(self, step: float, part: float) -> float:
        """A part of a step; the shortest one is tried before any that would be too short."""
        least = self.settings.min_step
        return least if part * step < least < step else part * step

    def _strays(self, a: Sample, b: Sample, bent: float) -> bool:
        """Whether a sample is one of another curve, though its tangent is much the same.

        It may be that of a shorter cycle, run through several times. A smooth curve goes about
        along the mean of its tangents; by how much not, they tell by how they turn, in this step
        or in the one before.
        """
        if a.orbit.outer is None and self._comes_together(a.orbit.x, b.orbit.x):
            return True
        chord = self.problem.step_between(a.orbit, b.orbit)
        length, mean = float(np.linalg.norm(chord)), a.tangent + b.tangent
        if length == 0.0:
            return True  # rounding lets it come no farther
        off = float(np.linalg.norm(chord / length - mean / np.linalg.norm(mean)))
        return off > 0.5 * max(_angle(a, b), bent) + STRAIGHT + ROUNDED_OFF / length

    def _comes_together(self, a: Floats, b: Floats) -> bool:
        """Whether points (n, d) of a cycle that are apart at one sample are one at the next."""
        n, apart = len(a), self.problem.apart
        divisors = [k for k in range(1, n) if n % k == 0]
        return any(
            apart(b, np.roll(b, k, axis=0)) < TOGETHER * apart(a, np.roll(a, k, axis=0))
            for k in divisors
        )

    # --- What is looked at ------------------------------------------------------------------------

    def _ends(self, a: Sample, b: Sample, step: float, *, starts: bool) -> list[ArcEnd]:
        """What ends the arc between two samples, by distance; UnclearError if that is not clear."""
        bound = self._bounded(a, b, step)
        found = self._multipliers(a, b, step, starts) + ([] if bound is None else [bound])
        found.sort(key=lambda end: end.distance)
        if found and found[0] is not bound and any(True for _ in self._borders(found[0].sample)):
            raise UnclearError  # a margin has vanished before
        self._look_for_dips(a, *((found[0].sample, found[0].distance) if found else (b, step)))
        return found

    def _asked(
        self, a: Sample, b: Sample, step: float, ends: list[ArcEnd], asked: Callable[[Sample], bool]
    ) -> list[ArcEnd]:
        """Those ends, and before them the place where the curve is asked to end."""
        last = ends[0].sample if ends else b
        if not asked(last):
            return ends
        low, high, found = 0.0, ends[0].distance if ends else step, last
        while high - low > LOCATED * step:  # halved each time
            middle = 0.5 * (low + high)
            sample = self.advance(a, middle)
            if sample is None:
                raise UnclearError
            if asked(sample):
                high, found = middle, sample
            else:
                low = middle
        test = TestFunction(Stop.ASKED, lambda sample: float(asked(sample)))
        return [ArcEnd(high, test, found, high - low), *ends]

    def _multipliers(self, a: Sample, b: Sample, step: float, starts: bool) -> list[ArcEnd]:
        """Where multipliers are 1 or -1, or pairs of them on the unit circle, or curves cross."""
        found = list[ArcEnd]()
        for test in self._special(a.orbit):
            before, after = test.value(a), test.value(b)
            if not (before * after < 0.0 or (after == 0.0 and before != 0.0)):
                continue
            if max(abs(before), abs(after)) <= test.noise:
                continue
            if starts and abs(before) <= BEGINS * abs(after):
                continue  # the curve begins where it vanishes, but for rounding
            if test.stop is Stop.LP and found:
                continue  # where curves cross one of them may turn round
            if test.stop is Stop.BP:
                found.append(self._crossed(a, b, step, test))
                continue
            test, before, after = self._exact(test, a, b)
            distance, sample = self._located(a, step, test, before, after, b)
            if test.stop is not Stop.NS or not _is_neutral_saddle(sample):
                left = abs(test.value(sample) / (after - before))
                found.append(ArcEnd(distance, test, sample, (LOCATED + left) * step))
        return found

    def _crossed(self, a: Sample, b: Sample, step: float, test: TestFunction) -> ArcEnd:
        """Where another curve crosses between two samples; UnclearError if it is not found.

        There the equations of the curve are singular, but those of the point are not.
        """
        before, after = test.value(a), test.value(b)
        way = self.problem.step_between(a.orbit, b.orbit)
        guess = self.problem.moved(a.orbit, before / (before - after) * way)
        orbit = branch_point(self.problem, guess) if guess.is_defined else None
        if orbit is None:
            raise UnclearError
        away = self.problem.step_between(a.orbit, orbit)
        distance = float(away @ a.tangent)
        aside = float(np.linalg.norm(away - distance * a.tangent))
        if not 0.0 <= distance <= step or aside > self.settings.max_turn * step:
            raise UnclearError
        return ArcEnd(distance, test, Sample(orbit, a.tangent))

    def _exact(self, test: TestFunction, a: Sample, b: Sample) -> tuple[TestFunction, float, float]:
        """A test function that is as exact as there is one, and its values at two samples.

        Where a curve turns round is not known as well as where a multiplier is 1.
        """
        before, after = test.value(a), test.value(b)
        if test.stop is Stop.LP and test.condition is not None:
            exact = replace(test, value=_of_condition(test.condition))
            if exact.value(a) * exact.value(b) < 0.0:
                return exact, exact.value(a), exact.value(b)
        return test, before, after

    def _newly_beyond(self, a: Sample, b: Sample) -> Iterator[TestFunction]:
        """Those of the bounds that the second sample lies beyond which it has not begun beyond.

        A point that is outside of the window at first may come in.
        """
        for test in self._bounds(b):
            if test.stop is not Stop.WINDOW or test.value(a) >= -ROUNDED_OFF:
                yield test

    def _bounds(self, sample: Sample) -> Iterator[TestFunction]:
        """Ends of spans, of the window and of the share that a sample lies beyond."""
        orbit = sample.orbit
        columns, low, high, stops = self._limits(orbit)
        at = orbit.unknowns[columns]
        held = {each.column for each in self.problem.conditions if isinstance(each, Held)}
        for k in np.flatnonzero((at < low) | (at > high)).tolist():
            column = int(columns[k])
            if column in held:
                continue
            end, inward = (low[k], 1.0) if at[k] < low[k] else (high[k], -1.0)
            condition: Condition = Held(column, float(end))
            if stops[k] is Stop.SHARE and orbit.x.shape[1] == 1:
                condition = AtLimit(end > 0.0)
            yield TestFunction(
                stops[k], _inside(column, float(end), inward), condition,
                rate=partial(self._rate_of, column=column, inward=inward),
            )  # fmt: skip

    def _limits(self, orbit: Orbit) -> tuple[Ints, Floats, Floats, list[Stop]]:
        """Which unknowns of an orbit are bounded, by what, and what it is to pass that."""
        n, share = len(orbit.x), -1 if orbit.outer is None else len(orbit.unknowns) - 1
        return _limits(self.settings, n, self.problem.free, share)

    def _borders(self, sample: Sample) -> Iterator[TestFunction]:
        """Margins that are negative at a sample, by more than rounding."""
        orbit = sample.orbit
        for i, image in enumerate(orbit.taken):
            negative = image.margins < 0.0
            if not negative.any():
                continue
            negative &= ~image.tied(orbit.x[orbit.place(i)], orbit.p)
            for code in image.codes[negative].tolist():
                if (i, code) not in self.ignored:
                    border, rate = OnBorder(i, code), partial(self.rate, i=i, code=code)
                    yield TestFunction(Stop.BORDER, _of_condition(border), border, (i, code), rate)

    def _bounded(self, a: Sample, b: Sample, step: float) -> ArcEnd | None:
        """Where the first bound is passed of those that the second of two samples lies beyond.

        The one that seems first is located, until none has been passed before it.
        """
        found = None
        for _ in range(MOST_BOUNDS):
            passed = [*self._borders(b), *self._newly_beyond(a, b)]
            if not passed:
                return found
            test = min(passed, key=lambda each: _part(each, a, b))
            before, after = test.value(a), test.value(b)
            if before <= NEAR and self._is_at(a, test, before):
                if step > COARSE * self.settings.min_step:
                    raise UnclearError  # a shorter step shows whether the curve leaves right here
                return ArcEnd(0.0, test, a)
            if before < 0.0:
                raise UnclearError
            distance, sample = self._located(a, step, test, before, after, b)
            is_back = test.border is not None and self.rate(sample, *test.border) > 0.0
            if is_back or (found is not None and distance >= found.distance):
                raise UnclearError  # it has vanished before, and is back
            found = ArcEnd(distance, test, sample)
            b, step = sample, distance
        raise UnclearError

    @staticmethod
    def _is_at(a: Sample, test: TestFunction, value: float) -> bool:
        """Whether a bound holds with equality at a sample, but for rounding."""
        if test.border is None:
            return abs(value) <= ROUNDED_OFF
        i, code = test.border
        image = a.orbit.taken[i]
        return bool(image.tied(a.orbit.x[a.orbit.place(i)], a.orbit.p)[image.place(code)])

    def _special(self, orbit: Orbit) -> Iterator[TestFunction]:
        """Folds, flips, pairs on the unit circle, branch points, and functions of its own."""
        yield from self.own
        one = len(self.problem.free) == 1
        for stop in self.tests:
            condition = Multiplier(stop.name) if orbit.outer is None else None
            if stop is Stop.LP and one:
                yield TestFunction(stop, _ahead, condition)
            elif stop is Stop.BP:
                yield TestFunction(stop, self._bordered)
            elif condition is not None and (stop is Stop.PD or orbit.x.shape[1] > 1):
                yield TestFunction(stop, _of_condition(condition), condition)

    def _bordered(self, sample: Sample) -> float:
        """The determinant of the equations bordered with the tangent."""
        if not math.isnan(sample.bordered):
            return sample.bordered
        return float(np.linalg.det(np.vstack([self.problem.matrix(sample.orbit), sample.tangent])))

    def agrees(self, orbit: Orbit, end: ArcEnd | None = None) -> bool:
        """Whether the map takes the pieces of an orbit, at points on borders aside."""
        at_border = {orbit.place(i) for i, _ in self.ignored}
        if end is not None and end.test.border is not None:
            at_border.add(orbit.place(end.test.border[0]))
        return all(
            i in at_border or self._is_taken(x, orbit.p, image)
            for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True))
        )

    def _differs_between(self, a: Sample, b: Sample) -> bool:
        """Whether the map takes another piece halfway: a margin may vanish that no sample has.

        A point between two samples is good enough where the map is not steep.
        """
        x = 0.5 * (a.orbit.x + b.orbit.x)
        p = 0.5 * (a.orbit.p + b.orbit.p)
        at_border = {a.orbit.place(i) for i, _ in self.ignored}
        return any(
            i not in at_border
            and float(np.abs(image.jacobian).max()) < STEEP
            and self.map.at(point, p).piece.key != image.piece.key
            for i, (point, image) in enumerate(zip(x, a.orbit.images, strict=True))
        )

    def _is_taken(self, x: Floats, p: Floats, image: Image) -> bool:
        """Whether the map takes the piece of an image, and the same of its solutions."""
        taken = self.map.at(x, p)
        slack = SAME_VALUE * max(1.0, float(np.abs(image.jacobian).max()))
        return taken.piece.key == image.piece.key and self.problem.same(
            taken.value, image.value, slack
        )

    def _look_for_dips(self, a: Sample, b: Sample, step: float) -> None:
        """UnclearError if a margin that is positive at both ends may be negative in between.

        It is a cubic there, with the values and slopes of both ends. One that only one of them has
        is taken for linear. One that falls at both ends, but by much less in between, is not the
        same all the way.
        """
        if step < COARSE * self.settings.min_step:
            return
        dips = dict[float, list[tuple[int, int, float]]]()
        for i, (one, other) in enumerate(zip(a.orbit.taken, b.orbit.taken, strict=True)):
            falls, rises = step * self._rates(a, i), step * self._rates(b, i)
            for k in np.flatnonzero(0.5 * one.margins + falls < 0.0).tolist():
                code = int(one.codes[k])
                if (i, code) in self.ignored or not one.margins[k] > 0.0:
                    continue
                m = other.place(code)
                if m < 0:
                    if one.margins[k] + falls[k] < 0.0:
                        raise UnclearError
                    continue
                ends = float(one.margins[k]), float(other.margins[m])
                rates = float(falls[k]), float(rises[m])
                if ends[1] > 0.0 and rates[1] > 0.0:
                    part, least = _least(*ends, *rates)
                    if least < WORTH * min(ends):
                        dips.setdefault(part, []).append((i, code, WORTH * min(ends)))
                if rates[1] < 0.0 and ends[1] - ends[0] > STEADY * max(rates):
                    raise UnclearError
            for k in np.flatnonzero(other.margins < rises).tolist():
                code = int(other.codes[k])
                inside = other.margins[k] > 0.0 and (i, code) not in self.ignored
                if inside and one.place(code) < 0:
                    raise UnclearError
        for part, margins in dips.items():
            lowest = self.advance(a, part * step)
            if lowest is None or any(
                not _margin(lowest.orbit, i, code) >= least for i, code, least in margins
            ):
                raise UnclearError

    def _rates(self, sample: Sample, i: int) -> Floats:
        """How fast all margins of an image grow along the curve."""
        orbit = sample.orbit
        found: Floats = orbit.taken[i].gradients @ self.motion(sample, orbit.place(i))
        return found

    def motion(self, sample: Sample, i: int) -> Floats:
        """How a point of an orbit and the parameters (d + k,) change along the curve."""
        (n, d), k = sample.orbit.x.shape, len(sample.orbit.p)
        wide = self._wide(sample)
        return np.concatenate((wide[i * d : i * d + d], wide[n * d : n * d + k]))

    def _wide(self, sample: Sample) -> Floats:
        """How all unknowns of an orbit change along the curve."""
        orbit, problem = sample.orbit, self.problem
        wide, columns = np.zeros(len(orbit.unknowns)), problem.columns(orbit)
        wide[columns] = sample.tangent * problem.scale(orbit)[columns]
        if orbit.outer is not None and orbit.x.shape[1] == 1:
            wide[-1] = _rate_of_share(orbit, wide)
        return wide

    def limits(self, sample: Sample) -> tuple[float, float, float]:
        """How fast both limits of a jump crossing in R^1, and its first point, grow along it."""
        orbit, motion = sample.orbit, self._wide(sample)
        last = motion[len(orbit.x) - 1 : -1]
        inner, outer = (float(each.jacobian[0] @ last) for each in orbit.taken[-2:])
        return inner, outer, float(motion[0])

    def rate_of_share(self, sample: Sample) -> float:
        """How fast the share of a jump crossing grows along the curve."""
        return float(self._wide(sample)[-1])

    def rate(self, sample: Sample, i: int, code: int) -> float:
        """How fast a margin grows along the curve."""
        return float(self._rates(sample, i)[sample.orbit.taken[i].place(code)])

    # --- Where it ends ----------------------------------------------------------------------------

    def _located(
        self, a: Sample, step: float, test: TestFunction, before: float, after: float, b: Sample
    ) -> tuple[float, Sample]:
        """Where a test function vanishes between two samples; UnclearError if it is not found."""
        quick = self._solved(a, step, test, before, after, b)
        if quick is not None:
            return quick
        seen = {0.0: (a, before), step: (b, after)}

        def value(distance: float) -> float:
            if distance not in seen:
                sample = self.advance(a, distance)
                if sample is None:
                    raise ArithmeticError
                seen[distance] = sample, test.value(sample)
            return seen[distance][1]

        if math.isnan(before):
            raise UnclearError  # it was not there: how it came to be negative is not seen
        try:
            brentq(value, 0.0, step, xtol=LOCATED * step, maxiter=ITERATIONS)
        except (ArithmeticError, RuntimeError, ValueError):  # lost, not converged, nan
            raise UnclearError from None
        distance = min(seen, key=lambda each: abs(seen[each][1]))
        sample = seen[distance][0]
        noise = abs(after - before) * BLUR / step  # orbits are known to BLUR
        if not abs(test.value(sample)) <= CLOSED_IN * min(abs(before), abs(after)) + noise:
            raise UnclearError  # it changes its sign without being zero
        return distance, sample

    def _solved(
        self, a: Sample, step: float, test: TestFunction, before: float, after: float, b: Sample
    ) -> tuple[float, Sample] | None:
        """The same by Newton's method, from where a cubic puts it; None unless it is in between."""
        if test.condition is None or test.rate is None:
            return None
        found = solve(self.problem.with_(test.condition), self._guess(a, b, test, before, after))
        if not found.converged:
            return None
        orbit = found.orbit
        if isinstance(test.condition, Held):
            orbit = held_at(orbit, test.condition.column, test.condition.value)
        elif isinstance(test.condition, AtLimit):
            orbit = replace(orbit, share=float(test.condition.outer))
        sample = self.start(orbit, a.tangent)
        away = self.problem.step_between(a.orbit, found.orbit)
        distance = float(away @ a.tangent)
        aside = float(np.linalg.norm(away - distance * a.tangent))
        is_there = aside <= self.settings.max_turn * step and 0.0 <= distance <= step
        if not (is_there and np.isfinite(sample.tangent).all()):
            if step > COARSE * self.settings.min_step:
                raise UnclearError  # it vanishes elsewhere: in between it need not
            return None
        return distance, sample

    def _guess(
        self, a: Sample, b: Sample, test: TestFunction, before: float, after: float
    ) -> Orbit:
        """Where a test function may vanish, by its values and rates at two samples.

        One that there is at the second only is taken for linear there; if it is level, it predicts
        nothing, and the second sample is where the search begins.
        """
        assert test.rate is not None
        if math.isnan(before):
            rate = test.rate(b)
            back = min(max(after / rate, 0.0), 1.0) if rate != 0.0 else 0.0
            return self.problem.moved(b.orbit, -back * b.tangent)
        chord = self.problem.step_between(a.orbit, b.orbit)
        length = float(np.linalg.norm(chord))
        part = zero_of_cubic(before, after, length * test.rate(a), length * test.rate(b))
        first, last = length * a.tangent, length * b.tangent
        cubic, square = first + last - 2.0 * chord, 3.0 * chord - 2.0 * first - last
        return self.problem.moved(a.orbit, part * (first + part * (square + part * cubic)))

    def _rate_of(self, sample: Sample, column: int, inward: float) -> float:
        """How fast an unknown grows inwards along the curve."""
        return inward * float(self._wide(sample)[column])

    def _closes(self, start: Sample, a: Sample, b: Sample, step: float) -> bool:
        """Whether the curve passes its own start between two samples."""
        away = self.problem.step_between(a.orbit, start.orbit)
        along = float(away @ a.tangent)
        aside = float(np.linalg.norm(away - along * a.tangent))
        return (
            0.0 < along <= step
            and aside <= step * self.settings.max_turn
            and float(start.tangent @ b.tangent) > math.cos(2.0 * self.settings.max_turn)
        )


@lru_cache
def _limits(
    settings: CurveSettings, n: int, free: tuple[int, ...], share: int
) -> tuple[Ints, Floats, Floats, list[Stop]]:
    """The bounds of n points, the free parameters, and the share in a column, if not negative."""
    points = n * len(settings.window)
    columns = [*range(points), *(points + each for each in free)]
    ends = [*settings.window * n, *settings.spans]
    stops = [Stop.WINDOW] * points + [Stop.SPAN] * len(settings.spans)
    if share >= 0:
        columns.append(share)
        ends.append((0.0, 1.0))
        stops.append(Stop.SHARE)
    low, high = np.array(ends).T
    return np.array(columns), low, high, stops


def _rate_of_share(orbit: Orbit, motion: Floats) -> float:
    """How fast the share of a jump crossing in R^1 grows as its points and parameters change."""
    inner, outer = orbit.taken[-2:]
    n = len(orbit.x)
    rates = [float(each.jacobian[0] @ motion[n - 1 : -1]) for each in (inner, outer)]
    jump = float(outer.value[0] - inner.value[0])
    if jump == 0.0:
        return math.nan
    return float(motion[0] - rates[0] - orbit.share * (rates[1] - rates[0])) / jump


def _ahead(sample: Sample) -> float:
    """How fast the first free parameter grows; noise about zero is none."""
    rate = float(sample.tangent[sample.orbit.x.size])
    return rate if abs(rate) > NEAR else 0.0


def _angle(a: Sample, b: Sample) -> float:
    return math.acos(min(1.0, float(a.tangent @ b.tangent)))


def _inside(column: int, end: float, inward: float) -> Callable[[Sample], float]:
    return lambda sample: inward * float(sample.orbit.unknowns[column] - end)


def _of_condition(condition: Condition) -> Callable[[Sample], float]:
    return lambda sample: float(condition.residual(sample.orbit)[0])


def _is_neutral_saddle(sample: Sample) -> bool:
    """Whether no two complex multipliers have the product 1, but two real ones."""
    multipliers = sample.orbit.multipliers()
    pairs = [each for each in multipliers if abs(each.imag) > 0.0]
    return not any(abs(abs(each) - 1.0) < NEAR for each in pairs)


def _least(a: float, b: float, da: float, db: float) -> tuple[float, float]:
    """Where in (0, 1) a cubic with values a, b and slopes da < 0 < db is least, and its value."""
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = math.sqrt(max(0.0, c2 * c2 - 3.0 * c3 * da))
    s = -da / (c2 + root) if c2 + root > 0.0 else 1.0
    return (s, a + s * (da + s * (c2 + s * c3))) if 0.0 < s < 1.0 else (0.5, min(a, b))


def _margin(orbit: Orbit, i: int, code: int) -> float:
    """A margin of an image; nan without it."""
    return float(OnBorder(i, code).residual(orbit)[0])


def _part(test: TestFunction, a: Sample, b: Sample) -> tuple[bool, float]:
    """About which part of the way from one sample to another a bound is passed, to compare.

    One that has been passed and rises comes last: beyond another border its events may be others,
    and it has jumped.
    """
    before, after = test.value(a), test.value(b)
    rises = test.rate is not None and test.rate(b) > 0.0
    return rises, math.inf if math.isnan(before) else before / (before - after)
