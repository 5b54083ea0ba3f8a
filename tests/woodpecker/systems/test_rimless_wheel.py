"""The rimless wheel against its closed form, and where its foot slips against forces by hand."""

import math
from pathlib import Path

import pytest
from needs import EACH_BACKEND, NEEDS_HEYOKA
from scipy.optimize import brentq

from pwmap import PointKind
from pwmap.diagrams.diagram import BranchKind
from studies.systems import rimless_wheel
from studies.systems.rimless_wheel import ALPHA, MU, VALUES, J, map_of, walking
from woodpecker.systems import continuation, return_map, shoot


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize("j", [1.0, 0.01])
def test_walk_and_multiplier_are_those_of_the_closed_form(j: float, backend: str) -> None:
    for gamma in (0.1, 0.2):
        cycle = shoot(map_of("gamma", backend=backend).holding(j=j), [0.5], p=[gamma])
        speed, multiplier = walking(gamma, VALUES[ALPHA], j)
        assert cycle.word == "I1f+2s"  # the stance foot lifts off, the next one sticks
        assert cycle.x[0, 0] == pytest.approx(speed, abs=1e-10)
        assert cycle.multipliers[0] == pytest.approx(multiplier, abs=1e-10)


def test_a_wheel_without_inertia_keeps_the_cosine() -> None:
    """Garcia's and McGeer's wheel: all mass at the hub."""
    _, multiplier = walking(0.1, math.pi / 8, 0.0)
    assert multiplier == pytest.approx(0.5, abs=1e-15)  # cos(pi/4)**2


def friction_left(gamma: float) -> float:
    """mu N - |T| at the stance foot as the next foot strikes; the hub moves on a circle."""
    alpha, j, mu = VALUES[ALPHA], VALUES[J], VALUES[MU]
    speed, multiplier = walking(gamma, alpha, j)
    turn, square = math.sin(alpha + gamma) / (1.0 + j), speed**2 / multiplier
    normal = math.cos(gamma) - math.sin(alpha) * turn - math.cos(alpha) * square
    along = math.cos(alpha) * turn - math.sin(alpha) * square - math.sin(gamma)
    return mu * normal - abs(along)


@pytest.mark.nightly
@NEEDS_HEYOKA
def test_the_study_of_the_wheel(tmp_path: Path) -> None:
    found = rimless_wheel.main(fast=True, out=tmp_path)
    assert max(found["speed"], found["multiplier"]) < 1e-10
    exact = brentq(friction_left, 0.1, 0.38, xtol=1e-15)
    assert found["slips_from"] == pytest.approx(exact, abs=1e-9)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_beyond_the_slip_each_branch_is_listed_once() -> None:
    """Two branches and the crossing between them, from one end of the span and back to it."""
    map_ = map_of("gamma")
    cycle, span = shoot(map_, [0.8], p=[0.37]), (0.36, 0.4)
    diagram = continuation(map_, cycle, span, [(0, 2)], orders=(1,)).diagram
    assert sorted(each.id for each in diagram.branches) == ["F1", "F2", "J1"]
    assert sorted(q.id for q in diagram.points) == ["BC1", "EP1", "EP2", "FF1"]
    assert all(len(q.branches) == (1 if q.kind is PointKind.EP else 2) for q in diagram.points)
    (one,), (other,) = (
        return_map(map_, [each.x[0 if each.parameter[0] == span[0] else -1]], p=[span[0]]).images
        for each in diagram.branches
        if each.kind is BranchKind.FIXED_POINT
    )
    assert abs(one - other) > 0.1
