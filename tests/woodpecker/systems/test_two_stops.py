"""A driven mass between two stops, against the closed form of its flight."""

import math

import numpy as np
import pytest
import sympy
from needs import NEEDS_HEYOKA
from scipy.optimize import fsolve

from pwmap import PointStatus
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

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


@NEEDS_HEYOKA
@pytest.mark.slow
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


@pytest.mark.nightly
@NEEDS_HEYOKA
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


@NEEDS_HEYOKA
@pytest.mark.slow
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
