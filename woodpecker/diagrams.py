"""Bifurcation diagrams of the toy: every branch of some iterates in a window."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.diagram import load_diagram as load_diagram  # for the users of woodpecker, too
from woodpecker.base.checks import instance, interval
from woodpecker.base.executors import worker_count
from woodpecker.base.settings import Settings
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.runs import about, finished, possible, recorded, settings_for
from woodpecker.search.diagrams import Found, finite_window, iterates, whole_diagram
from woodpecker.search.explorer import Progress
from woodpecker.search.search import Search
from woodpecker.toy_map import ToyPieces


def bifurcation_diagram(
    toy: Toy,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    orders: Sequence[int] = (1,),
    window: tuple[float, float] = WINDOW,
    *,
    settings: Settings | None = None,
    search: Search | None = None,
    progress: Progress | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
) -> Diagram:
    """Every branch of some iterates in a window, and how they hang together.

    Slices of the parameter are taken until they show nothing that no branch explains; see
    :mod:`woodpecker.search.search`. An iterate P_j counts orbits all of whose returns lie in the
    window.

    Parameters
    ----------
    toy
        The toy; its own value of ``parameter`` does not matter.
    parameter, span
        Parameter of the toy and its interval. Where the toy cannot have all of these values,
        branches end at the last that it can have.
    orders
        The iterates j.
    window
        Interval of phi_S [rad].
    settings
        Steps and tolerances; span and window are taken from the arguments.
    search
        How many slices.
    progress
        Called with every branch that is finished, and before every slice.
    run
        A file that keeps every finished branch, so that an interrupted run can go on.
    resume
        Go on with the run in that file.
    workers
        How many processes do the work, this one among them, by default one for each core; see
        :func:`woodpecker.base.executors.scheduler`. The result does not depend on it.
    executor
        Any executor of :mod:`concurrent.futures` (threads, processes, dask, MPI) that helps
        instead; it is not shut down, and has as many tasks at once as ``workers`` says.

    Returns
    -------
    Diagram
        Fixed points of P_j are listed with their minimal period only; ``given`` says
        under which law of impact, and how derivatives in the parameter were found.

    Raises
    ------
    ValueError
        If an order is not at least 1, the span or window does not ascend or is not finite, or there
        is no such run to resume.
    TypeError
        If the parameter is unknown, or the settings are no :class:`Settings`.

    Examples
    --------
    >>> from woodpecker import Toy, Search, bifurcation_diagram
    >>> few = Search(slices=4)
    >>> top = bifurcation_diagram(Toy(), "eps_n1", (0.33, 0.4), (1,), (-1, -0.8), search=few)
    >>> sorted((round(p.parameter, 9), str(p.kind)) for p in top.points if p.kind.name != "EP")
    [(0.341923454, 'BC'), (0.388349589, 'FF')]
    """
    return find_all(
        toy, parameter, span, orders, window, settings=settings, search=search, progress=progress,
        run=run, resume=resume, workers=workers, executor=executor,
    ).diagram  # fmt: skip


def find_all(
    toy: Toy,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    orders: Sequence[int] = (1,),
    window: tuple[float, float] = WINDOW,
    *,
    settings: Settings | None = None,
    search: Search | None = None,
    progress: Progress | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
) -> Found:
    """Like :func:`bifurcation_diagram`, with what the slices came to.

    Parameters
    ----------
    toy, parameter, span, orders, window
        What is searched, as for :func:`bifurcation_diagram`.
    settings, search, progress, run, resume, workers, executor
        How, as there.

    Returns
    -------
    Found
        The diagram, its slices, and how often P_1 was evaluated.

    Raises
    ------
    ValueError, TypeError
        As there.

    Examples
    --------
    >>> from woodpecker import Toy, Search, find_all
    >>> few = Search(slices=4)
    >>> found = find_all(Toy(), "eps_n1", (0.33, 0.4), (1,), (-1, -0.8), search=few)
    >>> len(found.diagram.branches), len(found.slices) >= 4
    (3, True)
    """
    map_ = ToyPieces(toy, parameter)
    instance("toy", toy, Toy)
    wanted, looked = interval("span", span, finite=True), Search() if search is None else search
    instance("search", looked, Search)
    chosen = settings_for(settings, span=possible(toy, parameter, wanted), window=window)
    finite_window(chosen)
    worker_count(workers)
    run_of = about(toy, parameter, chosen, wanted) | {
        "orders": iterates(orders), "search": asdict(looked)
    }  # fmt: skip
    map_.at(*map(_middle, (chosen.window, chosen.span)))  # compiled before there are processes
    with recorded(run, run_of, resume) as record:
        found = whole_diagram(
            map_, chosen, orders, looked, parameter_name=parameter, x_name="phi_s",
            progress=progress, workers=workers, executor=executor, record=record,
        )  # fmt: skip
    return replace(found, diagram=finished(found.diagram, toy, wanted, chosen))


def _middle(interval: tuple[float, float]) -> float:
    return 0.5 * (interval[0] + interval[1])
