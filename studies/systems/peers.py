"""Ways to follow a motion with impacts: work against accuracy, and the cost of generality.

    python -m studies.systems.peers [--fast] [--out DIR]

An impact oscillator and a rocking block are followed for a period and a half, from an impact of a
periodic motion with a closed form, so that the error of the last state is known:

- ``woodpecker.systems``, from the equations of motion;
- Moreau's time stepping [Moreau1988], written here for any system without friction: half a step
  with the old velocity, a contact problem for the new velocity and the impulses of all contacts
  whose gaps are closed there, and half a step with the new velocity;
- scipy's DOP853, with equations and impacts of each system by hand, and an event at the gap;
- PyDSTool's VODE [Clewley2012] with its events, for the oscillator, where PYDSTOOL_PYTHON names a
  Python that has it;
- Siconos [Acary2019], by the same scheme as Moreau's, for the oscillator, where the system's Python
  has it, or SICONOS_PYTHON names one.

A return of the toy is followed by the closed-form kernel, ``woodpecker.systems`` and Moreau's
scheme; other programs, among them Siconos, follow it in :mod:`studies.peers`.
"""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain, combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from studies.common.clocks import timed
from studies.common.record import Results, command
from studies.common.style import METHODS, RED, canvas, keep
from studies.common.tables import number, rows, seconds
from studies.peers import pydstool_peer, siconos_peer
from studies.peers.elsewhere import environment
from studies.peers.moreau import first_return_moreau
from studies.systems import oscillator, rocking_block, toy
from woodpecker import Toy, first_return, return_map
from woodpecker.base.arrays import Floats
from woodpecker.systems import ContactSystem
from woodpecker.systems import return_map as general_map
from woodpecker.systems.mechanics.index_sets import ContactState
from woodpecker.systems.simulation.motion import Run, assembled

STEPS = (1e-2, 3e-3, 1e-3, 3e-4)  # s, of Moreau's scheme
NEIGHBOURS = np.linspace(0.9, 1.1, 5)  # where an impact falls within a step is luck; the root mean
# square over neighbouring steps is not
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
TOY_STEPS = (1e-4, 1e-5, 1e-6)  # s
PHI_S = -0.53  # rad, where the toy starts
ROUNDS = 3  # of which the median is taken
PROGRAMS = Path(pydstool_peer.__file__).parent  # of the peers that are processes of their own
LONGEST = 120.0  # s, of one of them
CLOSED = 1e-12  # a gap up to this is closed: a contact at rest drifts by rounding


class Problem(NamedTuple):
    """A motion from an impact of a periodic motion, for a period and a half.

    Attributes
    ----------
    system
        The machine.
    start, t_end
        The state (q, u, t) after the impact [m, m/s, s], and the time at the end [s].
    exact
        The first coordinate and its rate there.
    flight, impact
        (t, y, side) -> y' for y of the first coordinate and its rate, and its rate afterwards.
    stop
        The value of the coordinate at which it strikes.
    """

    system: ContactSystem
    start: Floats
    t_end: float
    exact: Floats
    flight: Callable[[float, Floats, float], list[float]]
    impact: Callable[[float], float]
    stop: float


def impact_oscillator() -> Problem:
    """Shaw and Holmes' oscillator on its stable motion of one impact."""
    w, eps, sigma, zeta, force = 2.0, 0.5, 0.5, 0.05, 2.0
    closed = oscillator.ClosedForm(w, eps, sigma, zeta)
    orbit = closed.orbit(min(closed.speeds(force)))
    start = np.array([sigma, orbit.v, orbit.t])
    linear = [[0, 1, 0, 0], [-1, -2 * zeta, force, 0], [0, 0, 0, -w], [0, 0, w, 0]]
    half = math.pi / w
    phase = [math.cos(w * orbit.t), math.sin(w * orbit.t)]
    exact = (expm(half * np.array(linear)) @ np.array([sigma, orbit.v, *phase]))[:2]
    system = oscillator.system().replace(w=w, eps=eps, sigma=sigma, zeta=zeta, F=force)
    return Problem(
        system, start, orbit.t + 3.0 * half, exact,
        lambda t, y, side: [y[1], force * math.cos(w * t) - 2.0 * zeta * y[1] - y[0]],
        lambda v: -eps * v, sigma,
    )  # fmt: skip


