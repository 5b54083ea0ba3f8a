"""The 28 modes of the toy: linear motions with constant coefficients, from event to event.

A mode is a state of the beak contact (4: open, stick, slip +, slip -) times a state of the sleeve
(7: open, or one of stick, slip +, slip - at contact 2 or 3). With the closed contacts' constraints,
M qdd = h_0 + h_1 d + W lambda [Leine2001, Eqs. 1-3, 6-10] gives

    qdd = A + B d,    lambda = p + r d,    ddd = alpha + kappa d,    d = phi_S - phi_M,

a scalar oscillator: trigonometric for kappa < 0, hyperbolic for kappa > 0, polynomial for
kappa = 0. Restitution does not enter, so one table serves a whole continuation in eps_N. Along any
other parameter p the table is computed at p + i h with h = 1e-150: the imaginary part over h is the
derivative, as exact as the real part (complex step [Squire1998]; h^2 underflows).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from woodpecker.base.arrays import Complexes, Floats
from woodpecker.base.compiled import jit, part
from woodpecker.mechanics.cases import SINGULAR, fill_cases
from woodpecker.mechanics.equations import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
    unsound,
)
from woodpecker.mechanics.toy import ExpansionFriction, Toy

OPEN, STICK, SLIP_POSITIVE, SLIP_NEGATIVE = range(4)  # states of a contact
JAMMED = 1  # row of the mode in which nothing but the lower edge of the sleeve touches, and sticks

STEP = 1e-150  # imaginary part of the varying parameter
LARGEST = 1e100  # number in a table or a state: products of three of them do not overflow

_mass, _constant, _elastic = part(mass_matrix), part(force_at_rest), part(force_per_stretch)
_normal, _tangent, _offsets = (
    part(normal_directions),
    part(tangential_directions),
    part(gap_offsets),
)

# The kernel reads one array, because passing arrays costs compiled code time. Rows and columns:
MODES = 28
KAPPA, OMEGA, ALPHA, A, B, SECULAR, LAMBDA, GUARDS = 0, 1, 2, 3, 6, 9, 12, 24
# LAMBDA is followed by p_N, r_N, p_T, r_T of contacts 1, 2, 3; GUARDS by at most 4 guards, then -1
CONTACT = 28  # one row per contact:
LIMIT, MU, EPS, TANGENT, RESPONSE_N, RESPONSE_T = 0, 1, 2, 3, 6, 9
# the gap over its lever arm is LIMIT + SIGN * angle; responses are M^-1 w_N and M^-1 w_T
DELASSUS = 31  # rows and columns N1, T1, N2, T2, N3, T3 of W^T M^-1 W
FORCE = 37  # h_0, h_1, the length of the pole, the lever arms of the gaps, and
POLE, LEVER, SUMMED, PENDING, SOUND = 6, 7, 10, 11, 13  # SUMMED: 1 or 0, see ExpansionFriction;
# PENDING: 1 if the index combinations of the beak with contact 2 (PENDING + 1: with contact 3) are
# still to be written; SOUND: 1 if doubles can hold the equations of motion, or 0
PAIR = 38  # impulses of the beak with contact 2, then with contact 3: 36 index combinations each,
EXPANSION = 72  # in compression; so many rows further on the same in expansion
SHAPE = (182, 29)
CHANGE = (38, 24)  # of the derivatives: of the rows and columns that depend on parameters
NO_RATES: Floats = np.zeros((0, CHANGE[1]))  # the derivatives where nothing but restitution changes

SIGN = (-1.0, 1.0, -1.0)  # how the angle enters the gap of contacts 1, 2, 3
ANGLE = (2, 1, 1)  # which coordinate closes it: phi_S, phi_M, phi_M

# Guards: kind * 3 + contact - 1. Each is positive inside its mode and fires at zero.
GAP, NORMAL, CONE_POSITIVE, CONE_NEGATIVE, SLIP, SECTION = 0, 3, 6, 9, 12, 15


@part
def mode_of(states: Any) -> int:
    """Row of the mode table for states of contacts 1, 2, 3; one of the last two is open."""
    sleeve = states[1]
    if sleeve == OPEN and states[2] != OPEN:
        sleeve = states[2] + 3
    return int(7 * states[0] + sleeve)


@part
def mode_states(mode: int) -> tuple[int, int, int]:
    """States of contacts 1, 2, 3 in a row of the mode table."""
    sleeve = mode % 7
    return mode // 7, sleeve if sleeve <= 3 else OPEN, sleeve - 3 if sleeve > 3 else OPEN


class Numbers(NamedTuple):
    """The toy's parameters for compiled code; complex, see :func:`fill`."""

    m_m: complex
    j_m: complex
    m_s: complex
    j_s: complex
    g: complex
    r_0: complex
    r_m: complex
    h_m: complex
    l_m: complex
    l_g: complex
    h_s: complex
    l_s: complex
    c_phi: complex
    mu_1: complex
    mu_2: complex
    mu_3: complex


