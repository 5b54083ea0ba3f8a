"""No more than a scene needs: what each reduction of the problem buys, on the same work.

    python -m studies.reductions [--fast] [--out DIR]

(a) Closed form: a smooth phase is one oscillator, known for all times; against numerical
    integration of all six states, in Python with its events (:mod:`studies.peers.ode`), and
    compiled.
(b) Small contact problems: try the few index combinations of one or two contacts; against Lemke's
    path on the general linear complementarity problem, at the impacts of the map.
(c) One coordinate: Newton's method for the fixed point of the map; against Newton's method for all
    five states on the section. Both must find the same multiplier.
(d) Isolated roots: the first root of every guard from its closed form; against a look at all guards
    N times per swing for a change of sign.

Impacts at two contacts expand under the toy's own law, friction bounded by the sum of both normal
impulses, in both solvers of (b).

Each pair does the same work in the same language, in turn, round after round; ratios are those of
the medians of CPU time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.integrate import DOP853

from studies.common.clocks import Job, Seconds, Timing, clocked, race
from studies.common.motion import GUESS
from studies.common.places import WINDOW
from studies.common.record import Results, command
from studies.common.style import STABLE, VIOLET, WIDTH, grid, keep
from studies.peers.cases import CYCLE, FIXED_POINT, distance, numbers
from studies.peers.kernel import PlainPython, Work
from studies.peers.ode import first_return_ode
from woodpecker import Toy, free_frequency, return_map
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import COMPILED, jit
from woodpecker.mechanics.impacts import PAIR_ROOM, one_contact, rates, two_contacts
from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.mechanics.modes import (
    CONTACT,
    DELASSUS,
    EPS,
    EXPANSION,
    FIXED,
    FORCE,
    GUARDS,
    KAPPA,
    MU,
    OMEGA,
    PAIR,
    SECTION,
    SUMMED,
    A,
    B,
    fill_pair,
    mode_states,
    model,
)
from woodpecker.simulation import calls
from woodpecker.simulation.calls import sweep
from woodpecker.simulation.codes import EVENT_COLUMNS, IMPACT, NO_PATH, PHASE_COLUMNS
from woodpecker.simulation.events import next_event, starting_jet, time_to_minimum
from woodpecker.simulation.flow import flow, measure
from woodpecker.simulation.guards import bracketed, value

EVENTS = 60  # room for one return
SHORTEST = 5e-3  # s; a job repeats its work until it lasts about this long

TABLEAU = (np.array(DOP853.A), np.array(DOP853.B))  # of order 8, as in scipy
SMOOTH_TARGET = 1e-10  # rad; error at which integration is compared with the closed form

QUOTIENT = 1e-7  # rad, rad/s, m/s; of difference quotients: noise 1e-15 and curvature 1e3 balance
CONVERGED = 1e-12  # rad; as in woodpecker.Tolerances

HALVINGS = 40  # of a distance of starts, down to 1e-14 rad
NEAR = 10.0 ** -np.arange(3.0, 11.0)  # rad; distances from an edge, above the error of the edge
SAME_TIME = 1e-9  # s; events further apart are different ones
LONGEST = 0.5  # s; phases next to free fall last for seconds and only make sampling dearer
LOOK_AHEAD = 2.0 * LONGEST  # where sampling gives up
GRAZED = Toy(eps_n1=0.2)  # whose sleeve grazes the pole at many changes of word


class Phase(NamedTuple):
    """A smooth phase and the event that ends it."""

    z: Floats  # state at its start, (7,)
    mode: int
    before: int  # guard that began it, -1 for none
    time: float  # s, its length
    guard: int  # that ends it


class Impacts(NamedTuple):
    """Compressions and expansions of k impacts, padded to two contacts; (N, T) of each in turn."""

    size: Ints  # (k,) contacts that take part
    delassus: Floats  # (k, 4, 4)
    free: Floats  # (k, 4) relative velocities [m/s]
    mu: Floats  # (k, 2)
    floor: Floats  # (k, 2) smallest normal impulses [N s]
    first: Ints  # (k,) where the table of the two contacts begins in the model; 0 for one contact
    coupling: Floats  # (k,) what the other normal impulse adds to a bound of friction, over mu


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How much is measured."""

    rounds: int = 9
    starts: int = 400  # of the map, for phases and impacts
    impacts: int = 400
    edges: int = 100  # starts between which changes of word are looked for
    densities: tuple[int, ...] = (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096)


