"""Pictures of maps: what is drawn, read back from the axes."""

from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
import sympy
from legends import explained, legend_of
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.transforms import Bbox
from sympy import Rational

from pwmap import (
    Branch,
    BranchKind,
    Diagram,
    PiecewiseLinearMap,
    PointKind,
    SpecialPoint,
    bifurcation_diagram,
    parameter_plane,
)
from pwmap.diagrams import Stretch
from pwmap.plot import INK, Drawn, plot_cobweb, plot_diagram, plot_map
from pwmap.plot import labels as placing
from pwmap.plot.diagrams import STYLES
from pwmap.plot.labels import Labels
from pwmap.plot.palette import NOTHING, of_period
from pwmap.plot.plane import _face, plot_plane

P1L = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
AT_ONE = P1L.at({"a": Rational(5, 4), "r": 1})


def lines(ax: Axes) -> list[tuple[list[float], list[float]]]:
    return [
        (np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist())
        for line in ax.lines
    ]


def test_a_map_shows_pieces_jumps_and_fixed_points() -> None:
    ax = plot_map(AT_ONE, window=(-2.0, 2.0)).ax
    drawn = lines(ax)
    assert ([-2.0, 0.0], [-1.0, -1.0]) in drawn
    assert ([0.0, 2.0], [1.0, -1.5]) in drawn
    assert ([0.0, 0.0], [-1.0, 1.0]) in drawn  # the jump that crosses the diagonal
    assert ([-1.0], [-1.0]) in drawn
    assert ([4 / 9], [4 / 9]) in drawn
    ends = {(x[0], y[0]): line for (x, y), line in zip(drawn, ax.lines, strict=True) if len(x) == 1}
    assert ends[0.0, 1.0].get_markerfacecolor() == "white"  # x = 0 belongs to the left piece
    assert ends[0.0, -1.0].get_markerfacecolor() != "white"
    assert explained(ax) == [
        "jump crossing", "stable fixed point", "unstable fixed point",
        "included end", "excluded end",
    ]  # fmt: skip


def test_the_window_holds_all_breaks_and_fixed_points() -> None:
    low, high = plot_map(AT_ONE.iterate(2)).ax.get_xlim()
    assert low < -1.0
    assert high > 1.0


def test_a_cobweb_follows_the_orbit() -> None:
    ax = plot_cobweb(AT_ONE, Rational(1, 2), 2).ax
    # 1/2 -> 1 - 5/8 = 3/8 -> 1 - 15/32 = 17/32
    x, y = lines(ax)[-2]
    assert x == [0.5, 0.5, 0.375, 0.375, 0.53125]
    assert y == [0.5, 0.375, 0.375, 0.53125, 0.53125]


def test_the_plane_has_one_colour_for_each_set_of_periods() -> None:
    a, r = sympy.symbols("a r")
    plane = parameter_plane(P1L, a, r, (1, 4), (-1, 12), (1, 2, 3))
    ax = plot_plane(plane, samples=5).ax
    assert explained(ax) == [
        "none found", "period 1", "period 2", "period 3", "border collision",
        "border-collision fold-flip",
    ]  # fmt: skip
    edges = lines(ax)
    assert any(np.allclose(y, [2 * v / (v - 1) for v in x]) for x, y in edges if x[0] > 1.19)


def test_areas_name_all_periods_that_attract_in_them() -> None:
    """2 a - 4 is fixed on the left, and 1/2 goes to b + 1 and back."""
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x/2 + a - 2, x < 0), (b + 1, x < 1), (1/2, True))"
    )
    plane = parameter_plane(map_, "a", "b", (0, 1), (1, 2), orders=(1, 2))
    assert explained(plot_plane(plane, samples=5).ax)[0] == "periods 1 and 2"


