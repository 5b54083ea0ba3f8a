"""Connected branches as a diagram: maps solved by hand."""

from __future__ import annotations

import math
from collections.abc import Callable

import networkx as nx
import numpy as np
import pytest
from maps import (
    A,
    grazing,
    island,
    logistic,
    logistic_pair,
    lost_beyond,
    moving_edge,
    paper,
    skew_tent,
    staircase,
    start,
    two_cycle,
    two_lines,
)

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, PointKind
from woodpecker.diagram import connected
from woodpecker.piecewise.explore import Stage
from woodpecker.piecewise.maps import Evaluation, LabelledMap, iterate
from woodpecker.piecewise.network import SAME_POINT
from woodpecker.piecewise.settings import Settings

FIXED, JUMP = BranchKind.FIXED_POINT, BranchKind.JUMP

# Border collisions of the solved maps are found to a few roundings; see test_follow, test_jumps.
EXACT = 1e-11
# One step of continuation, Settings.max_step = 0.02 along a branch of either kind; bends add to it.
LONGEST = 0.0201


def explore(
    labelled_map: LabelledMap, x: float | list[float], p: float, span: tuple[float, float]
) -> Diagram:
    return connected(labelled_map, start(labelled_map, x, p), Settings(span=span))


def chain(codes: str) -> nx.MultiGraph:
    """Graph of a chain such as ``EP F BC J BC``: points and, between them, branches."""
    symbols = codes.split()
    kinds = {"F": "fixed-point", "J": "jump"}
    graph = nx.MultiGraph()
    for k, code in enumerate(symbols[::2]):
        graph.add_node(k, kind=code)
    for k, code in enumerate(symbols[1::2]):
        graph.add_edge(k, k + 1, kind=kinds[code])
    return graph


def assert_graph(diagram: Diagram, expected: nx.MultiGraph) -> None:
    assert nx.is_isomorphic(
        diagram.graph(),
        expected,
        node_match=nx.algorithms.isomorphism.categorical_node_match("kind", ""),
        edge_match=nx.algorithms.isomorphism.categorical_multiedge_match("kind", ""),
    ), [(branch.kind.value, branch.ends) for branch in diagram.branches]


def places(diagram: Diagram) -> dict[str, list[tuple[float, float]]]:
    """(parameter, x) of the special points by code, in ascending order."""
    found: dict[str, list[tuple[float, float]]] = {}
    for point in diagram.points:
        found.setdefault(point.kind.value, []).append((point.parameter, point.x))
    return {code: sorted(where) for code, where in found.items()}


def assert_places(diagram: Diagram, expected: dict[str, list[tuple[float, float]]]) -> None:
    found = places(diagram)
    assert found.keys() == expected.keys()
    for code, where in expected.items():
        assert np.array(found[code]) == pytest.approx(np.array(sorted(where)), abs=EXACT), code


def assert_curve(branch: Branch, x: Callable[[float], float]) -> None:
    expected = [x(p) for p in branch.parameter.tolist()]
    np.testing.assert_allclose(branch.x, expected, atol=EXACT, rtol=0.0)


def of_kind(diagram: Diagram, kind: BranchKind) -> list[Branch]:
    return [branch for branch in diagram.branches if branch.kind is kind]


def assert_sound(diagram: Diagram, longest: float = LONGEST) -> None:
    """What holds for every diagram: names, ends, and curves without gaps."""
    names = [branch.id for branch in diagram.branches] + [point.id for point in diagram.points]
    assert len(set(names)) == len(names)
    for point in diagram.points:
        assert point.branches
        for name in point.branches:
            assert point.id in diagram.branch(name).ends
    for branch in diagram.branches:
        for end, sample in zip(branch.ends, (0, -1), strict=True):
            point = diagram.point(end)
            assert branch.id in point.branches
            assert abs(branch.parameter[sample] - point.parameter) <= SAME_POINT
            assert abs(branch.x[sample] - point.x) <= SAME_POINT
        assert branch.word
        steps = np.hypot(np.diff(branch.parameter), np.diff(branch.x))
        assert steps.max(initial=0.0) <= longest, f"gap in {branch.id} {branch.ends}"


# --- solved maps ---------------------------------------------------------------------------------


