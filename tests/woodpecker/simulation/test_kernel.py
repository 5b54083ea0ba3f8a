"""The event loop on the hard scenes: boundaries, near coincidences, chatter, falling for ever."""

import math

import mpmath
import numpy as np
import numpy.typing as npt
import pytest
from scenes import plain, run
from toy_points import LOWER

from woodpecker import State, Status, Toy, equilibrium, first_return, return_map, simulate
from woodpecker.base.arrays import Ints
from woodpecker.mechanics import equations as mechanics
from woodpecker.mechanics.contact_problems import AMBIGUOUS, NO_SOLUTION, SOLVED
from woodpecker.mechanics.modes import (
    ALPHA,
    CONE_POSITIVE,
    KAPPA,
    LAMBDA,
    NORMAL,
    SLIP,
    A,
    B,
    mode_of,
    model,
)
from woodpecker.motion.codes import (
    AT_REST,
    TIME_REACHED,
)
from woodpecker.motion.events import time_to_minimum
from woodpecker.motion.flow import flow, measure
from woodpecker.motion.settling import settle
from woodpecker.simulation.status import status

FloatArray = npt.NDArray[np.float64]

OPEN, STICK, UP, DOWN = range(4)
TOY = Toy()

# Closed forms of a few terms: some roundings of 1e-16.
EXACT = 1e-14


def accelerations(states: tuple[int, ...], d: float, toy: Toy = TOY) -> FloatArray:
    row = model(toy)[mode_of(states)]
    return np.asarray(row[A : A + 3] + row[B : B + 3] * d)


def state_at(d: float, rate: float, sleeve: int = 1, dy: float = 0.0) -> FloatArray:
    """State with a sleeve contact closed (0-based), stretch d [rad] and its rate [rad/s]."""
    phi_m = TOY.phi_m_max * (-1.0 if sleeve == 1 else 1.0)
    return np.array([0.0, phi_m, phi_m + d, dy, 0.0, rate, 0.0])


def decide(
    z: FloatArray, closed: tuple[int, ...], slip: int, fired: int, toy: Toy = TOY
) -> tuple[int, tuple[int, ...]]:
    """Outcome of :func:`settle` and the states it chose."""
    touching: Ints = np.zeros(3, dtype=np.int64)
    touching[list(closed)] = 1
    states: Ints = np.zeros(3, dtype=np.int64)
    measure(model(toy), z, gaps := np.zeros(3))
    outcome = settle(
        model(toy),
        z,
        gaps,
        touching,
        slip * touching,
        np.int64(fired),
        states,
        np.zeros(3, dtype=np.int64),
    )
    return outcome, tuple(states.tolist())


# --- Decisions on the boundary, by rate -----------------------------------------------------------


def stretch_on_cone(edge: int, sleeve: int = 1) -> float:
    """Stretch at which lambda_T of the sticking contact is +mu lambda_N or -mu lambda_N."""
    row = model(TOY)[mode_of((OPEN, *((STICK, OPEN) if sleeve == 1 else (OPEN, STICK))))]
    (p_n, r_n), (p_t, r_t) = row[LAMBDA + 4 * sleeve : LAMBDA + 4 * sleeve + 4].reshape(2, 2)
    sign = 1.0 if edge == CONE_POSITIVE else -1.0
    mu = (TOY.mu_1, TOY.mu_2, TOY.mu_3)[sleeve]
    return float(-(mu * p_n - sign * p_t) / (mu * r_n - sign * r_t))


