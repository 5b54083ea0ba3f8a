"""Trajectories: exact at any time, events with impulses, energy to the last bits."""

import math

import numpy as np
import pytest

from woodpecker import (
    EventKind,
    State,
    Status,
    Toy,
    Trajectory,
    first_return,
    shoot,
    simulate,
)
from woodpecker.mechanics.equations import mass_matrix, normal_directions, tangential_directions
from woodpecker.mechanics.modes import (
    ALPHA,
    KAPPA,
    LAMBDA,
    OPEN,
    SLIP_POSITIVE,
    STICK,
    A,
    B,
    mode_states,
    model,
)
from woodpecker.simulation import energy_balance

TOY = Toy()
SCENES = [
    (0.5, -0.52947197, 3.0),
    (0.9, -1.3, 2.0),
    (0.125, -0.8, 2.0),
    (0.009, -0.885, 1.0),  # chatter
    (0.34, -1.757, 1.0),  # impulses that the laws leave open
    (1.0, -2.3, 2.0),
]


def motion(eps_n1: float, phi_s: float, t_end: float) -> Trajectory:
    return simulate(Toy(eps_n1=eps_n1), phi_s, t_end)


@pytest.mark.parametrize("scene", SCENES)
def test_energy_is_accounted_for(scene: tuple[float, float, float]) -> None:
    """Losses come from forces and impulses; the balance closes to rounding."""
    balance = energy_balance(motion(*scene))
    assert abs(balance.residual) <= 1e-12
    assert balance.friction >= 0.0
    assert balance.impacts >= -1e-18  # an impact never adds energy
    assert balance.initial - balance.final > 1e-3


@pytest.mark.parametrize("scene", SCENES)
def test_contacts_are_respected(scene: tuple[float, float, float]) -> None:
    """Gaps are not negative beyond the spacing of times near 3 s (4e-16) times 30 rad/s."""
    toy, q = Toy(eps_n1=scene[0]), motion(*scene).q
    assert (toy.phi_s_max - q[:, 2]).min() >= -2e-14
    assert (toy.phi_m_max - np.abs(q[:, 1])).min() >= -2e-14


@pytest.mark.parametrize("scene", SCENES)
def test_impacts_balance_momentum(scene: tuple[float, float, float]) -> None:
    toy, path = Toy(eps_n1=scene[0]), motion(*scene)
    mass = np.array(mass_matrix(toy))
    normal, tangent = np.array(normal_directions(toy)), np.array(tangential_directions(toy))
    for event in path.events:
        change = mass @ (np.array(event.u_after) - np.array(event.u_before))
        total = np.zeros(3)
        for p in event.impulses:
            total += normal[p.contact - 1] * (p.normal_compression + p.normal_expansion)
            total += tangent[p.contact - 1] * (p.tangential_compression + p.tangential_expansion)
        np.testing.assert_allclose(change, total, atol=1e-15)  # of momenta up to 1e-3
        if event.kind not in (EventKind.IMPACT, EventKind.INDETERMINATE_IMPACT):
            assert not event.impulses


def test_solution_is_exact_between_events() -> None:
    """qdd = A + B d in each phase by central differences, continuous q across events."""
    path = motion(0.5, -0.53, 0.3)
    numbers, h = model(TOY), 1e-6
    starts = path.phases[:, 6]
    for k, (start, end) in enumerate(zip(starts, [*starts[1:], path.t_end], strict=True)):
        if end - start < 1e-4:
            continue
        mode = int(path.phases[k, 7])
        for share in (0.2, 0.5, 0.8):
            t = start + share * (end - start)
            q, _ = path.at(t)
            before, after = path.at(t - h)[1], path.at(t + h)[1]
            row = numbers[mode]
            expected = row[A : A + 3] + row[B : B + 3] * (q[2] - q[1])
            # truncation h^2 q''''/6 with q'''' up to 1e9, rounding 1e-15/h of velocities near 20
            np.testing.assert_allclose((after - before) / (2.0 * h), expected, atol=2e-2)
            assert row[ALPHA] + row[KAPPA] * (q[2] - q[1]) == pytest.approx(
                expected[2] - expected[1], abs=1e-9
            )
    first = {event.time: event for event in reversed(path.events)}
    last = {event.time: event for event in path.events}
    for time in last:
        (q_left, u_left), (q_right, u_right) = path.at(time, left=True), path.at(time)
        np.testing.assert_allclose(q_left, q_right, atol=1e-15)
        np.testing.assert_allclose(u_left, first[time].u_before, atol=1e-12)
        np.testing.assert_allclose(u_right, last[time].u_after, atol=1e-12)


