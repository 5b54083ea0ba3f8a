"""Steep and crowded scenes of the toy on the engine, against the followers of the line.

Two programs that share the map only: places agree to the 1e-8 of the span asserted here, where the
worst is a fold beside a border.
"""

from typing import NamedTuple

import numpy as np
import pytest
from maps import continued
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import Diagram, PointKind
from woodpecker import Settings, Toy, ToyPieces, shoot
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.line import LineMap
from woodpecker.engine.network import connected

pytestmark = [pytest.mark.slow, NEEDS_NUMBA]

WINDOW = -2.5, -0.24
LENGTH = WINDOW[1] - WINDOW[0]


class Scene(NamedTuple):
    """A parameter, a cycle, a span, and the size of the parameter."""

    parameter: str
    x: float
    p: float
    span: tuple[float, float]
    size: float


def about(parameter: str, low: float) -> Scene:
    """The stable motion, and a parameter from a part of its value to 1.2 times that."""
    value = getattr(Toy(), parameter)
    return Scene(parameter, shoot(Toy(), -0.53).phi_s, value, (low * value, 1.2 * value), value)


def on_the_engine(scene: Scene) -> Diagram:
    map_ = LineMap(ToyPieces(Toy(), scene.parameter), LENGTH, scene.size)
    settings = CurveSettings(
        spans=(scene.span,), window=(WINDOW,), step=0.005, min_step=1e-13, max_step=0.02,
        max_turn=0.1,
    )  # fmt: skip
    return connected(
        map_, [scene.x], [scene.p], settings, orders=(1,), x_scale=(LENGTH,), p_scale=(scene.size,)
    ).diagram


def flips_in_tips(diagram: Diagram, within: float) -> set[str]:
    """Flips beside a fold: in the tip of a sharp fold they may be one point with it."""
    folds = [q.parameter for q in diagram.points if q.kind is PointKind.LP]
    return {
        q.id
        for q in diagram.points
        if q.kind is PointKind.PD and any(abs(q.parameter - p) < within for p in folds)
    }


def assert_same(scene: Scene, branches: int) -> None:
    own = on_the_engine(scene)
    settings = Settings(span=scene.span, window=WINDOW)
    known = continued(ToyPieces(Toy(), scene.parameter), scene.x, scene.p, settings)
    places = []
    for found in (own, known):
        sharp = flips_in_tips(found, 1e-11 * scene.size)
        assert len(found.branches) - len(sharp) == branches
        places.append(
            sorted((q.kind.value, q.parameter) for q in found.points if q.id not in sharp)
        )
    one, other = places
    assert [kind for kind, _ in one] == [kind for kind, _ in other]
    away = np.array([p for _, p in one]) - np.array([p for _, p in other])
    assert np.abs(away).max() < 1e-8 * scene.size


def test_folds_side_by_side() -> None:
    """Branches with slopes of 1e3 to 1e6 run 5e-5 of the window beside each other.

    A sample on the neighbour has much the same tangent.
    """
    start = -2.053406062136754, 0.18274692486568977
    assert_same(Scene("eps_n1", *start, (0.16, 0.19), 1.0), 24)


@pytest.mark.nightly
def test_a_branch_that_hugs_roots() -> None:
    """Slopes reach 1e13 at each border; beyond it the piece begins with a root."""
    start = -1.4500129611737054, 0.2992567336705579
    assert_same(Scene("eps_n1", *start, (0.152, 0.4), 1.0), 1)


@pytest.mark.nightly
def test_a_jump_whose_limit_changes_its_word_again_and_again() -> None:
    start = -1.151765823829134, 0.7596803500199938
    assert_same(Scene("eps_n1", *start, (0.73, 0.83), 1.0), 3)


@pytest.mark.nightly
def test_loops_within_a_step() -> None:
    """l_m: the branch turns back for 4e-7 where the lower sleeve leaves the pole once more."""
    assert_same(about("l_m", 0.8), 48)


@pytest.mark.nightly
@pytest.mark.parametrize(("parameter", "low", "branches"), [("r_m", 0.85, 10), ("r_0", 0.8, 11)])
def test_two_jumps_that_come_together(parameter: str, low: float, branches: int) -> None:
    """The piece between them ends, and the crossing goes back on the other one."""
    assert_same(about(parameter, low), branches)