def test_slip_starts_exactly_on_the_cone() -> None:
    """lambda_T2 = mu lambda_N2, no slip yet, no slip acceleration yet: the rate of d decides.

    The weight pulls down, so the force of the pole points up: the sleeve begins to slide down as
    the torque that jams it fades (d rises), and stays stuck if it grows (d falls).
    """
    d = stretch_on_cone(CONE_POSITIVE)
    assert d - TOY.phi_m_max == pytest.approx(-0.205135, abs=5e-7)  # printed digits
    assert decide(state_at(d, 3.0), (1,), 0, CONE_POSITIVE + 1) == (SOLVED, (OPEN, DOWN, OPEN))
    assert decide(state_at(d, -3.0), (1,), 0, CONE_POSITIVE + 1) == (SOLVED, (OPEN, STICK, OPEN))
    # The force of sliding down at that point is that of sticking, so the motion is continuous.
    sliding, sticking = (accelerations((OPEN, s, OPEN), d) for s in (DOWN, STICK))
    np.testing.assert_allclose(sliding, sticking, atol=1e-10)  # of terms up to 1e3


@pytest.mark.parametrize("slip", [-1, 1])
def test_release_at_zero_normal_force(slip: int) -> None:
    """lambda_N2 = 0 while sliding: with a relaxed spring; the rate of d decides."""
    opening, pressing = state_at(0.0, 3.0, dy=0.4 * slip), state_at(0.0, -3.0, dy=0.4 * slip)
    sliding = UP if slip > 0 else DOWN
    assert decide(opening, (1,), slip, NORMAL + 1) == (SOLVED, (OPEN, OPEN, OPEN))
    assert decide(pressing, (1,), slip, NORMAL + 1) == (SOLVED, (OPEN, sliding, OPEN))


def test_end_of_sliding() -> None:
    """Inside the cone the sleeve jams, outside it slides on: down if too heavy, up if thrown."""
    inside = 1.5 * stretch_on_cone(CONE_POSITIVE)
    outside = 0.5 * stretch_on_cone(CONE_POSITIVE)
    assert decide(state_at(inside, 2.0), (1,), 0, SLIP + 1) == (SOLVED, (OPEN, STICK, OPEN))
    assert decide(state_at(outside, 2.0), (1,), 0, SLIP + 1) == (SOLVED, (OPEN, DOWN, OPEN))


# --- The problem on acceleration level ------------------------------------------------------------


def test_painleve_at_the_sliding_sleeve() -> None:
    """G_NN + mu G_NT of contact 2, sliding down, is negative from mu_2 = 1.054977 on.

    Pressed (d < 0) there is no acceleration left, pulled (d > 0) there are two.
    """
    w = np.array([mechanics.normal_directions(TOY)[1], mechanics.tangential_directions(TOY)[1]])
    g = w @ np.linalg.solve(mechanics.mass_matrix(TOY), w.T)
    critical = float(-g[0, 0] / g[0, 1])
    assert critical == pytest.approx(1.0549773797777, rel=1e-12)
    for d, beyond in ((-0.3, NO_SOLUTION), (0.1, AMBIGUOUS)):
        z = state_at(d, 0.0, dy=-0.4)
        below, above = (TOY.replace(mu_2=factor * critical) for factor in (0.999, 1.001))
        assert decide(z, (1,), -1, -1, below)[0] == SOLVED
        assert decide(z, (1,), -1, -1, above)[0] == beyond


# --- Why a run stops ------------------------------------------------------------------------------

HANGING = [0.0, *equilibrium(TOY), 0.0, 0.0, 0.1, 0.0]  # swings within the band of centres
STICKY = TOY.replace(mu_1=1.9, mu_2=5.2, mu_3=0.12, eps_n1=0.02)


@pytest.mark.parametrize(
    ("toy", "phi_s", "reason"),
    [
        (TOY, -0.5, Status.RETURNED),
        (TOY, -0.05, Status.FREE_FALL),
        (TOY.replace(pole=0.01), -1.3, Status.POLE_END),
        (STICKY, -0.6, Status.CONTACT_AMBIGUOUS),
    ],
    ids=lambda value: value.name if isinstance(value, Status) else "",
)
def test_reasons_to_stop_on_the_way_to_the_section(toy: Toy, phi_s: float, reason: Status) -> None:
    assert first_return(toy, phi_s).status is reason


