"""Pictures of curves over two parameters: what is named, and where the toy is."""

import pytest
from legends import explained

from pwmap import PointKind
from pwmap.plot.labels import Labels
from pwmap.plot.palette import LINES
from woodpecker import Curve
from woodpecker.examples import border_curve
from woodpecker.plot.plane import label, plot_curves


@pytest.fixture(scope="module")
def curve() -> Curve:
    """The fold-flip of the paper's map over r and a, with a flip-border collision at a = 1."""
    return border_curve(0.5)


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
    said = "the toy" if inside else "the toy (0.5, 3) lies outside"
    assert explained(drawn.ax)[-1] == said
    assert ("the toy" in drawn.artists) is inside


def test_a_curve_has_the_colour_that_its_points_have_in_exact_planes(curve: Curve) -> None:
    """It is a fold-flip for a > 1 and a border collision, a fold, below."""
    lines = plot_curves({"A": curve}).ax.get_lines()
    drawn = {
        (line.get_color(), line.get_linestyle()) for line in lines if len(line.get_xdata()) > 1
    }
    assert drawn == {(LINES[PointKind.FF]["color"], "-"), (LINES[PointKind.BC]["color"], "-")}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("eps_n1", "$ε_{N1}$"), ("mu_2", "$μ_{2}$"), ("c_phi", "$c_{φ}$ [N m/rad]"),
        ("j_m", "$J_{M}$ [kg m$^2$]"), ("r_0", "$r_{0}$ [m]"), ("g", "$g_{}$ [m/s$^2$]"),
        ("a", "a"),
    ],
)  # fmt: skip
def test_axes_have_the_symbols_of_the_paper(name: str, text: str) -> None:
    assert label(name) == text
