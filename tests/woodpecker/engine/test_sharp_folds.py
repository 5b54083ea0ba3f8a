"""Folds whose tip is shorter than the smallest step."""

from dataclasses import replace

import numpy as np
import pytest
from sympy import symbols

from woodpecker.engine.curves import Arc, CurveSettings, SolutionCurve, Stop
from woodpecker.engine.following import follow
from woodpecker.engine.formulas import expression_map
from woodpecker.engine.newton import cycles
from woodpecker.engine.orbits import orbit_of
from woodpecker.engine.sharp_folds import extended_round_bend

SHARP = 1e14


@pytest.fixture(scope="module")
def given_up() -> Arc:
    """Fixed points x - p = SHARP (x + p)^2, followed from one half down to the tip at zero."""
    x, p = symbols("x p")
    map_ = expression_map((x,), (p,), {"A": (x - (x - p - SHARP * (x + p) ** 2) / 1000,)})
    settings = CurveSettings(spans=((-1, 1),), window=((-1, 1),), min_step=1e-13)
    curve = SolutionCurve(map_, cycles((0,), (1.0,), (1.0,)), settings)
    along, across = 0.5, (0.5 / SHARP) ** 0.5
    at, value = np.array([[(across + along) / 2]]), np.array([(across - along) / 2])
    return follow(curve, curve.start(orbit_of(map_.pieces, at, value), np.array([-1.0, 1.0])))


@pytest.mark.parametrize("still", [0, 1, 3])
def test_a_fold_is_seen_however_short_the_last_steps_were(given_up: Arc, still: int) -> None:
    """The least parameter is 1/(8 SHARP), at x = 3/(8 SHARP): slopes 1e-3 tell x to 1e-13 / 1e-3.

    Rounding decides how often a step is shortened before it is given up: the last may not turn.
    """
    assert given_up.stop is Stop.SHORT
    last = given_up.samples[-1]
    found = extended_round_bend(replace(given_up, samples=(*given_up.samples, *(last,) * still)))
    assert found is not None
    assert found.stop is Stop.LP
    tip = found.samples[-1].orbit
    assert float(tip.p[0]) == pytest.approx(1.0 / (8.0 * SHARP), abs=1e-15)
    assert float(tip.x[0, 0]) == pytest.approx(3.0 / (8.0 * SHARP), abs=1e-15)
