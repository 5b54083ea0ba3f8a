"""What does a digit cost? Error against CPU time for the kernel and for every other method.

    python -m studies.work_precision [--fast] [--out DIR]

Five tasks: three scenes of :mod:`studies.peers.cases`, the map at 1000 points, and the fixed point
with its multiplier. Each method runs over its own knob: rtol of ``solve_ivp``, the step of a
time-stepping scheme, the digits of mpmath. The kernel has none. Errors are distances from 30-digit
references. Friction is Coulomb's contact by contact (``expansion_friction="separate"``): Moreau's
scheme and Siconos know no other, and ``solve_ivp``, which has the project's contact problems, is
held to it. Methods run in turn, round after round, and every time is that of a call as a user makes
it.

- A method that would take minutes over the map runs on twelve of its points; its time is scaled to
  the thousand, and marked ``scaled``.
- A word that differs from the reference's means that events were missed or invented: such points
  are recorded (``word_right``) and drawn hollow, however small their error.
- A return that a method cannot finish is recorded with its reason (``lost``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from studies.common.clocks import Job, Seconds, clocked, race, repeats, summary, timed
from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.motion import GUESS
from studies.common.record import Results, command
from studies.common.style import GREY, METHODS, WIDTH, grid, keep
from studies.peers.cases import (
    CYCLE,
    DIGITS,
    FIXED_POINT,
    POINTS,
    SAMPLE_IMAGES,
    SAMPLED,
    SCENES,
    Scene,
    distance,
    numbers,
    recomputed_fixed_point,
    same_events,
    sample,
    starts,
)
from studies.peers.kernel import PlainPython, Precise, first_return_kernel, first_return_mpmath
from studies.peers.moreau import SCHEMES, SOLVERS, first_return_moreau
from studies.peers.ode import first_return_ode
from studies.peers.peer import LostError, PeerReturn
from studies.peers.siconos_peer import available, first_return_siconos, simulate_siconos
from woodpecker import ReturnMap, Toy, return_map, shoot
from woodpecker.base.compiled import COMPILED

KERNEL, PLAIN, TWIN = "kernel, compiled", "kernel, plain Python", "kernel, mpmath"
OURS = (KERNEL, PLAIN, TWIN)
MAP, FIXED = "map of 1000 points", "fixed point, multiplier"
TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)  # errors [rad] of the table
FLOOR = 1e-17  # rad; where smaller errors are drawn, a tenth of the spacing of doubles near 0.5

BEND = 0.1  # rad; length over which the slope of the map near its fixed point changes

SICONOS_ELSEWHERE = "Siconos: only on the scenes, for it starts a process for every return"

SLOW = 0.25  # s; work longer than this is measured once, and its own length hides the noise

AnyReturn = PeerReturn | Precise


class Setting(NamedTuple):
    """A method with its knob turned to one value."""

    method: str  # a key of style.METHODS
    variant: str  # solver of the contact problem, or ""
    knob: str  # "rtol", "step" or "digits"
    value: float
    peer: Callable[[Toy, float], AnyReturn]

    @property
    def noise(self) -> float:
        """Relative size of the error to be expected of one return."""
        return 10.0**-self.value if self.knob == "digits" else self.value


class Answer(NamedTuple):
    """How good a result is."""

    error: float  # rad; of a fixed point also its multiplier's, whichever is larger
    word_right: bool | None  # None if the task has no word
    evaluations: int | None  # of the right-hand side, or steps
    detail: dict[str, float] | None = None


class Entry(NamedTuple):
    """Work of one method on one task, and how its result is judged."""

    method: str
    variant: str
    knob: str
    value: float | None
    work: Callable[[], Any]
    judge: Callable[[Any], Answer]
    clock: Callable[[int], Job] | None = None  # of work in another process
    scale: float = 1.0  # from the work done to the task


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How much is measured."""

    rtols: tuple[float, ...] = tuple(10.0**-k for k in range(3, 13))
    solvers: tuple[str, ...] = ("RK45", "DOP853", "Radau", "LSODA")
    steps: tuple[float, ...] = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
    siconos: tuple[float, ...] = (1e-3, 1e-4, 1e-5)
    digits: tuple[int, ...] = (10, DIGITS, 50)
    rounds: int = 4
    whole_map: bool = True  # also for the plain kernel
    patience: float = 0.5  # s; a setting slower than this on the cycle goes no further
    halvings: int = 9  # of the step, to fit orders of convergence


