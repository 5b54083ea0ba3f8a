"""The impact oscillator against its closed form: orbits, folds, flips, and what grazing does."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from needs import EACH_BACKEND, NEEDS_HEYOKA

from pwmap import PointKind
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
from woodpecker.search.connected import Connected
from woodpecker.systems import (
    Section,
    SystemMap,
    continuation,
    curve_in_two,
    shoot,
    simulate,
)

CLOSE = 1e-10  # orbits are conditioned to some 1e3, and so are slopes at slow impacts


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


@pytest.mark.nightly
@NEEDS_HEYOKA
@pytest.mark.parametrize(("eps", "w"), [(0.9, 2.6), (0.8, 2.6)])
def test_the_map_does_not_jump_at_a_grazing(eps: float, w: float) -> None:
    """The limit of the root is known to the root of rounding only: some 1e-7 are no jump."""
    map_ = strobed("F").holding(w=w, eps=eps, sigma=1.0, zeta=0.05)
    cycle = shoot(map_, [-0.8, 2.0], p=[6.6])
    found = continuation(map_, cycle, (4.5, 7.5), [(-8.0, 1.0), (-10.0, 10.0)], orders=(1,))
    assert sorted(branch.word for branch in found.diagram.branches) == ["", "I1"]
    (met,) = [point for point in found.diagram.points if point.kind is PointKind.BC]
    assert abs(met.parameter - np.hypot(1.0 - w**2, 0.1 * w)) < CLOSE  # amplitude 1: the gap


@NEEDS_HEYOKA
@pytest.mark.slow
def test_the_curve_of_grazings_over_force_and_frequency() -> None:
    """There the amplitude of the free oscillation is the gap, 1."""
    map_ = strobed("F", "w").holding(eps=0.8, sigma=1.0, zeta=0.05)
    cycle, window = shoot(map_, [-0.1, 0.0], p=[5.5, 2.6]), [(-8.0, 1.0), (-10.0, 10.0)]
    found = continuation(map_, cycle, (4.5, 7.5), window, orders=(1,))
    (met,) = [point for point in found.diagram.points if point.kind is PointKind.BC]
    spans = (2.0, 10.0), (2.0, 3.2)
    curve = curve_in_two(map_, found, met.id, spans, window, max_step=0.2)
    assert sorted(curve.p[[0, -1], 1]) == [2.0, 3.2]
    exact = np.hypot(1.0 - curve.p[:, 1] ** 2, 0.1 * curve.p[:, 1])
    assert curve.p[:, 0] == pytest.approx(exact, abs=CLOSE)


@NEEDS_HEYOKA
@pytest.mark.slow
def test_a_curve_of_grazings_begins_on_either_side() -> None:
    """A branch that strikes ends there in a root; the amplitude is that of the free motion."""
    map_ = strobed("F", "eps").holding(w=2.8, sigma=1.0, zeta=0.05)
    cycle, window = shoot(map_, [-0.8, 2.0], p=[8.0, 0.8]), [(-8.0, 1.0), (-10.0, 10.0)]
    found = continuation(map_, cycle, (6.5, 8.5), window, orders=(1,))
    assert [branch.word for branch in found.diagram.branches] == ["I1", ""]
    curve = curve_in_two(map_, found, "BC1", [(6.5, 8.5), (0.3, 0.9)], window)
    assert sorted(curve.p[[0, -1], 1]) == [0.3, 0.9]
    assert curve.p[:, 0] == pytest.approx(np.hypot(1.0 - 2.8**2, 0.28), abs=CLOSE)


@pytest.fixture(scope="module")
def grazing() -> tuple[Connected, float]:
    return through_grazing()


@NEEDS_HEYOKA
@pytest.mark.slow
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


@pytest.mark.nightly
@NEEDS_HEYOKA
def test_newton_fails_where_the_germ_does_not() -> None:
    """Starts beside the grazing, each of which the map sends away faster than it converges."""
    assert newton_fails(1e-3) <= 4