FAST = Plan(rounds=3, starts=40, impacts=60, edges=20, densities=(4, 64, 1024))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure all four reductions and say in words what came out.

    Returns
    -------
    dict
        ``closed_form``, ``contacts``, ``shooting``, ``events``: seconds, ratios, and how far both
        ways agree; ``ratios``: one number for each bar of the picture; ``text``: a paragraph.
    """
    plan = FAST if fast else Plan()
    starts = np.linspace(*WINDOW, plan.starts)
    phases, impacts = recorded(Toy(), starts)
    hard, _ = recorded(GRAZED, beside_edges(GRAZED, starts[:: plan.starts // plan.edges]))
    with PlainPython() as other:
        found: Results = {
            "compiled": COMPILED,
            "closed_form": closed_form(other, plan),
            "contacts": contacts(thinned(impacts, plan.impacts), other, plan),
            "shooting": shooting(plan),
            "events": events(short(phases), short(hard), plan),
        }
    found["ratios"] = bars(found)
    found["text"] = paragraph(found)
    if out is not None:
        keep(draw(found), out / "reductions.png")
    return found


# What a motion consists of


def recorded(toy: Toy, begin: Floats) -> tuple[list[Phase], Impacts]:
    """Smooth phases and impacts of the returns from these starts, as in the kernel."""
    table = model(toy)
    phases: list[Phase] = []
    gaps = np.zeros(3)
    impacts: list[tuple[Ints, Floats, Floats]] = []
    for phi_s in begin:
        rows, happened = _one_return(table, phi_s)
        before = -1
        for row in rows:
            mode = int(row[7])
            states = np.array(mode_states(mode))
            measure(table, row[:7], gaps)
            time, guard = next_event(table, mode, row[:7], gaps, states, True, math.inf, before, -1)
            phases.append(Phase(row[:7].copy(), mode, before, time, guard))
            before = guard
        for event in happened:
            impacts += _phases_of_impact(table, event)
    return phases, _padded(table, impacts)


def beside_edges(toy: Toy, begin: Floats) -> Floats:
    """Starts on both sides of every change of word between neighbours, closer and closer to it.

    There a guard just reaches zero, or just does not: the events that are easy to miss.
    """
    low, high = begin[:-1].copy(), begin[1:].copy()
    words = return_map(toy, begin).words
    change = np.array([one != other for one, other in pairwise(words)])
    low, high, left = low[change], high[change], np.array(words[:-1])[change]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = np.array(return_map(toy, middle).words) == left
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.concatenate([edge + sign * NEAR for edge in low for sign in (-1.0, 1.0)])


def _one_return(table: Floats, phi_s: float) -> tuple[Floats, Floats]:
    """Phases and events of one return, as :func:`woodpecker.simulation.calls.run` leaves them."""
    phases = np.zeros((EVENTS, PHASE_COLUMNS))
    happened = np.zeros((EVENTS, EVENT_COLUMNS))
    z, counts = np.zeros(7), np.zeros(3, np.int64)
    z[1], z[2] = -table[CONTACT + 1, 0], phi_s
    calls.run(
        table, z, np.array([0, 1, 0]), True, math.inf, np.zeros(EVENTS, np.int16), phases,
        NO_PATH, happened, counts,
    )  # fmt: skip
    return phases[: counts[1]], happened[: counts[2]]


def _phases_of_impact(table: Floats, event: Floats) -> list[tuple[Ints, Floats, Floats]]:
    """Contacts, free velocities and floors of the compression, and of the expansion if any."""
    code = int(event[1])
    if code == 0 or code % 64 // 8 != IMPACT:
        return []
    hit = np.array([i for i in range(3) if code % 8 >> i & 1])
    z = np.concatenate([np.zeros(3), event[2:5], [0.0]])
    free = np.concatenate([rates(table, i, z) for i in hit])
    columns = np.concatenate([8 + (0 if i == 0 else 2) + np.arange(2) for i in hit])
    compression = event[columns]
    out = [(hit, free, np.zeros(len(hit)))]
    floor = table[CONTACT + hit, EPS] * compression[::2]
    if floor.any():
        pick = np.concatenate([[2 * i, 2 * i + 1] for i in hit])
        after = free + table[DELASSUS + pick][:, pick] @ compression
        after[np.abs(after) < 1e-12 * np.abs(free).max()] = 0.0  # contacts that came to rest
        out.append((hit, after, floor))
    return out


def _padded(table: Floats, impacts: Sequence[tuple[Ints, Floats, Floats]]) -> Impacts:
    k = len(impacts)
    out = Impacts(
        np.zeros(k, np.int64), np.zeros((k, 4, 4)), np.zeros((k, 4)), np.zeros((k, 2)),
        np.zeros((k, 2)), np.zeros(k, np.int64), np.zeros(k),
    )  # fmt: skip
    for row, (hit, free, floor) in enumerate(impacts):
        n = len(hit)
        pick = np.concatenate([[2 * i, 2 * i + 1] for i in hit])
        out.size[row] = n
        out.delassus[row, : 2 * n, : 2 * n] = table[DELASSUS + pick][:, pick]
        out.free[row, : 2 * n], out.floor[row, :n] = free, floor
        out.mu[row, :n] = table[CONTACT + hit, MU]
        if n == 2:
            summed = bool(floor.any() and table[FORCE, SUMMED])  # elsewhere it is Coulomb's table
            out.first[row] = PAIR + 36 * (hit[1] - 1) + EXPANSION * summed
            out.coupling[row] = float(summed)
    return out


def thinned(impacts: Impacts, count: int) -> Impacts:
    """About ``count`` of them, evenly spread."""
    stride = max(1, len(impacts.size) // count)
    return Impacts._make(column[::stride] for column in impacts)


# (a) Closed form


def closed_form(other: PlainPython, plan: Plan) -> Results:
    """The cycle in Python, with its events; its smooth phases alone, compiled."""
    toy = CYCLE.toy
    phases, _ = recorded(toy, np.array([CYCLE.phi_s]))
    rtol, once = 1e-3, first_return_ode(toy, CYCLE.phi_s, rtol=1e-3, atol=1e-5)
    while distance(once.phi_s, CYCLE.image) > SMOOTH_TARGET:
        rtol /= 10.0
        once = first_return_ode(toy, CYCLE.phi_s, rtol=rtol, atol=1e-2 * rtol)
    smooth = gathered(toy, phases)
    exact, steps = smooth.closed(), 1
    while smooth.distance(exact, smooth.integrated(steps)) > SMOOTH_TARGET:
        steps += 1
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(toy), [CYCLE.phi_s])
    jobs: dict[str, Job] = {
        "python_closed": lambda: ask(count=5)[1],
        "python_integrated": clocked(
            lambda: first_return_ode(toy, CYCLE.phi_s, rtol=rtol, atol=1e-2 * rtol)
        ),
        "closed": repeated(smooth.closed),
        "integrated": repeated(partial(smooth.integrated, steps)),
    }
    timings = race(jobs, plan.rounds)
    return {
        "rtol": rtol,
        "error_python": distance(once.phi_s, CYCLE.image),
        "steps": steps,
        "step": float(smooth.times.max() / steps),
        "error": smooth.distance(exact, smooth.integrated(steps)),
        "ratio_python": over(timings, "python_integrated", "python_closed"),
        "ratio": over(timings, "integrated", "closed"),
        "timings": timings,
    }


class Smooth(NamedTuple):
    """Smooth phases as compiled code wants them."""

    table: Floats
    z: Floats  # (n, 7)
    modes: Ints
    before: Ints
    times: Floats

    def closed(self) -> Floats:
        """Ends of the phases by the closed form."""
        out = np.empty((len(self.modes), 7))
        _flows(self.table, self.z, self.modes, self.times, out)
        return out

    def integrated(self, steps: int) -> Floats:
        """Ends of the phases by this many steps in the longest, in proportion in the others."""
        out = np.empty((len(self.modes), 7))
        _runge_kutta(self.table, self.z, self.modes, self.times, steps, *TABLEAU, out)
        return out

    @staticmethod
    def distance(one: Floats, other: Floats) -> float:
        """Largest difference in a coordinate [m] or [rad]."""
        return float(np.abs(one[:, :3] - other[:, :3]).max())


def gathered(toy: Toy, phases: Sequence[Phase]) -> Smooth:
    """The columns of some phases."""
    z, modes, before, times, _ = zip(*phases, strict=True)
    return Smooth(model(toy), np.array(z), np.array(modes), np.array(before), np.array(times))


@jit
def _flows(table: Floats, z: Floats, modes: Ints, times: Floats, out: Floats) -> None:
    for k in range(len(modes)):
        flow(table, modes[k], z[k], times[k], out[k])


@jit
def _runge_kutta(
    table: Floats, z: Floats, modes: Ints, times: Floats, steps: int, a: Floats, b: Floats,
    out: Floats,
) -> None:  # fmt: skip
    """An explicit Runge-Kutta method with equal steps for q'' = A + B (phi_S - phi_M)."""
    slopes, x = np.zeros((len(b), 6)), np.zeros(6)
    longest = times.max()
    for k in range(len(modes)):
        mode, n = modes[k], math.ceil(steps * times[k] / longest)
        h = times[k] / n
        for j in range(6):
            out[k, j] = z[k, j]
        for _ in range(n):
            for stage in range(len(b)):
                for j in range(6):
                    x[j] = out[k, j]
                    for earlier in range(stage):
                        x[j] += h * a[stage, earlier] * slopes[earlier, j]
                for j in range(3):
                    slopes[stage, j] = x[3 + j]
                    slopes[stage, 3 + j] = table[mode, A + j] + table[mode, B + j] * (x[2] - x[1])
            for stage in range(len(b)):
                for j in range(6):
                    out[k, j] += h * b[stage] * slopes[stage, j]


# (b) Contact problems


def contacts(impacts: Impacts, other: PlainPython, plan: Plan) -> Results:
    """Both solvers at the same impacts, in Python; the direct one compiled as well."""
    lists = [column.tolist() for column in impacts]
    ask = partial(other.ask, "studies.reductions:direct_work", *lists)
    jobs: dict[str, Job] = {
        "direct": clocked(partial(direct, impacts), count=20, units=len(impacts.size)),
        "python_direct": lambda: shared(ask()[1], len(impacts.size)),
        "lemke": clocked(partial(lemke, impacts), units=len(impacts.size)),
    }
    timings = race(jobs, plan.rounds)
    one, two = direct(impacts), lemke(impacts)
    solved = np.isfinite(two).all(axis=1)
    size = np.abs(two[solved]).max(axis=1)
    apart = np.abs(one[solved] - two[solved]).max(axis=1) / np.where(size > 0.0, size, 1.0)
    return {
        "problems": len(impacts.size),
        "with_two_contacts": int((impacts.size == 2).sum()),
        "unsolved_by_lemke": int((~solved).sum()),
        "largest_difference": float(apart.max()),
        "ratio_python": over(timings, "lemke", "python_direct"),
        "ratio": over(timings, "lemke", "direct"),
        "timings": timings,
    }


def direct(impacts: Impacts) -> Floats:
    """Impulses (N, T) of each contact in turn by trying index combinations."""
    out = np.zeros((len(impacts.size), 4))
    table = model(Toy())
    for k in (1, 2):
        fill_pair(table, k, np.empty((4, 4)), np.empty((2, 2)), np.empty((4, 10)))
    _direct(table, *impacts, out)
    return out


def direct_work(*columns: list[Any]) -> Work:
    """Work for another process: the direct solver at impacts that come as lists."""
    impacts = Impacts(*map(np.array, columns))
    return lambda: len(direct(impacts))


@jit
def _direct(
    table: Floats, size: Ints, delassus: Floats, free: Floats, mu: Floats, floor: Floats,
    first: Ints, coupling: Floats, out: Floats,
) -> None:  # fmt: skip
    cases, feeds = np.zeros((2, 2), dtype=np.int64), np.zeros(2, dtype=np.int64)
    owner = np.zeros(1, dtype=PAIR_ROOM)
    pair = owner[0]
    for k in range(len(size)):
        if size[k] == 1:
            g = delassus[k]
            _, _, out[k, 0], out[k, 1] = one_contact(
                g[0, 0], g[0, 1], g[1, 1], free[k, 0], free[k, 1], mu[k, 0], floor[k, 0]
            )
        else:
            two_contacts(
                table, first[k], delassus[k], free[k], mu[k], coupling[k], floor[k], feeds, cases,
                out[k], pair,
            )  # fmt: skip


def lemke(impacts: Impacts) -> Floats:
    """The same by Lemke's path; nan where it ends in a ray."""
    out = np.zeros((len(impacts.size), 4))
    for k, n in enumerate(impacts.size):
        normals_first = np.concatenate([np.arange(0, 2 * n, 2), np.arange(1, 2 * n, 2)])
        g = impacts.delassus[k][np.ix_(normals_first, normals_first)]
        friction = impacts.mu[k, :n, None] * np.where(np.eye(n) == 1.0, 1.0, impacts.coupling[k])
        answer = solve_contact_lcp(
            g, impacts.free[k, normals_first], friction, impacts.floor[k, :n]
        )
        out[k, 0 : 2 * n : 2], out[k, 1 : 2 * n : 2] = answer.impulse_n, answer.impulse_t
    return out


