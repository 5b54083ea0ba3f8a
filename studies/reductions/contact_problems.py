"""(b) Small contact problems: index combinations against Lemke's path, at impacts of the map."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from studies.common.clocks import Job, clocked, over, race, shared
from studies.common.record import Results
from studies.peers.kernel import PlainPython, Work
from studies.reductions.motions import Impacts
from studies.reductions.plan import Plan
from woodpecker import Toy
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.compiled import jit
from woodpecker.mechanics.contact_problems import PAIR_ROOM, one_contact, two_contacts
from woodpecker.mechanics.lcp import solve_contact_lcp
from woodpecker.mechanics.modes import fill_pair, model


def contacts(impacts: Impacts, other: PlainPython, plan: Plan) -> Results:
    """Both solvers at the same impacts, in Python; the direct one compiled as well."""
    lists = [column.tolist() for column in impacts]
    ask = partial(other.ask, "studies.reductions.contact_problems:direct_work", *lists)
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
