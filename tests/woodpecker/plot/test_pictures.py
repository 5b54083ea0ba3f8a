"""Pictures of motions and return maps: what is drawn, read back from the axes."""

from itertools import pairwise

import numpy as np
import pytest
from legends import explained
from matplotlib.ticker import MaxNLocator
from needs import NEEDS_NUMBA, SLOW_TOY

from woodpecker import Toy, Trajectory, return_map, simulate
from woodpecker.plot.curve import MapSamples
from woodpecker.plot.figures import plot_curve, plot_return_map
from woodpecker.plot.motions import plot_phase_portrait, plot_phase_portraits, plot_time_history


@pytest.fixture(scope="module")
def motion() -> Trajectory:
    return simulate(Toy(), -0.52947197, 0.14597607, samples=201)


BEAK, LOWER, UPPER = (
    f"impact of the {name}" for name in ("beak", "lower edge", "upper edge")
)  # fmt: skip


def test_impacts_are_told_apart_by_contact_over_time(motion: Trajectory) -> None:
    drawn = plot_time_history(motion)
    assert [ax.get_ylabel() for ax in drawn.axes] == [
        "$y$ [m]", r"$\varphi_M$ [rad]", r"$\varphi_S$ [rad]",
    ]  # fmt: skip
    assert explained(drawn.ax) == [BEAK, LOWER, UPPER, "stops"]
    (beak, *_), (upper, *_) = drawn.artists[BEAK], drawn.artists[UPPER]
    assert beak.get_xdata() == pytest.approx([0.048221], abs=1e-6)
    assert upper.get_xdata() == pytest.approx([0.045120, 0.048801], abs=1e-6)
    assert len({artists[0].get_marker() for name, artists in drawn.artists.items()
                if name.startswith("impact")}) == 3  # fmt: skip
    assert drawn.artists["motion"][0].get_ydata()[-1] == pytest.approx(-0.0194454, abs=1e-6)
    assert [len(drawn.artists[name]) for name in ("motion", "stops", BEAK)] == [3, 3, 3]


def test_a_phase_portrait_has_a_direction_and_impacts(motion: Trajectory) -> None:
    drawn = plot_phase_portrait(motion, "phi_s", "dphi_s")
    assert explained(drawn.ax) == ["start", "direction of time", BEAK, LOWER, UPPER]
    (start,) = drawn.artists["start"]
    assert (start.get_xdata(), start.get_ydata()) == (pytest.approx([-0.52947197]), [0.0])
    (beak,) = drawn.artists[BEAK]
    event = motion.events[4]
    assert event.symbol == "I1"
    x, y = beak.get_xdata(), beak.get_ydata()
    assert x[:2] == pytest.approx([0.12, 0.12])
    assert y[:2].tolist() == [event.u_before[2], event.u_after[2]]
    assert len(drawn.artists[UPPER][0].get_xdata()) == 3 * 2  # two strokes, each with a gap
    assert len(drawn.artists["direction of time"]) == 3
    for arrow in drawn.artists["direction of time"]:  # along the motion: later at its head

        def time(place: tuple[float, float]) -> float:
            off = np.abs(motion.q[:, 2] - place[0]) + np.abs(motion.u[:, 2] - place[1])
            return float(motion.t[off.argmin()])

        assert time(arrow.xy) > time(arrow.xyann)


def test_three_portraits_share_one_legend(motion: Trajectory) -> None:
    drawn = plot_phase_portraits(motion, styles={BEAK: {"color": "black"}})
    (legend,) = drawn.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "start", "direction of time", BEAK, LOWER, UPPER,
    ]  # fmt: skip
    assert [line.get_color() for line in drawn.artists[BEAK]] == ["black"] * 3
    assert drawn.axes[2].get_ylabel() == r"$\dot y$ [m/s]"
    with pytest.raises(ValueError, match="got 'beak'"):
        plot_phase_portraits(motion, styles={"beak": {}})


def test_a_motion_without_impacts_has_a_legend_of_stops_only() -> None:
    swinging = simulate(Toy(), -0.22, 0.02, samples=11)
    assert explained(plot_time_history(swinging).ax) == ["stops"]
    assert explained(plot_phase_portrait(swinging, "phi_s", "dphi_s").ax) == [
        "start", "direction of time",
    ]  # fmt: skip


