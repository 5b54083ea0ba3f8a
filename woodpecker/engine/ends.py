"""Events between two samples of a curve: bounds, borders, special multipliers, branch points.

If a zero of a test function may hide between the samples, StepTooLongError asks for a shorter step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import norm
from woodpecker.base.cubics import hermite_increment, hermite_root
from woodpecker.engine.curves import Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.newton import MAP_ROUNDING, STEEP, branch_point, solve
from woodpecker.engine.orbits import (
    AtLimit,
    Condition,
    Held,
    Multiplier,
    OnBorder,
    SpaceOrbit,
    held_at,
)

LOCATED = 2.0**-52  # scaled: tolerance of the distance of a zero, as fine as doubles allow
ZERO_REMAINDER = 2.0**-10  # of the smaller value at both ends: largest remainder that is a zero
ITERATIONS = 80  # of brentq: bisection alone takes fifty
# Scaled: a bound this close is met, and a flip this close to a fold cannot be told from it.
ROUNDED_OFF = 2.0**-44
BEGINS = 2.0**-20  # of a test function's value after a step: below it the start is a zero
# Of the smaller margin at the ends: a cubic that dips below it needs a closer look.
DIP_DEPTH = 0.25
PLACES = 8  # parts of a step: dips are sampled where one of these ends
# Of the slower rate at both ends: a margin must fall, or rise, at least that fast in between.
LEAST_RATE = 0.5
COARSE = 64.0  # times the shortest step: dips in shorter steps are not looked for
MOST_BOUNDS = 32  # passed in one step and located, each before the last one, at most
BRACKETED = 2.0**-14  # scaled: only in shorter steps is a zero bracketed if Newton's method fails
CHECK_HALFWAY = 2.0**-14  # scaled: in longer steps the map is also asked halfway, and before a root
NEAR = 1e-7  # scaled: a bound as near to the start of an arc may be where the arc comes from
ON_CIRCLE = 1e-7  # a pair whose modulus is as close to 1 lies on the unit circle
# Part of the way to a leap that the next step goes. Where two solutions of the event times merge,
# Newton's method may find either, so that the leap is located only roughly.
SHORT_OF_LEAP = 0.5
SUDDEN = 2.0**-10  # part of a step: a function large on both sides of so short a bracket leaps


class StepTooLongError(Exception):
    """A step leads to another curve, or an event may hide in it: ``part`` of it is to be tried.

    If even the shortest step fails, the curve ends by ``stop``.
    """

    def __init__(self, part: float = 0.5, stop: Stop = Stop.SHORT) -> None:
        self.part, self.stop = part, stop


class LeapError(StepTooLongError):
    """A test function changes its sign without a zero; a part of the step ends before that."""


class ArcEnd(NamedTuple):
    """What ends an arc between two samples: its distance from the first, and the sample there."""

    distance: float
    test: TestFunction
    sample: Sample
    width: float = 0.0  # the uncertainty of the distance


def ends_between(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, *, starts: bool
) -> list[ArcEnd]:
    """The events between two samples, by distance; StepTooLongError if one may have been missed."""
    bound = _bounded(curve, a, b, step)
    found = _multipliers(curve, a, b, step, starts) + ([] if bound is None else [bound])
    found = sorted(_told_apart(found), key=lambda end: end.distance)
    if bound is not None and found[0] is bound and step > CHECK_HALFWAY and _hides(curve, a, bound):
        raise StepTooLongError
    if found and found[0] is not bound and any(True for _ in _borders(curve, found[0].sample)):
        raise StepTooLongError  # a margin has vanished before
    last, distance = (found[0].sample, found[0].distance) if found else (b, step)
    _look_for_dips(curve, a, last, distance, starts=starts)
    return found


def _told_apart(ends: Sequence[ArcEnd]) -> list[ArcEnd]:
    """The events, in the order of tests, without those that rounding does not tell from others."""
    # Beside a root singularity a multiplier may pass both 1 and -1 from one double to the next:
    # that is a fold. Of a curve's own test functions that vanish at once the first one counts.
    kept, same = list[ArcEnd](), {Stop.PD: Stop.LP, Stop.SPECIAL: Stop.SPECIAL}
    for end in ends:
        others = [each for each in kept if each.test.stop is same.get(end.test.stop)]
        if all(abs(end.distance - each.distance) > ROUNDED_OFF for each in others):
            kept.append(end)
    return kept


def _hides(curve: SolutionCurve, a: Sample, bound: ArcEnd) -> bool:
    """Whether another event may hide before a bound at a root, where rounding is unbounded."""
    orbit = bound.sample.orbit
    if all(curve.problem.steepest(image) < STEEP for image in orbit.all_images):
        return False
    own = {*curve.ignored, bound.test.border}
    negative = (
        (i, code)
        for i, image in enumerate(orbit.all_images)
        for code in image.codes[image.margins < 0.0].tolist()
    )
    return any(each not in own for each in negative) or any(
        test.value(a) * test.value(bound.sample) < 0.0 for test in _special(curve, a.orbit)
    )


def first_where(
    curve: SolutionCurve, a: Sample, distance: float, b: Sample, holds: Callable[[Sample], bool]
) -> tuple[float, Sample]:
    """Where a condition that holds at a distance, and not at the first sample, begins to hold."""
    low, high, found = 0.0, distance, b
    while high - low > LOCATED:  # bisection
        middle = 0.5 * (low + high)
        sample = curve.advance(a, middle)
        if sample is None:
            raise StepTooLongError
        if holds(sample):
            high, found = middle, sample
        else:
            low = middle
    return high, found


def _multipliers(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, starts: bool
) -> list[ArcEnd]:
    """The zeros of multiplier tests (LP, PD, NS, BP) and of a curve's own test functions."""
    found = list[ArcEnd]()
    for test in _special(curve, a.orbit):
        before, after = test.value(a), test.value(b)
        is_at_end = _is_rounding(test, b, after, before)
        if not (before * after < 0.0 or is_at_end):
            continue  # also where a value is nan
        if max(abs(before), abs(after)) <= max(test.noise(a.orbit), test.noise(b.orbit)):
            continue
        if starts and abs(before) <= BEGINS * abs(after):
            continue  # the curve begins at this zero, up to rounding
        if test.stop is Stop.LP and found:
            continue  # at a branch point, as a pitchfork, one curve turns back
        if test.stop is Stop.BP:
            found.append(_crossed(curve, a, b, step, test))
            continue
        if is_at_end:
            end = _right_at_end(curve, a, b, step, test)
            found += [] if end is None else [end]
            continue
        test = _sharper_test(test, a, b)
        try:
            distance, sample = _located(curve, a, b, step, test)
        except LeapError:
            if not test.leaps:
                raise
            continue
        if test.stop is not Stop.NS or not _is_neutral_saddle(sample):
            left = abs(test.value(sample) / (test.value(b) - test.value(a)))
            found.append(ArcEnd(distance, test, sample, LOCATED + left * step))
    return found


