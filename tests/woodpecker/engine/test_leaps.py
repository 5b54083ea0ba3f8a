"""A test function that changes its sign without being zero: where a step is to end."""

from __future__ import annotations

import math

import numpy as np
import pytest

from woodpecker.engine import curves
from woodpecker.engine.curves import CurveSettings, Sample, SolutionCurve, Stop
from woodpecker.engine.ends import LeapError, ends_between
from woodpecker.engine.line import LineMap
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import orbit_of
from woodpecker.examples import two_lines

STEP = 0.01
PLACE = 0.3  # part of the step at which it leaps


def leaping(size: float) -> tuple[SolutionCurve, Sample, Sample, list[float]]:
    """Cycles of x/2 + p, x = 2 p, two of them, and a function that leaps between these.

    It falls from 1 to ``size`` and goes on from there to -1 with the opposite sign.
    """
    map_, asked = LineMap(two_lines()), list[float]()
    problem = cycles((0,), (1.0,), (1.0,))
    settings = CurveSettings(spans=((-2.0, 2.0),), window=((-5.0, 5.0),))
    piece = map_.at(np.array([-1.0]), np.array([-0.5])).piece
    p = -0.5, -0.5 + STEP / math.sqrt(5.0)  # it leads along (2, 1)
    at = [orbit_of((piece,), np.array([[2.0 * each]]), np.array([each])) for each in p]

    def value(sample: Sample) -> float:
        part = (float(sample.orbit.p[0]) - p[0]) / (p[1] - p[0])
        asked.append(part)
        if part < PLACE:
            return 1.0 - (1.0 - size) * part / PLACE
        return -size - (1.0 - size) * (part - PLACE) / (1.0 - PLACE)

    own = curves.TestFunction(Stop.SPECIAL, value)
    curve = SolutionCurve(map_, problem, settings, tests=(), own=(own,))
    first, last = (curve.start(orbit, np.array([2.0, 1.0])) for orbit in at)
    return curve, first, last, asked


@pytest.mark.parametrize("size", [0.5, 0.05, 2.0**-8])
def test_a_step_ends_right_before_a_leap(size: float) -> None:
    """Where it leaps is known to 2^-10 of the step, and the next step leads half the way."""
    curve, first, last, asked = leaping(size)
    with pytest.raises(LeapError) as found:
        ends_between(curve, first, last, STEP, starts=False)
    assert found.value.part == pytest.approx(0.5 * PLACE, abs=2.0**-10)
    assert len(asked) <= {0.5: 16, 0.05: 24, 2.0**-8: 40}[size]  # down to doubles it takes 55
