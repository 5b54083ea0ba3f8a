"""Pictures of curves over two parameters: what is named, and where the toy is."""

from typing import Any

import matplotlib as mpl
import pytest
import sympy

mpl.use("Agg")

from pwmap import PointKind
from pwmap.plot.labels import Labels
from pwmap.plot.palette import LINES
from woodpecker import Curve, Settings, continuation, curve_in_two, shoot
from woodpecker.plane import family_from_sympy
from woodpecker.plot.plane import plot_curves


@pytest.fixture(scope="module")
def curve() -> Curve:
    """The fold-flip of the paper's map over r and a, with a flip-border collision at a = 1."""
    x, a, r = sympy.symbols("x a r")
    map_: Any = sympy.Piecewise((r - 2, x <= 0), (r - a * x, True))
    family = family_from_sympy(map_, x, (r, a), words=["L", "R"])
    settings = Settings(span=(-1, 1), window=(-4, 4))
    over = family.over(0, (0.0, 1.25))
    point = continuation(over, shoot(over, 0.2, p=0.45), settings=settings).points[0]
    return curve_in_two(
        family, point, family.names, ((-1, 1), (0.5, 2)), value=1.25, settings=settings
    )


def test_curves_and_points_have_the_names_of_the_table(curve: Curve) -> None:
    drawn = plot_curves({"A": curve})
    drawn.figure.canvas.draw()
    (labels,) = drawn.artists["names"]
    assert isinstance(labels, Labels)
    special = [point.id for point in curve.points[1:-1]]
    assert special == ["PDB1"]
    assert [text for text, _ in labels.placed] == ["A", *special]


@pytest.mark.parametrize(("here", "inside"), [((0.0, 1.5), True), ((0.5, 3.0), False)])
def test_the_toy_is_marked_where_it_is_seen(
    curve: Curve, here: tuple[float, float], inside: bool
) -> None:
    drawn = plot_curves({"A": curve}, here=here)
    low, high = drawn.ax.get_ylim()
    assert (low, high) == pytest.approx((0.44, 2.06))  # of the curve from 0.5 to 2, with 0.04
    legend = drawn.ax.get_legend()
    assert legend is not None
    said = "the toy" if inside else "the toy (0.5, 3) lies outside"
    assert legend.get_texts()[-1].get_text() == said
    assert ("the toy" in drawn.artists) is inside


def test_a_curve_has_the_colour_that_its_points_have_in_exact_planes(curve: Curve) -> None:
    """It is a fold-flip for a > 1 and a border collision, a fold, below."""
    lines = plot_curves({"A": curve}).ax.get_lines()
    drawn = {
        (line.get_color(), line.get_linestyle()) for line in lines if len(line.get_xdata()) > 1
    }
    assert drawn == {(LINES[PointKind.FF]["color"], "-"), (LINES[PointKind.BC]["color"], "-")}
