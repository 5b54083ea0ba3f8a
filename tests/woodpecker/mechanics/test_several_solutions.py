"""A contact problem on velocity level has a solution, and with strong friction several."""

from __future__ import annotations

import numpy as np
import pytest
from lcp_oracles import contact_residual, enumerate_contacts

from woodpecker.mechanics.lcp import solve_contact_lcp

# As in test_lcp: rounding over bases of condition up to 1e5, and solutions that are one.
RESIDUAL, SAME = 1e-10, 1e-6


def test_strong_friction_has_several_solutions() -> None:
    """By hand, with G = [[1, 1], [1, 2]], free = (0.1, 1) and mu = 1.5: open, sliding and sticking.

    The contact separates as it is; but sliding friction presses it on by more than the impulse
    itself opens it (1 - 1.5 < 0), so that it may as well slide with 0.2, or stick.
    """
    g, free, mu = np.array([[1.0, 1.0], [1.0, 2.0]]), np.array([0.1, 1.0]), 1.5
    every = enumerate_contacts(g, free, mu)
    found = sorted(
        (*each.impulse_n, *each.impulse_t, *each.gamma_n, *each.gamma_t) for each in every
    )
    known = [(0.0, 0.0, 0.1, 1.0), (0.2, -0.3, 0.0, 0.6), (0.8, -0.9, 0.0, 0.0)]
    np.testing.assert_allclose(found, known, atol=1e-15)
    one = solve_contact_lcp(g, free, mu)
    assert one.success
    assert contact_residual(one, g, free, mu) < RESIDUAL


@pytest.mark.slow
def test_closing_contacts_of_a_motion_have_a_solution_or_several() -> None:
    """Two contacts of a body with two coordinates: some twenty of a thousand have several."""
    rng, several = np.random.default_rng(6), 0
    for _ in range(150):
        root, w, u = rng.normal(size=(2, 2)), rng.normal(size=(2, 4)), rng.normal(size=2)
        w[:, :2] *= -np.sign(u @ w[:, :2])  # both close
        g, free = w.T @ np.linalg.solve(root @ root.T + 2.0 * np.eye(2), w), w.T @ u
        mu = rng.uniform(0.0, 0.6, 2)
        one, every = solve_contact_lcp(g, free, mu), enumerate_contacts(g, free, mu)
        assert contact_residual(one, g, free, mu) < RESIDUAL
        velocities = np.array([(*each.gamma_n, *each.gamma_t) for each in every])
        mine = np.append(one.gamma_n, one.gamma_t)
        away = np.abs(velocities - mine).max(axis=1)
        assert away.min() < SAME * np.abs(free).max()
        several += away.max() > 0.01 * np.abs(free).max()
    assert several > 0
