"""Random systems pass no contact; what else they must keep is asked where their study runs."""

import numpy as np
import pytest
import sympy

from studies.systems.random_systems import SEED, SHAPES, draw_values, family
from woodpecker.systems import MotionStatus, simulate


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(18))
def test_no_contact_is_passed(number: int) -> None:
    n, m = SHAPES[number % len(SHAPES)]
    values, speeds = draw_values(n, m, np.random.default_rng([SEED, number]))
    system, _ = family(n, m)
    drawn = dict(zip(map(str, system.parameters), values.tolist(), strict=True))
    held = system.replace(**drawn)
    start = dict(zip(system.state[n:-1], speeds.tolist(), strict=True))
    motion = simulate(held, start, 4.0, backend="scipy", max_events=300)
    assert np.isfinite(motion.q).all()
    assert np.isfinite(motion.u).all()
    gap = sympy.lambdify([held.q], [c.gap.subs(held.parameters) for c in held.contacts])
    if motion.status is not MotionStatus.PASSED:
        assert np.min([gap(q) for q in motion.q]) > -1e-6  # rounding, and the dense output's error
