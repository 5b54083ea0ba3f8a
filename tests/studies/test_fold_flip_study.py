"""The fold-flip of a pushed oscillator on a belt, against DOP853 and the tent map."""

import numpy as np
import pytest
from needs import NEEDS_HEYOKA
from short_runs import ShortRun, is_picture, kept_run

from pwmap import PointKind
from studies.systems import fold_flip

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> ShortRun:
    return kept_run("system_fold_flip", tmp_path_factory)


def test_where_it_lies_and_what_is_beside_it(run: ShortRun) -> None:
    """Against DOP853, and from both sides; cycles beside it are those of the tent map."""
    assert run[0]["border"] < 1e-9  # both solve one equation to the rounding of their integrators
    # differences of order four with steps of 1e-3, of values known to 1e-13, are known to 1e-9
    assert run[0]["multipliers"] < 2e-9
    assert run[0]["sides"] < 1e-13  # the rounding of the terms of a slip
    above, below = run[0]["slopes"]
    assert above > 1.0
    assert below < -1.0
    assert run[0]["cycles"] == run[0]["tent"] == ["L", "LLR", "LR", "LRR", "R"]
    assert is_picture(run[1] / "system_fold_flip.png")


@pytest.mark.parametrize("sticks", [False, True])
def test_it_folds_and_flips(sticks: bool) -> None:
    """On one side there are both cycles and one of twice the period, on the other side none."""
    found = fold_flip.followed(sticks=sticks)
    diagram = found.diagram
    (point,) = (q for q in diagram.points if q.kind is PointKind.BC)
    assert point.note == "fold"
    assert "for an instant" in point.cause
    meeting = [each for each in diagram.branches if each.id in point.branches]
    assert sorted(each.order for each in meeting) == [1, 1, 2, 2]
    for each in meeting:
        assert np.min(each.parameter) == pytest.approx(point.parameter, abs=1e-8)
    # At a distance h the multiplier is 1.4437526 - 6.5 sqrt(h) where it sticks: from h of 1e-7 to
    # 3e-14 it has that limit to 1e-7.
    assert fold_flip.slopes_of(found) == pytest.approx((1.4437526, -2.3316900), abs=3e-7)
