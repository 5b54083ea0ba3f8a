"""A jump crossing in two dimensions, from an impact and a take-off that change their order."""

import numpy as np
import pytest
from needs import NEEDS_HEYOKA

from pwmap import PointKind
from pwmap.diagrams.diagram import BranchKind
from studies.systems.crossing import followed, map_of
from woodpecker.base.arrays import Floats
from woodpecker.search.connected import Connected

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]


def limits(x: Floats, p: Floats) -> list[Floats]:
    """Both, from either side of the border that is nearest."""
    image = map_of().at(x, p)
    gradient = image.gradients[int(np.abs(image.margins).argmin())]
    return [map_of().beside(x, p, sign * gradient).value for sign in (1.0, -1.0)]


@pytest.fixture(scope="module")
def found() -> Connected:
    return followed()


def test_cycle_and_crossing_meet_where_both_events_coincide(found: Connected) -> None:
    diagram = found.diagram
    border, end = sorted(
        (q for q in diagram.points if q.kind is PointKind.BC), key=lambda q: q.parameter
    )
    assert "the wall" in border.cause
    assert "the floor" in border.cause
    kinds = [branch.kind for branch in diagram.branches if branch.id in border.branches]
    assert sorted(kinds, key=str) == [BranchKind.FIXED_POINT, BranchKind.JUMP]
    assert border.note == "fold"
    graph = diagram.graph()
    assert graph.degree(border.id) == 2
    assert graph.degree(end.id) == 1  # no more branches are asked for


def test_the_crossing_ends_at_a_fixed_point_of_the_other_side(found: Connected) -> None:
    """At either end the point of the border is its own image from one side."""
    ends = [q for q in found.diagram.points if q.kind is PointKind.BC]
    (jump,) = (b for b in found.diagram.branches if b.kind is BranchKind.JUMP)
    assert len(ends) == 2
    for k in (0, -1):
        x, p = np.array([jump.x[k], jump.columns["u_x"][k]]), jump.parameter[[k]]
        assert min(np.abs(x - side).max() for side in limits(x, p)) < 1e-9


def test_points_of_the_crossing_lie_between_both_limits(found: Connected) -> None:
    """x = s P_+(x) + (1 - s) P_-(x), with both limits from either side of the border."""
    (jump,) = (b for b in found.diagram.branches if b.kind is BranchKind.JUMP)
    for k in range(1, len(jump) - 1, 3):
        x, p = np.array([jump.x[k], jump.columns["u_x"][k]]), jump.parameter[k : k + 1]
        sides = limits(x, p)
        way, away = sides[1] - sides[0], x - sides[0]
        share = float(away @ way) / float(way @ way)
        assert 0.0 < share < 1.0
        assert np.abs(away - share * way).max() < 1e-8 * np.linalg.norm(way)
        assert np.linalg.norm(way) > 1e-3  # it is a jump