@pytest.mark.slow
def test_curves_and_points_of_a_plane_have_names() -> None:
    """Where the period doubles at b = -1 and a = 1; the raster has two periods, and no other."""
    skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    plane = parameter_plane(skew, "a", "b", ("1/4", "5/4"), ("-3/2", "-1/2"), orders=(1, 2))
    drawn = plot_plane(plane, samples=20)
    assert {*(c.id for c in plane.curves), *(p.id for p in plane.points)} == set(written(drawn))
    assert len(plane.points) > 0
    assert "of codimension two" in explained(drawn.ax)


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


def written(drawn: Drawn) -> list[str]:
    """The names in a picture, after it was drawn."""
    drawn.figure.canvas.draw()
    (labels,) = drawn.artists["names"]
    assert isinstance(labels, Labels)
    return [text for text, _ in labels.placed]


def at(*places: tuple[str, float, float], end: tuple[float, float] = (1.0, 1.0)) -> Diagram:
    """A diagram of points alone, beside two ends: the origin, and by default (1, 1)."""
    ends = (("EP0", 0.0, 0.0), ("EP1", *end))
    points = tuple(
        SpecialPoint(
            id=name, kind=PointKind(name[:2]) if name[1:] else PointKind.BC, parameter=p, x=x
        )
        for name, p, x in (*ends, *places)
    )
    return Diagram(parameter_name="p", x_name="x", branches=(), points=points)


def boxes_of(drawn: Drawn) -> list[Bbox]:
    """Where names stand, after they were written."""
    return [box for _, box in drawn.artists["names"][0].placed]  # type: ignore[attr-defined]


@pytest.mark.slow
def test_names_are_written_and_words_marked_on_request() -> None:
    for words in (False, True):
        drawn = plot_diagram(small_diagram(), words=words)
        assert written(drawn) == ["C"]
        shown = ["stable", "border collision", "end point", *["word change"] * words]
        assert explained(drawn.ax) == shown
        assert list(drawn.artists) == [*shown[:3], "names", *shown[3:]]
        places = [np.asarray(marks.get_offsets()).tolist() for marks in drawn.ax.collections]
        assert ([[0.5, 1.0]] in places) is words
    assert written(plot_diagram(small_diagram(), labels=True)) == ["C", "EP1"]
    assert written(plot_diagram(small_diagram(), labels=False)) == []


def test_a_curve_of_a_plane_is_one_line_through_its_arcs() -> None:
    """Arcs are cut at strips; drawn one by one their edges would cover the ends of the others."""
    skew = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
    plane = parameter_plane(skew, "a", "b", ("1/4", "3/4"), (-5, "-1/2"), orders=(1, 2, 3))
    drawn = plot_plane(plane)
    lines = [line for line in drawn.ax.lines if line.get_marker() in ("", "None")]
    assert len(lines) == len(plane.curves)
    assert any(len(curve.arcs) > 1 for curve in plane.curves)
    assert all(np.isfinite(line.get_xydata()).all() for line in lines)


def paper_diagram(*orders: int) -> Diagram:
    return bifurcation_diagram(P1L.at({"a": Rational(5, 4)}), "r", (-1, 6), orders=orders)


@pytest.mark.nightly
def test_orders_are_told_apart_without_colours() -> None:
    names = written(plot_diagram(paper_diagram(1, 2, 3)))
    assert {"$P_{1}$", "$P_{2}$", "$P_{3}$"} <= set(names)
    assert "FF1" in names
    assert [name for name in written(plot_diagram(paper_diagram(1))) if "$" in name] == []
    assert "$P_{2}$" in written(plot_diagram(paper_diagram(1, 2).of_order(2)))


@pytest.mark.slow
def test_names_cover_neither_each_other_nor_markers() -> None:
    """Eight points within a tenth of the picture."""
    places = [(f"BC{k}", 0.5 + 0.01 * (k % 3), 0.01 * k) for k in range(8)]
    drawn = plot_diagram(at(*places))
    assert sorted(written(drawn)) == [f"BC{k}" for k in range(8)]
    boxes = boxes_of(drawn)
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
        for _, *place in places:
            assert not box.contains(*drawn.ax.transData.transform(place))
    drawn.ax.set_xlim(0.9, 1.1)  # what is not seen has no name
    assert written(drawn) == []