# (c) Shooting


class Found(NamedTuple):
    """A fixed point by Newton's method."""

    z: Floats
    jacobian: Floats
    returns: int  # simulated


def shooting(plan: Plan) -> Results:
    """Fixed point and multiplier with one unknown and with five."""
    toy = Toy()
    jobs = {
        "one": clocked(partial(shoot_one, toy, GUESS), 5),
        "five": clocked(partial(shoot_five, toy, GUESS), 5),
    }
    timings = race(jobs, plan.rounds)
    one, five = shoot_one(toy, GUESS), shoot_five(toy, GUESS)
    eigenvalues = sorted(np.linalg.eigvals(five.jacobian), key=abs, reverse=True)
    return {
        "error_one": distance(one.z[1], FIXED_POINT.phi_s),
        "error_five": distance(five.z[1], FIXED_POINT.phi_s),
        "multiplier_one": float(one.jacobian[0, 0]),
        "error_multiplier_one": distance(one.jacobian[0, 0], FIXED_POINT.multiplier),
        "eigenvalues_five": [[float(x.real), float(x.imag)] for x in eigenvalues],
        "error_multiplier_five": distance(eigenvalues[0].real, FIXED_POINT.multiplier),
        "largest_other_eigenvalue": float(abs(eigenvalues[1])),
        "returns_one": one.returns,
        "returns_five": five.returns,
        "ratio": over(timings, "five", "one"),
        "timings": timings,
    }


