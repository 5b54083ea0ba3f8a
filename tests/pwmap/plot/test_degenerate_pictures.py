"""Pictures of maps with slopes 0, 1 and -1, of one piece, or with long names."""

from pathlib import Path

import numpy as np
from legends import explained
from matplotlib.collections import QuadMesh

from pwmap import PiecewiseLinearMap, bifurcation_diagram, load_diagram, parameter_plane
from pwmap.plane import Colours, plane_raster
from pwmap.plot import axis_label, plot_diagram, plot_map
from pwmap.plot.plane import plot_plane


def test_intervals_of_fixed_points_are_told_where_they_are_not_drawn(tmp_path: Path) -> None:
    """Of p - x all points have the period 2; before, the picture had the fixed point alone."""
    found = bifurcation_diagram(PiecewiseLinearMap.from_sympy("p - x"), "p", (-1, 1), (1, 2))
    assert found.filled == [2]
    assert "intervals of fixed points: P_2" in repr(found)
    told = "not drawn: intervals of fixed points of $P_{2}$"
    assert told in explained(plot_diagram(found).ax)
    assert load_diagram(found.save(tmp_path / "found.json")) == found
    assert found.of_order(2).filled == [2]
    assert found.of_order(1).filled == []
    # x + p is the identity at p = 0 alone, along which there is a branch
    shifted = PiecewiseLinearMap.from_sympy("x + p")
    assert bifurcation_diagram(shifted, "p", (-1, 1), (1, 2)).filled == []


def test_the_graph_shows_intervals_of_fixed_points() -> None:
    """Of x for x <= 0 and 1/2 - x beyond: (-oo, 0], and of its second iterate (-oo, 1/2)."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((x, x <= 0), (1/2 - x, True))")
    for order, end in ((1, 0.0), (2, 0.5)):
        drawn = plot_map(map_.iterate(order), window=(-1.0, 1.0))
        lines = drawn.artists["interval of fixed points"]
        ends = [np.asarray(line.get_data(), dtype=float) for line in lines]  # type: ignore[attr-defined]
        assert min(line.min() for line in ends) == -1.0
        assert max(line.max() for line in ends) == end
        assert "interval of fixed points" in explained(drawn.ax)


def test_a_name_with_several_underscores_keeps_its_blanks() -> None:
    """LaTeX makes subscripts of it, in which mathematical text has no blanks."""
    assert axis_label("gap_of_the_lever") == r"$gap_{of\ the\ lever}$"
    assert axis_label("alpha") == r"$\alpha$"


def test_an_entropy_of_zero_has_the_colour_of_zero() -> None:
    """Before, the scale went from -0.1 to 0.1."""
    flat = PiecewiseLinearMap.from_sympy("Piecewise((a + b - x/2, True))")
    plane = parameter_plane(flat, "a", "b", (-1, 1), (-1, 1), orders=(1,))
    raster = plane_raster(plane, columns=2, rows=2)
    assert not raster.entropy.any()
    ax = plot_plane(plane, raster=raster, colours=Colours.ENTROPY).ax
    (mesh,) = (each for each in ax.collections if isinstance(each, QuadMesh))
    assert mesh.get_clim() == (0.0, np.log(2.0))
