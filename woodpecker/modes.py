"""The 28 modes of the toy: constant-coefficient motion between two events.

A mode is a state of the beak contact (4: open, stick, slip +, slip -) times a state of the sleeve
(7: open, or one of stick, slip +, slip - at contact 2 or 3). With the closed contacts' constraints,
M qdd = h_0 + h_1 d + W lambda [Leine2001, Eqs. 1-3, 6-10] gives

    qdd = A + B d,    lambda = p + r d,    ddd = alpha + kappa d,    d = phi_S - phi_M,

so one scalar oscillator carries everything: trigonometric for kappa < 0, hyperbolic for
kappa > 0, polynomial for kappa = 0. Restitution does not enter; one table serves a whole
continuation run in eps_N.
"""

from __future__ import annotations

from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from woodpecker.mechanics import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
)
from woodpecker.toy import Toy

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Contact(IntEnum):
    """State of one contact."""

    OPEN = 0
    STICK = 1
    SLIP_POSITIVE = 2
    SLIP_NEGATIVE = 3


# Columns of a row of the mode table.
KAPPA, OMEGA, ALPHA, A, B, SECULAR, LAMBDA = 0, 1, 2, 3, 6, 9, 12
COLUMNS = 24  # LAMBDA is followed by p_N, r_N, p_T, r_T of contacts 1, 2, 3

# Guards: kind * 3 + contact - 1. Each is positive inside its mode and fires at zero.
GAP, NORMAL, CONE_POSITIVE, CONE_NEGATIVE, SLIP, SECTION = 0, 3, 6, 9, 12, 15
MOST_GUARDS = 6


class Model(NamedTuple):
    """All the numbers the kernel needs, as arrays that numba understands."""

    table: Floats  # (28, 24), one row per mode
    guards: Ints  # (28, 6) guards to watch in each mode, padded with -1
    inverse_mass: Floats  # (3, 3)
    force: Floats  # (2, 3) rows h_0 and h_1 of h = h_0 + h_1 d
    normal: Floats  # (3, 3) rows w_N of contacts 1, 2, 3
    tangent: Floats  # (3, 3) rows w_T
    limit: Floats  # (3,) gap of a contact at zero angle over its lever arm [rad]
    sign: Floats  # (3,) angular gap = limit + sign * angle
    angle: Ints  # (3,) index in q of the angle that closes the contact
    mu: Floats  # (3,)
    eps: Floats  # (3,)
    pole: float  # [m]


def mode_index(beak: int, lower: int, upper: int) -> int:
    """Row of the mode table; at most one of the sleeve's contacts is closed."""
    return 7 * beak + (lower if lower else (upper + 3 if upper else 0))


def mode_states(index: int) -> tuple[Contact, Contact, Contact]:
    """States of contacts 1, 2, 3 in a mode; inverse of :func:`mode_index`."""
    beak, sleeve = divmod(index, 7)
    lower, upper = (sleeve, 0) if sleeve <= 3 else (0, sleeve - 3)
    return Contact(beak), Contact(lower), Contact(upper)


def consistent(states: tuple[int, ...]) -> bool:
    """Two closed contacts share the velocity of the sleeve: both stick, or slip the same way."""
    closed = {state for state in states if state != Contact.OPEN}
    return len(closed) <= 1


def model(toy: Toy) -> Model:
    """Mode table and contact data of a toy; the table is kept for toys alike but for eps_N."""
    mechanical = toy.replace(eps_n1=0.0, eps_n2=0.0, eps_n3=0.0)
    eps = np.array([toy.eps_n1, toy.eps_n2, toy.eps_n3])
    eps.setflags(write=False)
    return _mechanical_model(mechanical)._replace(eps=eps)


@lru_cache(maxsize=64)
def _mechanical_model(toy: Toy) -> Model:
    mass = np.array(mass_matrix(toy))
    normal, tangent = np.array(normal_directions(toy)), np.array(tangential_directions(toy))
    mu = np.array([toy.mu_1, toy.mu_2, toy.mu_3])
    table = np.full((28, COLUMNS), np.nan)
    guards = np.full((28, MOST_GUARDS), -1, dtype=np.int64)
    forces = np.column_stack([force_at_rest(toy), force_per_stretch(toy)])
    for index in range(28):
        states = mode_states(index)
        if consistent(states):
            table[index] = _row(states, mass, forces, normal, tangent, mu)
        watched = _watched(states)
        guards[index, : len(watched)] = watched
    lever = np.array([toy.h_s, toy.h_m, toy.h_m])
    arrays = (
        table,
        guards,
        np.linalg.inv(mass),
        np.ascontiguousarray(forces.T),
        normal,
        tangent,
        np.array(gap_offsets(toy)) / lever,
        np.array([-1.0, 1.0, -1.0]),
        np.array([2, 1, 1], dtype=np.int64),
        mu,
        np.zeros(3),
    )
    for array in arrays:
        array.setflags(write=False)
    return Model(*arrays, toy.pole)


