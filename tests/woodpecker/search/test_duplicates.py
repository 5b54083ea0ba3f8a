"""Which orbits branches explain: those of the same pieces are asked first."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from maps import fold, skew_tent, two_lines
from sympy import Piecewise, symbols

from pwmap import BranchKind, PointKind, PointStatus
from woodpecker import bifurcation_diagram, from_sympy
from woodpecker.base.settings import Settings
from woodpecker.engine.newton import Problem, Solution
from woodpecker.engine.orbits import SpaceOrbit
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.search import duplicates as module
from woodpecker.search.curves import BranchCurve, End
from woodpecker.search.duplicates import Duplicates
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks, base_of
from woodpecker.slices.orbits import CYCLE, orbit_of, problem_of, to_engine

SETTINGS = Settings(span=(-0.9, -0.1), window=(-3.0, 3.0))
PROBLEM = problem_of(SETTINGS, *CYCLE)


def fixed_point(map_: PiecewiseMap, x: float, p: float) -> SpaceOrbit:
    """A fixed point that is known exactly."""
    return to_engine(orbit_of([map_.at(x, p).piece], np.array([x]), p))


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Parameters at which the pieces of a branch were solved for."""
    places: list[float] = []
    solve = module.solve

    def counted(problem: Problem, start: SpaceOrbit) -> Solution:
        places.append(float(start.p[0]))
        return solve(problem, start)

    monkeypatch.setattr(module, "solve", counted)
    return places


def known_of(map_: PiecewiseMap, *starts: SpaceOrbit) -> Duplicates:
    """What the branches through some fixed points explain."""
    network = Network(SETTINGS)
    for start in starts:
        network.add(Tasks.of_line(map_, SETTINGS).cycle(start).curve)
    return Duplicates(network, BranchKind.FIXED_POINT, 1, base_of(map_, SETTINGS))


def test_a_branch_of_the_same_word_explains_without_more(asked: list[float]) -> None:
    """2 p and 2 (p + 1)/3 of two lines, far apart, and of a tent p/2 and p/4, close together."""
    for map_, left, right in (
        (two_lines(), lambda p: 2.0 * p, lambda p: 2.0 * (p + 1.0) / 3.0),
        (skew_tent(-1.0, 5.0), lambda p: 0.5 * p, lambda p: -0.25 * p),
    ):
        known = known_of(map_, *(fixed_point(map_, x(-0.5), -0.5) for x in (left, right)))
        for p in (-0.8123, -0.3456, -0.1001):
            for x in (left(p), right(p)):
                orbit = fixed_point(map_, x, p)
                assert known.explains(orbit, PROBLEM, orbit.keys)
    assert not asked


def test_a_branch_of_another_word_does_not(asked: list[float]) -> None:
    """It is asked whether it holds there, once, however many orbits are near it."""
    map_, p = two_lines(), -0.3456
    known = known_of(map_, fixed_point(map_, -1.0, -0.5))
    right = map_.at(1.0, p).piece
    for _ in range(3):
        orbit = to_engine(orbit_of([right], np.array([2.0 * p]), p))  # where the left branch is
        assert not known.explains(orbit, PROBLEM, orbit.keys)
    assert asked == [p]


def test_a_branch_that_is_added_later_counts() -> None:
    map_, p = two_lines(), -0.3456
    known = known_of(map_, fixed_point(map_, -1.0, -0.5))
    other = fixed_point(map_, 2.0 * (p + 1.0) / 3.0, p)
    assert not known.explains(other, PROBLEM, other.keys)
    added = fixed_point(map_, 1.0 / 3.0, -0.5)
    known.network.add(Tasks.of_line(map_, SETTINGS).cycle(added).curve)
    assert known.explains(other, PROBLEM, other.keys)


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_a_branch_that_was_given_up_is_not_drawn_where_another_goes_on(order: list[int]) -> None:
    """2 p, from -0.9 to -0.1, and what is left of it if it is given up sooner or later."""
    map_ = two_lines()
    whole = Tasks.of_line(map_, SETTINGS).cycle(fixed_point(map_, -1.0, -0.5)).curve
    parts = [given_up(whole, sample) for sample in (3, 1)]
    network = Network(SETTINGS)
    for number in order:
        network.add([whole, *parts][number])
    diagram = network.diagram("p", "x")
    (branch,) = diagram.branches
    assert sorted(branch.parameter[[0, -1]].tolist()) == [-0.9, -0.1]
    assert {point.status for point in diagram.points} == {PointStatus.LOCATED}
    network = Network(SETTINGS)
    for part in parts:
        network.add(part)
    (branch,) = network.diagram("p", "x").branches  # the longer one
    assert len(branch.parameter) == len(parts[1].parameter)


