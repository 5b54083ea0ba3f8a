"""Diagrams of return maps: all branches (d = 1), attractors, basins, curves in two parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import check_functions, explained
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.checks import instance, interval, positive, real_array, whole
from woodpecker.base.progress import Report
from woodpecker.base.settings import Settings
from woodpecker.engine.curves import CurveSettings
from woodpecker.engine.maps import PieceView, SpaceImage, SpacePiece
from woodpecker.engine.two_parameters import SpecialCurve, special_curve
from woodpecker.maps.pieces import Image
from woodpecker.maps.sweeps import Sweep, one_by_one
from woodpecker.search.connected import Connected
from woodpecker.search.diagrams import whole_diagram
from woodpecker.search.search import Search
from woodpecker.slices.attracting import OrbitDiagram, SettledOrbit, periods_of
from woodpecker.systems.returns import SystemMap
from woodpecker.systems.verbs import (
    HELD,
    SystemCycle,
    parameters_of,
    points_of,
    spans_of,
    window_of,
)

NOWHERE = -1  # basin of a start whose orbit converges to none of the cycles


class LineOfSystem:
    """A return map with one free coordinate and one free parameter, as a map of the line.

    Functions of such maps take it, as :func:`woodpecker.orbit_diagram`,
    :func:`woodpecker.slices_at` and :func:`woodpecker.local_model`.

    Parameters
    ----------
    map_
        The return map.

    Raises
    ------
    TypeError
        If ``map_`` is no return map.
    ValueError
        If its section has other than one free coordinate, or not one parameter is free.

    Examples
    --------
    >>> from sympy import symbols
    >>> from woodpecker.systems import Contact, ContactSystem, LineOfSystem, Section, SystemMap
    >>> y, v, g, eps = symbols("y u_y g eps")
    >>> floor = Contact(name="floor", gap=y, eps_n=eps)
    >>> ball = ContactSystem([y], [[1]], [-g], [floor], {g: 10.0, eps: 0.5})
    >>> line = LineOfSystem(SystemMap(ball, Section(when="floor", free=[v]), ["eps"]))
    >>> image = line.at(1.0, 0.5)
    >>> round(image.value, 12), round(image.slope, 12), round(image.d_parameter, 12)
    (0.5, 0.5, 1.0)
    """

    def __init__(self, map_: SystemMap) -> None:
        instance("map_", map_, SystemMap)
        if (map_.d, map_.k) != (1, 1):
            raise ValueError(
                "a map of the line has one coordinate and one free parameter, got "
                f"{map_.d} and {map_.k}"
            )
        self.map = map_

    def __repr__(self) -> str:
        """The map that it wraps."""
        return f"LineOfSystem({self.map!r})"

    @property
    def evaluations(self) -> int:
        """The number of returns that this thread has computed, by search or along a path."""
        return self.map.evaluations

    def at(self, x: float, p: float) -> Image:
        """The image of a point under the piece that the map takes there.

        Parameters
        ----------
        x, p
            The point and the parameter.

        Returns
        -------
        Image
            Value, derivatives and margins; if there is no value, the reason.
        """
        return _of_line(self.map.at(np.array([x]), np.array([p])))

    def sweep(self, x: Floats, p: float | Floats) -> Sweep:
        """Images and slopes at many points (n,), with one parameter or one each.

        They are nan where the system does not return; ValueError for a parameter at which friction
        or restitution is out of range.
        """
        points = real_array("x", x).ravel()
        each = np.broadcast_to(real_array("p", p), points.shape)
        for value in np.unique(each).tolist():
            self.check(value)
        return one_by_one(self.at, points, each)

    def check(self, p: float) -> None:
        """Raise ValueError if friction or restitution is out of range at a parameter."""
        self.map.check_laws(np.array([p]))


@dataclass(frozen=True, slots=True)
class _PieceOnLine(PieceView):
    own: SpacePiece

    def at(self, x: float, p: float) -> Image:
        return _of_line(self.own.at(np.array([x]), np.array([p])))


def _of_line(image: SpaceImage) -> Image:
    slope, d_parameter = image.jacobian[0].tolist()
    return Image(
        float(image.value[0]), slope, d_parameter, image.margins, image.gradients, image.codes,
        _PieceOnLine(image.piece), image.reason,
    )  # fmt: skip


@explained(HELD)
def bifurcation_diagram(
    map_: SystemMap, span: tuple[float, float], orders: Sequence[int],
    window: tuple[float, float], *, settings: Settings | None = None, search: Search | None = None,
    progress: Report | None = None,
) -> Diagram:  # fmt: skip
    """Find every branch of some iterates in a window, for a section with one free coordinate.

    Parameters
    ----------
    map_
        The return map of a system, with one free coordinate and one free parameter.
    span
        Ends of the parameter.
    orders
        The iterates.
    window
        Ends of the coordinate.
    settings, search, progress
        As for :func:`woodpecker.bifurcation_diagram`.

    Returns
    -------
    Diagram
        Branches and special points.

    Raises
    ------
    TypeError
        If ``map_`` is no return map.
    ValueError
        If it has other dimensions, or an interval is empty.
    """
    line = LineOfSystem(map_)
    check_functions(progress=progress)
    spans_of(map_, [span])
    chosen = replace(
        settings or Settings(), span=interval("span", span, finite=True),
        window=interval("window", window, finite=True),
    )  # fmt: skip
    return whole_diagram(
        line, chosen, orders, search, parameter_name=map_.parameters[0],
        x_name=str(map_.section.free[0]), progress=progress,
    ).diagram  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SettledReturns:
    """The attractors on which orbits of a return map settle.

    Attributes
    ----------
    p
        (s,) values of the parameter.
    start
        (s, d) first points of the orbits.
    x
        (s, keep, d) their last points.
    period
        (s,) periods of these, up to 64; 0 if there is none.
    lost
        How many orbits left the window, or did not return.
    parameter_name, x_names
        Names of the parameter and of the d coordinates.
    """

    p: Floats
    start: Floats
    x: Floats
    period: Ints
    lost: int
    parameter_name: str
    x_names: tuple[str, ...]

    def __repr__(self) -> str:
        coordinates = counted(self.x.shape[-1], "coordinate")
        return f"SettledReturns({coordinates}, {self.coordinate(0).summary()})"

    def coordinate(self, k: int) -> OrbitDiagram:
        """One of the d coordinates, for :func:`woodpecker.plot.orbits.plot_orbits` to draw.

        Lyapunov exponents are nan, as they are not known.
        """
        d = self.x.shape[-1]
        if whole("k", k, 0) >= d:
            raise ValueError(f"k must name one of {counted(d, 'coordinate')}, from 0 on, got {k}")
        values = zip(self.p.tolist(), self.start, self.x, self.period.tolist(), strict=True)
        orbits = (
            SettledOrbit(p=p, start=float(start[k]), x=x[:, k], exponent=math.nan, period=period)
            for p, start, x, period in values
        )
        return OrbitDiagram(
            orbits=tuple(orbits), lost=self.lost, parameter_name=self.parameter_name,
            x_name=self.x_names[k],
        )  # fmt: skip


@explained(HELD)
def orbit_diagram(
    map_: SystemMap, parameters: npt.ArrayLike, starts: npt.ArrayLike,
    window: Sequence[tuple[float, float]], *, transient: int = 300, keep: int = 128,
) -> SettledReturns:  # fmt: skip
    """Follow orbits from many starts at many values of the first free parameter.

    Parameters
    ----------
    map_
        The return map of a system, of any dimension d.
    parameters
        (n,) values of the first free parameter.
    starts
        (m, d) points, or (m,) if d = 1.
    window
        (d, 2) ends of the coordinates; an orbit that leaves them is lost.
    transient, keep
        How many returns are discarded, and how many are kept after that.

    Returns
    -------
    SettledReturns
        At most n m orbits.

    Raises
    ------
    TypeError
        If ``map_`` is no return map.
    ValueError
        If shapes do not fit, or the map has no free parameter.
    """
    instance("map_", map_, SystemMap)
    if not map_.k:
        raise ValueError("the map has no free parameter")
    transient, keep = whole("transient", transient, least=0), whole("keep", keep)
    ends = np.array(window_of(map_, window))
    map_ = map_.within(ends.tolist())
    first = points_of(map_, "starts", starts)
    values = np.atleast_1d(real_array("parameters", parameters))
    found, lost = list[tuple[float, Floats, Floats]](), 0
    for value in values.tolist():
        p = parameters_of(map_, [value, *map_.p[1:]])
        for start in first:
            orbit = _orbit(map_, start, p, ends, transient, keep)
            lost += orbit is None
            if orbit is not None:
                found.append((value, start, orbit))
    x = np.array([each[2] for each in found]).reshape(-1, keep, map_.d)
    return SettledReturns(
        p=np.array([each[0] for each in found]), lost=lost, x=x,
        start=np.array([each[1] for each in found]).reshape(-1, map_.d),
        period=periods_of(x / map_.x_scale), parameter_name=map_.parameters[0],
        x_names=tuple(map(str, map_.section.free)),
    )  # fmt: skip


def _orbit(
    map_: SystemMap, x: Floats, p: Floats, ends: Floats, transient: int, keep: int
) -> Floats | None:
    """The last points (keep, d) of an orbit; None if it is lost."""
    points = [x]
    for run in islice(map_.orbit(x, p), transient + keep):
        points.append(run.point)
        if not ((ends[:, 0] <= run.point) & (run.point <= ends[:, 1])).all():
            return None
    return np.array(points[transient:-1])


@explained(HELD)
def basins(
    map_: SystemMap, cycles: Sequence[SystemCycle], points: npt.ArrayLike, *, returns: int = 200,
    near: float = 1e-3, p: npt.ArrayLike | None = None,
) -> Ints:  # fmt: skip
    """Find the cycle to which the orbit of each of many points converges.

    Parameters
    ----------
    map_
        The return map of a system.
    cycles
        Stable cycles of it.
    points
        (m, d) points.
    returns
        Largest number of returns of an orbit.
    near
        Distance from a point of a cycle below which an orbit has reached it, as a fraction of the
        ranges of all these points and first returns, or in units of the scales that the map was
        given.
    p
        (k,) values of the free parameters; by default those of the system.

    Returns
    -------
    array of shape (m,)
        The index of the cycle; -1 where an orbit converges to none, or is lost.

    Raises
    ------
    TypeError
        If ``map_`` is no return map, or a cycle none.
    ValueError
        If shapes do not fit, a number is not positive, or there is no cycle.
    """
    instance("map_", map_, SystemMap)
    if not len(cycles):
        raise ValueError("at least one cycle is needed, got none")
    for cycle in cycles:
        instance("cycle", cycle, SystemCycle)
    returns, near = whole("returns", returns), positive("near", near)
    values = parameters_of(map_, p)
    places = np.concatenate([cycle.x for cycle in cycles])
    owners = np.repeat(np.arange(len(cycles)), [len(cycle.x) for cycle in cycles])
    starts = points_of(map_, "points", points)
    images = np.array([map_.search(x, values).point for x in starts])
    known = np.vstack([places, starts, images[np.isfinite(images).all(axis=1)]])
    map_ = map_.within(list(zip(known.min(axis=0), known.max(axis=0), strict=True)))
    found = np.full(len(starts), NOWHERE, dtype=np.int64)
    for k, start in enumerate(starts):
        orbit = (run.point for run in islice(map_.orbit(start, values), returns))
        for x in chain([start], orbit):
            away = (np.abs(places - x) / map_.x_scale).max(axis=1)
            if away.min() <= near:
                found[k] = owners[away.argmin()]
                break
    return found


@explained(HELD)
def curve_in_two(
    map_: SystemMap, found: Connected, point: str, spans: Sequence[tuple[float, float]],
    window: Sequence[tuple[float, float]], *, step: float = 0.005, min_step: float = 1e-9,
    max_step: float = 0.02, max_samples: int = 500,
) -> SpecialCurve:  # fmt: skip
    """Follow a special point over the first two free parameters.

    Parameters
    ----------
    map_
        The return map of a system, with at least two free parameters.
    found
        The result of :func:`continuation` over the first of them.
    point
        The id of a fold, flip, Neimark-Sacker point or border collision in its diagram.
    spans
        Ends of both parameters.
    window
        (d, 2) ends of the coordinates.
    step, min_step, max_step
        First, shortest and longest step, as fractions of the lengths of spans and window, or in
        units of the scales that the map was given.
    max_samples
        Largest number of samples of the curve, each way.

    Returns
    -------
    SpecialCurve
        The curve, both ways from the point.

    Raises
    ------
    TypeError
        If ``map_`` is no return map or ``found`` no result of a continuation.
    ValueError
        If there is no such point, it has no such curve, or fewer than two parameters are free.
    """
    instance("map_", map_, SystemMap)
    instance("found", found, Connected)
    if map_.k < 2:
        raise ValueError(f"two free parameters are needed, the map has {map_.k}")
    known = {each.id: each for each in found.diagram.points}
    if point not in known:
        raise ValueError(f"unknown point {point!r}, the diagram has {sorted(known)}")
    settings = CurveSettings(
        spans=spans_of(map_, spans), step=positive("step", step), window=window_of(map_, window),
        min_step=min_step, max_step=max_step, max_samples=whole("max_samples", max_samples),
    )  # fmt: skip
    map_ = map_.within(settings.window, settings.spans)
    return special_curve(
        map_, found.orbits[point], known[point].kind, (0, 1), settings, x_scale=map_.x_scale,
        p_scale=map_.p_scale,
    )  # fmt: skip
