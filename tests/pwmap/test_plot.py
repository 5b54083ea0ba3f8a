"""Pictures of maps: what is drawn, read back from the axes."""

from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
import pytest
import sympy
from matplotlib.axes import Axes
from sympy import Rational

from pwmap import (
    Branch,
    BranchKind,
    Diagram,
    PiecewiseLinearMap,
    PointKind,
    SpecialPoint,
    Stretch,
    parameter_plane,
)
from pwmap.plot import plot_cobweb, plot_diagram, plot_map
from pwmap.plot_plane import plot_plane

P1L = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
AT_ONE = P1L.at({"a": Rational(5, 4), "r": 1})


@pytest.fixture(autouse=True)
def _close() -> Iterator[None]:
    yield
    plt.close("all")


def lines(ax: Axes) -> list[tuple[list[float], list[float]]]:
    return [
        (np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist())
        for line in ax.lines
    ]


def test_a_map_shows_pieces_jumps_and_fixed_points() -> None:
    ax = plot_map(AT_ONE, window=(-2.0, 2.0))
    drawn = lines(ax)
    assert ([-2.0, 0.0], [-1.0, -1.0]) in drawn
    assert ([0.0, 2.0], [1.0, -1.5]) in drawn
    assert ([0.0, 0.0], [-1.0, 1.0]) in drawn  # the jump that crosses the diagonal
    assert ([-1.0], [-1.0]) in drawn
    assert ([4 / 9], [4 / 9]) in drawn
    ends = {(x[0], y[0]): line for (x, y), line in zip(drawn, ax.lines, strict=True) if len(x) == 1}
    assert ends[0.0, 1.0].get_markerfacecolor() == "white"  # x = 0 belongs to the left piece
    assert ends[0.0, -1.0].get_markerfacecolor() != "white"
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [
        "jump crossing", "stable fixed point", "unstable fixed point",
    ]  # fmt: skip


def test_the_window_holds_all_breaks_and_fixed_points() -> None:
    low, high = plot_map(AT_ONE.iterate(2)).get_xlim()
    assert low < -1.0
    assert high > 1.0


def test_a_cobweb_follows_the_orbit() -> None:
    ax = plot_cobweb(AT_ONE, Rational(1, 2), 2)
    # 1/2 -> 1 - 5/8 = 3/8 -> 1 - 15/32 = 17/32
    x, y = lines(ax)[-2]
    assert x == [0.5, 0.5, 0.375, 0.375, 0.53125]
    assert y == [0.5, 0.375, 0.375, 0.53125, 0.53125]


def test_the_plane_has_one_colour_for_each_set_of_periods() -> None:
    a, r = sympy.symbols("a r")
    plane = parameter_plane(P1L, a, r, (1, 4), (-1, 12), (1, 2, 3))
    ax = plot_plane(plane, samples=5)
    legend = ax.get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == [
        *("none found", "1", "2", "3", "border collision", "fold-flip"),
    ]
    edges = lines(ax)
    assert any(np.allclose(y, [2 * v / (v - 1) for v in x]) for x, y in edges if x[0] > 1.19)


def test_parameters_need_values() -> None:
    with pytest.raises(ValueError, match="give a, r a value first"):
        plot_map(P1L)
    with pytest.raises(ValueError, match="give a, r a value first"):
        plot_cobweb(P1L, 0, 3)
    with pytest.raises(ValueError, match="at least one step, got 0"):
        plot_cobweb(AT_ONE, 0, 0)


def small_diagram() -> Diagram:
    """A branch whose word changes at its second sample, between a named point and an end."""
    points = (
        SpecialPoint(id="BC1", kind=PointKind.BC, parameter=0.0, x=0.0, name="C"),
        SpecialPoint(id="EP1", kind=PointKind.EP, parameter=1.0, x=2.0),
    )
    branch = Branch(
        id="F1", kind=BranchKind.FIXED_POINT, order=1, word="A", ends=("BC1", "EP1"),
        parameter=np.array([0.0, 0.5, 1.0]), x=np.array([0.0, 1.0, 2.0]), multiplier=np.zeros(3),
        words=(Stretch(0, "A"), Stretch(1, "B", "a gap closes")),
    )  # fmt: skip
    return Diagram(parameter_name="p", x_name="x", branches=(branch,), points=points)


def test_names_are_written_and_words_marked_on_request() -> None:
    for words in (False, True):
        ax = plot_diagram(small_diagram(), words=words)
        assert [text.get_text() for text in ax.texts] == ["C"]
        legend = ax.get_legend()
        assert legend is not None
        shown = [text.get_text() for text in legend.get_texts()]
        assert shown == ["stable", "border collision", "end point", *["word change"] * words]
        places = [np.asarray(marks.get_offsets()).tolist() for marks in ax.collections]
        assert ([[0.5, 1.0]] in places) is words
