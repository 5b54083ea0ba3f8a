"""Which mechanisms of the continuation engine matter: each is switched off, on the same jobs.

    python -m studies.mechanisms [--fast] [--out DIR]

A mechanism without which all diagrams stay the same and no test fails is superfluous. Diagrams are
compared as graphs, by kinds, orders and parameters of special points; their cost is counted in
calls of the kernel. The jobs use public names only, so ``measured(table, jobs(...))`` also measures
another table of mechanisms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import networkx as nx

from pwmap import Diagram, PointStatus
from studies.common.engine_mechanisms import MECHANISMS
from studies.common.laws import SUMMED, TOYS
from studies.common.motion import GUESS
from studies.common.places import WINDOW
from studies.common.random_toys import beside, random_toy
from studies.common.record import Results, command
from studies.common.switched_off import Mechanism, counted, switched_off
from studies.common.tables import rows
from woodpecker import Search, Toy, bifurcation_diagram, continuation, shoot

Job = Callable[[], Diagram]
SAME = 1e-9  # of the span: parameters of special points are located to better than this
NEAR = 1e-5  # rad: phi_S at a flip is known to the root of rounding, some 1e-7 times a slope
COSTLY = 5.0  # times the calls that the whole program makes: a job is given up
# Of nine parameters and six random toys, those whose diagrams change without some mechanism.
TELLING, TELLING_TOYS = ("r_m", "l_g", "l_s"), (4, 7)
SLICES = 5  # of each: what branches do is looked at, not what slices find
FEW = ("c_phi",)  # what the fast version varies, and its random toys
FEW_TOYS = (5,)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Switch each mechanism off.

    Parameters
    ----------
    fast
        Three mechanisms and three jobs.
    out
        Not used: there is no picture.

    Returns
    -------
    dict
        See :func:`measured`.
    """
    if fast:
        short = {"main job, summed": main_job(TOYS[SUMMED], (0.1, 0.5)), **jobs(FEW, FEW_TOYS, 3)}
        return measured(MECHANISMS[:3], short)
    return measured(MECHANISMS, main_jobs() | jobs(TELLING, TELLING_TOYS, SLICES))


def measured(table: Sequence[Mechanism], work: Mapping[str, Job]) -> Results:
    """All jobs without each of some mechanisms.

    Returns
    -------
    dict
        ``jobs``: of each its branches, points, open ends, and calls of the kernel; ``without``: of
        each mechanism its ``purpose``, and of each job ``verdict`` ("same", "differs", "fails"),
        ``calls`` as a ratio, None if it failed, and what ``became`` of it.
    """
    whole = {name: _run(job, math.inf) for name, job in work.items()}
    without = {}
    for mechanism in table:
        row = {}
        for name, job in work.items():
            with switched_off(mechanism):
                row[name] = _judged(job, *whole[name])
        without[f"{mechanism.module}.{mechanism.name}"] = {"purpose": mechanism.purpose, **row}
    return {
        "jobs": {name: [*_size(diagram), count] for name, (diagram, count) in whole.items()},
        "without": without,
    }


# --- Jobs -----------------------------------------------------------------------------------------


def main_jobs() -> dict[str, Job]:
    """What is connected with the stable motion over the beak's restitution, under both laws."""
    return {f"main job, {law}": main_job(toy, (0.0, 1.0)) for law, toy in TOYS.items()}


def main_job(toy: Toy, span: tuple[float, float]) -> Job:
    """The same for a toy and a span."""
    return lambda: continuation(toy, shoot(toy, GUESS), "eps_n1", span)


def jobs(varied: Sequence[str], toys: Iterable[int], slices: int = 63) -> dict[str, Job]:
    """P_1 over some parameters of the paper's toy, each beside its value, and for random toys."""
    search = Search(slices=slices)
    work: dict[str, Job] = {
        name: partial(
            bifurcation_diagram, Toy(), name, beside(Toy(), name), (1,), WINDOW, search=search,
            workers=1,
        )
        for name in varied
    }  # fmt: skip
    for number in toys:
        toy, parameter, span, window, _ = random_toy(number)
        work[f"toy {number}, {parameter}"] = partial(
            bifurcation_diagram, toy, parameter, span, (1,), window, search=search, workers=1
        )
    return work


# --- Comparing ------------------------------------------------------------------------------------


def _run(job: Job, most: float) -> tuple[Diagram, int]:
    with counted(most) as calls:
        diagram = job()
    return diagram, calls.count


def _judged(job: Job, whole: Diagram, calls: int) -> Results:
    """What becomes of a job, as compared with what the whole program gives."""
    try:
        diagram, count = _run(job, COSTLY * calls)
    except Exception as error:  # whatever a program raises from which something was taken
        reason = f"{type(error).__name__}: {error}"
        return {"verdict": "fails", "calls": None, "became": reason}
    same = are_same(whole, diagram)
    return {
        "verdict": "same" if same else "differs",
        "calls": count / calls,
        "became": "" if same else _difference(whole, diagram),
    }


def are_same(one: Diagram, other: Diagram) -> bool:
    """Whether two diagrams over the same span have the same branches and special points."""
    if _size(one) != _size(other):
        return False
    ends = [p for branch in one.branches for p in branch.parameter[[0, -1]].tolist()]
    within = SAME * (max(ends) - min(ends)) if ends else 0.0

    def alike(a: dict[str, Any], b: dict[str, Any]) -> bool:
        return (
            (a["kind"], a["order"], a["status"]) == (b["kind"], b["order"], b["status"])
            and abs(a["parameter"] - b["parameter"]) <= within
            and abs(a["x"] - b["x"]) <= NEAR
        )

    edges = nx.algorithms.isomorphism.categorical_multiedge_match(["kind", "order"], ["", 0.0])
    return bool(nx.is_isomorphic(one.graph(), other.graph(), alike, edges))


def _size(diagram: Diagram) -> tuple[int, int, int]:
    """How many branches, special points, and open ends."""
    is_open = [point.status is PointStatus.OPEN for point in diagram.points]
    return len(diagram.branches), len(diagram.points), sum(is_open)


def _difference(whole: Diagram, diagram: Diagram) -> str:
    names = ("branches", "points", "open")
    pairs = zip(names, _size(whole), _size(diagram), strict=True)
    return ", ".join(f"{name} {a} -> {b}" for name, a, b in pairs)


# --- Showing --------------------------------------------------------------------------------------


def mechanisms(results: Mapping[str, Results]) -> str:
    """In which jobs diagrams change without each mechanism, as a table for a page."""
    found, lines, idle = results["mechanisms"], list[list[str]](), list[str]()
    for name, row in found["without"].items():
        judged = {job: row[job] for job in found["jobs"]}
        changes = [job for job, each in judged.items() if each["verdict"] != "same"]
        if not changes:
            idle.append(f"`{name}`")
            continue
        calls = [each["calls"] for each in judged.values() if each["calls"] is not None]
        mean = f"{sum(calls) / len(calls):.2f}" if calls else "–"
        lines.append([f"`{name}`", row["purpose"], "; ".join(changes), mean])
    table = rows(["without", "which is to", "differs or fails", "calls"], lines)
    jobs, others = "; ".join(found["jobs"]), ", ".join(idle)
    return f"{table}\n\nThe jobs: {jobs}. In none of them anything changes without {others}."


if __name__ == "__main__":
    command(main, "mechanisms")