def _is_rounding(test: TestFunction, sample: Sample, value: float, other: float) -> bool:
    """Whether the value of a test function at a sample is rounding, but not that at another."""
    # Rounding is rarely asked for: only it leaves so small a part of the other value.
    is_least = abs(value) <= BEGINS * abs(other) and other != 0.0
    return is_least and abs(value) <= test.noise(sample.orbit)


def _right_at_end(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction
) -> ArcEnd | None:
    """The zero of a test function that the second sample has met up to rounding, or None."""
    if test.stop is Stop.LP:
        onward = curve.advance(b, step)
        turn = 0.0 if onward is None else test.value(a) * test.value(onward)
        if turn == 0.0:  # the parameter also halts where a root in it ends the map
            raise StepTooLongError
        if turn > 0.0:
            return None  # an inflection
        if test.condition is not None:  # a tangent tells a fold to half digits
            found = solve(curve.problem.with_(test.condition), b.orbit)
            sample = curve.start(found.orbit, a.tangent)
            if found.converged and np.isfinite(sample.tangent).all():
                return ArcEnd(step, test, sample, LOCATED)
    # A jump may have closed before, as the piece beyond it ended. That is too thin to be seen at
    # last, where the line through two values leads on to zero.
    started, seen = test.value(a), curve.advance(a, (1.0 - SUDDEN) * step)

    def vanishes(at: Sample) -> bool:
        return _is_rounding(test, at, test.value(at), started)

    if seen is not None and vanishes(seen):
        first, sample = first_where(curve, a, step, b, vanishes)
        near, far = (curve.advance(a, (1.0 - k * SUDDEN) * first) for k in (1, 2))
        if near is not None and far is not None:
            value = test.value(near)
            off = SUDDEN * first * abs(value / (test.value(far) - value) - 1.0)
            if off < 0.25 * SUDDEN * first:  # else it vanishes like a higher power
                return ArcEnd(first, test, sample, LOCATED + 2.0 * off)
    return ArcEnd(step, test, b, LOCATED)


