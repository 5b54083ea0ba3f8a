"""Bifurcation diagrams of the toy: what hangs together with one solution, or everything."""

from __future__ import annotations

from dataclasses import replace

from pwmap.diagram import Diagram
from woodpecker.explore import Explorer, Progress
from woodpecker.follow import Settings
from woodpecker.labelled import Cycle, LabelledMap, correct
from woodpecker.returns import RESTITUTIONS
from woodpecker.shooting import PeriodicOrbit, cycle_of, toy_map
from woodpecker.toy import Toy

WINDOW = (-2.5, -0.24)  # left of the band of centres [rad]
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
