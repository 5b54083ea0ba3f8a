"""The return map of the toy, or any map, at many points, and the attractors of its orbits."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import explained
from woodpecker.base.checks import real_array, whole
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.mechanics.toy import Toy
from woodpecker.simulation import returns
from woodpecker.simulation.returns import ReturnMap
from woodpecker.simulation.status import Status
from woodpecker.toy_map import OWN_VALUES, Mapped, axes_of, map_and_names, mapped_at, value_of

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap
    from woodpecker.slices import OrbitDiagram, SweptMap


@explained(OWN_VALUES)
def return_map(
    source: Toy | PiecewiseMap | PiecewiseLinearMap,
    x: npt.ArrayLike,
    order: int = 1,
    *,
    p: float | None = None,
    executor: Executor | None = None,
) -> ReturnMap:
    """The images of many starts under P_order; for the toy computed on all cores.

    Parameters
    ----------
    source
        The toy, or any piecewise-smooth map of the line with one parameter.
    x
        Starts of any shape, for the toy phi_S [rad]; the result is flat.
    order
        Number of returns.
    p
        The parameter of a map; a toy has its own values.
    executor
        For the toy, an executor of :mod:`concurrent.futures` (a process pool, dask, MPI). By
        default the compiled kernel runs in threads, and plain Python serially.

    Returns
    -------
    ReturnMap
        Arrays of shape (n,) in the order of the starts. For a map period, drop and the derivative
        in eps_n1 are nan.

    Raises
    ------
    TypeError
        If the source is neither a toy nor a map, or the executor has no method ``map``.
    ValueError
        If starts are not real numbers, or none of the toy, the order is no positive whole number, a
        map has no ``p`` or a toy has one, or doubles cannot hold the equations of motion.

    Examples
    --------
    >>> from woodpecker import Toy, return_map
    >>> found = return_map(Toy(), [-1.0, -0.8, -0.6])
    >>> found.phi_s.round(9).tolist(), found.slope.round(4).tolist()
    ([-0.364324882, -0.491027576, -0.479415128], [-0.9013, -0.5404, -0.635])
    """
    if isinstance(source, Toy):
        value_of(source, p)
        return returns.return_map(source, x, order, executor=executor)
    mapped = mapped_at(source, p)
    starts, order = real_array("x", x).ravel(), whole("order", order, most=returns.ORDER_MOST)
    found = [_returned(mapped, start, order) for start in starts.tolist()]
    unknown = np.full(len(starts), math.nan)
    return ReturnMap(
        start=starts, phi_s=np.array([each[0] for each in found]), period=unknown, drop=unknown,
        slope=np.array([each[1] for each in found]), d_eps_n1=unknown,
        words=tuple(each[2] for each in found), status=tuple(each[3] for each in found),
    )  # fmt: skip


def _returned(mapped: Mapped, x: float, order: int) -> tuple[float, float, str, Status]:
    """The image, slope, word and status of one start."""
    slope, words = 1.0, list[str]()
    for _ in range(order):
        image = mapped.at(x)
        words.append(image.piece.word)
        if image.reason:
            return math.nan, math.nan, " | ".join(words), Status.NO_IMAGE
        x, slope = image.value, slope * image.slope
    return x, slope, " | ".join(words), Status.RETURNED


@explained("what else is varied is given to the toy or the map before")
def orbit_diagram(
    source: Toy | PiecewiseMap | SweptMap | PiecewiseLinearMap,
    parameters: npt.ArrayLike,
    starts: npt.ArrayLike,
    window: tuple[float, float],
    *,
    parameter: str | None = None,
    transient: int = 300,
    keep: int = 128,
    settings: Settings | None = None,
) -> OrbitDiagram:
    """Follow orbits from many starts at many values of a parameter.

    Parameters
    ----------
    source
        The toy, or any map of the line with one parameter, of which only values and slopes are
        used; one with ``sweep`` (:class:`woodpecker.slices.SweptMap`) takes all points at once.
    parameters, starts
        Values of the parameter, and first points, of shapes (n,) and (m,).
    window
        Interval of x; an orbit that leaves it is lost. A start may lie outside.
    parameter
        The parameter that takes these values, of the toy by default eps_n1.
    transient, keep
        How many iterates are discarded first, and how many are kept after these.
    settings
        Its window sets the unit of x, by default 1: an orbit that repeats to within 1e-6 of it
        after at most 64 points has that period.

    Returns
    -------
    OrbitDiagram
        At most n m orbits, each with its last ``keep`` points; those lost are counted.

    Raises
    ------
    TypeError, ValueError
        If the source is neither a toy nor a map, the parameter is unknown, nothing is to be kept,
        the window does not ascend, or parameters or starts are not real numbers.

    Examples
    --------
    >>> from woodpecker import Toy, orbit_diagram
    >>> found = orbit_diagram(Toy(), [0.5, 0.66], [-0.53], (-2.5, -0.24), transient=200, keep=8)
    >>> [(orbit.p, orbit.period) for orbit in found.orbits], found.lost
    ([(0.5, 1), (0.66, 2)], 0)
    """
    from woodpecker.slices import attracting  # loaded here only, as a return map needs no slices

    if isinstance(source, attracting.SweptMap):
        map_: PiecewiseMap | SweptMap = source
        name, x_name = axes_of(source, parameter)
    else:
        map_, name, x_name = map_and_names(source, parameter)
    found = attracting.orbit_diagram(
        map_, parameters, starts, window, transient=transient, keep=keep, settings=settings
    )
    return replace(found, parameter_name=name, x_name=x_name)