def begins_at_special(curve: SolutionCurve, a: Sample, b: Sample) -> bool:
    """Whether a test function vanishes at the first sample: a curve that begins there misses it."""
    values = [
        (abs(test.value(a)), abs(test.value(b)) - test.noise(b.orbit))
        for test in _special(curve, a.orbit)
    ]
    return any(after > 0.0 and before <= BEGINS * after for before, after in values)


def rounding_of_multipliers(orbit: SpaceOrbit, x_scale: tuple[float, ...] = (1.0,)) -> float:
    """The rounding error of test functions of multipliers, with lengths that count as 1.

    Each Jacobian of a piece is known to rounding, and is multiplied by those before and after it.
    """
    # Needed where such a function is zero all along: in maps that preserve areas, or have slope -1.
    d, lengths = orbit.x.shape[1], np.array(x_scale)
    steps = [image.jacobian[:, :d] * lengths / lengths[:, None] for image in orbit.images]
    before, after = [np.eye(d)], [np.eye(d)]
    for first, last in zip(steps, steps[::-1], strict=True):
        before.append(first @ before[-1])
        after.append(after[-1] @ last)
    sizes = [[float(np.linalg.norm(each)) for each in part] for part in (before, steps, after)]
    parts = zip(sizes[0][:-1], sizes[1], sizes[2][-2::-1], strict=True)
    rounded = sum(x * y * z / d for x, y, z in parts)  # the unit matrix has the norm sqrt(d)
    return float(ROUNDED_OFF * max(1.0, rounded) * max(1.0, sizes[0][-1]) ** (d - 1))


def _special(curve: SolutionCurve, orbit: SpaceOrbit) -> Iterator[TestFunction]:
    """The test functions LP, PD, NS and BP that a curve has, and its own."""
    yield from curve.own
    turns = len(curve.problem.free) == 1
    for stop in curve.tests:
        if stop is Stop.BP:
            yield TestFunction(stop, partial(_bordered, curve))
        else:
            test = _of_multiplier(stop, orbit.outer is None, curve.problem.x_scale, turns)
            if test is not None:
                yield test


@lru_cache
def _of_multiplier(
    stop: Stop, of_cycles: bool, x_scale: tuple[float, ...], turns: bool
) -> TestFunction | None:
    """The test function of LP, PD or NS, or None; LP in one parameter is a zero of its rate."""
    condition = Multiplier(stop.name) if of_cycles else None
    if stop is Stop.LP and turns:
        return TestFunction(stop, lambda sample: sample.ahead, condition)
    if condition is not None and (stop is Stop.PD or len(x_scale) > 1):
        noise = partial(rounding_of_multipliers, x_scale=x_scale)
        return TestFunction(stop, _of_condition(condition), condition, noise=noise)
    return None


def _bordered(curve: SolutionCurve, sample: Sample) -> float:
    """The determinant of the equations bordered with the tangent: it changes sign at a BP."""
    if not math.isnan(sample.bordered):
        return sample.bordered
    return float(np.linalg.det(np.vstack([curve.problem.matrix(sample.orbit), sample.tangent])))


def _sharper_test(test: TestFunction, a: Sample, b: Sample) -> TestFunction:
    """The test; of folds by the multiplier if that changes sign: tangents are less exact."""
    if test.stop is Stop.LP and test.condition is not None:
        exact = replace(test, value=_of_condition(test.condition))
        if exact.value(a) * exact.value(b) < 0.0:
            return exact
    return test


def _crossed(curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction) -> ArcEnd:
    """The branch point between two samples; StepTooLongError if it is not found."""
    before, after = test.value(a), test.value(b)
    way = curve.problem.step_between(a.orbit, b.orbit)
    guess = curve.problem.moved(a.orbit, before / (before - after) * way)
    orbit = branch_point(curve.problem, guess) if guess.is_defined else None
    if orbit is None:
        raise StepTooLongError
    away = curve.problem.step_between(a.orbit, orbit)
    distance = float(away @ a.tangent)
    aside = norm(away - distance * a.tangent)
    if not 0.0 <= distance <= step or aside > curve.settings.max_turn * step:
        raise StepTooLongError
    return ArcEnd(distance, test, Sample(orbit, a.tangent))


