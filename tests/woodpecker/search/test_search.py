"""Complete diagrams of maps that pwmap solves exactly: same branches, same points, same graph."""

import math
from fractions import Fraction

import networkx as nx
import numpy as np
import pytest
import sympy
from diagrams import assert_sound
from exact import same_graph
from maps import continued, everything, two_lines

from pwmap import BranchKind, Diagram, PiecewiseLinearMap, PointKind, bifurcation_diagram
from woodpecker import FormulaMap
from woodpecker.base.settings import Settings
from woodpecker.maps.symbolic import from_pwmap, from_sympy
from woodpecker.search.search import Search, _Plan, first_places

R = sympy.Symbol("r")
SEARCH = Search(slices=16)

MAPS = {
    "the paper's map": (
        [("r - 2", "x <= 0"), ("r - 5*x/4", "x > 0")], (-1, 11), (1, 2)),
    "the paper's map, less steep": (  # no flip comes with the fold at r = 0
        [("r - 2", "x <= 0"), ("r - x/2", "x > 0")], (-1, 3), (1,)),
    "crossings of four orders start at one fold-flip": (  # at x* (1 - (-a)**(1 - j)), a = 5/4
        [("r - 2", "x <= 0"), ("r - 5*x/4", "x > 0")], (-1, Fraction(19, 10)), (1, 2, 3, 4)),
    "an island": (  # a step between two jumps reaches the diagonal for r**2 <= 1 only
        [("x/2 - 2", "x < 0"), ("x/2 + 1 - r**2", "(x >= 0) & (x < 1)"), ("x/2 - 2", "x >= 1")],
        (-2, 2),
        (1,),
    ),
    "two lines that fold": (
        [("x/2 + r", "x < 0"), ("-x/2 + r + 1", "x >= 0")], (-2, 2), (1,)),
    "the same, cut by the span": (
        [("x/2 + r", "x < 0"), ("-x/2 + r + 1", "x >= 0")], (Fraction(-1, 2), 2), (1,)),
    "a border that moves": (
        [("x/2 + 5*r/4 - 1", "x < r/2"), ("-x/2 + 7*r/4 + 1", "x >= r/2")], (-2, 2), (1,)),
    "a fold-flip": (
        [("x/3 - 1", "x < 0"), ("r - 3*x/2", "x >= 0")], (-1, 1), (1, 2)),
    "three pieces": (
        [("-2 + r", "x < -1"), ("r - x/2", "(x >= -1) & (x < 1)"), ("2 + r/2", "x >= 1")],
        (-4, Fraction(7, 2)), (1,)),
    "a staircase": (
        [("x/2 + r", "x < 0"), ("x/2 + r - 1", "x >= 0")],
        (Fraction(-1, 2), Fraction(3, 2)), (1, 2, 3)),
    "a small jump, over which a branch may hop": (
        [("x/2 + r", "x < 0"), ("x/2 + r + 1/100000", "x >= 0")], (-2, 2), (1,)),
    "a small jump downwards": (
        [("x/2 + r", "x < 0"), ("x/2 + r - 1/100000", "x >= 0")], (-2, 2), (1,)),
    "a thin strip between two pieces of one formula": (
        [("x/2 + r", "x < 0"), ("x/2 + r + 1", "(x >= 0) & (x < 1/1000000)"),
         ("x/2 + r", "x >= 1/1000000")], (-2, 2), (1,)),
    "a corner": (  # continuous; a cycle of period two is born in it
        [("x/2 + r", "x < 0"), ("r - 3*x/2", "x >= 0")], (-1, 1), (1, 2)),
    "a corner that folds": ([("x/2 + r", "x < 0"), ("3*x/2 + r", "x >= 0")], (-1, 1), (1,)),
    "a corner without effect": ([("x/2 + r", "x < 0"), ("r - x/2", "x >= 0")], (-1, 1), (1,)),
    "a cycle between jumps of the second iterate": (  # of which two merge at r = 1
        [("x/2 + 1", "x < 0"), ("x/2 - 1 + r", "x >= 0")], (-2, 2), (1, 2)),
    "a jump that breaks off near zero": (
        [("x/2 + r", "x <= 0"), ("-3*x/2 + 1 + r", "x > 0")], (-2, 2), (1, 2, 3)),
    "a jump that closes on the diagonal": (  # both limits pass it at r = 1/3
        [("x/2 + r - 1/3", "x < 0"), ("3*x/2 + 1/3 - r", "x >= 0")], (-1, 1), (1, 2)),
}  # fmt: skip
LONG = (
    "crossings of four orders start at one fold-flip",
    "three pieces",
    "a staircase",
    "a jump that breaks off near zero",
)


