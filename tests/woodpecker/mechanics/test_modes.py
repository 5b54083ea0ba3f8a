"""The mode table satisfies the constrained equations of motion, row by row."""

from itertools import product

import numpy as np
import numpy.typing as npt
import pytest

from woodpecker import Toy
from woodpecker.mechanics import equations as mechanics
from woodpecker.mechanics.modes import (
    CONTACT,
    DELASSUS,
    FORCE,
    GUARDS,
    KAPPA,
    LAMBDA,
    LEVER,
    LIMIT,
    MODES,
    MU,
    OMEGA,
    POLE,
    RESPONSE_N,
    RESPONSE_T,
    SHAPE,
    TANGENT,
    A,
    B,
    mode_of,
    mode_states,
    model,
)

FloatArray = npt.NDArray[np.float64]
States = tuple[int, int, int]

OPEN, STICK, UP, DOWN = range(4)


def consistent(states: States) -> bool:
    """Two closed contacts share the velocity of the sleeve: both stick, or slip the same way."""
    return len({*states} - {OPEN}) <= 1


SLIP_SIGN = {UP: 1.0, DOWN: -1.0}
SLEEVES = [(OPEN, OPEN), *product((STICK, UP, DOWN), (OPEN,)), *product((OPEN,), (STICK, UP, DOWN))]
EVERY: list[States] = [(beak, *sleeve) for beak in range(4) for sleeve in SLEEVES]
LOCKED = [(STICK, STICK, OPEN), (STICK, OPEN, STICK)]  # at rest for good
MOVING = [states for states in EVERY if consistent(states) and states not in LOCKED]

# Linear systems of condition up to 1e5 after scaling: five digits less than doubles have.
SOLVED = 1e-11

TOYS = {
    "paper": Toy(),
    "other friction": Toy(mu_1=0.15, mu_2=0.7, mu_3=0.45),
    "no friction": Toy(mu_1=0.0, mu_2=0.0, mu_3=0.0),
    "heavy sleeve": Toy(m_m=0.003, j_m=8e-8, c_phi=0.02),
}


def label(states: States) -> str:
    return " ".join(("open", "stick", "slip_positive", "slip_negative")[state] for state in states)


moving = pytest.mark.parametrize("states", MOVING, ids=label)
toys = pytest.mark.parametrize("toy", TOYS.values(), ids=TOYS)


def row(toy: Toy, states: States) -> FloatArray:
    return np.asarray(model(toy)[mode_of(states)])


def forces(numbers: FloatArray, i: int) -> FloatArray:
    """Rows N and T, columns const and per stretch, of contact i (0-based)."""
    return np.asarray(numbers[LAMBDA + 4 * i : LAMBDA + 4 * i + 4].reshape(2, 2))


def directions(toy: Toy) -> tuple[FloatArray, FloatArray]:
    normal, tangential = mechanics.normal_directions(toy), mechanics.tangential_directions(toy)
    return np.array(normal), np.array(tangential)


def closed(states: States) -> list[int]:
    return [i for i in range(3) if states[i] != OPEN]


# --- Modes ----------------------------------------------------------------------------------------


def test_there_are_28_modes() -> None:
    assert len(EVERY) == MODES == 28
    assert [mode_of(states) for states in EVERY] == list(range(MODES))
    assert [mode_states(index) for index in range(MODES)] == EVERY


def test_consistent_modes() -> None:
    """One or no contact: 1 + 3 + 6. Two: both stick or both slip the same way, 3 states twice."""
    assert len(MOVING) + len(LOCKED) == 1 + 3 + 6 + 6
    assert all(len({s for s in states if s != OPEN}) <= 1 for states in MOVING)
    for index, states in enumerate(EVERY):
        numbers = model(Toy())[index, :GUARDS]
        assert np.isfinite(numbers).all() if consistent(states) else np.isnan(numbers).all()


# --- Equations of motion --------------------------------------------------------------------------


@toys
@moving
def test_equations_of_motion(toy: Toy, states: States) -> None:
    """M (A + B d) = h_0 + h_1 d + sum w lambda(d), for the constants and per stretch [Eq. 1]."""
    numbers, (normal, tangential) = row(toy, states), directions(toy)
    mass: FloatArray = np.array(mechanics.mass_matrix(toy))
    h: FloatArray = np.column_stack(
        [mechanics.force_at_rest(toy), mechanics.force_per_stretch(toy)]
    )
    motion = np.column_stack([numbers[A : A + 3], numbers[B : B + 3]])
    terms = [mass @ motion, -h]
    for i in closed(states):
        lambda_n, lambda_t = forces(numbers, i)
        terms += [-np.outer(normal[i], lambda_n), -np.outer(tangential[i], lambda_t)]
    size = np.abs(mass) @ np.abs(motion) + np.abs(terms[1:]).sum(axis=0)
    assert (np.abs(np.sum(terms, axis=0)) <= SOLVED * size).all()
    for i in range(3):
        if states[i] == OPEN:
            assert (forces(numbers, i) == 0.0).all()
    assert numbers[KAPPA] == motion[2, 1] - motion[1, 1]  # of the stretch phi_S - phi_M
    assert numbers[OMEGA] == np.sqrt(abs(numbers[KAPPA]))