def _row(
    states: tuple[Contact, ...], mass: Floats, forces: Floats, normal: Floats, tangent: Floats,
    mu: Floats,
) -> Floats:  # fmt: skip
    """Solve the constrained equations of motion for right-hand sides h_0 and h_1."""
    closed = [i for i in range(3) if states[i] != Contact.OPEN]
    n = 3 + 2 * len(closed)
    system, rhs = np.zeros((n, n)), np.zeros((n, 2))
    system[:3, :3], rhs[:3] = mass, forces
    for k, i in enumerate(closed):
        row_n, row_t = 3 + 2 * k, 4 + 2 * k
        system[:3, row_n], system[:3, row_t] = -normal[i], -tangent[i]
        system[row_n, :3] = normal[i]
        if states[i] == Contact.STICK:
            system[row_t, :3] = tangent[i]
        else:
            slip = 1.0 if states[i] == Contact.SLIP_POSITIVE else -1.0
            system[row_t, row_t], system[row_t, row_n] = 1.0, slip * mu[i]
    row = np.zeros(COLUMNS)
    if len(closed) == 2 and states[closed[0]] == Contact.STICK:
        return row  # at rest for good; the forces are not unique, see contact.rest_is_possible
    solution = _solve(system, rhs)
    angles = {int(np.flatnonzero(normal[i])[0]) for i in closed}
    solution[sorted(angles)] = 0.0  # a closed contact holds its angle exactly
    if all(states[i] != Contact.STICK for i in closed):
        solution[:, 0] = 0.0  # nothing holds the toy: with a relaxed spring it falls freely,
        solution[0, 0] = forces[0, 0] / mass[0, 0]  # at -g, and the contacts carry nothing
    elif states[0] != Contact.STICK:
        solution[0] = 0.0  # a jammed sleeve does not fall
    a, b = solution[:3, 0], solution[:3, 1]
    alpha, kappa = a[2] - a[1], b[2] - b[1]
    row[KAPPA], row[OMEGA], row[ALPHA] = kappa, np.sqrt(abs(kappa)), alpha
    row[A : A + 3], row[B : B + 3] = a, b
    row[SECULAR : SECULAR + 3] = a - b * (alpha / kappa) if kappa != 0.0 else a
    if kappa != 0.0:
        row[SECULAR + 1 : SECULAR + 3] = 0.0  # no torque has a mean: angles drift linearly at most
    for k, i in enumerate(closed):
        row[LAMBDA + 4 * i : LAMBDA + 4 * i + 2] = solution[3 + 2 * k]
        row[LAMBDA + 4 * i + 2 : LAMBDA + 4 * i + 4] = solution[4 + 2 * k]
    return row


def _solve(system: Floats, rhs: Floats) -> Floats:
    """Solve after scaling rows and columns, so that no unit is preferred."""
    columns = 1.0 / np.sqrt(np.abs(system).max(axis=0))
    scaled = system * columns
    rows = 1.0 / np.abs(scaled).max(axis=1)
    solution: Floats = columns[:, None] * np.linalg.solve(rows[:, None] * scaled, rows[:, None] * rhs)
    return solution


def _watched(states: tuple[Contact, ...]) -> list[int]:
    """Guards that can end a mode, in the order in which ties are resolved."""
    watched = []
    for i, state in enumerate(states):
        if state == Contact.OPEN:
            sleeve_elsewhere = i != 0 and (states[1] or states[2])
            if not sleeve_elsewhere:
                watched.append(GAP + i)
        elif state == Contact.STICK:
            watched += [CONE_POSITIVE + i, CONE_NEGATIVE + i]
        else:
            watched += [NORMAL + i, SLIP + i]
    if states == (Contact.OPEN, Contact.STICK, Contact.OPEN):
        watched.append(SECTION)
    return watched


__all__ = ["Contact", "Model", "consistent", "mode_index", "mode_states", "model"]
