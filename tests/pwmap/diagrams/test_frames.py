"""Diagrams, branches and maps as dataframes: rows, names of columns, and values."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
import sympy
from sympy import Rational
from test_diagram import WORDS, branch, diagram

from pwmap import PiecewiseLinearMap, bifurcation_diagram, parameter_plane

A, R = sympy.symbols("a r")
FIRST = ["branch", "kind", "order", "word"]


@pytest.mark.nightly
def test_a_row_for_each_sample() -> None:
    made = diagram()
    frame = made.to_dataframe()
    assert list(frame.columns) == [*FIRST, "eps_n1", "phi_s", "multiplier", "stable"]
    assert len(frame) == sum(len(each) for each in made.branches)
    first = frame[frame.branch == "b1"]
    assert first.eps_n1.tolist() == [0.1, 0.2, 0.4]
    assert first.phi_s.tolist() == [-0.5, -0.6, -0.4]
    assert first.word.tolist() == ["S2 D2", "S2 D2", "S2 D2 I3"]
    assert first.stable.tolist() == [False, True, False]
    assert first.kind.unique().tolist() == ["fixed-point"]
    assert frame[frame.branch == "j1"].kind.unique().tolist() == ["jump"]
    assert frame.order.dtype.kind == "i"
    assert frame.stable.dtype == bool


def test_what_was_not_observed_is_nan() -> None:
    made = diagram()
    drop = np.array([1.0, 2.0, 3.0])
    seen = tuple(
        replace(each, columns={"drop": drop}) if each.id == "b1" else each for each in made.branches
    )
    frame = replace(made, branches=seen).to_dataframe()
    assert frame[frame.branch == "b1"]["drop"].tolist() == [1.0, 2.0, 3.0]
    assert frame[frame.branch == "j1"]["drop"].isna().all()


def test_a_branch_alone() -> None:
    frame = branch(words=WORDS, columns={"drop": [3.0, 2.0, 1.0]}).to_dataframe()
    assert list(frame.columns) == [*FIRST, "parameter", "x", "multiplier", "stable", "drop"]
    assert frame["drop"].tolist() == [3.0, 2.0, 1.0]
    frame.loc[0, "x"] = 7.0  # a copy, not the locked array of the branch


def test_a_row_for_each_point() -> None:
    frame = diagram().points_to_dataframe().set_index("point")
    assert frame.loc["BC1", ["name", "kind", "note", "branches"]].tolist() == [
        "A", "BC", "fold", "b1 j1",
    ]  # fmt: skip
    assert frame.loc["BC1", "cause"] == "two contacts close at once"
    assert frame.loc["BC1", "interval_min"] == 0.4 - 1e-12
    assert frame.loc["BC1", "parameter_exact"] == Rational(2, 5)
    assert frame.loc["EP1", "status"] == "open"
    assert frame.loc["EP1", "precision"] == math.inf
    assert math.isnan(frame.loc["EP1", "interval_max"])
    assert frame.eps_n1.tolist() == [0.1, 0.4, 1.0]


def test_a_diagram_without_branches() -> None:
    empty = replace(diagram(), branches=(), points=())
    assert list(empty.to_dataframe().columns) == [*FIRST, "eps_n1", "phi_s", "multiplier", "stable"]
    assert len(empty.to_dataframe()) == len(empty.points_to_dataframe()) == 0
    assert "precision" in empty.points_to_dataframe().columns


def test_exact_values_are_expressions() -> None:
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((r - 2, x <= 0), (r - a*x, True))", given=[A > 1]
    )
    points = bifurcation_diagram(map_, "r", (-1, 2), orders=(1, 2)).points_to_dataframe()
    (fold_flip,) = points[points.kind == "FF"].to_dict("records")
    assert (fold_flip["parameter_exact"], fold_flip["x_exact"]) == (0, 0)
    assert 2 / (A + 1) in points.x_exact.tolist()


def test_pieces_of_a_map() -> None:
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))")
    frame = map_.at({A: "5/4"}).to_dataframe()
    assert frame.word.tolist() == ["L", "R"]
    assert frame.slope.tolist() == [0, sympy.Rational(-5, 4)]
    assert frame.intercept.tolist() == [R - 2, R]
    assert frame.upper.tolist() == [0, sympy.oo]
    assert frame.upper_closed.tolist() == [True, False]


def test_curves_and_points_of_a_plane() -> None:
    skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2, 3))
    curves = plane.to_dataframe().set_index("id")
    a, b = sympy.symbols("a b", real=True)
    assert curves.loc["BC1", ["kind", "note", "words"]].tolist() == ["BC", "fold", "LLR LRR"]
    assert str(curves.loc["BC1", "polynomial"]) == str(a * b + a + 1)
    (point,) = plane.points_to_dataframe().to_dict("records")
    golden = (sympy.sqrt(5) - 1) / 2
    assert sympy.expand(point["a_exact"] - golden) == 0
    assert sympy.expand(point["b_exact"] + golden + 2) == 0
    assert (point["a"], point["b"]) == pytest.approx(
        (float(golden), -float(golden) - 2.0), abs=1e-15
    )
    assert point["curves"] == "PD3 BC1"


def test_the_remedy_is_named_without_pandas(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError) as refused:
        diagram().to_dataframe()
    assert str(refused.value) == (
        "a dataframe needs pandas, which is not installed: pip install 'woodpecker-toy[data]'"
    )


def test_a_parameter_with_the_name_of_a_column_keeps_one_of_its_own() -> None:
    """order + x/2 has a fixed point at 2 order up to order = 0."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((order + x/2, x <= 0), (order - 2, True))")
    found = bifurcation_diagram(map_, "order", (-1, 1), orders=(1,))
    frame, points = found.to_dataframe(), found.points_to_dataframe()
    assert set(frame["order"]) == set(points["order"]) == {1}
    assert (frame["order_"].min(), points["order_"].min()) == (-1.0, -1.0)