@toys
@moving
def test_constraints_of_closed_contacts(toy: Toy, states: States) -> None:
    """A closed gap does not accelerate, exactly; a sticking point does not either [Eq. 3].

    lambda_T = -mu lambda_N in slip +, +mu lambda_N in slip -.
    """
    numbers, (normal, tangential) = row(toy, states), directions(toy)
    motion = np.column_stack([numbers[A : A + 3], numbers[B : B + 3]])
    mu = (toy.mu_1, toy.mu_2, toy.mu_3)
    for i in closed(states):
        assert (normal[i] @ motion == 0.0).all()
        if states[i] == STICK:
            size = np.abs(tangential[i]) @ np.abs(motion)
            assert (np.abs(tangential[i] @ motion) <= SOLVED * size).all()
        else:
            lambda_n, lambda_t = forces(numbers, i)
            expected = -SLIP_SIGN[states[i]] * mu[i] * lambda_n
            np.testing.assert_allclose(lambda_t, expected, rtol=SOLVED)


@pytest.mark.parametrize("states", LOCKED, ids=label)
def test_two_sticking_contacts_do_not_move(states: States) -> None:
    assert (row(Toy(), states)[:GUARDS] == 0.0).all()


# --- Numbers --------------------------------------------------------------------------------------


def test_frequencies_of_the_modes() -> None:
    """Free flight swings at 72.91 Hz, the jammed toy at sqrt(c_phi / (J_S + m_S l_G^2))."""
    toy = Toy()
    free, jammed = row(toy, (OPEN, OPEN, OPEN)), row(toy, (OPEN, STICK, OPEN))
    expected = 2.0 * np.pi * mechanics.free_frequency(toy)
    np.testing.assert_allclose(free[OMEGA], expected, rtol=SOLVED)
    inertia = toy.j_s + toy.m_s * toy.l_g**2
    np.testing.assert_allclose(-jammed[KAPPA], toy.c_phi / inertia, rtol=SOLVED)
    assert free[KAPPA] < 0.0
    # friction pushes the sleeve and through it the bird: this slip does not swing
    assert row(toy, (OPEN, OPEN, UP))[KAPPA] == pytest.approx(532.49, abs=5e-3)


# --- Rows of the contacts and the forces ----------------------------------------------------------


@toys
def test_rows_of_the_contacts(toy: Toy) -> None:
    numbers, (normal, tangential) = model(toy), directions(toy)
    mass: FloatArray = np.array(mechanics.mass_matrix(toy))
    rows = numbers[CONTACT : CONTACT + 3]
    assert rows[:, MU].tolist() == [toy.mu_1, toy.mu_2, toy.mu_3]
    assert (rows[:, TANGENT : TANGENT + 3] == tangential).all()
    levers = numbers[FORCE, LEVER : LEVER + 3]
    assert levers.tolist() == [toy.h_s, toy.h_m, toy.h_m]
    np.testing.assert_allclose(rows[:, LIMIT] * levers, mechanics.gap_offsets(toy), rtol=1e-15)
    both = np.stack([normal, tangential], axis=1).reshape(6, 3)  # N1, T1, N2, T2, N3, T3
    kicks = np.stack(
        [rows[:, RESPONSE_N : RESPONSE_N + 3], rows[:, RESPONSE_T : RESPONSE_T + 3]], axis=1
    ).reshape(6, 3)
    size = np.abs(kicks) @ np.abs(mass)
    assert (np.abs(kicks @ mass - both) <= SOLVED * size).all()  # M^-1 w
    delassus = numbers[DELASSUS : DELASSUS + 6, :6]
    product = np.abs(both) @ np.abs(kicks.T)
    assert (np.abs(delassus - both @ kicks.T) <= 4e-16 * product).all()  # sums of three terms
    root = np.sqrt(np.diag(delassus))
    np.testing.assert_allclose(  # symmetric up to the solution's error
        delassus / np.outer(root, root), delassus.T / np.outer(root, root), atol=SOLVED
    )
    assert numbers[FORCE, :3].tolist() == list(mechanics.force_at_rest(toy))
    assert numbers[FORCE, 3:6].tolist() == list(mechanics.force_per_stretch(toy))
    assert numbers[FORCE, POLE] == toy.pole


# --- What the table depends on --------------------------------------------------------------------


def test_each_model_is_a_copy() -> None:
    model(Toy())[:] = 0.0
    assert model(Toy())[0, KAPPA] != 0.0
    assert model(Toy()).shape == SHAPE
