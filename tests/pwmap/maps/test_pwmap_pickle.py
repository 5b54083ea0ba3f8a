"""Maps and what is found of them can be sent and copied, and behave as before."""

import copy
import pickle
import subprocess
import sys

import pytest
import sympy
from pickles import Way, pickled
from sympy import Rational

from pwmap import (
    PiecewiseLinearMap,
    bifurcation_diagram,
    dynamics,
    parameter_cells,
    parameter_plane,
    tongues,
    word_family,
)

PLAIN = sympy.symbols("x a r")
ASSUMED = sympy.Symbol("x", real=True), *sympy.symbols("a r", positive=True)


WAYS = pytest.mark.parametrize("way", [pickled, copy.deepcopy, copy.copy])
SYMBOLS = pytest.mark.parametrize("symbols", [PLAIN, ASSUMED], ids=["plain", "assumed"])
Symbols = tuple[sympy.Symbol, sympy.Symbol, sympy.Symbol]


def paper(symbols: Symbols, *given: sympy.Basic) -> PiecewiseLinearMap:
    x, a, r = symbols
    return PiecewiseLinearMap([(r - 2, x <= 0), (r - a * x, x > 0)], x, given=[a > 1, *given])


def shown(map_: PiecewiseLinearMap) -> list[object]:
    """All that is asked of a map here."""
    return [
        str(map_), repr(map_), map_.x, map_.parameters, map_.given, map_.order,
        map_.fixed_points(virtual=True), map_.fixed_intervals(), map_.jump_crossings(),
        map_.jumps(), map_.to_sympy(),
    ]  # fmt: skip


@WAYS
@SYMBOLS
def test_maps_and_their_iterates(way: Way, symbols: Symbols) -> None:
    _, a, r = symbols
    map_ = paper(symbols, r > 0, r < 2)
    second = map_.iterate(2)
    before = shown(second)  # some of it is remembered by now
    again = way(second)
    assert shown(again) == before
    assert again.parameters == (a, r)
    assert shown(way(map_).iterate(2)) == before
    assert shown(way(map_) @ map_) == shown(map_ @ way(map_)) == before
    values = {a: Rational(5, 4), r: 1}
    assert shown(again.at(values)) == shown(second.at(values))
    assert again(Rational(-1, 3)) == second(Rational(-1, 3))


@WAYS
@SYMBOLS
def test_cells_of_a_parameter(way: Way, symbols: Symbols) -> None:
    """The cells' maps keep what was decided for them, also at an edge that is no rational."""
    _, a, r = symbols
    golden = PiecewiseLinearMap([("r - a*x", "x > 0"), ("a*x + 1", "x <= 0")]).at({"r": 1})
    for map_, name in (
        (paper(symbols).at({a: Rational(5, 4)}), r),
        (paper(symbols), r),
        (golden, "a"),
    ):
        cells = parameter_cells(map_, name, orders=(1, 2), span=(1, 3))
        again = way(cells)
        assert (again.edges, again.given, again.orders) == (cells.edges, cells.given, cells.orders)
        for one, other in zip(again, cells, strict=True):
            assert (one.lower, one.upper) == (other.lower, other.upper)
            assert shown(one.map.iterate(2)) == shown(other.map.iterate(2))
            assert [str(way(p)) for p in other.map.pieces] == [str(p) for p in other.map.pieces]


@WAYS
def test_planes_diagrams_and_cycles(way: Way) -> None:
    map_ = paper(PLAIN)
    plane = parameter_plane(map_, "a", "r", (2, 3), (1, 3))
    again = way(plane)
    assert [(s.lower, s.upper, s.cells.edges) for s in again.strips] == [
        (s.lower, s.upper, s.cells.edges) for s in plane.strips
    ]
    assert plane.curves
    for one, other in zip(again.curves, plane.curves, strict=True):
        assert (one.id, one.ends, one.along("7/3")) == (other.id, other.ends, other.along("7/3"))
    diagram = bifurcation_diagram(map_.at({"a": 2}), "r", span=(-1, 3))
    assert way(diagram).points == diagram.points
    cycle = map_.at({"a": 2, "r": 3}).cycle("RL")
    assert (way(cycle), way(cycle).admissible) == (cycle, cycle.admissible)


@pytest.mark.slow
@WAYS
def test_families_tongues_and_densities(way: Way) -> None:
    family = word_family(paper(PLAIN), "L R^k", "k")
    again = way(family)
    assert again.conditions == family.conditions
    assert (again.at(3), again.word(5)) == (family.at(3), family.word(5))
    assert again.thresholds("r") == family.thresholds("r")
    pieces = [("x/2 + d", "x < 2 - 2*d"), ("x/2 + d - 1", "x >= 2 - 2*d")]
    for tongue in tongues(PiecewiseLinearMap(pieces), 3):
        copied = way(tongue)
        assert (copied.rotation, copied.word) == (tongue.rotation, tongue.word)
        assert (copied.values, copied.borders) == (tongue.values, tongue.borders)
    steep = PiecewiseLinearMap([("r - 2 + 3*x/2", "x <= 0"), ("r - 5*x/4", "x > 0")])
    golden = PiecewiseLinearMap([("b*x", "x < 1/b"), ("b*x - 1", "x >= 1/b")], given=["b > 1"])
    for map_, values in ((steep, {"r": 3}), (golden, {"b": (1 + sympy.sqrt(5)) / 2})):
        (band,) = dynamics(map_, values).attractors
        density = band.density
        assert density is not None
        bounds = density.exponent_bounds  # it is remembered
        assert way(density).exponent_bounds == bounds
        assert way(density).places == density.places
        measure = density.measure(0, Rational(1, 2))
        for same in (way(measure), way(density).measure("0", "1/2")):
            assert str(same) == str(measure)
            assert float(same) == float(measure)


@pytest.mark.nightly
def test_a_map_is_read_by_another_process() -> None:
    map_ = paper(ASSUMED, ASSUMED[2] > 2).iterate(2)
    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer).pieces[1])"
    text = subprocess.run(
        [sys.executable, "-c", code], input=pickle.dumps(map_), capture_output=True, check=True
    ).stdout
    assert text.decode().strip() == str(map_.pieces[1])
