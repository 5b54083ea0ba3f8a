"""What stands in single cells of tables, and in the columns that they are made of."""

import csv
import io
from dataclasses import replace

import numpy as np
import sympy
from rich.console import Console

from pwmap import PiecewiseLinearMap, bifurcation_diagram
from pwmap.diagrams.data import stable_inside
from pwmap.diagrams.tables import results_as_bytes, table_of_branches

LINES = "Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))"
DIAGRAM = bifurcation_diagram(PiecewiseLinearMap.from_sympy(LINES), "p", (-1, 2), orders=(1,))


def points_of(data: bytes) -> list[dict[str, str]]:
    return [*csv.DictReader(io.StringIO(data.decode()))]


def test_a_point_without_an_interval_has_empty_cells() -> None:
    """Exact points need none; those of doubles are known to lie in one."""
    first, *others = DIAGRAM.points
    mixed = replace(DIAGRAM, points=(replace(first, interval=(-1.25, -0.5)), *others))
    rows = points_of(results_as_bytes(mixed)["points.csv"])
    ends = [(row["interval_min"], row["interval_max"]) for row in rows]
    assert ends == [("-1.25", "-0.5"), *[("", "")] * len(others)]


def test_exact_values_are_text_that_can_be_read() -> None:
    rows = points_of(results_as_bytes(DIAGRAM)["points.csv"])
    exact = {name for name in rows[0] if name.endswith("_exact")}
    assert {"parameter_exact", "x_exact"} <= exact
    for row, point in zip(rows, DIAGRAM.points, strict=True):
        assert sympy.sympify(row["parameter_exact"]) == point.exact["parameter"]
        assert sympy.sympify(row["x_exact"]) == point.exact["x"]


def test_jumps_are_shown_with_both_limits() -> None:
    """At p the pieces end in p and p - 1; a fixed point has its own formula alone."""
    console = Console(width=200, record=True, file=io.StringIO())
    console.print(table_of_branches(DIAGRAM))
    (jump,) = (line for line in console.export_text().splitlines() if "jump" in line)
    assert "from p to p - 1" in " ".join(jump.split())
    console.print(table_of_branches(DIAGRAM))
    fixed = [line for line in console.export_text().splitlines() if "fixed-point" in line]
    assert len(fixed) == 2
    assert not any("from" in line for line in fixed)


def test_ends_of_a_branch_are_stable_as_what_lies_beside_them() -> None:
    """At a flip the multiplier is -1: neither stable nor unstable."""
    branch = DIAGRAM.branches[0]
    multiplier = np.array([-1.0, -0.9, -0.5, -1.5, -1.0])
    whole = replace(
        branch, parameter=np.arange(5.0), x=np.zeros(5), multiplier=multiplier, words=(), exact={}
    )
    assert stable_inside(whole).tolist() == [True, True, True, False, False]
    assert whole.stability == "partly stable"
    assert replace(whole, multiplier=[-1.0, -0.9, -0.5, -0.9, -1.0]).stability == "stable"
    assert replace(whole, multiplier=[-1.0, -1.1, -1.5, -1.1, -1.0]).stability == "unstable"
    assert [b.stability for b in DIAGRAM.branches if b.kind == "jump"] == [""]
