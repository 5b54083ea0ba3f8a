"""Bifurcation diagrams of the toy: what hangs together with one solution, or everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pwmap.diagram import Diagram
from woodpecker.complete import Search, complete
from woodpecker.explore import Explorer, Progress
from woodpecker.follow import Settings
from woodpecker.labelled import Cycle, LabelledMap, correct, windowed
from woodpecker.pieces import SampledMap
from woodpecker.returns import RESTITUTIONS
from woodpecker.shooting import PeriodicOrbit, cycle_of, toy_map, toy_samples
from woodpecker.toy import Toy

WINDOW = (-2.5, -0.24)  # left of the band of centres [rad]
MARGIN = 0.05  # rad; a map is followed a little beyond its window, to find where a branch leaves it
SMALLEST = 1e-9  # where a branch starts that would start at zero restitution


def continuation(
    toy: Toy,
    orbit: PeriodicOrbit,
    parameter: str = "eps_n1",
    span: tuple[float, float] = (0.0, 1.0),
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Diagram:
    """Follow a periodic solution both ways, and every branch that is connected to it.

    Parameters
    ----------
    toy
        The toy; its value of ``parameter`` is where the orbit lives.
    orbit
        A periodic solution of it, from :func:`woodpecker.shoot`.
    parameter, span
        Parameter of the toy and its interval.
    settings
        Steps, window and tolerances; the span is taken from ``span``. By default the window is
        (-2.5, -0.24) rad.
    progress
        Called with the parameter now and then.

    Returns
    -------
    Diagram
        Fixed-point and jump branches of P_order with their special points.

    Raises
    ------
    ValueError
        If the orbit did not converge or the span does not hold the toy's parameter.
    """
    if not orbit.success:
        raise ValueError(f"continuation needs a periodic solution, got one with: {orbit.message}")
    if orbit.toy != toy:
        raise ValueError("continuation needs an orbit of this toy, got one of another toy")
    chosen = settings if settings is not None else Settings(window=WINDOW)
    chosen = replace(chosen, span=(float(span[0]), float(span[1])))
    labelled_map = toy_map(toy, parameter)
    p = float(getattr(toy, parameter))
    if not span[0] <= p <= span[1]:
        raise ValueError(f"span must hold {parameter} = {p} of the toy, got {span}")
    start = cycle_of(orbit, labelled_map, p)
    if p == 0.0 and parameter in RESTITUTIONS:  # contacts that rest at zero bounce beyond it
        start, _, _ = correct(labelled_map, start.x, SMALLEST)
    return connected(
        labelled_map, start, chosen, parameter_name=parameter, x_name="phi_s", progress=progress
    )


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
) -> Diagram:
    """Every branch of some iterates in a window, and how they hang together.

    Slices of the parameter are taken until they show nothing that no branch explains; see
    :mod:`woodpecker.complete`. An iterate P_j counts orbits all of whose returns lie in the window.

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
        Called with the parameter now and then.

    Returns
    -------
    Diagram
        Fixed points of P_j are listed with their minimal period only.

    Raises
    ------
    ValueError
        If an order is not at least 1, or the span or window does not ascend.
    """
    labelled_map, samples = toy_map(toy, parameter), toy_samples(toy, parameter)
    chosen = replace(
        settings if settings is not None else Settings(),
        span=(float(span[0]), float(span[1])),
        window=(float(window[0]), float(window[1])),
    )
    return whole_diagram(
        labelled_map, samples, chosen, orders, search, parameter_name=parameter, x_name="phi_s",
        progress=progress,
    )  # fmt: skip


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
) -> Diagram:
    """Every branch of some iterates of a labelled map; see :func:`bifurcation_diagram`."""
    wanted = sorted(set(orders))
    if not wanted or not all(isinstance(order, int) and order >= 1 for order in wanted):
        raise ValueError(f"orders must be integers j >= 1, got {tuple(orders)}")
    low, high = settings.window
    inside = windowed(labelled_map, (low - MARGIN, high + MARGIN))
    explorer = Explorer(inside, settings, progress, wanted)
    complete(explorer, samples, wanted, search if search is not None else Search())
    return Diagram(
        parameter_name=parameter_name,
        x_name=x_name,
        branches=tuple(explorer.branches),
        points=explorer.special_points(),
    )


def connected(
    labelled_map: LabelledMap,
    start: Cycle,
    settings: Settings,
    *,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Progress | None = None,
) -> Diagram:
    """All branches of a labelled map that are connected with the cycle ``start``."""
    explorer = Explorer(labelled_map, settings, progress)
    explorer.explore_cycle(start)
    return Diagram(
        parameter_name=parameter_name,
        x_name=x_name,
        branches=tuple(explorer.branches),
        points=explorer.special_points(),
    )