def land(table: Floats, z: Floats) -> Floats:
    """Next return of a state (phi_M, phi_S, dy, dphi_M, dphi_S) at or near the section.

    A minimum of phi_S before the beak or the upper sleeve contact has struck is the end of the
    disturbance of the start, not a return.
    """
    state, counts = np.concatenate([[0.0], z, [0.0]]), np.zeros(3, np.int64)
    touching = z[0] <= -table[CONTACT + 1, 0] and z[3] == 0.0
    slips = rates(table, 1, state)[1] != 0.0
    states = np.array([0, (2 if slips else 1) if touching else 0, 0])
    codes = np.zeros(EVENTS, np.int16)
    away = 0
    while not away:
        calls.run(
            table, state, states, True, math.inf, codes, np.zeros((0, PHASE_COLUMNS)),
            NO_PATH, np.zeros((0, EVENT_COLUMNS)), counts,
        )  # fmt: skip
        away = int(np.bitwise_or.reduce(codes[: counts[0]] % 8)) & 0b101
    return state[1:6]


def shoot_one(toy: Toy, guess: float, steps: int = 20) -> Found:
    """Newton's method in phi_S with the exact slope of the map."""
    table, phi_s = model(toy), np.array([guess])
    out, words = np.empty((1, 5)), np.empty((1, EVENTS), np.int16)
    status, lengths = np.empty(1, np.int64), np.empty(1, np.int64)
    spent = 0
    for _ in range(steps):
        spent += 1
        sweep(table, FIXED, phi_s, 1, np.zeros((1, 3)), out, status, lengths, words)
        residual, slope = out[0, 0] - phi_s[0], out[0, 3]
        if abs(residual) <= CONVERGED:
            break
        phi_s += residual / (1.0 - slope)
    z = np.array([-toy.phi_m_max, phi_s[0], 0.0, 0.0, 0.0])
    return Found(z, np.array([[slope]]), spent)


