"""Sharp folds: folds whose tip is shorter than the smallest step.

Where a piece depends steeply on one combination u of x and p, both arms of a fold run along
u = const, and steps in arclength cannot turn round the tip. As a function of the distance across
the arms the curve is smooth and its equations are regular, so the fold is located in that distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.curves import Arc, Sample, SolutionCurve, Stop
from woodpecker.engine.newton import STEEP, across, solve
from woodpecker.engine.orbits import Multiplier

BENT = 0.1  # of the largest turn between samples: by which a curve turns in a bend at least
CLOSEST = 2.0**-48  # scaled: first distance across at which the other arm is sought
DOUBLINGS = 16  # of that distance
FARTHEST = CLOSEST * 2.0**DOUBLINGS  # scaled: how far back on the curve the bend may begin
FINEST = 1e-15  # relative tolerance of the distance across at which a fold or a flip lies


def extended_round_bend(arc: Arc) -> Arc | None:
    """Extend an arc that was given up in a sharp bend; None if there is none.

    It ends at the fold, else at a flip, else beyond the bend, where it still stops as ``SHORT``.
    """
    curve, last = arc.curve, arc.samples[-1]
    way = _across(curve, arc.samples)
    if way is None or last.orbit.outer is not None or len(curve.problem.free) > 1:
        return None
    found = _other_arm(curve, last, way)
    if found is None:
        return None
    other, away = found
    if _folds(last, other):
        stop, test = Stop.LP, lambda sample: sample.rate
    elif any(curve.problem.steepest(image) > STEEP for image in last.orbit.images):
        return None  # slopes of a root singularity, which `at_root` deals with
    elif _passes("PD", last, other):
        stop, test = Stop.PD, _flips
    elif curve.problem.step_between(last.orbit, other.orbit) @ last.tangent > 0.0:
        return replace(arc, samples=(*arc.samples, other), beyond=other)
    else:
        return None  # the turn is a rounding error, close to a special point
    place = _located(curve, last, way, other, away, test)
    if curve.problem.step_between(last.orbit, place.orbit) @ last.tangent < 0.0:
        return None
    if not curve.agrees(place.orbit):
        return None
    samples = arc.samples if place is last else (*arc.samples, place)
    return replace(arc, samples=samples, stop=stop, beyond=other, condition=Multiplier(stop.name))


def _other_arm(curve: SolutionCurve, last: Sample, way: Floats) -> tuple[Sample, float] | None:
    """The nearest sample beyond a fold or turn from which the curve goes on, and its distance."""
    along, nearest = last.tangent, None  # between two tries it turns by less than a right angle
    for doublings in range(DOUBLINGS):
        away = CLOSEST * 2.0**doublings
        other = _beside(curve, last, way, away, along)
        if other is None:
            continue
        along = other.tangent
        turns = float(last.tangent @ along) <= math.cos(curve.settings.max_turn)
        folds = _folds(last, other)
        if (folds or (turns and nearest is None)) and (
            curve.agrees(other.orbit) and _leads_on(curve, other)
        ):
            nearest = other, away
            if folds:
                break
    return nearest


def _folds(one: Sample, other: Sample) -> bool:
    """Whether the parameter turns back between two samples, beyond rounding."""
    return _passes("LP", one, other) and one.rate * other.rate <= 0.0


def _passes(kind: str, one: Sample, other: Sample) -> bool:
    """Whether a multiplier passes 1 (LP) or -1 (PD) between two samples."""
    multiplier = Multiplier(kind)
    return multiplier.value(one.orbit) * multiplier.value(other.orbit) < 0.0


def _flips(sample: Sample) -> float:
    """The test function of a flip."""
    return Multiplier("PD").value(sample.orbit)


def _across(curve: SolutionCurve, samples: Sequence[Sample]) -> Floats | None:
    """Unit vector across the end of a curve, to the side to which it bends; None if straight."""
    # The last steps may be too short to turn, though the bend began before them.
    last, least = samples[-1], BENT * curve.settings.max_turn
    for n, one in enumerate(reversed(samples[:-1])):
        way = float(one.tangent @ last.tangent) * last.tangent - one.tangent
        length = norm(way)
        if length > least:
            return np.asarray(way / length)
        if n and norm(curve.problem.step_between(last.orbit, one.orbit)) > FARTHEST:
            break
    return None


def _beside(
    curve: SolutionCurve, last: Sample, way: Floats, away: float, along: Floats
) -> Sample | None:
    """The cycle at a distance across the arm of a sharp fold; None if there is none."""
    problem = curve.problem
    guess = problem.moved(last.orbit, away * way)
    if not guess.is_defined:
        return None
    found = solve(problem.with_(across(problem, last.orbit, way, away)), guess)
    sample = curve.start(found.orbit, along)
    return sample if found.converged and np.isfinite(sample.tangent).all() else None


def _located(
    curve: SolutionCurve, last: Sample, way: Floats, other: Sample, away: float,
    test: Callable[[Sample], float],
) -> Sample:  # fmt: skip
    """The sample between two at which a test function vanishes, by the distance across."""
    found = [last]

    def value(distance: float) -> float:
        ends = {0.0: last, away: other}
        sample = ends.get(distance) or _beside(curve, last, way, distance, way)
        if sample is None:
            return 0.0  # rounding allows no closer bracket
        found.append(sample)
        return test(sample)

    brentq(value, 0.0, away, xtol=FINEST * away, disp=False)
    return min(found, key=lambda sample: abs(test(sample)))


def _leads_on(curve: SolutionCurve, start: Sample) -> bool:
    """Whether the curve can be followed on from a sample with the shortest allowed step."""
    ahead = curve.advance(start, curve.settings.min_step)
    turn = math.cos(curve.settings.max_turn)
    return ahead is not None and float(start.tangent @ ahead.tangent) > turn