def test_swinging_on_the_jammed_sleeve_for_ever_is_rest() -> None:
    result = run(TOY, HANGING, (OPEN, STICK, OPEN))
    assert (result.code, result.word) == (AT_REST, "")
    assert run(TOY, HANGING, (OPEN, STICK, OPEN), t_end=3.0).code == TIME_REACHED
    assert status(AT_REST) is Status.AT_REST


@pytest.mark.parametrize(
    ("phi_s", "reason"), [(-0.4, Status.CONTACT_NO_SOLUTION), (0.0, Status.CONTACT_AMBIGUOUS)]
)
def test_a_contact_problem_without_one_answer_stops_a_simulation(
    phi_s: float, reason: Status
) -> None:
    start = State(phi_m=-TOY.phi_m_max, phi_s=phi_s, dy=-0.4)
    trajectory = simulate(TOY.replace(mu_2=1.2), start, 1.0)
    assert trajectory.status is reason
    assert not trajectory.status.success
    assert (trajectory.t_end, trajectory.events) == (0.0, ())


def test_the_event_limit_keeps_what_happened() -> None:
    every = simulate(TOY, -0.5, 0.3)
    some = simulate(TOY, -0.5, 0.3, max_events=7)
    assert some.status is Status.EVENT_LIMIT
    assert len(some.events) == 7
    assert some.events == every.events[:7]
    assert some.word.split() == every.word.split()[:7]


# --- Two events almost at once --------------------------------------------------------------------

# Beak and upper edge of the sleeve strike in the same instant at LOWER.
# One-sided limits of P_1 there, from reference_mpmath at a distance of 1e-14.
BEAK_FIRST = -0.46826694763937475751
SLEEVE_FIRST = {"summed": -0.45005813505205375892, "separate": -0.29083456090079565554}


@pytest.mark.parametrize("law", SLEEVE_FIRST)
@pytest.mark.parametrize("distance", [1e-8, 1e-11, 1e-12, 1e-13, 1e-14])
def test_two_impacts_almost_at_once(distance: float, law: str) -> None:
    """Their times differ by 0.006 s/rad times the distance from the jump: down to 1e-17 s."""
    toy = TOY.replace(expansion_friction=law)
    for side, first, second, image, slope in (
        (-1.0, "I1", "I3", BEAK_FIRST, 0.9),
        (1.0, "I3", "I1+3", SLEEVE_FIRST[law], 0.5),
    ):
        phi_s = LOWER + side * distance
        one, other = [e for e in simulate(toy, phi_s, 0.04).events if e.symbol[0] == "I"][:2]
        assert (plain(one.symbol), plain(other.symbol)) == (first, second)
        assert 0.0 <= other.time - one.time <= 0.006 * distance + 1e-17
        result = first_return(toy, phi_s)
        assert f" {first} " in plain(result.word)
        # The slope times the distance, and some roundings.
        assert abs(result.phi_s - image) <= slope * distance + 1e-14


# --- Simultaneous impacts -------------------------------------------------------------------------


@pytest.mark.parametrize(("dphi_m", "dphi_s"), [(8.0, 20.0), (0.0, 20.0)])
def test_two_gaps_close_in_the_same_instant(dphi_m: float, dphi_s: float) -> None:
    """Both contacts take part, also one that was at rest; afterwards neither gap closes."""
    start = State(phi_m=TOY.phi_m_max, phi_s=TOY.phi_s_max, dy=-0.2, dphi_m=dphi_m, dphi_s=dphi_s)
    event = simulate(TOY, start, 0.01).events[0]
    assert (plain(event.symbol), event.time, event.contacts) == ("I1+3", 0.0, (1, 3))
    assert event.u_before == (-0.2, dphi_m, dphi_s)
    assert event.u_after[1] <= 0.0
    assert event.u_after[2] < 0.0
    assert all(impulse.normal_compression > 0.0 for impulse in event.impulses)


