"""Newton's method and pseudo-arclength continuation as in textbooks.

Neither knows words, pieces or jumps: a map is a function of (x, p), its derivatives are forward
differences, the predictor is the secant, and a step that does not converge is halved. Both use the
project's own map, exact to rounding, so that only the algorithm can be the cause of a failure.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.maps.pieces import PiecewiseMap

Plain = Callable[[float, float], float]  # (x, p) -> image; nan where there is none

DIFFERENCE = 1e-7  # of forward differences, near the square root of rounding
CONVERGED = 1e-10  # residual [rad] at which Newton's method ends
NEWTON_STEPS = 12
FIRST, LONGEST, SHORTEST = 1e-3, 1e-2, 1e-9  # arclength of a step in (x, p)
MOST = 2000  # steps of one path


class Shot(NamedTuple):
    """Where Newton's method ended."""

    x: float
    p: float
    residual: float
    steps: int

    @property
    def converged(self) -> bool:
        """Whether the residual is small."""
        return self.residual <= CONVERGED


class Path(NamedTuple):
    """Points of a branch, as the continuation saw it."""

    x: Floats
    p: Floats
    end: str
    corrections: int  # Newton steps, also those of steps that failed


def plain(map_: PiecewiseMap) -> Plain:
    """Only the values of a map."""
    return lambda x, p: map_.at(x, p).value


def newton(f: Plain, x: float, p: float) -> Shot:
    """Solve f(x, p) = x for x, the parameter held."""
    return _newton(f, np.array([x, p]), np.array([0.0, 1.0]))


def _newton(f: Plain, z: Floats, normal: Floats) -> Shot:
    """Newton's method for f(x, p) = x in the line through z that ``normal`` stands upon."""
    for step in range(NEWTON_STEPS + 1):
        x, p = z.tolist()
        gap = f(x, p) - x
        if not abs(gap) > CONVERGED or step == NEWTON_STEPS:  # also if there is no value
            break
        by_x = (f(x + DIFFERENCE, p) - f(x, p)) / DIFFERENCE - 1.0
        by_p = (f(x, p + DIFFERENCE) - f(x, p)) / DIFFERENCE if normal[0] else 0.0
        matrix = np.array([[by_x, by_p], normal])
        if not np.isfinite(matrix).all() or np.linalg.det(matrix) == 0.0:
            break
        z = z - np.linalg.solve(matrix, np.array([gap, 0.0]))
    residual = abs(gap) if math.isfinite(gap) else math.inf
    return Shot(float(z[0]), float(z[1]), residual, step)


def follow(
    f: Plain, x: float, p: float, direction: int, span: tuple[float, float],
    window: tuple[float, float],
) -> Path:  # fmt: skip
    """Follow the fixed points of f from (x, p) towards larger (+1) or smaller (-1) p."""
    second = newton(f, x, p + direction * FIRST)
    path, step, corrections = [np.array([x, p]), np.array([second.x, second.p])], FIRST, 0
    if not second.converged:
        return _path(path[:1], "no second point", second.steps)
    while len(path) < MOST:
        secant = path[-1] - path[-2]
        secant = secant / np.linalg.norm(secant)
        shot = _newton(f, path[-1] + step * secant, secant)
        corrections += shot.steps
        if not shot.converged:
            step *= 0.5
            if step < SHORTEST:
                return _path(path, "no convergence with the shortest step", corrections)
            continue
        path.append(np.array([shot.x, shot.p]))
        if not (span[0] <= shot.p <= span[1] and window[0] <= shot.x <= window[1]):
            return _path(path, "end of the span or the window", corrections)
        step = min(1.5 * step, LONGEST) if shot.steps <= 4 else step
    return _path(path, "limit on the number of steps", corrections)


def _path(points: list[Floats], end: str, corrections: int) -> Path:
    x, p = np.array(points).T
    return Path(x, p, end, corrections)
