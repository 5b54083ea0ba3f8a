"""The map of a cell answers for its cell: what holds throughout, or one sentence that refuses."""

import copy
import pickle

import pytest
import sympy
from pickles import Way, pickled
from sympy import Rational, sqrt

from pwmap import (
    FixedPoint,
    ParameterCell,
    PiecewiseLinearMap,
    UndecidedError,
    parameter_cells,
)

a, r, p, x = sympy.symbols("a r p x")
P1L = PiecewiseLinearMap([(r - 2, x <= 0), (r - a * x, x > 0)], given=[a > 1])
NUMERIC = P1L.at({a: Rational(5, 4)})
REFUSED = r"was cut for the orders 1 only: ask for .*parameter_cells\(\.\.\., orders=\(1, 2\)\)"


def last_cell(map_: PiecewiseLinearMap, orders: tuple[int, ...] = (1,)) -> ParameterCell:
    """That of r > 2, or the last part of it."""
    return parameter_cells(map_, r, orders=orders).cells[-1]


def words(points: tuple[FixedPoint, ...]) -> list[str]:
    return sorted(point.word for point in points)


WAYS = pytest.mark.parametrize("way", [lambda map_: map_, copy.copy, pickled])
BOTH = pytest.mark.parametrize("map_", [NUMERIC, P1L], ids=["numeric", "symbolic"])


@WAYS
@BOTH
def test_an_order_that_the_cells_were_not_cut_for(map_: PiecewiseLinearMap, way: Way) -> None:
    """For r > 2 the third iterate changes at 5/2 and elsewhere; at 21/10 it has four."""
    cell = last_cell(map_)
    assert (cell.lower, cell.upper) == (2, sympy.oo)
    cut = way(cell.map)
    assert words(cut.fixed_points()) == ["R"]
    third = cut.iterate(3)
    for ask in (
        third.fixed_points, third.fixed_intervals, third.jump_crossings, third.jumps,
        third.to_sympy, lambda: third.pieces, lambda: (cut @ cut @ cut).pieces,
        lambda: (cut @ map_ @ cut).fixed_points(), lambda: cut.cycles(3),
        lambda: cut.cycle("RL").admissible,
    ):  # fmt: skip
        with pytest.raises(UndecidedError, match=REFUSED):
            ask()
    at = NUMERIC.at({r: Rational(21, 10)}).iterate(3)
    assert words(at.fixed_points()) == ["LRR", "RLR", "RRL", "RRR"]
    more = parameter_cells(map_, r, orders=(1, 3))
    assert words(more.cells[-1].map.iterate(3).fixed_points())


def test_what_holds_throughout_a_cell_is_answered() -> None:
    """For 0 < r < 2 all iterates look alike, values and limits too."""
    for map_ in (NUMERIC, P1L):
        cell = parameter_cells(map_, r, orders=(1,)).cells[2]
        assert (cell.lower, cell.upper) == (0, 2)
        assert words(cell.map.iterate(4).fixed_points()) == ["LLLL", "RRRR"]
        assert words((cell.map @ map_).fixed_points()) == ["LL", "RR"]
        b = Rational(5, 4) if map_ is NUMERIC else a
        assert sympy.expand(cell.map(r) - (r - b * r)) == 0
        assert cell.map.word_of(r - 2) == "L"
        assert cell.map.limit(0, "+") == r
        assert cell.map.cycle("R").admissible
        assert not cell.map.cycle("RL").admissible
        kept = "r - 1 is not known to keep its sign in the cell 0 < r < 2, which"
        with pytest.raises(UndecidedError, match=kept):
            cell.map(r - 1)


def test_an_edge_answers_for_all_orders() -> None:
    golden = PiecewiseLinearMap([("1 - a*x", "x > 0"), ("a*x + 1", "x <= 0")])
    cells = parameter_cells(golden, a, orders=(1, 2, 3), span=(1, 2))
    (edge,) = (cell for cell in cells if cell.lower == cell.upper == (1 + sqrt(5)) / 2)
    assert len(edge.map.iterate(5).fixed_points()) > len(edge.map.fixed_points())
    assert edge.map.word_of(a**2 - a - 1) == "L"  # that is 0
    assert edge.map.jumps() == ()


def test_jumps_at_an_edge() -> None:
    """p + x/3 and x/2 jump at 0 but for p = 0."""
    map_ = PiecewiseLinearMap([("x/2", "x <= 0"), ("p + x/3", "x > 0")])
    left, edge, right = parameter_cells(map_, p)
    assert (len(left.map.jumps()), edge.map.jumps(), len(right.map.jumps())) == (1, (), 1)
    assert edge.lower == 0