def test_samples_hold_both_sides_of_an_event() -> None:
    path = simulate(TOY, -0.53, 0.1, samples=11)
    instants = {event.time for event in path.events}
    assert len(path.t) == 11 + 2 * len(instants)
    assert (np.diff(path.t) >= 0.0).all()
    repeated = path.t[:-1][np.diff(path.t) == 0.0]
    assert set(repeated.tolist()) == instants
    assert np.abs(np.diff(path.q, axis=0)[np.diff(path.t) == 0.0]).max() <= 1e-15


def test_cycle_repeats_itself() -> None:
    orbit = shoot(TOY, -0.53)
    path = simulate(TOY, orbit.phi_s, 3.0 * orbit.period)
    assert path.word == " ".join([orbit.word] * 3)
    assert path.drop == pytest.approx(3.0 * orbit.drop, abs=1e-12)
    for lap in range(3):
        q, u = path.at(0.05 + lap * orbit.period)
        np.testing.assert_allclose(q[1:], path.at(0.05)[0][1:], atol=1e-12)
        np.testing.assert_allclose(u, path.at(0.05)[1], atol=1e-10)
    assert path.at(np.zeros((2, 3)))[0].shape == (2, 3, 3)


def test_start_from_any_state() -> None:
    path = simulate(TOY, State(phi_m=0.0, phi_s=0.0, y=0.3, dphi_s=3.0), 0.1)
    assert path.q[0].tolist() == [0.3, 0.0, 0.0]
    assert path.events[0].symbol == "I3"
    sliding = simulate(TOY, State(phi_m=TOY.phi_m_max, phi_s=0.0, dy=-0.1), 0.01)
    assert sliding.word.split()[0] in {"D3", "J3"}
    jamming = simulate(TOY, State.on_section(TOY, -0.5), 0.01)
    np.testing.assert_array_equal(jamming.q, simulate(TOY, -0.5, 0.01).q)


def forces_and_velocities(path: Trajectory, k: int, i: int) -> tuple[np.ndarray, ...]:
    """lambda_N, lambda_T, gap rate over its lever and tangential velocity, 200 times in phase k."""
    end = path.phases[k + 1, 6] if k + 1 < len(path.phases) else path.t_end
    start, row = path.phases[k, 6], model(path.toy)[int(path.phases[k, 7])]
    times = np.linspace(start, end, 202)[1:-1]
    q, u = path.at(times[(times > start) & (times < end)])
    p_n, r_n, p_t, r_t = row[LAMBDA + 4 * i : LAMBDA + 4 * i + 4]
    d = q[:, 2] - q[:, 1]
    normal = np.sign(np.array(normal_directions(path.toy)[i]))
    return (
        p_n + r_n * d,
        p_t + r_t * d,
        u @ normal,
        u @ np.array(tangential_directions(path.toy)[i]),
    )


@pytest.mark.parametrize("scene", SCENES)
def test_forces_lie_in_their_cones(scene: tuple[float, float, float]) -> None:
    """Closed contacts: no pull, no gap rate; sticking inside the cone, sliding on its edge."""
    path = motion(*scene)
    toy, closed = path.toy, 0
    weight = 9.81 * (toy.m_s + toy.m_m)
    for k, phase in enumerate(path.phases):
        for i, state in enumerate(mode_states(int(phase[7]))):
            if state == OPEN:
                continue
            force_n, force_t, gap_rate, slip = forces_and_velocities(path, k, i)
            closed += len(force_n)
            # Forces of up to ten weights; at the ends of a phase they vanish up to rounding.
            slack = 1e-12 * weight
            assert (force_n >= -slack).all()
            assert (gap_rate == 0.0).all()
            mu = (toy.mu_1, toy.mu_2, toy.mu_3)[i]
            if state == STICK:
                assert (np.abs(force_t) <= mu * force_n + slack).all()
                assert np.abs(slip).max(initial=0.0) <= 1e-12  # of velocities up to 30 rad/s
            else:
                sign = 1.0 if state == SLIP_POSITIVE else -1.0
                np.testing.assert_allclose(force_t, -sign * mu * force_n, rtol=0.0, atol=slack)
                assert (sign * slip >= -1e-12).all()
    assert closed > 2000