def shoot_five(toy: Toy, guess: float, steps: int = 20) -> Found:
    """Newton's method in all states on the section, with difference quotients of the flow.

    Differences go to the side where the sleeve is not inside the pole and phi_S is past its
    minimum.
    """
    table, z, spent = model(toy), np.array([-toy.phi_m_max, guess, 0.0, 0.0, 0.0]), 0
    for _ in range(steps):
        image = land(table, z)
        jacobian = np.column_stack(
            [(land(table, z + QUOTIENT * e) - image) / QUOTIENT for e in np.eye(5)]
        )
        spent += 6
        residual = image - z
        if np.abs(residual).max() <= CONVERGED:
            break
        z = z + np.linalg.solve(np.eye(5) - jacobian, residual)
    return Found(z, jacobian, spent)


# (d) Events


def events(phases: Sequence[Phase], hard: Sequence[Phase], plan: Plan) -> Results:
    """Cost of both ways on phases of the map; failures there, and on phases next to grazing."""
    swing = 1.0 / free_frequency(Toy())
    usual, grazing = gathered(Toy(), phases), gathered(GRAZED, hard)
    jobs = {"isolated": clocked(partial(isolated, usual), 3, len(phases))}
    for n in plan.densities:
        jobs[str(n)] = clocked(partial(sampled, usual, swing / n), 1, len(phases))
    timings = race(jobs, plan.rounds)
    sampling = [
        {
            "per_swing": n,
            "missed": wrong(phases, *sampled(usual, swing / n)),
            "missed_next_to_grazing": wrong(hard, *sampled(grazing, swing / n)),
            "ratio": over(timings, str(n), "isolated"),
        }
        for n in plan.densities
    ]
    reliable = next((row for row in sampling if not row["missed_next_to_grazing"]), None)
    return {
        "phases": len(phases),
        "phases_next_to_grazing": len(hard),
        "isolated_missed": earlier(usual, swing / plan.densities[-1])
        + earlier(grazing, swing / plan.densities[-1]),
        "shortest_dip": shortest_dip(grazing.table, hard),
        "sampling": sampling,
        "reliable_per_swing": reliable["per_swing"] if reliable else None,
        "reason": None if reliable else "events were missed at every density tried",
        "timings": timings,
    }