def test_numbers_of_an_axis_do_not_overlap() -> None:
    """Of a narrow range they are long, and the axes of a body at rest have one too."""
    drawn = plot_phase_portraits(simulate(Toy(), -0.22, 0.02, samples=11))
    drawn.figure.canvas.draw()
    for ax in drawn.axes:
        boxes = [text.get_window_extent() for text in ax.get_xticklabels() if ax.bbox.x0 - 1.0
                 <= ax.transData.transform((text.get_position()[0], 0.0))[0]
                 <= ax.bbox.x1 + 1.0]  # fmt: skip
        assert len(boxes) >= 2
        gaps = [right.x0 - left.x1 for left, right in pairwise(boxes)]
        assert min(gaps) > 0.0
    wide = plot_phase_portrait(simulate(Toy(), -0.52947197, 0.02, samples=11), "y", "dy")
    given = MaxNLocator(9)
    wide.ax.xaxis.set_major_locator(given)
    plot_phase_portrait(simulate(Toy(), -0.22, 0.02, samples=11), "y", "dy", wide.ax)
    assert wide.ax.xaxis.get_major_locator() is given  # the caller's choice


@NEEDS_NUMBA
def test_a_jump_is_seen_whole() -> None:
    """The jump at -0.7578 reaches from -0.983 down to -1.164, the least value of the map."""
    toy = Toy(eps_n1=0.125)
    drawn = plot_return_map(toy, return_map(toy, np.linspace(-1.2, -0.4, 400)))
    (jumps,) = drawn.artists["jump"]
    x, y = np.asarray(jumps.get_xdata()), np.asarray(jumps.get_ydata())
    k = int(np.nanargmin(np.abs(x + 0.7577872573)))
    ends = sorted(y[k - k % 3 :][:2].tolist())  # a stroke, and a gap
    assert ends == pytest.approx([-1.1643, -0.9827], abs=1e-3)
    low, high = drawn.ax.get_ylim()
    assert low < ends[0] - 0.01
    assert "goes on below" not in drawn.artists
    assert high > -0.75


@SLOW_TOY
def test_where_the_jammed_woodpecker_swings_all_points_are_fixed() -> None:
    """Down to -0.2386 it comes back as far as it started; the curve leaves the picture twice."""
    drawn = plot_return_map(Toy(), return_map(Toy(), np.linspace(-0.3, -0.15, 800)))
    (line,) = drawn.artists["all are fixed points"]
    assert np.asarray(line.get_xdata()) == pytest.approx([-0.2386, -0.2217], abs=4e-4)
    assert np.asarray(line.get_ydata()) == pytest.approx(np.asarray(line.get_xdata()))
    (marks,) = drawn.artists["goes on below"]
    assert marks.get_xdata() == pytest.approx([-0.2515, -0.1755], abs=4e-4)


def test_a_curve_without_points_far_from_zero_has_a_height() -> None:
    """A fixed margin was lost in rounding, and matplotlib warned of a height of zero."""
    starts, none = np.linspace(-1e300, -1e299, 3), np.full(3, np.nan)
    curve = MapSamples(
        x=starts, y=none, links=np.zeros(2, int), bottom=float(starts[0]), evaluations=0
    )
    low, high = plot_curve(curve).ax.get_ylim()
    assert low < starts[0] < high


@SLOW_TOY
def test_free_fall_and_what_lies_below_are_marked() -> None:
    drawn = plot_return_map(Toy(), return_map(Toy(), np.linspace(-2.5, 0.11, 2000)))
    (falls,) = drawn.artists["free fall"]
    box = falls.get_extents().transformed(drawn.ax.transData.inverted())
    assert (box.x0, box.x1) == pytest.approx((-0.103, 0.009), abs=4e-3)
    marks, flanks = drawn.artists["goes on below"]
    assert marks.get_xdata() == pytest.approx([-1.225, -0.266], abs=4e-3)
    assert flanks.get_xdata() == pytest.approx([-0.103, 0.009], abs=4e-3)  # beside free fall
    assert explained(drawn.ax) == [
        "diagonal", "$P_{1}$", "jump", "stable fixed point", "unstable fixed point",
        "all are fixed points", "free fall", "goes on below",
    ]  # fmt: skip
    (stable,) = drawn.artists["stable fixed point"]
    assert np.abs(np.asarray(stable.get_xdata()) + 0.52947197).min() < 1e-3
