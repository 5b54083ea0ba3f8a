"""Diagrams of any piecewise-smooth map: what hangs together with one cycle, or everything."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import brief
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, iterates
from woodpecker.base.executors import Serial, scheduler
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap, map_of_pieces
from woodpecker.search.checkpoint import Record, past_of
from woodpecker.search.explorer import Explorer, Progress, Seen
from woodpecker.search.search import Past, Search, complete
from woodpecker.search.tasks import Worker
from woodpecker.slices.margins import depth
from woodpecker.slices.orbits import Orbit, at_parameter, minimal_period, orbit_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What a search for everything came to.

    Attributes
    ----------
    diagram
        All branches and special points.
    slices
        What each slice came to, in the order they were taken.
    evaluations
        How often the map was evaluated in this run, by slices and in following branches; if it
        does not count its pieces, how often it was asked for one.
    left
        What was left because the map was evaluated as often as allowed, as a sentence; empty as a
        rule. The diagram says it, too, in ``about["left"]``.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, from_sympy
    >>> from woodpecker.search.diagrams import whole_diagram
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings = Settings(span=(-1, 2), window=(-3, 3))
    >>> found = whole_diagram(lines, settings, search=Search(slices=4))
    >>> len(found.diagram.branches), len(found.slices) >= 4
    (3, True)
    """

    diagram: Diagram
    slices: tuple[Seen, ...]
    evaluations: int
    left: str = ""

    def __repr__(self) -> str:
        """The diagram, and what it took to find it."""
        left = f",\n  {self.left}" if self.left else ""
        return (
            f"Found({self.diagram!r},\n  {len(self.slices)} slices, "
            f"{self.evaluations} evaluations{left})"
        )


def cycle_near(map_: PiecewiseMap, x: npt.ArrayLike, p: float, settings: Settings) -> Orbit:
    """The cycle that Newton's method finds from a guess, under the pieces the map takes there.

    Parameters
    ----------
    map_
        The map.
    x
        Its points, one after the other, about; a single number for a fixed point.
    p
        The parameter.
    settings
        Scales and tolerances.

    Returns
    -------
    Orbit
        Its points in the order of the guess, each with its image and derivatives.

    Raises
    ------
    ValueError
        If the method does not converge, or comes to a cycle that is virtual: the map takes another
        piece at one of its points.
    TypeError
        If the map has no pieces.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, from_sympy
    >>> from woodpecker.search.diagrams import cycle_near
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> orbit = cycle_near(lines, -0.9, -0.5, Settings(span=(-1, 2), window=(-3, 3)))
    >>> orbit.x.round(12).tolist(), orbit.p
    ([-1.0], -0.5)
    """
    instance("settings", settings, Settings)
    points = np.atleast_1d(np.asarray(x, dtype=float))
    pieces = [map_of_pieces(map_).at(float(each), p).piece for each in points]
    found = at_parameter(orbit_of(pieces, points, p), settings)
    near = ", ".join(f"{each:.6g}" for each in points)
    if found is None:
        raise ValueError(f"expected a guess near a cycle of the map at {p}, got {near}")
    least = -settings.same * settings.x_scale  # a point may lie on a border
    for at, image in zip(found.x.tolist(), found.images, strict=True):
        if depth(image) < least:
            raise ValueError(
                f"expected a guess near a cycle of the map at {p}, got {near}: from there a "
                f"virtual one is found, at {at:.6g} the map takes another piece than "
                f"{brief(image.piece.word)!r}"
            )
    return found


def connected(
    map_: PiecewiseMap,
    x: npt.ArrayLike,
    p: float,
    settings: Settings,
    *,
    orders: Sequence[int] | None = None,
    parameter_name: str = "p",
    x_name: str = "x",
    progress: Progress | None = None,
) -> Diagram:
    """All branches of a map that hang together with a cycle.

    The cycle is followed with its minimal period, also where it was passed several times over.

    Parameters
    ----------
    map_
        The map, see :class:`woodpecker.maps.pieces.PiecewiseMap`.
    x, p
        The points of the cycle, about, a number if it is a fixed point; and the parameter there.
    settings
        Span, window, steps and tolerances.
    orders
        The iterates of which branches are followed, that of the cycle among them; by default no
        other. Where P_n flips the doubled branch starts if 2 n is one of them; where it meets a
        kink or the beginning of a square root, all cycles of these orders that are born there do.
    parameter_name, x_name
        What the diagram calls them.
    progress
        Called before the first branch, and with every one that is finished.

    Returns
    -------
    Diagram
        Branches of fixed points and jumps, with the special points in which they meet.

    Raises
    ------
    ValueError
        If there is no cycle near the guess, its period is none of the orders, or it lies outside
        of the span or of the window.
    TypeError
        If the map has no pieces.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, from_sympy
    >>> from woodpecker.search.diagrams import connected
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> diagram = connected(lines, -1.0, -0.5, Settings(span=(-1, 2), window=(-3, 3)))
    >>> [(branch.id, branch.word, branch.ends) for branch in diagram.branches]
    [('F1', 'L', ('EP1', 'BC1')), ('J1', 'L / R', ('BC1', 'BC2')), ('F2', 'R', ('BC2', 'EP2'))]
    """
    start = once(cycle_near(map_, x, p, settings), settings)
    _within("span", np.array([start.p]), settings.span)
    _within("window", start.x, settings.window)
    wanted = orders_with(start, orders)
    worker = Serial(Worker(map_, settings))
    explorer = Explorer(map_, worker, settings, wanted, progress or _nothing)
    explorer.follow(start)
    return explorer.diagram(parameter_name, x_name)


