"""Branch points, and the branches that start at them and at flips."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from diagrams import (
    FIXED,
    LOCATED,
    assert_curve,
    assert_graph,
    assert_places,
    assert_sound,
    chain,
    chained,
    points_of,
)
from maps import (
    BORDER,
    Line,
    continued,
    logistic,
    logistic_pair,
    one_piece,
    renamed_logistic,
    two_pieces,
)
from sympy import Piecewise, Rational, symbols, sympify

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus
from woodpecker import (
    FormulaMap,
    Smooth,
    Toy,
    bifurcation_diagram,
    continuation,
    from_sympy,
    shoot,
    slices_at,
    solutions,
)
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import WINDOW
from woodpecker.runs import saved_diagram
from woodpecker.search.curves import BranchCurve
from woodpecker.search.diagrams import cycle_near
from woodpecker.search.network import Network
from woodpecker.search.tasks import Tasks
from woodpecker.slices.orbits import orbit_of
from woodpecker.toy_map import ToyPieces

# A branch point is a regular root of its own equations, so it is located to rounding of them.
# Beside it rounding of what a cycle is off by, 1e-16, is divided by its distance from the branch
# point; the first sample is the first step away, 0.005.
BESIDE = 1e-12
INTERVAL = "degenerate: an interval of fixed points"


def pitchfork(unfolded: float = 0.0) -> FormulaMap:
    """p x - x^3: fixed points 0 and, for p > 1, +-sqrt(p - 1); a constant parts them."""
    return one_piece(
        Smooth(lambda x, p: p * x - x**3 + unfolded, lambda x, p: p - 3.0 * x * x, lambda x, _p: x)
    )


def fan(centre: str, ends: int) -> nx.MultiGraph:
    """The graph of branches that meet in one point and end in the span."""
    graph = chain(f"EP F {centre}")
    for k in range(1, ends):
        graph.add_node(-k, kind="EP")
        graph.add_edge(1, -k, kind=str(FIXED))
    return graph


# --- Branch points --------------------------------------------------------------------------------


def zero(p: Any) -> Any:
    return 0.0 * p


def root(p: Any) -> Any:
    """Of the pitchfork, above zero."""
    return np.sqrt(np.maximum(p - 1.0, 0.0))


def hyperbola(p: Any) -> Any:
    """Of p x (1 - x)."""
    return 1.0 - 1.0 / p


FORK = pitchfork(), [zero], [lambda p: -root(p), zero, root]  # fixed points before p = 1, and after
CROSSING = logistic(), [hyperbola, zero], [zero, hyperbola]
UP, DOWN = (root(1.3), 1.3), (-root(1.5), 1.5)


@pytest.mark.parametrize(
    ("curves", "span", "start"),
    [
        *((FORK, (low, 1.9), start)
          for low in (0.0, 0.013) for start in ((0.0, 0.5), (0.0, 1.3), UP, DOWN)),
        *((CROSSING, (0.5, 2.9), start)
          for start in ((0.0, 0.7), (0.0, 1.7), (0.5, 2.0), (hyperbola(0.7), 0.7))),
    ],
)  # fmt: skip
def test_a_branch_point_whichever_branch_leads_to_it(
    curves: Any, span: tuple[float, float], start: tuple[float, float]
) -> None:
    (map_, *sides), settings = curves, Settings(span=span, window=(-10.0, 10.0))
    diagram = continued(map_, *start, settings)
    assert_sound(diagram, settings)
    assert_graph(diagram, fan("BP", 4))
    ends = [(p, f(p)) for p, side in zip(span, sides, strict=True) for f in side]
    assert_places(diagram, {"BP": [(1.0, 0.0)], "EP": ends})
    (point,) = points_of(diagram, "BP")
    assert point.cause == "another branch crosses"
    assert point.precision < 1e-13
    for branch in diagram.branches:
        side = sides[int(branch.parameter.mean() > 1.0)]
        assert min(abs(branch.x - f(branch.parameter)).max() for f in side) < BESIDE


@pytest.mark.parametrize(
    ("span", "x", "graph"),
    [
        ((0.5, 1.0), 0.0, chain("EP F BP")),
        ((1.0, 1.5), 0.0, fan("BP", 3)),
        ((1.0, 1.5), -root(1.2), fan("BP", 3)),
    ],
)
def test_a_branch_point_right_at_the_end_of_the_span(
    span: tuple[float, float], x: float, graph: nx.MultiGraph
) -> None:
    """A branch ends in it; it ended just before, open, as there is no tangent right there."""
    settings = Settings(span=span, window=(-10.0, 10.0))
    diagram = continued(pitchfork(), x, sum(span) / 2 if x == 0.0 else 1.2, settings)
    assert_sound(diagram, settings)
    assert_graph(diagram, graph)
    (point,) = points_of(diagram, "BP")
    assert (point.parameter, point.status) == (1.0, PointStatus.LOCATED)
    assert point.x == pytest.approx(0.0, abs=BESIDE)


@pytest.mark.parametrize(
    ("span", "window"),
    [((0.25, 0.5), (-3.0, 3.0)), ((0.25, 0.5), (0.0, 1.0)), ((0.1, 0.25), (-1.0, 1.0))],
)
def test_both_branches_end_in_a_branch_point_at_an_end_of_the_span(
    span: tuple[float, float], window: tuple[float, float]
) -> None:
    """0 and 1 - 1/(4 p), fixed points of 4 p x (1 - x), which cross at p = 1/4."""
    x, p = symbols("x p")
    map_ = from_sympy(4 * p * x * (1 - x), x, p)
    diagram = bifurcation_diagram(map_, "p", span, (1,), window, workers=1)
    (point,) = points_of(diagram, "BP")
    assert (point.parameter, point.branches) == (0.25, ("F1", "F2"))
    assert point.x == pytest.approx(0.0, abs=BESIDE)
    assert len(diagram.points) == 3


@pytest.mark.parametrize("unfolded", [1e-3, 1e-6, 1e-9])
def test_branches_that_only_come_close_do_not_cross(unfolded: float) -> None:
    """p x - x^3 + c: the branch from x < 0 at p < 1 has no branch point; the other one folds."""
    settings = Settings(span=(0.0, 1.9))
    diagram = continued(pitchfork(unfolded), root(1.9), 1.9, settings)
    assert_graph(diagram, chain("EP F EP"))
    other = continued(pitchfork(unfolded), -root(1.9), 1.9, settings)
    assert_graph(other, chain("EP F LP F EP"))
    fold = -((0.5 * unfolded) ** (1.0 / 3.0))  # where 2 x^3 = -c, at p = 1 + 3 x^2
    # a square root of rounding, in x; the parameter is off by the square of that
    assert points_of(other, "LP")[0].parameter == pytest.approx(1.0 + 3.0 * fold**2, abs=1e-12)


# --- Flips ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("map_", [logistic(), renamed_logistic(0.7), renamed_logistic(0.6667)])
def test_the_doubled_branch_of_the_logistic_map(map_: FormulaMap) -> None:
    """Also where the word changes beside the flip, 3.3e-5 from x = 2/3."""
    settings = Settings(span=(2.5, 3.4))
    diagram = continued(map_, 0.6, 2.5, settings, orders=(1, 2))
    assert_sound(diagram, settings)
    assert_graph(diagram, fan("PD", 4))
    assert {branch.order for branch in diagram.branches} == {1, 2}
    (flip,) = points_of(diagram, "PD")
    assert (flip.order, flip.status) == (1, PointStatus.LOCATED)
    assert (flip.parameter, flip.x) == pytest.approx((3.0, 2.0 / 3.0), abs=LOCATED)
    for branch in diagram.branches:
        if branch.order == 1:
            assert_curve(branch, lambda p: 1.0 - 1.0 / p)
            continue
        root = np.sqrt((branch.parameter - 3.0).clip(0.0) * (branch.parameter + 1.0))
        side = math.copysign(1.0, branch.x[-1] - 0.65)
        expected = (branch.parameter + 1.0 + side * root) / (2.0 * branch.parameter)
        # x leaves like a square root: what p is off, some 1e-15, is divided by the way from there
        off = (branch.x - expected) * (branch.x - 2.0 / 3.0)
        assert off == pytest.approx(0.0, abs=LOCATED)
        assert branch.x[branch.parameter > 3.01] == pytest.approx(
            expected[branch.parameter > 3.01], abs=BESIDE
        )


def test_doubled_branches_flip_again() -> None:
    """P_4 starts at 1 + sqrt(6); at its own flip, 3.5440903, nothing does, for 8 is not wanted."""
    settings = Settings(span=(2.5, 3.6))
    diagram = continued(logistic(), 0.6, 2.5, settings, orders=(4, 2, 1))
    flips = sorted({round(point.parameter, 9) for point in points_of(diagram, "PD")})
    assert flips == pytest.approx([3.0, 1.0 + math.sqrt(6.0), 3.544090360], abs=1e-9)
    per_order = {n: sum(branch.order == n for branch in diagram.branches) for n in (1, 2, 4)}
    assert per_order == {1: 2, 2: 2 * 2, 4: 4 * 2}


@pytest.mark.parametrize("orders", [None, (1,), (1, 3)])
def test_nothing_starts_at_a_flip_unless_it_is_asked_for(orders: tuple[int, ...] | None) -> None:
    diagram = continued(logistic(), 0.6, 2.5, Settings(span=(2.0, 3.5)), orders=orders)
    assert_graph(diagram, chain("EP F PD F EP"))


def test_the_fixed_point_is_found_from_its_doubled_branch() -> None:
    settings = Settings(span=(2.5, 3.4))
    start = list(logistic_pair(3.2))
    diagram = continued(logistic(), start, 3.2, settings, orders=(1, 2))
    assert_sound(diagram, settings)
    assert_graph(diagram, fan("PD", 4))
    with pytest.raises(ValueError, match=r"orders must hold 2, the period .* got \(1,\)"):
        continued(logistic(), start, 3.2, settings, orders=(1,))


def test_a_cycle_passed_twice_is_followed_once() -> None:
    settings = Settings(span=(2.0, 3.5))
    twice = continued(logistic(), [0.6, 0.6], 2.5, settings)
    assert_graph(twice, chain("EP F PD F EP"))
    assert {branch.order for branch in twice.branches} == {1}


@pytest.mark.slow
@pytest.mark.parametrize("low", [2.0, 2.01, 2.37])
def test_the_flip_of_a_cycle_passed_twice_is_a_branch_point(low: float) -> None:
    settings = Settings(span=(low, 3.5))
    start = cycle_near(logistic(), [0.6, 0.6], 2.5, settings)
    curves = chained(Tasks.of_line(logistic(), settings), start)
    points = {end.p: end for curve in curves for end in curve.ends if end.kind is PointKind.BP}
    (p,) = points
    assert p == pytest.approx(3.0, abs=LOCATED)
    assert points[p].x == pytest.approx([2.0 / 3.0, 2.0 / 3.0], abs=LOCATED)


SHORT = Settings(span=(2.2, 2.9))  # before the flip


def fixed_points(times: int = 1) -> list[BranchCurve]:
    """Branches of the logistic map's fixed point, passed so many times."""
    start = orbit_of(logistic().pieces * times, np.array([0.6] * times), 2.5)
    return chained(Tasks.of_line(logistic(), SHORT), start)


