"""The comparison of computed diagrams with proved ones sees what differs, and nothing else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from exact import Graph, essential, same_graph

from pwmap import Branch, BranchKind, Diagram, PiecewiseLinearMap, PointKind, SpecialPoint
from pwmap import bifurcation_diagram as exact_diagram
from woodpecker.base.arrays import Floats

FIXED = BranchKind.FIXED_POINT
Change = Callable[[Diagram], Diagram]


def proved() -> Diagram:
    """Of x/2 + p for x < 0, -x/2 + p + 1 for x >= 0.

    Fixed points F1: 2 p (p < 0) and F2: 2 (p + 1)/3 (p >= -1); the jump J1 at 0 crosses between.
    """
    map_ = PiecewiseLinearMap([("x/2 + p", "x < 0"), ("-x/2 + p + 1", "x >= 0")])
    return exact_diagram(map_, "p", (-2, 1), orders=(1,))


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


def line(*x: float, p: tuple[float, ...] = (-1.0, -0.4, 0.0)) -> dict[str, Floats]:
    """Samples of the jump."""
    return {"parameter": np.array(p), "x": np.array(x), "multiplier": np.full(len(p), np.nan)}


def test_the_same_diagram() -> None:
    for change in (redrawn("J1", **line(0.0, 0.0, 0.0)), moved("BC1", x=5e-10)):
        assert same_graph(change(as_diagram(essential(proved()))), proved()) == []


@pytest.mark.parametrize(
    ("change", "sentences"),
    [
        (
            moved("BC1", x=2e-9),
            ["BC BC1 (fold) at p=-1, x=2e-09 is computed only: the nearest is",
             "BC BC1 (fold) at p=-1, x=0 is proved only", "branch F2 of P_1",
             "branch J1 of P_1", "is proved only", "is proved only"],
        ),
        (moved("BC2", kind=PointKind.FF), ["FF BC2 (fold) at p=0, x=0 is computed where BC"]),
        (without("J1"),
         ["jump branch J1 of P_1 from (p=-1, x=0) to (p=0, x=0) is proved only"]),
        (twice("F1"), ["(p=-2, x=-4) to (p=0, x=0) is computed only: drawn twice"]),
        (with_point(SpecialPoint(id="new", kind=PointKind.BC, parameter=-1.0, x=0.0)),
         ["at p=-1, x=0 is computed only: drawn"]),
        (redrawn("J1", kind=FIXED), ["fixed-point branch J1 of P_1", "jump branch J1 of P_1"]),
        (redrawn("J1", order=2), ["jump branch J1 of P_2", "jump branch J1 of P_1"]),
        (redrawn("F1", ends=("EP1", "BC1")), ["branch F1 of P_1", "branch F"]),
        (redrawn("J1", **line(0.0, 1e-8, 0.0)), ["branch J1 of P_1", "branch J1 of P_1"]),
        # followed, turned round, and followed again
        (redrawn("J1", **line(0.0, 0.0, 0.0, 0.0, p=(-1.0, -0.2, -0.8, 0.0))),
         ["branch J1 of P_1", "branch J1 of P_1"]),
    ],
)  # fmt: skip
def test_what_differs_is_named(change: Change, sentences: list[str]) -> None:
    said = same_graph(change(as_diagram(essential(proved()))), proved())
    assert len(said) == len(sentences)
    for sentence, found in zip(sentences, said, strict=True):
        assert sentence in found


def test_branches_of_two_orders_are_never_one() -> None:
    persists = moved("BC2", note="persistence")(proved())
    for order in (1, 2):
        diagram = redrawn("F2", ends=("BC2", "EP2"), order=order)(without("J1")(persists))
        assert ("BC2" in essential(diagram).nodes) == (order == 2)
