"""Hogan's rocking block against the closed form of its symmetric motions."""

import math

import numpy as np
import pytest
from needs import EACH_BACKEND

from studies.systems.rocking_block import Symmetric, map_of

CLOSE = 1e-10  # multipliers of a half motion grow like exp(pi/w): up to 5 here


def test_the_closed_form_is_one() -> None:
    """beta is least at the fold; a multiplier of the half motion is 1 there, -1 at the fork."""
    exact = Symmetric(3.0, 0.925)
    v = exact.fold()
    slopes = [exact.beta(v + h) - exact.beta(v - h) for h in (1e-4, 1e-5)]
    assert slopes == pytest.approx([0.0, 0.0], abs=1e-10)
    trace, det = exact.half(v)
    assert 1.0 - trace + det == pytest.approx(0.0, abs=1e-13)
    trace, det = exact.half(exact.pitchfork())
    assert 1.0 + trace + det == pytest.approx(0.0, abs=1e-13)


@pytest.mark.nightly
@EACH_BACKEND
def test_random_blocks_rock_as_the_closed_form_says(backend: str) -> None:
    """Points and multipliers of both halves, at the fold, at the pitchfork and between."""
    rng, map_ = np.random.default_rng(8), map_of("beta", backend=backend)
    for _ in range(6 if backend == "heyoka" else 2):
        w, r = rng.uniform(2.0, 4.0), rng.uniform(0.9, 0.98)  # no corner lifts off
        exact = Symmetric(w, r)
        for v in np.linspace(exact.fold(), exact.pitchfork(), 3):
            x, period = exact.point(v), 2.0 * math.pi / w
            image = map_.holding(w=w, r=r).at(x, np.array([exact.beta(v)]))
            assert image.piece.word == "I1+2f D2 I1f+2"
            away = image.value - x
            away[1] -= period * round(away[1] / period)
            assert np.abs(away).max() < CLOSE
            trace, det = exact.half(v)
            jacobian = image.jacobian[:, :2]
            assert np.trace(jacobian) == pytest.approx(trace**2 - 2.0 * det, abs=CLOSE)
            assert np.linalg.det(jacobian) == pytest.approx(det**2, abs=CLOSE)