def _within(name: str, values: Floats, interval: tuple[float, float]) -> None:
    """Complain of a cycle that lies outside of the span or of the window."""
    low, high = interval
    if values.min() < low or values.max() > high:
        shown_values = ", ".join(f"{value:.6g}" for value in values.tolist())
        raise ValueError(f"{name} must hold the cycle, at {shown_values}, got ({low}, {high})")


def once(cycle: Orbit, settings: Settings) -> Orbit:
    """A cycle with its minimal period.

    Passed several times over it would hide its flips, and meet the same borders again and again.
    """
    n = minimal_period(cycle, settings)
    return Orbit(cycle.x[:n], cycle.p, cycle.images[:n])


def orders_with(cycle: Orbit, orders: Sequence[int] | None) -> tuple[int, ...]:
    """Orders of the branches that are followed from a cycle.

    Raises
    ------
    ValueError
        If that of the cycle is not among them, or one is not at least 1.
    """
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
    progress: Progress | None = None,
    workers: int | None = 1,
    executor: Executor | None = None,
    record: Record | None = None,
) -> Found:
    """Every branch of some iterates of a map in a window, and how they hang together.

    Parameters
    ----------
    map_
        The map. It goes to other processes by cloudpickle, with lambdas in it too.
    settings
        Span, window (finite), steps and tolerances. An iterate P_j counts orbits of which all
        points lie in the window.
    orders
        The iterates j.
    search
        How many slices.
    parameter_name, x_name
        What the diagram calls them.
    progress
        Called with every branch, and before every slice.
    workers, executor
        See :func:`woodpecker.base.executors.scheduler`. The result does not depend on them.
    record
        Keeps what is finished; what it holds already is taken over.

    Returns
    -------
    Found
        Fixed points of P_j are listed with their minimal period only.

    Raises
    ------
    ValueError
        If an order is not at least 1, or the window is not finite.
    TypeError
        If the map has no pieces.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Search, Settings, from_sympy
    >>> from woodpecker.search.diagrams import whole_diagram
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> settings = Settings(span=(-1, 2), window=(-3, 3))
    >>> found = whole_diagram(lines, settings, orders=(1, 2), search=Search(slices=4))
    >>> [(branch.id, branch.order) for branch in found.diagram.branches]
    [('F1', 1), ('J1', 1), ('J2', 2), ('F2', 1), ('J3', 2), ('F3', 2), ('F4', 2), ('J4', 2)]
    """
    map_of_pieces(map_)
    instance("settings", settings, Settings)
    wanted = iterates(orders)
    finite_window(settings)
    with scheduler(Worker(map_, settings, whole=True), workers, executor, map_) as tasks:
        explorer = Explorer(map_, tasks, settings, wanted, progress or _nothing, record)
        past = restored(explorer, record, map_)
        seen = complete(explorer, settings, search or Search(), past)
    return Found(
        diagram=explorer.diagram(parameter_name, x_name),
        slices=tuple(seen),
        evaluations=explorer.evaluations
        + sum(each.evaluations for each in seen[len(past.slices) :]),
        left=explorer.left,
    )


def restored(explorer: Explorer, record: Record | None, map_: PiecewiseMap) -> Past:
    """Put an explorer back to where a record says it was after the last slice.

    Raises
    ------
    ValueError
        If that is a run of another map.
    """
    if record is None:
        return Past()
    past = past_of(explorer.network, record.entries, record.path, map_)
    explorer.spent = past.evaluations
    return past


def finite_window(settings: Settings) -> None:
    """Complain of a window that slices cannot cover."""
    instance("settings", settings, Settings)
    if not all(map(math.isfinite, settings.window)):
        raise ValueError(f"a search for every branch needs a finite window, got {settings.window}")


def _nothing(_: object) -> None:
    pass