def test_a_branch_of_a_cycle_passed_twice_is_not_kept_as_one_of_period_two() -> None:
    network = Network(SHORT)
    assert all(network.has(curve) for curve in fixed_points(2))


def test_what_goes_round_a_shorter_cycle_but_at_its_ends_is_not_kept() -> None:
    """An end may lie on another branch, or rounding part its points; those in between are one.

    A branch that doubles a flip may be as short, and its points as close all along: it is kept.
    """
    curve = fixed_points(2)[0]
    apart = 20.0 * SHORT.same * np.array([[1.0], [0.0]])
    torn = replace(curve, points=(*curve.points[:-1], curve.points[-1] + apart))
    assert Network(SHORT).has(torn)
    parting = np.linspace(0.0, 1.0, len(curve.points))
    doubled = tuple(curve.points[0] + part * apart for part in parting)
    short = replace(curve, points=doubled, parameter=2.5 + 1e-8 * parting)
    assert not Network(SHORT).has(short)


def test_a_branch_that_passed_over_a_thin_piece_is_the_same() -> None:
    """The other way, with a piece in its middle that the first one has not seen."""
    curve = fixed_points()[0]
    (word,) = curve.words
    middle = len(curve.points) // 2
    thin = replace(word, first=middle - 1, keys=("thin",)), replace(word, first=middle + 1)
    back = replace(
        curve, parameter=curve.parameter[::-1], points=curve.points[::-1],
        multiplier=curve.multiplier[::-1], ends=curve.ends[::-1], words=(word, *thin),
    )  # fmt: skip
    other = replace(back, words=(replace(word, keys=("other",)),))
    network = Network(SHORT)
    network.add(curve)
    assert network.has(back)
    assert not network.has(other)