def test_a_name_stands_closer_to_its_own_point_than_to_another() -> None:
    """Four points on a line, closer than names are wide."""
    row = [(0.1 * k, 1.0) for k in range(4)]
    drawn = plot_diagram(at(*((f"BC{k}", *place) for k, place in enumerate(row)), end=(3.0, 0.0)))
    assert len(written(drawn)) == 4
    places = drawn.ax.transData.transform(row)
    for k, box in enumerate(boxes_of(drawn)):
        away = np.hypot(*(places - np.clip(places, box.min, box.max)).T)
        assert away.argmin() == k


def test_points_on_one_another_share_one_label_from_left_to_right() -> None:
    """Two points 0.002 apart in a picture of 7 inches, that is one point of print; seven in one."""
    drawn = plot_diagram(at(("FF1", 0.502, 0.5), ("C", 0.5, 0.5), ("BC1", 0.7, 0.5)))
    assert written(drawn) == ["C, FF1", "BC1"]
    many = [(f"FF{k}", 0.5, 0.5) for k in (3, 9, 4, 8, 5, 7, 6)]
    assert written(plot_diagram(at(*many, ("BC2", 0.5, 0.5)))) == ["BC2, FF3\u2013FF9"]


def test_a_long_label_has_two_rows() -> None:
    """Four names of one letter and number in a row would be twice as wide as two."""
    wide, tall = [], []
    for n in (2, 4):
        drawn = plot_diagram(at(*((f"BC{k}", 0.5, 0.5) for k in range(n))))
        written(drawn)
        (box,) = boxes_of(drawn)
        wide.append(box.width)
        tall.append(box.height)
    assert abs(wide[1] - wide[0]) < 0.1 * wide[0]  # a comma more
    assert 1.8 * tall[0] < tall[1] < 2.6 * tall[0]  # two lines, and what is between them


CROWDED = (  # what the toy meets over mu_2 next to the end of its stable motion
    ("LP3", 0.280808, -0.469534), ("PD4", 0.280808, -0.469535), ("BC9", 0.280825, -0.469440),
    ("BC10", 0.280964, -0.467748), ("FF2", 0.281282, -0.464322), ("FF1", 0.282240, -0.461943),
    ("BC8", 0.282244, -0.456501), ("BC12", 0.282318, -0.449209), ("PD3", 0.282332, -0.456243),
    ("BC11", 0.282431, -0.450657), ("FF8", 0.282435, -0.444608), ("FF6", 0.282435, -0.444614),
    ("FF4", 0.282435, -0.444651), ("FF9", 0.282451, -0.443986), ("FF7", 0.282452, -0.443989),
    ("FF5", 0.282452, -0.444007), ("FF3", 0.282454, -0.444110), ("BC7", 0.284018, -0.442744),
    ("LP1", 0.284027, -0.468138), ("BC6", 0.284078, -0.449401), ("BC5", 0.284162, -0.450778),
)  # fmt: skip


@pytest.mark.slow
def test_labels_stay_inside_and_lines_to_them_strike_none() -> None:
    drawn = plot_diagram(at(*CROWDED), legend=False)
    drawn.ax.set(xlim=(0.278, 0.333), ylim=(-0.55, -0.437))
    texts = written(drawn)
    assert "FF3\u2013FF9" in texts
    assert "LP3, PD4, BC9" in texts
    boxes = boxes_of(drawn)
    for k, box in enumerate(boxes):
        assert drawn.ax.bbox.contains(*box.min)
        assert drawn.ax.bbox.contains(*box.max)
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
    leads = drawn.artists["names"][0].leads  # type: ignore[attr-defined]
    assert len(leads) > 1
    for number, start, end in leads:
        line = np.array(start) + np.linspace(0.0, 0.98, 200)[:, None] * np.subtract(end, start)
        for k, box in enumerate(boxes):
            assert k == number or not any(box.contains(*place) for place in line)