def _bounded(curve: SolutionCurve, a: Sample, b: Sample, step: float) -> ArcEnd | None:
    """The first bound on the way to the second sample, which is beyond it; None if within all."""
    # Locate the bound that seems to be first, and repeat from there until none was passed before.
    found = None
    for _ in range(MOST_BOUNDS):
        passed = [*_borders(curve, b), *_newly_beyond(curve, a, b)]
        if not passed:
            return found
        test = min(passed, key=lambda each: _part(each, a, b))
        before, is_coarse = test.value(a), step > COARSE * curve.settings.min_step
        if before <= NEAR and _is_at(a, test, before):
            if is_coarse:
                raise StepTooLongError  # shorter steps show whether the curve leaves right here
            return ArcEnd(0.0, test, a)
        if before < 0.0 or (before > 0.0 and is_coarse and _has_leapt(test, a, b)):
            raise StepTooLongError
        distance, sample = _located(curve, a, b, step, test)
        is_back = test.border is not None and curve.rate(sample, *test.border) > 0.0
        if is_back or (found is not None and distance >= found.distance):
            raise StepTooLongError  # it also vanished earlier, and has become positive again
        found = ArcEnd(distance, test, sample)
        b, step = sample, distance
    raise StepTooLongError


def _has_leapt(test: TestFunction, a: Sample, b: Sample) -> bool:
    """Whether a passed bound grows at both ends: it has leapt where another border was passed."""
    return test.rate is not None and test.rate(a) > 0.0 and test.rate(b) > 0.0


def _borders(curve: SolutionCurve, sample: Sample) -> Iterator[TestFunction]:
    """The margins that are negative at a sample, by more than rounding, as test functions."""
    orbit = sample.orbit
    for i, image in enumerate(orbit.all_images):
        negative = image.margins < 0.0
        if not negative.any():
            continue
        negative &= ~image.tied(orbit.x[orbit.point_of(i)], orbit.p)
        for code in image.codes[negative].tolist():
            if (i, code) not in curve.ignored:
                border, rate = OnBorder(i, code), partial(curve.rate, i=i, code=code)
                yield TestFunction(Stop.BORDER, _of_condition(border), border, (i, code), rate)


def _newly_beyond(curve: SolutionCurve, a: Sample, b: Sample) -> Iterator[TestFunction]:
    """Bounds beyond which the second sample lies; those of the window if the first is within."""
    scale = curve.problem.scale(a.orbit)
    for test in _bounds(curve, b):
        held = test.condition if test.stop is Stop.WINDOW else None
        if not isinstance(held, Held) or test.value(a) >= -ROUNDED_OFF * scale[held.column]:
            yield test
    before, after = _jump(a.orbit), _jump(b.orbit)
    if before * after < 0.0:  # both limits have passed the diagonal: s is in [0, 1] again
        for outer in (False, True):
            limit, side = AtLimit(outer), math.copysign(1.0, before if outer else -before)
            test = TestFunction(Stop.SHARE, partial(_signed, side, limit), limit)
            if test.value(b) < -ROUNDED_OFF * float(curve.problem.x_scale[0]):
                yield test


def _signed(side: float, condition: Condition, sample: Sample) -> float:
    return side * float(condition.residual(sample.orbit)[0])