def model(toy: Toy) -> Floats:
    """All numbers of the kernel, shape SHAPE; a copy, which may be changed.

    The kernel adds the index combinations of pairs when it first needs them. ValueError if the
    equations of motion overflow, or are singular, in doubles.
    """
    numbers = table(toy)
    if not numbers[FORCE, SOUND]:
        raise unsound(toy)
    return numbers


def table(toy: Toy) -> Floats:
    """The same as :func:`model` without the error; the entry SOUND says whether it is usable."""
    return _with_restitution(toy).copy()


@lru_cache(maxsize=64)
def _with_restitution(toy: Toy) -> Floats:
    numbers = _without_restitution(toy.replace(eps_n1=0.0, eps_n2=0.0, eps_n3=0.0)).copy()
    numbers[CONTACT : CONTACT + 3, EPS] = toy.eps_n1, toy.eps_n2, toy.eps_n3
    return numbers


@lru_cache(maxsize=64)
def _without_restitution(toy: Toy) -> Floats:
    numbers = np.full(SHAPE, np.nan)
    for index in range(MODES):
        guards = watched(mode_states(index))
        numbers[index, GUARDS:] = guards + [-1] * (SHAPE[1] - GUARDS - len(guards))
    numbers[FORCE, POLE] = toy.pole
    numbers[FORCE, SUMMED] = float(toy.expansion_friction == ExpansionFriction.SUMMED)
    with np.errstate(all="ignore"):
        fill(parameters_of(toy).tolist(), numbers, np.zeros(CHANGE))
    return numbers


def parameters_of(toy: Toy) -> Complexes:
    """The parameters that the mode table depends on, shape (16,)."""
    return np.array([complex(getattr(toy, name)) for name in Numbers._fields])


