"""Reprs of a line or a few, and small tables for notebooks."""

from dataclasses import replace

import pytest
import sympy
from test_diagram import branch, diagram, point

from pwmap import (
    Diagram,
    PiecewiseLinearMap,
    attractor_diagram,
    bifurcation_diagram,
    parameter_cells,
)
from pwmap.diagrams.shown import listed

MAP = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))")


def test_a_diagram_in_a_few_lines() -> None:
    found = bifurcation_diagram(MAP, "r", (-1, 6), orders=(1, 2, 3))
    assert repr(found) == (
        "Diagram(x over r: 11 branches in [-1, 6], 12 special points\n"
        "    order 1: 2 fixed-point, 1 jump\n"
        "    order 2: 2 jump\n"
        "    order 3: 3 jump, 3 fixed-point\n"
        "    points: 5 EP, 1 FF, 6 BC)"
    )
    empty = Diagram(parameter_name="p", x_name="x", branches=(), points=())
    assert repr(empty) == "Diagram(x over p: 0 branches, 0 special points)"


@pytest.mark.parametrize("text", ["a", "a and b", "a, b and c"])
def test_lists_in_a_sentence(text: str) -> None:
    assert listed(filter(str.islower, text.replace(" and", ",").split(", "))) == text


def test_a_branch_in_a_line() -> None:
    assert repr(branch(word="S2 D2 " * 30)) == (
        "Branch(b1: fixed-point of order 1, 3 samples, parameter 0.1 to 0.4, x -0.6 to -0.4, "
        "stable, from P1 to P2, "
        "word 'S2 D2 S2 D2 S2 D2 S2 D2 S2 D2 S2 D2 S2 D2 S2 D2 S2 D2 S2 ...')"
    )
    assert "stable" not in repr(branch(kind="jump"))


def test_tables_of_a_notebook() -> None:
    table = diagram()._repr_html_()
    assert table.startswith("<table><caption>phi_s over eps_n1: 2 branches in [0.1, 1]")
    assert "<td>A</td><td>border collision, fold</td><td>2/5</td>" in table
    assert table.count("<tr>") == 1 + len(diagram().points)
    many = replace(diagram(), points=tuple(point(f"P{k}") for k in range(40)), branches=())
    assert '<td colspan="6">and 16 more</td>' in many._repr_html_()
    assert "&lt;b&gt;" in replace(diagram(), x_name="<b>")._repr_html_()
    assert "<td>S2 D2</td>" in branch()._repr_html_()


@pytest.mark.slow
def test_maps_and_cells() -> None:
    at_one = MAP.at({"r": 1})
    assert repr(at_one.pieces[1]) == "<LinearPiece R: 1 - 5*x/4 for 0 < x>"
    assert repr(parameter_cells(MAP, "r")) == "ParameterCells(r, orders 1: 5 cells, edges 0, 2)"
    tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    found = attractor_diagram(tent, "a", ("6/5", "9/4"), 2)
    assert repr(found).startswith("AttractorDiagram(a in [6/5, 9/4], ")
    assert repr(found).endswith("crises: MC sqrt(2), FC 2)")
    assert found.crises[0].parameter == sympy.sqrt(2)
