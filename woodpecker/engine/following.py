"""Follow a curve: predictor, corrector and step control, from a sample to what ends it.

An *arc* is a part of a curve along which no piece changes and no test function vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.curves import MULTIPLIERS, Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.ends import ROUNDED_OFF, ArcEnd, UnclearError, asked_before, ends_between
from woodpecker.engine.maps import Image, Piece, margins_decide, taken
from woodpecker.engine.newton import BLUR, STEEP, solve, uncertainty
from woodpecker.engine.orbits import Condition, Held, Orbit, held_at

ASIDE = 1e-6  # scaled: an end that the piece beyond locates farther off is another one
STRAIGHT = 1e-4  # angle between a chord and its tangents that any smooth curve may have [rad]
KEPT_TURN = 0.7  # of the largest turn: what the next step is to have, so that few are refused
SAME_VALUE = 1e-9  # scaled, times slopes: values of a piece that are farther apart are of two
# solutions of its events, as there are beside a grazing
SHORTEST_ROW = 1e-7  # a gradient shorter than this does not say how far away its border is
LOOKED = 2.0**-14  # scaled: steps longer than that are looked at halfway
TOGETHER = 2.0**-8  # of how far apart points of a cycle were a step before


class Halt(NamedTuple):
    """What ends a curve besides what lies on it."""

    spent: Callable[[], bool] = lambda: False  # whether the map was evaluated as often as allowed
    # whether the curve is to end at a sample; None if nobody asks
    asked: Callable[[Sample], bool] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A curve from a sample to what ends it."""

    samples: tuple[Sample, ...]  # the end included
    stop: Stop
    curve: SolutionCurve
    border: tuple[int, int] | None = None  # of BORDER: image and code of the margin that vanishes
    beyond: Sample | None = None  # the sample after the end, where the curve goes on
    condition: Condition | None = None  # that its end obeys besides the equations of the curve
    step: float = math.inf
    width: float = 0.0
    test: TestFunction | None = None  # that vanishes at its end

    @property
    def precision(self) -> float:
        """How well the first free parameter is known at its end; infinite if it was given up."""
        if self.stop is Stop.SPAN:
            return 0.0
        if self.stop in (*MULTIPLIERS, Stop.ASKED):
            orbit, column = self.samples[-1].orbit, self.curve.problem.free[0]
            scale = self.curve.problem.p_scale[column]
            rate = abs(self.samples[-1].ahead) * scale
            return self.width * rate + BLUR * max(scale, abs(float(orbit.p[column])))
        if self.condition is None:
            return math.inf
        known = uncertainty(self.curve.problem.with_(self.condition), self.samples[-1].orbit)
        return max(known, self._left())

    def _left(self) -> float:
        """The error of the parameter where the end is only close to a steep border."""
        # A steep slope is that of a square root, b / (2 sqrt(h)), and b sqrt(h) is left of it;
        # twice that of other roots.
        if self.border is None:
            return 0.0
        orbit, problem = self.samples[-1].orbit, self.curve.problem
        image = orbit.taken[self.border[0]]
        k, d = image.place(self.border[1]), orbit.x.shape[1]
        away = abs(float(image.margins[k])) / max(norm(image.gradients[k]), SHORTEST_ROW)
        steep = float(np.abs(image.jacobian[:, :d]).max())
        if steep < STEEP or not math.isfinite(steep):
            return 0.0
        return 4.0 * steep * away * problem.p_scale[problem.free[0]] / problem.x_scale[0]


