"""Moreau's time stepping for the toy: one contact problem per step, and no event is ever located.

    python -m studies.peers.moreau [--fast] [--out DIR]

A step of length dt goes from (q_A, u_A) to (q_E, u_E). With K q = -h_1 (phi_S - phi_M),
gamma = W^T u and impulses Lambda [Moreau1988; Jean1999],

    M (u_E - u_A) = dt (h_0 - K q_F) + W Lambda,
    q_E = q_C + theta dt u_E,    q_C = q_A + (1 - theta) dt u_A.

The contacts whose gap is closed at q_C take part, since q_E = q_C for a contact that is at rest in
the end. Each of them obeys, with xi_N = gamma_NE + eps_N gamma_NA,

    0 <= Lambda_N  perp  xi_N >= 0,
    |Lambda_T| <= mu Lambda_N,    Lambda_T = -mu Lambda_N sign(gamma_TE) where gamma_TE != 0.

The schemes differ only in q_F, at which the spring's force is evaluated:

- ``theta``: q_F = theta q_E + (1 - theta) q_A, implicit. As the problem is linear, this replaces M
  by M + (theta dt)^2 K, with the spring's force at q_A + theta dt u_A. At theta = 1/2 the smooth
  motion conserves energy.
- ``midpoint``: q_F = q_C at theta = 1/2, explicit: Moreau's midpoint rule.

There are two solvers of the contact problem. ``lcp`` is direct. With the friction bounds
Lambda_R = mu Lambda_N + Lambda_T and Lambda_L = mu Lambda_N - Lambda_T the law is a linear
complementarity problem [Leine2001, Eqs. 4-5]. Of its complementary bases only four per contact
make sense: open, sticking, sliding forward, sliding backward. They are tried in turn, beginning
with that of the last step. ``pgs`` is projected Gauss-Seidel: each impulse in turn is projected on
its set, until no contact velocity changes by more than 1e-12 of the largest one in a sweep.

Siconos uses the scheme ``theta`` too; both agree to rounding (:mod:`studies.peers.siconos_peer`).

The impact law is Newton's; the toy's is Poisson's. With one contact closed and friction that does
not change between sticking and sliding during the impact both say gamma_NE = -eps_N gamma_NA. So
with eps_N2 = eps_N3 = 0 they can differ only where friction couples to the beak's restitution: in
an impact of the beak that begins to stick, or one that finds the sleeve's contact closed. Friction
is Coulomb's contact by contact, so the toy must be one with ``expansion_friction="separate"``.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np

from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.record import Results, command
from studies.peers.ode import IMAGE, PHI_S
from studies.peers.peer import LostError, PeerReturn, contact_by_contact
from woodpecker import Toy, first_return
from woodpecker.base.arrays import Codes, Floats, Ints
from woodpecker.base.compiled import COMPILED, jit
from woodpecker.mechanics.equations import (
    force_at_rest,
    force_per_stretch,
    gap_offsets,
    mass_matrix,
    normal_directions,
    tangential_directions,
)
from woodpecker.mechanics.modes import ANGLE, SIGN
from woodpecker.motion.codes import DETACH, IMPACT, REVERSAL, SLIP_START, STICK_START
from woodpecker.simulation.words import word

SchemeName = Literal["theta", "midpoint"]
SolverName = Literal["lcp", "pgs"]
SCHEMES: tuple[SchemeName, ...] = get_args(SchemeName)
SOLVERS: tuple[SolverName, ...] = get_args(SolverName)
PGS = SOLVERS.index("pgs")  # compiled code knows no strings

OPEN, STICK, FORWARD, BACKWARD = 0, 1, 2, 3  # state of a contact

# Compiled code passes one array cheaply and a tuple of arrays dearly. Numbers of a step: one row
# per contact, columns
LIMIT, MU, EPS = 0, 1, 2  # gap over its lever arm at angle 0 [rad], friction, restitution
DIRECTION = 3  # w_N, w_T: three entries each
RESPONSE = 9  # change of u by a unit of Lambda_N, of Lambda_T: three entries each
DELASSUS = 15  # rows N, T of G = W^T M^-1 W: six entries each, in the order N1, T1, N2, T2, N3, T3
# and a last row for the rest, columns
STEP, DT, THETA, GRAVITY, SPRING = 3, 0, 1, 2, 5  # change of u in a step by h_0, by h_1 per rad
NUMBERS = (4, 27)
# Motion z: q, u, then the impulses of the last step, (xi_N, gamma_T) without impulses, gamma_NA
Q, U, IMPULSE, FREE, APPROACH, MOTION = 0, 3, 6, 12, 18, 21
# States of the contacts, one row each. LOADED: in the last step, OPEN means no impulse; SHUT: the
# same, but OPEN for a contact that has just rebounded; both also one step earlier
LOADED, SHUT, LOADED_BEFORE, SHUT_BEFORE = 0, 1, 2, 3

CLOSED = 1e-12  # rad; a gap up to this over its lever arm is closed: a contact at rest drifts by
# the rounding, or by the stopping rule, of its velocity. A real gap crosses it in 1e-12 s
REBOUND = 1e-12  # m/s; a contact that leaves the impact slower than this stays closed
SINGULAR = 1e-11  # pivot below which a basis is rank-deficient: G, scaled, is rounded near 1e-15
SLACK = 1e-10  # relative violation allowed to a basis: SINGULAR and a margin
PGS_STOP = 1e-12  # relative change of a contact velocity in the last sweep
PGS_SWEEPS = 100_000  # after which Gauss-Seidel gives up

STEPS = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)  # s
FAST_STEPS = (1e-3, 1e-4, 1e-5)
NEIGHBOURS = np.linspace(0.9, 1.1, 9)  # where the events fall within the steps makes the error of
# one step a matter of luck; the root mean square over neighbouring steps is not
ASYMPTOTIC = 1e-4  # s; longer steps are not yet short against the phases of 0.6 ms and more
# At this eps_N1 and phi_S [rad] the beak begins to stick during the expansion, so Newton's law and
# Poisson's give different motions.
LAWS = (0.9, -0.4)

LONGEST = 3.0  # s without a return, after which the toy is given up for lost
EVENT_LIMIT = 2000  # symbols of a word

RETURNED, ENDED, NO_BASIS, NO_LIMIT, TOO_MANY_EVENTS = range(5)
LOST = {
    ENDED: f"the toy does not return within {LONGEST} s",
    NO_BASIS: "no basis solves the contact problem of a step",
    NO_LIMIT: f"Gauss-Seidel does not converge within {PGS_SWEEPS} sweeps",
    TOO_MANY_EVENTS: f"more than {EVENT_LIMIT} events",
}


class Samples(NamedTuple):
    """State after every step."""

    t: Floats  # s, shape (n + 1,)
    q: Floats  # (y, phi_M, phi_S) [m, rad, rad], shape (n + 1, 3)
    u: Floats  # their rates, shape (n + 1, 3)


def first_return_moreau(
    toy: Toy,
    phi_s: float,
    step: float = 1e-5,
    scheme: SchemeName = "theta",
    solver: SolverName = "lcp",
) -> PeerReturn:
    """Start at rest on the section and step until phi_S has its next minimum while jammed.

    The minimum lies in the step in which phi_S' rises through zero while contact 2 sticks;
    phi_S' is linear in that step. Events are what the steps show: an impact when a contact that
    was open carries an impulse, a detachment when a closed one carries none, and changes between
    sticking and sliding of a closed one. Two events of one contact within a step are not seen,
    and sliding that reverses is ``R3`` or, if a step ends in between, ``J3 S3``.

    Parameters
    ----------
    toy, phi_s
        The toy and the angle of the woodpecker at the start [rad].
    step
        Length of a step [s].
    scheme, solver
        As above, ``"theta"`` (with theta = 1/2) or ``"midpoint"``, ``"lcp"`` or ``"pgs"``.

    Raises
    ------
    ValueError
        If phi_s is beyond the beak's contact, the step is not positive, a name is unknown, or the
        toy is not under Coulomb's law contact by contact.
    LostError
        If the toy does not return within three seconds, or a contact problem is not solved.
    """
    numbers, (z, states) = discretise(toy, step, scheme), _start(toy, phi_s)
    codes, none = np.zeros(EVENT_LIMIT, np.int16), np.zeros((0, 6))
    steps = math.ceil(LONGEST / step)
    end, taken, events, late = _follow(
        numbers, _index(solver, SOLVERS), z, states, True, steps, codes, none
    )
    if end != RETURNED:
        raise LostError(f"{LOST[end]}; step {taken} of {step} s")
    # `late` is the time from the minimum to the end of the step, in which phi_S' rises from zero.
    return PeerReturn(
        phi_s=float(z[Q + 2] - 0.5 * late * z[U + 2]),
        period=taken * step - late,
        drop=float(late * z[U] - z[Q]),
        word=word(codes[:events].tolist()),
        evaluations=taken,
    )


def simulate_moreau(
    toy: Toy,
    phi_s: float,
    t_end: float,
    step: float = 1e-5,
    scheme: SchemeName = "theta",
    solver: SolverName = "lcp",
    theta: float = 0.5,
) -> Samples:
    """States after every step, from rest on the section to the first step past ``t_end`` [s].

    Parameters and errors as for :func:`first_return_moreau`; theta for the scheme of that name.
    """
    numbers, (z, states) = discretise(toy, step, scheme, theta), _start(toy, phi_s)
    steps = math.ceil(t_end / step)
    codes, samples = np.zeros(0, np.int16), np.empty((steps + 1, 6))
    end, taken, _, _ = _follow(
        numbers, _index(solver, SOLVERS), z, states, False, steps, codes, samples
    )
    if end != ENDED:
        raise LostError(f"{LOST[end]}; step {taken} of {step} s")
    times: Floats = step * np.arange(steps + 1, dtype=np.float64)
    return Samples(times, samples[:, :3], samples[:, 3:])


def word_of_states(toy: Toy, loaded: Ints) -> str:
    """Word of the contacts' states after every step, shape (n, 3), from the start on.

    It is the word of a program that tells no more than these states: a contact with restitution
    counts as closed from the second step on in which it carries an impulse.
    """
    states, codes = _start(toy, 0.0)[1], np.zeros(EVENT_LIMIT, np.int16)
    sticky = np.array([toy.eps_n1, toy.eps_n2, toy.eps_n3]) == 0.0
    events = 0
    for row in loaded:
        states[LOADED_BEFORE], states[SHUT_BEFORE] = states[LOADED], states[SHUT]
        states[LOADED] = row
        states[SHUT] = np.where(sticky | (states[LOADED_BEFORE] != OPEN), row, OPEN)
        events = _name_events(states, codes, events)
    return word(codes[:events].tolist())


def discretise(toy: Toy, step: float, scheme: SchemeName = "theta", theta: float = 0.5) -> Floats:
    """Numbers of a step, shape (4, 27); ValueError as for :func:`first_return_moreau`."""
    if not (math.isfinite(step) and step > 0.0):
        raise ValueError(f"step must be positive and finite, got {step}")
    if not 0.0 <= theta <= 1.0 or (scheme == "midpoint" and theta != 0.5):
        raise ValueError(f"theta must lie in [0, 1], and be 0.5 for the midpoint, got {theta}")
    contact_by_contact(toy)
    mass: Floats = np.array(mass_matrix(toy))
    spring: Floats = np.array(force_per_stretch(toy))
    if SCHEMES[_index(scheme, SCHEMES)] == "theta":
        stretch = np.array([0.0, -1.0, 1.0])  # of d = phi_S - phi_M by q, so K = -h_1 stretch^T
        mass = mass - (theta * step) ** 2 * np.outer(spring, stretch)
    directions: Floats = np.hstack([normal_directions(toy), tangential_directions(toy)])
    forces = np.stack([force_at_rest(toy), spring, *directions.reshape(6, 3)])
    changes = np.linalg.solve(mass, forces.T).T
    numbers = np.zeros(NUMBERS)
    numbers[:3, LIMIT] = np.array(gap_offsets(toy)) / np.array([toy.h_s, toy.h_m, toy.h_m])
    numbers[:3, MU] = toy.mu_1, toy.mu_2, toy.mu_3
    numbers[:3, EPS] = toy.eps_n1, toy.eps_n2, toy.eps_n3
    numbers[:3, DIRECTION : DIRECTION + 6] = directions
    numbers[:3, RESPONSE : RESPONSE + 6] = changes[2:].reshape(3, 6)
    numbers[:3, DELASSUS:] = (directions.reshape(6, 3) @ changes[2:].T).reshape(3, 12)
    numbers[STEP, DT], numbers[STEP, THETA] = step, theta
    numbers[STEP, GRAVITY : GRAVITY + 6] = step * changes[:2].ravel()
    return numbers


def _start(toy: Toy, phi_s: float) -> tuple[Floats, Ints]:
    """Motion and states at rest on the section, contact 2 closed and sticking."""
    if not (math.isfinite(phi_s) and phi_s < toy.phi_s_max):
        raise ValueError(f"phi_s must be finite and below {toy.phi_s_max:.6g}, got {phi_s}")
    z = np.zeros(MOTION)
    z[Q + 1], z[Q + 2] = -toy.phi_m_max, phi_s
    return z, np.array([[OPEN, STICK, OPEN]] * 4)


def _index(name: str, names: tuple[str, ...]) -> int:
    if name not in names:
        raise ValueError(f"expected one of {', '.join(names)}, got {name!r}")
    return names.index(name)


@jit
def _follow(
    numbers: Floats, solver: int, z: Floats, states: Ints, to_section: bool, steps: int,
    codes: Codes, samples: Floats,
) -> tuple[int, int, int, float]:  # fmt: skip
    """Take steps: (how it ended, steps taken, events, time since the minimum [s])."""
    part, events = np.empty(3, np.int64), 0
    _keep(samples, 0, z)
    for taken in range(1, steps + 1):
        rate = z[U + 2]
        end = _advance(numbers, solver, z, states, part)
        _keep(samples, taken, z)
        if end != RETURNED:
            return end, taken, events, 0.0
        if to_section:
            events = _name_events(states, codes, events)
            if events > len(codes):
                return TOO_MANY_EVENTS, taken, events, 0.0
            if rate < 0.0 <= z[U + 2] and states[SHUT_BEFORE, 1] == STICK == states[SHUT, 1]:
                late = numbers[STEP, DT] * z[U + 2] / (z[U + 2] - rate)
                return RETURNED, taken, events, late
    return ENDED, steps, events, 0.0


@jit
def _keep(samples: Floats, row: int, z: Floats) -> None:
    if len(samples):
        samples[row] = z[: U + 3]


@jit
def _advance(numbers: Floats, solver: int, z: Floats, states: Ints, part: Ints) -> int:
    """One step in place."""
    dt, theta = numbers[STEP, DT], numbers[STEP, THETA]
    stretch = z[Q + 2] - z[Q + 1] + theta * dt * (z[U + 2] - z[U + 1])
    for j in range(3):
        z[Q + j] += (1.0 - theta) * dt * z[U + j]
    n = _take_part(numbers, z, states, part)
    for j in range(3):
        z[U + j] += numbers[STEP, GRAVITY + j] + numbers[STEP, SPRING + j] * stretch
    end = _push(numbers, solver, z, states, part, n) if n else RETURNED
    for j in range(3):
        z[Q + j] += theta * dt * z[U + j]
    return end


@jit
def _take_part(numbers: Floats, z: Floats, states: Ints, part: Ints) -> int:
    """Find the contacts closed at q_C, with their gamma_NA; their number."""
    n = 0
    for i in range(3):
        states[LOADED_BEFORE, i], states[SHUT_BEFORE, i] = states[LOADED, i], states[SHUT, i]
        if numbers[i, LIMIT] + SIGN[i] * z[Q + ANGLE[i]] <= CLOSED:
            part[n], z[APPROACH + i] = i, _rate(numbers, i, 0, z)
            n += 1
        else:
            z[IMPULSE + 2 * i] = z[IMPULSE + 2 * i + 1] = 0.0
            states[LOADED, i] = states[SHUT, i] = OPEN
    return n


@jit
def _rate(numbers: Floats, i: int, axis: int, z: Floats) -> float:
    """Relative velocity of contact i, normal (axis 0) or tangential (1)."""
    w = DIRECTION + 3 * axis
    rate: float = numbers[i, w] * z[U] + numbers[i, w + 1] * z[U + 1] + numbers[i, w + 2] * z[U + 2]
    return rate


@jit
def _push(numbers: Floats, solver: int, z: Floats, states: Ints, part: Ints, n: int) -> int:
    """Solve the contact problem of n contacts and apply its impulses."""
    for k in range(n):
        i = part[k]
        z[FREE + 2 * i] = _rate(numbers, i, 0, z) + numbers[i, EPS] * z[APPROACH + i]
        z[FREE + 2 * i + 1] = _rate(numbers, i, 1, z)
    if solver == PGS:
        end = gauss_seidel(numbers, z, states, part, n)
    elif n == 1:
        end = enumerate_one(numbers, z, states, part[0])
    else:
        end = enumerate_bases(numbers, z, states, part, n)
    for k in range(n):
        i = part[k]
        for axis in range(2):
            for j in range(3):
                impulse = z[IMPULSE + 2 * i + axis]
                z[U + j] += numbers[i, RESPONSE + 3 * axis + j] * impulse
        # Chatter is over when there is no rebound left, or impulses in two steps on end.
        rebound = -numbers[i, EPS] * z[APPROACH + i]
        stays = rebound <= REBOUND or states[LOADED_BEFORE, i] != OPEN
        states[SHUT, i] = states[LOADED, i] if stays else OPEN
    return end


@jit
def enumerate_one(numbers: Floats, z: Floats, states: Ints, i: int) -> int:
    """Try the four bases of a single contact, in closed form, that of the last step first."""
    mu, normal, tangent = numbers[i, MU], DELASSUS + 2 * i, DELASSUS + 6 + 2 * i
    g_nn, g_nt, g_tt = numbers[i, normal], numbers[i, normal + 1], numbers[i, tangent + 1]
    free_n, free_t = z[FREE + 2 * i], z[FREE + 2 * i + 1]
    small_v = SLACK * max(abs(free_n), abs(free_t))
    small_i = small_v / min(g_nn, g_tt)
    for attempt in range(4):
        trial = (states[LOADED, i] + attempt) % 4
        if trial == OPEN:
            p_n = p_t = 0.0
            good = free_n >= -small_v
        elif trial == STICK:
            determinant = g_nn * g_tt - g_nt * g_nt
            p_n = (g_nt * free_t - g_tt * free_n) / determinant
            p_t = (g_nt * free_n - g_nn * free_t) / determinant
            good = p_n >= -small_i and abs(p_t) <= mu * p_n + small_i
        else:
            slope = -mu if trial == FORWARD else mu
            p_n = -free_n / (g_nn + slope * g_nt)
            p_t = slope * p_n
            slip = free_t + g_nt * p_n + g_tt * p_t
            good = p_n >= -small_i and (slip if trial == FORWARD else -slip) >= -small_v
        if good:
            z[IMPULSE + 2 * i], z[IMPULSE + 2 * i + 1], states[LOADED, i] = p_n, p_t, trial
            return RETURNED
    return NO_BASIS


@jit
def enumerate_bases(numbers: Floats, z: Floats, states: Ints, part: Ints, n: int) -> int:
    """The same for any number of contacts, by elimination."""
    last = 0
    trial, system = np.empty(n, np.int64), np.empty((2 * n, 2 * n + 1))
    for k in range(n):
        last += states[LOADED, part[k]] * 4**k
    for attempt in range(4**n):
        for k in range(n):
            trial[k] = (last + attempt) // 4**k % 4
        _write_basis(numbers, z, part, trial, system)
        _eliminate(system)
        if _holds(numbers, z, part, trial, system[:, -1]):
            for k in range(n):
                i = part[k]
                z[IMPULSE + 2 * i], z[IMPULSE + 2 * i + 1] = system[2 * k : 2 * k + 2, -1]
                states[LOADED, i] = trial[k]
            return RETURNED
    return NO_BASIS


@jit
def _delassus(numbers: Floats, part: Ints, row: int, column: int) -> float:
    """Entry of G; rows and columns (N, T) of the first contact that takes part, then the next."""
    i, j = part[row // 2], part[column // 2]
    entry: float = numbers[i, DELASSUS + 6 * (row % 2) + 2 * j + column % 2]
    return entry


@jit
def _write_basis(numbers: Floats, z: Floats, part: Ints, trial: Ints, system: Floats) -> None:
    """Equations of a basis for (Lambda_N, Lambda_T) of each contact, right-hand side last."""
    system[:] = 0.0
    for row in range(len(system)):
        i, state = part[row // 2], trial[row // 2]
        if state == STICK or (row % 2 == 0 and state != OPEN):  # no velocity
            for column in range(len(system)):
                system[row, column] = _delassus(numbers, part, row, column)
            system[row, -1] = -z[FREE + 2 * i + row % 2]
        else:  # no impulse, or friction
            system[row, row] = 1.0
            if state != OPEN:
                system[row, row - 1] = numbers[i, MU] if state == FORWARD else -numbers[i, MU]


@jit
def _eliminate(system: Floats) -> None:
    """Gauss-Jordan elimination in place; the solution ends in the last column.

    Two sticking contacts have four impulses for three velocities. An unknown without a pivot is
    set to zero; whether what comes out solves the problem is checked afterwards.
    """
    n = len(system)
    for i in range(n):
        system[i] /= np.abs(system[i, :n]).max()
    for i in range(n):
        pivot = i + np.argmax(np.abs(system[i:, i]))
        if abs(system[pivot, i]) < SINGULAR:
            system[i, :] = 0.0
            continue
        for j in range(n + 1):
            system[i, j], system[pivot, j] = system[pivot, j], system[i, j]
        system[i] /= system[i, i]
        for k in range(n):
            if k != i:
                system[k] -= system[k, i] * system[i]


@jit
def _holds(numbers: Floats, z: Floats, part: Ints, trial: Ints, impulse: Floats) -> bool:
    """Whether the impulses of a basis obey the law, up to rounding."""
    velocity, small_v, small_i = np.empty(len(impulse)), 0.0, 0.0
    for row in range(len(impulse)):
        free = z[FREE + 2 * part[row // 2] + row % 2]
        small_v = max(small_v, SLACK * abs(free))
        small_i = max(small_i, SLACK * abs(free) / _delassus(numbers, part, row, row))
        velocity[row] = free
        for column in range(len(impulse)):
            velocity[row] += _delassus(numbers, part, row, column) * impulse[column]
    for k in range(len(trial)):
        (v_n, v_t), (p_n, p_t) = velocity[2 * k : 2 * k + 2], impulse[2 * k : 2 * k + 2]
        if trial[k] == OPEN:
            good = v_n >= -small_v
        elif p_n < -small_i or abs(v_n) > small_v:
            good = False
        elif trial[k] == STICK:
            good = abs(v_t) <= small_v and abs(p_t) <= numbers[part[k], MU] * p_n + small_i
        else:
            good = (v_t if trial[k] == FORWARD else -v_t) >= -small_v
        if not good:  # a NaN is not good either
            return False
    return True


@jit
def gauss_seidel(numbers: Floats, z: Floats, states: Ints, part: Ints, n: int) -> int:
    """Project one impulse after the other, from those of the last step on."""
    size = 0.0
    for k in range(2 * n):
        size = max(size, abs(z[FREE + 2 * part[k // 2] + k % 2]))
    for _ in range(PGS_SWEEPS):
        change = 0.0
        for row in range(2 * n):
            i, own = part[row // 2], IMPULSE + 2 * part[row // 2] + row % 2
            velocity, g = z[FREE + 2 * i + row % 2], _delassus(numbers, part, row, row)
            for column in range(2 * n):
                other = IMPULSE + 2 * part[column // 2] + column % 2
                velocity += _delassus(numbers, part, row, column) * z[other]
            old, new = z[own], z[own] - velocity / g
            if row % 2 == 0:
                z[own] = max(new, 0.0)
            else:
                bound = numbers[i, MU] * z[own - 1]
                z[own] = min(max(new, -bound), bound)
            change = max(change, g * abs(z[own] - old))
        if change <= PGS_STOP * size:
            break
    else:
        return NO_LIMIT
    for k in range(n):
        i = part[k]
        p_n, p_t = z[IMPULSE + 2 * i], z[IMPULSE + 2 * i + 1]
        states[LOADED, i] = _state(numbers[i, MU], p_n, p_t)
    return RETURNED


@jit
def _state(mu: float, p_n: float, p_t: float) -> int:
    """State of a contact from its projected impulses."""
    if p_n <= 0.0:
        return OPEN
    if abs(p_t) < mu * p_n:
        return STICK
    return FORWARD if p_t < 0.0 else BACKWARD


@jit
def _name_events(states: Ints, codes: Codes, events: int) -> int:
    """Append what a step shows to the word; the new number of events."""
    hit = touching = 0
    for i in range(3):
        if states[SHUT_BEFORE, i] != OPEN:
            touching |= 1 << i
        elif states[LOADED, i] != OPEN and states[LOADED_BEFORE, i] == OPEN:
            hit |= 1 << i
    if hit:  # a contact that is closed already takes part in the impact
        return _append(codes, events, IMPACT, hit | touching)
    for i in range(3):
        before, after = states[SHUT_BEFORE, i], states[SHUT, i]
        if before in (OPEN, after):
            continue
        if after == OPEN:
            kind = DETACH
        elif after == STICK:
            kind = STICK_START
        else:
            kind = SLIP_START if before == STICK else REVERSAL
        events = _append(codes, events, kind, 1 << i)
    return events


@jit
def _append(codes: Codes, events: int, kind: int, contacts: int) -> int:
    if events < len(codes):
        codes[events] = 8 * kind + contacts
    return events + 1


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Error and cost of one return of the nominal cycle, by scheme, solver and step.

    Parameters
    ----------
    fast
        Take fewer steps.
    out
        Not used: there are no pictures.

    Returns
    -------
    dict
        For every scheme and solver: ``step`` [s], ``error`` of the image (root mean square over
        neighbouring steps [rad]), ``steps`` and ``cpu_ms`` per return, ``word``, and ``order``,
        the slope of log(error) over log(step) from 1e-4 s down (None if that is one point).
        ``laws``: a start at which the impact laws differ, and how far the image then stays from
        that of the kernel.
    """
    steps: tuple[float, ...] = FAST_STEPS if fast else STEPS
    if not COMPILED:
        steps = tuple(step for step in steps if step >= ASYMPTOTIC)  # plain Python takes minutes
    results: Results = {
        f"{scheme}, {solver}": convergence(steps, scheme, solver)
        for scheme in SCHEMES
        for solver in SOLVERS
    }
    eps_n1, phi_s = LAWS
    toy = CONTACT_BY_CONTACT.replace(eps_n1=eps_n1)
    image = first_return(toy, phi_s).phi_s
    results["laws"] = {
        "eps_n1": eps_n1,
        "phi_s": phi_s,
        "step": steps,
        "difference": [first_return_moreau(toy, phi_s, step).phi_s - image for step in steps],
    }
    return results


