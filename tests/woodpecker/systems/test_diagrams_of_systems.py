"""Verbs that show all of a return map: diagrams, curves in two parameters, attractors, basins."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA

from pwmap import PointKind
from pwmap.diagrams.diagram import PointStatus
from studies.systems import rimless_wheel, table
from studies.systems.oscillator import ClosedForm, impacts
from woodpecker import Search, Settings
from woodpecker.base.progress import Stage
from woodpecker.engine.curves import Stop
from woodpecker.examples import bouncing_ball
from woodpecker.plot.orbits import plot_orbits
from woodpecker.systems import (
    Contact,
    ContactSystem,
    Section,
    SystemMap,
    basins,
    bifurcation_diagram,
    continuation,
    curve_in_two,
    orbit_diagram,
    shoot,
    simulate,
)
from woodpecker.systems.simulation.motion import Run
from woodpecker.systems.simulation.paths import SystemPiece

pytestmark = NEEDS_HEYOKA


@pytest.mark.slow
def test_all_branches_of_the_wheel_are_its_walk() -> None:
    """Slices find it without a guess, where no foot slips."""
    found = bifurcation_diagram(
        rimless_wheel.map_of("gamma"), (0.1, 0.2), (1,), (0.35, 0.7), search=Search(slices=2)
    )
    (walk,) = found.branches
    values = rimless_wheel.VALUES[rimless_wheel.ALPHA], rimless_wheel.VALUES[rimless_wheel.J]
    exact = [rimless_wheel.walking(gamma, *values)[0] for gamma in walk.parameter]
    assert walk.x == pytest.approx(exact, abs=1e-10)
    assert (found.parameter_name, found.x_name) == ("gamma", "omega")


@pytest.mark.slow
def test_the_verbs_tell_their_progress() -> None:
    """One branch of the wheel; Ctrl-C after it keeps it."""
    map_, told, heard = rimless_wheel.map_of("gamma"), list[Stage](), list[bool]()

    def stop(stage: Stage) -> None:
        told.append(stage)
        if stage.branches:
            raise KeyboardInterrupt

    found = continuation(
        map_, shoot(map_, [0.4]), (0.09, 0.11), [(0, 2)], orders=(1,), progress=stop,
        on_interrupt=lambda: heard.append(True),
    ).diagram  # fmt: skip
    assert [stage.branches for stage in told] == [0, 1]
    assert (len(found.branches), len(heard)) == (1, 1)
    told.clear()
    few, span, window = Search(slices=2), (0.09, 0.11), (0.35, 0.5)
    bifurcation_diagram(map_, span, (1,), window, search=few, progress=told.append)
    assert told[-1].branches == 1


@pytest.mark.slow
def test_returns_are_counted_and_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """By search and along a path alike, of the wheel from step to step; a branch may take 3/5."""
    made, map_ = list[object](), rimless_wheel.map_of("gamma")

    def noting(own: Callable[..., object]) -> Callable[..., object]:
        return lambda *given: (made.append(own), own(*given))[1]

    monkeypatch.setattr(Run, "follow", noting(Run.follow))
    monkeypatch.setattr(SystemPiece, "at", noting(SystemPiece.at))
    cycle, window, span = shoot(map_, [0.4]), [(0.0, 2.0)], (0.09, 0.11)
    assert map_.evaluations == len(made) > 0
    whole, spent = continuation(map_, cycle, span, window, orders=(1,)), map_.evaluations
    assert whole.diagram.about.get("left") is None
    found = continuation(map_, cycle, span, window, orders=(1,), max_evaluations=100)
    assert 120 <= map_.evaluations - spent < 160  # each way, and one step more
    assert map_.evaluations == len(made)
    notes = {(point.note, point.status) for point in found.diagram.points}
    assert notes == {(Stop.SPENT.value, PointStatus.OPEN)}
    few = Settings(max_evaluations=100)
    lost = bifurcation_diagram(map_, span, (1,), (0.35, 0.5), settings=few)
    assert lost.about["left"].startswith("given up after 100 evaluations, as many as allowed")


@pytest.mark.slow
def test_curve_of_folds_is_that_of_the_closed_form() -> None:
    """Over amplitude and frequency of the force, for a preloaded stop."""
    exact = ClosedForm(2.8, 0.8, -0.5, 0.05)
    force, v = exact.fold()
    map_ = impacts("F", "w").holding(sigma=-0.5)
    orbit = exact.orbit(1.2 * v)
    cycle = shoot(map_, [orbit.v, orbit.t], p=[exact.force(orbit.v), exact.w])
    window = [(-5.0, 0.0), (0.0, 3.0)]
    found = continuation(map_, cycle, (0.9 * force, 2.2 * force), window, orders=(1,), max_step=0.5)
    (fold,) = (q for q in found.diagram.points if q.kind is PointKind.LP)
    spans = (0.5 * force, 2.0 * force), (2.5, 3.1)
    curve = curve_in_two(map_, found, fold.id, spans, window, max_step=0.2)
    assert np.ptp(curve.p[:, 1]) > 0.3
    assert len(curve.p) > 5
    for force_there, w in curve.p:
        there = ClosedForm(w, exact.eps, exact.sigma, exact.zeta).fold()[0]
        assert force_there == pytest.approx(there, abs=1e-9)


def test_orbits_settle_on_the_bounce_in_closed_form() -> None:
    """Between fold and flip the ball bounces once in each period of the table."""
    map_ = table.map_of("Gamma")
    low, high = table.limits(0.5)
    exact = table.orbit(0.5 * (low + high), 0.5)
    window = [(0.0, 10.0), (np.pi, 3.0 * np.pi)]
    found = orbit_diagram(
        map_, [0.5 * (low + high)], [exact + 0.01], window, transient=60, keep=4
    )  # fmt: skip
    assert found.lost == 0
    assert found.period.tolist() == [1]
    assert found.x[0] == pytest.approx(np.tile(exact, (4, 1)), abs=1e-9)
    lost = orbit_diagram(map_, [low], [[20.0, 4.0]], window, transient=1, keep=1)
    assert (lost.lost, lost.x.shape) == (1, (0, 1, 2))
    assert repr(found).startswith("SettledReturns(2 coordinates, 1 orbit, Gamma from ")
    assert repr(found).endswith(", period 1, 0 lost)")
    phases = found.coordinate(1)
    assert phases.points()[1] == pytest.approx(exact[1], abs=1e-9)
    drawn = plot_orbits(phases)
    assert [*drawn.artists] == ["period 1"]
    name = map_.section.free[1]
    assert (drawn.ax.get_xlabel(), drawn.ax.get_ylabel()) == (r"$\Gamma$", f"${sympy.latex(name)}$")
    with pytest.raises(ValueError, match="k must name one of 2 coordinates, from 0 on, got 2"):
        found.coordinate(2)


def particle_of_two_wells(unit: Any = 1) -> SystemMap:
    """A damped particle in the wells at 1 and -1, once in each second; at rest in either."""
    x, v, t = sympy.symbols("x u_x t")
    wall = Contact(name="wall", gap=3 * unit - x, eps_n=0.5)
    system = ContactSystem([x], [[1]], [x - x**3 / unit**2 - v], [wall], {})
    return SystemMap(system, Section(when=sympy.sin(2 * sympy.pi * t), free=[x, v]))


@pytest.mark.slow
def test_basins_of_two_wells_are_mirror_images() -> None:
    """But for the wall, which is not reached; the ridge between them belongs to none."""
    map_ = particle_of_two_wells()
    wells = [shoot(map_, [each, 0.0]) for each in (1.1, -1.1)]
    for well, side in zip(wells, (1, -1), strict=True):
        assert well.x[0] == pytest.approx([side, 0.0], abs=1e-9)
    rng = np.random.default_rng(5)
    points = rng.uniform(-1.0, 1.0, (8, 2))
    there, mirrored = (basins(map_, wells, sign * points) for sign in (1.0, -1.0))
    assert (there + mirrored == 1).all()
    assert set(there.tolist()) == {0, 1}
    assert basins(map_, wells, [[0.0, 0.0]]).tolist() == [-1]


@pytest.mark.parametrize(("returns", "found"), [(1, -1), (2, 0)])
def test_an_orbit_returns_as_often_as_is_said(returns: int, found: int) -> None:
    """Each impact halves the speed of a ball: two of them lead from 1 to 1/4."""
    map_ = SystemMap(bouncing_ball(), Section(when="floor", free=["u_y"]), backend="scipy")
    quarter = replace(shoot(map_, [1.0]), x=np.array([[0.25]]))
    assert basins(map_, [quarter], [1.0], returns=returns).tolist() == [found]


def test_a_cycle_knows_its_time() -> None:
    """An elastic ball is up for 2 v/g; on a table it returns one period of this later."""
    y, g = sympy.symbols("y g")
    floor = Contact(name="floor", gap=y, eps_n=1)
    ball = ContactSystem([y], [[1]], [-g], [floor], {g: 10.0})
    map_ = SystemMap(ball, Section(when="floor", free=["u_y"]), backend="scipy")
    for order in (1, 2):
        assert shoot(map_, [3.0], order=order).period == pytest.approx(0.6 * order, rel=1e-12)
    on_table = table.map_of("Gamma")
    gamma = 0.5 * sum(table.limits(0.5))
    cycle = shoot(on_table, table.orbit(gamma, 0.5), p=[gamma])
    assert cycle.period == pytest.approx(2.0 * np.pi, rel=1e-12)
    assert np.isnan(shoot(map_, [-3.0]).period)  # the ball is below the floor at once


def test_bounces_that_accumulate_after_the_end_are_not_summed() -> None:
    """A ball that would rest after 3 s is followed for 2.1 s."""
    motion = simulate(bouncing_ball(), {"y": 5.0}, 2.1, backend="scipy")
    assert motion.word == "I1 I1"
    assert motion.t[-1] == pytest.approx(2.1, abs=1e-12)


# --- Units ----------------------------------------------------------------------------------------


def before_a_stop(length: float, mass: float, time: float, **options: Any) -> SystemMap:
    """A pushed mass before a stop, in other units."""
    x, v, t, w, push, damping, stiff, place, inertia = sympy.symbols("x u_x t w F c k a m")
    values = {
        w: 2.8 / time, push: 8 * mass * length / time**2, damping: 0.1 * mass / time,
        stiff: mass / time**2, place: length, inertia: mass,
    }  # fmt: skip
    force = push * sympy.cos(w * t) - stiff * x - damping * v
    stop = Contact(name="stop", gap=place - x, eps_n=0.8)
    system = ContactSystem([x], [[inertia]], [force], [stop], values)
    return SystemMap(system, Section(when=sympy.sin(w * t), free=[x, v], at={t: 0}), **options)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("length", "mass", "time"), [(1e-3, 1e3, 1e-3), (1e-6, 1e-9, 1e-3), (1e9, 1.0, 1.0)]
)
def test_a_cycle_does_not_depend_on_units(length: float, mass: float, time: float) -> None:
    """With scales of 1: the same numbers of them."""
    found = []
    for a, m, s in ((1.0, 1.0, 1.0), (length, mass, time)):
        units = np.array([a, a / s])
        cycle = shoot(before_a_stop(a, m, s, backend="scipy"), np.array([-0.8, 2.0]) * units)
        assert cycle.success
        found.append(cycle.x / units)
    assert found[1] == pytest.approx(found[0], rel=2e-13)


@pytest.mark.slow
def test_a_branch_does_not_depend_on_units() -> None:
    """In m and s, and in numbers of km and h: steps are parts of span and window."""
    found = []
    for a, s in ((1.0, 1.0), (1e-3, 1.0 / 3600.0)):
        map_ = before_a_stop(a, 1.0, s, parameters=["F"])
        cycle = shoot(map_, [-0.8 * a, 2.0 * a / s])
        span, window = (4.0 * a / s**2, 10.0 * a / s**2), [(-8 * a, a), (-9 * a / s, 9 * a / s)]
        diagram = continuation(map_, cycle, span, window, orders=(1,)).diagram
        (graze,) = [point for point in diagram.points if point.kind is PointKind.BC]
        assert graze.parameter == pytest.approx(np.hypot(6.84, 0.28) * a / s**2, rel=1e-12)
        found.append([len(branch.parameter) for branch in diagram.branches])
    assert found[0] == found[1]


@pytest.mark.slow
@pytest.mark.parametrize(("length", "mass", "time"), [(1.0, 1.0, 1.0), (1e-6, 1e-12, 1e-6)])
def test_a_curve_of_folds_does_not_depend_on_units(length: float, mass: float, time: float) -> None:
    """A tip that taps a surface, of 1e-12 kg and some 1e5 Hz: folds of the closed form.

    Forces are some 1e-7 N, which differences for derivatives exceeded; and that a frequency of
    1e6 is held fixed made continuation in the force take ten times as many steps.
    """
    w = 1.2
    map_ = before_a_stop(length, mass, time, parameters=["F", "w"]).holding(w=w / time)
    exact = ClosedForm(w, 0.8, 1.0, 0.05)
    force, v = exact.fold()
    unit = mass * length / time**2
    orbit = exact.orbit(1.2 * v)
    plain = before_a_stop(1.0, 1.0, 1.0).system.replace(w=w, F=exact.force(orbit.v))
    leaves = {"x": 1.0, "u_x": orbit.v, "t": orbit.t}
    start = simulate(plain, leaves, 2 * np.pi / w).z[:2] * (length, length / time)
    cycle = shoot(map_, start, p=[exact.force(orbit.v) * unit, w / time])
    window = [(-6 * length, length), (-8 * length / time, 8 * length / time)]
    found = continuation(map_, cycle, (0.9 * force * unit, 2 * force * unit), window, orders=(1,))
    assert sum(len(branch.parameter) for branch in found.diagram.branches) < 120
    (fold,) = (q for q in found.diagram.points if q.kind is PointKind.LP)
    spans = (0.5 * force * unit, 2 * force * unit), (1.1 / time, 1.3 / time)
    curve = curve_in_two(map_, found, fold.id, spans, window)
    assert np.ptp(curve.p[:, 1]) == pytest.approx(0.2 / time, rel=1e-12)
    for force_there, w_there in curve.p:
        there = ClosedForm(w_there * time, exact.eps, exact.sigma, exact.zeta).fold()[0]
        assert force_there == pytest.approx(there * unit, rel=1e-9)


@pytest.mark.parametrize(("length", "mass", "time"), [(1e-9, 1e-6, 1.0), (1e-6, 1e-12, 1e-3)])
def test_margins_do_not_depend_on_units(length: float, mass: float, time: float) -> None:
    """A nanometre of stick and slip, with forces of 1e-15 N: each of them counted as zero."""
    x, v, y, t, w = sympy.symbols("x u_x y t w")
    stiff, damping, inertia, load, speed, push = sympy.symbols("k c m N V F")
    found = []
    for a, m, s in ((1.0, 1.0, 1.0), (length, mass, time)):
        force = m * a / s**2
        values = {
            stiff: m / s**2, damping: 0.05 * m / s, inertia: m, load: 3 * force, speed: 0.3 * a / s,
            push: 0.3 * force, w: 0.7 / s,
        }  # fmt: skip
        belt = Contact(name="belt", gap=y, slip=v - speed, mu=0.4)
        pulls = [push * sympy.cos(w * t) - stiff * x - damping * v, -load]
        system = ContactSystem([x, y], sympy.diag(inertia, inertia), pulls, [belt], values)
        section = Section(when=sympy.sin(w * t), free=[x, v], at={t: 0}, horizon=1e4 * s)
        map_ = SystemMap(system, section, ["F"], backend="scipy")
        image = map_.at(np.array([0.1 * a, 0.2 * a / s]), map_.p)
        to, along = np.array([a, a / s]), np.array([a, a / s, force])
        found.append((image.piece.word, [*image.codes], image.jacobian * along / to[:, None]))
    assert found[1][:2] == found[0][:2]
    assert found[0][0] == "J1 S1 J1"
    # with an absolute error of 1e-16 DOP853 has nine digits of a nanometre
    assert found[1][2] == pytest.approx(found[0][2], abs=1e-6)


def test_a_start_near_a_well_is_not_at_it_by_units() -> None:
    """Wells a millimetre apart: within 1e-3 of one lie all starts, if lengths of 1 m count."""
    map_ = particle_of_two_wells(sympy.Rational(1, 1000))
    wells = [shoot(map_, [each, 0.0]) for each in (1.1e-3, -1.1e-3)]
    assert basins(map_, wells, [[5e-4, 0.0], [-5e-4, 0.0]]).tolist() == [0, 1]
