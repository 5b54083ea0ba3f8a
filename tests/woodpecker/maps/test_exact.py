"""The comparison of computed diagrams with proved ones sees what differs, and nothing else."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from exact import essential, same_graph

from pwmap import BranchKind, Diagram, PiecewiseLinearMap, PointKind, SpecialPoint
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


def changed(records: str, name: str, /, **change: object) -> Change:
    """A diagram with one of its points, or of its branches, changed."""

    def make(diagram: Diagram) -> Diagram:
        found = [
            replace(each, **change) if each.id == name else each
            for each in getattr(diagram, records)
        ]
        return replace(diagram, **{records: tuple(found)})

    return make


moved, redrawn = partial(changed, "points"), partial(changed, "branches")


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
        assert same_graph(change(essential(proved())), proved()) == []


ALL = "BC1 F2 J1"


@pytest.mark.parametrize(
    ("change", "computed", "proved_only"),
    [
        (moved("BC1", x=2e-9), ALL, ALL),
        (moved("BC2", kind=PointKind.FF), "BC2", ""),  # where another kind is proved
        (without("J1"), "", "J1"),
        (twice("F1"), "again", ""),
        (with_point(SpecialPoint(id="new", kind=PointKind.BC, parameter=-1.0, x=0.0)), "new", ""),
        (redrawn("J1", kind=FIXED), "J1", "J1"),
        (redrawn("J1", order=2), "J1", "J1"),
        (redrawn("F1", ends=("EP1", "BC1")), "F1", "F1"),
        (redrawn("J1", **line(0.0, 1e-8, 0.0)), "J1", "J1"),
        # followed, turned round, and followed again
        (redrawn("J1", **line(0.0, 0.0, 0.0, 0.0, p=(-1.0, -0.2, -0.8, 0.0))), "J1", "J1"),
    ],
)
def test_what_differs_is_named(change: Change, computed: str, proved_only: str) -> None:
    told: dict[str, list[str]] = {"computed": [], "proved": []}
    for sentence in same_graph(change(essential(proved())), proved()):
        name, side = re.findall(r"^\w+\((?:id=')?(\w+).*? is (computed|proved)", sentence)[0]
        told[side].append(name)
    assert told == {"computed": computed.split(), "proved": proved_only.split()}


def test_branches_of_two_orders_or_stabilities_are_never_one() -> None:
    persists = moved("BC2", note="persistence")(proved())
    for change in ({}, {"order": 2}, {"multiplier": (1.5, 1.5)}):
        diagram = redrawn("F2", ends=("BC2", "EP2"), **change)(without("J1")(persists))
        assert ("BC2" in [point.id for point in essential(diagram).points]) == bool(change)