def isolated(smooth: Smooth) -> tuple[Floats, Ints]:
    """Time and guard of the first event of each phase, as the kernel finds them."""
    times, which = np.empty(len(smooth.modes)), np.empty(len(smooth.modes), np.int64)
    _isolate(*smooth[:4], times, which)
    return times, which


def sampled(smooth: Smooth, step: float) -> tuple[Floats, Ints]:
    """The same by looking at all guards every ``step`` seconds."""
    times, which = np.empty(len(smooth.modes)), np.empty(len(smooth.modes), np.int64)
    _sample(*smooth[:4], step, times, which)
    return times, which


def short(phases: Sequence[Phase]) -> list[Phase]:
    """Those that sampling can be asked to follow."""
    return [phase for phase in phases if phase.time < LONGEST]


def earlier(smooth: Smooth, step: float) -> int:
    """Events that sampling finds before the one that isolation calls the first."""
    return int((sampled(smooth, step)[0] < smooth.times - SAME_TIME).sum())


def wrong(phases: Sequence[Phase], times: Floats, which: Ints) -> int:
    """Number of events that are not the first of their phase."""
    found = zip(phases, times, which, strict=True)
    return sum(int(p.guard != guard or abs(p.time - time) > SAME_TIME) for p, time, guard in found)


def shortest_dip(table: Floats, phases: Sequence[Phase]) -> float:
    """Shortest time [s] for which a guard that ends a phase would stay negative if ignored."""
    shortest, gaps = math.inf, np.zeros(3)
    for phase in phases:
        if phase.guard == SECTION:
            continue
        states = np.array(mode_states(phase.mode))
        measure(table, phase.z, gaps)
        jet = starting_jet(table, phase.mode, phase.guard, phase.z, gaps, states, phase.before)
        kappa, omega = table[phase.mode, KAPPA], table[phase.mode, OMEGA]
        ahead = phase.time + np.geomspace(1e-9, 0.01, 1000)
        up = [t for t in ahead if value(*jet, kappa, omega, t)[0] > 0.0]
        if up:
            shortest = min(shortest, up[0] - phase.time)
    return float(shortest)


