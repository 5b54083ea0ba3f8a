"""Branch points: where two branches of cycles cross, and which way they go from there.

As a function of the first point of a cycle and of the parameter, what P_n is off by has a saddle
there: both of its derivatives vanish. So a branch point is a regular root of these two, although
the equations of the cycle itself are singular. At a flip P_2n has one too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.piecewise.orbits import Closed, Orbit, is_rounded, moved, scales, solve
from woodpecker.piecewise.settings import Settings


@dataclass(frozen=True, slots=True)
class Multiplier:
    """The multiplier of an orbit has a value.

    Attributes
    ----------
    value
        The value.
    settings
        Scales.
    finest
        Shortest distance over which slopes are compared, scaled; by default ``same``. At a branch
        point nothing is left of the equations but rounding; elsewhere less is, and next to a root
        in the map it has to be closer.
    """

    value: float
    settings: Settings
    finest: float = math.nan

    def residual(self, orbit: Orbit) -> float:
        """The multiplier less its value."""
        return orbit.multiplier - self.value

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives, by differences of slopes."""
        finest = self.settings.same if math.isnan(self.finest) else self.finest
        return _differences(orbit, _multiplier, self.settings, finest)


@dataclass(frozen=True, slots=True)
class Stationary:
    """The last image of an orbit does not change with the parameter, its first point held."""

    settings: Settings

    def residual(self, orbit: Orbit) -> float:
        """The derivative of the last image."""
        return _drift(orbit)

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives, by differences of slopes."""
        return _differences(orbit, _drift, self.settings, self.settings.same)


def saddle(guess: Orbit, settings: Settings) -> Orbit | None:
    """The saddle near an orbit; None if Newton's method finds none."""
    found = solve(guess, conditions(settings), settings)
    return found.orbit if found.converged else None


def closes(orbit: Orbit, settings: Settings) -> bool:
    """Whether a saddle is a cycle, in which two branches cross; else they only come close there."""
    return is_rounded(orbit, (Closed(),), settings.numerics)


def conditions(settings: Settings) -> tuple[Multiplier, Stationary]:
    """What a branch point obeys."""
    return Multiplier(1.0, settings), Stationary(settings)


def directions(orbit: Orbit, settings: Settings) -> tuple[Floats, ...]:
    """Unit vectors (n + 1,), in scaled unknowns, along the two branches that cross in an orbit.

    Where a quadratic form in the first point and the parameter vanishes; none if it does nowhere.
    """
    scale = scales(len(orbit), settings)
    along = ways(orbit) * scale[[0, -1]]
    by_multiplier, by_drift = (each.row(orbit) for each in conditions(settings))
    a, b = by_multiplier @ along
    c = float(by_drift @ along[:, 1]) * scale[-1] / scale[0]
    square = b * b - a * c
    if not (math.isfinite(square) and square > 0.0):
        return ()
    root = -(b + math.copysign(math.sqrt(square), b))
    found = []
    for x, p in ((root, a), (c, root)):
        way = (along @ np.array([x, p])) / scale
        if abs(way[-1]) <= settings.numerics.vertical * np.abs(way).max():
            way[-1] = 0.0
        found.append(way / np.linalg.norm(way))
    return tuple(found)


def ways(orbit: Orbit) -> Floats:
    """Derivatives (n + 1, 2) of the points of an orbit and of p in its first point and in p."""
    found = np.zeros((len(orbit) + 1, 2))
    found[0, 0] = found[-1, 1] = 1.0
    for i, image in enumerate(orbit.images[:-1]):
        found[i + 1] = image.slope * found[i] + image.d_parameter * found[-1]
    return found


def _multiplier(orbit: Orbit) -> float:
    return orbit.multiplier


def _drift(orbit: Orbit) -> float:
    """Derivative of the last image in the parameter, the first point held."""
    total = 0.0
    for image in orbit.images:
        total = image.slope * total + image.d_parameter
    return total


def _differences(
    orbit: Orbit, value: Callable[[Orbit], float], settings: Settings, finest: float
) -> Floats:
    """Derivatives (n + 1,) of a function of slopes in the unknowns, by central differences."""
    step = _steps(orbit, settings, finest)
    row = np.zeros(len(step))
    for k, length in enumerate(step.tolist()):
        way = np.zeros(len(step))
        way[k] = length
        above, below = value(moved(orbit, way)), value(moved(orbit, -way))
        if not math.isnan(above + below):
            row[k] = (above - below) / (2.0 * length)
        else:  # the map has an end here: to one side
            side = -1.0 if math.isnan(above) else 1.0
            near, far = (value(moved(orbit, side * n * way)) for n in (1, 2))
            row[k] = side * (4.0 * near - 3.0 * value(orbit) - far) / (2.0 * length)
    return row


def _steps(orbit: Orbit, settings: Settings, finest: float) -> Floats:
    """Lengths (n + 1,) over which differences are taken."""
    scale = scales(len(orbit), settings)
    away = np.full(len(scale), math.inf)
    for i, image in enumerate(orbit.images):
        with np.errstate(divide="ignore", invalid="ignore"):
            own = np.abs(image.margins[:, None] / image.gradients)
        x, p = np.fmin.reduce(own, axis=0, initial=math.inf).tolist()
        away[i], away[-1] = x, min(p, float(away[-1]))
    most, clear = settings.numerics.difference, settings.numerics.clear
    return np.maximum(np.minimum(most * scale, clear * away), finest * scale)
