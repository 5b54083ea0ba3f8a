"""A multiplier as an equation of the line, whose derivatives are differences of slopes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.engine.orbits import CLEAR, STEP
from woodpecker.slices.orbits import Orbit, moved, scales


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
        Shortest distance over which slopes are compared, scaled; next to a root in the map it has
        to be close.
    """

    value: float
    settings: Settings
    finest: float

    def residual(self, orbit: Orbit) -> float:
        """The multiplier less its value."""
        return orbit.multiplier - self.value

    def row(self, orbit: Orbit) -> Floats:
        """Its derivatives, by differences of slopes."""
        return _differences(orbit, _multiplier, self.settings, self.finest)


def _multiplier(orbit: Orbit) -> float:
    return orbit.multiplier


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
    return np.maximum(np.minimum(STEP * scale, CLEAR * away), finest * scale)
