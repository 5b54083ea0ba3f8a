"""Diagrams of the toy or any map: branches connected with an orbit, or all in a window."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, cast, overload

import numpy as np

from pwmap.algebra.arguments import check_functions, explained
from pwmap.diagrams.diagram import Diagram, PointKind, SpecialPoint
from pwmap.diagrams.diagram import load_diagram as load_diagram  # for the users of woodpecker, too
from woodpecker.base.checkpoint import START
from woodpecker.base.checks import instance, iterates
from woodpecker.base.executors import worker_count
from woodpecker.base.progress import Report
from woodpecker.base.settings import Settings
from woodpecker.base.shown import shown
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.mechanics.toy import WINDOW, Toy
from woodpecker.plane.curve import Curve, PlanePoint
from woodpecker.plane.families import Spans
from woodpecker.runs import AT, Subject, recorded, subject
from woodpecker.search.diagrams import (
    Found,
    cycle_near,
    finite_window,
    orders_with,
    whole_diagram,
)
from woodpecker.search.explorer import ON_EDGE, Explorer
from woodpecker.search.search import Search
from woodpecker.search.tasks import StopRule, Tasks
from woodpecker.shooting import PeriodicOrbit
from woodpecker.slices.orbits import Orbit, to_engine
from woodpecker.two_parameters import curve_in_two

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap

FOLLOWED = "a parameter is named and span is its interval; steps and tolerances are settings"
WORKERS = 1  # default for maps: evaluations of formulas are too cheap for more processes


# --- Branches connected with an orbit -------------------------------------------------------------


@overload
def continuation(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    orbit: PeriodicOrbit,
    parameter: str | None = None,
    span: tuple[float, float] | None = None,
    *,
    orders: Sequence[int] | None = None,
    settings: Settings | None = None,
    stop: StopRule | None = None,
    progress: Report | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> Diagram: ...


@overload
def continuation(
    source: Toy,
    orbit: SpecialPoint | PlanePoint,
    parameter: tuple[str, str],
    span: Spans,
    *,
    kind: PointKind | str | None = None,
    settings: Settings | None = None,
) -> Curve: ...


@explained(FOLLOWED)
def continuation(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    orbit: PeriodicOrbit | SpecialPoint | PlanePoint,
    parameter: str | tuple[str, str] | None = None,
    span: tuple[float, float] | Spans | None = None,
    *,
    kind: PointKind | str | None = None,
    orders: Sequence[int] | None = None,
    settings: Settings | None = None,
    stop: StopRule | None = None,
    progress: Report | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> Diagram | Curve:
    """Follow a periodic solution both ways over a parameter, and all branches connected with it.

    A special point of the toy and two parameters are passed on to :func:`woodpecker.curve_in_two`.

    Parameters
    ----------
    source
        The toy, or any piecewise-smooth map of the line with one parameter.
    orbit
        A periodic solution of it, from :func:`woodpecker.shoot`, followed with its minimal period.
    parameter
        The parameter of the toy that varies, by default eps_n1; of a map the name of its parameter,
        by default p.
    span
        Its interval, by default (0, 1) for a toy, that of the settings for a map. Branches of the
        toy end at the last value that it can have.
    kind
        Only for a point of codimension two, see :func:`woodpecker.curve_in_two`.
    orders
        The iterates whose branches are followed, by default only the minimal period of the orbit,
        which must be among them. The doubled branch at a flip of P_n needs 2 n. At border
        collisions branches of all of them start: jumps at jumps, cycles at kinks and grazings.
    settings
        Steps, window and tolerances. By default the window of a toy is (-2.5, -0.24) rad, and that
        of a map is infinite.
    stop
        A rule that ends branches, such as ``lambda state: abs(state.multiplier) > 5``, called at
        every sample with a :class:`woodpecker.search.BranchState`. The branch ends (EP, "stopped as
        asked") where it becomes true, located to rounding.
    progress
        Called before the first branch, and with each finished one.
    run, resume
        A file that stores every finished branch, but not ``stop``; whether to resume the
        interrupted run in it.

    Returns
    -------
    Diagram
        Fixed-point and jump branches of these iterates with their special points. For a toy
        ``given`` states the law of impact and the source of derivatives in the parameter.

    Raises
    ------
    ValueError
        If the orbit did not converge or belongs to another toy or map, if span, window or orders do
        not hold it, or if there is no run to resume.
    TypeError
        If a parameter is unknown, the settings are not :class:`Settings`, or arguments for one and
        for two parameters are mixed.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, shoot
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), "eps_n1", span=(0.45, 0.7))
    >>> for point in diagram.points:
    ...     print(point.kind, f"{point.parameter:.9f} {point.x:.9f}", point.cause or point.note)
    EP 0.450000000 -0.537769080 end of the parameter span
    PD 0.648549200 -0.518581245 the multiplier is -1
    EP 0.700000000 -0.515717105 end of the parameter span
    >>> from woodpecker.examples import two_lines  # a map of one's own
    >>> lines = two_lines()
    >>> diagram = continuation(lines, shoot(lines, -1.0, p=-0.5), "p", span=(-1, 2))
    >>> [(branch.id, branch.word, branch.ends) for branch in diagram.branches]
    [('F1', 'L', ('EP1', 'BC1')), ('J1', 'L / R', ('BC1', 'BC2')), ('F2', 'R', ('BC2', 'EP2'))]
    """
    if isinstance(orbit, str):
        raise TypeError(
            f"continuation needs the point itself, found by diagram.point({orbit!r}), got its name"
        )
    if not isinstance(orbit, PeriodicOrbit | SpecialPoint | PlanePoint):
        raise TypeError(
            "orbit must be a periodic solution, found by shoot, or a special point, got "
            f"{shown(orbit)}"
        )
    if isinstance(orbit, PeriodicOrbit) and (parameter is None or isinstance(parameter, str)):
        if kind is not None:
            raise TypeError(f"kind is for a point of codimension two, got {kind!r} for an orbit")
        followed = subject(source, parameter, cast("tuple[float, float] | None", span), settings)
        check_functions(progress=progress)
        start = _start(followed, orbit)
        wanted = orders_with(start, orders)
        beginning = {AT: _value(followed, orbit), START: orbit.points, "orders": wanted}
        with recorded(run, followed.about | beginning, resume, followed) as record:
            tasks = Tasks.of_line(followed.map_, followed.settings, stop)
            explorer = Explorer(tasks, wanted, progress, record)
            explorer.follow(to_engine(start))
        return followed.finished(explorer.diagram(followed.parameter, followed.x_name))
    if isinstance(orbit, PeriodicOrbit) or isinstance(parameter, str | None):
        raise TypeError(
            "a periodic solution is followed over one parameter, a special point over two, got "
            f"{type(orbit).__name__} and {parameter!r}"
        )
    if any(each is not None for each in (orders, stop, progress, run)) or resume:
        raise TypeError("orders, stop, progress, run and resume are for one parameter, not for two")
    instance("source", source, Toy)
    return curve_in_two(
        cast("Toy", source), orbit, parameter, cast("Spans", span), kind=kind, settings=settings
    )


def _value(followed: Subject, orbit: PeriodicOrbit) -> float:
    """The value of the followed parameter at an orbit; of a toy it may be any of its parameters."""
    toy = followed.source
    return float(getattr(toy, followed.parameter)) if isinstance(toy, Toy) else orbit.p


def _start(followed: Subject, orbit: PeriodicOrbit) -> Orbit:
    """The cycle to follow, with its minimal period, as flips cannot be seen from its multiples."""
    if not orbit.success:
        raise ValueError(f"continuation needs a periodic solution, got one with: {orbit.message}")
    if orbit.source is not followed.source and orbit.source != followed.source:
        what = "toy" if isinstance(followed.source, Toy) else "map"
        raise ValueError(f"continuation needs an orbit of this {what}, got one of another {what}")
    settings, p = followed.settings, _value(followed, orbit)
    low, high = followed.wanted
    if not low <= p <= high:
        of_toy = " of the toy" if isinstance(followed.source, Toy) else ""
        raise ValueError(f"span must hold {followed.parameter} = {p}{of_toy}, got ({low}, {high})")
    x = np.array(orbit.points[: orbit.minimal_period])
    (low, high), slack = settings.window, ON_EDGE * settings.x_scale
    if not (low - slack <= x.min() and x.max() <= high + slack):
        name = "phi_S" if isinstance(followed.source, Toy) else followed.x_name
        raise ValueError(
            f"window must hold the orbit, {name} = {', '.join(f'{v:.6g}' for v in x.tolist())}, "
            f"got ({low}, {high})"
        )
    return cycle_near(followed.map_, x, p, settings)


# --- All branches in a window ---------------------------------------------------------------------


@explained(FOLLOWED)
def bifurcation_diagram(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    parameter: str | None = None,
    span: tuple[float, float] | None = None,
    orders: Sequence[int] = (1,),
    window: tuple[float, float] | None = None,
    *,
    settings: Settings | None = None,
    search: Search | None = None,
    progress: Report | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
) -> Diagram:
    """Find all branches of some iterates in a window, and how they are connected.

    Slices at values of the parameter are taken until branches explain everything that they show,
    see :mod:`woodpecker.search.search`. All returns of a cycle must lie in the window, and those of
    a jump crossing up to its border.

    Parameters
    ----------
    source
        The toy, whose own value of ``parameter`` does not matter; or any piecewise-smooth map of
        the line with one parameter.
    parameter, span
        As for :func:`woodpecker.continuation`.
    orders
        The iterates j.
    window
        Finite interval of phi_S [rad] or x, by default (-2.5, -0.24) rad for a toy, that of the
        settings for a map.
    settings, search
        Steps and tolerances; the number of slices.
    progress
        Called with each finished branch, and before every slice.
    run, resume
        A file that stores every finished branch; whether to resume the interrupted run in it.
    workers
        Number of processes, including this one; by default one for each core, for a map this one
        alone. The result does not depend on it. Maps are sent by cloudpickle, even with lambdas.
    executor
        An executor of :mod:`concurrent.futures` (threads, processes, dask, MPI) to use instead of
        own processes, with as many tasks at once as ``workers``; it is not shut down.

    Returns
    -------
    Diagram
        Fixed points of P_j are listed with their minimal period only. For a toy ``given`` states
        the law of impact and the source of derivatives in the parameter.

    Raises
    ------
    ValueError
        If an order is below 1, the span or window does not ascend or is not finite, or there is no
        run to resume.
    TypeError
        If the source is neither a toy nor a map, the parameter is unknown, or the settings are not
        :class:`Settings`.

    Examples
    --------
    >>> from woodpecker import Toy, Search, bifurcation_diagram
    >>> few = Search(slices=4)
    >>> top = bifurcation_diagram(Toy(), "eps_n1", (0.33, 0.4), (1,), (-1, -0.8), search=few)
    >>> sorted((round(p.parameter, 9), str(p.kind)) for p in top.points if p.kind.name != "EP")
    [(0.341923454, 'BC'), (0.388349589, 'FF')]
    >>> from woodpecker.examples import two_lines  # a map of one's own
    >>> diagram = bifurcation_diagram(two_lines(), "p", (-1, 2), (1, 2), (-3, 3), search=few)
    >>> [(branch.id, branch.order) for branch in diagram.branches]
    [('F1', 1), ('J1', 1), ('J2', 2), ('F2', 1), ('J3', 2), ('F3', 2), ('F4', 2), ('J4', 2)]
    """
    return bifurcation_search(
        source, parameter, span, orders, window, settings=settings, search=search,
        progress=progress, run=run, resume=resume, workers=workers, executor=executor,
    ).diagram  # fmt: skip


def bifurcation_search(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    parameter: str | None = None,
    span: tuple[float, float] | None = None,
    orders: Sequence[int] = (1,),
    window: tuple[float, float] | None = None,
    *,
    settings: Settings | None = None,
    search: Search | None = None,
    progress: Report | None = None,
    run: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
) -> Found:
    """Find all branches as :func:`woodpecker.bifurcation_diagram`, and return the slices, too.

    Parameters
    ----------
    source, parameter, span, orders, window
        As there.
    settings, search, progress, run, resume, workers, executor
        As there.

    Returns
    -------
    Found
        The diagram, its slices, and the number of evaluations of P_1.

    Raises
    ------
    ValueError, TypeError
        As there.

    Examples
    --------
    >>> from woodpecker import Search, Toy
    >>> from woodpecker.diagrams import bifurcation_search
    >>> few = Search(slices=4)
    >>> found = bifurcation_search(Toy(), "eps_n1", (0.33, 0.4), (1,), (-1, -0.8), search=few)
    >>> len(found.diagram.branches), len(found.slices) >= 4
    (3, True)
    """
    of_toy = isinstance(source, Toy)
    if window is None and of_toy:
        window = WINDOW
    looked = Search() if search is None else search
    instance("search", looked, Search)
    check_functions(progress=progress)
    followed = subject(source, parameter, span, settings, window)
    chosen, map_ = followed.settings, followed.map_
    finite_window(chosen)
    worker_count(workers)
    run_of = followed.about | {"orders": iterates(orders), "search": asdict(looked)}
    if of_toy:
        middle = np.mean([chosen.window, chosen.span], axis=1).tolist()
        map_.at(*middle)  # compiles the kernel once, before processes are started
    with recorded(run, run_of, resume, followed) as record:
        found = whole_diagram(
            map_, chosen, orders, looked, parameter_name=followed.parameter,
            x_name=followed.x_name, progress=progress, executor=executor, record=record,
            workers=WORKERS if workers is None and executor is None and not of_toy else workers,
        )  # fmt: skip
    return replace(found, diagram=followed.finished(found.diagram))