def _jump(orbit: SpaceOrbit) -> float:
    """Outer minus inner limit of a jump crossing in R^1; 0 for other orbits."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return 0.0
    return float(orbit.outer.value[0] - orbit.images[-1].value[0])


def _bounds(curve: SolutionCurve, sample: Sample) -> Iterator[TestFunction]:
    """The ends of spans, window and share beyond which a sample lies, as test functions."""
    orbit = sample.orbit
    columns, low, high, stops = curve.bounds(orbit)
    at = orbit.unknowns[columns]
    for k in np.flatnonzero((at < low) | (at > high)).tolist():
        column = int(columns[k])
        end, inward = (low[k], 1.0) if at[k] < low[k] else (high[k], -1.0)
        condition: Condition = Held(column, float(end))
        if stops[k] is Stop.SHARE and orbit.x.shape[1] == 1:
            condition = AtLimit(end > 0.0)
        yield TestFunction(
            stops[k], _inside(column, float(end), inward), condition,
            rate=partial(_rate_of, curve, column=column, inward=inward),
        )  # fmt: skip


def _is_at(a: Sample, test: TestFunction, value: float) -> bool:
    """Whether a sample lies exactly on a bound, up to rounding."""
    if test.border is None:
        return abs(value) <= ROUNDED_OFF
    i, code = test.border
    image = a.orbit.all_images[i]
    return bool(image.tied(a.orbit.x[a.orbit.point_of(i)], a.orbit.p)[image.index_of(code)])


def _look_for_dips(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, *, starts: bool
) -> None:
    """StepTooLongError if a margin that is positive at both samples may vanish twice in between."""
    # A margin is modelled by the cubic of its values and slopes at both samples; one that only one
    # sample has, by a line. On the first step, whose start may have useless slopes (at a root), a
    # sample is taken where the cubic dips. A margin that falls at both samples, or rises at both,
    # but hardly changes so in between has leapt: it is not the same function all the way.
    if step < COARSE * curve.settings.min_step:
        return
    dips = dict[float, list[tuple[int, int, float]]]()
    both = zip(a.orbit.all_images, b.orbit.all_images, curve.rates(a), curve.rates(b), strict=True)
    for i, (one, other, before, after) in enumerate(both):
        falls, rises = step * before, step * after
        for k in np.flatnonzero(0.5 * one.margins + falls < 0.0).tolist():
            code = int(one.codes[k])
            if (i, code) in curve.ignored or not one.margins[k] > 0.0:
                continue
            m = other.index_of(code)
            if m < 0:
                if one.margins[k] + falls[k] < 0.0:
                    raise StepTooLongError
                continue
            ends = float(one.margins[k]), float(other.margins[m])
            rates = float(falls[k]), float(rises[m])
            if ends[1] > 0.0 and rates[1] > 0.0:
                part, least = _least(*ends, *rates)
                if least < DIP_DEPTH * min(ends):
                    if not starts:
                        raise StepTooLongError
                    dips.setdefault(part, []).append((i, code, DIP_DEPTH * min(ends)))
            if rates[1] < 0.0 and ends[1] - ends[0] > LEAST_RATE * max(rates):
                raise StepTooLongError
        for k in np.flatnonzero(0.5 * other.margins < rises).tolist():
            code = int(other.codes[k])
            if (i, code) in curve.ignored or not other.margins[k] > 0.0:
                continue
            m = one.index_of(code)
            if m < 0:
                if other.margins[k] < rises[k]:
                    raise StepTooLongError
                continue
            rates = float(falls[m]), float(rises[k])
            if rates[0] > 0.0 and other.margins[k] - one.margins[m] < LEAST_RATE * min(rates):
                raise StepTooLongError
    for part, margins in dips.items():
        lowest = curve.advance(a, part * step)
        if lowest is None or any(
            not lowest.orbit.margin(i, code) >= least for i, code, least in margins
        ):
            raise StepTooLongError


# --- Location of zeros ----------------------------------------------------------------------------


Seen = dict[float, tuple[Sample, float]]
"""Samples by their distances, and the values of a test function there."""


def _located(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction
) -> tuple[float, Sample]:
    """Distance and sample of the zero of a test function; StepTooLongError if it is not found."""
    quick = _solved(curve, a, b, step, test)
    if quick is not None:
        return quick
    before, after = test.value(a), test.value(b)
    seen: Seen = {0.0: (a, before), step: (b, after)}

    def value(distance: float) -> float:
        if distance not in seen:
            sample = curve.advance(a, distance, ahead=b)
            if sample is None:
                raise ArithmeticError
            seen[distance] = sample, test.value(sample)
            if not test.leaps and _is_leap(seen, step):
                raise _leap(seen, step)
        return seen[distance][1]

    if math.isnan(before):
        raise StepTooLongError  # only the second sample has it: how it became negative is unknown
    try:
        brentq(value, 0.0, step, xtol=min(LOCATED, ZERO_REMAINDER**2 * step), maxiter=ITERATIONS)
    except (ArithmeticError, RuntimeError, ValueError):  # no sample, no convergence, nan
        raise StepTooLongError from None
    distance = min(seen, key=lambda each: abs(seen[each][1]))
    sample = seen[distance][0]
    noise = abs(after - before) * MAP_ROUNDING / step  # since orbits are known to MAP_ROUNDING
    if not abs(test.value(sample)) <= ZERO_REMAINDER * min(abs(before), abs(after)) + noise:
        raise _leap(seen, step)
    return distance, sample


def _bracket(seen: Seen) -> tuple[float, float]:
    """The last distance at which a function has the sign of its start, and the next distance."""
    before = seen[0.0][1]
    same = {each for each, (_, value) in seen.items() if value * before > 0.0}
    return max(same, default=0.0), min(seen.keys() - same)


def _is_leap(seen: Seen, step: float) -> bool:
    """Whether a function that changes its sign is not small on either side of the change."""
    # A zero in a bracket of relative width w has values up to w^(1/4) of the smaller value at both
    # ends (a root of a square root), or, close to one end, up to w^(1/2) of the larger one.
    low, high = _bracket(seen)
    width, ends = (high - low) / step, [abs(seen[0.0][1]), abs(seen[step][1])]
    least = min(abs(seen[low][1]), abs(seen[high][1]))
    expected = max(math.sqrt(math.sqrt(width)) * min(ends), math.sqrt(width) * max(ends))
    return 0.0 < width <= SUDDEN and least > expected


def _leap(seen: Seen, step: float) -> LeapError:
    """The error to raise where a function leaps: the next step ends before the leap."""
    return LeapError(SHORT_OF_LEAP * _bracket(seen)[0] / step or 0.5)


def _solved(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction
) -> tuple[float, Sample] | None:
    """The zero of a test by Newton's method from a cubic guess; None if it is not in between."""
    if test.condition is None or test.rate is None:
        return None
    found = solve(curve.problem.with_(test.condition), _guess(curve, a, b, test))
    if not found.converged:
        if step > BRACKETED:
            raise StepTooLongError
        return None
    orbit = found.orbit
    if isinstance(test.condition, Held):
        orbit = held_at(orbit, test.condition.column, test.condition.value)
    elif isinstance(test.condition, AtLimit):
        orbit = replace(orbit, share=float(test.condition.outer))
    sample = curve.start(orbit, a.tangent)
    away = curve.problem.step_between(a.orbit, found.orbit)
    distance = float(away @ a.tangent)
    aside = norm(away - distance * a.tangent)
    is_there = aside <= curve.settings.max_turn * step and 0.0 <= distance <= step
    if not (is_there and np.isfinite(sample.tangent).all()):
        if step > COARSE * curve.settings.min_step:
            raise StepTooLongError  # a zero elsewhere: there need not be one in between
        return None
    return distance, sample