def test_branches_of_one_style_that_meet_are_one_line() -> None:
    """A pattern of dashes would start anew with each: short branches would look solid."""
    kink = PiecewiseLinearMap.from_sympy("Piecewise((p - 2*x, x <= 0), (p - 3*x/2, True))")
    found = bifurcation_diagram(kink, "p", (-1, 1), orders=(1,))
    assert len(found.branches) == 2
    ((p, x),) = lines(plot_diagram(found).ax)
    assert (p, x) == ([-1.0, 0.0, 0.0, 1.0], [-1 / 3, 0.0, 0.0, 0.4])


@pytest.mark.slow
def test_crowded_names_part_and_each_two_are_compared_a_few_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """After the first sweeps a name covers two markers, and goes first in the next ones.

    Most names stay where they are from one sweep to the next: of 48 * 49 pairs each is compared
    twice on average, where sweeps that remembered nothing compared each twelve times.
    """
    compared, beside = list[object](), placing._beside
    monkeypatch.setattr(placing, "_beside", lambda *about: compared.append(about) or beside(*about))
    p54 = P1L.at({"a": Rational(5, 4)})
    drawn = plot_diagram(bifurcation_diagram(p54, "r", (-1, 12), range(1, 8)), labels=True)
    assert len([name for name in written(drawn) if "$" not in name]) == 49
    (names,) = drawn.artists["names"]
    assert isinstance(names, Labels)
    boxes, markers = [box for _, box in names.placed], drawn.ax.transData.transform(names.markers)
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
        assert not any(box.contains(*marker) for marker in markers)
    assert len(compared) < 2.5 * 48 * 49


def test_a_star_lies_under_what_it_would_hide() -> None:
    drawn = plot_diagram(at(("FF1", 0.5, 0.5), ("BC1", 0.5, 0.5)))
    stars, circles = (
        drawn.artists["border-collision fold-flip"][0],
        drawn.artists["border collision"][0],
    )
    assert stars.get_zorder() < circles.get_zorder()


def test_a_branch_to_infinity_leaves_the_others_apart() -> None:
    """1/(p - 1) leaves x = 0 and x = 1/4 apart; all x <= 0 at p = 0 are drawn beyond the axes."""
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x + p, x <= 0), (1/2 - x, x < 1), (p*x - 1, True))"
    )
    found = bifurcation_diagram(map_, "p", (-1, "3/2"), (1,))
    ax = plot_diagram(found).ax
    low, high = ax.get_ylim()
    assert 0.02 * (high - low) < 0.25  # 2 % of the axes are wider than a line
    assert ax.get_xlim() == pytest.approx((-1.125, 1.625))  # a margin of 5 % around the span
    ((down, up),) = (x for p, x in lines(ax) if set(p) == {0.0})
    assert down < low < up == 0.0
    assert (1.5, 2.0) in {(p[-1], x[-1]) for p, x in lines(ax)}


def test_kinds_that_do_not_exist_are_refused_with_those_that_do() -> None:
    with pytest.raises(ValueError, match="'BCC' is not a valid PointKind, which is one of LP"):
        plot_diagram(small_diagram(), kinds=("BCC",))  # type: ignore[arg-type]


def test_a_name_has_its_marker_whatever_kinds_are_asked_for() -> None:
    drawn = plot_diagram(small_diagram(), kinds=())
    assert explained(drawn.ax) == ["stable", "border collision"]
    assert written(drawn) == ["C"]


def test_each_period_has_its_colour_and_higher_ones_thinner_lines() -> None:
    drawn = plot_diagram(paper_diagram(1, 2, 3))
    assert explained(drawn.ax)[-3:] == ["period 1", "period 2", "period 3"]
    looks = {
        (line.get_color(), round(line.get_linewidth(), 3))  # type: ignore[attr-defined]
        for line in drawn.artists["stable"]
    }
    assert looks == {(of_period(1), round(1.6 * 1.25, 3)), (of_period(3), round(1.6 * 0.85, 3))}
    jumps = {line.get_color() for line in drawn.artists["jump crossing"]}  # type: ignore[attr-defined]
    assert jumps == {of_period(k) for k in (1, 2, 3)}