def block() -> Problem:
    """Hogan's block on its symmetric motion, half way between fold and pitchfork."""
    w, r = rocking_block.VALUES[rocking_block.W], rocking_block.VALUES[rocking_block.R]
    closed = rocking_block.Symmetric(w, r)
    speed = 0.5 * (closed.fold() + closed.pitchfork())
    beta, (v, t) = closed.beta(speed), closed.point(speed).tolist()
    start = np.array([0.0, 0.0, v, -v, t])
    half = math.pi / w
    # a quarter of a period after the next impact but one: x'' = x + 1 - beta cos(w t) for x < 0
    linear = np.zeros((5, 5))
    linear[0, 1] = linear[1, 0] = linear[1, 4] = 1.0
    linear[1, 2], linear[2, 3], linear[3, 2] = -beta, -w, w
    phase = [math.cos(w * t), math.sin(w * t)]
    exact = (expm(0.5 * half * linear) @ np.array([0.0, v, *phase, 1.0]))[:2]
    return Problem(
        rocking_block.system().replace(beta=beta, w=w, r=r), start, t + 2.5 * half, exact,
        lambda t, y, side: [y[1], y[0] - side - beta * math.cos(w * t)],
        lambda v: r * v, 0.0,
    )  # fmt: skip


def by_systems(problem: Problem) -> Callable[[], Floats]:
    """The general method, its integrators compiled before."""
    eq, n = assembled(problem.system), problem.system.n
    # two corners touch where the block strikes: one stays, and the other one leaves
    closed, leaving = ((1,), (0,)) if n == 2 else ((), (0,))
    touch = ContactState(frozenset(closed), frozenset(), frozenset(leaving))

    def work() -> Floats:
        run = Run(eq, problem.start.copy(), eq.p, t_end=problem.t_end)
        return run.follow(touch).z[[0, n]]

    work()
    return work


# --- Moreau's scheme ------------------------------------------------------------------------------


class Moreau:
    """Moreau's time stepping for contacts without friction, with Newton's impact law."""

    def __init__(self, system: ContactSystem) -> None:
        assert system.u is not None
        values = dict(system.parameters)
        gaps = sympy.Matrix([each.gap for each in system.contacts])
        directions = gaps.jacobian(list(system.q))
        symbols = list(system.state)
        parts = system.M, sympy.Matrix(system.h), gaps, directions
        self._parts = [sympy.lambdify(symbols, part.subs(values), "numpy") for part in parts]
        self._eps = np.array([float(each.eps_n.subs(values)) for each in system.contacts])
        self._n = system.n

    def follow(self, start: Floats, t_end: float, step: float) -> Floats:
        """The last state (q, u) from one (q, u, t); the last step ends at a time."""
        n, t = self._n, float(start[-1])
        q, u = start[:n].copy(), start[n : 2 * n].copy()
        count = math.ceil((t_end - t) / step)
        dt = (t_end - t) / count
        for _ in range(count):
            q = q + 0.5 * dt * u
            mass, force, gaps, w = (part(*q, *u, t + 0.5 * dt) for part in self._parts)
            free = np.linalg.solve(mass, force.ravel()) * dt + u
            closed = np.flatnonzero(gaps.ravel() <= CLOSED)
            u = self._impulses(mass, w[closed], free, w[closed] @ u * self._eps[closed])
            q, t = q + 0.5 * dt * u, t + dt
        return np.concatenate([q, u])

    def _impulses(self, mass: Floats, w: Floats, free: Floats, kept: Floats) -> Floats:
        """Velocities with 0 <= Lambda perp w u + kept >= 0, by trying which contacts push."""
        response = np.linalg.solve(mass, w.T)
        for some in chain.from_iterable(combinations(range(len(w)), k) for k in range(len(w) + 1)):
            on = list(some)
            push = np.zeros(len(w))
            push[on] = np.linalg.solve(w[on] @ response[:, on], -(w @ free + kept)[on])
            u = free + response @ push
            if (push >= 0.0).all() and (w @ u + kept >= -CLOSED).all():
                return np.asarray(u)
        raise ArithmeticError("no set of contacts solves the contact problem of a step")


