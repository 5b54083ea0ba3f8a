"""Pictures of local models: what is drawn, and that names do not overlap."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from maps import paper
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pwmap import Diagram, PiecewiseLinearMap, bifurcation_diagram
from woodpecker import local_model
from woodpecker.plot.figures import APART, plot_local, spread

A = Fraction(51, 50)  # steepness of the paper's map; its fold-flip lies at r = 0, x = 0


def drawn(orders: tuple[int, ...]) -> tuple[Axes, Axes]:
    """The paper's own map next to its fold-flip, and its local model."""
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), (f"r - ({A})*x", "x > 0")])
    diagram: Diagram = bifurcation_diagram(map_, "r", (Fraction(-1, 4), Fraction(1, 4)), orders)
    figure = plot_local(local_model(paper(float(A)), 0.0, 0.0), diagram, reach=0.1).figure
    assert isinstance(figure, Figure)
    figure.canvas.draw()
    left, right = figure.axes
    return left, right


@pytest.mark.parametrize("span", [Fraction(1, 4), Fraction(1, 10**4)])
def test_a_model_is_drawn_over_a_part_of_the_branches_that_start_there(span: Fraction) -> None:
    """All branches that start at the fold-flip end with the span: its fortieth."""
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), (f"r - ({A})*x", "x > 0")])
    diagram: Diagram = bifurcation_diagram(map_, "r", (-span, span), (1, 2))
    _, right = plot_local(local_model(paper(float(A)), 0.0, 0.0), diagram).axes
    ends = [float(np.max(np.abs(line.get_xdata()))) for line in right.get_lines()]
    assert ends == pytest.approx([float(span) / 40.0] * 5, rel=1e-12)


def test_names_of_lines_do_not_overlap() -> None:
    """Jumps of P_2 and P_4 have slopes 0.980 and 0.961 in r, and end 3 points apart."""
    _, right = drawn((1,))
    assert sorted(text.get_text() for text in right.texts) == [f"$P_{j}$" for j in (1, 1, 2, 3, 4)]
    boxes = sorted((text.get_window_extent() for text in right.texts), key=lambda box: box.y0)
    assert all(one.y1 <= other.y0 for one, other in pairwise(boxes))


def test_places_are_spread_as_little_as_can_be() -> None:
    """Pairs about their mean; what is far apart stays; a group that grows takes its neighbour."""
    assert spread(np.array([]), APART).tolist() == []
    assert spread(np.array([0.0, 2.0, 100.0]), 4.0).tolist() == [-1.0, 3.0, 100.0]
    assert spread(np.array([0.0, 0.0, 5.0]), 4.0).tolist() == pytest.approx([-7 / 3, 5 / 3, 17 / 3])