def followed(name: str) -> tuple[FormulaMap, Settings, tuple[int, ...]]:
    """A map of the table for the engine, with span and window, and orders."""
    pieces, span, orders = MAPS[name]
    settings = Settings(span=(float(span[0]), float(span[1])), window=(-20.0, 20.0))
    return from_pwmap(PiecewiseLinearMap(pieces), R), settings, orders


def computed(name: str) -> Diagram:
    """The diagram of a map by continuation, which is sound whatever it shows."""
    map_, settings, orders = followed(name)
    found = everything(map_, settings, orders, SEARCH).diagram
    assert_sound(found, settings)
    return found


def proved(name: str) -> Diagram:
    """The same by proof."""
    pieces, span, orders = MAPS[name]
    return bifurcation_diagram(PiecewiseLinearMap(pieces), R, span, orders)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * name.startswith(LONG))
     for name in MAPS if name != "an island"],
)  # fmt: skip
def test_continuation_finds_what_is_proved(name: str) -> None:
    """By a search, and what is connected with one fixed point, if all is."""
    exact, found = proved(name), computed(name)
    assert same_graph(found, exact, tolerance=1e-12) == []
    known = {branch.word: branch.multiplier[0] for branch in exact.branches}
    for branch in found.branches:
        assert np.isnan(branch.multiplier).all() == (branch.kind is BranchKind.JUMP)
        if branch.kind is BranchKind.FIXED_POINT:
            k = len(branch) // 3  # where no word changes
            assert branch.multiplier[k] == known[branch.word_at(k).replace(" | ", "")]
    start = next(b for b in exact.branches if len(b.word) == 1 and len(b) > 1)
    if not nx.is_connected(exact.graph()) or "closes" in name:  # nothing leads to what closes
        return
    map_, settings, orders = followed(name)
    x, r = (0.37 * values[0] + 0.63 * values[-1] for values in (start.x, start.parameter))
    assert same_graph(continued(map_, x, r, settings, orders=orders), exact, tolerance=1e-12) == []


@pytest.mark.slow
def test_an_island_is_found_by_a_slice() -> None:
    """Nothing connects it with a branch that reaches the ends of the span; it is curved."""
    found, exact = computed("an island"), proved("an island")
    graphs = [diagram.graph() for diagram in (found, exact)]
    assert nx.is_isomorphic(
        *graphs,
        node_match=lambda a, b: a["kind"] == b["kind"],
        edge_match=lambda a, b: (
            sorted(e["kind"] for e in a.values()) == sorted(e["kind"] for e in b.values())
        ),
    )
    ends = {p.id for p in found.points if p.kind is PointKind.EP}
    (loop,) = [c for c in nx.connected_components(graphs[0]) if not c & ends]
    places = sorted((found.point(node).parameter, found.point(node).x) for node in loop)
    root = 0.5**0.5
    expected = [(-1.0, 0.0), (-root, 1.0), (root, 1.0), (1.0, 0.0)]
    np.testing.assert_allclose(places, expected, rtol=0.0, atol=1e-12)
    assert {found.point(node).kind for node in loop} == {PointKind.BC}


# --- Slices ---------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_a_crossing_that_comes_in_from_outside_of_the_window_is_drawn_once() -> None:
    """It starts at x = -5.07 and goes on to p = -1, x = -2; a slice shows it inside of x > -3."""
    x, p = sympy.symbols("x p", real=True)
    formula = sympy.Piecewise(
        ((7 * x + 19 * p + 7) / 16, x < (5 * p - 21) / 16),
        (27 * x * (1 - x) * (p / 4 + 1) / 16 - sympy.Rational(3, 8), x < -1),
        (13 * p / 8 - x**2 / 32 + 5 * x / 8, x < sympy.Rational(9, 8)),
        (
            19 * p / 32 - 3 * sympy.sqrt(x - sympy.Rational(9, 8)) / 16 + sympy.Rational(119, 256),
            True,
        ),
    )
    settings = Settings(span=(-1.0, 1.0), window=(-3.0, 3.0))
    found = everything(
        from_sympy(formula, x, p), settings, (1, 2), search=Search(slices=15)
    ).diagram
    jumps = [hit.x for hit in found.at(-0.688481) if hit.branch.kind is BranchKind.JUMP]
    # the first piece leads to its border x = (5 p - 21)/16 from x = -4 - 2 p
    assert [x for x in jumps if x < -2.5] == pytest.approx([-4.0 + 2.0 * 0.688481], abs=1e-12)