def by_hand(problem: Problem, tolerance: float) -> Floats:
    """DOP853 from event to event, as one writes it for one machine."""
    t, y = float(problem.start[-1]), problem.start[[0, problem.system.n]]
    while t < problem.t_end:
        side = math.copysign(1.0, y[1])  # it is where its speed has led it from the stop

        def gap(_: float, y: Floats, side: float) -> float:
            return float(y[0] - problem.stop) * side

        gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            problem.flight, (t, problem.t_end), y, "DOP853", args=(side,), events=gap,
            rtol=tolerance, atol=tolerance,
        )  # fmt: skip
        t, y = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            y = np.array([problem.stop, problem.impact(float(y[1]))])
    return np.asarray(y)


def by_pydstool(problem: Problem) -> Results:
    """The oscillator in PyDSTool; nothing where there is none."""
    if pydstool_peer.available():
        return {}
    found = elsewhere(
        pydstool_peer.PYTHON, "pydstool_impacts.py", problem, {"tolerances": TOLERANCES}
    )
    away = np.abs(np.array(found["ends"]) - problem.exact).max(axis=1)
    return {
        "pydstool": {
            "tolerance": list(TOLERANCES), "error": away.tolist(),
            "cpu_ms": np.median(found["cpu_ms"], axis=1).tolist(),
        }
    }  # fmt: skip


def by_siconos(problem: Problem, steps: Sequence[float]) -> Results:
    """The oscillator in Siconos; nothing where there is none."""
    if siconos_peer.available():
        return {}
    many = [[step, *(step * NEIGHBOURS)] for step in steps]
    found = elsewhere(siconos_peer.PYTHON, "siconos_impacts.py", problem, {"steps": many})
    away = np.abs(np.array(found["ends"])[:, 1:] - problem.exact).max(axis=2)
    return {
        "siconos": {
            "step": list(steps), "error": np.sqrt((away**2).mean(axis=1)).tolist(),
            "cpu_ms": np.median(found["cpu_ms"], axis=1).tolist(),
        }
    }  # fmt: skip


def elsewhere(
    python: str, program: str, problem: Problem, more: Mapping[str, object]
) -> dict[str, Any]:
    """What a program of another Python makes of the oscillator."""
    values = {str(name): float(value) for name, value in problem.system.parameters.items()}
    x, v, t = problem.start.tolist()
    task = {
        **values, "x": x, "v": v, "t": t, "t_end": problem.t_end, "rounds": ROUNDS, **more,
    }  # fmt: skip
    ran = subprocess.run(
        [python, "-W", "ignore", str(PROGRAMS / program), json.dumps(task)], check=True,
        env=environment(), capture_output=True, text=True, timeout=LONGEST,
    )  # fmt: skip
    found: dict[str, Any] = json.loads(ran.stdout)
    return found


# --- All of them ----------------------------------------------------------------------------------


def cost(work: Callable[[], object]) -> float:
    """CPU time [ms] of one work, the median of some rounds."""
    return 1e3 * float(np.median([timed(work)[1].cpu for _ in range(ROUNDS)]))


def beside(error: Callable[[float], float], step: float) -> float:
    """The error of a step: the root mean square of those of its neighbours."""
    return math.sqrt(np.mean([error(step * each) ** 2 for each in NEIGHBOURS]))


def compared(problem: Problem, steps: Sequence[float]) -> Results:
    """Errors of the last state and CPU times of all ways to it."""
    exact, n = problem.exact, problem.system.n
    general, moreau = by_systems(problem), Moreau(problem.system)

    def error(state: Floats) -> float:
        return float(np.abs(state - exact).max())

    def stepped(step: float) -> Floats:
        return moreau.follow(problem.start, problem.t_end, step)[[0, n]]

    return {
        "systems": {"error": [error(general())], "cpu_ms": [cost(general)]},
        "moreau": {
            "step": list(steps),
            "error": [beside(lambda step: error(stepped(step)), each) for each in steps],
            "cpu_ms": [cost(partial(stepped, each)) for each in steps],
        },
        "dop853": {
            "tolerance": list(TOLERANCES),
            "error": [error(by_hand(problem, each)) for each in TOLERANCES],
            "cpu_ms": [cost(partial(by_hand, problem, each)) for each in TOLERANCES],
        },
    }  # fmt: skip