def fill(parameters: Complexes | list[complex], numbers: Floats, rates: Floats) -> None:
    """Write all ``numbers`` (SHAPE) that depend on the parameters, and their ``rates`` (CHANGE).

    ``parameters`` (16,) are in the order of :class:`Numbers`, with imaginary parts STEP times their
    rates of change. Index combinations of pairs become due. A singular sliding mode (the paradox of
    Painleve) gets a row of nan and is never entered. If anything else is singular or overflows, the
    table is not SOUND.
    """
    p = parameters
    toy = Numbers(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13],
        p[14], p[15],
    )  # fmt: skip
    mass, normal, tangent = _mass(toy), _normal(toy), _tangent(toy)
    constant, elastic, offsets = _constant(toy), _elastic(toy), _offsets(toy)
    mu, lever = (toy.mu_1, toy.mu_2, toy.mu_3), (toy.h_s, toy.h_m, toy.h_m)
    system, row = np.empty((7, 13), dtype=np.complex128), np.empty(GUARDS, dtype=np.complex128)
    scale = np.empty(7)
    sound = True
    for index in range(MODES):
        beak, sleeve = index // 7, index % 7
        together = beak == OPEN or sleeve == 0 or (sleeve - 1) % 3 + 1 == beak
        if not together:  # two closed contacts share the velocity of the sleeve
            for k in range(GUARDS):
                numbers[index, k] = math.nan
            continue
        pivot = _mode(
            system, scale, row, beak, sleeve, mass, constant, elastic, normal, tangent, mu
        )
        size = 0.0
        for k in range(GUARDS):
            size += _put(numbers, rates, index, k, row[k])
        slides = beak > STICK or (sleeve > 0 and (sleeve - 1) % 3 + 1 > STICK)
        if not slides:
            least = SINGULAR if index == 0 else 0.0  # constraints are checked below
            sound = sound and pivot > least and size < LARGEST
        elif not (pivot > 0.0 and size < LARGEST):
            for k in range(GUARDS):
                numbers[index, k] = math.nan
    size = 0.0
    for i in range(3):
        size += _put(numbers, rates, CONTACT + i, LIMIT, offsets[i] / lever[i])
        size += _put(numbers, rates, CONTACT + i, MU, mu[i])
        size += _put(numbers, rates, FORCE, i, constant[i])
        size += _put(numbers, rates, FORCE, 3 + i, elastic[i])
        size += _put(numbers, rates, FORCE, LEVER + i, lever[i])
        for j in range(3):
            size += _put(numbers, rates, CONTACT + i, TANGENT + j, tangent[i][j])
            system[i, j] = mass[i][j]
            system[i, 3 + 2 * j], system[i, 4 + 2 * j] = normal[j][i], tangent[j][i]
    _solve(system, 3, 6, scale)
    for a in range(6):
        response = (RESPONSE_N, RESPONSE_T)[a % 2]
        for j in range(3):
            size += _put(numbers, rates, CONTACT + a // 2, response + j, system[j, 3 + a])
        for b in range(6):
            w = normal[b // 2] if b % 2 == 0 else tangent[b // 2]
            product = w[0] * system[0, 3 + a] + w[1] * system[1, 3 + a] + w[2] * system[2, 3 + a]
            size += _put(numbers, rates, DELASSUS + b, a, product)
    for i in range(3):
        n, t = DELASSUS + 2 * i, 2 * i
        product, mixed = numbers[n, t] * numbers[n + 1, t + 1], numbers[n, t + 1]
        sound = sound and product - mixed * mixed > SINGULAR * product
    numbers[FORCE, SOUND] = 1.0 if sound and size < LARGEST else 0.0
    numbers[FORCE, PENDING] = numbers[FORCE, PENDING + 1] = 1.0


refill = jit(fill)
"""Compiled :func:`fill`, for repeated calls; a single one takes Python less time than compiling."""


@part
def fill_pair(numbers: Floats, k: int, delassus: Floats, friction: Floats, system: Floats) -> None:
    """Write the index combinations of an impact at the beak and contact k (0-based), if due."""
    if numbers[FORCE, PENDING + k - 1] == 0.0:
        return
    first = PAIR + 36 * (k - 1)
    friction[0, 0], friction[1, 1] = numbers[CONTACT, MU], numbers[CONTACT + k, MU]
    friction[0, 1] = friction[1, 0] = 0.0
    fill_cases(delassus, friction, numbers[first : first + 36], system)
    friction[0, 1] = numbers[FORCE, SUMMED] * friction[0, 0]
    friction[1, 0] = numbers[FORCE, SUMMED] * friction[1, 1]
    first += EXPANSION
    fill_cases(delassus, friction, numbers[first : first + 36], system)
    numbers[FORCE, PENDING + k - 1] = 0.0


@part
def _put(numbers: Floats, rates: Floats, row: int, column: int, value: complex) -> float:
    """Write a number and its derivative; returns the sum of their moduli."""
    numbers[row, column], rates[row, column] = value.real, value.imag / STEP
    return float(abs(numbers[row, column]) + abs(rates[row, column]))


@part
def _mode(
    system: Complexes, scale: Floats, row: Complexes, beak: int, sleeve: int, mass: Any,
    constant: Any, elastic: Any, normal: Any, tangent: Any, mu: Any,
) -> float:  # fmt: skip
    """Write the row of a mode, from M qdd - W lambda = h and constraints; its least pivot, or 0."""
    state = mode_states(7 * beak + sleeve)
    n = 3 + (2 if beak != OPEN else 0) + (2 if sleeve != 0 else 0)
    row[:] = 0.0
    if n == 7 and beak == STICK:
        return 1.0  # at rest; forces are not unique, see contact_problems.rest_is_possible
    write_mode(n, state, mass, constant, elastic, normal, tangent, mu, system)
    least = _solve(system, n, 2, scale)
    if least == 0.0:
        return 0.0
    if beak != OPEN:
        system[2, n] = system[2, n + 1] = 0.0  # a closed contact holds its angle: exactly zero
    if sleeve != 0:
        system[1, n] = system[1, n + 1] = 0.0
    sticks = beak == STICK or (sleeve != 0 and (sleeve - 1) % 3 + 1 == STICK)
    if not sticks:  # nothing holds the toy: with a relaxed spring it falls freely,
        for i in range(n):
            system[i, n] = 0.0  # and the contacts carry nothing
        system[0, n] = _quotient(constant[0], mass[0][0])
    elif beak != STICK:
        system[0, n] = system[0, n + 1] = 0.0  # a jammed sleeve does not fall
    alpha, kappa = system[2, n] - system[1, n], system[2, n + 1] - system[1, n + 1]
    row[KAPPA], row[OMEGA], row[ALPHA] = kappa, math.sqrt(abs(kappa.real)), alpha
    for j in range(3):
        a, b = system[j, n], system[j, n + 1]
        row[A + j], row[B + j] = a, b
        row[SECULAR + j] = a
        if kappa.real != 0.0:  # over a swing no torque has a mean, so angles drift linearly at
            # most; y falls freely unless a contact sticks
            row[SECULAR + j] = a - b * _quotient(alpha, kappa) if j == 0 and not sticks else 0.0
    at = 3
    for i in range(3):
        if state[i] != OPEN:
            for k in range(2):
                row[LAMBDA + 4 * i + k] = system[at, n + k]
                row[LAMBDA + 4 * i + 2 + k] = system[at + 1, n + k]
            at += 2
    return least


@part
def write_mode(
    n: int, state: tuple[int, ...], mass: Any, constant: Any, elastic: Any, normal: Any,
    tangent: Any, mu: Any, system: Any,
) -> None:  # fmt: skip
    """Write the n equations of a mode with its two right-hand sides, in any kind of numbers."""
    system[:, :] = 0
    for i in range(3):
        for j in range(3):
            system[i, j] = mass[i][j]
        system[i, n], system[i, n + 1] = constant[i], elastic[i]
    at = 3
    for i in range(3):
        if state[i] == OPEN:
            continue
        for j in range(3):
            system[j, at], system[j, at + 1] = -normal[i][j], -tangent[i][j]
            system[at, j] = normal[i][j]
            if state[i] == STICK:
                system[at + 1, j] = tangent[i][j]
        if state[i] != STICK:
            system[at + 1, at + 1] = 1
            system[at + 1, at] = mu[i] if state[i] == SLIP_POSITIVE else -mu[i]
        at += 2


@part
def _quotient(a: complex, b: complex) -> complex:
    """Quotient a / b for abs(b.real) >= abs(b.imag), rounded once, where numpy rounds twice."""
    ratio = b.imag / b.real
    size = b.real + b.imag * ratio
    return complex((a.real + a.imag * ratio) / size, (a.imag - a.real * ratio) / size)


@part
def _solve(system: Complexes, n: int, right: int, scale: Floats) -> float:
    """Solve for the columns right of the first n, in place, scaled so that units do not matter."""
    # Scales and pivots are chosen by real parts. Returns the smallest pivot, of rows scaled to 1;
    # if that is zero nothing is solved.
    least = 1.0
    for j in range(n):
        scale[j] = 0.0
        for i in range(n):
            scale[j] = max(scale[j], abs(system[i, j].real))
        if not 0.0 < scale[j] < math.inf:
            return 0.0
        scale[j] = 1.0 / math.sqrt(scale[j])
    for i in range(n):
        largest = 0.0
        for j in range(n):
            system[i, j] *= scale[j]
            largest = max(largest, abs(system[i, j].real))
        if not 0.0 < largest < math.inf:
            return 0.0
        for j in range(n + right):
            system[i, j] = _quotient(system[i, j], complex(largest, 0.0))
    for i in range(n):
        pivot = i
        for k in range(i + 1, n):
            if abs(system[k, i].real) > abs(system[pivot, i].real):
                pivot = k
        size = abs(system[pivot, i].real)
        least = min(least, size)
        if not size > 0.0:
            return 0.0
        if pivot != i:
            for j in range(i, n + right):
                system[i, j], system[pivot, j] = system[pivot, j], system[i, j]
        for k in range(i + 1, n):
            if system[k, i] != 0.0:
                factor = _quotient(system[k, i], system[i, i])
                for j in range(i + 1, n + right):
                    system[k, j] -= factor * system[i, j]
    for j in range(n, n + right):
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                system[i, j] -= system[i, k] * system[k, j]
            system[i, j] = _quotient(system[i, j], system[i, i])
    for j in range(n, n + right):
        for i in range(n):
            system[i, j] *= scale[i]
    return float(least)


def watched(states: tuple[int, ...]) -> list[int]:
    """Guards that can end a mode, in the order in which ties are resolved."""
    guards = []
    for i, state in enumerate(states):
        if state == STICK:
            guards += [CONE_POSITIVE + i, CONE_NEGATIVE + i]
        elif state != OPEN:
            guards += [NORMAL + i, SLIP + i]
        elif i == 0 or states[1] == states[2] == OPEN:  # else the other edge holds the sleeve
            guards.append(GAP + i)
    return [*guards, SECTION] if states == (OPEN, STICK, OPEN) else guards