def _guess(curve: SolutionCurve, a: Sample, b: Sample, test: TestFunction) -> SpaceOrbit:
    """The guess for a zero of a test function: that of the cubic of its values and rates."""
    assert test.rate is not None
    before, after = test.value(a), test.value(b)
    if math.isnan(before):  # only the second sample has this margin
        return b.orbit
    chord = curve.problem.step_between(a.orbit, b.orbit)
    length = norm(chord)
    part = hermite_root(before, after, length * test.rate(a), length * test.rate(b))
    step = hermite_increment(part, chord, length * a.tangent, length * b.tangent)
    return curve.problem.moved(a.orbit, step)


def _rate_of(curve: SolutionCurve, sample: Sample, column: int, inward: float) -> float:
    """The rate at which an unknown moves inwards along the curve."""
    return inward * float(curve.all_rates(sample)[column])


def _inside(column: int, end: float, inward: float) -> Callable[[Sample], float]:
    return lambda sample: inward * float(sample.orbit.unknowns[column] - end)


def _of_condition(condition: Condition) -> Callable[[Sample], float]:
    return lambda sample: float(condition.residual(sample.orbit)[0])


def _is_neutral_saddle(sample: Sample) -> bool:
    """Whether no complex pair lies on the unit circle: then two real ones have the product 1."""
    multipliers = sample.orbit.multipliers()
    pairs = [each for each in multipliers if abs(each.imag) > 0.0]
    return not any(abs(abs(each) - 1.0) < ON_CIRCLE for each in pairs)


def _least(a: float, b: float, da: float, db: float) -> tuple[float, float]:
    """Where in (0, 1) a cubic with values a, b and slopes da < 0 < db is least, and its minimum."""
    # The place is rounded to one of PLACES, so that one sample may serve several margins.
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = math.sqrt(max(0.0, c2 * c2 - 3.0 * c3 * da))
    s = -da / (c2 + root) if c2 + root > 0.0 else 1.0
    least = a + s * (da + s * (c2 + s * c3)) if 0.0 < s < 1.0 else min(a, b)
    return min(max(round(s * PLACES), 1), PLACES - 1) / PLACES, least


def _part(test: TestFunction, a: Sample, b: Sample) -> tuple[bool, float]:
    """The part of the way at which a bound is passed, by linear interpolation, as a sort key."""
    # A passed bound that grows at the second sample comes last: it has leapt at another border.
    before, after = test.value(a), test.value(b)
    rises = test.rate is not None and test.rate(b) > 0.0
    is_known = not math.isnan(before) and before != after  # else nothing can be interpolated
    return rises, before / (before - after) if is_known else math.inf
