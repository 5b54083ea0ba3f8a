"""Branches of the toy that are hard to follow: where a margin dips, where a limit ends."""

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import PointKind, PointStatus
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import Toy
from woodpecker.search.diagrams import cycle_near
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import to_engine
from woodpecker.slices.slices import slices_at
from woodpecker.toy_map import ToyPieces

DIGITS = 1e-10  # of the places that are written here


@pytest.mark.nightly
@NEEDS_NUMBA
@pytest.mark.parametrize(
    ("p", "x"), [(0.14, -2.42089938), (0.165, -1.89591451), (0.3, -1.11014887)]
)
def test_a_margin_that_dips_below_zero_does_not_turn_a_branch_round(p: float, x: float) -> None:
    """The upper arm of the island, from the window's end to its collision, wherever it is entered.

    Within a step the beak's margins vanish, come back and vanish again: the branch was turned round
    where one came back (0.14553785, 0.14830486, 0.15757030, depending on where steps fell).
    """
    settings = Settings(span=(0.012, 1.0), window=(-2.5, -0.24))
    map_ = ToyPieces(Toy())
    start = to_engine(cycle_near(map_, [x], p, settings))
    curve = Tasks.of_line(map_, settings).cycle(start).curve
    ends = sorted((end.p, float(end.x[0, 0]), end.kind) for end in curve.ends)
    assert [kind for *_, kind in ends] == [PointKind.EP, PointKind.FF]
    assert [(p, x) for p, x, _ in ends] == [
        pytest.approx((0.1376285067, -2.5), abs=DIGITS),
        pytest.approx((0.3883495889, -0.8847733440), abs=DIGITS),
    ]
    way = np.sign(curve.parameter[-1] - curve.parameter[0])
    # where two borders lie closer than orbits are told apart a sample may lie a little behind
    assert (way * np.diff(curve.parameter)).min() > -settings.same * settings.p_scale


@NEEDS_NUMBA
@pytest.mark.slow
def test_a_jump_of_the_second_iterate_whose_limit_ends_in_a_root() -> None:
    """Beyond that root the next return has no value: no sample there, and the branch goes on."""
    settings = Settings(span=(0.012, 0.3), window=(-2.5, -0.24))
    map_ = ToyPieces(Toy())
    (found,) = slices_at(map_, 0.2539190149, (2,), settings)
    jump = min(found.jumps, key=lambda jump: abs(jump.head.x[0] + 2.2666708))
    curve = Tasks.of_line(map_, settings).jump(jump).curve
    first, last = sorted(curve.ends, key=lambda end: end.p)
    assert first.status is last.status is PointStatus.LOCATED
    assert min(curve.parameter) == first.p < 0.2532
    assert max(curve.parameter) == last.p > 0.26  # the root lies at 0.2539199558
    assert np.isfinite(curve.x).all()
