"""Impacts of random systems against all solutions of their complementarity problems."""

import numpy as np
import pytest
from lcp_oracles import enumerate_contacts

from woodpecker.systems.mechanics.impacts import ImpactPhase, solutions
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError

# Rounding of 1e-16 times the conditions of a mass matrix of four coordinates and of its contacts.
CLOSE = 1e-9


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
            after = velocity + delassus @ impulse
            every = enumerate_contacts(delassus, velocity, mu, floor)
            assert every
            for other in every:
                known = np.append(other.gamma_n, other.gamma_t)
                assert after == pytest.approx(known, abs=CLOSE)
            velocity, floor = after, np.maximum(eps * impulse[:m], 0.0)  # not by a rounding less
        assert found is None or (found is MotionStatus.AMBIGUOUS and 2 * m > n)
