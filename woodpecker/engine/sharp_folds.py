"""Sharp folds, which steps along a curve do not lead round.

Where a piece is a very steep function of one combination u of x and p, and u has an extremum along
the curve, both arms of a fold run along u = const, and its tip is shorter than the smallest step.
In the coordinate across the arms the curve is a graph, and the equations are regular.
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

BENT = 0.1  # of the largest turn between samples: how much a curve turns at least in a bend
CLOSEST = 2.0**-48  # scaled: how far across the other arm is looked for at first
DOUBLINGS = 16  # of that
FARTHEST = CLOSEST * 2.0**DOUBLINGS  # scaled: where the bend has begun at least
FINEST = 1e-15  # of the distance across: where a fold or a flip is


def rounded(arc: Arc) -> Arc | None:
    """An arc that was given up in a bend, as one that leads round it; None if there is no bend.

    It ends at the fold, or at the flip if there is no fold, or, ``SHORT`` still, beyond the bend.
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
        return None  # the end of a root is near
    elif _passes("PD", last, other):
        stop, test = Stop.PD, _flips
    elif curve.problem.step_between(last.orbit, other.orbit) @ last.tangent > 0.0:
        return replace(arc, samples=(*arc.samples, other), beyond=other)
    else:
        return None  # so close to a point it is rounding that turns
    place = _located(curve, last, way, other, away, test)
    if curve.problem.step_between(last.orbit, place.orbit) @ last.tangent < 0.0:
        return None
    if not curve.agrees(place.orbit):
        return None
    samples = arc.samples if place is last else (*arc.samples, place)
    return replace(arc, samples=samples, stop=stop, beyond=other, condition=Multiplier(stop.name))


def _other_arm(curve: SolutionCurve, last: Sample, way: Floats) -> tuple[Sample, float] | None:
    """The nearest sample beyond a fold, or a turn, that leads on, and how far across it is."""
    along, nearest = last.tangent, None  # it turns by less than a right angle in between
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
    """Whether the parameter turns round between two samples, and not by rounding alone."""
    return _passes("LP", one, other) and one.rate * other.rate <= 0.0


def _passes(kind: str, one: Sample, other: Sample) -> bool:
    """Whether a multiplier passes 1 (LP) or -1 (PD) between two samples."""
    multiplier = Multiplier(kind)
    return multiplier.value(one.orbit) * multiplier.value(other.orbit) < 0.0


def _flips(sample: Sample) -> float:
    """How far a multiplier is from -1."""
    return Multiplier("PD").value(sample.orbit)


def _across(curve: SolutionCurve, samples: Sequence[Sample]) -> Floats | None:
    """Unit vector across the end of a curve, to the side to which it turns; None if to none."""
    # The last step may be so short that it does not turn, though the bend has begun before.
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
    """Where a test vanishes between two samples, the second a distance across, but for rounding."""
    found = [last]

    def value(distance: float) -> float:
        ends = {0.0: last, away: other}
        sample = ends.get(distance) or _beside(curve, last, way, distance, way)
        if sample is None:
            return 0.0  # no closer than this
        found.append(sample)
        return test(sample)

    brentq(value, 0.0, away, xtol=FINEST * away, disp=False)
    return min(found, key=lambda sample: abs(test(sample)))


def _leads_on(curve: SolutionCurve, start: Sample) -> bool:
    """Whether a curve can be followed from a sample with steps that need not become shorter."""
    ahead = curve.advance(start, curve.settings.min_step)
    turn = math.cos(curve.settings.max_turn)
    return ahead is not None and float(start.tangent @ ahead.tangent) > turn