def test_one_half_of_a_fold_is_no_part_of_the_other() -> None:
    """x = +-sqrt(p): two branches come to the fold, of which one was given up on the way."""
    map_, settings = fold(), Settings(span=(-1.0, 0.5))
    upper, lower = (
        Tasks.of_line(map_, settings).cycle(fixed_point(map_, x, 0.25)).curve for x in (0.5, -0.5)
    )
    network = Network(settings)
    for each in (upper, given_up(lower, 2)):
        network.add(each)
    assert len(network.diagram("p", "x").branches) == 2


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_what_another_branch_passes_along_is_not_drawn(order: list[int]) -> None:
    """2 p from -0.9 to -0.1 passes two special points, at which two other branches end.

    If anything else starts there, the points are kept, and with them the branches that end there.
    """
    whole = Tasks.of_line(two_lines(), SETTINGS).cycle(fixed_point(two_lines(), -1.0, -0.5)).curve
    network = Network(SETTINGS)
    branches = whole, between(whole, 5, 20), between(whole, 20, 40)
    for number in order:
        network.add(branches[number])
    (branch,) = network.diagram("p", "x").branches
    assert len(branch.parameter) == len(whole.parameter)
    end = branches[2].ends[1]
    away = replace(
        whole, parameter=np.array([end.p, end.p]), points=(end.x, end.x + 0.1),
        multiplier=np.array([0.5, 0.5]), ends=(end, replace(end, x=end.x + 0.1)),
    )  # fmt: skip
    network.add(away)
    assert len(network.diagram("p", "x").branches) == 4


def between(curve: BranchCurve, first: int, last: int) -> BranchCurve:
    """A branch from one sample to another, where borders end it."""
    ends = (
        End(kind=PointKind.BC, p=float(curve.parameter[k]), x=curve.points[k])
        for k in (first, last)
    )
    return part(curve, slice(first, last + 1), *ends)


def part(curve: BranchCurve, kept: slice, *ends: End) -> BranchCurve:
    columns = {name: getattr(curve, name)[kept] for name in ("parameter", "points", "multiplier")}
    return replace(curve, **columns, ends=ends)


def given_up(curve: BranchCurve, sample: int) -> BranchCurve:
    """A branch from a sample on, where it was given up, to its end."""
    p, x = float(curve.parameter[sample]), curve.points[sample]
    end = End(kind=PointKind.EP, p=p, x=x, note="given up", status=PointStatus.OPEN)
    return part(curve, slice(sample, None), end, curve.ends[1])


def test_jumps_at_both_ends_of_a_thin_piece_are_two_branches() -> None:
    """They lie a few 1e-4 of the window apart, at p/2 -+ 1e-3 sqrt(1 + p/2), and one is longer."""
    x, p = symbols("x p")
    inside = (x - p / 2) ** 2 < (1 + p / 2) / 10**6
    map_ = from_sympy(Piecewise((x / 4 - 1, inside), (x / 4 + 1, True)), x, p)
    diagram = bifurcation_diagram(map_, "p", (-1.0, 1.0), window=(-3.0, 3.0))
    jumps = [branch for branch in diagram.branches if branch.kind is BranchKind.JUMP]
    assert [jump.words[0].word for jump in jumps] == ["B / A", "A / B"]
    for jump, side in zip(jumps, (-1.0, 1.0), strict=True):
        q = jump.parameter
        np.testing.assert_allclose(jump.x, q / 2 + 1e-3 * side * np.sqrt(1 + q / 2), atol=1e-12)