def test_map_of_the_paper() -> None:
    """[Leine2001, Fig. 12]: fixed points r/(1 + a) and r - 2, joined by the jump from A to B."""
    diagram = explore(paper(), 1.0 / (1.0 + A), 1.0, (-1.0, 3.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F FF J BC F EP"))
    assert_places(
        diagram,
        {"FF": [(0.0, 0.0)], "BC": [(2.0, 0.0)], "EP": [(-1.0, -3.0), (3.0, 3.0 / (1.0 + A))]},
    )
    right, left = of_kind(diagram, FIXED)
    (jump,) = of_kind(diagram, JUMP)
    assert (right.word, left.word, jump.word) == ("R", "L", "L / R")
    assert_curve(right, lambda r: r / (1.0 + A))
    assert_curve(left, lambda r: r - 2.0)
    assert_curve(jump, lambda _: 0.0)
    assert set(right.multiplier.tolist()) == {-A}
    assert set(left.multiplier.tolist()) == {0.0}
    assert np.isnan(jump.multiplier).all()
    for branch, low, high in ((right, 0.0, 3.0), (left, -1.0, 2.0), (jump, 0.0, 2.0)):
        assert (branch.parameter.min(), branch.parameter.max()) == pytest.approx((low, high))
        assert branch.order == 1
    assert (diagram.parameter_name, diagram.x_name) == ("p", "x")
    assert {point.note for point in diagram.points} == {"fold", "end of the parameter span"}


def test_where_one_starts_does_not_matter() -> None:
    """From the other fixed point of the same diagram."""
    diagram = explore(paper(), -1.0, 1.0, (-1.0, 3.0))
    assert_graph(diagram, chain("EP F FF J BC F EP"))
    assert places(diagram)["FF"][0] == pytest.approx((0.0, 0.0), abs=EXACT)


def test_weak_slope_makes_point_a_a_mere_fold() -> None:
    diagram = explore(paper(0.5), 1.0 / 1.5, 1.0, (-1.0, 3.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0), (2.0, 0.0)], "EP": [(-1.0, -3.0), (3.0, 2.0)]})


def test_two_lines() -> None:
    diagram = explore(two_lines(), -1.0, -0.5, (-2.0, 2.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(-1.0, 0.0), (0.0, 0.0)], "EP": [(-2.0, -4.0), (2.0, 2.0)]})
    left, right = of_kind(diagram, FIXED)
    assert_curve(left, lambda p: 2.0 * p)
    assert_curve(right, lambda p: 2.0 * (p + 1.0) / 3.0)
    assert {point.note for point in diagram.points if point.kind is PointKind.BC} == {"fold"}


def test_staircase() -> None:
    """Persistence at both ends of the jump: the parameter ascends all the way."""
    diagram = explore(staircase(), -1.0, -0.5, (-2.0, 2.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0), (1.0, 0.0)], "EP": [(-2.0, -4.0), (2.0, 2.0)]})
    notes = {point.note for point in diagram.points if point.kind is PointKind.BC}
    assert notes == {"persistence"}


