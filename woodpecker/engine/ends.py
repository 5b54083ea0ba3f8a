"""What ends an arc between two samples of a curve: bounds, borders, multipliers, curves that cross.

Where it is not clear what lies between two samples, TooLongError asks for a shorter step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import norm
from woodpecker.base.cubics import on_cubic, zero_of_cubic
from woodpecker.engine.curves import Sample, SolutionCurve, Stop, TestFunction
from woodpecker.engine.newton import BLUR, STEEP, branch_point, solve
from woodpecker.engine.orbits import (
    AtLimit,
    Condition,
    Held,
    Multiplier,
    OnBorder,
    SpaceOrbit,
    held_at,
)

LOCATED = 2.0**-52  # scaled: a zero of a test function is bracketed as closely as doubles allow
CLOSED_IN = 2.0**-10  # of its values at both ends: what is left of one that does vanish
ITERATIONS = 80  # of that: halvings alone take fifty
# Scaled: a bound that is nearer than this is met, and a flip that near cannot be told from a fold.
ROUNDED_OFF = 2.0**-44
BEGINS = 2.0**-20  # of a test function after a step: what rounding leaves of one that was zero
WORTH = 0.25  # part of a margin that is left where it dips: less is worth a look
PLACES = 8  # parts of a step: a dip is looked at where one of them ends
STEADY = 0.5  # of the smaller rate at both ends: by how much a margin falls at least in between
COARSE = 64.0  # least steps: a dip of a margin in a shorter step is left alone
MOST_BOUNDS = 32  # that are passed in a step, each before the last: more are left to shorter steps
BRACKETED = 2.0**-14  # scaled: only in shorter steps a zero is bracketed if Newton finds none
LOOKED = 2.0**-14  # scaled: in longer steps more is looked for, halfway and before a root
NEAR = 1e-7  # scaled: a bound that is nearer than this where an arc begins is where it comes from
# Of the way to a leap: the next step. Where two solutions of a path meet Newton's method finds
# either, and a function leaps somewhat before or beyond the place of that.
SHORT_OF_LEAP = 0.5
SUDDEN = 2.0**-10  # of a step: a function that is not small at both ends of that leaps in between


class TooLongError(Exception):
    """A step leads elsewhere, or what lies on it is not clear: a part of it may do.

    If none does the curve ends by ``stop``.
    """

    def __init__(self, part: float = 0.5, stop: Stop = Stop.SHORT) -> None:
        self.part, self.stop = part, stop


class LeapError(TooLongError):
    """A test function changes its sign without being zero; a part of the step ends before that."""


class ArcEnd(NamedTuple):
    """What may end an arc between two samples: at which distance from the first, and where."""

    distance: float
    test: TestFunction
    sample: Sample
    width: float = 0.0  # how far the distance may be off


def ends_between(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, *, starts: bool
) -> list[ArcEnd]:
    """What ends the arc between two samples, by distance; TooLongError if that is not clear."""
    bound = _bounded(curve, a, b, step)
    found = _multipliers(curve, a, b, step, starts) + ([] if bound is None else [bound])
    found = _told_apart(sorted(found, key=lambda end: end.distance))
    if bound is not None and found[0] is bound and step > LOOKED and _hides(curve, a, bound):
        raise TooLongError
    if found and found[0] is not bound and any(True for _ in _borders(curve, found[0].sample)):
        raise TooLongError  # a margin has vanished before
    last, distance = (found[0].sample, found[0].distance) if found else (b, step)
    _look_for_dips(curve, a, last, distance, starts=starts)
    return found


def _told_apart(ends: list[ArcEnd]) -> list[ArcEnd]:
    """What ends an arc, without flips that rounding does not tell from a fold."""
    # At the end of a root a multiplier may run through 1 and -1 from one double to the next.
    folds = [end for end in ends if end.test.stop is Stop.LP]
    return [
        end
        for end in ends
        if end.test.stop is not Stop.PD
        or all(abs(end.distance - fold.distance) > ROUNDED_OFF for fold in folds)
    ]


def _hides(curve: SolutionCurve, a: Sample, bound: ArcEnd) -> bool:
    """Whether more may have happened before a root of the map, where rounding has no bound."""
    orbit = bound.sample.orbit
    if all(curve.problem.steepest(image) < STEEP for image in orbit.taken):
        return False
    own = {*curve.ignored, bound.test.border}
    negative = (
        (i, code)
        for i, image in enumerate(orbit.taken)
        for code in image.codes[image.margins < 0.0].tolist()
    )
    return any(each not in own for each in negative) or any(
        test.value(a) * test.value(bound.sample) < 0.0 for test in _special(curve, a.orbit)
    )


def asked_before(
    curve: SolutionCurve,
    a: Sample,
    b: Sample,
    step: float,
    ends: list[ArcEnd],
    asked: Callable[[Sample], bool],
) -> list[ArcEnd]:
    """The ends, and before them the place where the curve is asked to end."""
    last = ends[0].sample if ends else b
    if not asked(last):
        return ends
    low, high, found = 0.0, ends[0].distance if ends else step, last
    while high - low > LOCATED:  # halved each time
        middle = 0.5 * (low + high)
        sample = curve.advance(a, middle)
        if sample is None:
            raise TooLongError
        if asked(sample):
            high, found = middle, sample
        else:
            low = middle
    test = TestFunction(Stop.ASKED, lambda sample: float(asked(sample)))
    return [ArcEnd(high, test, found, high - low), *ends]


def _multipliers(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, starts: bool
) -> list[ArcEnd]:
    """Where multipliers are 1 or -1, or pairs of them on the unit circle, or curves cross."""
    found = list[ArcEnd]()
    for test in _special(curve, a.orbit):
        before, after = test.value(a), test.value(b)
        if not (before * after < 0.0 or (after == 0.0 and abs(before) > 0.0)):
            continue  # nan vanishes nowhere
        if max(abs(before), abs(after)) <= max(test.noise(a.orbit), test.noise(b.orbit)):
            continue
        if starts and abs(before) <= BEGINS * abs(after):
            continue  # the curve begins where it vanishes, but for rounding
        if test.stop is Stop.LP and found:
            continue  # where curves cross one of them may turn round
        if test.stop is Stop.BP:
            found.append(_crossed(curve, a, b, step, test))
            continue
        test = _exact(test, a, b)
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


def begins_at_special(curve: SolutionCurve, a: Sample, b: Sample) -> bool:
    """Whether a test vanishes at the first of two samples: no curve that begins there sees that."""
    values = [
        (abs(test.value(a)), abs(test.value(b)) - test.noise(b.orbit))
        for test in _special(curve, a.orbit)
    ]
    return any(after > 0.0 and before <= BEGINS * after for before, after in values)


def rounding_of_multipliers(orbit: SpaceOrbit, x_scale: tuple[float, ...] = (1.0,)) -> float:
    """What rounding leaves of functions of multipliers that vanish, with lengths that count as 1.

    Each derivative of a piece is known to rounding, and is multiplied by those before and after.
    """
    # They may vanish all along: where the map preserves areas, or a slope is -1 / p after one of p.
    d, lengths = orbit.x.shape[1], np.array(x_scale)
    steps = [image.jacobian[:, :d] * lengths / lengths[:, None] for image in orbit.images]
    before, after = [np.eye(d)], [np.eye(d)]
    for first, last in zip(steps, steps[::-1], strict=True):
        before.append(first @ before[-1])
        after.append(after[-1] @ last)
    sizes = [[float(np.linalg.norm(each)) for each in part] for part in (before, steps, after)]
    parts = zip(sizes[0][:-1], sizes[1], sizes[2][-2::-1], strict=True)
    rounded = sum(x * y * z / d for x, y, z in parts)  # the matrix 1 has the size sqrt(d)
    return float(ROUNDED_OFF * max(1.0, rounded) * max(1.0, sizes[0][-1]) ** (d - 1))


def _special(curve: SolutionCurve, orbit: SpaceOrbit) -> Iterator[TestFunction]:
    """Folds, flips, pairs on the unit circle, branch points, and functions of its own."""
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
    """The test of a multiplier; of folds, where a curve in one parameter turns round."""
    condition = Multiplier(stop.name) if of_cycles else None
    if stop is Stop.LP and turns:
        return TestFunction(stop, lambda sample: sample.ahead, condition)
    if condition is not None and (stop is Stop.PD or len(x_scale) > 1):
        noise = partial(rounding_of_multipliers, x_scale=x_scale)
        return TestFunction(stop, _of_condition(condition), condition, noise=noise)
    return None


def _bordered(curve: SolutionCurve, sample: Sample) -> float:
    """The determinant of the equations bordered with the tangent."""
    if not math.isnan(sample.bordered):
        return sample.bordered
    return float(np.linalg.det(np.vstack([curve.problem.matrix(sample.orbit), sample.tangent])))


def _exact(test: TestFunction, a: Sample, b: Sample) -> TestFunction:
    """The test, or at a fold its condition: multipliers are known better than tangents there."""
    if test.stop is Stop.LP and test.condition is not None:
        exact = replace(test, value=_of_condition(test.condition))
        if exact.value(a) * exact.value(b) < 0.0:
            return exact
    return test


def _crossed(curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction) -> ArcEnd:
    """Where another curve crosses between two samples; TooLongError if it is not found."""
    before, after = test.value(a), test.value(b)
    way = curve.problem.step_between(a.orbit, b.orbit)
    guess = curve.problem.moved(a.orbit, before / (before - after) * way)
    orbit = branch_point(curve.problem, guess) if guess.is_defined else None
    if orbit is None:
        raise TooLongError
    away = curve.problem.step_between(a.orbit, orbit)
    distance = float(away @ a.tangent)
    aside = norm(away - distance * a.tangent)
    if not 0.0 <= distance <= step or aside > curve.settings.max_turn * step:
        raise TooLongError
    return ArcEnd(distance, test, Sample(orbit, a.tangent))


def _bounded(curve: SolutionCurve, a: Sample, b: Sample, step: float) -> ArcEnd | None:
    """Where the first bound is passed of those that the second of two samples lies beyond."""
    # The one that seems first is located, until none has been passed before it.
    found = None
    for _ in range(MOST_BOUNDS):
        passed = [*_borders(curve, b), *_newly_beyond(curve, a, b)]
        if not passed:
            return found
        test = min(passed, key=lambda each: _part(each, a, b))
        before, is_coarse = test.value(a), step > COARSE * curve.settings.min_step
        if before <= NEAR and _is_at(a, test, before):
            if is_coarse:
                raise TooLongError  # a shorter step shows whether the curve leaves right here
            return ArcEnd(0.0, test, a)
        if before < 0.0 or (before > 0.0 and is_coarse and _has_leapt(test, a, b)):
            raise TooLongError
        distance, sample = _located(curve, a, b, step, test)
        is_back = test.border is not None and curve.rate(sample, *test.border) > 0.0
        if is_back or (found is not None and distance >= found.distance):
            raise TooLongError  # it has vanished before, and is back
        found = ArcEnd(distance, test, sample)
        b, step = sample, distance
    raise TooLongError


def _has_leapt(test: TestFunction, a: Sample, b: Sample) -> bool:
    """Whether a bound that has been passed rises at both ends: it leapt at another border."""
    return test.rate is not None and test.rate(a) > 0.0 and test.rate(b) > 0.0


def _borders(curve: SolutionCurve, sample: Sample) -> Iterator[TestFunction]:
    """Margins that are negative at a sample, by more than rounding."""
    orbit = sample.orbit
    for i, image in enumerate(orbit.taken):
        negative = image.margins < 0.0
        if not negative.any():
            continue
        negative &= ~image.tied(orbit.x[orbit.place(i)], orbit.p)
        for code in image.codes[negative].tolist():
            if (i, code) not in curve.ignored:
                border, rate = OnBorder(i, code), partial(curve.rate, i=i, code=code)
                yield TestFunction(Stop.BORDER, _of_condition(border), border, (i, code), rate)


def _newly_beyond(curve: SolutionCurve, a: Sample, b: Sample) -> Iterator[TestFunction]:
    """Bounds that the second sample lies beyond; those of the window only if the first does not."""
    for test in _bounds(curve, b):
        if test.stop is not Stop.WINDOW or test.value(a) >= -ROUNDED_OFF:
            yield test
    before, after = _jump(a.orbit), _jump(b.orbit)
    if before * after < 0.0:  # both limits pass the diagonal, so that the share is inside again
        for outer in (False, True):
            limit, side = AtLimit(outer), math.copysign(1.0, before if outer else -before)
            test = TestFunction(Stop.SHARE, partial(_signed, side, limit), limit)
            if test.value(b) < -ROUNDED_OFF * float(curve.problem.x_scale[0]):
                yield test


def _signed(side: float, condition: Condition, sample: Sample) -> float:
    return side * float(condition.residual(sample.orbit)[0])


def _jump(orbit: SpaceOrbit) -> float:
    """The outer limit less the inner one of a jump crossing in R^1; 0 of others."""
    if orbit.outer is None or orbit.x.shape[1] > 1:
        return 0.0
    return float(orbit.outer.value[0] - orbit.images[-1].value[0])


def _bounds(curve: SolutionCurve, sample: Sample) -> Iterator[TestFunction]:
    """Ends of spans, of the window and of the share that a sample lies beyond."""
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
    """Whether a bound holds with equality at a sample, but for rounding."""
    if test.border is None:
        return abs(value) <= ROUNDED_OFF
    i, code = test.border
    image = a.orbit.taken[i]
    return bool(image.tied(a.orbit.x[a.orbit.place(i)], a.orbit.p)[image.place(code)])


def _look_for_dips(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, *, starts: bool
) -> None:
    """TooLongError if a margin that is positive at both ends may be negative in between."""
    # It is taken for the cubic of its values and slopes at both ends; a margin of one end only is
    # taken for linear. At a start at a root, where slopes say nothing, the curve is looked at where
    # the cubic dips. A margin that falls at both ends, but by much less in between, is not the same
    # all the way.
    if step < COARSE * curve.settings.min_step:
        return
    dips = dict[float, list[tuple[int, int, float]]]()
    both = zip(a.orbit.taken, b.orbit.taken, curve.rates(a), curve.rates(b), strict=True)
    for i, (one, other, before, after) in enumerate(both):
        falls, rises = step * before, step * after
        for k in np.flatnonzero(0.5 * one.margins + falls < 0.0).tolist():
            code = int(one.codes[k])
            if (i, code) in curve.ignored or not one.margins[k] > 0.0:
                continue
            m = other.place(code)
            if m < 0:
                if one.margins[k] + falls[k] < 0.0:
                    raise TooLongError
                continue
            ends = float(one.margins[k]), float(other.margins[m])
            rates = float(falls[k]), float(rises[m])
            if ends[1] > 0.0 and rates[1] > 0.0:
                part, least = _least(*ends, *rates)
                if least < WORTH * min(ends):
                    if not starts:
                        raise TooLongError
                    dips.setdefault(part, []).append((i, code, WORTH * min(ends)))
            if rates[1] < 0.0 and ends[1] - ends[0] > STEADY * max(rates):
                raise TooLongError
        for k in np.flatnonzero(other.margins < rises).tolist():
            code = int(other.codes[k])
            inside = other.margins[k] > 0.0 and (i, code) not in curve.ignored
            if inside and one.place(code) < 0:
                raise TooLongError
    for part, margins in dips.items():
        lowest = curve.advance(a, part * step)
        if lowest is None or any(
            not lowest.orbit.margin(i, code) >= least for i, code, least in margins
        ):
            raise TooLongError


# --- Where it ends --------------------------------------------------------------------------------


Seen = dict[float, tuple[Sample, float]]
"""Samples by their distances, and the values of a test function there."""


def _located(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction
) -> tuple[float, Sample]:
    """Where a test function vanishes between two samples; TooLongError if it is not found."""
    quick = _solved(curve, a, b, step, test)
    if quick is not None:
        return quick
    before, after = test.value(a), test.value(b)
    seen: Seen = {0.0: (a, before), step: (b, after)}

    def value(distance: float) -> float:
        if distance not in seen:
            sample = curve.advance(a, distance)
            if sample is None:
                raise ArithmeticError
            seen[distance] = sample, test.value(sample)
            if not test.leaps and _is_leap(seen, step):
                raise _leap(seen, step)
        return seen[distance][1]

    if math.isnan(before):
        raise TooLongError  # it was not there: how it came to be negative is not seen
    try:
        brentq(value, 0.0, step, xtol=min(LOCATED, CLOSED_IN**2 * step), maxiter=ITERATIONS)
    except (ArithmeticError, RuntimeError, ValueError):  # lost, not converged, nan
        raise TooLongError from None
    distance = min(seen, key=lambda each: abs(seen[each][1]))
    sample = seen[distance][0]
    noise = abs(after - before) * BLUR / step  # orbits are known to BLUR
    if not abs(test.value(sample)) <= CLOSED_IN * min(abs(before), abs(after)) + noise:
        raise _leap(seen, step)
    return distance, sample


def _bracket(seen: Seen) -> tuple[float, float]:
    """The last place where a function has the sign that it has at first, and the first other."""
    before = seen[0.0][1]
    same = {each for each, (_, value) in seen.items() if value * before > 0.0}
    return max(same, default=0.0), min(seen.keys() - same)


def _is_leap(seen: Seen, step: float) -> bool:
    """Whether a function that changes its sign is not small where it does."""
    # By the fourth root of the place, if not in proportion: so are those of roots of roots.
    low, high = _bracket(seen)
    width, ends = (high - low) / step, min(abs(seen[0.0][1]), abs(seen[step][1]))
    least = min(abs(seen[low][1]), abs(seen[high][1]))
    return 0.0 < width <= SUDDEN and least > math.sqrt(math.sqrt(width)) * ends


def _leap(seen: Seen, step: float) -> LeapError:
    """What is raised where a function leaps: the next step ends before that."""
    return LeapError(SHORT_OF_LEAP * _bracket(seen)[0] / step or 0.5)


def _solved(
    curve: SolutionCurve, a: Sample, b: Sample, step: float, test: TestFunction
) -> tuple[float, Sample] | None:
    """The zero of a test by Newton's method from a cubic's guess; None unless it lies between."""
    if test.condition is None or test.rate is None:
        return None
    found = solve(curve.problem.with_(test.condition), _guess(curve, a, b, test))
    if not found.converged:
        if step > BRACKETED:
            raise TooLongError
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
            raise TooLongError  # it vanishes elsewhere: in between it need not
        return None
    return distance, sample


def _guess(curve: SolutionCurve, a: Sample, b: Sample, test: TestFunction) -> SpaceOrbit:
    """Where a test function may vanish, by its values and rates at two samples."""
    assert test.rate is not None
    before, after = test.value(a), test.value(b)
    if math.isnan(before):  # only the second has it: the search begins there
        return b.orbit
    chord = curve.problem.step_between(a.orbit, b.orbit)
    length = norm(chord)
    part = zero_of_cubic(before, after, length * test.rate(a), length * test.rate(b))
    step = on_cubic(part, chord, length * a.tangent, length * b.tangent)
    return curve.problem.moved(a.orbit, step)


def _rate_of(curve: SolutionCurve, sample: Sample, column: int, inward: float) -> float:
    """How fast an unknown grows inwards along the curve."""
    return inward * float(curve.wide(sample)[column])


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
    # The place is one of a few, so that several margins are looked at together.
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    root = math.sqrt(max(0.0, c2 * c2 - 3.0 * c3 * da))
    s = -da / (c2 + root) if c2 + root > 0.0 else 1.0
    least = a + s * (da + s * (c2 + s * c3)) if 0.0 < s < 1.0 else min(a, b)
    return min(max(round(s * PLACES), 1), PLACES - 1) / PLACES, least


def _part(test: TestFunction, a: Sample, b: Sample) -> tuple[bool, float]:
    """The part of the way between two samples at which a bound is passed, to compare."""
    # One that has been passed and rises comes last: it has jumped beyond another border.
    before, after = test.value(a), test.value(b)
    rises = test.rate is not None and test.rate(b) > 0.0
    is_known = not math.isnan(before) and before != after  # else it does not tell
    return rises, before / (before - after) if is_known else math.inf
