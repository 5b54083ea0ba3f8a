"""Impacts of one contact by both solvers: closed forms, and problems without one solution."""

import math
from collections.abc import Callable
from itertools import product

import hypothesis.strategies as st
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given as drawn
from lcp_oracles import contact_residual, enumerate_contacts
from thoroughness import thorough

from woodpecker.mechanics.cases import BACKWARD, FORWARD, FREE, HOLD, REST
from woodpecker.mechanics.contact_problems import AMBIGUOUS, NO_SOLUTION, SOLVED
from woodpecker.mechanics.impact_terms import alone
from woodpecker.mechanics.lcp import solve_contact_lcp

# Closed forms with condition near 1: some roundings of 1e-16.
EXACT = 1e-13
# Lemke's path breaks ties of 1e-11, and a boundary may be taken for its other side; a margin of 10.
RESIDUAL = 1e-10

EPSILON = float(np.finfo(float).eps)

Answer = tuple[int, int, float, float]  # outcome, case, and impulses (N, T)
Solver = Callable[[npt.ArrayLike, npt.ArrayLike, float, float], Answer]


def by_lemke(g: npt.ArrayLike, free: npt.ArrayLike, mu: float, floor: float) -> Answer:
    """As enumeration of all bases has it, too; the case is that of the velocities."""
    found = solve_contact_lcp(g, free, mu, floor)
    impulse = np.append(found.impulse_n, found.impulse_t)
    (only,) = enumerate_contacts(g, free, mu, floor)
    assert np.append(only.impulse_n, only.impulse_t) == pytest.approx(impulse, abs=RESIDUAL)
    assert contact_residual(found, g, free, mu, floor) < RESIDUAL
    (v_n, v_t) = np.asarray(g) @ impulse + free
    assert (found.gamma_n[0], found.gamma_t[0]) == pytest.approx((v_n, v_t), abs=RESIDUAL)
    slides = HOLD if abs(v_t) < RESIDUAL else FORWARD if v_t > 0.0 else BACKWARD
    opens = v_n > RESIDUAL or impulse[0] < floor + RESIDUAL
    return SOLVED, 3 * (FREE if opens else REST) + slides, *impulse.tolist()


def directly(g: npt.ArrayLike, free: npt.ArrayLike, mu: float, floor: float) -> Answer:
    return alone(np.array(g), np.array(free), mu, np.float64(floor), True)


each_solver = pytest.mark.parametrize("solver", [by_lemke, directly], ids=["Lemke", "direct"])

COUPLED = [[2.0, 0.5], [0.5, 1.0]]  # g_nn, g_nt | g_nt, g_tt in 1/kg; determinant 1.75
POINT = [[2.0, 0.0], [0.0, 4.0]]  # masses 1/2 and 1/4 in the two directions
CASES = [
    # Stick: -G^-1 (-7, 0) = (4, -2).
    (COUPLED, (-7.0, 0.0), 0.6, 0.0, 3 * REST + HOLD, (4.0, -2.0)),
    # Slip forward: Lambda_N = 7 / (2 - 0.5 mu).
    (COUPLED, (-7.0, 5.0), 0.5, 0.0, 3 * REST + FORWARD, (4.0, -2.0)),
    # Slip backward: Lambda_N = 9 / (2 + 0.5 mu).
    (COUPLED, (-9.0, -8.0), 0.5, 0.0, 3 * REST + BACKWARD, (4.0, 2.0)),
    # Separation, sliding either way: no impulse.
    (COUPLED, (1.0, -3.0), 0.5, 0.0, 3 * FREE + BACKWARD, (0.0, 0.0)),
    (COUPLED, (1.0, 3.0), 0.5, 0.0, 3 * FREE + FORWARD, (0.0, 0.0)),
    # Expansion from rest with Lambda_N = 1: gamma_T = 0.5 + Lambda_T, held by mu >= 0.5.
    (COUPLED, (0.0, 0.0), 0.6, 1.0, 3 * FREE + HOLD, (1.0, -0.5)),
    (COUPLED, (0.0, 0.0), 0.4, 1.0, 3 * FREE + FORWARD, (1.0, -0.4)),
    (COUPLED, (0.0, -2.0), 0.4, 1.0, 3 * FREE + BACKWARD, (1.0, 0.4)),
    # The floor is too low to keep the contact from closing: 4 > 1 as in the first case.
    (COUPLED, (-7.0, 0.0), 0.6, 1.0, 3 * REST + HOLD, (4.0, -2.0)),
    # G_NN - mu G_NT = 0: sliding forward cannot stop the approach, sticking can.
    ([[1.0, 0.5], [0.5, 1.0]], (-3.0, 0.0), 2.0, 0.0, 3 * REST + HOLD, (4.0, -2.0)),
    # A mass point, by hand.
    (POINT, (-2.0, 0.5), 0.0, 0.0, 3 * REST + FORWARD, (1.0, 0.0)),
    (POINT, (-2.0, 4.0), 0.3, 0.0, 3 * REST + FORWARD, (1.0, -0.3)),
    (POINT, (-2.0, -4.0), 0.3, 0.0, 3 * REST + BACKWARD, (1.0, 0.3)),
    (POINT, (-2.0, 1.0), 0.5, 0.0, 3 * REST + HOLD, (1.0, -0.25)),
    (POINT, (0.0, 1.0), 0.5, 0.8, 3 * FREE + HOLD, (0.8, -0.25)),
    (POINT, (0.0, 3.0), 0.5, 0.8, 3 * FREE + FORWARD, (0.8, -0.4)),
]


