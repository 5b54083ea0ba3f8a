"""Cells of two parameters, against the cells of one at rational values of the other."""

import pickle
from collections.abc import Sequence
from itertools import pairwise

import pytest
import sympy
from sympy import Rational

from pwmap import PiecewiseLinearMap, parameter_cells, parameter_plane

a, r, b, x = sympy.symbols("a r b x")
P1L = PiecewiseLinearMap([(r - 2, x <= 0), (r - a * x, x > 0)], given=[a > 1])


def test_edges_that_meet_part_strips_exactly() -> None:
    """2 a/(a - 1) leaves the span r < 12 at a = 6/5."""
    plane = parameter_plane(P1L, a, r, (1, 4), (-1, 12), (1, 2))
    assert [strip.lower for strip in plane.strips] == [1, Rational(6, 5)]
    assert plane.strips[0].cells.edges == (0, 2)
    assert plane.strips[1].cells.edges == (0, 2, 2 * a / (a - 1))


SKEW = PiecewiseLinearMap([("a*x + 1", "x <= 0"), ("b*x + 1", "x > 0")], given=["a > 0", "b < 0"])
LORENZ = PiecewiseLinearMap([("1 + a*x - b*x**0/3", "x < 0"), ("b*x - a", "x >= 0")])


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("map_", "across", "along", "spans", "orders"),
    [
        (P1L, "a", "r", ((1, 4), (-1, 12)), (1, 2, 3, 4)),
        (P1L, "r", "a", ((1, 12), (Rational(3, 2), 4)), (1, 2, 3, 4)),
        (SKEW, "a", "b", ((Rational(1, 20), Rational(19, 20)), (-9, Rational(-1, 9))), range(1, 6)),
        (SKEW, "b", "a", ((-9, Rational(-1, 9)), (Rational(1, 20), Rational(19, 20))), range(1, 6)),
        (LORENZ, "a", "b", ((Rational(1, 3), 2), (Rational(-2), Rational(3, 2))), (1, 2, 3)),
    ],
    ids=["P1L over r", "P1L over a", "skew over b", "skew over a", "jump"],
)
def test_edges_of_any_degree_are_those_at_every_value(
    map_: PiecewiseLinearMap,
    across: str,
    along: str,
    spans: tuple[tuple[object, object], tuple[object, object]],
    orders: Sequence[int],
) -> None:
    """At rational values of one parameter the cells of the other have the same edges and points."""
    plane = parameter_plane(map_, across, along, *spans, orders)
    low, high = (sympy.sympify(end) for end in spans[0])
    assert (str(plane.across), str(plane.along)) == (across, along)
    assert (plane.strips[0].lower, plane.strips[-1].upper) == (low, high)
    for before, after in pairwise(plane.strips):
        assert before.upper == after.lower
    for n in range(1, 20):
        value = low + (high - low) * Rational(n, 20) + Rational(1, 997)
        strip = next(s for s in plane.strips if s.lower < value < s.upper)
        expected = parameter_cells(map_.at({across: value}), along, orders, spans[1])
        edges = [edge.subs(across, value) for edge in strip.cells.edges]
        assert len(edges) == len(expected.edges)
        for edge, other in zip(edges, expected.edges, strict=True):
            assert abs((edge - other).evalf(60)) < 1e-50
        for cell, one in zip(strip.cells, expected, strict=True):
            for order in orders:
                points = cell.map.iterate(order).fixed_points()
                same = one.map.iterate(order).fixed_points()
                assert [p.word for p in points] == [p.word for p in same]
                assert [p.stable for p in points] == [p.stable for p in same]
                for p, q in zip(points, same, strict=True):
                    assert sympy.cancel(p.x.subs(across, value) - q.x) == 0


def test_a_cell_with_algebraic_borders_answers_inside_only() -> None:
    """Over a the word RRL flips at a b^2 = 1, the root 1/sqrt(-b) of a polynomial of degree two."""
    plane = parameter_plane(
        SKEW, "b", "a", (-9, -3), (Rational(1, 20), Rational(19, 20)), (1, 2, 3)
    )
    cells = next(s for s in plane.strips if s.lower < -8 < s.upper).cells
    number = cells.edges.index(-sympy.sqrt(-b) / b)
    edge, cell = (c for c in cells if cells.edges[number] in (c.lower,))
    assert edge.is_edge
    assert edge.map.cycle("LLR").multiplier == a**2 * b
    values = {"b": -8, "a": Rational(9, 25)}  # 1/sqrt(8) = 0.3536 below
    assert [p.stable for p in cell.map.at(values).fixed_points()] == [False]
    with pytest.raises(ValueError, match="-sqrt"):
        cell.map.at({"b": -8, "a": Rational(7, 20)})
    kept = pickle.loads(pickle.dumps(cell))
    assert str(kept.map.iterate(3)) == str(cell.map.iterate(3))
