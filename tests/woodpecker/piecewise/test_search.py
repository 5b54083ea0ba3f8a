"""Complete diagrams of maps that pwmap solves exactly: same branches, same points, same graph."""

from __future__ import annotations

import math
from collections import Counter
from fractions import Fraction

import networkx as nx
import numpy as np
import pytest
import sympy
from maps import skew_tent, two_lines

from pwmap import BranchKind, Diagram, PiecewiseLinearMap, PointKind, bifurcation_diagram
from woodpecker.diagram import connected, whole_diagram
from woodpecker.piecewise.maps import Evaluation, LabelledMap, correct
from woodpecker.piecewise.partition import Resolution, partition, sampled
from woodpecker.piecewise.search import Search, _Plan, van_der_corput
from woodpecker.piecewise.settings import Settings

R = sympy.Symbol("r")
SEARCH = Search(slices=16, resolution=Resolution(spacing=0.02, smallest=1e-6))

MAPS = {
    "the paper's map": (
        [("r - 2", "x <= 0"), ("r - 5*x/4", "x > 0")], (-1, Fraction(5, 2)), (1, 2)),
    "an island": (  # a step between two jumps reaches the diagonal for r**2 <= 1 only
        [("x/2 - 2", "x < 0"), ("x/2 + 1 - r**2", "(x >= 0) & (x < 1)"), ("x/2 - 2", "x >= 1")],
        (-2, 2),
        (1,),
    ),
    "two lines that fold": (
        [("x/2 + r", "x < 0"), ("-x/2 + r + 1", "x >= 0")], (-2, 2), (1,)),
    "a fold-flip": (
        [("x/3 - 1", "x < 0"), ("r - 3*x/2", "x >= 0")], (-1, 1), (1, 2)),
    "three pieces": (
        [("-2 + r", "x < -1"), ("r - x/2", "(x >= -1) & (x < 1)"), ("2 + r/2", "x >= 1")],
        (-4, Fraction(7, 2)), (1,)),
    "a staircase": (
        [("x/2 + r", "x < 0"), ("x/2 + r - 1", "x >= 0")],
        (Fraction(-1, 2), Fraction(3, 2)), (1, 2, 3)),
}  # fmt: skip


def labelled(map_: PiecewiseLinearMap) -> LabelledMap:
    """A map of one parameter r in floating point, with its exact derivatives."""
    formulas = []
    for piece in map_.pieces:
        value = piece.expression
        parts = (value, sympy.diff(value, map_.x), sympy.diff(value, R))
        formulas.append((piece, sympy.lambdify((map_.x, R), parts, "math")))
    breaks = [float(piece.lower) for piece in map_.pieces[1:]]

    def evaluated(x: float, p: float) -> Evaluation:
        i = sum(x > b for b in breaks)
        if x in breaks and not map_.pieces[i].upper_closed:
            i += 1
        value, slope, rate = formulas[i][1](x, p)
        return Evaluation(value, slope, rate, formulas[i][0].word)

    return evaluated


def numeric(name: str) -> tuple[Diagram, Diagram]:
    """The diagram of a map by continuation, and by proof."""
    pieces, span, orders = MAPS[name]
    map_ = PiecewiseLinearMap(pieces)
    continued = labelled(map_)
    settings = Settings(span=(float(span[0]), float(span[1])), window=(-20.0, 20.0))
    found = whole_diagram(continued, sampled(continued), settings, orders, SEARCH).diagram
    return found, bifurcation_diagram(map_, R, span, orders)


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS)
def test_continuation_finds_what_is_proved(name: str) -> None:
    found, proved = numeric(name)
    kinds = Counter(point.kind for point in proved.points)
    assert Counter(point.kind for point in found.points) == kinds
    for kind in kinds:
        places = [
            sorted(
                ((p.parameter, p.x) for p in diagram.points if p.kind is kind),
                key=lambda place: (round(place[0], 6), place[1]),
            )
            for diagram in (found, proved)
        ]
        # collisions are located to 1e-10, ends of jumps to jumps.RESOLVED = 1e-11
        np.testing.assert_allclose(*places, rtol=0.0, atol=1e-10)
    for diagram in (found, proved):
        for branch in diagram.branches:
            if branch.kind is BranchKind.JUMP:
                assert np.isnan(branch.multiplier).all()
    graphs = [diagram.graph() for diagram in (found, proved)]
    assert nx.is_isomorphic(
        *graphs,
        node_match=lambda a, b: a["kind"] == b["kind"],
        edge_match=lambda a, b: (
            Counter((e["kind"], e["order"]) for e in a.values())
            == Counter((e["kind"], e["order"]) for e in b.values())
        ),
    )


