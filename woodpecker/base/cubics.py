"""Cubic Hermite interpolation: cubics with given values and slopes at both ends."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from woodpecker.base.arrays import Floats


def hermite_increment(part: float, change: Floats, rise: Floats, rise_there: Floats) -> Floats:
    """Increment of a cubic over a ``part`` of [0, 1], from its whole change and both end slopes."""
    cubic, square = rise + rise_there - 2.0 * change, 3.0 * change - 2.0 * rise - rise_there
    found: Floats = part * (rise + part * (square + part * cubic))
    return found


def hermite_root(before: float, after: float, rise: float, rise_there: float) -> float:
    """Root in [0, 1] of a cubic with given values and slopes; of the chord if a slope is inf."""
    change = after - before
    cubic, square = rise + rise_there - 2.0 * change, 3.0 * change - 2.0 * rise - rise_there
    if not math.isfinite(cubic):
        return before / (before - after)

    def value(s: float) -> float:
        """The cubic; at 1 it is ``after``, as rounding of a steep one might change the sign."""
        return after if s == 1.0 else before + s * (rise + s * (square + s * cubic))

    return float(brentq(value, 0.0, 1.0))