def test_a_contact_that_leaves_takes_no_part() -> None:
    """At zero gap but opening: the other one strikes alone."""
    start = State(phi_m=TOY.phi_m_max, phi_s=TOY.phi_s_max, dy=-0.2, dphi_m=-8.0, dphi_s=20.0)
    assert plain(simulate(TOY, start, 1e-6).events[0].symbol) == "I1"
    start = State(phi_m=TOY.phi_m_max, phi_s=TOY.phi_s_max, dy=-0.2, dphi_m=8.0, dphi_s=-20.0)
    assert plain(simulate(TOY, start, 1e-6).events[0].symbol) == "I3"


# --- Chatter --------------------------------------------------------------------------------------

CHATTER_IMAGE = -0.856354474973433798574924  # from reference_mpmath


@pytest.mark.parametrize(
    ("eps_n1", "phi_s"), [(0.009, -0.885), (0.0105, -0.885), (0.335, -0.885), (0.1469, -2.1086)]
)
def test_bounces_that_accumulate_are_summed(eps_n1: float, phi_s: float) -> None:
    """All angles come to rest, so the image does not depend on what happened before."""
    result = first_return(TOY.replace(eps_n1=eps_n1), phi_s)
    assert plain(result.word).startswith("S2 D2 I1 I3 ")
    assert plain(result.word).endswith(" C1 D1 R3 D3 I2 J2")
    assert result.status is Status.RETURNED
    assert abs(result.phi_s - CHATTER_IMAGE) < 1e-14  # roundings
    # the angles forget the start and the bounces; roundings through the bounces
    assert abs(result.slope) < 1e-9
    assert abs(result.d_eps_n1) < 1e-9


# --- Falling for ever -----------------------------------------------------------------------------


def test_grazing_for_ever_is_falling_for_ever() -> None:
    """Released at rest the sleeve swings back to the pole tangentially, period after period."""
    result = return_map(TOY, np.linspace(-0.10, 0.0096, 300))
    assert set(result.status) == {Status.FREE_FALL}
    assert set(result.words) == {"D2"}
    assert np.isinf(result.drop).all()
    assert np.isnan([result.phi_s, result.period, result.slope, result.d_eps_n1]).all()


def test_a_fall_is_recognized_without_waiting() -> None:
    """One event, whether the pole ends after half a metre or a light year."""
    for pole in (0.5, 1e3, 9.5e15):
        toy = TOY.replace(pole=pole)
        image = first_return(toy, -0.05)
        assert (image.status, image.word, image.drop) == (Status.POLE_END, "D2", pole)
        assert math.isnan(image.phi_s)
        assert math.isnan(image.slope)
        assert first_return(toy, -0.52947197).status is Status.RETURNED  # it falls by 19 mm only


def test_a_long_fall_that_ends_all_the_same() -> None:
    """Close to the centre of the dip at -0.266 the toy falls 40 km, in half as many events."""
    phi_s = -0.26594280000000003
    result = first_return(TOY, phi_s)
    assert result.status is Status.RETURNED
    assert result.drop > 1e4
    assert len(result.word.split()) < 12
    assert first_return(TOY.replace(pole=100.0), phi_s).status is Status.POLE_END
    assert first_return(TOY.replace(pole=100.0), phi_s).drop == 100.0


def test_a_contact_that_carries_nothing() -> None:
    """The spring relaxed and still: to slide without force and to open are the same motion."""
    start = State(phi_m=-TOY.phi_m_max, phi_s=-TOY.phi_m_max, dy=-0.4)
    trajectory = simulate(TOY, start, 2.0)
    assert (trajectory.status, trajectory.events) == (Status.TIME_REACHED, ())
    expected = [-0.4 * 2.0 - 0.5 * TOY.g * 4.0, start.phi_m, start.phi_s]
    np.testing.assert_allclose(trajectory.q[-1], expected, rtol=EXACT)


def test_rounding_that_puts_a_leaving_contact_inside() -> None:
    """One double beyond the limit but opening: no impact, and the angle is put on the limit."""
    limit = TOY.phi_m_max
    z = [0.0, -math.nextafter(limit, 1.0), -0.3, 0.0, 5.0, 0.0, 0.0]
    result = run(TOY, z, (OPEN, OPEN, OPEN), t_end=1e-6)
    assert (result.code, result.word) == (TIME_REACHED, "")
    assert result.phases[0, 1] == -limit


