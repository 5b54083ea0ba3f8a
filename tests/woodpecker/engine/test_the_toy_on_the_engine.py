"""The toy's return map followed by the engine, against what it is known to do."""

from itertools import pairwise

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind
from woodpecker import Toy, ToyPieces, continuation, shoot
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.line import LineMap
from woodpecker.engine.network import connected

WINDOW = -2.5, -0.24


@pytest.fixture(scope="module")
def diagram() -> Diagram:
    """All that is connected with the toy's stable motion, as the engine finds it."""
    length = WINDOW[1] - WINDOW[0]
    map_ = LineMap(ToyPieces(Toy(), "eps_n1"), x_scale=length)
    settings = CurveSettings(
        spans=((0.0, 1.0),), window=(WINDOW,), step=0.005, min_step=1e-13, max_step=0.02,
        max_turn=0.1,
    )  # fmt: skip
    start = shoot(Toy(eps_n1=0.5), -0.53)
    return connected(
        map_, [start.phi_s], [0.5], settings, orders=(1,), x_scale=(length,)
    ).diagram  # fmt: skip


@pytest.mark.nightly
@NEEDS_NUMBA
def test_special_points_are_those_that_continuation_finds(diagram: Diagram) -> None:
    """Kind, note and place; both locate to rounding, which the map amplifies a thousand times."""
    toy = Toy(eps_n1=0.5)
    known = continuation(toy, shoot(toy, -0.53))
    places = [
        sorted((q.kind.value, q.note, q.parameter, q.x) for q in each.points)
        for each in (diagram, known)
    ]
    assert [place[:2] for place in places[0]] == [place[:2] for place in places[1]]
    numbers = [np.array([place[2:] for place in each]) for each in places]
    assert numbers[0] == pytest.approx(numbers[1], abs=1e-12)


@NEEDS_NUMBA
def test_branches_join_the_same_points(diagram: Diagram) -> None:
    """Nine of fixed points and four of jump crossings, in one chain from span's end to end."""
    kinds = [branch.kind for branch in diagram.branches]
    assert kinds.count(BranchKind.FIXED_POINT) == 9
    assert kinds.count(BranchKind.JUMP) == 4
    assert len(diagram.points) == 14
    ends = [q for q in diagram.points if q.kind is PointKind.EP]
    assert sorted(q.parameter for q in ends) == [0.0, 1.0]
    assert all(len(q.branches) == 2 for q in diagram.points if q not in ends)


@NEEDS_NUMBA
def test_words_change_with_a_cause(diagram: Diagram) -> None:
    """The stable branch between C and its flip: as many changes of word as germs show there."""
    (stable,) = (
        b for b in diagram.branches
        if b.kind is BranchKind.FIXED_POINT and min(b.parameter) < 0.5 < max(b.parameter)
    )  # fmt: skip
    words = [stretch.word for stretch in stable.words]
    assert len(words) == 15
    assert all(one != other for one, other in pairwise(words))
    assert all(stretch.cause for stretch in stable.words[1:])
