"""When an impact can add energy: a bound, where it holds, and one example of each that does not.

Let K = Lambda_C . G Lambda_C / 2, and D >= 0 what friction takes in compression. Compression takes
K + D. With F the friction matrix of the expansion and e the largest eps_N, the impulses y of
another expansion that are admissible for this one's bounds,

    y_N >= floor,   |y_T| <= F Lambda_NE,

satisfy (y - Lambda_E) . gamma_E >= 0: that is what complementarity and sliding friction say. The
energy of the expansion, E(x) = x . gamma_C + x . G x / 2, is convex and gamma_E its gradient at
Lambda_E, so E(Lambda_E) <= E(y). Where y = e Lambda_C is admissible the impact changes the energy
by at most

    -K - D + E(e Lambda_C) = -(1 - e^2) K - (1 + e) D <= 0.                                (BOUND)

- All eps_N equal: Lambda_NE >= e Lambda_NC, so it is, for any mu and any F >= diag(mu).
- No friction: y_T = 0, so it is.
- Otherwise it is where e |Lambda_TC| <= F (eps_N Lambda_NC): always at the contact with eps_N = e.

Where it is not, shrink the compressive impulse of the other contact k to y_k = s e Lambda_Ck until
it is. With the sum as bound s >= Lambda_N1 / Lambda_Nk will do, and y . G y, convex in s, is still
at most e^2 Lambda_C . G Lambda_C if for all directions l_1 = (1, a), l_k = (1, b) in the cones

    l_k . G_kk l_k + l_1 . G_1k l_k >= 0.                                                   (FORM)

Then the energy changes by at most -(1 - e^2) K - D.                              (WEAKER BOUND)
"""

import math
from dataclasses import dataclass

import hypothesis.strategies as st
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from impacts import directions, frictions, laws, restitutions, scenes, strike
from lcp_oracles import enumerate_contacts
from scipy.optimize import brentq
from thoroughness import thorough

from woodpecker import ExpansionFriction, Toy
from woodpecker.base.compiled import COMPILED
from woodpecker.mechanics import equations as mechanics
from woodpecker.mechanics.contact_problems import INDETERMINATE, SOLVED
from woodpecker.mechanics.modes import ANGLE, SIGN

FloatArray = npt.NDArray[np.float64]
SUMMED, SEPARATE = ExpansionFriction.SUMMED, ExpansionFriction.SEPARATE

often = thorough(300 if COMPILED else 30)

# Energies over the energy before: impulses are good to 1e-11 of it, see test_impacts.SOLVES, and
# the difference of energies is a sum of products with them.
ROUNDING = 1e-10

PAIRS = {"1+2": (0, 1), "1+3": (0, 2)}


def kinetic(toy: Toy, u: npt.ArrayLike) -> float:
    v = np.asarray(u)
    return float(0.5 * v @ np.array(mechanics.mass_matrix(toy)) @ v)


def delassus(toy: Toy, contacts: tuple[int, ...]) -> FloatArray:
    w = directions(toy, contacts)
    return np.asarray(w.T @ np.linalg.solve(mechanics.mass_matrix(toy), w))


def state(rng: np.random.Generator, toy: Toy, contacts: tuple[int, ...]) -> FloatArray:
    """Velocities of energy 1/2, evenly over all directions in which the contacts close or rest."""
    root = np.linalg.cholesky(np.array(mechanics.mass_matrix(toy)))
    direction = rng.normal(size=3)
    u: FloatArray = np.linalg.solve(root.T, direction / np.linalg.norm(direction))
    for i in contacts:
        u[ANGLE[i]] = -SIGN[i] * abs(u[ANGLE[i]])
    if len(contacts) == 2 and rng.random() < 0.3:
        u[ANGLE[contacts[rng.integers(2)]]] = 0.0
    return u


