"""Pictures of the long run: what is drawn, read back from the axes."""

import numpy as np
import pytest
from legends import explained
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.patches import Rectangle, StepPatch
from sympy import Rational, Symbol

from pwmap import PiecewiseLinearMap, PointKind, attractor_diagram, bifurcation_diagram, dynamics
from pwmap.longrun import AttractorCell, AttractorDiagram
from pwmap.longrun.line import line_of
from pwmap.plot import (
    plot_attractors,
    plot_density,
    plot_entropy,
    plot_kneading,
    plot_long_run,
)

TENT = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
PAPER = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))")


# --- Over a parameter -----------------------------------------------------------------------------


@pytest.mark.slow
def test_bands_lie_below_branches_and_crises_are_named_where_they_are() -> None:
    """Two bands of the tent map merge at its fixed point, and are lost at 0."""
    found = attractor_diagram(TENT, "a", ("5/4", "9/4"), 2)
    diagram = bifurcation_diagram(TENT, "a", ("5/4", "9/4"), (1, 2))
    ax = plot_long_run(diagram, found, TENT, steps=20).ax
    areas = [each for each in ax.collections if isinstance(each, PolyCollection)]
    assert len(areas) == 3
    assert max(area.get_zorder() for area in areas) < min(line.get_zorder() for line in ax.lines)
    ends = np.concatenate([area.get_paths()[0].vertices for area in areas])
    for a in (2**0.5, 2.0):  # [a - a^2/2, a/2], by straight lines through places 0.05 apart
        x = ends[np.isclose(ends[:, 0], a), 1]
        assert np.allclose([x.min(), x.max()], [a * (1 - a / 2), a / 2], atol=4e-3)
    marks = [each for each in ax.collections if isinstance(each, PathCollection)]
    places = np.concatenate([np.asarray(each.get_offsets()) for each in marks])
    root = 2**0.5
    assert np.allclose(sorted(places.tolist()), [[root, root / (1 + root)], [2.0, 0.0]])
    (above,) = ax.child_axes
    names = above.get_xticklabels()  # type: ignore[attr-defined]
    assert [name.get_text() for name in names] == [r"MC $\sqrt{2}$", "FC $2$"]
    assert explained(ax) == [
        "unstable", "bands", "merging crisis (MC)", "final crisis (FC)",
        "period 1", "period 2",
    ]  # fmt: skip
    assert ax.get_xlim() == (1.25, 2.25)
    title = ax.set_title("the tent map")
    ax.figure.draw_without_rendering()  # type: ignore[union-attr]
    extents = [name.get_window_extent() for name in names]
    assert min(each.y0 for each in extents) > ax.bbox.y1  # above the axes: they cover no marker
    assert title.get_window_extent().y0 > max(each.y1 for each in extents)


def test_special_points_beyond_all_attractors_are_on_the_axes() -> None:
    """p/4 attracts, the repelling p begins at the break 1 (before: axes from 1/8 to 3/8)."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((x/2 + p/8, x < 1), (2*x - p, True))")
    span = ("1/2", "3/2")
    found, diagram = attractor_diagram(map_, "p", span, 1), bifurcation_diagram(map_, "p", span)
    low, high = plot_long_run(diagram, found, map_, steps=4).ax.get_ylim()
    assert low < 1 / 8
    assert high > max(point.x for point in diagram.points if point.kind is PointKind.BC) == 1


def test_a_pole_does_not_stretch_the_axes() -> None:
    """-1/(1 - p) attracts for -1 < p < 1, up to 106707/106708 and in an open cell beyond (before:
    axes down to -2e6); a quarter of 1 - p = 2 and less is too far away. At 3/2, 2 repels."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((p*x - 1, True))")
    span = ("-3/2", "3/2")
    found, diagram = attractor_diagram(map_, "p", span), bifurcation_diagram(map_, "p", span, (1,))
    low, high = plot_attractors(found, map_, steps=12).ax.get_ylim()
    assert (low, high) == pytest.approx((-2 - 0.18, -0.5 + 0.18), abs=0.4)
    low, high = plot_long_run(diagram, found, map_, steps=60).ax.get_ylim()
    assert -4 < low < -2
    assert 2 < high < 12


def test_long_cycles_are_drawn_where_they_are() -> None:
    """L R^3 of P1^L from 250/41 to 10: its points are those of the exact cycle."""
    map_ = PAPER.at({"a": "5/4"})
    ax = plot_attractors(attractor_diagram(map_, "r", (7, 9), 1), map_, steps=6).ax
    points = [np.asarray(line.get_ydata(), dtype=float) for line in ax.lines]
    assert len(points) == 4
    for x, exact in zip(np.transpose([(p[0], p[-1]) for p in points]), (7, 9), strict=True):
        (cycle,) = dynamics(map_, {"r": exact}).attractors
        assert np.allclose(x, sorted(map(float, cycle.points)))
    assert explained(ax) == ["period 4"]