@jit
def _states(mode: int, states: Ints) -> None:
    """States of the contacts in a mode, as in modes.mode_states."""
    sleeve = mode % 7
    states[0] = mode // 7
    states[1] = sleeve if sleeve <= 3 else 0
    states[2] = sleeve - 3 if sleeve > 3 else 0


@jit
def _isolate(
    table: Floats, z: Floats, modes: Ints, before: Ints, times: Floats, which: Ints
) -> None:
    states, gaps = np.zeros(3, dtype=np.int64), np.zeros(3)
    for k in range(len(modes)):
        _states(modes[k], states)
        measure(table, z[k], gaps)
        times[k], which[k] = next_event(
            table, modes[k], z[k], gaps, states, True, math.inf, before[k], -1
        )


@jit
def _sample(
    table: Floats, z: Floats, modes: Ints, before: Ints, step: float, times: Floats, which: Ints
) -> None:
    """First change of sign of a guard between two samples, then Newton's method for its root."""
    states, jets, gaps = np.zeros(3, dtype=np.int64), np.zeros((5, 4)), np.zeros(3)
    for k in range(len(modes)):
        mode = modes[k]
        _states(mode, states)
        measure(table, z[k], gaps)
        kappa, omega = table[mode, KAPPA], table[mode, OMEGA]
        end, fired, n = LOOK_AHEAD, -1, 0
        while n < 5 and table[mode, GUARDS + n] >= 0:
            guard = int(table[mode, GUARDS + n])
            if guard == SECTION:
                end, fired = time_to_minimum(table, mode, z[k]), guard
                break  # the last one
            jets[n, 0], jets[n, 1], jets[n, 2], jets[n, 3] = starting_jet(
                table, mode, guard, z[k], gaps, states, before[k]
            )
            n += 1
        low = 0.0
        while low < end:
            high = min(low + step, end)
            for i in range(n):
                f0, f1, f2, f3 = jets[i, 0], jets[i, 1], jets[i, 2], jets[i, 3]
                if value(f0, f1, f2, f3, kappa, omega, high)[0] < 0.0:
                    root = bracketed(f0, f1, f2, f3, kappa, omega, low, high)
                    if root < end:
                        end, fired = root, int(table[mode, GUARDS + i])
            low = high
        times[k], which[k] = end, fired


# What comes of it


def repeated(work: Work) -> Job:
    """Job that repeats a work, compiled by a first call, for about 5 ms."""
    work()
    once = max(clocked(work)().cpu, 1e-6)
    return clocked(work, max(1, math.ceil(SHORTEST / once)))


def over(timings: dict[str, Timing], slow: str, quick: str) -> float:
    """Ratio of medians of CPU time."""
    return timings[slow]["cpu_median"] / timings[quick]["cpu_median"]


def shared(seconds: Seconds, units: int) -> Seconds:
    """Time of one of several equal units."""
    return Seconds(seconds.wall / units, seconds.cpu / units)


def bars(found: Results) -> list[dict[str, Any]]:
    """What is drawn: by how much the general way is slower."""
    dense = found["events"]["sampling"][-1]
    misses = dense["missed_next_to_grazing"]
    sampling = f"{dense['per_swing']} samples a swing, missing {misses}"
    rows = [
        ("closed form", "integrator with events, Python", found["closed_form"]["ratio_python"]),
        ("closed form", "order 8 without events, compiled", found["closed_form"]["ratio"]),
        ("index combinations", "Lemke's path, Python", found["contacts"]["ratio_python"]),
        ("one unknown", "five unknowns, compiled", found["shooting"]["ratio"]),
        ("isolated roots", sampling, dense["ratio"]),
    ]
    return [{"reduction": a, "against": b, "ratio": x} for a, b, x in rows]


