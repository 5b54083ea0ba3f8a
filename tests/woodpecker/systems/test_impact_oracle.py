"""Impacts of random systems against another Lemke path: that of QuantEcon, which knows no contacts.

The equations are the paper's, from contact_lcp; the path, its ties and tolerances are another's.
"""

import numpy as np
import pytest
from lcp_oracles import matrices

from woodpecker.base.arrays import Floats
from woodpecker.systems.mechanics.impacts import ImpactPhase, solutions
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

# Rounding of 1e-16 times the conditions of a mass matrix of four coordinates and of its contacts.
CLOSE = 1e-9


def solved(a: Floats, b: Floats) -> Floats:
    # Imported here, not on collection: it compiles then, into a cache that one process may write.
    oracle = pytest.importorskip("quantecon.optimize").lcp_lemke
    found = oracle(np.ascontiguousarray(a), np.ascontiguousarray(b))
    assert found.success
    return np.asarray(found.z)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "m"), [(2, 1), (3, 1), (4, 1), (3, 2), (4, 2)])
def test_impacts_are_those_of_the_oracle(n: int, m: int) -> None:
    """Compression and expansion at contacts that all close, some of which others may open.

    With more directions than coordinates several contacts can jam, and separate as well: then the
    laws leave open which, and say so.
    """
    rng = np.random.default_rng([n, m])
    for _ in range(300):
        found = None
        root, w = rng.normal(size=(n, n)), rng.normal(size=(2 * m, n))
        delassus = w @ np.linalg.solve(root @ root.T + n * np.eye(n), w.T)
        velocity = w @ rng.normal(size=n)
        velocity[:m] = -np.abs(velocity[:m])
        if 2 * m > n:  # they are those of a motion
            velocity = w @ np.linalg.lstsq(w, velocity)[0]
        mu, eps, floor = rng.uniform(0.0, 0.6, m), rng.uniform(0.0, 0.9, m), np.zeros(m)
        for _ in range(2):
            phase = ImpactPhase(delassus, velocity, np.diag(mu), floor, (True,) * m)
            try:
                _, impulse = solutions(phase, np.zeros(m))
            except StoppedError as stop:
                found = stop.status
                break
            x = solved(*matrices(delassus, velocity, mu, floor))
            normal = x[:m] + floor
            other = np.concatenate([normal, x[m : 2 * m] - mu * normal])
            after = velocity + delassus @ impulse
            assert after == pytest.approx(velocity + delassus @ other, abs=CLOSE)
            velocity, floor = after, eps * normal
        assert found is None or (found is MotionStatus.AMBIGUOUS and 2 * m > n)