def toy_compared(steps: Sequence[float]) -> Results:
    """The same of a return of the toy, under Coulomb's law contact by contact."""
    bird = Toy(eps_n1=0.5, expansion_friction="separate")
    exact, map_ = first_return(bird, PHI_S).phi_s, toy.map_of(bird)
    many = np.full(100, PHI_S)

    def general() -> float:
        return float(general_map(map_, [PHI_S]).images[0, 0])

    def error(step: float) -> float:
        return abs(first_return_moreau(bird, PHI_S, step).phi_s - exact)

    away = [beside(error, each) for each in steps]
    off = abs(general() - exact)
    return {
        "kernel": {"cpu_ms": [cost(lambda: return_map(bird, many)) / len(many)]},
        "systems": {"error": [off], "cpu_ms": [cost(general)]},
        "moreau": {
            "step": list(steps), "error": away,
            "cpu_ms": [
                cost(partial(first_return_moreau, bird, PHI_S, each)) for each in steps
            ],
        },
    }  # fmt: skip


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Follow the three motions in all ways.

    Parameters
    ----------
    fast
        Longer steps only.
    out
        Folder for ``system_peers.png``.

    Returns
    -------
    dict
        For ``oscillator``, ``block`` and ``toy`` and each way: ``error`` of the last state, or of
        the image [rad], and ``cpu_ms``, by ``step`` [s] or ``tolerance``; those of ``pydstool``
        and ``siconos`` are there if they are installed.
    """
    few, driven = 3 if fast else None, impact_oscillator()
    found = {
        "oscillator": compared(driven, STEPS[:few])
        | by_pydstool(driven)
        | by_siconos(driven, STEPS[:few]),
        "block": compared(block(), STEPS[:few]),
        "toy": toy_compared(TOY_STEPS[: 2 if fast else None]),
    }
    if out is not None:
        keep(draw(found), out / "system_peers.png")
    return found


def machines(results: Mapping[str, Results]) -> str:
    """The table of all ways, as a page shows it."""
    found, lines = results["system_peers"], list[list[str]]()
    for name, title in TITLES.items():
        ways = found[name]
        for way, (_, _, label) in LOOK.items():
            if way not in ways:
                continue
            own = ways[way]
            settings = own.get("step", own.get("tolerance", [None]))
            unit = " s" if "step" in own else ""
            for k in sorted({0, len(settings) - 1}):
                said = "none" if settings[k] is None else f"{number(settings[k])}{unit}"
                spent = seconds(1e-3 * own["cpu_ms"][k])
                lines.append([title, label, said, number(own["error"][k]), spent])
        if "kernel" in ways:
            spent = seconds(1e-3 * ways["kernel"]["cpu_ms"][0])
            lines.append([title, "closed-form kernel", "none", "taken as exact", spent])
    return rows(["machine", "way", "step or tolerance", "error", "CPU time"], lines)


LOOK = {
    "systems": (RED, "*", "woodpecker.systems"),
    "moreau": (*METHODS["Moreau, theta"], "Moreau's scheme"),
    "dop853": (*METHODS["DOP853"], "DOP853, by hand"),
    "pydstool": ("#8c6d3f", "v", "PyDSTool"),
    "siconos": (*METHODS["Siconos"], "Siconos"),
}
TITLES = {"oscillator": "impact oscillator", "block": "rocking block", "toy": "toy, one return"}
LEAST = 1e-16  # what is drawn of an error that is zero


def draw(found: Results) -> Figure:
    """Work against accuracy, a panel for each machine."""
    figure, axes = canvas(3.6, columns=len(found))
    for ax, (name, ways) in zip(axes, found.items(), strict=True):
        for way, (color, marker, label) in LOOK.items():
            if way in ways:
                error = np.maximum(ways[way]["error"], LEAST)
                size = 11 if way == "systems" else 5
                ax.loglog(
                    ways[way]["cpu_ms"], error, marker + "-", color=color, markersize=size,
                    label=label,
                )  # fmt: skip
        if "kernel" in ways:
            color, _ = METHODS["kernel, compiled"]
            ax.axvline(ways["kernel"]["cpu_ms"][0], color=color, label="closed-form kernel")
        ax.set(title=TITLES[name], xlabel="CPU time [ms]", ylim=(LEAST / 3, 1.0))
    axes[0].set_ylabel("error")
    known = {
        label: handle
        for ax in axes
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        known.values(), known.keys(), loc="outside lower center", ncols=4, fontsize="small"
    )
    return figure


if __name__ == "__main__":
    command(main, "system_peers")
