"""Bands as branches of a diagram and crises as its points, for maps whose bands are known."""

from pathlib import Path

import numpy as np
import pytest
import sympy
from sympy import Rational, sqrt

from pwmap import (
    BranchKind,
    Diagram,
    PiecewiseLinearMap,
    PointKind,
    attractor_diagram,
    bifurcation_diagram,
    read_graph,
    write_graph,
)
from pwmap.longrun import with_attractors

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
A = sympy.Symbol("a")


@pytest.fixture(scope="module")
def tent() -> Diagram:
    diagram = bifurcation_diagram(TENT, "a", ("6/5", "9/4"), (1, 2))
    return with_attractors(diagram, attractor_diagram(TENT, "a", ("6/5", "9/4"), 2))


def bands(diagram: Diagram) -> list:
    return [branch for branch in diagram.branches if branch.kind is BranchKind.BAND]


@pytest.mark.slow
def test_bands_of_the_tent_map_end_in_crises(tent: Diagram) -> None:
    """Two bands, from the second image of the break to the fourth and from the third to the first,
    merge at sqrt(2); the one beyond, from the second to the first, is lost at 2."""
    low, high, one = bands(tent)
    assert low.order == high.order == 2
    assert one.order == 1
    assert {low.ends[1], high.ends[1], one.ends[0]} == {"MC1"}
    assert one.ends[1] == "FC1"
    merging, final = tent.point("MC1"), tent.point("FC1")
    assert (merging.exact["parameter"], final.exact["parameter"]) == (sqrt(2), 2)
    assert sympy.simplify(merging.exact["x"] - sqrt(2) / (1 + sqrt(2))) == 0
    assert final.exact["x"] == 0
    assert merging.branches == (low.id, high.id, one.id)
    assert merging.note == "2 bands on the left, 1 on the right"
    assert tent.point(low.ends[0]).note == "end of the parameter span"
    second = A * (1 - A / 2)
    expected = [(second, A * (1 - A * second)), (A * second, A / 2), (second, A / 2)]
    for branch, (lower, upper) in zip((low, high, one), expected, strict=True):
        assert sympy.expand(branch.exact["lower"] - lower) == 0
        assert sympy.expand(branch.exact["upper"] - sympy.expand(upper)) == 0
        for formula, column in ((lower, "low"), (upper, "high")):
            values = [float(formula.subs(A, p)) for p in branch.parameter]
            np.testing.assert_allclose(branch.columns[column], values, rtol=0, atol=1e-14)


def test_a_diagram_with_bands_is_asked_exactly(tent: Diagram) -> None:
    """At a = 7/5 there are two bands; each is met at both of its ends."""
    hits = [str(hit.exact["x"]) for hit in tent.at("7/5") if hit.branch.kind is BranchKind.BAND]
    assert hits == ["21/50", "721/1250", "147/250", "7/10"]
    assert [hit.branch.kind for hit in tent.at(sqrt(2))].count(BranchKind.BAND) == 0


def test_the_graph_goes_on_through_crises(tent: Diagram, tmp_path: Path) -> None:
    low, _, one = bands(tent)
    assert tent.path(low.id, one.id) == (low.id, "MC1", one.id)
    path = write_graph(tent.graph(), tmp_path / "graph.graphml")
    graph = read_graph(path)
    assert graph.nodes["MC1"]["parameter_exact"] == "sqrt(2)"
    assert graph.has_edge("MC1", "FC1", one.id)


@pytest.mark.nightly
def test_bands_begin_where_a_cycle_loses_its_stability() -> None:
    """At a = 9/16 the cycle L R flips at b = -16/9 and L L R at -256/81; it collides at -25/9."""
    map_ = SKEW.at({"a": Rational(9, 16)})
    diagram = bifurcation_diagram(map_, "b", (-4, "-1/2"), (1, 2, 3))
    both = with_attractors(diagram, attractor_diagram(map_, "b", (-4, "-1/2"), 3))
    assert both.branches[: len(diagram.branches)] == diagram.branches
    ends = {
        (p.kind, p.exact["parameter"])
        for branch in bands(both)
        for p in map(both.point, branch.ends)
        if p.kind is not PointKind.EP
    }
    assert ends >= {
        (PointKind.PD, Rational(-16, 9)),
        (PointKind.PD, Rational(-256, 81)),
        (PointKind.BC, Rational(-25, 9)),
    }
    counts = {p.id: p.exact["parameter"] for p in both.points if p.kind in ("MC", "XC")}
    assert len(counts) == 4
    b = sympy.Symbol("b")
    merging = Rational(9, 16) * b**2 + b - Rational(9, 16)
    assert any(sympy.simplify(merging.subs(b, value)) == 0 for value in counts.values())
    (known,) = (p for p in both.points if p.exact["parameter"] == Rational(-16, 9) and p.branches
                and any(name[0] == "B" for name in p.branches))  # fmt: skip
    assert sum(name[0] == "B" for name in known.branches) == 4


@pytest.mark.nightly
def test_where_the_attractor_is_open_nothing_is_claimed() -> None:
    """Right above a = 1 the tent map has more bands than are followed."""
    found = attractor_diagram(TENT, "a", ("10001/10000", "10003/10000"), 1)
    assert [cell.is_open for cell in found.cells] == [True]
    assert found.crises == ()
    diagram = bifurcation_diagram(TENT, "a", ("10001/10000", "10003/10000"), (1,))
    assert bands(with_attractors(diagram, found)) == []
