"""Assertions on diagrams for tests of the engine: graphs, places, branches without gaps."""

from collections.abc import Callable

import networkx as nx
import numpy as np
import pytest

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from woodpecker.base.settings import Settings
from woodpecker.search.curves import BranchCurve
from woodpecker.search.network import AT_FLIP
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import Orbit, to_engine

FIXED, JUMP = BranchKind.FIXED_POINT, BranchKind.JUMP

# Border collisions and folds of the solved maps solve equations whose coefficients are about 1, so
# they are located to some roundings of them.
LOCATED = 1e-13
BENT = 1.01  # a step of continuation against its length: it leaves the chord by max_turn^2/2


def chain(codes: str) -> nx.MultiGraph:
    """Graph of a chain such as ``EP F BC J BC``: points and, between them, branches."""
    symbols = codes.split()
    kinds = {"F": str(FIXED), "J": str(JUMP)}
    graph = nx.MultiGraph()
    for k, code in enumerate(symbols[::2]):
        graph.add_node(k, kind=code)
    for k, code in enumerate(symbols[1::2]):
        graph.add_edge(k, k + 1, kind=kinds[code])
    return graph


def assert_graph(diagram: Diagram, expected: nx.MultiGraph) -> None:
    """Points and branches are connected as in a graph of their kinds."""
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


def assert_places(
    diagram: Diagram, expected: dict[str, list[tuple[float, float]]], within: float = LOCATED
) -> None:
    """All special points, by code and place."""
    found = places(diagram)
    assert found.keys() == expected.keys()
    for code, where in expected.items():
        assert np.array(found[code]) == pytest.approx(np.array(sorted(where)), abs=within), code


def assert_curve(branch: Branch, x: Callable[[float], float]) -> None:
    """All samples of a branch lie on a curve x(p)."""
    expected = [x(p) for p in branch.parameter.tolist()]
    np.testing.assert_allclose(branch.x, expected, atol=LOCATED, rtol=0.0)


def of_kind(diagram: Diagram, kind: BranchKind) -> list[Branch]:
    """Its branches of a kind."""
    return [branch for branch in diagram.branches if branch.kind is kind]


def points_of(diagram: Diagram, code: str) -> list[SpecialPoint]:
    """Its special points of a code, by their parameter."""
    found = [point for point in diagram.points if point.kind.value == code]
    return sorted(found, key=lambda point: (point.parameter, point.x))


def notes(diagram: Diagram, code: str) -> list[str]:
    """What the special points of a code leave open, by their parameter."""
    return [point.note for point in points_of(diagram, code)]


def assert_sound(diagram: Diagram, settings: Settings) -> None:
    """What holds for every diagram: names, ends, and curves without gaps that turn in points."""
    names = [branch.id for branch in diagram.branches] + [point.id for point in diagram.points]
    assert len(set(names)) == len(names)
    for point in diagram.points:
        assert point.branches
        for name in point.branches:
            assert point.id in diagram.branch(name).ends
        if point.interval is not None:
            assert point.interval[0] <= point.parameter <= point.interval[1]
    for branch in diagram.branches:
        for end, sample in zip(branch.ends, (0, -1), strict=True):
            point = diagram.point(end)
            assert branch.id in point.branches
            near = AT_FLIP if point.kind is PointKind.PD else settings.same
            away = abs(branch.parameter[sample] - point.parameter) / settings.p_scale
            assert away <= settings.same
            assert abs(branch.x[sample] - point.x) / settings.x_scale <= near
        assert branch.word
        assert _turns(branch) == 0, f"{branch.id} {branch.ends} turns, or stays"
        steps = np.hypot(
            np.diff(branch.parameter) / settings.p_scale, np.diff(branch.x) / settings.x_scale
        )
        assert steps.max(initial=0.0) <= BENT * settings.max_step, (branch.id, branch.ends)


def _turns(branch: Branch) -> int:
    """How often the parameter turns, or stays; where two jumps meet in a corner they may turn."""
    ways = np.sign(np.diff(branch.parameter))
    changes = ways[1:] != ways[:-1]
    if branch.kind is JUMP:
        corners = [stretch.first + k for stretch in branch.changes for k in (-2, -1)]
        changes[[k for k in corners if 0 <= k < len(changes)]] = False
    return int(changes.sum()) + int((ways == 0.0).sum())


def to_the_last_bit(diagram: Diagram) -> list[tuple[object, ...]]:
    """All of a diagram, in its order."""
    return [
        *(
            (
                b.id, b.kind, b.order, b.words, b.ends,
                b.parameter.tobytes(), b.x.tobytes(), b.multiplier.tobytes(),
            )
            for b in diagram.branches
        ),
        *(
            (
                p.id, p.kind, p.parameter, p.x, p.branches, p.order, p.note, p.cause, p.status,
                p.precision, p.interval,
            )
            for p in diagram.points
        ),
    ]  # fmt: skip


def chained(tasks: Tasks, orbit: Orbit) -> list[BranchCurve]:
    """The branch through a cycle, and those that continue it, of a chain that is not closed."""
    found, todo = list[BranchCurve](), [tasks.cycle(to_engine(orbit))]
    while todo:
        followed = todo.pop(0)
        found.append(followed.curve)
        todo += [tasks.ahead(start) for start in followed.onward]
    return found