def follow(
    curve: SolutionCurve, start: Sample, first: float = math.inf, halt: Halt | None = None,
    origin: Sample | None = None,
) -> Arc:  # fmt: skip
    """Follow a curve from a sample to what ends it; the first step may be a shorter one.

    It closes where it comes back to its origin, by default the start. The loop is bounded: each
    turn keeps one of ``max_samples`` or shortens the step, down to ``min_step``.
    """
    settings, samples, grows, bent = curve.settings, [start], True, 0.0
    step = min(first, settings.step)
    given_up, halt = Stop.SHORT, halt or Halt()
    at_once = leaves(curve, start)
    if at_once is None and halt.asked is not None and halt.asked(start):
        at_once = Stop.ASKED
    if at_once is not None:
        return Arc((start,), at_once, curve)
    while len(samples) < settings.max_samples:
        if halt.spent():
            return Arc(tuple(samples), Stop.SPENT, curve)
        if step < settings.min_step:
            return Arc(tuple(samples), given_up, curve)
        last = samples[-1]
        before = samples[-2] if len(samples) > 1 else None
        found = to_end = _to_end(curve, last, step)
        found = found or curve.advance(last, step, before)
        turned = math.inf
        if found is not None and not _strays(curve, last, found, bent):
            turned = _angle(last, found) / settings.max_turn
        if found is None or turned > 1.0:
            step = _shorter(curve, step, max(0.25, min(0.5, KEPT_TURN / turned)))
            grows, given_up = False, Stop.SHORT
            continue
        try:
            ends = ends_between(curve, last, found, step, starts=len(samples) == 1)
            if halt.asked is not None:
                ends = asked_before(curve, last, found, step, ends, halt.asked)
        except UnclearError:
            step, grows, given_up = _shorter(curve, step, 0.5), False, Stop.SHORT
            continue
        end = ends[0] if ends else None
        if step > LOOKED and _differs_between(curve, last, found if end is None else end.sample):
            step, grows = 0.5 * step, False
            continue
        if not agrees(curve, found.orbit if end is None else end.sample.orbit, end):
            step, grows, given_up = _shorter(curve, step, 0.25), False, Stop.OTHER_PIECE
            continue
        if end is not None:
            beyond: Sample | None = found
            if len(ends) > 1:
                beyond = curve.advance(last, 0.5 * (end.distance + ends[1].distance))
            test = end.test
            return Arc(
                (*samples, end.sample), test.stop, curve, test.border, beyond, test.condition,
                step, end.width, test,
            )  # fmt: skip
        if to_end is not None:
            return Arc((*samples, to_end), Stop.SPAN, curve)
        home = start if origin is None else origin
        is_away = len(samples) > 2 or home is not start
        if is_away and _closes(curve, home, last, found, step):
            return Arc((*samples, home), Stop.CLOSED, curve)
        samples.append(found)
        bent = turned * settings.max_turn
        growth = min(2.0 if grows else 1.0, KEPT_TURN / max(turned, 1e-3))
        step, grows = min(settings.max_step, max(settings.min_step, step * growth)), True
    return Arc(tuple(samples), Stop.MANY, curve)


def leaves(curve: SolutionCurve, start: Sample) -> Stop | None:
    """Whether a sample lies at an end of span or window, or beyond, and the curve leaves."""
    orbit = start.orbit
    columns, low, high, stops = curve.bounds(orbit)
    at, along = orbit.unknowns[columns], curve.wide(start)[columns]
    out = ((at <= low) & (along < 0.0)) | ((at >= high) & (along > 0.0))
    return next((stop for stop, is_out in zip(stops, out, strict=True) if is_out), None)


def _to_end(curve: SolutionCurve, last: Sample, step: float) -> Sample | None:
    """The sample at the end of a span, if a step leads there: beyond, there may be no map."""
    orbit, problem = last.orbit, curve.problem
    size = orbit.x.size
    for j, (free, (low, high)) in enumerate(zip(problem.free, curve.settings.spans, strict=True)):
        rate, p = float(last.tangent[size + j]) * problem.p_scale[free], float(orbit.p[free])
        end = high if rate > 0.0 else low
        if rate == 0.0 or p == end or abs(end - p) >= step * abs(rate):
            continue
        guess = problem.moved(orbit, (end - p) / rate * last.tangent)
        found = solve(problem.with_(Held(size + free, end)), guess)
        if found.converged:
            sample = curve.start(held_at(found.orbit, size + free, end), last.tangent)
            return sample if np.isfinite(sample.tangent).all() else None
    return None