def test_a_cycle_of_slope_one_at_an_edge() -> None:
    map_ = PiecewiseLinearMap([("p*x", "x <= 0"), ("x + 1", "x > 0")])
    edge = next(cell for cell in parameter_cells(map_, p) if cell.lower == cell.upper == 1)
    with pytest.raises(ValueError, match="the slope of L is 1: it has no isolated cycle"):
        edge.map.cycle("L")


def test_an_edge_that_was_dropped() -> None:
    """M has its virtual fixed point 5/(1 - p) at one end of the line, none at 1, then at the other.

    The edge p = 1 changes nothing else; what differs across it is refused.
    """
    map_ = PiecewiseLinearMap([("-9", "x <= 0"), ("p*x + 5", "(x > 0) & (x <= 1)"), ("9", "x > 1")])
    cells = parameter_cells(map_, p, span=(Rational(1, 2), 2))
    assert cells.edges == ()
    (cell,) = cells
    assert words(cell.map.fixed_points()) == ["L", "R"]
    with pytest.raises(
        UndecidedError, match=r"p - 1 is not known to keep its sign in the cell 1/2 < p < 2"
    ):
        cell.map.fixed_points(virtual=True)
    for value in (Rational(3, 4), 1, Rational(3, 2)):
        assert words(map_.at({p: value}).fixed_points()) == ["L", "R"]


def test_values_outside_of_a_cell() -> None:
    numeric, symbolic = (parameter_cells(map_, r, orders=(1,)).cells for map_ in (NUMERIC, P1L))
    assert words(numeric[2].map.at({r: 1}).fixed_points()) == ["L", "R"]
    with pytest.raises(ValueError, match="r = 3 lies outside of the cell 0 < r < 2, for which"):
        numeric[2].map.at({r: 3})
    with pytest.raises(ValueError, match="r = 1 lies outside of the cell r = 2, for which"):
        symbolic[3].map.at({r: 1})
    with pytest.raises(ValueError, match="r = 2 lies outside of the cell 2 < r, for which"):
        symbolic[4].map.at({r: 2})
    with pytest.raises(ValueError, match="contradicts the assumption a > 1"):
        symbolic[4].map.at({a: 1})
    inside = symbolic[4].map.at({a: 2})  # r > 2 is kept
    assert inside.given == (r > 2,)
    assert words(inside.fixed_points()) == ["R"]


def test_an_edge_with_other_parameters_keeps_its_equation() -> None:
    """At r = 2 a/(a - 1) the 2-cycle starts; a = 3 leaves r = 3."""
    cells = parameter_cells(P1L, r, orders=(1, 2))
    edge = next(cell for cell in cells if cell.lower == cell.upper == 2 * a / (a - 1))
    assert edge.map.at({a: 3}).word_of(r - 3) == "L"
    assert edge.map.at({a: 3, r: 3}).parameters == ()
    with pytest.raises(ValueError, match="lies outside of the cell r = 2"):
        edge.map.at({a: 3, r: 4})


def test_maps_of_different_cells_do_not_compose() -> None:
    cells = parameter_cells(NUMERIC, r, orders=(1,)).cells
    with pytest.raises(ValueError, match="different cells, r < 0 and 0 < r < 2"):
        _ = cells[0].map @ cells[2].map
    again = pickle.loads(pickle.dumps(cells[2].map))
    assert words((again @ cells[2].map).fixed_points()) == ["LL", "RR"]
    foreign = PiecewiseLinearMap([("x/2", "x <= 0"), ("x/3", "x > 0")])
    at = cells[2].map.at({r: 1})
    for both, truth in ((cells[2].map @ foreign, at @ foreign), (foreign @ again, foreign @ at)):
        assert words(both.fixed_points()) == words(truth.fixed_points())
        with pytest.raises(ValueError, match="r = 2 lies outside of the cell 0 < r < 2"):
            both.at({r: 2})
    shifted = PiecewiseLinearMap([("x/2", "x <= p"), ("x/3", "x > p")])
    with pytest.raises(UndecidedError, match=r"the sign of .* does not follow without assumptions"):
        (cells[2].map @ shifted).fixed_points()


def test_conditions_that_follow_from_others_are_not_listed() -> None:
    """That a - 1 and a + 1 are negative is recorded, in this order; a < -1 says both."""
    lines = PiecewiseLinearMap.from_sympy("Piecewise((a*x + p, x <= 0), (b*x + p + c, True))")
    assert [*map(str, parameter_cells(lines, "p").given)] == ["c < 0", "b > 1", "a < -1"]


def test_values_of_others_beyond_where_the_list_holds() -> None:
    """Over [-1, 5] at order 2 cells hold for a > 5/3, where 2 a/(a - 1) lies inside."""
    cells = parameter_cells(P1L, r, (1, 2), ("-1", "5"))
    assert cells.given == (a > Rational(5, 3),)
    for cell in cells:
        with pytest.raises(ValueError, match="a = 4/3 lies outside of the cell"):
            cell.map.at({a: Rational(4, 3)})
