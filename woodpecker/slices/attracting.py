"""Brute force beside the branches: what orbits from many starts settle on.

An orbit diagram knows nothing of branches. It shows attractors, periodic or chaotic, and their
Lyapunov exponents from the exact slopes; what it shows must be explained by stable branches or by a
positive exponent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.checks import instance, interval, real_array, whole
from woodpecker.base.settings import Settings
from woodpecker.maps.pieces import PiecewiseMap, map_of_pieces
from woodpecker.maps.sweeps import one_by_one
from woodpecker.slices.orbits import Orbit, at_parameter, leads

REPEATS = 1e-6  # in x, a part of the window: an orbit that has settled repeats itself so closely
LONGEST = 64  # period that is looked for in an orbit that has settled
SHOWN = 8  # periods that are listed where a diagram is printed: one line


class Swept(Protocol):
    """What a map makes of many points: arrays of one shape, nan where it has no value.

    Examples
    --------
    >>> from woodpecker.maps import Sweep
    >>> from woodpecker.slices import Swept
    >>> def steepest(found: Swept) -> float:  # whatever has arrays of both will do
    ...     return float(max(abs(slope) for slope in found.slope))
    >>> steepest(Sweep(value=[0.5, 0.25], slope=[0.5, -1.25]))
    1.25
    """

    @property
    def value(self) -> Floats:
        """The images."""

    @property
    def slope(self) -> Floats:
        """The slopes there."""


@runtime_checkable
class SweptMap(Protocol):
    """A map that takes many points at once, faster than one by one.

    Examples
    --------
    >>> import numpy as np
    >>> from woodpecker import orbit_diagram
    >>> from woodpecker.maps import Sweep
    >>> from woodpecker.slices import SweptMap
    >>> class Tent:
    ...     def sweep(self, x, p):
    ...         return Sweep(p * np.minimum(x, 1 - x), np.where(x < 0.5, p, -p))
    >>> isinstance(Tent(), SweptMap)
    True
    >>> orbit, = orbit_diagram(Tent(), [1.5], [0.3], (0, 1), transient=100, keep=50).orbits
    >>> round(orbit.exponent, 12)  # log 1.5
    0.405465108108
    """

    def sweep(self, x: Floats, p: Floats) -> Swept:
        """The map at points (n,), each with a parameter of its own.

        Parameters
        ----------
        x, p
            Points, and the parameter of each, both of shape (n,).

        Returns
        -------
        Swept
            Images and slopes, shapes (n,); nan where there is no image.
        """


def swept(map_: PiecewiseMap | SweptMap, x: Floats, p: Floats) -> Swept:
    """A map at points (n,) with parameters (n,), at once if it can, otherwise one by one."""
    if isinstance(map_, SweptMap):
        return map_.sweep(x, p)
    return one_by_one(map_of_pieces(map_).at, x, p)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SettledOrbit:
    """The end of one orbit at one parameter.

    Attributes
    ----------
    p, start
        Parameter and first point.
    x
        The points that were kept, in order.
    exponent
        Lyapunov exponent: mean of log(abs(slope)) over these; -inf for a superstable orbit.
    period
        Smallest shift that repeats the kept points, or 0 if there is none of those looked for.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import orbit_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> orbit, = orbit_diagram(lines, [-0.5], [0.3], (-3, 3), transient=100, keep=8).orbits
    >>> orbit.period, round(float(orbit.x[-1]), 12), round(orbit.exponent, 6)
    (1, -1.0, -0.693147)
    """

    p: float
    start: float
    x: Floats
    exponent: float
    period: int

    def __repr__(self) -> str:
        """Parameter, start, period and exponent."""
        period = f"period={self.period}" if self.period else "no period"
        return (
            f"SettledOrbit(p={self.p:.6g}, start={self.start:.6g}, {period}, "
            f"exponent={self.exponent:.4g}, {len(self.x)} points)"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OrbitDiagram:
    """Where orbits end, over a parameter.

    Attributes
    ----------
    orbits
        One for each parameter and start whose images stayed in the window.
    lost
        How many did not: they fell, or left the window.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import orbit_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> found = orbit_diagram(lines, [-0.5, 0.5], [0.3, -0.4], (-3, 3), transient=100, keep=8)
    >>> [(orbit.p, orbit.period) for orbit in found.orbits], found.lost
    ([(-0.5, 1), (-0.5, 1), (0.5, 2), (0.5, 2)], 0)
    """

    orbits: tuple[SettledOrbit, ...]
    lost: int

    def __repr__(self) -> str:
        """How many orbits there are, of which periods, and how many were lost."""
        values = {orbit.p for orbit in self.orbits}
        over = f"p from {min(values):.6g} to {max(values):.6g}, " if values else ""
        held = sorted({orbit.period for orbit in self.orbits} - {0})
        listed = ", ".join(map(str, held[:SHOWN])) + (", ..." if len(held) > SHOWN else "")
        return (
            f"OrbitDiagram({counted(len(self.orbits), 'orbit')}, {over}"
            f"periods {listed or 'none'}, {self.lost} lost)"
        )

    def points(self) -> tuple[Floats, Floats]:
        """All points that were kept, to be drawn or written.

        Returns
        -------
        p, x
            Two arrays of one shape (n,): parameters and positions, orbit after orbit.
        """
        p = [np.full(len(orbit.x), orbit.p) for orbit in self.orbits]
        x = [orbit.x for orbit in self.orbits]
        return np.concatenate([*p, []]), np.concatenate([*x, []])


def orbit_diagram(
    map_: PiecewiseMap | SweptMap,
    parameters: npt.ArrayLike,
    starts: npt.ArrayLike,
    window: tuple[float, float],
    *,
    transient: int = 300,
    keep: int = 128,
    settings: Settings | None = None,
) -> OrbitDiagram:
    """Follow orbits from many starts at many parameters.

    Parameters
    ----------
    map_
        For instance :class:`woodpecker.ToyPieces`, or what ``from_sympy`` returns. Of its pieces
        nothing is asked but values and slopes; a map that takes many points at once (``sweep``)
        gets all starts at all parameters in one array.
    parameters, starts
        Shapes (n,) and (m,).
    window
        Interval of x; an orbit that leaves it is lost. A start may lie outside.
    transient, keep
        How many iterates are cut, and how many are kept after that.
    settings
        The unit of x: an orbit that repeats itself to 1e-6 of it after at most 64 points has that
        period. By default in units of x.

    Returns
    -------
    OrbitDiagram
        At most n m orbits, each with its last ``keep`` points; those lost are counted.

    Raises
    ------
    ValueError
        If nothing is to be kept, the window is no two ascending numbers, or parameters or starts
        are no real numbers.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import orbit_diagram, from_sympy
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> found = orbit_diagram(lines, [-0.5, 0.5], [0.3, -0.4], (-3, 3), transient=100, keep=8)
    >>> [(orbit.p, orbit.start, orbit.period) for orbit in found.orbits]
    [(-0.5, 0.3, 1), (-0.5, -0.4, 1), (0.5, 0.3, 2), (0.5, -0.4, 2)]
    """
    chosen = Settings() if settings is None else settings
    instance("settings", chosen, Settings)
    keep, transient = whole("keep", keep), whole("transient", transient, least=0)
    window = interval("window", window)
    first = np.atleast_1d(real_array("starts", starts))
    values = np.atleast_1d(real_array("parameters", parameters))
    p, x = (each.ravel() for each in np.broadcast_arrays(values[:, None], first))
    stayed, kept, stretch = _settled(map_, p, x, window, transient, keep)
    periods = periods_of(kept, chosen)
    rows = zip(p[stayed].tolist(), x[stayed].tolist(), kept, stretch / keep, periods, strict=True)
    return OrbitDiagram(
        orbits=tuple(
            SettledOrbit(p=p, start=start, x=points, exponent=float(exponent), period=int(period))
            for p, start, points, exponent, period in rows
        ),
        lost=len(p) - len(stayed),
    )


def _settled(
    map_: PiecewiseMap | SweptMap, p: Floats, x: Floats, window: tuple[float, float],
    transient: int, keep: int,
) -> tuple[Ints, Floats, Floats]:  # fmt: skip
    """Which of n orbits stay in the window from the first image on; last points, log of slopes."""
    alive, kept, stretch = np.arange(len(p)), np.empty((len(p), keep)), np.zeros(len(p))
    for n in range(transient + keep):
        if not len(alive):
            break
        here = swept(map_, x, p)
        if n >= transient:
            kept[alive, n - transient] = x
            with np.errstate(divide="ignore", invalid="ignore"):
                stretch[alive] += np.log(np.abs(here.slope))
        stays = (window[0] <= here.value) & (here.value <= window[1])  # not where it is nan
        alive, x, p = alive[stays], here.value[stays], p[stays]
    return alive, kept[alive], stretch[alive]


def periods_of(x: Floats, settings: Settings) -> Ints:
    """Smallest shift that repeats each row of x (n, m), or 0 if none does of those looked for."""
    same, periods, left = REPEATS * settings.x_scale, np.zeros(len(x), int), np.arange(len(x))
    for shift in range(1, min(LONGEST, x.shape[1] // 2) + 1):
        repeats = np.abs(x[left, shift:] - x[left, :-shift]).max(axis=1, initial=0.0) <= same
        periods[left[repeats]] = shift
        left = left[~repeats]
    return periods


def unexplained(
    orbits: OrbitDiagram, diagram: Diagram, map_: PiecewiseMap, distance: float | None = None,
    settings: Settings | None = None,
) -> list[SettledOrbit]:  # fmt: skip
    """Orbits that end on a cycle of which the diagram has no stable branch.

    The cycle is solved for. A branch passes through it if one Newton step leads there from where
    the branch is between its samples. Chaotic orbits (positive exponent, no period) and cycles of a
    period the diagram does not hold explain themselves.

    Parameters
    ----------
    orbits, diagram
        Of the same map and parameter.
    map_
        This map.
    distance
        How far a branch may stray from the line between two of its samples; by default as far as
        they are apart in x, for the Newton step tells.
    settings
        Tolerances.

    Returns
    -------
    list of SettledOrbit
        Empty where the diagram accounts for all.

    Examples
    --------
    >>> from sympy import Piecewise, symbols
    >>> from woodpecker import Settings, continuation, from_sympy, orbit_diagram, shoot
    >>> from woodpecker.slices import unexplained
    >>> x, p = symbols("x p")
    >>> formula = Piecewise((x/2 + p, x < 0), (x/3 + p - 1, True))
    >>> lines = from_sympy(formula, x, p, words=["L", "R"])
    >>> orbits = orbit_diagram(lines, [-0.5, 1.5], [0.3], (-3, 3), transient=100, keep=8)
    >>> settings = Settings(span=(-1, 0), window=(-3, 3))  # all branches end at p = 0
    >>> left = continuation(lines, shoot(lines, -1.0, p=-0.5), settings=settings)
    >>> [(orbit.p, orbit.period) for orbit in unexplained(orbits, left, lines)]
    [(1.5, 1)]
    """
    chosen = Settings() if settings is None else settings
    for name, value, kind in (("orbits", orbits, OrbitDiagram), ("settings", chosen, Settings)):
        instance(name, value, kind)
    held = {branch.order for branch in diagram.branches}
    slices: dict[float, list[tuple[int, float, float]]] = {}
    left = []
    for orbit in orbits.orbits:
        if orbit.period not in held or (orbit.exponent > 0.0 and math.isfinite(orbit.exponent)):
            continue
        if orbit.p not in slices:
            slices[orbit.p] = [
                (hit.branch.order, hit.x, _apart(hit.branch, orbit.p))
                for hit in diagram.at(orbit.p)
                if hit.branch.kind is BranchKind.FIXED_POINT and abs(hit.multiplier) <= 1.0
            ]
        stable = np.array([each[1:] for each in slices[orbit.p] if each[0] == orbit.period])
        cycle = _cycle(map_, orbit, chosen)
        if cycle is None or not _passes(stable.reshape(-1, 2), cycle, distance, chosen):
            left.append(orbit)
    return left


def _apart(branch: Branch, p: float) -> float:
    """How far the samples of a branch on both sides of a parameter are apart in x."""
    low, high = np.sort([branch.parameter[:-1], branch.parameter[1:]], axis=0)
    around = (low <= p) & (p <= high)
    return float(np.abs(np.diff(branch.x))[around].max(initial=0.0))


def _cycle(map_: PiecewiseMap, orbit: SettledOrbit, settings: Settings) -> Orbit | None:
    """The cycle on which an orbit has settled; None if Newton's method does not find it there."""
    x = orbit.x[-orbit.period :]
    images = tuple(map_.at(each, orbit.p) for each in x.tolist())
    return at_parameter(Orbit(x, orbit.p, images), settings)


def _passes(hits: Floats, cycle: Orbit, distance: float | None, settings: Settings) -> bool:
    """Whether points of branches stand for a cycle: one Newton step leads from them to it.

    ``hits`` (n, 2) are points, and how far their branches may stray from there.
    """
    if not len(hits):
        return False
    chosen = hits[np.abs(hits[:, :1] - cycle.x).argmin(axis=0)]
    nearest = chosen[:, 0]
    before = float(np.abs(nearest - cycle.x).max())
    same = settings.same * settings.x_scale
    distance = max(same, float(chosen[:, 1].max())) if distance is None else distance
    return before <= distance and leads(nearest, cycle, settings)
