"""Roots of numbers that sympy fails to take apart: products of two close ones, such as N."""

from pathlib import Path

import pytest
import sympy

from pwmap import (
    PiecewiseLinearMap,
    attractor_diagram,
    bifurcation_diagram,
    load_diagram,
    parameter_cells,
)

N = 10**60 - 9  # = (10^30 - 3) (10^30 + 3), of which both have large factors
P, Q = sympy.symbols("p q")


def with_break(at: str) -> PiecewiseLinearMap:
    """0 is fixed while the break is above it, and N from there on."""
    return PiecewiseLinearMap([("0", f"x < {at}"), (f"{N} + (x - {N})/2", f"x >= {at}")])


@pytest.mark.parametrize(
    ("at", "start", "root"),
    [
        # from the binomial series, as N = 10^60 (1 - 9/10^60)
        ("p**2", 0, 10**30 - sympy.Rational(9, 2 * 10**30)),
        ("(p - 1)**2", 2, 10**30 + 1 - sympy.Rational(9, 2 * 10**30)),
        ("p**3", 0, 10**20 - sympy.Rational(9, 3 * 10**40)),
    ],
)
def test_a_root_of_a_product_of_close_numbers_ends_branches(
    at: str, start: int, root: sympy.Rational, tmp_path: Path
) -> None:
    """The break meets N at a root of N; before, sympy's ValueError ended the diagram."""
    map_, span = with_break(at), (start, 2 * 10**30)
    found = bifurcation_diagram(map_, "p", span, (1,))
    (place,) = (point.exact["parameter"] for point in found.points if point.kind == "BC")
    # the next term of the series is 81/8 over 10^90, or 9 over 10^100, and smaller ones follow
    assert abs(sympy.N(place - root, 30, maxn=300)) < 11 * sympy.Rational(1, 10**90)
    loaded = load_diagram(found.save(tmp_path / "root.json"))
    assert [point.exact for point in loaded.points] == [point.exact for point in found.points]
    assert [branch.exact for branch in loaded.branches] == [each.exact for each in found.branches]
    cells = attractor_diagram(map_, "p", span, 1).cells
    assert [(cell.cycles, cell.upper) for cell in cells] == [(("L", "R"), place), (("L",), span[1])]


def test_with_another_parameter_such_a_root_is_kept_by_its_polynomial() -> None:
    """(p + q)^2 = N is met by p = -q + 10^30 - 9/(2 10^30) - ..."""
    (edge,) = parameter_cells(with_break("(p + q)**2"), "p", (1,), (0, 10**31), {"q": 1}).edges
    for value in (0, 1, 7):
        off = edge.subs(Q, value) + value - 10**30 + sympy.Rational(9, 2 * 10**30)
        assert abs(sympy.N(off, 30, maxn=300)) < 11 * sympy.Rational(1, 10**90)
