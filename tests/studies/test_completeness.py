"""Diagrams against plain tabulation, which sees what is taken from them or put in twice."""

from dataclasses import replace

import numpy as np
import pytest
from needs import NEEDS_NUMBA, SLOW_TOY
from short_runs import short_run

from pwmap import BranchKind, Diagram
from studies.common.tabulated import compared, tabulated, unpaired
from woodpecker import Search, Toy, bifurcation_diagram

WINDOW = (-1.0, -0.45)  # rad
SPAN, PLACE = (0.3, 0.36), 0.3456  # of eps_N1: two cycles, and a jump that crosses the diagonal
POINTS = 501  # their distances are a hundred of these


@pytest.fixture(scope="module")
def diagram() -> Diagram:
    search = Search(slices=3)
    return bifurcation_diagram(Toy(), "eps_n1", SPAN, (1,), WINDOW, search=search, workers=1)


def without(diagram: Diagram, kind: BranchKind) -> Diagram:
    """A diagram without its branches of a kind."""
    kept = tuple(branch for branch in diagram.branches if branch.kind is not kind)
    return replace(diagram, branches=kept)


def twice(diagram: Diagram) -> Diagram:
    """A diagram with all of its branches twice."""
    again = tuple(replace(branch, id=f"{branch.id}b") for branch in diagram.branches)
    return replace(diagram, branches=(*diagram.branches, *again))


@NEEDS_NUMBA
def test_a_table_shows_cycles_and_jumps_of_the_paper() -> None:
    """The stable cycle at eps_N1 = 0.5 and the jump at -0.8847733440, to the last double."""
    toy = Toy()
    (change,) = tabulated(toy, np.linspace(*WINDOW, POINTS), 1, WINDOW).changes
    assert (change.jumps, change.word) == (False, "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2")
    assert change.x == pytest.approx(-0.52947197, abs=1e-8)  # as it is published
    there = tabulated(toy.replace(eps_n1=PLACE), np.linspace(*WINDOW, POINTS), 1, WINDOW)
    (jump,) = there.places(jumps=True)
    assert jump == pytest.approx(-0.8847733440, abs=1e-10)


@NEEDS_NUMBA
def test_a_diagram_has_what_a_table_shows(diagram: Diagram) -> None:
    found = compared(Toy(), diagram, PLACE, 1, WINDOW, POINTS)
    assert (found["cycles"], found["jumps"]) == (2, 1)
    assert (found["drawn_cycles"], found["drawn_jumps"]) == (2, 1)
    assert found["missing"] == found["double"] == found["unconfirmed"] == []


@NEEDS_NUMBA
@pytest.mark.parametrize(
    ("kind", "count"), [(BranchKind.JUMP, 1), (BranchKind.FIXED_POINT, 2)], ids=str
)
def test_what_is_taken_from_a_diagram_is_missing(
    diagram: Diagram, kind: BranchKind, count: int
) -> None:
    found = compared(Toy(), without(diagram, kind), PLACE, 1, WINDOW, POINTS)
    assert len(found["missing"]) == count
    assert found["double"] == found["unconfirmed"] == []


@NEEDS_NUMBA
def test_what_is_drawn_twice_is_seen(diagram: Diagram) -> None:
    found = compared(Toy(), twice(diagram), PLACE, 1, WINDOW, POINTS)
    assert sorted(kind for kind, _ in found["double"]) == ["cycle", "cycle", "jump"]
    assert found["missing"] == found["unconfirmed"] == []
    assert found["closer"] == 0


def test_points_are_paired_with_others_that_are_near() -> None:
    left, free = unpaired(np.array([0.0, 1.0, 1.05, 3.0]), np.array([0.1, 1.1, 2.0]), 0.2)
    assert (left, free) == ([2, 3], [2])


@SLOW_TOY
def test_nothing_is_missing(tmp_path_factory: pytest.TempPathFactory) -> None:
    results = short_run("completeness", tmp_path_factory.mktemp("completeness"))
    for part in (results["paper"], *results["toys"]):
        assert part["cycles"] > 0
        assert part["missing"] == part["double"] == part["unconfirmed"] == []
        assert part["drawn_cycles"] >= part["cycles"]
