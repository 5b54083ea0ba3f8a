"""Curves of orbits: predictor, corrector, step control, and one locator of what ends them.

An *arc* is a part of a curve along which no piece changes and no test function vanishes. Every
curve is followed by the one loop here, whatever its conditions are: cycles, jump crossings, special
points in two parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats
from woodpecker.engine.maps import PiecewiseMap
from woodpecker.engine.newton import (
    HALF,
    Across,
    Problem,
    branch_point,
    solve,
    tangent,
    uncertainty,
)
from woodpecker.engine.orbits import Condition, Held, Multiplier, OnBorder, Orbit

LOCATED = 1e-15  # of a step: a zero of a test function is bracketed as closely as doubles allow
ITERATIONS = 80  # of that: halvings alone take fifty
COARSE = 64.0  # least steps: a dip of a margin in a shorter step is left alone
NEAR = 1e-7  # scaled: a bound that is nearer than this where an arc begins is where it comes from


class Stop(Enum):
    """What ends an arc; the value is the sentence a user reads."""

    SPAN = "end of the parameter span"
    WINDOW = "end of the window"
    BORDER = "a point meets a border"
    SHARE = "the crossing meets a limit of the jump"
    LP = "fold: a multiplier is 1"
    PD = "flip: a multiplier is -1"
    NS = "Neimark-Sacker: a pair of multipliers lies on the unit circle"
    BP = "branch point: two curves cross"
    CLOSED = "the curve is closed"
    OTHER_PIECE = "the map takes another piece, and no margin of this one says so"
    SHORT = "steps become too short"
    MANY = "more samples than a curve may have"

    @property
    def is_open(self) -> bool:
        """Whether the curve was given up here: how it goes on is not known."""
        return self in (Stop.OTHER_PIECE, Stop.SHORT, Stop.MANY)


MULTIPLIERS = (Stop.LP, Stop.PD, Stop.NS, Stop.BP)


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
    """

    orbit: Orbit
    tangent: Floats


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
    """

    samples: tuple[Sample, ...]
    stop: Stop
    curve: Curve
    border: tuple[int, int] | None = None
    beyond: Sample | None = None
    condition: Condition | None = None

    @property
    def precision(self) -> float:
        """How well the first free parameter is known at its end; infinite if it was given up."""
        if self.stop is Stop.SPAN:
            return 0.0
        if self.stop is Stop.BP:
            return HALF
        if self.condition is None:
            return math.inf
        return uncertainty(self.curve.problem.with_(self.condition), self.samples[-1].orbit)


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
    """

    stop: Stop
    value: Callable[[Sample], float]
    condition: Condition | None = None
    border: tuple[int, int] | None = None

    @property
    def is_bound(self) -> bool:
        """Whether it is positive inside, and zero where a curve begins at it."""
        return self.stop not in MULTIPLIERS


