"""Solutions between the samples of a diagram, to the last digits."""

from __future__ import annotations

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, Diagram
from woodpecker.continued import continuation
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import shoot
from woodpecker.simulation.returns import first_return
from woodpecker.solutions import solutions

TOY = Toy()


@pytest.fixture(scope="module")
def diagram() -> Diagram:
    return continuation(TOY, shoot(TOY, -0.53), span=(0.1, 0.7))


@pytest.mark.slow
@NEEDS_NUMBA
def test_each_branch_is_met_exactly(diagram: Diagram) -> None:
    """Straight lines are off by some 1e-5; solutions by the rounding of a return."""
    furthest = 0.0
    for value in np.random.default_rng(11).uniform(0.1, 0.7, 25).tolist():
        met = [hit for hit in diagram.at(value) if hit.branch.kind is BranchKind.FIXED_POINT]
        found = solutions(TOY, diagram, value)
        assert [one.branch.id for one in found] == [hit.branch.id for hit in met]
        for (branch, orbit), hit in zip(found, met, strict=True):
            assert orbit.success, (value, orbit.message)
            back = first_return(TOY.replace(eps_n1=value), orbit.phi_s)
            # rounding of a return of slope m is some 20 spacings of doubles times m
            assert back.phi_s == pytest.approx(orbit.phi_s, abs=1e-14 * (1.0 + abs(back.slope)))
            assert orbit.word in {stretch.word for stretch in branch.words}
            assert orbit.multiplier == pytest.approx(hit.multiplier, abs=0.02)
            furthest = max(furthest, abs(orbit.phi_s - hit.x))
    assert 1e-6 < furthest < 1e-3


@NEEDS_NUMBA
def test_wrong_values_are_refused(diagram: Diagram) -> None:
    with pytest.raises(ValueError, match=r"eps_n1 must lie in \[0, 1\], got 2.0"):
        solutions(TOY, diagram, 2.0)
    assert solutions(TOY, diagram, 0.9) == ()