@pytest.mark.parametrize(("length", "short_of", "same"), [
    (0.1, 3e-8, True), (0.1, 3e-7, False), (1e-5, 3e-8, True), (1e-7, 3e-8, False),
])  # fmt: skip
def test_branches_with_the_same_ends_are_one(length: float, short_of: float, same: bool) -> None:
    """A part of the span apart at one end: a border may be taken there for the flip beside it."""
    curve = fixed_points()[0]
    part = np.linspace(0.0, 1.0, 12)

    def between(first: float, last: float) -> BranchCurve:
        p = first + (last - first) * part
        points = tuple(np.array([[1.0 - 1.0 / each]]) for each in p)
        return replace(curve, parameter=p, points=points, multiplier=2.0 - p)

    unit = SHORT.p_scale
    network = Network(SHORT)
    network.add(between(2.5, 2.5 + length * unit))
    assert network.has(between(2.5, 2.5 + (length - short_of) * unit)) is same


def test_a_flip_right_before_a_border() -> None:
    """p - x - x^2 flips at p = 0; its doubled points +-sqrt(p) leave the piece at p = 4e-8, before
    the usual first step is over. It is met from the collision there, and not followed twice."""
    value = Smooth(lambda x, p: -x - x * x + p, lambda x, _p: -1.0 - 2.0 * x, lambda _x, _p: 1.0)
    map_ = two_pieces(value, Line(0.0, 0.0, 5.0).smooth(), at=2e-4)
    diagram = continued(map_, -0.1, -0.19, Settings(span=(-0.5, 0.5)), orders=(1, 2))
    pair = [b for b in diagram.branches if (b.order, b.kind) == (2, BranchKind.FIXED_POINT)]
    far = sorted(float(max(b.x.tolist(), key=abs)) for b in pair)
    assert far == pytest.approx([-2e-4, 2e-4], abs=BESIDE)
    for branch in pair:
        ends = sorted((diagram.point(end) for end in branch.ends), key=lambda p: p.parameter)
        assert ends[0].kind is PointKind.PD
        met = ends[1]
        assert (met.kind, met.cause) == (PointKind.BC, BORDER)
        assert met.parameter == pytest.approx(4e-8, abs=BESIDE)
        assert branch.x**2 == pytest.approx(branch.parameter, abs=BESIDE)