def paragraph(found: Results) -> str:
    """The result in words, every number from the measurement."""
    smooth, hits = found["closed_form"], found["contacts"]
    shot, roots = found["shooting"], found["events"]
    sampling = roots["sampling"]
    rest = shot["largest_other_eigenvalue"]
    apart = abs(shot["eigenvalues_five"][0][0] - shot["multiplier_one"])
    first, last = sampling[0], sampling[-1]
    return (
        f"The closed form is {smooth['ratio_python']:.2g} times as quick as integrating six states "
        f"with events to {smooth['error_python']:.0e} rad, both in Python; without events and "
        f"compiled, {smooth['ratio']:.2g} times as quick as a formula of order 8 with "
        f"{1e3 * smooth['step']:.2g} ms steps, which errs by {smooth['error']:.0e} rad. "
        f"Trying index combinations is {hits['ratio_python']:.2g} times as quick as Lemke's path, "
        f"both in Python, over {hits['problems']} contact problems, {hits['with_two_contacts']} of "
        f"them with two contacts; the impulses agree to {hits['largest_difference']:.0e}, and "
        f"Lemke's path fails {hits['unsolved_by_lemke']} times. "
        f"Shooting with five unknowns costs {shot['ratio']:.2g} times as much as with one "
        f"({shot['returns_five']} returns instead of {shot['returns_one']}); its multiplier is the "
        f"same to {apart:.0e}, and the other four eigenvalues are "
        f"{f'below {rest:.0e}' if rest else 'exactly 0'}. "
        f"In {roots['phases']} phases of the map and {roots['phases_next_to_grazing']} next to "
        f"grazing, sampling finds {roots['isolated_missed']} events before the one that isolating "
        "all roots gives. Next to grazing "
        f"{first['per_swing']} samples a swing miss {first['missed_next_to_grazing']}, at "
        f"{first['ratio']:.2g} times its cost, and {last['per_swing']} samples "
        f"{last['missed_next_to_grazing']}, at {last['ratio']:.2g} times; the shortest dip of a "
        f"guard lasts {roots['shortest_dip']:.0e} s."
    )


# The picture


def draw(found: Results) -> Figure:
    """Bars: how much slower the general way is. Beside them: what sampling misses."""
    figure = plt.figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    rows = [row for row in found["ratios"] if row["ratio"] is not None]
    ratios = [row["ratio"] for row in rows]
    left.barh(range(len(rows)), ratios, color=STABLE, height=0.5)
    left.set_yticks(
        range(len(rows)), [f"{r['reduction']}\nagainst {r['against']}" for r in rows], fontsize=7.5
    )
    for y, x in enumerate(ratios):
        left.annotate(f"{x:.3g}", (x, y), (3, 0), textcoords="offset points", va="center",
                      fontsize=8)  # fmt: skip
    left.invert_yaxis()
    left.set(xscale="log", xlim=(1.0, 4.0 * max(ratios)))
    left.set_xlabel("time of the general way over ours [-]", fontsize=8.5)
    left.set_title("(a) what each reduction saves", fontsize=8.5, loc="left")
    _draw_sampling(right, found["events"])
    for ax in (left, right):
        grid(ax)
        ax.tick_params(axis="x", labelsize=8)
    right.tick_params(labelsize=8)
    return figure


def _draw_sampling(ax: Axes, roots: Results) -> None:
    """Events that sampling misses over what it costs."""
    rows = roots["sampling"]
    cost, missed = [r["ratio"] for r in rows], [r["missed_next_to_grazing"] for r in rows]
    ax.plot(cost, missed, "o-", color=VIOLET, markersize=4, linewidth=1.0)
    for row, x, y in list(zip(rows, cost, missed, strict=True))[::2]:
        ax.annotate(f"{row['per_swing']}", (x, y), (4, 4), textcoords="offset points",
                    fontsize=7.5, color=VIOLET)  # fmt: skip
    ax.plot(1.0, roots["isolated_missed"], "o", color=STABLE, markersize=6, clip_on=False, zorder=5)
    ax.annotate("isolated roots", (1.0, roots["isolated_missed"]), (5, 5), fontsize=7.5,
                textcoords="offset points", color=STABLE)  # fmt: skip
    ax.set(xscale="log", xlim=(0.6, 5.0 * max(cost)), ylim=(0.0, 1.12 * max(missed)))
    ax.set_xlabel("time over that of isolated roots [-]", fontsize=8.5)
    phases = f"{roots['phases_next_to_grazing']} phases"
    ax.set_ylabel(f"missed events in {phases} [-]", fontsize=8.5)
    ax.set_title("(b) sampling, times per swing", fontsize=8.5, loc="left")


if __name__ == "__main__":
    command(main, "reductions")
