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

import numpy as np

from woodpecker.arrays import Floats
from woodpecker.cases import case_table
from woodpecker.mechanics import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
)
from woodpecker.toy import ExpansionFriction, Toy


class Contact(IntEnum):
    """State of one contact."""

    OPEN = 0
    STICK = 1
    SLIP_POSITIVE = 2
    SLIP_NEGATIVE = 3


# The kernel reads one array, because compiled code passes one array cheaply. Rows and columns:
MODES = 28
KAPPA, OMEGA, ALPHA, A, B, SECULAR, LAMBDA, GUARDS = 0, 1, 2, 3, 6, 9, 12, 24
# LAMBDA is followed by p_N, r_N, p_T, r_T of contacts 1, 2, 3; GUARDS by at most 4 guards, then -1
CONTACT = 28  # one row per contact:
LIMIT, MU, EPS, TANGENT, RESPONSE_N, RESPONSE_T = 0, 1, 2, 3, 6, 9
# the gap over its lever arm is LIMIT + SIGN * angle; responses are M^-1 w_N and M^-1 w_T
DELASSUS = 31  # rows and columns N1, T1, N2, T2, N3, T3 of W^T M^-1 W
FORCE = 37  # h_0, h_1, the length of the pole, the lever arms of the gaps, the law of expansion
POLE, LEVER, SUMMED = 6, 7, 10  # SUMMED: 1 or 0, see toy.ExpansionFriction
PAIR = 38  # impulses of the beak with contact 2, then with contact 3: 36 index combinations each,
EXPANSION = 72  # in compression; so many rows further on the same in expansion
SHAPE = (182, 29)

SIGN = (-1.0, 1.0, -1.0)  # how the angle enters the gap of contacts 1, 2, 3
ANGLE = (2, 1, 1)  # which coordinate closes it: phi_S, phi_M, phi_M

# Guards: kind * 3 + contact - 1. Each is positive inside its mode and fires at zero.
GAP, NORMAL, CONE_POSITIVE, CONE_NEGATIVE, SLIP, SECTION = 0, 3, 6, 9, 12, 15


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


def model(toy: Toy) -> Floats:
    """All numbers the kernel needs, shape SHAPE; a copy, to be changed at will."""
    return _bouncing(toy).copy()


@lru_cache(maxsize=64)
def _bouncing(toy: Toy) -> Floats:
    numbers = _plastic(toy.replace(eps_n1=0.0, eps_n2=0.0, eps_n3=0.0)).copy()
    numbers[CONTACT : CONTACT + 3, EPS] = toy.eps_n1, toy.eps_n2, toy.eps_n3
    return numbers


@lru_cache(maxsize=64)
def _plastic(toy: Toy) -> Floats:
    mass: Floats = np.array(mass_matrix(toy))
    forces = np.column_stack([force_at_rest(toy), force_per_stretch(toy)])
    normal: Floats = np.array(normal_directions(toy))
    tangent: Floats = np.array(tangential_directions(toy))
    mu, lever = np.array([toy.mu_1, toy.mu_2, toy.mu_3]), np.array([toy.h_s, toy.h_m, toy.h_m])
    summed = 1.0 if toy.expansion_friction == ExpansionFriction.SUMMED else 0.0
    numbers = np.full(SHAPE, np.nan)
    for index in range(MODES):
        states = mode_states(index)
        if consistent(states):
            numbers[index, :GUARDS] = _row(states, mass, forces, normal, tangent, mu)
        watched = _watched(states)
        numbers[index, GUARDS:] = watched + [-1] * (SHAPE[1] - GUARDS - len(watched))
    directions = np.stack([normal, tangent], axis=1).reshape(6, 3)
    responses = _solve(mass, directions.T).T
    contacts = numbers[CONTACT : CONTACT + 3]
    contacts[:, LIMIT], contacts[:, MU] = np.array(gap_offsets(toy)) / lever, mu
    contacts[:, TANGENT : TANGENT + 3] = tangent
    contacts[:, RESPONSE_N : RESPONSE_N + 3] = responses[0::2]
    contacts[:, RESPONSE_T : RESPONSE_T + 3] = responses[1::2]
    numbers[DELASSUS : DELASSUS + 6, :6] = directions @ responses.T
    for k in (1, 2):
        chosen = [0, 1, 2 * k, 2 * k + 1]
        delassus = (directions @ responses.T)[np.ix_(chosen, chosen)]
        for phase, coupling in enumerate((0.0, summed)):
            friction = mu[[0, k], None] * np.where(np.eye(2) == 1.0, 1.0, coupling)
            table, row = case_table(delassus, friction), PAIR + 36 * (k - 1) + EXPANSION * phase
            numbers[row : row + 36, : table.shape[1]] = table
    numbers[FORCE, :6], numbers[FORCE, POLE] = forces.T.ravel(), toy.pole
    numbers[FORCE, SUMMED] = summed
    numbers[FORCE, LEVER : LEVER + 3] = lever
    return numbers


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
    row = np.zeros(GUARDS)
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
    solution = np.linalg.solve(rows[:, None] * scaled, rows[:, None] * rhs)
    return np.asarray(columns[:, None] * solution)


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