@pytest.mark.parametrize("order", [1, 2])
def test_a_period_has_one_colour_alone_and_beside_others(order: int) -> None:
    both = paper_diagram(1, 2)
    colours = [
        {line.get_color() for name in STYLES for line in drawn.artists.get(name, ())}  # type: ignore[attr-defined]
        for drawn in (plot_diagram(both.of_order(order)), plot_diagram(both))
    ]
    assert colours == [{of_period(order)}, {of_period(1), of_period(2)}]


def test_the_legend_has_the_style_that_a_caller_gives() -> None:
    drawn = plot_diagram(paper_diagram(1, 2), styles={"stable": {"color": "red"}})
    assert [line.get_color() for line in legend_of(drawn.ax).get_lines()[:2]] == ["red", INK]
    assert explained(drawn.ax)[-2:] == ["period 1", "period 2"]  # of unstable lines and jumps


def test_the_legend_has_no_colour_that_no_line_has() -> None:
    styles = {"stable": {"color": "red"}, "unstable": {"c": "k"}, "jump crossing": {"color": "k"}}
    drawn = plot_diagram(paper_diagram(1, 2), styles=styles)
    assert "period 1" not in explained(drawn.ax)
    assert "period 2" not in explained(drawn.ax)
    assert len(drawn.artists["period 1"]) > 1


def test_a_period_has_the_style_that_a_caller_gives() -> None:
    drawn = plot_diagram(paper_diagram(1, 2), styles={"period 2": {"color": "green"}})
    assert {line.get_color() for line in drawn.artists["period 2"]} == {"green"}  # type: ignore[attr-defined]
    shown = dict(zip(explained(drawn.ax), legend_of(drawn.ax).get_lines(), strict=False))
    samples = {str(line.get_color()) for line in shown.values()}
    assert {"green", of_period(1)} <= samples
    assert of_period(2) not in samples


@pytest.mark.slow
def test_branches_have_labels_on_request() -> None:
    texts = written(plot_diagram(paper_diagram(1), branches=True, labels=False))
    assert texts == ["F2", "F1", "J1"]  # the longest first
    own = {"F1": "slips", "J1": "jumps"}
    assert set(written(plot_diagram(paper_diagram(1), branches=own, labels=False))) == {
        "slips",
        "jumps",
    }
    with pytest.raises(KeyError, match="no branch 'F9'"):
        plot_diagram(paper_diagram(1), branches={"F9": "?"})


def test_cells_in_which_several_periods_attract_are_hatched() -> None:
    faces = [_face(periods) for periods in ((), (1,), (1, 2), (2, 3, 5))]
    assert [each["facecolor"] for each in faces] == [NOTHING, *map(of_period, (1, 1, 2))]
    assert [each["edgecolor"] for each in faces] == [NOTHING, *map(of_period, (1, 2, 3))]
    assert len({each["hatch"] for each in faces}) == 3


@pytest.mark.slow
def test_crowded_points_have_ids_where_there_is_room() -> None:
    """Twelve points in a picture of 2 by 2 inches, three after a zoom; one has a name."""
    row = at(*((f"BC{k}", float(k), 0.0) for k in range(12)), end=(11.0, 0.0))
    crowded = row.named({"A": "BC4"})
    figure = plt.figure(figsize=(2.0, 2.0))
    drawn = plot_diagram(crowded, figure.add_axes((0.0, 0.0, 1.0, 1.0)))
    assert written(drawn) == ["A"]
    drawn.ax.set_xlim(2.5, 5.5)
    assert written(drawn) == ["A", "BC3", "BC5"]
    figure.set_size_inches(4.0, 4.0)
    drawn.ax.set_xlim(-1.0, 12.0)
    assert len(written(drawn)) == 12


