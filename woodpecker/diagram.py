"""Bifurcation diagrams of the toy: what hangs together with one solution, or everything."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from pwmap.diagrams.diagram import BranchKind, Diagram
from woodpecker.base.checkpoint import Entry, version_of
from woodpecker.base.checks import whole
from woodpecker.base.executors import Serial, scheduler, worker_count
from woodpecker.continued import WINDOW, continuation, given, saved_continuation
from woodpecker.engine.checkpoint import VERSION
from woodpecker.mechanics.toy import LAW, Toy, parameters
from woodpecker.piecewise.checkpoint import Journal, read_journal
from woodpecker.piecewise.explore import Explorer, Progress, Start, restore
from woodpecker.piecewise.maps import Cycle, LabelledMap, windowed
from woodpecker.piecewise.network import Atlas
from woodpecker.piecewise.partition import SampledMap
from woodpecker.piecewise.search import Report, Search, complete
from woodpecker.piecewise.settings import Settings
from woodpecker.piecewise.tasks import Worker
from woodpecker.toymaps import toy_map, toy_samples

__all__ = [
    "WINDOW",
    "Found",
    "bifurcation_diagram",
    "connected",
    "continuation",
    "find_all",
    "saved_diagram",
    "whole_diagram",
]

MARGIN = 0.05  # rad; a map is followed a little beyond its window, to find where a branch leaves it


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What a search for everything came to.

    Attributes
    ----------
    diagram
        All branches and special points.
    reports
        What the slices of each order showed.
    evaluations
        How often P_1 was evaluated in this run: by slices, and in following branches.
    """

    diagram: Diagram
    reports: tuple[Report, ...]
    evaluations: int


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
    :mod:`woodpecker.piecewise.search`. An iterate P_j counts orbits all of whose returns lie in
    the window.

    Parameters
    ----------
    toy
        The toy; its own value of ``parameter`` does not matter.
    parameter, span
        Parameter of the toy and its interval.
    orders
        The iterates j.
    window
        Interval of phi_S [rad].
    settings
        Steps and tolerances; span and window are taken from the arguments.
    search
        How many slices, and how closely they look.
    progress
        Called now and then.
    run
        A file that keeps every finished branch, so that an interrupted run can go on.
    resume
        Go on with the run in that file.
    workers
        How many processes do the work, by default one for each core; see
        :func:`woodpecker.base.executors.scheduler`. The result does not depend on it.
    executor
        Any executor of :mod:`concurrent.futures` (threads, processes, dask, MPI) to do the work
        instead; it is not shut down.

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
    """Like :func:`bifurcation_diagram`, with a report of the search."""
    labelled_map, samples = toy_map(toy, parameter), toy_samples(toy, parameter)
    chosen = replace(settings if settings is not None else Settings(), span=span, window=window)
    _searchable(chosen)
    worker_count(workers)
    looked = search if search is not None else Search()
    wanted = _wanted(orders)
    about = _about(toy, parameter, chosen) | {"orders": wanted, "search": asdict(looked)}
    labelled_map(*map(_middle, (chosen.window, chosen.span)))  # compiled before there are processes
    with _journal(run, about, resume) as journal:
        found = whole_diagram(
            labelled_map, samples, chosen, wanted, looked, parameter_name=parameter,
            x_name="phi_s", progress=progress, workers=workers, executor=executor, journal=journal,
        )  # fmt: skip
    diagram = replace(found.diagram, given=given(toy, parameter))
    return replace(found, diagram=diagram)


def _middle(interval: tuple[float, float]) -> float:
    return 0.5 * (interval[0] + interval[1])


def _about(toy: Toy, parameter: str, settings: Settings) -> Entry:
    """What two runs must have in common, so that one can go on with the other's journal."""
    fixed = {name: value for name, value in asdict(toy).items() if name != parameter}
    return {"toy": _finite(fixed), "parameter": parameter, "settings": asdict(settings)}


def _finite(values: Entry) -> Entry:
    return {name: str(value) if value == math.inf else value for name, value in values.items()}


