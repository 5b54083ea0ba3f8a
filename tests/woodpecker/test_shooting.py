"""Periodic solutions of the toy, and its return map as a map of one parameter."""

import math

import numpy as np
import pytest
import sympy

from pwmap.diagrams.data import UNDECIDED
from pwmap.diagrams.diagram import PointKind
from woodpecker.diagrams import continuation
from woodpecker.maps.symbolic import from_sympy
from woodpecker.mechanics.equations import equilibrium
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import DEFAULT, ShootingStatus, periodic_orbit, shoot
from woodpecker.simulation.returns import first_return
from woodpecker.simulation.status import Status
from woodpecker.slices.orbits import Orbit, orbit_of
from woodpecker.toy_map import Mapped, ToyPieces

TOY = Toy()
CYCLE = "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"  # of the stable motion at eps_n1 = 0.5
RESIDUAL = 1e-12  # the map is good to 1e-14 or so; two orders more leave room for steep slopes


# --- shooting ------------------------------------------------------------------------------------


@pytest.mark.parametrize("guess", [-0.53, -0.5, -0.56])
def test_stable_motion(guess: float) -> None:
    """The reference values have eight digits and more, found by two independent programs."""
    orbit = shoot(TOY, guess)
    assert orbit.status is ShootingStatus.CONVERGED
    assert orbit.success
    assert orbit.message == "a periodic solution was found"
    assert orbit.phi_s == pytest.approx(-0.529471967110851036, abs=1e-12)  # of Newton's method
    assert orbit.period == pytest.approx(0.14597607, abs=1e-8)
    assert 1000.0 * orbit.drop == pytest.approx(19.4454, abs=5e-5)
    assert orbit.multiplier == pytest.approx(-0.83916, abs=5e-6)
    assert orbit.stable
    assert orbit.word == CYCLE
    assert orbit.residual < RESIDUAL
    assert orbit.points == (orbit.phi_s,)
    assert (orbit.order, orbit.minimal_period, orbit.toy) == (1, 1, TOY)
    back = first_return(TOY, orbit.phi_s)
    assert back.phi_s == pytest.approx(orbit.phi_s, abs=RESIDUAL)
    # sums of some ten phases, in another order
    assert (back.period, back.drop) == pytest.approx((orbit.period, orbit.drop), rel=1e-14)
    assert back.slope == pytest.approx(orbit.multiplier, rel=1e-12)  # searched and followed


@pytest.mark.parametrize("order", [2, 3])
def test_higher_orders_find_the_motion_again(order: int) -> None:
    once, orbit = shoot(TOY, -0.53), shoot(TOY, -0.53, order)
    assert orbit.success
    assert orbit.residual < RESIDUAL
    assert orbit.points == pytest.approx([once.phi_s] * order, abs=1e-11)
    assert orbit.multiplier == pytest.approx(once.multiplier**order, abs=1e-10)
    assert orbit.period == pytest.approx(order * once.period, abs=1e-11)
    assert orbit.drop == pytest.approx(order * once.drop, abs=1e-11)
    assert orbit.word == " | ".join([CYCLE] * order)
    assert (orbit.order, orbit.minimal_period) == (order, 1)
    assert orbit.message == (f"a periodic solution was found: one of period 1, {order} times over")


@pytest.mark.parametrize("guess", [-0.53, -0.51])
def test_motion_of_period_two_past_the_flip(guess: float) -> None:
    """The flip is at eps_n1 = 0.6485; at 0.66 two points alternate, stable again."""
    toy = TOY.replace(eps_n1=0.66)
    orbit = shoot(toy, guess, 2)
    assert orbit.success
    assert orbit.residual < RESIDUAL
    assert (orbit.order, orbit.minimal_period) == (2, 2)
    assert orbit.message == "a periodic solution was found"
    assert sorted(orbit.points) == pytest.approx([-0.53000422, -0.50628075], abs=1e-8)
    assert abs(guess - orbit.phi_s) < 0.01
    one, two = orbit.points
    assert first_return(toy, one).phi_s == pytest.approx(two, abs=RESIDUAL)
    assert first_return(toy, one, 2).phi_s == pytest.approx(one, abs=2 * RESIDUAL)
    above, below = (first_return(toy, one + side * 1e-6, 2).phi_s for side in (1.0, -1.0))
    slope = (above - below) / 2e-6
    assert orbit.multiplier == pytest.approx(slope, abs=1e-7)  # P2''' reaches 1e4
    assert abs(orbit.multiplier) < 1.0 < abs(shoot(toy, -0.5177).multiplier)
    assert orbit.period == pytest.approx(sum(first_return(toy, x).period for x in (one, two)))
    assert orbit.drop == pytest.approx(sum(first_return(toy, x).drop for x in (one, two)))


@pytest.mark.parametrize("guess", [-0.884773, -0.8847, -0.8848])
def test_jump_across_the_diagonal_is_no_solution(guess: float) -> None:
    """At eps_n1 = 0.125 P1 jumps at -0.884773 from -1.514 to -0.462, past the diagonal."""
    orbit = shoot(TOY.replace(eps_n1=0.125, expansion_friction="separate"), guess)
    assert not orbit.success
    assert orbit.status is ShootingStatus.AT_JUMP
    assert "-0.884773" in orbit.message