@pytest.mark.nightly
def test_names_keep_clear_of_the_legend() -> None:
    drawn = plot_diagram(paper_diagram(1, 2, 3))
    written(drawn)
    corner = legend_of(drawn.ax).get_window_extent()
    assert not any(box.overlaps(corner) for box in boxes_of(drawn))


@pytest.mark.nightly
def test_many_points_have_labels_on_request_only() -> None:
    many = at(*((f"BC{k}", float(k), 0.0) for k in range(1, 32)), end=(32.0, 0.0))
    assert written(plot_diagram(many)) == []
    assert len(written(plot_diagram(many, labels=True))) == 33  # ends, too


@pytest.mark.slow
def test_only_what_is_stable() -> None:
    drawn = plot_diagram(paper_diagram(1, 2, 3), stable_only=True)
    assert explained(drawn.ax) == [
        "stable", "border collision", "end point", "period 1", "period 3",
    ]  # fmt: skip
    assert len(drawn.artists["stable"]) == 4  # one fixed point, and a cycle of period 3
    assert written(drawn).count("FF1") == 0


def test_styles_change_what_they_name() -> None:
    style = {
        "stable": {"color": "black", "linewidth": 3.0},
        "border-collision fold-flip": {"zorder": 9},
    }
    drawn = plot_diagram(paper_diagram(1), styles=style)
    (line, *_) = drawn.artists["stable"]
    assert (line.get_color(), line.get_linewidth()) == ("black", 3.0)
    assert drawn.artists["border-collision fold-flip"][0].get_zorder() == 9
    pieces = plot_map(AT_ONE, styles={"pieces": {"color": "red"}}).artists["pieces"]
    assert [each.get_color() for each in pieces] == ["red", "red"]
    with pytest.raises(
        ValueError, match=r"style of 'stable' has no property 'colour'; possible are .*, color, .*"
    ):
        plot_diagram(paper_diagram(1), styles={"stable": {"linewidth": 2, "colour": "k"}})


def test_a_diagram_is_drawn_on_given_axes() -> None:
    _, ax = plt.subplots()
    drawn = plot_diagram(small_diagram(), ax, legend=False)
    assert drawn.ax is ax
    assert drawn.figure is ax.figure
    assert ax.get_legend() is None


def test_all_text_grows_with_the_size_of_matplotlib() -> None:
    """For a slide: legend and names as much as the numbers of the axes."""
    sizes = []
    for points in (10.0, 20.0):
        with plt.rc_context({"font.size": points}):
            drawn = plot_diagram(small_diagram())
            drawn.figure.canvas.draw()
            names = [text.get_fontsize() for text in drawn.ax.texts]
            sizes.append([legend_of(drawn.ax).get_texts()[0].get_fontsize(), *names])
    assert sizes[1] == pytest.approx([2.0 * size for size in sizes[0]])


def test_a_size_of_pictures_in_the_settings_of_matplotlib_counts() -> None:
    assert plot_map(AT_ONE).figure.get_size_inches().tolist() != [13.3, 7.5]
    with plt.rc_context({"figure.figsize": (13.3, 7.5)}):
        assert plot_map(AT_ONE).figure.get_size_inches().tolist() == [13.3, 7.5]


def test_names_of_curves_that_lie_on_each_other_do_not_touch() -> None:
    """Jump crossings of orders 1, 3 and 5 lie on x = 0: their names read as one."""
    two_lines = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
    drawn = plot_diagram(bifurcation_diagram(two_lines, "p", (-1, 2), orders=range(1, 6)))
    assert len(written(drawn)) > 5
    least = 2.0 * drawn.figure.dpi / 72.0
    for one, other in combinations(boxes_of(drawn), 2):
        assert not one.padded(0.99 * least).overlaps(other)


