"""Whether diagrams are complete and free of duplicates: each compared with plain tabulation.

    python -m studies.completeness [--fast] [--out DIR]

The paper's toy in the whole window, with P_1 and P_2, and random toys with P_1. At some parameters
the diagram must have all that a table shows, and the table must confirm all that the diagram has;
:mod:`studies.common.tabulated` says what a table cannot show.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pwmap import Diagram, PointStatus
from studies.common.clocks import timed
from studies.common.motion import GUESS
from studies.common.places import SPAN, WINDOW
from studies.common.random_toys import Drawn, random_toy
from studies.common.record import Results, command
from studies.common.tabulated import compared
from woodpecker import Search, Toy, first_return
from woodpecker.base.executors import processes, worker_count
from woodpecker.diagrams import bifurcation_search

SEED = 12  # of the parameters at which tables are made
SUMS = ("cycles", "jumps", "lost", "drawn_cycles", "drawn_jumps", "closer")
LISTS = ("missing", "double", "unconfirmed")


class Size(NamedTuple):
    """How much is looked at."""

    search: Search
    span: tuple[float, float]  # of eps_N1, for the toy of the paper
    parameters: int  # of the paper's toy, and points of each of their tables
    points: int
    toys: int  # random ones, the same of them
    parameters_of_toys: int
    points_of_toys: int


FULL = Size(Search(), SPAN, 12, 400_001, 100, 3, 40_001)
FAST = Size(Search(slices=7), (0.105, 0.13), 2, 20_001, 3, 1, 4_001)


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Tabulate, and compare.

    Parameters
    ----------
    fast
        A part of the first diagram, three random toys, few points.
    out
        Not used: there is no picture.

    Returns
    -------
    dict
        ``paper``: see :func:`of_paper`; ``toys``: for each see :func:`of_toy`; ``total``: see
        :func:`total`.
    """
    size = FAST if fast else FULL
    first_return(Toy(), GUESS)  # compiled before clocks run
    with processes(worker_count(None)) as pool:  # one diagram each, the longest first
        of_each = pool.map if pool is not None else map
        paper, *toys = of_each(partial(_part, size=size), [None, *range(size.toys)])
    return {"paper": paper, "toys": toys, "total": total(toys)}


def _part(number: int | None, size: Size) -> Results:
    """The paper's toy for None, else a random one."""
    return of_paper(size) if number is None else of_toy(number, size)


def total(toys: Sequence[Results]) -> Results:
    """Sums over some toys; ``unfinished``: how many searches took all that they may take."""
    return {
        **{name: sum(each[name] for each in toys) for name in ("refused", *SUMS)},
        **{name: sum(len(each[name]) for each in toys) for name in (*LISTS, "open")},
        "unfinished": sum(bool(each["left"]) for each in toys),
    }


def of_paper(size: Size) -> Results:
    """P_1 and P_2 of the paper's toy over eps_N1.

    Returns
    -------
    dict
        ``span``, ``points`` of a table; sums, lists, seconds and open ends as :func:`of_toy` has
        them; ``tables``: see :func:`studies.common.tabulated.compared`.
    """
    drawn = Drawn(Toy(), "eps_n1", size.span, WINDOW, 0)
    places = scattered(np.random.default_rng(SEED), size.span, size.parameters)
    found = _examined(drawn, (1, 2), size.search, places, size.points)
    return {"span": size.span, "points": size.points, **found}


def of_toy(number: int, size: Size) -> Results:
    """P_1 of a random toy over one of its parameters.

    Returns
    -------
    dict
        ``toy``, ``parameter``, ``span``, ``window``; ``refused``: how many toys were drawn before;
        ``places``: how many tables; ``seconds`` for its diagram; how much the tables show, and
        lists of what differs; ``open``: of branches that were given up the order, place, note and
        cause; ``left``: what the search left.
    """
    drawn = random_toy(number)
    places = scattered(np.random.default_rng([SEED, number]), drawn.span, size.parameters_of_toys)
    found = _examined(drawn, (1,), size.search, places, size.points_of_toys)
    del found["tables"]  # what they differ in is in the lists
    return {
        "toy": repr(drawn.toy), "parameter": drawn.parameter, "span": drawn.span,
        "window": drawn.window, "refused": drawn.refused, "places": len(places), **found,
    }  # fmt: skip


def scattered(rng: np.random.Generator, span: tuple[float, float], count: int) -> list[float]:
    """One random value in each of some equal parts of a span: none at which a slice was taken."""
    parts = (np.arange(count) + rng.random(count)) / count
    values: list[float] = (span[0] + parts * (span[1] - span[0])).tolist()
    return values


def _examined(
    drawn: Drawn, orders: tuple[int, ...], search: Search, places: Sequence[float], points: int
) -> Results:
    """A diagram, what tables say of it, and its open ends."""
    toy, parameter, span, window, _ = drawn
    found, clock = timed(
        lambda: bifurcation_search(toy, parameter, span, orders, window, search=search, workers=1)
    )
    tables = [
        compared(toy, found.diagram, p, order, window, points) for p in places for order in orders
    ]
    return {
        "seconds": clock.cpu,
        "evaluations": found.evaluations,
        "branches": len(found.diagram.branches),
        **{name: sum(each[name] for each in tables) for name in SUMS},
        **{
            name: [[each["parameter"], *item] for each in tables for item in each[name]]
            for name in LISTS
        },
        "open": given_up(found.diagram),
        "left": found.left,
        "tables": tables,
    }


def given_up(diagram: Diagram) -> list[list[object]]:
    """Order, parameter, phi_S [rad], note and cause of each open end."""
    return [
        [point.order, point.parameter, point.x, point.note, point.cause]
        for point in diagram.points
        if point.status is PointStatus.OPEN
    ]


if __name__ == "__main__":
    command(main, "completeness")
