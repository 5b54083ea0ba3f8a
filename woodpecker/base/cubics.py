"""Cubics through two values with two slopes."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from woodpecker.base.arrays import Floats


def on_cubic(part: float, change: Floats, rise: Floats, rise_there: Floats) -> Floats:
    """How far a cubic, by its change and its slopes at both ends, has come after a part."""
    cubic, square = rise + rise_there - 2.0 * change, 3.0 * change - 2.0 * rise - rise_there
    found: Floats = part * (rise + part * (square + part * cubic))
    return found


def zero_of_cubic(before: float, after: float, rise: float, rise_there: float) -> float:
    """The root in [0, 1] of a cubic by values and slopes at both ends; a line if a slope is inf."""
    change = after - before
    cubic, square = rise + rise_there - 2.0 * change, 3.0 * change - 2.0 * rise - rise_there
    if not math.isfinite(cubic):
        return before / (before - after)

    def value(s: float) -> float:
        """The cubic; exact at 1, where rounding of a steep one might change its sign."""
        return after if s == 1.0 else before + s * (rise + s * (square + s * cubic))

    return float(brentq(value, 0.0, 1.0))
