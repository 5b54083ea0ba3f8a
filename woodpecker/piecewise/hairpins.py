"""Folds that are too sharp to be followed round.

Where a piece is a very steep function of one combination u of x and p, and that function has an
extremum, fixed points turn round in a needle whose tip is rounder than the smallest step only over
a shorter way. Both arms run along u = const, so arclength does not lead from one to the other. The
coordinate across the arms does: there the branch is a graph, and the equations are regular.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.corrector import Corrector
from woodpecker.piecewise.crossings import is_inside
from woodpecker.piecewise.orbits import SPACING, Closed, Distance, moved, scales, solve, tangent
from woodpecker.piecewise.samples import Sample, angle
from woodpecker.piecewise.settings import Settings


def round_hairpin(corrector: Corrector, samples: Sequence[Sample]) -> tuple[Sample, Sample] | None:
    """The fold right ahead of the last sample of a branch of cycles, and a sample on the other arm.

    Parameters
    ----------
    corrector
        Finds cycles.
    samples
        The branch so far; its last two tangents say to which side it turns. From a single one the
        side is found by a step that is shorter than the shortest.

    Returns
    -------
    None if the branch does not turn round within some smallest steps, or not inside of its pieces.
    A flip between the fold and one of the samples is one point with the fold.
    """
    start = samples[-2:] if len(samples) > 1 else _probed(corrector, samples[-1])
    across = _across(start)
    if across is None:
        return None
    last, settings = start[-1], corrector.settings
    away, widest = settings.converged, settings.numerics.noise * settings.min_step
    other = _beside(corrector, last, across, away)
    while other is None or not _turns(last, other):
        away *= 2.0
        if away > widest:
            return None
        other = _beside(corrector, last, across, away)
    fold, away = _fold(corrector, last, across, away)
    other = _other_arm(corrector, last, across, 2.0 * away, widest)
    if fold is None or other is None or not _is_ahead(last, fold, settings):
        return None
    closes = (is_inside(s.orbit, Closed()) and corrector.agrees(s.orbit) for s in (fold, other))
    return (fold, other) if all(closes) else None


def _probed(corrector: Corrector, start: Sample) -> list[Sample]:
    """A sample and one right ahead of it, so close that the branch can be followed there."""
    step = corrector.settings.min_step
    while step > corrector.settings.converged:
        ahead = corrector.advance(start, step)
        if isinstance(ahead, Sample):
            return [start, ahead]
        step *= 0.5
    return [start]


def _across(samples: Sequence[Sample]) -> Floats | None:
    """Unit vector (n + 1,) across a branch, to the side to which it turns; None if to none."""
    if len(samples) < 2:
        return None
    one, other = samples[-2].tangent, samples[-1].tangent
    across: Floats = float(one @ other) * other - one
    length = float(np.linalg.norm(across))
    return across / length if length > math.sqrt(SPACING) else None


def _beside(corrector: Corrector, last: Sample, across: Floats, away: float) -> Sample | None:
    """The cycle at a distance across the arm of a hairpin; None if there is none."""
    scale = scales(len(last.orbit), corrector.settings)
    distance = Distance(last.orbit.point, across, away, scale)
    start = moved(last.orbit, away * across * scale)
    if not start.defined:
        return None
    solution = solve(start, (corrector.closing, distance), corrector.settings)
    along = tangent(solution.orbit, corrector.closing, corrector.settings)
    if not (solution.converged and corrector.is_met(solution.orbit) and np.isfinite(along).all()):
        return None
    return Sample(solution.orbit, along if last.forward else -along, last.forward)


def _turns(last: Sample, other: Sample) -> bool:
    """Whether a fold lies between two samples."""
    return float(last.tangent[-1] * other.tangent[-1]) < 0.0


def _is_ahead(last: Sample, fold: Sample, settings: Settings) -> bool:
    """Whether a branch leads from a sample to a fold; the other arm leads away from it."""
    way = (fold.orbit.point - last.orbit.point) / scales(len(last.orbit), settings)
    return float(last.tangent @ way) > 0.0


def _fold(
    corrector: Corrector, last: Sample, across: Floats, away: float
) -> tuple[Sample | None, float]:
    """The fold nearer than a distance across, and its own; None if the branch is lost there."""
    found: dict[float, Sample | None] = {0.0: last}

    def value(distance: float) -> float:
        if distance not in found:
            found[distance] = _beside(corrector, last, across, distance)
        there = found[distance]
        return math.nan if there is None else float(there.tangent[-1])

    try:
        root = float(brentq(value, 0.0, away, xtol=SPACING * away, disp=False))
    except ValueError:  # there is no cycle at some distance in between
        return None, away
    nearest = min(found, key=lambda distance: abs(distance - root))
    return found[nearest], nearest


def _other_arm(
    corrector: Corrector, last: Sample, across: Floats, away: float, widest: float
) -> Sample | None:
    """A sample beyond a fold from which steps lead on, at least a distance across from the last."""
    while away <= widest:
        found = _beside(corrector, last, across, away)
        if found is not None and _turns(last, found) and _leads_on(corrector, found):
            return found
        away *= 2.0
    return None


def _leads_on(corrector: Corrector, start: Sample) -> bool:
    """Whether a branch can be followed from a sample, with steps that need not become shorter."""
    step = corrector.settings.min_step
    ahead = corrector.advance(start, step)
    most = corrector.settings.numerics.kept_turn * corrector.turn(step)
    return isinstance(ahead, Sample) and angle(start.tangent, ahead.tangent) <= most
