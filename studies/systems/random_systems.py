"""Random systems of 2 to 4 coordinates and 1 to 3 contacts: laws that every motion must obey.

    python -m studies.systems.random_systems [--fast] [--out DIR]

M, K, C, gaps, slips, friction and restitution are random. Masses and the directions of contacts are
drawn once for a family; all others are parameters, so that all systems of a family share its
compiled integrators. All contacts of a system have the same restitution: then no impact may add
energy. Where the contact laws have no unique solution, a status says so.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import sympy

from studies.common.record import Results, command
from woodpecker.base.arrays import Floats
from woodpecker.systems import Contact, ContactSystem, MotionStatus
from woodpecker.systems.mechanics.equations import Equations
from woodpecker.systems.mechanics.index_sets import ContactState
from woodpecker.systems.simulation.motion import Run, assembled

SHAPES = [(n, m) for n in (2, 3, 4) for m in (1, 2, 3)]  # coordinates, contacts
T_END, EVENTS_MOST = 4.0, 300
SEED = 36


class Family(NamedTuple):
    """Systems of one shape, mass matrix and directions of contacts."""

    system: ContactSystem
    mass: Floats


@cache
def family(n: int, m: int) -> Family:
    """One of n coordinates and m contacts; its parameters in the order in which they are drawn."""
    rng = np.random.default_rng([SEED, n, m])
    root, w_n, w_t = rng.normal(size=(n, n)), rng.normal(size=(m, n)), rng.normal(size=(m, n))
    mass = root @ root.T + n * np.eye(n)
    q, u = (sympy.Matrix(sympy.symbols(f"{name}:{n}")) for name in "xv")
    stiffness, damping = (sympy.Matrix(n, n, sympy.symbols(f"{name}:{n * n}")) for name in "kc")
    push, away = sympy.Matrix(sympy.symbols(f"f:{n}")), sympy.symbols(f"d:{m}")
    mu, eps = sympy.symbols("mu eps")
    contacts = [
        Contact(
            name=f"contact {i}", gap=sympy.Matrix(w_n[i]).dot(q) + away[i],
            slip=sympy.Matrix(w_t[i]).dot(u), mu=mu, eps_n=eps,
        )
        for i in range(m)
    ]  # fmt: skip
    values = dict.fromkeys([*stiffness, *damping, *push, *away, mu, eps], 0.5)
    force = push - stiffness * q - damping * u
    return Family(ContactSystem(list(q), mass, force, contacts, values, u=list(u)), mass)


def draw_values(n: int, m: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Parameters of a system of a family, and speeds to start with."""
    spring, damper = rng.normal(size=(2, n, n))
    p = [
        spring @ spring.T, 0.01 * damper @ damper.T, 2.0 * rng.normal(size=n),
        rng.uniform(0.1, 1.0, size=m), rng.uniform(0.0, 0.6), rng.uniform(0.0, 0.9),
    ]  # fmt: skip
    return np.concatenate([np.ravel(each) for each in p]), 2.0 * rng.normal(size=n)


@cache
def equations(n: int, m: int, backend: str) -> Equations:
    """The equations of a family, with its integrators."""
    return assembled(family(n, m).system, (), backend)


def motion_of(number: int, backend: str) -> tuple[Run, Floats]:
    """The motion of a random system from rest in its coordinates, and the mass matrix."""
    n, m = SHAPES[number % len(SHAPES)]
    p, speeds = draw_values(n, m, np.random.default_rng([SEED, number]))
    z = np.concatenate([np.zeros(n), speeds, [0.0]])
    run = Run(equations(n, m, backend), z, p, t_end=T_END, events_most=EVENTS_MOST)
    run.follow(ContactState(frozenset()))
    return run, family(n, m).mass


def faults(run: Run, mass: Floats) -> list[str]:
    """What a motion has done that it must not do."""
    found = list[str]()
    if not np.isfinite(run.z).all():
        found.append("a state is not finite")
    if run.status is MotionStatus.OVERFLOW:
        found.append("a bounded motion overflows")
    for event in run.events:
        before, after = (0.5 * u @ mass @ u for u in (event.before, event.after))
        if not after <= before * (1.0 + 1e-12) + 1e-12:  # rounding of two sums of squares
            found.append("energy grows")
    return found


def survey(numbers: Sequence[int], compared: int) -> Results:
    """Follow random systems, and the first of them with both backends.

    Parameters
    ----------
    numbers
        Which ones.
    compared
        How many of them; the second backend takes thirty times as long.

    Returns
    -------
    dict
        ``systems``; ``faults``: how many motions did what they must not; ``statuses``: how many
        ended so; ``compared``, ``same_words`` of both backends, and ``differ``: how many of the
        others ended so; ``slowest`` [s] of all motions.
    """
    statuses, differ = Counter[str](), Counter[str]()
    wrong, took = 0, list[float]()
    for k, number in enumerate(numbers):
        start = time.perf_counter()
        run, mass = motion_of(number, "heyoka")
        took.append(time.perf_counter() - start)
        statuses[run.status.name] += 1
        wrong += bool(faults(run, mass))
        if k < compared:
            other, _ = motion_of(number, "scipy")
            if other.symbols != run.symbols or other.status is not run.status:
                differ[run.status.name] += 1
    return {
        "systems": len(numbers), "faults": wrong, "statuses": dict(statuses), "compared": compared,
        "same_words": compared - differ.total(), "differ": dict(differ), "slowest": max(took),
    }  # fmt: skip


def main(fast: bool = False, out: Path | None = None) -> Results:
    """What random motions must keep, and how often both backends say the same.

    Parameters
    ----------
    fast
        Systems of the two least shapes only.
    out
        Not used: there is no picture.

    Returns
    -------
    dict
        As :func:`survey` has it; 10 000 systems take eight minutes, half of it for compiling.
    """
    if fast:
        numbers = [k for k in range(36) if k % len(SHAPES) < 2]
        return survey(numbers, len(numbers))
    return survey(range(10_000), 1000)


if __name__ == "__main__":
    command(main, "system_random")