@contextmanager
def _journal(
    run: str | os.PathLike[str] | None, about: Entry, resume: bool
) -> Iterator[Journal | None]:
    """A journal for the time of a run, or none."""
    if run is None:
        if resume:
            raise ValueError("resuming needs the file of a run")
        yield None
        return
    journal = Journal(run, about, resume=resume)
    try:
        yield journal
    finally:
        journal.close()


def saved_diagram(run: str | os.PathLike[str]) -> Diagram:
    """The branches that a run of the toy has finished so far.

    Raises
    ------
    ValueError
        If the file is not that of a run.
    """
    if version_of(run) == VERSION:
        return saved_continuation(run)
    about, entries = read_journal(run)
    toy, parameter = about.get("toy"), about.get("parameter")
    if not isinstance(toy, dict) or LAW not in toy or parameter not in parameters():
        raise ValueError(f"{run}, line 1: expected a run of the toy, got one of {sorted(about)}")
    atlas = Atlas()
    restore(atlas, entries, Path(run))
    found = atlas.diagram(parameter, "phi_s")
    return replace(found, given=given(Toy(expansion_friction=toy[LAW]), parameter))


def _followable(start: Cycle, settings: Settings) -> None:
    """Complain of a cycle whose branch would end where it begins."""
    if not start.steepness <= settings.steepest:
        raise ValueError(
            f"the slopes of the cycle must multiply to {settings.steepest:g} at most (steepest), "
            f"got {start.steepness:g}"
        )


def _searchable(settings: Settings) -> None:
    """Complain of a window that slices cannot cover."""
    if not all(map(math.isfinite, settings.window)):
        raise ValueError(f"a search for every branch needs a finite window, got {settings.window}")


def _wanted(orders: Sequence[int]) -> list[int]:
    """Orders of iterates, ascending, each once."""
    wanted = sorted({whole("orders", order) for order in orders})
    if not wanted:
        raise ValueError(f"orders must name at least one iterate, got {tuple(orders)}")
    return wanted


def whole_diagram(
    labelled_map: LabelledMap,
    samples: SampledMap,
    settings: Settings,
    orders: Sequence[int] = (1,),
    search: Search | None = None,
    *,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Progress | None = None,
    workers: int | None = 1,
    executor: Executor | None = None,
    journal: Journal | None = None,
) -> Found:
    """Every branch of some iterates of a labelled map; see :func:`bifurcation_diagram`.

    Maps that are to be sent to other processes must pickle: a function at the top level of a
    module does, a lambda does not.
    """
    wanted = _wanted(orders)
    _searchable(settings)
    low, high = settings.window
    inside = windowed(labelled_map, (low - MARGIN, high + MARGIN))
    looked = search if search is not None else Search()
    worker = Worker(
        labelled_map=inside, settings=settings, orders=tuple(wanted), samples=samples,
        resolution=looked.resolution,
    )  # fmt: skip
    with scheduler(worker, workers, executor) as tasks:
        explorer = Explorer(tasks, progress, journal)
        reports = complete(explorer, tasks, settings, wanted, looked)
    return Found(
        diagram=explorer.atlas.diagram(parameter_name, x_name),
        reports=tuple(reports),
        evaluations=explorer.evaluations + sum(report.evaluations for report in reports),
    )


def connected(
    labelled_map: LabelledMap,
    start: Cycle,
    settings: Settings,
    *,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Progress | None = None,
    journal: Journal | None = None,
) -> Diagram:
    """All branches of a labelled map that are connected with the cycle ``start``.

    Raises
    ------
    ValueError
        If the cycle is steeper than ``settings.steepest``.
    """
    _followable(start, settings)
    worker = Worker(labelled_map=labelled_map, settings=settings)
    explorer = Explorer(Serial(worker), progress, journal)
    if explorer.atlas.branches:
        explorer.go_on()
    else:
        explorer.explore([Start(BranchKind.FIXED_POINT, len(start.x), start)])
    return explorer.atlas.diagram(parameter_name, x_name)
