"""Pictures of systems with contacts: what is drawn, read back from the axes."""

import numpy as np
import pytest
import sympy
from legends import explained
from matplotlib.collections import QuadMesh

from pwmap.plot.drawn import Drawn
from woodpecker.examples import bouncing_ball
from woodpecker.plot.systems import (
    plot_basins,
    plot_system_map,
    plot_system_motion,
    plot_system_portrait,
)
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, shoot, simulate

x, y, v, w, g, t = sympy.symbols("x y u_x u_y g t")
BALL = bouncing_ball()


@pytest.mark.nightly
def test_time_history_marks_impacts() -> None:
    """The first after 1 s; the second, with half the speed, 1 s later."""
    motion = simulate(BALL, {"y": 5.0}, 2.1, backend="scipy")
    drawn = plot_system_motion(BALL, motion, ["y", w])
    assert [ax.get_ylabel() for ax in drawn.axes] == ["$y$", "$u_{y}$"]
    for ax_marks in drawn.artists["impact"]:
        assert ax_marks.get_xdata() == pytest.approx([1.0, 2.0], abs=1e-9)  # type: ignore[attr-defined]
    height = drawn.artists["motion"][0].get_ydata()  # type: ignore[attr-defined]
    assert (height.min(), height.max()) == pytest.approx((0.0, 5.0), abs=1e-9)


def test_portrait_dots_the_jump_of_the_speed() -> None:
    motion = simulate(BALL, {"y": 5.0}, 1.5, backend="scipy")
    drawn = plot_system_portrait(BALL, motion, "y", "u_y")
    (stroke,) = drawn.artists["impact"]
    assert stroke.get_ydata()[:2] == pytest.approx([-10.0, 5.0], abs=1e-9)  # type: ignore[attr-defined]
    assert np.isnan(drawn.artists["motion"][0].get_ydata()).sum() >= 1  # type: ignore[attr-defined]


def test_short_flights_are_drawn_as_curves() -> None:
    """Of few samples: a chord over 1/8 of a flight's speeds misses 1/64 of its energy."""
    motion = simulate(BALL, {"y": 5.0}, 5.0, samples=2, backend="scipy")
    line = plot_system_portrait(BALL, motion, "y", "u_y").artists["motion"][0]
    points = np.column_stack(line.get_data())  # type: ignore[attr-defined]
    height, speed = points.T
    energy, middle = 10 * height + speed**2 / 2, 0.5 * (points[1:] + points[:-1])
    missed = energy[1:] - 10 * middle[:, 0] - middle[:, 1] ** 2 / 2
    # flights of 2**-10 of the longest are summed, with less than 50 J/kg/2**20
    assert np.nanmax(missed - energy[1:] / 63) < 50 / 2**20


def test_stick_and_slip_are_told_apart() -> None:
    belt = Contact(name="belt", gap=y, slip=v - 0.5, mu=0.3)
    brick = ContactSystem([x, y], [[1, 0], [0, 1]], [-x, -10], [belt], {})
    drawn = plot_system_motion(brick, simulate(brick, {"x": 5.0}, 8.0, backend="scipy"), ["x"])
    assert explained(drawn.ax) == ["sticks", "slips"]


@pytest.mark.slow
def test_return_map_of_a_ball_halves_the_speed() -> None:
    map_ = SystemMap(BALL, Section(when="floor", free=[w]), backend="scipy")
    drawn = plot_system_map(map_, np.linspace(1.0, 3.0, 5))
    (line,) = drawn.artists["$P_{1}$"]
    assert line.get_ydata() == pytest.approx(0.5 * line.get_xdata(), abs=1e-9)  # type: ignore[attr-defined]


def basins_of_two_wells(unit: float, x_end: float, u_end: float) -> Drawn:
    """Wells at (+-1, 0) in such a unit, over four points."""
    wall = Contact(name="wall", gap=3 * unit - x, eps_n=0.5)
    system = ContactSystem([x], [[1]], [x - x**3 / unit**2 - 2 * v], [wall], {})
    map_ = SystemMap(system, Section(when=sympy.sin(t), free=[x, v]), backend="scipy")
    wells = [shoot(map_, [each * unit, 0.0]) for each in (1.1, -1.1)]
    plane = {"x": (-x_end * unit, x_end * unit), "u_x": (-u_end * unit, u_end * unit)}
    return plot_basins(map_, wells, plane, points=2)


@pytest.mark.slow
def test_basins_have_the_colours_of_their_cycles() -> None:
    drawn = basins_of_two_wells(1.0, 1.0, 0.1)
    (mesh,) = drawn.artists["basins"]
    assert isinstance(mesh, QuadMesh)
    assert np.asarray(mesh.get_array()).tolist() == [[1, 0], [1, 0]]


@pytest.mark.slow
@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_numbers_of_small_machines_are_those_of_large_ones(unit: float) -> None:
    """A machine in metres has wells at (+-1, 0), one in micrometres has them at 1e-6 times that."""
    drawn = basins_of_two_wells(unit, 2.0, 1.0)
    numbers = ("1", "-1") if unit == 1.0 else (rf"${k} \times 10^{{-6}}$" for k in (1, -1))
    assert explained(drawn.ax) == [f"({each}, 0)" for each in numbers]
    drawn.figure.draw_without_rendering()  # type: ignore[union-attr]
    factor = drawn.ax.yaxis.get_offset_text().get_text()
    assert ("10^{" in factor) is (unit < 1.0)


def test_wrong_names_are_refused() -> None:
    motion = simulate(BALL, {"y": 5.0}, 0.5, backend="scipy")
    with pytest.raises(
        ValueError, match=r"unknown coordinate 'z', the state has \['y', 'u_y', 't'\]"
    ):
        plot_system_motion(BALL, motion, ["z"])
    map_ = SystemMap(BALL, Section(when="floor", free=[w]), backend="scipy")
    with pytest.raises(ValueError, match="a plane has two coordinates, got 1"):
        plot_basins(map_, [], {"u_y": (0.0, 1.0)})
    section = Section(when=sympy.sin(t), free=[y, w])
    with pytest.raises(ValueError, match="one dimension can be drawn, got 2"):
        plot_system_map(SystemMap(BALL, section, backend="scipy"), [1.0, 2.0])