# --- The toy --------------------------------------------------------------------------------------

NEAR = (-0.5255, -0.518)  # its doubled cycle, the lower point
FLIP = 0.64854920022763  # of the stable motion, from its multiplier


@pytest.mark.slow
def test_the_doubled_motion_of_the_toy(tmp_path: Path) -> None:
    """It leaves the flip to larger eps_N1, turns round 3.6e-7 further on, and is unstable then."""
    toy, path = Toy(), tmp_path / "run.jsonl"
    settings = Settings(window=WINDOW)
    motion = shoot(toy, -0.53)
    diagram = continuation(toy, motion, span=(0.45, 0.7), orders=(1, 2), run=path)
    (flip,) = points_of(diagram, "PD")
    assert flip.parameter == pytest.approx(FLIP, abs=1e-12)
    assert [diagram.branch(name).order for name in flip.branches] == [1, 1, 2, 2]
    assert saved_diagram(path).graph().number_of_edges() == len(diagram.branches)
    for p in (0.64, 0.648):
        (second,) = slices_at(ToyPieces(toy), p, (2,), settings)
        expected = [each.x for each in second.cycles if NEAR[0] < each.x.min() < NEAR[1]]
        found = [
            hit.orbit.phi_s for hit in solutions(toy, diagram, p)
            if hit.branch.order == 2 and NEAR[0] < min(hit.orbit.points) < NEAR[1]
        ]  # fmt: skip
        # multipliers lie 0.003 from 1 there: rounding of a return, 1e-15, times 300
        assert found == pytest.approx(sorted(np.concatenate(expected)), abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_flip_that_no_double_tells_from_a_fold(side: float) -> None:
    """The doubled cycle of 1 + s x (x < 1/2) and p + c (x - 1)^2 has the multiplier 2 s c u.

    With u its distance from 1, p = u / s - c u^2: it folds at u = 1 / (2 s c) and flips at minus
    that, here at 5e-18. From both sides it comes to the fold, and goes on beyond.
    """
    x, p = symbols("x p")
    s, c = 10**10, 10**7
    map_ = from_sympy(Piecewise((1 + s * x, x < 0.5), (p + c * (x - 1) ** 2, True)), x, p)
    u = side * 1e-4
    settings = Settings(span=(-0.2, 0.2), window=(-3.0, 3.0))
    start = shoot(map_, 1.0 + u, p=u / s - c * u * u, order=2)
    diagram = continuation(map_, start, "p", span=(-0.2, 0.2), settings=settings)
    kinds = {point.kind for point in diagram.points}
    folds = [point for point in diagram.points if point.kind is PointKind.LP]
    assert kinds == {PointKind.LP, PointKind.EP}
    assert all(point.status is PointStatus.LOCATED for point in diagram.points)
    # to the spacing of doubles at 1, which is 44 of its multiplier
    assert all(abs(point.parameter) < 2.0**-52 for point in folds)
    ends = [float(branch.x[k]) for branch in diagram.branches for k in (0, -1)]
    for sign in (1.0, -1.0):  # -0.2 = u / s - c u^2: both ends of the curve
        assert any(abs(value - 1.0 - sign * math.sqrt(0.2 / c)) < 1e-12 for value in ends)


@pytest.mark.slow
def test_neither_flip_nor_fold_where_a_formula_ends_and_one_slope_is_minus_one() -> None:
    """The root ends at p = 1, on a cycle of multiplier 1/10 whose points lie 2.4 apart."""
    x, p = symbols("x p")
    map_ = from_sympy(
        Piecewise((p + 1 - x, x < -p / 5), ((1 - p) ** Rational(1, 2) / 2 - x / 10, True)), x, p
    )
    diagram = bifurcation_diagram(map_, "p", (0.0, 2.0), orders=(1, 2), window=(-4.0, 4.0))
    assert any(str(branch.word) == "A | B" for branch in diagram.of_order(2).branches)
    assert not {point.kind for point in diagram.points} & {PointKind.PD, PointKind.LP}


@pytest.mark.slow
def test_fixed_points_of_one_parameter_lie_on_neither_side_of_it() -> None:
    """At p = -1/3 the slope is -1 on the right: its points have period two, up to the border.

    From below a crossing of P^2 at x = -1 comes there, from above one at the image of -1.
    """
    x, p = symbols("x p")
    right = Rational(1, 7) - p / 3 - (p + Rational(4, 3)) * x
    map_ = from_sympy(Piecewise((x / 2 - 1 + p, x < -1), (right, True)), x, p)
    diagram = bifurcation_diagram(map_, "p", (-1.0, 0.0), orders=(1, 2), window=(-4.0, 4.0))
    (flip,) = (point for point in diagram.points if point.kind is PointKind.PD)
    first, last = (point for point in diagram.points if point.kind is PointKind.BC)
    assert flip.x == pytest.approx(8 / 63)
    assert last.x == pytest.approx(79 / 63)
    assert {first.note, last.note} == {INTERVAL}
    assert flip.note == "degenerate: points nearby have twice the period"
    sides = [diagram.sides(point.id) for point in (flip, first, last)]
    jumps = [{diagram.branch(each).kind for side in both for each in side} for both in sides]
    assert jumps == [{BranchKind.FIXED_POINT}, {BranchKind.JUMP}, {BranchKind.JUMP}]
    assert [(len(below), len(above)) for below, above in sides] == [(1, 1), (1, 0), (0, 1)]


@pytest.mark.parametrize(("term", "degenerate"), [("0", True), ("x**3", False), ("x**5", False)])
def test_a_flip_is_degenerate_where_all_points_nearby_have_twice_its_period(
    term: str, degenerate: bool
) -> None:
    x, p = symbols("x p")
    map_ = from_sympy(p * x + sympify(term), x, p)
    diagram = bifurcation_diagram(map_, "p", (-1.5, -0.5), window=(-0.3, 0.4))
    (flip,) = (point for point in diagram.points if point.kind is PointKind.PD)
    assert (flip.parameter, flip.x) == pytest.approx((-1.0, 0.0), abs=1e-12)
    assert bool(flip.note) is degenerate


@pytest.mark.parametrize(
    ("pieces", "border", "place", "note"),
    [
        (("1/7 - p", "p/2 + x/2 - 6/7"), "3/4", ("-17/28", "-11/14"), "fold"),  # 1/7 - p = 3/4
        (("p + 5/7", "p + x/2 - 10/7"), "0", ("-5/7", "-15/7"), "fold"),  # p + 5/7 = 0
        # slopes 2 and 1/2 have the product 1: all cycles of period two have one parameter
        pytest.param(
            ("p/2 + 2*x + 10/7", "p/2 + x/2 - 1"),
            "-3/2",
            ("8/21", "-29/21"),
            INTERVAL,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_a_cycle_of_period_two_meets_beside_flat_and_neutral_pieces(
    pieces: tuple[str, str], border: str, place: tuple[str, str], note: str
) -> None:
    """Behind a flat piece there is no jump: a cycle ends alone, whatever starts at the border."""
    x, p = symbols("x p")
    left, right = (sympify(piece, rational=True) for piece in pieces)
    map_ = from_sympy(Piecewise((left, x < Rational(border)), (right, True)), x, p)
    diagram = bifurcation_diagram(map_, "p", (-1.0, 1.0), orders=(1, 2), window=(-6.0, 6.0))
    at_p, at_x = (float(Rational(each)) for each in place)
    found = [
        point.note
        for point in diagram.points
        if abs(point.parameter - at_p) + abs(point.x - at_x) < 1e-9
    ]
    assert found == [note]