@pytest.mark.slow
def test_an_island_is_found_by_a_slice() -> None:
    """Nothing connects it with a branch that reaches the ends of the span."""
    found, _ = numeric("an island")
    graph = found.graph()
    ends = {p.id for p in found.points if p.kind is PointKind.EP}
    (loop,) = [c for c in nx.connected_components(graph) if not c & ends]
    places = sorted((found.point(node).parameter, found.point(node).x) for node in loop)
    root = 0.5**0.5
    expected = [(-1.0, 0.0), (-root, 1.0), (root, 1.0), (1.0, 0.0)]
    np.testing.assert_allclose(places, expected, rtol=0.0, atol=1e-10)
    assert {found.point(node).kind for node in loop} == {PointKind.BC}


def test_slices_fill_the_span_evenly() -> None:
    assert [van_der_corput(k) for k in range(1, 8)] == [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]


def test_slices_gather_where_something_new_shows() -> None:
    """Eight slices; the fifth, at 5/8, is the only one that counts: two more beside it."""
    plan = _Plan(Search(slices=7, finest=0.01))
    first = [plan.places[k] for k in range(7)]
    assert sorted(first) == [k / 8 for k in range(1, 8)]
    for k in range(7):
        plan.took(new=k in (0, 4))  # the first of a search always shows something
    assert plan.places[7:] == [0.5 * (0.625 + 0.5), 0.5 * (0.625 + 0.75)]
    plan.took(new=True)
    assert plan.places[9:] == [0.5 * (0.5625 + 0.5), 0.5 * (0.5625 + 0.625)]


def test_gaps_between_slices_have_an_end() -> None:
    plan = _Plan(Search(slices=3, finest=0.05))
    while plan.done < len(plan.places):
        plan.took(new=True)
    gaps = np.diff(sorted(plan.places))
    assert gaps.min() >= 0.05
    assert len(plan.places) <= 20


def test_a_cycle_ends_where_its_points_meet_on_an_edge() -> None:
    """A continuous map of slopes 1/2 and -3/2: 6 p / 7 and -2 p / 7 are a cycle, p > 0."""
    labelled_map = skew_tent(0.5, -1.5)
    settings = Settings(span=(-1.0, 1.0), window=(-5.0, 5.0))
    found = whole_diagram(labelled_map, sampled(labelled_map), settings, (1, 2), SEARCH).diagram
    twos = found.of_order(2).branches
    assert len(twos) == 2
    (meeting,) = set(twos[0].ends) & set(twos[1].ends)
    point = found.point(meeting)
    assert (point.parameter, point.x) == pytest.approx((0.0, 0.0), abs=1e-9)
    ones = [branch for branch in found.of_order(1).branches if meeting in branch.ends]
    assert len(ones) == 2
    slopes = sorted(float(branch.x[-1] / branch.parameter[-1]) for branch in twos)
    assert slopes == pytest.approx([-2.0 / 7.0, 6.0 / 7.0], abs=1e-9)


@pytest.mark.parametrize("orders", [(), (0,), (1.5,), (1, True), (np.True_,), ("1",), (1, None)])
def test_orders_are_checked(orders: tuple[int, ...]) -> None:
    continued = labelled(PiecewiseLinearMap(MAPS["a fold-flip"][0]))
    with pytest.raises(ValueError, match="orders must "):
        whole_diagram(continued, sampled(continued), Settings(), orders)


def test_orders_may_be_integers_of_any_kind() -> None:
    continued, settings = two_lines(), Settings(span=(0.5, 1.0), window=(-5.0, 5.0))
    few = Search(slices=1, resolution=SEARCH.resolution)
    found = [
        whole_diagram(continued, sampled(continued), settings, orders, few)
        for orders in ((1, 2), np.array([2, 1, 2]), (np.int8(1), sympy.Integer(2)))
    ]
    branches = [[(b.id, b.word) for b in each.diagram.branches] for each in found]
    assert branches[0] == branches[1] == branches[2]
    assert {report.order for report in found[1].reports} == {1, 2}


@pytest.mark.parametrize("window", [(-math.inf, math.inf), (0.0, math.inf)])
def test_a_search_needs_a_finite_window(window: tuple[float, float]) -> None:
    """A branch does not: that of one fixed point is followed in an infinite window."""
    settings = Settings(span=(-2.0, 2.0), window=window)
    sentence = r"a search for every branch needs a finite window, got \(.*inf\)"
    with pytest.raises(ValueError, match=sentence):
        whole_diagram(two_lines(), sampled(two_lines()), settings)
    with pytest.raises(ValueError, match=r"must be finite, got \("):
        partition(sampled(two_lines()), 0.0, window)
    start, _, _ = correct(two_lines(), [0.9], 0.4)
    branches = connected(two_lines(), start, settings).branches
    assert [str(branch.kind) for branch in branches[:2]] == ["fixed-point", "jump"][: len(branches)]