@each_solver
@pytest.mark.parametrize(("g", "free", "mu", "floor", "case", "impulse"), CASES)
def test_closed_forms(
    g: list[list[float]], free: tuple[float, float], mu: float, floor: float, case: int,
    impulse: tuple[float, float], solver: Solver,
) -> None:  # fmt: skip
    outcome, found, *impulses = solver(g, free, mu, floor)
    assert (outcome, found) == (SOLVED, case)
    assert impulses == pytest.approx(impulse, abs=10.0 * EXACT)


@each_solver
@thorough(15)
@drawn(free_n=st.floats(-5.0, 5.0), free_t=st.floats(-5.0, 5.0), floor=st.floats(0.0, 3.0))
def test_without_friction(solver: Solver, free_n: float, free_t: float, floor: float) -> None:
    """mu = 0: Lambda_N = max(floor, -free_N / G_NN), nothing tangential."""
    outcome, _, *impulses = solver(COUPLED, (free_n, free_t), 0.0, floor)
    assert outcome == SOLVED
    assert impulses == pytest.approx([max(floor, -free_n / 2.0), 0.0], abs=RESIDUAL)


@pytest.mark.parametrize(
    ("free", "floor", "case"),
    [
        ((-2.0, 2.0 + 4.0 * EPSILON), 0.0, 3 * REST + HOLD),  # outside the cone by a rounding
        ((-2.0 + 2.0 * EPSILON, 3.0), 1.0, 3 * REST + FORWARD),  # below the floor by a rounding
    ],
)
def test_on_a_boundary_it_rests_and_sticks(
    free: tuple[float, float], floor: float, case: int
) -> None:
    assert directly(POINT, free, 0.5, floor) == (
        SOLVED,
        case,
        pytest.approx(1.0),
        pytest.approx(-0.5),
    )


def test_on_a_boundary_rounding_leaves_a_solution() -> None:
    """However little two directions differ, with det(G) down to 1e-10 G_NN G_TT."""
    rng = np.random.default_rng(4)
    for digits in range(1, 11):
        for mu, g_tt in 10.0 ** rng.uniform(-1.0, 1.0, (40, 2)):
            g_nt = math.sqrt((1.0 - 10.0**-digits) * g_tt)
            g = np.array([[1.0, g_nt], [g_nt, g_tt]])
            for along, floor in product((mu, 0.5 * mu, -0.5 * mu, -mu), (0.0, 1.0)):
                assert directly(g, -g @ (1.0, along), mu, floor)[0] != NO_SOLUTION


def test_parallel_directions_do_not_stick() -> None:
    """G is singular: sliding forward, Lambda_N = 1 / (1 - mu)."""
    found = directly([[1.0, 1.0], [1.0, 1.0]], (-1.0, 0.0), 0.5, 0.0)
    assert found == (SOLVED, 3 * REST + FORWARD, 2.0, -1.0)


@pytest.mark.parametrize(("g", "rubs"), [(COUPLED, False), ([[2.0, 0.0], [0.0, 0.0]], True)])
def test_without_a_tangent_there_is_no_tangential_impulse(g: list[list[float]], rubs: bool) -> None:
    found = alone(np.array(g), np.array([-1.0, -3.0 * g[1][1]]), 0.0, np.float64(0.0), rubs)
    assert found == (SOLVED, 3 * REST + FORWARD, 0.5, 0.0)


def test_solutions_are_those_of_lemkes_path() -> None:
    """Directions that friction couples weakly: one solution, whose condition is below 1e3."""
    rng = np.random.default_rng(11)
    for _ in range(60):
        root, velocity = rng.normal(size=(2, 4)), rng.normal(size=2)
        problem = root @ root.T + np.eye(2), velocity, rng.uniform(0.0, 0.3), rng.uniform()
        own, other = directly(*problem), by_lemke(*problem)
        assert own[:2] == other[:2]
        assert own[2:] == pytest.approx(other[2:], abs=1e-12)


@pytest.mark.parametrize(
    ("g", "free", "mu", "outcome"),
    [
        # It opens at once with (1, 3), or its impulses (1, -2) leave it with (0, 1).
        ([[1.0, 1.0], [1.0, 1.5]], (1.0, 3.0), 2.0, AMBIGUOUS),
        # A rod that may separate, slide or stick, see test_lcp.
        ([[1.6, -1.2], [-1.2, 3.4]], (1.0, -8.0), 2.0, AMBIGUOUS),
        # A positive definite G has an answer; this one, of no body, presses against all friction.
        ([[1.0, 2.0], [2.0, 1.0]], (-1.0, 0.0), 1.0, NO_SOLUTION),
    ],
)
def test_several_answers_and_none_are_reported(
    g: list[list[float]], free: tuple[float, float], mu: float, outcome: int
) -> None:
    """As many as enumeration has."""
    answers = len(enumerate_contacts(g, free, mu))
    assert (answers > 1) if outcome == AMBIGUOUS else (answers == 0)
    assert directly(g, free, mu, 0.0)[0] == outcome


def test_a_velocity_without_a_value_has_no_solution() -> None:
    assert directly([[1.0, 1.0], [1.0, 1.5]], (math.nan, 3.0), 2.0, 0.0)[0] == NO_SOLUTION
