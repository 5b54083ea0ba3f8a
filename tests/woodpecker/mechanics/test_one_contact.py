"""Impacts of one contact: closed forms, Lemke's path, and problems without one solution."""

import math

import numpy as np
import pytest

from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.mechanics.one_contact import (
    AMBIGUOUS,
    BACKWARD,
    FORWARD,
    FREE,
    HOLD,
    NO_SOLUTION,
    REST,
    SOLVED,
    given,
    one_contact,
    stated,
)

STRONG = np.array([[1.0, 1.0], [1.0, 1.5]])  # with mu = 2 friction more than undoes the impulse


@pytest.mark.slow
@pytest.mark.parametrize(
    ("velocity", "mu", "floor", "case", "impulse"),
    [
        ((-2.0, 0.5), 0.0, 0.0, 3 * REST + FORWARD, (1.0, 0.0)),
        ((-2.0, 4.0), 0.3, 0.0, 3 * REST + FORWARD, (1.0, -0.3)),
        ((-2.0, -4.0), 0.3, 0.0, 3 * REST + BACKWARD, (1.0, 0.3)),
        ((-2.0, 1.0), 0.5, 0.0, 3 * REST + HOLD, (1.0, -0.25)),
        ((1.0, 3.0), 0.5, 0.0, 3 * FREE + FORWARD, (0.0, 0.0)),
        ((0.0, 1.0), 0.5, 0.8, 3 * FREE + HOLD, (0.8, -0.25)),
        ((0.0, 3.0), 0.5, 0.8, 3 * FREE + FORWARD, (0.8, -0.4)),
    ],
)
def test_cases_of_a_mass_point(
    velocity: tuple[float, float], mu: float, floor: float, case: int,
    impulse: tuple[float, float],
) -> None:  # fmt: skip
    """Masses 1/2 and 1/4 in the two directions: g = (2, 4), and everything follows by hand."""
    found = one_contact(np.diag([2.0, 4.0]), np.array(velocity), mu, floor, True)
    assert found == (SOLVED, case, *(pytest.approx(each, abs=1e-15) for each in impulse))


def test_without_friction_there_is_no_tangential_impulse() -> None:
    found = one_contact(np.array([[2.0, 0.0], [0.0, 0.0]]), np.array([-1.0, 0.0]), 0.0, 0.0, False)
    assert found == (SOLVED, 3 * REST + FORWARD, 0.5, 0.0)


def test_solutions_are_those_of_lemkes_path() -> None:
    """Directions that friction couples weakly: one solution, whose condition is below 1e3."""
    rng = np.random.default_rng(11)
    for _ in range(300):
        root, velocity = rng.normal(size=(2, 4)), rng.normal(size=2)
        delassus, mu, floor = root @ root.T + np.eye(2), rng.uniform(0.0, 0.3), rng.uniform()
        status, case, *impulse = one_contact(delassus, velocity, mu, floor, True)
        other = solve_contact_lcp(delassus, velocity, mu, floor)
        assert status == SOLVED
        assert impulse[0] == pytest.approx(other.impulse_n[0], abs=1e-12)
        assert impulse[1] == pytest.approx(other.impulse_t[0], abs=1e-12)
        assert (case // 3 == FREE) == (other.gamma_n[0] > 1e-12)


def test_several_solutions_and_none() -> None:
    """It opens at once with (1, 3), or its impulses (1, -2) leave it with (0, 1)."""
    assert one_contact(STRONG, np.array([1.0, 3.0]), 2.0, 0.0, True)[0] == AMBIGUOUS
    assert one_contact(STRONG, np.array([math.nan, 3.0]), 2.0, 0.0, True)[0] == NO_SOLUTION


@pytest.mark.nightly
@pytest.mark.slow
def test_what_an_impact_consists_of() -> None:
    rng = np.random.default_rng(2)
    root, w_n, w_t = rng.normal(size=(3, 3)), rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    rates, slips, mu, eps = rng.normal(size=(4, 4))
    mass, contacts, still = root @ root.T + np.eye(3), np.array([0, 2]), np.array([0, 1, 0, 0])
    found = stated(mass, w_n, w_t, rates, slips, mu, eps, contacts, still)
    w = np.vstack([w_n[[0, 2]], w_t[[0, 2]]])
    assert found[0] == pytest.approx(w @ np.linalg.inv(mass) @ w.T, rel=1e-12)
    assert found[1] == pytest.approx(np.linalg.inv(mass) @ w.T, rel=1e-12)
    assert found[2].tolist() == [rates[0], 0.0, slips[0], slips[2]]
    assert [found[3].tolist(), found[4].tolist()] == [mu[[0, 2]].tolist(), eps[[0, 2]].tolist()]

    u, impulse, into = rng.normal(size=3), rng.normal(size=4), np.zeros((2, 4))
    after, left, floor = given(*found[:3], u, impulse, found[4], contacts, into)
    assert mass @ (after - u) == pytest.approx(w.T @ impulse, rel=1e-11)
    assert left - found[2] == pytest.approx(w @ (after - u), rel=1e-11)
    assert floor.tolist() == (found[4] * impulse[:2]).tolist()
    assert into.tolist() == [[impulse[0], 0.0, impulse[1], 0.0], [impulse[2], 0.0, impulse[3], 0.0]]