def _shorter(curve: SolutionCurve, step: float, part: float) -> float:
    """A part of a step; the shortest one is tried before any that would be too short."""
    least = curve.settings.min_step
    return least if part * step < least < step else part * step


def _strays(curve: SolutionCurve, a: Sample, b: Sample, bent: float) -> bool:
    """Whether a sample lies on another curve, though its tangent is much the same."""
    # It may be a shorter cycle, run through several times. A smooth curve follows the mean of its
    # tangents, within what their turn in this step, or the one before, allows.
    if a.orbit.outer is None and _comes_together(curve, a.orbit.x, b.orbit.x):
        return True
    chord = curve.problem.step_between(a.orbit, b.orbit)
    length, mean = norm(chord), a.tangent + b.tangent
    if length == 0.0:
        return True  # rounding lets it come no farther
    off = norm(chord / length - mean / norm(mean))
    return off > 0.5 * max(_angle(a, b), bent) + STRAIGHT + ROUNDED_OFF / length


def _comes_together(curve: SolutionCurve, a: Floats, b: Floats) -> bool:
    """Whether points (n, d) of a cycle that are apart at one sample are one at the next."""
    n, apart = len(a), curve.problem.apart
    divisors = [k for k in range(1, n) if n % k == 0]
    return any(
        apart(b, np.roll(b, k, axis=0)) < TOGETHER * apart(a, np.roll(a, k, axis=0))
        for k in divisors
    )


def agrees(curve: SolutionCurve, orbit: Orbit, end: ArcEnd | None = None) -> bool:
    """Whether the map takes the pieces of an orbit; points on borders do not count."""
    at_border = {orbit.place(i) for i, _ in curve.ignored}
    if end is not None and end.test.border is not None:
        at_border.add(orbit.place(end.test.border[0]))
    return all(
        i in at_border or _is_taken(curve, x, orbit.p, image)
        for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True))
    )


def _differs_between(curve: SolutionCurve, a: Sample, b: Sample) -> bool:
    """Whether the map takes another piece halfway: a margin may vanish that no sample has."""
    x = 0.5 * (a.orbit.x + b.orbit.x)
    p = 0.5 * (a.orbit.p + b.orbit.p)
    at_border = {a.orbit.place(i) for i, _ in curve.ignored}
    return any(
        i not in at_border
        and float(np.abs(image.jacobian).max()) < STEEP
        and not _takes(curve, point, p, image.piece)
        for i, (point, image) in enumerate(zip(x, a.orbit.images, strict=True))
    )


def _takes(curve: SolutionCurve, x: Floats, p: Floats, piece: Piece) -> bool:
    if margins_decide(curve.map):
        return _is_taken(curve, x, p, piece.at(x, p))
    return taken(curve.map, x, p)[0] == piece.key


def _is_taken(curve: SolutionCurve, x: Floats, p: Floats, image: Image) -> bool:
    """Whether the map takes the piece of an image, and the same of its solutions."""
    # A map whose margins decide is asked only where one of them vanishes but for rounding.
    if image.reason:
        return False
    if margins_decide(curve.map) and not image.tied(x, p).any():
        return bool((image.margins > 0.0).all())
    key, value = taken(curve.map, x, p)
    slack = SAME_VALUE * max(1.0, float(np.abs(image.jacobian).max()))
    return key == image.piece.key and curve.problem.same(value, image.value, slack)


def _closes(curve: SolutionCurve, start: Sample, a: Sample, b: Sample, step: float) -> bool:
    """Whether the curve passes its own start between two samples."""
    away = curve.problem.step_between(a.orbit, start.orbit)
    along = float(away @ a.tangent)
    aside = norm(away - along * a.tangent)
    return (
        0.0 < along <= step
        and aside <= step * curve.settings.max_turn
        and float(start.tangent @ b.tangent) > math.cos(2.0 * curve.settings.max_turn)
    )


def _angle(a: Sample, b: Sample) -> float:
    return math.acos(min(1.0, float(a.tangent @ b.tangent)))