def test_impulses_of_an_impact() -> None:
    """No pull, friction within its bound; the expansion stores at least eps_N of the compression.

    The bound is mu Lambda_N, in the expansion mu times the sum over the contacts that take part.
    """
    for scene in SCENES:
        toy = Toy(eps_n1=scene[0])
        for event in motion(*scene).events:
            stored = sum(p.normal_expansion for p in event.impulses)
            for p in event.impulses:
                eps = (toy.eps_n1, toy.eps_n2, toy.eps_n3)[p.contact - 1]
                assert p.normal_compression >= 0.0
                # Impulses up to 1e-3 N s; small ones are solved with errors of 1e-11 of those.
                assert p.normal_expansion >= eps * p.normal_compression - 1e-14
                assert abs(p.tangential_compression) <= 0.3 * p.normal_compression + 1e-14
                assert abs(p.tangential_expansion) <= 0.3 * stored + 1e-14


@pytest.mark.parametrize(("phi_s", "eps_n1"), [(-0.61, 0.3), (-0.8, 0.125), (-1.3, 0.5)])
def test_a_simulation_comes_by_the_return_map(phi_s: float, eps_n1: float) -> None:
    """After the period of the first return it is on the section, at the image."""
    toy = Toy(eps_n1=eps_n1)
    once = first_return(toy, phi_s)
    q, u = simulate(toy, phi_s, 1.5 * once.period).at(once.period)
    np.testing.assert_allclose(q, [-once.drop, -toy.phi_m_max, once.phi_s], atol=1e-14)
    # phi_S'' = 1e3 times the rounding of the time.
    np.testing.assert_allclose(u, 0.0, atol=1e-12)


@pytest.mark.parametrize("t_end", [0.1, 0.3, 1.0, 2.7182818284590451])
def test_the_end_is_the_time_asked_for(t_end: float) -> None:
    path = simulate(TOY, -0.53, t_end, samples=3)
    assert (path.t_end, path.t[-1], path.status) == (t_end, t_end, Status.TIME_REACHED)
    np.testing.assert_array_equal(path.at(t_end)[0], path.q[-1])


@pytest.mark.parametrize(("y", "pole"), [(0.0, 1.0), (0.5, 1.0), (-0.25, 3.0)])
def test_free_fall_off_the_pole(y: float, pole: float) -> None:
    """At rest in the middle of the pole, y = y_0 - g t^2 / 2 until the height -pole is passed."""
    toy = TOY.replace(pole=pole)
    path = simulate(toy, State(phi_m=0.0, phi_s=0.0, y=y), 10.0)
    assert (path.status, path.events, path.drop) == (Status.POLE_END, (), pole + y)
    assert path.t_end == pytest.approx(math.sqrt(2.0 * (pole + y) / toy.g), rel=1e-14)
    q, u = path.at(path.t_end / 2.0)
    np.testing.assert_allclose(q, [y - (pole + y) / 4.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(u, [-toy.g * path.t_end / 2.0, 0.0, 0.0], rtol=1e-14)


def test_a_fall_for_ever_lasts_as_long_as_asked_for() -> None:
    path = simulate(TOY, State(phi_m=0.0, phi_s=0.0), 100.0)
    assert (path.status, path.t_end) == (Status.TIME_REACHED, 100.0)
    assert path.drop == pytest.approx(0.5 * TOY.g * 100.0**2, rel=1e-14)


def test_a_motion_without_events() -> None:
    """Within the band of centres nothing happens and nothing is lost."""
    path = simulate(TOY, -0.22, 1.0)
    assert (path.events, path.word, path.drop) == ((), "", 0.0)
    balance = energy_balance(path)
    assert (balance.friction, balance.impacts) == (0.0, 0)
    assert abs(balance.residual) <= 1e-6  # of a swing of 1e-8 J in a potential of 1e-4 J


@pytest.mark.parametrize("contact", [1, 2, 3])
def test_a_start_may_touch_but_not_penetrate(contact: int) -> None:
    sign, angle = (1.0, -1.0, 1.0)[contact - 1], "phi_s" if contact == 1 else "phi_m"
    limit = sign * (TOY.phi_s_max if contact == 1 else TOY.phi_m_max)
    touching = {"phi_m": 0.0, "phi_s": 0.0} | {angle: limit}
    assert simulate(TOY, State(**touching), 1e-3).q[0, 2 if contact == 1 else 1] == limit
    inside = touching | {angle: float(np.nextafter(limit, 2.0 * limit))}
    with pytest.raises(ValueError, match=f"the start penetrates contact {contact}: its angle is"):
        simulate(TOY, State(**inside), 1e-3)