FAST = Plan(
    rtols=(1e-4, 1e-8),
    solvers=("RK45", "DOP853"),
    steps=(1e-4, 1e-5),
    siconos=(1e-3,),
    digits=(10,),
    rounds=1,
    whole_map=False,
    patience=0.05,
    halvings=5,
)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure every method on every task, fit orders, draw.

    Parameters
    ----------
    fast
        Take few settings and one round, and the map at a few points.
    out
        Folder for ``work_precision.png``.

    Returns
    -------
    dict
        ``kernel_ahead``: whether, on every task, no peer that gets below 1e-3 is as quick as the
        compiled kernel, and the kernel reaches every target. ``table``: per task and target error
        the cheapest peer, and its time over the kernel's. ``orders``: convergence orders, expected
        and fitted. ``missed``: settings with a wrong word, per task. ``tasks``: all points.
        ``left_out``: what was not measured, and why.
    """
    plan = FAST if fast else Plan()
    settings = list(peers(plan))
    warm(settings)
    with PlainPython() as other, ThreadPoolExecutor(1) as one_core:
        tasks = {
            scene.name: measured(
                [*scene_entries(scene, settings, other), *siconos_entries(scene, plan)],
                plan.rounds,
            )
            for scene in SCENES
        }
        quick, slow = affordable(settings, tasks[CYCLE.name], plan.patience)
        tasks[MAP] = measured(
            map_entries(quick, other, one_core, plan.whole_map), min(plan.rounds, 2)
        )
        tasks[FIXED] = measured(fixed_entries(quick, other), min(plan.rounds, 3))
    table = {task: compared(rows) for task, rows in tasks.items()}
    if out is not None:
        keep(draw(tasks), out / "work_precision.png")
    return {
        "kernel_ahead": all(map(ahead, tasks.values())),
        "compiled": COMPILED,
        "table": table,
        "orders": orders(tasks, plan),
        "missed": {task: [name(row) for row in rows if row["word_right"] is False]
                   for task, rows in tasks.items()},
        "tasks": tasks,
        "left_out": [*slow, available() or SICONOS_ELSEWHERE],
    }  # fmt: skip


# What runs


def peers(plan: Plan) -> Iterator[Setting]:
    """All methods but the kernel itself, over their knobs."""
    for digits in plan.digits:
        yield Setting(TWIN, "", "digits", digits, partial(first_return_mpmath, digits=digits))
    for solver in plan.solvers:
        for rtol in plan.rtols:
            peer = partial(first_return_ode, method=solver, rtol=rtol, atol=1e-2 * rtol)
            yield Setting(solver, "", "rtol", rtol, peer)
    for scheme in SCHEMES:
        for way in SOLVERS:
            for step in plan.steps:
                peer = partial(first_return_moreau, step=step, scheme=scheme, solver=way)
                yield Setting(f"Moreau, {scheme}", way, "step", step, peer)


def warm(settings: Iterable[Setting]) -> None:
    """Compile what is compiled: the kernel, and the coarsest setting of every method, run once."""
    first_return_kernel(CYCLE.toy, CYCLE.phi_s)
    known: set[tuple[str, str]] = set()
    for setting in settings:
        if setting[:2] not in known:
            known.add(setting[:2])
            try:
                setting.peer(CYCLE.toy, CYCLE.phi_s)
            except LostError:
                continue


def evaluations_of(once: AnyReturn) -> int | None:
    """What a return took; None if that was not counted."""
    return once.evaluations if isinstance(once, PeerReturn) else None


def scene_entries(scene: Scene, settings: Iterable[Setting], other: PlainPython) -> Iterator[Entry]:
    """One return of a scene by everyone."""

    def judge(once: AnyReturn) -> Answer:
        right = same_events(once.word, scene.word)
        return Answer(distance(once.phi_s, scene.image), right, evaluations_of(once))

    def judge_plain(result: Sequence[Any]) -> Answer:
        images, words = result
        right = same_events(words[0], scene.word)
        return Answer(distance(images[0], scene.image), right, None)

    kernel = partial(first_return_kernel, scene.toy, scene.phi_s)
    yield Entry(KERNEL, "", "", None, kernel, lambda once: judge(once)._replace(evaluations=None))
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(scene.toy), [scene.phi_s])
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], judge_plain, elsewhere(ask))
    for setting in settings:
        yield Entry(*setting[:4], partial(setting.peer, scene.toy, scene.phi_s), judge)


def siconos_entries(scene: Scene, plan: Plan) -> Iterator[Entry]:
    """The same by Siconos, if it is there. Its time is that of its time loop up to the return."""

    def judge(once: PeerReturn) -> Answer:
        right = same_events(once.word, scene.word)
        return Answer(distance(once.phi_s, scene.image), right, once.evaluations)

    def loop(step: float, _count: int) -> Job:
        def job() -> Seconds:
            run = simulate_siconos(scene.toy, scene.phi_s, float(scene.period), step, every=0)
            return Seconds(run.seconds, run.seconds)

        return job

    for step in () if available() else plan.siconos:
        work = partial(first_return_siconos, scene.toy, scene.phi_s, step)
        yield Entry("Siconos", "", "step", step, work, judge, partial(loop, step))


def map_entries(
    settings: Iterable[Setting], other: PlainPython, one_core: ThreadPoolExecutor, whole: bool
) -> Iterator[Entry]:
    """The map: the compiled kernel at all points, plain Python if ``whole``, others at a few."""
    toy, few, everywhere = CONTACT_BY_CONTACT, sample(), slice(None)
    part = POINTS / len(few)
    known = return_map(toy, few).words  # a test checks these words

    def judge(
        images: Iterable[float | Decimal], words: Iterable[str], evaluations: int | None
    ) -> Answer:
        errors = [distance(x, exact) for x, exact in zip(images, SAMPLE_IMAGES, strict=True)]
        right = all(map(same_events, words, known))
        return Answer(max(errors), right, evaluations, {"error_median": median(errors)})

    def judge_few(returns: Sequence[AnyReturn]) -> Answer:
        counts = [count for count in map(evaluations_of, returns) if count is not None]
        total = sum(counts) if len(counts) == len(returns) else None
        return judge([once.phi_s for once in returns], [once.word for once in returns], total)

    def judge_whole(map_: ReturnMap) -> Answer:
        return judge(map_.phi_s[SAMPLED].tolist(), map_.words[SAMPLED], None)

    chosen = SAMPLED if whole else everywhere
    begin = starts() if whole else few
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(toy), begin.tolist())

    def judge_plain(result: Sequence[Any]) -> Answer:
        return judge(result[0][chosen], result[1][chosen], None)

    compiled = partial(return_map, toy, starts(), executor=one_core)
    yield Entry(KERNEL, "", "", None, compiled, judge_whole)
    scale = 1.0 if whole else part
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], judge_plain, elsewhere(ask), scale)
    for setting in settings:
        few_returns = partial(_returns, setting.peer, toy, few.tolist())
        yield Entry(*setting[:4], few_returns, judge_few, scale=part)


def _returns(
    peer: Callable[[Toy, float], AnyReturn], toy: Toy, points: Sequence[float]
) -> list[AnyReturn]:
    return [peer(toy, x) for x in points]


def fixed_entries(settings: Iterable[Setting], other: PlainPython) -> Iterator[Entry]:
    """The stable cycle and its multiplier, from a guess 5e-4 rad away."""

    def judge(x: Any, multiplier: Any, evaluations: int | None = None) -> Answer:
        detail = {
            "error_phi_s": distance(x, FIXED_POINT.phi_s),
            "error_multiplier": distance(multiplier, FIXED_POINT.multiplier),
        }
        return Answer(max(detail.values()), None, evaluations, detail)

    toy = CONTACT_BY_CONTACT
    yield Entry(KERNEL, "", "", None, partial(shoot, toy, GUESS),
                lambda orbit: judge(orbit.phi_s, orbit.multiplier))  # fmt: skip
    ask = partial(other.ask, "studies.peers.kernel:fixed_point", numbers(toy), GUESS)
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], lambda r: judge(*r[:2]), elsewhere(ask))
    for setting in settings:
        if setting.method != TWIN:
            yield Entry(*setting[:4], partial(newton, setting), lambda r: judge(*r))
        elif setting.value == DIGITS:
            yield Entry(*setting[:4], recomputed_fixed_point, lambda r: judge(*r[:2]))


def newton(setting: Setting, steps: int = 12) -> tuple[float, float, int]:
    """Fixed point, multiplier and evaluations by Newton's method with difference quotients.

    A peer has no slope, so it is a central difference over the cube root of its noise times a
    tenth of a radian, over which the map bends. It is taken once for the steps and once at the end
    for the multiplier: fresh ones in between only cost.
    """
    spent = 0

    def image(x: float) -> float:
        nonlocal spent
        if not x < CONTACT_BY_CONTACT.phi_s_max:
            raise LostError(f"Newton's method leaves the map, to {x:.3g} rad")
        once = setting.peer(CONTACT_BY_CONTACT, x)
        spent += evaluations_of(once) or 0
        return float(once.phi_s)

    def slope(x: float) -> float:
        h: float = BEND * setting.noise ** (1.0 / 3.0)
        return (image(x + h) - image(x - h)) / (2.0 * h)

    x = GUESS
    steepness = slope(x)
    for _ in range(steps):
        step = (image(x) - x) / (1.0 - steepness)
        x += step
        if abs(step) <= setting.noise:
            break
    return x, slope(x), spent


def elsewhere(ask: Callable[..., tuple[Any, Seconds]]) -> Callable[[int], Job]:
    """Clock of work in another process, which reports its own time."""
    return lambda count: lambda: ask(count=count)[1]


# Measuring


def measured(entries: Iterable[Entry], rounds: int) -> list[dict[str, Any]]:
    """One row per entry: errors from a first run, times from rounds in which all take turns."""
    chosen, rows, jobs = list(entries), [], {}
    for index, entry in enumerate(chosen):
        row, run = first_run(entry)
        rows.append(row)
        if row["lost"] is None and run.cpu <= SLOW:
            clock = entry.clock or partial(clocked, entry.work)
            jobs[str(index)] = clock(repeats(run.cpu))
    for key, timing in race(jobs, rounds).items():
        rows[int(key)] |= _times(timing, chosen[int(key)].scale)
    return rows


def first_run(entry: Entry) -> tuple[dict[str, Any], Seconds]:
    """Row of an entry with its error and the time of one run; ``lost`` if it fails."""
    row: dict[str, Any] = {
        "method": entry.method,
        "variant": entry.variant,
        "knob": entry.knob,
        "value": entry.value,
        "scaled": entry.scale != 1.0,
        "lost": None,
    }
    try:
        result, run = timed(entry.work)
    except LostError as reason:
        empty = dict.fromkeys(("error", "word_right", "evaluations", "cpu", "wall", "rounds"))
        return {**row, **empty, "lost": str(reason)}, Seconds(0.0, 0.0)
    if entry.clock is not None:
        run = entry.clock(1)()
    answer = entry.judge(result)
    row |= {"error": answer.error, "word_right": answer.word_right}
    row |= {"evaluations": answer.evaluations, **(answer.detail or {})}
    return row | _times(summary([run]), entry.scale), run


def _times(timing: dict[str, float], scale: float) -> dict[str, float]:
    return {
        "cpu": scale * timing["cpu_median"],
        "wall": scale * timing["wall_median"],
        "rounds": timing["rounds"],
    }


def affordable(
    settings: Sequence[Setting], rows: Sequence[dict[str, Any]], patience: float
) -> tuple[list[Setting], list[str]]:
    """Settings quick enough for the map and the fixed point, and a sentence on each other one."""
    costs = {(r["method"], r["variant"], r["value"]): r["cpu"] for r in rows}
    quick, left_out = [], []
    for setting in settings:
        cost = costs[setting.method, setting.variant, setting.value]
        if cost is None or cost <= patience:
            quick.append(setting)
        else:
            words = name(setting._asdict())
            left_out.append(f"{words}: {cost:.2f} s per return, so neither map nor fixed point")
    return quick, left_out


# What comes of it


def name(row: dict[str, Any]) -> str:
    """Method, variant and knob of a row in words."""
    knob = f"{row['knob']} {row['value']:.0e}" if row["knob"] else ""
    return " ".join(filter(None, (row["method"], row["variant"], knob)))


def compared(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """For each target error the cheapest peer that reaches it, and its time over the kernel's.

    A point with a wrong word counts for the peer.
    """
    kernel = rows[0]
    lines = []
    for target in TARGETS:
        able = [r for r in rows if r["method"] not in OURS and reaches(r, target)]
        best = min(able, key=lambda r: r["cpu"], default=None)
        lines.append({
            "error_below": target,
            "kernel_reaches": reaches(kernel, target),
            "peer": name(best) if best else None,
            "peer_cpu": best["cpu"] if best else None,
            "kernel_cpu": kernel["cpu"],
            "ratio": best["cpu"] / kernel["cpu"] if best else None,
            "reason": None if best else "no peer reaches this error at any setting measured",
        })  # fmt: skip
    return lines


def reaches(row: dict[str, Any], target: float) -> bool:
    """Whether the error of a row is known and small enough."""
    return row["error"] is not None and row["error"] <= target


def ahead(rows: Sequence[dict[str, Any]]) -> bool:
    """Whether the compiled kernel reaches every target, and no peer below 1e-3 is as quick."""
    kernel, others = rows[0], [r for r in rows[1:] if r["method"] not in OURS]
    quicker = [r for r in others if reaches(r, max(TARGETS)) and r["cpu"] <= kernel["cpu"]]
    return reaches(kernel, min(TARGETS)) and not quicker


EXPECTED = {  # order of the error in the step, and why
    "RK45": (5.0, "the formula and its interpolant, with which events are located"),
    "DOP853": (8.0, "the formula and its interpolant, with which events are located"),
    "Radau": (4.0, "the formula has order 5, but its cubic interpolant locates the events"),
    "Moreau, theta": (1.0, "an impact waits for the end of its step"),
    "Moreau, midpoint": (1.0, "an impact waits for the end of its step"),
    "Siconos": (1.0, "an impact waits for the end of its step"),
}
FINEST = 3  # steps whose slope tells whether the error still falls
FITTED = (1e-12, 1e-2)  # rad; above, the motion is another one, below, it is rounding. A ladder
# that has no two errors in it is fitted as a whole


def orders(tasks: dict[str, list[dict[str, Any]]], plan: Plan) -> list[dict[str, Any]]:
    """Orders of convergence: the slope of log error over log step, expected and fitted.

    For Runge-Kutta methods, on the cycle, the error control is switched off (rtol = 1000) and
    max_step is the step; evaluations grow like its inverse. LSODA changes its order as it goes,
    so it has none to fit. Time stepping is fitted on every task. On the map it converges to another
    motion at one start, where the beak sticks during compression (``I1s``): its impact law is
    Newton's, and there Poisson's law says something else.
    """
    lines = []
    for solver in ("RK45", "DOP853", "Radau"):
        ladder = []
        for k in range(plan.halvings):
            step = 4e-3 / 2**k
            once = first_return_ode(CYCLE.toy, CYCLE.phi_s, solver, 1e3, 1e3, step)
            if same_events(once.word, CYCLE.word):
                ladder.append((step, distance(once.phi_s, CYCLE.image)))
        lines.append(_order(CYCLE.name, solver, "", ladder))
    for task, rows in tasks.items():
        ladders: dict[tuple[str, str], list[tuple[float, float]]] = {}
        for row in rows:
            if row["knob"] == "step" and row["error"] is not None and task != FIXED:
                key = row["method"], row["variant"]
                ladders.setdefault(key, []).append((row["value"], row["error"]))
        lines += [_order(task, *key, ladder) for key, ladder in ladders.items()]
    return lines


def _order(
    task: str, method: str, variant: str, ladder: Sequence[tuple[float, float]]
) -> dict[str, Any]:
    """One line: over which errors the slope was fitted, and whether there is convergence at all."""
    expected, why = EXPECTED[method]
    used = [(step, error) for step, error in ladder if FITTED[0] <= error <= FITTED[1]]
    used = used if len(used) >= 2 else list(ladder)
    fitted, finest = (_slope(used), _slope(used[-FINEST:])) if len(used) >= 2 else (None, None)
    return {
        "task": task,
        "method": method,
        "variant": variant,
        "expected": expected,
        "why": why,
        "fitted": fitted,
        "fitted_finest": finest,
        "reason": None if fitted is not None else "measured at one step only",
        "converges": None if finest is None else finest > 0.5 * expected,
        "steps": [used[0][0], used[-1][0]],
        "errors": [used[0][1], used[-1][1]],
        "points": len(used),
    }


def _slope(ladder: Sequence[tuple[float, float]]) -> float:
    log_steps, log_errors = np.log(np.array(ladder)).T
    return float(np.polyfit(log_steps, log_errors, 1)[0])


# The picture


def draw(tasks: dict[str, list[dict[str, Any]]]) -> Figure:
    """Error against CPU time: one panel for each task, all on the same axes."""
    figure = plt.figure(figsize=(WIDTH, 5.8), layout="constrained")
    axes = np.ravel(figure.subplots(2, 3, sharex=True, sharey=True)).tolist()
    titles = {scene.name: f"{scene.name}, one return" for scene in SCENES}
    for ax, letter, (task, rows) in zip(axes, "abcde", tasks.items(), strict=False):
        grid(ax)
        ax.set_title(f"({letter}) {titles.get(task, task)}", fontsize=8.5, loc="left")
        panel(ax, rows)
    first = axes[0]
    first.set(xscale="log", yscale="log", xlim=(3e-18, 3.0))
    first.xaxis.set_major_locator(LogLocator(numticks=20, subs=(1.0,), base=1e4))
    first.yaxis.set_major_locator(LogLocator(numticks=20))
    for ax in axes[:5]:
        ax.xaxis.set_minor_locator(NullLocator())
        ax.yaxis.set_minor_locator(NullLocator())
        ax.tick_params(labelsize=8)
    axes[2].tick_params(labelbottom=True)
    for ax in (axes[0], axes[3]):
        ax.set_ylabel("CPU time [s]", fontsize=9)
    for ax, unit in zip(axes[2:5], ("[rad]", "[rad]", "[rad], [-]"), strict=True):
        ax.set_xlabel(f"error {unit}", fontsize=9)
    legend(axes[5], {row["method"] for rows in tasks.values() for row in rows})
    return figure


def panel(ax: Axes, rows: Sequence[dict[str, Any]]) -> None:
    """Curves of one task, a line along the knob of each method and variant."""
    curves: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        if row["error"] is not None:
            curves.setdefault((row["method"], row["variant"]), []).append(row)
    kernel = curves[KERNEL, ""][0]
    ax.axhline(kernel["cpu"], color=METHODS[KERNEL][0], linewidth=0.6, linestyle=(0, (1, 2)))
    for (method, variant), points in curves.items():
        color, marker = METHODS[method]
        errors = [max(point["error"], FLOOR) for point in points]
        times = [point["cpu"] for point in points]
        dashes = {"pgs": (0, (4, 2))}.get(variant, "-")
        ax.plot(errors, times, color=color, linewidth=0.9, linestyle=dashes, zorder=2)
        for error, time, point in zip(errors, times, points, strict=True):
            hollow = point["word_right"] is False
            ax.plot(
                error, time, marker, color=color, zorder=5 if method == KERNEL else 3,
                markersize=6 if method == KERNEL else (3.0 if point["scaled"] else 4.0),
                markerfacecolor="white" if hollow else color, markeredgewidth=0.9,
            )  # fmt: skip


def legend(ax: Axes, present: set[str]) -> None:
    """Methods and marks, in the place of the sixth panel."""
    ax.axis("off")
    handles = [
        Line2D(
            [],
            [],
            color=color,
            marker=marker,
            linewidth=0.9,
            markersize=4.5,
            label=f"{method}, below {FLOOR:.0e}" if method == TWIN else method,
        )
        for method, (color, marker) in METHODS.items()
        if method in present
    ]
    handles += [
        Line2D([], [], color=GREY, linewidth=0.9, linestyle=(0, (4, 2)),
               label="dashed: Gauss-Seidel, not LCP"),
        Line2D([], [], color=GREY, marker="o", linewidth=0.0, markerfacecolor="white",
               markersize=4.5, label="hollow: wrong word"),
        Line2D([], [], color=GREY, marker="o", linewidth=0.0, markersize=3.0,
               label="small: 12 of 1000 points, scaled"),
    ]  # fmt: skip
    ax.legend(handles=handles, loc="center", fontsize=8, frameon=False)


if __name__ == "__main__":
    command(main, "work_precision")
