"""Things at values of a parameter: all that are near, in the order in which they came."""

import numpy as np

from woodpecker.search.nearby import Nearby


def test_all_that_are_near_are_found_in_their_order() -> None:
    rng, width = np.random.default_rng(3), 1e-3
    places = rng.uniform(-0.05, 0.05, 400)
    kept = Nearby[int](width)
    for k, p in enumerate(places.tolist()):
        kept.add(p, k)
    for p in rng.uniform(-0.06, 0.06, 50).tolist():
        found = kept.near(p)
        assert found == sorted(found)
        assert set(np.flatnonzero(np.abs(places - p) <= width)) <= set(found)
        assert np.abs(places[found] - p).max(initial=0.0) <= 2.0 * width