class End(NamedTuple):
    """What may end an arc between two samples: at which distance from the first, and where."""

    distance: float
    test: TestFunction
    sample: Sample


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
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
    """

    map: PiecewiseMap
    problem: Problem
    settings: CurveSettings
    ignored: frozenset[tuple[int, int]] = frozenset()
    tests: tuple[Stop, ...] = MULTIPLIERS

    def start(self, orbit: Orbit, along: Floats | None = None) -> Sample:
        """An orbit as a sample; its tangent points along a direction in scaled unknowns."""
        direction = tangent(self.problem, orbit)
        return Sample(orbit, direction if along is None or along @ direction >= 0.0 else -direction)

    def advance(self, last: Sample, distance: float) -> Sample | None:
        """The sample at a distance; None if Newton's method leads to none."""
        across = Across(self.problem, last.orbit, last.tangent, distance)
        guess = self.problem.moved(last.orbit, distance * last.tangent)
        found = solve(self.problem.with_(across), guess)
        if not found.converged:
            return None
        sample = self.start(found.orbit, last.tangent)
        return sample if np.isfinite(sample.tangent).all() else None

    def follow(self, start: Sample) -> Arc:
        """Follow the curve from a sample to what ends it.

        Each turn of the loop either keeps a sample, of which there are ``max_samples``, or shortens
        the step, of which ``min_step`` is the end.
        """
        settings, samples, step = self.settings, [start], self.settings.step
        given_up = Stop.SHORT
        while len(samples) < settings.max_samples:
            if step < settings.min_step:
                return Arc(tuple(samples), given_up, self)
            last = samples[-1]
            found = self.advance(last, step)
            if found is None or self._turns(last, found) or self._dips(last, found, step):
                step, given_up = 0.5 * step, Stop.SHORT
                continue
            ends = self._ends(last, found, step)
            if ends is None:
                step, given_up = 0.5 * step, Stop.SHORT
                continue
            end = ends[0] if ends else None
            if not self._agrees(found.orbit if end is None else end.sample.orbit, end):
                step, given_up = 0.5 * step, Stop.OTHER_PIECE
                continue
            if end is not None:
                beyond: Sample | None = found
                if len(ends) > 1:
                    beyond = self.advance(last, 0.5 * (end.distance + ends[1].distance))
                test = end.test
                return Arc(
                    (*samples, end.sample), test.stop, self, test.border, beyond, test.condition
                )
            if len(samples) > 2 and self._closes(start, last, found, step):
                return Arc((*samples, start), Stop.CLOSED, self)
            samples.append(found)
            turned = _angle(last, found) / settings.max_turn
            step = min(settings.max_step, step * min(2.0, 0.5 / max(turned, 0.25)))
        return Arc(tuple(samples), Stop.MANY, self)

    # --- What is looked at ------------------------------------------------------------------------

    def _tests(self, at: Sample) -> Iterator[TestFunction]:
        """All test functions that are to be looked at from a sample on."""
        orbit, problem = at.orbit, self.problem
        (n, d), settings = orbit.x.shape, self.settings
        free = zip(problem.free, settings.spans, strict=True)
        bounds = [(Stop.SPAN, n * d + each, ends) for each, ends in free]
        bounds += [(Stop.WINDOW, i * d + j, settings.window[j]) for i in range(n) for j in range(d)]
        if orbit.outer is not None:
            bounds.append((Stop.SHARE, len(orbit.unknowns) - 1, (0.0, 1.0)))
        for stop, column, ends in bounds:
            for end, inward in zip(ends, (1.0, -1.0), strict=True):
                yield TestFunction(stop, _inside(column, end, inward), Held(column, end))
        for i, image in enumerate(orbit.taken):
            for code in image.codes.tolist():
                if (i, code) not in self.ignored:
                    border = OnBorder(i, code)
                    yield TestFunction(Stop.BORDER, _of_condition(border), border, (i, code))
        yield from self._special(orbit)

    def _special(self, orbit: Orbit) -> Iterator[TestFunction]:
        """Folds, flips, pairs on the unit circle, branch points."""
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
        return float(np.linalg.det(np.vstack([self.problem.matrix(sample.orbit), sample.tangent])))

    def _agrees(self, orbit: Orbit, end: End | None) -> bool:
        """Whether the map takes the pieces of an orbit, at points on borders aside."""
        at_border = {orbit.place(i) for i, _ in self.ignored}
        if end is not None and end.test.border is not None:
            at_border.add(orbit.place(end.test.border[0]))
        return all(
            i in at_border or self.map.at(x, orbit.p).piece.key == image.piece.key
            for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True))
        )

    def _turns(self, a: Sample, b: Sample) -> bool:
        return _angle(a, b) > self.settings.max_turn

    def _dips(self, a: Sample, b: Sample, step: float) -> bool:
        """Whether a margin that is positive at both ends may vanish twice in between.

        It is a cubic there, with the values and slopes of both ends.
        """
        if step < COARSE * self.settings.min_step:
            return False
        for i, (one, other) in enumerate(zip(a.orbit.taken, b.orbit.taken, strict=True)):
            for code in one.codes.tolist():
                k, m = one.place(code), other.place(code)
                if (i, code) in self.ignored or m < 0:
                    continue
                ends = float(one.margins[k]), float(other.margins[m])
                rates = [step * self.rate(at, i, code) for at in (a, b)]
                if min(ends) > 0.0 and rates[0] < 0.0 < rates[1] and _least(*ends, *rates) < 0.0:
                    return True
        return False

    def rate(self, sample: Sample, i: int, code: int) -> float:
        """How fast a margin grows along the curve."""
        orbit, problem = sample.orbit, self.problem
        columns = problem.columns(orbit)
        gradient = orbit.gradient(i, code)[columns] * problem.scale(orbit)[columns]
        return float(gradient @ sample.tangent)

    # --- Where it ends ----------------------------------------------------------------------------

    def _ends(self, a: Sample, b: Sample, step: float) -> list[End] | None:
        """What ends the arc between two samples, by distance; None if one cannot be located."""
        found = []
        for test in self._tests(a):
            before, after = test.value(a), test.value(b)
            if test.is_bound and before < NEAR and (after < 0.0 or before < 0.0):
                if step > COARSE * self.settings.min_step:
                    return None  # a shorter step shows whether the curve leaves right here
                if after < 0.0:
                    found.append(End(0.0, test, a))
                continue
            if math.isnan(before) or math.isnan(after) or before * after > 0.0 or before == 0.0:
                continue
            located = self._located(a, step, test, before, after, b)
            if located is None:
                return None
            if test.stop is Stop.NS and _is_neutral_saddle(located[1]):
                continue
            found.append(End(located[0], test, located[1]))
        return sorted(found, key=lambda end: end.distance)

    def _located(
        self, a: Sample, step: float, test: TestFunction, before: float, after: float, b: Sample
    ) -> tuple[float, Sample] | None:
        """Where a test function vanishes between two samples."""
        seen = {0.0: (a, before), step: (b, after)}

        def value(distance: float) -> float:
            if distance not in seen:
                sample = self.advance(a, distance)
                if sample is None:
                    raise ArithmeticError
                seen[distance] = sample, test.value(sample)
            return seen[distance][1]

        try:
            distance = float(brentq(value, 0.0, step, xtol=LOCATED * step, maxiter=ITERATIONS))
        except (ArithmeticError, RuntimeError, ValueError):  # lost, not converged, nan
            return None
        value(distance)
        sample = seen[distance][0]
        if test.stop is Stop.BP:
            orbit = branch_point(self.problem, sample.orbit)
            return distance, sample if orbit is None else Sample(orbit, sample.tangent)
        if test.condition is not None:
            solution = solve(self.problem.with_(test.condition), sample.orbit)
            if solution.converged:
                sample = self.start(solution.orbit, sample.tangent)
        return distance, sample

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


def _least(a: float, b: float, da: float, db: float) -> float:
    """The least value in (0, 1) of a cubic with values a, b and slopes da < 0 < db at 0 and 1."""
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = math.sqrt(max(0.0, c2 * c2 - 3.0 * c3 * da))
    s = -da / (c2 + root) if c2 + root > 0.0 else 1.0
    return a + s * (da + s * (c2 + s * c3)) if 0.0 < s < 1.0 else min(a, b)
