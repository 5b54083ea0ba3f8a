"""The return by a general ODE solver, with which the closed form of ``woodpecker`` is compared.

Each smooth phase is handed to :func:`scipy.integrate.solve_ivp` as the six-dimensional ODE
M qdd = h + W lambda of its mode [Leine2001, Eqs. 1-3, 6-10]; the guards of the mode are its
terminal events. Modes and contact problems are the project's own, so the two programs differ only
in how they move between events and how they find the next one. It follows either law of friction,
whichever the toy has.

    python -m studies.peers.ode [--fast]
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from studies.peers.peer import LostError, PeerReturn
from woodpecker import Toy
from woodpecker.base.arrays import Floats, Ints
from woodpecker.mechanics.contact_problems import SOLVED
from woodpecker.mechanics.modes import (
    ALPHA,
    ANGLE,
    CONTACT,
    GAP,
    GUARDS,
    KAPPA,
    LIMIT,
    OPEN,
    SECTION,
    SIGN,
    SLIP,
    SLIP_POSITIVE,
    STICK,
    TANGENT,
    A,
    B,
    mode_of,
    model,
)
from woodpecker.motion.arriving import carry_out_event
from woodpecker.motion.codes import ROOM
from woodpecker.motion.events import force_guard
from woodpecker.motion.flow import measure
from woodpecker.simulation.words import word

PHI_S = -0.52947197  # the nominal cycle at eps_N1 = 0.5, to eight digits
# To thirty digits by studies/peers/reference_mpmath.py, from the double nearest to PHI_S:
IMAGE = "-0.529471964686405381795441868166"
PERIOD = "0.145976064190706193049720121441"

STEP_OFF = 1e-6  # s; the fastest mode turns by 5e-4 rad in it, so the first term left out of the
# Taylor step is below rounding, while a guard that leaves zero cubically is far above it
HALVINGS = 12  # of STEP_OFF, before two events are called one
EVENT_LIMIT = 1000
LONGEST_PHASE = 10.0  # s; a mode that lasts longer is taken for free fall

Guard = Callable[[float, Floats], float]


def first_return_ode(
    toy: Toy,
    phi_s: float,
    method: str = "DOP853",
    rtol: float = 1e-10,
    atol: float | Sequence[float] = 1e-12,
    max_step: float = math.inf,
) -> PeerReturn:
    """Start at rest on the section and follow the toy for one return with ``solve_ivp``.

    At an event the project's contact problem is solved
    (:func:`woodpecker.motion.arriving.carry_out_event`) and the integration starts anew in the next
    mode. The guard that has just fired is zero there, some of its derivatives may be too, and
    ``solve_ivp`` compares only the signs at both ends of a step: it would fire again at once, or
    not, as rounding has it. So every phase begins with one Taylor step of third order over 1e-6 s,
    after which all guards are positive; the step is halved while one is not. Two events closer than
    1e-6 s / 2^12 raise. A guard that dips below zero and comes back within one step of the solver
    is missed: that is the solver's nature, and the word
    shows it.

    Parameters
    ----------
    toy, phi_s
        The toy and the angle of the woodpecker at the start [rad].
    method, rtol, atol, max_step
        As for ``solve_ivp``; atol in m and rad, m/s and rad/s, max_step in s. With large
        tolerances max_step is the step itself.

    Raises
    ------
    ValueError
        If phi_s is not finite or beyond the beak's contact.
    LostError
        If the toy does not return, or a contact problem has no or several solutions.
    """
    if not (math.isfinite(phi_s) and phi_s < toy.phi_s_max):
        raise ValueError(f"phi_s must be finite and below {toy.phi_s_max:.6g}, got {phi_s}")
    numbers = model(toy)
    codes, counts = np.zeros(EVENT_LIMIT, np.int16), np.zeros(3, np.int64)
    room = np.zeros(1, ROOM)[0]
    z, states = room.z, room.states
    z[1], z[2] = -toy.phi_m_max, phi_s
    states[:] = OPEN, STICK, OPEN
    fired, evaluations, modes = -1, 0, dict[int, _Mode]()
    solver = _Solver(method, rtol, atol, max_step)
    while fired != SECTION:
        measure(numbers, z, room.gaps)
        status = carry_out_event(numbers, fired, codes, counts, room)
        if status != SOLVED or counts[0] > len(codes):
            raise LostError(f"the contact problem at t = {z[6]} s has no single solution")
        mode = mode_of(states)
        if mode not in modes:
            modes[mode] = _motion(numbers, mode, states)
        _step_off(modes[mode], z)
        fired, spent = _to_next_event(modes[mode], z, solver)
        evaluations += spent
    return PeerReturn(
        float(z[2]), float(z[6]), float(-z[0]), word(codes[: counts[0]].tolist()), evaluations
    )


class _Solver(NamedTuple):
    """Options of ``solve_ivp``."""

    method: str
    rtol: float
    atol: float | Sequence[float]
    max_step: float


class _Mode(NamedTuple):
    """What the solver is given in one mode."""

    derivative: Callable[[float, Floats], list[float]]
    names: tuple[int, ...]  # guards as numbered in woodpecker.mechanics.modes
    guards: tuple[Guard, ...]
    rates: Callable[[Floats], tuple[Floats, Floats, Floats]]


def _motion(numbers: Floats, mode: int, states: Ints) -> _Mode:
    """Right-hand side and events of a mode from the numbers of the mode table.

    A list of floats is the fastest right-hand side: with six components it beats a matrix product
    twice over and costs no more than a compiled function.
    """
    a, b = numbers[mode, A : A + 3], numbers[mode, B : B + 3]
    (a_y, a_m, a_s), (b_y, b_m, b_s) = a.tolist(), b.tolist()

    def derivative(_t: float, x: Floats) -> list[float]:
        _, phi_m, phi_s, dy, dphi_m, dphi_s = x.tolist()
        d = phi_s - phi_m
        return [dy, dphi_m, dphi_s, a_y + b_y * d, a_m + b_m * d, a_s + b_s * d]

    def rates(z: Floats) -> tuple[Floats, Floats, Floats]:
        d, rate = z[2] - z[1], z[5] - z[4]
        return a + b * d, b * rate, b * (numbers[mode, ALPHA] + numbers[mode, KAPPA] * d)

    names = tuple(int(guard) for guard in numbers[mode, GUARDS : GUARDS + 5] if guard >= 0)
    guards = tuple(_guard(numbers, mode, states, name) for name in names)
    return _Mode(derivative, names, guards, rates)


def _guard(numbers: Floats, mode: int, states: Ints, name: int) -> Guard:
    """One guard as a terminal event: it falls through zero; phi_S' rises through it."""
    kind, i = (name // 3) * 3, name % 3
    function: Any  # functions with attributes have no type of their own
    if name == SECTION:

        def function(_t: float, x: Floats) -> float:
            return x.item(5)

    elif kind == GAP:
        limit, sign, j = float(numbers[CONTACT + i, LIMIT]), SIGN[i], ANGLE[i]

        def function(_t: float, x: Floats) -> float:
            return limit + sign * x.item(j)

    elif kind == SLIP:
        direction = 1.0 if states[i] == SLIP_POSITIVE else -1.0
        w: list[float] = (direction * numbers[CONTACT + i, TANGENT : TANGENT + 3]).tolist()
        w_y, w_m, w_s = w

        def function(_t: float, x: Floats) -> float:
            return w_y * x.item(3) + w_m * x.item(4) + w_s * x.item(5)

    else:
        p, r = (float(value) for value in force_guard(numbers, mode, name))

        def function(_t: float, x: Floats) -> float:
            return p + r * (x.item(2) - x.item(1))

    function.terminal, function.direction = True, 1.0 if name == SECTION else -1.0
    guard: Guard = function
    return guard


def _to_next_event(motion: _Mode, z: Floats, solver: _Solver) -> tuple[int, int]:
    """Move the state to the next event: its guard, and the evaluations that this took."""
    span = z[6], z[6] + LONGEST_PHASE
    solution = solve_ivp(motion.derivative, span, z[:6], events=motion.guards, **solver._asdict())
    hits = [k for k, times in enumerate(solution.t_events or ()) if len(times)]
    if not hits:
        raise LostError(f"the toy does not return: {solution.message}")
    z[:6], z[6] = solution.y[:, -1], solution.t[-1]
    return motion.names[hits[0]], solution.nfev


def _step_off(motion: _Mode, z: Floats) -> None:
    """Move the state to where every guard is positive, by one short Taylor step."""
    acceleration, jerk, snap = motion.rates(z)
    for halvings in range(HALVINGS):
        h = STEP_OFF / 2**halvings
        q = z[:3] + h * (z[3:6] + h / 2 * (acceleration + h / 3 * (jerk + h / 4 * snap)))
        u = z[3:6] + h * (acceleration + h / 2 * (jerk + h / 3 * snap))
        x = np.concatenate([q, u])
        values = [guard(0.0, x) for guard in motion.guards]
        if all(f > 0.0 or k == SECTION for k, f in zip(motion.names, values, strict=True)):
            z[:6], z[6] = x, z[6] + h
            return
    raise LostError(f"two events closer than {h} s at t = {z[6]} s")


def main(fast: bool = False) -> dict[str, dict[str, float]]:
    """Error [rad] and cost of one return by several methods and tolerances."""
    toy, reference, rows = Toy(), Decimal(IMAGE), {}
    for method in ("DOP853",) if fast else ("DOP853", "RK45", "LSODA", "Radau"):
        for rtol in (1e-6, 1e-10) if fast else (1e-6, 1e-8, 1e-10, 1e-12):
            seconds = []
            for _ in range(2 if fast else 5):
                start = time.process_time()
                once = first_return_ode(toy, PHI_S, method, rtol, 1e-2 * rtol)
                seconds.append(time.process_time() - start)
            rows[f"{method} {rtol:.0e}"] = {
                "error": float(abs(Decimal(once.phi_s) - reference)),
                "evaluations": once.evaluations,
                "cpu_ms": 1e3 * min(seconds),
            }
    return rows


if __name__ == "__main__":
    for name, row in main(fast="--fast" in sys.argv).items():
        print(f"{name:14s}", "  ".join(f"{key} {value:.3g}" for key, value in row.items()))
