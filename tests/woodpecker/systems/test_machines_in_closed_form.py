"""Machines with motions in closed form: points, multipliers, folds, flips and grazings."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA, NIGHTLY_SYSTEM, SLOW_SYSTEM
from scipy.optimize import brentq, fsolve

from pwmap import PointKind, PointStatus
from pwmap.diagrams.diagram import BranchKind
from studies.systems import rimless_wheel, rocking_block
from studies.systems.oscillator import (
    BASE,
    SIGMA,
    ClosedForm,
    T,
    V,
    W,
    X,
    difference,
    impacts,
    newton_fails,
    random_oscillator,
    special_orbits,
    strobed,
    system,
    through_grazing,
)
from studies.systems.rimless_wheel import ALPHA, MU, VALUES, J, walking
from studies.systems.rocking_block import Symmetric
from woodpecker.search.connected import Connected
from woodpecker.systems import (
    Contact,
    ContactSystem,
    Section,
    SystemMap,
    continuation,
    curve_in_two,
    return_map,
    shoot,
    simulate,
)

# Orbits are conditioned to some 1e3, and so are slopes at slow impacts; multipliers of half motions
# of a block grow like exp(pi/w), up to 5 here.
CLOSE = 1e-10
Pair = tuple[float, float]


@pytest.mark.nightly
@EACH_BACKEND
def test_folds_and_flips_are_those_of_the_closed_form(backend: str) -> None:
    rng, map_ = np.random.default_rng(3), impacts("F", backend=backend)
    kinds = set()
    for _ in range(8):
        exact = random_oscillator(rng)
        for kind, orbit in special_orbits(exact):
            kinds.add(kind)
            assert difference(map_, exact, orbit) < CLOSE
            if kind == "fold":  # the closed form is one: its own test function vanishes
                assert 1.0 - orbit.trace + orbit.det == pytest.approx(0.0, abs=1e-12)
    assert kinds == {"fold", "flip"}


@NIGHTLY_SYSTEM
@pytest.mark.parametrize(("eps", "w"), [(0.9, 2.6), (0.8, 2.6)])
def test_the_map_does_not_jump_at_a_grazing(eps: float, w: float) -> None:
    """The limit of the root is known to the root of rounding only: some 1e-7 are no jump."""
    map_ = strobed("F").holding(w=w, eps=eps, sigma=1.0, zeta=0.05)
    cycle = shoot(map_, [-0.8, 2.0], p=[6.6])
    found = continuation(map_, cycle, (4.5, 7.5), [(-8.0, 1.0), (-10.0, 10.0)], orders=(1,))
    assert sorted(branch.word for branch in found.diagram.branches) == ["", "I1"]
    (met,) = [point for point in found.diagram.points if point.kind is PointKind.BC]
    assert abs(met.parameter - np.hypot(1.0 - w**2, 0.1 * w)) < CLOSE  # amplitude 1: the gap


@SLOW_SYSTEM
@pytest.mark.parametrize(
    ("second", "guess", "p", "span", "spans"),
    [
        ("w", [-0.1, 0.0], [5.5, 2.6], (4.5, 7.5), [(2.0, 10.0), (2.0, 3.2)]),
        # from a branch that strikes, and ends there in a root
        ("eps", [-0.8, 2.0], [8.0, 0.8], (6.5, 8.5), [(6.5, 8.5), (0.3, 0.9)]),
    ],
)
def test_a_curve_of_grazings_begins_on_either_side(
    second: str, guess: list[float], p: list[float], span: Pair, spans: list[Pair]
) -> None:
    """Over force and frequency or restitution: where the free oscillation has the amplitude 1."""
    values = {"w": 2.8, "eps": 0.8, "sigma": 1.0, "zeta": 0.05}
    del values[second]
    map_ = strobed("F", second).holding(**values)
    cycle, window = shoot(map_, guess, p=p), [(-8.0, 1.0), (-10.0, 10.0)]
    found = continuation(map_, cycle, span, window, orders=(1,))
    words = [branch.word for branch in found.diagram.branches]
    assert words == (["I1", ""] if second == "eps" else ["", "I1"])
    (met,) = [point for point in found.diagram.points if point.kind is PointKind.BC]
    curve = curve_in_two(map_, found, met.id, spans, window, max_step=0.2)
    assert sorted(curve.p[[0, -1], 1]) == list(spans[1])
    w = curve.p[:, 1] if second == "w" else 2.8
    assert curve.p[:, 0] == pytest.approx(np.hypot(1.0 - w**2, 0.1 * w), abs=CLOSE)


@pytest.fixture(scope="module")
def grazing() -> tuple[Connected, float]:
    return through_grazing()


@SLOW_SYSTEM
def test_cycles_that_are_born_at_the_grazing_are_followed(grazing: tuple[Connected, float]) -> None:
    """One without impacts, and of those that strike: of order one on, of order two back.

    With A the derivative of the map, H of the distance from the border, and a kick v sqrt(-h), a
    cycle of order three would be at (1 - A^3)^-1 (A^2, 1, A) v sqrt(-h). There H is less at both
    other points than at the one that strikes: they would strike, too, so that there is none.
    """
    found, force = grazing
    (border,) = (q for q in found.diagram.points if q.kind is PointKind.BC)
    assert border.parameter == pytest.approx(force, abs=CLOSE)  # the amplitude is the gap
    assert "grazes" in border.cause
    struck = [b for b in found.diagram.branches if "I1" in b.word]
    assert {b.order for b in struck} == {1, 2}
    assert all(b.id in border.branches for b in struck)
    ahead = {b.order: bool(np.median(b.parameter) > force) for b in struck}
    assert ahead == {1: True, 2: False}


@NEEDS_HEYOKA
def test_the_slope_goes_like_the_inverse_root() -> None:
    """Nordmark: halving the distance four times over doubles the slope twice."""
    exact = ClosedForm(2.8, 0.8, 0.5, 0.05)
    map_, force = strobed("F"), BASE[SIGMA] / exact.gain
    cycle = shoot(map_, [-0.1, 0.0], p=[force * (1.0 - 1e-9)])
    distances = 4.0 ** -np.arange(8, 14)
    slopes = [
        np.linalg.norm(map_.at(cycle.x[0], np.array([force * (1.0 + d)])).jacobian[:, :2], 2)
        for d in distances
    ]
    order = np.polyfit(np.log(distances), np.log(slopes), 1)[0]
    assert order == pytest.approx(-0.5, abs=0.01)  # the next term is of order 1/2 in distance


@EACH_BACKEND
def test_rounding_of_the_gap_does_not_change_the_path(backend: str) -> None:
    """A start that leaves the stop, but for rounding, is that of the return right beside it."""
    map_, gap = strobed("F", backend=backend), BASE[SIGMA]
    images = [map_.at(np.array([gap + k * np.spacing(gap), -0.7]), map_.p) for k in range(-2, 3)]
    assert {image.piece.word for image in images} == {""}
    assert len({image.piece.key for image in images}) == 1
    assert np.ptp([image.value for image in images], axis=0) == pytest.approx(0.0, abs=1e-13)


@NEEDS_HEYOKA
def test_a_section_in_the_instant_of_an_impact_is_not_passed_over() -> None:
    """The impact comes once in two periods, at a phase in closed form: the section has it, too."""
    values = {"w": 3.9, "eps": 0.5, "sigma": 0.1, "zeta": 0.1}
    exact, theta = ClosedForm(**values, n=2), sympy.Symbol("theta")
    orbit, period = exact.orbit(min(exact.speeds(2.0))), 2.0 * np.pi / exact.w
    section = Section(when=sympy.sin(W * T - theta), free=[X, V], at={T: theta / W})
    of = replace(system(), parameters={**BASE, theta: 0.0}).replace(F=2.0, **values)
    start = {"x": exact.sigma, "u_x": orbit.v, "t": orbit.t}
    point = simulate(of, start, orbit.t + period).z[:2]
    map_, phase = SystemMap(of, section, ["theta"]), exact.w * orbit.t
    for k in range(-4, 5):
        p = np.array([phase + k * np.spacing(phase)])
        for i in range(-8, 9):  # rounding parts both events in every way
            beside = point + np.array([0.0, i * np.spacing(point[1])])
            assert map_.duration(beside, p) == pytest.approx(period, abs=CLOSE)
        speed = map_.at(point, p).value[1]  # before or after the impact, as rounding has it
        assert min(abs(speed - orbit.v), abs(speed + orbit.v / exact.eps)) < CLOSE


@NIGHTLY_SYSTEM
def test_newton_fails_where_the_germ_does_not() -> None:
    """Starts beside the grazing, each of which the map sends away faster than it converges."""
    assert newton_fails(1e-3) <= 4


# --- A driven mass between two stops, against the closed form of its flight -----------------------

C, OMEGA, EPS = 0.1, 2.8, 0.8
PERIOD = 2.0 * math.pi / OMEGA
TIMES = 0.4, 0.86, 2.0  # of impacts, from which their equations are solved


def rattle(force: float) -> SystemMap:
    """From period to period of the force; mass, stiffness and half of the room are 1."""
    x, v, t, f = sympy.symbols("x u_x t F")
    stops = [
        Contact(name="right stop", gap=1 - x, eps_n=EPS),
        Contact(name="left stop", gap=1 + x, eps_n=EPS),
    ]
    force_of = f * sympy.cos(OMEGA * t) - C * v - x
    system = ContactSystem([x], [[1]], [force_of], stops, {f: force})
    section = Section(when=sympy.sin(OMEGA * t), free=[x, v], at={t: 0})
    return SystemMap(system, section, ["F"])


def flight(state: np.ndarray, begin: float, end: float, force: float) -> np.ndarray:
    """Position and speed after a flight: a forced oscillation and one that decays."""
    amplitude = force / complex(1.0 - OMEGA**2, C * OMEGA)

    def forced(t: float) -> np.ndarray:
        turning = amplitude * np.exp(1j * OMEGA * t)
        return np.array([turning.real, (1j * OMEGA * turning).real])

    free, decay, t = state - forced(begin), 0.5 * C, end - begin
    own = math.sqrt(1.0 - decay**2)
    b = (free[1] + decay * free[0]) / own
    cos, sin = math.cos(own * t), math.sin(own * t)
    x = free[0] * cos + b * sin
    v = -decay * x + own * (b * cos - free[0] * sin)
    return forced(end) + math.exp(-decay * t) * np.array([x, v])


def left_over(unknowns: np.ndarray, force: float) -> list[float]:
    """By how much a right and two left impacts miss the stops, and the period its start."""
    state, times, off = unknowns[:2], [0.0, *unknowns[2:], PERIOD], list[float]()
    for k, stop in enumerate((1.0, -1.0, -1.0)):
        state = flight(state, times[k], times[k + 1], force)
        off.append(float(state[0]) - stop)
        state = np.array([state[0], -EPS * state[1]])
    last = flight(state, times[3], times[4], force)
    return [*off, *(last - unknowns[:2]).tolist()]


@SLOW_SYSTEM
def test_the_motion_with_a_grazing_impact_more_leaves_the_grazing() -> None:
    """It begins along the border, where its margin grows with the square of the distance."""
    map_ = rattle(10.4)
    cycle = shoot(map_, [-0.6, 2.3])
    found = continuation(map_, cycle, (10.0, 11.0), [(-1, 1), (-20, 20)], orders=(1,)).diagram
    assert sorted((p.kind.value, len(p.branches)) for p in found.points) == [
        ("BC", 2), ("EP", 1), ("EP", 1),
    ]  # fmt: skip
    assert found.point("BC1").parameter == pytest.approx(10.5530793, abs=1e-7)
    (other,) = (each for each in found.branches if each.word == "I1 I2 I2")
    assert [each.word for each in other.words] == ["I1 I2 I2"]
    for k in (len(other.x) // 2, -1):
        at = np.array([other.x[k], other.columns["u_x"][k]])
        force = float(other.parameter[k])
        exact = fsolve(left_over, [*at, *TIMES], args=(force,), xtol=1e-13)
        assert exact[:2] == pytest.approx(at, abs=1e-9)
        assert np.abs(left_over(exact, force)).max() < 1e-11
        assert exact[2] < exact[3] < exact[4] < PERIOD


@NIGHTLY_SYSTEM
def test_two_periods_of_which_one_grazes() -> None:
    """Branches of the doubled period lead from the flip to the grazing, whole and once each."""
    cycle = shoot(rattle(8.0), [-0.13, 2.33])
    window = [(-1, 1), (-20, 20)]
    found = continuation(rattle(8.0), cycle, (8.0, 11.0), window, max_branches=8).diagram
    assert not any(point.status is PointStatus.OPEN for point in found.points)
    ends = {point.id: point.parameter for point in found.points}
    mixed = [
        each for each in found.branches if sorted(each.word.split(" | ")) == ["I1 I2", "I1 I2 I2"]
    ]
    assert len(mixed) == 2  # one for each point of the cycle
    for each in mixed:
        assert sorted(ends[name] for name in each.ends) == pytest.approx(
            [9.2762356, 10.5530793], abs=1e-7
        )


@SLOW_SYSTEM
def test_a_motion_that_grazes_both_stops_at_once_says_so() -> None:
    """Without impacts the amplitude F/|1 - w^2 + i c w| reaches both stops where it is 1."""
    stiffness = complex(1.0 - OMEGA**2, C * OMEGA)
    start = 6.0 / stiffness
    cycle = shoot(rattle(6.0), [start.real, (1j * OMEGA * start).real])
    assert (cycle.success, cycle.word) == (True, "")
    window = [(-1, 1), (-20, 20)]
    found = continuation(rattle(6.0), cycle, (5.0, 8.0), window, orders=(1,)).diagram
    graze = found.point("BC1")
    assert graze.parameter == pytest.approx(abs(stiffness), abs=1e-12)
    assert graze.cause == (
        "right stop grazes in phase 0 and left stop grazes in phase 0: "
        "what starts there may be missed"
    )


# --- Hogan's rocking block against the closed form of its symmetric motions -----------------------


def test_the_closed_form_is_one() -> None:
    """beta is least at the fold; a multiplier of the half motion is 1 there, -1 at the fork."""
    exact = Symmetric(3.0, 0.925)
    v = exact.fold()
    slopes = [exact.beta(v + h) - exact.beta(v - h) for h in (1e-4, 1e-5)]
    assert slopes == pytest.approx([0.0, 0.0], abs=1e-10)
    trace, det = exact.half(v)
    assert 1.0 - trace + det == pytest.approx(0.0, abs=1e-13)
    trace, det = exact.half(exact.pitchfork())
    assert 1.0 + trace + det == pytest.approx(0.0, abs=1e-13)


@pytest.mark.nightly
@EACH_BACKEND
def test_random_blocks_rock_as_the_closed_form_says(backend: str) -> None:
    """Points and multipliers of both halves, at the fold, at the pitchfork and between."""
    rng, map_ = np.random.default_rng(8), rocking_block.map_of("beta", backend=backend)
    for _ in range(6 if backend == "heyoka" else 2):
        w, r = rng.uniform(2.0, 4.0), rng.uniform(0.9, 0.98)  # no corner lifts off
        exact = Symmetric(w, r)
        for v in np.linspace(exact.fold(), exact.pitchfork(), 3):
            x, period = exact.point(v), 2.0 * math.pi / w
            image = map_.holding(w=w, r=r).at(x, np.array([exact.beta(v)]))
            assert image.piece.word == "I1+2f D2 I1f+2"
            away = image.value - x
            away[1] -= period * round(away[1] / period)
            assert np.abs(away).max() < CLOSE
            trace, det = exact.half(v)
            jacobian = image.jacobian[:, :2]
            assert np.trace(jacobian) == pytest.approx(trace**2 - 2.0 * det, abs=CLOSE)
            assert np.linalg.det(jacobian) == pytest.approx(det**2, abs=CLOSE)


# --- The rimless wheel against its closed form, and where its foot slips against forces by hand ---


@pytest.mark.nightly
@EACH_BACKEND
@pytest.mark.parametrize("j", [1.0, 0.01])
def test_walk_and_multiplier_are_those_of_the_closed_form(j: float, backend: str) -> None:
    for gamma in (0.1, 0.2):
        cycle = shoot(rimless_wheel.map_of("gamma", backend=backend).holding(j=j), [0.5], p=[gamma])
        speed, multiplier = walking(gamma, VALUES[ALPHA], j)
        assert cycle.word == "I1f+2s"  # the stance foot lifts off, the next one sticks
        assert cycle.x[0, 0] == pytest.approx(speed, abs=1e-10)
        assert cycle.multipliers[0] == pytest.approx(multiplier, abs=1e-10)


def test_a_wheel_without_inertia_keeps_the_cosine() -> None:
    """Garcia's and McGeer's wheel: all mass at the hub."""
    _, multiplier = walking(0.1, math.pi / 8, 0.0)
    assert multiplier == pytest.approx(0.5, abs=1e-15)  # cos(pi/4)**2


def friction_left(gamma: float) -> float:
    """mu N - |T| at the stance foot as the next foot strikes; the hub moves on a circle."""
    alpha, j, mu = VALUES[ALPHA], VALUES[J], VALUES[MU]
    speed, multiplier = walking(gamma, alpha, j)
    turn, square = math.sin(alpha + gamma) / (1.0 + j), speed**2 / multiplier
    normal = math.cos(gamma) - math.sin(alpha) * turn - math.cos(alpha) * square
    along = math.cos(alpha) * turn - math.sin(alpha) * square - math.sin(gamma)
    return mu * normal - abs(along)


@NIGHTLY_SYSTEM
def test_the_study_of_the_wheel(tmp_path: Path) -> None:
    found = rimless_wheel.main(fast=True, out=tmp_path)
    assert max(found["speed"], found["multiplier"]) < 1e-10
    exact = brentq(friction_left, 0.1, 0.38, xtol=1e-15)
    assert found["slips_from"] == pytest.approx(exact, abs=1e-9)


@SLOW_SYSTEM
def test_beyond_the_slip_each_branch_is_listed_once() -> None:
    """Two branches and the crossing between them, from one end of the span and back to it."""
    map_ = rimless_wheel.map_of("gamma")
    cycle, span = shoot(map_, [0.8], p=[0.37]), (0.36, 0.4)
    diagram = continuation(map_, cycle, span, [(0, 2)], orders=(1,)).diagram
    assert sorted(each.id for each in diagram.branches) == ["F1", "F2", "J1"]
    assert sorted(q.id for q in diagram.points) == ["BC1", "EP1", "EP2", "FF1"]
    assert all(len(q.branches) == (1 if q.kind is PointKind.EP else 2) for q in diagram.points)
    (one,), (other,) = (
        return_map(map_, [each.x[0 if each.parameter[0] == span[0] else -1]], p=[span[0]]).images
        for each in diagram.branches
        if each.kind is BranchKind.FIXED_POINT
    )
    assert abs(one - other) > 0.1