def test_moving_edge() -> None:
    diagram = explore(moving_edge, -2.0, 0.0, (-2.0, 2.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F BC J BC F EP"))
    assert_places(diagram, {"BC": [(-1.0, -0.5), (1.0, 0.5)], "EP": [(-2.0, -7.0), (2.0, 3.0)]})
    assert_curve(of_kind(diagram, JUMP)[0], lambda p: 0.5 * p)


def test_jump_cut_by_the_span() -> None:
    diagram = explore(two_lines(), -0.5, -0.25, (-0.5, 2.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F BC J EP"))
    assert_places(diagram, {"BC": [(0.0, 0.0)], "EP": [(-0.5, -1.0), (-0.5, 0.0)]})


def test_word_change_joins_two_branches() -> None:
    diagram = explore(skew_tent(0.5, -1.5), -0.2, -0.1, (-1.0, 1.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F WC F EP"))
    assert_places(diagram, {"WC": [(0.0, 0.0)], "EP": [(-1.0, -2.0), (1.0, 0.4)]})
    left, right = diagram.branches
    assert (left.word, right.word) == ("L", "R")
    assert set(left.multiplier.tolist()) == {0.5}
    assert set(right.multiplier.tolist()) == {-1.5}  # at the corner, too: the slope on its side


def test_grazing_flips_beyond_its_corner() -> None:
    diagram = explore(grazing(-1.0), -0.5, -0.25, (-1.0, 1.0))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP F WC F PD F EP"))
    stable = [branch.stable[1:-1] for branch in diagram.branches]
    assert [(bool(flags.any()), bool(flags.all())) for flags in stable] == [
        (True, True), (False, False), (True, True)
    ]  # fmt: skip


def test_fall_ends_a_branch() -> None:
    diagram = explore(lost_beyond(1.0), 0.0, 0.0, (-1.0, 1.0))
    assert_graph(diagram, chain("EP F FALL"))
    assert_places(diagram, {"EP": [(-1.0, -2.0)], "FALL": [(0.5, 1.0)]})
    assert [point.note for point in diagram.points if point.kind is PointKind.FALL] == ["lost"]


def test_flip_cuts_both_branches_of_period_two() -> None:
    """A cycle is followed once; each of its points has a branch."""
    diagram = explore(logistic, list(logistic_pair(3.2)), 3.2, (3.1, 3.6))
    assert_sound(diagram)
    once = chain("EP F PD F EP")
    assert_graph(diagram, nx.disjoint_union(once, once))
    assert {branch.order for branch in diagram.branches} == {2}
    for parameter, _ in places(diagram)["PD"]:
        assert parameter == pytest.approx(1.0 + math.sqrt(6.0), abs=1e-10)
    for k, branch in enumerate(diagram.branches):
        assert_curve(branch, lambda p, k=k: logistic_pair(p)[k // 2])


def test_island_is_drawn_once() -> None:
    """Two folds, and the circle of radius 0.3 covered once, wherever it is cut besides."""
    diagram = explore(island(-0.5, 0.5, 0.3), -0.2, 0.5, (-2.0, 2.0))
    folds = [point for point in diagram.points if point.kind is PointKind.LP]
    assert sorted(point.parameter for point in folds) == pytest.approx([0.2, 0.8], abs=1e-10)
    assert all(len(point.branches) == 2 for point in folds)
    length = sum(
        float(np.hypot(np.diff(branch.parameter), np.diff(branch.x)).sum())
        for branch in diagram.branches
    )
    # chords of 0.02 are short by (0.02/0.3)^2/24 = 2e-4; the closing gap is below 0.02
    assert length == pytest.approx(2.0 * math.pi * 0.3, abs=0.03)


def test_jump_of_the_second_iterate_starts_at_point_a() -> None:
    """P2^L: from the fixed point r/(1 + a), of slope a^2, to the jump r/a [Leine2001, Eq. 15]."""
    second = iterate(paper(), 2)
    diagram = explore(second, 1.0 / (1.0 + A), 1.0, (-1.0, 3.0))
    assert_sound(diagram)
    jumps = of_kind(diagram, JUMP)
    assert jumps, "no jump branch leaves point A"
    for jump in jumps:
        np.testing.assert_allclose(jump.x, jump.parameter / A, atol=1e-9)


def test_orbit_of_period_two_and_its_jumps() -> None:
    """Both phases of the orbit, joined and continued by jumps of the second iterate.

    The jumps are -2 (p < -1), 0 (-1 < p < 1/2) and 2 - 2 p (1/2 < p < 1), see maps.two_cycle.
    """
    diagram = explore(two_cycle, [-2 / 3, 2 / 3], 0.0, (-2.0, 0.9))
    assert_sound(diagram)
    assert_graph(diagram, chain("EP J BC F BC J BC F BC J EP"))
    assert_places(
        diagram,
        {
            "EP": [(-2.0, -2.0), (0.9, 0.2)],
            "BC": [(-1.0, -2.0), (0.5, 0.0), (-1.0, 0.0), (0.5, 1.0)],
        },
    )


def test_two_jumps_that_merge_give_birth_to_a_fixed_point() -> None:
    """Further on, 2 - 2 p meets 0 at p = 1, where the fixed point 2 (p - 1) begins."""
    diagram = explore(two_cycle, [-2 / 3, 2 / 3], 0.0, (-2.0, 2.0))
    assert_graph(diagram, chain("EP J BC F BC J BC F BC J BC F EP"))
    # the piece between the two jumps closes there: found to jumps.RESOLVED = 1e-11 only
    assert places(diagram)["BC"][-1] == pytest.approx((1.0, 0.0), abs=1e-10)


@pytest.mark.parametrize("lap", [0, 1])
def test_jump_branches_of_the_second_iterate_have_no_gaps(lap: int) -> None:
    """A jump starts where the branch that meets it ends, in the phase the diagram shows."""
    x = np.roll([-2 / 3, 2 / 3], -lap).tolist()
    diagram = explore(two_cycle, x, 0.0, (-2.0, 0.9))
    assert of_kind(diagram, JUMP)
    assert_sound(diagram)


def test_word_changes_close_together_stay_apart() -> None:
    """Beside the jump the right piece is renamed at p = -0.6 and again 5e-8 further on.

    The new names reach up to x = 0.1 only, which 2 (p + 1)/3 passes at p = -0.85.
    """
    first, second = -0.6, -0.6 - 5e-8

    def renamed(x: float, p: float) -> Evaluation:
        here = two_lines()(x, p)
        name = "far" if x > 0.1 else "R0" if p >= first else "R1" if p >= second else "R2"
        return here if x < 0.0 else here._replace(word=name)

    diagram = explore(renamed, -1.0, -0.5, (-2.0, 2.0))
    assert_graph(diagram, chain("EP F BC J WC J WC J BC F WC F EP"))
    changes = [p for p, _ in places(diagram)["WC"]]
    assert changes == pytest.approx([-0.85, second, first], abs=1e-9)
    assert {branch.word for branch in of_kind(diagram, JUMP)} == {"L / R0", "L / R1", "L / R2"}


def test_names_and_progress_are_passed_on() -> None:
    seen: list[Stage] = []
    labelled = two_lines()
    diagram = connected(
        labelled, start(labelled, -1.0, -0.5), Settings(span=(-2.0, 2.0)),
        parameter_name="mu", x_name="phi", progress=seen.append,
    )  # fmt: skip
    assert (diagram.parameter_name, diagram.x_name) == ("mu", "phi")
    assert min(stage.parameter for stage in seen) == -2.0
    assert max(stage.parameter for stage in seen) == 2.0


# --- the toy -------------------------------------------------------------------------------------
