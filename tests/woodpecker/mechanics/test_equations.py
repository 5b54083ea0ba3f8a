"""Equations 6-10 rederived from the geometry with sympy; the numbers the paper prints."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

from woodpecker import Toy, parameters
from woodpecker.mechanics import equations as mechanics

# Sums and products of a few terms of one sign or nearly so: some roundings of 1.1e-16.
EXACT = 1e-14

P = SimpleNamespace(**{name: sp.Symbol(name, positive=True) for name in parameters()})
Q = sp.symbols("y phi_M phi_S", real=True)
U = sp.symbols("dy dphi_M dphi_S", real=True)
Y, PHI_M, PHI_S = Q

FUNCTIONS = [
    mechanics.mass_matrix,
    mechanics.force_at_rest,
    mechanics.force_per_stretch,
    mechanics.gap_offsets,
    mechanics.normal_directions,
    mechanics.tangential_directions,
]


def random_toys(seed: int, count: int) -> list[Toy]:
    """Toys whose masses, inertias and stiffness differ by up to a factor of 30 from the paper's."""
    rng, toys = np.random.default_rng(seed), []
    for _ in range(count):
        factors = 10.0 ** rng.uniform(-1.5, 1.5, size=5)
        names = ("m_m", "j_m", "m_s", "j_s", "c_phi")
        changes = {n: getattr(Toy(), n) * f for n, f in zip(names, factors, strict=True)}
        toys.append(Toy(**changes))
    return toys


def numbers(toy: Toy) -> dict[sp.Symbol, float]:
    return {getattr(P, name): getattr(toy, name) for name in parameters() if name != "pole"}


# --- The geometry ---------------------------------------------------------------------------------


def turned(angle: sp.Symbol, x: sp.Expr, z: sp.Expr) -> sp.Matrix:
    return sp.Matrix([[sp.cos(angle), -sp.sin(angle)], [sp.sin(angle), sp.cos(angle)]]) * sp.Matrix(
        [x, z]
    )


# Points of the bodies (x outward from the axis of the pole, z upward) as functions of q [Fig. 3].
CENTRE_M = sp.Matrix([0, Y])
SPRING = CENTRE_M + turned(PHI_M, P.l_m, 0)
CENTRE_S = SPRING + turned(PHI_S, P.l_g, 0)
BEAK = SPRING + turned(PHI_S, P.l_g - P.l_s, P.h_s)
LOWER = CENTRE_M + turned(PHI_M, P.r_m, -P.h_m)
UPPER = CENTRE_M + turned(PHI_M, P.r_m, P.h_m)
POINTS = (BEAK, LOWER, UPPER)
STRAIGHT = dict.fromkeys(Q, 0)


def gradient(expression: sp.Expr) -> list[sp.Expr]:
    """Linearized kinematics: the gradient at q = 0."""
    return [sp.diff(expression, q).subs(STRAIGHT) for q in Q]


def assert_same(one: object, other: object) -> None:
    """Exactly the same polynomials."""
    assert sp.Matrix(one).shape == sp.Matrix(other).shape
    assert (sp.Matrix(one) - sp.Matrix(other)).expand().is_zero_matrix


def test_gaps_are_the_distances_of_the_points_from_the_pole() -> None:
    assert_same(mechanics.gap_offsets(P), [point[0].subs(STRAIGHT) - P.r_0 for point in POINTS])


def test_normal_directions_are_gradients_of_the_gaps() -> None:
    assert_same(mechanics.normal_directions(P), [gradient(point[0] - P.r_0) for point in POINTS])


def test_tangential_directions_are_gradients_of_the_heights() -> None:
    assert_same(mechanics.tangential_directions(P), [gradient(point[1]) for point in POINTS])


def kinetic_energy() -> sp.Expr:
    """Of the linearized motion; the horizontal motion of both centres is of second order."""
    speed_m, speed_s = (sp.Matrix(gradient(c[1])).dot(U) for c in (CENTRE_M, CENTRE_S))
    rotation = P.j_m * U[1] ** 2 + P.j_s * U[2] ** 2
    return (P.m_m * speed_m**2 + P.m_s * speed_s**2 + rotation) / 2


def potential_energy() -> sp.Expr:
    """Of the linearized heights and the spring."""
    height_m, height_s = (sp.Matrix(gradient(c[1])).dot(Q) for c in (CENTRE_M, CENTRE_S))
    return P.g * (P.m_m * height_m + P.m_s * height_s) + P.c_phi * (PHI_S - PHI_M) ** 2 / 2


def test_mass_matrix_is_the_hessian_of_the_kinetic_energy() -> None:
    """Hence J_M in entry (2, 2)."""
    assert_same(mechanics.mass_matrix(P), sp.hessian(kinetic_energy(), U))


def test_forces_are_the_gradient_of_the_potential_energy() -> None:
    """Hence g in the first row."""
    d = PHI_S - PHI_M
    h_0, h_1 = mechanics.force_at_rest(P), mechanics.force_per_stretch(P)
    h = [a + b * d for a, b in zip(h_0, h_1, strict=True)]
    assert_same(h, [-sp.diff(potential_energy(), q) for q in Q])


