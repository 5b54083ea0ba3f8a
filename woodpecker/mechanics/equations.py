"""Mass matrix, forces and contact directions in (y, phi_M, phi_S) [Leine2001, Eqs. 6-10].

The functions use only ``+ - * /`` on the attributes of ``toy`` and return nested tuples, so that
they serve floats, numpy, sympy and mpmath alike. Two misprints of the paper are corrected: entry
(2, 2) of the mass matrix has J_M, not J_S; the first row of h has the factor g.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, real_array
from woodpecker.mechanics.toy import Toy

Vector = tuple[Any, Any, Any]


def mass_matrix(toy: Any) -> tuple[Vector, Vector, Vector]:
    """M, rows of shape (3, 3) in kg, kg m, kg m^2 [Leine2001, Eq. 6, corrected]."""
    m, j_m, j_s, l_m, l_g = toy.m_s, toy.j_m, toy.j_s, toy.l_m, toy.l_g
    return (
        (m + toy.m_m, m * l_m, m * l_g),
        (m * l_m, j_m + m * l_m * l_m, m * l_m * l_g),
        (m * l_g, m * l_m * l_g, j_s + m * l_g * l_g),
    )


def force_at_rest(toy: Any) -> Vector:
    """h_0 of h = h_0 + h_1 d in N, N m, N m: gravity [Leine2001, Eq. 7, corrected]."""
    return (
        -toy.g * (toy.m_s + toy.m_m),
        -toy.g * toy.m_s * toy.l_m,
        -toy.g * toy.m_s * toy.l_g,
    )


def force_per_stretch(toy: Any) -> Vector:
    """h_1 of h = h_0 + h_1 d in N m/rad, d = phi_S - phi_M: the spring [Leine2001, Eq. 7]."""
    return (0 * toy.c_phi, toy.c_phi, -toy.c_phi)


def gap_offsets(toy: Any) -> Vector:
    """Gaps g_N1, g_N2, g_N3 [m] at phi_M = phi_S = 0 [Leine2001, Eq. 8]."""
    return (toy.l_m + toy.l_g - toy.l_s - toy.r_0, toy.r_m - toy.r_0, toy.r_m - toy.r_0)


def normal_directions(toy: Any) -> tuple[Vector, Vector, Vector]:
    """w_N of contacts 1, 2, 3 in m [Leine2001, Eq. 9]."""
    zero = 0 * toy.h_m
    return ((zero, zero, -toy.h_s), (zero, toy.h_m, zero), (zero, -toy.h_m, zero))


def tangential_directions(toy: Any) -> tuple[Vector, Vector, Vector]:
    """w_T of contacts 1, 2, 3; first entry [-], others [m] [Leine2001, Eq. 10]."""
    one, zero = 1 + 0 * toy.r_m, 0 * toy.r_m
    return (
        (one, toy.l_m, toy.l_g - toy.l_s),
        (one, toy.r_m, zero),
        (one, toy.r_m, zero),
    )


class Equilibrium(NamedTuple):
    """Angles at which the bird hangs backward at rest on the jammed sleeve.

    Examples
    --------
    >>> from woodpecker import Toy, equilibrium
    >>> rest = equilibrium(Toy())
    >>> round(rest.phi_m, 6), round(rest.phi_s, 6)
    (-0.103448, -0.221694)
    """

    phi_m: float  # rad
    phi_s: float  # rad


def unsound(toy: Toy) -> ValueError:
    """The error for a toy whose equations of motion overflow, or are singular, in doubles."""
    return ValueError(
        f"the equations of motion of {toy!r} overflow, or are singular, in double precision"
    )


def equilibrium(toy: Toy) -> Equilibrium:
    """Equilibrium angles [rad] on the jammed sleeve; it exists if mu_2 >= ``jam_limit(toy)``.

    The spring carries the bird's weight: c_phi d = -m_S g l_G [Leine2001, Results].

    Parameters
    ----------
    toy
        The toy.

    Returns
    -------
    Equilibrium
        The angles phi_M and phi_S [rad].

    Raises
    ------
    TypeError, ValueError
        If ``toy`` is no toy, or the angles overflow.

    Examples
    --------
    >>> from woodpecker import Toy, equilibrium
    >>> print(f"{equilibrium(Toy()).phi_s:.9f} rad")
    -0.221693812 rad
    """
    instance("toy", toy, Toy)
    phi_m = -toy.phi_m_max
    phi_s = phi_m - toy.m_s * toy.g * toy.l_g / toy.c_phi
    if not math.isfinite(phi_s):
        raise unsound(toy)
    return Equilibrium(phi_m, phi_s)


def jam_limit(toy: Toy) -> float:
    """Smallest mu_2 [-] that holds the toy at its equilibrium: abs(lambda_T2) / lambda_N2.

    Infinite if the pole pulls on the sleeve there (lambda_N2 <= 0).

    Parameters
    ----------
    toy
        The toy; its own mu_2 does not matter.

    Returns
    -------
    float
        The friction coefficient [-].

    Raises
    ------
    TypeError, ValueError
        If ``toy`` is no toy, or the contact forces overflow.

    Examples
    --------
    >>> from woodpecker import Toy, jam_limit
    >>> print(f"{jam_limit(Toy()):.7f}")
    0.2851875
    """
    instance("toy", toy, Toy)
    d = -toy.m_s * toy.g * toy.l_g / toy.c_phi
    weight, torque, _ = force_at_rest(toy)
    lambda_t = -weight
    lambda_n = -(torque + toy.c_phi * d + toy.r_m * lambda_t) / toy.h_m
    if not (math.isfinite(lambda_t) and math.isfinite(lambda_n)):
        raise unsound(toy)
    return float(lambda_t / lambda_n) if lambda_n > 0.0 else math.inf


def free_frequency(toy: Toy) -> float:
    """Eigenfrequency [Hz] of sleeve, spring and bird without contact.

    Parameters
    ----------
    toy
        The toy.

    Returns
    -------
    float
        The frequency [Hz].

    Raises
    ------
    TypeError, ValueError
        If ``toy`` is no toy, or the frequency overflows.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> from woodpecker.mechanics import free_frequency
    >>> print(f"{free_frequency(Toy()):.6f} Hz")
    72.908498 Hz
    """
    instance("toy", toy, Toy)
    mass = toy.m_s + toy.m_m
    between = toy.m_s * toy.m_m / mass
    length = toy.l_m + toy.l_g
    free = toy.j_m + toy.j_s + between * length * length  # sums only: nothing cancels
    held = toy.j_m * toy.j_s + between * (toy.l_m * toy.l_m * toy.j_s + toy.l_g * toy.l_g * toy.j_m)
    square = toy.c_phi * free / held if held > 0.0 else math.inf
    if not 0.0 < square < math.inf:
        raise unsound(toy)
    return math.sqrt(square) / (2.0 * math.pi)


def energy(toy: Toy, q: Any, u: Any) -> tuple[Any, Any]:
    """Kinetic and potential energy [J] of states q, u of shape (..., 3).

    Parameters
    ----------
    toy
        The toy.
    q, u
        Coordinates (y, phi_M, phi_S) and velocities [m, rad, m/s, rad/s], shape (..., 3).

    Returns
    -------
    kinetic, potential
        Arrays of shape (...) [J]; the potential energy is zero at q = 0.

    Raises
    ------
    TypeError, ValueError
        If ``toy`` is no toy, q or u are not finite or of another shape, or an energy overflows.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> from woodpecker.mechanics import energy
    >>> kinetic, potential = energy(Toy(), [0.0, -0.1, -0.5], [0.0, 0.0, 2.0])  # y, phi_M, phi_S
    >>> f"{1e6 * kinetic:.6f} {1e6 * potential:.6f}"  # micro-joule
    '3.425000 72.767500'
    """
    instance("toy", toy, Toy)
    q, u = _coordinates("q", q), _coordinates("u", u)
    with np.errstate(over="ignore", invalid="ignore"):
        kinetic = 0.5 * np.einsum("...i,ij,...j->...", u, np.array(mass_matrix(toy)), u)
        stretch = q[..., 2] - q[..., 1]
        potential = 0.5 * toy.c_phi * stretch**2 - q @ np.array(force_at_rest(toy))
    if not (np.isfinite(kinetic).all() and np.isfinite(potential).all()):
        raise ValueError(f"the energy of {toy!r} overflows in double precision")
    return kinetic, potential


def _coordinates(name: str, value: Any) -> Floats:
    """An array (..., 3) of finite numbers."""
    numbers = real_array(name, value)
    if numbers.shape[-1:] != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"{name} must be three finite numbers, or rows of three, got {value}")
    return numbers
