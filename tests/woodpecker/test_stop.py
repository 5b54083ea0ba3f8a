"""Branches that end where a rule of the user says."""

import math

import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind, PointStatus
from woodpecker.diagrams import continuation
from woodpecker.mechanics.toy import Toy
from woodpecker.search import BranchState
from woodpecker.shooting import PeriodicOrbit, shoot

ASKED = "stopped as asked"
pytestmark = [NEEDS_NUMBA, pytest.mark.slow]


@pytest.fixture(scope="module")
def motion() -> PeriodicOrbit:
    return shoot(Toy(), -0.53)


def asked(diagram: Diagram) -> list[float]:
    found = [point for point in diagram.points if point.note == ASKED]
    for point in found:
        assert point.kind is PointKind.EP
        assert point.status is PointStatus.LOCATED
        assert point.precision < 1e-13
    return sorted(point.parameter for point in found)


def test_at_a_parameter(motion: PeriodicOrbit) -> None:
    """The end is bracketed to rounding, and what begins beyond is not followed."""
    found = continuation(Toy(), motion, stop=lambda s: not 0.2 < s.parameter < 0.6)
    assert asked(found) == pytest.approx([0.2, 0.6], abs=1e-15)
    assert len(found.branches) == 1
    assert len(found.points) == 2


def test_at_a_multiplier(motion: PeriodicOrbit) -> None:
    """Where |multiplier| = 0.9 on either side of the start."""
    found = continuation(Toy(), motion, stop=lambda s: abs(s.multiplier) > 0.9)
    (branch,) = found.branches
    assert len(asked(found)) == 2
    for k in (0, -1):
        assert branch.multiplier[k] == pytest.approx(-0.9, abs=1e-12)
        there = shoot(Toy(eps_n1=float(branch.parameter[k])), float(branch.x[k]))
        assert there.multiplier == pytest.approx(-0.9, abs=1e-10)


def test_a_rule_sees_kind_order_points_and_word(motion: PeriodicOrbit) -> None:
    """At the first jump; words and points are those of the branch."""
    seen: list[BranchState] = []

    def rule(state: BranchState) -> bool:
        seen.append(state)
        return state.kind is BranchKind.JUMP

    found = continuation(Toy(), motion, stop=rule)
    for branch in found.branches:
        assert branch.kind is BranchKind.FIXED_POINT or len(branch) <= 2
    cycles = [state for state in seen if state.kind is BranchKind.FIXED_POINT]
    assert {state.order for state in seen} == {1}
    assert all(state.x == state.points[0] and state.word for state in seen)
    assert all(math.isnan(state.multiplier) for state in seen if state.kind is BranchKind.JUMP)
    assert "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2" in {state.word for state in cycles}
