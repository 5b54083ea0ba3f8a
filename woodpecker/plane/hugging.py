"""Curves of folds and flips that lead along a border, closer to it than steps are long.

Where a time goes like a root of the distance d from a border, slopes change fast beside it, and
folds and flips may lie next to it all along a curve: a step would cross the border, and Newton's
method for their equation, which goes like a root of d, leads away unless d is known well. So d is
predicted, by a power of what it was, and solved for first: in place of the equation with slopes
the margin has that value, which is regular.
"""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import replace

import numpy as np

from woodpecker.engine.curves import Sample
from woodpecker.engine.newton import Across, Problem, solve
from woodpecker.engine.orbits import Condition, OnBorder, Orbit

NEAR = 0.01  # of a step: a border that is nearer leads along
SOLVED = 1e-8  # of a multiplier: beside a root slopes are good to half of the digits only
MOST = 2.0  # times by which the margin grows in a step at most, or shrinks


def nearest_margin(
    problem: Problem, orbit: Orbit, ignored: Set[tuple[int, int]] = frozenset()
) -> tuple[int, int, float] | None:
    """The margin nearest to vanishing: image, code, and how far away that is in scaled unknowns."""
    best, scale = (math.inf, 0, 0), np.array([*problem.x_scale, *problem.p_scale])
    for i, image in enumerate(orbit.images):
        size = np.linalg.norm(image.gradients * scale, axis=1)
        for margin, most, code in zip(image.margins, size, image.codes.tolist(), strict=True):
            if most > 0.0 and (i, code) not in ignored:
                best = min(best, (abs(float(margin)) / float(most), i, code))
    return None if best[0] == math.inf else (best[1], best[2], best[0])


def distance(problem: Problem, orbit: Orbit, i: int, code: int) -> float:
    """How far away a border is where a margin vanishes, to first order, in scaled unknowns."""
    image, scale = orbit.images[i], np.array([*problem.x_scale, *problem.p_scale])
    k = image.place(code)
    return float(abs(image.margins[k]) / np.linalg.norm(image.gradients[k] * scale))


def beside_border(
    problem: Problem, steep: Condition, orbits: tuple[Orbit | None, Orbit], guess: Orbit,
    across: Across,
) -> Orbit | None:  # fmt: skip
    """A better guess a step ahead on a curve that leads along a border; None if it does not.

    Parameters
    ----------
    problem
        That of the curve.
    steep
        Its equation with slopes.
    orbits
        The last two along it; None if there is only one.
    guess, across
        A guess, and how far ahead of the last orbit it is to be.
    """
    before, last = orbits
    near = nearest_margin(problem, last)
    if near is None or not 0.0 < near[2] < NEAR * across.distance or not guess.is_defined:
        return None
    i, code, _ = near
    value = _margin(last, i, code)
    if before is not None and before.keys == last.keys:
        once = _margin(before, i, code)
        length = float(np.linalg.norm(problem.step_between(before, last)))
        if once > 0.0 and length > 0.0 and value > 0.0:
            grown = (value / once) ** min(across.distance / length, MOST)
            value *= min(max(grown, 1.0 / MOST), MOST)
    kept = tuple(OnBorder(i, code, value) if each is steep else each for each in problem.conditions)
    found = solve(replace(problem, conditions=(*kept, across)), guess)
    return found.orbit if found.converged else None


def _margin(orbit: Orbit, i: int, code: int) -> float:
    image = orbit.images[i]
    k = image.place(code)
    return math.nan if k < 0 else float(image.margins[k])


def corrected(
    problem: Problem, steep: Condition, before: Sample | None, last: Sample, guess: Orbit,
    across: Across,
) -> Orbit | None:  # fmt: skip
    """Newton's method from a guess, or first from beside the border that the curve hugs.

    Beside a root short steps of Newton's method do not say that an equation with slopes holds, and
    long ones lead to other curves: no solution is farther from the guess than that is ahead.

    Parameters
    ----------
    problem, steep
        That of the curve, and its equation with slopes.
    before, last, guess, across
        As :data:`woodpecker.engine.curves.Corrector` has them.
    """
    orbits = None if before is None else before.orbit, last.orbit
    for each in (beside_border(problem, steep, orbits, guess, across), guess):
        if each is None:
            continue
        found = solve(problem.with_(across), each)
        away = float(np.linalg.norm(problem.step_between(guess, found.orbit)))
        if found.converged and away <= across.distance and has_value(steep, found.orbit):
            return found.orbit
    return None


def has_value(steep: Condition, orbit: Orbit) -> bool:
    """Whether an equation with slopes holds, as well as slopes are known."""
    return bool(np.abs(steep.residual(orbit)).max() <= SOLVED)
