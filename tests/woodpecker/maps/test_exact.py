"""The comparison of computed diagrams with proved ones sees what differs, and nothing else."""

from collections.abc import Callable
from dataclasses import replace
from random import Random

import exact
import numpy as np
import pytest
from exact import Graph, essential, random_case, random_map, same_graph

from pwmap import Branch, BranchKind, Diagram, PiecewiseLinearMap, PointKind, SpecialPoint
from pwmap import bifurcation_diagram as exact_diagram
from woodpecker.maps.derivatives import check_derivatives
from woodpecker.maps.symbolic import from_pwmap

FIXED, JUMP = BranchKind.FIXED_POINT, BranchKind.JUMP
Change = Callable[[Diagram], Diagram]


def point(name: str, kind: str, p: float, x: float) -> SpecialPoint:
    return SpecialPoint(id=name, kind=PointKind(kind), parameter=p, x=x)


def branch(
    name: str, kind: BranchKind, ends: tuple[str, str], p: list[float], x: list[float]
) -> Branch:
    slope = 0.5 if kind is FIXED else np.nan
    return Branch(
        id=name, kind=kind, order=1, word="", parameter=np.array(p), x=np.array(x),
        multiplier=np.full(len(p), slope), ends=ends,
    )  # fmt: skip


def two_lines() -> Diagram:
    """By hand: x/2 + p for x < 0, -x/2 + p + 1 for x >= 0.

    Fixed points 2 p (p < 0) and 2 (p + 1)/3 (p >= -1); the jump at 0 crosses for -1 < p < 0.
    """
    points = (
        point("EP1", "EP", -2.0, -4.0),
        point("BC1", "BC", -1.0, 0.0),
        point("BC2", "BC", 0.0, 0.0),
        point("EP2", "EP", 1.0, 4.0 / 3.0),
    )
    branches = (
        branch("A", FIXED, ("EP1", "BC2"), [-2.0, -1.5, -0.2, 0.0], [-4.0, -3.0, -0.4, 0.0]),
        branch("B", FIXED, ("EP2", "BC1"), [1.0, 0.5, -1.0], [4.0 / 3.0, 1.0, 0.0]),
        branch("C", JUMP, ("BC1", "BC2"), [-1.0, -0.4, 0.0], [0.0, 0.0, 0.0]),
    )
    return Diagram(parameter_name="p", x_name="x", branches=branches, points=points)


def proved() -> Diagram:
    map_ = PiecewiseLinearMap([("x/2 + p", "x < 0"), ("-x/2 + p + 1", "x >= 0")])
    return exact_diagram(map_, "p", (-2, 1), orders=(1,))


def moved(name: str, **change: object) -> Change:
    """A diagram with one point changed."""

    def changed(diagram: Diagram) -> Diagram:
        points = [replace(p, **change) if p.id == name else p for p in diagram.points]  # type: ignore[arg-type]
        return replace(diagram, points=tuple(points))

    return changed


def redrawn(name: str, **change: object) -> Change:
    """A diagram with one branch changed."""

    def changed(diagram: Diagram) -> Diagram:
        branches = [
            replace(b, **change) if b.id == name else b  # type: ignore[arg-type]
            for b in diagram.branches
        ]
        return replace(diagram, branches=tuple(branches))

    return changed


def without(name: str) -> Change:
    return lambda d: replace(d, branches=tuple(b for b in d.branches if b.id != name))


def twice(name: str) -> Change:
    return lambda d: replace(d, branches=(*d.branches, replace(d.branch(name), id="again")))


def with_point(extra: SpecialPoint) -> Change:
    return lambda d: replace(d, points=(*d.points, extra))


def test_the_same_diagram() -> None:
    assert same_graph(two_lines(), proved()) == []
    assert same_graph(moved("BC1", x=5e-10)(two_lines()), proved()) == []


def back_and_forth(diagram: Diagram) -> Diagram:
    """A jump that is followed, turned round, and followed again."""
    p = np.array([-1.0, -0.2, -0.8, 0.0])
    return redrawn("C", parameter=p, x=0.0 * p, multiplier=np.full(4, np.nan))(diagram)


