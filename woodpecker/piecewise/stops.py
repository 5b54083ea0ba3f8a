"""Where an arc may end between two samples: ends of span and window, and test functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import BranchKind
from woodpecker.piecewise.branch_points import closes, directions, saddle
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.jumps import carried_over
from woodpecker.piecewise.orbits import (
    SPACING,
    Coordinate,
    Margin,
    Orbit,
    scales,
    solve,
)
from woodpecker.piecewise.samples import BranchState, Sample, Stop, StopRule
from woodpecker.piecewise.settings import Settings


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    """An end that lies between two samples."""

    stop: Stop
    sample: Sample
    distance: float
    margins: tuple[Margin, ...] = ()
    inner: bool = True
    meeting: Orbit | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Test:
    """A function of samples whose change of sign ends an arc."""

    stop: Stop
    value: Callable[[Sample], float]


class UnclearError(Exception):
    """A shorter step is needed to tell what lies between two samples."""


def ending_at(
    corrector: Corrector, a: Sample, step: float, stop: Stop, orbit: Orbit,
    margins: tuple[Margin, ...] = (),
) -> Ending | None:  # fmt: skip
    """An orbit as the end of an arc; None if it does not lie within a step."""
    scale, slack = scales(len(orbit), corrector.settings), corrector.settings.numerics.slack
    distance = float(a.tangent @ ((orbit.point - a.orbit.point) / scale))
    if not -corrector.settings.same <= distance <= step * (1.0 + slack) + corrector.settings.same:
        return None
    return Ending(stop, corrector.sample(orbit, a.tangent), distance, margins)


def _limits(corrector: Corrector, orbit: Orbit) -> Iterator[tuple[Stop, int, tuple[float, float]]]:
    """What bounds the unknowns of an orbit: the stop, the index of the unknown, its interval."""
    yield Stop.SPAN, -1, corrector.settings.span
    for i in range(len(orbit)):
        yield Stop.WINDOW, i, corrector.settings.window


def leaves(corrector: Corrector, start: Sample) -> Stop | None:
    """Whether a sample lies at an end of span or window, and the branch leaves it there."""
    orbit, along = start.orbit, start.tangent
    for stop, index, (low, high) in _limits(corrector, orbit):
        value = orbit.point[index]
        if (value <= low and along[index] < 0.0) or (value >= high and along[index] > 0.0):
            return stop
    return None


def at_ends(corrector: Corrector, a: Sample, b: Sample, step: float) -> list[Ending]:
    """Ends of the span and of the window; UnclearError if one was passed and is not found."""
    found = []
    for stop, index, (low, high) in _limits(corrector, a.orbit):
        one, other = float(a.orbit.point[index]), float(b.orbit.point[index])
        for end, outward in ((low, -1.0), (high, 1.0)):
            if outward * (other - end) >= 0.0 > outward * (one - end):
                guess = corrector.between(a, b, (end - one) / (other - one))
                condition = Coordinate(index, end)
                solution = solve(guess, (corrector.closing, condition), corrector.settings)
                ending = ending_at(corrector, a, step, stop, solution.orbit)
                if not solution.converged or ending is None:
                    raise UnclearError
                found.append(ending)
    return found


def at_test(corrector: Corrector, a: Sample, b: Sample, step: float, test: Test) -> list[Ending]:
    """Where a test function changes its sign between two samples, if it does."""
    before, after = test.value(a), test.value(b)
    if before * after < 0.0 or (after == 0.0 and before != 0.0):
        return _located(corrector, a, step, test, SPACING)
    return []


def _located(
    corrector: Corrector, a: Sample, step: float, test: Test, finest: float
) -> list[Ending]:
    """Where a test function vanishes; UnclearError if the branch is lost on the way.

    Beside a square root a multiplier changes its sign through infinity: that is no ending.
    """
    found: dict[float, Sample] = {}

    def value(distance: float) -> float:
        sample = a if distance == 0.0 else corrector.advance(a, distance)
        if isinstance(sample, float):
            raise UnclearError
        found[distance] = sample
        return test.value(sample)

    try:
        root = float(brentq(value, 0.0, step, xtol=max(finest * step, SPACING)))
    except ValueError:  # its sign there is another one with other steps
        raise UnclearError from None
    nearest = min(found, key=lambda distance: abs(distance - root))
    values = [abs(test.value(found[distance])) for distance in (0.0, nearest, step)]
    if 2.0 * values[1] > min(values[::2]):
        return []
    there = found[nearest]
    if a.jump is not None and test.stop is Stop.FOLD:
        there = replace(there, jump=carried_over(corrector.map, a.jump, there.orbit))
    return [Ending(test.stop, there, nearest)]


def at_branch_point(corrector: Corrector, a: Sample, b: Sample, step: float) -> list[Ending]:
    """Where another branch crosses, if one does after all; UnclearError if it is not found."""
    orbit = saddle(corrector.between(a, b, 0.5), corrector.settings)
    ways = () if orbit is None else directions(orbit, corrector.settings)
    if orbit is None or not ways:
        folds = a.tangent[-1] * b.tangent[-1] < 0.0
        return _located(
            corrector,
            a,
            step,
            TURNING if folds else BRANCHING,
            corrector.settings.numerics.crossing,
        )
    away = (orbit.point - a.orbit.point) / scales(len(orbit), corrector.settings)
    distance, same = float(a.tangent @ away), corrector.settings.same
    longest = step * (1.0 + corrector.settings.max_turn) + same
    if not (
        distance >= -same
        and float(np.linalg.norm(away)) <= longest
        and closes(orbit, corrector.settings)
    ):
        raise UnclearError  # it has led to another branch
    along = max(ways, key=lambda way: abs(float(way @ a.tangent)))
    along = along if along @ a.tangent >= 0.0 else -along
    return [Ending(Stop.BRANCHING, Sample(orbit, along, b.forward), distance)]


def closing_up(corrector: Corrector, a: Sample, b: Sample, start: Sample) -> list[Ending]:
    """Whether the branch passes through its own start."""
    if b.orbit.keys != start.orbit.keys:
        return []
    scale = scales(len(start.orbit), corrector.settings)
    one, other = ((s.orbit.point - start.orbit.point) / scale for s in (a, b))
    length = float(np.linalg.norm(other - one))
    before, after = float(start.tangent @ one), float(start.tangent @ other)
    if not (before < 0.0 <= after and np.linalg.norm(one) <= 2.0 * length):
        return []
    off = one + (other - one) * (before / (before - after))
    if np.linalg.norm(off) > corrector.settings.max_turn * length:
        return []
    return [Ending(Stop.CLOSED, Sample(start.orbit, start.tangent), -float(a.tangent @ one))]


def first_of(endings: list[Ending], settings: Settings) -> Ending:
    """The ending that comes first; at the end of the span or of the window nothing else does.

    Of margins that vanish at once it is the one that belongs to the earliest of what happens,
    not the one that rounding puts first.
    """
    first = min(each.distance for each in endings)
    near = [each for each in endings if each.distance <= first + settings.same]
    ends = [each for each in near if each.stop in (Stop.SPAN, Stop.WINDOW)]
    if ends:
        return ends[0]
    at_once = [each for each in near if each.distance <= first + settings.nearest]
    if all(each.margins and each.stop is at_once[0].stop for each in at_once):
        return min(at_once, key=lambda each: (each.margins[0].index, each.margins[0].code))
    return min(near, key=lambda each: each.distance)


def at_stop(
    corrector: Corrector, rule: StopRule | None, a: Sample, b: Sample, step: float
) -> list[Ending]:
    """Where a branch is to end between two samples; UnclearError if it is lost on the way."""
    if not is_asked(rule, b):
        return []
    scale = scales(len(a.orbit), corrector.settings)
    length = float(a.tangent @ ((b.orbit.point - a.orbit.point) / scale))
    low, high, found = 0.0, length, b
    while high - low > SPACING * step:
        middle = 0.5 * (low + high)
        sample = corrector.advance(a, middle)
        if isinstance(sample, float):
            raise UnclearError
        if not low < middle < high:
            break
        if is_asked(rule, sample):
            high, found = middle, sample
        else:
            low = middle
    return [Ending(Stop.ASKED, found, high)]


def is_asked(rule: StopRule | None, sample: Sample) -> bool:
    """Whether a branch is to end here."""
    if rule is None:
        return False
    orbit, jump = sample.orbit, sample.jump
    if jump is None:
        kind, order, multiplier = BranchKind.FIXED_POINT, len(orbit), orbit.multiplier
    else:
        kind, order, multiplier = BranchKind.JUMP, jump.order, math.nan
    word = " | ".join(orbit.words) if jump is None else jump.word
    return bool(rule(BranchState(kind, order, orbit.p, orbit.x.copy(), multiplier, word)))


FOLD = Test(Stop.FOLD, lambda sample: float(sample.tangent[-1]))
BRANCHING = Test(Stop.BRANCHING, lambda sample: sample.orbit.multiplier - 1.0)
TURNING = Test(Stop.BRANCHING, FOLD.value)
FLIP = Test(Stop.FLIP, lambda sample: sample.orbit.multiplier + 1.0)
