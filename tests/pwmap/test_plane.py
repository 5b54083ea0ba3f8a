"""Cells of two parameters, against the cells of one at rational values of the other."""

import pytest
import sympy
from sympy import Rational

from pwmap import PiecewiseLinearMap, parameter_cells, parameter_plane

a, r, b, x = sympy.symbols("a r b x")
P1L = PiecewiseLinearMap([(r - 2, x <= 0), (r - a * x, x > 0)], given=[a > 1])
ORDERS = (1, 2, 3, 4)


def test_strips_hold_the_cells_of_every_value() -> None:
    plane = parameter_plane(P1L, a, r, (1, 4), (-1, 12), ORDERS)
    assert (plane.across, plane.along) == (a, r)
    assert plane.strips[0].lower == 1
    assert plane.strips[-1].upper == 4
    for before, after in zip(plane.strips, plane.strips[1:], strict=False):
        assert before.upper == after.lower
    for n in range(11, 40):
        value = Rational(n, 10)
        strips = [s for s in plane.strips if s.lower < value < s.upper]
        if not strips:
            continue
        expected = parameter_cells(P1L.at({a: value}), r, ORDERS, (-1, 12))
        assert [edge.subs(a, value) for edge in strips[0].cells.edges] == list(expected.edges)
        for cell, other in zip(strips[0].cells, expected, strict=True):
            for order in ORDERS:
                points = cell.map.iterate(order).fixed_points()
                same = other.map.iterate(order).fixed_points()
                assert [p.word for p in points] == [p.word for p in same]
                assert [p.stable for p in points] == [p.stable for p in same]
                for p, q in zip(points, same, strict=True):
                    assert sympy.expand(p.x.subs(a, value) - q.x) == 0


def test_edges_that_meet_part_strips_exactly() -> None:
    """2 a/(a - 1) leaves the span r < 12 at a = 6/5."""
    plane = parameter_plane(P1L, a, r, (1, 4), (-1, 12), (1, 2))
    assert [strip.lower for strip in plane.strips] == [1, Rational(6, 5)]
    assert plane.strips[0].cells.edges == (0, 2)
    assert plane.strips[1].cells.edges == (0, 2, 2 * a / (a - 1))


def test_other_parameters_are_refused() -> None:
    three = PiecewiseLinearMap([(r - b, x <= 0), (r - a * x, x > 0)], given=[a > 1])
    with pytest.raises(ValueError, match=r"expected a map of a and r, this one has \['a', 'b'"):
        parameter_plane(three, a, r, (1, 4), (-1, 12))


def test_a_decision_of_higher_degree_is_refused() -> None:
    with pytest.raises(ValueError, match="degree 2 in a"):
        parameter_plane(P1L, r, a, (1, 12), (2, 4), (1, 2, 3))