# --- Backends -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
def test_sympy_and_floats_agree(function) -> None:  # type: ignore[no-untyped-def]
    for toy in random_toys(1, 20):
        expected = np.array(sp.Array(function(P)).subs(numbers(toy)).tolist(), dtype=float)
        found = np.array(function(toy))
        assert found.shape == expected.shape
        # Gap offsets are differences of numbers ten times larger: EXACT of those.
        np.testing.assert_allclose(found, expected, rtol=EXACT, atol=EXACT * 0.025)


def test_arrays_of_toys_broadcast() -> None:
    """One toy whose fields are arrays gives the same numbers as many toys."""
    toys = random_toys(2, 5)
    many = SimpleNamespace(
        **{name: np.array([getattr(toy, name) for toy in toys]) for name in parameters()}
    )
    for function in FUNCTIONS:
        one = np.array(function(many))
        assert (np.moveaxis(one, -1, 0) == np.array([function(toy) for toy in toys])).all()


# --- Numbers of the paper -------------------------------------------------------------------------


def test_eigenfrequency() -> None:
    """72.91 Hz as printed. Entry (2, 2) as printed, J_S for J_M, would make it 20.09 Hz."""
    toy = Toy()
    assert mechanics.free_frequency(toy) == pytest.approx(72.908, abs=5e-4)  # printed digits
    misprint = mechanics.free_frequency(toy.replace(j_m=toy.j_s))  # J_M occurs nowhere else
    assert misprint == pytest.approx(20.09, abs=5e-3)


def test_eigenfrequency_is_the_only_one() -> None:
    """M^-1 times the stiffness has the eigenvalues 0, 0, omega^2."""
    for toy in [Toy(), *random_toys(4, 20)]:
        force = np.array(mechanics.force_per_stretch(toy))
        stiffness = -np.outer(force, [0.0, -1.0, 1.0])
        every = np.linalg.eigvals(np.linalg.solve(mechanics.mass_matrix(toy), stiffness))
        omega = 2.0 * math.pi * mechanics.free_frequency(toy)
        # Both solve with M, of condition up to 1e5 after scaling rows.
        np.testing.assert_allclose(np.sort(every.real) / omega**2, [0.0, 0.0, 1.0], atol=1e-9)


def test_torques_balance_at_the_equilibrium() -> None:
    """phi_M = -0.1034 and phi_S = -0.2216 as printed."""
    for toy in [Toy(), *random_toys(5, 20)]:
        phi_m, phi_s = mechanics.equilibrium(toy)
        assert phi_m == -toy.phi_m_max
        weight = mechanics.force_at_rest(toy)[2]
        torque = weight + mechanics.force_per_stretch(toy)[2] * (phi_s - phi_m)
        assert abs(torque) <= EXACT * abs(weight) * max(1.0, abs(phi_m / (phi_s - phi_m)))
    assert mechanics.equilibrium(Toy()).phi_s == pytest.approx(-0.221694, abs=5e-7)  # printed


def test_jam_limit() -> None:
    """0.285 as printed; in closed form (m_S + m_M) h_M / (m_S (l_M + l_G) - r_M (m_S + m_M))."""
    assert mechanics.jam_limit(Toy()) == pytest.approx(0.28519, abs=5e-6)  # printed digits
    for toy in random_toys(6, 50):
        whole = toy.m_s + toy.m_m
        lever = toy.m_s * (toy.l_m + toy.l_g) - toy.r_m * whole
        expected = whole * toy.h_m / lever if lever > 0.0 else math.inf
        assert mechanics.jam_limit(toy) == pytest.approx(expected, rel=1e-12)  # lever cancels


def test_a_heavy_sleeve_never_jams() -> None:
    """Its weight opens contact 2: r_M (m_S + m_M) >= m_S (l_M + l_G) from m_M = 31.8 g on."""
    assert mechanics.jam_limit(Toy(m_m=0.0317)) > 1000.0 * mechanics.jam_limit(Toy())
    assert mechanics.jam_limit(Toy(m_m=0.0319)) == math.inf


# --- Energy ---------------------------------------------------------------------------------------


def test_energy_is_the_sum_of_its_parts() -> None:
    state = [0.3, -0.1, -0.5, 0.2, 3.0, -7.0]
    values = numbers(Toy()) | dict(zip([*Q, *U], state, strict=True))
    expected = [float(part.subs(values)) for part in (kinetic_energy(), potential_energy())]
    np.testing.assert_allclose(mechanics.energy(Toy(), state[:3], state[3:]), expected, rtol=EXACT)


@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 3)])
def test_energy_keeps_the_shape_of_the_states(shape: tuple[int, ...]) -> None:
    q, u = np.random.default_rng(7).normal(size=(2, *shape, 3))
    kinetic, potential = mechanics.energy(Toy(), q, u)
    assert np.shape(kinetic) == np.shape(potential) == shape
    last = mechanics.energy(Toy(), q.reshape(-1, 3)[-1], u.reshape(-1, 3)[-1])
    # The same sums in another order.
    np.testing.assert_allclose([np.ravel(kinetic)[-1], np.ravel(potential)[-1]], last, rtol=EXACT)
