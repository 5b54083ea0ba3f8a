"""The diagrams of a map of the line: all branches in a window, or those connected with a cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import counted
from woodpecker.base.checks import instance, iterates
from woodpecker.base.executors import scheduler
from woodpecker.base.progress import Report
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap, map_of_pieces
from woodpecker.search.checkpoint import Record, Seen
from woodpecker.search.connected import cycle_near as near_in_space
from woodpecker.search.explorer import Explorer
from woodpecker.search.search import Search, complete
from woodpecker.search.tasks import Tasks, base_of
from woodpecker.slices.orbits import Orbit, minimal_period, of_engine, to_engine


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """The result of a search for all branches of a window.

    Attributes
    ----------
    diagram
        All branches and special points.
    slices
        The slices, in the order in which they were taken.
    evaluations
        How often the map was evaluated in this run; a map that does not count the evaluations of
        its pieces counts only its own.
    left
        A sentence on what was left when the allowed evaluations were spent, as in
        ``diagram.about["left"]``; else empty.

    Examples
    --------
    >>> from woodpecker import Search
    >>> from woodpecker.diagrams import bifurcation_search
    >>> from woodpecker.examples import two_lines
    >>> few = Search(slices=4)
    >>> found = bifurcation_search(two_lines(), "p", (-1, 2), window=(-3, 3), search=few)
    >>> len(found.diagram.branches), len(found.slices) >= 4
    (3, True)
    """

    diagram: Diagram
    slices: tuple[Seen, ...]
    evaluations: int
    left: str = ""

    def __repr__(self) -> str:
        left = f",\n  {self.left}" if self.left else ""
        return (
            f"Found({self.diagram!r},\n  {counted(len(self.slices), 'slice')}, "
            f"{counted(self.evaluations, 'evaluation')}{left})"
        )


def cycle_near(map_: PiecewiseMap, x: npt.ArrayLike, p: float, settings: Settings) -> Orbit:
    """The cycle of a map of the line near a guess of its points.

    ValueError if there is none, or a virtual one; TypeError if the map has no pieces.
    """
    instance("settings", settings, Settings)
    points = np.atleast_1d(np.asarray(x, dtype=float))[:, None]
    base = base_of(map_of_pieces(map_), settings)
    return of_engine(near_in_space(base, points, np.array([p], dtype=float)))


def connected(
    map_: PiecewiseMap, x: npt.ArrayLike, p: float, settings: Settings, *,
    orders: Sequence[int] | None = None, parameter_name: str = "p", x_name: str = "x",
    progress: Report | None = None,
) -> Diagram:  # fmt: skip
    """All branches of a map that are connected with a cycle, see :func:`woodpecker.continuation`.

    ValueError if there is no cycle near the guess, its period is none of the orders, or it lies
    outside of the span or the window; TypeError if the map has no pieces.
    """
    found, tasks = cycle_near(map_, x, p, settings), Tasks.of_line(map_, settings)
    n = minimal_period(found, settings)
    cycle = Orbit(found.x[:n], found.p, found.images[:n])
    start = to_engine(cycle)
    tasks.base.settings.check_holds(start.p, start.x)
    explorer = Explorer(tasks, orders_with(cycle, orders), progress)
    explorer.follow(start)
    return explorer.diagram(parameter_name, x_name)


def orders_with(cycle: Orbit, orders: Sequence[int] | None) -> tuple[int, ...]:
    """The orders to follow from a cycle; ValueError if one is below 1 or its own is missing."""
    wanted = (len(cycle),) if orders is None else iterates(orders)
    if len(cycle) not in wanted:
        raise ValueError(f"orders must hold {len(cycle)}, the period of the cycle, got {wanted}")
    return wanted


def whole_diagram(
    map_: PiecewiseMap,
    settings: Settings,
    orders: Sequence[int] = (1,),
    search: Search | None = None,
    *,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Report | None = None,
    workers: int | None = 1,
    executor: Executor | None = None,
    record: Record | None = None,
) -> Found:
    """All branches of some iterates, see :func:`woodpecker.diagrams.bifurcation_search`.

    A record receives what is finished, and what it holds already is taken over. ValueError if an
    order is below 1 or the window not finite; TypeError if the map has no pieces.
    """
    map_of_pieces(map_)
    instance("settings", settings, Settings)
    wanted = iterates(orders)
    finite_window(settings)
    tasks = Tasks.of_line(map_, settings, whole=True)
    with scheduler(tasks, workers, executor, tasks.line) as carried_out:
        explorer = Explorer(tasks, wanted, progress, record, scheduler=carried_out)
        complete(explorer, search or Search())
    return Found(
        diagram=explorer.diagram(parameter_name, x_name),
        slices=tuple(explorer.seen),
        evaluations=explorer.evaluations,
        left=explorer.left,
    )


def finite_window(settings: Settings) -> None:
    """ValueError if the window is infinite, so that slices cannot cover it."""
    instance("settings", settings, Settings)
    if not all(map(math.isfinite, settings.window)):
        raise ValueError(f"a search for every branch needs a finite window, got {settings.window}")
