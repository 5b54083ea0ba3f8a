"""Folds that are too sharp to be followed round.

Where a piece is a very steep function of one combination u of x and p, and that function has an
extremum, cycles turn round in a needle whose tip is rounder than the smallest step only over a
shorter way. Both arms run along u = const, so arclength does not lead from one to the other. The
coordinate across the arms does: there the curve is a graph, and the equations are regular.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats
from woodpecker.engine.curves import Arc, Curve, Sample, Stop
from woodpecker.engine.newton import across, solve
from woodpecker.engine.orbits import Multiplier

BENT = 2.0**-26  # angle between two tangents that says to which side a curve turns [rad]
CLOSEST = 2.0**-48  # scaled: how far across the other arm is looked for at first
DOUBLINGS = 16  # of that
FINEST = 1e-15  # of the distance across: where the fold is


def rounded(arc: Arc) -> Arc:
    """An arc that came to the tip of a needle, as one that ends at its fold.

    A flip between the fold and one of the samples is one point with the fold. An arc that comes to
    something else is left as it is.
    """
    curve, last = arc.curve, arc.samples[-1]
    way = _across(arc.samples)
    if way is None or last.orbit.outer is not None or len(curve.problem.free) > 1:
        return arc
    for doublings in range(DOUBLINGS):
        away = CLOSEST * 2.0**doublings
        other = _beside(curve, last, way, away)
        if other is not None and _turned(last, other) and _leads_on(curve, other):
            break
    else:
        return arc
    fold = _fold(curve, last, way, away)
    if curve.problem.step_between(last.orbit, fold.orbit) @ last.tangent < 0.0:
        return arc
    if not (curve.agrees(fold.orbit) and curve.agrees(other.orbit)):
        return arc
    samples = arc.samples if fold is last else (*arc.samples, fold)
    return replace(arc, samples=samples, stop=Stop.LP, beyond=other, condition=Multiplier("LP"))


def _turned(one: Sample, other: Sample) -> bool:
    """Whether a fold lies between: the parameter turns round, and the multiplier passes 1."""
    multiplier = Multiplier("LP")
    passes = multiplier.value(one.orbit) * multiplier.value(other.orbit) < 0.0
    return passes and _rate(one) * _rate(other) < 0.0


def _rate(sample: Sample) -> float:
    """How fast the parameter grows."""
    return float(sample.tangent[sample.orbit.x.size])


def _across(samples: Sequence[Sample]) -> Floats | None:
    """Unit vector across a curve, to the side to which it turns; None if to none."""
    if len(samples) < 2:
        return None
    one, other = samples[-2].tangent, samples[-1].tangent
    way: Floats = float(one @ other) * other - one
    length = float(np.linalg.norm(way))
    return way / length if length > BENT else None


def _beside(curve: Curve, last: Sample, way: Floats, away: float) -> Sample | None:
    """The cycle at a distance across the arm of a needle; None if there is none."""
    problem = curve.problem
    guess = problem.moved(last.orbit, away * way)
    if not guess.is_defined:
        return None
    found = solve(problem.with_(across(problem, last.orbit, way, away)), guess)
    sample = curve.start(found.orbit, way)
    return sample if found.converged and np.isfinite(sample.tangent).all() else None


def _fold(curve: Curve, last: Sample, way: Floats, away: float) -> Sample:
    """The fold nearer than a distance across; or what is next to it, where rounding ends that."""
    found = [last]

    def rate(distance: float) -> float:
        sample = last if distance == 0.0 else _beside(curve, last, way, distance)
        if sample is None:
            return 0.0  # no closer than this
        found.append(sample)
        return _rate(sample)

    brentq(rate, 0.0, away, xtol=FINEST * away, disp=False)
    return min(found, key=lambda sample: abs(_rate(sample)))


def _leads_on(curve: Curve, start: Sample) -> bool:
    """Whether a curve can be followed from a sample with steps that need not become shorter."""
    ahead = curve.advance(start, curve.settings.min_step)
    turn = math.cos(curve.settings.max_turn)
    return ahead is not None and float(start.tangent @ ahead.tangent) > turn
