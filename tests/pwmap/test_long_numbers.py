"""Numbers of more than 4300 digits, which Python refuses to write, are shown by their sizes."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import sympy

from pwmap import (
    PiecewiseLinearMap,
    bifurcation_diagram,
    constant_entropy,
    dynamics,
    load_diagram,
    parameter_plane,
)
from pwmap.algebra.texts import text
from pwmap.diagrams.tables import table_of_branches, table_of_points, write_results

LONG = Fraction(10**5000 + 1, 3)
LINES = PiecewiseLinearMap.from_sympy("Piecewise((a*x + m, x <= 0), (b*x + m - 1, True))")
FLAT = LINES.at({"a": Fraction(1, 2), "b": Fraction(1, 3)})


def test_a_text_has_sizes_for_long_numbers_alone() -> None:
    x, long = sympy.Symbol("x"), sympy.Rational(LONG.numerator, LONG.denominator)
    assert text(sympy.Rational(1, 3)) == "1/3"
    assert text(long * x + 1) == "about 1e+5000*x/3 + 1"
    for interval in (
        sympy.Interval(0, 1), sympy.Interval.open(0, 1), sympy.Interval.Lopen(0, 1),
        sympy.Interval.Ropen(0, 1),
    ):  # fmt: skip
        ends = interval.left_open, interval.right_open
        expected = str(interval).replace("1", "about 1e+4999")
        assert text(sympy.Interval(interval.start, long, *ends)) == expected


@pytest.mark.parametrize("values", [
    {"a": "1/2", "b": "1/3", "m": LONG}, {"a": LONG, "b": -2, "m": "1/2"},
])  # fmt: skip
def test_maps_and_what_is_found_of_them_are_shown(values: dict[str, Any]) -> None:
    map_ = LINES.at(values)
    assert "about 1e+" in str(map_)
    twice = map_.iterate(2)
    for found in (twice.fixed_points(), twice.jump_crossings(), twice.pieces, dynamics(map_)):
        repr(found)
    assert "about" in repr(twice.fixed_points())


def test_diagrams_are_shown_and_saved(tmp_path: Path) -> None:
    diagram = bifurcation_diagram(FLAT, "m", (-LONG, LONG), (1, 2))
    for each in (diagram, *diagram.points, *diagram.branches):
        repr(each)
    assert "about -1e+4999" in diagram._repr_html_()
    table_of_branches(diagram)
    table_of_points(diagram)
    write_results(diagram, tmp_path)
    assert "about -1e+4999" in (tmp_path / "points.csv").read_text()
    again = load_diagram(diagram.save(tmp_path / "long.json"))  # there it has all digits
    assert again.points[0].exact["parameter"] == -sympy.Rational(LONG.numerator, LONG.denominator)


def test_long_runs_and_planes_are_shown() -> None:
    assert "about 1e+4999" in repr(constant_entropy(FLAT, "m", (-LONG, LONG)))
    plane = parameter_plane(LINES.at({"m": 1}), "a", "b", (Fraction(1, 10), LONG), (-5, -1), (1,))
    repr([*plane.curves, *plane.points, *plane.strips])