def some_toy(rng: np.random.Generator, mu_max: float, law: ExpansionFriction) -> Toy:
    """Frictions up to ``mu_max``; restitutions often near 1, where gains are to be feared."""
    mu, eps = rng.uniform(0.0, mu_max, size=3), rng.uniform(size=3) ** 0.3
    eps *= rng.random(3) < 0.7
    return Toy(
        mu_1=mu[0], mu_2=mu[1], mu_3=mu[2], eps_n1=eps[0], eps_n2=eps[1], eps_n3=eps[2],
        expansion_friction=law,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Energies of an impact over the energy before it; nan where it has no one solution."""

    gain: float
    bound: float

    @property
    def unique(self) -> bool:
        return not math.isnan(self.gain)


def balance(toy: Toy, contacts: tuple[int, ...], u: FloatArray) -> Balance:
    blow = strike(toy, contacts, u)
    if blow.outcome not in (SOLVED, INDETERMINATE):
        return Balance(gain=math.nan, bound=math.nan)
    g, free = delassus(toy, contacts), directions(toy, contacts).T @ u
    pressed = blow.impulses[0, : len(free)]
    k, d = 0.5 * pressed @ g @ pressed, -pressed[1::2] @ (g @ pressed + free)[1::2]
    e, before = restitutions(toy, contacts).max(), kinetic(toy, u)
    return Balance(
        gain=kinetic(toy, blow.u) / before - 1.0,
        bound=(-(1.0 - e**2) * k - (1.0 + e) * d) / before,
    )


# --- Where the bound holds ------------------------------------------------------------------------


@pytest.mark.nightly
@laws
@scenes
@often
@given(
    seed=st.integers(0, 2**32 - 1), eps=st.none() | st.floats(0.0, 1.0),
    mu_max=st.floats(0.0, 3.0),
)  # fmt: skip
def test_equal_restitutions_or_no_friction_lose_energy(
    contacts: tuple[int, ...], law: ExpansionFriction, seed: int, eps: float | None, mu_max: float
) -> None:
    """Either law; one contact is a case of it. ``eps`` of all contacts, or no friction."""
    rng = np.random.default_rng(seed)
    toy = some_toy(rng, 0.0 if eps is None else mu_max, law)
    if eps is not None:
        toy = toy.replace(eps_n1=eps, eps_n2=eps, eps_n3=eps)
    energy = balance(toy, contacts, state(rng, toy, contacts))
    assume(energy.unique)
    assert energy.gain <= energy.bound + ROUNDING
    assert energy.bound <= ROUNDING


def form(toy: Toy, contacts: tuple[int, int]) -> float:
    """Least value of FORM for both orders of the contacts, over the first G_NN.

    Linear in a, so least at an end; quadratic in b, so least at an end or where it is level.
    """
    g, mu = delassus(toy, contacts), frictions(toy, contacts)
    least = np.inf
    for own, other in ((0, 1), (1, 0)):
        here, there = slice(2 * own, 2 * own + 2), slice(2 * other, 2 * other + 2)
        for a in (-mu[other], mu[other]):
            push = g[here, there] @ [1.0, a]
            (n, c), (_, t) = g[here, here]
            level = -(2.0 * c + push[1]) / (2.0 * t)
            for b in (-mu[own], mu[own], np.clip(level, -mu[own], mu[own])):
                least = min(least, n + 2.0 * c * b + t * b * b + push @ [1.0, b])
    return float(least / g[0, 0])


def test_with_the_papers_friction_the_sum_never_adds_energy() -> None:
    """FORM > 0 at mu = 0.3, so no state and no restitutions do; equal mu: up to 0.43223."""
    assert form(Toy(), (0, 1)) == pytest.approx(0.677105, abs=1e-6)
    assert form(Toy(), (0, 2)) == pytest.approx(0.276043, abs=1e-6)
    limits = [
        brentq(lambda mu, pair=pair: form(Toy(mu_1=mu, mu_2=mu, mu_3=mu), pair), 0.1, 3.0)
        for pair in PAIRS.values()
    ]
    assert limits == pytest.approx([1.131912, 0.432231], abs=1e-6)


# --- Where it does not ----------------------------------------------------------------------------


def test_contact_by_contact_adds_energy_with_unequal_restitutions() -> None:
    """Sleeve and beak strike at once: the beak's expansion is elastic, the sleeve's friction gone.

    In compression the upper edge's friction 0.6 Lambda_N3 holds against the beak. In expansion it
    has less than half of that left, contact by contact; under the sum it has more.
    """
    u = np.array([-0.26, 20.03, 10.0])
    gains = {}
    for law in ExpansionFriction:
        toy = Toy(mu_1=0.0, mu_3=0.6, eps_n1=0.95, expansion_friction=law)
        blow = strike(toy, PAIRS["1+3"], u)
        assert blow.outcome == SOLVED
        gains[law] = kinetic(toy, blow.u) / kinetic(toy, u) - 1.0
        equal = toy.replace(eps_n3=0.95)
        assert kinetic(equal, strike(equal, PAIRS["1+3"], u).u) < kinetic(equal, u)
    assert gains[SEPARATE] == pytest.approx(0.06083, abs=1e-5)
    assert gains[SUMMED] == pytest.approx(-0.32484, abs=1e-5)


def test_the_sum_can_add_energy_to_other_bodies() -> None:
    """Two contacts that almost jam, G near rank 2: normals and tangents opposed in pairs.

    Compression ends at rest with Lambda = (1, 1.4, 1.4, 0.95) by construction, from a velocity of
    order eta. In expansion Lambda_N1 = 1 is met by Lambda_T2 = -+ 0.7 at most, and 0.3 of it goes
    into the motion, which is more.
    """
    eta, mu, eps = 0.05, np.array([1.5, 0.7]), np.array([1.0, 0.0])
    w = np.array([[1, 0, 0, -1], [0, -1, 1, 0], [eta, 0, 0, eta], [0, eta, eta, 0]])  # N1 T1 N2 T2
    w = w[:, [0, 2, 1, 3]]  # normals first
    g, u = w.T @ w, -w @ [1.0, 1.4, 1.4, 0.95]
    (pressed,) = enumerate_contacts(g, w.T @ u, mu)
    np.testing.assert_allclose(pressed.impulse_n, [1.0, 1.4], rtol=1e-9)
    np.testing.assert_allclose(pressed.impulse_t, [1.4, 0.95], rtol=1e-9)
    friction = np.outer(mu, [1.0, 1.0])
    (released,) = enumerate_contacts(g, np.zeros(4), friction, eps * pressed.impulse_n)
    np.testing.assert_allclose(released.impulse_n, [1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(released.impulse_t, [0.0, 0.7], atol=1e-9)
    after = w @ [1.0, 0.0, 0.0, 0.7]
    np.testing.assert_allclose(after, [0.3, 0.0, 1.7 * eta, 0.0], atol=1e-15)
    assert 0.5 * after @ after > 2.0 * 0.5 * u @ u