# --- Units, backends ------------------------------------------------------------------------------

STARTS = [
    (-0.35, 0.5), (-0.45, 0.5), (-0.52947197, 0.5), (-0.61, 0.3), (-0.7, 0.9), (-0.8, 0.125),
    (-0.885, 0.009), (-0.95, 0.05), (-1.1, 0.9), (-1.765, 0.1367), (-2.2751, 0.2378),
]  # fmt: skip


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_masses_do_not_matter(factor: float) -> None:
    """Masses, inertias and stiffness times a factor: the same map, the same words."""
    names = ("m_m", "j_m", "m_s", "j_s", "c_phi")
    changes = {name: factor * getattr(TOY, name) for name in names}
    for phi_s, eps_n1 in STARTS:
        toy = TOY.replace(eps_n1=eps_n1)
        one, other = first_return(toy, phi_s), first_return(toy.replace(**changes), phi_s)
        assert (one.word, one.status) == (other.word, other.status)
        # Mode tables that differ in roundings, 1e-14 or so; steep flanks amplify them.
        tolerance = 1e-13 * (10.0 + abs(one.slope))
        assert other.phi_s == pytest.approx(one.phi_s, abs=tolerance)
        assert other.slope == pytest.approx(one.slope, rel=1e-9, abs=1e-9)


# --- The flow -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "states", [(OPEN, OPEN, OPEN), (OPEN, STICK, OPEN), (OPEN, OPEN, UP), (DOWN, OPEN, DOWN)]
)
def test_flow_against_the_equations_of_motion(states: tuple[int, int, int]) -> None:
    """qdd = A + B d integrated by mpmath's Taylor method to 25 digits."""
    mode = mode_of(np.array(states))
    row = model(TOY)[mode]
    z = np.array([0.1, 0.02, -0.4, -0.3, 0.0, 20.0, 0.25])
    if states == (OPEN, OPEN, OPEN):
        z[4] = 5.0
    if states[0] != OPEN:
        z[5] = 0.0
    with mpmath.workdps(25):
        a = [mpmath.mpf(x) for x in row[A : A + 3]]
        b = [mpmath.mpf(x) for x in row[B : B + 3]]
        solution = mpmath.odefun(
            lambda _, x: [*x[3:], *(p + r * (x[2] - x[1]) for p, r in zip(a, b, strict=True))],
            0,
            [mpmath.mpf(x) for x in z[:6]],
        )
        for t in (1e-5, 1e-3, 0.01, 0.03):
            out = np.zeros(7)
            flow(model(TOY), mode, z, t, out)
            expected = np.array([float(x) for x in solution(t)])
            # Positions of order 1, velocities of order 100; omega t is 14 at most.
            np.testing.assert_allclose(out[:3], expected[:3], rtol=0.0, atol=1e-14)
            np.testing.assert_allclose(out[3:6], expected[3:], rtol=0.0, atol=1e-12)
            assert out[6] == 0.25 + t


@pytest.mark.parametrize(
    ("offset", "rate", "part"),
    [(0.1, 0.0, 0.5), (-0.1, 0.0, 1.0), (0.0, -2.0, 0.25), (0.0, 2.0, 0.75)],
    ids=["from a maximum", "from a minimum", "falling", "rising"],
)
def test_time_to_the_next_minimum(offset: float, rate: float, part: float) -> None:
    mode = mode_of((OPEN, STICK, OPEN))
    row = model(TOY)[mode]
    period, centre = 2.0 * math.pi / math.sqrt(-row[KAPPA]), -row[ALPHA] / row[KAPPA]
    found = time_to_minimum(model(TOY), mode, state_at(centre + offset, rate))
    assert found == pytest.approx(part * period, rel=EXACT)
