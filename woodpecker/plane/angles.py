"""Angles between tangents."""

from __future__ import annotations

import math

from woodpecker.base.arrays import Floats


def angle(one: Floats, other: Floats) -> float:
    """Angle [rad] between two unit vectors."""
    return math.acos(min(1.0, max(-1.0, float(one @ other))))