def convergence(steps: tuple[float, ...], scheme: SchemeName, solver: SolverName) -> Results:
    """Error and cost of one return of the nominal cycle for each step, as :func:`main` says."""
    toy = CONTACT_BY_CONTACT
    table: Results = {"step": steps, "error": [], "steps": [], "cpu_ms": [], "word": []}
    for step in steps:
        first_return_moreau(toy, PHI_S, step, scheme, solver)  # compiles
        start = time.process_time()
        returns = [first_return_moreau(toy, PHI_S, step * s, scheme, solver) for s in NEIGHBOURS]
        seconds = (time.process_time() - start) / len(returns)
        nominal = returns[len(returns) // 2]
        errors = np.array([once.phi_s for once in returns]) - float(IMAGE)
        table["error"].append(float(np.sqrt(np.mean(errors**2))))
        table["steps"].append(nominal.evaluations)
        table["cpu_ms"].append(1e3 * seconds)
        table["word"].append(nominal.word)
    fitted = np.array(steps) <= ASYMPTOTIC
    table["order"] = None
    if fitted.sum() > 1:
        logarithms = np.log(steps)[fitted], np.log(table["error"])[fitted]
        table["order"] = float(np.polyfit(*logarithms, 1)[0])
    return table


if __name__ == "__main__":
    command(main, "peer_moreau")
