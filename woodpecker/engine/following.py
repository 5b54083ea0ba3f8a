"""Follow a curve by predictor, corrector and step control, from a sample to what ends it.

An *arc* is a part of a curve on which no piece changes and no test function changes sign.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.ends import (
    CHECK_HALFWAY,
    LOCATED,
    ROUNDED_OFF,
    ArcEnd,
    StepTooLongError,
    ends_between,
    first_where,
)
from woodpecker.engine.maps import SpacePiece, margins_decide, taken
from woodpecker.engine.newton import STEEP, solve
from woodpecker.engine.orbits import Held, held_at
from woodpecker.engine.rooted import extended_to_root, is_steep

STRAIGHT = 1e-4  # angle between chord and mean tangent that every smooth curve may have [rad]
KEPT_TURN = 0.7  # of the largest turn: aimed at in the next step, so that few steps are refused
# A turn that is so many times sharper than in the step before, or than a slight one [rad], may be
# the leap to another solution of the event times.
SUDDEN_TURN, SLIGHT_TURN = 16.0, 1e-3
CLOSE = 2.0**-14  # scaled: only refused steps shorter than this suggest the end of a root
# Bound of the change of a margin in a step: a multiple of what the larger of its rates at both ends
# predicts, plus a part of its size for rounding.
LARGEST_CHANGE, LARGEST_CHANGE_PART = 4.0, 2.0**-20
MERGED_PART = 2.0**-8  # of their previous distance: points of a cycle closer than this have merged


class StopRequests(NamedTuple):
    """Reasons from outside to end a curve."""

    spent: Callable[[], bool] = lambda: False  # whether no evaluation of the map is left
    # whether the curve is to end at a sample; None if there is no such request
    asked: Callable[[Sample], bool] | None = None


class _Step(NamedTuple):
    """An accepted step along a curve."""

    sample: Sample
    ends: list[ArcEnd]  # the zeros of test functions in this step, by distance
    turn: float  # of the tangent [rad]
    is_last: bool  # whether it ends exactly at the end of the span


def follow(
    curve: SolutionCurve, start: Sample, first: float = math.inf, halt: StopRequests | None = None,
    origin: Sample | None = None,
) -> Arc:  # fmt: skip
    """Follow a curve from a sample to what ends it; ``first`` may shorten the first step.

    A curve closes where it comes back to ``origin``, by default its start. The loop is bounded:
    each pass adds one of ``max_samples`` or shortens the step, down to ``min_step``.
    """
    settings, samples, grows, turn = curve.settings, [start], True, 0.0
    step = min(first, settings.step)
    given_up, halt = Stop.SHORT, halt or StopRequests()
    home = start if origin is None else origin
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
        try:
            taken = _step(curve, samples, step, turn, halt)
        except StepTooLongError as refused:
            so_far = Arc(tuple(samples), given_up, curve)
            ended = extended_to_root(so_far, step) if step < CLOSE else None
            if ended is not None:
                return ended
            step, grows, given_up = _shorter(curve, step, refused.part), False, refused.stop
            continue
        is_away = len(samples) > 2 or home is not start
        if is_away and _closes(curve, home, samples[-1], taken, step):
            return Arc((*samples, home), Stop.CLOSED, curve)
        if taken.ends:
            return _ended(curve, samples, taken, step)
        if taken.is_last:
            return Arc((*samples, taken.sample), Stop.SPAN, curve)
        samples.append(taken.sample)
        turn = taken.turn
        # Double the step, but not after a refusal, nor beyond where it would turn by KEPT_TURN.
        growth = 2.0 if grows else 1.0
        if growth * turn > KEPT_TURN * settings.max_turn:
            growth = KEPT_TURN * settings.max_turn / turn
        step, grows = min(settings.max_step, max(settings.min_step, step * growth)), True
    return Arc(tuple(samples), Stop.MANY, curve)


def _step(
    curve: SolutionCurve, samples: Sequence[Sample], step: float, bent: float, halt: StopRequests
) -> _Step:
    """A step from the last sample; ``bent`` is the angle by which the last step turned."""
    # StepTooLongError if it leads to another curve, or a zero of a test function could hide in it.
    last, before = samples[-1], samples[-2] if len(samples) > 1 else None
    at_end = to_end(curve, last, step)
    found = at_end or curve.advance(last, step, before)
    turn, most = math.inf, curve.settings.max_turn
    if found is not None and not _is_on_other_curve(curve, last, found, bent):
        turn = angle(last, found)
    is_sudden = before is not None and turn > SUDDEN_TURN * max(bent, SLIGHT_TURN)
    if found is None or turn > most or (is_sudden and step > CLOSE):
        raise StepTooLongError(max(0.25, min(0.5, KEPT_TURN * most / turn)))
    ends = ends_between(curve, last, found, step, starts=before is None)
    if halt.asked is not None:
        ends = _asked_before(curve, last, found, step, ends, halt.asked)
    sample, border = (ends[0].sample, ends[0].test.border) if ends else (found, None)
    if math.isnan(sample.orbit.share):
        raise StepTooLongError  # a limit has no value, as may happen beyond a border
    if step > CHECK_HALFWAY and _differs_between(curve, last, sample):
        raise StepTooLongError
    if not curve.agrees(sample.orbit, border, is_last=sample is at_end):
        raise StepTooLongError(0.25, Stop.OTHER_PIECE)
    return _Step(found, ends, turn, at_end is not None)


def _asked_before(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, ends: list[ArcEnd],
    asked: Callable[[Sample], bool],
) -> list[ArcEnd]:  # fmt: skip
    """The events, and before them the point at which the caller asks the curve to end."""
    last = ends[0].sample if ends else b
    if not asked(last):
        return ends
    test = TestFunction(Stop.ASKED, lambda sample: float(asked(sample)))
    first, found = first_where(curve, a, ends[0].distance if ends else step, last, asked)
    return [ArcEnd(first, test, found, LOCATED), *ends]


def _ended(curve: SolutionCurve, samples: Sequence[Sample], last: _Step, step: float) -> Arc:
    """The arc that ends with the first zero in its last step."""
    end, *others = last.ends
    beyond: Sample | None = last.sample
    if others:
        beyond = curve.advance(samples[-1], 0.5 * (end.distance + others[0].distance))
    test = end.test
    return Arc(
        (*samples, end.sample), test.stop, curve, test.border, beyond, test.condition, step,
        end.width, test,
    )  # fmt: skip


def leaves(curve: SolutionCurve, start: Sample) -> Stop | None:
    """The bound at or beyond which a sample lies, if the curve leads farther out; else None."""
    # A window is left by points within it: others may lie anywhere.
    orbit = start.orbit
    columns, low, high, stops = curve.bounds(orbit)
    at, along = orbit.unknowns[columns], curve.all_rates(start)[columns]
    out = ((at <= low) & (along < 0.0)) | ((at >= high) & (along > 0.0))
    far = np.maximum(low - at, at - high) > ROUNDED_OFF * curve.problem.scale(orbit)[columns]
    out &= ~(far & np.array([stop is Stop.WINDOW for stop in stops]))
    return next((stop for stop, is_out in zip(stops, out, strict=True) if is_out), None)


def to_end(curve: SolutionCurve, last: Sample, step: float) -> Sample | None:
    """The sample exactly at the end of a span if a step would pass it: the map may end there."""
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
            if np.isfinite(sample.tangent).all():
                return sample
            if np.isfinite(problem.matrix(sample.orbit)).all():  # a branch point right at the end
                return Sample(sample.orbit, last.tangent)
    return None


def _shorter(curve: SolutionCurve, step: float, part: float) -> float:
    """A part of a step; before it is too short, the shortest allowed step is tried."""
    least = curve.settings.min_step
    return least if part * step < least < step else part * step


def _is_on_other_curve(curve: SolutionCurve, a: Sample, b: Sample, bent: float) -> bool:
    """Whether the corrector has come to another curve, though the tangent has hardly changed."""
    # That may be a shorter cycle, repeated. The chord of a smooth curve has the direction of the
    # mean tangent, up to the angle by which the curve turns in this step or the one before.
    if a.orbit.outer is None and _points_merge(curve, a.orbit.x, b.orbit.x):
        return True
    chord = curve.problem.step_between(a.orbit, b.orbit)
    length, mean = norm(chord), a.tangent + b.tangent
    if length == 0.0 or _leaps(curve, a, b, length):
        return True  # no progress beyond rounding, or another event time
    off = norm(chord / length - mean / norm(mean))
    return off > 0.5 * max(angle(a, b), bent) + STRAIGHT + ROUNDED_OFF / length


def _leaps(curve: SolutionCurve, a: Sample, b: Sample, length: float) -> bool:
    """Whether a margin changes in a step by more than its rates at both ends allow."""
    # Beyond a root singularity the same events may be found at other times, with moderate slopes.
    for n, (one, other) in enumerate(zip(a.orbit.all_images, b.orbit.all_images, strict=True)):
        if not is_steep(one, other):
            continue
        both, i, k = np.intersect1d(one.codes, other.codes, True, return_indices=True)
        moves = np.array([(n, code) not in curve.ignored for code in both.tolist()], dtype=bool)
        i, k = i[moves], k[moves]
        ends = one.margins[i], other.margins[k]
        rates = np.maximum(np.abs(curve.rates(a)[n][i]), np.abs(curve.rates(b)[n][k]))
        size = np.maximum(np.abs(ends[0]), np.abs(ends[1]))
        if (
            np.abs(ends[1] - ends[0]) > LARGEST_CHANGE * length * rates + LARGEST_CHANGE_PART * size
        ).any():
            return True
    return False


def _points_merge(curve: SolutionCurve, a: Floats, b: Floats) -> bool:
    """Whether points (n, d) of a cycle that were apart have merged at the next sample."""
    n, apart = len(a), curve.problem.apart
    divisors = [k for k in range(1, n) if n % k == 0]
    return any(apart(b[k:], b[:-k]) < MERGED_PART * apart(a[k:], a[:-k]) for k in divisors)


def _differs_between(curve: SolutionCurve, a: Sample, b: Sample) -> bool:
    """Whether the map takes another piece halfway: a margin that neither sample has may vanish."""
    x = 0.5 * (a.orbit.x + b.orbit.x)
    p = 0.5 * (a.orbit.p + b.orbit.p)
    at_border = {a.orbit.point_of(i) for i, _ in curve.ignored}
    return any(
        i not in at_border
        and curve.problem.steepest(image) < STEEP
        and not _takes(curve, point, p, image.piece)
        for i, (point, image) in enumerate(zip(x, a.orbit.images, strict=True))
    )


def _takes(curve: SolutionCurve, x: Floats, p: Floats, piece: SpacePiece) -> bool:
    if margins_decide(curve.map):
        return curve.takes(x, p, piece.at(x, p))
    return taken(curve.map, x, p)[0] == piece.key


def _closes(curve: SolutionCurve, start: Sample, a: Sample, taken: _Step, step: float) -> bool:
    """Whether the curve passes its start in this step, in its direction, before what ends it."""
    there, length = taken.sample, step
    if taken.ends:
        there, length = taken.ends[0].sample, taken.ends[0].distance - ROUNDED_OFF
    away = curve.problem.step_between(a.orbit, start.orbit)
    along = float(away @ a.tangent)
    aside = norm(away - along * a.tangent)
    return (
        0.0 < along <= length
        and aside <= step * curve.settings.max_turn
        and float(start.tangent @ there.tangent) > math.cos(2.0 * curve.settings.max_turn)
    )


def angle(a: Sample, b: Sample) -> float:
    """The angle between two tangents [rad]; 0 if one is unknown."""
    return math.acos(max(-1.0, min(1.0, float(a.tangent @ b.tangent))))