@pytest.mark.nightly
def test_attractors_side_by_side_have_shades_of_their_own() -> None:
    """Two tent maps, on [-1, 0] and on [0, 1]: each has its bands."""
    two = PiecewiseLinearMap.from_sympy(
        "Piecewise((-1 + a*(x + 1), x <= -1/2), (-1 - a*x, x < 0), (a*x, x <= 1/2), "
        "(a*(1 - x), True))"
    )
    drawn = plot_attractors(attractor_diagram(two, "a", ("3/2", "7/4"), 1), two, steps=6)
    areas = {name: artists[0] for name, artists in drawn.artists.items()}
    assert list(areas) == ["bands", "bands of a second attractor"]
    shades = {tuple(area.get_facecolor()[0]) for area in areas.values()}  # type: ignore[attr-defined]
    assert len(shades) == 2


def test_neutral_intervals_are_hatched_where_they_are() -> None:
    """c - x turns (c - 2, 2) for 1 < c < 4, where 3 x - 9 + c beyond 2 comes back to it."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((c - x, x < 2), (6 + c - 3*x, True))")
    ax = plot_attractors(attractor_diagram(map_, "c", ("5/2", "7/2"), 1), map_, steps=6).ax
    (area,) = [each for each in ax.collections if isinstance(each, PolyCollection)]
    ends = area.get_paths()[0].vertices
    for c in (2.5, 3.5):
        x = ends[np.isclose(ends[:, 0], c), 1]
        assert np.allclose([x.min(), x.max()], [c - 2, 2.0])
    assert explained(ax) == ["neutral intervals"]


def test_neutral_intervals_without_end_leave_the_axes_to_the_branches() -> None:
    """Of p - x all points have the period 2 (before: axes from -1120 to 1120, p/2 a flat line)."""
    map_, span = PiecewiseLinearMap.from_sympy("p - x"), (-1, 1)
    drawn = plot_long_run(
        bifurcation_diagram(map_, "p", span), attractor_diagram(map_, "p", span), map_, steps=6
    )
    low, high = drawn.ax.get_ylim()
    assert -0.6 < low < -0.5
    assert 0.5 < high < 0.6
    # those of x end at 0, those of p - x at 0 and p (before: cut off at -1000 and 1000)
    large = PiecewiseLinearMap.from_sympy("Piecewise((x, x <= 0), (p - x, True))")
    span = (-(10**6), 10**6)
    ax = plot_attractors(attractor_diagram(large, "p", span), large, steps=6).ax
    low, high = ax.get_ylim()
    assert (low, high) == pytest.approx((-0.12e6, 1.12e6))
    ends = [area.get_paths()[0].vertices[:, 1] for area in ax.collections]
    assert min(x.min() for x in ends) < low - 1e6
    assert max(x.max() for x in ends) == 1e6
    assert all(np.isfinite(x).all() for x in ends)


@pytest.mark.parametrize(("shift", "strips"), [(Rational(0), 1), (Rational(1, 10**5), 0)])
def test_places_at_which_attractors_are_open_are_grey(shift: Rational, strips: int) -> None:
    """At -9/7 a side of a break attracts; a place close to it, where a cycle does, stands for it.

    One of twelve places is there, or a hundredth of their distance beside it. The others are
    rationals within an eighth of their distance, so that a strip is as wide but for a quarter.
    """
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x/2 + m + 1, x < -1), (m - 2*x, x < 1), (x/2 + m - 1, True))"
    )
    middle, m = Rational(-9, 7) + shift, Symbol("m")
    ends = middle - Rational(6, 1000), middle + Rational(7, 1000)
    cell = AttractorCell(*ends, middle, line_of(map_, {"m": middle}), is_open=True)
    found = AttractorDiagram(map=map_, parameter=m, order=1, cells=(cell,), crises=())
    drawn = plot_attractors(found, map_, steps=12)
    shown = [each for each in drawn.artists.get("not known", []) if isinstance(each, Rectangle)]
    assert len(shown) == strips
    for strip in shown:
        assert abs(strip.get_x() + 0.5 * strip.get_width() + 9 / 7) < 0.001 / 8
        assert abs(strip.get_width() - 0.001) < 0.001 / 4


@pytest.mark.nightly
def test_the_entropy_of_the_tent_map_is_drawn_between_its_bounds() -> None:
    ax = plot_entropy(TENT, "a", ("3/2", 2), steps=5).ax
    for line in ax.lines:
        over, values = (np.asarray(data, dtype=float) for data in line.get_data())
        assert np.allclose(over, [1.55, 1.65, 1.75, 1.85, 1.95])
        assert np.allclose(values, np.log(over), atol=1e-3)  # graphs of laps to order 24
    assert explained(ax)[0].startswith("between bounds, at most ")


@pytest.mark.slow
def test_an_entropy_of_zero_is_not_drawn_on_the_frame() -> None:
    bottom, top = plot_entropy(TENT, "a", ("1/2", 2), steps=3, orders=(4,)).ax.get_ylim()
    assert -0.1 * top < bottom < -0.01 * top


# --- At one place ---------------------------------------------------------------------------------


def letters(ax: Axes, row: int) -> str:
    texts = [text for text in ax.texts if text.get_position()[1] == row]
    return "".join(text.get_text() for text in texts if text.get_text() in {"L", "R", "…"})


def frames(ax: Axes) -> list[tuple[float, float]]:
    """Where the letters that come again begin, and how many they are."""
    shown = [p for p in ax.patches if isinstance(p, Rectangle) and not p.get_fill()]
    return [(p.get_x(), p.get_width()) for p in shown]


def test_a_kneading_table_frames_what_comes_again() -> None:
    """Of the break: 0 -> 1 -> -1/2 -> 0 at a = 2, b = -3/2."""
    ax = plot_kneading(dynamics(SKEW, {"a": 2, "b": "-3/2"}), steps=8).ax
    assert [letters(ax, 0), letters(ax, 1)] == ["LRLRRLRR", "RRLRRLRR"]
    assert frames(ax) == [(1, 3), (0, 3)]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["$0^-$", "$0^+$"]
    fates = [text.get_text() for text in ax.texts][8::9]
    assert fates == ["periodic after a while, period 3"] * 2


def test_a_kneading_table_ends_where_a_cycle_draws_in() -> None:
    ax = plot_kneading(dynamics(PAPER, {"a": "5/4", "r": 3}), steps=12).ax
    assert [letters(ax, 0), letters(ax, 1)] == ["LRRRRRRRRLRR", "R…"]
    assert frames(ax) == [(1, 9)]


def test_a_kneading_table_has_the_letters_of_single_points() -> None:
    """Left of 0 all points go to 0, which is a piece for itself."""
    text = "Piecewise((0, x < 0), (0, x <= 0), (2*x, True))"
    drawn = plot_kneading(dynamics(PiecewiseLinearMap.from_sympy(text)), steps=4)
    assert {name: len(drawn.artists[name]) for name in "LMR"} == {"L": 1, "M": 3, "R": 4}


def test_a_frame_is_cut_with_the_table() -> None:
    ax = plot_kneading(dynamics(PAPER, {"a": "5/4", "r": 3}), steps=4).ax
    assert frames(ax) == [(1, 3)]
    assert letters(ax, 0) == "LRRR"
    with pytest.raises(ValueError, match="expected a map with breaks, this one has none"):
        plot_kneading(dynamics(PiecewiseLinearMap.from_sympy("x/2 + 1")))


def test_a_density_is_drawn_over_a_histogram() -> None:
    ax = plot_density(dynamics(SKEW, {"a": 2, "b": "-3/2"}), points=20_000).ax
    (steps,) = (patch for patch in ax.patches if isinstance(patch, StepPatch))
    values, edges, _ = steps.get_data()
    assert np.asarray(values).tolist() == [0.5, 0.75]
    assert np.asarray(edges).tolist() == [-0.5, 0.0, 1.0]
    bars = [p for p in ax.patches if isinstance(p, Rectangle)]
    mass = sum(bar.get_width() * bar.get_height() for bar in bars)
    left = sum(bar.get_width() * bar.get_height() for bar in bars if bar.get_x() < -1e-9)
    assert abs(mass - 1.0) < 1e-12
    assert abs(left - 0.25) < 0.01  # 20 000 dependent points


@pytest.mark.parametrize("text", [
    "Piecewise((2*x - 10**8, x <= 10**8 + 1/2), (3*10**8 + 2 - 2*x, True))",  # from 1e8 to 1e8 + 1
    "Piecewise((2*x, x <= 1/(2*10**30)), (2/10**30 - 2*x, True))",  # from 0 to 1e-30
])  # fmt: skip
def test_the_histogram_is_even_where_bands_are_small_or_far_away(text: str) -> None:
    """The tent map is uniform: of 20 000 points in 120 bars, each has 1/120 up to five sigmas."""
    found = dynamics(PiecewiseLinearMap.from_sympy(text))
    bars = [p for p in plot_density(found, points=20_000).ax.patches if isinstance(p, Rectangle)]
    shares = np.array([bar.get_width() * bar.get_height() for bar in bars])
    assert len(shares) == 120
    assert abs(shares - 1 / 120).max() < 5 / np.sqrt(120 * 20_000)


@pytest.mark.slow
def test_samples_of_the_entropy_are_not_joined() -> None:
    drawn = plot_entropy(TENT, "a", ("5/4", "2"), steps=4, orders=(4,))
    assert [line.get_linestyle() for line in drawn.artists["bounds"]] == ["None", "None"]  # type: ignore[attr-defined]