@pytest.mark.parametrize(
    ("change", "sentences"),
    [
        (
            moved("BC1", x=2e-9),
            ["BC BC1 at p=-1, x=2e-09 is computed only: the nearest is",
             "BC BC1 (fold) at p=-1, x=0 is proved only", "branch B of P_1",
             "branch C of P_1", "is proved only", "is proved only"],
        ),
        (moved("BC2", kind=PointKind.FF), ["FF BC2 at p=0, x=0 is computed where BC"]),
        (without("C"), ["jump branch J1 of P_1 from (p=-1, x=0) to (p=0, x=0) is proved only"]),
        (twice("A"), ["(p=-2, x=-4) to (p=0, x=0) is computed only: drawn twice"]),
        (with_point(point("new", "BC", -1.0, 0.0)), ["at p=-1, x=0 is computed only: drawn"]),
        (redrawn("C", kind=FIXED), ["fixed-point branch C of P_1", "jump branch J1 of P_1"]),
        (redrawn("C", order=2), ["jump branch C of P_2", "jump branch J1 of P_1"]),
        (redrawn("A", ends=("EP1", "BC1")), ["branch A of P_1", "branch F"]),
        (redrawn("C", x=np.array([0.0, 1e-8, 0.0])), ["branch C of P_1", "branch J1 of P_1"]),
        (back_and_forth, ["branch C of P_1", "branch J1 of P_1"]),
    ],
)  # fmt: skip
def test_what_differs_is_named(change: Change, sentences: list[str]) -> None:
    said = same_graph(change(two_lines()), proved())
    assert len(said) == len(sentences)
    for sentence, found in zip(sentences, said, strict=True):
        assert sentence in found


def test_branches_of_two_orders_are_never_one() -> None:
    kink = replace(point("k", "BC", 0.0, 1.0), note="persistence")
    ends = (kink, point("e1", "EP", -1.0, 1.0), point("e2", "EP", 1.0, 1.0))
    lines = [
        branch(f"F{k}", FIXED, ("k", f"e{k}"), [0.0, 2.0 * k - 3.0], [1.0, 1.0]) for k in (1, 2)
    ]
    for order in (1, 2):
        branches = (lines[0], replace(lines[1], order=order))
        diagram = Diagram(parameter_name="p", x_name="x", branches=branches, points=ends)
        assert ("k" in essential(diagram).nodes) == (order == 2)


def as_diagram(graph: Graph) -> Diagram:
    """A graph as a computation would draw it."""
    branches = [
        Branch(
            id=edge.name, kind=edge.kind, order=edge.order, word="", parameter=edge.p, x=edge.x,
            multiplier=np.full(len(edge.p), 0.5), ends=edge.ends,
        )
        for edge in graph.edges
    ]  # fmt: skip
    return Diagram(
        parameter_name="p", x_name="x", branches=tuple(branches),
        points=tuple(graph.nodes.values()),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_random_cases_agree_with_themselves_only(seed: int) -> None:
    """Each of them, drawn without words, is its own graph, and none if a branch is left out."""
    _, diagram = random_case(Random(seed), (1, 2))
    drawn = as_diagram(essential(diagram))
    assert same_graph(drawn, diagram) == []
    for gone in drawn.branches:
        rest = tuple(b for b in drawn.branches if b is not gone)
        said = same_graph(replace(drawn, branches=rest), diagram)
        assert len(said) == 1
        assert "is proved only" in said[0]


@pytest.mark.nightly
def test_random_maps_are_of_all_sorts() -> None:
    """Kinks in a third; steep and flat pieces; breaks that move; each agrees with its formulas."""
    rng = Random(7)
    maps = [random_map(rng) for _ in range(60)]
    assert {len(map_.pieces) for map_ in maps} == {2, 3}
    assert 10 <= sum(not map_.jumps() for map_ in maps) <= 30  # a third, within three deviations
    slopes = [abs(float(piece.slope)) for map_ in maps for piece in map_.pieces]
    assert min(slopes) > 0
    assert sum(slope > 1 for slope in slopes) > 30
    assert sum(slope < 1 for slope in slopes) > 30
    assert sum("p" in piece.condition() for map_ in maps for piece in map_.pieces) > 30
    for map_ in maps[:10]:
        numeric = from_pwmap(map_, "p")
        check_derivatives(numeric, [(-3.0, 0.3), (0.1, 0.3), (4.0, 0.3)])
        fixed = map_.at({"p": 0}).fixed_points()
        for at in fixed:
            assert numeric.at(float(at.x), 0.0).value == pytest.approx(float(at.x), abs=1e-13)


def test_the_span_is_inside_of_what_is_assumed() -> None:
    _, diagram = random_case(Random(3), (1,))
    ends = {p.parameter for p in diagram.points if p.kind is PointKind.EP}
    assert ends <= set(map(float, exact.SPAN))