@pytest.mark.parametrize("slices", [1, 7, 63])
def test_slices_fill_the_span_evenly(slices: int) -> None:
    """Gaps of multiples of the golden ratio are 1/(n + 1) but for a factor of 2."""
    near = 0.5 * Search().finest
    first, last, *inner = first_places(Search(slices=slices))
    assert (first, last) == (near, 1.0 - near)
    assert len(inner) == slices
    gaps = np.diff(sorted([0.0, *inner, 1.0])) * (slices + 1)
    assert 0.4 < gaps.min() <= gaps.max() < 2.0


def test_slices_gather_where_something_new_shows() -> None:
    """Two more halfway to its neighbours, but not for the first, which always show something."""
    plan = _Plan(Search(slices=7, finest=0.01), (0.0, 1.0))
    first = list(plan.places)
    around = sorted([0.0, *first, 1.0])
    assert plan.beside(plan.took()) == []
    for _ in range(4):
        place = plan.took()
    i = around.index(place)
    halfway = [0.5 * (place + around[i + side]) for side in (-1, 1)]
    assert plan.beside(place) == halfway
    plan.add(halfway)
    assert plan.places[9:] == halfway
    beside = 0.5 * (halfway[0] + around[i - 1]), 0.5 * (halfway[0] + place)
    assert plan.beside(halfway[0]) == list(beside)


@pytest.mark.parametrize("span", [(0.0, 1.0), (-3.0, 5.0)])
def test_gaps_between_slices_have_an_end(span: tuple[float, float]) -> None:
    """New is found in every slice, and a special point every 1e-4 of the span."""
    search, length = Search(slices=3, finest=0.05, crowded=2), span[1] - span[0]
    points = np.linspace(*span, 10001).tolist()
    plan = _Plan(search, span)
    first = len(plan.places)
    while plan.done < len(plan.places):
        plan.add(plan.beside(plan.took()))
        if plan.done == len(plan.places):
            plan.add(plan.crowded(points))
    gaps = np.diff(sorted(plan.places)) / length
    assert gaps[1:-1].min() >= search.finest  # the first and last were taken next to the ends
    assert gaps.max() < 2.0 * search.finest
    assert first < len(plan.places) <= 1.0 / search.finest


def test_slices_gather_where_special_points_do() -> None:
    """Gaps with more of them than are wanted are halved, until none is."""
    plan = _Plan(Search(slices=3, finest=1e-4, crowded=10), (0.0, 1.0))
    points = [0.31 + 1e-3 * k for k in range(40)]
    while more := plan.crowded(points):
        plan.add(more)
    ends = np.array(sorted([0.0, *plan.places, 1.0]))
    counts = np.diff(np.searchsorted(points, ends))
    assert counts.max() <= 10
    assert np.diff(ends)[counts == 0].max() > 0.1  # nothing is added elsewhere


def test_what_each_slice_came_to_is_told() -> None:
    settings = Settings(span=(0.5, 1.0), window=(-5.0, 5.0))
    found = everything(two_lines(), settings, (1,), Search(slices=3))
    assert len(found.slices) >= 5
    assert found.slices[0].new == (1,)
    assert {seen.new for seen in found.slices[1:]} == {()}
    assert {seen.left for seen in found.slices} == {()}
    assert {seen.unresolved for seen in found.slices} == {0.0}
    assert all(0.5 <= seen.p <= 1.0 for seen in found.slices)
    assert found.evaluations > sum(seen.evaluations for seen in found.slices) > 0


# --- Arguments ------------------------------------------------------------------------------------


@pytest.mark.parametrize("orders", [(), (0,), (1.5,), (1, True), (np.True_,), ("1",), (1, None)])
def test_orders_are_checked(orders: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="orders must "):
        everything(two_lines(), Settings(window=(-5.0, 5.0)), orders)


@pytest.mark.parametrize("window", [(-math.inf, math.inf), (0.0, math.inf)])
def test_a_search_needs_a_finite_window(window: tuple[float, float]) -> None:
    """A branch does not: that of one fixed point is followed in an infinite window."""
    settings = Settings(span=(-2.0, 2.0), window=window)
    sentence = r"a search for every branch needs a finite window, got \(.*inf\)"
    with pytest.raises(ValueError, match=sentence):
        everything(two_lines(), settings)
    branches = continued(two_lines(), 0.9, 0.4, settings).branches
    assert str(branches[0].kind) == "fixed-point"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"slices": 0}, "slices must be a whole number of at least 1, got 0"),
        ({"finest": 0.0}, r"finest must lie in \(0, 1\), got 0.0"),
        ({"finest": 1.0}, r"finest must lie in \(0, 1\), got 1.0"),
        ({"finest": math.nan}, r"finest must lie in \(0, 1\), got nan"),
    ],
)
def test_searches_refuse(options: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        Search(**options)  # type: ignore[arg-type]