@pytest.mark.parametrize(
    ("guess", "expected"), [(-0.884773, -0.8550349404), (-0.8848, -1.0746022972)]
)
def test_shooting_from_beside_a_jump_finds_the_fixed_point_of_its_side(
    guess: float, expected: float
) -> None:
    """With the sum P1 jumps there from -1.017 to -0.821, and both pieces reach the diagonal."""
    orbit = shoot(TOY.replace(eps_n1=0.125), guess)
    assert orbit.success
    assert orbit.phi_s == pytest.approx(expected, abs=1e-9)
    # -1.43 on the right, as next to A; -0.29 on the left, the branch from B
    assert abs(orbit.multiplier) == pytest.approx(abs(first_return(orbit.toy, orbit.phi_s).slope))
    assert (abs(orbit.multiplier) < 1.0) is (guess < -0.88478)


@pytest.mark.parametrize("guess", [-0.09, -0.05, 0.0])
@pytest.mark.parametrize("order", [1, 2])
def test_start_that_falls_is_lost(guess: float, order: int) -> None:
    """Above -0.2052 the sleeve cannot jam; in (-0.10, 0.01) it never does again."""
    orbit = shoot(TOY, guess, order)
    assert orbit.status is ShootingStatus.LOST
    assert not orbit.success
    assert orbit.phi_s == guess
    assert Status.FREE_FALL.value in orbit.message


@pytest.mark.parametrize(
    ("guess", "order"), [(-0.22, 1), (-0.22, 2), (-0.21, 1), (-0.23, 1), (-0.23, 3)]
)
def test_rest_is_no_periodic_solution(guess: float, order: int) -> None:
    """Between -0.2382 and -0.2217 P1 is the identity: nothing falls, nothing is followed.

    From above the equilibrium P1 leads to its mirror image, so Newton's method finds rest. A bird
    far out pulls the sleeve fast; its rest has no slope the kernel could give.
    """
    orbit = shoot(TOY, guess, order)
    for each in (orbit, shoot(Toy(l_g=1.0), -0.53)):
        assert (each.status, each.success) == (ShootingStatus.CENTRE, False)
    assert (orbit.order, orbit.minimal_period, orbit.drop) == (order, 1, 0.0)
    assert "stays jammed" in orbit.message
    if (guess, order) == (-0.23, 1):
        assert (orbit.phi_s, orbit.multiplier, orbit.word) == (guess, 1.0, "")
        assert not orbit.stable  # a multiplier of -1, from above, is rounded
    if guess > -0.2217:
        assert orbit.phi_s == pytest.approx(equilibrium(TOY).phi_s, abs=1e-9)


def test_a_solution_without_a_finite_slope_is_no_success() -> None:
    """Whatever makes it so: a multiplier that is nan says nothing of stability."""
    (image,) = orbit_of([ToyPieces(TOY).at(-0.53, 0.5).piece], np.array([-0.53]), 0.5).images
    nowhere = image._replace(value=-0.53, slope=math.nan)
    mapped = Mapped(TOY, ToyPieces(TOY), 0.5)
    orbit = periodic_orbit(mapped, Orbit(np.array([-0.53]), 0.5, (nowhere,)), DEFAULT)
    assert (orbit.status, orbit.success) == (ShootingStatus.NO_SLOPE, False)
    assert orbit.message == "the returns close, but the return map has no finite slope here: nan"


@pytest.mark.slow
@pytest.mark.parametrize("order", [2, 3])
def test_continuation_follows_the_minimal_period(order: int) -> None:
    """The flip is a special point of P1; as a fold-like point of P2 it would go unseen."""
    found = continuation(TOY, shoot(TOY, -0.53, order), span=(0.5, 0.7))
    flips = [point for point in found.points if point.kind is PointKind.PD]
    assert [point.order for point in flips] == [1]
    assert flips[0].parameter == pytest.approx(0.648549, abs=1e-6)
    there = shoot(TOY.replace(eps_n1=flips[0].parameter), -0.5186)
    assert there.multiplier == pytest.approx(-1.0, abs=1e-9)  # what says that it is the flip
    assert {branch.order for branch in found.branches} == {1}


@pytest.mark.parametrize(("slope", "stable"), [(-1.0, False), (1e-10 - 1.0, True), (-1.1, False)])
def test_a_multiplier_on_the_unit_circle_decides_nothing(slope: float, stable: bool) -> None:
    x, p = sympy.symbols("x p")
    lines = from_sympy(sympy.Piecewise((p + slope * x, x < 0), (p + slope * x, True)), x, p)
    orbit = shoot(lines, 0.1, p=0.2)
    assert orbit.x == pytest.approx(0.2 / (1.0 - slope), abs=1e-15)
    assert (orbit.success, orbit.stable) == (True, stable)
    assert orbit.message.endswith(UNDECIDED) == (slope == -1.0)


# --- the map of one parameter --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "phi_s", "p", "reason"),
    [
        ("eps_n1", -0.53, 1.1, r"eps_n1 must lie in [0, 1], got 1.1"),
        ("eps_n1", -0.53, -0.1, r"eps_n1 must lie in [0, 1], got -0.1"),
        ("mu_2", -0.53, -0.1, "mu_2 must be at least 0 and finite, got -0.1"),
        ("m_s", -0.53, 0.0, "m_s must be positive and finite, got 0.0"),
        ("l_s", 0.119, 0.0202, "the beak touches the pole"),
        ("eps_n1", 0.2, 0.5, "the beak touches the pole"),
        ("eps_n1", math.nan, 0.5, "phi_s must be finite, got nan"),
        ("eps_n1", -0.05, 0.5, Status.FREE_FALL.value),
    ],
)
def test_no_value_and_why(name: str, phi_s: float, p: float, reason: str) -> None:
    here = ToyPieces(TOY, name).at(phi_s, p)
    assert here.reason == reason
    assert math.isnan(here.value)
    beyond = ToyPieces(TOY, "r_m").at(-0.53, 0.002)
    assert beyond.reason.startswith("r_m must exceed r_0 = 0.0025")