def test_ends_are_marked_at_jumps_only() -> None:
    """A hollow tip looked as if the tent had none; its iterates are continuous, too."""
    tent = PiecewiseLinearMap.from_sympy("Piecewise((2*x, x <= 1/2), (2 - 2*x, True))")
    for map_ in (tent, tent.iterate(3)):
        drawn = plot_map(map_)
        assert (drawn.artists["ends"], len(drawn.artists["pieces"])) == ([], len(map_.pieces))
        assert explained(drawn.ax) == ["unstable fixed point"]
    point = PiecewiseLinearMap([("x", "x < 0"), ("1", "Eq(x, 0)"), ("2*x", "x > 0")])
    ends = [tuple(float(v[0]) for v in end.get_data()) for end in plot_map(point).artists["ends"]]
    assert sorted(ends) == [(0.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.0, 1.0)]


def test_pieces_that_are_too_steep_for_doubles_are_drawn_from_end_to_end() -> None:
    """P_6 rises from 0 to 1 with the slope 1e18, where the doubles nearest to its ends are one."""
    steep = PiecewiseLinearMap.from_sympy(
        "Piecewise((0, x < 999/1000), (1000*x - 999, x < 1), (1, True))"
    )
    rising = plot_map(steep.iterate(6)).artists["pieces"][-2]
    assert [float(y) for y in rising.get_ydata()] == [0.0, 1.0]


@pytest.mark.slow
@pytest.mark.parametrize(("a", "highest"), [(2, 6), (3, 4)])
def test_a_long_legend_covers_no_marker(a: int, highest: int) -> None:
    """In one column it covered one at each of the nine places that matplotlib tries."""
    map_ = P1L.at({"a": a})
    diagram = bifurcation_diagram(map_, "r", (-1, 4), range(1, highest + 1))
    drawn = plot_diagram(diagram, words=True, branches=True)
    drawn.figure.canvas.draw()
    radius = 3.0 * drawn.figure.dpi / 72.0  # of a marker, whose area is 26 square points
    box = legend_of(drawn.ax).get_window_extent().padded(radius)
    scattered = [each for parts in drawn.artists.values() for each in parts
                 if isinstance(each, PathCollection)]  # fmt: skip
    points = np.concatenate([np.asarray(each.get_offsets()) for each in scattered])
    assert box.count_contains(drawn.ax.transData.transform(points)) == 0


def test_two_diagrams_on_the_same_axes_share_a_legend_and_names_keep_apart() -> None:
    """The first is of one iterate and has an end of its own; BC1 is the same point in both."""
    first = at(("BC1", 0.5, 0.5), ("A", 1.0, 0.0), end=(2.0, 0.0)).named({"start": "EP0"})
    drawn = plot_diagram(first)
    second = plot_diagram(at(("BC1", 0.5, 0.5), ("FF2", 1.0, 0.0), end=(2.0, 0.0)), drawn.ax)
    assert explained(drawn.ax) == ["border collision", "end point", "border-collision fold-flip"]
    assert written(second) == ["FF2"]
    assert written(drawn) == ["start", "BC1", "A"]
    assert not any(
        one.overlaps(other) for one, other in combinations([*boxes_of(drawn), *boxes_of(second)], 2)
    )


def test_no_white_line_parts_hatched_strips() -> None:
    """Each hatched area lies on one of its colour with an edge, which reaches into the next."""
    map_ = PiecewiseLinearMap([("x/2 + m", "x < 0"), ("b*x + m - 1", "x >= 0")])
    plane = parameter_plane(map_, "m", "b", (1, 2), (-1, "-1/4"), orders=(1, 2))
    areas = plot_plane(plane, samples=20).ax.collections
    hatched = [k for k, area in enumerate(areas) if area.get_hatch()]
    assert hatched
    for under in (areas[k - 1] for k in hatched):
        assert not under.get_hatch()
        assert under.get_linewidth() == [0.3]
        assert under.get_edgecolor().tolist() == under.get_facecolor().tolist()
