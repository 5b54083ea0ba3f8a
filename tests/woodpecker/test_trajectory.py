"""Trajectories: exact at any time, events with impulses, energy to the last bits."""

import numpy as np
import pytest

from woodpecker import State, Status, Toy, energy_balance, shoot, simulate
from woodpecker.mechanics import mass_matrix, normal_directions, tangential_directions
from woodpecker.modes import ALPHA, KAPPA, A, B, mode_states, model
from woodpecker.trajectory import Trajectory
from woodpecker.words import EventKind

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


def test_modes_of_the_cycle() -> None:
    path = simulate(TOY, -0.53, 0.14)
    states = [mode_states(int(mode)) for mode in path.phases[:, 7]]
    assert [tuple(map(int, state)) for state in states[:4]] == [
        (0, 1, 0),  # jams
        (0, 3, 0),  # slides down
        (0, 0, 0),  # falls
        (0, 0, 0),  # the upper contact opens at once
    ]


def test_start_from_any_state() -> None:
    path = simulate(TOY, State(phi_m=0.0, phi_s=0.0, y=0.3, dphi_s=3.0), 0.1)
    assert path.q[0].tolist() == [0.3, 0.0, 0.0]
    assert path.events[0].symbol == "I3"
    sliding = simulate(TOY, State(phi_m=TOY.phi_m_max, phi_s=0.0, dy=-0.1), 0.01)
    assert sliding.word.split()[0] in {"D3", "J3"}
    jamming = simulate(TOY, State.on_section(TOY, -0.5), 0.01)
    np.testing.assert_array_equal(jamming.q, simulate(TOY, -0.5, 0.01).q)


def test_both_gaps_close_in_the_same_instant() -> None:
    """With equal angle limits (powers of two: no rounding) a rigid turn brings both to the pole."""
    toy = TOY.replace(l_m=0.5, l_g=0.5, l_s=0.5, r_0=0.25, r_m=0.5, h_s=2.0, h_m=2.0)
    assert toy.phi_m_max == toy.phi_s_max == 0.125
    angle = toy.phi_s_max - 2.0**-10
    start = State(phi_m=angle, phi_s=angle, dphi_m=8.0, dphi_s=8.0)
    path = simulate(toy, start, 2e-4)
    assert path.events[0].symbol.startswith(("I1+3", "I1s+3", "I~1"))
    assert path.events[0].time == 2.0**-13
    assert {p.contact for p in path.events[0].impulses} == {1, 3}


def test_the_pole_ends() -> None:
    path = simulate(TOY.replace(pole=0.1), -0.52947197, 3.0)
    assert path.status is Status.POLE_END
    assert path.drop == 0.1
    assert path.q[-1, 0] == pytest.approx(-0.1, abs=1e-15)
    assert path.t[-1] == path.t_end < 0.8


def test_event_limit_is_reported() -> None:
    path = simulate(TOY, -0.53, 1.0, max_events=5)
    assert path.status is Status.EVENT_LIMIT
    assert path.word == "S2 D2 I3 D3 I1"


@pytest.mark.parametrize(
    ("start", "t_end", "sentence"),
    [
        (0.2, 1.0, "the start penetrates contact 1"),
        (State(phi_m=-0.2, phi_s=0.0), 1.0, "the start penetrates contact 2"),
        (State(phi_m=0.2, phi_s=0.0), 1.0, "the start penetrates contact 3"),
        (State(phi_m=0.0, phi_s=float("nan")), 1.0, "a state must be finite"),
        (-0.5, 0.0, "t_end must be positive and finite, got 0.0"),
        (-0.5, float("inf"), "t_end must be positive and finite, got inf"),
    ],
)
def test_wrong_requests(start: float | State, t_end: float, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        simulate(TOY, start, t_end)


def test_times_outside_are_refused() -> None:
    path = simulate(TOY, -0.53, 0.1)
    for t in (-1e-9, 0.1 + 1e-9, float("nan")):
        with pytest.raises(ValueError, match=r"t must lie in \[0, 0.1\]"):
            path.at(t)
